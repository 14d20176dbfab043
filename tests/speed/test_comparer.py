"""The comparer of `.ci/speed.py`, by what was measured: five runs while other work shared the processor."""

import csv
import importlib.util
import json
import sys
from dataclasses import replace
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
spec = importlib.util.spec_from_file_location("speed", ROOT / ".ci" / "speed.py")
speed = importlib.util.module_from_spec(spec)
sys.modules["speed"] = speed
spec.loader.exec_module(speed)

LAST = speed.last_release(speed.read_history())


def measured_runs():
    runs = {}
    with (ROOT / "docs" / "results" / "speed_runs.csv").open(encoding="utf-8") as file:
        for each in csv.DictReader(file):
            counts = int(each["iterations"]), int(each["unknowns"])
            row = speed.Row(
                "now",
                "-",
                each["case"],
                float(each["ratio"]),
                *counts,
                float(each["cpu_s"]),
                LAST[each["case"]].processor,
            )
            runs.setdefault(each["run"], {})[row.case] = row
    return list(runs.values())


RUNS = measured_runs()
QUIET = RUNS[1]


def refused(now):
    return [finding.case for finding in speed.compare(LAST, now) if finding.refused]


def test_there_are_ten_cases_and_five_runs():
    assert len(LAST) == 10
    assert [set(run) for run in RUNS] == [set(LAST)] * 5


@pytest.mark.parametrize("number", range(5))
def test_the_same_code_is_accepted_whatever_else_the_processor_does(number):
    """A case that one run has too slow is measured again, as `main` does: here, by the next run."""
    run, again = RUNS[number], RUNS[(number + 1) % 5]
    slow = refused(run)
    assert len(slow) <= 1
    assert refused(speed.keep_fastest(run, {case: again[case] for case in slow})) == []


@pytest.mark.parametrize("case", sorted(LAST))
def test_a_case_that_is_slower_by_half_is_refused_in_every_run(case):
    for run in RUNS:
        slowed = run | {case: replace(run[case], ratio=1.5 * run[case].ratio)}
        assert set(refused(slowed)) == {case, *refused(run)}


def test_on_another_processor_time_is_told_and_counts_are_refused():
    other = {case: replace(row, ratio=3 * row.ratio, processor="another 1 1") for case, row in QUIET.items()}
    assert refused(other) == []
    assert all("another processor" in finding.text for finding in speed.compare(LAST, other))
    assert refused(other | {"train": replace(other["train"], iterations=1)}) == ["train"]


def test_a_processor_is_told_by_maker_family_and_model(tmp_path):
    info = tmp_path / "cpuinfo"
    lines = ["processor\t: 0", "vendor_id\t: Maker", "cpu family\t: 6", "model\t\t: 85", "model name\t: One of many"]
    info.write_text("\n".join([*lines, "", "model\t: 9"]))
    assert speed._processor(info) == "Maker 6 85"
    assert speed._processor(tmp_path / "none")


def test_measuring_again_does_not_save_a_case_that_is_slower_by_half():
    slow = [{case: replace(row, ratio=1.5 * row.ratio) for case, row in run.items()} for run in RUNS]
    assert set(refused(speed.keep_fastest(speed.keep_fastest(slow[0], slow[1]), slow[2]))) == set(LAST)


def test_a_disturbed_case_is_saved_by_measuring_again():
    disturbed = QUIET | {"train": replace(QUIET["train"], ratio=2 * QUIET["train"].ratio)}
    assert refused(disturbed) == ["train"]
    assert refused(speed.keep_fastest(disturbed, {"train": RUNS[2]["train"]})) == []


@pytest.mark.parametrize("name", ["iterations", "unknowns"])
@pytest.mark.parametrize("factor", [0.7, 1.3])
def test_counts_that_change_by_more_than_a_fifth_are_refused_either_way(name, factor):
    row = QUIET["press_no_slip"]
    changed = replace(row, **{name: round(factor * getattr(row, name))})
    assert refused(QUIET | {"press_no_slip": changed}) == ["press_no_slip"]


def test_counts_that_change_by_a_tenth_are_accepted():
    row = QUIET["press_no_slip"]
    assert refused(QUIET | {"press_no_slip": replace(row, iterations=round(1.1 * row.iterations))}) == []


def test_a_case_that_was_not_measured_is_refused_and_a_new_one_is_told():
    now = {("new" if case == "train" else case): row for case, row in QUIET.items()}
    found = {finding.case: finding for finding in speed.compare(LAST, now)}
    assert found["train"].refused
    assert not found["new"].refused
    assert "no release" in found["new"].text


def test_the_last_version_of_the_history_is_the_one_compared_with():
    older = [replace(row, version="0.0.1", ratio=9.0) for row in LAST.values()]
    assert speed.last_release([*older, *LAST.values()]) == LAST


def test_rows_of_a_version_replace_its_own_and_leave_the_others(tmp_path):
    path = tmp_path / "speed.csv"
    older = [replace(row, version="0.0.1") for row in LAST.values()]
    speed.append(older, LAST, path)
    speed.append(speed.read_history(path), {case: replace(row, ratio=7.0) for case, row in LAST.items()}, path)
    rows = speed.read_history(path)
    assert [row.version for row in rows] == ["0.0.1"] * 10 + [next(iter(LAST.values())).version] * 10
    assert {row.ratio for row in rows[10:]} == {7.0}


def test_a_release_is_the_median_of_its_measurements():
    middle = speed.middle(RUNS)
    assert middle["train"].ratio == sorted(run["train"].ratio for run in RUNS)[2]


def test_what_the_benchmark_writes_is_read(tmp_path):
    extra = {"rounds": [0.5, 0.4], "yardsticks": [0.2, 0.275, 0.2], "iterations": 107, "unknowns": 3195}
    path = tmp_path / "speed.json"
    path.write_text(json.dumps({"benchmarks": [{"name": "test_press[no_slip]", "extra_info": extra}]}))
    row = speed.read_measured(path)["press_no_slip"]
    assert (row.ratio, row.iterations, row.unknowns, row.cpu_s) == (2.0, 107, 3195, 0.4)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "version,case\n0.1.0,train\n",
        "version,commit,case,ratio,iterations,unknowns,cpu_s\n0.1.0,a,train,fast,1,1,1\n",
        "version,commit,case,ratio,iterations,unknowns,cpu_s\n0.1.0,a,train,-1,1,1,1\n",
        "version,commit,case,ratio,iterations,unknowns,cpu_s\n0.1.0,a,train,nan,1,1,1\n",
    ],
    ids=["empty", "columns missing", "no number", "negative", "nan"],
)
def test_a_damaged_history_is_refused_with_a_remedy(tmp_path, text):
    path = tmp_path / "speed.csv"
    path.write_text(text)
    with pytest.raises(speed.SpeedError, match="Take the committed file again"):
        speed.read_history(path)
