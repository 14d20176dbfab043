"""What docs/threats.md promises about code and files that come from elsewhere."""

import ast
import json
from collections.abc import Iterator
from pathlib import Path

import h5py
import numpy as np
import pytest

import palpate
from errors import refused
from palpate.core import ArtefactStore, Recipe, reject_external_links

SOURCE = Path(palpate.__file__).parent
"""Of the checkout, or of the wheel that is tested beside it."""
FILES = sorted(SOURCE.rglob("*.py"))

CALLS = {"eval", "exec", "compile", "__import__"}
MODULES = {"pickle", "cPickle", "dill", "cloudpickle", "shelve", "marshal", "joblib", "telnetlib"}
METHODS = {
    "os.system",
    "os.popen",
    "torch.load",
    "numpy.load",
    "np.load",
    "onnx.load",
    "onnx.load_model",
    "yaml.load",
    "shutil.unpack_archive",
    "tarfile.open",
}


def dangers(text: str) -> Iterator[str]:
    """What in a source text could run what stands in a file."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name.split(".")[0] in MODULES)
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] in MODULES:
            yield str(node.module)
        if isinstance(node, ast.Call):
            yield from _dangers_of_call(node)


def _dangers_of_call(node: ast.Call) -> Iterator[str]:
    name = ast.unparse(node.func).removeprefix("self.")
    only_numbers = any(word.arg == "weights_only" and ast.unparse(word.value) == "True" for word in node.keywords)
    unpickled = any(word.arg == "allow_pickle" and ast.unparse(word.value) == "False" for word in node.keywords)
    harmless = (name == "torch.load" and only_numbers) or (name in ("np.load", "numpy.load") and unpickled)
    if name in CALLS or (name in METHODS and not harmless):
        yield name
    for word in node.keywords:
        value = word.value.value if isinstance(word.value, ast.Constant) else None
        if word.arg == "shell" and value is not False:
            yield f"{name}(shell=…)"
        if word.arg == "allow_pickle" and value is not False:
            yield f"{name}(allow_pickle=…)"
        if name.endswith("YAML") and word.arg == "typ" and value not in ("safe", "rt"):
            yield f"{name}(typ={value})"


def test_no_file_of_the_package_could_run_what_stands_in_a_file() -> None:
    found = {str(path.relative_to(SOURCE)): list(dangers(path.read_text())) for path in FILES}
    assert {path: names for path, names in found.items() if names} == {}


@pytest.mark.parametrize(
    "text",
    [
        "import pickle",
        "from pickle import loads",
        "eval('1')",
        "exec(text)",
        "import os\nos.system('ls')",
        "subprocess.run('ls', shell=True)",
        "subprocess.run('ls', shell=flag)",
        "np.load(path)",
        "numpy.fromfile(path, allow_pickle=True)",
        "torch.load(path)",
        "self.torch.load(path, weights_only=False)",
        "onnx.load(path)",
        "YAML(typ='unsafe')",
        "tarfile.open(path)",
    ],
)
def test_the_search_finds_what_it_is_for(text: str) -> None:
    assert list(dangers(text))


def linked(folder: Path, link: h5py.ExternalLink | h5py.SoftLink) -> Path:
    """A file whose member `depth` lies elsewhere."""
    with h5py.File(folder / "secret.h5", "w") as file:
        file["depth"] = np.arange(3.0)
    path = folder / "press.h5"
    with h5py.File(path, "w") as file:
        file.create_group("inner")["depth"] = link
    return path


def test_refuse_outside_links_names_the_member_that_lies_in_another_file(tmp_path: Path) -> None:
    path = linked(tmp_path, h5py.ExternalLink(str(tmp_path / "secret.h5"), "/depth"))
    with h5py.File(path) as file:
        assert file["inner/depth"][1] == 1.0, "without the check, HDF5 follows the link"
        with refused("hdf5-outside-link", "inner/depth"):
            reject_external_links(file, path)


def test_refuse_outside_links_refuses_raw_data_in_another_file(tmp_path: Path) -> None:
    (tmp_path / "raw").write_bytes(b"secret!!")
    path = tmp_path / "press.h5"
    with h5py.File(path, "w") as file:
        file.create_dataset("depth", (1,), "f8", external=[(str(tmp_path / "raw"), 0, 8)])
    with h5py.File(path) as file, refused("hdf5-outside-link", "depth"):
        reject_external_links(file, path)


def test_refuse_outside_links_refuses_virtual_datasets(tmp_path: Path) -> None:
    path = linked(tmp_path, h5py.SoftLink("/none"))
    layout = h5py.VirtualLayout((3,), "f8")
    layout[:] = h5py.VirtualSource(str(tmp_path / "secret.h5"), "depth", (3,))
    with h5py.File(path, "a") as file:
        file.create_virtual_dataset("virtual", layout)
    with h5py.File(path) as file, refused("hdf5-outside-link", "virtual"):
        reject_external_links(file, path)


def test_refuse_outside_links_ends_where_links_run_in_a_circle(tmp_path: Path) -> None:
    path = tmp_path / "circle.h5"
    with h5py.File(path, "w") as file:
        group = file.create_group("a")
        group["a"] = group
        file["soft"] = h5py.SoftLink("/a")
        file["depth"] = np.arange(3.0)
    with h5py.File(path) as file:
        reject_external_links(file, path)


@pytest.mark.parametrize("kind", ["..", "../up", "a/b", "/etc", "", ".hidden", "a\0b"])
def test_a_recipe_cannot_name_a_folder_outside_the_store(tmp_path: Path, kind: str) -> None:
    with refused("artefact-kind-malformed"):
        ArtefactStore(tmp_path).path(Recipe(kind, {}))


def test_a_manifest_cannot_lead_out_of_the_store(tmp_path: Path) -> None:
    store = ArtefactStore(tmp_path / "store")
    recipe = Recipe("press", {})
    path = store.write(recipe, lambda path: path.write_text("force") and None)
    manifest = path.with_suffix(".manifest.json")
    content = json.loads(manifest.read_text())
    manifest.write_text(json.dumps({**content, "kind": "../../elsewhere"}))
    assert store.find(recipe) is None
    assert sorted(item.name for item in tmp_path.iterdir()) == ["store"]
