"""Figures with matplotlib, in the colours of the command. Needs the extra ``plot``.

Every function draws into `ax` or into a new figure, and returns the axes.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import matplotlib.pyplot as plt
import numpy as np
from cycler import cycler

from fractional_haptics._native import COLOURS, GRID, INK
from fractional_haptics._series import columns_of, described

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes

    from fractional_haptics._series import Series
    from fractional_haptics.analysis import Region
    from fractional_haptics.experiment import Run
    from fractional_haptics.tissue import Identification

__all__ = ["STYLE", "columns", "identification", "quantiles", "regions", "relaxation"]

STYLE: dict[Any, Any] = {
    "axes.prop_cycle": cycler(color=COLOURS),
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "axes.grid": True,
    "grid.color": GRID,
    "axes.axisbelow": True,
    "legend.frameon": False,
}
"""For ``matplotlib.rc_context(STYLE)``: colours that people with any colour vision tell apart (Okabe and Ito, 2008)."""


def _axes(ax: Axes | None) -> Axes:
    if ax is not None:
        return ax
    # The figure first: a backend that is chosen inside the context would be half forgotten behind it.
    figure = plt.figure(layout="constrained")
    with plt.rc_context(STYLE):
        return figure.add_subplot()


def regions(regions: Mapping[str, Region] | Region, ax: Axes | None = None) -> Axes:
    """Regions of stable walls: dissipation to the right, stiffness up.

    Parameters
    ----------
    regions : Region or dict of str to Region
        With their labels. Units of dissipation differ between orders: compare regions of one order.
    ax : Axes, optional
        Where to draw.

    Returns
    -------
    Axes
    """
    ax = _axes(ax)
    labelled = regions if isinstance(regions, Mapping) else {"": regions}
    for index, (label, region) in enumerate(labelled.items()):
        colour = COLOURS[index % len(COLOURS)]
        for part, points in enumerate(region.polygons):
            closed = np.vstack([points, points[:1]])
            ax.plot(closed[:, 1], closed[:, 0], color=colour, label=label if part == 0 and label else None)
            if region.areas[part] > 0:
                ax.fill(closed[:, 1], closed[:, 0], color=colour, alpha=0.1, linewidth=0)
            else:
                ax.fill(closed[:, 1], closed[:, 0], color=ax.get_facecolor(), linewidth=0)
    ax.set(xlabel="dissipation $B$ / N·s$^μ$/m", ylabel="stiffness $K$ / (N/m)", xlim=(0, None), ylim=(0, None))
    if any(labelled):
        ax.legend()
    return ax


def relaxation(run: Run, ax: Axes | None = None) -> Axes:
    """The force of a relaxation beside its closed form, time logarithmic.

    Parameters
    ----------
    run : Run
        Of ``experiment.relax``.
    ax : Axes, optional
        Where to draw.

    Returns
    -------
    Axes

    Raises
    ------
    ValueError
        A run of another kind, or one that was cut short.
    """
    if run.kind != "relax" or "closed_form_force_n" not in run.columns:
        raise ValueError(f"a run of {run.kind} has no relaxation to draw: give one of experiment.relax that ran to its end")
    ax = _axes(ax)
    time = run["time_s"]
    shown = time > 0
    origin = "simulated" if "simulated_force_n" in run.columns else "rendered"
    ax.semilogx(time[shown], run[f"{origin}_force_n"][shown], color=COLOURS[0], label=origin)
    ax.semilogx(time[shown], run["closed_form_force_n"][shown], color=COLOURS[1], linestyle="--", label="closed form")
    if run.against:
        ax.semilogx(run.against["time_s"], run.against["record_force_n"], ".", color=INK, label="record", zorder=1)
    ax.set(xlabel="time / s", ylabel="force on the hand / N", title=str(run.report["tissue"]))
    ax.legend()
    return ax


def columns(result: Series, *names: str, ax: Axes | None = None) -> Axes:
    """Columns of any result over its time or frequency; `result.plot` calls it.

    Parameters
    ----------
    result : Run, Response, Felt, Answer, Table, …
        What has a ``to_xarray``.
    names : str
        Its columns; none for the second one of the table, and all that share its unit.
    ax : Axes, optional
        Where to draw.

    Returns
    -------
    Axes

    Raises
    ------
    ValueError
        A result without columns, as a run that was cut short.
    KeyError
        A name that is not one of its columns.
    """
    table = columns_of(result)
    axes = {name: described(result, name) for name in table}
    along, *known = table
    if unknown := [name for name in names if name not in table]:
        raise KeyError(f"{unknown[0]!r} is not one of the columns {', '.join(known)}")
    unit = axes[names[0] if names else known[0]].get("units", "")
    shown = names or [name for name in known if axes[name].get("units", "") == unit and table[name].dtype.kind in "fciu"]
    ax = _axes(ax)
    for name in shown:
        label = axes[name]["long_name"] if axes[name].get("units", "") == unit else _named(axes[name])
        values = np.abs(table[name]) if np.iscomplexobj(table[name]) else table[name]
        ax.plot(table[along], values, label=label)
    if axes[along].get("units") in ("rad/s", "Hz"):
        ax.set_xscale("log")
    # The words that all end with: of simulated and closed form force the force.
    words = [axes[name]["long_name"].split()[::-1] for name in shown if axes[name].get("units", "") == unit]
    common = {"long_name": " ".join(os.path.commonprefix(words)[::-1]), "units": unit}
    ax.set(xlabel=_named(axes[along]), ylabel=_named(common), title=getattr(result, "kind", ""))
    if len(shown) > 1:
        ax.legend()
    return ax


_LABELS = {
    "relaxation": ("time / s", "relaxation modulus / Pa"),
    "creep": ("time / s", "creep compliance / (1/Pa)"),
    "oscillation": ("angular frequency / (rad/s)", "storage and loss modulus / Pa"),
    "record": ("time / s", "stress / Pa"),
}


def identification(found: Identification, ax: Axes | None = None, fits: int = 3) -> Axes:
    """A record and the models fitted to it.

    Parameters
    ----------
    found : Identification
        Of ``tissue.identify``.
    ax : Axes, optional
        Where to draw.
    fits : int, default 3
        So many of the fits, best first.

    Returns
    -------
    Axes
    """
    ax = _axes(ax)
    draw = ax.plot if found.kind == "record" else ax.loglog
    # Of an oscillation all frequencies are there twice: storage, then loss.
    half = len(found.x) // 2 if found.kind == "oscillation" else len(found.x)
    for part in range(0, len(found.x), max(half, 1)):
        rows = slice(part, part + half)
        draw(found.x[rows], found.measured[rows], ".", color=INK, label="record" if part == 0 else None)
        for index, fit in enumerate(found.fits[:fits]):
            style = ["-", "--", ":", "-."][index % 4]
            label = f"{fit.kind}, rms {fit.rms:.2g}" if part == 0 else None
            colour = COLOURS[index % len(COLOURS)]
            draw(found.x[rows], fit.predicted[rows], style, color=colour, label=label)
    xlabel, ylabel = _LABELS[found.kind]
    ax.set(xlabel=xlabel, ylabel=ylabel)
    ax.legend()
    return ax


def quantiles(
    result: xarray.DataArray,
    over: str = "sample",
    ax: Axes | None = None,
    *,
    shares: Sequence[float] = (0.05, 0.25, 0.5, 0.75, 0.95),
    label: str | None = None,
) -> Axes:
    """The spread of a result of a sweep: its median as a line, bands between the quantiles that belong together.

    Parameters
    ----------
    result : xarray.DataArray
        One result of a sweep, as ``result["stiffness"]``, with `over` and one more dimension; choose of others with ``sel``.
        Points that failed, NaN, are left out.
    over : str, default "sample"
        The dimension along which it spreads.
    ax : Axes, optional
        Where to draw; several results share it, each in the next colour.
    shares : sequence of float
        Quantiles from 0 to 1, the same from either end, with 0.5 in the middle or without.
    label : str, optional
        In the legend, before the bands.

    Returns
    -------
    Axes

    Raises
    ------
    ValueError
        Other dimensions, shares that do not mirror each other.
    """
    along = [name for name in map(str, result.dims) if name != over]
    if over not in result.dims or len(along) != 1:
        raise ValueError(
            f"a result of the dimensions {', '.join(map(str, result.dims))} has no single one beside {over}: "
            "choose with result.sel(…), or name another one in over"
        )
    rising = sorted(shares)
    if not rising or not np.allclose(np.add(rising, rising[::-1]), 1.0) or not 0 <= rising[0] <= rising[-1] <= 1:
        raise ValueError(f"shares {tuple(shares)} do not mirror each other about 0.5, as 0.05, 0.5, 0.95 do")
    ax = _axes(ax)
    found = result.quantile(rising, dim=over, skipna=True).transpose("quantile", along[0])
    place = result.coords[along[0]]
    x = np.asarray(place)
    colour = COLOURS[len(ax.lines) % len(COLOURS)]
    middle = rising.index(0.5) if 0.5 in rising else None
    for low in range(len(rising) // 2):
        between = f"{100 * (rising[-1 - low] - rising[low]):.4g} % of {over}s"
        ends = np.asarray(found[low]), np.asarray(found[len(rising) - 1 - low])
        ax.fill_between(x, *ends, color=colour, alpha=0.15 + 0.1 * low, linewidth=0, label=f"{label}, {between}" if label else between)
    if middle is not None:
        ax.plot(x, np.asarray(found[middle]), color=colour, marker=".", label=f"{label}, median" if label else "median")
    ax.set(xlabel=_named({"long_name": place.name, **place.attrs}), ylabel=_named({"long_name": result.name, **result.attrs}))
    ax.legend()
    return ax


def _named(attributes: Mapping[str, Any]) -> str:
    """Name and unit of an axis."""
    name, unit = str(attributes["long_name"]), str(attributes.get("units", ""))
    if not name:
        return unit
    return name if unit in ("", "1") else f"{name} / {unit if '/' not in unit else f'({unit})'}"
