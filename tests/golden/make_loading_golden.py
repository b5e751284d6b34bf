#!/usr/bin/env python3
"""Makes loading.csv and loading_force.csv beside this script, with 30 digits in mpmath.

    pip install mpmath==1.3.0 && python3 tests/golden/make_loading_golden.py

loading.csv: factor γ for both moduli and map e of specimens, by the formulas of their sources.
loading_force.csv: the force of Lee and Radok under a ramp and hold, f = γV/Γ(1−α)·∫ (t − τ)^(−α) de(δ(τ)), by quadrature.
Written once (2026-11-23); the tests read the CSV files and do not need Python.
"""
import csv
import pathlib

from mpmath import mp, mpf, exp, expm1, gamma, pi, quad, sqrt, tan

mp.dps = 30
HERE = pathlib.Path(__file__).parent
DEPTHS = ["1e-7", "5e-5", "1e-3", "4e-3"]
# Kind, area, thickness, radius, half angle, bonded, Poisson's ratio, stiffening.
SPECIMENS = [
    ("shear", "4e-4", "2e-2", "", "", 0, "0.5", "0"),
    ("shear", "4e-4", "2e-2", "", "", 0, "0.3", "6"),
    ("tension", "4e-4", "2e-2", "", "", 0, "0.45", "0"),
    ("tension", "4e-4", "2e-2", "", "", 1, "0.5", "25"),
    ("compression", "4e-4", "2e-2", "", "", 0, "0.5", "0"),
    ("compression", "4e-4", "2e-3", "", "", 1, "0.5", "0"),
    ("punch", "", "", "2e-3", "", 0, "0.4", "0"),
    ("punch", "", "", "2e-3", "", 0, "0.4", "8"),
    ("sphere", "", "", "5e-3", "", 0, "0.5", "0"),
    ("sphere", "", "", "5e-3", "", 0, "0", "12"),
    ("sphere", "", "3e-3", "5e-3", "", 1, "0.5", "0"),
    ("sphere", "", "3e-3", "5e-3", "", 1, "0.5", "10"),
    ("cone", "", "", "", "1.2", 0, "0.5", "0"),
    ("sphere", "", "3e-3", "5e-3", "", 0, "0.5", "10"),
]


def number(text):
    return mpf(text) if text else None


def pressed(specimen):
    """γ·e(δ) with the shear modulus, for Young's modulus, and the rate of e; γ·e' of the first."""
    kind, *sizes, bonded, nu, b = specimen
    area, thickness, radius, angle = map(number, sizes)
    nu, b = mpf(nu), mpf(b)
    if kind in ("shear", "tension", "compression"):
        factor = area / thickness * (1 if kind == "shear" else 2 * (1 + nu))
        if bonded:
            # Gent and Lindley: radius over twice the thickness.
            factor *= 1 + 2 * (sqrt(area / pi) / (2 * thickness)) ** 2
        plain, length = (lambda d: d), thickness
    elif kind == "punch":
        factor, plain, length = 4 * radius / (1 - nu), (lambda d: d), radius
    elif kind == "sphere":
        # Hertz: 8√R/(3(1 − ν))·δ^(3/2), told with e = δ√(δ/R).
        factor, length = 8 * radius / (3 * (1 - nu)), thickness or radius

        def plain(d):
            x = sqrt(radius * d) / thickness if thickness else mpf(0)
            factors = ["1.133", "1.283", "0.769", "0.0975"] if bonded else ["0.884", "0.781", "0.386", "0.0048"]
            layer = 1 + sum(mpf(factor) * x ** (n + 1) for n, factor in enumerate(factors))
            return d * sqrt(d / radius) * layer
    else:
        # Sneddon: 4 tan φ/(π(1 − ν))·δ², told with e = δ²/1 mm.
        factor, plain, length = 4 * tan(angle) / (pi * (1 - nu)) / 1000, (lambda d: 1000 * d**2), None

    def e(d):
        x = b * d / length if length and b else mpf(0)
        return plain(d) * (expm1(x) / x if x else 1)

    return factor, factor / (2 * (1 + nu)), e


def text(value):
    return mp.nstr(value, 20, min_fixed=0, max_fixed=0)


def write(name, header, rows):
    with open(HERE / name, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)
    print(name, len(rows), "rows")


SIZES = ["kind", "area_m2", "thickness_m", "radius_m", "half_angle_rad", "bonded", "poisson_ratio", "stiffening"]
rows = []
for specimen in SPECIMENS:
    shear, young, e = pressed(specimen)
    for depth in DEPTHS:
        rows.append([*specimen, text(shear), text(young), depth, text(e(mpf(depth)))])
write("loading.csv", [*SIZES, "shape_shear_m", "shape_young_m", "depth_m", "e_m"], rows)

# 1 mm in 1 s, then held; V = 1 kPa·s^α, α = 0.2247.
DEPTH, RAMP, VISCOSITY, ORDER = mpf("1e-3"), mpf(1), mpf(1000), mpf("0.2247")
TIMES = ["0.1", "0.3", "1", "1.1", "1.3", "2", "5"]


def force(specimen, t):
    shape, _, e = pressed(specimen)
    start = max(t - RAMP, mpf(0))
    # With w = (t − τ)^(1−α) the kernel is constant; e by a difference that 60 digits bear.
    def rate(w):
        depth = DEPTH * (t - w ** (1 / (1 - ORDER))) / RAMP
        step = depth * mpf("1e-20")
        return (e(depth + step) - e(depth - step)) / (2 * step) * DEPTH / RAMP if depth > 0 else mpf(0)

    low, high = start ** (1 - ORDER), t ** (1 - ORDER)
    with mp.workdps(60):
        integral = quad(rate, [low, (low + high) / 2, high]) / (1 - ORDER)
    return shape * VISCOSITY / gamma(1 - ORDER) * integral


rows = []
for specimen in [SPECIMENS[6], SPECIMENS[7], SPECIMENS[8], SPECIMENS[11], SPECIMENS[10], SPECIMENS[12]]:
    for time in TIMES:
        value = force(specimen, mpf(time))
        if specimen[0] == "punch" and specimen[7] == "0":
            t = mpf(time)
            rest = (t - RAMP) ** (1 - ORDER) if t > RAMP else 0
            exact = pressed(specimen)[0] * VISCOSITY * DEPTH * (t ** (1 - ORDER) - rest) / gamma(2 - ORDER)
            assert abs(value / exact - 1) < mpf("1e-12"), (time, value, exact)
        rows.append([*specimen, time, text(value)])
write("loading_force.csv", [*SIZES, "time_s", "force_n"], rows)
