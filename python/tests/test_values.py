"""Values: they compare, have a hash where they cannot change, and go through pickles."""

import copy
import pickle
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import control as ct
import numpy as np
import pytest

from fractional_haptics import analysis, control, experiment, operators, tissue
from fractional_haptics.sweep import Grid, Output, together

T = 1e-3


def device() -> analysis.Device:
    return analysis.Device(0.065, 3.5, 100.0, 1e-3, 2e-3)


def linear() -> analysis.LinearPlant:
    return analysis.LinearPlant([[0.0, 1.0], [0.0, -50.0]], [0.0, 15.0], [1.0, 0.0], 1e-3)


IMMUTABLE: dict[str, Callable[[], Any]] = {
    "Device": device,
    "LinearPlant": linear,
    "Loop": lambda: analysis.Loop(device(), 1000.0, 3.0, 0.5, T, "grunwald:50"),
    "Loop of matrices": lambda: analysis.Loop(linear(), 1000.0, 3.0, 0.5, T),
    "Verdict": lambda: analysis.Loop(device(), 1000.0, 3.0, 0.5, T).verdict(),
    "Margins": lambda: analysis.Loop(device(), 1000.0, 3.0, 0.5, T).margins(),
    "Region": lambda: analysis.region(device(), 0.5, T, points=50),
    "Port": lambda: analysis.Port(0.5, T, "full:1e-6", 1e-3, 2e-3),
    "Coupler": lambda: analysis.Coupler(0.5, T, 1.0, 100.0),
    "Coupled": lambda: analysis.coupled(device(), analysis.Coupler(1.0, T, 0.0, 100.0), object_mass_kg=0.2),
    "Model": lambda: tissue.find("fish-muscle").model,
    "Model of lists": lambda: tissue.find("fish-muscle").model.prony(6, 1e-2, 100.0)[0],
    "Material": lambda: tissue.find("fish-muscle"),
    "TransferFunction": lambda: control.TransferFunction("1/(s^0.5+1)"),
    "Plant from a text": lambda: control.plant("0.55exp(-s)/(62s+1)"),
    "Plant from a function": lambda: control.plant(control.TransferFunction("1/(s^0.5+1)"), 0.5),
    "Plant from matrices": lambda: control.plant(ct.ss([[-1.0]], [[1.0]], [[2.0]], [[0.0]]), 0.5),
    "Plant from a response": lambda: control.plant(ct.FrequencyResponseData(1 / (1 + 1j * np.arange(1, 9)), np.arange(1, 9))),
}

HOLD_ARRAYS: dict[str, Callable[[], Any]] = {
    "Felt": lambda: analysis.transparency(device(), 500.0, 1.0, 0.5, T, [1.0, 10.0]),
    "Response": lambda: control.simulate("1/(s+1)", control.Pid(0.1, proportional=2.0), reference=np.ones(9)),
    "Designed": lambda: control.design("0.55exp(-s)/(62s+1)", 0.05),
    "Identification": lambda: tissue.identify(
        np.geomspace(0.1, 10, 20), 1e3 * np.geomspace(0.1, 10, 20) ** -0.2, models=["spring-pot"]
    ),
    "Run": lambda: _without_times(experiment.relax(tissue="prostate-healthy", duration_s=2.0)),
    "Grid": lambda: Grid(x=([1.0, 2.0], "m"), y=together(a=[1, 2, 3], b=["x", "y", "z"])),
    "Output": lambda: Output("N", axes={"t": [0.0, 1.0]}),
}


def _without_times(run: experiment.Run) -> experiment.Run:
    """Two runs have the same forces, but not the same clock."""
    return experiment.Run(run.kind, run.columns, {"samples": run.report["samples"]}, run.folder)


@pytest.mark.parametrize("name", [*IMMUTABLE, *HOLD_ARRAYS])
def test_a_value_is_equal_to_its_twin_and_to_its_copies(name: str) -> None:
    make = IMMUTABLE.get(name) or HOLD_ARRAYS[name]
    value = make()
    for other in (make(), pickle.loads(pickle.dumps(value)), copy.deepcopy(value)):
        assert type(other) is type(value)
        assert other == value
        assert not other != value
        if name in IMMUTABLE:
            assert hash(other) == hash(value)
    assert value != 1
    if name in HOLD_ARRAYS:
        with pytest.raises(TypeError, match="unhashable"):
            hash(value)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (device(), analysis.Device(0.065, 3.5, 100.0, 1e-3)),
        (device(), linear()),
        (linear(), analysis.LinearPlant([[0.0, 1.0], [0.0, -50.0]], [0.0, 15.0], [1.0, 0.0])),
        (analysis.Port(0.5, T), analysis.Port(0.5, T, delay_s=1e-4)),
        (analysis.Coupler(0.5, T, 1.0, 100.0), analysis.Coupler(0.5, T, 1.0, 101.0)),
        (analysis.Loop(device(), 1.0, 3.0, 0.5, T), analysis.Loop(device(), 1.0, 3.0, 0.5, T, "full")),
        (analysis.region(device(), 0.5, T), analysis.region(device(), 0.6, T)),
        (control.plant("1/(s+1)"), control.plant("1/(s+2)")),
        (tissue.find("fish-muscle"), tissue.find("prostate-healthy")),
        (Grid(x=[1.0, 2.0]), Grid(x=[1.0, 3.0])),
        (Grid(x=[1.0], y=[1.0]), Grid(y=[1.0], x=[1.0])),
    ],
)
def test_values_of_other_numbers_are_others(one: object, other: object) -> None:
    assert one != other
    assert not one == other


def test_arrays_in_values_are_compared_by_their_numbers() -> None:
    first, second = (
        analysis.Felt(np.array([1.0]), np.array([np.nan]), np.array([third])) for third in (1.0, 2.0)
    )
    assert first == copy.deepcopy(first)
    assert first != second


BEYOND = [10**15, 10**30, -1]


@pytest.mark.parametrize("count", BEYOND)
@pytest.mark.parametrize(
    "call",
    [
        lambda count: operators.grunwald_weights(0.5, count),
        lambda count: operators.Operator(0.5, T).weights(count),
        lambda count: control.TransferFunction("1/(s^0.5+1)").step_response(T, count),
        lambda count: control.TransferFunction("1/(s^0.5+1)").impulse_response(T, count),
        lambda count: analysis.region(device(), 0.5, T, points=count),
        lambda count: tissue.find("fish-muscle").model.prony(count, 1e-2, 100.0),
        lambda count: tissue.find("fish-muscle").model.export("table", count, 1e-2, 100.0),
        lambda count: tissue.identify([1.0, 2.0, 3.0], [3.0, 2.0, 1.0], starts=count),
        lambda count: tissue.identify([1.0, 2.0, 3.0], [3.0, 2.0, 1.0], bootstrap=count),
        lambda count: experiment.zwidth(points=count),
    ],
)
def test_a_count_that_cannot_be_is_refused(call: Callable[[int], object], count: int) -> None:
    with pytest.raises(ValueError, match="in \\[|ask for fewer|memory|whole number"):
        call(count)


@pytest.mark.parametrize("gigabytes", [6, 40, 4000])
def test_a_count_without_room_is_refused_and_does_not_abort(gigabytes: int) -> None:
    # In a process that may not have so much: what the machine has plays no part.
    code = f"""
import resource
resource.setrlimit(resource.RLIMIT_AS, (5 << 30, 5 << 30))
from fractional_haptics import control, operators
count = {gigabytes} * 10**9 // 8
for call in (
    lambda: operators.grunwald_weights(0.5, count),
    lambda: operators.Operator(0.5, 1e-3).weights(count),
    lambda: control.TransferFunction("1/(s^0.5+1)").step_response(1e-6, count),
):
    try:
        call()
    except ValueError as error:
        print("ask for fewer" in str(error) or error)
"""
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=600, check=False)
    assert (ran.returncode, ran.stdout.split()) == (0, ["True"] * 3), ran.stderr


MASKED = np.ma.masked_array([1.0, 2.0, 3.0], [False, True, False])


@pytest.mark.parametrize(
    "call",
    [
        lambda: operators.differintegrate(MASKED, 0.5, T),
        lambda: operators.differintegrate(np.ma.masked_array(np.ones((2, 3)), True), 0.5, T),
        lambda: operators.Operator(0.5, T).process(MASKED),
        lambda: operators.frequency_response(MASKED, 0.5, T),
        lambda: tissue.find("fish-muscle").model.relaxation_modulus(MASKED),
        lambda: tissue.identify(MASKED, MASKED),
        lambda: analysis.Loop(device(), 1.0, 1.0, 0.5, T).loop_gain(MASKED),
        lambda: analysis.Loop(device(), 1.0, 1.0, 0.5, T).to_control(MASKED),
        lambda: analysis.transparency(device(), 1.0, 1.0, 0.5, T, MASKED),
        lambda: analysis.LinearPlant([[0.0]], np.ma.masked_array([1.0], [True]), [1.0]),
        lambda: analysis.region(device(), 0.5, T).contains(MASKED, 1.0),
        lambda: control.simulate("1/(s+1)", control.Pid(0.1, proportional=2.0), reference=MASKED),
        lambda: Grid(x=MASKED),
    ],
)
def test_a_masked_array_is_refused_with_what_to_do(call: Callable[[], object]) -> None:
    with pytest.raises(ValueError, match="masked array.*compressed"):
        call()


@pytest.mark.parametrize(
    "call",
    [
        lambda folder: _log(folder / "run.mcap"),
        lambda folder: tissue.find(folder / "gel.toml"),
        lambda folder: tissue.find("gel", folder / "tissues"),
        lambda folder: tissue.library(folder / "tissues"),
        lambda folder: _store(folder / "store"),
    ],
)
def test_a_file_that_is_missing_is_not_found(call: Callable[[Any], object], tmp_path: Any) -> None:
    with pytest.raises(FileNotFoundError) as caught:
        call(tmp_path)
    assert str(tmp_path) in str(caught.value)


def _log(path: Any) -> object:
    from fractional_haptics.log import read_log

    return read_log(path)


def _store(path: Any) -> object:
    from fractional_haptics.sweep import open_sweep

    return open_sweep(path)
