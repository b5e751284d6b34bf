"""The share of uncertain devices on which a fractional wall stays stable, over order and stiffness.

    python robust_stability_map.py --samples 1000 --out .
    python robust_stability_map.py --samples 100000 --out .      # resumes in robust-stability.zarr

A desktop device that is known to ±20 % in mass and ±50 % in damping, at 1 kHz, with a delay of 0 to 1 ms beside the
hold. The dissipation B of each order gives the same force for the same motion at 100 rad/s: 200 N/m of amplitude.
"""

import argparse
import time
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr

from fractional_haptics.sweep.maps import UncertainDevice, robust_stability_map

DEVICES = UncertainDevice(mass_kg=(0.052, 0.078), damping_n_s_per_m=(1.75, 5.25), delay_s=(0.0, 1e-3))


def draw(result: xr.Dataset, path: Path) -> None:
    """Draws the share as a map with its lines of 50, 95 and 99.9 %."""
    figure, axes = plt.subplots(figsize=(6.4, 4.2), layout="constrained")
    number = f"{result.sizes['sample']:,}".replace(",", " ")
    coordinates = result["order"].values, result["stiffness"].values / 1e3
    share = result["share"].transpose("stiffness", "order").values
    shades = axes.pcolormesh(*coordinates, 100 * share, shading="nearest", cmap="viridis", vmin=0, vmax=100)
    lines = axes.contour(*coordinates, 100 * share, levels=[50, 95, 99.9], colors="white", linewidths=1)
    axes.clabel(lines, fmt=lambda level: f"{level:g} %")
    figure.colorbar(shades, label="devices that stay stable, %")
    axes.set(
        xlabel="order μ",
        ylabel="stiffness K, kN/m",
        yscale="log",
        title=f"K + B D$^μ$, B = 200 N/m · (100 rad/s)$^{{-μ}}$, 1 kHz, {number} devices",
    )
    figure.savefig(path, dpi=130)


def main() -> None:
    """Computes, draws, and prints the order that bears the stiffest wall for 99 % of the devices."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples", type=int, default=200, help="devices (default 200)")
    parser.add_argument(
        "--out", type=Path, default=Path(), help="folder of the store and of the figure (default: here)"
    )
    parser.add_argument("--orders", type=int, default=21, help="orders from 0 to 2 (default 21)")
    arguments = parser.parse_args()
    orders = np.linspace(0.0, 2.0, arguments.orders)
    started = time.perf_counter()
    result = robust_stability_map(
        orders,
        np.geomspace(500.0, 2e4, 40),
        DEVICES,
        dissipation=200.0 / 100.0**orders,
        sample_time=1e-3,
        number=arguments.samples,
        store=arguments.out / "robust-stability.zarr",
    )
    spent = time.perf_counter() - started
    draw(result, arguments.out / "robust-stability.png")
    sure = result["share"] >= 0.99
    stiffest = result["stiffness"].where(sure).max("stiffness")
    best = stiffest.fillna(0.0).argmax("order")
    print(f"{result['share'].size} walls on {arguments.samples} devices in {spent:.1f} s")
    print(f"failed points: {int((result['error'] != '').sum())}")
    print(
        f"99 % of the devices bear {float(stiffest[best]):.0f} N/m at order {float(result['order'][best]):.1f}"
        if bool(sure.any())
        else "no wall of this map is stable on 99 % of the devices"
    )


if __name__ == "__main__":
    main()
