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
