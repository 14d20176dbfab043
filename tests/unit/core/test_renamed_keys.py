"""Old columns are read with a warning; old keys of a spec are refused with the new one."""

import pytest
from palpate_benchmark import BenchmarkSpec, TwinPressSpec
from pydantic import ValidationError

from palpate.calibration import ToleranceSpec
from palpate.camera import CalibrationSpec
from palpate.core.renamed_keys import RENAMED_COLUMNS, RENAMED_KEYS, new_column, rename_columns
from palpate.fabrication import ProcessSpec
from palpate.fea import ObstacleSpec, WallSpec
from palpate.learn import RecordingSpec
from palpate.material import FitSpec, PrepareSpec
from palpate.optimise import RequirementsSpec
from palpate.sensor import AcceptanceSpec, AlignSpec, SensorSpec
from palpate.simulation import SimulatedRobotSpec, VirtualBenchSpec
from palpate.study import AsBuiltSpec, Study, filter_rows, sort_rows
from palpate.viewer.sketch import DesignDraft

SPECS = {
    spec.__name__: spec
    for spec in (
        AcceptanceSpec,
        AlignSpec,
        AsBuiltSpec,
        BenchmarkSpec,
        CalibrationSpec,
        DesignDraft,
        FitSpec,
        ObstacleSpec,
        PrepareSpec,
        ProcessSpec,
        RecordingSpec,
        RequirementsSpec,
        SensorSpec,
        SimulatedRobotSpec,
        ToleranceSpec,
        TwinPressSpec,
        VirtualBenchSpec,
        WallSpec,
        Study,
    )
}


@pytest.mark.parametrize(("old", "new"), RENAMED_COLUMNS.items())
def test_an_old_column_is_read_with_a_warning(old: str, new: str) -> None:
    with pytest.warns(FutureWarning, match=f"{old} is {new} now"):
        assert rename_columns({old: 1.0, "other": 2.0}) == {new: 1.0, "other": 2.0}
    with pytest.warns(FutureWarning):
        assert new_column(old, {new: 1.0}) == new


@pytest.mark.parametrize(("old", "new"), RENAMED_COLUMNS.items())
def test_a_question_may_name_an_old_column(old: str, new: str) -> None:
    rows = [{new: 2.0}, {new: 1.0}]
    with pytest.warns(FutureWarning):
        assert filter_rows(rows, f"{old} < 1.5") == ({new: 1.0},)
    with pytest.warns(FutureWarning):
        assert sort_rows(rows, old)[0] == {new: 1.0}


@pytest.mark.parametrize(
    ("name", "old", "new"), [(name, *pair) for name in RENAMED_KEYS for pair in RENAMED_KEYS[name].items()]
)
def test_an_old_key_is_refused_with_the_new_one(name: str, old: str, new: str) -> None:
    with pytest.raises(ValidationError) as caught:
        SPECS[name].model_validate({old: 1.0})
    first = caught.value.errors()[0]
    assert (first["type"], first["ctx"]) == ("yaml-key-renamed", {"old": old, "new": new})
    assert new.partition(":")[0] in SPECS[name].model_fields
