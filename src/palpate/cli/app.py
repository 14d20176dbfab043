"""The command `palpate`: its subcommands, loaded only when called, and its exit codes.

0 done · 1 a negative result, or a fault of the program, with a log · 2 bad input, with a remedy · 130 interrupted
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from importlib.util import find_spec
from typing import Annotated, Any, cast

import docstring_parser
from cyclopts import App, Parameter

from palpate import __version__
from palpate.cli.border import guarded
from palpate.cli.costs import cost_sentence
from palpate.core import PalpateError

_parse = docstring_parser.parse_from_object


def _parse_functions(described: Any) -> docstring_parser.Docstring:
    """Parse docstrings of functions only; each field of a class has a help of its own."""
    return docstring_parser.parse("") if isinstance(described, type) else _parse(described)


cast(Any, docstring_parser).parse_from_object = _parse_functions  # cyclopts looks it up at each call

_VERBS = {
    "run": ("run:run", "Run a study: presses, data, training and accuracy of every design."),
    "press": ("press:press", "Solve one press of a skin by a wall or another obstacle."),
    "search": ("optimise:optimise", "Search the best design that meets requirements."),
    "view": ("view:view", "Show results in a browser; design and press a dome there."),
    "verify": ("verify:verify", "Solve problems with known solutions and compare."),
    "doctor": ("doctor:doctor", "List installed and missing packages, with remedies."),
}
"""Verb → place below `palpate.cli`, and help."""
_PLUGINS = {
    "benchmark": ("palpate_benchmark", "cli:app", "Make the open data set, score predictions, run baselines."),
    "claims": ("palpate_zaid2024", "cli:claims", "Compare finished studies with the claims of the paper."),
}
"""Verb → package of the plug-in, place in it, and help."""
_GROUPS = {
    "design": (
        "Show a design, press it, and write the files to build or simulate it.",
        {
            "show": ("design:design", "Show radius, shape, markers and limits of a design."),
            "press": _VERBS["press"],
            "stability": ("stability:stability", "Follow the flat and the inverted branch of a dome."),
            "convergence": ("convergence:convergence", "Compute the mesh dependence of a press."),
            "profile": ("profile:profile", "Find the skin that follows a drawn meridian (table, DXF, STEP)."),
            "bound": ("limit:limit", "Compute lower bounds on the error of any estimator of a design."),
            "make": ("make:make", "Write mold, print pattern, enclosure and instructions."),
            "specimens": ("specimens:specimens", "Write molds of test specimens."),
            "export": ("export:export", "Write a sensor as an asset of MuJoCo, URDF or USD."),
            "deck": ("deck:deck", "Write the input file of a press for Abaqus or CalculiX."),
        },
    ),
    "study": (
        "Run studies and show their results.",
        {
            "run": _VERBS["run"],
            "status": ("status:status", "Show the progress of a study."),
            "store": ("store:app", "Verify or clean the artefacts of a result folder."),
            "show": ("grid:show", "Show the designs of a result folder, filtered and sorted."),
            "plot": ("grid:plot", "Draw one metric of a result folder as PNG and SVG."),
            "compare": ("grid:compare", "Compare the designs of two result folders."),
            "export": ("grid:export", "Write the table of a result folder as CSV, Parquet or Markdown."),
            "model": ("grid:model", "Write the estimator of the best design as one ONNX file."),
        },
    ),
    "material": (
        "Fit materials to test files, and show the library.",
        {
            "list": ("material:list_library", "List the materials of the library."),
            "show": ("material:show", "Show one material and its validity."),
            "fit": ("fit:fit", "Fit a material to test files."),
        },
    ),
    "calibration": (
        "Calibrate a camera and a built unit, and predict the accuracy of built units.",
        {
            "camera": ("calibrate:calibrate", "Calibrate the lens of a camera from images of a board."),
            "inspect": ("inspect:inspect", "Measure the print errors of a unit in its rest image."),
            "identify": ("identify:identify", "Identify a built unit from calibration presses."),
            "predict": ("twin:twin", "Build the twins of designs and predict the accuracy of built units."),
            "accept": ("accept:accept", "Test whether a built unit is within its tolerances."),
        },
    ),
    "sensor": (
        "Read poses from the images of a built sensor.",
        {
            "live": ("sensor:live", "Read poses from the images of a sensor."),
            "serve": ("serve:serve", "Send the readings of a sensor to other programs by WebSocket."),
            "detect": ("sensor:find", "Detect the markers in images."),
            "check": ("check_sensor:check", "Check whether the camera of a sensor is set up to measure."),
        },
    ),
    "recording": (
        "Take recordings, and train estimators on those of any sensor with markers.",
        {
            "take": ("take:take", "Take a recording of presses by a robot, manually or simulated."),
            "train": ("learn:learn", "Train estimators on a recording with poses."),
        },
    ),
    "simulation": (
        "Simulate built units and robots.",
        {
            "bench": ("bench:bench", "Simulate built units that deviate from a design, from image to pose."),
            "align": ("align:align", "Align a tool normal to walls on a simulated robot."),
        },
    ),
}
"""Group → help and verbs."""
OLD_VERBS = {
    "status": "study status",
    "store check": "study store check",
    "store gc": "study store gc",
    "deck": "design deck",
    "stability": "design stability",
    "convergence": "design convergence",
    "design": "design show",
    "fit": "material fit",
    "limit": "design bound",
    "grid show": "study show",
    "grid plot": "study plot",
    "grid compare": "study compare",
    "grid export": "study export",
    "grid model": "study model",
    "twin": "calibration predict",
    "optimise": "search",
    "serve": "sensor serve",
    "make": "design make",
    "export": "design export",
    "specimens": "design specimens",
    "calibrate": "calibration camera",
    "find": "sensor detect",
    "live": "sensor live",
    "inspect": "calibration inspect",
    "identify": "calibration identify",
    "learn": "recording train",
    "bench": "simulation bench",
    "align": "simulation align",
    "accept": "calibration accept",
}
"""Verbs of version 0.2 → verbs; the old ones are accepted for one version."""


def _without_package(name: str, package: str) -> Callable[..., None]:
    def refuse(*words: Annotated[str, Parameter(show=False, allow_leading_hyphen=True)]) -> None:
        raise PalpateError(
            f"palpate {name} is a command of the package {package}, which is not installed.",
            f"Install it from a checkout of palpate: pip install -e plugins/{package}",
            code="package-missing",
        )

    return refuse


def _add_verbs(part: App, verbs: Mapping[str, tuple[str, str]], group: str = "") -> None:
    for name, (place, help_text) in verbs.items():
        cost = cost_sentence(f"{group} {name}".strip()) or cost_sentence(name)
        epilogue = {"help_epilogue": cost} if cost else {}
        part.command(f"palpate.cli.{place}", name=name, help=help_text, **epilogue)


app = App(
    name="palpate",
    version=__version__,
    help="Design, simulate, build and read vision-based tactile sensors.",
    version_flags=["--version"],
    help_format="plaintext",  # Markdown costs 0.04 CPU-s
    suppress_keyboard_interrupt=False,  # `guarded` answers it
)
_add_verbs(app, _VERBS)
for _name, (_package, _place, _help) in _PLUGINS.items():
    _found = find_spec(_package) is not None
    app.command(f"{_package}.{_place}" if _found else _without_package(_name, _package), name=_name, help=_help)
for _name, (_help, _verbs) in _GROUPS.items():
    _group = App(name=_name, help=_help)
    _add_verbs(_group, _verbs, _name)
    app.command(_group)


def current_words(words: list[str]) -> list[str]:
    """Return words with the current verb in the place of an old one, which is named on standard error."""
    for count in (2, 1):
        old = " ".join(words[:count])
        inside = old in _GROUPS and words[1:2] in ([], ["--help"], ["-h"], *([verb] for verb in _GROUPS[old][1]))
        if old in OLD_VERBS and not inside:
            print(f"palpate {old} is palpate {OLD_VERBS[old]} now; the old name ends with 0.4.", file=sys.stderr)
            return [*OLD_VERBS[old].split(), *words[count:]]
    return words


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and leave with its exit code.

    Parameters
    ----------
    arguments
        Words after `palpate`; without them, those of the process.
    """
    words = current_words(list(sys.argv[1:] if arguments is None else arguments))
    sys.exit(guarded(lambda: _call(words)))


def _call(words: list[str]) -> Any:
    command, bound, _ = app.parse_args(words, exit_on_error=False, print_error=False)[:3]
    if "--json" in words:
        from palpate.cli.output import keep_inputs

        bound.apply_defaults()
        keep_inputs(["palpate", *words], bound.arguments)
    return command(*bound.args, **bound.kwargs)
