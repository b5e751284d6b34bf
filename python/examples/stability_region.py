"""All stable walls on a device, and one of them beside python-control's margins.

::

    python stability_region.py [FIGURE.png]
"""

import math
import sys

import control
import numpy as np

from fractional_haptics.analysis import Device, Loop, Port, region

T = 1e-3
device = Device(mass_kg=0.065, damping_n_s_per_m=3.5, delay_s=0.3e-3, current_lag_s=0.5e-3)

# 1 Regions for the operator as it is written, and as two schemes make it.
schemes = ("exact", "full", "grunwald:20")
regions = {scheme: region(device, 0.5, T, scheme, 1000) for scheme in schemes}
for scheme, found in regions.items():
    print(f"{scheme:12} K up to {found.stiffness_max_n_per_m:7.0f} N/m, B up to {found.dissipation_max_n_s_mu_per_m:.1f}")

# 2 A wall at half of the largest stiffness: stable, with which margin? Passive?
stiffness = 0.5 * regions["full"].stiffness_max_n_per_m
dissipation = regions["full"].dissipation_at_stiffness_max_n_s_mu_per_m
loop = Loop(device, stiffness, dissipation, 0.5, T, "full")
margins = loop.margins()
required = Port(0.5, T, "full", delay_s=0.3e-3, current_lag_s=0.5e-3).required_damping(stiffness, dissipation)
print(f"K = {stiffness:.0f} N/m is stable: {loop.verdict().stable}; it may grow {margins.gain_up.value:.2f} times")
print(f"passive with more than {required:.1f} N·s/m; the device has 3.5")

# 3 The same margins by python-control, from the frequency response.
data = loop.to_control(np.geomspace(1.0, math.pi / T, 5000))
gain, *_ = control.stability_margins(data)
print(f"python-control says {gain:.2f} times")
assert math.isclose(gain, margins.gain_up.value, rel_tol=1e-2)

# 4 The picture, if one is asked for.
if len(sys.argv) > 1:
    import matplotlib.pyplot as plt

    from fractional_haptics import plot

    with plt.rc_context(plot.STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
        plot.regions(regions, left)
        response = np.squeeze(data.complex)
        right.loglog(data.omega, np.abs(response), label="loop gain")
        right.loglog(data.omega, loop.sensitivity(data.omega), label="sensitivity")
        right.set(xlabel="angular frequency / (rad/s)", ylabel="magnitude")
        right.legend()
        figure.savefig(sys.argv[1])
