"""Yeoh's law compared with closed forms: homogeneous tests, simple shear, Drucker's stability.

*Incompressible*, by `palpate.material`: stresses follow from the isochoric part with the third direction free.
*One element* of the product, nearly incompressible, in a state of homogeneous stress: its error is about p/K.
*Drucker*: ``d tau_i = D_ij d eps_j`` with ``tau = (sigma_1 - sigma_3, sigma_2 - sigma_3)`` and ``eps`` the two free
logarithmic strains; the material is stable while ``tr D`` and ``det D`` are positive.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from palpate.core import FloatArray
from palpate.material import LAWS, Material, Mode, stretches, trace_curve
from palpate.mechanics import cauchy_stress
from palpate.verify.case import Row, compare
from palpate.verify.equilibrium import find_equilibrium, make_solid, reactions
from palpate.verify.mapped import even, join, map_block
from palpate.verify.read_reference import read_reference
from palpate.verify.rubber import YEOH

_PRINTED = 5e-10
"""Half a unit of the tenth digit, the last in the files."""
_RATES = {
    Mode.UNIAXIAL: np.array([1.0, -0.5]),
    Mode.EQUIBIAXIAL: np.array([1.0, 1.0]),
    Mode.PLANAR: np.array([1.0, 0.0]),
}
"""Logarithmic strain rates of the first two directions."""
_SCAN = np.linspace(0.0, 1.0, 800)
"""Shares of the logarithmic distance from no stretch to the ends of the scan, 0.1 and 8."""


def homogeneous() -> list[Row]:
    """Nominal and Cauchy stress and energy in uniaxial, equibiaxial and planar tension and compression."""
    rows = []
    for mode in Mode:
        data = read_reference("yeoh_homogeneous").where(mode=mode)
        stretch = data["stretch"]
        curve = trace_curve(YEOH, mode, stretch)
        difference, slope = _differences(YEOH, mode, stretch)
        rate = slope[:, 0] @ _RATES[mode]
        ours = {
            "nominal1_Pa": curve.nominal,
            "cauchy1_Pa": curve.cauchy,
            "cauchy2_Pa": curve.cauchy_constraint,
            "W_Pa": curve.energy,
            "dnominal1_dstretch_Pa": (rate - difference[:, 0]) / stretch**2,
            "drucker_min_eig_Pa": _drucker(YEOH, mode, stretch),
        }
        at = [f"stretch {value:g}" for value in stretch]
        for column, values in ours.items():
            scale = np.maximum(np.abs(data[column]), 1.0)
            rows.append(compare(f"{column}, {mode}", 1e6 * values, data[column], _PRINTED, at, scale))
    return rows


def simple_shear() -> list[Row]:
    """Shear stress and the normal stress of Poynting's effect, the third direction free of stress."""
    data = read_reference("yeoh_simple_shear")
    F = np.tile(np.eye(3), (len(data), 1, 1))
    F[:, 0, 1] = data["gamma"]
    energy, tau, _ = YEOH.evaluate(F)
    ours = {
        "cauchy12_Pa": tau[:, 3],
        "cauchy11_Pa": tau[:, 0] - tau[:, 2],
        "cauchy22_Pa": tau[:, 1] - tau[:, 2],
        "W_Pa": energy,
    }
    at = [f"gamma {value:g}" for value in data["gamma"]]
    shear = np.maximum(data["cauchy12_Pa"], 1.0)
    scales = {"cauchy22_Pa": shear}
    return [
        compare(key, 1e6 * value, data[key], _PRINTED, at, scales.get(key, np.maximum(np.abs(data[key]), 1.0)))
        for key, value in ours.items()
    ]


def one_element() -> list[Row]:
    """Compare one cell in frictionless tension: nominal stress at K/mu = 1e5, change of volume at 2000."""
    rows, soft = [], YEOH.with_bulk_ratio(2000.0)
    for mode in Mode:
        data = read_reference("yeoh_homogeneous").where(mode=mode).between("stretch", 0.5, 2.0)
        nominal = [_pull_cube(YEOH, mode, stretch)[0] for stretch in data["stretch"]]
        volume = [_pull_cube(soft, mode, stretch)[1] for stretch in data["stretch"]]
        at = [f"stretch {value:g}" for value in data["stretch"]]
        scale = np.maximum(np.abs(data["nominal1_Pa"]), 1.0)
        expected = 1e-6 * (data["cauchy1_Pa"] + data["cauchy2_Pa"]) / 3 / soft.bulk_modulus
        rows += [
            compare(f"nominal stress, {mode}, Pa", 1e6 * np.array(nominal), data["nominal1_Pa"], 1e-3, at, scale),
            compare(f"J - 1 over its maximum, {mode}", volume, expected, 2e-2, at, np.abs(expected).max()),
        ]
    return rows


def _pull_cube(material: Material, mode: Mode, stretch: float) -> tuple[float, float]:
    """Nominal stress (MPa) and J - 1 of a unit cube of one cell with prescribed stretch of its faces."""
    grid = join(map_block((even(1),) * 3, lambda q: q))
    imposed = {Mode.UNIAXIAL: [0], Mode.EQUIBIAXIAL: [0, 1], Mode.PLANAR: [0, 1]}[mode]
    fixed = np.stack([grid.near(axis, 0.0) for axis in range(3)], axis=-1)
    for axis in imposed:
        fixed[grid.near(axis, 1.0), axis] = True
    solid = make_solid(grid, material, fixed)
    principal = stretches(mode, np.array([stretch]))[0]
    state = find_equilibrium(solid, grid.nodes * (principal - 1)).state
    force = reactions(solid, state)[grid.near(0, 1.0), 0].sum()
    corner = state.u[grid.near(0, 1.0) & grid.near(1, 1.0) & grid.near(2, 1.0)][0]
    return float(force), float(np.prod(1 + corner) - 1)


def one_element_in_shear() -> list[Row]:
    """One cell in simple shear, its surface prescribed: the Cauchy stress at its Gauss points."""
    data = read_reference("yeoh_simple_shear").between("gamma", 0.01, 2.0)
    grid = join(map_block((even(1),) * 3, lambda q: q))
    middle = np.all(np.abs(grid.nodes - 0.5) < 0.1, axis=1)
    solid = make_solid(grid, YEOH, np.repeat(~middle[:, None], 3, axis=1))
    shear, poynting = [], []
    for gamma in data["gamma"]:
        displacement = np.zeros(grid.nodes.shape)
        displacement[:, 0] = gamma * grid.nodes[:, 1]
        stress = 1e6 * cauchy_stress(solid, find_equilibrium(solid, displacement).state)[0]
        shear.append(stress[:, 3].mean())
        poynting.append((stress[:, 0] - stress[:, 1]).mean())
    at = [f"gamma {value:g}" for value in data["gamma"]]
    return [
        compare("cauchy12_Pa", shear, data["cauchy12_Pa"], 1e-8, at),
        compare("cauchy11_Pa - cauchy22_Pa", poynting, data["cauchy11_Pa"] - data["cauchy22_Pa"], 1e-8, at),
    ]


def drucker_limits() -> list[Row]:
    """Compare the first unstable stretch in tension and compression, from 0.1 to 8; nan if stable."""
    data = read_reference("yeoh_drucker_limits")
    coefficients = zip(data["C10_Pa"], data["C20_Pa"], data["C30_Pa"], strict=True)
    at = data.labels("C10_Pa", "C20_Pa", "mode")
    rows = []
    found = np.array(
        [
            [
                _first_unstable(
                    Material("Yeoh", LAWS.get("yeoh").from_numbers([1e-6 * float(each) for each in c])),
                    Mode(mode),
                    end,
                )
                for end in (8.0, 0.1)
            ]
            for c, mode in zip(coefficients, data.labels("mode"), strict=True)
        ]
    )
    for k, way in enumerate(("tension", "compression")):
        rows.append(compare(f"stretch, {way}", found[:, k], data[f"first_unstable_stretch_{way}"], 1e-4, at))
    return rows


def _first_unstable(material: Material, mode: Mode, end: float) -> float:
    """First stretch on the way to `end` at which the Drucker matrix is singular; nan if stable."""
    path = end ** _SCAN[1:]
    unstable = np.flatnonzero(_drucker(material, mode, path) <= 0)
    if not len(unstable) or unstable[0] == 0:
        return float("nan") if not len(unstable) else float(path[0])
    first = unstable[0]
    between = path[first - 1], path[first]
    return float(brentq(lambda stretch: _drucker(material, mode, np.array([stretch]))[0], *between, xtol=1e-10))


def _drucker(material: Material, mode: Mode, stretch: FloatArray) -> FloatArray:
    """Smallest eigenvalues (n,) MPa of the Drucker matrix at stretches (n,)."""
    _, slope = _differences(material, mode, stretch)
    return np.asarray(np.linalg.eigvalsh(slope)[:, 0])


def _differences(material: Material, mode: Mode, stretch: FloatArray) -> tuple[FloatArray, FloatArray]:
    """``tau_i - tau_3`` (n, 2) and its Drucker matrix (n, 2, 2), MPa.

    In principal axes the spatial tangent is ``c_ij = d tau_i / d eps_j - 2 tau_i delta_ij``.
    """
    _, tau, c = material.evaluate(stretches(mode, stretch)[:, :, None] * np.eye(3))
    slope = c[:, :3, :3] + 2 * tau[:, :3, None] * np.eye(3)
    against_third = slope[:, :2] - slope[:, 2:]
    return tau[:, :2] - tau[:, 2:3], against_third[:, :, :2] - against_third[:, :, 2:]
