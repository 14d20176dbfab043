"""Every table of every verb in terminals of 80, 100 and 120 columns: no digit and no name is cut."""

import json
import re
import shutil
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from terminal import ROOT, Shown, show

from inventory.collect import verbs
from inventory.commands import COMMANDS
from inventory.compare import new_words
from presses import copy_artefacts, stored_folder
from results import PAPER, leave_out_pictures

DATA = ROOT / "examples" / "data"
WIDTHS = (80, 100, 120)
CHEAP = {
    "material list": "material list",
    "material show": "material show zaid_2024_ecoflex_00_30",
    "press": "press --cells 4 --depth 0.4",
    "design": "design show --markers 19",
    "profile": f"design profile {DATA}/profile.csv",
    "grid show": "study show small",
    "grid show, wide": "study show small --wide",
    "grid compare": "study compare small small",
    "limit": "design bound small",
    "claims": "claims small",
    "calibrate": f"calibration camera {DATA}/board --board chessboard:9x6:25",
    "find": "sensor detect images",
    "check": f"sensor check {DATA}/recording/poses.csv --rest-images 2 --press-images 2",
    "fit": f"material fit --uniaxial {DATA}/rubber/uniaxial.csv --model yeoh --alone "
    f"--relaxation {DATA}/rubber/relaxation.csv",
    "verify": "verify --only cook",
}
"""Verb → its words: those that take less than a second."""
DEAR = {
    "run": "run {data}/small.yaml --out small --workers 1",
    "press": "press --height 20 --thickness 2 --tilt 5 --depth 4 --contact 0.8 --cells 5",
    "press, skin": "press --skin ellipsoid --height 18 --thickness 2 --obstacle ball:radius=6,offset=3 --depth 3 "
    "--cells 5",
    "press, inverted": "press --height 20 --thickness 1 --branch inverted --depth 8 --step 2 --cells 6",
    "press, gel": "press --height 10 --thickness 1 --base-radius 10 --material neo-hooke:0.5 --gel neo-hooke:0.05 "
    "--depth 1 --step 0.5 --cells 4",
    "convergence": "design convergence --meshes 4 6 8 --depth 2 --step 1",
    "find": "sensor detect short",
    "check": "sensor check short/poses.csv --rest-images 2 --press-images 2",
    "stability": "design stability --height 20 --thickness 1 --tilts 0 --cells 6 --depth 4 --step 1",
    "status": "study status {data}/small.yaml --out small",
    "limit": "design bound {data}/small.yaml --out small",
    "profile": "design profile {data}/profile.csv",
    "grid show": "study show small",
    "grid compare": "study compare small small",
    "twin": "calibration predict {data}/small.yaml --out small --workers 1",
    "accept": "calibration accept {data}/recording/poses.csv --model small/twins/H20_T2.h5 --markers 61 "
    "--min-depth 1 --no-zero",
    "learn": "recording train short --out learnt --estimators ridge",
    "live": "sensor live --source {data}/recording --model small/twins/H20_T2.h5 --markers 61 --count 4",
    "benchmark score": "benchmark score predictions.csv --set set/set",
    "fit": "material fit --uniaxial {data}/rubber/uniaxial.csv --equibiaxial {data}/rubber/equibiaxial.csv "
    "--planar {data}/rubber/planar.csv --model yeoh",
}
"""Words that differ from those of the inventory, or are none of its own."""
GROUPS = {
    "study": ("run", "status", "limit", "grid", "twin", "live", "identify", "accept", "bench", "align", "claims"),
    "press": ("press", "stability", "convergence", "design", "fit", "material", "profile", "verify", "doctor"),
    "images": ("calibrate", "find", "check", "inspect", "learn", "benchmark"),
}
"""Part of the slow test → first words of the names of its verbs: later ones read the results of earlier ones."""
NOT_RUN = {
    "study run": "the same verb as run",
    "design press": "the same verb as press",
    "search": "its smallest search takes a quarter of an hour; its columns are tested in tests/unit/optimise",
}


def make_grid(folder: Path) -> None:
    """Write a grid of four designs of the paper."""
    from palpate.study import evaluate_grid, write_grid

    with pytest.MonkeyPatch.context() as changes:
        leave_out_pictures(changes)
        write_grid(folder / "small", evaluate_grid(PAPER[:4]))


@pytest.fixture(scope="module")
def cheap(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Shown]:
    folder = tmp_path_factory.mktemp("cheap")
    make_grid(folder)
    (folder / "images").mkdir()
    for image in ("00.png", "10.png"):
        shutil.copy(DATA / "recording" / image, folder / "images")
    return dict(zip(CHEAP, show(list(CHEAP.values()), WIDTHS, folder), strict=True))


@pytest.mark.parametrize("verb", CHEAP)
def test_a_terminal_shows_tables_uncut(cheap: dict[str, Shown], verb: str) -> None:
    shown = cheap[verb]
    assert shown.code == 0
    assert shown.faults == {}
    assert [width for width in WIDTHS if len(shown.text[width].split("\n")) > 3] == list(WIDTHS)


def numbers(values: Iterable[Any], form: str) -> set[str]:
    return {format(value, form) for value in values}


def test_a_grid_keeps_the_figures_that_decide(cheap: dict[str, Shown]) -> None:
    from palpate.study import evaluate_grid

    designs = evaluate_grid(PAPER[:4]).designs
    for width in WIDTHS:
        words = set(cheap["grid show"].text[width].split())
        for name, form in (("markers", "d"), ("rmse_deg", ".3f"), ("max_error_deg", ".3f")):
            assert numbers((row[name] for row in designs), form) <= words
        assert "small/grid.csv" in words


def test_a_list_keeps_the_names_of_materials_whole(cheap: dict[str, Shown]) -> None:
    from palpate.material import get_material, list_materials

    for width in WIDTHS:
        words = set(cheap["material list"].text[width].split())
        assert set(list_materials()) <= words
        assert numbers((1e3 * get_material(name).young_modulus for name in list_materials()), ".1f") <= words


def test_a_press_keeps_forces_and_depths_whole(cheap: dict[str, Shown]) -> None:
    from palpate.design import DomeSpec, build_skin
    from palpate.fea import WallSpec, solve_press
    from palpate.mesh import MeshSpec, mesh_skin
    from palpate.study import MaterialSpec

    mesh = mesh_skin(build_skin(DomeSpec()), MaterialSpec().mesh(MeshSpec(cells=4)))
    press = solve_press(mesh, MaterialSpec().material(), WallSpec(depth=0.4))
    for width in WIDTHS:
        words = set(cheap["press"].text[width].split())
        assert numbers(press.depth, ".2f") <= words
        assert numbers(press.force[:, 2], ".4f") <= words


def test_wide_shows_every_column_with_its_meaning(cheap: dict[str, Shown]) -> None:
    text = cheap["grid show, wide"].text[80]
    assert "more column" not in text
    assert "least-squares bound: " in text
    assert "bistable from" in text


RICH = """
import fcntl, json, struct, sys, termios
from rich.console import Console
from rich.table import Table
_, (width,) = json.load(sys.stdin)
fcntl.ioctl(1, termios.TIOCSWINSZ, struct.pack("HHHH", 50, width, 0, 0))
table = Table(title="materials")
for name in ("name", "law", "E kPa", "stretch", "stable", "fit"):
    table.add_column(name)
table.add_row("marechal_2020_dragon_skin_10", "ogden", "164.7", "1.06 to 4.97", "yes", "R2 0.998 of five samples")
print(f"\\x01\\x02{width}\\x02", end="", flush=True)
Console().print(table)
print("\\x030", end="", flush=True)
"""


def test_a_table_that_cuts_names_is_found(tmp_path: Path) -> None:
    (shown,) = show([""], [80], tmp_path, RICH)
    assert shown.faults
    assert "marechal_2020_dragon_skin_10" not in shown.text[80]


@cache
def verbs_with_tables() -> dict[str, bool]:
    """Every verb, and whether it prints a table."""
    return {verb: "--wide" in flags for verb, flags in verbs()}


def verb_of(words: str) -> str:
    """The verb of a command line."""
    starts = (" ".join(words.split()[:count]) for count in (1, 2, 3))
    return next(start for start in starts if start in verbs_with_tables())


def every_verb() -> dict[str, str]:
    """Words of every verb that prints a table, or lines as they come, on small inputs."""
    found = {name: new_words(name).replace(" --json", "") for name in COMMANDS} | DEAR
    return {
        name: words.format(data=DATA)
        for name, words in found.items()
        if verb_of(words) == "sensor live" or verbs_with_tables()[verb_of(words)]
    }


def run_group(folder: Path, group: str) -> None:
    """Run the verbs of a group in one folder, so that later ones read the results of earlier ones."""
    if group == "study":
        copy_artefacts(DATA / "small.yaml", folder / "small")
    shorten_recording(folder / "short")
    found: dict[str, tuple[dict[int, str], int]] = {}
    for name, words in words_of(group).items():
        if name == "benchmark score":
            predict(folder)
        # lines of readings are printed as they come, at one width
        each = [(width,) for width in WIDTHS] if name == "live" else [WIDTHS]
        shown = [show([words], widths, folder)[0] for widths in each]
        text = {width: one for part in shown for width, one in part.text.items()}
        found[name] = (text, max(part.code for part in shown))
    (folder / "shown.json").write_text(json.dumps(found))


def words_of(group: str) -> dict[str, str]:
    return {name: words for name, words in every_verb().items() if re.split("[ ,]", name)[0] in GROUPS[group]}


def shorten_recording(folder: Path) -> None:
    """Write the first 32 images of the recording: ten presses."""
    folder.mkdir()
    lines = (DATA / "recording" / "poses.csv").read_text().splitlines()[:33]
    (folder / "poses.csv").write_text("\n".join([*lines, ""]))
    for line in lines[1:]:
        shutil.copy(DATA / "recording" / line.split(",")[0], folder)


def predict(folder: Path) -> None:
    """Write predictions of zero for the test images of the set."""
    rows = (folder / "set/set/hidden.csv").read_text().splitlines()[1:]
    lines = [f"{row.split(',')[0]},0,0,3" for row in rows]
    (folder / "predictions.csv").write_text("\n".join(["image,rx_deg,ry_deg,depth_mm", *lines]) + "\n")


@pytest.mark.slow(60)
@pytest.mark.parametrize("group", GROUPS)
def test_every_verb_shows_its_tables_uncut(group: str) -> None:
    words = json.dumps(words_of(group), sort_keys=True)
    folder = stored_folder("terminal", [words], lambda made: run_group(made, group))
    found = {
        name: Shown({int(width): one for width, one in text.items()}, code)
        for name, (text, code) in json.loads((folder / "shown.json").read_text()).items()
    }
    assert {name: one.faults or one.code for name, one in found.items() if one.faults or one.code > 1} == {}
    assert {tuple(sorted(one.text)) for one in found.values()} == {WIDTHS}
    assert len(found) == len(words_of(group)) > 4


def test_every_verb_with_a_table_is_run_or_has_a_reason() -> None:
    tables = {verb for verb, printed in verbs_with_tables().items() if printed}
    assert {name for group in GROUPS for name in words_of(group)} == set(every_verb())
    assert tables - {verb_of(words) for words in every_verb().values()} == set(NOT_RUN)
