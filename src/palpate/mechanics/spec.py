"""What a user chooses about the solver."""

from __future__ import annotations

from palpate.core import Spec, parameter

BASE_RADIUS = 20.0
"""Base radius in mm of the skin for which the lengths of a `SolverSpec` are given: that of the paper's domes."""


class SolverSpec(Spec):
    """How a press is solved. The defaults hold 1 % in force and marker displacement over the paper's grid."""

    backend: str = parameter("auto", unit="", meaning="linear solver, or auto; `palpate doctor` lists them")
    penalty_ratio: float = parameter(
        60.0,
        unit="1",
        meaning="contact penalty over E/T; ten times more changes the force by less than 0.1 %",
        gt=1,
        le=1e6,
    )
    tangential_ratio: float = parameter(1.0, unit="1", meaning="friction spring over contact penalty", gt=0, le=10)
    smoothing_ratio: float = parameter(
        1e-3, unit="1", meaning="width of the penalty's smooth start over the wall's thickness", gt=0, le=0.1
    )
    adhesion: float = parameter(
        2e-2,
        unit="1",
        meaning="tension over E up to which the flat branch is held; beyond it the dome may turn inside out",
        ge=0,
        le=0.1,
    )
    tolerance: float = parameter(1e-4, unit="1", meaning="greatest residual over mu T²", gt=1e-12, le=1e-2)
    first_step: float = parameter(
        0.1, unit="mm", meaning="first increment, for a base radius of 20 mm; it grows with the skin", gt=0, le=10
    )
    largest_step: float = parameter(
        0.8, unit="mm", meaning="largest increment, for a base radius of 20 mm; it grows with the skin", gt=0, le=10
    )
    edge_share: float = parameter(
        0.4,
        unit="1",
        meaning="advance of the patch's edge in an increment over the wall's thickness, at most; 1.5 times "
        "that without friction, 0.8 times where points slip",
        source="docs/design_notes/mechanics.md",
        gt=0.01,
        le=10,
    )
    smallest_step: float = parameter(
        1e-3,
        unit="mm",
        meaning="smallest increment before the press gives up, for a base radius of 20 mm",
        gt=0,
        le=1,
    )
    derivatives: tuple[str, ...] = parameter(
        (),
        unit="",
        meaning="what a press is differentiated by, such as tilt_deg or thickness (palpate.fea.variations)",
    )
    iterations: int = parameter(
        16, unit="1", meaning="Newton iterations before an increment is shortened", ge=4, le=100
    )
