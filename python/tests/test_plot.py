"""`plot` draws what it is given; looks are not tested."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest

from fractional_haptics import control, experiment, plot, records
from fractional_haptics.analysis import Device, region, transparency
from fractional_haptics.tissue import Model, identify

T = np.geomspace(0.01, 100, 40)


def gel() -> Model:
    return Model("spring-pot", viscosity_pa_s_alpha=5000.0, order=0.2)


def test_regions_are_drawn_with_their_extremes() -> None:
    found = {scheme: region(Device(0.065, 3.5), 0.5, 1e-3, scheme) for scheme in ("exact", "muir:3")}
    ax = plot.regions(found)
    tallest = max(one.stiffness_max_n_per_m for one in found.values())
    assert ax.get_ylim()[1] > tallest
    assert [text.get_text() for text in ax.get_legend().get_texts()] == list(found)
    assert ax.lines[0].get_color() == "#0072b2"
    assert plot.regions(found["exact"], ax) is ax


def test_identifications_are_drawn_for_every_kind() -> None:
    for kind, y in (
        ("relaxation", gel().relaxation_modulus(T)),
        ("creep", gel().creep_compliance(T)),
        ("oscillation", gel().complex_modulus(T)),
    ):
        ax = plot.identification(identify(T, y, kind, models=["spring-pot"]))
        assert len(ax.lines) == (4 if kind == "oscillation" else 2)


def test_a_run_without_a_relaxation_is_refused() -> None:
    with pytest.raises(ValueError, match="creep"):
        plot.relaxation(experiment.creep(duration_s=1.0))


def test_columns_of_any_run_are_drawn_over_time() -> None:
    run = experiment.creep(duration_s=1.0)
    ax = plot.columns(run)
    name = list(run.columns)[-1]
    assert plot.columns(run, name, ax=ax) is ax
    assert np.array_equal(ax.lines[-1].get_ydata(), run[name], equal_nan=True)


RESULTS: dict[str, tuple[Callable[[], Any], str, dict[str, str], tuple[str, str]]] = {
    "relax": (
        lambda: experiment.relax(duration_s=3.0),
        "time_s",
        {"simulated_force_n": "N", "position_m": "m"},
        ("time / s", "force on the hand / N"),
    ),
    "creep": (lambda: experiment.creep(duration_s=1.0), "time_s", {"simulated_strain": "", "position_m": "m"}, ("time / s", "strain")),
    "transparency": (
        lambda: experiment.analyze_transparency(
            mass="65 g", damping="3.5 N·s/m", sample_time="1 ms", order=0.5, stiffness=500.0, dissipation=1.0
        ),
        "omega_rad_s",
        {"effective_stiffness": "N/m"},
        ("omega / (rad/s)", "stiffness / (N/m)"),
    ),
    "zwidth": (
        lambda: experiment.zwidth(points=2, orders=[0.5, 1.0]),
        "dissipation",
        {"stiffness_max": "N/m", "dissipation": "N·s^μ/m", "order": ""},
        ("dissipation / (N·s^μ/m)", "N/m"),
    ),
    "Felt": (
        lambda: transparency(Device(0.065, 3.5), 500.0, 1.0, 0.5, 1e-3, [1.0, 10.0]),
        "omega_rad_s",
        {"damping_n_s_per_m": "N·s/m"},
        ("omega / (rad/s)", "stiffness / (N/m)"),
    ),
    "Response": (
        lambda: control.simulate("1/(s+1)", control.Pid(0.1, proportional=2.0), reference=np.ones(9)),
        "time_s",
        {"command": ""},
        ("time / s", ""),
    ),
    "Designed": (lambda: control.design("0.55exp(-s)/(62s+1)", 0.05), "time_s", {"output": ""}, ("time / s", "")),
    "Identified": (
        lambda: control.identify((np.arange(40) * 0.1, np.ones(40), 2 * (1 - np.exp(-np.arange(40) * 0.1)))),
        "time_s",
        {"model": ""},
        ("time / s", ""),
    ),
    "tissue": (
        lambda: identify(T, gel().creep_compliance(T), "creep", models=["spring-pot"]),
        "time_s",
        {"compliance_per_pa": "Pa⁻¹", "spring_pot_compliance_per_pa": "Pa⁻¹"},
        ("time / s", "creep compliance / (1/Pa)"),
    ),
    "oscillation": (
        lambda: identify(T, gel().complex_modulus(T), "oscillation", models=["spring-pot"]),
        "angular_frequency_rad_s",
        {"storage_modulus_pa": "Pa", "spring_pot_loss_modulus_pa": "Pa"},
        ("angular frequency / (rad/s)", "storage and loss modulus / Pa"),
    ),
    "Region": (
        lambda: region(Device(0.065, 3.5), 0.5, 1e-3),
        "point",
        {"stiffness_n_per_m": "N/m", "polygon": ""},
        ("dissipation $B$ / N·s$^μ$/m", "stiffness $K$ / (N/m)"),
    ),
}


@pytest.mark.parametrize("name", RESULTS)
def test_a_result_has_labelled_arrays_with_units_and_a_figure(name: str) -> None:
    make, axis, units, labels = RESULTS[name]
    result = make()
    labelled = result.to_xarray()
    assert set(labelled.dims) == {axis}
    assert list(labelled.coords) == [axis]
    assert {key: labelled[key].attrs.get("units", "") for key in units} == units
    for key, array in labelled.items():
        assert array.attrs["long_name"] and len(array) == len(labelled[axis])
        if isinstance(result, experiment.Run):
            assert np.array_equal(array, result[str(key)], equal_nan=True)
    ax = result.plot()
    assert (ax.get_xlabel(), ax.get_ylabel()) == labels
    key = next(iter(units))
    assert result.plot(key, ax=ax) is ax
    assert np.array_equal(ax.lines[-1].get_ydata(), labelled[key], equal_nan=True)
    with pytest.raises(KeyError, match="'place' is not one of the columns"):
        result.plot("place")
    plt.close("all")


def test_a_report_goes_with_the_arrays_into_a_file(tmp_path: Path) -> None:
    run = experiment.relax(duration_s=2.0)
    assert json.loads(run.to_xarray().attrs["report"]) == run.report


def test_columns_of_other_units_say_theirs() -> None:
    ax = experiment.creep(duration_s=1.0).plot("simulated_force_n", "position_m")
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["simulated force", "position / m"]
    assert ax.get_ylabel() == "simulated force / N"


def test_a_table_of_people_is_labelled_too(tmp_path: Path) -> None:
    table = records.Table(tmp_path, "p07", "feel", {"trial": "Number", "peak_n": "Largest force", "said": "Words"})
    with pytest.raises(ValueError, match="this Table has no columns of numbers"):
        table.plot()
    table.append(trial=0, peak_n=0.5, said="soft")
    table.append(trial=1, peak_n=None, said="3 times")
    labelled = table.to_xarray()
    assert labelled["peak_n"].attrs == {"long_name": "peak", "units": "N"}
    np.testing.assert_array_equal(labelled["peak_n"], [0.5, np.nan])
    assert list(labelled["said"].values) == ["soft", "3 times"]
    assert table.plot().get_ylabel() == "peak / N"


def test_without_the_packages_their_extras_are_named() -> None:
    code = (
        "import sys; sys.modules.update(matplotlib=None, xarray=None, pandas=None)\n"
        "from fractional_haptics import experiment\n"
        "run = experiment.relax(duration_s=1.5)\n"
        "for call in (run.plot, run.to_xarray, run.to_frame):\n"
        "    try: call()\n"
        "    except ImportError as error: print(error)\n"
    )
    ran = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert ran.stdout.splitlines() == [
        f"{package} is missing: pip install 'fractional-haptics[{extra}]'"
        for package, extra in (("matplotlib", "plot"), ("xarray", "xarray"), ("pandas", "log"))
    ]
