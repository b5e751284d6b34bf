"""Work of a sweep: one block, computed the same wherever it is computed.

Random numbers of a point come from ``SeedSequence(seed, spawn_key=(index,))``, where the index is the place of the
point along the dimensions of samples, or in the whole grid if there are none. They depend neither on the block nor on
the worker, so any cut and any number of workers gives the same numbers.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product
from math import prod
from operator import mul
from threading import Event
from time import perf_counter
from typing import Any
from zlib import crc32

import numpy as np

from .blocks import Part
from .grid import Grid, Samples
from .outputs import Outputs, empty_rows, kind_of, put

LONGEST_ERROR = 500
"""Characters kept of the text of an error."""


@dataclass(frozen=True)
class Work:
    """A function with all that is the same for each block."""

    function: Callable[..., Any]
    arguments: tuple[str, ...]
    """Names of the coordinates that the function takes."""
    takes_rng: bool
    seed: int


@dataclass
class Block:
    """Results of one block: for each variable an array whose first dimensions are those of the block."""

    number: int
    values: dict[str, np.ndarray]
    errors: dict[int, str]
    """Texts of the points that failed, by their place in the block."""
    seconds: float
    complete: bool = True
    """False if the workers died and not the points failed: it is not done, and is tried again in the next run."""

    def checksum(self) -> int:
        """CRC-32 of all results and texts."""
        crc = crc32(repr(sorted(self.errors.items())).encode())
        for name in sorted(self.values):
            crc = crc32(self.values[name].tobytes(), crc)
        return crc


@dataclass
class Probe:
    """A few points tried: the time each took, the kinds of result seen, and the first error."""

    seconds: list[float]
    kinds: list[dict[str, tuple[tuple[int, ...], bool]]]
    error: str | None


def work_of(function: Callable[..., Any], grid: Grid, seed: int) -> Work:
    """Checks that a function takes the coordinates of the grid.

    A coordinate of samples, and `rng`, are passed only to a function that names them.

    Raises
    ------
    TypeError, ValueError
        No function, a coordinate it does not take, an argument that nothing gives, a seed that is no whole number.
    """
    if not callable(function):
        raise TypeError(f"the first argument of a sweep is a function, not {type(function).__name__}")
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
        raise ValueError(f"the seed is a whole number from 0, not {seed!r}")
    try:
        parameters = inspect.signature(function).parameters
    except (TypeError, ValueError):
        return Work(function, tuple(_settings(grid)), False, int(seed))
    anything = any(one.kind is one.VAR_KEYWORD for one in parameters.values())
    named = {name for name, one in parameters.items() if one.kind in (one.POSITIONAL_OR_KEYWORD, one.KEYWORD_ONLY)}
    if not anything and (unknown := [name for name in _settings(grid) if name not in named]):
        raise TypeError(
            f"the function takes no argument {unknown[0]!r}, an axis of the grid, by name; "
            f"it takes: {', '.join(sorted(named)) or 'none'}"
        )
    given = {"rng", *grid.coordinates}
    for name, one in parameters.items():
        needed = one.default is one.empty and one.kind not in (one.VAR_POSITIONAL, one.VAR_KEYWORD)
        if needed and (name not in given or one.kind is one.POSITIONAL_ONLY):
            raise TypeError(
                f"nothing gives the function its argument {name!r}: make it an axis of the grid, passed by name, "
                "or bind it by functools.partial"
            )
    arguments = tuple(name for name in grid.coordinates if name in named or name in _settings(grid))
    return Work(function, arguments, "rng" in named, int(seed))


def _settings(grid: Grid) -> list[str]:
    return [name for name, (_, one) in grid.coordinates.items() if not isinstance(one, Samples)]


def run(work: Work, outputs: Outputs, part: Part, stop: Event | None = None) -> Block | None:
    """Computes a block; None if `stop` is set meanwhile.

    A point that raises is NaN in each variable and its text is kept.
    """
    started = perf_counter()
    rows = empty_rows(outputs, part.size)
    errors: dict[int, str] = {}
    for row, arguments in enumerate(_points(work, part)):
        if stop is not None and stop.is_set():
            return None
        try:
            put(outputs, rows, row, work.function(**arguments))
        except (KeyboardInterrupt, SystemExit, GeneratorExit):
            raise
        except BaseException as error:  # also what Rust raises for a panic, which is no Exception
            errors[row] = _text(error)
            for name, one in outputs.items():
                rows[name][row] = one.missing
    values = {name: array.reshape(part.shape + array.shape[1:]) for name, array in rows.items()}
    return Block(part.number, values, errors, perf_counter() - started)


def probe(work: Work, points: list[Part], seconds: float) -> Probe:
    """Tries points one after the other, for that long at most, but at least one until one succeeds."""
    tried = Probe([], [], None)
    started = perf_counter()
    for part in points:
        (arguments,) = _points(work, part)
        before = perf_counter()
        try:
            tried.kinds.append(kind_of(work.function(**arguments)))
        except (KeyboardInterrupt, SystemExit, GeneratorExit):
            raise
        except BaseException as error:
            tried.error = tried.error or _text(error)
        tried.seconds.append(perf_counter() - before)
        if tried.kinds and perf_counter() - started > seconds:
            break
    return tried


def random_numbers(seed: int, index: int) -> np.random.Generator:
    """Random numbers of a point: those of child `index` that ``SeedSequence(seed)`` would spawn."""
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed, spawn_key=(index,))))


def _points(work: Work, part: Part) -> Iterator[dict[str, Any]]:
    """Arguments of each point of a block, in order."""
    columns = [(name, *part.coordinates[name]) for name in work.arguments]
    strides = _strides(part)
    first = sum(a * s for a, s in zip(part.start, strides, strict=True))
    for place in product(*map(range, part.shape)):
        arguments = {name: values[place[dimension]] for name, dimension, values in columns}
        if work.takes_rng:
            arguments["rng"] = random_numbers(work.seed, first + sum(map(mul, place, strides)))
        yield arguments


def _strides(part: Part) -> list[int]:
    """Steps of the index of the random numbers along each dimension; 0 along one that shares them."""
    counted = part.random_dimensions or tuple(range(len(part.grid_shape)))
    return [
        prod(part.grid_shape[later] for later in counted if later > place) if place in counted else 0
        for place in range(len(part.grid_shape))
    ]


def _text(error: BaseException) -> str:
    text = f"{type(error).__name__}: {error}"
    return text if len(text) <= LONGEST_ERROR else text[: LONGEST_ERROR - 1] + "…"
