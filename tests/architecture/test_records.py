"""One type per concept: a design, and a pose with its uncertainty."""

import ast
from collections.abc import Iterator
from functools import cache

from source_files import FILES, SOURCE, nodes

PARTS = {"skin", "layout", "camera", "material"}
POSES, UNCERTAINTIES = {"pose", "poses", "tilt_deg"}, {"half_width", "half_widths", "covariance", "sd"}
INPUTS = {"Study", "BenchmarkSpec", "DesignDraft", "PackFlags"}
"""Keys of files and flags that a user writes; a method or a task of each returns its designs."""
KNOWN = {
    "SkinEvaluation": "a skin and the name of its elastomer in a search, before markers and camera are chosen",
    "_View": "a camera and the rim that may hide markers from it",
    "Twin": "the skin and the elastomer of its presses, which have neither markers nor a camera",
    "UnitModel": "the layout as designed and the estimated camera of one unit",
}
"""Records that are left, each with the reason; a row may only go."""


@cache
def records() -> tuple[tuple[str, set[str]], ...]:
    """Name and fields of every class: annotated ones, and those that its constructor sets."""
    return tuple(_records())


def _records() -> Iterator[tuple[str, set[str]]]:
    for path in (path for path in FILES if path.is_relative_to(SOURCE)):
        for node in nodes(path):
            if isinstance(node, ast.ClassDef):
                fields = {
                    item.target.id
                    for item in node.body
                    if isinstance(item, ast.AnnAssign) and isinstance(item.target, ast.Name)
                }
                for item in node.body:
                    if isinstance(item, ast.FunctionDef) and item.name == "__init__":
                        fields |= {
                            target.attr.lstrip("_")
                            for target in ast.walk(item)
                            if isinstance(target, ast.Attribute) and isinstance(target.ctx, ast.Store)
                        }
                yield node.name, fields


def test_only_one_record_is_a_design() -> None:
    found = {name for name, fields in records() if len(fields & PARTS) > 1}
    assert found - INPUTS - set(KNOWN) == set()
    assert set(KNOWN) <= found, "a row of KNOWN that no longer applies goes"


def test_only_one_record_is_a_pose_with_its_uncertainty() -> None:
    found = {name for name, fields in records() if fields & POSES and fields & UNCERTAINTIES}
    assert found == {"PoseEstimate"}
