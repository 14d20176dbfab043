import json
from pathlib import Path

import pytest

from errors import refused
from palpate.core import ArtefactStore, Recipe
from palpate.core import store as core_store

RECIPE = Recipe(kind="press", spec={"tilt_deg": 5.0, "depth": 8.0}, inputs=("abc",), version="1")


@pytest.fixture
def store(tmp_path: Path) -> ArtefactStore:
    return ArtefactStore(tmp_path / "store")


def write_text(store: ArtefactStore, text: str = "force") -> Path:
    return store.write(RECIPE, lambda path: path.write_text(text) and None)


def test_key_does_not_depend_on_the_order_of_the_spec() -> None:
    other = Recipe(kind="press", spec={"depth": 8.0, "tilt_deg": 5.0}, inputs=("abc",), version="1")
    assert other.key == RECIPE.key


@pytest.mark.parametrize(
    "changed",
    [
        Recipe("dataset", RECIPE.spec, RECIPE.inputs, "1"),
        Recipe("press", {"tilt_deg": 5.0, "depth": 7.9}, RECIPE.inputs, "1"),
        Recipe("press", RECIPE.spec, ("abd",), "1"),
        Recipe("press", RECIPE.spec, RECIPE.inputs, "2"),
    ],
)
def test_anything_that_matters_changes_the_key(changed: Recipe) -> None:
    assert changed.key != RECIPE.key


def test_a_written_artefact_is_found_with_its_manifest(store: ArtefactStore) -> None:
    assert store.find(RECIPE) is None
    path = write_text(store)
    assert store.find(RECIPE) == path
    assert path.read_text() == "force"
    manifest = json.loads(path.with_suffix(".manifest.json").read_text())
    assert manifest["spec"] == RECIPE.spec
    assert manifest["inputs"] == ["abc"]
    assert "numpy" in manifest["made_by"]


def test_a_broken_artefact_is_set_aside_and_can_be_made_again(store: ArtefactStore) -> None:
    path = write_text(store)
    path.write_text("forge")
    assert store.find(RECIPE) is None
    assert path.with_name(path.name + ".broken").read_text() == "forge"
    write_text(store)
    assert store.find(RECIPE) == path


def test_an_artefact_that_another_process_sets_aside_in_the_meantime_is_missing(
    store: ArtefactStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    checksum = core_store._checksum
    write_text(store)
    monkeypatch.setattr(core_store, "_checksum", lambda path: path.unlink() or checksum(path))
    assert store.find(RECIPE) is None


def test_an_artefact_without_manifest_counts_as_missing(store: ArtefactStore) -> None:
    write_text(store).with_suffix(".manifest.json").unlink()
    assert store.find(RECIPE) is None


def test_a_writer_that_fails_leaves_nothing(store: ArtefactStore) -> None:
    def fail(path: Path) -> None:
        path.write_text("half")
        raise RuntimeError("power cut")

    with pytest.raises(RuntimeError):
        store.write(RECIPE, fail)
    assert store.find(RECIPE) is None
    assert [path for path in store.root.rglob("*") if path.is_file()] == []


def test_a_folder_that_cannot_be_written_is_an_error_with_a_remedy(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("not a folder")
    with refused("store-unwritable", "--out"):
        write_text(ArtefactStore(tmp_path / "file"))


@pytest.mark.parametrize("key", ["", "a", "../up", "ABC", "g" * 8, "0" * 65, "00/00"])
def test_a_key_that_is_not_one_never_leaves_the_store(store: ArtefactStore, key: str) -> None:
    good = "0123456789abcdef"
    assert store.locate("press", good, ".h5").name == f"{good}.h5"
    assert store.locate("press", good).is_relative_to(store.root / "press")
    with refused("artefact-key-malformed", key[:40]):
        store.locate("press", key)
    with refused("artefact-kind-malformed"):
        store.locate("../press", good)
