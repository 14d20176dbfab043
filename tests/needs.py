"""What a test needs beside the package: where it is missing the test is skipped, with what to install."""

import importlib
import shutil
from typing import Any

import pytest

EXTRAS = {
    "cad": ("build123d", "ezdxf", "lib3mf", "trimesh"),
    "cluster": ("distributed",),
    "davis": ("dv_processing",),
    "learn": ("onnx", "onnxruntime", "optuna", "torch"),
    "parquet": ("pyarrow",),
    "ros": ("rosbags",),
    "ros2": ("websockets",),
    "ur": ("rtde_control",),
    "test": ("h5netcdf", "mlcroissant", "mujoco", "playwright", "pxr", "xarray", "yourdfpy"),
    "vision": ("PIL", "cv2"),
    "web": ("fastapi", "nicegui"),
}
"""Extra → modules that tests ask it for."""
LIBRARIES = {"libGL.so.1": "libgl1", "libX11.so.6": "libx11-6", "libexpat.so.1": "libexpat1"}
"""Library of the system → Debian package."""
PROGRAMS = {"calculix-ccx": ("ccx",), "chromium": ("chromium", "chromium-browser", "google-chrome")}
"""Debian package → names of its program."""


def needs(module: str) -> Any:
    """Import a module that an extra brings; skip the test, or its whole file, where that cannot be."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        top = module.partition(".")[0]
        extra = next(name for name, modules in EXTRAS.items() if top in modules)
        package = next((package for library, package in LIBRARIES.items() if library in str(error)), "")
        remedy = f"apt install {package}" if package else f"pip install -e '.[{extra}]'"
        pytest.skip(f"{top} cannot be imported ({error}): {remedy}", allow_module_level=True)


def find_program(package: str) -> str | None:
    """Path of the program that a Debian package brings."""
    return next(filter(None, map(shutil.which, PROGRAMS[package])), None)


def needs_program(package: str) -> pytest.MarkDecorator:
    """Mark of tests that call the program of a Debian package."""
    missing = find_program(package) is None
    return pytest.mark.skipif(missing, reason=f"{PROGRAMS[package][0]} is not there: apt install {package}")
