"""Trials in two intervals: which of two walls was stiffer? A method chooses their difference, as QUEST+ or a staircase.

Each trial is a row of SUBJECT.csv; a second start goes on behind the last of them. One in ten trials is a catch trial, with a
difference that nobody misses, of which the method learns nothing. A wall that nobody touched is offered again. Used by
`felt_threshold.py` and `felt_staircase.py`.
"""

import csv
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

import numpy as np

from fractional_haptics import session

STIFFNESS = 300.0
TRIES = 5
DIFFERENCES = np.geomspace(0.02, 0.6, 25)
COLUMNS = ("subject", "trial", "catch", "difference", "stiffer", "answer", "correct", "log", "answered_s",
           "first_tick", "first_peak_n", "first_deepest_m", "second_tick", "second_peak_n", "second_deepest_m")  # fmt: skip


class Method(Protocol):
    """Chooses among `DIFFERENCES`."""

    def next(self) -> int | None:
        """The number of the next difference; `None` after the last trial."""

    def learn(self, number: int, correct: bool) -> None:
        """What became of the difference that `next` gave last."""


def spring(difference: float) -> dict[str, float]:
    return {"order": 1.0, "stiffness_n_per_m": STIFFNESS * (1.0 + difference), "dissipation_n_s_mu_per_m": 0.0}


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


def offered(s: session.Session, wall: dict[str, float], surface_m: float, press: Callable[[], None], seconds: float) -> session.Felt:
    """Offers a wall until it was touched, and the hand is out again."""
    said = ""
    for _ in range(TRIES):
        press()
        try:
            felt = s.feel(wall, seconds=seconds, surface=surface_m)
        except TimeoutError as error:
            said = str(error)
        else:
            out(s)
            if felt.touched:
                return felt
            said = "nobody touched the wall: press it"
        print(said, flush=True)
    raise TimeoutError(said)


def out(s: session.Session) -> None:
    for _ in range(TRIES):
        try:
            return s.rest()
        except TimeoutError as error:
            print(error, flush=True)
    return s.rest()


def measure(subject: str, seed: int, answers: Callable[[list[session.Felt]], int], method: Method,
            trials: int = 60, device: str = "sim", **parameters) -> None:  # fmt: skip
    """Does what is left of the trials of a subject, at most so many in all."""
    table = Path(f"{subject}.csv")
    done = list(csv.DictReader(table.open(newline=""))) if table.exists() else []
    number = method.next()
    for row in done:
        number = learned(method, number, row)
    if number is None or len(done) >= trials:
        return
    logs = (Path(f"{subject}-{start}.mcap") for start in range(1, 1000))
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
            difference = DIFFERENCES[-1 if catch else number]
            stiffer = int(chance.integers(1, 3))
            felt = []
            for interval in (1, 2):
                surface_m = chance.uniform(-1e-3, 1e-3)

                def press(deep_m: float = surface_m + 6e-3, words: str = f"Trial {trial + 1}, wall {interval}: press.") -> None:
                    if device == "sim":
                        s.hand([(0.0, -3e-3), (0.1, deep_m), (0.2, deep_m), (0.3, -3e-3)])
                    else:
                        print(words, flush=True)

                wall = spring(difference if interval == stiffer else 0.0)
                felt.append(offered(s, wall, surface_m, press, 0.3 if device == "sim" else 3.0))
            answer = answers(felt)
            s.mark("answer", str(answer))
            one, two = felt
            values = (subject, trial, int(catch), difference, stiffer, answer, int(answer == stiffer), log.name,
                      two.time_s + two.duration_s, one.tick, one.peak_force_n, one.deepest_m,
                      two.tick, two.peak_force_n, two.deepest_m)  # fmt: skip
            row = dict(zip(COLUMNS, values, strict=True))
            rows.writerow(row)
            file.flush()
            number = learned(method, number, row)
            if number is None:
                break


def learned(method: Method, number: int | None, row: dict) -> int | None:
    """The number of the next difference, once this row is known."""
    if number is None or int(row["catch"]):
        return number
    method.learn(number, bool(int(row["correct"])))
    return method.next()


def start(method: Method, trials: int) -> str:
    """`python EXAMPLE.py [SUBJECT [DEVICE]]`; the subject."""
    subject, device, *_ = [*sys.argv[1:], *("p00", "sim")[len(sys.argv) - 1 :]]
    observer = person if device != "sim" else Observer(threshold=0.1, slope=2.5, seed=1)
    try:
        measure(subject, 1, observer, method, trials, device)
    except (TimeoutError, RuntimeError) as error:
        sys.exit(f"{error}; {subject}.csv has all trials that were answered: start again to go on")
    return subject
