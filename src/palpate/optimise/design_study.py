"""Study, fabrication pack and camera of a design that the search found."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
from ruamel.yaml import YAML

from palpate.camera import CameraSpec
from palpate.design import Design, MarkerSpec
from palpate.fabrication import FabricationPack, write_pack
from palpate.material import get_material
from palpate.optimise.front import DesignCandidate, Front
from palpate.optimise.spec import RequirementsSpec
from palpate.study import Study

PACKS = "packs"
"""Folder of the packs inside that of a search."""


def camera_of(spec: RequirementsSpec, entry: DesignCandidate) -> CameraSpec:
    """Return the camera of a design at its distance."""
    camera = next(choice.camera for choice in spec.cameras if choice.name == entry.option.camera)
    return camera.model_copy(update={"distance": entry.option.distance})


def design_of(spec: RequirementsSpec, entry: DesignCandidate) -> Design:
    """Return one design of a front."""
    proposal = entry.trial.finest
    return Design(proposal.skin, entry.option.markers, camera_of(spec, entry), get_material(proposal.material))


def design_study(spec: RequirementsSpec, name: str, design: Design, material: str) -> Study:
    """Return the study of a single design over the working range of the requirements.

    `material` is the elastomer's name in a study.
    """
    return Study.model_validate(_study_data(spec, name, design, material))


def winner_study(front: Front, winner: DesignCandidate) -> str:
    """Return the winner's study as YAML, the input of `palpate run` and `palpate design make`."""
    spec = front.spec
    study = _study_data(spec, f"{spec.name}-winner", design_of(spec, winner), winner.trial.finest.material)
    text = io.StringIO()
    YAML().dump(study, text)
    return text.getvalue()


def pack_name(entry: DesignCandidate) -> str:
    """Return the name of a design's pack."""
    return f"skin{entry.trial.number}_{entry.option.markers.count}"


def write_packs(folder: Path, front: Front) -> list[FabricationPack]:
    """Write the missing fabrication packs of the designs on the front.

    Raises
    ------
    PalpateError
        If a pack cannot be made, or the folder cannot be written.
    """
    found = []
    for entry in front.pareto:
        place = folder / PACKS / pack_name(entry)
        if place.exists():
            continue
        place.parent.mkdir(parents=True, exist_ok=True)
        found.append(write_pack(place, design_of(front.spec, entry), front.spec.process))
    return found


def _study_data(spec: RequirementsSpec, name: str, design: Design, material: str) -> dict[str, Any]:
    shape, markers = design.skin_spec.model_dump(), design.markers
    assert isinstance(markers, MarkerSpec), "a search proposes specs"
    sizes = {size: shape.pop(size) for size in ("height", "base_radius", "thickness")}
    return {
        "name": name,
        "seed": spec.seed,
        "designs": {
            **({"skin": shape} if shape else {}),
            "heights": [sizes["height"]],
            "thicknesses": [sizes["thickness"]],
            "base_radius": sizes["base_radius"],
            "markers": [_marker_data(markers)],
        },
        "material": {"name": material},
        "tilts_deg": [round(float(tilt), 6) for tilt in np.linspace(0.0, spec.max_tilt_deg, 7)],
        "obstacle": {"depth": spec.depth, "depth_step": spec.depth / 10.0},
        "camera": design.camera_spec.model_dump(mode="json", exclude_defaults=True),
        "built": {
            "calibration_presses": max(spec.calibration_presses, 1),
            "tolerance": spec.tolerance.model_dump(exclude_defaults=True),
        },
    }


def _marker_data(markers: MarkerSpec) -> dict[str, Any]:
    if markers.ring_diameters is None:
        return markers.model_dump(mode="json", exclude_none=True)
    return {"ring_diameters": list(markers.ring_diameters), "diameter": markers.diameter}
