"""Every door of `palpate`: for each command, words that are right, so that one wrong word at a time can be tried.

``{name}`` stands for a path of the fixture `house`. `files` are inputs that are read: a wrong one of each kind is
tried in the place of the right one. `outputs` are written: each is tried where nothing can be written. `against` are
words that contradict each other or are out of bounds in their own way.
"""

import sys
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np
from palpate_benchmark import PRESETS

from drawn_tactip import DrawnSensor, draw_motions, draw_recording
from palpate.camera import RenderSpec, build_camera, flat_marker_outlines, render
from palpate.datasets import Normalisation
from palpate.design import DomeSpec, MarkerSpec, Skin, build_skin, place_markers, place_orientation_mark
from palpate.learn import Estimator, write_estimator
from palpate.study import evaluate_grid, write_grid
from palpate.surrogate import Twin, write_twin
from palpate.surrogate.surface_series import place_circles
from palpate.surrogate.tensor_spline import fit_spline
from palpate.surrogate.twin import FORCES

sys.path.append(str(Path(__file__).parents[1] / "grid"))
from results import PAPER


@dataclass(frozen=True)
class Row:
    words: str = ""
    files: tuple[str, ...] = ()
    outputs: tuple[str, ...] = ()
    against: tuple[str, ...] = ()
    skip: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """Kinds of wrong file that are right for an input, by its name."""
    few: str = ""
    """Words beside which a wrong file is tried, where `words` compute for long before they come to it."""


FIT, TESTS = (
    "--files {curve} --relaxation {relax} --alone",
    ("--files", "--tension", "--compression", "--uniaxial", "--equibiaxial", "--planar", "--relaxation"),
)
BUILT = "--markers 37"
SOLVE = (
    "--backend none",
    "--contact sticky",
    "--contact 11",
    "--rim round",
    "--material cheese",
    "--material {text}",
)

ROWS = {
    "run": Row("--study first --out new", ("--study",), ("--out",), ("--workers 0", "--timeout 0", "--cluster here")),
    "study status": Row("--study first --out {results}", ("--study", "--out")),
    "study store check": Row("--folder {spare}", ("--folder",)),
    "study store gc": Row("{study} --folder {spare}", ("--folder", "STUDIES")),
    "press": Row("--cells 4", ("--points",), ("--export",), (*SOLVE, "--solver calculix --unload", "--branch up")),
    "design deck": Row(
        "--output new.inp --cells 4", (), ("--output",), (*SOLVE[1:], "--dialect x", "--element shells")
    ),
    "design stability": Row("--cells 4", (), (), (*SOLVE[1:], "--tilts 50", "--tilts -1", "--tilts x")),
    "design convergence": Row(
        "--out new",
        ("--layout",),
        ("--out",),
        (*SOLVE[1:], "--meshes 8", "--meshes 2 8", "--meshes x", "--markers 8"),
    ),
    "design profile": Row("--file {profile}", ("--file",), ("--out",), ("--thickness 0", "--thickness 40")),
    "design show": Row("", ("--layout",), (), ("--markers 8", "--rings 20 10", "--rings 10 --layout {text}")),
    "material fit": Row(
        FIT,
        TESTS,
        ("--output", "--figure"),
        (
            "--model x",
            "--toe x",
            "--figure a.txt",
            "--moduli x",
            "--time-unit year",
            "--relaxation {curve}",
            "--tension {relax}",
        ),
        few="--files {curve}",
    ),
    "material list": Row(),
    "material show": Row(
        "--name yeoh:1,1,1",
        ("--name",),
        (),
        ("--name cheese", "--name yeoh:1", "--name yeoh:nan,1,1", "--name yeoh:inf,1,1"),
    ),
    "design bound": Row("--source first --out new", ("--source",), ("--out",), ("--workers 0",)),
    "calibration predict": Row(
        "--source first --out new",
        ("--source", "--layout"),
        ("--out",),
        (
            "--workers 0",
            "--calibration-presses 0",
            "--tolerance x=1",
            "--cluster local:2",
            "--height 10",
            "--material cheese",
        ),
    ),
    "study show": Row("--directory {results}", ("--directory",), (), ("--where x>1", "--where (", "--sort x")),
    "study plot": Row(
        "--directory {results} --out new", ("--directory",), ("--out",), ("--kind pie", "--metric x", "--where x>1")
    ),
    "study export": Row(
        "--directory {results} --to new.csv", ("--directory",), ("--to",), ("--to a.txt", "--where x>1")
    ),
    "study model": Row(
        "--directory {results} --out new.onnx", ("--directory",), ("--out",), ("--where markers>999", "--sort x")
    ),
    "study compare": Row(
        "--first {results} --second {results}", ("--first", "--second"), (), ("--metric x", "--metric shape")
    ),
    "view": Row(
        "--results {results} --port 0",
        ("--results",),
        (),
        ("--token short", "--port 70000", "--port -1", "--host no.where"),
        {"--results": ("folder",)},  # its page says what to do
    ),
    "search": Row(
        "--requirements {wanted} --out new",
        ("--requirements",),
        ("--out",),
        ("--skins 0", "--workers 0", "--cluster here", "--timeout 5", "--sampler luck", "--validate maybe"),
    ),
    "claims": Row("{results} --out new.md", ("RESULTS",), ("--out", "--figures"), ("--out new.txt",)),
    "design make": Row(
        "--out new",
        ("--layout", "--lens"),
        ("--out",),
        ("--markers 8", "--camera x", "--mapping x", "--material cheese"),
    ),
    "design export": Row(
        "--to mjcf --out new --cells 4",
        ("--lens",),
        ("--out",),
        ("--to sdf", "--depth 0.5", "--material cheese", "--contact sticky", "--density 1", "--skin x"),
    ),
    "design specimens": Row("--out new", (), ("--out",), ("--count 0",)),
    "calibration camera": Row(
        "--folder {photos} --board chessboard:9x6:25",
        ("--folder",),
        ("--out", "--print-board"),
        ("--board x", "--lens x"),
    ),
    "sensor detect": Row("--folder {images}", ("--folder",), (), ("--polarity x", "--method x")),
    "sensor check": Row(
        "--source {images}", ("--source", "--press"), ("--out",), ("--polarity x", "--rest-images 0", "--focus -1")
    ),
    "sensor live": Row(
        f"--model {{model}} --source {{images}} {BUILT}",
        ("--model", "--source", "--layout", "--lens", "--unit", "--press-image"),
        ("--out",),
        (
            "--out a.txt",
            "--press-pose 1 2 3",
            "--press-image {image}",
            "--count 0",
            "--rest-images 99",
            "--markers 91",
            "--material cheese",
        ),
    ),
    "sensor serve": Row(
        f"--model {{model}} --source {{images}} {BUILT} --port 0",
        ("--model", "--source", "--layout", "--lens", "--unit"),
        (),
        ("--token short", "--port 70000", "--host no.where", "--rest-images 99", "--markers 91"),
    ),
    "calibration inspect": Row(
        f"--image {{image}} {BUILT}",
        ("--image", "--layout", "--lens"),
        ("--out", "--picture"),
        ("--out a.txt", "--picture a.txt"),
    ),
    "simulation bench": Row(
        f"--model {{model}} --out new {BUILT} --units 1",
        ("--model", "--layout"),
        ("--out",),
        (
            "--tolerance x=1",
            "--tolerance dot",
            "--tolerance marker_position=-1",
            "--tolerance marker_position=nan",
            "--tolerance marker_position=x",
            "--contact 11",
            "--contact nan",
            "--contact sticky",
            "--solver x",
            "--markers 91",
            "--min-depth 9",
        ),
    ),
    "benchmark make": Row(
        "--spec tiny --out new",
        ("--spec",),
        ("--out",),
        ("--workers 0", "--seed -1", "--cluster local:2", "--timeout 5"),
    ),
    "benchmark score": Row(
        "--predictions {predictions} --set {set} --out new.csv",
        ("--predictions", "--set"),
        ("--out",),
        ("--out a.txt", "--track dots", "--track pictures", "--predictions {truth}"),
    ),
    "benchmark baselines": Row(
        "--set {set} --out new --spec tiny --only twin",
        ("--set", "--spec"),
        ("--out",),
        ("--only luck", "--workers 0", "--timeout 5"),
    ),
    "calibration identify": Row(
        f"--truth {{truth}} --model {{twin}} {BUILT}",
        ("--truth", "--model", "--layout", "--lens", "--unit"),
        ("--out", "--report"),
        ("--height 10", "--robot-tilt 0", "--robot-depth 9", "--robot-force 0"),
    ),
    "recording train": Row(
        "--recording {recording} --out new --estimators ridge",
        ("--recording", "--rest", "--from", "--forces"),
        ("--out",),
        (
            "--targets nothing",
            "--image nothing",
            "--press nothing",
            "--angles turns",
            "--lengths feet",
            "--times s",
            "--force-unit N",
            "--euler xx",
            "--estimators x",
            "--correspondence x",
            "--test-share 0.7",
            "--from {twin}",
        ),
    ),
    "recording take": Row(
        f"--out new --robot simulated --model {{twin}} {BUILT} --tilts 1 --azimuths 1 --depths 1 --dwell 0",
        ("--model", "--layout", "--lens", "--unit"),
        ("--out",),
        (
            "--robot manual",
            "--robot nobody --source {recording}",
            "--robot manual --source {nowhere}",
            "--source 0",
            "--depth 9",
            "--max-tilt 13",
            "--tilts 0",
            "--next 101",
            "--model {model}",
            "--out {results}",
        ),
    ),
    "simulation align": Row(
        f"--model {{twin}} --out new {BUILT} --walls 1",
        ("--model", "--layout"),
        ("--out",),
        (
            "--walls 0",
            "--calibration-presses 9",
            "--tolerance 0",
            "--force 0.000001",
            "--wall-tilt-compliance 6",
            "--clamping-force -1",
            "--model {model}",
            "--height 10",
            "--level 2",
        ),
    ),
    "calibration accept": Row(
        f"--truth {{truth}} --model {{model}} {BUILT} --no-zero --min-depth 0",
        ("--truth", "--model", "--readings", "--layout", "--lens", "--unit", "--gauge-study"),
        ("--out",),
        ("--readings {truth}", "--markers 91", "--gauge-study {truth}", "--roller-distance 0"),
    ),
    "verify": Row("--only cook", (), (), ("--only no-such-case",)),
    "doctor": Row(),
}


def furnish(folder: Path) -> dict[str, Path]:
    """Right and wrong inputs of every kind, by name."""
    dome = build_skin(DomeSpec())
    layout = place_markers(dome, MarkerSpec(count=37))
    points = np.vstack([layout.positions, place_orientation_mark(dome, layout)])
    edges = flat_marker_outlines(points, (points - [0, 0, dome.center_z]) / dome.radius, layout.diameter)
    right = {name: folder / name for name in ("images", "photos", "results", "spare")}
    right["images"].mkdir()
    for number in range(3):
        cv2.imwrite(str(right["images"] / f"{number}.png"), render(build_camera(), edges, RenderSpec(seed=number)))
    right["photos"] = Path(__file__).parents[1] / "camera" / "data" / "chessboard_opencv"
    right["image"] = right["images"] / "0.png"
    right["truth"] = right["images"] / "truth.csv"
    right["truth"].write_text("image,press,rx_deg,ry_deg,depth_mm\n0.png,rest,,,\n1.png,1,1,0,3\n2.png,2,1,0,4\n")
    write_grid(right["results"], evaluate_grid(PAPER[:2]))
    (right["spare"] / "store").mkdir(parents=True)
    right["profile"] = folder / "tip.csv"
    angle = np.linspace(0, np.pi / 2, 50)
    rows = "\n".join(f"{r},{z}" for r, z in zip(20 * np.sin(angle), 20 * np.cos(angle), strict=True))
    right["profile"].write_text(f"r_mm,z_mm\n{rows}\n")
    right["study"] = folder / "study.yaml"
    right["study"].write_text("name: small\n")
    right["wanted"] = folder / "wanted.yaml"
    right["wanted"].write_text("name: wanted\n")
    right["curve"] = folder / "tension.csv"
    strain = np.linspace(0, 1, 40)
    rows = "\n".join(f"{x},{0.1 * x}" for x in strain)
    right["curve"].write_text(f"strain (mm/mm),stress (MPa)\n{rows}\n")
    right["relax"] = folder / "held.csv"
    rows = "\n".join(f"{t},{0.8 + 0.2 * np.exp(-t)}" for t in np.geomspace(0.01, 100, 40))
    right["relax"].write_text(f"time (s),stress (MPa)\n{rows}\n")
    right["model"] = folder / "model.onnx"
    write_estimator(right["model"], still_model(build_camera().project(layout.positions)))
    right["recording"] = folder / "recording"
    draw_recording(right["recording"], draw_motions(8, shear=1.0), DrawnSensor(rings=3))
    right["set"], right["predictions"] = folder / "set", folder / "predictions.csv"
    draw_set(right["set"], right["predictions"])
    right["twin"] = folder / "twin.h5"
    write_twin(right["twin"], still_twin(dome))
    kept = right["results"] / "store" / "estimator" / "ff" / "ff.onnx"
    kept.parent.mkdir(parents=True)
    kept.write_bytes(right["model"].read_bytes())
    wrong = {"nowhere": folder / "nowhere", "folder": folder / "folder"}
    wrong["folder"].mkdir()
    contents = {"empty": b"", "text": b"colour, taste\nred, sweet\n", "noise": bytes(range(128, 256)) * 40}
    contents["half"] = right["model"].read_bytes()[:200]
    for name, content in contents.items():
        wrong[name] = folder / name
        wrong[name].write_bytes(content)
    return {**right, **wrong}


def draw_set(folder: Path, predictions: Path) -> None:
    """The tables of a benchmark of one image, and what somebody says of it."""
    folder.mkdir()
    (folder / "spec.json").write_text(PRESETS["tiny"].model_dump_json())
    (folder / "SHA256SUMS").write_text("")
    (folder / "test.csv").write_text("image,design,unit,picture\n7,H20_T2_M19,6,\n")
    (folder / "hidden.csv").write_text(
        "image,press,rx_deg,ry_deg,depth_mm,force_n,shear_n,friction,branch\n7,1,1,0,3,0.1,0,1,flat\n"
    )
    predictions.write_text("image,rx_deg,ry_deg,depth_mm\n7,1,0,3\n")


def still_twin(dome: Skin) -> Twin:
    """A twin of a dome that nothing moves."""
    tilts, depths = np.arange(0.0, 12.1, 4.0), np.arange(0.0, 8.1, 2.0)
    axes = (np.zeros(1), tilts, depths)
    pressed, drifts = (np.zeros((1, len(tilts), len(depths), parts * (1 + FORCES))) for parts in (3, 3))
    return Twin(
        skin=dome,
        order=np.zeros(1, int),
        modes=np.zeros((1, 3, len(place_circles()))),
        tilts_deg=tilts,
        depths_mm=depths,
        inverse_frictions=np.zeros(1),
        max_depth_mm=np.full((1, len(tilts)), 8.0),
        amplitudes=fit_spline(axes, pressed),
        lateral=fit_spline(axes, drifts),
    )


def still_model(rest: "np.ndarray[tuple[int, int], np.dtype[np.float64]]") -> Estimator:
    """A model of 37 markers that always says zero."""
    return Estimator(
        normalisation=Normalisation((173.0, 130.0), (173.0, 130.0)),
        weights=(np.zeros((1, 74, 3)),),
        biases=(np.zeros((1, 3)),),
        activation="relu",
        output_mean=np.zeros(3),
        output_sd=np.ones(3),
        rest_px=rest,
        seed=0,
        made_by={"method": "test"},
        training_images=1,
        validation_images=0,
    )
