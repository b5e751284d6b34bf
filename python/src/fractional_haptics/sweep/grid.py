"""Grids: the points of a sweep, as named arrays with units.

A grid is the product of its dimensions, in the order in which they are given; the last one runs fastest. A dimension
is one axis (`axis`), several axes that run side by side (`together`), or independent random draws (`samples`).
"""

from __future__ import annotations

import keyword
from collections.abc import Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from math import prod
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fractional_haptics._values import HoldsArrays, same

RESERVED = frozenset({"error", "rng"})
"""Names that the sweep itself uses: the texts of failed points, and the random numbers of a point."""


@dataclass(frozen=True, eq=False)
class Axis(HoldsArrays):
    """A named coordinate without its name: values, unit, and a sentence about it. Made by `axis`."""

    values: np.ndarray = field(repr=False)
    unit: str = "1"
    about: str = ""

    def __len__(self) -> int:
        return len(self.values)

    def part(self, start: int, stop: int) -> list[Any]:
        """Values from `start` to before `stop`, as Python's own numbers and texts."""
        values: list[Any] = self.values[start:stop].tolist()
        return values

    def summary(self) -> dict[str, Any]:
        """Facts that tell this axis from another: unit, length, ends, and a digest of all values."""
        values = np.ascontiguousarray(self.values)
        raw = "\0".join(values.tolist()).encode() if values.dtype.kind == "U" else values.tobytes()
        return {
            "unit": self.unit,
            "kind": values.dtype.kind,
            "length": len(values),
            "first": values[0].item(),
            "last": values[-1].item(),
            "sha256": sha256(raw).hexdigest(),
        }


@dataclass(frozen=True)
class Samples:
    """Independent random draws, numbered from 0. Made by `samples`."""

    number: int
    unit: str = "1"
    about: str = "number of the random draw"

    def __len__(self) -> int:
        return self.number

    @property
    def values(self) -> np.ndarray:
        """Numbers of the draws."""
        return np.arange(self.number)

    def part(self, start: int, stop: int) -> range:
        """Numbers from `start` to before `stop`."""
        return range(start, stop)

    def summary(self) -> dict[str, Any]:
        """Facts that tell this axis from another."""
        return {"unit": self.unit, "kind": "samples", "length": self.number, "first": 0, "last": self.number - 1}


@dataclass(frozen=True, eq=False)
class Together(HoldsArrays):
    """Axes of one length that share a dimension. Made by `together`."""

    axes: Mapping[str, Axis]

    def __len__(self) -> int:
        return len(next(iter(self.axes.values())))


def axis(values: ArrayLike, unit: str = "1", about: str = "") -> Axis:
    """Makes an axis of a grid.

    Parameters
    ----------
    values : array_like
        One-dimensional: numbers, truth values or texts. No NaN.
    unit : str
        Unit of the values as it is to stand in the result, for example ``"N/m"``; ``"1"`` for none.
    about : str
        A few words for the label of a figure.

    Raises
    ------
    ValueError
        No values, more than one dimension, a NaN (with its index), or values that are neither numbers nor texts.
    """
    if isinstance(values, np.ma.MaskedArray):
        raise ValueError("an axis is a masked array, and masked values are none: give values.compressed()")
    array = np.array(values)
    if array.ndim != 1:
        raise ValueError(f"an axis has one dimension, not {array.ndim}: give a one-dimensional array")
    if array.size == 0:
        raise ValueError("an axis without values makes an empty grid: give at least one value")
    if array.dtype.kind not in "biufU":
        raise ValueError(f"values of type {array.dtype} cannot be an axis: give real numbers, truth values or texts")
    if array.dtype.kind == "f" and np.isnan(array).any():
        raise ValueError(f"value {int(np.flatnonzero(np.isnan(array))[0])} of an axis is NaN: leave it out")
    array.setflags(write=False)
    return Axis(array, unit, about)


def samples(number: int) -> Samples:
    """Makes a dimension of independent random draws (Monte Carlo).

    The random numbers of a point then depend on its place along the dimensions of samples alone: draw 7 is the same
    device for each stiffness and each order, so that neighbours on a map differ by the map and not by luck.

    Parameters
    ----------
    number : int
        Number of draws, at least 1.
    """
    if number != int(number) or number < 1:
        raise ValueError(f"a number of samples is a whole number from 1, not {number!r}")
    return Samples(int(number))


def together(**axes: Any) -> Together:
    """Makes one dimension of several axes that run side by side, for example the mass and damping of each device.

    Parameters
    ----------
    **axes
        Axes of the same length, as in `Grid`.
    """
    made = {name: as_axis(name, value) for name, value in axes.items()}
    lengths = {name: len(one) for name, one in made.items()}
    if len(set(lengths.values())) != 1:
        raise ValueError(f"axes that run together are at least one and have the same length, not {lengths}")
    return Together(made)


class Grid:
    """Points of a sweep: the product of its dimensions, the last one running fastest.

    Parameters
    ----------
    **dimensions
        For each name an axis (`axis`), `samples`, axes `together`, a pair ``(values, unit)``, or values without unit.
        Names are passed to the function as they are, so by the custom of this project without a unit in them: the
        unit is kept with the axis.

    Attributes
    ----------
    dimensions : dict
        Axes by the name of their dimension.
    coordinates : dict
        For each name of a coordinate its dimension and its axis.
    shape : tuple of int
    size : int
        Number of points.
    """

    def __init__(self, **dimensions: Any) -> None:
        if not dimensions:
            raise ValueError("the grid is empty: name at least one axis, for example Grid(order=[0.5, 1.0])")
        self.dimensions: dict[str, Axis | Samples | Together] = {
            name: value if isinstance(value, Together | Samples) else as_axis(name, value)
            for name, value in dimensions.items()
        }
        self.coordinates: dict[str, tuple[str, Axis | Samples]] = {}
        for dimension, value in self.dimensions.items():
            for name, one in value.axes.items() if isinstance(value, Together) else [(dimension, value)]:
                _check_name(name)
                if name in self.coordinates or (name != dimension and name in self.dimensions):
                    raise ValueError(f"two coordinates are called {name!r}: rename one")
                self.coordinates[name] = (dimension, one)
        self.shape = tuple(len(value) for value in self.dimensions.values())
        self.size = prod(self.shape)

    @property
    def random_dimensions(self) -> tuple[int, ...]:
        """Places of the dimensions of samples."""
        return tuple(place for place, value in enumerate(self.dimensions.values()) if isinstance(value, Samples))

    def summary(self) -> dict[str, Any]:
        """Facts that tell this grid from another."""
        return {
            "dimensions": dict(zip(self.dimensions, self.shape, strict=True)),
            "axes": {name: {"dimension": dim, **one.summary()} for name, (dim, one) in self.coordinates.items()},
        }

    __hash__ = None  # type: ignore[assignment]

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Grid):
            return NotImplemented
        # In the same order too: the last one runs fastest.
        return same(list(self.dimensions.items()), list(other.dimensions.items()))

    def __repr__(self) -> str:
        return f"Grid({', '.join(f'{name}={len(value)}' for name, value in self.dimensions.items())})"


def as_axis(name: str, value: Any) -> Axis:
    """An axis from what a user may give for one: an `Axis`, ``(values, unit)``, or values."""
    if isinstance(value, Axis):
        return value
    values, unit = value if isinstance(value, tuple) and len(value) == 2 and isinstance(value[1], str) else (value, "1")
    try:
        return axis(values, unit)
    except ValueError as error:
        raise ValueError(f"axis {name!r}: {error}") from None


def _check_name(name: str) -> None:
    if not name.isidentifier() or keyword.iskeyword(name):
        raise ValueError(f"{name!r} cannot be the name of an argument: use letters, digits and _")
    if name in RESERVED or name.startswith("_"):
        raise ValueError(f"an axis cannot be called {name!r}, which the sweep uses itself: rename it")
