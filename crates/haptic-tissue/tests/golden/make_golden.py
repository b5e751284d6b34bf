#!/usr/bin/env python3
"""Makes the golden values beside this script, in mpmath.

    pip install mpmath==1.3.0 && python3 make_golden.py

Written once (2026-11-20); the tests read the CSV files and do not need Python. Models with two orders by the series of the
Mittag-Leffler function (power series, asymptotic for long times) and by inverting the Laplace transform on Talbot's contour,
which must agree to 1e-14; models with three terms by the contour, with two numbers of nodes that must agree to 1e-17. The
tests compute by another formula, the integral over the cut.
"""
import csv
import pathlib

from mpmath import mp, mpf, mpc, rgamma, exp, pi, cot, fsum, inf

HERE = pathlib.Path(__file__).parent
mp.dps = 50


def text(x):
    return mp.nstr(x, 20, min_fixed=0, max_fixed=0)


def write(name, header, rows):
    with open(HERE / name, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)
    print(name, len(rows), "rows", flush=True)


def talbot(transform, time, nodes):
    """Inverse Laplace transform on Talbot's contour, Weideman's parameters."""
    total = mpf(0)
    for k in range(nodes):
        theta = -pi + (2 * k + 1) * pi / nodes
        a = mpf("0.6407") * theta
        s = nodes / time * (mpf("0.5017") * theta * cot(a) - mpf("0.6122") + mpc(0, "0.2645") * theta)
        ds = nodes / time * (mpf("0.5017") * cot(a) - mpf("0.5017") * theta * mpf("0.6407") / mp.sin(a) ** 2 + mpc(0, "0.2645"))
        total += exp(s * time) * transform(s) * ds
    return (total / mpc(0, nodes)).real


def mittag_leffler(a, b, z):
    """E_{a,b}(−z), z > 0: power series, or the asymptotic one where its smallest term is below 1e-40."""
    scale = z ** (1 / a)  # t/τ
    if scale < 60:
        with mp.workdps(110):
            terms, k = [], 0
            while True:
                term = (-z) ** k * rgamma(a * k + b)
                terms.append(term)
                k += 1
                if k * a > 2 and abs(z) ** k * abs(rgamma(a * k + b)) < mpf(10) ** -90 and a * k > 2 * scale:
                    break
                if k > 60000:
                    return None
            return fsum(terms)
    with mp.workdps(60):
        total, k = mpf(0), 1
        while True:
            term = -((-z) ** -k) * rgamma(b - a * k)
            # |1/Γ(b − ak)| ≤ Γ(1 − b + ak)/π by reflection; the first terms may be 0 and say nothing.
            bound = z**-k * mp.gamma(1 - b + a * k) / pi if a * k > b else inf
            total += term
            if bound < abs(total) * mpf(10) ** -38:
                return total
            if a * k > scale:
                # The series stops at its smallest term; the exponential that it leaves out counts for a near 1.
                return total if bound < abs(total) * mpf(10) ** -20 else None
            k += 1


ORDERS = [
    ("1", "0"), ("1", "0.01"), ("0.99", "0"), ("0.95", "0.02"), ("0.999", "0.001"), ("0.675", "0.11"), ("0.85", "0.1"),
    ("0.3", "0.05"), ("0.5", "0.49"), ("0.9", "0.6"), ("0.2247", "0"), ("0.03", "0.01"), ("1", "0.5"), ("0.7", "0"), ("0.9999", "0.9"),
]
TIMES = ["1e-6", "1e-5", "1e-4", "1e-3", "0.01", "0.1", "0.3", "1", "3", "10", "30", "100", "1e3", "1e4", "1e5", "1e6"]
TAU, SECOND = mpf("0.02"), mpf(22100)


def check(label, one, other):
    if one is None:
        return other
    if other is None:
        return one
    error = abs(one / other - 1)
    assert error < mpf(10) ** -14, (label, mp.nstr(one, 20), mp.nstr(other, 20), mp.nstr(error, 3))
    return one


def inverted(label, transform, time):
    """Talbot with two numbers of nodes, until both agree."""
    for dps, nodes in ((60, 60), (90, 120), (160, 240)):
        with mp.workdps(dps):
            one = talbot(transform, time, nodes)
            other = talbot(transform, time, nodes + 14)
            if abs(one / other - 1) < mpf(10) ** -17:
                return one
    return None


# M of two elements and a spring. A model that is only listed here gets all its golden values from the contour.
MODELS = {
    "fractional-kelvin-voigt": lambda k1, k2, e: k1 + k2,
    "fractional-maxwell": lambda k1, k2, e: k1 * k2 / (k1 + k2),
    "fractional-zener": lambda k1, k2, e: e + k1 * k2 / (k1 + k2),
    "fractional-poynting-thomson": lambda k1, k2, e: e * (k1 + k2) / (e + k1 + k2),
}
# What two_orders() computes without the contour.
ELEMENTARY = [
    *(("fractional-kelvin-voigt", quantity) for quantity in ("relaxation", "creep")),
    *(("fractional-maxwell", quantity) for quantity in ("relaxation", "creep")),
    ("fractional-zener", "relaxation"),
    ("fractional-poynting-thomson", "creep"),
]


def modulus(model, v, a, g, b, e):
    return lambda s: MODELS[model](v * s**a, g * s**b, e)


def orders():
    """Both orders as text and as numbers, and the two moduli that meet at TAU."""
    for a_text, b_text in ORDERS:
        a, b = mpf(float(a_text)), mpf(float(b_text))
        g = SECOND
        yield a_text, b_text, a, b, mpf(float(g * TAU ** (a - b))), g


def two_orders():
    rows = []
    for a_text, b_text, a, b, v, g in orders():
        tau = (v / g) ** (1 / (a - b))
        for x in TIMES:
            t = mpf(float(TAU * mpf(x)))
            z = g / v * t ** (a - b)
            m = modulus("fractional-maxwell", v, a, g, b, None)
            if (a_text, b_text) == ("1", "0"):
                e1, e2 = exp(-z), -mp.expm1(-z) / z
                value, creep = g * e1, t / v * e2
            else:
                e1 = mittag_leffler(a - b, 1 - b, z)
                value = check(("G", a_text, b_text, x), None if e1 is None else g * t**-b * e1, inverted("G", lambda s: m(s) / s, t))
                e2 = mittag_leffler(a - b, 1 + a, z)
                k = modulus("fractional-kelvin-voigt", v, a, g, b, None)
                creep = check(("J", a_text, b_text, x), None if e2 is None else t**a / v * e2, inverted("J", lambda s: 1 / (s * k(s)), t))
            tail = [text(v), text(a), text(g), text(b), "", text(t)]
            rows.append(["fractional-maxwell", "relaxation", *tail, text(value)])
            rows.append(["fractional-kelvin-voigt", "creep", *tail, text(creep)])
            # The sums, elementary.
            rows.append(["fractional-kelvin-voigt", "relaxation", *tail, text(v * t**-a * rgamma(1 - a) + g * t**-b * rgamma(1 - b))])
            rows.append(["fractional-maxwell", "creep", *tail, text(t**a / v * rgamma(1 + a) + t**b / g * rgamma(1 + b))])
            e = SECOND / 8
            tail[4] = text(e)
            rows.append(["fractional-zener", "relaxation", *tail, text(e + value)])
            rows.append(["fractional-poynting-thomson", "creep", *tail, text(1 / e + creep)])
        print("two orders", a_text, b_text, flush=True)
    return rows


def three_terms():
    rows = []
    for a_text, b_text, a, b, v, g in orders():
        for share in ("0.05", "1", "30"):
            e = mpf(float(g * TAU**-b * mpf(share)))
            for x in TIMES:
                t = mpf(float(TAU * mpf(x)))
                for model, quantity in ((model, quantity) for model in MODELS for quantity in ("relaxation", "creep")):
                    if (model, quantity) in ELEMENTARY:
                        continue
                    m = modulus(model, v, a, g, b, e)
                    creep = quantity == "creep"
                    value = inverted(model, (lambda s: 1 / (s * m(s))) if creep else (lambda s: m(s) / s), t)
                    if value is None:
                        print("left out", model, a_text, b_text, share, x, flush=True)
                        continue
                    rows.append([model, quantity, text(v), text(a), text(g), text(b), text(e), text(t), text(value)])
        print("three terms", a_text, b_text, flush=True)
    return rows


def ramps():
    """Stress after a ramp of strain and a hold, from G integrated once: ∫G = the inverse of M/s²."""
    rows = []
    for a_text, b_text in (("1", "0"), ("0.675", "0.11"), ("0.95", "0.02"), ("0.3", "0.05")):
        a, b = mpf(float(a_text)), mpf(float(b_text))
        g = SECOND
        v = mpf(float(g * TAU ** (a - b)))
        e = SECOND / 8
        for model in MODELS:
            m = modulus(model, v, a, g, b, e)
            for t in ("0.001", "0.01", "0.1", "1", "10", "100"):
                t = mpf(float(t))
                stress = inverted(model, lambda s: m(s) / s**2, t)
                strain = inverted(model, lambda s: 1 / (m(s) * s**2), t)
                if stress is None or strain is None:
                    print("left out ramp", model, a_text, b_text, t, flush=True)
                    continue
                for quantity, value in (("ramp-stress", stress), ("ramp-strain", strain)):
                    rows.append([model, quantity, text(v), text(a), text(g), text(b), text(e), text(t), text(value)])
    return rows


if __name__ == "__main__":
    header = ["model", "quantity", "viscosity_pa_s_alpha", "order", "second_viscosity_pa_s_beta", "second_order", "elastic_modulus_pa", "time_s", "value"]
    write("closed_forms.csv", header, two_orders() + three_terms() + ramps())
