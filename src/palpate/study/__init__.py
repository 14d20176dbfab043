"""Study: one YAML file carried through the whole chain, on worker processes, resumed where it was."""

from palpate.study.available import available_cores
from palpate.study.built_task import keep_twins
from palpate.study.cluster import check_place
from palpate.study.observer import Observer, Silence
from palpate.study.read_study import list_presets, read_study
from palpate.study.result import Counts, DesignLimits, DesignResult, PressSummary, StudyResult, TaskFailure
from palpate.study.run_study import run_limits, run_study
from palpate.study.run_twins import BuiltDesign, run_twins
from palpate.study.status import KindStatus, StudyStatus, find_status, needed_keys
from palpate.study.study import BuiltSpec, DesignsSpec, MaterialSpec, Study, study_of

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
    "Silence",
    "Study",
    "StudyResult",
    "StudyStatus",
    "TaskFailure",
    "available_cores",
    "check_place",
    "find_status",
    "keep_twins",
    "list_presets",
    "needed_keys",
    "read_study",
    "run_limits",
    "run_study",
    "run_twins",
    "study_of",
]
