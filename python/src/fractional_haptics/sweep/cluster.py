"""A Dask cluster: any ``dask.distributed.Client``, from two processes to a Slurm allocation.

Each block is one task. It takes the pickled function and the coordinates of its block, and gives its results back to
the client, which alone writes: workers need no common file system. Blocks of a worker that dies are computed again by
another one. No call waits for ever: a scheduler that is silent, or has no workers, for longer than `timeout` ends the
sweep with an error; what is written stays.
"""

from __future__ import annotations

import functools
import queue
import uuid
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import CancelledError
from time import monotonic
from typing import Any

import cloudpickle
from distributed import Client, KilledWorker

from .blocks import Part
from .errors import ClusterLost, SweepError
from .outputs import Outputs, empty_rows
from .work import Block, Probe, Work, probe, run

LARGEST_FUNCTION = 1 << 20
"""Bytes of the largest pickled function: it goes along with each block."""

_PER_THREAD = 2  # blocks sent to each thread, so that none waits for the next
_LOOK_EVERY_S = 1.0
_ANSWER_WITHIN_S = 10.0
_ATTEMPTS = 4


class Cluster:
    """The workers of a client.

    Parameters
    ----------
    client : dask.distributed.Client
    timeout : float
        Seconds without an answer of the scheduler, or without workers, after which the sweep ends.

    Raises
    ------
    TypeError, ValueError
        No client, an asynchronous one, a timeout that is not positive.
    ClusterLost
        A closed client, or one whose scheduler does not answer or has no workers within `timeout`.
    """

    def __init__(self, client: Client, timeout: float) -> None:
        if not isinstance(client, Client):
            raise TypeError(f"the client is a dask.distributed.Client, not {type(client).__name__}")
        if client.asynchronous:
            raise TypeError("the client is asynchronous: make it by Client(…) without asynchronous=True")
        if not timeout > 0:
            raise ValueError(f"a timeout is a positive number of seconds, not {timeout!r}")
        self._client: Any = client  # Dask has few types
        self._timeout = float(timeout)
        self._heard = monotonic()
        self.width = 0
        self._wait_for(lambda: self._look() > 0)

    def probe(self, work: Work, points: list[Part], seconds: float) -> Probe:
        """Tries points on a worker."""
        ((_, tried),) = self._run(_probe, _pickled(work), iter([points]), 1, seconds)
        if isinstance(tried, str):
            raise SweepError(f"the first point ends the worker that computes it ({tried}): try it in a process alone")
        assert isinstance(tried, Probe)
        return tried

    def blocks(self, work: Work, outputs: Outputs, parts: Iterator[Part]) -> Generator[tuple[Part, Block], None, None]:
        """Blocks as they are done. Closing the iterator cancels the others.

        A block that ends its workers again and again, by memory for example, comes as one of failed points.
        """
        for part, block in self._run(_block, _pickled(work), parts, None, outputs):
            yield part, block if isinstance(block, Block) else _failed(part, outputs, block)

    def _run(
        self, task: Callable[..., Any], function: bytes, items: Iterator[Any], width: int | None, extra: Any
    ) -> Generator[tuple[Any, Any], None, None]:
        """Results of ``task(function, extra, item)``, or the text by which its workers died."""
        run_name = f"sweep-{uuid.uuid4().hex[:8]}"
        finished: queue.SimpleQueue[Any] = queue.SimpleQueue()
        pending: dict[str, tuple[Any, Any, int, int]] = {}
        again: list[tuple[Any, int, int]] = []
        fresh = ((item, number, 1) for number, item in enumerate(items))
        looked = monotonic()
        try:
            while True:
                limit = width or _PER_THREAD * max(1, self.width)
                while len(pending) < limit and (entry := again.pop() if again else next(fresh, None)) is not None:
                    item, number, attempt = entry
                    key = f"{run_name}-{number}-{attempt}"
                    future = self._client.submit(task, function, extra, item, key=key, pure=False)
                    pending[key] = (future, item, number, attempt)
                    future.add_done_callback(finished.put)
                if not pending:
                    return
                if monotonic() - looked > _LOOK_EVERY_S:
                    looked = monotonic()
                    self._look()
                try:
                    done = finished.get(timeout=_LOOK_EVERY_S)
                except queue.Empty:
                    continue
                future, item, number, attempt = pending.pop(done.key)
                result = self._result(future)
                if result is None:  # the scheduler forgot it, or the worker that had it died
                    if attempt == _ATTEMPTS:
                        raise ClusterLost(f"block {number} was lost {attempt} times: look at the scheduler's log")
                    again.append((item, number, attempt + 1))
                else:
                    yield item, result
        finally:
            if pending and self._client.status == "running":
                self._client.cancel([future for future, *_ in pending.values()], force=True)

    def _result(self, future: Any) -> Any:
        """What a future holds; None if it was lost."""
        try:
            if future.status != "lost":
                return future.result(timeout=self._timeout)
        except CancelledError:
            pass
        except KilledWorker as error:
            return f"KilledWorker: {error}"
        except (TimeoutError, OSError):
            return None
        except Exception as error:
            raise SweepError(
                f"the workers cannot run a block: {type(error).__name__}: {error}. "
                "The same versions of Python, fractional_haptics and of the function's module must be installed there."
            ) from error
        self._wait_for(lambda: self._look() >= 0)
        return None

    def _look(self) -> int:
        """Threads of the cluster, -1 if the scheduler does not answer.

        Raises
        ------
        ClusterLost
            A closed client, or no thread for longer than the timeout.
        """
        if self._client.status in ("closed", "closing"):
            raise ClusterLost("the client of the cluster is closed: make a new one; a store goes on where it was")
        threads = -1
        if self._client.status == "running":
            try:
                answer = self._client.sync(
                    self._client.scheduler.ncores, callback_timeout=min(_ANSWER_WITHIN_S, self._timeout)
                )
                threads = sum(answer.values())
            except (TimeoutError, OSError):
                pass
        if threads > 0:
            self._heard = monotonic()
            self.width = threads
        elif monotonic() - self._heard > self._timeout:
            reason = "has no workers" if threads == 0 else "does not answer"
            raise ClusterLost(
                f"the scheduler {self._client.scheduler.address if self._client.scheduler else ''} {reason} "
                f"for {self._timeout:g} s: start it again, or give a longer timeout; a store goes on where it was"
            )
        return threads

    def _wait_for(self, condition: Callable[[], bool]) -> None:
        """Looks until the condition holds; `_look` ends it."""
        pause = queue.SimpleQueue[None]()
        while not condition():
            try:
                pause.get(timeout=min(0.2, self._timeout))
            except queue.Empty:
                continue


def _pickled(work: Work) -> bytes:
    try:
        pickled: bytes = cloudpickle.dumps(work)
    except Exception as error:
        raise TypeError(
            f"the function cannot be sent to a cluster: {type(error).__name__}: {error}. "
            "Open devices, files and locks inside it, and define it at the top of a module."
        ) from error
    if len(pickled) > LARGEST_FUNCTION:
        raise ValueError(
            f"the function takes {len(pickled)} bytes with all that is bound to it, and goes along with each block: "
            f"keep it under {LARGEST_FUNCTION}, and read large data inside it (once, by functools.cache)"
        )
    return pickled


@functools.lru_cache(maxsize=4)
def _unpickled(pickled: bytes) -> Work:
    work = cloudpickle.loads(pickled)
    assert isinstance(work, Work)
    return work


def _block(function: bytes, outputs: Outputs, part: Part) -> Block | None:
    return run(_unpickled(function), outputs, part)


def _probe(function: bytes, seconds: float, points: list[Part]) -> Probe:
    return probe(_unpickled(function), points, seconds)


def _failed(part: Part, outputs: Outputs, text: str) -> Block:
    rows = empty_rows(outputs, part.size)
    values = {name: array.reshape(part.shape + array.shape[1:]) for name, array in rows.items()}
    return Block(part.number, values, dict.fromkeys(range(part.size), text), 0.0, complete=False)
