"""Learning: from images of markers to the pose of the wall, and how good any estimator could be."""

from palpate.learn.metrics import DepthErrors, ErrorSummary, Metrics, measure_errors

__all__ = ["DepthErrors", "ErrorSummary", "Metrics", "measure_errors"]
