"""Configuration of the solver of a press."""

from __future__ import annotations

from palpate.core import Spec, parameter

BASE_RADIUS = 20.0
"""Base radius, mm, for which the lengths of a `SolverSpec` are given: that of the paper's domes."""


class SolverSpec(Spec):
    """Settings of the solver; the defaults keep force and markers within 1 % over the paper's grid."""

    backend: str = parameter("auto", unit="", meaning="linear solver, or auto; `palpate doctor` lists them")
    penalty_ratio: float = parameter(
        60.0,
        unit="1",
        meaning="contact penalty over E/T; a tenfold penalty changes the force by 0.2 %",
        gt=1,
        le=1e6,
    )
    tangential_ratio: float = parameter(
        1.0, unit="1", meaning="ratio of tangential to normal contact penalty", gt=0, le=10
    )
    smoothing_ratio: float = parameter(
        1e-3, unit="1", meaning="smoothing width of the contact penalty over the skin thickness", gt=0, le=0.1
    )
    adhesion: float = parameter(
        2e-2,
        unit="1",
        meaning="maximum stabilisation tension over E on the flat branch; above it, the dome may snap through",
        ge=0,
        le=0.1,
    )
    tolerance: float = parameter(1e-4, unit="1", meaning="maximum residual over mu T²", gt=1e-12, le=1e-2)
    first_step: float = parameter(
        0.1, unit="mm", meaning="first increment for a base radius of 20 mm; scales with the base radius", gt=0, le=10
    )
    largest_step: float = parameter(
        0.8,
        unit="mm",
        meaning="maximum increment for a base radius of 20 mm; scales with the base radius",
        gt=0,
        le=10,
    )
    edge_share: float = parameter(
        0.4,
        unit="1",
        meaning="maximum advance of the contact edge per increment over the skin thickness; 1.5 times this value "
        "without friction, 0.8 times with slipping points",
        source="docs/design_notes/mechanics.md",
        gt=0.01,
        le=10,
    )
    smallest_step: float = parameter(
        1e-3,
        unit="mm",
        meaning="minimum increment for a base radius of 20 mm; the press ends below it",
        gt=0,
        le=1,
    )
    derivatives: tuple[str, ...] = parameter(
        (),
        unit="",
        meaning="parameters of the derivatives of a press, such as tilt_deg or thickness (palpate.fea.variations)",
    )
    iterations: int = parameter(
        16, unit="1", meaning="maximum Newton iterations before an increment is shortened", ge=4, le=100
    )
