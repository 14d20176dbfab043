"""Old names work for one version and say what replaces them."""

import importlib

import pytest
from packaging.version import Version

from palpate.core import __version__


@pytest.mark.parametrize(
    ("room", "old", "new"), [("design", "build_dome", "build_skin"), ("mesh", "mesh_dome", "mesh_skin")]
)
def test_an_old_name_is_the_new_one_and_warns_where_it_is_used(room, old, new):
    module = importlib.import_module(f"palpate.{room}")
    with pytest.warns(DeprecationWarning, match=rf"palpate\.{room}\.{old} is palpate\.{room}\.{new} now") as seen:
        found = getattr(module, old)
    assert found is getattr(module, new)
    assert seen[0].filename == __file__
    assert old not in module.__all__


def test_what_is_to_go_has_not_outlived_its_version():
    with pytest.warns(DeprecationWarning, match="takes the old name away") as seen:
        from palpate.design import build_dome
    assert build_dome is not None
    gone = str(seen[0].message).split("; ")[1].split(" ")[0]
    assert Version(__version__) < Version(gone)


def test_a_name_that_never_was_is_missing():
    with pytest.raises(AttributeError) as missing:
        importlib.import_module("palpate.design").build_cone  # noqa: B018
    assert missing.value.name == "build_cone"
    with pytest.raises(ImportError):
        from palpate.mesh import mesh_cone  # noqa: F401
