"""Which tissue is most like the one you know? Somebody rates tissues, and a Gaussian process proposes the next (package `scikit-learn`).

::

    python rated_tissue.py [SUBJECT [DEVICE [KEY=VALUE...]]]

A tissue is a fractional standard linear solid: a spring E0 beside a spring E1 in series with a spring-pot, which is as stiff as E1 at
the time tau. Each rating is a row of the table in `study`; the next tissue follows from the rows and the seed alone, so that a second
start goes on behind the last. Without a device a simulated observer rates by the parameters themselves, with noise.
"""

import warnings
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from scipy.stats import qmc
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel
from two_interval import offered, started

from fractional_haptics import records, session

SCALE, STEP = (0.0, 10.0), 0.5
# Ends of the region that is searched.
LOW = {"order": 0.2, "e0_pa": 2e3, "e1_pa": 2e3, "tau_s": 0.05}
HIGH = {"order": 0.8, "e0_pa": 8e3, "e1_pa": 8e3, "tau_s": 0.5}
KEYS = tuple(LOW)
COLUMNS = {
    "trial": "Number from 0 on",
    "order": "Order of the spring-pot",
    "e0_pa": "Modulus at rest",
    "e1_pa": "Modulus at once, less that at rest",
    "tau_s": "Time at which the spring-pot is as stiff as its spring",
    "rating": "How like the known tissue, from 0 to 10 in steps of 0.5",
    "tick": "First tick of the tissue, in the log",
    "peak_n": "Largest force",
    "deepest_m": "Largest depth",
    "log": "Name of the log",
}
FIRST = 10
"""Trials of a Sobol sequence, before there is enough to learn from."""
WELL = 0.6
"""Share of the best rating from which on a tissue is worth another trial."""

# Equal steps of a place are equal ratios of moduli and times.
LOGS = np.array([False, True, True, True])
ENDS = [np.where(LOGS, np.log(list(ends.values())), list(ends.values())) for ends in (LOW, HIGH)]


def tissue(place: np.ndarray) -> dict[str, float]:
    """The tissue at a place in the unit cube, to four digits."""
    values = ENDS[0] + place * (ENDS[1] - ENDS[0])
    return {key: float(f"{value:.4g}") for key, value in zip(KEYS, np.where(LOGS, np.exp(values), values), strict=True)}


def place(row: Mapping[str, str | float]) -> np.ndarray:
    values = np.array([float(row[key]) for key in KEYS])
    return (np.where(LOGS, np.log(values), values) - ENDS[0]) / (ENDS[1] - ENDS[0])


def learned(rows: Sequence[Mapping[str, str]]) -> GaussianProcessRegressor:
    kernel = ConstantKernel(1.0, (0.1, 100.0)) * RBF([0.5] * 4, (0.15, 5.0)) + WhiteKernel(0.01, (1e-5, 0.3))
    with warnings.catch_warnings():
        # A length at the end of its range is fine.
        warnings.simplefilter("ignore", ConvergenceWarning)
        return GaussianProcessRegressor(kernel, normalize_y=True).fit([place(row) for row in rows], [float(row["rating"]) for row in rows])


def proposed(rows: Sequence[Mapping[str, str]], seed: int) -> dict[str, float]:
    """The tissue of the next trial: the least known of those that are expected to be rated well. Where a rating changes fast, on the
    flanks of the best, one says more than at the best itself."""
    if len(rows) < FIRST:
        return tissue(qmc.Sobol(4, rng=seed).random(16)[len(rows)])
    chance, process = np.random.default_rng([seed, len(rows)]), learned(rows)
    rated = np.array([place(row) for row in rows])
    near = rated[process.predict(rated).argmax()] + chance.normal(0.0, 0.1, (1000, 4))
    among = np.vstack([chance.random((2000, 4)), near.clip(0.0, 1.0)])
    mean, deviation = process.predict(among, return_std=True)
    return tissue(among[np.where(mean > WELL * mean.max(), deviation, -1.0).argmax()])


def preferred(rows: Sequence[Mapping[str, str]], seed: int) -> dict[str, float]:
    """The tissue with the highest expected rating."""
    chance, process = np.random.default_rng([seed, 0]), learned(rows)
    best = np.array([place(row) for row in rows])
    for width in (0.3, 0.1, 0.03, 0.01):
        among = np.vstack([best, (best[0] + chance.normal(0.0, width, (2000, 4))).clip(0.0, 1.0)])
        best = among[process.predict(among).argmax()][None]
    return tissue(best[0])


def stimulus(solid: Mapping[str, float]) -> dict[str, float]:
    """What is felt of a piece of 4 cm² and 20 mm: at long times its wall, a spring beside a spring-pot."""
    shape_m = 4e-4 / 20e-3
    pot = solid["e1_pa"] * solid["tau_s"] ** solid["order"]
    stiffness, dissipation = shape_m * solid["e0_pa"], shape_m * pot
    return {"order": solid["order"], "stiffness_n_per_m": stiffness, "dissipation_n_s_mu_per_m": dissipation}


Rates = Callable[[dict[str, float], session.Felt], float | str]


def person(_: dict[str, float], __: session.Felt) -> str:
    return input("How like the one you know, from 0, not at all, to 10, the same? ")


class Observer:
    """Rates by the distance from the tissue that it knows, half a width of the region away 6 of 10, to the nearest mark."""

    def __init__(self, known: Mapping[str, float], seed: int, noise: float = 0.2) -> None:
        self.known, self.noise, self.chance = place(known), noise, np.random.default_rng([seed, 1])

    def __call__(self, solid: dict[str, float], _: session.Felt) -> float:
        distance = (place(solid) - self.known) / 0.5
        rating = SCALE[1] * np.exp(-distance @ distance / 2) + self.chance.normal(0.0, self.noise)
        return float(np.clip(STEP * round(rating / STEP), *SCALE))


def rate(subject: str, seed: int, rates: Rates, trials: int = 40, device: str = "sim", **parameters) -> dict[str, float]:
    """Does what is left of the trials of a subject; the tissue that is most like the known one."""
    table = records.Table("study", subject, "likeness", COLUMNS)
    if len(table.rows) < trials:
        with session.open(device, log=table.log(), **{"force_limit": "4 N", **parameters}) as s:
            for trial in range(len(table.rows), trials):
                solid = proposed(table.rows, seed)
                s.allow([stimulus(solid)])
                felt = offered(s, device, f"Tissue {trial + 1}", stimulus(solid))
                while True:
                    try:
                        rating = s.rate(rates(solid, felt), "likeness", scale=SCALE, step=STEP)
                        break
                    except ValueError as error:
                        print(error)
                table.append(trial=trial, **solid, rating=rating, tick=felt.tick, peak_n=felt.peak_force_n,
                             deepest_m=felt.deepest_m, log=s.log.name)  # fmt: skip
    return preferred(table.rows, seed)


if __name__ == "__main__":
    known = {"order": 0.45, "e0_pa": 4.5e3, "e1_pa": 3.5e3, "tau_s": 0.15}

    def run(subject: str, device: str, **parameters) -> None:
        found = rate(subject, 1, person if device != "sim" else Observer(known, 1), 40, device, **parameters)
        print(", ".join(f"{key} {value:g}" for key, value in found.items()))

    started(run)
