"""Documentation: MyST pages, the reference from docstrings, the tables of specs and commands from the program."""

from __future__ import annotations

import importlib
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE.parent / "src"), str(HERE)]

from palpate import __version__  # noqa: E402
from palpate.cli.app import app  # noqa: E402
from palpate.core import Spec, parameters  # noqa: E402

project, author, copyright, release = "palpate", "The palpate developers", "The palpate developers", __version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_copybutton", "mathml"]
myst_enable_extensions = ["dollarmath", "amsmath", "deflist"]
myst_heading_anchors = 3
exclude_patterns = ["_build", "results/**/*.csv", "images/*.py"]
html_theme = "pydata_sphinx_theme"
html_theme_options = {
    "show_toc_level": 2,
    "navigation_with_keys": False,
    "header_links_before_dropdown": 7,
    "secondary_sidebar_items": ["page-toc"],
}
html_sidebars = {page: [] for page in ("index", "install", "quick_start", "where_to_add")}
html_show_sourcelink = False
highlight_language = "text"
html_title = "palpate"
autodoc_member_order = "groupwise"
autodoc_typehints = "none"
napoleon_google_docstring = False
nitpicky = False
suppress_warnings = ["ref.python", "myst.header"]

STAGES = [
    "material",
    "camera",
    "design",
    "mesh",
    "vision",
    "fabrication",
    "mechanics",
    "fea",
    "surrogate",
    "calibration",
    "datasets",
    "learn",
    "sensor",
    "simulation",
    "rig",
    "study",
    "optimise",
    "verify",
    "testing",
]
PLUGINS = ["palpate_zaid2024", "palpate_benchmark"]


def commands(part: Any = app, words: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """Words of every verb."""
    for name in part:
        if part[name].default_command is not None:
            yield (*words, name)
        elif not name.startswith("-"):
            yield from commands(part[name], (*words, name))


def write_reference() -> None:
    """Write a page a stage: its specs as tables, its public names from their docstrings; and one of the commands."""
    for title in [*(f"palpate.{stage}" for stage in STAGES), *PLUGINS]:
        module = importlib.import_module(title)
        lines = [f"# {title}", "", f"```{{automodule}} {title}", "```", ""]
        for name in sorted(module.__all__):
            item = getattr(module, name)
            if isinstance(item, type) and issubclass(item, Spec):
                lines += _table(item)
            elif callable(item) and getattr(item, "__module__", "").startswith("palpate"):
                kind = "autoclass" if isinstance(item, type) else "autofunction"
                lines += [f"```{{{kind}}} {title}.{name}", *([":members:"] if kind == "autoclass" else []), "```", ""]
        _write(HERE / "reference" / f"{title.removeprefix('palpate.')}.md", "\n".join(lines))
    lines = ["# Commands", "", "`palpate COMMAND --help`, as the program prints it.", ""]
    for words in commands():
        call = [sys.executable, "-m", "palpate", *words, "--help"]
        text = subprocess.run(call, capture_output=True, text=True, check=True, cwd=HERE.parent, env=_plain()).stdout
        lines += [f"## palpate {' '.join(words)}", "", "```text", text.strip(), "```", ""]
    _write(HERE / "reference" / "commands.md", "\n".join(lines))


def write_examples() -> None:
    """Run every example and show its program, what it printed and what it drew."""
    place = HERE / "reference" / "examples"
    place.mkdir(parents=True, exist_ok=True)
    lines = ["# Examples", "", "Each was run when this page was made, and a test asserts its number.", ""]
    programs = sorted((HERE.parent / "examples").glob("ex*.py"))
    for number, program in enumerate(programs, start=1):
        print(f"running {program.stem} ({number} of {len(programs)})", flush=True)
        text = _run_example(program, place)
        title = program.read_text(encoding="utf-8").split("\n", 1)[0].strip('"').rstrip(".")
        lines += [
            f"## {title}",
            "",
            f"```{{literalinclude}} ../../examples/{program.name}",
            ":language: python",
            "```",
            "",
        ]
        lines += ["It prints", "", "```text", text.strip(), "```", ""]
        if (place / f"{program.stem}.svg").is_file():
            lines += [f"![{title}](examples/{program.stem}.svg)", ""]
    _write(HERE / "reference" / "examples.md", "\n".join(lines))


def _run_example(program: Path, place: Path) -> str:
    """What an example prints, or the package that it lacks; kept until a source changes."""
    kept = place / f"{program.stem}.txt"
    newest = max(path.stat().st_mtime for path in [program, *(HERE.parent / "src").rglob("*.py")])
    if not kept.is_file() or kept.stat().st_mtime < newest:
        call = [sys.executable, str(program)]
        done = subprocess.run(call, capture_output=True, text=True, check=False, cwd=place, env=_plain())
        if missing := re.search(r"^ModuleNotFoundError: (No module named .*)$", done.stderr, re.MULTILINE):
            print(f"{program.stem}: {missing[1]}", flush=True)
            return missing[1]
        if done.returncode:
            raise RuntimeError(f"{program.name} failed:\n{done.stderr}")
        kept.write_text(done.stdout, encoding="utf-8")
    return kept.read_text(encoding="utf-8")


def _table(spec: type[Spec]) -> list[str]:
    lines = [f"## {spec.__name__}", "", (spec.__doc__ or "").strip().splitlines()[0], ""]
    lines += ["| name | default | unit | meaning |", "|---|---|---|---|"]
    for note in parameters(spec):
        default = spec.model_fields[note.name].get_default(call_default_factory=True)
        lines.append(f"| `{note.name}` | {default} | {note.unit} | {note.meaning} |")
    return [*lines, ""]


def _plain() -> dict[str, str]:
    return {
        **os.environ,
        "COLUMNS": "100",
        "NO_COLOR": "1",
        "MPLBACKEND": "agg",
        "PYTHONPATH": str(HERE.parent / "src"),
    }


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(exist_ok=True)
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


write_reference()
write_examples()
