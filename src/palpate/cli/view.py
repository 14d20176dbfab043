"""`palpate view`: the grid and the pressed dome in a browser."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from palpate.learn import is_recorded_model

_RESULTS = (
    "Result folder of a study, a search or a recording that was learnt; without one, only a dome can be designed and "
    "pressed."
)
_HOST = "Address to listen at; any but this machine's own asks every visitor for a token."
_PORT = "Port to listen at; 0 takes any that is free."
_TOKEN = "What every visitor must bring, 16 letters and digits or more; without one, it is made where it is needed."


def view(
    results: Annotated[Path | None, Parameter(help=_RESULTS)] = None,
    *,
    host: Annotated[str, Parameter(help=_HOST)] = "127.0.0.1",
    port: Annotated[int, Parameter(help=_PORT)] = 8750,
    token: Annotated[str, Parameter(help=_TOKEN)] = "",
) -> None:
    """Look at results, and design and press a dome, in a browser."""
    from palpate.viewer import ServeSpec, serve

    if results is not None and results.is_file() and is_recorded_model(results):
        results = results.parent
    serve(results, ServeSpec(host, port, token), _announce)


def _announce(link: str) -> None:
    print(f"Open {link}\nStop with Ctrl+C.", flush=True)
