"""Client of a readings server: yields every reading as a dictionary."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any
from urllib.parse import parse_qs, urlsplit

from palpate.core import PalpateError, load_extra


def follow_readings(link: str) -> Iterator[dict[str, Any]]:
    """Yield the readings of a server until it ends.

    Parameters
    ----------
    link
        Link printed by `palpate sensor serve`, with its token.

    Raises
    ------
    PalpateError
        If no server answers, or the token is wrong.
    MissingExtraError
        If the package websockets is not installed.

    Examples
    --------
    ::

        for reading in follow_readings("http://127.0.0.1:8760/reading"):
            print(reading["rx_deg"], reading["lost"])
    """
    load_extra("websockets", "web")
    from websockets.exceptions import ConnectionClosed, InvalidHandshake
    from websockets.sync.client import connect

    place = urlsplit(link)
    token = parse_qs(place.query).get("token", [""])[0]
    headers = {"Cookie": f"palpate_{place.port}={token}"} if token else {}
    try:
        with connect(f"ws://{place.netloc}/readings", additional_headers=headers) as socket:
            for message in socket:
                yield json.loads(message)
    except ConnectionClosed:
        return
    except (OSError, InvalidHandshake) as error:
        raise PalpateError(
            f"Nothing answers at {place.netloc}: {error}.",
            "Start palpate sensor serve, and take its link.",
            code="server-silent",
        ) from None
