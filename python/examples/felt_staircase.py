"""A staircase of stiffness: three right answers make the difference smaller, a wrong one larger (PsychoPy's `StairHandler`).

::

    python felt_staircase.py [SUBJECT [DEVICE [KEY=VALUE...]]]

It comes to rest where three right answers in a row are as likely as not: at 79.4 % of right ones (H. Levitt, Transformed
up-down methods in psychoacoustics, J. Acoust. Soc. Am. 49, 1971, table I). PsychoPy says neither slope nor interval of it.
"""

import numpy as np
from psychopy.data import StairHandler
from two_interval import DIFFERENCES, start


class Staircase:
    """Steps over the numbers of the differences, so that each wall is known beforehand."""

    def __init__(self, reversals: int = 12) -> None:
        self.stairs = StairHandler(
            startVal=len(DIFFERENCES) - 4, stepType="lin", stepSizes=[4, 2, 1], minVal=0, maxVal=len(DIFFERENCES) - 1,
            nUp=1, nDown=3, nReversals=reversals, nTrials=1,
        )  # fmt: skip

    def next(self) -> int | None:
        number = next(self.stairs, None)
        return None if number is None else int(number)

    def learn(self, number: int, correct: bool) -> None:
        self.stairs.addResponse(int(correct), intensity=number)

    def threshold(self) -> float:
        """Geometric mean of the reversals at the smallest step."""
        numbers = np.asarray(self.stairs.reversalIntensities[-8:], dtype=int)
        return float(np.exp(np.log(DIFFERENCES[numbers]).mean()))


if __name__ == "__main__":
    stairs = Staircase()
    subject = start(stairs, trials=200)
    print(f"{subject} answers right in 79 of 100 trials at a difference of {stairs.threshold():.1%}")
