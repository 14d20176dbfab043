"""Readings over HTTP and a websocket, with the viewer's access control.

GET  /reading    the newest reading, 204 before the first
POST /image      an image file (PNG, JPEG) is read as the next one; returns its reading
WS   /readings   every reading; `lost` counts the readings that a slow client missed
"""

from __future__ import annotations

import asyncio
import socket
import threading
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from typing import Any

from palpate.camera import Source, decode_image
from palpate.core import PalpateError, load_extra
from palpate.sensor import Broadcast, Sensor, SourceReader
from palpate.viewer.guard import Guard
from palpate.viewer.server import ServeSpec, bind_server, page_url

_BACKLOG_BYTES = 32_768
"""Send buffer of each client, some fifty readings."""
SCHEMA_VERSION = 2
"""Version of the keys of a reading, its key `schema`; 1, of 0.2, had none."""


@dataclass(frozen=True)
class Feed:
    """Image source of a server, in addition to the images that clients send.

    Attributes
    ----------
    open_source
        Opens the source; `None` if only clients send images.
    again
        Whether the source is reopened at its end.
    retry_s
        Time between two tries, s.
    """

    open_source: Callable[[], Source] | None = None
    again: bool = True
    retry_s: float = 1.0


def build_readings_app(sensor: Sensor, feed: Feed) -> Any:
    """Build the ASGI application of an open sensor, without access control.

    Raises
    ------
    MissingExtraError
        If Starlette is not installed.
    """
    load_extra("starlette", "web", "Starlette")
    from starlette.applications import Starlette
    from starlette.concurrency import run_in_threadpool
    from starlette.requests import Request
    from starlette.responses import JSONResponse, Response
    from starlette.routing import Route, WebSocketRoute
    from starlette.websockets import WebSocket, WebSocketDisconnect

    hub = Broadcast()
    loops: list[asyncio.AbstractEventLoop] = []
    reader = SourceReader(sensor, lambda row: _hand_over(loops, hub, _with_schema(row)))

    @asynccontextmanager
    async def live(_: Any) -> AsyncIterator[None]:
        loops.append(asyncio.get_running_loop())
        if feed.open_source is not None:
            words = (feed.open_source, feed.retry_s, feed.again)
            threading.Thread(target=reader.run, args=words, daemon=True).start()
        yield
        reader.stop()

    async def newest(_: Request) -> Response:
        return JSONResponse(hub.last) if hub.last else Response(status_code=204)

    async def take_image(request: Request) -> Response:
        try:
            image = decode_image(await request.body())
        except PalpateError as error:
            content = {"problem": error.problem, "remedy": error.remedy, "code": error.code}
            return JSONResponse(content, status_code=400)
        return JSONResponse(_with_schema(await run_in_threadpool(reader.read, image)))

    async def stream(socket: WebSocket) -> None:
        await socket.accept()
        with hub.listen() as listener, suppress(WebSocketDisconnect, RuntimeError):
            gone = asyncio.ensure_future(_until_gone(socket))
            try:
                while not gone.done():
                    waiting = asyncio.ensure_future(listener.take())
                    await asyncio.wait({gone, waiting}, return_when=asyncio.FIRST_COMPLETED)
                    if not waiting.done():
                        waiting.cancel()
                        break
                    await socket.send_json(waiting.result())
            finally:
                gone.cancel()

    routes = [
        Route("/", newest),
        Route("/reading", newest),
        Route("/image", take_image, methods=["POST"]),
        WebSocketRoute("/readings", stream),
    ]
    return Starlette(routes=routes, lifespan=live)


def _with_schema(row: dict[str, Any]) -> dict[str, Any]:
    return {"schema": SCHEMA_VERSION, **row}


async def _until_gone(socket: Any) -> None:
    """Return when a client closes; messages of the client are ignored."""
    while (await socket.receive())["type"] != "websocket.disconnect":
        pass


def _hand_over(loops: list[asyncio.AbstractEventLoop], hub: Broadcast, row: dict[str, Any]) -> None:
    """Publish a reading in the event loop of the server, from the reading thread."""
    with suppress(RuntimeError):  # the server has been closed meanwhile
        loops[-1].call_soon_threadsafe(hub.publish, row)


def bound_backlog(listener: socket.socket) -> None:
    """Limit the send buffer of the system, so that a slow client gets recent readings."""
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _BACKLOG_BYTES)


def serve_readings(sensor: Sensor, feed: Feed, spec: ServeSpec, announce: Callable[[str], None]) -> None:
    """Serve the readings of a sensor until it is interrupted.

    Parameters
    ----------
    sensor, feed
        The opened sensor, and its image source.
    spec
        Where to listen.
    announce
        Called with the link as soon as the port is taken.

    Raises
    ------
    PalpateError
        If the address is not available.
    MissingExtraError
        If Starlette or uvicorn is not installed.
    """
    uvicorn: Any = load_extra("uvicorn", "web")
    app = build_readings_app(sensor, feed)
    door, listener = bind_server(spec)
    try:
        bound_backlog(listener)
        announce(page_url(door, "reading"))
        # unpacked: packing costs time, and a client that stalls would have minutes of readings in the system
        config = uvicorn.Config(
            Guard(app, door), log_level="warning", server_header=False, lifespan="on", ws_per_message_deflate=False
        )
        uvicorn.Server(config).run(sockets=[listener])
    finally:
        listener.close()
