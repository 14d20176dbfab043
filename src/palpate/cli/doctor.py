"""`palpate doctor`: installed and missing packages, the linear solver, and remedies."""

from __future__ import annotations

import ctypes
import importlib
import re
import shutil
import sys
from dataclasses import asdict, dataclass, replace
from functools import cache
from importlib import metadata
from typing import Annotated

from cyclopts import Parameter
from packaging.markers import Marker
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from palpate.cli.output import Output
from palpate.core import installed_version, provenance
from palpate.core.report import Column, Report

FOR_DEVELOPERS = {"all", "docs", "test"}
"""Extras that a user of palpate does not need."""

_COLUMNS = (
    Column("name"),
    Column("ok", "installed"),
    Column("detail", prose=True),
    Column("remedy", prose=True),
)
SYSTEM_PACKAGES = {
    "libGL.so.1": "libgl1",
    "libX11.so.6": "libx11-6",
    "libexpat.so.1": "libexpat1",
    "libgomp.so.1": "libgomp1",
    "libglib-2.0.so.0": "libglib2.0-0",
    "libgthread-2.0.so.0": "libglib2.0-0",
    "libstdc++.so.6": "libstdc++6",
}
"""Shared library → system package (Debian, Ubuntu) that contains it."""
LINKED = {"build123d": ("libGL.so.1", "libX11.so.6", "libexpat.so.1"), "pyvista": ("libGL.so.1",)}
"""Package → shared libraries of the system that its import needs."""
_LOAD = "Also import every package (about 10 s) and report those that do not load."


@dataclass(frozen=True)
class InstallCheck:
    """One check of the installation: name, result, detail, and remedy if it fails."""

    name: str
    ok: bool
    detail: str
    remedy: str = ""


def doctor(*, load: Annotated[bool, Parameter(negative="", help=_LOAD)] = False, output: Output = Output()) -> int:
    """Report installed and missing packages, the linear solver, and remedies."""
    needed = _needed()
    _modules_by_distribution.cache_clear()  # packages may have been installed since
    checks = [_check_python(), *(_check_package(name, "", load) for name, extra in needed.items() if not extra)]
    required_ok = all(check.ok for check in checks)
    backends = _check_backends() if required_ok else []
    checks += [_check_package(name, extra, load) for name, extra in needed.items() if extra]
    checks.append(_check_calculix())
    used = next((check.name for check in backends if check.ok), None)
    healthy = required_ok and used is not None
    content = {
        "healthy": healthy,
        "solver": used,
        "checks": [asdict(check) for check in checks],
        "solvers": [asdict(check) for check in backends],
        "versions": provenance(),
    }
    rows = [asdict(check) for check in (*checks, *(replace(one, name=f"solver {one.name}") for one in backends))]
    note = f"Linear solver in use: {used or 'none'}."
    output.show(content, Report(f"palpate {provenance()['palpate']}", _COLUMNS, rows, (note,)))
    return 0 if healthy else 1


def _check_python() -> InstallCheck:
    version = ".".join(str(part) for part in sys.version_info[:3])
    return InstallCheck(
        "python", sys.version_info >= (3, 11), version, "" if sys.version_info >= (3, 11) else "Use 3.11."
    )


def _needed() -> dict[str, str]:
    """Return palpate's requirements: distribution → extra that installs it, empty if required.

    The result is empty without metadata, as in a folder of sources that was never installed. Backends of the linear
    solver, which only some platforms need, are checked separately.
    """
    try:
        needed = [Requirement(text) for text in metadata.requires("palpate") or ()]
    except metadata.PackageNotFoundError:
        return {}
    extras = sorted({extra for item in needed for extra in re.findall(r"extra == ['\"](\w+)", str(item.marker))})
    found = {item.name: "" for item in needed if item.marker is None}
    for extra in (name for name in extras if name not in FOR_DEVELOPERS):
        chosen = [item.name for item in needed if item.marker and _only_for(item.marker, extra)]
        found |= {name: extra for name in chosen if name not in found}
    return found


def _only_for(marker: Marker, extra: str) -> bool:
    return marker.evaluate({"extra": extra}) and not marker.evaluate({"extra": ""})


def _check_package(name: str, extra: str, load: bool) -> InstallCheck:
    wanted = f'-e ".[{extra}]"' if extra else name
    if installed_version(name) is None:
        return InstallCheck(name, False, "not installed", f"pip install {wanted}")
    try:
        for library in LINKED.get(name, ()) if sys.platform == "linux" else ():
            ctypes.CDLL(library)
        if load:
            importlib.import_module(_module_of(name))
    except Exception as error:  # incompatible versions of packages raise any error
        missing = re.search(r"lib[\w.+-]+\.so[.\d]*", str(error))
        if missing is not None:
            package = SYSTEM_PACKAGES.get(missing[0], f"the system package with {missing[0]}")
            return InstallCheck(name, False, f"{missing[0]} is missing", f"apt-get install {package}")
        return InstallCheck(name, False, f"does not load: {error}"[:60], f"pip install --upgrade {wanted}")
    return InstallCheck(name, True, installed_version(name) or "")


def _module_of(name: str) -> str:
    """Return the module by which a distribution is imported: that of its name, or else its first module."""
    modules = sorted(_modules_by_distribution().get(canonicalize_name(name), ()))
    public = [module for module in modules if not module.startswith("_")]
    own = name.lower().replace("-", "_")
    return own if own in public else next(iter(public or modules), own)


@cache
def _modules_by_distribution() -> dict[str, set[str]]:
    """Return the modules of each distribution by its normalised name; the metadata are read once."""
    found: dict[str, set[str]] = {}
    for module, names in metadata.packages_distributions().items():
        for name in names:
            found.setdefault(canonicalize_name(name), set()).add(module)
    return found


def _check_calculix() -> InstallCheck:
    path = shutil.which("ccx")
    return InstallCheck(
        "calculix", path is not None, path or "not installed", "" if path else "apt-get install calculix-ccx"
    )


def _check_backends() -> list[InstallCheck]:
    from palpate.mechanics import solver_backends

    return [
        InstallCheck(name, available, "installed" if available else "not installed", "" if available else remedy)
        for name, available, remedy in solver_backends()
    ]
