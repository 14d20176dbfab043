#!/usr/bin/env python3
"""Audit the installed dependencies: licences that Apache-2.0 may stand beside, and known vulnerabilities.

Licences are read from the packages themselves. Vulnerabilities are asked of PyPI by pip-audit; where no advisory
service answers, that is said and is no failure: a machine without network cannot know.
"""

from __future__ import annotations

import re
import subprocess
import sys
import urllib.error
import urllib.request
from importlib.metadata import Distribution, distributions

ADVISORIES = "https://pypi.org/pypi/pip/24.0/json"
"""Where pip-audit asks; PyPI tells what is known of one version of a package."""
REFUSED = re.compile(r"\b(A?GPL|GNU (Affero )?General Public)", re.IGNORECASE)
SPARED = re.compile(r"\b(LGPL|GNU Lesser|GNU Library)", re.IGNORECASE)


def licences(package: Distribution) -> list[str]:
    """The licences that a package names for itself."""
    meta = package.metadata
    stated = [value for key, value in meta.items() if key == "Classifier" and value.startswith("License ::")]
    first_line = (meta.get("License") or "").strip().split("\n")[0]
    return [text for text in (meta.get("License-Expression"), first_line, *stated) if text]


def is_refused(named: list[str]) -> bool:
    """Whether every licence named is GPL: one who offers another beside it may be used under that one."""
    alternatives = [part for text in named for part in re.split(r"\bOR\b", text)]
    bound = [bool(REFUSED.search(part)) and not SPARED.search(part) for part in alternatives]
    return bool(bound) and all(bound)


def main() -> int:
    found = {package.metadata["Name"]: licences(package) for package in distributions()}
    refused = {name: named for name, named in found.items() if is_refused(named)}
    for name, named in sorted(refused.items()):
        print(f"{name}: {'; '.join(named)}: not beside Apache-2.0")
    print(f"{len(found)} packages, licences of {sum(map(bool, found.values()))} named, {len(refused)} refused")
    try:
        urllib.request.urlopen(ADVISORIES, timeout=20).close()
    except (urllib.error.URLError, TimeoutError) as error:
        print(f"vulnerabilities NOT audited: no advisory service answers here ({error})")
        return 1 if refused else 0
    audit = subprocess.run(
        [sys.executable, "-m", "pip_audit", "--skip-editable", "--progress-spinner=off"], check=False
    )
    return 1 if refused or audit.returncode else 0


if __name__ == "__main__":
    sys.exit(main())
