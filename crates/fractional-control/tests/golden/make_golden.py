#!/usr/bin/env python3
"""Golden values of fractional transfer functions: step responses by numerical inversion of the Laplace transform.

    python3 -m venv venv && venv/bin/pip install mpmath==1.4.1
    venv/bin/python make_golden.py

Talbot's contour with 70 digits. Each value is computed with two numbers of nodes, which must agree to 1e-12.
Writes podlubny.csv (function, t, y) and random.csv (function, t, y; 200 stable functions, orders up to 3).
"""
import csv
import random
from pathlib import Path

from mpmath import arg, exp, invertlaplace, mp, mpc, mpf, pi

HERE = Path(__file__).parent
TIMES = [0.5, 1.0, 2.0, 4.0, 8.0]


def value(terms, s):
    return sum(mpf(str(c)) * s ** mpf(str(order)) for c, order in terms)


def text(terms):
    parts = []
    for c, order in terms:
        power = "" if order == 0 else "s" if order == 1 else f"s^{order}"
        parts.append(f"{c}{power}")
    return "+".join(parts)


def step(above, below, t):
    def transform(s):
        return value(above, s) / value(below, s) / s

    mp.dps = 70
    values = [invertlaplace(transform, mpf(str(t)), method="talbot", degree=n) for n in (100, 140)]
    assert abs(values[0] - values[1]) < mpf("1e-12"), (text(above), text(below), t, values)
    return values[1]


def unstable_poles(below):
    """By the turn of the denominator along the imaginary axis, finely sampled."""
    mp.dps = 20
    turn, last = mpf(0), None
    for k in range(-1500, 1501):
        here = value(below, mpc(0, exp(mpf(k) / 100)))
        if last is not None:
            turn += arg(here / last)
        last = here
    return round(float((pi / 2 * mpf(str(below[0][1])) - turn) / pi))


def randoms():
    draw = random.Random(20261120)
    found = []
    while len(found) < 200:
        count = draw.choice([2, 3, 3, 4])
        highest = round(draw.uniform(0.4, 3.0), 2)
        orders = {highest, 0}
        while len(orders) < count:
            orders.add(round(draw.uniform(0.1, highest - 0.1), draw.choice([1, 2])))
        orders = sorted(orders, reverse=True)
        if any(a - b < 0.099 for a, b in zip(orders, orders[1:])):
            continue
        below = [(round(draw.uniform(0.3, 3.0), 3), order) for order in orders]
        above = [(round(draw.uniform(0.3, 3.0), 3), 0)]
        if draw.random() < 0.4 and highest > 0.8:
            above.insert(0, (round(draw.uniform(0.1, 1.0), 3), round(draw.uniform(0.1, highest - 0.5), 2)))
        if unstable_poles(below) == 0:
            found.append((above, below))
    return found


def write(name, functions, times):
    with open(HERE / name, "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["function", "t_s", "y"])
        for above, below in functions:
            for t in times:
                y = step(above, below, t)
                out.writerow([f"({text(above)})/({text(below)})", t, mp.nstr(y, 15)])


PLANT = [(0.8, 2.2), (0.5, 0.9), (1, 0)]
CONTROLLER = [(3.7343, 1.15), (20.5, 0)]
CLOSED = [(0.8, 2.2), (3.7343, 1.15), (0.5, 0.9), (21.5, 0)]

if __name__ == "__main__":
    times = [round(0.25 * k, 2) for k in range(1, 41)]
    write("podlubny.csv", [([(1, 0)], PLANT), (CONTROLLER, CLOSED)], times)
    write("random.csv", randoms(), TIMES)
