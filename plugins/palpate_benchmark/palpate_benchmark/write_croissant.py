"""Croissant 1.0 metadata (MLCommons): files with checksums, and columns with meanings."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from palpate_benchmark.columns import TABLES, Column
from palpate_benchmark.set_files import CHECKSUMS, digest
from palpate_benchmark.spec import SPLITS, BenchmarkSpec

CROISSANT = "croissant.json"
NAME = "palpate-benchmark"
_KINDS = {
    ".csv": "text/csv",
    ".h5": "application/x-hdf5",
    ".zip": "application/zip",
    ".json": "application/json",
    ".md": "text/markdown",
}
_CONTEXT: dict[str, Any] = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    "citeAs": "cr:citeAs",
    "column": "cr:column",
    "conformsTo": "dct:conformsTo",
    "cr": "http://mlcommons.org/croissant/",
    "rai": "http://mlcommons.org/croissant/RAI/",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "dct": "http://purl.org/dc/terms/",
    "equivalentProperty": "cr:equivalentProperty",
    "examples": {"@id": "cr:examples", "@type": "@json"},
    "extract": "cr:extract",
    "field": "cr:field",
    "fileProperty": "cr:fileProperty",
    "fileObject": "cr:fileObject",
    "fileSet": "cr:fileSet",
    "format": "cr:format",
    "includes": "cr:includes",
    "isLiveDataset": "cr:isLiveDataset",
    "jsonPath": "cr:jsonPath",
    "key": "cr:key",
    "md5": "cr:md5",
    "parentField": "cr:parentField",
    "path": "cr:path",
    "recordSet": "cr:recordSet",
    "references": "cr:references",
    "regex": "cr:regex",
    "repeated": "cr:repeated",
    "replace": "cr:replace",
    "samplingRate": "cr:samplingRate",
    "sc": "https://schema.org/",
    "separator": "cr:separator",
    "source": "cr:source",
    "subField": "cr:subField",
    "transform": "cr:transform",
}
"""JSON-LD context that Croissant 1.0 prescribes."""


def write_croissant(folder: Path, spec: BenchmarkSpec) -> None:
    """Write ``croissant.json`` for the files in a folder.

    Parameters
    ----------
    folder
        Folder that contains all other files of the data set except the checksums.
    spec
        Contents of the data set.
    """
    files = [path for path in sorted(folder.iterdir()) if path.name not in (CROISSANT, CHECKSUMS)]
    content = {
        "@context": _CONTEXT,
        "@type": "sc:Dataset",
        "conformsTo": "http://mlcommons.org/croissant/1.0",
        "name": NAME,
        "description": _describe(spec),
        "version": "1.0.0",
        "url": spec.url,
        "license": spec.licence,
        "creator": {"@type": "sc:Organization", "name": spec.creator},
        "datePublished": spec.published,
        "citeAs": f"{spec.creator}: palpate benchmark of vision-based tactile sensors, version 1.0.0, {spec.url}",
        "keywords": ["tactile sensing", "robotics", "pose estimation", "simulation"],
        "distribution": [_file(path) for path in files] + [_pictures(split) for split in SPLITS],
        "recordSet": [_records(name, columns) for name, columns in TABLES.items() if (folder / name).is_file()],
    }
    text = json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False)
    (folder / CROISSANT).write_text(text + "\n", encoding="utf-8")


def _describe(spec: BenchmarkSpec) -> str:
    return (
        f"Images of {spec.units} simulated built units of each of {len(spec.designs)} designs of a domed tactile "
        "sensor: positions of all markers, rendered images of some presses, and the pose of the wall, depth, force, "
        "friction and branch of each. Training, calibration and test have different units."
    )


def _file(path: Path) -> dict[str, Any]:
    return {
        "@type": "cr:FileObject",
        "@id": path.name,
        "name": path.name,
        "contentUrl": path.name,
        "contentSize": f"{path.stat().st_size} B",
        "encodingFormat": _KINDS[path.suffix],
        "sha256": digest(path),
    }


def _pictures(split: str) -> dict[str, Any]:
    return {
        "@type": "cr:FileSet",
        "@id": f"{split}-pictures",
        "name": f"{split}-pictures",
        "description": "Rendered images, 8 bit grey; rest_DESIGN_UNIT.png is the unit untouched.",
        "containedIn": {"@id": f"{split}_pictures.zip"},
        "encodingFormat": "image/png",
        "includes": f"{split}/*.png",
    }


def _records(name: str, columns: tuple[Column, ...]) -> dict[str, Any]:
    own = name.removesuffix(".csv")
    return {
        "@type": "cr:RecordSet",
        "@id": own,
        "name": own,
        "field": [
            {
                "@type": "cr:Field",
                "@id": f"{own}/{column.name}",
                "name": f"{own}/{column.name}",
                "description": column.meaning + (f" ({column.unit})" if column.unit not in ("", "1") else ""),
                "dataType": column.kind,
                "source": {"fileObject": {"@id": name}, "extract": {"column": column.name}},
            }
            for column in columns
        ],
    }
