"""The continuous integration installs and tests by the README's own lines, so that a newcomer sees what it sees."""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]


def commands(text: str) -> list[str]:
    """Lines that install or test, without comments."""
    lines = (re.split(r"\s+[#|]", line)[0].strip() for line in text.splitlines())
    return [line for line in lines if line.startswith(("pip install", "pytest"))]


def test_ci_runs_the_commands_of_the_readme_and_no_others() -> None:
    readme, steps = (ROOT / "README.md").read_text(), (ROOT / ".ci" / "run").read_text()
    written = commands(readme.split("## Tests")[1])
    before = ["pip install torch==2.13.0"]
    assert before[0] in readme
    assert commands(steps.split("== audit")[0] + steps.split("== pytest")[1]) == before + written


def test_the_default_leaves_out_what_the_second_command_runs() -> None:
    written = commands((ROOT / "README.md").read_text().split("## Tests")[1])
    assert written[1:] == ["pytest", "pytest -m slow"]
    assert "-m 'not slow and not speed'" in (ROOT / "pyproject.toml").read_text()


def test_contributing_shows_the_rooms_in_the_order_of_their_imports() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    layers = project["tool"]["importlinter"]["contracts"][0]["layers"]
    chain = re.search(r"^    core →.*?\n\n", (ROOT / "CONTRIBUTING.md").read_text(), re.M | re.S)
    assert chain is not None
    shown = [sorted(re.findall(r"\w+", part)) for part in chain[0].split("→")]
    assert shown == [sorted(re.findall(r"\w+", layer)) for layer in reversed(layers)]
