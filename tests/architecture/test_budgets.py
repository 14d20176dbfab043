"""The budgets of the code, held over every file of the package."""

import ast
import statistics
from collections.abc import Iterator
from pathlib import Path

from source_files import FILES, SOURCE, name, nodes, tree

FILE_LINES, FILE_LINES_P90 = 400, 300
FUNCTION_LINES, FUNCTION_LINES_P90 = 60, 30
ARGUMENTS = 6
FORBIDDEN_NAMES = {"utils", "helpers", "common", "misc", "base", "manager"}

Function = ast.FunctionDef | ast.AsyncFunctionDef


def functions(path: Path) -> Iterator[Function]:
    return (node for node in nodes(path) if isinstance(node, Function))


def body_lines(function: Function) -> int:
    """Lines of a function without its docstring."""
    assert function.end_lineno is not None
    lines = function.end_lineno - function.lineno + 1
    first = function.body[0]
    if ast.get_docstring(function) is not None:
        assert first.end_lineno is not None
        lines -= first.end_lineno - first.lineno + 1
    return lines


def is_abstract_implementation(function: Function, owner: ast.ClassDef | None) -> bool:
    """Implementers of an abstract method do not repeat its docstring; ruff cannot tell, so bases are the mark."""
    return owner is not None and bool(owner.bases)


def is_contract_test(function: Function, path: Path) -> bool:
    """The tests of a published suite are sentences already."""
    return "testing" in path.parts and function.name.startswith("test_")


def public_nodes(module: ast.Module) -> Iterator[tuple[ast.AST, ast.ClassDef | None]]:
    for node in module.body:
        if isinstance(node, Function | ast.ClassDef) and not node.name.startswith("_"):
            yield node, None
            if isinstance(node, ast.ClassDef):
                methods = (item for item in node.body if isinstance(item, Function))
                yield from ((item, node) for item in methods if not item.name.startswith("_"))


def test_a_file_fits_its_budget() -> None:
    lines = {name(path): len(path.read_text().splitlines()) for path in FILES}
    assert {path: count for path, count in lines.items() if count > FILE_LINES} == {}
    assert statistics.quantiles(lines.values(), n=10)[-1] <= FILE_LINES_P90


def test_a_file_is_named_by_its_concept() -> None:
    assert [name(path) for path in FILES if path.stem in FORBIDDEN_NAMES] == []


def test_functions_fit_their_budget() -> None:
    lines = {f"{name(path)} {one.name}": body_lines(one) for path in FILES for one in functions(path)}
    assert {one: count for one, count in lines.items() if count > FUNCTION_LINES} == {}
    assert statistics.quantiles(lines.values(), n=10)[-1] <= FUNCTION_LINES_P90


def test_functions_take_few_arguments() -> None:
    """More than six arguments are a spec; compiled kernels take arrays, which no spec can carry."""
    counts = {
        f"{name(path)} {one.name}": len(arguments_of(one))
        for path in FILES
        for one in functions(path)
        if not is_kernel(one) and one.name != "parameter"
    }
    assert {one: count for one, count in counts.items() if count > ARGUMENTS} == {}


def arguments_of(function: Function) -> list[ast.arg]:
    arguments = [*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs]
    return [item for item in arguments if item.arg not in ("self", "cls")]


def is_kernel(function: Function) -> bool:
    return any(isinstance(mark, ast.Name) and mark.id == "kernel" for mark in function.decorator_list)


def test_everything_public_has_a_docstring() -> None:
    silent = [
        f"{name(path)} {getattr(node, 'name', '')}"
        for path in FILES
        for node, owner in [(tree(path), None), *public_nodes(tree(path))]
        if isinstance(node, Function | ast.ClassDef | ast.Module)
        and not ast.get_docstring(node)
        and not (isinstance(node, Function) and is_abstract_implementation(node, owner))
        and not (isinstance(node, Function) and is_contract_test(node, path))
    ]
    assert silent == []


def test_functions_are_fully_typed() -> None:
    untyped = [
        f"{name(path)} {one.name}"
        for path in FILES
        for one in functions(path)
        if one.returns is None or any(item.annotation is None for item in arguments_of(one))
    ]
    assert untyped == []


def test_forbidden_constructs_are_absent() -> None:
    found = [f"{name(path)}: {fault}" for path in FILES for node in nodes(path) for fault in faults_of(node, path)]
    assert found == []


def faults_of(node: ast.AST, path: Path) -> Iterator[str]:
    if isinstance(node, ast.ImportFrom) and any(alias.name == "*" for alias in node.names):
        yield f"star import in line {node.lineno}"
    if isinstance(node, ast.ExceptHandler) and node.type is None:
        yield f"bare except in line {node.lineno}"
    if isinstance(node, ast.Global):
        yield f"global in line {node.lineno}"
    if isinstance(node, ast.Call):
        called = ast.unparse(node.func)
        if called == "print" and not path.is_relative_to(SOURCE / "cli"):
            yield f"print in line {node.lineno}"
        if called in ("torch.manual_seed", "np.random.seed"):
            yield f"global random state in line {node.lineno}"
    if isinstance(node, Function):
        defaults = [*node.args.defaults, *node.args.kw_defaults]
        if any(isinstance(default, ast.List | ast.Dict | ast.Set) for default in defaults):
            yield f"mutable default of {node.name}"
