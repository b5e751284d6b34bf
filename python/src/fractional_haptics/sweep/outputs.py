"""Outputs: the variables that a function's result becomes.

A function returns one number, one small array, or a mapping of names to these. Every variable is a floating number, so
that a failed point can be NaN; truth values become 0 and 1, so that a mean is a share.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fractional_haptics._values import HoldsArrays

from .grid import RESERVED, Axis, Grid, as_axis, axis

NAMELESS = "value"
"""Name of the variable of a function that returns a number or an array without a name."""

_DTYPES = ("float64", "float32", "complex128")


@dataclass(frozen=True, eq=False)
class Output(HoldsArrays):
    """One variable of the result.

    Parameters
    ----------
    unit : str
        Unit, for example ``"N/m"``; ``"1"`` for none.
    about : str
        A few words for the label of a figure.
    axes : mapping
        For a small array its axes by name, as in `Grid`; empty for a number.
    dtype : {"float64", "float32", "complex128"}
        Type in which it is kept.
    """

    unit: str = "1"
    about: str = ""
    axes: Mapping[str, Axis] = field(default_factory=dict)
    dtype: str = "float64"

    def __post_init__(self) -> None:
        if self.dtype not in _DTYPES:
            raise ValueError(f"dtype {self.dtype!r}: only {', '.join(_DTYPES)} can say by NaN that a point failed")
        object.__setattr__(self, "axes", {name: as_axis(name, one) for name, one in self.axes.items()})

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the value of one point."""
        return tuple(len(one) for one in self.axes.values())

    @property
    def missing(self) -> complex | float:
        """Value of a failed point."""
        return complex(np.nan, np.nan) if self.dtype == "complex128" else np.nan

    def to_json(self) -> dict[str, Any]:
        """The output as it goes into a manifest."""
        return {
            "unit": self.unit,
            "about": self.about,
            "dtype": self.dtype,
            "axes": {
                name: {"values": one.values.tolist(), "unit": one.unit, "about": one.about}
                for name, one in self.axes.items()
            },
        }

    @staticmethod
    def from_json(known: Mapping[str, Any]) -> Output:
        """The output that a manifest holds."""
        axes = {name: axis(**one) for name, one in known["axes"].items()}
        return Output(known["unit"], known["about"], axes, known["dtype"])


Outputs = Mapping[str, Output]


def as_outputs(given: Mapping[str, Output | str], grid: Grid) -> dict[str, Output]:
    """Checks outputs that a user gave, where a text is a unit.

    Raises
    ------
    ValueError
        No output, or a name that is also one of the grid, of another output's axis, or of the sweep.
    """
    if not given:
        raise ValueError("outputs names no variable: name at least one, or leave it out")
    outputs = {name: Output(one) if isinstance(one, str) else one for name, one in given.items()}
    taken = set(grid.coordinates) | set(grid.dimensions)
    for name, one in outputs.items():
        if name in RESERVED:
            raise ValueError(f"a result cannot be called {name!r}, which the sweep uses itself: rename it")
        for clash in ({name, *one.axes} & taken) | ({name} & set(one.axes)):
            raise ValueError(f"{clash!r} is a result, or an axis of one, and also an axis of the grid: rename one")
    axes: dict[str, Axis] = {}
    for one in outputs.values():
        for name, inner in one.axes.items():
            if name in outputs or axes.setdefault(name, inner).summary() != inner.summary():
                raise ValueError(f"{name!r} is an axis of two kinds in the results: rename one")
    return outputs


def named(result: Any) -> Mapping[str, Any]:
    """The result of a function as a mapping."""
    return result if isinstance(result, Mapping) else {NAMELESS: result}


def kind_of(result: Any) -> dict[str, tuple[tuple[int, ...], bool]]:
    """For each variable of a result its shape, and if it is complex."""
    kinds = {}
    for name, value in named(result).items():
        array = _number(str(name), value)
        kinds[str(name)] = (array.shape, array.dtype.kind == "c")
    return kinds


def outputs_from(kinds: Mapping[str, tuple[tuple[int, ...], bool]]) -> dict[str, Output]:
    """Outputs without units of results of those kinds; axes of arrays count from 0."""
    return {
        name: Output(
            axes={
                f"{name}_{place}" if len(shape) > 1 else f"{name}_index": axis(np.arange(length), "1", "index")
                for place, length in enumerate(shape)
            },
            dtype="complex128" if is_complex else "float64",
        )
        for name, (shape, is_complex) in kinds.items()
    }


def empty_rows(outputs: Outputs, points: int) -> dict[str, np.ndarray]:
    """Arrays for that many points, all missing."""
    return {name: np.full((points, *one.shape), one.missing, one.dtype) for name, one in outputs.items()}


def put(outputs: Outputs, rows: dict[str, np.ndarray], row: int, result: Any) -> None:
    """Writes the result of one point into its row.

    Raises
    ------
    ValueError, TypeError
        Another set of names or another shape than the outputs have, or something that is no number. The row is then
        as it was, or partly written.
    """
    values = named(result)
    if values.keys() != outputs.keys():
        raise ValueError(f"returned {_list(values)}, where this sweep has {_list(outputs)}")
    for name, value in values.items():
        array = rows[name]
        if array.ndim == 1 and type(value) is float:
            array[row] = value
            continue
        number = _number(name, value)
        if number.shape != array.shape[1:]:
            raise ValueError(f"{name!r} has shape {number.shape}, where this sweep has {array.shape[1:]}")
        if number.dtype.kind == "c" and array.dtype.kind != "c":
            raise TypeError(f'{name!r} is complex: give outputs with Output(dtype="complex128")')
        array[row] = number


def _number(name: str, value: Any) -> np.ndarray:
    array = np.asarray(value)
    if array.dtype.kind not in "biufc":
        raise TypeError(f"{name!r} is {type(value).__name__}, neither a number nor an array of numbers")
    return array


def _list(names: Mapping[str, Any]) -> str:
    return ", ".join(repr(name) for name in names) or "nothing"
