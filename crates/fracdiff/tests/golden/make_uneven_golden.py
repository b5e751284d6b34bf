#!/usr/bin/env python3
"""Makes uneven.csv: D^mu of the straight lines between samples at uneven times, with 50 digits.

    pip install mpmath==1.3.0 && python3 make_uneven_golden.py

Not by the sum that the code uses: each line contributes s·int_a^b (t - tau)^(-mu) dtau / Gamma(1 - mu) by the substitution
tau = t - v, in closed form of v, for mu < 1; for mu <= 0 the integral of the signal itself, line by line.
Times: geometric from 1 us to 1000 s, jittered by half a step about 1 ms, and one pair 1 ns apart. Signals: 2 + t^0.7, and a
noisy one whose slopes are large.
"""
import random

from mpmath import mp, mpf, rgamma

mp.dps = 50


def piece(mu, t, a, b, xa, xb):
    """(1/Gamma(-mu)) int_a^b (t - tau)^(-mu - 1) x(tau) dtau of a line, mu < 0, by powers of v = t - tau."""
    slope = (xb - xa) / (b - a)
    # x = xb' + slope·(t - v - a) = c - slope·v
    c = xa + slope * (t - a)
    high, low = t - a, t - b
    first = c * (high ** -mu - low ** -mu) / -mu
    second = slope * (high ** (1 - mu) - low ** (1 - mu)) / (1 - mu)
    return (first - second) * rgamma(-mu)


def operator(mu, times, x, n, reference):
    t = times[n]
    if mu == 0:
        return x[n] - reference
    if mu < 0:
        whole = sum(piece(mu, t, times[j], times[j + 1], x[j] - reference, x[j + 1] - reference) for j in range(n))
        return whole
    # The derivative of order mu is the integral of order 1 - mu of the slope, and of the jump at the start.
    slopes = [(x[j + 1] - x[j]) / (times[j + 1] - times[j]) for j in range(n)]
    lines = sum(piece(mu - 1, t, times[j], times[j + 1], s, s) for j, s in enumerate(slopes))
    age = t - times[0]
    jump = (x[0] - reference) * rgamma(1 - mu) * age ** -mu if age > 0 else mpf(0)
    return lines + jump


def records():
    random.seed(26)
    geometric = [0.0] + [1e-6 * 10 ** (9 * n / 119) for n in range(120)]
    yield "geometric", geometric, [2.0 + t**0.7 for t in geometric]
    jittered, t = [], 5.0
    for _ in range(120):
        jittered.append(t)
        t += 1e-3 * random.uniform(0.5, 1.5)
    jittered.insert(60, jittered[59] + 1e-9)
    yield "jittered", jittered, [random.gauss(1.0, 0.1) for _ in jittered]


def main():
    rows = []
    for name, times, x in records():
        exact = [mpf(t) for t in times]
        signal = [mpf(v) for v in x]
        for mu in ("-1.6", "-0.5", "0.25", "0.5", "0.9"):
            for reference in (0.0, x[0]):
                for n in (1, 2, 59, 60, 61, len(times) - 1):
                    y = operator(mpf(float(mu)), exact, signal, n, mpf(reference))
                    rows.append(f"{name},{mu},{reference!r},{n},{mp.nstr(y, 20)}")
        for t, v in zip(times, x):
            rows.append(f"{name},sample,{t!r},{v!r},")
    with open("uneven.csv", "w") as file:
        file.write("record,order,reference,row,value\n" + "\n".join(rows) + "\n")


if __name__ == "__main__":
    main()
