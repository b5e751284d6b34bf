"""Threads of this process: the default. They share the processors as far as the function lets go of the interpreter."""

from __future__ import annotations

import os
from collections.abc import Generator, Iterator
from itertools import islice
from queue import SimpleQueue
from threading import Event, Thread

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
        """Blocks as they are done. Closing the iterator does not wait: each thread ends after the point it is at."""
        stop = Event()
        todo: SimpleQueue[Part | None] = SimpleQueue()
        done: SimpleQueue[tuple[Part, Block | None, BaseException | None]] = SimpleQueue()

        def work_off() -> None:
            for part in iter(todo.get, None):
                try:
                    done.put((part, run(work, outputs, part, stop), None))
                except BaseException as error:
                    done.put((part, None, error))

        # Daemons: a point that takes an hour does not hold up the end of the program either.
        for number in range(self.width):
            Thread(target=work_off, name=f"sweep-{number}", daemon=True).start()
        pending = 0
        try:
            while True:
                for part in islice(parts, 2 * self.width - pending):
                    todo.put(part)
                    pending += 1
                if not pending:
                    return
                part, block, error = done.get()
                pending -= 1
                if error is not None:
                    raise error
                if block is not None:
                    yield part, block
        finally:
            stop.set()
            for _ in range(self.width):
                todo.put(None)


def _processors() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
