"""What is drawn about a built unit, and the image that its camera takes."""

import math
from dataclasses import dataclass
from typing import final

import numpy as np
import pytest

from errors import refused
from palpate.calibration import IMPERFECTIONS, Deviation, ToleranceSpec, sample_deviation, single_deviation
from palpate.camera import LENSES, CameraSpec, Lens, RenderSpec
from palpate.design import Design, DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.material import get_material
from palpate.simulation.simulated_unit import SimulatedUnit

DOME = build_skin(DomeSpec())
LAYOUT = place_markers(DOME, MarkerSpec(count=37))
DESIGN = Design.of_skin(DOME, LAYOUT)
TOLERANCE = ToleranceSpec(lateral=0.5, twist_deg=1.0, curvature=5.0)
PARTS = {part: item for item in IMPERFECTIONS for part in item.parts}


def test_every_deviation_is_within_its_tolerance_and_none_is_forgotten():
    units = [sample_deviation(TOLERANCE, 0, number).as_dict() for number in range(1, 60)]
    assert {item.name for item in IMPERFECTIONS} | {"friction_max"} == set(ToleranceSpec.model_fields)
    for part, item in PARTS.items():
        drawn, limit = np.array([unit[part] for unit in units]), getattr(TOLERANCE, item.name)
        if item.name == "friction_min":
            assert ((drawn >= limit) & (drawn <= 2 * limit)).all()
        else:
            assert np.abs(drawn).max() <= limit
            assert np.abs(drawn).max() > 0.9 * limit
            assert not item.signed or drawn.min() < 0


@final
@dataclass(frozen=True)
class Pinhole(Lens):
    """A lens without coefficients."""

    name = "pinhole"
    max_radius = math.inf

    def distort(self, points):
        return points

    undistort = distort

    def mirrored(self):
        return self


@final
@dataclass(frozen=True)
class Aside(Lens):
    """A lens whose first coefficient is no distortion."""

    name = "aside"
    leading = "bend"
    max_radius = math.inf
    shift: float = 0.0
    bend: float = 0.0

    distort = undistort = mirrored = Pinhole.distort


def test_distortion_that_is_left_over_goes_to_the_coefficient_that_means_it(monkeypatch):
    off = Deviation(k1=0.01)
    given = {
        "brown": (-0.3, 0.1, 1e-3, 2e-3, 0.0),
        "kannala-brandt": (-0.05, 0.01, -0.05, 0.02),
        "pinhole": (),
        "aside": (0.1, 0.2),
    }
    get = LENSES.get
    guests = {"pinhole": Pinhole, "aside": Aside}
    monkeypatch.setattr(type(LENSES), "get", lambda self, name: guests.get(name) or get(name))
    found = {}
    for lens, coefficients in given.items():
        nominal = CameraSpec.model_construct(**CameraSpec().model_dump() | {"lens": lens, "distortion": coefficients})
        found[lens] = np.subtract(off.camera(nominal).distortion, coefficients)
    assert found["brown"] == pytest.approx([0.01, 0, 0, 0, 0])
    assert found["kannala-brandt"] == pytest.approx([0.01, 0, 0, 0])
    assert len(found["pinhole"]) == 0
    assert found["aside"] == pytest.approx([0, 0.01])


def test_a_unit_does_not_depend_on_how_many_are_drawn_nor_on_the_other_tolerances():
    assert sample_deviation(TOLERANCE, 3, 7) == sample_deviation(TOLERANCE, 3, 7)
    assert sample_deviation(TOLERANCE, 3, 7) != sample_deviation(TOLERANCE, 3, 8)
    wider = sample_deviation(ToleranceSpec(thickness=0.1), 3, 7)
    assert wider.thickness == pytest.approx(2 * sample_deviation(TOLERANCE, 3, 7).thickness)
    assert wider.offset_x == sample_deviation(TOLERANCE, 3, 7).offset_x


@pytest.mark.parametrize("item", IMPERFECTIONS, ids=lambda item: item.name)
def test_one_imperfection_alone_leaves_the_rest_as_designed(item):
    units = [single_deviation(TOLERANCE, item, 0, draw) for draw in range(2)]
    for unit in units:
        moved = {name for name, value in unit.as_dict().items() if value and name != "seed"}
        assert moved == set(item.parts)
    sign = -1.0 if item.signed else 1.0
    for part in item.parts:
        assert getattr(units[0], part) == sign * getattr(units[1], part)


def test_a_stiffer_mixture_scales_the_moduli_alone():
    material = get_material("zaid_2024_ecoflex_00_30")
    mixed = Deviation(modulus=0.1, stiffening=0.2).material(material)
    assert mixed.law.constants["C10"] == pytest.approx(1.1 * material.law.constants["C10"])
    assert mixed.law.constants["C20"] == pytest.approx(1.32 * material.law.constants["C20"])
    assert Deviation(modulus=0.1).material(get_material("ogden:0.02,2.0")).law.constants["mu1"] == pytest.approx(
        0.022
    )
    with refused("law-not-stiffening"):
        Deviation(stiffening=0.1).material(get_material("ogden:0.02,2.0"))


def test_the_camera_is_mounted_off_and_its_lens_not_quite_known():
    camera = Deviation(offset_x=0.5, roll_deg=2.0, focal=0.01, centre_x_px=1.0, k1=0.02).camera(CameraSpec())
    assert (camera.offset_x, camera.roll_deg, camera.distortion[0]) == (0.5, 2.0, 0.02)
    assert camera.fx_px == pytest.approx(1.01 * CameraSpec().fx_px)
    assert camera.cx_px == pytest.approx(CameraSpec().cx_px + 1.0)


def test_dots_are_misprinted_within_the_tolerance_and_stay_on_the_inner_surface():
    as_designed = SimulatedUnit(DESIGN, Deviation(), RenderSpec()).edges
    printed = SimulatedUnit(DESIGN, Deviation(marker_position=0.1, print_shift_x=0.2), RenderSpec()).edges
    assert np.abs(DOME.distance(printed)).max() < 1e-9
    off = np.linalg.norm(printed.mean(axis=1) - as_designed.mean(axis=1), axis=-1)
    assert 0.1 < off.max() < 0.6
    moved = (printed - as_designed).mean(axis=1)
    assert moved[0, 0] == pytest.approx(0.2, abs=0.11)


def test_missing_dots_are_not_drawn_and_the_mark_never_is_missing():
    edges = SimulatedUnit(DESIGN, Deviation(missing=0.2, seed=4), RenderSpec()).edges
    all_of_them = SimulatedUnit(DESIGN, Deviation(), RenderSpec()).edges
    assert len(edges) == 38 - 7
    assert np.allclose(edges[-1], all_of_them[-1])


def test_light_and_dirt_stay_while_noise_is_new():
    spec = RenderSpec(noise=2.0, dirt=10, unevenness=0.3)
    first, again = (spec.model_copy(update={"noise_seed": seed}) for seed in (1, 2))
    images = [SimulatedUnit(DESIGN, Deviation(), chosen).render_rest() for chosen in (first, again)]
    assert np.array_equal(images[0], images[1])  # the scene numbers its images itself
    from palpate.camera import build_camera, render

    edges = SimulatedUnit(DESIGN, Deviation(), spec).edges
    one, two = (render(build_camera(), edges, chosen).astype(float) for chosen in (first, again))
    assert 2.0 < np.std(one - two) < 3.5
    assert abs(np.mean(one - two)) < 0.05
