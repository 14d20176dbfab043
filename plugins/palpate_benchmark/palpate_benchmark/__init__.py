"""Benchmark: open data set of images of built units, hidden test labels, scores and five baselines."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
