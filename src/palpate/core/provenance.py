"""Where a number came from: versions of the program, of Python and of the libraries that matter."""

from __future__ import annotations

import platform
from importlib import metadata

LIBRARIES = ("numpy", "scipy", "numba", "h5py", "pydantic", "py-mkl-pardiso", "rslab", "torch", "optuna")
"""Distributions whose version can change a result."""


def installed_version(distribution: str) -> str | None:
    """Version of an installed distribution, or `None`; nothing is imported."""
    try:
        return metadata.version(distribution)
    except metadata.PackageNotFoundError:
        return None


def provenance() -> dict[str, str]:
    """Versions of palpate, Python, the platform and `LIBRARIES`, as name → version.

    A library that is not installed is left out.

    Examples
    --------
    >>> {"palpate", "python", "platform", "numpy"} <= set(provenance())
    True
    """
    from palpate.core.version import __version__

    found = {
        "palpate": __version__,
        "python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
    }
    for name in LIBRARIES:
        version = installed_version(name)
        if version is not None:
            found[name] = version
    return found
