"""The one file that tests messages: every error of the source has a code, one problem, one remedy and a value."""

from __future__ import annotations

import ast
import re
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from errors import check_refusal
from needs import needs
from palpate.camera import read_image
from palpate.cli import main
from palpate.cli.border import BAD_INPUT, guarded
from palpate.core import load_extra
from palpate.material import Relaxation, relax_history
from palpate.sensor import ReferencePress

ROOT = Path(__file__).parents[3]
SOURCE = ROOT / "src" / "palpate"
FILES = sorted([*SOURCE.rglob("*.py"), *ROOT.glob("plugins/palpate_*/palpate_*/**/*.py")])
ERRORS = ("PalpateError", "MissingExtraError", "StoreError", "LeakageError", "MissingArtefactError")
OF_THE_CLASS = {"MissingExtraError": "extra-missing", "MissingArtefactError": "artefact-missing"}
"""Classes whose code, remedy and sentence are their own."""
HANDED_ON = {"code", "error.code", "finding.code", "doubts[0].code", "first['type']", "errors[0]['type']"}
"""Codes that a caller gives, of an error that is told anew, of a finding, and of the first fault of a spec."""
KEBAB = re.compile(r"[a-z0-9]+(-[a-z0-9]+)+")
FIELD = "\0"
"""A value in a message."""


@dataclass(frozen=True)
class Message:
    """One construction of an error."""

    place: str
    kind: str
    codes: tuple[str, ...]
    problem: str
    remedy: str


def text_of(node: ast.expr | None, module: ast.Module) -> str:
    """The words of a message, its values as `FIELD`."""
    if node is None:
        return ""
    if isinstance(node, ast.Constant):
        return str(node.value)
    if isinstance(node, ast.JoinedStr):
        return "".join(text_of(part, module) for part in node.values)
    if isinstance(node, ast.BinOp):
        return text_of(node.left, module) + text_of(node.right, module)
    if isinstance(node, ast.IfExp):
        return f"{text_of(node.body, module)}{text_of(node.orelse, module)}"
    if isinstance(node, ast.Name):
        for line in module.body:
            if isinstance(line, ast.Assign) and any(
                isinstance(name, ast.Name) and name.id == node.id for name in line.targets
            ):
                return text_of(line.value, module)
    return FIELD


def codes_of(call: ast.Call, kind: str) -> tuple[str, ...]:
    given = next((word.value for word in call.keywords if word.arg == "code"), None)
    if given is None:
        return (OF_THE_CLASS.get(kind, ""),)
    if isinstance(given, ast.IfExp):
        return tuple(ast.literal_eval(each) for each in (given.body, given.orelse))
    return (str(given.value) if isinstance(given, ast.Constant) else ast.unparse(given),)


@cache
def messages() -> tuple[Message, ...]:
    return tuple(found for path in FILES for found in messages_of(path))


def messages_of(path: Path) -> Iterator[Message]:
    text = path.read_text("utf-8")
    module = ast.parse(text if any(f"{name}(" in text for name in ERRORS) else "")
    for node in ast.walk(module):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in ERRORS:
            kind, place = node.func.id, f"{path.relative_to(ROOT)}:{node.lineno}"
            what, *more = (text_of(each, module) for each in node.args)
            if kind in OF_THE_CLASS or kind == "LeakageError":
                more = [FIELD]
            if kind == "MissingExtraError":
                what = f"{FIELD}."
            yield Message(place, kind, codes_of(node, kind), what, more[0] if more else "")


def listed(text: str) -> Counter[str]:
    """Codes and how many of their messages are excepted: ``code`` or ``code*2``."""
    pairs = [word.partition("*") for word in text.split()]
    return Counter({code: int(count or 1) for code, _, count in pairs})


HANDS_A_SENTENCE_ON = listed(
    """
    calibration-few-images columns-none doubts[0].code error.code*2 errors[0]['type'] evaluation-leaks
    finding.code*2 images-unreadable*2 inverted-state-missing path-ended*2 press-missing solver-no-increment
    source-gone twin-not-made*2 unit-not-simulated units-not-drawn
    """
)
"""Messages that end in the sentence of something else, which has its own period."""
WITHOUT_REMEDY = listed(
    """
    dataset-column-lengths errors[0]['type'] estimates-shape model-outputs-missing unit-not-simulated video-cut-off
    video-empty
    """
)
"""Messages without a remedy of their own: reasons in a table, and what hands the remedy of something else on."""
WITHOUT_VALUE = listed(
    """
    argument-missing*3 azimuths-need-flat-wall benchmark-no-pictures calibration-press-missing
    calibration-press-no-touch cuda-missing dataset-no-forces dataset-not-finite deck-filled-shell
    deck-shell-stiff deck-wall-bent evaluation-no-image fit-no-samples*2 fit-stress-falls
    force-not-positive forces-need-wall grid-empty grid-missing grid-selection-empty image-damaged
    image-mirrored image-not-encoded image-not-finite inverted-state-gel
    inverted-state-route law-exponent-zero law-term-incomplete limit-obstacle-level
    markers-outside-skin mesh-half-needed model-missing*2 model-no-design network-no-force*2
    network-no-unit*3 notebook-missing obstacle-misses-skin option-not-for-solver
    options-exclusive*2 outline-begins-with-curve outline-leaves-axis-aslant picture-missing press-curve-missing
    press-pose-incomplete presses-designs-differ presses-none*3 presses-obstacles-differ presses-share-no-depth
    question-operator-unknown recording-markers-unassigned relaxation-not-falling relaxation-without-law
    results-missing rest-image-missing rest-markers-on-line*2 rim-touched-first rings-not-printable source-no-image
    template-not-for-pins tracker-no-marker twin-needs-flat-wall video-empty wall-bent-no-facets
    """
)
"""Messages whose problem names no value: there is none to name."""


def over(found: list[Message], allowed: Counter[str]) -> dict[str, int]:
    """What breaks a rule more often than is listed; and what is listed more often than it breaks it, below zero."""
    counts = Counter("|".join(message.codes) for message in found)
    return {code: counts[code] - allowed[code] for code in counts | allowed if counts[code] != allowed[code]}


def test_every_error_has_a_code() -> None:
    assert len(messages()) > 500
    wrong = [(each.place, code) for each in messages() for code in each.codes if not KEBAB.fullmatch(code)]
    assert [item for item in wrong if item[1] not in HANDED_ON] == []


def test_a_code_belongs_to_one_class_of_errors() -> None:
    kinds: defaultdict[str, set[str]] = defaultdict(set)
    for each in messages():
        for code in each.codes:
            kinds[code].add(each.kind)
    assert {code: names for code, names in kinds.items() if len(names) > 1 and code not in HANDED_ON} == {}


def test_the_types_of_a_spec_s_faults_are_written_as_codes() -> None:
    assert {code for code in spec_codes() if not KEBAB.fullmatch(code)} == set()


def test_every_code_that_a_test_names_is_in_use() -> None:
    """Those of pydantic itself are written with underscores, and ``usage`` is the command line's own."""
    tests = sorted((ROOT / "tests").rglob("*.py"))
    known = {code for each in messages() for code in each.codes} | spec_codes() | {"usage", "enum", "missing"}
    known |= {code for path in (*FILES, *tests) for code in written_codes(path)}
    named = {code for path in tests for code in named_codes(path)}
    assert {code for code in named if code not in known and "_" not in code} == set()


def test_every_problem_is_a_sentence() -> None:
    """Exceptions are listed, and their number may only fall."""
    open_ended = [each for each in messages() if not each.problem.endswith(".")]
    assert over(open_ended, HANDS_A_SENTENCE_ON) == {}
    assert HANDS_A_SENTENCE_ON.total() <= 21


def test_every_error_has_a_remedy() -> None:
    """Exceptions are listed, and their number may only fall."""
    assert over([each for each in messages() if not each.remedy], WITHOUT_REMEDY) == {}
    assert WITHOUT_REMEDY.total() <= 7


def test_every_problem_names_a_value() -> None:
    """Exceptions are listed, and their number may only fall."""
    assert over([each for each in messages() if FIELD not in each.problem], WITHOUT_VALUE) == {}
    assert WITHOUT_VALUE.total() <= 80


REMEDIES_BEGIN = listed(
    """
    Give Choose Use Write Check Make Record Leave Name Run Correct Take Start Export Change Save Train Draw Set Solve
    Reduce Open Add Connect Lower Fill Install Put Repair Number Begin Move Refine Reinstall Calibrate Create Mesh
    Request Hold Ask Call Look Keep Predict Copy See Uninstall Separate Increase Sample Paint Report Fit Tilt Measure
    Generate Widen Average Supported Known Flip Let Assign pip
    """
)


def test_no_problem_begins_as_a_remedy_does() -> None:
    """Else the two have changed places."""
    assert [each.place for each in messages() if each.problem.split(" ")[0] in REMEDIES_BEGIN] == []


@cache
def spec_codes() -> set[str]:
    """Types of the faults that specs find themselves."""
    calls = (
        node
        for path in FILES
        if "PydanticCustomError" in (text := path.read_text("utf-8"))
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    )
    found = set()
    for call in calls:
        names = {"PydanticCustomError": 0, "_refuse": 1}
        at = names.get(call.func.id, -1) if isinstance(call.func, ast.Name) else -1
        if 0 <= at < len(call.args) and isinstance(call.args[at], ast.Constant):
            found.add(str(ast.literal_eval(call.args[at])))
    return found


def written_codes(path: Path) -> set[str]:
    """Codes that are handed on as a keyword, and those of findings."""
    text = path.read_text("utf-8")
    return {*re.findall(r'\bcode="([^"]+)"', text), *re.findall(r'\bFinding\(\s*[\w.]+,\s*"([^"]+)"', text)}


def named_codes(path: Path) -> set[str]:
    """Codes in the calls of `refused` and `check_refusal` of a file of tests."""
    calls = re.findall(
        r"\b(?:refused\(|check_refusal\([^\n]*?,)\s*(\(.*?\)|\"[^\"]+\")", path.read_text("utf-8"), re.DOTALL
    )
    return {code for call in calls for code in re.findall(r'"([^"]+)"', call)}


def missing_extra() -> None:
    load_extra("no_such_library", "cad", "No Such")


def missing_image() -> None:
    read_image(Path("none.png"))


def negative_depth() -> None:
    ReferencePress.simulate(np.zeros((2, 2)), (0.0, 0.0, -1.0), None)  # type: ignore[arg-type]


def time_that_goes_back() -> None:
    relax_history(Relaxation((0.1,), (1.0,)), np.array([0.0, 2.0, 1.0]), np.zeros(3))


LIVE: dict[str | Callable[[], Any], tuple[object, ...]] = {
    missing_extra: ("extra-missing", "No Such", ".[cad]"),
    missing_image: ("image-unreadable", "none.png"),
    negative_depth: ("press-depth-not-positive", "-1"),
    time_that_goes_back: ("time-goes-back", 2, 1),
    "press --thickness -1": ("greater_than_equal", "--thickness", "-1"),
    "press --material cheese": ("material-unknown", "cheese"),
    "press --material neo-hooke:-1": ("shear-modulus-not-positive", "-1"),
    "press --obstacle pyramid": ("kind-unknown", "pyramid"),
    "press --points none.csv": ("file-unreadable", "none.csv"),
    "press --points points.csv": ("point-outside-skin", "points.csv", 25),
    "press --export taken": ("folder-exists", "taken"),
    "design deck -o none/press.inp": ("folder-missing", "none"),
    "design show --markers 8": ("marker-count-not-rings", 8, 7, 19),
    "design show --hight 20": ("usage", "--hight"),
    "run second": ("file-unreadable", "second"),
    "run first --workers 0": ("option-out-of-bounds", "--workers", 0),
    "study show taken": ("grid-missing", "taken", "grid.json"),
    "material fit none.csv": ("file-unreadable", "none.csv"),
    "material fit points.csv --tension points.csv": ("column-missing", "points.csv", "--strain"),
    "sensor detect taken": ("folder-no-image", "taken"),
    "calibration camera taken --board chess": ("board-unknown", "chess"),
    "verify --only doom": ("case-unknown", "doom"),
    "material show yeoh:1": ("law-constant-count", "yeoh", 1),
}
"""What a person or a program asks for, and the code and values of the answer."""
OF_IMAGES = (missing_image, "sensor detect taken", "calibration camera taken --board chess")
"""Those that need OpenCV."""


@pytest.mark.parametrize("asked", LIVE, ids=lambda asked: asked if isinstance(asked, str) else asked.__name__)
def test_an_answer_is_one_problem_one_remedy_and_the_code(
    asked: str | Callable[[], Any],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    if asked in OF_IMAGES:
        needs("cv2")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "points.csv").write_text("x_mm,y_mm\n0,0\n25,0\n")
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken" / "mine.txt").write_text("mine")
    if callable(asked):
        assert guarded(asked) == BAD_INPUT
    else:
        with pytest.raises(SystemExit) as left:
            main(asked.split())
        assert left.value.code == BAD_INPUT
    shown = capsys.readouterr()
    assert shown.out == ""
    problem, remedy = shown.err.rstrip("\n").split("\n")
    code, *values = LIVE[asked]
    assert re.fullmatch(rf"Error: \S.*[.?] \[{code}\]", problem)
    assert re.fullmatch(r"\S.*\S", remedy)
    check_refusal(shown.err, str(code), *values)
