import csv
import json
import os
import shlex
import signal
import time
import weakref
from collections.abc import Callable
from pathlib import Path

import pytest
from command_table import list_commands

import palpate
from errors import check_refusal, check_values
from palpate.cli import main
from palpate.cli.app import OLD_VERBS, app, current_words
from palpate.cli.border import guarded
from palpate.study import StudyResult
from results import FIRST, leave_out_pictures


def call(*words: str) -> int:
    with pytest.raises(SystemExit) as left:
        main(words)
    assert isinstance(left.value.code, int)
    return left.value.code


def test_design_gives_radius_shape_markers_and_findings(capsys: pytest.CaptureFixture[str]) -> None:
    assert call("design", "show", "--height", "30", "--thickness", "2", "--markers", "37", "--json") == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown["radius_mm"] == pytest.approx(65 / 3)
    assert shown["shape"] == "spherical cap"
    assert shown["markers"] == len(shown["positions_mm"]) == 37
    assert [finding["code"] for finding in shown["findings"]] == ["undercut"]


def test_json_of_rows_has_the_inputs_with_their_defaults(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["design", "convergence", "--meshes", "4", "5", "--depth", "1", "--step", "1", "--json"]
    assert call(*words) == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown["inputs"]["command"] == " ".join(["palpate", *words])
    assert shown["inputs"]["meshes"] == [4, 5]
    assert shown["inputs"]["flags"]["wall"]["depth"] == 1.0
    assert shown["inputs"]["flags"]["material"]
    assert [row["cells"] for row in shown["rows"]] == [4, 5]


def test_design_takes_rings(capsys: pytest.CaptureFixture[str]) -> None:
    assert call("design", "show", "--rings", "10", "25", "45", "--json") == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown["markers"] == 37
    assert shown["positions_mm"][-1][2] is None
    assert shown["findings"][0]["code"] == "ring-outside-dome"


def test_design_prints_for_people(capsys: pytest.CaptureFixture[str]) -> None:
    assert call("design", "show", "--markers", "7") == 0
    shown = capsys.readouterr().out
    check_values(shown, "hemisphere", "20 mm")
    assert "17.861" in shown


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("design", "--height", "70"), ("less_than_equal", "--height", 60, 70)),
        (("design", "--height", "tall"), ("float_parsing", "--height", "tall")),
        (("design", "--markers", "8"), ("marker-count-not-rings", 8, 7, 19)),
        (("design", "--heigth", "3"), ("usage", "--heigth", "--height")),
        (("design", "--layout", "nowhere.csv"), ("file-unreadable", "nowhere.csv")),
        (("dezign",), ("usage", "dezign")),
        (("press", "--tilt", "50"), ("less_than_equal", "--tilt", 30, 50)),
        (("press", "--contact", "-0.5"), ("friction-out-of-bounds", "--contact", "-0.5", "10")),
        (("press", "--contact", "sticky"), ("contact-unknown", "--contact", "sticky")),
        (("press", "--material", "cheese"), ("material-unknown", "--material", "cheese", "palpate material list")),
        (("press", "--material", "yeoh:1,2"), ("law-constant-count", "yeoh", "C10,C20,C30")),
        (("press", "--bulk-ratio", "1"), ("greater_than_equal", "--bulk-ratio")),
        (("press", "--rim", "round"), ("enum", "--rim", "round")),
        (("press", "--points", "nowhere.csv"), ("file-unreadable", "nowhere.csv")),
        (("study", "status", "."), ("study-is-folder", ".", "--out", "palpate study show")),
        (("sensor", "live", "--source", "nowhere.mp4"), ("file-missing", "nowhere.mp4")),
        (("sensor", "serve", "--source", "nowhere.mp4"), ("file-missing", "nowhere.mp4")),
        (("run", "second"), ("file-unreadable", "second", "first, flat_pad")),
        (("run", "first", "--workers", "0"), ("option-out-of-bounds", "--workers", 0)),
        (("run",), ("usage", "--study")),
        (("study", "show", "nowhere"), ("grid-missing", "nowhere")),
        (("study", "plot", "nowhere"), ("grid-missing", "nowhere")),
        (("study", "plot", "nowhere", "--kind", "pie"), ("usage", "--kind", "pie")),
        (("study", "export", "nowhere"), ("usage", "--to")),
        (("study", "compare", "nowhere", "nowhere"), ("grid-missing", "nowhere")),
        (("limit", "nowhere.yaml"), ("file-unreadable", "nowhere.yaml", "first, flat_pad")),
        (("limit", "first", "--workers", "0"), ("option-out-of-bounds", "--workers", 0)),
    ],
)
def test_bad_input_is_one_sentence_and_exit_code_2(
    words: tuple[str, ...], says: tuple[object, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    assert call(*words) == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    check_refusal(shown.err, *says)
    assert "Traceback" not in shown.err
    assert len(shown.err.splitlines()) <= 12


def test_the_table_of_a_press_names_design_material_obstacle_and_contact(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--thickness", "3", "--tilt", "2", "--contact", "0.5", "--depth", "0.4", "--step", "0.4", "--cells", "4"]
    assert call("press", *words, "--material", "neo-hooke:0.02") == 0
    check_values(capsys.readouterr().out.splitlines()[0], "H20 T3", "neo-hooke:0.02", "tilt 2°", 0.5)


def test_a_run_reports_how_many_rows_of_earlier_tables_it_replaces(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    made = [FIRST]
    monkeypatch.setattr("palpate.cli.run.announce_compilation", lambda: None)
    leave_out_pictures(monkeypatch)
    monkeypatch.setattr("palpate.study.run_study", lambda *_: StudyResult("first", tuple(made[-1]), (), {}, {}, 1.0))
    shown = []
    for designs in (FIRST, FIRST, FIRST[2:]):
        made.append(designs)
        assert call("run", "first", "--out", str(tmp_path)) == 0
        shown.append([line for line in capsys.readouterr().out.splitlines() if "earlier" in line])
    assert shown[:2] == [[], []]
    check_values(shown[2][0], tmp_path, 2, len(FIRST))


def test_a_point_outside_the_dome_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "points.csv").write_text("x_mm,y_mm\n0,0\n25,0\n")
    assert call("press", "--points", str(tmp_path / "points.csv")) == 2
    check_refusal(capsys.readouterr().err, "point-outside-skin", "points.csv", 2, "(25, 0)")


def test_an_output_that_cannot_be_written_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("mine")
    assert call("run", "first", "--out", str(tmp_path / "file")) == 2
    check_refusal(capsys.readouterr().err, "file-unwritable", tmp_path / "file", "--out")
    assert (tmp_path / "file").read_text() == "mine"


def test_an_unforeseen_error_is_one_line_with_a_log(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))

    def fail() -> None:
        raise ZeroDivisionError

    assert guarded(fail) == 1
    shown = capsys.readouterr().err
    assert "ZeroDivisionError" in shown
    assert len(shown.splitlines()) == 1
    assert "Traceback" in Path(shown.split()[-1]).read_text()


def check_it_ends(command: Callable[[], None]) -> None:
    """A command that interrupts itself ends at once, with the exit code of an interruption."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a job in the background ignores it
    start = time.monotonic()
    try:
        assert guarded(command) == 130
    finally:
        signal.signal(signal.SIGINT, before)
    assert time.monotonic() - start < 3.0


def test_an_interruption_in_a_destructor_which_would_swallow_it_still_ends_the_command() -> None:
    class Swallowing:
        def __del__(self) -> None:
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(0.1)

    def command() -> None:
        Swallowing()
        for _ in range(100):
            time.sleep(0.05)

    check_it_ends(command)


def test_an_interruption_while_numba_frees_a_type_still_ends_the_command() -> None:
    from numba.core.types import abstract

    class Type:
        pass

    def _on_type_disposal(reference: object) -> None:
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.1)

    assert _on_type_disposal.__name__ == abstract._on_type_disposal.__name__

    def command() -> None:
        freed = Type()
        kept = weakref.ref(freed, _on_type_disposal)
        del freed
        for _ in range(100):
            time.sleep(0.05)
        assert kept() is None

    check_it_ends(command)


def test_an_interruption_that_a_library_wraps_is_one() -> None:
    def command() -> None:
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as error:
            raise ValueError("serializing failed") from error

    assert guarded(command) == 130


def test_interruption_has_its_exit_code() -> None:
    def interrupt() -> None:
        raise KeyboardInterrupt

    assert guarded(interrupt) == 130


def test_doctor_names_every_package_of_every_extra_that_a_user_may_want(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert call("doctor", "--json") == 0
    named = {check["name"] for check in json.loads(capsys.readouterr().out)["checks"]}
    assert named >= {"numpy", "cyclopts", "torch", "onnx", "onnxruntime", "pyarrow", "distributed", "rosbags"}
    assert named >= {"opencv-python-headless", "nicegui", "build123d", "manifold3d", "calculix"}
    assert not named & {"pytest", "sphinx", "palpate"}


def test_doctor_writes_the_command_that_mends_as_it_must_be_typed(capsys, monkeypatch):
    wanted = ["no-such-package>=2; python_version > '3' and extra == 'learn'"]
    monkeypatch.setattr("importlib.metadata.requires", lambda name: wanted)
    assert call("doctor") == 0
    assert 'pip install -e ".[learn]"' in capsys.readouterr().out


def test_doctor_tells_of_a_package_that_does_not_load(capsys, monkeypatch, tmp_path):
    (tmp_path / "fits_no_other.py").write_text("raise AttributeError('removed in 2.0')\n")
    (tmp_path / "old-1.0.dist-info").mkdir()
    (tmp_path / "old-1.0.dist-info" / "METADATA").write_text("Name: old\nVersion: 1.0\n")
    (tmp_path / "old-1.0.dist-info" / "top_level.txt").write_text("fits_no_other\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr("importlib.metadata.requires", lambda name: ["old; extra == 'viz'"])
    assert call("doctor") == 0
    assert "removed in 2.0" not in capsys.readouterr().out
    assert call("doctor", "--load") == 0
    output = capsys.readouterr().out
    assert "removed in 2.0" in output
    assert 'pip install --upgrade -e ".[viz]"' in output


def test_doctor_names_the_system_package_of_a_library_that_is_missing(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(library: str) -> None:
        raise OSError(f"{library}: cannot open shared object file: No such file or directory")

    monkeypatch.setattr("ctypes.CDLL", refuse)
    monkeypatch.setattr("importlib.metadata.requires", lambda name: ["build123d; extra == 'cad'"])
    assert call("doctor") == 0
    assert "apt-get install libgl1" in capsys.readouterr().out


def test_doctor_names_the_solver_in_use(capsys: pytest.CaptureFixture[str]) -> None:
    assert call("doctor", "--json") == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown["healthy"]
    assert shown["solver"] in [check["name"] for check in shown["solvers"]]
    assert shown["versions"]["palpate"]


def test_help_names_units_defaults_and_bounds(capsys: pytest.CaptureFixture[str]) -> None:
    call("press", "--help")
    shown = " ".join(capsys.readouterr().out.replace("│", " ").split())
    assert "(mm; >= 2, <= 60). [default: 20.0]" in shown
    assert "(deg; >= 0, <= 30). [default: 0.0]" in shown


@pytest.mark.parametrize("old", OLD_VERBS)
def test_an_old_verb_is_the_new_one_with_a_note(old: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert current_words([*old.split(), "--json"]) == [*OLD_VERBS[old].split(), "--json"]
    check_values(capsys.readouterr().err, f"palpate {old}", f"palpate {OLD_VERBS[old]}")
    assert OLD_VERBS[old] in dict(list_commands())


def test_a_group_of_the_same_name_as_an_old_verb_is_a_group(capsys: pytest.CaptureFixture[str]) -> None:
    for words in (["design"], ["design", "--help"], ["design", "press", "--tilt", "3"], ["run", "first"]):
        assert current_words(words) == words
    assert not capsys.readouterr().err


def test_every_verb_that_ends_states_its_cost() -> None:
    with (Path(palpate.__file__).parent / "cli" / "costs.csv").open(newline="") as file:
        costs = {row["verb"]: row for row in csv.DictReader(file)}
    verbs = {verb for verb, _ in list_commands(app)}
    served = {"view", "sensor serve", "search", "claims", "benchmark make", "benchmark score", "benchmark baselines"}
    assert verbs - served == set(costs)
    for verb, row in costs.items():
        words = shlex.split(row["command"])
        assert words[: 1 + len(verb.split())] == ["palpate", *verb.split()]
        assert app.parse_args(words[1:], exit_on_error=False, print_error=False)[0]
        assert float(row["cpu_s"]) > 0


def test_the_front_lists_no_names_of_its_implementation() -> None:
    assert {"DomeSpec", "solve_press"} <= set(dir(palpate))
    assert not {"Any", "TYPE_CHECKING", "import_module"} & set(dir(palpate))
