"""Print, template and sheet of a pack agree on the rotation of the skin in its housing and under the pad."""

import re
from pathlib import Path

import meshio
import numpy as np
import pytest

from needs import needs
from palpate.camera import CameraSpec
from palpate.design import Design, DomeSpec, MarkerSpec, place_orientation_mark
from palpate.fabrication import FabricationPack
from palpate.fabrication.flange_key import NOTCH_AZIMUTH_DEG
from palpate.material import get_material

needs("build123d")
DESIGN = Design(DomeSpec(), MarkerSpec(count=37), CameraSpec(), get_material("zaid_2024_ecoflex_00_30"))


def vertices(folder: Path, name: str) -> np.ndarray:
    return meshio.read(folder / f"{name}.stl").points


def azimuths(points: np.ndarray) -> np.ndarray:
    return np.degrees(np.arctan2(points[:, 1], points[:, 0])) % 360


def test_notches_of_flange_and_template_key_rib_and_long_arm_are_at_one_azimuth(pack: FabricationPack) -> None:
    foot = vertices(pack.folder, "module")
    foot = foot[foot[:, 2] < foot[:, 2].min() + 1e-3]
    reach = np.hypot(*foot[:, :2].T)
    notch = foot[(reach > 26.0) & (reach < reach.max() - 0.01)]
    assert azimuths(notch).mean() == pytest.approx(NOTCH_AZIMUTH_DEG, abs=0.1)
    assert reach.max() - np.hypot(*notch[:, :2].T).min() == pytest.approx(1.5, abs=0.01)
    shell = vertices(pack.folder, "template")
    edge = shell[shell[:, 2] < shell[:, 2].min() + 1e-3]
    outer = np.hypot(*edge[:, :2].T)
    cut = edge[(outer > outer.min() + 0.01) & (outer < outer.max() - 0.01)]
    assert azimuths(cut).mean() == pytest.approx(NOTCH_AZIMUTH_DEG, abs=1.0)
    ezdxf = needs("ezdxf")
    lines = ezdxf.readfile(pack.folder / "artwork.dxf").modelspace().query('LINE[layer=="ALIGNMENT"]')
    ends = np.array([[*line.dxf.start][:2] + [*line.dxf.end][:2] for line in lines])
    far = ends.reshape(-1, 2)[np.abs(ends.reshape(-1, 2)).max(axis=1).argmax()]
    assert azimuths(far[None] * [-1, 1])[0] == pytest.approx(NOTCH_AZIMUTH_DEG), (
        "x of the page is minus x of the dome"
    )


def test_sizes_and_places_of_the_sheets_datums_are_those_of_the_parts(pack: FabricationPack) -> None:
    text = (pack.folder / "instructions.md").read_text()
    wide = float(re.search(r"covers the cavity \(([\d.]+) mm across\)", text).group(1))
    size = np.ptp(vertices(pack.folder, "mold_cavity"), axis=0)
    assert (wide, wide) == pytest.approx(size[:2], abs=0.02)
    apart = [float(one) for one in re.search(r"crosses \(([\d.]+) mm and ([\d.]+) mm apart", text).groups()]
    svg = (pack.folder / "artwork.svg").read_text()
    centres = {float(x) for x in re.findall(r'x1="([-\d.]+)"[^/]*x2="\1"', svg)}
    assert apart == pytest.approx([max(centres) - min(centres)] * 2, abs=0.01)
    reach, enough = map(float, re.search(r"begin ([\d.]+) mm from the axis: ([\d.]+) mm are enough", text).groups())
    cavity = vertices(pack.folder, "mold_cavity")
    pins = np.hypot(*cavity[cavity[:, 2] > cavity[:, 2].max() - 1e-3, :2].T)
    assert reach == pytest.approx(pins.min(), abs=0.01)
    assert enough == pytest.approx(apart[0] / 2 + 2.0)
    assert enough < reach
    place = [int(one) for one in re.search(r"near column (\d+), row (\d+)", text).groups()]
    mark = place_orientation_mark(DESIGN.skin, DESIGN.layout)
    assert place == pytest.approx(DESIGN.camera.project(mark), abs=0.5)
    assert "key opposite the cable slot" in text
    low, high = map(float, re.search(r"surface, ([\d.]+) to ([\d.]+) mm from the pinhole", text).groups())
    ahead = float(re.search(r"lens and ([\d.]+) mm above the lower face of the shelf", text)[1])
    points = DESIGN.layout.positions - DESIGN.camera.origin
    assert low <= points[:, 2].min() < points[:, 2].max() == pytest.approx(high, abs=0.1)
    housing = vertices(pack.folder, "housing")
    housing[:, 2] += -1.0 - housing[:, 2].max()  # the key ends 1 mm below the base
    shelf = np.unique(housing[np.hypot(*housing[:, :2].T) < 11.1, 2].round(2))
    assert shelf.min() == pytest.approx(-low - ahead, abs=0.1)
