"""Centres of the circles of a drawing: DXF by its unit, SVG by the size of its page."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from palpate.core import BoolArray, FloatArray, PalpateError, load_extra

DRAWINGS = (".dxf", ".svg")
"""Endings of the files that are read as drawings."""
_MM = {"mm": 1.0, "cm": 10.0, "in": 25.4, "pt": 25.4 / 72, "pc": 25.4 / 6, "px": 25.4 / 96, "": 25.4 / 96, "q": 0.25}
"""Length of each unit of SVG in mm (CSS Values and Units 3)."""
_OUTLINE = 3.0
"""Circles larger than the median by this factor are outlines, not markers. By hand."""
_SAME_MM = 0.05
"""Distance below which two centres are one marker, drawn twice. By hand."""
_EVEN = 0.12
"""Range of distances from the middle over those of an ellipse; octagon 0.08, hexagon 0.13. By hand."""
_SAMPLES = 8
"""Points of each segment of a curve: a circle of four segments is 0.6 % too small."""


def read_circles(path: Path) -> FloatArray:
    """Read the centres (n, 2) mm of the circles of a drawing, by distance from the axis, then by azimuth.

    In a drawing without circles, ellipses count, also as closed paths, polylines and splines, into which programs
    convert circles.

    The axis of the skin is the origin of a DXF file and the middle of the page of an SVG file, whose y axis is turned
    upward. Circles larger than three times the median are outlines and left out. Points count if there is no circle.

    Raises
    ------
    MissingExtraError
        If ezdxf is not installed.
    PalpateError
        If the file is not such a drawing, has no unit, or has no circle.
    """
    if not path.is_file():
        raise PalpateError(f"{path} does not exist.", "Give the file of a layout.", code="file-missing")
    try:
        rows = list(_dxf_circles(path) if path.suffix.lower() == ".dxf" else _svg_circles(path))
    except PalpateError:
        raise
    except Exception as error:  # a damaged drawing ends the parsers by errors of every kind
        raise _broken(path, error) from error
    if not rows:
        raise PalpateError(
            f"{path} has no circle.", "Draw each marker as a circle or an ellipse.", code="drawing-empty"
        )
    from scipy.spatial import cKDTree  # here, because scipy is slow to load

    circles = np.array(rows, float)
    if not (np.abs(circles) < 1e6).all():
        raise _broken(path, ValueError("a circle lies over a kilometre away, or its place or size is no number"))
    sizes = circles[:, 2]
    centres = circles[sizes <= _OUTLINE * np.median(sizes), :2]
    centres = np.delete(centres, cKDTree(centres).query_pairs(_SAME_MM, output_type="ndarray")[:, 1], axis=0)
    x, y = np.round(centres, 3).T
    radius = np.round(np.hypot(x, y), 3)
    azimuth = np.where(radius > 0, np.mod(np.arctan2(y, x), 2 * np.pi), 0.0)
    return np.asarray(centres[np.lexsort((np.round(azimuth, 6), radius))])


def _broken(path: Path, error: Exception) -> PalpateError:
    return PalpateError(
        f"{path} cannot be read as a drawing ({error}).", "Export the drawing again.", code="drawing-broken"
    )


def dxf_entities(path: Path) -> tuple[list[Any], float]:
    """Return the visible entities of a DXF file, also of inserted blocks, and its unit in mm.

    Raises
    ------
    MissingExtraError
        If ezdxf is not installed.
    PalpateError
        If the file cannot be read or has no unit.
    """
    ezdxf = load_extra("ezdxf", "cad")
    try:
        document = ezdxf.readfile(path)
        entities = [one for inserted in document.modelspace() for one in _visible(document, inserted)]
    except Exception as error:  # as above
        raise _broken(path, error) from error
    unit = document.units or (4 if document.header.get("$MEASUREMENT", 0) == 1 else 0)
    if not unit:
        raise PalpateError(
            f"{path} has no unit ($INSUNITS is 0).", "Set the unit of the drawing, such as mm.", code="drawing-unit"
        )
    return entities, float(ezdxf.units.conversion_factor(unit, ezdxf.units.MM))


def _dxf_circles(path: Path) -> Iterator[tuple[float, float, float]]:
    """Centre and radius of circles, mm; without circles of points, else of curves that are ellipses."""
    entities, scale = dxf_entities(path)
    found = [(*one.dxf.center.vec2, one.dxf.radius) for one in entities if one.dxftype() == "CIRCLE"]
    found = found or [(*one.dxf.location.vec2, 0.0) for one in entities if one.dxftype() == "POINT"]
    for x, y, radius in found or _dxf_curves(entities):
        yield scale * x, scale * y, scale * radius


def _dxf_curves(entities: list[Any]) -> Iterator[tuple[float, float, float]]:
    """Centre and mean radius of ellipses, of curves like them, and of arcs that are whole circles."""
    paths = load_extra("ezdxf.path", "cad")
    arcs: dict[tuple[float, ...], BoolArray] = {}
    for one in entities:
        if one.dxftype() == "ARC":
            centre = one.ocs().to_wcs(one.dxf.center)
            key = (*np.round([centre.x, centre.y, one.dxf.radius], 5).tolist(),)
            along = (np.arange(360) + 0.5 - one.dxf.start_angle) % 360.0 < (
                one.dxf.end_angle - one.dxf.start_angle
            ) % 360.0
            arcs[key] = arcs.get(key, np.zeros(360, bool)) | along
        elif one.dxftype() in ("ELLIPSE", "LWPOLYLINE", "POLYLINE", "SPLINE"):
            try:
                curve = paths.make_path(one)
            except (TypeError, ValueError, ArithmeticError, LookupError):
                continue  # a mesh, or a spline without points
            if curve.is_closed:
                yield from _ellipse(np.array([[*point.vec2] for point in curve.flattening(1.0, _SAMPLES)]))
    yield from ((x, y, radius) for (x, y, radius), covered in arcs.items() if covered.all())


def _ellipse(points: FloatArray) -> list[tuple[float, float, float]]:
    """Centre and mean radius of a closed curve through points (n, 2); empty for other shapes."""
    middle = points.mean(axis=0) if len(points) > 4 else np.zeros(2)
    here = points - middle
    there = np.roll(here, -1, axis=0)
    cross = here[:, 0] * there[:, 1] - here[:, 1] * there[:, 0]
    area = float(cross.sum()) / 2
    if len(points) <= 4 or area == 0:
        return []
    centre = ((here + there) * cross[:, None]).sum(axis=0) / (6 * area)
    pairs = here[:, :, None] * here[:, None] + (here + there)[:, :, None] * (here + there)[:, None]
    pairs += there[:, :, None] * there[:, None]
    moments = (pairs * cross[:, None, None]).sum(axis=0) / (24 * area) - np.outer(centre, centre)
    out = np.concatenate([here, (here + there) / 2]) - centre
    size = 0.5 * np.sqrt(np.maximum((out @ np.linalg.pinv(moments) * out).sum(axis=1), 0.0))
    x, y = (middle + centre).tolist()
    return [(x, y, float(np.sqrt(abs(area) / np.pi)))] if np.ptp(size) < _EVEN else []


def _visible(document: Any, entity: Any) -> Iterator[Any]:
    """Entities of a block, or the entity itself, on layers that are on."""
    name = entity.dxf.layer
    if name in document.layers and (document.layers.get(name).is_off() or document.layers.get(name).is_frozen()):
        return
    if entity.dxftype() == "INSERT":
        for inserted in entity.virtual_entities():
            yield from _visible(document, inserted)
    else:
        yield entity


def _svg_circles(path: Path) -> Iterator[tuple[float, float, float]]:
    """Centre and radius of circles and ellipses, mm, about the middle of the page with y upward."""
    root = ElementTree.parse(path).getroot()
    box = [float(value) for value in re.findall(r"[-+.\deE]+", root.get("viewBox", ""))]
    width, height = (_length(path, root.get(name)) for name in ("width", "height"))
    if len(box) != 4 or box[2] <= 0 or box[3] <= 0:
        if width is None or height is None:
            raise PalpateError(
                f"{path} has neither a size nor a viewBox.",
                "Set the page size, such as width='40mm'.",
                code="drawing-unit",
            )
        box = [0.0, 0.0, width / _MM["px"], height / _MM["px"]]
    scale = (width or (height or 0.0) * box[2] / box[3]) / box[2] or _MM["px"]
    page = np.array(
        [[scale, 0, -scale * (box[0] + box[2] / 2)], [0, -scale, scale * (box[1] + box[3] / 2)], [0, 0, 1]]
    )
    yield from [*_svg_children(path, root, page, paths=False)] or _svg_children(path, root, page, paths=True)


def _svg_children(
    path: Path, node: ElementTree.Element, matrix: FloatArray, paths: bool
) -> Iterator[tuple[float, float, float]]:
    """Centre and radius, mm, of circles and ellipses below a node; with `paths`, of such paths too."""
    for child in node:
        kind = str(child.tag).rpartition("}")[2]
        style = "".join(re.findall(r"display\s*:\s*(none)", child.get("style", "")))
        if kind in ("defs", "clipPath", "mask", "symbol", "marker") or "none" in (child.get("display"), style):
            continue
        own = matrix @ _transform(child.get("transform", ""))
        if kind in ("circle", "ellipse"):
            values = (child.get("cx", "0"), child.get("cy", "0"), child.get("r", child.get("rx", "0")))
            x, y, size = ((_length(path, value) or 0.0) / _MM["px"] for value in values)
            x, y, _ = own @ [x, y, 1.0] if np.isfinite(x + y) else (x, y, 1.0)
            if size > 0.0:  # SVG draws no other
                yield float(x), float(y), size * float(np.sqrt(abs(np.linalg.det(own[:2, :2]))))
        elif paths and kind == "path" and "z" in child.get("d", "").lower():
            curves = load_extra("svgelements", "cad").Path(child.get("d")).as_subpaths()
            for curve in curves:
                parts = [part for part in curve if type(part).__name__ not in ("Move", "Close")]
                along = np.arange(_SAMPLES) / _SAMPLES
                points = np.array([[*part.point(t)] for part in parts for t in along]).reshape(-1, 2)
                yield from _ellipse(points @ own[:2, :2].T + own[:2, 2])
        yield from _svg_children(path, child, own, paths)


def _length(path: Path, text: str | None) -> float | None:
    """Length in mm; `None` if absent or relative."""
    found = re.fullmatch(r"\s*([-+]?(?i:nan|inf)|[-+.\deE]+?)\s*([a-zA-Z]*|%)\s*", text or "")
    if found is None or found[2] == "%":
        return None
    if found[2].lower() not in _MM:
        raise PalpateError(
            f"{path} has the length '{text}'.", f"Units are {', '.join(filter(None, _MM))}.", code="drawing-unit"
        )
    return float(found[1]) * _MM[found[2].lower()]


def _transform(text: str) -> FloatArray:
    """Matrix (3, 3) of the attribute `transform` (SVG 1.1, section 7.6)."""
    whole = np.eye(3)
    for name, inside in re.findall(r"(\w+)\s*\(([^)]*)\)", text):
        values = [float(value) for value in re.findall(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?", inside)]
        step = np.eye(3)
        if name == "translate":
            step[:2, 2] = [*values, 0.0][:2]
        elif name == "scale":
            step[0, 0], step[1, 1] = values[0], values[-1]
        elif name == "matrix":
            step[:2] = np.reshape(values, (3, 2)).T
        elif name == "rotate":
            angle, about = np.radians(values[0]), np.array([*values[1:], 0.0, 0.0][:2])
            step[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
            step[:2, 2] = about - step[:2, :2] @ about
        elif name in ("skewX", "skewY"):
            step[(0, 1) if name == "skewX" else (1, 0)] = np.tan(np.radians(values[0]))
        whole = whole @ step
    return whole
