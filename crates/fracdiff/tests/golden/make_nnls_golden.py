"""Problems of non-negative least squares and their solutions by SciPy, for src/full_memory/nnls.rs.

    python3 -m pip install scipy && python3 make_nnls_golden.py > nnls.csv

A line per problem: name, rows, columns, A column by column, b, x.
"""
import numpy as np
from scipy.optimize import nnls

rng = np.random.default_rng(12)
rows = np.geomspace(16, 2e4, 40)
rates = np.exp(-0.9 * np.arange(14) - 2.0)
decays = np.exp(-np.outer(rows, rates)) * (rates**0.5) / rows[:, None] ** -0.5

problems = {
    "all of the plain solution is positive": ([[1, 0], [0, 2], [1, 1]], [3, 4, 5]),
    "one is held at zero": ([[1, 2], [3, 4], [5, 6]], [5, 2, 1]),
    "nothing but zero": ([[1, 2], [3, 4]], [-1, -2]),
    "one that entered leaves again": ([[73, 71, 52], [87, 74, 46], [72, 2, 7], [80, 89, 71]], [49, 67, 68, 20]),
    "random, tall": (rng.standard_normal((12, 6)), rng.standard_normal(12)),
    "random, square": (rng.standard_normal((8, 8)), rng.standard_normal(8)),
    "random, all positive": (rng.random((20, 10)), rng.random(20)),
    "decaying modes": (decays, np.ones(40)),
}

for name, (a, b) in problems.items():
    a, b = np.array(a, float), np.array(b, float)
    x, _ = nnls(a, b)
    numbers = [*a.T.flatten(), *b, *x]
    print(f'"{name}"', *a.shape, *(repr(float(v)) for v in numbers), sep=";")
