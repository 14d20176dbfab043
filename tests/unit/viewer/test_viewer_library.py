"""A result folder as the explorer reads it."""

import json

import numpy as np
import pytest
from made_up_presses import KEYS, write_results

from errors import refused
from palpate.viewer.library import DesignLibrary
from palpate.viewer.message import write_message
from palpate.viewer.results import artefact_path, model_path, read_design, read_results
from palpate.viewer.scene import describe_markers, describe_motion, describe_shell
from view_message import read_message


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    return DesignLibrary(read_results(write_results(tmp_path_factory.mktemp("results"))))


def test_designs_of_one_dome_share_their_presses(library):
    assert library.specimen(library.design(0)) is library.specimen(library.design(1))
    assert library.design(1).name == "H20 T2, 19 markers"


def test_what_the_page_draws_is_whole(library):
    design = library.design(1)
    specimen = library.specimen(design)
    meta, arrays = read_message(describe_shell(specimen, design.design.layout, design.design.camera))
    assert meta["tilts_deg"] == [0, 3, 6]
    assert arrays["cells"].max() == len(arrays["rest"]) - 1
    motion = specimen.pressed.at(2.5)
    _, pressed = read_message(describe_motion(specimen, motion, "pressure"))
    assert pressed["pressure"].shape == (6, len(arrays["rest"]))
    assert pressed["pressure"][0].max() == 0 < pressed["pressure"][-1].max()
    meta, moved = read_message(describe_motion(specimen, motion, "stress"))
    assert moved["displacement"].shape == (6, *arrays["rest"].shape)
    assert moved["stress"].shape == (6, len(arrays["rest"]))
    assert np.abs(moved["stress"][0]).max() == 0
    assert moved["stress"][-1].max() > 0
    assert meta["branch"] == ["flat"] * 6
    seen = specimen.pressed.markers(design.design.layout, design.design.camera, motion, 20.0)
    _, marks = read_message(describe_markers(seen))
    assert marks["pixels"].shape == (6, 19, 2)


def test_a_design_whose_chain_broke_says_why(library):
    with refused("press-missing", "did not converge"):
        library.specimen(library.design(2))


@pytest.mark.parametrize("number", [-1, 3, 10**9])
def test_a_design_that_is_not_there_is_refused(library, number):
    with refused("design-unknown"):
        library.design(number)


@pytest.mark.parametrize("key", ["../../../etc/passwd", "..", "", "A" * 32, "0" * 31 + "/", "0" * 33])
def test_a_key_cannot_leave_the_store(library, key):
    with refused("artefact-key-malformed"):
        artefact_path(library.results, "press", key, ".h5")


def test_a_broken_artefact_is_named(tmp_path):
    folder = write_results(tmp_path)
    key = KEYS[3.0]
    (folder / "store" / "press" / key[:2] / f"{key}.h5").write_bytes(b"not hdf5")
    library = DesignLibrary(read_results(folder))
    with refused("press-unreadable"):
        library.specimen(library.design(0))


def test_a_folder_without_results_says_what_to_give(tmp_path):
    with refused("grid-missing"):
        read_results(tmp_path)


def test_a_grid_without_sizes_is_refused(tmp_path):
    folder = write_results(tmp_path)
    text = (folder / "grid.json").read_text()
    (folder / "grid.json").write_text(text.replace('"height_mm": 20.0', '"height_mm": null', 1))
    with refused("grid-value-missing", "height_mm"):
        read_results(folder)


def test_a_design_without_a_model_says_so(library):
    with refused("model-missing"):
        model_path(library.results, library.design(0))


def test_a_message_is_read_back():
    meta, arrays = read_message(
        write_message({"a": "ä"}, {"x": np.eye(2), "n": np.arange(3), "yes": np.ones(1, bool)})
    )
    assert meta == {"a": "ä"}
    assert arrays["x"].tolist() == [[1, 0], [0, 1]]
    assert arrays["n"].tolist() == [0, 1, 2]


def test_markers_are_the_datasets_whatever_their_number(tmp_path):
    """Rows of a barrel, or a file of points: no number of rings has so many."""
    folder, key = write_results(tmp_path), "d" * 32
    grid = json.loads((folder / "grid.json").read_text())
    grid["designs"][0] |= {"markers": 20, "dataset_key": key}
    (folder / "grid.json").write_text(json.dumps(grid))
    places = np.column_stack([np.linspace(-5, 5, 20), np.zeros(20), np.full(20, 19.0)])
    manifest = folder / "store" / "dataset" / key[:2] / f"{key}.manifest.json"
    manifest.parent.mkdir(parents=True)
    manifest.write_text(json.dumps({"spec": {"markers_mm": places.tolist()}}))
    assert read_design(read_results(folder), 0).design.layout.positions == pytest.approx(places)
