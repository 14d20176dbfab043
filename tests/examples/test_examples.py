"""Every example runs, and gives the number that its reader expects; every benchmark can be imported."""

import importlib.util
import io
import runpy
import sys
from contextlib import redirect_stdout
from pathlib import Path

import pytest

from needs import needs
from presses import stored

EXAMPLES = Path(__file__).parents[2] / "examples"
BENCHMARKS = sorted((EXAMPLES.parent / "benchmarks").glob("*.py"))
ELSEWHERE = {"felupe_press": "felupe"}
"""Benchmark → the library of its own environment, which this one may lack."""
EXPECTED = {
    "ex01_press": pytest.approx(0.1997, rel=0.01),
    "ex02_markers": pytest.approx(1.949, rel=0.01),
    "ex03_two_states": pytest.approx(2.61, abs=0.06),
    "ex04_mesh": pytest.approx(-0.0113, abs=0.003),
    "ex05_mold": pytest.approx(9.17, rel=0.01),
    "ex06_limit": pytest.approx(0.402, rel=0.02),
    "ex07_material": pytest.approx(0.02803, rel=0.01),
    "ex08_dots": pytest.approx(0.076, abs=0.05),
    "ex09_friction": pytest.approx(3.0, rel=0.05),
    "ex10_train": pytest.approx(0.73, rel=0.1),
    "ex11_ball": pytest.approx(0.0670, rel=0.01),
    "ex12_ellipsoid": pytest.approx(0.18, rel=0.2),
    "ex13_ball_sensor": pytest.approx(0.021, rel=0.2),
    "ex14_mujoco": pytest.approx(2.99, abs=0.02),
    "ex15_gel_filled": pytest.approx(12.0, rel=0.02),
    "ex16_slide": pytest.approx(0.6, rel=0.02),
    "ex17_edge_sensor": pytest.approx((0.029, 0.47), rel=0.3),
    "ex18_deburring_cell": pytest.approx(0.035, abs=0.03),
}
SLOW = {"ex18_deburring_cell": pytest.mark.slow}
NEEDS = {
    "ex05_mold": ["build123d"],
    "ex08_dots": ["cv2"],
    "ex10_train": ["torch"],
    "ex12_ellipsoid": ["torch"],
    "ex13_ball_sensor": ["torch"],
    "ex14_mujoco": ["mujoco", "trimesh"],
    "ex17_edge_sensor": ["torch"],
    "ex18_deburring_cell": ["mujoco", "trimesh"],
}


def test_every_example_is_expected() -> None:
    assert sorted(path.stem for path in EXAMPLES.glob("ex*.py")) == sorted(EXPECTED)


@pytest.mark.parametrize("name", [pytest.param(name, marks=SLOW.get(name, ())) for name in EXPECTED])
def test_an_example_gives_its_number(name: str, tmp_path, monkeypatch) -> None:
    for needed in NEEDS.get(name, ()):
        needs(needed)
    monkeypatch.chdir(tmp_path)  # where an example leaves its picture
    monkeypatch.setenv("MPLBACKEND", "agg")
    path = EXAMPLES / f"{name}.py"

    def run() -> tuple[object, str]:
        with redirect_stdout(io.StringIO()) as printed:
            return runpy.run_path(str(path))["main"](), printed.getvalue()

    value, printed = stored("example", [path.read_text()], run)
    assert value == EXPECTED[name]
    assert printed


@pytest.mark.parametrize("path", BENCHMARKS, ids=lambda path: path.stem)
def test_a_benchmark_can_be_imported(path: Path, monkeypatch) -> None:
    if path.stem in ELSEWHERE:
        pytest.importorskip(ELSEWHERE[path.stem])
    monkeypatch.syspath_prepend(str(path.parent))
    monkeypatch.setenv("MPLBACKEND", "agg")
    spec = importlib.util.spec_from_file_location(f"benchmark_{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, spec.name, module)
    spec.loader.exec_module(module)
