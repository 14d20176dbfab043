"""Damaged files at every door are taken or refused with a remedy; `benchmarks/fuzz_doors.py` is the long campaign."""

import contextlib
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from palpate.camera import Calibration, read_calibration, write_calibration
from palpate.camera.lens import make_lens
from palpate.core import ArtefactStore, PalpateError, Recipe
from palpate.core.store import find_corruption
from palpate.datasets import Dataset, DatasetSpec, read_dataset, sample_poses, write_dataset
from palpate.design import DomeSpec, build_skin, read_points
from palpate.fea import read_press
from palpate.learn import calibrate_interval, fit_ridge, open_predictor, read_estimator, write_estimator
from palpate.material import get_material, read_material, read_test_file, write_material
from palpate.study import read_study

SOURCE = Path(__file__).parents[3] / "src" / "palpate"
TOKENS = (
    b"nan",
    b"1e999",
    b"-1",
    b"[[[[",
    b"&a [*a]",
    b"!!python/object:os.system",
    b"\x00",
    b"\xff\xfe",
    b"\n",
    b",",
)

NESTED = b"a: " + b"[" * 1200
"""Nested more deeply than functions may call each other under hypothesis; deeper still takes seconds more."""

CHANGES = st.lists(
    st.tuples(st.integers(0, 10**6), st.integers(0, 30), st.one_of(st.binary(max_size=8), st.sampled_from(TOKENS))),
    min_size=1,
    max_size=5,
)
DAMAGED = settings(
    max_examples=40, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


def damage(good: bytes, changes: list[tuple[int, int, bytes]]) -> bytes:
    """Replace pieces of a good input, each given by its place, its length and what comes instead."""
    for place, length, instead in changes:
        at = place % (len(good) + 1)
        good = good[:at] + instead + good[at + length :]
    return good


def take_or_refuse(read: Callable[[Path], object], path: Path, content: bytes) -> None:
    path.write_bytes(content)
    with contextlib.suppress(PalpateError):
        read(path)


@pytest.fixture(scope="module")
def dataset() -> Dataset:
    """A dataset of forty presses of seven markers, linear in the pose."""
    spec = DatasetSpec(n_presses=40)
    poses = np.column_stack([sample_poses(spec), np.full(40, 4.0)])
    rest = np.random.default_rng(0).uniform(100, 200, (7, 2))
    moved = poses[:, :2] @ np.random.default_rng(1).normal(0, 3.0, (2, 14))
    return Dataset(
        spec=spec,
        images_px=rest + moved.reshape(40, 7, 2),
        poses=poses,
        press=np.arange(40),
        validation=np.arange(40) % 2 == 0,
        branch=np.full(40, "flat"),
        travel_mm=np.full(40, 1.0),
        rest_px=rest,
        image_size_px=(346, 260),
        solved_presses=1,
        dropped={},
    )


@given(changes=CHANGES)
@example(changes=[(0, 0, NESTED)])
@DAMAGED
def test_study_files(tmp_path: Path, changes: list[tuple[int, int, bytes]]) -> None:
    good = (SOURCE / "study" / "presets" / "first.yaml").read_bytes()
    take_or_refuse(read_study, tmp_path / "study.yaml", damage(good, changes))


@given(changes=CHANGES)
@DAMAGED
def test_marker_tables(tmp_path: Path, changes: list[tuple[int, int, bytes]]) -> None:
    dome = build_skin(DomeSpec())
    good = b"x_mm,y_mm,z_mm\n0,0,20\n12,0,16\n"
    take_or_refuse(lambda path: read_points(path, dome), tmp_path / "dots.csv", damage(good, changes))


@given(changes=CHANGES)
@DAMAGED
def test_material_tables(tmp_path: Path, changes: list[tuple[int, int, bytes]]) -> None:
    rows = "".join(f"{0.1 * i:.2f},{0.02 * i:.4f}\n" for i in range(20))
    good = f"Strain (mm/mm),Stress (MPa)\n{rows}".encode()
    (tmp_path / "tension.csv").write_bytes(good)
    assert read_test_file(tmp_path / "tension.csv")
    take_or_refuse(read_test_file, tmp_path / "tension.csv", damage(good, changes))


@given(changes=CHANGES)
@example(changes=[(0, 0, NESTED)])
@DAMAGED
def test_material_files(tmp_path: Path, changes: list[tuple[int, int, bytes]]) -> None:
    write_material(tmp_path / "good.yaml", get_material("zaid_2024_ecoflex_00_30"))
    good = (tmp_path / "good.yaml").read_bytes()
    take_or_refuse(read_material, tmp_path / "material.yaml", damage(good, changes))


@given(changes=CHANGES)
@DAMAGED
def test_manifests(tmp_path: Path, changes: list[tuple[int, int, bytes]]) -> None:
    recipe = Recipe("press", {"tilt_deg": 1.0})
    path = ArtefactStore(tmp_path).write(recipe, lambda path: path.write_text("force") and None)
    manifest = path.with_suffix(".manifest.json")
    manifest.write_bytes(damage(manifest.read_bytes(), changes))
    assert isinstance(find_corruption(path), str)


@given(changes=CHANGES)
@DAMAGED
def test_datasets(tmp_path: Path, dataset: Dataset, changes: list[tuple[int, int, bytes]]) -> None:
    write_dataset(tmp_path / "good.h5", dataset)
    take_or_refuse(read_dataset, tmp_path / "dataset.h5", damage((tmp_path / "good.h5").read_bytes(), changes))


@given(changes=CHANGES)
@DAMAGED
def test_presses(tmp_path: Path, changes: list[tuple[int, int, bytes]]) -> None:
    with h5py.File(tmp_path / "good.h5", "w") as file:
        file.attrs["kind"] = "palpate press"
        file.attrs["version"] = "of another year"
        file["depth"] = np.arange(10.0)
    take_or_refuse(read_press, tmp_path / "press.h5", damage((tmp_path / "good.h5").read_bytes(), changes))


@pytest.fixture(scope="module")
def model(dataset: Dataset, tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("model") / "good.onnx"
    write_estimator(path, calibrate_interval(fit_ridge(dataset), dataset))
    return path.read_bytes()


@DAMAGED
@given(changes=CHANGES)
@example(changes=[(860, 4, b"x")])
def test_lenses(tmp_path: Path, lens: bytes, changes: list[tuple[int, int, bytes]]) -> None:
    take_or_refuse(read_calibration, tmp_path / "lens.yaml", damage(lens, changes))


@pytest.fixture(scope="module")
def lens(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    found = Calibration(
        lens=make_lens("brown", (-0.1, 0.01, 1e-4, 0.0, 0.0)),
        width_px=346,
        height_px=260,
        intrinsics_px=np.array([300.0, 300.0, 173.0, 130.0]),
        rms_px=0.2,
        covariance=np.eye(9) * 1e-4,
        image_names=("a.png",),
        image_rms_px=np.array([0.2]),
        rejected=(),
        coverage=np.ones((6, 8), int),
        board=None,
    )
    path = tmp_path_factory.mktemp("lens") / "lens.yaml"
    write_calibration(path, found)
    return path.read_bytes()


@pytest.mark.parametrize("read", [read_estimator, open_predictor])
@given(changes=CHANGES)
@DAMAGED
def test_models(
    tmp_path: Path, model: bytes, read: Callable[[Path], object], changes: list[tuple[int, int, bytes]]
) -> None:
    take_or_refuse(read, tmp_path / "model.onnx", damage(model, changes))
