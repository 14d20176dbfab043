"""Pose dial: tilt of the wall, interval of the estimate, and tolerance, as SVG."""

from __future__ import annotations

import math

from palpate.sensor import Reading
from palpate.viewer.live import LiveVerdict

COLOURS = {
    LiveVerdict.GO: "#009e73",
    LiveVerdict.NO_GO: "#d55e00",
    LiveVerdict.UNSURE: "#b8860b",
    LiveVerdict.NO_TOUCH: "#7a8793",
}
"""Safe for colour-blind users; the verdict is also written as text."""
_SIZE = 100.0
_WIDE_DEG = 15.0
"""Range beyond which circles are drawn every 10° instead of 3°."""


def draw_dial(
    reading: Reading | None,
    tolerance_deg: float,
    verdict: LiveVerdict,
    truth: tuple[float, ...] | None = None,
    reach_deg: float = 12.0,
) -> str:
    """Draw the dial.

    Parameters
    ----------
    reading
        The estimate; `None` before the first.
    tolerance_deg
        Radius of the tolerance circle.
    verdict
        Selects the colour.
    truth
        rx, ry (degrees) and depth (mm), drawn as a cross if known.
    reach_deg
        Tilt at the dial's edge.
    """
    scale = _SIZE / max(reach_deg, tolerance_deg, 1.0)
    step = 3 if reach_deg <= _WIDE_DEG else 10
    rings = "".join(
        f'<circle r="{scale * tilt:.2f}" class="ring"/><text x="2" y="{-scale * tilt + 7:.1f}">{tilt}°</text>'
        for tilt in range(step, math.ceil(reach_deg), step)
    )
    parts = [
        '<svg viewBox="-108 -108 216 216" class="dial" role="img" aria-label="Pose of the wall">',
        f'<circle r="{_SIZE}" class="edge"/>{rings}<path d="M-100 0H100M0 -100V100" class="ring"/>',
        f'<circle r="{scale * tolerance_deg:.2f}" class="tolerance"/>',
    ]
    if truth is not None:
        x, y = scale * truth[0], -scale * truth[1]
        parts.append(f'<path d="M{x - 5:.1f} {y:.1f}h10M{x:.1f} {y - 5:.1f}v10" class="truth"/>')
    if reading is not None and verdict is not LiveVerdict.NO_TOUCH:
        parts.append(_point(reading, scale, COLOURS[verdict]))
    return "".join([*parts, '<text x="88" y="-4">rx</text><text x="4" y="-102">ry</text></svg>'])


def _point(reading: Reading, scale: float, colour: str) -> str:
    x, y = scale * reading.pose[0], -scale * reading.pose[1]
    wide, tall = (scale * min(half, 30.0) if math.isfinite(half) else 0.0 for half in reading.half_width[:2])
    return (
        f'<rect x="{x - wide:.2f}" y="{y - tall:.2f}" width="{2 * wide:.2f}" height="{2 * tall:.2f}" rx="2" '
        f'fill="{colour}" opacity="0.3"/><circle cx="{x:.2f}" cy="{y:.2f}" r="4" fill="{colour}"/>'
    )
