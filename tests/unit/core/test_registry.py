from __future__ import annotations

from pathlib import Path

import pytest

from errors import refused
from palpate.core import Registry

OWN = {"extra": "palpate.core.errors:MissingExtraError"}


@pytest.fixture
def guest(tmp_path, monkeypatch):
    """Install packages into a folder on the path: name of the package, its code, its entry points."""

    def install(name: str, code: str, **points: str) -> None:
        (tmp_path / f"{name}.py").write_text(code)
        info = tmp_path / f"{name}-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
        rows = "".join(f"{key} = {value}\n" for key, value in points.items())
        (info / "entry_points.txt").write_text(f"[palpate.test_errors]\n{rows}")

    monkeypatch.syspath_prepend(str(tmp_path))
    return install


def errors(**kwargs) -> Registry[type[Exception]]:
    return Registry("palpate.test_errors", "error", OWN, **kwargs)


def test_an_own_entry_is_loaded_by_its_name():
    assert errors().get("extra").__name__ == "MissingExtraError"
    assert errors().names == ("extra",)
    assert "extra" in errors()


def test_an_unknown_name_is_refused_with_the_names_there_are_and_the_group():
    with refused("kind-unknown", "none", "extra", "palpate.test_errors"):
        errors().get("none")


def test_an_entry_point_of_an_installed_package_is_found_and_loaded_once(guest):
    guest("guest_one", "class Own(Exception): pass", late="guest_one:Own")
    registry = errors()
    assert registry.names == ("extra", "late")
    assert registry.get("late") is registry.get("late")


def test_a_package_that_cannot_be_imported_hinders_only_who_asks_for_it(guest):
    guest("guest_two", "import a_module_that_is_not_there", broken="guest_two:Own")
    registry = errors()
    assert registry.get("extra")
    with refused("kind-unloadable", "broken", "guest_two"):
        registry.get("broken")


def test_two_packages_of_one_name_are_refused_by_their_names(guest):
    guest("guest_three", "class Own(Exception): pass", same="guest_three:Own")
    guest("guest_four", "class Own(Exception): pass", same="guest_four:Own", extra="guest_four:Own")
    with refused("kind-offered-twice", "guest_"):
        errors().get("same")
    with refused("kind-offered-twice", "palpate", "guest_four"):
        errors().get("extra")


def test_what_is_no_implementation_is_refused(guest):
    guest("guest_five", "Own = 5", number="guest_five:Own")
    with refused("kind-wrong-type"):
        errors(fits=lambda found: isinstance(found, type)).get("number")


def test_nothing_is_imported_before_it_is_asked_for(guest, tmp_path: Path):
    mark = tmp_path / "imported"
    guest("guest_six", f"open({str(mark)!r}, 'w').close()\nclass Own(Exception): pass", lazy="guest_six:Own")
    registry = errors()
    assert "lazy" in registry.names
    assert not mark.exists()
    registry.get("lazy")
    assert mark.exists()
