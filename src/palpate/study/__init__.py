"""Study: one YAML file carried through the whole chain, on worker processes, resumed where it was."""

from palpate.study.available import available_cores
from palpate.study.built_task import TwinTask, keep_twins, plan_twin
from palpate.study.cluster import check_place
from palpate.study.observer import Observer, Silence
from palpate.study.plan import plan_study
from palpate.study.read_spec import read_spec
from palpate.study.read_study import list_presets, read_study
from palpate.study.result import Counts, DesignLimits, DesignResult, PressSummary, StudyResult, TaskFailure
from palpate.study.run_study import on_its_device, run_limits, run_study, run_tasks, writable
from palpate.study.run_twins import BuiltDesign, run_twins
from palpate.study.status import KindStatus, StudyStatus, find_status, needed_keys
from palpate.study.study import BuiltSpec, DesignsSpec, MaterialSpec, Study, study_of
from palpate.study.task import PressTask, Task, find_made, write_json

__all__ = [
    "BuiltDesign",
    "BuiltSpec",
    "Counts",
    "DesignLimits",
    "DesignResult",
    "DesignsSpec",
    "KindStatus",
    "MaterialSpec",
    "Observer",
    "PressSummary",
    "PressTask",
    "Silence",
    "Study",
    "StudyResult",
    "StudyStatus",
    "Task",
    "TaskFailure",
    "TwinTask",
    "available_cores",
    "check_place",
    "find_made",
    "find_status",
    "keep_twins",
    "list_presets",
    "needed_keys",
    "on_its_device",
    "plan_study",
    "plan_twin",
    "read_spec",
    "read_study",
    "run_limits",
    "run_study",
    "run_tasks",
    "run_twins",
    "study_of",
    "writable",
    "write_json",
]
