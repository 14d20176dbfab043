"""Studies from YAML files and presets."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

from ruamel.yaml.comments import CommentedMap

from palpate.core import PalpateError
from palpate.study.read_spec import read_spec
from palpate.study.study import Study


def list_presets() -> tuple[str, ...]:
    """Names of the studies that the package contains."""
    folder = resources.files("palpate.study") / "presets"
    return tuple(sorted(item.name.removesuffix(".yaml") for item in folder.iterdir()))


def read_study(source: str | Path) -> Study:
    """Read a study.

    Parameters
    ----------
    source
        Path of a YAML file, or the name of a preset: ``first``, ``paper``, ``best``, … (`list_presets`).

    Returns
    -------
    Study
        Paths in the file are relative to its folder.

    Raises
    ------
    PalpateError
        If the file or preset does not exist, or is not a valid study; the message names file and line.

    Examples
    --------
    >>> study = read_study("first")
    >>> len(study.designs.skins()), study.tilts_deg[:3]
    (2, (0.0, 2.0, 4.0))
    """
    path = Path(source)
    if not path.exists() and str(source) in list_presets():
        text = (resources.files("palpate.study") / "presets" / f"{source}.yaml").read_text("utf-8")
        return _parse(text, Path(f"{source}.yaml"))
    if path.is_dir():
        raise PalpateError(
            f"{path} is a folder, not a study.",
            f"Give its YAML file, and its result folder by --out; `palpate study show {path}` shows results.",
            code="study-is-folder",
        )
    try:
        text = path.read_text("utf-8")
    except OSError as error:
        raise PalpateError(
            f"The study {source} cannot be read: {error.strerror}.",
            f"Give a YAML file or a preset: {', '.join(list_presets())}.",
            code="file-unreadable",
        ) from error
    except UnicodeDecodeError as error:
        raise PalpateError(
            f"{source} is not a text file.", "Give a YAML file in UTF-8.", code="file-not-text"
        ) from error
    return _parse(text, path)


def _parse(text: str, path: Path) -> Study:
    return read_spec(path, text, Study, "See the preset `first`.", lambda tree: _resolve_files(tree, path.parent))


def _resolve_files(tree: CommentedMap, folder: Path) -> None:
    designs = tree.get("designs")
    markers = designs.get("markers") if isinstance(designs, dict) else None
    for layout in markers if isinstance(markers, list) else []:
        if isinstance(layout, dict) and isinstance(layout.get("file"), str):
            layout["file"] = str(folder / _file_name(layout["file"]))
    skin = designs.get("skin") if isinstance(designs, dict) else None
    if isinstance(skin, dict) and isinstance(skin.get("file"), str):
        skin["file"] = str(folder / _file_name(skin["file"]))
    material = tree.get("material")
    if isinstance(material, dict) and str(material.get("name", "")).endswith((".yaml", ".yml")):
        material["name"] = str(folder / _file_name(material["name"]))


def _file_name(name: str) -> str:
    if "\0" in name:
        raise PalpateError(
            f"{name!r} can be no file: its name holds a zero byte.", "Correct the name.", code="file-name-malformed"
        )
    return name
