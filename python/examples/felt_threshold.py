"""A threshold of stiffness: which of two walls is stiffer? QUEST+ chooses the next pair (package `questplus`).

::

    python felt_threshold.py [SUBJECT [DEVICE]]

Without a device a simulated observer feels the walls of the simulated one in virtual time. Each trial is a row of SUBJECT.csv;
a second start goes on behind the last of them. One in ten trials is a catch trial, with a difference that nobody misses.
"""

import csv
import sys
from pathlib import Path

import numpy as np
from questplus import QuestPlus

from fractional_haptics import session

STIFFNESS = 300.0
DIFFERENCES = np.geomspace(0.02, 0.6, 25)
TRIALS = 60
COLUMNS = ("subject", "trial", "catch", "difference", "stiffer", "answer", "correct", "log", "answered_s",
           "first_tick", "first_peak_n", "first_deepest_m", "second_tick", "second_peak_n", "second_deepest_m")  # fmt: skip


def spring(difference: float) -> dict[str, float]:
    return {"order": 1.0, "stiffness_n_per_m": STIFFNESS * (1.0 + difference), "dissipation_n_s_mu_per_m": 0.0}


def quest() -> QuestPlus:
    """Half of all guesses are right; one answer in fifty is a slip."""
    return QuestPlus(
        stim_domain={"intensity": DIFFERENCES},
        param_domain={
            "threshold": np.geomspace(0.02, 0.6, 41),
            "slope": np.linspace(1.0, 5.0, 9),
            "lower_asymptote": [0.5],
            "lapse_rate": [0.02],
        },
        outcome_domain={"response": ["Correct", "Incorrect"]},
        func="weibull",
        stim_scale="linear",
    )


def interval(found: QuestPlus) -> tuple[float, float, float]:
    """The threshold, and the ends between which it lies in 95 of 100 cases."""
    thresholds, posterior = found.param_domain["threshold"], found.marginal_posterior["threshold"]
    shares = np.cumsum(posterior) - posterior / 2
    low, middle, high = (float(np.interp(share, shares, thresholds)) for share in (0.025, 0.5, 0.975))
    return middle, low, high


def person(_: list[session.Felt]) -> int:
    while (answer := input("Which was stiffer, 1 or 2? ").strip()) not in ("1", "2"):
        pass
    return int(answer)


class Observer:
    """Decides by what was felt, as a Weibull function of the difference of both stiffnesses."""

    def __init__(self, threshold: float, slope: float, seed: int) -> None:
        self.threshold, self.slope = threshold, slope
        self.chance = np.random.default_rng([seed, 1])

    def __call__(self, felt: list[session.Felt]) -> int:
        first, second = (one.peak_force_n / one.deepest_m for one in felt)
        difference = abs(second - first) / min(first, second)
        right = 0.98 - 0.48 * np.exp(-((difference / self.threshold) ** self.slope))
        stiffer = 1 if first > second else 2
        return stiffer if self.chance.random() < right else 3 - stiffer


def measure(subject: str, seed: int, answers, device: str = "sim", trials: int = TRIALS, **parameters) -> QuestPlus:
    """Does what is left of the trials of a subject."""
    table = Path(f"{subject}.csv")
    done = list(csv.DictReader(table.open(newline=""))) if table.exists() else []
    found = quest()
    for row in done:
        learn(found, row)
    if len(done) >= trials:
        return found
    logs = (Path(f"{subject}-{number}.mcap") for number in range(1, 1000))
    log = next(log for log in logs if not log.exists())
    with session.open(device, log=log, force_limit="4 N", **parameters) as s, table.open("a", newline="") as file:
        rows = csv.DictWriter(file, COLUMNS)
        if not done:
            rows.writeheader()
        s.allow(spring(difference) for difference in (0.0, *DIFFERENCES))
        for trial in range(len(done), trials):
            # By its number, so that a second start goes on with the same order.
            chance = np.random.default_rng([seed, 0, trial])
            catch = trial % 10 == 9
            difference = DIFFERENCES[-1] if catch else found.next_stim["intensity"]
            stiffer = int(chance.integers(1, 3))
            felt = []
            for number in (1, 2):
                surface_m = chance.uniform(-1e-3, 1e-3)
                if device == "sim":
                    s.hand([(0.0, -3e-3), (0.1, surface_m + 6e-3), (0.2, surface_m + 6e-3), (0.3, -3e-3)])
                else:
                    print(f"Trial {trial + 1}, wall {number}: press.", flush=True)
                felt.append(s.feel(spring(difference if number == stiffer else 0.0),
                                   seconds=0.3 if device == "sim" else 3.0, surface=surface_m))  # fmt: skip
                s.rest()
            answer = answers(felt)
            s.mark("answer", str(answer))
            one, two = felt
            values = (subject, trial, int(catch), difference, stiffer, answer, int(answer == stiffer), log.name,
                      two.time_s + two.duration_s, one.tick, one.peak_force_n, one.deepest_m,
                      two.tick, two.peak_force_n, two.deepest_m)  # fmt: skip
            row = dict(zip(COLUMNS, values, strict=True))
            rows.writerow(row)
            file.flush()
            learn(found, row)
    return found


def learn(found: QuestPlus, row: dict) -> None:
    if not int(row["catch"]):
        outcome = "Correct" if int(row["correct"]) else "Incorrect"
        found.update(stim={"intensity": float(row["difference"])}, outcome={"response": outcome})


if __name__ == "__main__":
    subject, device, *_ = [*sys.argv[1:], *("p00", "sim")[len(sys.argv) - 1 :]]
    observer = person if device != "sim" else Observer(threshold=0.1, slope=2.5, seed=1)
    threshold, low, high = interval(measure(subject, 1, observer, device))
    print(f"{subject} feels a difference of {threshold:.1%}; 95 % interval {low:.1%} to {high:.1%}")
