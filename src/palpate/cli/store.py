"""`palpate study store`: verify the artefacts of a result folder, and remove unused ones."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

from palpate.cli.costs import cost_sentence
from palpate.cli.output import JsonOutput
from palpate.core import PalpateError, check_store, clean_store

app = App(name="store", help="Verify or clean the artefacts of a result folder.")

Folder = Annotated[Path, Parameter(help="Result folder of one or several studies.")]


@app.command(help_epilogue=cost_sentence("study store check"))
def check(folder: Folder, *, output: JsonOutput = JsonOutput()) -> int:
    """Read every artefact and move broken ones to quarantine; the next run makes them again.

    The exit code is 1 if an artefact was broken.
    """
    read, broken = check_store(_store(folder))
    output.show(
        {"read": read, "broken": [{"path": str(item.path), "reason": item.reason} for item in broken]},
        *(f"{item.path}: {item.reason}" for item in broken),
        f"{read} artefacts read, {len(broken)} broken" + (" and moved to quarantine." if broken else "."),
    )
    return 1 if broken else 0


@app.command(help_epilogue=cost_sentence("study store gc"))
def gc(
    folder: Folder,
    *studies: Annotated[str, Parameter(help="YAML files or presets of all studies whose artefacts are kept.")],
    dry_run: Annotated[bool, Parameter(negative="", help="List the files without removing them.")] = False,
    output: JsonOutput = JsonOutput(),
) -> None:
    """Remove artefacts unused by the studies, quarantined files, and files of killed processes.

    Artefacts of studies that are not named are removed, so use --dry-run first. Artefacts in progress are kept.
    """
    from palpate.study import needed_keys, read_study

    store = _store(folder)
    if not studies:
        raise PalpateError(
            "No study was named, so every artefact would be removed.",
            "Name the studies whose artefacts are kept.",
            code="argument-missing",
        )
    removed = clean_store(store, needed_keys(read_study(study) for study in studies), dry_run=dry_run)
    size = sum(item.size for item in removed)
    listed = [{"path": str(item.path), "bytes": item.size, "reason": item.reason} for item in removed]
    output.show(
        {"dry_run": dry_run, "bytes": size, "removed": listed},
        *(f"{item.path}: {item.reason}" for item in removed),
        f"{'Would remove' if dry_run else 'Removed'} {len(removed)} files, {size / 1e6:.1f} MB.",
    )


def _store(folder: Path) -> Path:
    store = folder / "store"
    if not store.is_dir():
        raise PalpateError(
            f"{folder} is not a result folder: it has no folder 'store'.",
            "Give a folder made by palpate run.",
            code="folder-not-results",
        )
    return store
