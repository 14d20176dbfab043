"""Uncertainty budget of a reading, against the posterior of the unit, its closed forms and the nonlinear chain."""

from dataclasses import replace

import numpy as np
import pytest

from palpate.calibration import (
    CONTACT_STATE,
    IMPERFECTIONS,
    UNIT_PARAMETERS,
    AccuracySpec,
    Deviation,
    PoseFitter,
    ToleranceSpec,
    UncertaintyBudget,
    UnitModel,
    build_unit_model,
    infer_from_rest,
)
from palpate.calibration.mounting import prior_mounting
from palpate.calibration.predict_accuracy import sample_working_range
from palpate.camera import project_markers
from palpate.core import generator
from palpate.core.state import State
from palpate.design import Design, place_markers
from palpate.sensor import ReferenceSpec
from palpate.simulation import SimulatedUnit, TwinBackend
from small_chain import DOME, MARKERS, MATERIAL, small_twin

SPEC = AccuracySpec(poses=20, units=400, noise_px=0.02)
TOLERANCE = ToleranceSpec()


def nominal(tolerance: ToleranceSpec = TOLERANCE) -> UnitModel:
    twin, design = small_twin(), Design(DOME, MARKERS, material=MATERIAL)
    layout = place_markers(twin.skin, MARKERS)
    rest = design.camera.project(layout.positions)
    belief = infer_from_rest(twin, layout, design.camera_spec, rest, tolerance, SPEC.noise_px)
    belief = replace(belief, mean=State.zeros(UNIT_PARAMETERS))
    return build_unit_model(twin, layout, belief, tolerance)


@pytest.fixture(scope="module")
def model() -> UnitModel:
    return nominal()


@pytest.fixture(scope="module")
def budget(model: UnitModel) -> UncertaintyBudget:
    return UncertaintyBudget.of_unit(model, None, SPEC, ReferenceSpec().thermal)


def lines(found: UncertaintyBudget) -> dict[str, np.ndarray]:
    return {line.name: line.contribution_deg for line in found.components}


def test_lines_of_tolerances_add_up_to_the_posterior_of_the_unit(model: UnitModel, budget: UncertaintyBudget) -> None:
    """The posterior is computed from the curvature of the cost, without any decomposition by tolerances."""
    known = prior_mounting(model.posterior, model.tolerance)
    whole = UncertaintyBudget.of_unit(model, known, SPEC, ReferenceSpec().thermal)
    assert budget.combined_deg == pytest.approx(whole.combined_deg, rel=0.01)


def test_seating_and_stiffness_have_their_closed_forms(budget: UncertaintyBudget) -> None:
    """A seating tilt is an error of either axis and of every direction; stiffness has no effect."""
    found = lines(budget)
    assert found["seating, tilt"] == pytest.approx(np.full(3, TOLERANCE.seating_tilt_deg / np.sqrt(3.0)), rel=1e-6)
    assert found["seating, turn"][-1] < 1e-6 < 0.005 < found["seating, turn"][0]
    assert not found["stiffness of the skin"].any()
    assert found["marker noise, of the image and at rest"].all()


def test_lines_of_thickness_and_temperature_are_changes_of_the_nonlinear_fit(
    model: UnitModel, budget: UncertaintyBudget
) -> None:
    """Units with a thick skin, and warm ones, are drawn by the simulation and fitted; the budget has derivatives."""
    design, environment, kelvin = Design(DOME, MARKERS, material=MATERIAL), ReferenceSpec(), 2.0
    changes: dict[str, list[float]] = {"skin thickness": [], "temperature": []}
    warm = Deviation(
        focal=kelvin * environment.focal_per_k,
        distance=kelvin * environment.holder_per_k * design.camera_spec.distance,
    )
    units = {"": (Deviation(), 1.0), "skin thickness": (Deviation(thickness=0.03), 1.0)}
    units["temperature"] = (warm, 1.0 + kelvin * environment.skin_per_k)
    for pose, friction in sample_working_range(
        model.marker_twin.twin, SPEC, TOLERANCE, generator(SPEC.seed, "budget", "poses")
    ):
        contact = State.zeros(CONTACT_STATE).replace(
            rx_deg=pose[0], ry_deg=pose[1], depth_mm=pose[2], inverse_friction=friction
        )
        read = {}
        for name, (deviation, grown) in units.items():
            unit, fitter = SimulatedUnit(design, deviation), PoseFitter(model, SPEC.noise_px)
            edges = grown * TwinBackend(unit, model.marker_twin.twin).edges(contact)[:-1]
            seen = project_markers(unit.camera, edges).centres
            fitter.fit(seen)
            read[name] = float(np.hypot(*fitter.fit(seen).pose[:2]))
        for name, change in changes.items():
            change.append(read[name] - read[""])
    found = {line.name: line for line in budget.components}
    for name, size in (("skin thickness", 0.03), ("temperature", kelvin)):
        assert found[name].sensitivity == pytest.approx(np.sqrt(np.mean(np.square(changes[name]))) / size, rel=0.1)


def test_total_angle_and_normal_of_equal_errors_have_the_textbook_factors(model: UnitModel) -> None:
    """With seating alone, the total angle has the SD of an axis; the radius is that of chi with two degrees."""
    fields = [name for name in ToleranceSpec.model_fields if name not in ("friction_min", "seating_tilt_deg")]
    seated = nominal(TOLERANCE.model_copy(update=dict.fromkeys(fields, 0.0) | {"seating_tilt_deg": 3.0}))
    found = UncertaintyBudget.of_unit(seated, None, replace(SPEC, units=4000))
    sd = 3.0 / np.sqrt(3.0)
    assert found.expanded_deg == pytest.approx(np.full(3, 2.0 * sd), rel=0.01)
    assert found.normal_deg == pytest.approx(sd * np.sqrt(-2.0 * np.log(1.0 - 0.9545)), rel=0.02)


def test_a_line_of_few_degrees_of_freedom_raises_the_coverage_factor(budget: UncertaintyBudget) -> None:
    """The factor of a budget with one line of type A is Student's, as in table G.2 of the GUM: 2.65 for five."""
    assert budget.factor == pytest.approx(np.full(3, 2.0), abs=1e-9)
    alone = UncertaintyBudget((), 1.0, 1.0).with_line("a", np.full(3, 0.1), 5)
    assert alone.factor == pytest.approx(np.full(3, 2.65), abs=0.005)
    both = alone.with_line("b", np.full(3, 0.1), 5)
    assert both.dof == pytest.approx(np.full(3, 10.0))
    assert both.with_line("c", np.full(3, 0.2), 9, without="b").combined_deg == pytest.approx(
        np.full(3, np.hypot(0.1, 0.2))
    )


def test_a_quantity_within_its_tolerance_has_the_deviation_of_a_uniform_one(budget: UncertaintyBudget) -> None:
    uniform = float(np.std(np.linspace(-1.0, 1.0, 200_001)))
    found = {line.name: line for line in budget.components}
    told = [item for item in IMPERFECTIONS if item.label in found]
    assert len(told) > 8
    for item in told:
        line = found[item.label]
        assert (line.unit, line.kind, line.distribution) == (item.unit, "B", "uniform")
        assert line.standard == pytest.approx(uniform * getattr(TOLERANCE, item.name), rel=1e-4)
        assert line.sensitivity == pytest.approx(line.contribution_deg[2] / line.standard)
    thermal = ReferenceSpec().thermal
    warm = uniform * thermal["change_k"]
    assert found["temperature"].standard == pytest.approx(warm, rel=1e-4)
    softer = np.hypot(uniform * TOLERANCE.modulus, thermal["modulus_per_k"] * warm)
    assert found["stiffness of the skin"].standard == pytest.approx(softer, rel=1e-4)
    assert found["marker noise, of the image and at rest"].standard == SPEC.noise_px
    assert [line.contribution_deg[2] for line in budget.components] == sorted(
        (line.contribution_deg[2] for line in budget.components), reverse=True
    )
    assert budget.combined_deg**2 == pytest.approx(
        np.sum([line.contribution_deg**2 for line in found.values()], axis=0)
    )
