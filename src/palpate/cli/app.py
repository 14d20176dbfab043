"""The command `palpate`: its subcommands, loaded only when called, and its exit codes.

0 done · 1 a fault of the program, with a log · 2 bad input, with a remedy · 130 interrupted
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Any, cast

import docstring_parser
from cyclopts import App

from palpate import __version__
from palpate.cli.border import guarded

_parse = docstring_parser.parse_from_object


def _parse_functions(described: Any) -> docstring_parser.Docstring:
    """Parse docstrings of functions only; each field of a class has a help of its own."""
    return docstring_parser.parse("") if isinstance(described, type) else _parse(described)


cast(Any, docstring_parser).parse_from_object = _parse_functions  # cyclopts looks it up at each call

app = App(
    name="palpate",
    version=__version__,
    help="From an idea to a trusted vision-based tactile sensor: design, press, camera, learning, grid.",
    version_flags=["--version"],
    suppress_keyboard_interrupt=False,  # `guarded` answers it
)
app.command("palpate.cli.run:run", name="run", help="Run a study: every design through the whole chain.")
app.command("palpate.cli.status:status", name="status", help="How far a study is.")
app.command("palpate.cli.store:app", name="store", help="Verify or clean the artefacts of a result folder.")
app.command("palpate.cli.press:press", name="press", help="Press one dome by a flat wall.")
app.command("palpate.cli.deck:deck", name="deck", help="Write the input file of a press for Abaqus or CalculiX.")
app.command("palpate.cli.stability:stability", name="stability", help="Where a dome has two stable states.")
app.command("palpate.cli.convergence:convergence", name="convergence", help="How much a press depends on its mesh.")
app.command("palpate.cli.design:design", name="design", help="Radius, shape, markers and limits of a design.")
app.command("palpate.cli.fit:fit", name="fit", help="Fit a material to the files of a test bench.")
app.command("palpate.cli.material:app", name="material", help="Look at the library of materials.")
app.command("palpate.cli.limit:limit", name="limit", help="How good any estimator of a design could be.")
app.command("palpate.cli.grid:app", name="grid", help="Look at a specification grid.")
app.command("palpate.cli.twin:twin", name="twin", help="Twins of designs, and how good built units will be.")
app.command("palpate.cli.optimise:optimise", name="optimise", help="Requirements in, the best design out.")
app.command("palpate.cli.view:view", name="view", help="Look at results in a browser, design and press a dome.")
app.command("palpate.cli.serve:serve", name="serve", help="Readings of a sensor for other programs, by websocket.")
app.command("palpate.cli.claims:claims", name="claims", help="Hold finished studies against the paper's claims.")
app.command("palpate.cli.make:make", name="make", help="Write mold, print pattern, enclosure and instructions.")
app.command("palpate.cli.export:export", name="export", help="A sensor as an asset of MuJoCo, URDF or USD.")
app.command("palpate.cli.specimens:specimens", name="specimens", help="Write molds of test specimens.")
app.command("palpate.cli.calibrate:calibrate", name="calibrate", help="The lens of a camera from images of a board.")
app.command("palpate.cli.sensor:find", name="find", help="Find the dots in a folder of images.")
app.command("palpate.cli.sensor:live", name="live", help="From images of a sensor to the pose of the wall.")
app.command("palpate.cli.inspect:inspect", name="inspect", help="Print errors of a built dome from its rest image.")
app.command("palpate.cli.identify:identify", name="identify", help="What a built unit is, from known presses.")
app.command("palpate.cli.learn:learn", name="learn", help="Learn to read a sensor from a recording with poses.")
app.command("palpate.cli.bench:bench", name="bench", help="Built units that deviate, played from image to pose.")
app.command("palpate.cli.benchmark:app", name="benchmark", help="An open set, its judge, its baselines.")
app.command("palpate.cli.align:align", name="align", help="Square a tool to walls on a simulated robot.")
app.command("palpate.cli.accept:accept", name="accept", help="Whether a built unit is within its tolerances.")
app.command("palpate.cli.verify:verify", name="verify", help="Solve problems with known answers and compare.")
app.command("palpate.cli.doctor:doctor", name="doctor", help="Say what is installed and what is missing.")


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and leave with its exit code.

    Parameters
    ----------
    arguments
        Words after `palpate`; without them, those of the process.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    sys.exit(guarded(lambda: app(words, exit_on_error=False, print_error=False, result_action="return_value")))
