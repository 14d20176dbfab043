"""Fabrication packs, each written once for all tests that read it."""

import json
import pickle
from dataclasses import replace
from pathlib import Path

from palpate.design import Design, MarkerSpec, MountSpec
from palpate.fabrication import FabricationPack, ProcessSpec, write_pack
from presses import stored_folder


def stored_pack(design: Design, process: ProcessSpec, mount: MountSpec) -> FabricationPack:
    """Pack of a design, as `write_pack` returns it, from the store if it was written before; only to be read."""
    assert isinstance(design.markers, MarkerSpec)
    specs = (design.skin_spec, design.markers, design.camera_spec, process, mount)
    names = [f"{type(spec).__name__} {spec.model_dump_json()}" for spec in specs]
    material = design.material.name, json.dumps(design.material.key_data(), sort_keys=True)

    def write(folder: Path) -> None:
        pack = write_pack(folder / "pack", design, process, mount)
        (folder / "pack.pickle").write_bytes(pickle.dumps(pack))

    folder = stored_folder("pack", [*names, *material], write)
    return replace(pickle.loads((folder / "pack.pickle").read_bytes()), folder=folder / "pack")
