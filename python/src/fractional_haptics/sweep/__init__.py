"""Sweeps: a function at each point of a grid, on threads or on a cluster, into a store that can be resumed.

::

    from fractional_haptics.sweep import Grid, axis, samples, sweep

    def largest(order, delay, rng):
        mass = rng.normal(0.065, 0.005)
        ...
        return {"stiffness": limit}

    result = sweep(
        largest,
        Grid(order=axis([0.5, 1.0], about="order"), delay=axis([0.0, 1e-3], "s"), sample=samples(1000)),
        store="largest.zarr",
        outputs={"stiffness": "N/m"},
    )
    result["stiffness"].mean("sample").plot()

Needs ``pip install 'fractional-haptics[sweep]'``. ``docs/guide/src/sweeps.md`` explains stores, clusters and costs.
"""

from .errors import ClusterLost, StoreInUse, StoreMismatch, SweepError
from .grid import Axis, Grid, Samples, Together, axis, samples, together
from .outputs import Output
from .progress import Progress
from .run import open_sweep, sweep

__all__ = [
    "Axis",
    "ClusterLost",
    "Grid",
    "Output",
    "Progress",
    "Samples",
    "StoreInUse",
    "StoreMismatch",
    "SweepError",
    "Together",
    "axis",
    "open_sweep",
    "samples",
    "sweep",
    "together",
]
