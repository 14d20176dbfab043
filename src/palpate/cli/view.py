"""`palpate view`: the grid and the pressed dome in a browser."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from palpate.core import PalpateError
from palpate.recording import is_recorded_model

_RESULTS = "Result folder of a study or of a search; without one, only a dome can be designed and pressed."
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

    _refuse_learnt(results)
    serve(results, ServeSpec(host, port, token), _announce)


def _refuse_learnt(results: Path | None) -> None:
    """Say how to look at what `palpate learn` made: it has no design, no grid and no mesh to show."""
    model = results / "model.h5" if results is not None and results.is_dir() else results
    if model is None or not model.is_file() or not is_recorded_model(model):
        return
    raise PalpateError(
        f"{model} was learnt from a recording: it has no dome and no grid that could be shown.",
        f"Open report.md, correspondence.png and errors.png in {model.parent}; readings as they come: "
        f"palpate live --model {model} --source CAMERA.",
    )


def _announce(link: str) -> None:
    print(f"Open {link}\nStop with Ctrl+C.", flush=True)
