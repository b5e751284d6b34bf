#!/usr/bin/env python3
"""Golden values of plants with powers of brackets and diffusion: step responses by numerical inversion of the Laplace transform.

    python3 -m venv venv && venv/bin/pip install mpmath==1.3.0
    venv/bin/python make_implicit.py

Talbot's contour with 60 digits and two numbers of nodes, which must agree to 1e-14. Writes implicit.csv (plant, t, y).
"""
import csv
from pathlib import Path

from mpmath import exp, invertlaplace, mp, mpf, sqrt

PLANTS = {
    "1.5/(0.2s+1)^0.6": lambda s: mpf("1.5") / (s / 5 + 1) ** mpf("0.6"),
    "1/(s+1)^0.05": lambda s: 1 / (s + 1) ** mpf("0.05"),
    "1/(s+1)^0.97": lambda s: 1 / (s + 1) ** mpf("0.97"),
    "((s+1)/(s+2))^0.5": lambda s: ((s + 1) / (s + 2)) ** mpf("0.5"),
    "(s+3)^0.3/(s+1)^0.7": lambda s: (s + 3) ** mpf("0.3") / (s + 1) ** mpf("0.7"),
    "1/((s+1)^0.4*(100s+1)^0.3)": lambda s: 1 / ((s + 1) ** mpf("0.4") * (100 * s + 1) ** mpf("0.3")),
    "exp(-sqrt(3s))": lambda s: exp(-sqrt(3 * s)),
    "exp(-2sqrt(s+0.5))": lambda s: exp(-2 * sqrt(s + mpf("0.5"))),
    "exp(-sqrt(40s))/(s+1)^0.5": lambda s: exp(-sqrt(40 * s)) / sqrt(s + 1),
    "exp(-sqrt(s))*exp(-sqrt(s+1))/(0.1s+1)^0.2": lambda s: exp(-sqrt(s) - sqrt(s + 1)) / (s / 10 + 1) ** mpf("0.2"),
    # Cuts that begin far from each other.
    "9*exp(-sqrt(2s))/((50s+1)^0.4*(0.00001s+1)^0.8)": lambda s: 9 * exp(-sqrt(2 * s))
    / ((50 * s + 1) ** mpf("0.4") * (s / 100000 + 1) ** mpf("0.8")),
    "exp(-sqrt(3s))/(s+1)": lambda s: exp(-sqrt(3 * s)) / (s + 1),
    "2/(s+1)^1.5": lambda s: 2 / (s + 1) ** mpf("1.5"),
    "(s+2)^0.5/(s^1.5+s+1)": lambda s: sqrt(s + 2) / (s ** mpf("1.5") + s + 1),
}


def step(plant, t):
    values = [invertlaplace(lambda s: plant(s) / s, t, method="talbot", degree=degree) for degree in (60, 80)]
    assert abs(values[0] - values[1]) < mpf(10) ** -14, (t, values)
    return values[1]


mp.dps = 60
with (Path(__file__).parent / "implicit.csv").open("w", newline="") as file:
    table = csv.writer(file, lineterminator="\n")
    for text, plant in PLANTS.items():
        for t in ("0.05", "0.5", "2", "10", "100"):
            table.writerow([text, t, mp.nstr(step(plant, mpf(t)), 17)])
