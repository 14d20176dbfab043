"""Access control of the server: origin, token and body size of requests.

Without a token only local pages are answered: ``Host`` must be a loopback address, which stops names that resolve to
it, and ``Origin`` must be the same, which stops other sites, also on websockets. With a token, every request must
carry it; it is compared in constant time, and a link with the token sets a cookie and is redirected without it.
"""

from __future__ import annotations

import hmac
from collections.abc import Awaitable, Callable, MutableMapping
from dataclasses import dataclass
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qsl, urlencode

Scope = MutableMapping[str, Any]
Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

LOOPBACK = ("127.0.0.1", "localhost", "::1")
LARGEST_BODY = 1_000_000
"""Maximum size of a body, bytes; uploads are not used, clicks and texts are small."""
LONGEST_QUERY = 8_000
_METHODS = ("GET", "HEAD", "POST")
_HEADERS = {
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
    "referrer-policy": "no-referrer",
    "cross-origin-resource-policy": "same-origin",
    "content-security-policy": "default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval' blob:; "
    "style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; font-src 'self' data:; worker-src 'self' blob:; "
    "connect-src 'self' blob: data: ws: wss:; object-src 'none'; base-uri 'none'; form-action 'self'; "
    "frame-ancestors 'none'",
}


@dataclass(frozen=True)
class ServerAddress:
    """Address of the server, and its token (empty: none is required)."""

    host: str
    port: int
    token: str = ""

    @property
    def cookie(self) -> str:
        """Name of the cookie of the token, different for servers on one machine."""
        return f"palpate_{self.port}"


class Guard:
    """Server application with access control.

    Parameters
    ----------
    app
        Guarded application.
    door
        Address and token.
    """

    def __init__(self, app: App, door: ServerAddress) -> None:
        self._app = app
        self._door = door

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request or connection."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        headers = {name.decode("latin-1").lower(): value.decode("latin-1") for name, value in scope["headers"]}
        refusal = self._refuse(scope, headers)
        if refusal:
            await _turn_away(scope, receive, send, *refusal)
        elif scope["type"] == "websocket":
            await self._app(scope, receive, send)
        elif self._door.token and "token" in dict(_query(scope)):
            await self._send_on(scope, send)
        else:
            await self._serve(scope, receive, send)

    def _refuse(self, scope: Scope, headers: MutableMapping[str, str]) -> tuple[int, str] | None:
        """Return status and message for a rejected request."""
        host, origin = headers.get("host", ""), headers.get("origin")
        if scope["type"] == "http" and scope["method"] not in _METHODS:
            return 405, "This method is not answered."
        if not self._door.token and _name(host) not in LOOPBACK:
            return 403, "This address is not answered. Open the link that palpate printed."
        if origin is not None and origin.split("://")[-1].lower() != host.lower():
            return 403, "Requests of other pages are not answered."
        if len(scope.get("query_string", b"")) > LONGEST_QUERY:
            return 414, "The link is too long."
        if not _is_short(headers.get("content-length", "0")):
            return 413, f"Bodies above {LARGEST_BODY} bytes are not taken."
        if self._door.token and not self._knows(scope, headers):
            return 401, "The token is missing or wrong. Open the link that palpate printed, with its token."
        return None

    def _knows(self, scope: Scope, headers: MutableMapping[str, str]) -> bool:
        try:
            jar = SimpleCookie(headers.get("cookie", ""))
        except CookieError:
            jar = SimpleCookie()
        kept = jar[self._door.cookie].value if self._door.cookie in jar else ""
        given = dict(_query(scope)).get("token", "") if scope["type"] == "http" else ""
        expected = self._door.token.encode()
        return sum(hmac.compare_digest(text.encode(), expected) for text in (kept, given)) > 0

    async def _send_on(self, scope: Scope, send: Send) -> None:
        """Set the token as a cookie and redirect to the address without it."""
        rest = urlencode([(name, value) for name, value in _query(scope) if name != "token"])
        path = "/" + scope["path"].lstrip("/")  # two slashes would lead to another machine
        place = path + (f"?{rest}" if rest else "")
        cookie = f"{self._door.cookie}={self._door.token}; Path=/; HttpOnly; SameSite=Strict"
        headers = [
            (b"location", place.encode()),
            (b"set-cookie", cookie.encode()),
            (b"referrer-policy", b"no-referrer"),
        ]
        await send({"type": "http.response.start", "status": 303, "headers": headers})
        await send({"type": "http.response.body", "body": b""})

    async def _serve(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on while its body is small enough; reject a larger one."""
        taken, started, refused = 0, False, False

        async def counted() -> Message:
            nonlocal taken, refused
            message = await receive()
            taken += len(message.get("body", b""))
            if taken <= LARGEST_BODY:
                return message
            if not started and not refused:
                refused = True
                await _turn_away(scope, receive, send, 413, f"Bodies above {LARGEST_BODY} bytes are not taken.")
            return {"type": "http.disconnect"}

        async def marked(message: Message) -> None:
            nonlocal started
            if refused:
                return
            if message["type"] == "http.response.start":
                started = True
                extra = [(name.encode(), value.encode()) for name, value in _HEADERS.items()]
                message = {**message, "headers": [*message.get("headers", []), *extra]}
            await send(message)

        try:
            await self._app(scope, counted, marked)
        except Exception:
            if not refused:  # an application may well stumble over a visitor who was turned away
                raise


def _name(host: str) -> str:
    """Name or address in a Host header, without its port."""
    if host.startswith("["):
        return host[1:].partition("]")[0].lower()
    return host.rpartition(":")[0].lower() if ":" in host else host.lower()


def _is_short(length: str) -> bool:
    return length.isascii() and length.isdigit() and len(length) < 16 and int(length) <= LARGEST_BODY


def _query(scope: Scope) -> list[tuple[str, str]]:
    return parse_qsl(scope.get("query_string", b"").decode("latin-1"), keep_blank_values=True)


async def _turn_away(scope: Scope, receive: Receive, send: Send, status: int, sentence: str) -> None:
    if scope["type"] == "websocket":
        await receive()  # the connection must be asked for before it can be refused
        await send({"type": "websocket.close", "code": 1008, "reason": sentence})
        return
    headers = [(b"content-type", b"text/plain; charset=utf-8"), (b"connection", b"close")]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": sentence.encode()})
