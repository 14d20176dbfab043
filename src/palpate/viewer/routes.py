"""Routes of the browser's requests: messages of one design, and exported files."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fastapi import APIRouter, FastAPI, Request, Response
from fastapi.responses import JSONResponse

from palpate.core import PalpateError
from palpate.core.report import csv_text
from palpate.viewer.design_cache import DesignCache
from palpate.viewer.export import dome_parts, marker_rows
from palpate.viewer.gltf import write_gltf
from palpate.viewer.link import selected_rows
from palpate.viewer.scene import describe_markers, describe_motion, describe_shell
from palpate.viewer.trained import TrainedSensor

BINARY = "application/octet-stream"


def make_routes(shelf: DesignCache, sensors: Mapping[str, TrainedSensor] | None = None) -> APIRouter:
    """Make the routes below ``/data``: name of a cached design or picture, tilt and azimuth in degrees."""
    router = APIRouter(prefix="/data")

    @router.get("/shell/{name:path}")
    def shell(name: str) -> Response:
        design, specimen = shelf.find(name)
        return Response(describe_shell(specimen, design.design.layout, design.design.camera), media_type=BINARY)

    @router.get("/motion/{name:path}")
    def motion(name: str, tilt: float = 0.0, azimuth: float = 0.0, field: str = "") -> Response:
        _, specimen = shelf.find(name)
        seen = specimen.pressed.at(tilt, azimuth)
        return Response(describe_motion(specimen, seen, field), media_type=BINARY)

    @router.get("/markers/{name:path}")
    def markers(name: str, tilt: float = 0.0, azimuth: float = 0.0) -> Response:
        design, specimen = shelf.find(name)
        pressed = specimen.pressed
        seen = pressed.markers(design.design.layout, design.design.camera, pressed.at(tilt, azimuth), azimuth)
        return Response(describe_markers(seen), media_type=BINARY)

    @router.get("/markers.csv")
    def markers_csv(name: str, tilt: float = 0.0, azimuth: float = 0.0) -> Response:
        return _csv("markers.csv", marker_rows(*shelf.find(name), tilt, azimuth))

    @router.get("/dome.glb")
    def dome(name: str, depth: float = 0.0, tilt: float = 0.0, azimuth: float = 0.0) -> Response:
        design, specimen = shelf.find(name)
        model = write_gltf(dome_parts(design, specimen, (depth, tilt, azimuth)))
        return Response(model, media_type="model/gltf-binary", headers=_attachment("dome.glb"))

    @router.get("/grid.csv")
    def grid(where: str = "", result: str = "") -> Response:
        if result not in shelf.libraries:
            raise PalpateError("There is no grid.", "Start the viewer with a result folder.", code="grid-missing")
        found = shelf.libraries[result].results.grid
        rows = [dict(found.designs[i]) for i in sorted(selected_rows(found, where))]
        return _csv("grid.csv", rows)

    @router.get("/learnt/{name}")
    def picture(name: str, result: str = "") -> Response:
        found = sensors[result].pictures if sensors and result in sensors else {}
        if name not in found:
            raise PalpateError(
                "There is no such picture.",
                "Make the report again by palpate recording train.",
                code="picture-missing",
            )
        return Response(found[name].read_bytes(), media_type="image/png")

    return router


def answer_errors(app: FastAPI) -> None:
    """Answer every `PalpateError` with its message and remedy."""

    @app.exception_handler(PalpateError)
    def _respond(_: Request, error: PalpateError) -> JSONResponse:
        return JSONResponse({"problem": error.problem, "remedy": error.remedy, "code": error.code}, status_code=422)


def _csv(name: str, rows: list[dict[str, Any]]) -> Response:
    return Response(csv_text(rows), media_type="text/csv", headers=_attachment(name))


def _attachment(name: str) -> dict[str, str]:
    return {"content-disposition": f'attachment; filename="{name}"'}
