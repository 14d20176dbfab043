"""One study file in, a grid out; interrupted in every way and run again."""

import csv
import json
import os
import signal
import sqlite3
import subprocess
import time
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path

import pytest
from command_line import finish, start

from needs import needs
from palpate.cli import main
from palpate.learn import open_predictor
from presses import run_tiny_study

Ask = Callable[[Sequence[str | Path]], "subprocess.CompletedProcess[str]"]
COLUMNS = {
    "height_mm",
    "thickness_mm",
    "markers",
    "rmse_deg",
    "max_error_deg",
    "rmse_jitter_deg",
    "max_error_jitter_deg",
    "travel_mm",
    "peak_stress_mpa",
    "force_n",
    "presses",
    "samples",
    "seed",
    "bound_deg",
    "rmse_over_bound",
    "rmse_spread_deg",
}


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return run_tiny_study(tmp_path_factory.mktemp("finished"))


@pytest.fixture
def ask(capsys: pytest.CaptureFixture[str]) -> Ask:
    """The command line in this process: for what does not depend on how it is started, or how it ends."""

    def answer(words: Sequence[str | Path]) -> subprocess.CompletedProcess[str]:
        capsys.readouterr()
        with pytest.raises(SystemExit) as left:
            main(list(map(str, words)))
        shown = capsys.readouterr()
        code = left.value.code
        return subprocess.CompletedProcess(words, code if isinstance(code, int) else 0, shown.out, shown.err)

    return answer


def artefacts(out: Path) -> dict[str, float]:
    """Artefacts of a result folder by the time they were written."""
    return {path.name: path.stat().st_mtime for path in (out / "store").rglob("*.manifest.json")}


def numbers(out: Path) -> list[dict[str, str]]:
    with (out / "grid.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def wait_for(out: Path, count: int) -> None:
    """Wait until a running study has `count` artefacts."""
    limit = time.monotonic() + 120
    while len(artefacts(out)) < count:
        assert time.monotonic() < limit, "no artefact came"
        time.sleep(0.05)


def spawned_by(parent: int) -> list[int]:
    """Processes that `parent` has spawned to work, oldest first."""
    return sorted(
        int(process.name)
        for process in Path("/proc").glob("[0-9]*")
        if b"spawn_main" in (process / "cmdline").read_bytes()
        and int((process / "stat").read_text().rpartition(")")[2].split()[1]) == parent
    )


def test_a_study_leaves_table_and_pictures(finished: Path) -> None:
    rows = numbers(finished)
    assert [row["markers"] for row in rows] == ["7", "19"]
    assert set(rows[0]) >= COLUMNS
    assert all(float(row[name]) >= 0 for row in rows for name in COLUMNS)
    assert json.loads((finished / "grid.json").read_text())
    assert list(finished.glob("*.png"))
    assert list(finished.glob("*.svg"))
    with closing(sqlite3.connect(finished / "grid.sqlite")) as database:
        assert database.execute("SELECT markers FROM design ORDER BY design").fetchall() == [(7,), (19,)]
        presses = database.execute("SELECT count(DISTINCT value) FROM provenance WHERE kind = 'press_key'").fetchone()
    assert presses == (3,)


def test_limits_need_no_training_and_are_those_of_the_grid(tiny_study: Path, finished: Path, ask: Ask) -> None:
    before = artefacts(finished)
    done = ask(["limit", tiny_study, "--out", finished, "--json"])
    assert done.returncode == 0, done.stderr
    computed = json.loads(done.stdout)["designs"]
    assert artefacts(finished) == before
    read = json.loads(ask(["limit", finished, "--json"]).stdout)["designs"]
    for one, other in zip(computed, read, strict=True):
        assert one["bound_deg"] == pytest.approx(other["bound_deg"], rel=1e-6)
        assert [part["floor_deg"] for part in one["by_depth"]] == [part["floor_deg"] for part in other["by_depth"]]
        assert [round(part["depth_mm"], 9) for part in one["by_depth"]] == [2.4, 3.2, 4.0]


def test_the_model_of_a_study_predicts_by_itself(finished: Path) -> None:
    models = sorted((finished / "store" / "estimator").rglob("*.onnx"))
    opened = sorted((open_predictor(path) for path in models), key=lambda predictor: predictor.markers)
    assert [(predictor.markers, predictor.level) for predictor in opened] == [(7, 0.9), (19, 0.9)]


def test_the_model_of_the_best_design_is_taken_out(finished: Path, tmp_path: Path, ask: Ask) -> None:
    output = ask(["study", "model", finished, "--out", tmp_path / "best.onnx"])
    assert output.returncode == 0, output.stderr
    best = min(numbers(finished), key=lambda row: float(row["rmse_jitter_deg"]))
    assert f"{best['markers']} markers" in output.stdout
    assert open_predictor(tmp_path / "best.onnx").markers == int(best["markers"])


def test_the_grid_is_drawn_exported_and_compared(finished: Path, tmp_path: Path, ask: Ask) -> None:
    done = ask(["study", "plot", finished, "--kind", "depth", "--metric", "bound_deg", "-o", tmp_path, "--json"])
    assert [Path(name).name for name in json.loads(done.stdout)["files"]] == [
        "bound_by_depth.png",
        "bound_by_depth.svg",
    ]
    assert ask(["study", "export", finished, "--to", tmp_path / "grid.md", "--where", "markers < 10"]).returncode == 0
    assert len((tmp_path / "grid.md").read_text().splitlines()) == 3
    shown = json.loads(ask(["study", "compare", finished, finished, "--json"]).stdout)
    assert [row["rmse_deg_ratio"] for row in shown["designs"]] == [1.0, 1.0]
    assert shown["differences"] == []


def test_a_second_run_makes_nothing_and_gives_the_same_grid(tiny_study: Path, finished: Path) -> None:
    before, rows = artefacts(finished), numbers(finished)
    started = time.monotonic()
    done = finish(["run", tiny_study, "--out", finished, "--json"])
    assert done.returncode == 0, done.stderr
    assert time.monotonic() - started < 15
    shown = json.loads(done.stdout)
    assert shown["computed"] == {}
    made = {"press": 3, "inverted": 1, "dataset": 2, "limit": 2, "estimator": 2, "learning": 2}
    assert shown["reused"] == made
    assert artefacts(finished) == before
    assert numbers(finished) == rows


@pytest.mark.slow
def test_killed_in_the_middle_it_goes_on_where_it_was(tiny_study: Path, finished: Path, tmp_path: Path) -> None:
    process = start(["run", tiny_study, "--out", tmp_path, "--workers", "4"])
    wait_for(tmp_path, 1)
    process.kill()
    process.communicate()
    time.sleep(3)  # its workers look for their parent once a second
    kept = artefacts(tmp_path)
    assert 1 <= len(kept) < 11
    done = finish(["run", tiny_study, "--out", tmp_path, "--workers", "3", "--json"])
    assert done.returncode == 0, done.stderr
    assert sum(json.loads(done.stdout)["reused"].values()) == len(kept)
    assert kept.items() <= artefacts(tmp_path).items()
    assert numbers(tmp_path) == numbers(finished)


@pytest.mark.slow
def test_one_worker_makes_the_grid_of_two(tiny_study: Path, finished: Path, tmp_path: Path) -> None:
    done = finish(["run", tiny_study, "--out", tmp_path, "--workers", "1", "--json"])
    assert done.returncode == 0, done.stderr
    assert sum(json.loads(done.stdout)["computed"].values()) == 12
    assert numbers(tmp_path) == numbers(finished)
    assert_all_is_made(tiny_study, tmp_path)


def assert_all_is_made(study: Path, folder: Path) -> None:
    output = json.loads(finish(["status", study, "--out", folder, "--json"]).stdout)
    assert (output["made"], output["of"], output["remaining_s"]) == (12, 12, 0)


@pytest.mark.slow
def test_a_dask_worker_killed_in_the_middle_costs_nothing_but_time(
    tiny_study: Path, finished: Path, tmp_path: Path
) -> None:
    needs("distributed")
    process = start(["run", tiny_study, "--out", tmp_path, "--cluster", "local:3", "--json"])
    wait_for(tmp_path, 2)
    workers = spawned_by(process.pid)
    assert len(workers) == 3
    os.kill(workers[1], signal.SIGKILL)
    out, err = process.communicate(timeout=300)
    assert process.returncode == 0, err
    output = json.loads(out)
    assert sum(output["computed"].values()) in (11, 12)  # the killed one may just have put its artefact away
    assert len(artefacts(tmp_path)) == 12
    assert numbers(tmp_path) == numbers(finished)
    assert_all_is_made(tiny_study, tmp_path)


def test_a_bit_flipped_in_a_finished_artefact_is_found_and_mended(tiny_study: Path, finished: Path, ask: Ask) -> None:
    rows = numbers(finished)
    limit = next((finished / "store" / "limit").rglob("*[0-9a-f].json"))
    content = limit.read_bytes()
    limit.write_bytes(content[:-3] + bytes([content[-3] ^ 1]) + content[-2:])
    done = ask(["run", tiny_study, "--out", finished, "--json"])
    assert json.loads(done.stdout)["computed"] == {"limit": 1}, done.stderr
    assert limit.read_bytes() == content
    assert numbers(finished) == rows
    reason = limit.with_name(limit.name + ".broken.reason").read_text()
    assert reason.strip()
    assert json.loads(ask(["study", "store", "check", finished, "--json"]).stdout)["broken"] == []


def test_interrupted_it_says_how_to_go_on(tiny_study: Path, tmp_path: Path) -> None:
    process = start(["run", tiny_study, "--out", tmp_path, "--workers", "2"])
    wait_for(tmp_path, 1)
    os.killpg(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=20)
    assert process.returncode == 130
    assert out == ""
    assert len(err.strip().splitlines()) >= 1
    assert "Traceback" not in err


def test_a_broken_artefact_is_made_again(tiny_study: Path, finished: Path, ask: Ask) -> None:
    rows = numbers(finished)
    press = next((finished / "store" / "press").rglob("*.h5"))
    press.write_bytes(press.read_bytes()[:-100])
    done = ask(["run", tiny_study, "--out", finished, "--json"])
    assert json.loads(done.stdout)["computed"] == {"press": 1}
    assert press.with_name(press.name + ".broken").exists()
    assert numbers(finished) == rows


def test_the_grid_can_be_asked(finished: Path, ask: Ask) -> None:
    done = ask(["study", "show", finished, "--where", "markers >= 10", "--sort", "-rmse_deg", "--json"])
    assert done.returncode == 0, done.stderr
    assert [row["markers"] for row in json.loads(done.stdout)["rows"]] == [19]


def test_a_finished_study_is_held_against_the_papers_claims(finished: Path, tmp_path: Path, ask: Ask) -> None:
    done = ask(["claims", finished, "--out", tmp_path / "claims.md", "--json"])
    assert done.returncode == 0, done.stderr
    answers = {answer["claim"]: answer for answer in json.loads(done.stdout)["rows"]}
    assert len(answers) == 13
    assert answers["C1"]["verdict"] == "holds"
    assert {answers[name]["verdict"] for name in ("C3", "C6", "C9", "C10")} == {"not decided"}
    assert answers["C10"]["why"].startswith("needs H10 T1, T2, T3, T4; H20 T1")
    assert f"palpate claims {finished}" in (tmp_path / "claims.md").read_text()


@pytest.mark.parametrize(
    "words",
    [["--where", "markers >"], ["--where", "colour == 3"], ["--sort", "colour"], ["--where", "__import__('os')"]],
)
def test_a_bad_question_is_bad_input(finished: Path, words: list[str], ask: Ask) -> None:
    done = ask(["study", "show", finished, *words])
    assert done.returncode == 2
    assert done.stdout == ""
    assert "Traceback" not in done.stderr


@pytest.mark.slow
def test_a_failed_task_is_reported_and_the_rest_goes_on(tiny_study: Path, tmp_path: Path) -> None:
    study = tmp_path / "narrow.yaml"
    camera = "camera: {fx_px: 900, fy_px: 900}\n"  # sees the inner dots only
    study.write_text(tiny_study.read_text() + camera)
    done = finish(["run", study, "--out", tmp_path / "out", "--json"])
    assert done.returncode == 1
    shown = json.loads(done.stdout)
    assert shown["computed"]["press"] == 3
    assert {failure["task"] for failure in shown["failures"]} >= {"learning H20 T2 19 markers"}
    assert "Traceback" not in done.stderr
