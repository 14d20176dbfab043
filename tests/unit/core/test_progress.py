"""The estimate of the remaining time, with a clock that the test moves."""

import heapq
import itertools

import pytest

from palpate.core.progress import _duration_text
from palpate.core.run import Progress


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


@pytest.mark.parametrize("workers", [1, 2, 4, 7])
@pytest.mark.parametrize("pieces", [20, 33, 100])
@pytest.mark.parametrize("together", [True, False])
def test_the_estimate_of_equal_pieces_is_within_1_5_from_a_tenth_on(
    workers: int, pieces: int, together: bool
) -> None:
    clock, seconds, cost = Clock(), 40.0, 7.0
    progress = Progress(clock)
    progress.plan(pieces * cost)
    names = map(str, itertools.count())
    running: list[tuple[float, str]] = []
    for worker in range(workers):  # they start together, or one after the other as processes do
        clock.now = 0.0 if together else worker * seconds / workers
        running.append((clock.now + seconds, next(names)))
        progress.begin(running[-1][1], cost)
    heapq.heapify(running)
    begun, asked = workers, []
    while running:
        end, name = running[0]
        for share in (0.3, 0.6, 0.9):
            before = clock.now
            clock.now += share * (end - before)
            asked.append((clock.now, progress.share, progress.remaining_s))
            clock.now = before
        clock.now = end
        heapq.heappop(running)
        progress.finish(name)
        if begun < pieces:
            heapq.heappush(running, (end + seconds, str(begun)))
            progress.begin(str(begun), cost)
            begun += 1
        asked.append((clock.now, progress.share, progress.remaining_s))
    total, compared = clock.now, 0
    for now, share, estimate in asked:
        if share >= 0.1 and total - now > 0.01 * seconds:
            assert estimate is not None
            assert 1 / 1.5 < estimate / (total - now) < 1.5, f"at {share:.2f} of the work"
            compared += 1
    assert compared > pieces / 2


def test_the_estimate_of_one_piece_follows_its_advance() -> None:
    clock = Clock()
    progress = Progress(clock)
    progress.plan(8.0)
    progress.begin("press", 8.0)
    assert progress.remaining_s is None
    for done in range(1, 8):
        clock.now += 30.0
        progress.advance("press", done)
        assert progress.remaining_s == pytest.approx(30.0 * (8 - done))
    clock.now += 10.0
    assert progress.remaining_s == pytest.approx(20.0)


def test_pieces_that_failed_say_nothing_of_the_speed() -> None:
    clock = Clock()
    progress = Progress(clock)
    progress.plan(10.0)
    for _ in range(5):
        progress.begin("bad", 1.0)
        progress.finish("bad", "No press.")
    assert progress.remaining_s is None
    progress.begin("good", 1.0)
    clock.now = 60.0
    progress.finish("good")
    assert progress.remaining_s == pytest.approx(4 * 60.0)


@pytest.mark.parametrize(
    ("cost", "text"), [(3, "60 s"), (9, "4.0 min"), (1000, "8.3 h")], ids=["seconds", "minutes", "hours"]
)
def test_the_remaining_time_is_in_minutes_or_hours(cost: float, text: str) -> None:
    clock = Clock()
    progress = Progress(clock)
    progress.plan(cost)
    assert progress.remaining_text == ""
    progress.begin("piece", 1.0)
    clock.now = 30.0
    progress.finish("piece")
    assert progress.remaining_text == f"about {text} remaining"


def test_the_start_of_workers_is_forgotten_when_as_much_other_work_is_done() -> None:
    clock = Clock()
    progress = Progress(clock)
    progress.plan(100.0)
    for number in range(10):
        for name in ("a", "b"):
            progress.begin(f"{name}{number}", 5.0)
        clock.now += 45.0 if number == 0 else 5.0  # the first pieces of both workers compile for 40 s
        for name in ("a", "b"):
            progress.finish(f"{name}{number}")
        if number in (1, 4):
            assert progress.remaining_s == pytest.approx(5.0 * (9 - number))


def test_the_share_of_the_work_counts_what_is_done_of_running_pieces_and_ends_at_one() -> None:
    clock = Clock()
    progress = Progress(clock)
    assert progress.share == 0.0
    progress.plan(10.0)
    progress.begin("a", 4.0)
    progress.advance("a", 1.0)
    assert progress.share == pytest.approx(0.1)
    progress.advance("a", 9.0)
    assert progress.share == pytest.approx(0.4), "never more than the piece"
    progress.finish("a")
    progress.begin("b", 8.0)
    progress.advance("b", 2.0)
    assert progress.share == pytest.approx(0.6)
    progress.advance("b", 8.0)
    assert progress.share == 1.0


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (0.4, "0 s"),
        (119.9, "120 s"),
        (120.0, "2.0 min"),
        (596.9, "9.9 min"),
        (597.0, "10 min"),
        (7199.0, "120 min"),
        (7200.0, "2.0 h"),
    ],
)
def test_a_time_changes_its_unit_at_two_minutes_and_at_two_hours(seconds: float, text: str) -> None:
    assert _duration_text(seconds) == text
