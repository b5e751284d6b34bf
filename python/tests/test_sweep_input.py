"""Bad input of sweeps: each is refused before anything is computed, with a text that says what to do."""

import functools

import numpy as np
import pytest

pytest.importorskip("xarray")

from fractional_haptics.sweep import Grid, Output, axis, samples, sweep, together


def value(x):
    return x


def refused(kind, text, function=value, grid=None, **more):
    with pytest.raises(kind, match=text):
        sweep(function, {"x": [1.0]} if grid is None else grid, **more)


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: Grid(), "the grid is empty: name at least one axis"),
        (lambda: Grid(x=[]), "axis 'x': an axis without values"),
        (lambda: Grid(x=[[1.0, 2.0]]), "axis 'x': an axis has one dimension, not 2"),
        (lambda: Grid(x=[1.0, np.nan]), "axis 'x': value 1 of an axis is NaN"),
        (lambda: Grid(x=[1j]), "axis 'x': values of type complex128"),
        (lambda: Grid(x=[None]), "axis 'x': values of type object"),
        (lambda: Grid(error=[1.0]), "an axis cannot be called 'error'"),
        (lambda: Grid(rng=[1.0]), "an axis cannot be called 'rng'"),
        (lambda: Grid(_x=[1.0]), "an axis cannot be called '_x'"),
        (lambda: Grid(**{"a b": [1.0]}), "'a b' cannot be the name of an argument"),
        (lambda: Grid(**{"lambda": [1.0]}), "'lambda' cannot be the name of an argument"),
        (lambda: Grid(x=[1.0], pair=together(x=[1.0], y=[2.0])), "two coordinates are called 'x'"),
        (lambda: Grid(pair=together(x=[1.0], y=[2.0]), x=[1.0]), "two coordinates are called 'x'"),
        (lambda: together(a=[1.0], b=[1.0, 2.0]), "have the same length, not {'a': 1, 'b': 2}"),
        (lambda: together(), "at least one"),
        (lambda: samples(0), "a whole number from 1, not 0"),
        (lambda: samples(2.5), "a whole number from 1, not 2.5"),
    ],
)
def test_a_grid_that_cannot_be(make, text):
    with pytest.raises(ValueError, match=text):
        make()


def test_functions_that_do_not_fit_the_grid():
    refused(TypeError, "a sweep is a function, not int", function=3)
    refused(
        TypeError, "takes no argument 'y', an axis of the grid, by name; it takes: x", grid={"x": [1.0], "y": [1.0]}
    )
    refused(TypeError, "nothing gives the function its argument 'gain'", function=lambda x, gain: x)
    refused(TypeError, "takes no argument 'x', an axis of the grid, by name; it takes: none", function=lambda x, /: x)


def test_functions_that_fit_in_other_ways():
    grid = {"x": [1.0, 2.0]}
    assert sweep(lambda **all: all["x"], grid)["value"].sum() == 3
    assert sweep(functools.partial(lambda x, gain: gain * x, gain=2.0), grid)["value"].sum() == 6
    assert sweep(lambda x, gain=3.0: gain * x, grid)["value"].sum() == 9


def test_outputs_that_cannot_be():
    refused(ValueError, "'x' is a result, or an axis of one, and also an axis", outputs={"x": "1"})
    refused(ValueError, "'x' is a result, or an axis of one, and also", outputs={"y": Output(axes={"x": [1, 2]})})
    refused(ValueError, "'y' is a result, or an axis of one, and also", outputs={"y": Output(axes={"y": [1, 2]})})
    refused(ValueError, "a result cannot be called 'error'", outputs={"error": "1"})
    refused(ValueError, "outputs names no variable", outputs={})
    refused(
        ValueError,
        "'t' is an axis of two kinds",
        outputs={"a": Output(axes={"t": [1, 2]}), "b": Output(axes={"t": [1, 2, 3]})},
    )
    refused(ValueError, "'x' is a result, or an axis of one, and also", function=lambda x: {"x": 1.0})
    with pytest.raises(ValueError, match="dtype 'int64': only float64, float32, complex128"):
        Output(dtype="int64")


def test_options_that_cannot_be(tmp_path):
    refused(ValueError, "the seed is a whole number from 0, not -1", seed=-1)
    refused(ValueError, "the seed is a whole number from 0, not 1.5", seed=1.5)
    refused(ValueError, "block_points is from 1 to 1000000, not 0", block_points=0)
    refused(ValueError, "block_seconds is a positive time, not 0", block_seconds=0)
    refused(ValueError, "block_seconds is a positive time, not nan", block_seconds=float("nan"))
    refused(ValueError, "a number of workers is a whole number from 1, not 0", workers=0)
    refused(ValueError, 'store_format is "zarr" or "parquet", not \'hdf5\'', store=tmp_path, store_format="hdf5")


def test_results_of_different_forms_need_outputs():
    refused(Exception, "different names or shapes: give outputs", lambda x: {"a": 1} if x else {"b": 1}, {"x": [0, 1]})


def test_an_axis_is_not_changed_by_its_maker():
    values = np.array([1.0, 2.0])
    made = axis(values)
    values[0] = 5.0
    assert made.values[0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        made.values[0] = 3.0
