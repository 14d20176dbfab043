"""Commands of packages beside palpate: refused in one sentence where their package is not installed."""

import pytest

from errors import check_values
from palpate.cli.app import _without_package
from palpate.core import PalpateError


def test_a_command_without_its_package_names_what_installs_it() -> None:
    with pytest.raises(PalpateError) as error:
        _without_package("claims", "palpate_zaid2024")("results/best", "--out", "page.md")
    assert error.value.code == "package-missing"
    check_values(str(error.value), "palpate_zaid2024", "plugins/palpate_zaid2024")
