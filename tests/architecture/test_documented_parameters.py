"""What a docstring names is what the code has: parameters those of the signature, attributes those of the class."""

import ast
import re
from functools import cache

from source_files import FILES, name, nodes

Function = ast.FunctionDef | ast.AsyncFunctionDef


def documented(node: Function | ast.ClassDef, section: str) -> list[str]:
    """Names that a section in numpy's style explains; several may share a line."""
    found = re.search(rf"^{section}\n-+\n(.*?)(?=^\w[\w ]*\n-+$|\Z)", ast.get_docstring(node) or "", re.M | re.S)
    heads = re.findall(r"^[\w*].*", found[1], re.M) if found else []
    return [name.strip(" *") for head in heads for name in head.split(" : ")[0].split(",")]


def arguments(function: Function) -> list[str]:
    spec = function.args
    named = [*spec.posonlyargs, *spec.args, spec.vararg, *spec.kwonlyargs, spec.kwarg]
    return [item.arg for item in named if item is not None and item.arg not in ("self", "cls")]


def fields(owner: ast.ClassDef, shared: bool = False) -> list[str]:
    """Public fields that a class declares; those of the class itself (``ClassVar``) where `shared`."""
    declared = [item for item in owner.body if isinstance(item, ast.AnnAssign) and isinstance(item.target, ast.Name)]
    chosen = [item for item in declared if shared or "ClassVar" not in ast.dump(item.annotation)]
    return [name for item in chosen if not (name := ast.unparse(item.target)).startswith("_")]


def methods(owner: ast.ClassDef) -> dict[str, Function]:
    return {item.name: item for item in owner.body if isinstance(item, Function)}


@cache
def classes() -> dict[str, ast.ClassDef]:
    """Every class of the package by its name."""
    return {node.name: node for path in FILES for node in nodes(path) if isinstance(node, ast.ClassDef)}


def inherited(owner: ast.ClassDef) -> set[str]:
    """Fields, properties and what `__init__` sets, of a class and of those it builds on."""
    bases = [classes()[base.id] for base in owner.bases if isinstance(base, ast.Name) and base.id in classes()]
    own = {
        node.attr for node in ast.walk(owner) if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store)
    }
    return own.union(
        fields(owner, shared=True), methods(owner), *(inherited(base) for base in bases if base is not owner)
    )


def faults_of(node: Function | ast.ClassDef) -> list[str]:
    taken = node if isinstance(node, Function) else methods(node).get("__init__")
    named = documented(node, "Parameters")
    faults = [
        f"{node.name}: {named} are not {arguments(taken)}" for _ in named[:1] if taken and named != arguments(taken)
    ]
    if isinstance(node, ast.ClassDef) and (named := documented(node, "Attributes")):
        is_record = "dataclass" in ast.dump(ast.Tuple(node.decorator_list)) or "NamedTuple" in ast.dump(
            ast.Tuple(node.bases)
        )
        faults += [f"{node.name} has no {name}" for name in named if name not in inherited(node)]
        faults += [
            f"{node.name}: {name} is not explained" for name in fields(node) if is_record and name not in named
        ]
    return faults


def test_docstrings_name_what_the_code_has() -> None:
    found = [
        f"{name(path)}: {fault}"
        for path in FILES
        for node in nodes(path)
        if isinstance(node, Function | ast.ClassDef)
        for fault in faults_of(node)
    ]
    assert found == []
