"""`plot` draws what it is given; looks are not tested."""

import numpy as np
import pytest

from fractional_haptics import experiment, plot
from fractional_haptics.analysis import Device, region
from fractional_haptics.tissue import Model, identify


def test_regions_are_drawn_with_their_extremes() -> None:
    found = {scheme: region(Device(0.065, 3.5), 0.5, 1e-3, scheme) for scheme in ("exact", "muir:3")}
    ax = plot.regions(found)
    tallest = max(one.stiffness_max_n_per_m for one in found.values())
    assert ax.get_ylim()[1] > tallest
    assert [text.get_text() for text in ax.get_legend().get_texts()] == list(found)
    assert ax.lines[0].get_color() == "#0072b2"
    assert plot.regions(found["exact"], ax) is ax


def test_identifications_are_drawn_for_every_kind() -> None:
    gel = Model("spring-pot", viscosity_pa_s_alpha=5000.0, order=0.2)
    t = np.geomspace(0.01, 100, 40)
    for kind, y in (
        ("relaxation", gel.relaxation_modulus(t)),
        ("creep", gel.creep_compliance(t)),
        ("oscillation", gel.complex_modulus(t)),
    ):
        ax = plot.identification(identify(t, y, kind, models=["spring-pot"]))
        assert len(ax.lines) == (4 if kind == "oscillation" else 2)


def test_a_run_without_a_relaxation_is_refused() -> None:
    with pytest.raises(ValueError, match="creep"):
        plot.relaxation(experiment.creep(duration_s=1.0))


def test_columns_of_any_run_are_drawn_over_time() -> None:
    run = experiment.creep(duration_s=1.0)
    ax = plot.columns(run)
    drawn = [line.get_label() for line in ax.lines]
    assert len(drawn) > 0 and len({str(name).rpartition("_")[2] for name in drawn}) == 1
    name = list(run.columns)[-1]
    assert plot.columns(run, name, ax=ax) is ax
    assert ax.lines[-1].get_label() == name
    assert np.array_equal(ax.lines[-1].get_ydata(), run[name], equal_nan=True)
    with pytest.raises(KeyError, match="place"):
        plot.columns(run, "place")
