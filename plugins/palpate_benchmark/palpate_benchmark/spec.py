"""Specs of the benchmark: designs, units, presses, images and baselines."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, model_validator
from pydantic_core import PydanticCustomError

from palpate.calibration import ToleranceSpec
from palpate.camera import CameraSpec, RenderSpec
from palpate.core import Spec, parameter
from palpate.design import DomeSpec, MarkerSpec
from palpate.fea import check_contact
from palpate.learn import TrainingSpec, paper_training

Contact = Annotated[str | float, BeforeValidator(check_contact)]
Split = Literal["train", "calibrate", "test"]
SPLITS: tuple[Split, ...] = ("train", "calibrate", "test")
WORKSHOP = ToleranceSpec(
    stiffening=0.0, friction_min=0.3, friction_max=3.0, seating_tilt_deg=0.0, seating_turn_deg=0.0, depth_zero=0.0
)
"""Tolerances of a careful workshop, with walls from slippery to rough.

Poses are in the unit's own frame, hence without seating errors. The form of the material law is fixed, because a twin
does not model its variation.
"""
LIGHT = RenderSpec(vignetting=0.35, unevenness=0.2, glare=25.0, blur_px=0.8, noise=3.0, dirt=15, rim=True)
"""Light, lens and sensor of the rendered images, as on the virtual bench."""


class BenchmarkDesign(Spec):
    """A dome and its rings of markers."""

    height: float = parameter(20.0, unit="mm", meaning="height of the inner surface's apex over the base", gt=0)
    thickness: float = parameter(2.0, unit="mm", meaning="skin thickness", gt=0)
    markers: int = parameter(169, unit="1", meaning="number of markers", ge=7)

    @property
    def name(self) -> str:
        """Name of the design in every file, e.g. ``H20_T2_M169``."""
        return f"H{self.height:g}_T{self.thickness:g}_M{self.markers}"

    @property
    def skin(self) -> DomeSpec:
        """The dome."""
        return DomeSpec(height=self.height, thickness=self.thickness)

    @property
    def marker_layout(self) -> MarkerSpec:
        """The marker layout."""
        return MarkerSpec(count=self.markers)


class TwinPressSpec(Spec):
    """Presses of a twin."""

    cells: int = parameter(11, unit="1", meaning="cells along a meridian of its meshes", ge=4, le=200)
    tilts_deg: tuple[float, ...] = parameter((0.0, 4.0, 8.0, 12.0), unit="deg", meaning="tilts of the presses")
    contacts: tuple[Contact, ...] = parameter(
        ("no-slip", 1.2, 0.6, 0.3), unit="1", meaning="contact laws of the presses"
    )
    depth_step: float = parameter(
        0.8, unit="mm", meaning="depth step of its presses; finer if they are shallow", gt=0, le=10
    )
    inverted: bool = parameter(True, unit="", meaning="whether the inverted branch is pressed as well")
    checks: int = parameter(2, unit="1", meaning="validation presses between those of the twin", ge=0, le=20)


class BenchmarkSpec(Spec):
    """Contents of the data set.

    The same spec gives the same bytes, for equal versions and one type of processor.
    """

    seed: int = parameter(0, unit="1", meaning="seed of units, poses, noise and numbering", ge=0)
    hidden_seed: int | None = parameter(
        None,
        unit="1",
        meaning="seed of the test units and of the image numbers; empty: derived from `seed`",
        ge=0,
    )
    designs: tuple[BenchmarkDesign, ...] = (
        BenchmarkDesign(),
        BenchmarkDesign(thickness=3.0, markers=91),
        BenchmarkDesign(height=30.0, markers=37),
    )
    """Domes and their markers."""
    material: str = parameter("zaid_2024_ecoflex_00_30", unit="", meaning="elastomer, as in a study")
    train_units: int = parameter(12, unit="1", meaning="training units of each design", ge=1, le=10_000)
    calibrate_units: int = parameter(
        4, unit="1", meaning="units of each design for choices and intervals", ge=1, le=10_000
    )
    test_units: int = parameter(4, unit="1", meaning="units of each design with hidden labels", ge=1, le=10_000)
    presses: int = parameter(120, unit="1", meaning="presses of each unit", ge=1, le=100_000)
    images: int = parameter(14, unit="1", meaning="images of each press, one in each equal part of the depth", ge=1)
    pictures: int = parameter(36, unit="1", meaning="rendered images of each unit, sampled from its images", ge=0)
    max_tilt_deg: float = parameter(12.0, unit="deg", meaning="maximum tilt; uniform over the disc", gt=0, le=30)
    min_depth: float = parameter(1.0, unit="mm", meaning="minimum depth on the flat branch", ge=0, le=60)
    depth: float = parameter(8.0, unit="mm", meaning="maximum depth", gt=0, le=60)
    inverted_share: float = parameter(
        0.1, unit="1", meaning="share of presses on the inverted branch, if the skin has one", ge=0, le=1
    )
    noise_px: float = parameter(
        0.02, unit="px", meaning="standard deviation of a marker coordinate, as measured by the detector", ge=0, le=10
    )
    tolerance: ToleranceSpec = WORKSHOP
    camera: CameraSpec = CameraSpec()
    render: RenderSpec = LIGHT
    twin: TwinPressSpec = TwinPressSpec()
    url: str = parameter(
        "https://example.org/palpate-benchmark", unit="", meaning="address of the published data set"
    )
    creator: str = parameter("The palpate developers", unit="", meaning="publisher of the data set")
    published: str = Field(
        default="2026-01-01",
        pattern=r"^\d{4}-\d{2}-\d{2}$",
        description="Date of publication, as in 2026-01-31.",
    )
    licence: str = parameter(
        "https://creativecommons.org/licenses/by/4.0/", unit="", meaning="licence of the data set"
    )

    @property
    def units(self) -> int:
        """Units of each design."""
        return self.train_units + self.calibrate_units + self.test_units

    def split_of(self, unit: int) -> Split:
        """Return the split of unit 1, 2, …"""
        if unit <= self.train_units:
            return "train"
        return "calibrate" if unit <= self.train_units + self.calibrate_units else "test"

    @model_validator(mode="after")
    def _designs_differ(self) -> BenchmarkSpec:
        names = [design.name for design in self.designs]
        if not names or len(set(names)) < len(names):
            raise PydanticCustomError(
                "designs-not-distinct", "at least one design is needed, and each design only once.", {}
            )
        return self

    @model_validator(mode="after")
    def _depths_rise(self) -> BenchmarkSpec:
        if self.min_depth >= self.depth:
            raise PydanticCustomError(
                "depths-not-rising",
                "the minimum depth is {minimum} mm; it must be below the maximum depth of {maximum} mm.",
                {"minimum": f"{self.min_depth:g}", "maximum": f"{self.depth:g}"},
            )
        return self

    @model_validator(mode="after")
    def _pictures_are_images(self) -> BenchmarkSpec:
        if self.pictures > self.presses * self.images:
            raise PydanticCustomError(
                "pictures-exceed-images",
                "{pictures} rendered images per unit exceed its {images} images.",
                {"pictures": self.pictures, "images": self.presses * self.images},
            )
        return self


class BaselineSpec(Spec):
    """Settings of the five baselines."""

    seed: int = parameter(0, unit="1", meaning="seed of weights and batches", ge=0)
    jitter_px: float = parameter(0.1, unit="px", meaning="jitter of marker coordinates in training", ge=0, le=20)
    network: TrainingSpec = TrainingSpec(epochs=40, repeats=3)
    paper: TrainingSpec = paper_training(4, 256, 0.0).model_copy(update={"epochs": 60, "repeats": 1})
    picture_px: int = parameter(
        128, unit="px", meaning="longer side of the input of the image network", ge=32, le=512
    )
    picture_epochs: int = parameter(30, unit="1", meaning="epochs of the image network", ge=1, le=100_000)
    twin: TwinPressSpec = TwinPressSpec(cells=10, contacts=("no-slip", 1.0, 0.5, 0.3))
    """Twin of the fit, on another mesh and with other frictions than the twin behind the data set."""


TINY = BenchmarkSpec(
    designs=(BenchmarkDesign(markers=19), BenchmarkDesign(height=18.0, markers=37)),
    train_units=3,
    calibrate_units=2,
    test_units=1,
    presses=10,
    images=3,
    pictures=4,
    depth=3.0,
    twin=TwinPressSpec(cells=4, depth_step=1.0, contacts=("no-slip",), inverted=False, checks=0),
    tolerance=WORKSHOP.model_copy(update={"friction_min": 0.0, "friction_max": 0.0}),
)
PRESETS = {"full": BenchmarkSpec(), "tiny": TINY}
"""The published data set, and a small one for tests, made in seconds and without slip."""
TINY_BASELINES = BaselineSpec(
    network=TrainingSpec(epochs=3, repeats=1, layers=1, width=16),
    paper=paper_training(1, 16, 0.0).model_copy(update={"epochs": 2, "repeats": 1}),
    picture_px=64,
    picture_epochs=1,
    twin=TwinPressSpec(cells=5, depth_step=1.0, contacts=("no-slip",), inverted=False, checks=0),
)
