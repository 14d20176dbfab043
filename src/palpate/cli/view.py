"""`palpate view`: results and pressed domes in a browser."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from palpate.cli.output import RESULTS

_RESULTS = (
    "Result folder of a study, search or training on a recording, file of a press or twin, or a folder of these; by "
    "default results, if it has any."
)
_HOST = "Address to listen at; at other addresses than this machine's own, visitors need a token."
_PORT = "Port to listen at; 0 selects a free port."
_TOKEN = "Token of the visitors, at least 16 letters and digits; by default it is generated if needed."


def view(
    results: Annotated[Path | None, Parameter(help=_RESULTS)] = None,
    *,
    host: Annotated[str, Parameter(help=_HOST)] = "127.0.0.1",
    port: Annotated[int, Parameter(help=_PORT)] = 8750,
    token: Annotated[str, Parameter(help=_TOKEN)] = "",
) -> None:
    """Show results in a browser; design and press a dome there."""
    from palpate.learn import is_recorded_model
    from palpate.viewer import ServeSpec, find_results, serve

    if results is None and RESULTS.is_dir() and find_results(RESULTS):
        results = RESULTS
    if results is not None and results.is_file() and is_recorded_model(results):
        results = results.parent
    serve(results, ServeSpec(host, port, token), _announce)


def _announce(link: str) -> None:
    print(f"Open {link}\nStop with Ctrl+C.", flush=True)
