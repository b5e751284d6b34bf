"""Williams-Landel-Ferry and Arrhenius fits by SciPy, for the tests of master curves: prints what `master.rs` compares with."""

import numpy as np
from scipy.optimize import curve_fit

REFERENCE_C = 20.0
TEMPERATURES_C = np.array([-10.0, 0.0, 10.0, 25.0, 30.0, 40.0])
LOG10_SHIFTS = np.array([4.31, 2.36, 1.02, -0.38, -0.79, -1.42])


def wlf(x, c1, c2):
    return -c1 * x / (c2 + x)


def arrhenius(x, energy):
    celsius = 273.15
    return energy / (8.314462618 * np.log(10)) * (1 / (REFERENCE_C + x + celsius) - 1 / (REFERENCE_C + celsius))


for law, start in [(wlf, (8.0, 100.0)), (arrhenius, (1e5,))]:
    x = TEMPERATURES_C - REFERENCE_C
    values, covariance = curve_fit(law, x, LOG10_SHIFTS, p0=start, xtol=1e-15, ftol=1e-15)
    left = LOG10_SHIFTS - law(x, *values)
    print(law.__name__, *(f"{v:.9g} ± {e:.9g}" for v, e in zip(values, np.sqrt(np.diag(covariance)))), f"rms {np.sqrt(np.mean(left**2)):.9g}")


def public():
    """Best spring-pot of 40 starts for public records, which stay outside the repository: rms of the logarithms."""
    import sys
    from pathlib import Path

    from scipy.optimize import least_squares
    from scipy.special import gammaln

    def relaxation(x, order):
        return [-order * np.log(x) - gammaln(1 - order)]

    def creep(x, order):
        return [order * np.log(x) - gammaln(1 + order)]

    def sweep(x, order):
        angle = np.pi / 2 * order
        return [order * np.log(x) + np.log(part(angle)) for part in (np.cos, np.sin)]

    folder = Path(sys.argv[1])
    random = np.random.default_rng(1)
    for name, law, sign in [
        ("polystyrene-relaxation-145C.csv", relaxation, 1),
        ("polypropylene-relaxation.csv", relaxation, 1),
        ("laponite-relaxation-600.csv", relaxation, 1),
        ("polystyrene-creep-160C.csv", creep, -1),
        ("polystyrene-sweep-160C.csv", sweep, 1),
        ("polyisoprene-13k-sweep.csv", sweep, 1),
    ]:
        rows = [line.replace(",", "\t").split("\t") for line in (folder / name).read_text().splitlines()[1:] if line.strip()]
        table = np.array(rows, dtype=float).T
        wanted = np.log(table[1:])

        def left(p):
            return np.concatenate([sign * p[0] + one - want for one, want in zip(law(table[0], p[1]), wanted)])

        starts = zip(random.uniform(-5, 25, 40), random.uniform(0.02, 0.98, 40))
        fits = [least_squares(left, start, bounds=([-50, 1e-9], [50, 1 - 1e-9])) for start in starts]
        best = min(fits, key=lambda fit: fit.cost)
        print(f'("{name}", {np.sqrt(np.mean(best.fun**2)):.9g}),')


if __import__("sys").argv[1:]:
    public()
