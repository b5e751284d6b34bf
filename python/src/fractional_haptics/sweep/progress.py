"""Progress of a sweep: a record that a callback gets, a bar by tqdm, or lines of text."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from time import monotonic
from typing import Any, Literal

_LINES_EVERY_S = 10.0

Report = Callable[["Progress"], None]


@dataclass(frozen=True)
class Progress:
    """State of a sweep.

    Attributes
    ----------
    done, failed, total : int
        Points done, also those of earlier runs; failed among them; of the grid.
    elapsed_s : float
        Time of this run.
    points_per_s : float
        Rate of this run; NaN before the first block.
    remaining_s : float
        Time left at that rate; NaN before the first block.
    """

    done: int
    failed: int
    total: int
    elapsed_s: float
    points_per_s: float
    remaining_s: float

    def __str__(self) -> str:
        return (
            f"{self.done} of {self.total} points, {self.failed} failed, {self.points_per_s:.3g} points/s, "
            f"{_clock(self.remaining_s)} left"
        )


class Meter:
    """Counts what is done and reports it.

    Parameters
    ----------
    total : int
        Points of the grid.
    done, failed : int
        Points of earlier runs.
    report : callable or bool or None
        A callback; True for a bar, or lines if tqdm is not installed; False for nothing; None for a bar at a terminal.
    """

    def __init__(self, total: int, done: int, failed: int, report: Report | bool | None) -> None:
        self._total, self._done, self._failed = total, done, failed
        self._earlier = done
        self._started = monotonic()
        if report is None:
            report = sys.stderr.isatty()
        self._report: Report | None = (_bar(total) if report else None) if isinstance(report, bool) else report
        self._tell()

    @property
    def failed(self) -> int:
        """Points that failed, also in earlier runs."""
        return self._failed

    def add(self, points: int, failed: int) -> None:
        """Counts a block."""
        self._done += points
        self._failed += failed
        self._tell()

    def close(self) -> None:
        """Ends the bar."""
        getattr(self._report, "close", lambda: None)()

    def _tell(self) -> None:
        if self._report is None:
            return
        elapsed = monotonic() - self._started
        now = self._done - self._earlier
        rate = now / elapsed if now and elapsed > 0 else float("nan")
        self._report(Progress(self._done, self._failed, self._total, elapsed, rate, (self._total - self._done) / rate))


def _bar(total: int) -> Report:
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return _Lines()
    return _Bar(tqdm(total=total, unit="point", unit_scale=True))


class _Bar:
    def __init__(self, bar: Any) -> None:
        self._bar = bar
        self._first = True

    def __call__(self, progress: Progress) -> None:
        if self._first:
            self._first = False
            self._bar.initial = self._bar.n = progress.done
        self._bar.set_postfix(failed=progress.failed, refresh=False)
        self._bar.update(progress.done - self._bar.n)

    def close(self) -> None:
        self._bar.close()


class _Lines:
    def __init__(self) -> None:
        self._next = 0.0

    def __call__(self, progress: Progress) -> None:
        if progress.elapsed_s >= self._next or progress.done == progress.total:
            self._next = progress.elapsed_s + _LINES_EVERY_S
            print(progress, file=sys.stderr, flush=True)

    def close(self) -> Literal[None]:
        return None


def _clock(seconds: float) -> str:
    if seconds != seconds:
        return "?"
    minutes, left = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{left:02}"
