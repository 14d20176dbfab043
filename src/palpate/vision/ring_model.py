"""Ring model of a print in the image: radii and centres of its rings, and extrapolation.

A ring of radius ρ on the skin is imaged at the scale g(ρ) = r/ρ of the nominal camera, which depends on its height.
An offset of the camera from the axis moves a ring's centre in proportion to its scale: c = a + b g. A distorted print
has other radii than the design; they are determined from the same profile.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray

_EVEN = 0.07
"""Maximum residual of a ring's blobs over the distance of neighbours. By hand."""
_PRIOR = 2.0
"""Weight of the prior scatter of centres, in rings. By hand."""
_FLAT = 1e-6
"""Difference of height over the radius below which a skin is flat."""
_BEYOND = 1.3
"""Extent of the profile, over the outermost known radius. By hand."""
_ASIDE_MM = 4.0
"""Standard deviation of the camera's offset from the axis, in each direction. By hand."""
_LEAST_OFF_PX, _OFF, BENT = 0.1, 3.0, 0.08
"""Standard deviation of ring centres about their line: minimum (px), and slope.

The slope is in mm per relative error of the radii, which is limited to the last value. By hand.
"""
_RIM = 0.98
"""Maximum radius of a print, over that of the meridian. By hand."""
_STEP = 0.05
"""Half the difference of radii for the slope of the profile, mm. By hand."""
_ZOOM_SHARE = 0.2
"""Share of a common growth of all rings that is attributed to the camera.

Its distance is known to 4 %, a print's size to 8 %. By hand.
"""
_ZOOM_SD = 0.035
"""Standard deviation of the remaining zoom error. By hand."""
_NESTED = 0.7
"""Distance of ring centres over that of their radii, at which they count as crossing. By hand."""
TWIST, _TWIST_POWER = 0.25, 20.0
"""Maximum rotation between neighbouring rings over the marker step; penalty of a step, powers of ten.
By hand."""


@dataclass(frozen=True, eq=False)
class RingFit:
    """One ring of markers.

    Attributes
    ----------
    weights
        (7, 2) coefficients of `ring_harmonics`, px.
    blob, error_px
        (n,) blob of each of its markers, -1 without one, and its distance from the ring, NaN without one.
    power
        Log10 of the number of false alarms: expected number of such rings among as many random blobs in one place.
    """

    weights: FloatArray
    blob: NDArray[np.intp]
    error_px: FloatArray

    power: float = 0.0

    @property
    def count(self) -> int:
        """Number of its blobs."""
        return int((self.blob >= 0).sum())

    @property
    def share(self) -> float:
        """Share of its markers with a blob."""
        return float(np.mean(self.blob >= 0))

    @property
    def residual_px(self) -> float:
        """Root mean square distance of its blobs from it; infinite without a blob."""
        off = self.error_px[np.isfinite(self.error_px)]
        return float(np.sqrt(np.mean(off**2))) if len(off) else np.inf

    @property
    def even(self) -> bool:
        """Whether the residual is small enough for a print."""
        return self.residual_px < _EVEN * 2.0 * np.pi * self.radius_px / len(self.blob)

    @property
    def turn(self) -> float:
        """Angle from the image's first axis to azimuth 0, by the nearest rotation of its shape."""
        left, _, right = np.linalg.svd(self.weights[1:3])
        turn = left @ right
        return float(np.arctan2(turn[0, 1], turn[0, 0]))

    @property
    def radius_px(self) -> float:
        """Mean of its half axes."""
        return float(np.linalg.svd(self.weights[1:3], compute_uv=False).mean())


@dataclass(frozen=True, eq=False)
class RingsFit:
    """Rings found from one seed, from the inside; the first is the centre marker."""

    rings: tuple[RingFit, ...]

    @property
    def count(self) -> int:
        """Number of blobs."""
        return int(sum((ring.blob >= 0).sum() for ring in self.rings))

    @property
    def power(self) -> float:
        """Log10 of the number of false alarms of the print, around one centre."""
        return float(sum(ring.power for ring in self.rings)) + _TWIST_POWER * float((self.twist**2).sum())

    @property
    def twist(self) -> FloatArray:
        """Rotation (k - 1,) of each ring against the one inside, over the step of its markers."""
        turns = np.array([ring.turn for ring in self.rings[1:]])
        steps = np.array([2.0 * np.pi / len(ring.blob) for ring in self.rings[2:]])
        return np.asarray(((np.diff(turns) + np.pi) % (2.0 * np.pi) - np.pi) / steps)

    @property
    def even(self) -> bool:
        """Whether all rings are even, equally rotated and nested."""
        turned_alike = not (np.abs(self.twist) > TWIST).any()
        return turned_alike and not self.crossing and all(ring.even for ring in self.rings[1:])

    @property
    def crossing(self) -> int:
        """Number of the first ring too near to the one inside; 0 if all are nested."""
        for number, (ring, outer) in enumerate(pairwise(self.rings[1:]), 2):
            aside = float(np.linalg.norm(outer.weights[0] - ring.weights[0]))
            if aside > _NESTED * (outer.radius_px - ring.radius_px):
                return number
        return 0

    @property
    def residual_px(self) -> float:
        """Root mean square distance of the blobs from their rings, without the centre marker."""
        off = np.concatenate([ring.error_px[np.isfinite(ring.error_px)] for ring in self.rings[1:]])
        return float(np.sqrt(np.mean(off**2))) if len(off) else np.inf


class Profile:
    """Image radius r (px) by ring radius ρ (mm) in the nominal camera, interpolated from known rings.

    The meridian is modelled as a circle about the axis, ρ² + z² = p + q z, and the scale by 1/g = s + t z; the
    deviations of the known rings (k,) from this model are interpolated.
    """

    def __init__(self, rho: FloatArray, height: FloatArray, radius_px: FloatArray) -> None:
        ones = np.ones_like(rho)
        self._circle = np.linalg.lstsq(np.column_stack([ones, height]), rho**2 + height**2, rcond=None)[0]
        self._flat = float(height.mean()) if np.ptp(height) < _FLAT * rho.max() else None
        model = np.column_stack([ones, self._heights(rho)])
        self._factors = np.linalg.lstsq(model, rho / radius_px, rcond=None)[0]
        self._known, self._beside = rho, (radius_px / rho) * (model @ self._factors)
        self._rho = np.linspace(0.0, _BEYOND * float(rho.max()), 400)
        self._px = np.maximum.accumulate(self._rho * self.scale(self._rho))

    @property
    def widest(self) -> float:
        """Maximum radius of the meridian, mm."""
        p, q = self._circle
        reach = _RIM * float(np.sqrt(max(q * q / 4.0 + p, 0.0)))
        return float(self._rho[-1]) if self._flat is not None else max(reach, float(self._known.max()))

    def _heights(self, rho: FloatArray) -> FloatArray:
        """Return the heights of the meridian, mm."""
        if self._flat is not None:
            return np.full_like(rho, self._flat)
        p, q = self._circle
        return np.asarray(q / 2.0 + np.sqrt(np.maximum(q * q / 4.0 + p - rho**2, 0.0)))

    def scale(self, rho: FloatArray | float) -> FloatArray:
        """Return the scale along a ring of this radius (mm), px/mm."""
        rho = np.asarray(rho, float)
        model = self._factors[0] + self._factors[1] * self._heights(rho)
        return np.asarray(np.interp(rho, self._known, self._beside) / model)

    def slope(self, rho: float) -> float:
        """Return the radial scale at this radius (mm), px/mm."""
        ends = np.array([rho - _STEP, rho + _STEP])
        return float(np.diff(ends * self.scale(ends))[0] / (2.0 * _STEP))

    def rho(self, radius_px: FloatArray | float) -> FloatArray:
        """Return the radius (mm) of a ring of this radius in the nominal image, px."""
        return np.asarray(np.interp(radius_px, self._px, self._rho))


@dataclass(frozen=True, eq=False)
class RingModel:
    """Fitted centres and radii of the rings of a print.

    Attributes
    ----------
    profile, zoom
        Profile of the nominal camera, and image scale over that of this camera.
    rho
        (k,) radius of each ring, mm, at the nominal distance: without the common factor of the camera.
    drift, drift_sd
        (2, 2) a in px and b in mm of the centres a + b g, and standard deviation of b, mm.
    left_px
        (k, 2) residuals of the centres.
    """

    profile: Profile
    zoom: float
    rho: FloatArray
    drift: FloatArray
    left_px: FloatArray
    drift_sd: float

    def centre_sd_px(self, expected_px: float) -> float:
        """Return the scatter of the centres, given a prior `expected_px`."""
        free = max(len(self.left_px) - 2, 0)
        square = (self.left_px**2).sum() / 2.0 + _PRIOR * expected_px**2
        return float(np.sqrt(square / (free + _PRIOR)))

    def radius_px(self, of_px: float, growth: float, share: float) -> float:
        """Return the image radius of a ring `growth` times as wide on the skin as one of image radius `of_px`.

        `share` multiplies the zoom.
        """
        zoom = self.zoom * share
        rho = np.minimum(self.profile.rho(of_px / zoom) * growth, self.profile.widest)
        return float(zoom * rho * self.profile.scale(rho))

    def steeper(self, of_px: float, to_px: float) -> float:
        """Return the change of the radial scale (px/mm) from one image radius (px) to another."""
        slopes = [self.profile.slope(float(self.profile.rho(px / self.zoom))) for px in (of_px, to_px)]
        return self.zoom * abs(slopes[1] - slopes[0])

    def centre(self, rho: float) -> FloatArray:
        """Return the centre (2,) of a ring of this radius, mm."""
        return np.asarray(self.drift[0] + self.zoom * self.profile.scale(rho) * self.drift[1])


def fit_ring_model(
    rings: Sequence[RingFit], profile: Profile, nominal_px: FloatArray, design_rho: FloatArray
) -> RingModel:
    """Fit the model to rings, from the innermost, without the centre marker.

    `nominal_px` and `design_rho` are the design's radii (k,) in px of the nominal image and in mm.
    """
    nominal_px, design_rho = nominal_px[: len(rings)], design_rho[: len(rings)]
    radius = np.array([ring.radius_px for ring in rings])
    zoom = 1.0 + _ZOOM_SHARE * (float(np.median(radius / nominal_px)) - 1.0)
    rho = profile.rho(radius / zoom)
    centres = np.stack([ring.weights[0] for ring in rings])
    scale = zoom * profile.scale(rho)
    bent = float(np.abs(rho / design_rho - 1.0).max())
    drift, sd = _drift(centres, scale, np.sqrt(rho / rho.max()), min(bent, BENT) * _OFF)
    left = centres - drift[0] - scale[:, None] * drift[1]
    return RingModel(profile, zoom, rho, drift, left, sd)


def _drift(centres: FloatArray, scale: FloatArray, weight: FloatArray, error_mm: float) -> tuple[FloatArray, float]:
    """Fit the line a + b g to ring centres, with a zero prior on b; return it and b's deviation."""
    middle = float(np.average(scale, weights=weight**2))
    expected = np.hypot(_LEAST_OFF_PX, error_mm * scale.mean())
    sd = expected
    for _ in range(2):
        rows = np.column_stack([weight, weight * (scale - middle)])
        rows = np.vstack([rows, [0.0, sd / _ASIDE_MM]])
        fit = np.linalg.lstsq(rows, np.vstack([weight[:, None] * centres, np.zeros(2)]), rcond=None)[0]
        drift = np.vstack([fit[0] - middle * fit[1], fit[1]])
        left = centres - drift[0] - scale[:, None] * drift[1]
        free = max(len(centres) - 2, 0)
        sd = float(np.sqrt(((left**2).sum() / 2.0 + _PRIOR * expected**2) / (free + _PRIOR)))
    spread = (weight**2 * (scale - middle) ** 2).sum()
    return drift, float(1.0 / np.sqrt(spread / sd**2 + 1.0 / _ASIDE_MM**2))


def extrapolate_ring(law: RingModel, outer: RingFit, design: tuple[float, float]) -> tuple[FloatArray, float, float]:
    """Extrapolate a ring from the outermost one, of radius `design[0]`, to the radius `design[1]`, mm.

    Returns
    -------
    ndarray
        (7, 2) coefficients of `ring_harmonics`, px.
    float
        Standard deviation of its radius by the unknown zoom, px.
    float
        Standard deviation of each coordinate of its centre, px.
    """
    zooms = (1.0, 1.0 - _ZOOM_SD, 1.0 + _ZOOM_SD)
    radii = [law.radius_px(outer.radius_px, design[1] / design[0], share) for share in zooms]
    weights = outer.weights * (radii[0] / outer.radius_px)
    rho = float(law.profile.rho(radii[0] / law.zoom))
    weights[0] = law.centre(rho) + law.left_px[-1]
    aside = law.drift_sd * law.zoom * abs(float(law.profile.scale(rho) - law.profile.scale(float(law.rho[-1]))))
    return weights, max(abs(radius - radii[0]) for radius in radii), aside
