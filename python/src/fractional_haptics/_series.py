"""Series: columns of numbers along one axis, which a result gives as labelled arrays and draws.

One mechanism for all results. Their keys carry the units, as those of a report do: `_native.name_and_unit` makes of ``force_n`` the name
``force`` and the unit ``N``.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from fractional_haptics import _native
from fractional_haptics._values import needed

if TYPE_CHECKING:
    from types import ModuleType

    import xarray
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

__all__ = ["Series", "along_rows", "columns_of", "described", "longest_rows", "outline"]


class Series:
    """What has columns of numbers along one axis."""

    __slots__ = ()

    def _series(self) -> Mapping[str, NDArray[Any]]:
        """Arrays of one length by their keys, that of the axis first."""
        raise NotImplementedError

    def _drawn(self, plot: ModuleType, ax: Axes | None) -> Axes:
        """The figure where no column is named."""
        return plot.columns(self, ax=ax)  # type: ignore[no-any-return]

    def to_xarray(self) -> xarray.Dataset:
        """The columns as labelled arrays: time or frequency as coordinate, name and unit of each in its ``attrs``. Needs the extra ``xarray``.

        Returns
        -------
        xarray.Dataset
            Its variables have the names of the columns. The report is in ``attrs``, as JSON, which a file takes too.

        Raises
        ------
        ImportError
            xarray is not installed.
        ValueError
            A result without columns, as a run that was cut short.

        Examples
        --------
        >>> from fractional_haptics import experiment
        >>> experiment.relax(duration_s=2.0).to_xarray()["simulated_force_n"].attrs
        {'long_name': 'simulated force', 'units': 'N'}
        """
        xr = needed("xarray")
        columns = columns_of(self)
        axis = next(iter(columns))
        arrays = {key: (axis, values, described(self, key)) for key, values in columns.items()}
        report = self if isinstance(self, Mapping) else getattr(self, "report", None)
        attributes = {} if report is None else {"report": json.dumps(report)}
        return xr.Dataset(arrays, attrs=attributes)  # type: ignore[no-any-return]

    def plot(self, *names: str, ax: Axes | None = None) -> Axes:
        """Draws the result; its columns of these names, if some are given. Needs the extra ``plot``.

        Parameters
        ----------
        names : str
            Columns, as `to_xarray` names them; none for the figure that suits the result.
        ax : Axes, optional
            Where to draw.

        Returns
        -------
        Axes

        Raises
        ------
        ImportError
            matplotlib is not installed.
        KeyError
            A name that is not one of its columns.
        ValueError
            A result without columns, as a run that was cut short.
        """
        needed("matplotlib", "plot")
        from fractional_haptics import plot

        return plot.columns(self, *names, ax=ax) if names else self._drawn(plot, ax)


def columns_of(result: Series) -> Mapping[str, NDArray[Any]]:
    """Its columns, where it has some beside the axis."""
    columns = result._series()
    if len(columns) < 2:
        raise ValueError(f"this {type(result).__name__} has no columns of numbers: it was cut short, or its answer is no series")
    return columns


def described(result: Series, key: str) -> dict[str, str]:
    """Name and unit of a column; that of a dissipation, which its order decides, stands in the report or in a column."""
    name, unit = _native.name_and_unit(key)
    if isinstance(result, Mapping):
        units = result.get(f"{key}_unit", result._series().get(f"{key}_unit", [unit]))
        unit = units if isinstance(units, str) else str(units[0])
    return {"long_name": name} | ({"units": unit} if unit else {})


def along_rows(rows: Sequence[Mapping[str, Any]]) -> dict[str, NDArray[Any]]:
    """The columns of rows: what is a number in each, or nothing, as NaN; other columns as texts."""
    import numpy as np

    columns: dict[str, NDArray[Any]] = {}
    for key in rows[0] if rows else ():
        cells = [row.get(key) for row in rows]
        if any(isinstance(cell, Mapping | list) for cell in cells):
            continue
        try:
            columns[key] = np.array([np.nan if cell in (None, "n/a") else float(cell) for cell in cells])
        except ValueError:
            columns[key] = np.array([str(cell) for cell in cells])
    return columns


def longest_rows(report: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
    """The columns of the longest list of rows in a report; of rows with lists of rows those of all of them, as of a boundary for each order."""
    rows = max(_lists(report), key=len, default=[])
    within = [{**inner, **row} for row in rows for some in _lists(row) for inner in some]
    return along_rows(within or rows)


def _lists(report: Mapping[str, Any]) -> list[list[Mapping[str, Any]]]:
    return [rows for rows in report.values() if isinstance(rows, list) and rows and isinstance(rows[0], Mapping)]


def outline(region: _native.Region) -> dict[str, NDArray[Any]]:
    """The points of a region's polygons, one polygon behind the other."""
    import numpy as np

    polygons = region.polygons
    points = np.vstack([np.empty((0, 2)), *polygons])
    return {
        "point": np.arange(len(points)),
        "dissipation_n_s_mu_per_m": points[:, 1],
        "stiffness_n_per_m": points[:, 0],
        "polygon": np.repeat(np.arange(len(polygons)), [len(polygon) for polygon in polygons]),
    }


def _equip() -> None:
    """Gives the region of the native module what the others inherit."""

    def drawn(region: _native.Region, plot: ModuleType, ax: Axes | None) -> Axes:
        return plot.regions(region, ax)  # type: ignore[no-any-return]

    for key, function in {"_series": outline, "_drawn": drawn, "to_xarray": Series.to_xarray, "plot": Series.plot}.items():
        setattr(_native.Region, key, function)


_equip()
