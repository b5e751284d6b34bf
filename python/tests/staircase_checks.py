"""Checks of the staircase's example, which `test_felt_threshold.py` runs in a process of its own."""

import numpy as np
from felt_staircase import Staircase
from test_felt_threshold import SLOPE, THRESHOLD, stopped_goes_on
from two_interval import DIFFERENCES, Observer, measure


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


def test_what_was_stopped_goes_on(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    stopped_goes_on(Staircase)
