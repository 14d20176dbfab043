"""Skins of revolution from a drawn meridian: a table, a DXF drawing of the section, or a STEP body."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError
from scipy.interpolate import CubicSpline
from scipy.spatial import cKDTree

from palpate.core import FloatArray, PalpateError, load_extra
from palpate.core.run import LocalWorkers, Outcome, Progress, Status
from palpate.core.tables import named_table
from palpate.core.units import split_unit
from palpate.design.drawing_points import dxf_entities
from palpate.design.points_file import MM
from palpate.design.spec import SkinSpec
from palpate.design.spline import Spline, SplineSpec

_RADIAL, _AXIAL = ("r", "rho", "radius", "x"), ("z", "height", "y")
"""Names of the columns of a table: distance from the axis, height."""
_CLOSE, _LOOSE = 0.01, 0.05
"""Deviation from the drawing, mm, that is aimed at, and from which a skin is rejected. By hand."""
_FAR = 1e5
"""Distance from the origin, mm, from which a point is a wrong number; its curve would fill the memory."""
_FLATTENING, _JOIN, _SPACING = 0.002, 0.01, 0.02
"""Chord error of arcs, largest gap between curves, distance of compared points, mm. By hand."""
_MOST_POINTS = 16
"""Maximum number of points of a meridian. By hand."""
_UNEVEN = 0.1
"""Largest deviation of the drawn thickness from one with a taper, mm. By hand."""
_CORNER = np.radians(25.0)
"""Change of direction from which two segments of a curve meet in a corner."""
_STEP_POINTS, _TABLE_POINTS = 400, 2000
"""Number of points that replace an edge of a STEP body, and the smooth curve of a table. By hand."""


@dataclass(frozen=True, eq=False)
class Profile:
    """A drawn meridian, and the skin that follows it.

    Attributes
    ----------
    inner, outer
        (n, 2) mm distance from the axis and height above the base, from the apex to the rim; `outer` is empty if one
        curve was drawn.
    spec
        Skin.
    deviation_mm, thickness_deviation_mm
        Maximum distance between drawing and skin, of the inner surface and of the thickness.
    """

    inner: FloatArray
    outer: FloatArray
    spec: SplineSpec
    deviation_mm: float
    thickness_deviation_mm: float = 0.0


def read_profile(path: Path, thickness: float = 2.0) -> Profile:
    """Read the meridian of a skin, and find the skin that follows it.

    A table has columns of the distance from the axis and of the height (``r_mm, z_mm``), from apex to rim or back. A
    DXF drawing has the axis of the skin at x = 0 and its height along y. It contains the inner curve, or the inner
    and the outer curve, which decide `thickness` (mm) and taper. A base line is left out. A STEP body is cut through
    its axis.

    Raises
    ------
    MissingExtraError
        If ezdxf or build123d is not installed.
    PalpateError
        If the file has no such curve, or no smooth skin follows it within 0.05 mm.
    """
    if not path.is_file():
        raise PalpateError(f"{path} does not exist.", "Give the file of a profile.", code="file-missing")
    kind = path.suffix.lower()
    curves = (
        _step_curves(path) if kind in (".step", ".stp") else _dxf_curves(path) if kind == ".dxf" else _table(path)
    )
    inner, *more = _chains(path, [_near(path, curve) for curve in curves])
    outer = more[0] if more else np.empty((0, 2))
    spec, deviation, at = _follow(path, inner, thickness)
    if deviation > _LOOSE:
        raise _no_skin(
            path, f"The nearest smooth skin deviates by {deviation:.2g} mm at r = {at[0]:.3g} mm, z = {at[1]:.3g} mm"
        )
    if not len(outer):
        return Profile(inner, outer, spec, deviation)
    spec, uneven = _thicken(path, spec, outer)
    return Profile(inner, outer, spec, deviation, uneven)


def profile_data(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the plain values of the skin that follows the `file` of a profile, with its `thickness`.

    Raises
    ------
    PalpateError
        As `read_profile`, or if the data have no file.
    """
    if not isinstance(data.get("file"), str | Path):
        raise PalpateError(
            f"The skin {dict(data)} has no file.", "Write profile:file=NAME.dxf.", code="parameter-missing"
        )
    if more := set(data) - {"kind", "file", *SkinSpec.model_fields}:
        raise PalpateError(
            f"The skin 'profile' has no parameter '{min(more)}'.",
            "It has file and thickness.",
            code="parameter-unknown",
        )
    try:
        thickness = float(data.get("thickness", 2.0))
    except ValueError as error:
        raise PalpateError(
            f"The thickness '{data['thickness']}' is not a number.",
            "Give mm, such as 2.",
            code="thickness-not-number",
        ) from error
    return read_profile(Path(data["file"]), thickness).spec.build().spec_data


def _no_skin(path: Path, reason: str) -> PalpateError:
    return PalpateError(
        f"{path}: {reason}.",
        "Draw a smooth curve that is level at the axis and ends on the base.",
        code="profile-not-smooth",
    )


def _table(path: Path) -> list[FloatArray]:
    table, found = named_table(path), {}
    for at, name in enumerate(table.header):
        axis, unit = split_unit(name.lower())[0], table.unit(at).lower()
        part = "r" if axis in _RADIAL else "z" if axis in _AXIAL else ""
        if not part or part in found:
            continue
        if unit not in MM or not table.is_numeric(at) or not np.isfinite(table.numbers(at)).all():
            raise PalpateError(
                f"{path}: column {name} is not a length.",
                f"Write numbers under r_mm,z_mm; units are {', '.join(MM)}.",
                code="columns-wrong",
            )
        found[part] = MM[unit] * table.numbers(at)
    if len(found) < 2:
        raise PalpateError(
            f"{path} has the columns {', '.join(table.header)}.", "Write r_mm,z_mm.", code="columns-wrong"
        )
    points = _near(path, np.column_stack([found["r"], found["z"]]))
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if len(points) < 4 or steps.min() <= 0:
        raise PalpateError(
            f"{path} has {len(points)} points, the nearest {steps.min(initial=0.0):.3g} mm apart.",
            "Give 4 or more different points in the order of the meridian.",
            code="profile-few-points",
        )
    along = np.concatenate([[0.0], np.cumsum(steps)])
    fine = np.linspace(0.0, along[-1], _TABLE_POINTS)
    return [np.asarray(CubicSpline(along, points)(fine))]


def _near(path: Path, points: FloatArray) -> FloatArray:
    """The points, after a check that they are near enough to the origin to belong to a skin."""
    if (far := float(np.abs(points).max())) >= _FAR:
        raise PalpateError(
            f"{path} has a point {far:.3g} mm from the origin.", "Correct the number or its unit.", code="profile-far"
        )
    return points


def _dxf_curves(path: Path) -> list[FloatArray]:
    ezdxf, (entities, scale) = load_extra("ezdxf", "cad"), dxf_entities(path)
    from ezdxf import path as paths

    curves = []
    for entity in entities:
        try:
            points = list(paths.make_path(entity).flattening(_FLATTENING / scale))
        except (TypeError, ValueError, ezdxf.DXFError):  # texts, dimensions and hatches are no curves
            continue
        if len(points) > 1:
            curves.append(scale * np.array([(point.x, point.y) for point in points]))
    return curves


def _step_curves(path: Path) -> list[FloatArray]:
    """Cut a STEP body in a separate process, which a damaged file can end (segmentation fault)."""
    load_extra("build123d", "cad")
    with LocalWorkers(1) as pool:
        pool.submit(_cut_step, path)
        outcomes: list[Outcome] = []
        while not outcomes:
            outcomes = [outcome for _, outcome in pool.wait(1.0)]
    if outcomes[0].status is Status.DONE:
        return list(outcomes[0].value)
    raise outcomes[0].error or PalpateError(
        f"{path} ends the CAD kernel: {outcomes[0].reason}.", "Export the body again.", code="drawing-broken"
    )


def _cut_step(path: Path, _progress: Progress) -> list[FloatArray]:
    """Edges of the section through the axis of revolution, about which the body's box is square."""
    cad = load_extra("build123d", "cad")
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Section
    from OCP.gp import gp_Dir, gp_Pln, gp_Pnt

    try:
        box = (shape := cad.import_step(str(path))).bounding_box()
    except Exception:  # the kernel's errors of a damaged file are of every kind
        box = None
    if box is None or not box.diagonal > 0.0:
        raise PalpateError(f"{path} has no STEP body that can be read.", "Export it again.", code="drawing-broken")
    sizes, middle = np.array(tuple(box.size)), np.array(tuple(box.center()))
    for axis in (2, 1, 0):
        across, aside = [number for number in range(3) if number != axis]
        if abs(sizes[across] - sizes[aside]) < 1e-3 * sizes[across]:
            break
    else:
        raise PalpateError(
            f"{path} is {' x '.join(f'{size:.4g}' for size in sizes)} mm: not a body of revolution about x, y or z.",
            "Export the whole body, revolved by 360°.",
            code="profile-not-revolved",
        )
    normal = gp_Dir(*(1.0 if number == aside else 0.0 for number in range(3)))
    cut = BRepAlgoAPI_Section(shape.wrapped, gp_Pln(gp_Pnt(*middle), normal))
    curves = []
    for edge in cad.Shape.cast(cut.Shape()).edges():
        points = np.array([tuple(point) for point in edge.positions(np.linspace(0.0, 1.0, _STEP_POINTS))])
        curves.append(np.column_stack([points[:, across] - middle[across], points[:, axis]]))
    return curves


def _chains(path: Path, curves: list[FloatArray]) -> list[FloatArray]:
    """Inner and, if drawn, outer curve (n, 2), from the apex to the base, which is moved to height 0."""
    pieces = [piece for curve in curves for piece in _one_side(curve)]
    pieces = [piece for piece in pieces if piece[:, 0].max() > _JOIN]
    if not pieces:
        raise PalpateError(
            f"{path} has no curve apart from the axis.", "Draw the profile at x > 0.", code="drawing-empty"
        )
    every = np.vstack(pieces)
    near = every[:, 0] < _JOIN
    if not near.any():
        raise PalpateError(
            f"{path}: the profile reaches the axis only to r = {every[:, 0].min():.3g} mm.",
            "Draw it from the axis (x = 0) to the base.",
            code="profile-open",
        )
    apex, low, high = every[near, 1].mean(), every[:, 1].min(), every[:, 1].max()
    sign, base = (1.0, low) if apex - low >= high - apex else (-1.0, high)
    segments = []
    for piece in pieces:
        piece = np.column_stack([piece[:, 0], sign * (piece[:, 1] - base)])
        level, upright = (piece[:, axis] < _JOIN for axis in (1, 0))
        drawn = ~((level[1:] & level[:-1]) | (upright[1:] & upright[:-1]))  # base line and axis are no surface
        for run in np.split(np.arange(len(drawn)), np.flatnonzero(np.diff(drawn)) + 1):
            if len(run) and drawn[run[0]]:
                segments.append(piece[run[0] : run[-1] + 2])
    chains = [part for chain in _join(segments) for part in _split_at_rim(chain)]
    whole = [one if one[0, 0] < one[-1, 0] else one[::-1] for one in chains]
    whole = sorted((one for one in whole if one[0, 0] < _JOIN), key=lambda one: float(one[0, 1]))
    if len(whole) not in (1, 2) or len(whole) != len(chains) or whole[0][-1, 1] > _JOIN:
        raise PalpateError(
            f"{path} has {len(chains)} curves, {len(whole)} of them from the axis; the first ends "
            f"{whole[0][-1, 1] if whole else np.nan:.3g} mm above the base.",
            "Draw the inner curve, or the inner and the outer curve, from the axis to the base, and nothing else.",
            code="profile-curves",
        )
    return [whole[0], *(_to_corner(one) for one in whole[1:])]


def _split_at_rim(chain: FloatArray) -> list[FloatArray]:
    """A curve, or both parts of one that begins and ends at the axis, as the outline of a section does."""
    if max(chain[0, 0], chain[-1, 0]) > _JOIN:
        return [chain]
    rim = int(np.argmin(chain[:, 1] + 1e-9 * chain[:, 0]))
    return [chain[: rim + 1], chain[rim:]]


def _to_corner(curve: FloatArray) -> FloatArray:
    """A curve up to its first corner, beyond which the flange or the face of the rim begins."""
    ways = np.diff(curve, axis=0)
    turn = np.abs(np.diff(np.unwrap(np.arctan2(ways[:, 1], ways[:, 0]))))
    corners = np.flatnonzero(turn > _CORNER)
    return curve[: corners[0] + 2] if len(corners) else curve


def _one_side(curve: FloatArray) -> list[FloatArray]:
    """Parts (n, 2) of a curve at x ≥ 0; of a curve at x ≤ 0 its mirror image."""
    if curve[:, 0].max() < _JOIN:
        curve = curve * [-1.0, 1.0]
    cross = np.flatnonzero((curve[:-1, 0] * curve[1:, 0]) < 0)
    share = curve[cross, 0] / (curve[cross, 0] - curve[cross + 1, 0])
    on_axis = curve[cross] + share[:, None] * (curve[cross + 1] - curve[cross])
    curve = np.insert(curve, cross + 1, np.column_stack([np.zeros(len(cross)), on_axis[:, 1]]), axis=0)
    right = curve[:, 0] >= -1e-9
    runs = np.split(np.arange(len(curve)), np.flatnonzero(np.diff(right)) + 1)
    return [np.maximum(curve[run], [0.0, -np.inf]) for run in runs if right[run[0]] and len(run) > 1]


def _join(pieces: list[FloatArray]) -> list[FloatArray]:
    """Join curves whose ends meet apart from the axis; both halves of a mirrored section count once."""
    left: list[FloatArray] = []
    for piece in pieces:
        if not any(max(_apart(one, piece), _apart(piece, one)) < _JOIN for one in left):
            left.append(piece)
    chains = []
    while left:
        chain, grown = left.pop(0), True
        while grown:
            grown = False
            for number, other in enumerate(left):
                for first, second in product((chain, chain[::-1]), (other, other[::-1])):
                    if first[-1, 0] >= _JOIN and np.linalg.norm(first[-1] - second[0]) < _JOIN:
                        chain, grown = np.vstack([first, second[1:]]), True
                        break
                if grown:
                    del left[number]
                    break
        chains.append(chain)
    return chains


def _dense(curve: FloatArray) -> FloatArray:
    """Points at most `_SPACING` apart on a polyline."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))])
    at = np.linspace(0.0, along[-1], int(along[-1] / _SPACING) + 2)
    return np.column_stack([np.interp(at, along, curve[:, axis]) for axis in (0, 1)])


def _apart(one: FloatArray, other: FloatArray) -> float:
    return float(cKDTree(_dense(one)).query(_dense(other))[0].max())


def _follow(path: Path, inner: FloatArray, thickness: float) -> tuple[SplineSpec, float, FloatArray]:
    """Return the skin of fewest points that follows a curve (n, 2), its deviation, mm, and where."""
    dense, tree = _dense(inner), cKDTree(_dense(inner))
    height, radius = round(float(inner[0, 1]), 4), round(float(inner[-1, 0]), 4)
    best: tuple[SplineSpec, float, FloatArray] | None = None
    for count in range(1, _MOST_POINTS + 1):
        chosen = dense[np.linspace(0, len(dense) - 1, count + 2).round().astype(int)[1:-1]] / [radius, height]
        points = tuple((round(float(rho), 6), round(float(z), 6)) for rho, z in chosen)
        spec = _spec(path, {"height": height, "base_radius": radius, "thickness": thickness, "points": points})
        smooth = _dense(Spline(height, radius, thickness, points).curve(np.linspace(0.0, 1.0, len(dense))))
        back, there = tree.query(smooth)[0], cKDTree(smooth).query(dense)[0]
        at = smooth[int(np.argmax(back))] if back.max() > there.max() else dense[int(np.argmax(there))]
        deviation = float(max(back.max(), there.max()))
        if best is None or deviation < best[1]:
            best = spec, deviation, at
        if deviation <= _CLOSE:
            break
    assert best is not None
    return best


def _spec(path: Path, values: Mapping[str, Any]) -> SplineSpec:
    try:
        return SplineSpec(**values)
    except ValidationError as error:
        wrong = error.errors()[0]
        raise PalpateError(
            f"{path}: {'.'.join(map(str, wrong['loc'][:1]))} {wrong['input']} is out of bounds: {wrong['msg']}.",
            "Check the unit of the drawing, and the thickness in mm.",
            code="profile-size",
        ) from error


def _thicken(path: Path, spec: SplineSpec, outer: FloatArray) -> tuple[SplineSpec, float]:
    """Return the skin with thickness and taper of a drawn outer curve, and their deviation, mm."""
    skin = Spline(spec.height, spec.base_radius, spec.thickness, spec.points)
    t = np.linspace(0.0, 1.0, 4001)
    apart, nearest = cKDTree(skin.curve(t)).query(_dense(outer))
    inside = nearest < len(t) - 1
    square = t[nearest[inside]] ** 2
    apex, slope = np.linalg.lstsq(np.column_stack([np.ones_like(square), square]), apart[inside], rcond=None)[0]
    uneven = float(np.abs(apex + slope * square - apart[inside]).max())
    taper = float(1.0 + slope / apex)
    taper = 1.0 if abs(taper - 1.0) * apex < _CLOSE else taper
    if uneven > _UNEVEN:
        raise PalpateError(
            f"{path}: the drawn thickness deviates by {uneven:.2g} mm from one that changes evenly from apex to rim.",
            "Draw the inner curve alone and give the thickness.",
            code="profile-thickness",
        )
    return _spec(path, {**spec.model_dump(), "thickness": round(float(apex), 3), "taper": round(taper, 3)}), uneven
