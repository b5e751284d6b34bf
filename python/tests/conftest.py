"""No window opens, and no figure stays."""

import os

import matplotlib
import pytest

# No test remembers limits of devices in the folders of whoever runs it.
os.environ["FRACTIONAL_HAPTICS_STATE"] = ""

matplotlib.use("Agg")


@pytest.fixture(autouse=True)
def closed_figures():
    yield
    import matplotlib.pyplot as plt

    plt.close("all")
