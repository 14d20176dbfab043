"""The budgets of the code, held over every file of the package."""

import ast
import statistics
from collections.abc import Iterator
from pathlib import Path

import pytest

SOURCE = Path(__file__).parents[2] / "src" / "palpate"
FILES = sorted(SOURCE.rglob("*.py"))

FILE_LINES, FILE_LINES_P90 = 400, 300
FUNCTION_LINES, FUNCTION_LINES_P90 = 60, 30
ARGUMENTS = 6
FORBIDDEN_NAMES = {"utils", "helpers", "common", "misc", "base", "manager"}

Function = ast.FunctionDef | ast.AsyncFunctionDef


def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text())


def name(path: Path) -> str:
    return str(path.relative_to(SOURCE))


def functions(path: Path) -> Iterator[Function]:
    return (node for node in ast.walk(tree(path)) if isinstance(node, Function))


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


@pytest.mark.parametrize("path", FILES, ids=name)
def test_a_file_fits_its_budget(path: Path) -> None:
    assert len(path.read_text().splitlines()) <= FILE_LINES
    assert path.stem not in FORBIDDEN_NAMES


def test_nine_files_of_ten_are_short() -> None:
    lines = [len(path.read_text().splitlines()) for path in FILES]
    assert statistics.quantiles(lines, n=10)[-1] <= FILE_LINES_P90


@pytest.mark.parametrize("path", FILES, ids=name)
def test_functions_fit_their_budget(path: Path) -> None:
    long = {function.name: body_lines(function) for function in functions(path)}
    assert {key: lines for key, lines in long.items() if lines > FUNCTION_LINES} == {}


def test_nine_functions_of_ten_are_short() -> None:
    lines = [body_lines(function) for path in FILES for function in functions(path)]
    assert statistics.quantiles(lines, n=10)[-1] <= FUNCTION_LINES_P90


@pytest.mark.parametrize("path", FILES, ids=name)
def test_functions_take_few_arguments(path: Path) -> None:
    """More than six arguments are a spec; compiled kernels take arrays, which no spec can carry."""
    many = {}
    for function in functions(path):
        arguments = [*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs]
        count = len([item for item in arguments if item.arg not in ("self", "cls")])
        if count > ARGUMENTS and not is_kernel(function) and function.name != "parameter":
            many[function.name] = count
    assert many == {}


def is_kernel(function: Function) -> bool:
    return any(isinstance(mark, ast.Name) and mark.id == "kernel" for mark in function.decorator_list)


@pytest.mark.parametrize("path", FILES, ids=name)
def test_everything_public_says_what_it_is(path: Path) -> None:
    module = tree(path)
    assert ast.get_docstring(module), "the module has no docstring"
    silent = [
        getattr(node, "name", "")
        for node, owner in public_nodes(module)
        if isinstance(node, Function | ast.ClassDef)
        and not ast.get_docstring(node)
        and not (isinstance(node, Function) and is_abstract_implementation(node, owner))
        and not (isinstance(node, Function) and is_contract_test(node, path))
    ]
    assert silent == []


@pytest.mark.parametrize("path", FILES, ids=name)
def test_functions_are_fully_typed(path: Path) -> None:
    untyped = []
    for function in functions(path):
        arguments = [*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs]
        bare = [item.arg for item in arguments if item.annotation is None and item.arg not in ("self", "cls")]
        if bare or function.returns is None:
            untyped.append(function.name)
    assert untyped == []


@pytest.mark.parametrize("path", FILES, ids=name)
def test_forbidden_constructs_are_absent(path: Path) -> None:
    found = []
    in_cli = path.is_relative_to(SOURCE / "cli")
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.ImportFrom) and any(alias.name == "*" for alias in node.names):
            found.append(f"star import in line {node.lineno}")
        if isinstance(node, ast.ExceptHandler) and node.type is None:
            found.append(f"bare except in line {node.lineno}")
        if isinstance(node, ast.Global):
            found.append(f"global in line {node.lineno}")
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "print" and not in_cli:
            found.append(f"print in line {node.lineno}")
        if isinstance(node, Function):
            defaults = [*node.args.defaults, *node.args.kw_defaults]
            if any(isinstance(default, ast.List | ast.Dict | ast.Set) for default in defaults):
                found.append(f"mutable default of {node.name}")
    assert found == []
