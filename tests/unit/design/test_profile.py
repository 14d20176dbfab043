"""Skins from drawn meridians: arcs, sections and bodies of known shape are followed, corners and gaps refused."""

from pathlib import Path

import numpy as np
import pytest

from errors import end_process, refused
from needs import needs
from palpate.core.run import Progress
from palpate.design import DomeSpec, build_skin, read_profile, read_skin, skin_from_data
from palpate.design.profile import _cut_step
from palpate.fea import WallSpec
from palpate.material import get_material
from palpate.mesh import MeshSpec, mesh_skin
from palpate.study import read_study
from presses import solve_press

HEIGHT, BASE, THICK = 18.0, 21.0, 2.5
RADIUS = (HEIGHT**2 + BASE**2) / (2 * HEIGHT)
CENTRE = HEIGHT - RADIUS
WIDE = float(np.degrees(np.arccos(-CENTRE / RADIUS)))
"""Spherical cap: radius and height of the centre of its inner surface, and its half angle, degrees."""


def meridian(radius: float = RADIUS, count: int = 200) -> np.ndarray:
    """Points (n, 2) of a cap from the apex to the base plane."""
    angle = np.linspace(0.0, np.arccos(-CENTRE / radius), count)
    return np.column_stack([radius * np.sin(angle), radius * np.cos(angle) + CENTRE])


def table(path: Path, points: np.ndarray, head: str = "r_mm,z_mm") -> Path:
    np.savetxt(path, points, delimiter=",", header=head, comments="")
    return path


def arcs(path: Path, *radii: float, unit: int = 4, extra: bool = True) -> Path:
    """Whole arcs of a section with base line, axis and a text."""
    ezdxf = needs("ezdxf")
    document, mm = ezdxf.new("R2010", units=unit), {4: 1.0, 1: 25.4, 5: 10.0}[unit]
    space = document.modelspace()
    for radius in radii:
        wide = np.degrees(np.arccos(-CENTRE / radius))
        space.add_arc((0, CENTRE / mm), radius / mm, 90 - wide, 90 + wide)
    if extra:
        space.add_line((-30 / mm, 0), (30 / mm, 0))
        space.add_line((0, -5 / mm), (0, 40 / mm))
        space.add_text("skin")
    document.saveas(path)
    return path


def follows_the_cap(path: Path, thickness: float | None = None) -> bool:
    found = read_profile(path)
    spec = found.spec
    assert (spec.height, spec.base_radius) == pytest.approx((HEIGHT, BASE), abs=2e-3)
    assert found.deviation_mm < 0.01
    if thickness is not None:
        assert spec.thickness == pytest.approx(thickness, abs=0.005)
    points = spec.build().curve(np.linspace(0, 1, 50))
    return float(np.abs(np.hypot(points[:, 0], points[:, 1] - CENTRE) - RADIUS).max()) < 0.012


@pytest.mark.parametrize(
    ("head", "change"),
    [
        ("r_mm,z_mm", lambda points: points),
        ("z_cm,r_cm", lambda points: points[::-1, ::-1] / 10),
        ("r_in,height_in", lambda points: points / 25.4),
        ("r_mm,z_mm", lambda points: points * [1, -1] + [0, 100]),
        ("x_mm,y_mm", lambda points: points * [-1, 1]),
    ],
)
def test_a_table_is_followed_from_both_ends_in_any_unit(tmp_path: Path, head: str, change) -> None:
    assert follows_the_cap(table(tmp_path / "cap.csv", change(meridian()), head))


@pytest.mark.parametrize("unit", [4, 1, 5])
def test_arcs_of_a_section_give_shape_and_thickness(tmp_path: Path, unit: int) -> None:
    assert follows_the_cap(arcs(tmp_path / "cap.dxf", RADIUS, unit=unit))
    assert follows_the_cap(arcs(tmp_path / "both.dxf", RADIUS + THICK, RADIUS, unit=unit), THICK)


def test_a_closed_outline_gives_shape_and_thickness(tmp_path: Path) -> None:
    ezdxf = needs("ezdxf")
    for name, outer in (
        ("flat", meridian(RADIUS + THICK)),
        ("square", meridian() * (1 + THICK / RADIUS) - [0, CENTRE * THICK / RADIUS]),
    ):
        document = ezdxf.new("R2010", units=4)
        outline = np.vstack([meridian(), outer[::-1]])
        document.modelspace().add_lwpolyline([tuple(point) for point in outline], close=True)
        document.saveas(tmp_path / f"{name}.dxf")
        assert follows_the_cap(tmp_path / f"{name}.dxf", THICK)


def test_a_taper_is_measured(tmp_path: Path) -> None:
    """The drawn thickness falls from 3 to 1.8 mm with the square of the meridian's parameter."""
    ezdxf = needs("ezdxf")
    document, inner = ezdxf.new("R2010", units=4), meridian()
    share = np.linspace(0, 1, len(inner)) ** 2
    outer = inner + (3.0 - 1.2 * share)[:, None] * (inner - [0, CENTRE]) / RADIUS
    for curve in (inner, outer):
        document.modelspace().add_lwpolyline([tuple(point) for point in curve])
    document.saveas(tmp_path / "taper.dxf")
    spec = read_profile(tmp_path / "taper.dxf").spec
    assert (spec.thickness, spec.taper) == pytest.approx((3.0, 0.6), abs=0.03)


@pytest.fixture
def here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bodies are cut in this process: another loads the CAD kernel for seconds."""
    monkeypatch.setattr("palpate.design.profile._step_curves", lambda path: _cut_step(path, Progress()))


@pytest.mark.parametrize("axis", ["X", "Y", "Z"])
def test_a_revolved_body_is_cut_through_its_axis(tmp_path: Path, axis: str, request: pytest.FixtureRequest) -> None:
    cad = needs("build123d")
    if axis != "X":
        request.getfixturevalue("here")
    outer = cad.Sphere(RADIUS + THICK) - cad.Sphere(RADIUS)
    half = cad.Pos(0, 0, 50 - CENTRE) * cad.Box(100, 100, 100)
    body = outer & half
    turn = {"X": cad.Rot(0, 90, 0), "Y": cad.Rot(90, 0, 0), "Z": cad.Rot(0, 0, 30)}[axis]
    cad.export_step(cad.Pos(3, 4, 5) * turn * body, str(tmp_path / "cap.step"))
    assert follows_the_cap(tmp_path / "cap.step", THICK)


def test_a_press_of_the_followed_skin_is_that_of_the_dome(tmp_path: Path) -> None:
    """The dome has a closed form, and the spline has none."""
    dome = build_skin(DomeSpec(height=HEIGHT, base_radius=BASE, thickness=THICK))
    skins = (dome, read_profile(table(tmp_path / "cap.csv", meridian()), THICK).spec.build())
    wall, silicone = WallSpec(tilt_deg=4.0, depth=3.0, depth_step=1.0), get_material("zaid_2024_ecoflex_00_30")
    one, other = (solve_press(mesh_skin(skin, MeshSpec(cells=10)), silicone, wall) for skin in skins)
    apart = np.linalg.norm(other.force - one.force, axis=1)
    assert (apart[1:] < 3e-3 * np.linalg.norm(one.force[1:], axis=1)).all()


def test_a_drawn_hemisphere_has_no_undercut(tmp_path: Path) -> None:
    """The spline is 0.3 µm wider than the base."""
    angle = np.linspace(0.0, np.pi / 2, 46)
    half = 20.0 * np.column_stack([np.sin(angle), np.cos(angle)])
    assert not read_profile(table(tmp_path / "half.csv", half)).spec.build().bulges
    assert build_skin(DomeSpec(height=23, base_radius=20)).bulges


def test_a_study_and_a_flag_take_the_numbers_of_the_drawing(tmp_path: Path) -> None:
    arcs(tmp_path / "cap.dxf", RADIUS, RADIUS + THICK)
    (tmp_path / "study.yaml").write_text("name: own\ndesigns: {skin: {kind: profile, file: cap.dxf}, markers: [7]}\n")
    [skin] = read_study(tmp_path / "study.yaml").designs.skins()
    assert skin == read_profile(tmp_path / "cap.dxf").spec
    assert read_skin(f"profile:file={tmp_path / 'cap.dxf'}", DomeSpec()) == skin
    assert "file" not in skin.model_dump()
    other = "name: own\ndesigns: {skin: {kind: profile, file: cap.dxf}, thicknesses: [1 mm, 3 mm], markers: [7]}\n"
    (tmp_path / "study.yaml").write_text(other)
    assert [one.thickness for one in read_study(tmp_path / "study.yaml").designs.skins()] == [1.0, 3.0]


def cone(count: int = 50) -> np.ndarray:
    return np.column_stack([np.linspace(0, BASE, count), np.linspace(HEIGHT, 0, count)])


@pytest.mark.parametrize(
    ("name", "points", "head", "code"),
    [
        ("corner.csv", cone(), "r_mm,z_mm", "profile-not-smooth"),
        ("open.csv", meridian()[40:], "r_mm,z_mm", "profile-open"),
        ("metres.csv", meridian(), "r_m,z_m", "profile-size"),
        ("no_unit.csv", meridian(), "r,z", "columns-wrong"),
        ("names.csv", meridian(), "a_mm,b_mm", "columns-wrong"),
        ("far.csv", np.vstack([meridian(), [1e308, 0.0]]), "r_mm,z_mm", "profile-far"),
    ],
)
def test_a_curve_that_no_skin_follows_is_refused(tmp_path: Path, name: str, points, head: str, code: str) -> None:
    with refused(code):
        read_profile(table(tmp_path / name, points, head))


@pytest.mark.parametrize("count", [6, 10, 20])
def test_a_table_of_few_points_is_followed(tmp_path: Path, count: int) -> None:
    """Chords between ten points would be 0.08 mm off; a smooth curve goes through them."""
    assert follows_the_cap(table(tmp_path / "cap.csv", meridian(count=count)))


def test_wrong_numbers_of_a_profile_are_refused(tmp_path: Path) -> None:
    path = table(tmp_path / "cap.csv", meridian())
    with refused("thickness-not-number", "thick"):
        read_skin(f"profile:file={path},thickness=thick", DomeSpec())
    with refused("parameter-unknown", "taper"):
        read_skin(f"profile:file={path},taper=0.5", DomeSpec())
    with refused("profile-size", "thickness", 40.0):
        read_profile(path, 40.0)
    with refused("profile-size", "thickness"):
        read_profile(arcs(tmp_path / "thin.dxf", RADIUS, RADIUS + 0.1))
    with refused("profile-few-points", 3):
        read_profile(table(tmp_path / "few.csv", meridian(count=3)))


@pytest.mark.usefixtures("here")
def test_a_drawing_with_other_curves_is_refused(tmp_path: Path) -> None:
    with refused("profile-curves", 3):
        read_profile(arcs(tmp_path / "three.dxf", RADIUS, RADIUS + 1, RADIUS + 2))
    (tmp_path / "not.step").write_text("no body")
    with refused("drawing-broken", "not.step"):
        read_profile(tmp_path / "not.step")
    with refused("file-missing", "lost.csv"):
        read_profile(tmp_path / "lost.csv")
    with refused("parameter-missing"):
        skin_from_data({"kind": "profile"})


def test_a_body_that_ends_the_kernel_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A damaged STEP file can end the process that reads it (exit code 139)."""
    needs("build123d")
    monkeypatch.setattr("palpate.design.profile._cut_step", end_process)
    (tmp_path / "bad.step").write_text("")
    with refused("drawing-broken", "bad.step"):
        read_profile(tmp_path / "bad.step")
