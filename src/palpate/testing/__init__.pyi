"""Contract suites: what every implementation of a contract must satisfy, for the package's own and for others.

A test class inherits a suite and gives its fixtures; pytest, which this room alone needs, collects the rest.
"""

from palpate.testing.estimator import EstimatorSuite
from palpate.testing.law import LawSuite
from palpate.testing.lens import LensSuite
from palpate.testing.linear_solver import LinearSolverSuite
from palpate.testing.obstacle import ObstacleSuite
from palpate.testing.recording_reader import RecordingReaderSuite
from palpate.testing.robot import RobotSuite
from palpate.testing.skin import SkinSuite
from palpate.testing.source import SourceSuite

__all__ = [
    "EstimatorSuite",
    "LawSuite",
    "LensSuite",
    "LinearSolverSuite",
    "ObstacleSuite",
    "RecordingReaderSuite",
    "RobotSuite",
    "SkinSuite",
    "SourceSuite",
]
