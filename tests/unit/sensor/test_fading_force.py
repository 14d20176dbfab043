"""Forces of readings through time: what a relaxing skin bears 0.1 s and 30 s after touch."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from errors import refused
from made_up_readings import make_reading
from palpate.calibration import Force
from palpate.material import Moduli, Relaxation, get_material
from palpate.sensor import Sensor
from palpate.sensor.force_relaxation import ForceRelaxation
from palpate.sensor.pose_estimator import ReaderState
from palpate.surrogate import twin_relaxation
from palpate.surrogate.twin_file import material_text

SERIES = Relaxation((0.1, 0.2), (0.5, 8.0))
NORMAL = np.array([0.0, 0.1, np.sqrt(0.99)])
ELASTIC = np.array([0.05, -0.02, 0.6])


def reading(vector=ELASTIC, touching=True):
    force = Force(np.asarray(vector, float), np.diag([1e-6, 2e-6, 4e-4]), NORMAL)
    return make_reading([0.0, 0.0, 3.0], touching=touching, force=force)


def test_a_touch_that_stays_bears_what_the_modulus_of_its_time_says():
    fading = ForceRelaxation(SERIES)
    fading.update(reading([0, 0, 0], touching=False), 99.999)
    for number in range(3001):
        now = 100.0 + number * 0.01
        found = fading.update(reading(), now)
        if number in (10, 3000):
            exact = float(SERIES.modulus(now - 99.9995))  # it came within the millisecond before
            assert found.force.vector == pytest.approx(exact * ELASTIC, rel=1e-3)
            assert found.force.covariance == pytest.approx(exact**2 * reading().force.covariance, rel=2e-3)
    # the same pose: 0.1 s after touch 40 % above the force of long ago, after 30 s 0.7 %
    assert float(SERIES.modulus(0.1)) == pytest.approx(1.3991, abs=1e-3)
    assert float(SERIES.modulus(30.0)) == pytest.approx(1.0067, abs=1e-4)


def test_the_rate_of_readings_does_not_matter_and_lost_ones_are_passed_over():
    dense, sparse = ForceRelaxation(SERIES), ForceRelaxation(SERIES)
    lost = replace(reading(), force=None)
    for number in range(201):
        now = number * 0.1
        size = min(now / 5, 1.0)
        last = dense.update(reading(size * ELASTIC), now)
        if number in (0, 50, 200):
            other = sparse.update(reading(size * ELASTIC), now)
        else:
            assert sparse.update(lost, now) is lost
    assert other.force.vector == pytest.approx(last.force.vector, rel=1e-9)


def test_a_skin_let_go_of_pulls_nothing_and_recovers():
    fading = ForceRelaxation(Relaxation((0.6,), (2.0,), Moduli.INSTANTANEOUS))
    fading.update(reading(), 0.0)
    fading.update(reading(), 20.0)
    eased = fading.update(reading(0.3 * ELASTIC), 20.01)
    assert eased.force.normal_force.value == 0.0
    untouched = reading([0, 0, 0], touching=False)
    assert fading.update(untouched, 20.02) is untouched
    for now in (30.0, 60.0):
        fading.update(untouched, now)
    again = fading.update(reading(), 60.001)
    assert again.force.vector == pytest.approx(ELASTIC, rel=1e-3)


def test_a_clock_that_starts_anew_begins_a_new_history():
    fading = ForceRelaxation(SERIES)
    fading.update(reading(), 500.0)
    fading.update(reading(), 600.0)
    fresh = fading.update(reading(), 3.0)
    assert fresh.force.vector == pytest.approx(SERIES.scale * ELASTIC)


def test_the_twin_tells_how_its_material_relaxes():
    plain = get_material("zaid_2024_ecoflex_00_30")
    told = {
        name: SimpleNamespace(material=material_text(each))
        for name, each in {
            "plain": plain,
            "fading": replace(plain, relaxation=SERIES),
            "torn": replace(plain, relaxation=SERIES, gel=plain),
        }.items()
    }
    assert twin_relaxation(SimpleNamespace(material="")) is None
    assert twin_relaxation(told["plain"]) is None
    assert twin_relaxation(told["fading"]) == SERIES
    with refused("gel-relaxes-otherwise"):
        twin_relaxation(told["torn"])


@pytest.mark.parametrize("clock", [True, False])
def test_a_sensor_follows_its_force_where_a_clock_tells_the_time(clock, monkeypatch):
    naming = SimpleNamespace(positions_px=np.zeros((3, 2)))
    reader = SimpleNamespace(relaxation=SERIES, begin=ReaderState)
    ticks = iter([0.0, 0.1, 30.0])
    sensor = Sensor(None, reader, None, None, naming, None, (lambda: next(ticks)) if clock else None)
    monkeypatch.setattr(sensor, "_read_elastic", lambda *_: reading())
    forces = [sensor.read(None).force.vector[2] / ELASTIC[2] for _ in range(3)]
    assert forces == pytest.approx([float(SERIES.modulus(t)) for t in (0.0, 0.1, 30.0)] if clock else [1.0] * 3)
