"""Deviations of a built unit from its design, sampled within the manufacturing tolerances.

Every imperfection has its own random stream: its value in a unit is the same whether it is sampled alone or with all
others.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any

from palpate.calibration.tolerance import ToleranceSpec
from palpate.camera import LENSES, CameraSpec
from palpate.core import child_seed, generator, parameters
from palpate.design import Design, SkinSpec
from palpate.material import Material


@dataclass(frozen=True)
class Deviation:
    """Deviations of one unit; the defaults are the nominal unit.

    Attributes
    ----------
    thickness
        Deviation of the skin thickness, mm.
    modulus, stiffening
        Relative deviation of all constants of the law, and of the higher-order constants from the first.
    friction
        Coefficient of friction; 0: contact as in the training.
    marker_position, print_shift_x, print_shift_y
        Maximum displacement of single markers, and displacement of the whole print, mm.
    missing
        Share of missing markers.
    offset_x, offset_y, distance, tilt_x_deg, tilt_y_deg, roll_deg
        Deviation from the nominal pose of the camera, mm and degrees.
    focal, centre_x_px, centre_y_px, k1
        Calibration error of the lens: relative focal length, centre (px), leading distortion coefficient.
    seating_x_deg, seating_y_deg, seating_turn_deg
        Rotation of the skin relative to the robot.
    depth_zero
        Depth of first contact on the robot's scale, mm.
    lateral, twist_deg
        Maximum lateral motion (mm) and twist (degrees) of the robot in a press.
    curvature
        Maximum curvature of a wall, 1/m.
    seed
        Seed of the displaced and missing markers.
    unit
        Number of the unit, which selects the poses of its trial; 0 for the nominal unit.
    """

    thickness: float = 0.0
    modulus: float = 0.0
    stiffening: float = 0.0
    friction: float = 0.0
    marker_position: float = 0.0
    print_shift_x: float = 0.0
    print_shift_y: float = 0.0
    missing: float = 0.0
    offset_x: float = 0.0
    offset_y: float = 0.0
    distance: float = 0.0
    tilt_x_deg: float = 0.0
    tilt_y_deg: float = 0.0
    roll_deg: float = 0.0
    focal: float = 0.0
    centre_x_px: float = 0.0
    centre_y_px: float = 0.0
    k1: float = 0.0
    seating_x_deg: float = 0.0
    seating_y_deg: float = 0.0
    seating_turn_deg: float = 0.0
    depth_zero: float = 0.0
    lateral: float = 0.0
    twist_deg: float = 0.0
    curvature: float = 0.0
    seed: int = 0
    unit: int = 0

    def dome(self, nominal: SkinSpec) -> SkinSpec:
        """Return the skin as built: only the outer surface moves, since the mold's core shapes the inner one."""
        return nominal.model_copy(update={"thickness": nominal.thickness + self.thickness})

    def material(self, nominal: Material) -> Material:
        """Return the elastomer as mixed."""
        return replace(nominal, law=nominal.law.scaled(1.0 + self.modulus, 1.0 + self.stiffening))

    def built(self, design: Design) -> Design:
        """Return the design as built; its layout is nominal, without the displacements of the markers."""
        return replace(
            design,
            skin_spec=self.dome(design.skin_spec),
            camera_spec=self.camera(design.camera_spec),
            material=self.material(design.material),
        )

    def camera(self, nominal: CameraSpec) -> CameraSpec:
        """Return the camera as mounted, with the lens in error by its calibration.

        `k1` is added to the lens's `leading` coefficient, or ignored if the lens lacks one.
        """
        pose = ("offset_x", "offset_y", "distance", "tilt_x_deg", "tilt_y_deg", "roll_deg")
        values: dict[str, Any] = {name: getattr(nominal, name) + getattr(self, name) for name in pose}
        values |= {name: getattr(nominal, name) * (1.0 + self.focal) for name in ("fx_px", "fy_px")}
        values |= {"cx_px": nominal.cx_px + self.centre_x_px, "cy_px": nominal.cy_px + self.centre_y_px}
        lens = LENSES.get(nominal.lens)
        named = zip(lens.parameters(), nominal.distortion, strict=True)
        values["distortion"] = tuple(value + self.k1 * (name == lens.leading) for name, value in named)
        return nominal.model_copy(update=values)

    def as_dict(self) -> dict[str, float]:
        """Return plain data."""
        return asdict(self)


@dataclass(frozen=True)
class Imperfection:
    """One entry of the error budget.

    Attributes
    ----------
    name
        Field of `ToleranceSpec`.
    label
        Label in tables and figures.
    parts
        Fields of `Deviation` that it changes.
    signed
        Whether the deviation has either sign.
    solved
        Whether it requires presses to be solved.
    stream
        Name of its random stream; `name` if empty.
    """

    name: str
    label: str
    parts: tuple[str, ...]
    signed: bool = True
    solved: bool = False
    stream: str = ""

    @property
    def unit(self) -> str:
        """Unit of the deviation; ``"1"`` for a ratio."""
        return next(note.unit for note in parameters(ToleranceSpec) if note.name == self.name).replace("deg", "°")


IMPERFECTIONS = (
    Imperfection("thickness", "skin thickness", ("thickness",), solved=True),
    Imperfection("modulus", "stiffness", ("modulus",), solved=True),
    Imperfection("stiffening", "stiffening", ("stiffening",), solved=True),
    Imperfection("friction_min", "friction", ("friction",), signed=False, solved=True, stream="friction"),
    Imperfection("marker_position", "position of each marker", ("marker_position",), signed=False, stream="dot"),
    Imperfection("print_shift", "position of the print", ("print_shift_x", "print_shift_y"), stream="pad"),
    Imperfection("missing", "missing markers", ("missing",), signed=False),
    Imperfection("camera_offset", "camera's offset", ("offset_x", "offset_y")),
    Imperfection("camera_distance", "camera's distance", ("distance",)),
    Imperfection("camera_tilt_deg", "camera's tilt", ("tilt_x_deg", "tilt_y_deg")),
    Imperfection("camera_roll_deg", "camera's roll", ("roll_deg",)),
    Imperfection("focal", "focal length", ("focal",)),
    Imperfection("centre_px", "centre of the lens", ("centre_x_px", "centre_y_px")),
    Imperfection("distortion", "distortion", ("k1",)),
    Imperfection("seating_tilt_deg", "seating, tilt", ("seating_x_deg", "seating_y_deg")),
    Imperfection("seating_turn_deg", "seating, turn", ("seating_turn_deg",)),
    Imperfection("depth_zero", "depth zero", ("depth_zero",), stream="touch"),
    Imperfection("lateral", "lateral motion", ("lateral",), signed=False, solved=True),
    Imperfection("twist_deg", "twist", ("twist_deg",), signed=False, solved=True),
    Imperfection("curvature", "curvature of the wall", ("curvature",), signed=False, solved=True, stream="bend"),
)


def sample_deviation(tolerance: ToleranceSpec, seed: int, unit: int) -> Deviation:
    """Sample the deviations of unit 1, 2, ….

    Signed deviations are uniform within their tolerances, other deviations equal them (they are the maxima of later
    draws), and friction lies between its minimum and maximum.

    Examples
    --------
    >>> deviation = sample_deviation(ToleranceSpec(), seed=0, unit=1)
    >>> abs(deviation.thickness) <= 0.05, deviation == sample_deviation(ToleranceSpec(), seed=0, unit=1)
    (True, True)
    """
    values: dict[str, Any] = {"seed": child_seed(seed, "dots", unit), "unit": unit}
    for item in IMPERFECTIONS:
        limit, rng = float(getattr(tolerance, item.name)), generator(seed, item.stream or item.name, unit)
        for part in item.parts:
            values[part] = limit * float(rng.uniform(-1.0, 1.0)) if item.signed else limit
        if item.name == "friction_min":
            values["friction"] = tolerance.friction_at(float(rng.uniform())) if limit else 0.0
    return Deviation(**values)


def single_deviation(tolerance: ToleranceSpec, item: Imperfection, seed: int, draw: int) -> Deviation:
    """Return one imperfection alone at its tolerance; `draw` selects signs and the displaced markers."""
    limit, rng = float(getattr(tolerance, item.name)), generator(seed, item.stream or item.name, "sign", draw // 2)
    values: dict[str, Any] = {"seed": child_seed(seed, "dots", draw)}
    for part in item.parts:
        sign = 1.0 if rng.uniform() < 0.5 else -1.0
        values[part] = limit * (sign * (-1.0) ** draw if item.signed else 1.0)
    return Deviation(**values)
