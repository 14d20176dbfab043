"""Lines of text files: thinned lines by their own text, limits from both sides, encodings by Python's own."""

from pathlib import Path

import pytest

from errors import refused
from palpate.core import text_lines
from palpate.core.text_lines import HEAD, read_bytes, split_lines


def test_a_file_of_the_maximum_size_is_read_and_a_larger_one_refused(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(text_lines, "MAX_BYTES", 10)
    path = tmp_path / "table.csv"
    path.write_bytes(b"123456789\n")
    assert read_bytes(path) == b"123456789\n"
    path.write_bytes(b"123456789\n\n")
    with refused("table-too-large"):
        read_bytes(path)


@pytest.mark.parametrize("ending", ["\n", "\r\n", "\r"])
def test_lines_are_numbered_from_one_whatever_ends_them(ending: str) -> None:
    lines, left_out = split_lines(ending.join(["rx_deg", "1", "2"]).encode())
    assert (lines, left_out) == ([(1, "rx_deg"), (2, "1"), (3, "2")], 0)


@pytest.mark.parametrize("more", [0, 1])
def test_only_a_file_of_more_lines_than_the_maximum_is_thinned(more: int) -> None:
    count = 2 * HEAD
    lines, left_out = split_lines("".join(f"{k}\n" for k in range(1, count + more)).encode(), count)
    assert (left_out > 0) == bool(more)
    assert len(lines) + left_out == count


def test_a_thinned_file_keeps_its_head_and_lines_in_equal_steps_with_their_numbers() -> None:
    count = 5 * HEAD
    lines, left_out = split_lines("".join(f"line {k}\r\n" for k in range(1, count + 1)).encode(), 2 * HEAD)
    assert all(text == f"line {number}" for number, text in lines)
    numbers = [number for number, _ in lines]
    assert numbers[:HEAD] == list(range(1, HEAD + 1))
    assert {b - a for a, b in zip(numbers[HEAD:], numbers[HEAD + 1 :], strict=False)} == {3}
    assert numbers[HEAD] == HEAD + 1
    assert len(lines) + left_out == count


@pytest.mark.parametrize(
    ("text", "encoding"),
    [("Größe;Maß\n1;2\n", "cp1252"), ("应变,应力\n1,2\n", "gb18030"), ("ひずみ,応力\n1,2\n", "cp932")],
)
def test_letters_of_a_header_tell_the_encoding(text: str, encoding: str) -> None:
    assert split_lines(text.encode(encoding))[0][0] == (1, text.split("\n")[0])


@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be"])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_two_bytes_a_letter_are_read_with_and_without_a_mark(encoding: str, mark: str, tmp_path: Path) -> None:
    path = tmp_path / "wide.csv"
    path.write_bytes((mark + "rx_deg,ry_deg\n1.5,2.5\n").encode(encoding))
    assert read_bytes(path) == b"rx_deg,ry_deg\n1.5,2.5\n"
