"""The law of a print of rings in the image: how radius and centre change from ring to ring, and what comes next.

A ring of radius ρ on the dome is drawn at the scale g(ρ) = r/ρ of the nominal camera, since the dome is nearer to
the camera or farther there. A camera beside the axis moves a ring's centre by as much as its scale says: c = a + b g.
A print that is bent as a whole has other radii than the design; they are read off the same profile.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray

_EVEN = 0.07
"""Greatest residual of a ring's dots over the distance of neighbours."""
_PRIOR = 2.0
"""Rings that what is said beforehand of the scatter of centres weighs as much as."""
_FLAT = 1e-6
"""Differences of height over the radius below which a skin is flat."""
_BEYOND = 1.3
"""How far the profile goes, over the outermost known radius."""
_ASIDE_MM = 4.0
"""Standard deviation of how far a camera stands beside the axis, in each direction."""
_LEAST_OFF_PX, _OFF, _BENT = 0.1, 3.0, 0.08
"""Standard deviation of the centres of rings about their line: at least, and in mm over how far the radii are off."""
_RIM = 0.98
"""Share of the meridian's greatest radius beyond which nothing is printed."""
_STEP = 0.05
"""Half the difference of radii over which the profile's slope is taken, mm."""
_ZOOM_SHARE = 0.2
"""Share of a common growth of all rings that is the camera's, as far as a camera's distance is better known than a
print's size: 4 % against 8 %."""
_ZOOM_SD = 0.035
"""Standard deviation of what is then left."""
_NESTED = 0.7
"""Distance of the centres of two neighbouring rings over that of their radii, at which they all but touch."""
TWIST, _TWIST_POWER = 0.25, 20.0
"""Greatest turn of a ring against the one inside, over the step of its dots; powers of ten that a step costs."""


@dataclass(frozen=True, eq=False)
class RingFit:
    """One ring of dots.

    Attributes
    ----------
    weights
        (7, 2) factors of `waves`, px.
    blob
        (n,) dot of each of its markers, -1 where there is none.
    error_px
        (n,) how far the dots lie from the ring; NaN where there is none.
    power
        Power of ten of the number of such rings that as many dots strewn at random would show in one place.
    """

    weights: FloatArray
    blob: NDArray[np.intp]
    error_px: FloatArray

    power: float = 0.0

    @property
    def count(self) -> int:
        """Number of its dots that were seen."""
        return int((self.blob >= 0).sum())

    @property
    def share(self) -> float:
        """Share of its dots that were seen."""
        return float(np.mean(self.blob >= 0))

    @property
    def residual_px(self) -> float:
        """Root of the mean squared distance of its dots from it; infinite without a dot."""
        off = self.error_px[np.isfinite(self.error_px)]
        return float(np.sqrt(np.mean(off**2))) if len(off) else np.inf

    @property
    def even(self) -> bool:
        """Whether the dots lie as near to it as a print's do."""
        return self.residual_px < _EVEN * 2.0 * np.pi * self.radius_px / len(self.blob)

    @property
    def turn(self) -> float:
        """Angle from the first axis of the image to azimuth 0, of the turn that is nearest to its shape."""
        left, _, right = np.linalg.svd(self.weights[1:3])
        turn = left @ right
        return float(np.arctan2(turn[0, 1], turn[0, 0]))

    @property
    def radius_px(self) -> float:
        """Mean of its half axes."""
        return float(np.linalg.svd(self.weights[1:3], compute_uv=False).mean())


@dataclass(frozen=True, eq=False)
class RingsFit:
    """The rings that were found from one seed, from the inside; the first is the dot in the middle."""

    rings: tuple[RingFit, ...]

    @property
    def count(self) -> int:
        """Number of dots."""
        return int(sum((ring.blob >= 0).sum() for ring in self.rings))

    @property
    def power(self) -> float:
        """Power of ten of the number of such prints among dots strewn at random, about one middle."""
        return float(sum(ring.power for ring in self.rings)) + _TWIST_POWER * float((self.twist**2).sum())

    @property
    def twist(self) -> FloatArray:
        """(k - 1,) how far each ring is turned against the one inside, over the step of its dots."""
        turns = np.array([ring.turn for ring in self.rings[1:]])
        steps = np.array([2.0 * np.pi / len(ring.blob) for ring in self.rings[2:]])
        return np.asarray(((np.diff(turns) + np.pi) % (2.0 * np.pi) - np.pi) / steps)

    @property
    def even(self) -> bool:
        """Whether all rings are, turned alike, and each within the next."""
        turned_alike = not (np.abs(self.twist) > TWIST).any()
        return turned_alike and not self.crossing and all(ring.even for ring in self.rings[1:])

    @property
    def crossing(self) -> int:
        """Number of the first ring that comes too near to the one inside; 0 where none does."""
        for number, (ring, outer) in enumerate(pairwise(self.rings[1:]), 2):
            aside = float(np.linalg.norm(outer.weights[0] - ring.weights[0]))
            if aside > _NESTED * (outer.radius_px - ring.radius_px):
                return number
        return 0

    @property
    def residual_px(self) -> float:
        """Root of the mean squared distance of the dots from their rings, the middle left out."""
        off = np.concatenate([ring.error_px[np.isfinite(ring.error_px)] for ring in self.rings[1:]])
        return float(np.sqrt(np.mean(off**2))) if len(off) else np.inf


class Profile:
    """The nominal camera's radius r in px of a ring of radius ρ in mm, from some known ones.

    The meridian is taken for a circle about the axis, ρ² + z² = p + q z, and the scale for 1/g = s + t z; what the
    known rings are beside that is kept.

    Parameters
    ----------
    rho, height, radius_px
        (k,) radius and height of rings, mm, and their radius in the image, px.
    """

    def __init__(self, rho: FloatArray, height: FloatArray, radius_px: FloatArray) -> None:
        ones = np.ones_like(rho)
        self._circle = np.linalg.lstsq(np.column_stack([ones, height]), rho**2 + height**2, rcond=None)[0]
        self._flat = float(height.mean()) if np.ptp(height) < _FLAT * rho.max() else None
        model = np.column_stack([ones, self._heights(rho)])
        self._factors = np.linalg.lstsq(model, rho / radius_px, rcond=None)[0]
        self._known, self._beside = rho, (radius_px / rho) * (model @ self._factors)
        self._rho = np.linspace(0.0, _BEYOND * float(rho.max()), 400)
        self._px = np.maximum.accumulate(self._rho * self.scale(self._rho))

    @property
    def widest(self) -> float:
        """Radius up to which the meridian is followed, mm."""
        p, q = self._circle
        reach = _RIM * float(np.sqrt(max(q * q / 4.0 + p, 0.0)))
        return float(self._rho[-1]) if self._flat is not None else max(reach, float(self._known.max()))

    def _heights(self, rho: FloatArray) -> FloatArray:
        """Heights of the meridian, mm."""
        if self._flat is not None:
            return np.full_like(rho, self._flat)
        p, q = self._circle
        return np.asarray(q / 2.0 + np.sqrt(np.maximum(q * q / 4.0 + p - rho**2, 0.0)))

    def scale(self, rho: FloatArray | float) -> FloatArray:
        """Pixels of a millimetre along a ring of this radius, mm."""
        rho = np.asarray(rho, float)
        model = self._factors[0] + self._factors[1] * self._heights(rho)
        return np.asarray(np.interp(rho, self._known, self._beside) / model)

    def slope(self, rho: float) -> float:
        """Pixels of a millimetre outwards at this radius, mm."""
        ends = np.array([rho - _STEP, rho + _STEP])
        return float(np.diff(ends * self.scale(ends))[0] / (2.0 * _STEP))

    def rho(self, radius_px: FloatArray | float) -> FloatArray:
        """Radius in mm of a ring in the nominal image, px."""
        return np.asarray(np.interp(radius_px, self._px, self._rho))


@dataclass(frozen=True, eq=False)
class RingModel:
    """Centres and radii of the rings of a print, and what they say of another ring.

    Attributes
    ----------
    profile
        That of the nominal camera.
    zoom
        Pixels of the image over those of the nominal camera.
    rho
        (k,) radius of each ring, mm, for the nominal distance: without a common factor, which is the camera's.
    drift
        (2, 2) a in px and b in mm of the centres a + b g.
    left_px
        (k, 2) centres beside that.
    drift_sd
        Standard deviation of b, mm.
    """

    profile: Profile
    zoom: float
    rho: FloatArray
    drift: FloatArray
    left_px: FloatArray
    drift_sd: float

    def centre_sd_px(self, expected_px: float) -> float:
        """How far the centres scatter, where `expected_px` is what one would say beforehand."""
        free = max(len(self.left_px) - 2, 0)
        square = (self.left_px**2).sum() / 2.0 + _PRIOR * expected_px**2
        return float(np.sqrt(square / (free + _PRIOR)))

    def radius_px(self, of_px: float, growth: float, share: float) -> float:
        """Radius in the image of the ring `growth` times as wide on the dome as one of radius `of_px`.

        `share` multiplies the zoom.
        """
        zoom = self.zoom * share
        rho = np.minimum(self.profile.rho(of_px / zoom) * growth, self.profile.widest)
        return float(zoom * rho * self.profile.scale(rho))

    def steeper(self, of_px: float, to_px: float) -> float:
        """How many px farther outwards a print a millimetre aside moves dots at one radius (px) than at another."""
        slopes = [self.profile.slope(float(self.profile.rho(px / self.zoom))) for px in (of_px, to_px)]
        return self.zoom * abs(slopes[1] - slopes[0])

    def centre(self, rho: float) -> FloatArray:
        """(2,) centre of a ring of this radius, mm."""
        return np.asarray(self.drift[0] + self.zoom * self.profile.scale(rho) * self.drift[1])


def fit_ring_model(
    rings: Sequence[RingFit], profile: Profile, nominal_px: FloatArray, design_rho: FloatArray
) -> RingModel:
    """The law of some rings, from the innermost, the middle left out.

    `nominal_px` and `design_rho` are the design's radii (k,) in px of the nominal image and in mm.
    """
    nominal_px, design_rho = nominal_px[: len(rings)], design_rho[: len(rings)]
    radius = np.array([ring.radius_px for ring in rings])
    zoom = 1.0 + _ZOOM_SHARE * (float(np.median(radius / nominal_px)) - 1.0)
    rho = profile.rho(radius / zoom)
    centres = np.stack([ring.weights[0] for ring in rings])
    scale = zoom * profile.scale(rho)
    bent = float(np.abs(rho / design_rho - 1.0).max())
    drift, sd = _drift(centres, scale, np.sqrt(rho / rho.max()), min(bent, _BENT) * _OFF)
    left = centres - drift[0] - scale[:, None] * drift[1]
    return RingModel(profile, zoom, rho, drift, left, sd)


def _drift(centres: FloatArray, scale: FloatArray, weight: FloatArray, error_mm: float) -> tuple[FloatArray, float]:
    """The line a + b g through the centres of rings, b held near zero as far as they scatter, and b's deviation."""
    middle = float(np.average(scale, weights=weight**2))
    expected = np.hypot(_LEAST_OFF_PX, error_mm * scale.mean())
    sd = expected
    for _ in range(2):
        rows = np.column_stack([weight, weight * (scale - middle)])
        rows = np.vstack([rows, [0.0, sd / _ASIDE_MM]])
        fit = np.linalg.lstsq(rows, np.vstack([weight[:, None] * centres, np.zeros(2)]), rcond=None)[0]
        drift = np.vstack([fit[0] - middle * fit[1], fit[1]])
        left = centres - drift[0] - scale[:, None] * drift[1]
        free = max(len(centres) - 2, 0)
        sd = float(np.sqrt(((left**2).sum() / 2.0 + _PRIOR * expected**2) / (free + _PRIOR)))
    spread = (weight**2 * (scale - middle) ** 2).sum()
    return drift, float(1.0 / np.sqrt(spread / sd**2 + 1.0 / _ASIDE_MM**2))


def extrapolate_ring(law: RingModel, outer: RingFit, design: tuple[float, float]) -> tuple[FloatArray, float, float]:
    """A ring outside the outermost one, as its own shape goes on.

    Parameters
    ----------
    law, outer
        The law of all rings, and the outermost.
    design
        Radii of the outermost ring and of the one that is wanted, mm.

    Returns
    -------
    ndarray
        (7, 2) factors of `waves`, px.
    float
        Standard deviation of its radius, px, since it is not known how much of the rings' size is the camera's.
    float
        Standard deviation of each coordinate of its centre, px.
    """
    zooms = (1.0, 1.0 - _ZOOM_SD, 1.0 + _ZOOM_SD)
    radii = [law.radius_px(outer.radius_px, design[1] / design[0], share) for share in zooms]
    weights = outer.weights * (radii[0] / outer.radius_px)
    rho = float(law.profile.rho(radii[0] / law.zoom))
    weights[0] = law.centre(rho) + law.left_px[-1]
    aside = law.drift_sd * law.zoom * abs(float(law.profile.scale(rho) - law.profile.scale(float(law.rho[-1]))))
    return weights, max(abs(radius - radii[0]) for radius in radii), aside
