"""Who may come in: this machine's own pages, or those who bring the token."""

import socket

import pytest

from errors import refused

pytest.importorskip("fastapi", reason="the extra web is not there: pip install -e '.[web]'")

from fastapi import FastAPI, Request, WebSocket
from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect

from palpate.viewer.guard import LARGEST_BODY, Guard, ServerAddress
from palpate.viewer.server import ServeSpec, bind_server, is_loopback, page_url, serve

TOKEN = "0123456789abcdef0123"


def client(token: str = "", host: str = "127.0.0.1") -> TestClient:
    app = FastAPI()

    @app.get("/x")
    def answer() -> str:
        return "in"

    @app.post("/size")
    async def size(request: Request) -> int:
        return len(await request.body())

    @app.websocket("/ws")
    async def talk(socket: WebSocket) -> None:
        await socket.accept()
        await socket.send_text("in")

    return TestClient(Guard(app, ServerAddress(host, 8750, token)), base_url="http://127.0.0.1:8750")


@pytest.mark.parametrize("host", ["127.0.0.1:8750", "localhost:8750", "[::1]:8750", "LOCALHOST"])
def test_this_machine_is_answered(host):
    answer = client().get("/x", headers={"host": host})
    assert answer.json() == "in"
    assert answer.headers["x-content-type-options"] == "nosniff"
    assert "default-src 'self'" in answer.headers["content-security-policy"]


@pytest.mark.parametrize("host", ["evil.example", "evil.example:8750", "127.0.0.1.evil.example", "", "[::2]:8750"])
def test_other_names_that_point_here_are_refused(host):
    assert client().get("/x", headers={"host": host}).status_code == 403


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://localhost:9999", "https://127.0.0.1:8751"])
def test_other_pages_are_refused(origin):
    assert client().get("/x", headers={"origin": origin}).status_code == 403
    with pytest.raises(WebSocketDisconnect), client().websocket_connect("/ws", headers={"origin": origin}):
        pass


def test_our_own_page_may_talk():
    own = {"origin": "http://127.0.0.1:8750", "host": "127.0.0.1:8750"}
    assert client().get("/x", headers=own).status_code == 200
    with client().websocket_connect("/ws", headers=own) as socket:
        assert socket.receive_text() == "in"


@pytest.mark.parametrize("query", ["", "?token=", "?token=0123456789abcdef0124", "?token=%C3%A9"])
def test_without_the_token_nothing_is_answered(query):
    assert client(TOKEN, "0.0.0.0").get("/x" + query).status_code == 401
    with pytest.raises(WebSocketDisconnect), client(TOKEN).websocket_connect("/ws" + query):
        pass


def test_a_link_with_the_token_becomes_a_cookie():
    visitor = client(TOKEN, "0.0.0.0")
    first = visitor.get(f"/x?a=1&token={TOKEN}", follow_redirects=False)
    assert (first.status_code, first.headers["location"]) == (303, "/x?a=1")
    assert "HttpOnly" in first.headers["set-cookie"]
    assert "SameSite=Strict" in first.headers["set-cookie"]
    assert visitor.get("/x").json() == "in"
    with visitor.websocket_connect("ws://127.0.0.1:8750/ws") as socket:  # the cookie is this address's
        assert socket.receive_text() == "in"


def test_a_link_cannot_lead_to_another_machine():
    answer = client(TOKEN).get(f"//evil.example/?token={TOKEN}", follow_redirects=False)
    assert not answer.headers["location"].startswith("//")


def test_a_body_that_says_it_is_large_is_refused():
    assert client().post("/size", content=b"x" * (LARGEST_BODY + 1)).status_code == 413
    assert client().post("/size", content=b"x" * 1000).json() == 1000


def test_a_body_that_does_not_say_how_large_it_is_is_counted():
    pieces = (b"x" * 100_000 for _ in range(20))
    assert client().post("/size", content=pieces).status_code == 413


@pytest.mark.parametrize("length", ["-1", "1e3", "9" * 40, "x"])
def test_a_length_that_is_none_is_refused(length):
    assert client().post("/size", headers={"content-length": length}).status_code in (400, 413)


@pytest.mark.parametrize("method", ["PUT", "DELETE", "PATCH", "TRACE", "OPTIONS"])
def test_other_methods_are_not_answered(method):
    assert client().request(method, "/x").status_code == 405


def test_a_link_beyond_measure_is_refused():
    assert client().get("/x?a=" + "b" * 9000).status_code == 414


def test_another_address_makes_a_token():
    door, listener = bind_server(ServeSpec(host="0.0.0.0", port=0))
    listener.close()
    assert len(door.token) >= 32
    assert door.token in page_url(door)


def test_what_is_sent_goes_out_at_once() -> None:
    """Not when the last packet is acknowledged, 40 ms later."""
    door, listener = bind_server(ServeSpec(port=0))
    with listener, socket.create_connection(("127.0.0.1", door.port)):
        visitor, _ = listener.accept()
        with visitor:
            assert visitor.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)


def test_this_machines_address_needs_none():
    door, listener = bind_server(ServeSpec(port=0))
    listener.close()
    assert door.token == ""
    assert page_url(door) == f"http://127.0.0.1:{door.port}/"


@pytest.mark.parametrize("token", ["short", "with spaces in it ok", "x" * 15])
def test_a_token_that_is_none_is_refused(token):
    with refused("token-malformed"):
        bind_server(ServeSpec(port=0, token=token))


def test_a_second_viewer_at_the_same_port_is_refused():
    door, listener = bind_server(ServeSpec(port=0))
    with refused("port-unavailable"):
        bind_server(ServeSpec(port=door.port))
    listener.close()


@pytest.mark.parametrize("port", [-1, 70000])
def test_a_port_that_is_none_is_refused(port):
    with refused("port-unavailable"):
        bind_server(ServeSpec(port=port))


@pytest.mark.parametrize(
    ("host", "own"),
    [("127.0.0.1", True), ("127.8.8.8", True), ("::1", True), ("0.0.0.0", False), ("10.0.0.1", False)],
)
def test_only_loopback_is_this_machine_alone(host, own):
    assert is_loopback(host) is own


def test_a_folder_that_is_not_there_is_reported_before_a_port_is_taken(tmp_path):
    with refused("folder-missing", "nowhere"):
        serve(tmp_path / "nowhere", ServeSpec(), pytest.fail)
