"""Study: one YAML file carried through the whole chain, on worker processes, resumed where it was."""

from palpate.study.available import available_cores
from palpate.study.built_task import TwinTask, export_twins, plan_twin
from palpate.study.cluster import check_cluster_address
from palpate.study.plan import plan_study
from palpate.study.read_spec import read_spec
from palpate.study.read_study import list_presets, read_study
from palpate.study.result import Counts, DesignBounds, DesignResult, PressSummary, StudyResult, TaskFailure
from palpate.study.run_study import ensure_writable, resolve_device, run_bounds, run_study, run_tasks
from palpate.study.run_twins import DesignAccuracy, run_twins
from palpate.study.status import KindStatus, StudyStatus, find_status, needed_keys
from palpate.study.study import AsBuiltSpec, DesignsSpec, MaterialSpec, Study, single_design_study
from palpate.study.task import PressTask, Task, find_artefact, write_json

__all__ = [
    "AsBuiltSpec",
    "Counts",
    "DesignAccuracy",
    "DesignBounds",
    "DesignResult",
    "DesignsSpec",
    "KindStatus",
    "MaterialSpec",
    "PressSummary",
    "PressTask",
    "Study",
    "StudyResult",
    "StudyStatus",
    "Task",
    "TaskFailure",
    "TwinTask",
    "available_cores",
    "check_cluster_address",
    "ensure_writable",
    "export_twins",
    "find_artefact",
    "find_status",
    "list_presets",
    "needed_keys",
    "plan_study",
    "plan_twin",
    "read_spec",
    "read_study",
    "resolve_device",
    "run_bounds",
    "run_study",
    "run_tasks",
    "run_twins",
    "single_design_study",
    "write_json",
]
