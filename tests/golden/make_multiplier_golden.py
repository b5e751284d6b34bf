#!/usr/bin/env python3
"""Writes multiplier.csv beside this script: the steepest contact that a multiplier can prove, by linear programmes.

    pip install numpy scipy==1.17.1 && python3 tests/golden/make_multiplier_golden.py

Independent of the crate: a held force on m x'' + b x' + c x (a matrix exponential, with the lag of the current as a
state), the wall K + B T^-mu (1 - w)^mu itself, and at each of some thousand angles Re{M(1/k + L)} >= t > 0 for
M = x_0 + sum x_i (1 - w^i), x >= 0, sum x = 1, i = -120 to 120. Largest k with such an x to 1e-4, by HiGHS. The loops are
those of many random ones whose conditions on phases promise the most that no multiplier keeps, and two easy ones.
Columns: mass kg, damping N s/m, hand N/m, current lag s, stiffness N/m, dissipation N s^mu/m, order, k.
"""
import csv
import pathlib

import numpy as np
from scipy.optimize import linprog
from scipy.signal import cont2discrete

T = 1e-3
LAGS = [i for n in range(1, 121) for i in (n, -n)]
LOOPS = [
    (0.2813154411046621, 0.2819968749390306, 11.515150881071412, 0, 559.948542380462, 1.712571865781749, 0.7168452875106842),
    (0.03931564386247227, 0.14796987153567007, 0, 0, 76.32841568638332, 0.08333090256116035, 0.8737768501412141),
    (0.40270754599253533, 2.4995712288299146, 490.27282242518044, 0.00020016081334294002, 150.29173825405667, 0.17337892765368035, 0.9596866968393564),
    (0.14578950163261406, 0.6021046628991111, 322.99470348864764, 0, 1663.7331096994171, 3.1074093325508154, 0.8067793201094823),
    (0.15373041825290604, 0.11576328307935044, 373.10706713547046, 0, 24.382393871090287, 7.412151392226151, 0.22150863676534785),
    (0.034959074412985444, 0.21821714086477675, 323.55175847675196, 0, 1727.142898458301, 1118.349126852113, 0.17031813728374454),
    (0.18312010668555198, 0.25020041018011874, 241.7480985579172, 0, 18.856301404914543, 15.862514140993893, 0.10590775456803336),
    (0.2403719016478952, 0.10749421588234898, 496.0533289441098, 0, 313.41103276487945, 138.4070394171584, 0.2723768802752601),
    (0.065, 3.5, 0, 0, 400, 10, 0.5),
    (0.2, 2, 300, 0.001, 1000, 20, 0.8),
]


def loop_gain(loop, theta):
    m, b, c, lag, k, d, mu = loop
    a, u = [[0, 1], [-c / m, -b / m]], [[0], [1 / m]]
    if lag:
        a = [[*a[0], 0], [*a[1], 1 / m], [0, 0, -1 / lag]]
        u = [[0], [0], [1 / lag]]
    n = len(a)
    ad, ud, *_ = cont2discrete((np.array(a), np.array(u), np.eye(n), np.zeros((n, 1))), T)
    z = np.exp(1j * theta)
    plant = np.array([np.linalg.solve(z_ * np.eye(n) - ad, ud)[0, 0] for z_ in z])
    return plant * (k + d * T**-mu * (1 - 1 / z) ** mu)


def has_multiplier(theta, gain, k):
    value = 1 / k + gain
    columns = [value.real]
    for i in LAGS:
        columns.append(((2 * np.sin(i * theta / 2) ** 2 + 1j * np.sin(i * theta)) * value).real)
    rows = np.array(columns).T
    rows /= np.abs(rows).max(axis=1, keepdims=True)
    unknowns = rows.shape[1]
    result = linprog(
        [0] * unknowns + [-1],
        # HiGHS counts 1e-10 as nothing; what is left of 1 - sum h may be 1e-7.
        A_ub=1e3 * np.hstack([-rows, np.ones((len(rows), 1))]),
        b_ub=np.zeros(len(rows)),
        A_eq=[[1] * unknowns + [0]],
        b_eq=[1],
        bounds=[(0, None)] * unknowns + [(None, 1)],
        method="highs-ds",
        options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
    )
    return result.status == 0 and -result.fun > 1e-10


def steepest(loop):
    theta = np.unique(np.concatenate([np.geomspace(1e-6, np.pi, 1200), np.linspace(1e-3, np.pi, 1200)]))
    gain = loop_gain(loop, theta)
    low, high = 1e-6, 1e6
    while high > (1 + 1e-4) * low:
        k = (low * high) ** 0.5
        low, high = (k, high) if has_multiplier(theta, gain, k) else (low, k)
    return low


if __name__ == "__main__":
    with open(pathlib.Path(__file__).parent / "multiplier.csv", "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["mass_kg", "damping", "hand", "lag_s", "stiffness", "dissipation", "order", "k"])
        for loop in LOOPS:
            out.writerow([*loop, float(f"{steepest(loop):.5g}")])
