"""The comparer of `.ci/speed.py`, by what was measured: nine runs on two processors, busy and free."""

import importlib.util
import json
import re
import sys
from dataclasses import replace
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
spec = importlib.util.spec_from_file_location("speed", ROOT / ".ci" / "speed.py")
speed = importlib.util.module_from_spec(spec)
sys.modules["speed"] = speed
spec.loader.exec_module(speed)

LAST = speed.last_release(speed.read_runs())
RUNS = [{case: runs[number] for case, runs in LAST.items()} for number in range(len(LAST["train"]))]
QUIET = RUNS[1]


def refused(now, runs=None):
    last = LAST if runs is None else {case: [run[case] for run in runs] for case in LAST}
    return [finding.case for finding in speed.compare(last, now) if finding.refused]


def test_there_are_ten_cases_and_as_many_runs_of_each():
    assert len(LAST) == 10
    assert {len(runs) for runs in LAST.values()} == {len(RUNS)}
    assert len(RUNS) >= 9
    assert len({run["train"].processor for run in RUNS}) == 2


@pytest.mark.parametrize("number", range(len(RUNS)))
def test_the_same_code_is_accepted_by_the_runs_of_other_moments(number):
    """Without the run itself: as a new run on a machine that was measured in other states."""
    others = [run for each, run in enumerate(RUNS) if each != number]
    assert refused(RUNS[number], others) == []


@pytest.mark.parametrize("case", sorted(LAST))
def test_a_case_that_is_half_as_slow_again_as_the_slowest_run_is_refused(case):
    slowest = max(run[case].ratio for run in RUNS)
    for run in RUNS:
        assert refused(run | {case: replace(run[case], ratio=1.5 * slowest)}) == [case]


def test_a_case_that_takes_twice_its_time_is_refused_in_every_run():
    for run in RUNS:
        for case, row in run.items():
            assert refused(run | {case: replace(row, ratio=2.0 * row.ratio)}) == [case]


def test_on_another_processor_time_is_told_and_counts_are_refused():
    other = {case: replace(row, ratio=3 * row.ratio, processor="another 1 1") for case, row in QUIET.items()}
    assert refused(other) == []
    found = speed.compare(LAST, other)
    assert not any(finding.slow for finding in found)
    assert all(f"{other[finding.case].ratio:.3g}" in finding.text for finding in found)
    moved = {case: replace(row, processor="another 1 1") for case, row in QUIET.items()}
    pairs = zip(speed.compare(LAST, QUIET), speed.compare(LAST, moved), strict=True)
    assert all(there.text.startswith(here.text) and there.text != here.text for here, there in pairs), "it is told"
    assert refused(other | {"train": replace(other["train"], iterations=1)}) == ["train"]


def test_a_processor_is_told_by_maker_family_and_model(tmp_path):
    info = tmp_path / "cpuinfo"
    lines = ["processor\t: 0", "vendor_id\t: Maker", "cpu family\t: 6", "model\t\t: 85", "model name\t: One of many"]
    info.write_text("\n".join([*lines, "", "model\t: 9"]))
    assert speed._processor(info) == "Maker 6 85"
    assert speed._processor(tmp_path / "none")


def test_measuring_again_does_not_save_a_case_that_takes_twice_its_time():
    slow = [{case: replace(row, ratio=2.0 * row.ratio) for case, row in run.items()} for run in RUNS]
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
    assert found["new"].text
    assert not re.search(r"\d", found["new"].text), "it is compared with nothing"


def test_the_last_version_of_the_history_is_the_one_compared_with():
    older = [replace(row, version="0.0.1", ratio=9.0) for row in QUIET.values()]
    assert speed.last_release([*older, *QUIET.values()]) == {case: [row] for case, row in QUIET.items()}


def test_rows_are_written_and_read_back(tmp_path):
    rows = speed.read_runs()
    speed.write_rows(tmp_path / "runs.csv", rows)
    assert speed.read_runs(tmp_path / "runs.csv") == rows


def test_the_page_shows_the_medians_of_the_runs():
    rows = speed.medians(speed.read_runs())
    shown = [replace(row, ratio=float(f"{row.ratio:.4g}"), cpu_s=float(f"{row.cpu_s:.3g}")) for row in rows]
    assert speed.read_runs(speed.HISTORY) == shown
    assert [row.processor for row in rows] == [QUIET["train"].processor] * 10 + [RUNS[-1]["train"].processor] * 10
    train = sorted(run["train"].ratio for run in RUNS if run["train"].processor == rows[-1].processor)
    assert rows[-1].ratio == train[len(train) // 2]


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
        "version,case,ratio,iterations,unknowns,cpu_s,processor\n0.1.0,train,fast,1,1,1,x\n",
        "version,case,ratio,iterations,unknowns,cpu_s,processor\n0.1.0,train,-1,1,1,1,x\n",
        "version,case,ratio,iterations,unknowns,cpu_s,processor\n0.1.0,train,nan,1,1,1,x\n",
    ],
    ids=["empty", "columns missing", "no number", "negative", "nan"],
)
def test_a_damaged_history_is_refused_with_a_remedy(tmp_path, text):
    path = tmp_path / "speed.csv"
    path.write_text(text)
    with pytest.raises(speed.SpeedError):
        speed.read_runs(path)
