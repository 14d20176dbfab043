import pytest

from errors import check_values, refused
from palpate.design import Dome, Finding, MarkerSpec, Severity, check_design, place_markers, raise_on_errors

DOME = Dome(20.0, 20.0, 2.0)


def check(dome: Dome = DOME, **markers: object) -> dict[str, Finding]:
    layout = place_markers(dome, MarkerSpec(**markers))
    return {finding.code: finding for finding in check_design(dome, layout)}


@pytest.mark.parametrize("thickness", [1.0, 2.0, 3.0, 4.0])
@pytest.mark.parametrize("height", [10.0, 20.0])
@pytest.mark.parametrize("count", [7, 37, 91, 169])
def test_the_papers_designs_without_undercut_have_no_findings(height: float, thickness: float, count: int) -> None:
    assert check(Dome(height, 20.0, thickness), count=count) == {}


def test_a_bulging_dome_is_reported_as_undercut_with_its_width() -> None:
    finding = check(Dome(30.0, 20.0, 2.0))["undercut"]
    assert finding.severity is Severity.WARNING
    check_values(finding.message, "43.33 mm", "8.333 mm")


def test_a_wall_thicker_than_its_radius_is_reported() -> None:
    check_values(check(Dome(8.0, 8.0, 10.0), count=7)["wall-thicker-than-radius"].message, "10 mm")


def test_a_ring_outside_the_dome_is_an_error_with_a_remedy() -> None:
    found = check(ring_diameters=(10.0, 42.0))
    finding = found["ring-outside-dome"]
    assert finding.severity is Severity.ERROR
    check_values(finding.message, 12, "21 mm")
    with refused("ring-outside-dome", "40"):
        raise_on_errors(found.values())


def test_dots_that_overlap_are_reported_with_their_distance() -> None:
    check_values(check(count=169, diameter=4.0)["dots-overlap"].message, "4 mm")


def test_a_dot_over_the_rim_is_reported() -> None:
    found = check(Dome(10.0, 20.0, 2.0), ring_diameters=(39.5,))
    assert found["marker-near-rim"].severity is Severity.WARNING
    raise_on_errors(found.values())
