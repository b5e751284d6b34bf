#!/usr/bin/env python3
"""Makes weights.csv beside this script, with 50 digits in mpmath.

    pip install mpmath==1.3.0 && python3 make_weights_golden.py

Written once (2026-11-20); the tests read the CSV file and do not need Python.
"""
import csv
import pathlib

from mpmath import mp, mpf, gamma, rgamma

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
write("weights.csv", ["kernel", "order", "lag", "weight"], rows)
