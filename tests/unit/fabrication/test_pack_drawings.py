"""Drawings of a pack: their scale, letters and title block, and their numbers, compared with the solids."""

import re
from collections.abc import Iterator
from itertools import combinations

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextPath

from needs import needs
from palpate.camera import CameraSpec
from palpate.design import Design, DomeSpec, MarkerSpec, MountSpec, box
from palpate.fabrication import ProcessSpec
from palpate.fabrication.drawing_sheet import LETTERS, MM_PER_INCH, PAGE, TitleBlock, cut_part
from palpate.fabrication.pack import PackContent
from palpate.fabrication.pack_drawings import draw_pack
from palpate.fabrication.write_artwork import draw_page
from palpate.fabrication.write_pack import _for_printer, _make
from palpate.material import get_material

needs("build123d")


@pytest.fixture(scope="module")
def made() -> PackContent:
    design = Design(DomeSpec(), MarkerSpec(count=37), CameraSpec(), get_material("zaid_2024_ecoflex_00_30"))
    return _make(design, ProcessSpec(), MountSpec())


@pytest.fixture(scope="module")
def drawn(made: PackContent) -> dict[str, Figure]:
    return draw_pack(made, {"mold_core": 10, "mold_cavity": 11, "housing": 12, "clamp_ring": 13, "robot_plate": 14})


def words(figure: Figure) -> list[str]:
    return [text.get_text() for text in (*figure.texts, *figure.axes[0].texts)]


def scale_of(figure: Figure) -> float:
    page, part = (float(one) for one in figure.get_label().split(":"))
    return page / part


def test_a_drawing_is_to_the_scale_of_its_title_block(drawn: dict[str, Figure]) -> None:
    for name, figure in drawn.items():
        assert figure.get_size_inches() * MM_PER_INCH == pytest.approx(PAGE), name
        axis = figure.axes[0]
        wide = axis.get_position().size * PAGE
        for size, (low, high) in zip(wide, (axis.get_xlim(), axis.get_ylim()), strict=True):
            assert size / (high - low) == pytest.approx(scale_of(figure)), name


def test_everything_drawn_is_on_its_page_and_above_the_title_block(drawn: dict[str, Figure]) -> None:
    for name, figure in drawn.items():
        axis = figure.axes[0]
        low, high = np.array([axis.get_xlim(), axis.get_ylim()]).T
        for collection in axis.collections:
            if isinstance(collection, LineCollection):
                points = np.concatenate(collection.get_segments())
                assert (points >= low).all(), name
                assert (points <= high).all(), name


def test_letters_are_at_least_2_5_mm_high(drawn: dict[str, Figure], made: PackContent) -> None:
    block = TitleBlock("H 20", "elastomer")
    pages = [*drawn.values(), draw_page(made.artwork, block)]
    sizes = {text.get_fontsize() for figure in pages for text in (*figure.texts, *figure.axes[0].texts)}
    height = TextPath((0, 0), "H", size=min(sizes), prop=FontProperties()).get_extents().height
    assert height / 72 * MM_PER_INCH >= 2.5
    assert min(sizes) == LETTERS


def test_a_title_block_names_design_material_version_date_scale_and_page(made: PackContent, monkeypatch) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    block = TitleBlock("H 20  T 2", "elastomer")
    figure = draw_page(made.artwork, block)
    block.number(figure, 3, 7)
    text = " | ".join(words(figure))
    for part in ("H 20  T 2", "elastomer", "1970-01-02", "scale 1 : 1", "page 3 of 7", "artwork", "palpate "):
        assert part in text


def test_parts_are_named_and_numbered_as_in_the_bill(drawn: dict[str, Figure]) -> None:
    assert {"10  core", "11  cavity"} <= set(words(drawn["mold_parts"]))
    names = {"contact module", "12  housing", "13  clamp ring", "14  robot plate"}
    assert names <= set(words(drawn["enclosure_parts"]))
    assert {"core", "cavity", "elastomer"} <= set(words(drawn["mold_section"]))
    assert {"housing", "clamp ring", "contact module", "robot plate", "pinhole"} <= set(
        words(drawn["enclosure_section"])
    )


def features(figure: Figure) -> Iterator[tuple[str, float]]:
    for text in words(figure):
        if found := re.fullmatch(r"([\w, ]+) ([\d.]+)°", text):
            yield from ((name, float(found[2])) for name in found[1].split(", "))


def test_azimuths_of_the_plans_are_those_of_pins_holes_screws_rib_key_and_slot(
    drawn: dict[str, Figure], made: PackContent
) -> None:
    parts = {**made.mold.parts, **made.enclosure.parts}
    core, foot = parts["mold_core"], made.module.foot
    low = float(core.bounds[0, 2])
    text = "\n".join(word for plan in ("mold_plan", "enclosure_plan") for word in words(drawn[plan]))
    sizes = {  # half the diameter of a feature, and of the circle that it is on
        name: np.array(re.search(pattern, text).groups(), float) / 2
        for name, pattern in {
            "pin": r"pins Ø ([\d.]+) on Ø ([\d.]+)",
            "pour": r"pour hole Ø ([\d.]+) .* on Ø ([\d.]+)",
            "vent": r"vents Ø ([\d.]+) on Ø ([\d.]+)",
            "screw": r"screws Ø ([\d.]+), 10 deep, on Ø ([\d.]+)",
            "M3": r"M3: Ø ([\d.]+) on Ø ([\d.]+)",
            "M6": r"M6: Ø ([\d.]+) on Ø ([\d.]+)",
            "dowel": r"dowel: Ø ([\d.]+) on Ø ([\d.]+)",
        }.items()
    }
    spots = {  # part, distance from the axis, height, and whether there is material
        "pin": (parts["mold_cavity"], sizes["pin"][1], foot - 2, True),
        "rib": (parts["mold_cavity"], 27.5, foot + 1, True),
        "pour": (core, sizes["pour"][1], low + 1, False),
        "vent": (core, sizes["vent"][1], low + 1, False),
        "screw": (parts["housing"], sizes["screw"][1], foot - 9.5, False),
        "key": (parts["housing"], 27.7, foot + 1, True),
        "cable": (parts["housing"], 36.0, parts["housing"].bounds[0, 2] + 7, False),
        "M3": (parts["robot_plate"], sizes["M3"][1], parts["robot_plate"].bounds[0, 2] + 6, False),
        "M6": (parts["robot_plate"], sizes["M6"][1], parts["robot_plate"].bounds[0, 2] + 6, False),
        "dowel": (parts["robot_plate"], sizes["dowel"][1], parts["robot_plate"].bounds[0, 2] + 6, False),
    }
    seen = {name: [] for name in spots}
    for plan in ("mold_plan", "enclosure_plan"):
        for name, azimuth in features(drawn[plan]):
            part, reach, level, filled = spots[name]
            for away in (0.0, 14.0) if name not in ("pin", "rib") else (0.0,):
                expected = filled if away == 0.0 else not filled
                assert is_solid(part, reach, azimuth + away, level) is expected, (name, azimuth + away)
            for step in (-1, 1) if name in sizes else ():
                half = sizes[name][0]
                assert is_solid(part, reach + step * (half - 0.08), azimuth, level) is filled, (name, "narrower")
                assert is_solid(part, reach + step * (half + 0.08), azimuth, level) is not filled, (name, "wider")
            seen[name].append(azimuth)
    assert {name: len(found) for name, found in seen.items()} == {
        "pin": 3, "rib": 1, "pour": 1, "vent": 6, "screw": 6, "key": 1, "cable": 1, "M3": 4, "M6": 4, "dowel": 1
    }  # fmt: skip


@pytest.mark.parametrize("plan", ["mold_plan", "enclosure_plan"])
def test_no_line_of_a_plan_meets_a_word_and_no_word_another(drawn: dict[str, Figure], plan: str) -> None:
    figure = drawn[plan]
    axis, canvas = figure.axes[0], FigureCanvasAgg(figure)
    boxes = [text.get_window_extent(canvas.get_renderer()) for text in axis.texts]
    for line in axis.lines:
        path = line.get_path().transformed(axis.transData)
        assert not any(path.intersects_bbox(box, filled=False) for box in boxes)
    for first, second in combinations(boxes, 2):
        assert not first.overlaps(second)


def test_circles_of_a_plan_bend_by_less_than_4_degrees(drawn: dict[str, Figure]) -> None:
    curves = [
        line for each in drawn["mold_plan"].axes[0].collections for line in each.get_segments() if len(line) > 2
    ]
    sides = np.diff(np.array(max(curves, key=lambda line: np.ptp(line, axis=0).max())), axis=0)
    turns = np.diff(np.unwrap(np.arctan2(*sides.T)))
    assert np.abs(np.degrees(turns)).max() < 4.0


def is_solid(part, reach: float, azimuth: float, level: float) -> bool:
    x, y = reach * np.cos(np.radians(azimuth)), reach * np.sin(np.radians(azimuth))
    grain = box((x - 0.05, y - 0.05, level - 0.05), (x + 0.05, y + 0.05, level + 0.05))
    return part.overlap(grain) > 0.5e-3


def test_a_section_has_the_area_of_the_cut(made: PackContent) -> None:
    triangles, edges, _ = cut_part(made.solids["module"], 0.0, 0.5)
    (ax, ay), (bx, by) = (triangles[:, 1] - triangles[:, 0]).T, (triangles[:, 2] - triangles[:, 0]).T
    skin = np.pi / 4 * (22**2 - 20**2)
    flange = 3.0 * (made.module.flange_foot - made.module.opening_foot)
    assert np.abs(ax * by - ay * bx).sum() / 2 == pytest.approx(skin + flange, rel=0.05)
    assert len(edges) > 20
    assert cut_part(made.solids["clamp_ring"].moved(x=100.0), 180.0, 0.5) is None


def test_heights_and_widths_on_the_enclosure_are_those_of_its_parts(
    drawn: dict[str, Figure], made: PackContent
) -> None:
    parts = made.enclosure.parts
    numbers = {
        float(found[1])
        for text in words(drawn["enclosure_section"])
        if (found := re.fullmatch(r"(?:Ø )?([\d.]+)", text))
    }
    plate, ring = parts["robot_plate"].bounds, parts["clamp_ring"].bounds
    top = made.solids["module"].bounds[1, 2]
    sizes = [np.ptp(ring[:, 0]), np.ptp(plate[:, 0]), np.ptp(plate[:, 2]), top - plate[0, 2]]
    sizes += [made.module.foot - plate[1, 2], made.enclosure.camera_distance]
    for size in sizes:
        assert min(abs(size - one) for one in numbers) < 0.06, (size, numbers)


def test_the_artwork_gives_the_angle_of_its_mark_on_the_page_and_on_the_part(made: PackContent) -> None:
    text = "\n".join(words(draw_page(made.artwork, TitleBlock("", ""))))
    here, part = map(float, re.search(r"mark: ([\d.]+)° here, ([\d.]+)° on the part", text).groups())
    assert here == pytest.approx(np.degrees(np.arctan2(*made.artwork.mark[::-1])), abs=0.05)
    assert part == pytest.approx(180 - here)


def test_mold_ring_and_robot_plate_lie_on_their_largest_face_in_their_files(made: PackContent) -> None:
    for name in ("mold_core", "mold_cavity", "clamp_ring", "robot_plate"):
        mesh = _for_printer(name, {**made.mold.parts, **made.enclosure.parts}[name].mesh())
        faces = mesh.points[mesh.triangles]
        flat = np.ptp(faces[..., 2], axis=1) < 1e-6
        (ax, ay, _), (bx, by, _) = (faces[flat, 1] - faces[flat, 0]).T, (faces[flat, 2] - faces[flat, 0]).T
        level, area = faces[flat, 0, 2], np.abs(ax * by - ay * bx) / 2
        on_bed = area[level < level.min() + 1e-6].sum()
        assert on_bed > 0.95 * max(area[np.abs(level - one) < 1e-6].sum() for one in np.unique(level.round(6))), name
