"""An own tissue end to end: record, model, tissue file, and the force that a haptic loop renders.

::

    python own_tissue.py [FOLDER]
"""

import sys
import tempfile
from pathlib import Path

import numpy as np

from fractional_haptics import experiment, tissue

folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(tempfile.mkdtemp())

# 1 A record, as a rheometer gives it: a gel that relaxes, with 1 % of noise. Here it is made up.
gel = tissue.Model("fractional-zener", viscosity_pa_s_alpha=3e3, order=0.6, second_viscosity_pa_s_beta=8e3,
                   second_order=0.15, elastic_modulus_pa=500.0)  # fmt: skip
time_s = np.geomspace(0.01, 300.0, 200)
noise = np.random.default_rng(7).standard_normal(time_s.size)
modulus_pa = gel.relaxation_modulus(time_s) * np.exp(0.01 * noise)

# 2 Which model does the record ask for, and how sure is each parameter?
found = tissue.identify(time_s, modulus_pa)
for fit in found.fits:
    print(f"{fit.kind:30} rms {fit.rms:.4f}  BIC {fit.bic:.0f}")
for estimate in found.best.estimates:
    print(f"  {estimate.name:28} {estimate.value:10.4g} {estimate.unit}  ± {estimate.standard_error}")
for warning in found.warnings:
    print("  note:", warning)
assert found.best.rms < 0.012

# 3 A tissue file, which host-cli takes too.
residual = f"rms {found.best.rms:.4f} in log modulus"
source = {"citation": "made up", "conditions": "none", "checked": True, "residual": residual}
own = tissue.Material("my-gel", "a gel", found.best.model, source, {"time_from_s": 0.01, "time_to_s": 300.0})
file = folder / "my-gel.toml"
file.write_text(own.to_toml())

# 4 The loop renders it, and its force is held against the closed form.
run = experiment.relax(tissue=str(file), duration_s=5.0, ramp_time_s=0.5)
late = run["time_s"] > 1.0
error = np.max(np.abs(run["simulated_force_n"][late] / run["closed_form_force_n"][late] - 1))
print(f"{len(run['time_s'])} samples, largest force {run.report['peak_force_n']:.3f} N, off by {100 * error:.2f} %")
assert error < 0.02
