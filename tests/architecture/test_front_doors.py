"""Public names of each stage. Taking one away breaks somebody's program: do it on purpose, here as well."""

import importlib

import pytest

FRONT_DOORS = {
    "core": {
        "ArtefactStore",
        "MissingExtraError",
        "PalpateError",
        "ParameterNote",
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
        "DomeShape",
        "DomeSpec",
        "Finding",
        "MarkerLayout",
        "MarkerSpec",
        "MountSpec",
        "Solid",
        "build_dome",
        "build_module",
        "build_solid",
        "check_design",
        "place_markers",
        "place_orientation_mark",
        "read_points",
        "ring_diameters",
    },
    "material": {"Material", "get_material", "list_materials"},
    "mesh": {"Mesh", "MeshSpec", "Rim", "mesh_dome"},
    "camera": {
        "BoardSpec",
        "Calibration",
        "RenderSpec",
        "render",
        "Camera",
        "CameraSpec",
        "build_camera",
        "calibrate_camera",
        "preset",
        "read_calibration",
        "read_image",
        "write_board",
        "write_calibration",
    },
    "markers": {
        "Blobs",
        "DetectSpec",
        "Detector",
        "Naming",
        "Tracker",
        "Tracks",
        "build_pattern",
        "find_markers",
        "name_markers",
        "prepare_detector",
    },
    "fea": {
        "DeckSpec",
        "FEA_VERSION",
        "Press",
        "SolverSpec",
        "WallSpec",
        "deck_text",
        "export_press",
        "read_press",
        "Stability",
        "find_stability",
        "plot_convergence",
        "study_convergence",
        "solve_press",
        "solve_press_calculix",
        "write_deck",
        "write_press",
    },
    "dataset": {"DATASET_VERSION", "Dataset", "DatasetSpec", "generate_dataset", "read_dataset", "write_dataset"},
    "learn": {
        "Coverage",
        "LEARN_VERSION",
        "Metrics",
        "Prediction",
        "SearchSpec",
        "calibrate",
        "compare_splits",
        "evaluate",
        "measure_coverage",
        "open_predictor",
        "search",
        "shuffle_labels",
    },
    "fabricate": {"FabricationPack", "PackSpec", "ProcessSpec", "draw_artwork", "write_pack"},
    "study": {"DesignResult", "Observer", "Study", "StudyResult", "list_presets", "read_study", "run_study"},
    "grid": {"SpecificationGrid", "evaluate_grid", "write_grid"},
    "cli": {"main"},
}


@pytest.mark.parametrize("stage", FRONT_DOORS)
def test_public_names_stay(stage: str) -> None:
    door = importlib.import_module(f"palpate.{stage}")
    assert FRONT_DOORS[stage] <= set(door.__all__)
    assert all(hasattr(door, name) for name in door.__all__)
    assert len(door.__all__) <= 40, "a front door fits one screen"
