"""The law of a bent print is found from its dots, and the inspection reports it."""

import sys
from pathlib import Path

import numpy as np
import pytest

from palpate.core import generator
from palpate.design import Design
from palpate.sensor import Unit, draw_inspection, inspect_unit
from palpate.vision import assign_markers, register_dome

sys.path.insert(0, str(Path(__file__).parents[1] / "vision"))
from bent_prints import bent, design_of, draw, judge


@pytest.mark.parametrize("kept", [False, True])
@pytest.mark.parametrize("count", [37, 91, 169])
def test_the_radii_of_a_bent_print_are_found_and_explain_its_image(count, kept):
    drawn = bent(count, generator(3, "law", count), scale=1.6, mark=False, missing=0.0, kept=kept)
    design = design_of(count, 1.6)
    naming = judge(assign_markers(drawn["dots"], design.pattern), drawn, drawn["dots"], design).naming
    found = register_dome(naming, design.layout, design.skin, design.camera)
    relative = found.distortion.growth / found.distortion.growth.mean() - drawn["law"] / drawn["law"].mean()
    assert np.abs(relative).max() < 0.03  # the common growth is shared with the camera's distance
    off = found.camera.project(found.distortion.positions) - drawn["smooth"]
    assert np.sqrt((off**2).sum(axis=1).mean()) < 0.45
    assert found.distortion.rms_px < 0.2 * found.rms_px


def test_an_inspection_of_a_bent_print_reports_the_rings_and_draws_them():
    rng = generator(4, "inspection")
    drawn = bent(91, rng, scale=1.6, mark=False, missing=0.0)
    design = design_of(91, 1.6)
    unit = Unit(Design.of_skin(design.skin, design.layout, design.camera), has_orientation_mark=False)
    inspection = inspect_unit([draw(drawn["dots"], drawn["shape"], rng, scale=1.6)], unit)
    assert inspection.distortion is not None
    assert inspection.distortion.rms_px < 1.0
    axis, law = draw_inspection(inspection).axes[0], inspection.distortion
    members = [law.rings.members(number) for number in range(1, len(law.rings) + 1)]
    rings = [law.positions[np.append(ring, ring[0]), :2] for ring in members]
    lines = [next(line for line in axis.lines if np.array_equal(line.get_xydata(), ring)) for ring in rings]
    assert lines[0].get_label() in [text.get_text() for text in axis.get_legend().texts]


def test_an_even_print_has_no_law():
    design = design_of(91)
    pixels = design.pattern.expected_px + generator(5, "even").normal(0, 0.1, (91, 2))
    assert (
        register_dome(assign_markers(pixels, design.pattern), design.layout, design.skin, design.camera).distortion
        is None
    )
