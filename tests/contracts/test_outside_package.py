"""Another package adds to palpate by entry points alone: it is installed into an empty folder and tested there."""

import json
import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from errors import check_values
from needs import needs

HERE = Path(__file__).parent / "outside_package"
SOURCE = Path(__file__).parents[2] / "src"


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What `pip install --no-deps --target` leaves: the package, and the entry points of its pyproject."""
    project = tomllib.loads((HERE / "pyproject.toml").read_text())["project"]
    site = tmp_path_factory.mktemp("site")
    shutil.copytree(HERE / "src", site, dirs_exist_ok=True)
    shutil.copytree(HERE / "tests", site / "tests")
    info = site / f"{project['name'].replace('-', '_')}-{project['version']}.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n")
    groups = [
        f"[{group}]\n" + "".join(f"{name} = {value}\n" for name, value in points.items())
        for group, points in project["entry-points"].items()
    ]
    (info / "entry_points.txt").write_text("\n".join(groups))
    return site


def run(site: Path, *words: str) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join([str(site), str(SOURCE)])
    return subprocess.run(
        [sys.executable, *words],
        env=os.environ | {"PYTHONPATH": path},
        cwd=site,
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )


def test_the_guest_passes_the_published_suites(installed: Path) -> None:
    done = run(installed, "-m", "pytest", "-q", "-p", "no:cacheprovider", "tests")
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-2000:]


def test_the_guests_law_and_lens_are_known_on_the_command_line_and_in_a_study(installed: Path) -> None:
    shown = run(
        installed, "-c", "from palpate.cli import main; main()", "material", "show", "carroll:0.008,0.00001,0.006"
    )
    assert shown.returncode == 0, shown.stderr
    assert "carroll" in shown.stdout
    camera = "from palpate.camera import CameraSpec, build_camera; "
    made = run(installed, "-c", camera + "print(build_camera(CameraSpec(lens='division', distortion=[-0.2])).lens)")
    assert made.stdout.strip() == "Division(k=-0.2)"
    (installed / "mine.yaml").write_text("name: mine\ncamera:\n  lens: division\n  distortion: [-0.2]\n")
    read = "from palpate.study import read_study; print(read_study('mine.yaml').camera.model_dump_json())"
    assert '"lens":"division","distortion":[-0.2]' in run(installed, "-c", read).stdout


LEARN = """
import sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
from drawn_tactip import DrawnSensor, draw_motions, draw_recording
from palpate.cli import main
from palpate.learn.member import ImageRidge
ImageRidge.sides = (16,)
folder = Path("drawn")
folder.mkdir()
draw_recording(folder, draw_motions(8, 1, shear=2.0), DrawnSensor(rings=3))
main(["learn", str(folder), "--out", "learnt", "--estimators", "ridge", "--json"])
"""


def test_the_guests_estimator_is_trained_and_reported_with_the_others(installed: Path) -> None:
    done = run(installed, "-c", LEARN, str(Path(__file__).parents[1]))
    assert done.returncode == 0, done.stderr
    names = {one["name"] for one in json.loads(done.stdout)["estimators"]}
    assert {"neighbours", "dots-ridge", "picture-ridge"} <= names


GUEST_STUDY = """
name: wheel
designs: {heights: [20 mm], thicknesses: [2 mm], markers: [19]}
obstacle: {kind: wheel, radius: 9 mm, depth: 3 mm, contact: frictionless}
offsets_mm: [0, 2]
mesh: {cells: 4}
dataset: {n_presses: 30, dropped_images: 0}
learning: {preset: quick}
"""


def test_the_guests_obstacle_gives_a_row_of_a_grid(installed: Path) -> None:
    needs("torch")
    (installed / "wheel.yaml").write_text(GUEST_STUDY)
    command = "from palpate.cli import main; main()"
    done = run(installed, "-c", command, "run", "wheel.yaml", "--workers", "1", "--json")
    assert done.returncode == 0, done.stderr
    (row,) = json.loads(done.stdout)["designs"]
    assert not row["failure"]
    assert 0 < row["rmse_mm"] < 2
    assert json.loads(row["spec"])["obstacle"]["kind"] == "wheel"
    assert json.loads(row["spec"])["offsets_mm"] == [0, 2]


def test_without_the_guest_its_names_are_unknown_and_the_group_is_named(tmp_path: Path) -> None:
    found = run(tmp_path, "-c", "from palpate.camera import CameraSpec; CameraSpec(lens='division')").stderr
    check_values(found, "division", "palpate.lenses")
