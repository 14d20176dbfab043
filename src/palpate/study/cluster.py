"""Tasks on a Dask cluster: local processes, or the workers of a remote scheduler.

The workers must see the result folder under the same path. Dask sends tasks as pickles: give the address of a
scheduler only if everybody who can reach it is trusted, or use ``tls://``.
"""

from __future__ import annotations

import logging
import re
from contextlib import suppress
from typing import Any
from uuid import uuid4

from palpate.core import PalpateError, load_extra, worker_process
from palpate.core.run import MOST_WORKERS, WORKER_DIED, Call, Outcome, Progress, Status, WorkerPool, run_call
from palpate.study.task import EstimatorTask

CONNECT_S = 30.0
"""Timeout for a scheduler and its first worker to answer, s. By hand."""

GPU = "GPU"
"""Dask resource of workers with a GPU: ``dask worker --resources GPU=1``."""


class ClusterWorkers(WorkerPool):
    """Workers of a Dask cluster; each thread is a member.

    Parameters
    ----------
    where
        ``"local:N"`` for N processes on this machine, or the address of a scheduler, ``"tcp://HOST:PORT"``.

    Raises
    ------
    MissingExtraError
        If distributed is not installed.
    PalpateError
        If `where` is not such an address, or no scheduler answers.
    """

    def __init__(self, where: str) -> None:
        super().__init__()
        self._client, self._cluster = _connect(where)
        self._busy: dict[Any, Call] = {}
        self._size = self._count()

    @property
    def size(self) -> int:
        return self._size

    def _start(self, call: Call) -> None:
        key = (
            f"{call.work.__name__}-{uuid4().hex}"  # Dask takes one key for one computation, also after a worker died
        )
        needs = {GPU: 1} if any(map(_wants_gpu, call.arguments)) and self._has_gpu() else None
        arguments = (call.work, call.arguments, Progress())
        self._busy[self._client.submit(run_call, *arguments, key=key, pure=False, resources=needs)] = call

    def _collect(self, seconds: float) -> list[tuple[Call, Outcome]]:
        with suppress(TimeoutError):
            _distributed().wait(list(self._busy), timeout=seconds, return_when="FIRST_COMPLETED")
        done = [future for future in self._busy if future.done()]
        self._size = self._count()
        return [(self._busy.pop(future), _outcome(future)) for future in done]

    def _stop(self, call: Call) -> None:
        future = next(future for future, busy in self._busy.items() if busy is call)
        workers = [name for name, keys in self._client.processing().items() if future.key in keys]
        trace = _where(self._client, future)
        del self._busy[future]
        future.cancel()
        if workers:
            self._client.restart_workers(workers, timeout=CONNECT_S, raise_for_error=False)
        self._early.append((call, Outcome(None, WORKER_DIED, trace, 0.0, Status.DIED)))

    def shutdown(self) -> None:
        for future in self._busy:
            with suppress(Exception):
                future.cancel()
        self._client.close()
        if self._cluster is not None:
            self._cluster.close()

    def _count(self) -> int:
        return max(1, sum(self._client.nthreads().values()))

    def _has_gpu(self) -> bool:
        workers = self._client.scheduler_info(n_workers=-1)["workers"].values()
        return any(worker["resources"].get(GPU, 0) >= 1 for worker in workers)


def check_cluster_address(where: str) -> None:
    """Reject an address that is neither ``local:N`` nor that of a scheduler.

    Raises
    ------
    PalpateError
        With the two forms.
    """
    local = re.fullmatch(r"local:(\d{1,4})", where)
    if local is not None and 1 <= int(local[1]) <= MOST_WORKERS:
        return
    if re.fullmatch(r"(tcp|tls)://[\w.:\[\]-]+:\d{1,5}", where) is None:
        raise PalpateError(
            f"--cluster is '{where}'.",
            f"Give local:N with N from 1 to {MOST_WORKERS}, or a scheduler's address, tcp://HOST:PORT.",
            code="cluster-malformed",
        )


def _connect(where: str) -> tuple[Any, Any]:
    """Return a client, and the local cluster to be closed after it, if any."""
    check_cluster_address(where)
    distributed = _distributed()
    if where.startswith("local:"):
        with worker_process.single_threaded():
            cluster = distributed.LocalCluster(
                n_workers=int(where.removeprefix("local:")),
                threads_per_worker=1,
                processes=True,
                host="127.0.0.1",
                dashboard_address=None,
                silence_logs=logging.CRITICAL,
            )
        return distributed.Client(cluster, timeout=CONNECT_S), cluster
    try:
        client = distributed.Client(where, timeout=CONNECT_S)
    except (OSError, TimeoutError, ValueError) as error:
        raise PalpateError(
            f"No Dask scheduler answers at {where}: {type(error).__name__}.",
            "Start one with: dask scheduler",
            code="scheduler-silent",
        ) from error
    try:
        client.wait_for_workers(1, timeout=CONNECT_S)
    except TimeoutError as error:
        client.close()
        raise PalpateError(
            f"The Dask scheduler at {where} has no worker.",
            f"Start some with: dask worker {where} --nthreads 1",
            code="scheduler-no-worker",
        ) from error
    return client, None


def _distributed() -> Any:
    return load_extra("distributed", "cluster")


def _outcome(future: Any) -> Outcome:
    if future.status == "finished":
        result: Outcome = future.result()
        return result
    error = future.exception() if future.status == "error" else None
    if error is None or isinstance(
        error, _distributed().KilledWorker
    ):  # a future that was lost has no error of its own
        return Outcome(reason=WORKER_DIED, status=Status.DIED)
    return Outcome(reason=f"{type(error).__name__}: {error}", status=Status.FAILED)


def _wants_gpu(argument: Any) -> bool:
    return isinstance(argument, EstimatorTask) and argument.spec.device == "cuda"


def _where(client: Any, future: Any) -> str:
    """Return the stack of a running task, as far as its worker reports it."""
    with suppress(Exception):
        stacks = client.call_stack([future])
        return "\n".join("".join(stack) for found in stacks.values() for stack in found.values())
    return ""
