"""Writing and reading of an identified unit: a JSON file with which a sensor is opened."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from palpate.calibration.force import ScalarEstimate
from palpate.calibration.mounting import MOUNTING_PARAMETERS, Mounting
from palpate.calibration.unit_model import UNIT_PARAMETERS, UnitPosterior
from palpate.camera import CameraSpec
from palpate.core import FloatArray, PalpateError, atomic_write, provenance
from palpate.core.state import State
from palpate.design import MarkerLayout, Skin

UNIT_VERSION = "3"
_KIND = "palpate unit"
_AGAIN = "Make it again with `palpate calibration identify`."


@dataclass(frozen=True, eq=False)
class IdentifiedUnit:
    """An identified unit.

    Attributes
    ----------
    skin_data, markers_mm
        Its design: the skin's spec as plain data, and the layout (m, 3) mm.
    posterior, mounting
        Posterior of its parameters, and mounting on its robot.
    scale
        Stiffness relative to the design.
    """

    skin_data: dict[str, Any]
    markers_mm: FloatArray
    posterior: UnitPosterior
    mounting: Mounting
    scale: ScalarEstimate

    def check(self, skin: Skin, layout: MarkerLayout) -> None:
        """Raise a `PalpateError` if skin or layout differ from the unit's design."""
        same = len(layout) == len(self.markers_mm) and np.allclose(layout.positions, self.markers_mm, atol=1e-6)
        if skin.spec_data != self.skin_data or not same:
            raise PalpateError(
                f"The design of the unit file differs from {skin.name} with {len(layout)} markers.",
                "Give the file of this unit, or the options of its design.",
                code="unit-design-differs",
            )


def write_unit(path: Path, unit: IdentifiedUnit) -> None:
    """Write an identified unit.

    Raises
    ------
    PalpateError
        If the file cannot be written.
    """
    belief, mounting = unit.posterior, unit.mounting
    sd = np.sqrt(np.diag(mounting.covariance))
    values = np.concatenate([belief.mean.values, mounting.mean.values])
    content = {
        "kind": _KIND,
        "version": UNIT_VERSION,
        "skin": unit.skin_data,
        "markers_mm": unit.markers_mm.tolist(),
        "camera": belief.nominal.model_dump(mode="json"),
        "rest_px": [None if np.isnan(u) else [u, v] for u, v in belief.rest_px.tolist()],
        "parameters": {
            name: {"mean": float(mean), "sd": float(deviation)}
            for name, mean, deviation in zip((*UNIT_PARAMETERS, *MOUNTING_PARAMETERS), values, sd, strict=True)
        },
        "stiffness": {"mean": unit.scale.value, "sd": unit.scale.sd},
        "covariance": mounting.covariance.tolist(),
        "made_by": provenance(),
    }
    with atomic_write(path) as draft:
        draft.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def read_unit(path: Path) -> IdentifiedUnit:
    """Read an identified unit.

    Raises
    ------
    PalpateError
        If the file is not a unit of this version.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        if content.get("kind") != _KIND or content.get("version") != UNIT_VERSION:
            raise PalpateError(f"{path} is not a unit of version {UNIT_VERSION}.", _AGAIN, code="unit-file-version")
        values = np.array(
            [content["parameters"][name]["mean"] for name in (*UNIT_PARAMETERS, *MOUNTING_PARAMETERS)], float
        )
        covariance = np.array(content["covariance"], float)
        rest = np.array([[np.nan, np.nan] if dot is None else dot for dot in content["rest_px"]], float)
        unit = IdentifiedUnit(
            content["skin"],
            np.array(content["markers_mm"], float).reshape(-1, 3),
            UnitPosterior(
                CameraSpec.model_validate(content["camera"]),
                rest.reshape(-1, 2),
                State(UNIT_PARAMETERS, values[: len(UNIT_PARAMETERS)]),
                covariance[: len(UNIT_PARAMETERS), : len(UNIT_PARAMETERS)],
            ),
            Mounting(State(MOUNTING_PARAMETERS, values[len(UNIT_PARAMETERS) :]), covariance),
            ScalarEstimate(float(content["stiffness"]["mean"]), float(content["stiffness"]["sd"])),
        )
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise PalpateError(
            f"{path} cannot be read as a unit: {error}.", _AGAIN, code="unit-file-unreadable"
        ) from None
    size = len(UNIT_PARAMETERS) + len(MOUNTING_PARAMETERS)
    sound = covariance.shape == (size, size) and np.isfinite(covariance).all() and np.isfinite(values).all()
    sound = sound and unit.scale.value > 0 and unit.scale.sd >= 0
    if (
        not sound
        or len(unit.posterior.rest_px) != len(unit.markers_mm)
        or np.linalg.eigvalsh(covariance).min() < -1e-9
    ):
        raise PalpateError(f"{path} contains invalid numbers.", _AGAIN, code="unit-file-damaged")
    return unit
