"""Records and the best fits that SciPy finds for them: python3 make_golden.py [RECORD…]

Writes RECORD.csv for synthetic records and best.csv: the least root of the mean square over 40 random starts of
scipy.optimize.least_squares for each record and model. The residual is that of haptic_tissue::identify: ln model - ln record.
Relaxation modulus and creep compliance come from M(s) by mpmath where the script checks itself, and by the same contour in
double precision (checked to 1e-9 against mpmath below) where it fits.

Needs numpy, scipy, mpmath. Deterministic: all random numbers are seeded.
"""

import csv
import pathlib
import sys
import time

import mpmath
import numpy as np
from scipy.optimize import least_squares

HERE = pathlib.Path(__file__).parent
FISH = HERE / "../../records/fish-muscle-relaxation.tsv"
MODELS = {
    "spring-pot": 2,
    "fractional-kelvin-voigt": 4,
    "fractional-maxwell": 4,
    "fractional-zener": 5,
    "fractional-poynting-thomson": 5,
}
STARTS = 40

N = 32
theta = (2 * np.arange(N // 2) + 1) * np.pi / N
cot = 1 / np.tan(0.6407 * theta)
Z = N * (0.5017 * theta * cot - 0.6122 + 0.2645j * theta)
DZ = N * (0.5017 * (cot - 0.6407 * theta * (1 + cot**2)) + 0.2645j)
C = 2 * np.exp(Z) * DZ / (1j * N) / Z


def modulus(model, x, ln_s, exp=np.exp):
    """M(s) of parameters ln V, alpha, ln G, beta, ln E."""
    e1 = exp(x[0] + x[1] * ln_s)
    if model == "spring-pot":
        return e1
    e2 = exp(x[2] + x[3] * ln_s)
    if model == "fractional-kelvin-voigt":
        return e1 + e2
    if model == "fractional-maxwell":
        return e1 * e2 / (e1 + e2)
    if model == "fractional-zener":
        return e1 * e2 / (e1 + e2) + exp(x[4])
    return (e1 + e2) * exp(x[4]) / (e1 + e2 + exp(x[4]))


def in_time(kind, model, x, t):
    ln_s = np.log(Z)[:, None] - np.log(t)[None, :]
    m = modulus(model, x, ln_s)
    return (C[:, None] * (m if kind == "relaxation" else 1 / m)).sum(axis=0).real


def ln_model(kind, model, x, axis):
    with np.errstate(all="ignore"):
        if kind == "oscillation":
            m = modulus(model, x, np.log(axis) + 0.5j * np.pi)
            both = np.concatenate([m.real, m.imag])
        else:
            both = in_time(kind, model, x, axis)
        return np.log(np.maximum(both, 1e-300))


def check():
    """The contour against mpmath's inversion of the Laplace transform with 40 digits."""
    mpmath.mp.dps = 40
    x = [np.log(876e3), 0.675, np.log(22.1e3), 0.11, np.log(900.0)]
    worst = 0.0
    for model in MODELS:
        for kind in ("relaxation", "creep"):
            for t in (1e-2, 1.0, 1e3):
                exact = [mpmath.mpf(v) for v in x]
                def transform(s):
                    m = modulus(model, exact, mpmath.log(s), mpmath.exp)
                    return m / s if kind == "relaxation" else 1 / (m * s)
                want = float(mpmath.invertlaplace(transform, t, method="talbot", degree=60))
                have = in_time(kind, model, x, np.array([t]))[0]
                worst = max(worst, abs(have / want - 1))
    print(f"contour against mpmath: {worst:.1e}")
    assert worst < 1e-9


SYNTHETIC = {
    # kind, model, ln V, alpha, ln G, beta, ln E; axis; noise
    "maxwell-creep": ("creep", "fractional-maxwell", [np.log(5e4), 0.7, np.log(8e3), 0.15], np.logspace(-2, 3, 60), 0.01),
    "zener-relaxation": ("relaxation", "fractional-zener", [np.log(2e4), 0.8, np.log(1e4), 0.1, np.log(1.5e3)], np.logspace(-2, 3, 80), 0.02),
    "poynting-thomson-creep": ("creep", "fractional-poynting-thomson", [np.log(3e3), 0.6, np.log(1e3), 0.1, np.log(2e4)], np.logspace(-3, 3, 80), 0.01),
    "kelvin-voigt-oscillation": ("oscillation", "fractional-kelvin-voigt", [np.log(200.0), 0.7, np.log(2e3), 0.1], np.logspace(-2, 2, 40), 0.01),
    "zener-oscillation": ("oscillation", "fractional-zener", [np.log(2e4), 0.9, np.log(1e4), 0.2, np.log(8e2)], np.logspace(-3, 3, 50), 0.01),
}
MEASURED = {"fish-muscle": "relaxation", "chia": "oscillation", "perihepatic": "creep"}
HEADERS = {
    "relaxation": ["time_s", "relaxation_modulus_pa"],
    "creep": ["time_s", "creep_compliance_per_pa"],
    "oscillation": ["omega_rad_s", "storage_modulus_pa", "loss_modulus_pa"],
}


def make(name):
    kind, model, x, axis, noise = SYNTHETIC[name]
    random = np.random.default_rng(sum(map(ord, name)))
    values = np.exp(ln_model(kind, model, x, axis) + noise * random.standard_normal(len(axis) * (2 if kind == "oscillation" else 1)))
    columns = [axis, *np.split(values, 2 if kind == "oscillation" else 1)]
    with open(HERE / f"{name}.csv", "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(HEADERS[kind])
        out.writerows([f"{v:.8g}" for v in row] for row in zip(*columns))


def read(name):
    path, delimiter = (FISH, "\t") if name == "fish-muscle" else (HERE / f"{name}.csv", ",")
    table = np.genfromtxt(path, delimiter=delimiter, skip_header=1)
    return table[:, 0], np.log(np.concatenate(table[:, 1:].T))


def best(kind, model, axis, wanted, starts=STARTS, seed=1, residual=None):
    """The least rms over random starts; of another residual than that of a record of a kind if one is given."""
    residual = residual or (lambda x: ln_model(kind, model, x, axis) - wanted)
    random = np.random.default_rng(seed)
    sign = -1.0 if kind == "creep" else 1.0
    middle = sign * 0.5 * (wanted.min() + wanted.max())
    span = wanted.max() - wanted.min()
    low = np.tile([-60.0, 0.0], 3)[: MODELS[model]]
    high = np.tile([60.0, 1.0], 3)[: MODELS[model]]
    roots = []
    for _ in range(starts):
        start = np.empty(MODELS[model])
        start[0::2] = middle + (random.random(len(start[0::2])) - 0.5) * (span + 6.0)
        start[1::2] = random.uniform(0.02, 0.98, len(start[1::2]))
        fit = least_squares(residual, start, bounds=(low, high), x_scale="jac", max_nfev=300)
        roots.append(np.sqrt(np.mean(fit.fun**2)))
    return np.array(roots)


def main():
    check()
    names = sys.argv[1:] or [*SYNTHETIC, *MEASURED]
    rows = []
    for name in names:
        if name in SYNTHETIC:
            make(name)
        kind = SYNTHETIC[name][0] if name in SYNTHETIC else MEASURED[name]
        axis, wanted = read(name)
        for model in MODELS:
            began = time.time()
            roots = best(kind, model, axis, wanted)
            near = int((roots <= 1.01 * roots.min()).sum())
            rows.append([name, kind, model, f"{roots.min():.6e}", near])
            print(*rows[-1], f"{time.time() - began:.1f} s", flush=True)
    with open(HERE / "best.csv", "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["record", "kind", "model", "rms", "starts_within_1_percent"])
        out.writerows(rows)


if __name__ == "__main__":
    main()
