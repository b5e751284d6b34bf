"""A threshold of stiffness: which of two walls is stiffer? QUEST+ chooses the next pair (package `questplus`).

::

    python felt_threshold.py [SUBJECT [DEVICE [KEY=VALUE...]]]

Without a device a simulated observer feels the walls of the simulated one in virtual time.
"""

import numpy as np
from questplus import QuestPlus
from two_interval import DIFFERENCES, start


class Quest:
    """Half of all guesses are right; one answer in fifty is a slip."""

    def __init__(self) -> None:
        self.found = QuestPlus(
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

    def next(self) -> int:
        return int(np.argmin(np.abs(DIFFERENCES - self.found.next_stim["intensity"])))

    def learn(self, number: int, correct: bool) -> None:
        outcome = "Correct" if correct else "Incorrect"
        self.found.update(stim={"intensity": DIFFERENCES[number]}, outcome={"response": outcome})

    def interval(self) -> tuple[float, float, float]:
        """The threshold, and the ends between which it lies in 95 of 100 cases."""
        thresholds, posterior = self.found.param_domain["threshold"], self.found.marginal_posterior["threshold"]
        shares = np.cumsum(posterior) - posterior / 2
        low, middle, high = (float(np.interp(share, shares, thresholds)) for share in (0.025, 0.5, 0.975))
        return middle, low, high


if __name__ == "__main__":
    quest = Quest()
    subject = start(quest, trials=60)
    threshold, low, high = quest.interval()
    print(f"{subject} feels a difference of {threshold:.1%}; 95 % interval {low:.1%} to {high:.1%}")
