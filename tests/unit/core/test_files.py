"""What is written appears whole or not at all."""

from pathlib import Path

import pytest

from errors import refused
from palpate.core import atomic_folder, atomic_write, atomic_write_into, wrap_write_errors


class InterruptedWorkError(Exception):
    pass


def break_off(path: Path) -> None:
    path.write_text("half")
    raise InterruptedWorkError


def test_a_file_takes_its_place_when_it_is_whole(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text("old")
    with atomic_write(path) as draft:
        draft.write_text("new")
        assert (draft.name, draft.parent.parent, path.read_text()) == ("a.txt", tmp_path, "old")
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_that_is_broken_off_leaves_the_old_one(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text("old")
    with pytest.raises(InterruptedWorkError), atomic_write(path) as draft:
        break_off(draft)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_files_of_a_folder_appear_together(tmp_path: Path) -> None:
    folder = tmp_path / "new" / "folder"
    with atomic_write_into(folder) as drafts:
        for name in ("a.csv", "b.csv"):
            (drafts / name).write_text(name)
        assert [path for path in folder.iterdir() if path != drafts] == []
    assert sorted(path.name for path in folder.iterdir()) == ["a.csv", "b.csv"]


@pytest.mark.parametrize("there", [False, True])
def test_a_new_folder_appears_whole_or_not_at_all(tmp_path: Path, there: bool) -> None:
    folder = tmp_path / "pack"
    if there:
        folder.mkdir()
    with pytest.raises(InterruptedWorkError), atomic_folder(folder) as draft:
        break_off(draft / "half")
    assert [*tmp_path.rglob("*")] == ([folder] if there else [])
    with atomic_folder(folder) as draft:
        (draft / "whole").write_text("")
    assert [path.name for path in folder.iterdir()] == ["whole"]
    with refused("folder-exists"), atomic_folder(folder):
        pass


@pytest.mark.parametrize("opened", [atomic_write, atomic_write_into, atomic_folder])
def test_what_cannot_be_written_is_reported_with_its_reason_and_remedy(tmp_path: Path, opened) -> None:
    (tmp_path / "file").write_text("")
    path = tmp_path / "file" / "a.txt"
    with refused("file-unwritable", "a.txt", "Name another."), opened(path, "Name another."):
        pass


def test_an_error_without_a_reason_of_the_system_is_reported_as_it_is() -> None:
    with refused("file-unwritable", "The grid", "disk full"), wrap_write_errors("The grid"):
        raise OSError("disk full")


def test_an_hdf5_file_has_the_bytes_that_hdf5_writes(tmp_path: Path) -> None:
    import h5py
    import numpy as np

    from palpate.core import create_hdf5

    for path, create in ((tmp_path / "one.h5", create_hdf5), (tmp_path / "other.h5", lambda p: h5py.File(p, "w"))):
        with create(path) as file:
            file.create_dataset("x", data=np.arange(10_000.0), compression="gzip")
            file.create_dataset("names", data=["a", "b"], dtype=h5py.string_dtype())
            file.attrs["kind"] = "test"
    assert (tmp_path / "one.h5").read_bytes() == (tmp_path / "other.h5").read_bytes()


def test_a_failed_hdf5_file_is_not_written(tmp_path: Path) -> None:
    from palpate.core import create_hdf5

    with pytest.raises(KeyError), create_hdf5(tmp_path / "one.h5") as file:
        raise KeyError(file.attrs)
    assert not (tmp_path / "one.h5").exists()
