"""What is changed while processes start is changed back, also by Ctrl-C."""

import os
import signal
import threading
import time

import pytest

from palpate.core.worker_process import single_threaded


@pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="Ctrl-C is not blocked on Windows")
def test_an_interruption_while_processes_start_leaves_the_environment_as_it_was(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    before = signal.pthread_sigmask(signal.SIG_BLOCK, ())
    handler = signal.signal(signal.SIGINT, signal.default_int_handler)  # a job in the background ignores it
    try:
        with pytest.raises(KeyboardInterrupt), single_threaded():
            signal.raise_signal(signal.SIGINT)
    finally:
        signal.signal(signal.SIGINT, handler)
    assert os.environ["OMP_NUM_THREADS"] == "7"
    assert signal.pthread_sigmask(signal.SIG_BLOCK, ()) == before


@pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="Ctrl-C is not blocked on Windows")
def test_an_interruption_that_another_thread_receives_waits_for_the_started_process() -> None:
    started: list[bool] = []
    ended = threading.Event()

    def begin() -> None:
        os.kill(os.getpid(), signal.SIGINT)
        for _ in range(20):
            time.sleep(0.01)
        started.append(True)

    other = threading.Thread(target=ended.wait)
    other.start()  # it does not block Ctrl-C
    handler = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt), single_threaded():
            begin()
    finally:
        signal.signal(signal.SIGINT, handler)
        ended.set()
        other.join()
    assert started
