"""Simulated controller of Universal Robots that speaks its public protocols, and fails on request.

Dashboard (port 29999), script (30003) and RTDE (30004), after the vendor's guides. It knows the commands of the
program that ur-rtde uploads, moves the flange on straight lines, and stops if its watchdog receives no signal.
"""

from __future__ import annotations

import itertools
import os
import socket
import struct
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

START = np.array([0.4, -0.12, 0.3, 0.0, 3.1, 0.0])
SAYS = {
    "polyscopeversion": "URSoftware 5.11.1.108318 (Dec 15 2021)",
    "is in remote control": "true",
    "get serial number": "20215500123",
    "get robot model": "UR5",
    "robotmode": "Robotmode: RUNNING",
}
VECTORS = ("actual_", "target_", "external_force_torque")
INTEGERS = ("int_register", "robot_mode", "safety_mode", "joint_mode")
STOPS = {"protective": 1 << 2, "safeguard": 1 << 4, "emergency": 1 << 7}
HOSTS = (f"127.{os.getpid() % 250 + 1}.{number // 250}.{number % 250 + 2}" for number in itertools.count())
"""Addresses of this machine; the ports are fixed."""
STEP_S = 0.002
MOVE, STOP_SCRIPT, SET_TCP, STOP_MOVE, WATCHDOG, GET_TCP = 3, 255, 29, 33, 35, 40


def kind(name: str) -> tuple[str, str]:
    """Type of a value: its name in RTDE, and its format."""
    if name.startswith(VECTORS):
        return "VECTOR6D", "6d"
    if "double_register" in name or name == "timestamp":
        return "DOUBLE", "d"
    return ("INT32", "i") if any(word in name for word in INTEGERS) else ("UINT32", "I")


class UrController:
    """Controller at an address of its own; `fault` makes its next move fail."""

    def __init__(self) -> None:
        self.host = next(HOSTS)
        self.pose, self.speed, self.force, self.tool = START.copy(), np.zeros(6), np.zeros(6), np.ones(6)
        self.running = self.silent = False
        self.safety, self.fault, self.commands, self.places = 1, "", [], [START.copy()]
        self.registers: dict[str, Any] = {}
        self.watchdog_hz, self.heard = 0.0, time.monotonic()
        self.move_number, self.connections, self.open = 0, [], True
        ports = {29999: self.dashboard, 30003: self.script, 30004: self.rtde}
        self.listening = [self.listen(port, serve) for port, serve in ports.items()]

        threading.Thread(target=self.watch, daemon=True).start()

    def watch(self) -> None:
        """End the program if the watchdog receives no signal."""
        while self.open:
            time.sleep(STEP_S)
            self.running &= not (self.watchdog_hz and time.monotonic() - self.heard > 1.0 / self.watchdog_hz)

    def listen(self, port: int, serve: Callable[[socket.socket], None]) -> socket.socket:
        listening = socket.create_server((self.host, port))

        def accept() -> None:
            while self.open:
                try:
                    connection, _ = listening.accept()
                except OSError:
                    return
                connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                self.connections.append(connection)
                threading.Thread(target=guarded, args=(serve, connection), daemon=True).start()

        threading.Thread(target=accept, daemon=True).start()
        return listening

    def close(self) -> None:
        self.open = False
        self.drop()
        for each in self.listening:
            each.close()

    def drop(self) -> None:
        """Close every connection."""
        for each in self.connections:
            with suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)
        self.connections.clear()

    def dashboard(self, connection: socket.socket) -> None:
        connection.sendall(b"Connected: Universal Robots Dashboard Server\n")
        for line in connection.makefile("rb"):
            word = line.decode().strip().lower()
            self.running &= word != "stop"
            says = f"Program running: {str(self.running).lower()}" if word == "running" else SAYS.get(word, "ok")
            connection.sendall(f"{says}\n".encode())

    def script(self, connection: socket.socket) -> None:
        while received := connection.recv(1 << 16):
            if b"def rtde_control" in received:
                self.move_number += 1
                self.watchdog_hz, self.registers["output_int_register_0"], self.running = 0.0, 1, True

    def rtde(self, connection: socket.socket) -> None:
        inputs: list[list[str]] = []
        lock, stream = threading.Lock(), connection.makefile("rb")

        def send(code: int, body: bytes) -> None:
            with lock:
                connection.sendall(struct.pack(">HB", 3 + len(body), code) + body)

        def report(hz: float, names: list[str]) -> None:
            while self.open:
                time.sleep(1.0 / hz)
                if not self.silent:
                    send(ord("U"), b"\x01" + b"".join(self.value(name) for name in names))

        outputs: tuple[float, list[str]] = (125.0, [])
        while head := stream.read(3):
            size, code = struct.unpack(">HB", head)
            body = stream.read(size - 3)
            if code == ord("V"):
                send(code, b"\x01")
            elif code == ord("v"):
                send(code, struct.pack(">4I", 5, 11, 1, 108318))
            elif code in (ord("O"), ord("I")):
                start = 8 * (code == ord("O"))
                names = [name for name in body[start:].decode().split(",") if name]
                if start:
                    outputs = (struct.unpack(">d", body[:8])[0], names)
                else:
                    inputs.append(names)
                send(code, bytes([max(len(inputs), 1)]) + ",".join(kind(name)[0] for name in names).encode())
            elif code == ord("S"):
                send(code, b"\x01")
                threading.Thread(target=guarded, args=(report, *outputs), daemon=True).start()
            elif code == ord("U"):
                names = inputs[body[0] - 1]
                layout = ">" + "".join(kind(name)[1] for name in names)
                values = struct.unpack(layout, body[1 : 1 + struct.calcsize(layout)])
                self.obey(dict(zip(names, values, strict=True)))

    def value(self, name: str) -> bytes:
        known = {
            "timestamp": time.monotonic(),
            "actual_TCP_pose": self.pose,
            "actual_TCP_speed": self.speed,
            "actual_TCP_force": self.force,
            "robot_status_bits": 1 | self.running << 1,
            "safety_status_bits": self.safety,
            "runtime_state": 1 + self.running,
        }
        layout = kind(name)[1]
        found = known.get(name, self.registers.get(name, 0))
        return (
            struct.pack(f">{layout}", *np.broadcast_to(found, 6))
            if layout == "6d"
            else struct.pack(f">{layout}", found)
        )

    def obey(self, values: dict[str, Any]) -> None:
        self.heard = time.monotonic()
        command = values["input_int_register_0"]
        if command == 0:
            self.registers["output_int_register_0"] = 1
            return
        numbers = [value for name, value in values.items() if "double" in name]
        if command in (MOVE, STOP_MOVE, STOP_SCRIPT):
            self.move_number += 1
        if command == MOVE:
            self.commands.append(np.array(numbers[:6]))
            arguments = (self.move_number, np.array(numbers[:6]), numbers[6])
            threading.Thread(target=self.travel, args=arguments, daemon=True).start()
        elif command == SET_TCP:
            self.tool = np.array(numbers)
        elif command == WATCHDOG:
            self.watchdog_hz = numbers[0]
        elif command == GET_TCP:
            self.registers |= {f"output_double_register_{axis}": value for axis, value in enumerate(self.tool)}
        elif command == STOP_SCRIPT:
            self.running = False
        self.registers["output_int_register_0"] = 2

    def travel(self, number: int, goal: np.ndarray, speed: float) -> None:
        """Move on a straight line, unless another command or a fault ends it."""
        start, fault, self.fault = self.pose.copy(), self.fault, ""
        first = Rotation.from_rotvec(start[3:])
        turn = (first.inv() * Rotation.from_rotvec(goal[3:])).as_rotvec()
        steps = max(int(np.linalg.norm(goal[:3] - start[:3]) / (speed * STEP_S)), 4)
        for step in range(1, steps + 1):
            time.sleep(STEP_S)
            if number != self.move_number or not self.running or self.safety != 1:
                break
            place = start[:3] + step / steps * (goal[:3] - start[:3])
            turned = first * Rotation.from_rotvec(step / steps * turn)
            self.pose = np.concatenate([place, turned.as_rotvec()])
            self.speed = np.concatenate([goal[:3] - start[:3], turn]) / (steps * STEP_S)
            self.places.append(self.pose)
            if step == steps // 2:
                self.fail(fault)
        self.speed = np.zeros(6)

    def fail(self, fault: str) -> None:
        self.safety = STOPS.get(fault, self.safety)
        self.force = np.array([0.0, 0.0, 80.0, 0.0, 0.0, 0.0]) if fault == "force" else self.force
        self.running &= fault != "program"
        self.silent |= fault == "silence"
        if fault == "drop":
            self.drop()


def guarded(serve: Callable[..., None], *arguments: Any) -> None:
    """Serve until the connection is closed."""
    try:
        serve(*arguments)
    except (OSError, ValueError):
        return
