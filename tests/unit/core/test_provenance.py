import palpate
from palpate.core import installed_version, provenance


def test_provenance_names_palpate_and_numpy() -> None:
    found = provenance()
    assert found["palpate"] == palpate.__version__
    assert found["numpy"] == installed_version("numpy")


def test_a_library_that_is_not_there_has_no_version() -> None:
    assert installed_version("no-such-distribution-anywhere") is None
