import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from errors import refused
from palpate.core import ArtefactStore, PalpateError, Recipe, check_store, clean_store, list_store
from palpate.core.store import StoreError
from palpate.core.store_lock import can_lock, is_locked, take_lock

ONE, TWO = Recipe("press", {"tilt_deg": 1.0}), Recipe("press", {"tilt_deg": 2.0})


@pytest.fixture
def store(tmp_path: Path) -> ArtefactStore:
    store = ArtefactStore(tmp_path / "store")
    for recipe in (ONE, TWO):
        store.write(recipe, lambda path: path.write_text("force") and None)
    return store


def damage(path: Path, how: str) -> None:
    manifest = path.with_suffix(".manifest.json")
    content = json.loads(manifest.read_text())
    if how == "truncated":
        path.write_text("forc")
    elif how == "bit flipped":
        path.write_text("forcd")
    elif how == "zero length":
        path.write_text("")
    elif how == "manifest missing":
        manifest.unlink()
    elif how == "manifest is no JSON":
        manifest.write_text('{"kind": ')
    elif how == "manifest is nested without end":
        manifest.write_text("[" * 100_000)
    elif how == "manifest is a list":
        manifest.write_text("[1, 2]")
    elif how == "wrong schema":
        del content["sha256"]
        manifest.write_text(json.dumps(content))
    elif how == "of another artefact":
        manifest.write_text(json.dumps({**content, "key": TWO.key}))


FAULTS = {
    "truncated": "It has 4 bytes instead of 5.",
    "bit flipped": "Its content has changed: the checksum differs.",
    "zero length": "It is empty.",
    "manifest missing": "Its manifest is missing.",
    "manifest is no JSON": "Its manifest cannot be read.",
    "manifest is nested without end": "Its manifest cannot be read.",
    "manifest is a list": "Its manifest has no checksum.",
    "wrong schema": "Its manifest has no checksum.",
    "of another artefact": "Its manifest is that of another artefact.",
}


@pytest.mark.parametrize("how", FAULTS)
def test_check_store_sets_a_broken_artefact_aside_with_its_reason(store: ArtefactStore, how: str) -> None:
    path = store.path(ONE)
    damage(path, how)
    read, broken = check_store(store.root)
    assert read == 2
    assert [(item.path, item.reason) for item in broken] == [(path, FAULTS[how])]
    assert path.with_name(path.name + ".broken.reason").read_text() == FAULTS[how] + "\n"
    assert not path.exists()
    assert store.find(TWO) is not None
    assert check_store(store.root) == (1, ())


@pytest.mark.parametrize("how", FAULTS)
def test_a_broken_artefact_is_never_found(store: ArtefactStore, how: str) -> None:
    damage(store.path(ONE), how)
    assert store.find(ONE) is None
    assert store.find(TWO) is not None


@pytest.mark.parametrize("how", [how for how in FAULTS if how not in ("bit flipped", "of another artefact")])
def test_planning_sees_by_the_size_that_an_artefact_is_broken(store: ArtefactStore, how: str) -> None:
    assert store.has(ONE)
    damage(store.path(ONE), how)
    assert not store.has(ONE)
    assert store.path(ONE).with_name(store.path(ONE).name + ".broken").exists()


def test_a_manifest_of_before_sizes_were_noted_is_held_to_its_checksum(store: ArtefactStore) -> None:
    manifest = store.path(ONE).with_suffix(".manifest.json")
    content = json.loads(manifest.read_text())
    del content["bytes"]
    manifest.write_text(json.dumps(content, indent=2))
    assert store.has(ONE)
    store.path(ONE).write_text("forcd")
    assert not store.has(ONE)


def test_list_store_tells_whole_from_quarantined_and_working(store: ArtefactStore) -> None:
    store.path(ONE).write_text("forg")
    assert store.find(ONE) is None
    with store.lease(ONE) as free:
        assert free
        stored = list_store(store.root)
    assert stored.artefacts == {("press", f"{TWO.key}.h5")}
    assert stored.quarantined == {("press", f"{ONE.key}.h5.broken")}
    assert stored.working == {("press", ONE.key)}
    assert list_store(store.root).working == frozenset()


def test_list_store_of_nothing_is_empty(tmp_path: Path) -> None:
    assert list_store(tmp_path / "none").artefacts == frozenset()


def test_clean_store_takes_away_only_what_no_study_needs(store: ArtefactStore) -> None:
    journal = store.path(ONE, ".journal")
    journal.write_text("trials")
    only_listed = clean_store(store.root, [ONE.key], dry_run=True)
    assert store.find(TWO) is not None
    removed = clean_store(store.root, [ONE.key])
    assert removed == only_listed
    assert {removal.path for removal in removed} == {store.path(TWO), store.path(TWO, ".manifest.json")}
    assert len({removal.reason for removal in removed}) == 1
    assert sum(removal.size for removal in removed) > 5
    assert store.find(ONE) is not None
    assert journal.exists()
    assert store.find(TWO) is None


def test_clean_store_takes_quarantined_files_and_what_killed_processes_left(store: ArtefactStore) -> None:
    store.path(ONE).write_text("forg")
    assert store.find(ONE) is None
    shelf = store.path(TWO).parent
    (shelf / ".writing-abc").mkdir()
    (shelf / ".writing-abc" / "half.h5").write_text("half")
    store.path(TWO, ".lock").touch()
    reasons = sorted({removal.reason for removal in clean_store(store.root, [ONE.key, TWO.key])})
    assert len(reasons) == 2
    names = {path.name for path in store.root.rglob("*") if path.is_file()}
    assert names == {f"{TWO.key}.h5", f"{TWO.key}.manifest.json", f"{ONE.key}.manifest.json"}


def test_clean_store_leaves_alone_what_is_being_written(store: ArtefactStore) -> None:
    three = Recipe("press", {"tilt_deg": 3.0})
    removed = []

    def write(path: Path) -> None:
        path.write_text("force")
        removed.extend(clean_store(store.root, [ONE.key, TWO.key]))

    with store.lease(three):
        store.write(three, write)
        removed.extend(clean_store(store.root, [ONE.key, TWO.key]))
    assert removed == []
    assert store.find(three) is not None


def test_clean_store_follows_no_link_out_of_the_store(store: ArtefactStore, tmp_path: Path) -> None:
    outside = tmp_path / "outside"
    outside.mkdir()
    (outside / "precious.h5").write_text("mine")
    (store.root / "press" / "zz").symlink_to(outside)
    (store.path(ONE).parent / "link.h5").symlink_to(outside / "precious.h5")
    clean_store(store.root, [])
    assert (outside / "precious.h5").read_text() == "mine"
    assert store.find(ONE) is None


def test_a_lease_that_another_process_holds_is_not_free_until_it_dies(store: ArtefactStore) -> None:
    code = (
        "import sys, time; from pathlib import Path; from palpate.core import ArtefactStore, Recipe\n"
        "with ArtefactStore(Path(sys.argv[1])).lease(Recipe('press', {'tilt_deg': 1.0})) as free:\n"
        "    print(free, flush=True); time.sleep(100)"
    )
    with subprocess.Popen([sys.executable, "-c", code, str(store.root)], stdout=subprocess.PIPE, text=True) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == "True\n"
        with store.lease(ONE) as free:
            assert not free
        with store.lease(TWO) as free:
            assert free
        holder.kill()
        holder.wait()
    with store.lease(ONE) as free:
        assert free


def test_take_lock_takes_the_new_file_where_the_old_one_was_removed(tmp_path: Path) -> None:
    path = tmp_path / "one.lock"
    lock = take_lock(path)
    assert lock is not None
    assert is_locked(path)
    assert take_lock(path) is None
    lock.release()
    assert not path.exists()
    assert not is_locked(path)
    again = take_lock(path)
    assert again is not None
    again.release()


def test_can_lock_says_whether_a_held_folder_refuses(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert can_lock(tmp_path)

    def refuse(descriptor: int, operation: int) -> None:
        raise OSError(95, os.strerror(95))

    monkeypatch.setattr("palpate.core.store_lock.flock", refuse)
    assert not can_lock(tmp_path)
    assert take_lock(tmp_path / "a.lock") is not None, "a file system without locks grants every lock"


def test_a_store_error_is_one_that_the_user_can_mend(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("not a folder")
    with refused("store-unwritable", "--out"), ArtefactStore(tmp_path / "file").lease(ONE):
        pass
    assert issubclass(StoreError, PalpateError)
