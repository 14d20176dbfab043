"""Serve 60 images a second to 20 clients, one stalled, the camera unplugged and back: latency, losses, memory.

    python benchmarks/serve_clients.py H20_T2.h5 --seconds 130

Server and clients are two processes of one machine; the time of an image is that at which its reading begins.
"""

import argparse
import asyncio
import json
import multiprocessing
import resource
import socket
import time
from pathlib import Path

import numpy as np
import uvicorn
import websockets

from palpate.calibration import Deviation
from palpate.camera import RenderSpec, Source
from palpate.core import PalpateError
from palpate.design import Design, MarkerSpec, place_markers
from palpate.sensor import Unit, open_sensor
from palpate.simulation import SimulatedUnit
from palpate.surrogate import read_twin
from palpate.viewer import Feed, ServeSpec, build_readings_app
from palpate.viewer.guard import Guard
from palpate.viewer.serve_readings import bound_backlog
from palpate.viewer.server import bind_server

RATE, CLIENTS = 60.0, 20


def memory_mb() -> float:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 1e6


def serve(path: Path, seconds: float, told: "multiprocessing.Queue") -> None:
    twin = read_twin(path)
    layout = place_markers(twin.skin, MarkerSpec(count=169))
    scene = SimulatedUnit(Design.of_skin(twin.skin, layout), Deviation(), RenderSpec(noise=2.0, blur_px=0.7))
    images = [scene.render_rest()]
    sensor = open_sensor(images, Unit(Design.of_skin(twin.skin, layout)), twin)
    began = time.monotonic()

    class Camera(Source):
        opened = 0

        def __init__(self) -> None:
            type(self).opened += 1
            if type(self).opened == 2:
                raise PalpateError("The camera cannot be opened.", "Plug it in.", code="source-not-opened")

        @property
        def name(self) -> str:
            return "60 images a second"

        def images(self):
            due = time.monotonic()
            while True:
                due += 1.0 / RATE
                time.sleep(max(0.0, due - time.monotonic()))
                if type(self).opened == 1 and time.monotonic() - began > 0.5 * seconds:
                    yield PalpateError("The camera gives nothing any more.", "Plug it in.", code="camera-gone")
                    return
                yield images[0]

    door, listener = bind_server(ServeSpec(port=0))
    bound_backlog(listener)
    app = Guard(build_readings_app(sensor, Feed(Camera)), door)
    server = uvicorn.Server(uvicorn.Config(app, log_level="error", lifespan="on", ws_per_message_deflate=False))
    told.put(door.port)

    async def run() -> None:
        task = asyncio.ensure_future(server.serve(sockets=[listener]))
        for share in (0.2, 0.5, 0.95):
            await asyncio.sleep(max(0.0, began + share * seconds - time.monotonic()))
            told.put((share, memory_mb()))
        await asyncio.sleep(max(0.0, began + seconds - time.monotonic()))
        server.should_exit = server.force_exit = True
        await task

    asyncio.run(run())


async def listen(port: int, until: float, stall: tuple[float, float] | None, rows: list) -> None:
    link = f"ws://127.0.0.1:{port}/readings"
    line = socket.socket()
    if stall:
        line.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 8192)  # else the system keeps minutes of readings for it
    line.connect(("127.0.0.1", port))
    async with websockets.connect(link, sock=line, max_queue=4, open_timeout=30) as client:
        try:
            while time.monotonic() < until:
                if stall and stall[0] < time.monotonic() < stall[1]:
                    await asyncio.sleep(stall[1] - time.monotonic())
                row = json.loads(await client.recv())
                rows.append((row["image"], row["lost"], time.time() - row["taken_s"], row["camera"]))
        except websockets.ConnectionClosed:
            return


async def clients(port: int, seconds: float) -> list[list]:
    now = time.monotonic()
    logs = [[] for _ in range(CLIENTS)]
    stalls = [(now + 0.1 * seconds, now + 0.6 * seconds), *[None] * (CLIENTS - 1)]
    await asyncio.gather(
        *(listen(port, now + seconds, stall, log) for stall, log in zip(stalls, logs, strict=True)),
    )
    return logs


def main() -> None:
    reader = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    reader.add_argument("twin", type=Path)
    reader.add_argument("--seconds", type=float, default=130.0)
    chosen = reader.parse_args()
    told: multiprocessing.Queue = multiprocessing.Queue()
    server = multiprocessing.Process(target=serve, args=(chosen.twin, chosen.seconds + 5.0, told))
    server.start()
    logs = asyncio.run(clients(told.get(), chosen.seconds - 5.0))
    server.join()
    late = np.array([row[2] for log in logs[1:] for row in log]) * 1e3
    print(f"images: {len(logs[1])} in {chosen.seconds - 5:g} s, clients: {CLIENTS}")
    print(f"image to client, ms: P50 {np.median(late):.1f}, P99 {np.quantile(late, 0.99):.1f}, most {late.max():.1f}")
    for name, which in (("19 clients", logs[1:]), ("the stalled one", logs[:1])):
        missing = sum(log[-1][0] - log[0][0] + 1 - len(log) for log in which)
        said = sum(row[1] for log in which for row in log[1:])
        last = min(log[-1][0] for log in which)
        print(f"{name}: {missing} readings missing, {said} said to be lost, heard up to image {last}")
    print(f"camera gone: {sum(row[3] == 'gone' for row in logs[1])} time")
    while not told.empty():
        share, used = told.get()
        print(f"memory of the server after {share:.0%}: {used:.1f} MB")


if __name__ == "__main__":
    main()
