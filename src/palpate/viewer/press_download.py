"""Download of a solved press for ParaView."""

from __future__ import annotations

from nicegui import run, ui

from palpate.core import PalpateError
from palpate.fea import Press
from palpate.viewer.page_head import show_error
from palpate.viewer.work import press_archive


async def download_press(press: Press, fault: ui.label) -> None:
    """Send a press to the browser as ``press.zip``; an error is shown in `fault`."""
    ui.notify(f"Exporting the solved press: {press.obstacle.label} …", position="top")
    try:
        content = await run.io_bound(press_archive, press)
    except PalpateError as error:
        show_error(fault, str(error), error.code)
    else:
        assert content is not None  # only a server that stops returns nothing
        ui.download.content(content, "press.zip")
