"""The examples of a threshold: their simulated observer is found, and a stop loses nothing."""

import csv
import os
import warnings
from pathlib import Path

import numpy as np
import pytest
from felt_threshold import Quest
from two_interval import DIFFERENCES, Observer, measure

from fractional_haptics import log

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    from felt_staircase import Staircase

pytestmark = pytest.mark.filterwarnings("ignore::Warning")

THRESHOLD, SLOPE = 0.1, 2.5
SHARED = ("trial", "catch", "difference", "stiffer", "answer", "correct")


def rows(subject: str) -> list[dict[str, str]]:
    return list(csv.DictReader(Path(f"{subject}.csv").open(newline="")))


def test_the_threshold_of_an_observer_is_within_its_own_interval(tmp_path, monkeypatch) -> None:
    """`CAMPAIGN_CASES` sets how many seeds, 3 by default: nine in ten of 20 have to be."""
    monkeypatch.chdir(tmp_path)
    seeds = int(os.environ.get("CAMPAIGN_CASES", 3))
    within = 0
    for seed in range(seeds):
        quest = Quest()
        measure(f"s{seed}", seed, Observer(THRESHOLD, SLOPE, seed), quest)
        middle, low, high = quest.interval()
        print(f"seed {seed}: {middle:.3f} in [{low:.3f}, {high:.3f}]")
        within += low <= THRESHOLD <= high
        # It says something at all.
        assert high / low < 6
    assert within >= 0.9 * seeds - 0.7, f"{within} of {seeds}"


def climbed(seed: int) -> float:
    """The threshold of a staircase whose answers come from the observer's own law, without a device."""
    stairs, chance, trial = Staircase(), np.random.default_rng([seed, 1]), 0
    number = stairs.next()
    while number is not None:
        drawn = chance.random()
        if trial % 10 != 9:
            stairs.learn(number, drawn < 0.98 - 0.48 * np.exp(-((DIFFERENCES[number] / THRESHOLD) ** SLOPE)))
            number = stairs.next()
        trial += 1
    return stairs.threshold()


def test_a_staircase_is_that_of_an_observer_who_feels_the_differences_themselves(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    for seed in range(3):
        stairs = Staircase()
        measure(f"s{seed}", seed, Observer(THRESHOLD, SLOPE, seed), stairs, trials=300)
        assert stairs.stairs.finished
        assert stairs.threshold() == climbed(seed)
    # Where 0.98 − 0.48·exp(−(d/THRESHOLD)^SLOPE) = 0.5^(1/3). Reversals lie below it by a fraction of a step, which is 15 %.
    rest = THRESHOLD * np.log(0.48 / (0.98 - 0.5 ** (1 / 3))) ** (1 / SLOPE)
    climbs = np.log([climbed(seed) for seed in range(100)])
    error = np.std(climbs, ddof=1) / 10
    assert error < 0.02
    assert -0.05 - 3 * error < np.mean(climbs) - np.log(rest) < 3 * error


class Sharp:
    """Takes the stiffer wall for the stiffer one, and goes away at a trial."""

    def __init__(self, leaves: int) -> None:
        self.left = leaves

    def __call__(self, felt) -> int:
        if self.left == 0:
            raise KeyboardInterrupt
        self.left -= 1
        first, second = (one.peak_force_n / one.deepest_m for one in felt)
        return 1 if first > second else 2


@pytest.mark.parametrize("method", [Quest, Staircase])
def test_what_was_stopped_goes_on_with_the_same_trials_and_each_row_is_in_its_log(method, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    measure("whole", 4, Sharp(-1), method(), trials=12)
    with pytest.raises(KeyboardInterrupt):
        measure("stopped", 4, Sharp(5), method(), trials=12)
    assert len(rows("stopped")) == 5
    measure("stopped", 4, Sharp(-1), method(), trials=12)
    assert [[row[key] for key in SHARED] for row in rows("whole")] == [[row[key] for key in SHARED] for row in rows("stopped")]
    assert {row["log"] for row in rows("stopped")} == {"stopped-1.mcap", "stopped-2.mcap"}
    # The order is blind, and one in ten is a catch trial.
    assert {row["stiffer"] for row in rows("whole")} == {"1", "2"}
    assert [int(row["trial"]) for row in rows("whole") if row["catch"] == "1"] == [9]
    forces = log.read_log("whole-1.mcap")["commanded_force_n"].abs()
    for row in rows("whole"):
        for which in ("first", "second"):
            tick = int(row[f"{which}_tick"])
            assert forces.iloc[tick : tick + 300].max() == float(row[f"{which}_peak_n"])
