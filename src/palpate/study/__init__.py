"""Study: one YAML file carried through the whole chain, on worker processes, resumed where it was."""

from palpate.study.observer import Observer, Silence
from palpate.study.read_study import list_presets, read_study
from palpate.study.result import Counts, DesignLimits, DesignResult, PressSummary, StudyResult, TaskFailure
from palpate.study.run_study import available_cores, run_limits, run_study
from palpate.study.study import DesignsSpec, MaterialSpec, Study

__all__ = [
    "Counts",
    "DesignLimits",
    "DesignResult",
    "DesignsSpec",
    "MaterialSpec",
    "Observer",
    "PressSummary",
    "Silence",
    "Study",
    "StudyResult",
    "TaskFailure",
    "available_cores",
    "list_presets",
    "read_study",
    "run_limits",
    "run_study",
]
