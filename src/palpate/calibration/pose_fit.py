"""What the fit of one image says, and what is carried from it to the next."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial

import numpy as np

from palpate.calibration.force import LEVEL_90, Force
from palpate.calibration.unit_model import PredictedImage
from palpate.core import FloatArray
from palpate.core.state import State
from palpate.design import TILT_SPACE
from palpate.surrogate import LATERAL

POSE: tuple[str, ...] = TILT_SPACE.names
CONTACT_STATE = (*POSE, "inverse_friction", "curvature", *LATERAL)
"""What is fitted beside the unit: pose, 1/µ, the wall's curvature (1/m), and its travel (mm) and turn on the way."""
Linear = tuple[State, PredictedImage, FloatArray]
"""A touch, what is seen there, and how it depends on the unit."""


@dataclass(frozen=True, eq=False)
class PoseFit:
    """What one image says.

    Attributes
    ----------
    pose
        (3,) rx, ry (degrees) and depth (mm) in the dome's frame, or on the robot's scale where the mounting is known.
    inverse_friction
        1/µ.
    covariance
        (4, 4) of pose and slip, what is unknown of the unit included.
    curvature, curvature_sd
        Curvature of the wall, 1/m, and its standard deviation; 0 where it was not asked.
    lateral
        (3,) how far the wall travelled in its plane (mm) and turned (degrees) on the way; 0 where it was not asked.
    force
        On the wall.
    residual_px
        Root mean square distance of a coordinate from the fit, px.
    misfit
        Mean weighted square of what is left, about 1 where the model is that of what is seen.
    steps
        Gauss–Newton steps taken.
    state
        `CONTACT_STATE`, in the dome's frame.
    cost
        Half the weighted squares of what is left, and of what was fitted against its prior.
    unit
        (11,) correction of the unit's numbers with which the image fits best.
    inverted
        Whether the skin stands in its other state.
    """

    pose: FloatArray
    inverse_friction: float
    covariance: FloatArray
    curvature: float
    curvature_sd: float
    lateral: FloatArray
    force: Force
    residual_px: float
    misfit: float
    steps: int
    state: State
    cost: float
    unit: FloatArray
    inverted: bool = False

    @property
    def half_width(self) -> FloatArray:
        """Half-widths (4,) of the intervals of nine tenths of pose and 1/µ."""
        return LEVEL_90 * np.sqrt(np.diag(self.covariance))


@dataclass(frozen=True, eq=False)
class BranchState:
    """Where the fit of one branch of the skin stands.

    Attributes
    ----------
    last
        `CONTACT_STATE` of the last image; `None` before any.
    moved, motion
        Change of it with the last image, and that with which the next one is expected.
    near
        Where the image was last linearised in the unit's numbers.
    """

    last: State | None = None
    moved: State = field(default_factory=partial(State.zeros, CONTACT_STATE))
    motion: State = field(default_factory=partial(State.zeros, CONTACT_STATE))
    near: Linear | None = None

    def after(self, contact: State, near: Linear, scale: State) -> BranchState:
        """The state after a contact: the wall is expected to go on as it moved, if it moved so before.

        `scale` is the change of a contact within which images are alike.
        """
        still = State.zeros(CONTACT_STATE)
        moved = still if self.last is None else contact - self.last
        turned, far = (float(np.linalg.norm(each[POSE] / scale[POSE])) for each in (moved - self.moved, moved))
        return BranchState(contact, moved, moved if turned < 0.5 * far else still, near)


@dataclass(frozen=True, eq=False)
class FitState:
    """From where the next image is fitted: by the design's branch of the skin, and by the inverted one."""

    flat: BranchState = field(default_factory=BranchState)
    other: BranchState = field(default_factory=BranchState)
    inverted: bool = False
