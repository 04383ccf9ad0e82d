"""Many recordings on a Dask cluster: several machines that share the dataset's folder and the store's."""

import logging
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import ExitStack
from dataclasses import dataclass
from typing import TYPE_CHECKING

from corsmal.dataset import Recording
from corsmal.engines.engine import Outcome, Task, attempt, never
from corsmal.errors import CorsmalError

if TYPE_CHECKING:
    from distributed import Client, Future, as_completed

TIMEOUT_S = 10
WORKERLESS_S = 60.0
"""How long a cluster may be without workers while it has work."""
POLL_S = 0.02
AHEAD = 2
"""Recordings that are on their way to each of the cluster's threads; more would only wait in memory."""


@dataclass(frozen=True)
class DaskCluster:
    """The engine of a Dask cluster.

    Args:
        scheduler: address of a running cluster's scheduler, such as ``tcp://10.0.0.5:8786``; None: a cluster of this
            machine, for as long as the work takes.
        workers: processes of such a cluster.
    """

    scheduler: str | None = None
    workers: int = 2

    def __str__(self) -> str:
        return f"Dask, {self.scheduler or f'processes: {self.workers}'}"

    def __call__(
        self, task: Task, recordings: Sequence[Recording], *, cancelled: Callable[[], bool] = never
    ) -> Iterator[Outcome]:
        """Yield an outcome for each recording as soon as there is one; ``cancelled`` is checked between them.

        Raises:
            CorsmalError: the scheduler does not answer, or is lost on the way.
        """
        from distributed import as_completed  # noqa: PLC0415 - takes a second, and only clusters need it

        waiting, suspects = enumerate(recordings), list[int]()
        with ExitStack() as stack:
            client = self._client(stack)
            running: dict[Future, int] = {}
            answers = as_completed([])

            def submit() -> None:
                wanted = AHEAD * max(1, sum(client.nthreads().values())) - len(running)
                for index, recording in (pair for _, pair in zip(range(wanted), waiting, strict=False)):
                    future = client.submit(attempt, task, index, recording, pure=False)
                    running[future] = index
                    answers.add(future)

            submit()
            while running:
                for future in _answered(client, answers, cancelled=cancelled):
                    if cancelled():
                        return
                    index = running.pop(future)
                    if _lost_its_worker(future):
                        suspects.append(index)
                    else:
                        yield _outcome(future, index)
                    submit()
                if cancelled():
                    return
            for index in suspects:  # one after the other: a worker ends with all that it was given, whoever is to blame
                if cancelled():
                    return
                yield _outcome(client.submit(attempt, task, index, recordings[index], pure=False), index)

    def _client(self, stack: ExitStack) -> "Client":
        from distributed import Client, LocalCluster  # noqa: PLC0415 - as above

        try:
            address = self.scheduler or stack.enter_context(
                LocalCluster(
                    n_workers=self.workers,
                    threads_per_worker=1,
                    dashboard_address="127.0.0.1:0",
                    silence_logs=logging.CRITICAL,
                )
            )
            return stack.enter_context(Client(address, timeout=TIMEOUT_S))
        except (OSError, ValueError) as error:
            where = self.scheduler or "on this machine"
            raise CorsmalError(
                f"the Dask scheduler {where} does not answer ({error}); start it or name another"
            ) from error


def _answered(client: "Client", answers: "as_completed", *, cancelled: Callable[[], bool]) -> "list[Future]":
    """The futures that are done by now; waits for the first of them, unless the work is to stop.

    Raises:
        CorsmalError: the cluster has no workers and gets none.
    """
    alive_s = time.monotonic()
    while not (done := list(answers.next_batch(block=False))) and not cancelled():
        time.sleep(POLL_S)
        now_s = time.monotonic()
        if now_s - alive_s > WORKERLESS_S / 10 and _has_workers(client):
            alive_s = now_s
        if now_s - alive_s > WORKERLESS_S:
            raise CorsmalError(
                f"the Dask cluster has had no worker for {WORKERLESS_S:.0f} s; what was done is kept: start workers, "
                "and give the same command"
            )
    return done


def _has_workers(client: "Client") -> bool:
    try:
        return bool(client.nthreads())
    except OSError:  # the scheduler is lost: so are its futures, which say so
        return False


def _lost_its_worker(future: "Future") -> bool:
    from distributed.scheduler import KilledWorker  # noqa: PLC0415 - as above

    return future.status == "error" and isinstance(future.exception(), KilledWorker)


def _outcome(future: "Future", index: int) -> Outcome:
    """What a worker returned; a worker that died over a recording several times is that recording's problem."""
    try:
        error = future.exception()
    except CancelledError as lost:
        raise CorsmalError("the Dask scheduler was lost; what was done is kept, the same command resumes") from lost
    if isinstance(error, RuntimeError) and "deserialization" in str(error):
        raise CorsmalError(
            "the cluster cannot load this version of corsmal; start scheduler and workers in the repository's folder"
        ) from error
    if error is not None:
        return Outcome(index, problem=f"its worker ended: {' '.join(str(error).split())}")
    outcome: Outcome = future.result()
    return outcome
