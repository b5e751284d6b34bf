#!/usr/bin/env python3
"""Makes coupling.csv beside this script: the least device damping of a coupled port, 50 digits in mpmath.

    pip install mpmath==1.3.0 && python3 tests/golden/make_coupling_golden.py

b = sup over θ of cos(θ/2)(1 − cos(θ/2))/(2 Re(1/Z_c)), Z_c = k_c + b_c·T^μ/P(w), from the definitions,
with complex arithmetic and no closed form. Written once (2026-11-20); the tests read the CSV file and do not
need Python.
"""
import csv
import pathlib

from mpmath import mp, mpf, mpc, cos, exp, pi, power, linspace

mp.dps = 90  # near θ = 1e-20 Re P may lose 40 digits
HERE = pathlib.Path(__file__).parent


def exact(mu, w):
    return power(1 - w, mu)


def muir3(mu, w):
    return 1 - mu * w + mu**2 / 3 * w**2 - mu / 3 * w**3


def grunwald(length):
    def operator(mu, w):
        total, weight, factor = mpc(0), mpf(1), mpc(1)
        for j in range(length):
            total += weight * factor
            factor *= w
            weight *= 1 - (mu + 1) / (j + 1)
        return total

    return operator


OPERATORS = {"exact": exact, "muir:3": muir3, "grunwald:20": grunwald(20)}

GRID = [mpf(10) ** (mpf(i) / 4) for i in range(-80, -6)]
GRID += list(linspace(mpf(10) ** mpf("-1.5"), pi, 1200))


def least(operator, mu, k, b, t):
    def damping(theta):
        w = exp(mpc(0, -theta))
        z = k + b * t**mu / OPERATORS[operator](mu, w)
        re = (1 / z).real
        assert re > 0, (operator, mu, theta)
        return cos(theta / 2) * (1 - cos(theta / 2)) / (2 * re)

    values = [damping(theta) for theta in GRID]
    best = max(range(len(GRID)), key=lambda i: values[i])
    low, high = GRID[max(best - 1, 0)], GRID[min(best + 1, len(GRID) - 1)]
    ratio = (mp.sqrt(5) - 1) / 2
    for _ in range(140):
        c, d = high - ratio * (high - low), low + ratio * (high - low)
        low, high = (low, d) if damping(c) > damping(d) else (c, high)
    theta = (low + high) / 2
    return max(damping(theta), values[best]), theta if best else mpf(0)


CASES = [  # operator, μ, k_c, b_c, T
    ("exact", "0", "2", "3", "0.001"),
    ("exact", "0.1", "0", "1", "0.001"),
    ("exact", "0.25", "0", "7", "0.002"),
    ("exact", "0.25", "5", "7", "0.002"),
    ("exact", "0.5", "0", "10", "0.001"),
    ("exact", "0.5", "0.01", "10", "0.001"),
    ("exact", "0.5", "1", "10", "0.001"),
    ("exact", "0.75", "0", "100", "0.001"),
    ("exact", "0.75", "0.3", "100", "0.001"),
    ("exact", "0.9", "0", "500", "0.0005"),
    ("exact", "0.99", "0", "1000", "0.001"),
    ("exact", "0.9999", "0", "1000", "0.001"),
    ("exact", "0.9999", "0.02", "1000", "0.001"),
    ("exact", "1", "0", "1000", "0.001"),
    ("exact", "1", "0.1", "1000", "0.001"),
    ("exact", "1", "2", "1000", "0.001"),
    ("exact", "1", "50", "1000", "0.001"),
    ("exact", "1.5", "3", "0", "0.001"),
    ("muir:3", "0.25", "0", "7", "0.002"),
    ("muir:3", "0.5", "1", "10", "0.001"),
    ("muir:3", "0.75", "0", "100", "0.001"),
    ("muir:3", "0.75", "0.3", "100", "0.001"),
    ("muir:3", "0.99", "0", "1000", "0.001"),
    ("muir:3", "1", "0", "1000", "0.001"),
    ("muir:3", "1", "0.1", "1000", "0.001"),
    ("grunwald:20", "0.25", "0", "7", "0.002"),
    ("grunwald:20", "0.5", "1", "10", "0.001"),
    ("grunwald:20", "0.75", "0", "100", "0.001"),
    ("grunwald:20", "0.95", "0.05", "1000", "0.001"),
    ("grunwald:20", "1", "0", "1000", "0.001"),
    ("grunwald:20", "1", "2", "1000", "0.001"),
]

with open(HERE / "coupling.csv", "w", newline="") as file:
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(["operator", "order", "stiffness", "dissipation", "sample_time_s", "least_damping",
                     "worst_theta"])
    for operator, *numbers in CASES:
        value, theta = least(operator, *map(mpf, numbers))
        text = [mp.nstr(x, 20, min_fixed=0, max_fixed=0) for x in (value, theta)]
        writer.writerow([operator, *numbers, *text])
        print(operator, numbers, *text, flush=True)
