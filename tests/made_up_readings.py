"""Readings and pose fits made up for tests."""

import numpy as np

from palpate.calibration import CONTACT_STATE, Force, PoseFit
from palpate.calibration.force import LEVEL_90, ScalarEstimate
from palpate.core.state import State
from palpate.sensor import Reading


def make_reading(pose, half_width=(0.2, 0.2, 0.1), touching=True, flags=(), **fields):
    """Return a reading of image 1 with 37 markers."""
    given = {"found": 37, "image": 1, "latency_ms": 3.0} | fields
    return Reading(
        pose=np.array(pose, float), half_width=np.array(half_width, float), touching=touching, flags=flags, **given
    )


def make_fit(pose, covariance, force=None, friction=(0.8, 0.2), **fields):
    """Return a fit of a pose (3,), degrees and mm, with covariance (3, 3)."""
    force = force or Force(np.array([0.0, 0.0, 0.2]), 1e-4 * np.eye(3), np.array([0.0, 0.0, 1.0]))
    state = State.zeros(CONTACT_STATE).replace(rx_deg=pose[0], ry_deg=pose[1], depth_mm=pose[2])
    given = {"residual_px": 0.05, "misfit": 1.0, "steps": 3, "cost": 1.0, "unit": np.zeros(11)} | fields
    return PoseFit(
        np.array(pose, float),
        LEVEL_90 * np.sqrt(np.diag(covariance)),
        covariance=np.asarray(covariance),
        inverse_friction=ScalarEstimate(*friction),
        curvature=ScalarEstimate(0.0, 0.0),
        force=force,
        state=state,
        **given,
    )
