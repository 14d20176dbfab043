"""`palpate sensor serve`: readings of a sensor for other programs, by WebSocket and HTTP."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from palpate.cli.flag import flags_of
from palpate.cli.sensor import check_source, open_images
from palpate.cli.unit import ModelFlags, UnitFlags, open_printing_scale
from palpate.core import PalpateError
from palpate.sensor import SensorSpec

_SOURCE = (
    "Number of a camera, a video, a folder of images, or 'synthetic' (simulated images). The first images must show "
    "the unloaded skin."
)
_HOST = "Address to listen at; at other addresses than this machine's own, clients need a token."
_PORT = "Port to listen at; 0 selects a free port."
_TOKEN = "Token of the clients, at least 16 letters and digits; by default it is generated if needed."


@Parameter(name="*")
@dataclass(frozen=True)
class DoorFlags:
    """Address, port and token of the server."""

    host: Annotated[str, Parameter(help=_HOST)] = "127.0.0.1"
    port: Annotated[int, Parameter(help=_PORT)] = 8760
    token: Annotated[str, Parameter(help=_TOKEN)] = ""


def serve(
    *,
    source: Annotated[str, Parameter(help=_SOURCE)],
    reads: ModelFlags = ModelFlags(),
    built: UnitFlags = UnitFlags(),
    rig: Annotated[SensorSpec, flags_of(SensorSpec, group="Readings")] = SensorSpec(),
    door: DoorFlags = DoorFlags(),
) -> None:
    """Read a sensor and send every reading to all clients; clients may also send images."""
    from palpate.sensor import open_model
    from palpate.viewer import Feed, ServeSpec, serve_readings

    check_source(source)
    unit = built.unit(reads.material)
    model = open_model(reads.find(built), unit.design.skin)
    with open_images(source, unit) as opened:
        rest, clock = list(islice(opened.images(), rig.rest_images)), opened.clock
    images = [image for image in rest if not isinstance(image, PalpateError)]
    if len(images) < rig.rest_images:
        raise PalpateError(
            f"The source has {len(images)} readable rest images, and {rig.rest_images} are required.",
            "Record more images, or lower --rest-images.",
            code="rest-images-few",
        )
    sensor = open_printing_scale(images, unit, model, rig)
    sensor.clock = clock
    feed = Feed(lambda: open_images(source, unit), again=not Path(source).exists())
    serve_readings(sensor, feed, ServeSpec(door.host, door.port, door.token), _announce)


def _announce(link: str) -> None:
    print(f"Latest reading: {link}. All readings: WebSocket at /readings.", file=sys.stderr, flush=True)
