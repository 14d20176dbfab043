"""Limits of a design: what cannot be built, cannot be printed or is outside what the methods are made for."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from palpate.core import PalpateError
from palpate.design.finding import Finding, Severity
from palpate.design.markers import MarkerLayout
from palpate.design.skin import Skin


def check_design(skin: Skin, markers: MarkerLayout) -> tuple[Finding, ...]:
    """Report the limits that a dome and its markers meet.

    Parameters
    ----------
    skin
        The skin.
    markers
        Its markers.

    Returns
    -------
    tuple of Finding
        Errors first; empty where nothing is wrong.

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
    """Stop where a finding is an error.

    Raises
    ------
    PalpateError
        With the sentence and the remedy of the first error.
    """
    for finding in findings:
        if finding.severity is Severity.ERROR:
            raise PalpateError(finding.message, finding.remedy, code=finding.code)


def _check_wall(skin: Skin) -> Iterator[Finding]:
    if skin.thickness >= skin.radius:
        yield Finding(
            Severity.WARNING,
            "wall-thicker-than-radius",
            f"The wall is {skin.thickness:g} mm thick, its inner radius only {skin.radius:.4g} mm.",
            f"Take less than {skin.radius:.4g} mm, or a larger dome: this is a block with a hollow, not a shell.",
        )
    if skin.bulges and skin.hole:
        yield Finding(
            Severity.WARNING,
            "undercut",
            f"The barrel bulges: {2 * skin.widest[0]:.4g} mm wide halfway, {2 * skin.base_radius:g} mm at its ends.",
            "A rigid core cannot be pulled straight: stretch the skin off it, or use a soft or split one.",
        )
    elif skin.bulges:
        yield Finding(
            Severity.WARNING,
            "undercut",
            f"The dome bulges over its base: {2 * skin.widest[0]:.4g} mm wide at z = {skin.widest[1]:.4g} mm, "
            f"{2 * skin.base_radius:g} mm at the base.",
            f"A rigid core cannot be pulled: use a soft or split core, or a height up to {skin.base_radius:g} mm.",
        )


def _check_markers(skin: Skin, markers: MarkerLayout) -> Iterator[Finding]:
    outside = ~markers.on_dome
    if outside.any():
        farthest = float(np.hypot(markers.positions[outside, 0], markers.positions[outside, 1]).max())
        yield Finding(
            Severity.ERROR,
            "ring-outside-dome",
            f"{int(outside.sum())} markers are up to {farthest:.4g} mm from the axis, outside the dome, "
            f"which reaches {skin.widest[0]:.4g} mm.",
            f"Keep ring diameters below {2 * skin.widest[0]:.4g} mm.",
        )
    pair = markers.closest_pair()
    if pair is not None and pair[2] < markers.diameter:
        yield Finding(
            Severity.WARNING,
            "dots-overlap",
            f"Markers {pair[0]} and {pair[1]} are {pair[2]:.3g} mm apart, but a dot is {markers.diameter:g} mm wide.",
            f"Print dots below {pair[2]:.3g} mm, or spread the markers.",
        )
    room = skin.distance_to_rim(markers.positions[~outside])
    near = room < markers.diameter / 2.0
    if near.any():
        yield Finding(
            Severity.WARNING,
            "marker-near-rim",
            f"{int(near.sum())} markers are as near as {float(room.min()):.3g} mm to the rim, less than "
            f"half a dot ({markers.diameter / 2.0:.3g} mm).",
            "Move them towards the apex: a dot over the clamped rim is cut and hardly moves.",
        )
