"""Closed-form curves against the reference files (exact, 8 printed digits)."""

import csv
from pathlib import Path

import numpy as np
import pytest

from palpate.material import Mode, get_material, trace_curve

DATA = Path(__file__).parent / "data"
ECOFLEX = get_material("zaid_2024_ecoflex_00_30")


@pytest.mark.parametrize("mode", list(Mode))
def test_homogeneous_modes(mode: Mode) -> None:
    rows = [row for row in csv.DictReader((DATA / "yeoh_homogeneous.csv").open()) if row["mode"] == mode]
    curve = trace_curve(ECOFLEX, mode, np.array([float(row["stretch"]) for row in rows]))
    for values, column in (
        (curve.nominal, "nominal1_Pa"),
        (curve.cauchy, "cauchy1_Pa"),
        (curve.cauchy_constraint, "cauchy2_Pa"),
        (curve.energy, "W_Pa"),
    ):
        expected = np.array([float(row[column]) for row in rows])
        assert values * 1e6 == pytest.approx(expected, rel=1e-8, abs=1e-4)


def test_simple_shear() -> None:
    rows = list(csv.DictReader((DATA / "yeoh_simple_shear.csv").open()))
    gamma = np.array([float(row["gamma"]) for row in rows])
    F = np.tile(np.eye(3), (len(gamma), 1, 1))
    F[:, 0, 1] = gamma
    _, tau, _ = ECOFLEX.evaluate(F)
    expected = np.array([[float(row["cauchy12_Pa"]), float(row["cauchy11_Pa"])] for row in rows])
    assert 1e6 * tau[:, 3] == pytest.approx(expected[:, 0], rel=1e-8)
    assert 1e6 * (tau[:, 0] - tau[:, 2]) == pytest.approx(expected[:, 1], rel=1e-8)
