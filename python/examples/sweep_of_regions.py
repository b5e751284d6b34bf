"""The stiffest stable wall over order, delay and mass: a sweep with a store that can be resumed.

python sweep_of_regions.py [FOLDER]
"""

import sys
from pathlib import Path

import numpy as np

from fractional_haptics.analysis import Device, region
from fractional_haptics.sweep import Grid, axis, sweep


def stiffest(order, delay, mass):
    """Largest stable stiffness at the best dissipation."""
    found = region(Device(mass, 3.5, delay_s=delay), order, 1e-3)
    return {"stiffness": found.stiffness_max_n_per_m}


def main() -> None:
    """Sweeps and prints the stiffest wall for each delay, and its order."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    result = sweep(
        stiffest,
        Grid(
            order=axis(np.linspace(0.0, 2.0, 41), about="order μ"),
            delay=axis([0.0, 0.5e-3, 1e-3, 2e-3], "s", "delay"),
            mass=axis([0.04, 0.065, 0.1], "kg", "mass"),
        ),
        store=folder / "stiffest.zarr",
        outputs={"stiffness": "N/m"},
    )
    of_one = result["stiffness"].sel(mass=0.065)
    for delay in result["delay"].values:
        along = of_one.sel(delay=delay)
        print(f"delay {1e3 * delay:.1f} ms: {float(along.max()):7.0f} N/m at order {float(along.idxmax()):.2f}")


if __name__ == "__main__":
    main()
