#!/usr/bin/env python3
"""Writes roots.csv beside this script: 2000 polynomials and their roots, with 60 digits in mpmath.

    pip install mpmath==1.3.0 && python3 crates/fracdiff/tests/golden/make_roots_golden.py

Columns: the coefficients, of z^0 first, numbers of f64; and sum(cos(3*ln|z| + |arg z|)) over the roots that are not 0, in which each of
them shows relative to its own size. Cyclic polynomials (z^n + c, their powers and products) stand first, then random ones up to degree 12.
"""
import itertools
import pathlib
import random

from mpmath import mp, mpf

mp.dps = 60
CASES = 2000
random.seed(31)


def product(a, b):
    out = [0] * (len(a) + len(b) - 1)
    for (i, x), (j, y) in itertools.product(enumerate(a), enumerate(b)):
        out[i + j] += x * y
    return out


def roots(coefficients):
    used = coefficients[next(k for k, c in enumerate(coefficients) if c):]
    return mp.polyroots([mpf(c) for c in reversed(used)], maxsteps=2000, extraprec=400) if len(used) > 1 else []


def row(factors):
    """Of factors and how often each stands; None where mpmath does not find their roots."""
    whole, total, degree = [1], mpf(0), 0
    for factor, times in factors:
        for _ in range(times):
            whole = product(whole, factor)
        try:
            found = roots(factor)
        except mp.NoConvergence:
            return None
        total += times * sum(mp.cos(3 * mp.log(abs(z)) + abs(mp.arg(z))) for z in found)
    assert all(float(c) == c for c in whole)
    text = " ".join(repr(float(c)).removesuffix(".0") for c in whole)
    return f"{text},{mp.nstr(total, 12)}"


def cyclic(n, c):
    return [c] + [0] * (n - 1) + [1]


rows = [row([(cyclic(n, c), 1)]) for n in range(1, 13) for c in (1, -1, 3)]
rows += [row([(cyclic(n, c), 2)]) for n in range(1, 7) for c in (1, -1, 3)]
rows += [row([(cyclic(n, 1), 1), ([0, 1], 12 - n)]) for n in range(3, 12)]
rows += [row([(cyclic(n, 1), 1), (cyclic(m, 2), 1)]) for n in range(2, 7) for m in range(2, 7)]
while len(rows) < CASES:
    degree = random.randint(1, 12)
    spread = random.choice((0, 0, 0, 1, 6))
    kept = random.choice((1.0, 0.5))
    coefficients = [random.randint(-9, 9) if random.random() < kept else 0 for _ in range(degree)] + [random.randint(1, 9)]
    coefficients = [float(f"{c}e{random.randint(-spread, spread)}") if spread else c for c in coefficients]
    if any(coefficients[:-1]):
        rows.append(row([(coefficients, 1)]))
    rows = [found for found in rows if found]
with open(pathlib.Path(__file__).parent / "roots.csv", "w", newline="\n") as file:
    file.write("coefficients,witness\n" + "\n".join(rows) + "\n")
