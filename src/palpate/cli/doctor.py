"""`palpate doctor`: what is installed, which solver is used, what is missing and how to get it."""

from __future__ import annotations

import importlib
import re
import shutil
import sys
from dataclasses import asdict, dataclass

from palpate.cli.flag import JsonFlag
from palpate.cli.output import print_json, print_table
from palpate.core import installed_version, provenance

REQUIRED = {
    "numpy": "numpy",
    "scipy": "scipy",
    "numba": "numba",
    "h5py": "h5py",
    "pydantic": "pydantic",
    "ruamel.yaml": "ruamel.yaml",
    "matplotlib": "matplotlib",
}
"""Distribution → module without which nothing runs."""

EXTRAS = {
    "torch": ("torch", "learn"),
    "optuna": ("optuna", "learn"),
    "build123d": ("build123d", "cad"),
    "trimesh": ("trimesh", "cad"),
    "ezdxf": ("ezdxf", "cad"),
    "meshio": ("meshio", "viz"),
    "pyvista": ("pyvista", "viz"),
    "nicegui": ("nicegui", "web"),
}
"""Distribution → module, and the extra that brings it."""

SYSTEM_PACKAGES = {
    "libGL.so.1": "libgl1",
    "libgomp.so.1": "libgomp1",
    "libglib-2.0.so.0": "libglib2.0-0",
    "libgthread-2.0.so.0": "libglib2.0-0",
    "libstdc++.so.6": "libstdc++6",
}
"""Shared library → system package (Debian, Ubuntu) that brings it."""


@dataclass(frozen=True)
class Check:
    """One thing looked at: what it is, whether it is fine, and what to do where it is not."""

    name: str
    ok: bool
    detail: str
    remedy: str = ""


def doctor(*, json: JsonFlag = False) -> int:
    """Say what is installed, which solver backend is used, and name what is missing."""
    checks = [_check_python(), *(_check_module(name, module, "") for name, module in REQUIRED.items())]
    required_ok = all(check.ok for check in checks)
    backends = _check_backends() if required_ok else []
    checks += [_check_module(name, module, extra) for name, (module, extra) in EXTRAS.items()]
    checks.append(_check_calculix())
    used = next((check.name for check in backends if check.ok), None)
    healthy = required_ok and used is not None
    if json:
        content = {
            "healthy": healthy,
            "solver": used,
            "checks": [asdict(check) for check in checks],
            "solvers": [asdict(check) for check in backends],
            "versions": provenance(),
        }
        print_json(content)
        return 0 if healthy else 1
    rows = [[check.name, "yes" if check.ok else "no", check.detail, check.remedy] for check in checks]
    rows += [[f"solver {check.name}", "yes" if check.ok else "no", check.detail, check.remedy] for check in backends]
    print_table(f"palpate {provenance()['palpate']}", ["what", "there", "detail", "remedy"], rows)
    print(f"Linear solver in use: {used or 'none'}.")
    return 0 if healthy else 1


def _check_python() -> Check:
    version = ".".join(str(part) for part in sys.version_info[:3])
    return Check("python", sys.version_info >= (3, 11), version, "" if sys.version_info >= (3, 11) else "Use 3.11.")


def _check_module(name: str, module: str, extra: str) -> Check:
    wanted = f'"palpate[{extra}]"' if extra else name
    try:
        importlib.import_module(module)
    except Exception as error:  # an old package beside a new one fails as it likes
        if isinstance(error, ModuleNotFoundError) and error.name == module:
            return Check(name, False, "not installed", f"pip install {wanted}")
        missing = re.search(r"lib[\w.+-]+\.so[.\d]*", str(error))
        if missing is not None:
            package = SYSTEM_PACKAGES.get(missing[0], f"the system package with {missing[0]}")
            return Check(name, False, f"{missing[0]} is missing", f"apt-get install {package}")
        return Check(name, False, f"does not load: {error}"[:60], f"pip install --upgrade {wanted}")
    return Check(name, True, installed_version(name) or "")


def _check_calculix() -> Check:
    path = shutil.which("ccx")
    return Check(
        "calculix", path is not None, path or "not installed", "" if path else "apt-get install calculix-ccx"
    )


def _check_backends() -> list[Check]:
    from palpate.mechanics import solver_backends

    return [
        Check(name, available, "installed" if available else "not installed", "" if available else remedy)
        for name, available, remedy in solver_backends()
    ]
