"""Lines of a text file of any encoding, with their numbers."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from palpate.core.errors import PalpateError

MAX_BYTES = 2_000_000_000
"""Maximum size of a text file. By hand."""
HEAD = 400
"""Lines at the beginning of a file that are never thinned. By hand."""
_BOMS = ((b"\xef\xbb\xbf", "utf-8"), (b"\xff\xfe", "utf-16-le"), (b"\xfe\xff", "utf-16-be"))
_BINARY = re.compile(rb"[\x00-\x08\x0e-\x1a\x1c-\x1f]")
_SAVE = "Save the table as CSV text."
_LETTERS = {
    "cp1252": "äöüßÄÖÜéèêàçâîôûñ°µ²³±·½σελ",
    "gb18030": "应变力位移时间载荷拉伸压缩试样标距伸长率名义工程真实单编号强度速温秒毫米兆帕千牛顿图像接触深角百分比",
    "cp932": "ひずみ応力荷重変位時間引張圧縮試験片伸び公称真単番号標線距離秒画像接触深傾角度強温速ストレロード",
}
"""Letters in headers of test machines by which an encoding other than UTF is recognised."""

Line = tuple[int, str]
"""Number of a line in its file, from 1, and its text."""


def read_bytes(path: Path) -> bytes:
    """Read the bytes of a text file, in UTF-8 or in an encoding of one byte or two.

    Raises
    ------
    PalpateError
        If the file cannot be read, is too large, or is not text.
    """
    try:
        if path.stat().st_size > MAX_BYTES:
            raise PalpateError(
                f"{path} has {path.stat().st_size / 1e9:.1f} GB.", "Export fewer rows.", code="table-too-large"
            )
        data = path.read_bytes()
    except OSError as error:
        raise PalpateError(
            f"{path} cannot be read: {error.strerror}.", "Give a table, such as a CSV file.", code="file-unreadable"
        ) from None
    if data.startswith((b"PK", b"\xd0\xcf\x11\xe0")):
        raise PalpateError(f"{path} is a spreadsheet or an archive, not text.", _SAVE, code="file-is-spreadsheet")
    for mark, encoding in (*_BOMS, *_wide(data)):
        if data.startswith(mark):
            data = data[len(mark) :]
            data = data if encoding == "utf-8" else data.decode(encoding, "replace").encode()
            break
    if _BINARY.search(data[:100_000]):
        raise PalpateError(f"{path} is not text: it contains binary data.", _SAVE, code="file-not-text")
    return data


def _wide(data: bytes) -> list[tuple[bytes, str]]:
    """Detect UTF-16 without its mark, by zeros in every second byte of Latin text."""
    head = np.frombuffer(data[:2000], np.uint8)
    even, odd = (float(np.mean(head[at::2] == 0)) if len(head) > 8 else 0.0 for at in (0, 1))
    return [(b"", "utf-16-le")] if odd > 0.6 > 4 * even else [(b"", "utf-16-be")] if even > 0.6 > 4 * odd else []


def split_lines(data: bytes, max_lines: int | None = None) -> tuple[list[Line], int]:
    """Split the bytes of a text into lines, and count those left out.

    Of a file of more than `max_lines`, the head and every k-th line of the rest are kept.
    """
    if b"\n" not in data:
        data = data.replace(b"\r", b"\n")
    encoding = _encoding(data)
    if max_lines is None or data.count(b"\n") + 1 <= max_lines:
        texts = data.decode(encoding, "replace").replace("\r\n", "\n").split("\n")
        return list(enumerate(texts, start=1)), 0
    end = np.flatnonzero(np.frombuffer(data, np.uint8) == ord("\n"))
    step = -(-len(end) // max_lines)
    chosen = np.concatenate([np.arange(HEAD), np.arange(HEAD, len(end) - 1, step)])
    begin = np.concatenate([[0], end[:-1] + 1])
    lines = [(int(at) + 1, data[begin[at] : end[at]].decode(encoding, "replace").rstrip("\r")) for at in chosen]
    return lines, len(end) - len(chosen)


def _encoding(data: bytes) -> str:
    """UTF-8 if the bytes are valid, else the encoding that gives the most letters of headers."""
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        head = data[:20_000]
        counts = {}
        for encoding, letters in _LETTERS.items():
            text = head.decode(encoding, "replace")
            counts[encoding] = sum(map(letters.count, text)) - 2 * text.count("\ufffd")
        return max(counts, key=lambda encoding: counts[encoding])
    return "utf-8"
