"""Draft of a design on the page, with its findings."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, BeforeValidator

from palpate.camera import CameraSpec
from palpate.core import PalpateError, Spec
from palpate.design import (
    Design,
    DomeSpec,
    Finding,
    MarkerSpec,
    Severity,
    SkinSpec,
    skin_from_data,
)
from palpate.fabrication import ProcessSpec, check_process
from palpate.fea import WallSpec
from palpate.mesh import MeshSpec, mesh_skin
from palpate.study import MaterialSpec
from palpate.viewer.library import RenderedSkin
from palpate.viewer.pressed_skin import PressedSkin
from palpate.viewer.results import GridDesign
from palpate.viewer.shell import build_shell

REST_CELLS = 16
"""Cells from pole to rim of a skin that is only displayed."""


def _as_skin(given: Any) -> Any:
    return skin_from_data(given) if isinstance(given, dict) else given


class DesignDraft(Spec):
    """Design with its press and its fabrication settings."""

    skin: Annotated[SkinSpec, BeforeValidator(_as_skin)] = DomeSpec()
    markers: MarkerSpec = MarkerSpec()
    material: MaterialSpec = MaterialSpec()
    camera: CameraSpec = CameraSpec()
    obstacle: WallSpec = WallSpec()
    process: ProcessSpec = ProcessSpec()

    @cached_property
    def design(self) -> Design:
        """The design of these values."""
        return Design(self.skin, self.markers, self.camera, self.material.material())


@dataclass(frozen=True, eq=False)
class DesignPreview:
    """Displayed draft: the design, its skin at rest, and findings, errors first."""

    design: GridDesign
    specimen: RenderedSkin
    findings: tuple[Finding, ...]


def build_preview(sketch: DesignDraft) -> DesignPreview:
    """Build the skin of a draft at rest and check it, in milliseconds.

    Raises
    ------
    PalpateError
        If the skin cannot be built or its markers cannot be placed.
    """
    skin, layout, camera = sketch.design.skin, sketch.design.layout, sketch.design.camera
    if not layout.on_dome.all():
        raise PalpateError(
            "Some markers lie outside the dome.", "Use smaller rings, or a wider dome.", code="markers-outside-skin"
        )
    mesh = mesh_skin(skin, MeshSpec(cells=REST_CELLS))
    findings = check_process(sketch.design, sketch.process)
    hidden = int((~camera.visible(layout.positions, skin)).sum())
    if hidden:
        remedy = "Move the camera further away, or leave the outer ring out."
        sentence = f"{hidden} of {len(layout)} markers are out of the camera's sight."
        findings = (Finding(Severity.WARNING, "markers-out-of-sight", sentence, remedy), *findings)
    order = list(Severity)
    findings = tuple(sorted(findings, key=lambda finding: order.index(finding.severity)))
    design = GridDesign(-1, sketch_row(sketch), sketch.design, ())
    return DesignPreview(
        design, RenderedSkin(PressedSkin(mesh, None, sketch.obstacle.tilt_deg), build_shell(mesh)), findings
    )


def sketch_row(sketch: DesignDraft) -> dict[str, float | int | str | None]:
    """Return the figures of a draft that a grid has as well."""
    return {
        "height_mm": sketch.skin.height,
        "base_radius_mm": sketch.skin.base_radius,
        "thickness_mm": sketch.skin.thickness,
        "markers": sketch.markers.count,
    }


def bounds_of(spec: type[BaseModel], name: str) -> tuple[float, float]:
    """Minimum and maximum of a spec's field, as declared; infinite if undeclared."""
    low, high = -np.inf, np.inf
    for item in spec.model_fields[name].metadata:
        low = max(low, *(float(_bound(item, word, -np.inf)) for word in ("ge", "gt")))
        high = min(high, *(float(_bound(item, word, np.inf)) for word in ("le", "lt")))
    return low, high


def _bound(item: Any, word: str, usual: float) -> float:
    found = getattr(item, word, None)
    return usual if found is None else float(found)
