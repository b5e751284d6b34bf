"""The least sums of squares that SciPy finds in motions of elastic and of stiffening tissue: python3 make_stiff_golden.py

Writes elastic.csv: records of tissue without memory whose stress is convex, sigma = E (exp(b e) - 1)/b with a wave of noise, under one
ramp, fitted by a spring-pot, whose least sum is at order 0 or near it; and stiff.csv: ramps and holds of a spring-pot that stiffens,
fitted by V, order and b together. The objective is that of haptic_tissue::identify: the sum of the squared errors of all stresses
but the first. Each is the best of 40 random starts of scipy.optimize.least_squares. The records are made from formulas, which the
tests have too; nothing is read.

Needs numpy, scipy. Deterministic: all random numbers are seeded.
"""

import csv
import pathlib

import numpy as np
from scipy.optimize import least_squares
from scipy.special import gamma

HERE = pathlib.Path(__file__).parent
STARTS = 40


def wave(n):
    """Errors of unit size that need no generator of random numbers."""
    k = np.arange(n)
    return np.sin(7.0 * k * k + 3.0 * k + 0.5)


def best(residual, low, high, scale_seed):
    random = np.random.default_rng(scale_seed)
    roots = []
    for _ in range(STARTS):
        start = low + random.random(len(low)) * (high - low)
        fit = least_squares(residual, start, bounds=(low, high), x_scale="jac", xtol=1e-12, ftol=1e-12, gtol=1e-12, max_nfev=400)
        roots.append((np.sqrt(np.mean(fit.fun**2)), *fit.x))
    roots.sort()
    near = sum(root[0] <= 1.001 * roots[0][0] for root in roots)
    return roots[0], near


def memory(times, knot_times, changes):
    """Sum of the changes of rate times (t - t_j)^(1 - a)/Gamma(2 - a), of a, at each time."""
    since = times[:, None] - knot_times[None, :]
    seen = since > 0.0
    ln_since = np.log(np.where(seen, since, 1.0))

    def at(order):
        return (np.where(seen, np.exp((1.0 - order) * ln_since), 0.0) @ changes) / gamma(2.0 - order)

    return at


def elastic():
    for b in (0.0, 2.0, 5.0, 10.0, 20.0, 40.0):
        for n in (30, 100, 300, 1000, 3000, 10000):
            for noise in (0.0, 0.003, 0.03):
                times = np.linspace(0.0, 10.0, n + 1)
                strain = 0.1 * times / 10.0
                seen = strain if b == 0.0 else np.expm1(b * strain) / b
                stress = 1e5 * seen
                stress = stress + noise * stress[-1] * wave(n + 1)
                stress[0] = 0.0
                yield b, n, noise, times, strain, stress


def write_elastic():
    rows = []
    for b, n, noise, times, strain, stress in elastic():
        # Two thousand samples are compared at most, as the fit does: all of the short ones.
        rest = slice(1, None)
        size = np.sqrt(np.mean(stress[rest] ** 2))
        rate = strain[-1] / times[-1]

        def residual(x):
            ramp = rate * times[rest] ** (1.0 - x[1]) / gamma(2.0 - x[1])
            return (np.exp(x[0]) * ramp - stress[rest]) / size

        middle = np.log(1e5)
        (root, ln_v, order), near = best(residual, np.array([middle - 7.0, 0.0]), np.array([middle + 7.0, 1.0]), n)
        rows.append([b, n, noise, f"{root * size:.9e}", f"{np.exp(ln_v):.6e}", f"{order:.6f}", near])
        print(*rows[-1], flush=True)
    with open(HERE / "elastic.csv", "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["b", "samples", "noise", "rms_pa", "viscosity_pa_s_alpha", "order", "starts_within_a_thousandth"])
        out.writerows(rows)


def stiff():
    for order in (0.05, 0.2, 0.45):
        for b in (4.0, 9.0, 18.0, 30.0):
            for noise in (0.001, 0.01):
                n = 150
                times = np.linspace(0.0, 15.0, n + 1)
                strain = 0.15 * np.minimum(times / 3.0, 1.0)
                fine = np.linspace(0.0, 3.0, 1201)
                at = ramp(times, fine, order, b)
                stress = 2000.0 * at
                stress = stress + noise * stress.max() * wave(n + 1)
                stress[0] = 0.0
                yield order, b, noise, times, strain, stress, fine


def ramp(times, fine, order, b):
    """Stress of V = 1 under a strain of 0.05 in a second, for 3 s, then held; straight between the fine times."""
    seen = np.expm1(b * 0.05 * fine) / b
    rates = np.diff(seen) / np.diff(fine)
    changes = np.diff(np.concatenate([[0.0], rates, [0.0]]))
    return memory(times, fine, changes)(order)


def write_stiff():
    rows = []
    for order, b, noise, times, strain, stress, fine in stiff():
        rest = slice(1, None)
        size = np.sqrt(np.mean(stress[rest] ** 2))
        since = times[rest][:, None] - fine[None, :]
        inside = since > 0.0
        ln_since = np.log(np.where(inside, since, 1.0))

        def residual(x):
            seen = np.expm1(x[2] * 0.05 * fine) / x[2]
            rates = np.diff(seen) / np.diff(fine)
            changes = np.diff(np.concatenate([[0.0], rates, [0.0]]))
            powers = np.where(inside, np.exp((1.0 - x[1]) * ln_since), 0.0)
            return (np.exp(x[0]) * (powers @ changes) / gamma(2.0 - x[1]) - stress[rest]) / size

        low, high = np.array([np.log(2000.0) - 5.0, 0.0, 0.1]), np.array([np.log(2000.0) + 5.0, 0.98, 100.0])
        (root, ln_v, found, steep), near = best(residual, low, high, int(100 * order + b))
        rows.append([order, b, noise, f"{root * size:.9e}", f"{np.exp(ln_v):.6e}", f"{found:.6f}", f"{steep:.6f}", near])
        print(*rows[-1], flush=True)
    with open(HERE / "stiff.csv", "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["true_order", "true_b", "noise", "rms_pa", "viscosity_pa_s_alpha", "order", "b", "starts_within_a_thousandth"])
        out.writerows(rows)


if __name__ == "__main__":
    write_elastic()
    write_stiff()
