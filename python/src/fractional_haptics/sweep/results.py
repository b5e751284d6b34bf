"""Results of a sweep in memory, and the Dataset that they become."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Protocol

import numpy as np
import xarray as xr

from .blocks import Part
from .grid import Axis, Grid, Samples
from .outputs import Outputs
from .work import Block

ERROR_ABOUT = "text of the error of a point that failed, empty if it did not"


class Results(Protocol):
    """A place where blocks go."""

    def write(self, part: Part, block: Block) -> None:
        """Keeps the results of a block, all or none of them."""

    def dataset(self, attributes: Mapping[str, Any]) -> xr.Dataset:
        """Everything that is kept so far; NaN where nothing is."""


class Stored(Results, Protocol):
    """One that keeps them from run to run."""

    def read(self, part: Part) -> Block:
        """A block as it is kept."""


class InMemory:
    """Arrays of the whole grid.

    Parameters
    ----------
    grid : Grid
    outputs : mapping
    """

    def __init__(self, grid: Grid, outputs: Outputs) -> None:
        self._grid, self._outputs = grid, outputs
        self._arrays = {name: np.full(grid.shape + one.shape, one.missing, one.dtype) for name, one in outputs.items()}
        self._errors = np.full(grid.shape, "", dtype=object)

    def write(self, part: Part, block: Block) -> None:
        """Keeps the results of a block."""
        for name, values in block.values.items():
            self._arrays[name][part.region] = values
        self._errors[part.region] = error_texts(part, block)

    def dataset(self, attributes: Mapping[str, Any]) -> xr.Dataset:
        """Everything that is kept so far."""
        variables = {
            name: (tuple(dims), self._arrays[name], attrs)
            for name, dims, attrs in variables_of(self._grid, self._outputs)
        }
        variables["error"] = (tuple(self._grid.dimensions), self._errors, {"long_name": ERROR_ABOUT})
        coordinates = {
            name: (dimension, one.values, attributes_of(one))
            for name, dimension, one in coordinates_of(self._grid, self._outputs)
        }
        return xr.Dataset(variables, coordinates, dict(attributes))


def error_texts(part: Part, block: Block) -> np.ndarray:
    """Texts of a block's errors, in its shape."""
    texts = np.full(part.size, "", dtype=object)
    for row, text in block.errors.items():
        texts[row] = text
    return texts.reshape(part.shape)


def coordinates_of(grid: Grid, outputs: Outputs) -> Iterator[tuple[str, str, Axis | Samples]]:
    """Name, dimension and axis of each coordinate of the result."""
    for name, (dimension, one) in grid.coordinates.items():
        yield name, dimension, one
    inner = {name: one for output in outputs.values() for name, one in output.axes.items()}
    for name, one in inner.items():
        yield name, name, one


def variables_of(grid: Grid, outputs: Outputs) -> Iterator[tuple[str, list[str], dict[str, str]]]:
    """Name, dimensions and attributes of each variable of the result but `error`."""
    for name, one in outputs.items():
        yield name, [*grid.dimensions, *one.axes], _attributes(one.unit, one.about)


def attributes_of(one: Axis | Samples) -> dict[str, str]:
    """Attributes of a coordinate, as xarray's plots read them."""
    return _attributes(one.unit, one.about)


def _attributes(unit: str, about: str) -> dict[str, str]:
    return {"units": unit, **({"long_name": about} if about else {})}
