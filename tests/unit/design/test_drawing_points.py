"""Layouts from drawings: circles of DXF by the unit of the file, of SVG by the size of the page."""

from pathlib import Path

import numpy as np
import pytest

from errors import refused
from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers

ezdxf = pytest.importorskip("ezdxf")
SKIN = build_skin(DomeSpec())
LAYOUT = place_markers(SKIN, MarkerSpec(count=37)).positions[:, :2]
SHUFFLED = np.random.default_rng(0).permutation(LAYOUT)


def draw(path: Path, centres: np.ndarray, *, unit: int = 4, radius: float = 0.75, measurement: int = 0) -> Path:
    document = ezdxf.new("R2010", units=unit)
    document.header["$MEASUREMENT"] = measurement
    for x, y in centres:
        document.modelspace().add_circle((x, y), radius)
    document.saveas(path)
    return path


def read(path: Path) -> np.ndarray:
    return place_markers(SKIN, MarkerSpec(file=path)).positions


def same(found: np.ndarray) -> bool:
    """Whether places are those of the layout, in any order, and on the skin."""
    apart = np.linalg.norm(found[:, None, :2] - LAYOUT, axis=2)
    return len(found) == len(LAYOUT) and apart.min(axis=1).max() < 1e-3 and abs(SKIN.distance(found)).max() < 1e-6


@pytest.mark.parametrize(("unit", "mm"), [(4, 1.0), (1, 25.4), (5, 10.0), (6, 1000.0), (13, 1e-3)])
def test_circles_of_dxf_are_read_by_its_unit(tmp_path: Path, unit: int, mm: float) -> None:
    assert same(read(draw(tmp_path / "a.dxf", SHUFFLED / mm, unit=unit, radius=0.75 / mm)))


def test_a_drawing_without_unit_is_metric_or_refused(tmp_path: Path) -> None:
    assert same(read(draw(tmp_path / "metric.dxf", SHUFFLED, unit=0, measurement=1)))
    with refused("drawing-unit", "none.dxf"):
        read(draw(tmp_path / "none.dxf", SHUFFLED, unit=0))


def test_outlines_repeated_circles_and_hidden_layers_are_no_markers(tmp_path: Path) -> None:
    path = draw(tmp_path / "a.DXF", np.vstack([SHUFFLED, SHUFFLED[:5]]))
    document = ezdxf.readfile(path)
    document.modelspace().add_circle((0, 0), 20.0)
    document.layers.add("construction").off()
    document.modelspace().add_circle((1.1, 2.2), 0.75, dxfattribs={"layer": "construction"})
    document.saveas(path)
    assert same(read(path))


def test_circles_of_inserted_blocks_and_single_points_count(tmp_path: Path) -> None:
    document = ezdxf.new("R2010", units=4)
    document.blocks.new("marker").add_circle((0, 0), 0.5)
    for x, y in SHUFFLED:
        document.modelspace().add_blockref("marker", (x, y))
    document.saveas(tmp_path / "blocks.dxf")
    assert same(read(tmp_path / "blocks.dxf"))
    document = ezdxf.new("R2010", units=4)
    for x, y in SHUFFLED:
        document.modelspace().add_point((x, y))
    document.saveas(tmp_path / "points.dxf")
    assert same(read(tmp_path / "points.dxf"))


def svg(path: Path, page: str, body: str) -> Path:
    path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" {page}>{body}</svg>', encoding="utf-8")
    return path


def circles(centres: np.ndarray, scale: float = 1.0, unit: str = "") -> str:
    rows = [(scale * x, scale * y, scale * 0.75) for x, y in centres]
    return "".join(f'<circle cx="{x}{unit}" cy="{y}{unit}" r="{r}{unit}"/>' for x, y, r in rows)


CIRCLES, MOVE, BACK = (
    circles(SHUFFLED),
    "translate(20,20) scale(1,-1)",
    '<g transform="matrix(0 -1 1 0 0 0) scale(1 -1)">',
)


@pytest.mark.parametrize(
    ("page", "body"),
    [
        ('width="40mm" height="40mm" viewBox="0 0 40 40"', circles(SHUFFLED * [1, -1] + 20)),
        ('width="4cm" height="4cm" viewBox="-200 -200 400 400"', circles(SHUFFLED * [1, -1], 10)),
        ('width="40mm" height="40mm" viewBox="0 0 40 40"', f'<g transform="{MOVE}">{CIRCLES}</g>'),
        ('width="40mm" viewBox="-20 -20 40 40"', f'<g transform="rotate(90)">{BACK}{CIRCLES}</g></g>'),
        ('width="30in" height="30in"', circles(SHUFFLED * [1, -1] + 15 * 25.4, unit="mm")),
        ('viewBox="-50 -50 100 100"', circles(SHUFFLED * [1, -1], 96 / 25.4)),
    ],
)  # fmt: skip
def test_circles_of_svg_are_read_about_the_middle_of_the_page(tmp_path: Path, page: str, body: str) -> None:
    hidden = '<defs><circle cx="1" cy="1" r="0.7"/></defs><circle r="19.9" cx="0" cy="0" display="none"/>'
    hidden += '<circle cx="3" cy="3" r="0"/><circle cx="2" cy="2"/>'
    assert same(read(svg(tmp_path / "a.svg", page, hidden + body)))


def test_a_damaged_entity_of_dxf_is_refused(tmp_path: Path) -> None:
    """The parser keeps an entity of an unknown name, without a layer."""
    path = draw(tmp_path / "a.dxf", SHUFFLED)
    path.write_text(path.read_text().replace("\nCIRCLE\n", "\nCnanIRCLE\n", 1))
    with refused("drawing-broken", "a.dxf"):
        read(path)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # as on the command line
@pytest.mark.parametrize(
    ("name", "text", "code"),
    [
        ("a.dxf", "no drawing", "drawing-broken"),
        ("a.svg", "<svg", "drawing-broken"),
        (
            "a.svg",
            '<svg xmlns="http://www.w3.org/2000/svg" width="9mm" height="9mm" viewBox="0 0 9 9">'
            '<circle cx="1e400" cy="2" r="1"/></svg>',
            "drawing-broken",
        ),
        (
            "a.svg",
            '<svg xmlns="http://www.w3.org/2000/svg" width="9mm" height="9mm" viewBox="0 0 9 9">'
            '<circle cx="1e308" cy="2" r="1"/></svg>',
            "drawing-broken",
        ),
        ("a.svg", '<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 0"/></svg>', "drawing-unit"),
        (
            "a.svg",
            '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9"><path d="M0 0"/></svg>',
            "drawing-empty",
        ),
        ("a.svg", '<svg xmlns="http://www.w3.org/2000/svg" width="4em" height="9"/>', "drawing-unit"),
        ("a.svg", '<svg width="9mm" height="9mm"><circle cx="nan" cy="2" r="1"/></svg>', "drawing-broken"),
        ("a.svg", '<svg width="9mm" height="9mm"><circle cx="2" cy="-inf" r="1"/></svg>', "drawing-broken"),
        ("a.svg", '<svg viewBox="0 0 9 9"><g transform="matrix(1 2)"><circle/></g></svg>', "drawing-broken"),
        ("a.svg", '<svg viewBox="a b c d"><circle/></svg>', "drawing-unit"),
    ],
)
def test_what_is_no_layout_is_refused(tmp_path: Path, name: str, text: str, code: str) -> None:
    (tmp_path / name).write_text(text)
    with refused(code, name):
        read(tmp_path / name)


def test_a_missing_drawing_is_refused(tmp_path: Path) -> None:
    with refused("file-missing", "lost.dxf"):
        read(tmp_path / "lost.dxf")


ROUND = np.linspace(0, 2 * np.pi, 25)
RIM = 0.75 * np.column_stack([np.cos(ROUND), np.sin(ROUND)])
CURVES = {
    "ellipse": lambda space, at: space.add_ellipse(at, (0.9, 0), 0.5),
    "polyline of arcs": lambda space, at: space.add_lwpolyline(
        [(at[0] - 0.75, at[1], 0, 0, 1), (at[0] + 0.75, at[1], 0, 0, 1)], close=True
    ),
    "polyline of lines": lambda space, at: space.add_lwpolyline(at + RIM[:-1], close=True),
    "old polyline": lambda space, at: space.add_polyline2d(at + RIM[:-1], close=True),
    "spline": lambda space, at: space.add_spline(np.column_stack([at + RIM, 0 * ROUND])),
    "two arcs": lambda space, at: [space.add_arc(at, 0.75, begin, begin + 180) for begin in (20, 200)],
}


@pytest.mark.parametrize("kind", CURVES)
def test_curves_into_which_programs_convert_circles_are_markers(kind: str, tmp_path: Path) -> None:
    document = ezdxf.new("R2010", units=4)
    space = document.modelspace()
    for at in SHUFFLED:
        CURVES[kind](space, at)
    space.add_lwpolyline([(-0.7, 9.3), (0.7, 9.3), (0.7, 10.7), (-0.7, 10.7)], close=True)  # a square is no marker
    rounded = [(0.3, -0.7), (0.7, -0.3), (0.7, 0.3), (0.3, 0.7), (-0.3, 0.7), (-0.7, 0.3), (-0.7, -0.3), (-0.3, -0.7)]
    space.add_lwpolyline([(x, 12 + y, 0, 0, 0.414 * (k % 2 == 0)) for k, (x, y) in enumerate(rounded)], close=True)
    CURVES[kind](space, SHUFFLED[0] + np.array([0.004, -0.003]))  # the same marker, drawn again
    space.add_arc((1.0, 2.0), 0.7, 0, 180)
    document.saveas(tmp_path / "a.dxf")
    assert same(read(tmp_path / "a.dxf"))


PATHS = {
    "two arcs": "M {left},{y} a .75,.75 0 1 0 1.5,0 a .75,.75 0 1 0 -1.5,0 z",
    "Bézier curves": "M{right},{y}c0,.414-.336,.75-.75,.75s-.75-.336-.75-.75s.336-.75 .75-.75s.75,.336 .75,.75z",
}


ROUNDED = "M1.4,1h.6a.4,.4 0 0 1 .4,.4v.6a.4,.4 0 0 1 -.4,.4h-.6a.4,.4 0 0 1 -.4,-.4v-.6a.4,.4 0 0 1 .4,-.4z"


@pytest.mark.parametrize("kind", PATHS)
@pytest.mark.parametrize("together", [False, True])
def test_circles_of_svg_converted_to_paths_are_markers(kind: str, together: bool, tmp_path: Path) -> None:
    pytest.importorskip("svgelements")
    drawn = [PATHS[kind].format(left=x - 0.75, right=x + 0.75, y=-y) for x, y in SHUFFLED]
    drawn = [" ".join(drawn)] if together else drawn
    paths = "".join(f'<path d="{one}"/>' for one in [*drawn, "M 1,1 h 1.4 v 1.4 h -1.4 z", ROUNDED])
    text = f'<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="40mm" viewBox="-20 -20 40 40">{paths}</svg>'
    (tmp_path / "a.svg").write_text(text)
    assert same(read(tmp_path / "a.svg"))


@pytest.mark.parametrize("hidden", ['display="none"', 'style="fill:red; display: none"'])
def test_a_hidden_layer_of_svg_has_no_markers(hidden: str, tmp_path: Path) -> None:
    shown = "".join(f'<circle cx="{x}" cy="{-y}" r=".75"/>' for x, y in SHUFFLED)
    layer = f'<g {hidden}><circle cx="1" cy="2" r=".75"/></g>'
    head = '<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="40mm" viewBox="-20 -20 40 40">'
    text = f"{head}{shown}{layer}</svg>"
    (tmp_path / "a.svg").write_text(text)
    assert same(read(tmp_path / "a.svg"))
