"""A pool ends every process that it has started, also one that an interruption met at its start."""

from pathlib import Path

import pytest
from small_task import Sum

from palpate.core import ArtefactStore
from palpate.study.worker_pool import LocalWorkers


def test_a_worker_that_is_interrupted_at_its_start_ends_with_its_pool(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Starting:
        ended = False

        def submit(self, *_: object) -> None:
            raise KeyboardInterrupt

        def leave(self) -> None:
            self.ended = True

    member = Starting()
    pool = LocalWorkers(ArtefactStore(tmp_path), 1)
    monkeypatch.setattr(pool, "_free", [member])
    with pytest.raises(KeyboardInterrupt), pool:
        pool.submit(Sum("one", 1.0))
    assert member.ended
