#!/usr/bin/env python3
"""Makes the golden vectors beside this script and the weights of fracdiff, with 50 digits in mpmath.

    pip install mpmath==1.3.0 && python3 tests/golden/make_golden.py

Written once (2026-11-20); the tests read the CSV files and do not need Python.
"""
import csv
import pathlib

from mpmath import mp, mpf, gamma, quad, exp, inf, sin, cos, pi, nsum, rgamma

mp.dps = 50
HERE = pathlib.Path(__file__).parent


def write(name, header, rows):
    with open(HERE / name, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)
    print(name, len(rows), "rows")


def text(x):
    return mp.nstr(x, 20, min_fixed=0, max_fixed=0)


# E_α(−z): by its integral for z > 0, 0 < α < 1 (Gorenflo, Mainardi 1997), checked by the series
# where that converges well.
def mittag_leffler(a, z):
    # With y = z·r^α the integrand has no singular end.
    kernel = lambda y: exp(-(y ** (1 / a))) / ((y / z) ** 2 + 2 * (y / z) * cos(pi * a) + 1)
    value = quad(kernel, [0, 0.1, 0.5, 1, 1.5, 2, 3, 5, 10, 20, inf]) * sin(pi * a) / (pi * a * z)
    if z <= 2:
        series = nsum(lambda k: (-z) ** k * rgamma(a * k + 1), [0, inf])
        assert abs(value - series) < mpf("1e-15"), (a, z, value, series)
    return value


rows = []
for alpha in ["0.2154", "0.2247", "0.5", "0.9"]:
    for z in ["0.001", "0.1", "1", "2", "10", "100", "10000"]:
        rows.append([alpha, z, mp.nstr(mittag_leffler(mpf(alpha), mpf(z)), 16)])
write("mittag_leffler.csv", ["alpha", "minus_z", "value"], rows)


# Force of the cancerous prostate (E₀ = 0) in ramp and hold: theory.md 9. A σ = A η r [...]/Γ(2−α).
eta, alpha = mpf(8650), mpf("0.2247")
strain, ramp_s = mpf("0.05"), mpf(1)
rows = []
for t in ["0.001", "0.01", "0.1", "0.5", "1", "1.001", "1.1", "2", "10", "100", "200"]:
    x = mpf(t)
    grown = x ** (1 - alpha) - (max(x - ramp_s, mpf(0)) ** (1 - alpha) if x > ramp_s else 0)
    rows.append([t, text(eta * strain / ramp_s * grown / gamma(2 - alpha))])
write("relaxation_stress_pa.csv", ["time_s", "stress_pa"], rows)


# Grünwald weights Γ(j−μ)/(Γ(−μ)Γ(j+1)) and piecewise-linear weights, second differences of
# j^(1−μ) over Γ(2−μ). Lags up to 24 h at 1 kHz.
LAGS = [0, 1, 2, 3, 5, 8, 15, 16, 31, 32, 33, 64, 100, 1000, 12345, 200000, 7654321, 86400000]
rows = []
for order in ["-1.95", "-1.5", "-0.95", "-0.5", "-0.05", "0.05", "0.2154", "0.2247", "0.5", "0.9",
              "0.95", "1.5", "1.99"]:
    mu = mpf(order)
    for j in LAGS:
        rows.append(["grunwald", order, j, text(gamma(j - mu) * rgamma(-mu) / gamma(j + 1))])
    if mu < 1:
        for j in LAGS:
            p = 1 - mu
            power = lambda x: mpf(x) ** p if x > 0 else mpf(0)
            value = (power(j + 1) - 2 * power(j) + power(j - 1)) / gamma(2 - mu)
            rows.append(["piecewise-linear", order, j, text(value)])
write("../../crates/fracdiff/tests/golden/weights.csv", ["kernel", "order", "lag", "weight"], rows)
