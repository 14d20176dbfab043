"""Files of relaxation tests: columns, units, signs, and what is refused."""

import numpy as np
import pytest

from errors import check_values, refused
from palpate.material import TestFileSpec, read_relaxation

TIME = np.geomspace(0.1, 100, 40)
STRESS = 0.02 * (0.8 + 0.2 * np.exp(-TIME / 3))


def write(path, header, *columns):
    rows = "\n".join(",".join(f"{cell:.9g}" for cell in row) for row in zip(*columns, strict=True))
    path.write_text(f"{header}\n{rows}\n")
    return path


def test_time_and_stress_are_found_by_their_names(tmp_path):
    test = read_relaxation(write(tmp_path / "relax.csv", "time (s),stress (kPa)", TIME, STRESS))
    assert test.time == pytest.approx(TIME)
    assert test.stress == pytest.approx(STRESS)
    assert test.strain is None
    check_values(test.notes[-1], 0)


@pytest.mark.parametrize(
    "header",
    [
        "tempo (s),forza (N)",
        "tiempo [s],esfuerzo [MPa]",
        "时间(秒),力(N)",
        "Time (s),σ (kPa)",
        "t (s),Storage modulus (MPa)",
    ],
)
def test_names_are_those_of_stress_and_strain_files(tmp_path, header):
    test = read_relaxation(write(tmp_path / "a.csv", header, TIME, STRESS))
    assert test.time == pytest.approx(TIME)
    assert test.stress == pytest.approx(STRESS)


def test_a_stress_beside_its_force_and_a_strain_beside_its_travel_are_taken(tmp_path):
    header, strain = "time (s),force (N),stress (MPa),position (mm),strain (-)", np.full(40, 0.3)
    test = read_relaxation(write(tmp_path / "a.csv", header, TIME, 50 * STRESS, STRESS, 20 * strain, strain))
    assert test.stress == pytest.approx(STRESS)
    assert test.strain == pytest.approx(strain)


@pytest.mark.parametrize("name", ["Position (mm)", "Crosshead (mm)", "Distance (mm)", "Position number"])
def test_a_position_is_no_strain_since_it_may_begin_anywhere(tmp_path, name):
    path = write(tmp_path / "a.csv", f"Time (s),Load (N),{name}", TIME, STRESS, 120.0 + np.minimum(TIME, 10.0))
    assert read_relaxation(path).strain is None


def test_a_modulus_counts_before_a_force(tmp_path):
    header = "Time (s),Relaxation modulus (Pa),Normal force (N),Strain (%)"
    test = read_relaxation(write(tmp_path / "a.csv", header, TIME, STRESS, STRESS[::-1], np.full(40, 5.0)))
    assert test.stress == pytest.approx(STRESS)


@pytest.mark.parametrize(("unit", "size"), [("ms", 1e3), ("min", 1 / 60), ("h", 1 / 3600)])
def test_times_of_other_units_become_seconds(tmp_path, unit, size):
    test = read_relaxation(write(tmp_path / "a.csv", f"Zeit [{unit}],Kraft [N]", TIME * size, STRESS))
    assert test.time == pytest.approx(TIME, rel=1e-6)


def test_compression_of_either_sign_is_positive(tmp_path):
    strain = np.full(40, 0.7)
    test = read_relaxation(write(tmp_path / "a.csv", "time (s),stretch,stress (MPa)", TIME, strain, -STRESS))
    assert test.stress == pytest.approx(STRESS)
    assert test.strain == pytest.approx(0.3)


def test_a_stress_that_comes_up_first_is_taken_for_an_even_ramp(tmp_path):
    time = np.concatenate([[0, 0.5, 1.0], 1.0 + TIME])
    stress = np.concatenate([[0, 0.01, 0.021], STRESS])
    test = read_relaxation(write(tmp_path / "a.csv", "time (s),stress (MPa)", time, stress))
    assert test.ramp_times == (0.0, 1.0)
    assert "linearly" in test.notes[-1]


def test_columns_without_names_are_given_by_number(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("\n".join(f"{b:.9g};{a:.9g}" for a, b in zip(TIME, STRESS, strict=True)))
    test = read_relaxation(path, TestFileSpec(time="2", time_unit="s", stress="1"))
    assert test.time == pytest.approx(TIME)


WRONG = {
    "no time": ("strain,stress (MPa)", (TIME, STRESS), {}, ("column-missing", "--time")),
    "no unit": ("time,stress (MPa)", (TIME, STRESS), {}, ("column-unit-unknown", "--time-unit")),
    "two stresses": ("time (s),stress a,stress b", (TIME, STRESS, STRESS), {}, ("column-ambiguous", "--stress")),
    "one column twice": ("time (s),stress", (TIME, STRESS), {"stress": "1"}, ("column-taken-twice",)),
    "times that fall": ("time (s),stress", (TIME[::-1], STRESS), {}, ("times-not-rising",)),
    "a time twice": ("time (s),stress", (np.repeat(TIME[::2], 2), STRESS), {}, ("times-not-rising",)),
    "a stress that rises": ("time (s),stress", (TIME, STRESS[::-1]), {}, ("held-stress-rises",)),
    "a step in the stress": ("time (s),stress", (TIME, STRESS + 0.003 * (TIME > 20)), {}, ("held-stress-rises",)),
    "half a decade": ("time (s),stress", (np.geomspace(1, 5, 40), STRESS), {}, ("relaxation-too-short",)),
    "five rows": ("time (s),stress", (TIME[::8], STRESS[::8]), {}, ("table-few-rows", "5")),
    "an unloading": ("time (s),stress", (TIME, STRESS - 0.03 * (TIME > 50)), {}, ("held-stress-changes-sign",)),
    "no strain": ("time (s),strain,stress", (TIME, 0 * TIME, STRESS), {}, ("strain-zero", "0")),
    "a strain let go": ("time (s),strain,stress", (TIME, 0.3 * (TIME < 1), STRESS), {}, ("strain-released",)),
    "strain and stress in one": (
        "time (s),strain,stress",
        (TIME, TIME, STRESS),
        {"strain": "3"},
        ("column-taken-twice", "3"),
    ),
    "time before the touch": ("time (s),stress", (TIME - 5, STRESS), {}, ("strain-missing", "-4.9")),
}


@pytest.mark.parametrize("kind", WRONG)
def test_a_file_that_holds_no_relaxation_is_refused_with_a_remedy(kind, tmp_path):
    header, columns, spec, says = WRONG[kind]
    with refused(*says) as caught:
        read_relaxation(write(tmp_path / "wrong.csv", header, *columns), TestFileSpec(**spec))
    assert "wrong.csv" in caught.value.problem
    assert caught.value.remedy


def test_columns_without_numbers_are_refused(tmp_path):
    path = tmp_path / "a.csv"
    rows = "\n".join(f",,{a:.9g},{b:.9g}" for a, b in zip(TIME, STRESS, strict=True))
    path.write_text(f"time (s),stress,gap,temperature\n{rows}\n")
    with refused("columns-empty"):
        read_relaxation(path)


def test_an_empty_cell_is_named_by_its_row(tmp_path):
    path = write(tmp_path / "a.csv", "time (s),stress", TIME, STRESS)
    lines = path.read_text().splitlines()
    lines[7] = lines[7].split(",")[0] + ","
    path.write_text("\n".join(lines))
    with refused("cell-empty", "8", "2"):
        read_relaxation(path)
