"""Blocks: boxes of a grid that are computed, written and resumed as one."""

from __future__ import annotations

from collections.abc import Container, Iterator
from dataclasses import dataclass
from math import ceil, prod
from typing import Any

import numpy as np

from .grid import Grid

LARGEST_BLOCK = 1_000_000
"""Points of the largest block: its results stay small enough to be sent and kept in memory."""


@dataclass(frozen=True)
class Part:
    """One block with all that is needed to compute it: nothing else of the grid is sent to a worker."""

    number: int
    start: tuple[int, ...]
    shape: tuple[int, ...]
    grid_shape: tuple[int, ...]
    random_dimensions: tuple[int, ...]
    coordinates: dict[str, tuple[int, Any]]
    """For each coordinate the place of its dimension, and its values along this block."""

    @property
    def size(self) -> int:
        """Number of points."""
        return prod(self.shape)

    @property
    def region(self) -> tuple[slice, ...]:
        """Place of the block in the arrays of the result."""
        return tuple(slice(a, a + n) for a, n in zip(self.start, self.shape, strict=True))


class Blocks:
    """A grid cut into boxes of one shape, smaller at the far ends; numbered as the points are, last dimension first.

    Parameters
    ----------
    grid : Grid
    shape : tuple of int
        Points of a box along each dimension.
    """

    def __init__(self, grid: Grid, shape: tuple[int, ...]) -> None:
        self.grid = grid
        self.shape = shape
        self.counts = tuple(ceil(n / b) for n, b in zip(grid.shape, shape, strict=True))

    def __len__(self) -> int:
        return prod(self.counts)

    def part(self, number: int) -> Part:
        """Block of that number."""
        places = np.unravel_index(number, self.counts)
        start = [int(place) * width for place, width in zip(places, self.shape, strict=True)]
        stop = [min(a + b, n) for a, b, n in zip(start, self.shape, self.grid.shape, strict=True)]
        return self._box(number, start, stop)

    def parts(self, without: Container[int]) -> Iterator[Part]:
        """All blocks but those, in order."""
        return (self.part(number) for number in range(len(self)) if number not in without)

    def _box(self, number: int, start: list[int], stop: list[int]) -> Part:
        places = {name: place for place, name in enumerate(self.grid.dimensions)}
        return Part(
            number,
            tuple(start),
            tuple(b - a for a, b in zip(start, stop, strict=True)),
            self.grid.shape,
            self.grid.random_dimensions,
            {
                name: (places[dim], one.part(start[places[dim]], stop[places[dim]]))
                for name, (dim, one) in self.grid.coordinates.items()
            },
        )


def shape_of(grid: Grid, points: int) -> tuple[int, ...]:
    """Shape of a box of at most `points` points that is long along the last dimensions, in even cuts."""
    left = max(1, min(points, LARGEST_BLOCK))
    shape = []
    for length in reversed(grid.shape):
        width = ceil(length / ceil(length / min(length, left)))
        shape.append(width)
        left = max(1, left // width)
    return tuple(reversed(shape))
