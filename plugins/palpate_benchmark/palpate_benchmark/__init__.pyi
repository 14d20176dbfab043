"""Benchmark: open data set of images of built units, hidden test labels, scores and five baselines."""

from palpate_benchmark.make_benchmark import BenchmarkFiles, make_benchmark
from palpate_benchmark.predictions import Predictions, read_predictions, write_predictions
from palpate_benchmark.read_benchmark_spec import read_baseline_spec, read_benchmark_spec
from palpate_benchmark.read_set import BenchmarkSet, SplitMarkers, SplitTable, read_set
from palpate_benchmark.run_baselines import BASELINES, run_baselines
from palpate_benchmark.score import BenchmarkScore, ErrorLine, ScoreLine, score_file, score_predictions
from palpate_benchmark.score_page import SCORE_COLUMNS, compare_report, score_report, score_rows
from palpate_benchmark.simulate_unit import deviation_of, simulate_unit
from palpate_benchmark.spec import (
    PRESETS,
    TINY_BASELINES,
    BaselineSpec,
    BenchmarkDesign,
    BenchmarkSpec,
    TwinPressSpec,
)
from palpate_benchmark.unit_images import UnitImages

__all__ = [
    "BASELINES",
    "PRESETS",
    "SCORE_COLUMNS",
    "TINY_BASELINES",
    "BaselineSpec",
    "BenchmarkDesign",
    "BenchmarkFiles",
    "BenchmarkScore",
    "BenchmarkSet",
    "BenchmarkSpec",
    "ErrorLine",
    "Predictions",
    "ScoreLine",
    "SplitMarkers",
    "SplitTable",
    "TwinPressSpec",
    "UnitImages",
    "compare_report",
    "deviation_of",
    "make_benchmark",
    "read_baseline_spec",
    "read_benchmark_spec",
    "read_predictions",
    "read_set",
    "run_baselines",
    "score_file",
    "score_predictions",
    "score_report",
    "score_rows",
    "simulate_unit",
    "write_predictions",
]
