"""Server of the viewer: one process, one result or folder of results, access control."""

from __future__ import annotations

import ipaddress
import secrets
import socket
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from palpate.core import PalpateError, load_extra
from palpate.viewer.guard import LOOPBACK, Guard, ServerAddress

_GIVE = "Give a result of a study, search or training, a press, a twin, or a folder of these."
SHORTEST_TOKEN = 16
"""Minimum number of characters of a token."""


@dataclass(frozen=True)
class ServeSpec:
    """Address of the viewer.

    Attributes
    ----------
    host, port
        Address and port; port 0 is any that is free.
    token
        Token of visitors; empty: none on a loopback address, a new one on any other.
    """

    host: str = "127.0.0.1"
    port: int = 8750
    token: str = ""


def bind_server(spec: ServeSpec) -> tuple[ServerAddress, socket.socket]:
    """Bind the port, and decide on the token.

    Raises
    ------
    PalpateError
        If the token is too short, or the address is not this machine's or in use.
    """
    if spec.token and (len(spec.token) < SHORTEST_TOKEN or not spec.token.isascii() or not spec.token.isalnum()):
        raise PalpateError(
            f"The token has {len(spec.token)} characters or other signs than letters and digits.",
            f"Take {SHORTEST_TOKEN} letters and digits or more, or leave it out: one is made.",
            code="token-malformed",
        )
    token = spec.token or ("" if is_loopback(spec.host) else secrets.token_hex(16))
    kind = socket.AF_INET6 if ":" in spec.host else socket.AF_INET
    listener = socket.socket(kind, socket.SOCK_STREAM)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        # else a reading waits until the last one is acknowledged (Nagle 1984), 40 ms
        listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        listener.bind((spec.host, spec.port))
        listener.listen()  # from now on visitors wait, even before the pages are ready
    except (OSError, OverflowError) as error:
        listener.close()
        reason = getattr(error, "strerror", None) or str(error)
        raise PalpateError(
            f"The viewer cannot listen at {spec.host}, port {spec.port}: {reason}.",
            "Another viewer may be running there: open it, or choose another --port (0: any that is free).",
            code="port-unavailable",
        ) from None
    return ServerAddress(spec.host, listener.getsockname()[1], token), listener


def is_loopback(host: str) -> bool:
    """Whether an address is reachable from this machine only."""
    if host in LOOPBACK:
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def page_url(door: ServerAddress, page: str = "") -> str:
    """Return the link to a page with the token."""
    host = f"[{door.host}]" if ":" in door.host else door.host
    return f"http://{host}:{door.port}/{page}" + (f"?token={door.token}" if door.token else "")


def serve(folder: Path | None, spec: ServeSpec, announce: Callable[[str], None]) -> None:
    """Serve the viewer until it is interrupted.

    Parameters
    ----------
    folder
        A result, or a folder of results, which are listed; without one, only pages that need no results are shown.
    spec
        Where to listen.
    announce
        Called with the link as soon as the port is taken.

    Raises
    ------
    PalpateError
        If the folder does not exist, or contains nothing to show; and as `bind_server`.
    MissingExtraError
        If NiceGUI is not installed.
    """
    if folder is not None and not folder.exists():
        raise PalpateError(f"{folder} does not exist.", _GIVE, code="folder-missing")
    load_extra("nicegui", "web", "NiceGUI")
    uvicorn: Any = load_extra("uvicorn", "web")
    from palpate.viewer.opened_results import find_results
    from palpate.viewer.pages import build_app

    if folder is not None and not find_results(folder):
        raise PalpateError(f"{folder} contains no result.", _GIVE, code="results-missing")
    door, listener = bind_server(spec)
    try:
        guarded = Guard(build_app(folder), door)
        announce(page_url(door, "" if folder else "design"))
        server = uvicorn.Server(
            uvicorn.Config(guarded, log_level="warning", server_header=False, ws_max_size=1_000_000, lifespan="on")
        )
        server.run(sockets=[listener])
    finally:
        listener.close()
