"""Writes delayed_plant.csv: the sampled plant behind a delay and a current lag, to 30 digits.

    python3 -m pip install mpmath && python3 make_delayed_plant_golden.py

Independent of the crate: the step response of 1/((s^2 + delta s + gamma)(1 + tau s)) by partial fractions at a
working precision so high that their cancellation does not matter (confluent poles are moved apart by 1e-60), its
values at j + 1 - h, and the numerator as the product of denominator and pulse response. No matrix exponential.
Columns: delta, gamma, h, tau, four coefficients of the numerator (0 where there is none), numerator at w = 1.
Time in samples; h and tau are the doubles printed, taken as exact.
"""

import pathlib

import mpmath
from mpmath import mp, mpf

mp.dps = 300


def step(poles, gain, t):
    """Step response of gain/((s - p1)...(s - p_last)): residues of e^(st)/s/..., all poles simple."""
    if t <= 0:
        return mpf(0)
    total = mpf(0)
    roots = [mp.mpc(0)] + [mp.mpc(p) for p in poles]
    for i, p in enumerate(roots):
        product = mp.mpc(1)
        for j, q in enumerate(roots):
            if i != j:
                product *= p - q
        total += mp.exp(p * t) / product
    return gain * mp.re(total)


def apart(roots):
    """Moves equal poles (and those at 0) apart."""
    moved = []
    for k, p in enumerate(roots):
        moved.append(mp.mpc(p) + (k + 1) * mpf(10) ** -60 * (1 + abs(p)))
    return moved


def plant(delta, gamma, h, tau):
    d, g, h, tau = mpf(delta), mpf(gamma), mpf(h), mpf(tau)
    root = mp.sqrt(mp.mpc(d * d - 4 * g))
    poles = [(-d + root) / 2, (-d - root) / 2]
    gain = mpf(1)
    if tau > 0:
        poles.append(-1 / tau)
        gain = 1 / tau
    near = apart(poles)
    x = [step(near, gain, j + 1 - h) for j in range(4)]
    pulse = [x[0]] + [x[j] - x[j - 1] for j in range(1, 4)]
    denominator = [mp.mpc(1)]
    for p in poles:
        c = mp.exp(p)
        denominator = [
            (denominator[k] if k < len(denominator) else 0) - (c * denominator[k - 1] if k > 0 else 0)
            for k in range(len(denominator) + 1)
        ]
    n = len(poles)
    numerator = []
    for k in range(4):
        term = mpf(0)
        for j in range(k + 1):
            if j <= n:
                term += mp.re(denominator[j]) * pulse[k - j]
        numerator.append(term if k <= n else mpf(0))
    return numerator, sum(numerator)


def cases():
    fractions = [0.0, 1e-6, 0.25, 0.5, 0.9, 1 - 1e-6]
    lags = [0.0, 1e-6, 1e-3, 0.1, 1.0, 3.0, 100.0]
    devices = [(0.0, 0.0), (1e-9, 0.0), (0.0, 1e-9), (0.1, 0.0), (0.1, 0.0025), (1.0, 2.0), (3.0, 0.5), (10.0, 10.0)]
    for delta, gamma in devices:
        for h in fractions:
            for tau in lags:
                if h > 0 or tau > 0:
                    yield delta, gamma, h, tau
    # The lag's pole on top of the device's, and beside it.
    for gap in [0.0, 1e-14, 1e-9, 1e-4]:
        yield 1.0, 0.0, 0.3, 1.0 + gap
        yield 2.0, 1.0, 0.3, 1.0 + gap


def main():
    lines = ["delta,gamma,h,tau,n0,n1,n2,n3,sum"]
    for case in cases():
        numerator, total = plant(*case)
        numbers = [mpmath.nstr(x, 30) for x in [*numerator, total]]
        lines.append(",".join([*(repr(x) for x in case), *numbers]))
    pathlib.Path(__file__).with_name("delayed_plant.csv").write_text("\n".join(lines) + "\n")


main()
