"""Limits of a design: manufacture, print, and validity of the methods."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from palpate.core import PalpateError
from palpate.design.finding import Finding, Severity
from palpate.design.markers import MarkerLayout
from palpate.design.skin import Skin


def check_design(skin: Skin, markers: MarkerLayout) -> tuple[Finding, ...]:
    """Report the limits that a skin and its markers exceed, errors first; empty if all are met.

    Examples
    --------
    >>> from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers
    >>> skin = build_skin(DomeSpec(height=30))
    >>> [finding.code for finding in check_design(skin, place_markers(skin, MarkerSpec()))]
    ['undercut']
    """
    findings = [*_check_wall(skin), *_check_markers(skin, markers)]
    order = list(Severity)
    return tuple(sorted(findings, key=lambda finding: order.index(finding.severity)))


def raise_on_errors(findings: Iterable[Finding]) -> None:
    """Raise the first finding that is an error.

    Raises
    ------
    PalpateError
        With message and remedy of this finding.
    """
    for finding in findings:
        if finding.severity is Severity.ERROR:
            raise PalpateError(finding.message, finding.remedy, code=finding.code)


def _check_wall(skin: Skin) -> Iterator[Finding]:
    if skin.thickness >= skin.radius:
        yield Finding(
            Severity.WARNING,
            "wall-thicker-than-radius",
            f"The skin is {skin.thickness:g} mm thick, its inner radius only {skin.radius:.4g} mm.",
            f"Use a thickness below {skin.radius:.4g} mm, or a larger dome.",
        )
    if skin.bulges and skin.hole:
        yield Finding(
            Severity.WARNING,
            "undercut",
            f"The barrel bulges: {2 * skin.widest[0]:.4g} mm wide halfway, {2 * skin.base_radius:g} mm at its ends.",
            "A rigid core cannot be removed: stretch the skin off it, or use a soft or split core.",
        )
    elif skin.bulges:
        yield Finding(
            Severity.WARNING,
            "undercut",
            f"The dome bulges over its base: {2 * skin.widest[0]:.4g} mm wide at z = {skin.widest[1]:.4g} mm, "
            f"{2 * skin.base_radius:g} mm at the base.",
            f"A rigid core cannot be pulled: stretch the skin off it, split it, or use H <= {skin.base_radius:g} mm.",
        )


def _check_markers(skin: Skin, markers: MarkerLayout) -> Iterator[Finding]:
    outside = ~markers.on_dome
    if outside.any():
        farthest = float(np.hypot(markers.positions[outside, 0], markers.positions[outside, 1]).max())
        yield Finding(
            Severity.ERROR,
            "ring-outside-dome",
            f"{int(outside.sum())} markers are up to {farthest:.4g} mm from the axis, outside the skin, "
            f"which extends to {skin.widest[0]:.4g} mm.",
            f"Keep ring diameters below {2 * skin.widest[0]:.4g} mm.",
        )
    pair = markers.closest_pair()
    if pair is not None and pair[2] < markers.diameter:
        yield Finding(
            Severity.WARNING,
            "dots-overlap",
            f"Markers {pair[0]} and {pair[1]} are {pair[2]:.3g} mm apart, but {markers.diameter:g} mm wide.",
            f"Reduce the marker diameter below {pair[2]:.3g} mm, or increase the spacing.",
        )
    room = skin.distance_to_rim(markers.positions[~outside])
    near = room < markers.diameter / 2.0
    if near.any():
        yield Finding(
            Severity.WARNING,
            "marker-near-rim",
            f"{int(near.sum())} markers are as near as {float(room.min()):.3g} mm to the rim, less than "
            f"half a marker ({markers.diameter / 2.0:.3g} mm).",
            "Move them towards the apex: a marker over the clamped rim is cut and hardly moves.",
        )
