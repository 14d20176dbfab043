"""Press solvers: palpate's own elements, another program, or an installed package."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, final

from palpate.core import Registry
from palpate.fea.branch import Branch
from palpate.fea.spec import ObstacleSpec
from palpate.material import Material
from palpate.mechanics import SolverSpec
from palpate.mesh import Mesh

if TYPE_CHECKING:
    from palpate.fea.press import Press


class PressSolver(ABC):
    """Solver of presses of the flat branch from rest; made without arguments it has default settings."""

    @abstractmethod
    def check(self, obstacle: ObstacleSpec) -> None:
        """Raise if a press cannot be solved, before anything is computed.

        Raises
        ------
        PalpateError
            If a program is missing, or the solver does not support this press.
        """

    @abstractmethod
    def solve(self, mesh: Mesh, material: Material, obstacle: ObstacleSpec) -> Press:
        """Solve one press; its `solved_by` names the solver.

        Raises
        ------
        PalpateError
            If the obstacle does not touch the skin first, or the solver returns no increment.
        """


@final
@dataclass(frozen=True)
class PalpateSolver(PressSolver):
    """Quadratic hexahedra, contact by a penalty, and continuation (see `solve_press`), on one `branch`."""

    spec: SolverSpec = field(default_factory=SolverSpec)
    branch: Branch = Branch.FLAT

    def check(self, obstacle: ObstacleSpec) -> None:
        """Accept every obstacle that a spec can describe."""

    def solve(self, mesh: Mesh, material: Material, obstacle: ObstacleSpec) -> Press:
        from palpate.fea.solve_press import solve_press  # here: flags of a press need the settings alone

        return solve_press(mesh, material, obstacle, self.spec, self.branch)


PRESS_SOLVERS: Registry[type[PressSolver]] = Registry(
    "palpate.press_solvers",
    "press solver",
    {"palpate": "palpate.fea.press_solver:PalpateSolver", "calculix": "palpate.fea.calculix:CalculixSolver"},
    lambda found: isinstance(found, type) and issubclass(found, PressSolver),
)
"""Press solvers by name."""
