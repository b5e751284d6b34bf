"""Ready-made sweeps: maps that take hours on one machine.

Each takes the options of `sweep` (``client``, ``store``, ``seed``, ``progress``, …) and returns its Dataset with the
figure asked for beside the raw results.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, Literal

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from fractional_haptics.analysis import Device, region
from fractional_haptics.experiment import zwidth
from fractional_haptics.tissue import MODELS, identify

from .grid import Grid, axis, samples, together
from .outputs import Output
from .run import sweep

_NORMAL_95 = 1.959963984540054  # 97.5 % quantile of the normal distribution


@dataclass(frozen=True)
class UncertainDevice:
    """Devices known within limits: each parameter uniform between its two ends, independent of the others.

    Attributes
    ----------
    mass_kg, damping_n_s_per_m, delay_s, hand_stiffness_n_per_m, current_lag_s : tuple of two floats
        Least and largest value, as in `fractional_haptics.analysis.Device`.
    """

    mass_kg: tuple[float, float]
    damping_n_s_per_m: tuple[float, float]
    delay_s: tuple[float, float] = (0.0, 0.0)
    hand_stiffness_n_per_m: tuple[float, float] = (0.0, 0.0)
    current_lag_s: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        for one in fields(self):
            low, high = getattr(self, one.name)
            if not 0.0 <= low <= high < np.inf:
                raise ValueError(f"{one.name} goes from a least value of at least 0 to a largest, not {(low, high)}")

    def __call__(self, rng: np.random.Generator) -> Device:
        """A device of these; it takes five random numbers, whatever the limits are."""
        return Device(**{one.name: rng.uniform(*getattr(self, one.name)) for one in fields(self)})


def robust_stability_map(
    order: ArrayLike,
    stiffness: ArrayLike,
    devices: Callable[[np.random.Generator], Device],
    *,
    dissipation: ArrayLike,
    sample_time: float,
    number: int = 10_000,
    scheme: str = "exact",
    **options: Any,
) -> xr.Dataset:
    """The share of uncertain devices on which a wall ``K + B D^order`` is stable, over order and stiffness.

    Parameters
    ----------
    order : array_like
        Orders, 0 to 2.
    stiffness : array_like
        Stiffnesses K in N/m.
    devices : callable
        Draws a device with a random generator: `UncertainDevice`, or a function of your own.
    dissipation : array_like
        B in N·s^order/m, one for each order: their units differ, so one number for all is no fair comparison.
    sample_time : float
        T in s.
    number : int
        Devices. The 95 % interval of a share of one half is ±1 % with 10 000, ±0.3 % with 100 000.
    scheme : str
        The operator that runs, see `fractional_haptics.operators`.
    **options
        Of `sweep`.

    Returns
    -------
    xarray.Dataset
        ``share`` (order, stiffness) with the 95 % interval ``share_low``, ``share_high`` by Wilson;
        ``stable`` (order, sample, stiffness): 1, 0, or NaN where ``error`` says why.

    Notes
    -----
    One region by D-decomposition for each order and device; walls are looked up in its polygon. Draw n is the same
    device for each order.

    References
    ----------
    E. B. Wilson, *Probable inference, the law of succession, and statistical inference*, J. American Statistical
    Association 22, 1927.
    """
    walls = axis(stiffness, "N/m", "stiffness K")
    orders = together(order=axis(order, "1", "order μ"), dissipation=axis(dissipation, "N·s^μ/m", "dissipation B"))
    point = functools.partial(
        _stable_walls,
        devices=devices,
        stiffness=np.asarray(walls.values, dtype=float),
        sample_time=float(sample_time),
        scheme=scheme,
    )
    outputs = {"stable": Output("1", "stable", axes={"stiffness": walls}, dtype="float32")}
    found: xr.Dataset = sweep(point, Grid(order=orders, sample=samples(number)), outputs=outputs, **options)
    return found.assign(_shares(found["stable"]))


def _stable_walls(
    order: float,
    dissipation: float,
    rng: np.random.Generator,
    *,
    devices: Callable[[np.random.Generator], Device],
    stiffness: np.ndarray,
    sample_time: float,
    scheme: str,
) -> dict[str, np.ndarray]:
    found = region(devices(rng), order, sample_time, scheme)
    return {"stable": found.contains(stiffness, dissipation)}


def _shares(stable: xr.DataArray) -> dict[str, Any]:
    """Share of ones over the samples, and its interval by Wilson; an order at a time, for the memory."""
    dims = ("order", "stiffness")
    shape = (stable.sizes["order"], stable.sizes["stiffness"])
    share, low, high = (np.full(shape, np.nan) for _ in range(3))
    for row in range(shape[0]):
        values = stable.isel(order=row).transpose("sample", "stiffness").values
        known = np.isfinite(values)
        number = known.sum(axis=0)
        with np.errstate(invalid="ignore", divide="ignore"):
            p = np.where(known, values, 0.0).sum(axis=0, dtype=float) / number
            z2 = _NORMAL_95**2 / number
            middle = (p + z2 / 2) / (1 + z2)
            half = np.sqrt(z2 * (p * (1 - p) + z2 / 4)) / (1 + z2)
        share[row], low[row], high[row] = p, middle - half, middle + half
    about = {"units": "1", "long_name": "share of devices that stay stable"}
    return {
        "share": (dims, share, about),
        "share_low": (dims, low, {**about, "long_name": "low end of the 95 % interval"}),
        "share_high": (dims, high, {**about, "long_name": "high end of the 95 % interval"}),
    }


def zwidth_map(
    order: ArrayLike,
    devices: Mapping[str, Mapping[str, Any]],
    delay_s: ArrayLike,
    *,
    points: int = 21,
    common: Mapping[str, Any] | None = None,
    **options: Any,
) -> xr.Dataset:
    """The stiffest walls that devices render, by trial, over order, device and delay.

    Parameters
    ----------
    order : array_like
        Orders, 0 to 2.
    devices : mapping
        For each name the parameters of a device, as `fractional_haptics.experiment.zwidth` takes them:
        ``{"desktop": {"mass_kg": 0.065, "damping_n_s_per_m": 3.5}}``.
    delay_s : array_like
        Delays in s.
    points : int
        Dissipations tried for each wall.
    common : mapping, optional
        Parameters that are the same for all devices: sample time, push, seed.
    **options
        Of `sweep`.

    Returns
    -------
    xarray.Dataset
        Over ``order``, ``device`` and ``delay``: ``stiffness``, the largest that came to rest (0 if none did),
        ``dissipation``, where it did, and ``analysis_stiffness``, what the analysis says there (NaN if it knows none).
    """
    shared = dict(common or {})
    if clash := {"delay_s"} & {*shared, *(key for one in devices.values() for key in one)}:
        raise ValueError(f"{clash.pop()} is an axis of this map: leave it out of the devices")
    point = functools.partial(
        _stiffest_wall, devices={name: {**shared, **one} for name, one in devices.items()}, points=int(points)
    )
    outputs = {
        "stiffness": Output("N/m", "largest stable stiffness"),
        "dissipation": Output("N·s^μ/m", "dissipation where it is"),
        "analysis_stiffness": Output("N/m", "largest stable stiffness there by the analysis"),
    }
    grid = Grid(
        order=axis(order, "1", "order μ"), device=axis(list(devices), "1", "device"), delay=axis(delay_s, "s", "delay")
    )
    found: xr.Dataset = sweep(point, grid, outputs=outputs, **options)
    return found


def _stiffest_wall(
    order: float, device: str, delay: float, *, devices: Mapping[str, Mapping[str, Any]], points: int
) -> dict[str, float]:
    tried = zwidth(orders=[order], points=points, delay_s=delay, **devices[device])
    boundary = tried["orders"][0]["boundary"]
    if not boundary:
        return {"stiffness": 0.0, "dissipation": np.nan, "analysis_stiffness": np.nan}
    best = max(boundary, key=lambda one: float(one["stiffness_max"]))
    known = best["analysis_stiffness_n_per_m"]
    return {
        "stiffness": best["stiffness_max"],
        "dissipation": best["dissipation"],
        "analysis_stiffness": np.nan if known is None else known,
    }


def cohort_bootstrap(
    specimens: Sequence[tuple[ArrayLike, ArrayLike]],
    model: str,
    *,
    number: int = 1000,
    kind: Literal["relaxation", "creep"] = "relaxation",
    starts: int = 8,
    **options: Any,
) -> xr.Dataset:
    """How sure the parameters of a tissue are: a bootstrap over the specimens of a cohort, and within each.

    Each draw takes as many specimens as there are, with repetition; gives each drawn record new residuals, taken from
    its own with repetition; fits the model; and takes the mean of each parameter, of a modulus the geometric one.

    Parameters
    ----------
    specimens : sequence of pairs
        For each specimen times in s and moduli or compliances, as `fractional_haptics.tissue.identify` takes; at least two.
    model : str
        Name of the model.
    number : int
        Draws.
    kind : {"relaxation", "creep"}
        Kind of the records.
    starts : int
        Starts of the search in each fit.
    **options
        Of `sweep`.

    Returns
    -------
    xarray.Dataset
        For each parameter of the model its values by ``sample``: ``result["order"].quantile([0.025, 0.975])``. The same
        names with ``_cohort``: the means of the fits of the records as they are.

    Raises
    ------
    ValueError
        Fewer than two specimens, an unknown model, or a specimen that cannot be fitted, with its number.
    """
    if kind not in ("relaxation", "creep"):
        raise ValueError(f'kind is "relaxation" or "creep", whose residuals are of the logarithm, not {kind!r}')
    if model not in MODELS:
        raise ValueError(f"no model is called {model!r}; known are {', '.join(MODELS)}")
    if len(specimens) < 2:
        raise ValueError(f"a cohort has at least two specimens, not {len(specimens)}")
    fit = functools.partial(_fitted, model=model, kind=kind, starts=int(starts))
    records, fitted = [], []
    for place, (t, y) in enumerate(specimens):
        try:
            parameters, predicted, measured = fit(t, y)
        except ValueError as error:
            raise ValueError(f"specimen {place}: {error}") from None
        records.append((np.asarray(t, dtype=float), predicted, np.log(measured / predicted)))
        fitted.append(parameters)
    units = {one.name: one.unit for one in MODELS[model].parameters}
    outputs = {name: Output(unit or "1") for name, unit in units.items()}
    point = functools.partial(_drawn_cohort, records=tuple(records), fit=fit, units=units)
    found = sweep(point, Grid(sample=samples(number)), outputs=outputs, **options)
    means = _means(fitted, units)
    return found.assign({f"{name}_cohort": ((), means[name], found[name].attrs) for name in units})


def _fitted(
    t: ArrayLike, y: ArrayLike, *, model: str, kind: Literal["relaxation", "creep"], starts: int
) -> tuple[Mapping[str, float], np.ndarray, np.ndarray]:
    """Parameters, prediction and record of a fit."""
    found = identify(t, y, kind, models=[model], starts=starts)
    if found.best.model is None:
        raise ValueError(f"the {model} comes down to a simpler model on this record")
    return found.best.model.parameters, found.best.predicted, found.measured


def _drawn_cohort(
    rng: np.random.Generator,
    *,
    records: tuple[tuple[np.ndarray, np.ndarray, np.ndarray], ...],
    fit: Callable[..., Any],
    units: Mapping[str, str],
) -> dict[str, float]:
    fitted = []
    for place in rng.integers(len(records), size=len(records)):
        t, predicted, residuals = records[place]
        drawn = predicted * np.exp(rng.choice(residuals, size=len(residuals)))
        fitted.append(fit(t, drawn)[0])
    return _means(fitted, units)


def _means(fitted: Sequence[Mapping[str, float]], units: Mapping[str, str]) -> dict[str, float]:
    """Means of parameters: of a modulus, which has a unit, the geometric one."""
    means = {}
    for name, unit in units.items():
        values = np.array([one[name] for one in fitted])
        means[name] = float(np.exp(np.log(values).mean()) if unit else values.mean())
    return means
