"""The smallest spread of the overshoot that any PI^λD^μ has behind a long dead time: writes late.csv.

Plants e^(−0.45s)/(τs + 1), crossover 1 rad/s, held for 0.02 s, |S(0.1j)| ≤ 0.1. Crossover and phase margin fix K_p and K_d; λ, μ from 0.05
to 1.95 and K_i are searched on a grid, and on by Nelder and Mead from its best. The loop is run at five gains from half to double: with the rule of second
order for s, exactly for the plant, by an inverse transform. A loop is stable if 1 + L does not wind around 0. Needs numpy and scipy.
"""
import csv
import pathlib

import numpy as np
from scipy.optimize import minimize

T, L = 0.02, 0.45
GAINS = [10 ** (db / 20) for db in (-6, -3, 0, 3, 6)]
PLANTS = [(4.5, 60), (2.25, 65), (1.125, 70)]
GRID, INTEGRALS, REFINED = 48, 40, 20


def operator(q):
    return (1.5 - 2 * q + 0.5 * q * q) / T


def plant(q, tau):
    whole, part = divmod(L / T, 1)
    early, all_ = np.exp(-(1 - part) * T / tau), np.exp(-T / tau)
    return q ** round(whole) * ((1 - early) * q + (early - all_) * q * q) / (1 - all_ * q)


class Loop:
    def __init__(self, tau, margin, samples):
        radius = 10 ** (6 / samples)
        self.samples, self.growth = samples, radius ** np.arange(samples)
        self.q = np.exp(-2j * np.pi * np.arange(samples // 2 + 1) / samples) / radius
        self.g, self.log_s = plant(self.q, tau), np.log(operator(self.q))
        at = lambda omega: (plant(np.exp(-1j * omega * T), tau), operator(np.exp(-1j * omega * T)))
        g, self.s = at(1.0)
        self.slow = at(0.1)
        self.wanted = np.exp(1j * np.radians(margin - 180)) / g

    def gains(self, lam, mu, ki):
        i, d = self.s**-lam, self.s**mu
        kd = (self.wanted.imag - ki * i.imag) / d.imag
        return self.wanted.real - ki * i.real - kd * d.real, kd

    def spread(self, lam, mu, ki):
        """Infinite where the disturbance is not held off, or a loop is not stable."""
        kp, kd = self.gains(lam, mu, ki)
        g, s = self.slow
        holds = abs(1 + (kp + ki * s**-lam + kd * s**mu) * g) >= 10
        found = np.full(len(ki), np.inf)
        kp, ki, kd = kp[holds, None], ki[holds, None], kd[holds, None]
        own = (kp + ki * np.exp(-lam * self.log_s) + kd * np.exp(mu * self.log_s)) * self.g
        stable, overshoots = np.ones(len(kp), bool), []
        for gain in GAINS:
            closed = 1 + gain * own
            stable &= abs(np.angle(closed[:, 1:] / closed[:, :-1]).sum(1)) < 1.5
            y = np.fft.irfft(gain * own / closed / (1 - self.q), n=self.samples, axis=1) * self.growth
            overshoots.append(np.maximum(y[:, : self.samples * 3 // 4].max(1, initial=0) - 1, 0))
        found[holds] = np.where(stable, np.ptp(overshoots, axis=0), np.inf)
        return found


def best(tau, margin):
    loop, found = Loop(tau, margin, 2048), []
    integrals = np.geomspace(0.01, 30, INTEGRALS)
    for lam in np.linspace(0.05, 1.95, GRID):
        for mu in np.linspace(0.05, 1.95, GRID):
            spread = loop.spread(lam, mu, integrals)
            place = spread.argmin()
            found.append((spread[place], lam, mu, np.log(integrals[place])))
    loop = Loop(tau, margin, 4096)

    def spread(x):
        inside = 0.02 < x[0] < 1.98 and 0.02 < x[1] < 1.98
        return loop.spread(x[0], x[1], np.exp(x[2:]))[0] if inside else np.inf

    options = {"maxfev": 600, "xatol": 1e-5, "fatol": 1e-7}
    ends = [minimize(spread, x, method="Nelder-Mead", options=options) for _, *x in sorted(found)[:REFINED]]
    end = min(ends, key=lambda end: end.fun)
    lam, mu, ki = end.x[0], end.x[1], np.exp(end.x[2])
    kp, kd = loop.gains(lam, mu, ki)
    return f"{kp:.6f}+{ki:.6f}/s^{lam:.6f}+{kd:.6f}s^{mu:.6f}", f"{end.fun:.5f}"


with open(pathlib.Path(__file__).with_name("late.csv"), "w", newline="") as file:
    rows = csv.writer(file, lineterminator="\n")
    rows.writerow(["time_constant", "margin_deg", "controller", "spread"])
    for tau, margin in PLANTS:
        rows.writerow([tau, margin, *best(tau, margin)])
