"""Pose fit of one image, and the state that is passed to the next image."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial

import numpy as np

from palpate.calibration.force import Force, ScalarEstimate
from palpate.calibration.unit_model import PredictedImage
from palpate.core import FloatArray
from palpate.core.state import State
from palpate.design import TILT_SPACE, PoseEstimate
from palpate.surrogate import LATERAL

POSE: tuple[str, ...] = TILT_SPACE.names
CONTACT_STATE = (*POSE, "inverse_friction", "curvature", *LATERAL)
"""Fitted contact parameters: pose, 1/µ, curvature of the wall (1/m), lateral motion (mm) and twist."""
Linear = tuple[State, PredictedImage, FloatArray]
"""Contact, its predicted image, and the derivatives by the standardised unit parameters."""


@dataclass(frozen=True, eq=False)
class PoseFit(PoseEstimate):
    """Pose fit of one image, in the skin's frame, or on the robot's scale if the mounting is known.

    Attributes
    ----------
    covariance
        (3, 3) of rx, ry (degrees) and depth (mm), including the uncertainty of the unit.
    inverse_friction, curvature
        1/µ, and the curvature of the wall (1/m); 0 if not fitted.
    force
        Contact force.
    residual_px
        Root mean square residual of a coordinate, px.
    misfit
        Reduced chi-square, about 1 if the model explains the image.
    steps
        Number of Gauss-Newton steps.
    state
        `CONTACT_STATE`, in the skin's frame; entries that are not fitted are 0.
    cost
        Half the sum of squares of bounded residuals and of the standardised unit parameters.
    unit
        (11,) correction of the unit parameters with which the image fits best.
    inverted
        Whether the skin is on the inverted branch.
    """

    covariance: FloatArray
    inverse_friction: ScalarEstimate
    curvature: ScalarEstimate
    force: Force
    residual_px: float
    misfit: float
    steps: int
    state: State
    cost: float
    unit: FloatArray
    inverted: bool = False


@dataclass(frozen=True, eq=False)
class BranchState:
    """State of the fit on one branch of the skin.

    Attributes
    ----------
    last
        `CONTACT_STATE` of the last image; `None` before the first.
    moved, motion
        Its change with the last image, and the change expected with the next.
    near
        Last linearisation in the unit parameters.
    """

    last: State | None = None
    moved: State = field(default_factory=partial(State.zeros, CONTACT_STATE))
    motion: State = field(default_factory=partial(State.zeros, CONTACT_STATE))
    near: Linear | None = None

    def after(self, contact: State, near: Linear, scale: State) -> BranchState:
        """Return the state after a contact; the last motion is extrapolated if it is like the one before.

        `scale` is the change of a contact within which images are alike.
        """
        still = State.zeros(CONTACT_STATE)
        moved = still if self.last is None else contact - self.last
        turned, far = (float(np.linalg.norm(each[POSE] / scale[POSE])) for each in (moved - self.moved, moved))
        return BranchState(contact, moved, moved if turned < 0.5 * far else still, near)


@dataclass(frozen=True, eq=False)
class FitState:
    """State from which the next image is fitted: the flat branch, and the inverted one (`other`)."""

    flat: BranchState = field(default_factory=BranchState)
    other: BranchState = field(default_factory=BranchState)
    inverted: bool = False
