"""The orientation mark of built units: prints aside, dots off their places, cameras near and aside."""

from __future__ import annotations

import numpy as np
import pytest

from palpate.calibration import ToleranceSpec, sample_deviation
from palpate.camera import CameraSpec
from palpate.design import Design, DomeSpec, EllipsoidSpec, MarkerSpec, build_skin, place_markers
from palpate.sensor import Unit
from palpate.sensor.sensor import analyse_rest
from palpate.simulation import DEGRADED, SimulatedUnit

FLAT = EllipsoidSpec(height=19.2, thickness=1.2, aspect=0.6, taper=0.8)
WIDE_GAP = (4.128, 7.179, 10.217, 16.231, 20.658, 29.144, 31.809)
"""Skin and rings that a search chose."""


@pytest.mark.parametrize("rings", [1, 2, 3, 4, 6])
@pytest.mark.parametrize("distance", [30.0, 38.0])
def test_numbers_are_told_of_every_unit(rings, distance):
    """Where a print stands aside, its mark lies a pixel from where round rings would have it."""
    skin, tolerance = build_skin(DomeSpec()), ToleranceSpec()
    reach = float(skin.arc_length(np.array([[skin.base_radius, 0.0, 0.0]]))[0])
    diameters = 2.0 * skin.at_arc_length(np.linspace(0.0, 0.75 * reach, rings + 1)[1:])
    layout = place_markers(skin, MarkerSpec(ring_diameters=tuple(map(float, diameters)), diameter=1.0))
    camera = CameraSpec(distance=distance)
    unit = Unit(Design.of_skin(skin, layout, camera), tolerance=tolerance)
    for number in (1, 2):
        deviation = sample_deviation(tolerance, 0, number)
        scene = SimulatedUnit(Design.of_skin(skin, layout, camera), deviation, DEGRADED)
        naming = analyse_rest([scene.render_rest()], unit, None, None, True).naming
        assert not naming.ambiguous
        there = np.flatnonzero(scene.printed)
        centres = scene.camera.project(scene.edges[:-1].mean(axis=1))
        inside = ((centres > 5.0) & (centres < [camera.width_px - 6.0, camera.height_px - 6.0])).all(axis=1)
        there, centres = there[inside], centres[inside]
        found = naming.found[there]
        assert (~found).sum() <= 1 + 0.1 * len(found)
        off = np.linalg.norm(naming.positions_px[there] - centres, axis=1)[found]
        assert np.median(off) < 0.2
        assert off.max() < 4.0  # a few touch; another's place is 6 px away


def test_outer_rings_beyond_a_wide_gap_belong_to_the_field():
    """Two rings beyond 27 px without a dot, where neighbours are 10 px apart: in one of 20 units they were masked."""
    skin, tolerance, camera = build_skin(FLAT), ToleranceSpec(), CameraSpec(distance=30.0)
    layout = place_markers(skin, MarkerSpec(ring_diameters=WIDE_GAP, diameter=1.0))
    scene = SimulatedUnit(Design.of_skin(skin, layout, camera), sample_deviation(tolerance, 0, 8), DEGRADED)
    unit = Unit(Design.of_skin(skin, layout, camera), tolerance=tolerance)
    naming = analyse_rest([scene.render_rest()], unit, None, None, True).naming
    assert not naming.ambiguous
    assert naming.found.sum() >= scene.printed.sum() - 1
