"""Study: one YAML file through the whole chain to a specification grid, its pictures and simulator assets."""

from palpate.study.accuracy_task import TwinTask, export_twins, plan_twin
from palpate.study.asset import OPTICAL_FROM_BODY, SensorAsset, build_asset, check_force_curve_press
from palpate.study.asset_shell import skin_surface
from palpate.study.asset_spec import AssetFormat, AssetSpec
from palpate.study.available import available_cores
from palpate.study.cluster import check_cluster_address
from palpate.study.compare_grids import Comparison, compare_grids
from palpate.study.draw_grid import write_picture
from palpate.study.evaluate_grid import evaluate_grid
from palpate.study.export_asset import check_asset, describe_asset, export_asset
from palpate.study.export_grid import export_grid, grid_report, html_rows
from palpate.study.grid import (
    Cell,
    Row,
    SpecificationGrid,
    design_label,
    design_spec,
    own_column,
    ranking_column,
    rows_for_design,
)
from palpate.study.grid_columns import MAIN_COLUMNS, grid_column
from palpate.study.grid_io import is_grid, read_grid, write_grid
from palpate.study.grid_model import copy_model
from palpate.study.grid_query import filter_rows, sort_rows
from palpate.study.mass import compute_mass_properties
from palpate.study.panel import cut_depth_panels, cut_marker_panels, cut_panels, cut_tilt_panels
from palpate.study.plan import plan_study
from palpate.study.plot_grid import (
    check_plot_request,
    draw_grid,
    draw_plot,
    plot_file_name,
    plot_grid,
)
from palpate.study.read_spec import read_spec
from palpate.study.read_study import list_presets, read_study
from palpate.study.result import Counts, DesignBounds, DesignResult, PressSummary, StudyResult, TaskFailure
from palpate.study.run_study import ensure_writable, resolve_device, run_bounds, run_study, run_tasks
from palpate.study.run_twins import DesignAccuracy, run_twins
from palpate.study.status import StudyStatus, find_status, needed_keys
from palpate.study.study import AsBuiltSpec, DesignsSpec, MaterialSpec, Study, single_design_study
from palpate.study.task import PressTask, Task, find_artefact, write_json

__all__ = [
    "MAIN_COLUMNS",
    "OPTICAL_FROM_BODY",
    "AsBuiltSpec",
    "AssetFormat",
    "AssetSpec",
    "Cell",
    "Comparison",
    "Counts",
    "DesignAccuracy",
    "DesignBounds",
    "DesignResult",
    "DesignsSpec",
    "MaterialSpec",
    "PressSummary",
    "PressTask",
    "Row",
    "SensorAsset",
    "SpecificationGrid",
    "Study",
    "StudyResult",
    "StudyStatus",
    "Task",
    "TaskFailure",
    "TwinTask",
    "available_cores",
    "build_asset",
    "check_asset",
    "check_cluster_address",
    "check_force_curve_press",
    "check_plot_request",
    "compare_grids",
    "compute_mass_properties",
    "copy_model",
    "cut_depth_panels",
    "cut_marker_panels",
    "cut_panels",
    "cut_tilt_panels",
    "describe_asset",
    "design_label",
    "design_spec",
    "draw_grid",
    "draw_plot",
    "ensure_writable",
    "evaluate_grid",
    "export_asset",
    "export_grid",
    "export_twins",
    "filter_rows",
    "find_artefact",
    "find_status",
    "grid_column",
    "grid_report",
    "html_rows",
    "is_grid",
    "list_presets",
    "needed_keys",
    "own_column",
    "plan_study",
    "plan_twin",
    "plot_file_name",
    "plot_grid",
    "ranking_column",
    "read_grid",
    "read_spec",
    "read_study",
    "resolve_device",
    "rows_for_design",
    "run_bounds",
    "run_study",
    "run_tasks",
    "run_twins",
    "single_design_study",
    "skin_surface",
    "sort_rows",
    "write_grid",
    "write_json",
    "write_picture",
]
