"""Threads of this process: the default. They share the processors as far as the function lets go of the interpreter."""

from __future__ import annotations

import os
from collections.abc import Generator, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from itertools import islice
from threading import Event

from .blocks import Part
from .outputs import Outputs
from .work import Block, Probe, Work, probe, run


class Threads:
    """A pool of threads.

    Parameters
    ----------
    number : int or None
        Threads; None for as many as this process has processors.
    """

    def __init__(self, number: int | None = None) -> None:
        if number is not None and (number != int(number) or number < 1):
            raise ValueError(f"a number of workers is a whole number from 1, not {number!r}")
        self.width = int(number) if number is not None else _processors()

    def probe(self, work: Work, points: list[Part], seconds: float) -> Probe:
        """Tries points in the calling thread."""
        return probe(work, points, seconds)

    def blocks(self, work: Work, outputs: Outputs, parts: Iterator[Part]) -> Generator[tuple[Part, Block], None, None]:
        """Blocks as they are done. Closing the iterator ends each thread after the point it is at."""
        stop = Event()
        pool = ThreadPoolExecutor(self.width, thread_name_prefix="sweep")
        pending: dict[Future[Block | None], Part] = {}
        try:
            while True:
                for part in islice(parts, 2 * self.width - len(pending)):
                    pending[pool.submit(run, work, outputs, part, stop)] = part
                if not pending:
                    return
                # A timeout lets Ctrl-C through on every system.
                for future in wait(pending, timeout=1.0, return_when=FIRST_COMPLETED).done:
                    part = pending.pop(future)
                    block = future.result()
                    if block is not None:
                        yield part, block
        finally:
            stop.set()
            pool.shutdown(wait=True, cancel_futures=True)


def _processors() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
