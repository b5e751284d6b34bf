"""Trials in two intervals: which of two walls was stiffer? A method chooses their difference, as QUEST+ or a staircase.

Each trial is a row of a table in the folder `study`; a second start goes on behind the last of them. One in ten trials is a catch trial, with a
difference that nobody misses, of which the method learns nothing. A wall that nobody touched is offered again. Used by
`felt_threshold.py` and `felt_staircase.py`.
"""

import sys
from collections.abc import Callable, Mapping
from typing import Any, Protocol

import numpy as np

from fractional_haptics import records, session

STIFFNESS = 300.0
TRIES = 5
DIFFERENCES = np.geomspace(0.02, 0.6, 25)
COLUMNS = {
    "trial": "Number from 0 on",
    "catch": "1 of a trial with a difference that nobody misses",
    "difference": "How much stiffer one wall was than the other, 0.1 for 10 %",
    "stiffer": "The interval of the stiffer wall, 1 or 2",
    "answer": "The interval that was answered",
    "correct": "1 of a right answer",
    "log": "Name of the log",
    "answered_s": "End of the second interval, in the log",
    "first_tick": "First tick of the first wall, in the log",
    "first_peak_n": "Largest force of the first wall",
    "first_deepest_m": "Largest depth in the first wall",
    "second_tick": "First tick of the second wall",
    "second_peak_n": "Largest force of the second wall",
    "second_deepest_m": "Largest depth in the second wall",
}


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


def offered(s: session.Session, device: str, words: str, wall: Mapping[str, Any], surface_m: float = 0.0) -> session.Felt:
    """Offers a wall until it was touched, and the hand is out again."""
    said, deep_m = "", surface_m + 6e-3
    for _ in range(TRIES):
        if device == "sim":
            s.hand([(0.0, -3e-3), (0.1, deep_m), (0.2, deep_m), (0.3, -3e-3)])
        else:
            print(f"{words}: press.", flush=True)
        try:
            felt = s.feel(wall, seconds=0.3 if device == "sim" else 3.0, surface=surface_m)
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
    table = records.Table("study", subject, "stiffness", COLUMNS)
    number = method.next()
    for row in table.rows:
        number = learned(method, number, row)
    if number is None or len(table.rows) >= trials:
        return
    with session.open(device, log=table.log(), **{"force_limit": "4 N", **parameters}) as s:
        s.allow(spring(difference) for difference in (0.0, *DIFFERENCES))
        for trial in range(len(table.rows), trials):
            # By its number, so that a second start goes on with the same order.
            chance = np.random.default_rng([seed, 0, trial])
            catch = trial % 10 == 9
            difference = DIFFERENCES[-1 if catch else number]
            stiffer = int(chance.integers(1, 3))
            felt = []
            for interval in (1, 2):
                wall = spring(difference if interval == stiffer else 0.0)
                felt.append(offered(s, device, f"Trial {trial + 1}, wall {interval}", wall, chance.uniform(-1e-3, 1e-3)))
            answer = answers(felt)
            s.mark("answer", str(answer))
            one, two = felt
            table.append(trial=trial, catch=int(catch), difference=difference, stiffer=stiffer, answer=answer,
                         correct=int(answer == stiffer), log=s.log.name, answered_s=two.time_s + two.duration_s,
                         first_tick=one.tick, first_peak_n=one.peak_force_n, first_deepest_m=one.deepest_m,
                         second_tick=two.tick, second_peak_n=two.peak_force_n, second_deepest_m=two.deepest_m)  # fmt: skip
            number = learned(method, number, table.rows[-1])
            if number is None:
                break


def learned(method: Method, number: int | None, row: Mapping[str, str]) -> int | None:
    """The number of the next difference, once this row is known."""
    if number is None or int(row["catch"]):
        return number
    method.learn(number, bool(int(row["correct"])))
    return method.next()


def start(method: Method, trials: int) -> str:
    """Measures whom the command line names; the subject."""

    def run(subject: str, device: str, **parameters) -> None:
        observer = person if device != "sim" else Observer(threshold=0.1, slope=2.5, seed=1)
        measure(subject, 1, observer, method, trials, device, **parameters)

    return started(run)


def started(run: Callable[..., None]) -> str:
    """`python EXAMPLE.py [SUBJECT [DEVICE [KEY=VALUE...]]]`; the subject."""
    subject, device, *keys = [*sys.argv[1:], *("p00", "sim")[len(sys.argv) - 1 :]]
    given = dict(key.split("=", 1) for key in keys)
    try:
        run(subject, device, **{key: int(value) if value.isdecimal() else value for key, value in given.items()})
    except (TimeoutError, RuntimeError) as error:
        sys.exit(f"{error}; the table of {subject} has all trials that were answered: start again to go on")
    return subject
