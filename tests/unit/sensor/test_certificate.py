"""Certificate of an acceptance test: decision rule, reference standard, uncertainty of a reading, and its files."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from errors import refused
from palpate.calibration import UncertaintyBudget
from palpate.core import generator
from palpate.sensor import AcceptanceSpec, Certificate, GroundTruth, ReferenceSpec, accept_unit
from palpate.sensor.gauge_study import study_repeatability


def accepted(error=0.2, presses=12, spec=None, reference=None, bias=0.0):
    rng, images = generator(0, "certificate"), 6
    press = np.repeat(np.arange(presses), images)
    poses = np.column_stack([rng.uniform(-8, 8, (presses, 2))[press], np.tile(np.linspace(3, 6, images), presses)])
    noise = np.column_stack(
        [error * rng.normal(size=(len(press), 2)) + [bias, 0.0], 0.01 * rng.normal(size=len(press))]
    )
    names = tuple(map(str, range(len(press))))
    truth = GroundTruth((), names, press, poses, np.full(len(press), np.nan))
    return accept_unit(truth, poses + noise, None, spec or AcceptanceSpec(zero=False), reference)


def budget(sd=0.1):
    return UncertaintyBudget((), sd, 2.45 * sd).with_line("seating, tilt", np.full(3, sd), np.inf)


def decide(value, expanded, guard=True, stated="plate 7"):
    reference = ReferenceSpec(reference=stated, reference_tilt_deg=expanded / 2.0, direction_limit_deg=0.0)
    spec = AcceptanceSpec(zero=False, max_deg=value, rmse_deg=9.0, guard=guard)
    return next(check for check in accepted(reference=reference, spec=spec).checks if "maximum" in check.what)


def test_a_figure_near_its_tolerance_is_not_decided():
    """Tolerances about one figure: U below, at and above it, by the definition of ISO 14253-1."""
    figure = decide(9.0, 0.1).value
    assert decide(figure + 0.11, 0.1).decision == "conformity proven"
    assert decide(figure + 0.09, 0.1).decision == "not decided"
    assert decide(figure - 0.09, 0.1).decision == "not decided"
    assert decide(figure - 0.11, 0.1).decision == "non-conformity proven"
    assert [decide(figure + 0.09, 0.1, guard).passed for guard in (True, False)] == [False, True]
    assert decide(figure + 0.09, 0.1, guard=False).decision == "accepted (simple)"


def test_nothing_is_proven_without_a_stated_reference():
    figure = decide(9.0, 0.1).value
    assert decide(figure + 0.11, 0.1, stated="").decision == "within tolerance"
    assert decide(figure + 0.11, 0.1, stated="").passed
    assert decide(figure - 0.11, 0.1, stated="").decision == "outside tolerance"
    pages = [Certificate(accepted(reference=ReferenceSpec(reference=name)), "u").page() for name in ("", "plate 7")]
    assert ["proven" in str(page[2]) for page in pages] == [False, True]
    assert ["not stated" in page[1] for page in pages] == [True, False]


def test_the_total_angle_is_tested_with_rx_and_ry():
    found = accepted(bias=0.3)
    errors, _ = found.angle_errors()
    total = next(score for score in found.scores if score.component == "total angle")
    read = np.hypot(*found.estimates[:, :2].T) - np.hypot(*found.truth[:, :2].T)
    assert total.errors.rmse == pytest.approx(np.sqrt(np.mean(read**2)))
    assert errors[:, 2] == pytest.approx(read)
    assert {"total angle RMSE", "total angle maximum error"} <= {check.what for check in found.checks}


def test_repeatability_within_and_between_presses_is_that_of_the_general_study():
    found = accepted(error=0.3)
    errors, press = found.angle_errors()
    kept = np.arange(len(press)) % 7 > 0  # presses of different numbers of images
    found = replace(found, press=press[kept], truth=found.truth[kept], estimates=found.estimates[kept])
    study = study_repeatability({"total angle": errors[kept, 2]}, {"part": press[kept]})
    variances = [study.component("total angle", term).variance for term in ("repeatability", "part")]
    assert found.repeatability_deg() == pytest.approx(np.sqrt(np.maximum(variances, 0.0)))


def test_a_sine_plate_has_the_uncertainty_of_drawn_plates():
    """The closed formula against 20 000 plates with uniform errors of all lengths."""
    spec, tilt, rng = ReferenceSpec(seat_limit_deg=0.0, direction_limit_deg=0.5), 25.0, np.random.default_rng(0)
    draw = rng.uniform(-1.0, 1.0, (5, 20_000))
    length = spec.roller_distance + spec.roller_limit * draw[0]
    height = spec.roller_distance * np.sin(np.radians(tilt)) + spec.block_limit * draw[1]
    height = height + spec.flatness_limit * (draw[2] + draw[3])
    angle, turn = np.degrees(np.arcsin(height / length)), np.radians(spec.direction_limit_deg) * draw[4]
    axis, total = spec.tilt_sd_deg(tilt)
    assert total == pytest.approx(angle.std(), rel=0.02)
    assert axis == pytest.approx(np.hypot(angle.std(), (angle * np.sin(turn)).std()), rel=0.02)


def test_recorded_errors_count_once():
    """Errors below the budget change nothing; larger ones raise the total to the recorded RMSE."""
    found = accepted(error=0.02)
    axis, total = found.reference.tilt_sd_deg(found.max_tilt_deg)
    standard = np.array([axis, axis, total])
    small = Certificate(found, "u", budget=budget()).reading_budget()
    assert small.combined_deg == pytest.approx(np.hypot(0.1, standard))
    found = accepted(error=0.3)
    large = Certificate(found, "u", budget=budget()).reading_budget()
    errors, _ = found.angle_errors()
    assert large.combined_deg == pytest.approx(np.hypot(np.sqrt(np.mean(errors**2, axis=0)), standard), rel=1e-3)
    assert (large.factor > 2.0).all()
    alone = Certificate(found, "u").reading_budget()
    assert [line.name for line in alone.components] == ["recorded errors", "reference standard"]
    exact = accepted(error=0.0)
    axis, total = exact.reference.tilt_sd_deg(exact.max_tilt_deg)
    assert Certificate(exact, "u").reading_budget().combined_deg == pytest.approx([axis, axis, total])


def remounted(mountings, sd=(0.2, 0.2), seed=0):
    """Readings of five parts, each twice after every mounting with tilts of an SD about rx and ry."""
    rng = np.random.default_rng(seed)
    part, mounting, _ = (x.ravel() for x in np.indices((5, mountings, 2)))
    shifts = np.array(sd) * rng.standard_normal((mountings, 2))
    values = {
        k: 5.0 * part + shifts[mounting, n] + 0.02 * rng.standard_normal(len(part))
        for n, k in enumerate(("rx", "ry"))
    }
    return values | {"total angle": np.hypot(*values.values())}, {"part": part, "mounting": mounting}, shifts


@pytest.mark.parametrize("seed", range(4))
def test_an_axis_without_reproducibility_leaves_the_uncertainty_finite(seed):
    study = study_repeatability(*remounted(3, (0.3, 0.0), seed)[:2])
    found = Certificate(accepted(error=0.02), "u", budget=budget(), study=study).reading_budget()
    assert np.isfinite(found.expanded_deg).all()
    assert found.expanded_deg[0] > found.expanded_deg[1]


def test_an_infinite_uncertainty_is_refused():
    endless = UncertaintyBudget((), 0.1, 0.2).with_line("a", np.full(3, np.nan))
    with refused("uncertainty-not-finite"):
        Certificate(accepted(), "u", budget=endless).reading_budget()


def test_the_radius_of_the_normal_contains_an_error_of_azimuth():
    """A turn of 10° about z leaves the total angle, and must show in the direction of the normal."""
    exact, (c, s) = accepted(error=0.0), (np.cos(np.radians(10)), np.sin(np.radians(10)))
    read = exact.truth.copy()
    read[:, :2] = read[:, :2] @ np.array([[c, s], [-s, c]])
    found = Certificate(replace(exact, estimates=read), "u", budget=budget()).reading_budget()
    recorded = np.linalg.norm(read[:, :2] - exact.truth[:, :2], axis=1)
    assert found.normal_deg > 0.95 * np.quantile(recorded, 0.9545) > 1.0
    study = study_repeatability(*remounted(30, (0.001, 0.001))[:2])
    for each in (None, budget(0.001)):
        wide = Certificate(accepted(error=0.2), "u", budget=each, study=study).reading_budget()
        assert wide.normal_deg == pytest.approx(2.49 * 0.2, rel=0.2)  # not in proportion to the first line


def test_sentences_about_the_twin_need_a_twin():
    bare, twin = (Certificate(accepted(), "u", budget=each) for each in (None, budget()))
    for says in ("by the twin", "worst pose", "seating has its tolerance", "from that of the rest image", "± 2 K"):
        pages = ["\n".join(map(str, each.page())) for each in (bare, twin)]
        assert [says in page for page in pages] == [False, True], says
    assert bare.as_dict()["uncertainty"]["largest_standard_deg"] is None


def test_repeatability_is_counted_beyond_the_marker_noise():
    values, levels, _ = remounted(30, (0.0, 0.0))
    noisy = {name: value + 0.3 * np.random.default_rng(1).standard_normal(300) for name, value in values.items()}
    study = study_repeatability(noisy, levels)
    repeated = np.sqrt([study.component(name, "repeatability").variance for name in ("rx", "ry")])
    for noise in (0.0, 0.2, 0.5):
        lines = budget().with_line("marker noise, of the image and at rest", np.full(3, noise), kind="B")
        found = Certificate(accepted(error=0.02), "u", budget=lines, study=study).reading_budget()
        line = next(each for each in found.components if each.name.startswith("repeatability"))
        wanted = np.sqrt(np.maximum(repeated**2 - noise**2, 0.0))
        assert line.contribution_deg[:2] == pytest.approx(wanted)


def test_a_gauge_study_replaces_the_tolerance_of_the_seating():
    values, levels, shifts = remounted(30)
    study = study_repeatability(values, levels)
    found = Certificate(accepted(error=0.02), "u", budget=budget(), study=study).reading_budget()
    names = {line.name.split(":")[0] for line in found.components}
    assert names == {"operator, day and mounting", "reference standard", "repeatability beyond marker noise"}
    days = dict(zip(("part", "day"), levels.values(), strict=True))
    few, few_levels, _ = remounted(4)
    for kept in (
        study_repeatability(values, {"part": levels["part"]}),
        study_repeatability(values, days),
        study_repeatability(few, few_levels),
    ):
        seated = Certificate(accepted(error=0.02), "u", budget=budget(), study=kept)
        assert "seating, tilt" in [line.name for line in seated.reading_budget().components]
        assert any("Remounting" in line for line in seated.not_covered())
    assert found.combined_deg == pytest.approx(np.full(3, np.sqrt(np.mean(shifts.var(axis=0, ddof=1)))), rel=0.15)


def test_the_certificate_lists_its_inputs_and_limits(tmp_path):
    plate = ReferenceSpec(reference="plate 7", temperature_c=21.0)
    Certificate(accepted(reference=plate), "unit 7", {"estimator": "a.h5"}, budget()).write(tmp_path)
    data = json.loads((tmp_path / "accept.json").read_text())
    assert data["reference"]["reference"] == "plate 7"
    assert data["files"] == {"estimator": "a.h5"}
    assert set(data["uncertainty"]["expanded_deg"]) == {"rx", "ry", "total angle"}
    bare = Certificate(accepted(), "unit 7").not_covered()
    assert len(bare) == len(data["not_covered"]) + 2
    page = (tmp_path / "accept.md").read_text()
    assert "plate 7" in page
    assert "21 °C" in page
    assert len(re.findall(rb"/Type /Page\b", (tmp_path / "accept.pdf").read_bytes())) == 2
