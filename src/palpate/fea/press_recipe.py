"""Recipe of a press in the store, for any solver."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from palpate.core import Recipe, stage_version
from palpate.design import SkinSpec
from palpate.fea.branch import Branch
from palpate.fea.io import PRESS_FORMAT
from palpate.fea.spec import ObstacleSpec
from palpate.material import Material
from palpate.mesh import MeshSpec


def press_recipe(
    skin: SkinSpec,
    mesh: MeshSpec,
    material: Material,
    wall: ObstacleSpec,
    solver: Mapping[str, Any],
    branch: Branch = Branch.FLAT,
) -> Recipe:
    """Return the recipe of a press on one `branch`.

    `solver` contains the data of the `SolverSpec` of palpate's solver; else the solver's name and the data of its
    spec.
    """
    spec = {
        "dome": skin.model_dump(mode="json"),
        "mesh": mesh.model_dump(mode="json"),
        "material": material.key_data(),
        "obstacle": wall.model_dump(mode="json"),
        "solver": dict(solver),
        "branch": str(branch),
    }
    gel = () if material.gel is None else (material.gel.law,)
    version = f"{stage_version('press', skin, material.law, *gel, wall)}; format {PRESS_FORMAT}"
    return Recipe(kind="inverted" if branch is Branch.INVERTED else "press", spec=spec, version=version)
