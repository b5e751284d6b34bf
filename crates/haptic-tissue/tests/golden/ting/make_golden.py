#!/usr/bin/env python3
"""Makes ting.csv beside this script, in mpmath.

    pip install mpmath==1.3.0 && python3 make_golden.py

Written once (2026-11-23); the tests read the CSV file and do not need Python. An indenter goes in for 1 s, 1 mm deep, and out
at twice that speed. Ting's integrals as they stand: t1 by a root of the integral of M in closed form, the force by Gauss
quadrature of M(t − τ) e'(δ(τ)) δ'(τ); the force on the way in likewise. The tests compute both from straight pieces.
"""
import csv
import pathlib

from mpmath import mp, mpf, rgamma, exp, sqrt, quad, findroot

mp.dps = 30
HERE = pathlib.Path(__file__).parent
DEPTH, IN, OUT = mpf("1e-3"), mpf(1), mpf("0.5")
SPEED, BACK = DEPTH / IN, DEPTH / OUT


def mittag_leffler(a, b, z):
    """E_{a,b}(z) by its power series, |z| of some 1."""
    total, k = mpf(0), 0
    while True:
        term = z**k * rgamma(a * k + b)
        total += term
        k += 1
        if k > 4 and abs(term) < mpf(10) ** -28:
            return total


def spring_pot(t, n):
    """n-fold integral of V t^(-a)/Gamma(1-a)."""
    v, a = mpf(1000), mpf("0.25")
    return v * t ** (n - a) * rgamma(1 + n - a)


def zener(t, n):
    """E and a Maxwell branch of 2000 Pa and 0.2 s."""
    e, g, tau = mpf(500), mpf(2000), mpf(400) / 2000
    return [e + g * exp(-t / tau), e * t + g * tau * (1 - exp(-t / tau))][n]


def fractional_zener(t, n):
    """E beside V s^a and G s^b in series."""
    v, a, g, b, e = mpf(1500), mpf("0.7"), mpf(3000), mpf("0.15"), mpf(400)
    x = a - b
    own = g * t ** (n - b) * mittag_leffler(x, 1 - b + n, -(g / v) * t**x)
    return own + e * [mpf(1), t][n]


MODELS = {"spring-pot": spring_pot, "zener": zener, "fractional-zener": fractional_zener}

R, H, MM = mpf("4e-3"), mpf("3e-3"), mpf("1e-3")
LAYER = [mpf(x) for x in ("1", "1.133", "1.283", "0.769", "0.0975")]


def layer(d):
    """e' of a sphere on a bonded layer; the coefficients of Dimitriadis and others."""
    chi = [(sqrt(R * d) / H) ** n for n in range(5)]
    return sqrt(d / R) * sum(c * (mpf(3) + n) / 2 * x for n, (c, x) in enumerate(zip(LAYER, chi)))


# e' by the depth.
MAPS = {
    "punch": lambda d: mpf(1),
    "sphere": lambda d: mpf(3) / 2 * sqrt(d / R),
    "cone": lambda d: 2 * d / MM,
    "layer": layer,
}


def force(modulus, slope, t):
    """F over the shape, Pa m, at a time."""
    end = t
    if t > IN:
        rest = BACK * modulus(t - IN, 1)

        def left(t1):
            return SPEED * (modulus(t - t1, 1) - modulus(t - IN, 1)) - rest

        if left(mpf(0)) <= 0:
            return mpf(0)
        end = findroot(left, (mpf(0), IN), solver="anderson", tol=1e-40)
        if slope is MAPS["punch"]:
            # F = ∫ M dδ over the whole motion: of t1 it has no need.
            direct = SPEED * (modulus(t, 1) - modulus(t - IN, 1)) - rest
            ours = SPEED * (modulus(t, 1) - modulus(t - end, 1))
            assert abs(direct - ours) < mpf(10) ** -20
    # Both ends may be singular: each half goes with the fourth power of y from its own.
    half = end / 2

    def near_start(y):
        tau = half * y**4
        return modulus(t - tau, 0) * slope(SPEED * tau) * SPEED * half * 4 * y**3

    def near_end(y):
        before = half * y**4
        return modulus(t - end + before, 0) * slope(SPEED * (end - before)) * SPEED * half * 4 * y**3

    return quad(near_start, [0, 1]) + quad(near_end, [0, 1])


rows = []
for model, modulus in MODELS.items():
    for name, slope in MAPS.items():
        for at in ("0.05", "0.5", "1", "1.01", "1.1", "1.2", "1.3", "1.4", "1.5"):
            value = force(modulus, slope, mpf(at))
            rows.append([model, name, at, mp.nstr(value, 15, min_fixed=0, max_fixed=0)])
with open(HERE / "ting.csv", "w", newline="") as file:
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(["model", "map", "time_s", "force_per_shape_pa_m"])
    writer.writerows(rows)
print(len(rows), "rows")
