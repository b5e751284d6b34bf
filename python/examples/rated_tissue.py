"""Which tissue is most like the one you know? Somebody rates tissues, and a Gaussian process proposes the next (package `scikit-learn`).

::

    python rated_tissue.py [SUBJECT [DEVICE [KEY=VALUE...]]]

A tissue is a fractional standard linear solid: a spring E0 beside a spring E1 in series with a spring-pot, which is as stiff as E1 at
the time tau. All tissues of the region are proved before the first is felt. Each rating is a row of the table in `study`; the next tissue follows from the rows and the seed alone, so that a second
start goes on behind the last. Without a device a simulated observer rates by the parameters themselves, with noise.
"""

import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from scipy.stats import qmc
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel
from two_interval import offered, started

from fractional_haptics import records, session, tissue

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


def solid_at(place: np.ndarray) -> dict[str, float]:
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
        return solid_at(qmc.Sobol(4, rng=seed).random(16)[len(rows)])
    chance, process = np.random.default_rng([seed, len(rows)]), learned(rows)
    rated = np.array([place(row) for row in rows])
    near = rated[process.predict(rated).argmax()] + chance.normal(0.0, 0.1, (1000, 4))
    among = np.vstack([chance.random((2000, 4)), near.clip(0.0, 1.0)])
    mean, deviation = process.predict(among, return_std=True)
    return solid_at(among[np.where(mean > WELL * mean.max(), deviation, -1.0).argmax()])


def preferred(rows: Sequence[Mapping[str, str]], seed: int) -> dict[str, float]:
    """The tissue with the highest expected rating."""
    chance, process = np.random.default_rng([seed, 0]), learned(rows)
    best = np.array([place(row) for row in rows])
    for width in (0.3, 0.1, 0.03, 0.01):
        among = np.vstack([best, (best[0] + chance.normal(0.0, width, (2000, 4))).clip(0.0, 1.0)])
        best = among[process.predict(among).argmax()][None]
    return solid_at(best[0])


def stimulus(solid: Mapping[str, float], pot: float | None = None) -> dict[str, Any]:
    """A piece of 4 cm² and 20 mm of this solid; its spring-pot, Pa·s^order, by tau unless it is given."""
    model = tissue.Model(
        "fractional-zener",
        elastic_modulus_pa=solid["e0_pa"],
        second_viscosity_pa_s_beta=solid["e1_pa"],
        second_order=0.0,
        viscosity_pa_s_alpha=pot or solid["e1_pa"] * solid["tau_s"] ** solid["order"],
        order=solid["order"],
    )
    source = {"citation": "made up", "conditions": "none", "checked": False}
    material = tissue.Material("solid", "a fractional standard linear solid", model, source)
    return {"tissue": material, "loading": "tension", "area_m2": 4e-4, "thickness_m": 20e-3}


def region() -> tuple[dict[str, Any], dict[str, Any]]:
    """Ends between which all numbers of the models lie, as those of their spring-pots."""
    least, most = LOW["e1_pa"] * LOW["tau_s"] ** HIGH["order"], HIGH["e1_pa"] * HIGH["tau_s"] ** LOW["order"]
    return stimulus(LOW, least), stimulus(HIGH, most)


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
            s.allow_between(*region())
            for trial in range(len(table.rows), trials):
                solid = proposed(table.rows, seed)
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
