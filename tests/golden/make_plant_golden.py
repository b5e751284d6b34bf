"""Writes plant.csv: the sampled plant (4.1) to 50 digits.

    python3 -m pip install mpmath && python3 make_plant_golden.py

Independent of the crate: the closed forms of the dissertation (its eq. 4.1) evaluated at a working
precision so high that their cancellation does not matter, never the divided differences that the
crate uses. delta and gamma are the doubles printed, taken as exact.
Columns: delta, gamma, n1, n0, pole_sum = c2 + c3, pole_product = exp(-delta), and
rest = 1 - (c2 + c3) + exp(-delta).
"""

import pathlib

import mpmath
from mpmath import mp, mpf

mp.dps = 400


def plant(delta, gamma):
    d, g = mpf(delta), mpf(gamma)
    e = mp.exp(-d)
    if g == 0:
        total = 1 + e
        if d == 0:
            return mpf(1) / 2, mpf(1) / 2, total, e, mpf(0)
        n1 = (d - 1 + e) / d**2
        n0 = (1 - e - d * e) / d**2
        return n1, n0, total, e, mpf(0)
    c1 = mp.sqrt(mp.mpc(d**2 - 4 * g))
    if c1 == 0:  # critically damped, exactly: double root s = d/2
        s = d / 2
        c = mp.exp(-s)
        n1 = (1 - c * (1 + s)) / g
        total = 2 * c
        rest = 1 - total + e
        return n1, rest / g - n1, total, e, rest
    c2 = mp.exp(-(d + c1) / 2)
    c3 = mp.exp(-(d - c1) / 2)
    n1 = ((2 - c2 - c3) * c1 + (c2 - c3) * d) / (2 * c1 * g)
    n0 = ((2 * e - c2 - c3) * c1 + (c3 - c2) * d) / (2 * c1 * g)
    total = mp.re(c2 + c3)
    return mp.re(n1), mp.re(n0), total, e, 1 - total + e


def cases():
    sizes = [1e-9, 1e-7, 1e-5, 1e-3, 0.01, 0.1, 0.5, 1.0, 2.0, 3.7, 10.0]
    yield 0.0, 0.0
    for s in sizes:
        yield s, 0.0  # no hand
        yield 0.0, s  # no damping
    for delta in sizes:
        for gamma in sizes:
            yield delta, gamma
        # delta^2 = 4 gamma exactly, and both sides of it
        critical = delta * delta / 4
        for gap in [0.0, 1e-15, 1e-12, 1e-8, 1e-4, 1e-2]:
            for side in [1, -1]:
                gamma = critical * (1 + side * gap)
                if 1e-9 <= gamma <= 10:
                    yield delta, gamma
    # gamma towards 0 below the range, with and without damping
    for gamma in [1e-12, 1e-18, 1e-100]:
        for delta in [0.0, 1e-9, 0.1, 10.0]:
            yield delta, gamma


def digits(x):
    return mpmath.nstr(x, 50, min_fixed=0, max_fixed=0)


rows = ["delta,gamma,n1,n0,pole_sum,pole_product,rest"]
for delta, gamma in dict.fromkeys(cases()):
    rows.append(",".join([repr(delta), repr(gamma)] + [digits(x) for x in plant(delta, gamma)]))
out = pathlib.Path(__file__).with_name("plant.csv")
out.write_text("\n".join(rows) + "\n")
print(f"{len(rows) - 1} cases, mpmath {mpmath.__version__}")
