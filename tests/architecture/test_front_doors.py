"""Public names of each stage. Taking one away breaks somebody's program: do it on purpose, here as well."""

import importlib
from pathlib import Path

import pytest

FRONT_DOORS = {
    "core": {
        "ArtefactStore",
        "MissingExtraError",
        "PalpateError",
        "Recipe",
        "Spec",
        "child_seed",
        "generator",
        "kernel",
        "parameter",
        "parameters",
        "provenance",
    },
    "design": {
        "Dome",
        "Skin",
        "DomeSpec",
        "Finding",
        "MarkerLayout",
        "MarkerSpec",
        "MountSpec",
        "build_skin",
        "build_contact_module",
        "check_design",
        "place_markers",
        "place_orientation_mark",
        "read_points",
        "ring_diameters",
    },
    "material": {"Material", "get_material", "list_materials"},
    "cad": {"CadSolid", "read_step", "revolve", "write_step"},
    "mechanics": {"Continuation", "Obstacle", "Problem", "SolverSpec", "Term"},
    "mesh": {"Mesh", "MeshSpec", "mesh_skin"},
    "camera": {
        "BoardSpec",
        "Calibration",
        "RenderSpec",
        "render",
        "Camera",
        "CameraSpec",
        "build_camera",
        "calibrate_camera",
        "camera_preset",
        "read_calibration",
        "read_image",
        "write_board",
        "write_calibration",
    },
    "vision": {
        "Blobs",
        "DetectSpec",
        "Detector",
        "MarkerAssignment",
        "Tracker",
        "Tracks",
        "Registration",
        "register_dome",
        "build_pattern",
        "find_markers",
        "assign_markers",
        "prepare_detector",
    },
    "fea": {
        "Press",
        "SolverSpec",
        "WallSpec",
        "export_press",
        "read_press",
        "Stability",
        "find_stability",
        "plot_convergence",
        "study_convergence",
        "solve_press",
        "write_press",
    },
    "twin": {"PressField", "Twin", "build_field", "build_twin", "image_jacobian", "read_twin", "write_twin"},
    "built": {
        "Deviation",
        "IdentifiedUnit",
        "PoseFitter",
        "ToleranceSpec",
        "UnitModel",
        "predict_accuracy",
        "identify",
        "infer_from_rest",
        "build_unit_model",
    },
    "dataset": {"Dataset", "DatasetSpec", "generate_dataset", "read_dataset", "write_dataset"},
    "learn": {
        "Coverage",
        "Metrics",
        "Prediction",
        "LearningSpec",
        "calibrate_interval",
        "compare_splits",
        "evaluate",
        "measure_coverage",
        "open_predictor",
        "search_estimator",
        "shuffle_labels",
    },
    "recording": {
        "RecordedModel",
        "Recording",
        "RecordingSpec",
        "train_on_recording",
        "read_model",
        "read_recording",
        "write_model",
    },
    "sensor": {
        "Reading",
        "SensorSpec",
        "Sensor",
        "Unit",
        "find_depth_zero",
        "open_sensor",
        "identify_unit",
        "open_model",
        "run_sensor",
        "score_readings",
    },
    "simulation": {"VirtualBench", "Deviation", "ToleranceSpec", "VirtualBenchSpec", "run_bench", "run_budget"},
    "deck": {"DeckSpec", "deck_text", "solve_press_calculix", "write_deck"},
    "optimise": {"RequirementsSpec", "optimise_design", "read_requirements", "write_front"},
    "claims": {"assess_claims", "read_evidence", "write_claims"},
    "fabricate": {"FabricationPack", "ProcessSpec", "draw_artwork", "write_pack"},
    "study": {"DesignResult", "Study", "StudyResult", "list_presets", "read_study", "run_study"},
    "grid": {"SpecificationGrid", "evaluate_grid", "write_grid"},
    "ros": {"Message", "build_message", "header_of"},
    "robot": {
        "AlignSpec",
        "Aligner",
        "Alignment",
        "AlignmentOutcome",
        "Placement",
        "Robot",
        "Tool",
        "find_tool_offset",
    },
    "simulator": {"AssetFormat", "AssetSpec", "SensorAsset", "build_asset", "export_asset"},
    "cli": {"main"},
}


SOURCE = Path(__file__).parents[2] / "src" / "palpate"
STAGES = sorted(door.parent.name for door in SOURCE.glob("*/__init__.py"))
MOST_NAMES = 35
WIDER = {"core": 38, "built": 39, "design": 37, "fea": 38, "learn": 53, "mechanics": 37, "study": 37}
"""Rooms that are still to be trimmed."""


@pytest.mark.parametrize("stage", STAGES)
def test_public_names_stay(stage: str) -> None:
    door = importlib.import_module(f"palpate.{stage}")
    assert FRONT_DOORS.get(stage, set()) <= set(door.__all__)
    assert all(hasattr(door, name) for name in door.__all__)
    assert len(door.__all__) <= WIDER.get(stage, MOST_NAMES), "a front door fits one screen"
