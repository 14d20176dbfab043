"""Check of the camera of a built sensor: light, sharpness, noise, motion and frame rate of its images.

Each figure is compared with its limit, the field of `CameraCheckSpec` of the same name. A figure that the images do
not determine is left out, such as the white balance of grey images.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from palpate.core import FloatArray, PalpateError, flag_name, parameters, wrap_write_errors
from palpate.core.report import Report
from palpate.rig.camera_check_spec import CameraCheckSpec
from palpate.rig.image_series import MOTION_VARIANCE, ImageSeries
from palpate.sensor import provenance_line, write_report
from palpate.vision import DetectSpec

_REMEDIES = {
    "unreadable": "Check cable, USB port and light, and record again.",
    "blank": "Take off the lens cap, switch on the light, and check that the camera faces the skin.",
    "frozen": "Connect the camera again, and close other programs that use it.",
    "saturated": "Shorten the exposure or dim the light.",
    "dark": "Increase the light or the exposure time, and only then the gain.",
    "markers": "Check light, focus and view; give --polarity and --diameter if the markers are clear.",
    "at_border": "Centre the camera or move it back until every marker is wholly visible.",
    "contrast": "Print markers of another colour, or keep other light off the skin.",
    "evenness": "Move or diffuse the lights, or add one on the dark side.",
    "focus": "Turn the lens until the edges of markers are sharp, and lock it.",
    "noise_px": "Increase the light and lower the gain.",
    "motion_blur_px": "Shorten the exposure, stop vibrations, or press more slowly.",
    "vibration_px": "Tighten camera and skin, and keep motors and fans off the rig.",
    "magnification_px": "Switch off the autofocus and lock the focus ring.",
    "sharpness": "Switch off the autofocus and lock the focus ring.",
    "drift_px": "Let the camera warm up before the rest images, and tighten its mount.",
    "brightness": "Switch off automatic exposure and gain, and supply the lights with direct current.",
    "auto_exposure": "Switch off automatic exposure and gain.",
    "white_balance": "Switch off the automatic white balance.",
    "dropped": "Lower the resolution, use another USB port, or record to a faster disk.",
    "irregular": "Switch off a frame rate that depends on the light (exposure_dynamic_framerate).",
}
"""Remedy of each fault, in the order of the report."""
_MINIMA = {"blank", "dark", "markers", "contrast", "evenness"}
"""Figures that have a minimum."""
_EFFECTS = {
    "blank": {"dark", "markers"},
    "saturated": {"markers", "contrast", "noise_px", "focus", "auto_exposure"},
    "dark": {"markers", "noise_px", "brightness"},
    "contrast": {"noise_px", "motion_blur_px"},
    "noise_px": {"motion_blur_px", "brightness", "auto_exposure", "white_balance"},
    "evenness": {"noise_px", "magnification_px", "sharpness"},
    "focus": {"noise_px", "contrast", "motion_blur_px", "magnification_px"},
    "magnification_px": {"drift_px"},
    "vibration_px": {"drift_px"},
    "sharpness": {"brightness", "magnification_px"},
    "brightness": {"auto_exposure"},
    "irregular": {"dropped"},
}
"""Fault → faults that it causes, which are left out."""


@dataclass(frozen=True)
class CameraFigure:
    """One figure of a camera, its limit, and the remedy if it is beyond."""

    code: str
    meaning: str
    value: float
    limit: float
    unit: str
    passed: bool
    remedy: str

    @property
    def limit_text(self) -> str:
        """Limit with its sign."""
        return f"{'≥' if self.code in _MINIMA else '≤'} {self.limit:g}"

    @property
    def sentence(self) -> str:
        """Sentence with value, limit and remedy."""
        unit = f" {self.unit}" if self.unit != "1" else ""
        meaning = f"{self.meaning[:1].upper()}{self.meaning[1:]}"
        return f"{self.code}: {meaning}: {self.value:.3g}{unit} (limit {self.limit_text}{unit}). {self.remedy}"


@dataclass(frozen=True, eq=False)
class CameraCheck:
    """Result of the check of a camera.

    Attributes
    ----------
    figures
        Figures that the images determine.
    rest, press
        Measured images at rest and of presses.
    caused
        Codes of figures that are left out, since they are beyond their limits by another finding.
    """

    figures: tuple[CameraFigure, ...]
    rest: ImageSeries
    press: ImageSeries
    caused: tuple[str, ...] = ()

    @property
    def findings(self) -> tuple[CameraFigure, ...]:
        """Figures beyond their limits."""
        return tuple(one for one in self.figures if not one.passed)

    def as_dict(self) -> dict[str, Any]:
        """Return the result as JSON data; `passed` is true without a finding."""
        return {
            "passed": not self.findings,
            "findings": [one.code for one in self.findings],
            "caused_by_findings": list(self.caused),
            "rest_images": len(self.rest.exposures),
            "press_images": len(self.press.exposures),
            "figures": [asdict(one) for one in self.figures],
        }

    def page(self, title: str) -> list[str | Report]:
        """Return the report: verdict, a sentence for each finding, and all figures with their limits."""
        verdict = f"findings: {', '.join(one.code for one in self.findings)}" if self.findings else "no finding"
        rows = [
            (one.code, f"{one.value:.3g}", one.limit_text, one.unit.strip("1"), "ok" if one.passed else "beyond")
            for one in self.figures
        ]
        return [
            f"# Camera check: {title}",
            f"**{verdict}**",
            *(one.sentence for one in self.findings),
            Report.of("", ("figure", "value", "limit", "unit", "result"), rows),
            *([f"Left out, since another finding causes them: {', '.join(self.caused)}."] if self.caused else []),
            f"Images at rest: {len(self.rest.exposures)}; of presses: {len(self.press.exposures)}.",
            "![Image with markers, and series](images.png)",
            provenance_line(),
        ]

    def write(self, folder: Path, title: str) -> None:
        """Write ``check.json``, ``check.md`` and ``images.png`` into a folder.

        Raises
        ------
        PalpateError
            If they cannot be written.
        """
        write_report(folder, "check", {"source": title, **self.as_dict()}, self.page(title))
        with wrap_write_errors(folder, "Choose another folder."):
            self.rest.draw().savefig(folder / "images.png", dpi=120)


def check_camera(
    rest: Iterable[NDArray[Any] | PalpateError],
    press: Iterable[NDArray[Any] | PalpateError] = (),
    times: Sequence[float] | FloatArray = (),
    spec: CameraCheckSpec | None = None,
    detect: DetectSpec | None = None,
) -> CameraCheck:
    """Check a camera by images of the unloaded skin, and of presses.

    Parameters
    ----------
    rest, press
        Images (h, w) or (h, w, 3) of integers in their order; an error stands for an unreadable image.
    times
        (n,) times of the images at rest, s; empty if unknown; read after the images.
    spec, detect
        Limits, and known properties of the markers.

    Raises
    ------
    PalpateError
        If no image at rest can be read.
    """
    spec, unloaded = spec or CameraCheckSpec(), ImageSeries(detect or DetectSpec())
    unloaded.read(rest)
    if not unloaded.exposures:
        raise PalpateError(
            f"None of {unloaded.unreadable} images at rest can be read.",
            "Record the unloaded skin.",
            code="rest-image-missing",
        )
    pressed = ImageSeries(unloaded.detect, unloaded.detector, unloaded.shape)
    pressed.read(press)
    values = _measure_images(unloaded, pressed) | _measure_rate(np.array(times, float))
    if unloaded.figures:
        values |= _measure_markers(unloaded) | _measure_motion(unloaded, spec.significant)
        values |= _measure_colours(unloaded, pressed)
        if pressed.figures:
            values["motion_blur_px"] = max(values["motion_blur_px"], pressed.motion_blur(unloaded))
    figures = tuple(_compare(values, spec))
    caused = {flag_name(CameraCheckSpec, name) for name in values} - {one.code for one in figures}
    return CameraCheck(figures, unloaded, pressed, tuple(sorted(caused)))


def _compare(values: Mapping[str, float], spec: CameraCheckSpec) -> list[CameraFigure]:
    """Compare figures with their limits; a fault that another one causes is left out."""
    limits = spec.model_dump()
    failed = {name for name in values if (values[name] - limits[name]) * (-1.0 if name in _MINIMA else 1.0) > 0.0}
    caused = {effect for name in failed for effect in _EFFECTS.get(name, ())}
    described = {one.name: one for one in parameters(CameraCheckSpec)}
    figures = []
    for name, remedy in _REMEDIES.items():
        if name in values and name not in failed & caused:
            code, one, within = flag_name(CameraCheckSpec, name), described[name], name not in failed
            meaning = one.meaning.removeprefix("maximum ").removeprefix("minimum ")
            figures.append(CameraFigure(code, meaning, values[name], limits[name], one.unit, within, remedy))
    return figures


def _measure_images(rest: ImageSeries, press: ImageSeries) -> dict[str, float]:
    """Figures of whole images, whether or not they show markers."""
    count, (_, saturated, spread) = len(rest.exposures), np.median(rest.exposures, axis=0).tolist()
    values = {
        "unreadable": float(rest.unreadable + press.unreadable),
        "saturated": saturated,
        "dark": float(np.median(rest.light)) / rest.top,
        "markers": float(np.median([len(one.blobs) for one in rest.figures] or [0])),
    }
    values |= {} if rest.figures else {"blank": spread}
    return values | ({"frozen": rest.repeated / (count - 1)} if count > 1 else {})


def _measure_markers(rest: ImageSeries, isolated: float = 1.4) -> dict[str, float]:
    """Light and sharpness at the markers, and the number of cut ones.

    A cut blob is dirt, not a marker, if it is `isolated` times as far from its neighbour as the median blob is.
    """
    assert rest.last is not None
    motion, size_px, parts = rest.motion_blur(), np.array(rest.last.shape[1::-1], float), []
    for one in rest.figures:
        blobs = one.blobs
        border = np.minimum(blobs.positions_px, size_px - 1.0 - blobs.positions_px).min(axis=1)
        cut = blobs.at_border | (border < 0.5 * blobs.diameter_px)
        apart = cKDTree(blobs.positions_px).query(blobs.positions_px, k=[2])[0][:, 0]
        cut &= apart < isolated * np.median(apart)
        contrast, diameter = np.median(one.looks, axis=1)
        blur = np.sqrt(max(one.edge_px**2 - MOTION_VARIANCE * motion**2, 0.0))
        dark = np.median(one.brighter - one.light.mean(axis=1) + one.light.max(axis=1)) / rest.top
        parts.append((one.saturated, dark, contrast, cut.sum(), 2.0 * blur / diameter))
    names = ("saturated", "dark", "contrast", "at_border", "focus")
    values = dict(zip(names, np.median(parts, axis=0).tolist(), strict=True))
    return values | {"evenness": _measure_evenness(rest), "motion_blur_px": motion}


def _measure_evenness(rest: ImageSeries, tail: float = 0.05, alike: float = 1.5) -> float:
    """Light at a percentile `tail` of the markers over that at 1 - `tail`, in the first image.

    A marker in dim light has the relative contrast and the size of the median marker, up to a factor `alike`.
    """
    many, few = rest.faint or rest.figures[0], rest.figures[0]
    usual = np.median(few.looks, axis=1, keepdims=True)
    light = many.brighter[(abs(np.log(many.looks / usual)) < np.log(alike)).all(axis=0)]
    low, high = np.quantile(light if len(light) else few.brighter, [tail, 1.0 - tail])
    return float(low / high)


def _measure_motion(rest: ImageSeries, significant: float) -> dict[str, float]:
    """Noise and motion of the markers at rest, px, and the change of sharpness."""
    motion, noise = rest.motion
    count, time = len(motion), np.linspace(-0.5, 0.5, len(motion))
    if count < 2:
        return {"noise_px": float(np.median(rest.figures[0].blobs.sigma_px))}
    trend = time @ motion[:, :3] / (time @ time)
    left = motion[:, :3] - motion[:, :3].mean(axis=0) - time[:, None] * trend
    error = np.sqrt((left**2).sum() / max(count - 2, 1) / (time @ time))
    size = float(np.linalg.norm(trend))
    return {
        "noise_px": noise,
        "vibration_px": float(np.sqrt(0.5 * (np.diff(motion[:, :2], axis=0) ** 2).mean())),
        "drift_px": size if size > significant * error else 0.0,
        "magnification_px": float(np.ptp(_smooth(motion[:, 3]))),
        "sharpness": float(np.ptp(_smooth(rest.edge_px)) / rest.edge_px.mean()),
    }


def _measure_colours(rest: ImageSeries, press: ImageSeries) -> dict[str, float]:
    """Changes of light and of colours, between images at rest and by a press."""
    light = rest.brightness
    values = {"brightness": float(np.ptp(light, axis=0).min())} if len(light) > 1 else {}
    colours = [float(np.ptp(light / light.mean(axis=1, keepdims=True), axis=0).max())]
    ratios = [rest.light_ratio(one) for one in press.figures]
    if ratios:
        values["auto_exposure"] = max(min(map(_common, ratio.T)) for ratio in ratios)
        colours += [_common(column) for one in ratios for column in (one / one.mean(axis=1, keepdims=True)).T]
    return values | ({"white_balance": max(colours)} if colours and light.shape[1] > 1 else {})


def _measure_rate(times: FloatArray) -> dict[str, float]:
    """Missing images and irregular intervals, by times (n,) s; empty for fewer than 3 times."""
    intervals = np.diff(times)
    if len(intervals) < 2 or not np.median(intervals) > 0.0:
        return {}
    intervals = intervals / np.median(intervals)
    missing = float(np.maximum(np.rint(intervals) - 1.0, 0.0).sum())
    uneven = float((intervals - np.rint(intervals)).std())
    return {"dropped": missing / (missing + len(times)), "irregular": uneven}


def _common(ratio: FloatArray) -> float:
    """Return the change of 90 % of ratios (n,): the smaller distance of their deciles from 1."""
    low, high = np.quantile(ratio, [0.1, 0.9]) - 1.0
    return float(min(abs(low), abs(high))) if low * high > 0.0 else 0.0


def _smooth(series: FloatArray, parts: int = 6) -> FloatArray:
    """Return the means of consecutive parts of a series (k,), which have less noise than its values."""
    return np.array([part.mean() for part in np.array_split(series, min(parts, len(series)))])
