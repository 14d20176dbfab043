"""Give every door damaged files and words: no traceback, no hang, no crash, little memory.

    python benchmarks/fuzz_doors.py --count 1000 --seed 0 --out /tmp/fuzz

Each door gets `count` inputs, made from good ones by damage that only the seed and the number decide. A door may take
an input or refuse it by an error with a remedy; everything else is a finding, kept in the folder: a traceback, and a
file opened for writing, moved or removed outside the input's own folder. A door runs in a process of its own, which
is ended and started again after 10 s without an answer.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import multiprocessing
import os
import resource
import socket
import subprocess
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from urllib.parse import quote

import numpy as np

from palpate.core import PalpateError

HANG_S = 10.0
TOKENS = [
    *b"nan inf -inf 1e999 -1 0 1e-320 99999999999999999999 0x1F null true [] {} [[[[[[[[ {a: &a [*a] *b".split(),
    *b"!!python/object:os.system <<: , ; : # ' \" --- ../../ /etc/passwd \x00 \xff\xfe \xc2\xb2".split(b" "),
    *(b"\n", b"\r", b"\t", b" ", b"[" * 2000, b"a" * 5000, b"1," * 2000, "°µ∞\u202e".encode()),
]
WORDS = [
    *b"--height --thickness --markers --rings --layout --json --where --sort --out --help --dry-run -- - ---".split(),
    *b"design material list show grid status store check gc first paper 20 -1 0 nan inf 7 37 8 = . ../..".split(),
    *(b"10 mm", b"4 cm", b"", b"nowhere", b"/etc/passwd", b"/dev/null", b"a" * 3000, "\u202eé".encode()),
    *(b"markers > 3", b"markers ((", b"__import__('os')"),
]
COMMANDS = [["design"], ["material", "show"], ["material", "list"], ["grid", "show"], ["status"], ["store", "check"]]


def damage(good: bytes, random: np.random.Generator) -> bytes:
    """One to six damages of a good input."""
    data = bytearray(good)
    for _ in range(int(random.integers(1, 7))):
        at = int(random.integers(0, len(data) + 1))
        end = min(len(data), at + int(random.integers(1, 40)))
        how = int(random.integers(0, 7))
        if how == 0 and at < len(data):
            data[at] ^= 1 << int(random.integers(0, 8))
        elif how == 1:
            del data[at:end]
        elif how == 2:
            data[at:at] = data[at:end] * int(random.integers(1, 20))
        elif how == 3:
            data[at:at] = TOKENS[int(random.integers(0, len(TOKENS)))]
        elif how == 4:
            data[at:end] = TOKENS[int(random.integers(0, len(TOKENS)))]
        elif how == 5:
            data[at:end] = random.bytes(end - at)
        elif random.random() < 0.3:
            del data[at:]
    return bytes(data)


def damage_words(random: np.random.Generator) -> list[str]:
    """A cheap command with words after it that may or may not make sense."""
    command = COMMANDS[int(random.integers(0, len(COMMANDS)))]
    return [*command, *(WORDS[int(i)].decode() for i in random.integers(0, len(WORDS), int(random.integers(0, 7))))]


@dataclass(frozen=True)
class Door:
    """A way for files to come in: good ones, the ending of their names, and who reads them."""

    name: str
    suffix: str
    good: tuple[bytes, ...]
    read: Callable[[Path], object]


def _run_words(path: Path) -> object:
    from palpate.cli import main

    shown = io.StringIO()
    with contextlib.redirect_stdout(shown), contextlib.redirect_stderr(shown):
        try:
            main(json.loads(path.read_text()))
        except SystemExit as left:
            if left.code not in (0, 1, 2) or "palpate failed" in shown.getvalue():
                raise RuntimeError(f"exit code {left.code}: {shown.getvalue()[-300:]}") from None
            return left.code
    raise RuntimeError("the command did not end")


def _read_manifest(path: Path) -> object:
    from palpate.core.store import MANIFEST, find_corruption

    artefact = path.with_suffix(".h5")
    artefact.write_bytes(b"force")
    os.replace(path, artefact.with_suffix(MANIFEST))
    return find_corruption(artefact)


def _read_failures(path: Path) -> object:
    from palpate.study.status import _read_failures

    os.replace(path, path.with_name("failures.json"))
    return _read_failures(path.parent)


def _find_dots(path: Path) -> object:
    from palpate.camera import read_image
    from palpate.vision import prepare_detector

    image = read_image(path)
    return prepare_detector(image).find(image)


def _read_grid(path: Path) -> object:
    from palpate.study import read_grid

    os.replace(path, path.with_name("grid.sqlite"))
    return read_grid(path.parent)


def _calibration_door(folder: Path) -> Door:
    from palpate.camera import Calibration, read_calibration, write_calibration
    from palpate.camera.lens import make_lens

    lens = Calibration(
        lens=make_lens("brown", (-0.1, 0.01, 1e-4, 0.0, 0.0)),
        width_px=346,
        height_px=260,
        intrinsics_px=np.array([300.0, 300.0, 173.0, 130.0]),
        rms_px=0.2,
        covariance=np.eye(9) * 1e-4,
        image_names=("a.png", "b.png"),
        image_rms_px=np.array([0.2, 0.2]),
        rejected=(("c.png", "no board"),),
        coverage=np.ones((6, 8), int),
        board=None,
    )
    write_calibration(folder / "lens.yaml", lens)
    good = (folder / "lens.yaml").read_bytes()
    return Door("calibration", ".yaml", (good,), lambda path: read_calibration(path).camera_spec())


def _image_door(folder: Path) -> Door:
    import cv2

    from palpate.camera import RenderSpec, build_camera, flat_marker_outlines, render
    from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers

    dome = build_skin(DomeSpec())
    layout = place_markers(dome, MarkerSpec(count=37))
    normals = (layout.positions - [0, 0, dome.center_z]) / dome.radius
    image = render(
        build_camera(), flat_marker_outlines(layout.positions, normals, layout.diameter), RenderSpec(noise=2.0)
    )
    kinds = (".png", ".jpg", ".tif", ".bmp", ".pgm", ".webp")
    return Door("image", ".png", tuple(cv2.imencode(kind, image)[1].tobytes() for kind in kinds), _find_dots)


def _grid_door(folder: Path) -> Door:
    from palpate.study import SpecificationGrid
    from palpate.study.grid_database import write_database

    rows = tuple({"height_mm": 20.0, "markers": count, "rmse_deg": 0.1, "dome": "hemisphere"} for count in (7, 37))
    write_database(folder / "grid.sqlite", SpecificationGrid(rows))
    return Door("grid", ".sqlite", ((folder / "grid.sqlite").read_bytes(),), _read_grid)


TARGETS = (
    "/?design=1&other=0&tilt=3&depth=1.5&metric=rmse_deg&where=markers%20%3E%203",
    "/data/shell/0",
    "/data/motion/0?tilt=2.5&stress=true",
    "/data/markers/0?tilt=2&azimuth=30",
    "/data/markers.csv?name=0&tilt=2",
    "/data/dome.glb?name=0&depth=1&tilt=2&azimuth=40",
    "/data/grid.csv?where=markers%20%3E%203",
    "/design?height=20",
    "/live",
    "/_nicegui/../../../etc/passwd",
)
"""What is asked of the viewer; half of the inputs damage this alone, the others the whole request."""


def _request_door(folder: Path) -> Door:
    """A viewer at work on a small result folder; inputs are what comes in through its socket."""
    import threading

    from palpate.viewer.server import ServeSpec, serve

    (folder / "small.yaml").write_text(
        "name: small\ndesigns: {heights: [20 mm], thicknesses: [2 mm], markers: [7]}\nmesh: {cells: 6}\n"
        "tilts_deg: [0, 4]\nobstacle: {depth: 2.4 mm}\ndataset: {n_presses: 20, max_tilt_deg: 4, dropped_images: 0}\n"
    )
    results = folder / "results"
    words = ["run", str(folder / "small.yaml"), "--out", str(results), "--workers", "1"]
    entry = "from palpate.cli import main; main()"
    subprocess.run([sys.executable, "-c", entry, *words], check=True, capture_output=True)
    link: list[str] = []
    threading.Thread(target=serve, args=(results, ServeSpec(port=0), link.append), daemon=True).start()
    while not link:
        time.sleep(0.05)
    port = int(link[0].rstrip("/").rpartition(":")[2])

    def ask(target: bytes) -> bytes:
        end = f" HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nConnection: close\r\n\r\n"
        return b"GET " + target + end.encode()

    def knock_once(path: Path) -> bytes:
        given = path.read_bytes()
        return _send(port, ask(quote(given, safe="/?&=%+.:~,").encode()) if given.startswith(b"/") else given)

    targets = tuple(target.encode() for target in TARGETS)
    _send(port, ask(targets[0]), 60.0)
    return Door("request", ".http", (*targets, *map(ask, targets)), knock_once)


def _send(port: int, request: bytes, patience: float = 1.0) -> bytes:
    """The answer; a request without an end waits for the rest, so after it a whole one must be answered."""
    answer = b""
    connection = socket.create_connection(("127.0.0.1", port), timeout=patience)
    with connection, contextlib.suppress(ConnectionError, TimeoutError):
        connection.sendall(request)
        while part := connection.recv(65536):
            answer += part
    status = answer.split(b" ", 2)[1:2]
    if status and status[0].startswith(b"5"):
        raise RuntimeError(f"the viewer stumbled: {answer[:300]!r} over {request!r}")
    if status and status[0].startswith(b"2"):
        return answer
    if patience < 0.8 * HANG_S:
        whole = f"GET /data/grid.csv HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nConnection: close\r\n\r\n"
        if b"200 OK" not in _send(port, whole.encode(), 0.8 * HANG_S):
            raise RuntimeError(f"the viewer answers nothing any more after {request!r}")
    raise PalpateError(f"refused: {status}", "", code="fuzz-refused")


def _study_door(_: Path) -> Door:
    from palpate.study import list_presets, read_study

    presets = Path(__file__).parents[1] / "src" / "palpate" / "study" / "presets"
    return Door(
        "study", ".yaml", tuple((presets / f"{name}.yaml").read_bytes() for name in list_presets()), read_study
    )


def _points_door(_: Path) -> Door:
    from palpate.design import DomeSpec, build_skin, read_points

    dome = build_skin(DomeSpec())
    good = (b"x_mm,y_mm\n1,0\n5,5\n", b"x_mm,y_mm,z_mm\n0,0,20\n12,0,16\n")
    return Door("points", ".csv", good, lambda path: read_points(path, dome))


def _bench_door(_: Path) -> Door:
    from palpate.material import read_test_file

    stress = "\n".join(f"{0.1 * i:.2f},{0.02 * i:.4f}" for i in range(20))
    strain = "\n".join(f"{0.1 * i:.2f};{0.3 * i:.4f}" for i in range(20))
    good = (f"Strain (mm/mm),Stress (MPa)\n{stress}\n".encode(), f"strain (%);stress (kPa)\n{strain}\n".encode())
    return Door("bench", "-tension.csv", good, read_test_file)


def _material_door(_: Path) -> Door:
    from palpate.material import read_material

    library = Path(__file__).parents[1] / "src" / "palpate" / "material" / "library"
    good = tuple(path.read_bytes() for path in sorted(library.glob("*.yaml"))[:6])
    return Door("material", ".yaml", good, read_material)


def _press_door(folder: Path) -> Door:
    from palpate.design import DomeSpec, build_skin
    from palpate.fea import WallSpec, read_press, solve_press, write_press
    from palpate.material import get_material
    from palpate.mesh import MeshSpec, mesh_skin

    mesh = mesh_skin(build_skin(DomeSpec()), MeshSpec(cells=4))
    press = solve_press(mesh, get_material("zaid_2024_ecoflex_00_30"), WallSpec(depth=0.1, depth_step=0.1))
    write_press(folder / "press.h5", press)
    return Door("press", ".h5", ((folder / "press.h5").read_bytes(),), read_press)


def _dataset(presses: int = 40, markers: int = 7):  # type: ignore[no-untyped-def]
    from palpate.datasets import Dataset, DatasetSpec, sample_poses

    spec = DatasetSpec(n_presses=presses)
    poses = np.column_stack([sample_poses(spec), np.full(presses, 4.0)])
    rest = np.random.default_rng(0).uniform(100, 200, (markers, 2))
    moved = poses[:, :2] @ np.random.default_rng(1).normal(0, 3.0, (2, 2 * markers))
    return Dataset(
        spec=spec,
        images_px=rest + moved.reshape(presses, markers, 2),
        poses=poses,
        press=np.arange(presses),
        validation=np.arange(presses) % 2 == 0,
        branch=np.full(presses, "flat"),
        travel_mm=np.full(presses, 1.0),
        rest_px=rest,
        image_size_px=(346, 260),
        solved_presses=1,
        dropped={},
    )


def _dataset_door(folder: Path) -> Door:
    from palpate.datasets import read_dataset, write_dataset

    write_dataset(folder / "dataset.h5", _dataset())
    return Door("dataset", ".h5", ((folder / "dataset.h5").read_bytes(),), read_dataset)


def _model(folder: Path) -> bytes:
    from palpate.learn import calibrate_interval, fit_ridge, write_estimator

    dataset = _dataset()
    write_estimator(folder / "model.onnx", calibrate_interval(fit_ridge(dataset), dataset))
    return (folder / "model.onnx").read_bytes()


def _estimator_door(folder: Path) -> Door:
    from palpate.learn import read_estimator

    return Door("estimator", ".onnx", (_model(folder),), read_estimator)


def _predictor_door(folder: Path) -> Door:
    from palpate.learn import open_predictor

    return Door("predictor", ".onnx", (_model(folder),), open_predictor)


def _manifest(folder: Path) -> bytes:
    from palpate.core import ArtefactStore, Recipe

    path = ArtefactStore(folder).write(Recipe("press", {"a": [1, 2]}), lambda path: path.write_text("force") and None)
    return path.with_suffix(".manifest.json").read_bytes()


MAKERS: dict[str, Callable[[Path], Door]] = {
    "study": _study_door,
    "points": _points_door,
    "bench": _bench_door,
    "material": _material_door,
    "press": _press_door,
    "dataset": _dataset_door,
    "estimator": _estimator_door,
    "predictor": _predictor_door,
    "manifest": lambda folder: Door("manifest", ".json", (_manifest(folder),), _read_manifest),
    "failures": lambda _: Door("failures", ".json", (b'[{"task": "press", "reason": "thin"}]',), _read_failures),
    "calibration": _calibration_door,
    "image": _image_door,
    "grid": _grid_door,
    "request": _request_door,
    "words": lambda _: Door("words", ".json", (), _run_words),
}
"""How the good inputs of each door are made; some are solved and trained, in seconds."""


def make_input(door: Door, seed: int, number: int) -> bytes:
    """The input of this number: the same from the same seed."""
    random = np.random.default_rng([seed, number])
    if not door.good:
        return json.dumps(damage_words(random)).encode()
    return damage(door.good[int(random.integers(0, len(door.good)))], random)


class Fence:
    """Notes what this process writes, moves or removes outside a folder; files of the system and caches excepted."""

    EVENTS = frozenset(
        {"open", "os.rename", "os.remove", "os.mkdir", "os.rmdir", "os.symlink", "os.link", "shutil.move"}
    )

    def __init__(self, folder: Path) -> None:
        self.folder, self.crossed = os.path.realpath(folder), list[str]()
        sys.addaudithook(self._look)

    def _look(self, event: str, words: tuple[object, ...]) -> None:
        if event not in self.EVENTS or (event == "open" and not self._writes(words)):
            return
        for word in words[:2]:
            if isinstance(word, str | bytes) and not (event == "open" and word is not words[0]):
                place = os.path.realpath(os.fsdecode(word))
                if not place.startswith((self.folder, "/dev/", "/proc/")) and "cache" not in place.lower():
                    self.crossed.append(f"{event} {place}")

    @staticmethod
    def _writes(words: tuple[object, ...]) -> bool:
        flags = words[2] if len(words) > 2 and isinstance(words[2], int) else 0
        return bool(flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT))


def knock(name: str, seed: int, numbers: range, answers: Connection) -> None:
    """Give a door its inputs; tell after each its number, the finding, and the memory so far in MiB."""
    with tempfile.TemporaryDirectory() as text:
        folder = Path(text)
        os.chdir(folder)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
        try:
            door = MAKERS[name](folder)
        except Exception:
            answers.send(traceback.format_exc())
            return
        answers.send("")
        fence = Fence(folder)
        for number in numbers:
            path = folder / "inside" / f"input{door.suffix}"
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(make_input(door, seed, number))
            started, finding = time.perf_counter(), ""
            try:
                door.read(path)
                how = "taken"
            except PalpateError:
                how = "refused"
            except BaseException:
                how, finding = "finding", traceback.format_exc(limit=-4)
            if fence.crossed:
                how, finding = "finding", "\n".join(["outside:", *fence.crossed])
                fence.crossed.clear()
            memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
            answers.send((number, how, finding, time.perf_counter() - started, memory))


@dataclass
class Tally:
    """How a door took its inputs."""

    how: Counter[str]
    slowest_s: float = 0.0
    memory_mib: float = 0.0


def watch(name: str, count: int, seed: int, keep: Path) -> Tally:
    """Give a door all of its inputs, over crashes and hangs."""
    tally, number = Tally(Counter()), 0
    context = multiprocessing.get_context("spawn")
    while number < count:
        ours, theirs = context.Pipe()
        process = context.Process(target=knock, args=(name, seed, range(number, count), theirs), daemon=True)
        process.start()
        theirs.close()
        if ours.poll(180) and (fault := ours.recv()):
            raise SystemExit(f"The good inputs of the door {name} cannot be made:\n{fault}")
        while number < count:
            try:
                answer = ours.recv() if ours.poll(HANG_S) else None
            except EOFError:
                answer = (number, "crash", f"the process died with exit code {process.exitcode}", 0.0, 0.0)
            number, how, finding, seconds, memory = answer or (
                number,
                "hang",
                f"no answer in {HANG_S} s",
                HANG_S,
                0.0,
            )
            tally.how[how] += 1
            tally.slowest_s, tally.memory_mib = max(tally.slowest_s, seconds), max(tally.memory_mib, memory)
            if finding:
                _keep(keep, f"{name}-{seed}-{number}", finding)
            number += 1
            if how in ("crash", "hang"):
                break
        process.kill()
        process.join()
    return tally


def _keep(folder: Path, name: str, finding: str) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.txt").write_text(finding)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("doors", nargs="*", default=list(MAKERS), help=f"of {', '.join(MAKERS)}; all without any")
    parser.add_argument("--count", type=int, default=1000, help="inputs a door")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("fuzz"), help="folder for findings")
    chosen = parser.parse_args()
    print("| door | taken | refused | findings | hangs | crashes | ms an input | slowest, s | memory, MiB |")
    print("|---|---|---|---|---|---|---|---|---|")
    bad = 0
    for name in chosen.doors:
        started = time.perf_counter()
        tally = watch(name, chosen.count, chosen.seed, chosen.out)
        mean_ms = (time.perf_counter() - started) / chosen.count * 1000
        counts = [tally.how[how] for how in ("taken", "refused", "finding", "hang", "crash")]
        shown = " | ".join(str(count) for count in counts)
        print(f"| {name} | {shown} | {mean_ms:.1f} | {tally.slowest_s:.2f} | {tally.memory_mib:.0f} |", flush=True)
        bad += sum(counts[2:])
    raise SystemExit(1 if bad else 0)


if __name__ == "__main__":
    main()
