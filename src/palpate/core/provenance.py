"""Provenance of results: versions of the program, of Python and of the libraries that affect results."""

from __future__ import annotations

import platform
from functools import cache
from importlib import metadata

LIBRARIES = ("numpy", "scipy", "numba", "h5py", "pydantic", "py-mkl-pardiso", "rslab", "torch", "optuna")
"""Distributions whose version can change a result."""


@cache  # a search of every folder of distributions
def installed_version(distribution: str) -> str | None:
    """Return the version of an installed distribution, or `None`, without importing it."""
    try:
        return metadata.version(distribution)
    except metadata.PackageNotFoundError:
        return None


def provenance() -> dict[str, str]:
    """Return the versions of palpate, Python, the platform and installed `LIBRARIES`, as name → version.

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
