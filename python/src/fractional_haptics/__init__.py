"""Fractional-order operators, viscoelastic tissue, stability of haptic loops and their experiments.

The numbers come from the Rust crates of the same project; nothing is computed twice.

Modules
-------
operators
    ``D^μ`` of whole records and of streams.
tissue
    Models, the library, models from records.
analysis
    What is stable, passive and transparent.
bridge
    A driver in Python as a device.
control
    Fractional transfer functions, controllers, tuning.
experiment
    Relaxation, creep, walls, couplers, touches of shapes, Z-width, design, analyses.
session
    A person feels walls: judged, changed in the hand, answers and forces in one log.
records
    Tables and logs of people, in the folders of BIDS.
log
    Logs of runs as pandas tables.
plot
    Figures with matplotlib.
sweep
    Maps over grids, on threads or on a cluster.
"""

from importlib import import_module as _import_module
from typing import TYPE_CHECKING as _TYPE_CHECKING

from fractional_haptics import _values as _values
from fractional_haptics._native import __version__

if _TYPE_CHECKING:  # editors and type checkers see them all
    from fractional_haptics import analysis as analysis
    from fractional_haptics import bridge as bridge
    from fractional_haptics import control as control
    from fractional_haptics import experiment as experiment
    from fractional_haptics import log as log
    from fractional_haptics import operators as operators
    from fractional_haptics import plot as plot
    from fractional_haptics import records as records
    from fractional_haptics import session as session
    from fractional_haptics import sweep as sweep
    from fractional_haptics import tissue as tissue

_MODULES = ("analysis", "bridge", "control", "experiment", "log", "operators", "plot", "records", "session", "sweep", "tissue")

__all__ = ["__version__", *_MODULES]


def __getattr__(name: str) -> object:
    """Imports a module when it is first named: what it needs is then loaded, and not before."""
    if name in _MODULES:
        return _import_module(f"{__name__}.{name}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
