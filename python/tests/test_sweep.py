"""Results of a sweep: variables, units, failures, random numbers, progress."""

import threading
import time

import numpy as np
import pytest
from numpy.testing import assert_array_equal

pytest.importorskip("xarray")

from fractional_haptics.sweep import Grid, Output, Progress, SweepError, axis, samples, sweep, together


def plane(x, y):
    return {"sum": x + y, "product": x * y}


def drawn(x, rng):
    return x + rng.standard_normal()


GRID = Grid(x=axis([1.0, 2.0, 3.0], "m", "place"), y=axis([10, 20], "m"))


def test_each_point_is_where_its_coordinates_say():
    result = sweep(plane, GRID, outputs={"sum": "m", "product": Output("m²", "area")})
    assert_array_equal(result["sum"], np.add.outer([1.0, 2.0, 3.0], [10, 20]))
    assert result["product"].sel(x=2.0, y=20) == 40.0
    assert result["sum"].dims == ("x", "y")
    assert (result["error"] == "").all()


def test_units_and_labels_are_in_the_result():
    result = sweep(plane, GRID, outputs={"sum": "m", "product": Output("m²", "area")})
    assert result["x"].attrs == {"units": "m", "long_name": "place"}
    assert result["sum"].attrs == {"units": "m"}
    assert result["product"].attrs == {"units": "m²", "long_name": "area"}
    assert result.attrs["function"] == f"{__name__}.plane"


@pytest.mark.parametrize("points", [1, 2, 4, 5, 100, None])
def test_any_blocks_and_any_threads_give_the_same_bits(points):
    grid = Grid(x=np.linspace(0, 1, 7), y=np.arange(5), draw=samples(3))

    def function(x, y, draw, rng):
        return x * y + rng.standard_normal() + draw

    reference = np.array(
        [
            [
                [
                    x * y + np.random.default_rng(np.random.SeedSequence(9, spawn_key=(i,))).standard_normal() + i
                    for i in range(3)
                ]
                for y in range(5)
            ]
            for x in np.linspace(0, 1, 7)
        ]
    )
    for workers in (1, 3):
        result = sweep(function, grid, seed=9, block_points=points, workers=workers)
        assert_array_equal(result["value"], reference)


def test_a_draw_is_the_same_all_over_the_map_and_another_for_each_seed():
    grid = Grid(x=[0.0, 0.0, 0.0], draw=samples(50))
    values = sweep(drawn, grid)["value"].values
    assert (values == values[0]).all()
    assert len(set(values[0])) == 50
    assert (sweep(drawn, grid, seed=1)["value"].values != values).all()


def test_two_dimensions_of_samples_are_drawn_together():
    values = sweep(drawn, Grid(a=samples(4), x=[0.0, 0.0], b=samples(5)))["value"].values
    assert (values[:, 0] == values[:, 1]).all()
    assert len(set(values[:, 0].ravel())) == 20


def test_without_samples_each_point_has_its_own_numbers():
    values = sweep(drawn, Grid(x=np.zeros(20)))["value"].values
    children = np.random.SeedSequence(0).spawn(20)
    assert_array_equal(values, [np.random.default_rng(child).standard_normal() for child in children])


def test_a_point_that_fails_is_nan_with_its_text_and_the_others_are_there():
    def touchy(x, y):
        if x == 2.0:
            raise ValueError(f"no {x} with {y}")
        return plane(x, y)

    result = sweep(touchy, GRID, block_points=2)
    assert result["error"].sel(x=2.0, y=10) == "ValueError: no 2.0 with 10"
    assert np.isnan(result["sum"].sel(x=2.0)).all()
    assert np.isnan(result["product"].sel(x=2.0)).all()
    assert_array_equal(result["sum"].sel(x=3.0), [13.0, 23.0])
    assert int((result["error"] != "").sum()) == 2


def test_a_point_half_written_when_it_fails_is_nan_in_each_variable():
    def half(x):
        return {"a": 1.0, "b": 1.0 if x < 2 else "text"}

    result = sweep(half, {"x": [0.0, 1.0, 2.0]}, outputs={"a": "1", "b": "1"})
    assert np.isnan(result["a"][2])
    assert result["error"][2] == "TypeError: 'b' is str, neither a number nor an array of numbers"


@pytest.mark.parametrize(
    ("late", "text"),
    [
        ({"a": 1.0}, "ValueError: returned 'a', where this sweep has 'a', 'b'"),
        ({"a": 1.0, "b": 2.0, "c": 3.0}, "ValueError: returned 'a', 'b', 'c', where this sweep has 'a', 'b'"),
        ({"a": [1.0, 2.0], "b": 2.0}, "ValueError: 'a' has shape (2,), where this sweep has ()"),
        ({"a": 1j, "b": 2.0}, "TypeError: 'a' is complex: give outputs with Output(dtype=\"complex128\")"),
        (None, "ValueError: returned 'value', where this sweep has 'a', 'b'"),
    ],
)
def test_a_result_of_another_form_is_a_failed_point(late, text):
    result = sweep(lambda x: {"a": 1.0, "b": 2.0} if x < 5 else late, {"x": range(6)}, outputs={"a": "1", "b": "1"})
    assert result["error"][5] == text
    assert_array_equal(result["a"][:5], np.ones(5))


def test_a_panic_of_a_library_is_a_failed_point():
    class Panic(BaseException):
        pass

    def panics(x):
        if x == 1:
            raise Panic("index out of bounds")
        return x

    assert sweep(panics, {"x": [0, 1, 2]})["error"][1] == "Panic: index out of bounds"


def test_truth_values_and_whole_numbers_become_floating_numbers():
    result = sweep(lambda x: {"yes": x > 1, "count": int(x)}, {"x": [0.0, 1.0, 2.0, 3.0]})
    assert result["yes"].dtype == np.float64
    assert result["yes"].mean() == 0.5
    assert_array_equal(result["count"], [0, 1, 2, 3])


def test_small_arrays_and_complex_numbers_become_variables():
    outputs = {
        "response": Output("N/m", axes={"frequency": axis([1.0, 10.0, 100.0], "Hz")}, dtype="complex128"),
        "matrix": Output(axes={"row": [0, 1], "column": ["a", "b", "c"]}, dtype="float32"),
    }
    result = sweep(
        lambda x: {"response": x * np.array([1, 1j, -1]), "matrix": np.full((2, 3), x)},
        {"x": [1.0, 2.0]},
        outputs=outputs,
    )
    assert result["response"].sel(x=2.0, frequency=10.0) == 2j
    assert result["frequency"].attrs == {"units": "Hz"}
    assert result["matrix"].sel(x=2.0, row=1, column="c") == 2.0
    assert result["matrix"].dtype == np.float32


def test_forms_are_found_without_outputs():
    result = sweep(lambda x: {"z": x * 1j, "pair": [x, -x], "matrix": np.eye(2)}, {"x": [1.0, 2.0]})
    assert result["z"].dtype == np.complex128
    assert result["pair"].dims == ("x", "pair_index")
    assert result["matrix"].dims == ("x", "matrix_0", "matrix_1")


def test_axes_together_share_a_dimension():
    grid = Grid(device=together(name=axis(["a", "b", "c"]), mass=axis([1.0, 2.0, 3.0], "kg")), gain=[10.0, 20.0])
    result = sweep(lambda name, mass, gain: mass * gain + len(name), grid)
    assert result["value"].dims == ("device", "gain")
    assert_array_equal(result["value"], [[11, 21], [21, 41], [31, 61]])
    assert list(result["name"].values) == ["a", "b", "c"]
    assert result["mass"].attrs["units"] == "kg"


def test_threads_run_at_the_same_time():
    both = threading.Barrier(2, timeout=600)
    result = sweep(lambda x: float(both.wait() >= 0), {"x": [1, 2]}, workers=2, block_points=1, outputs={"value": "1"})
    assert_array_equal(result["value"], [1, 1])


def test_progress_tells_rate_and_remaining_time():
    seen: list[Progress] = []
    sweep(lambda x: time.sleep(0.002), {"x": range(20)}, outputs={"value": "1"}, block_points=5, progress=seen.append)
    assert [one.done for one in seen] == [0, 5, 10, 15, 20]
    assert [one.failed for one in seen] == [0, 5, 10, 15, 20]
    assert seen[-1].remaining_s == 0
    middle = seen[2]
    assert middle.remaining_s == pytest.approx(10 / middle.points_per_s)
    assert middle.points_per_s == pytest.approx(10 / middle.elapsed_s)
    assert str(middle).startswith("10 of 20 points, 10 failed, ")


def test_a_bar_and_lines_can_be_shown(capsys, monkeypatch):
    pytest.importorskip("tqdm")
    sweep(lambda x: x, {"x": range(3)}, progress=True)
    assert "3.00/3.00" in capsys.readouterr().err
    monkeypatch.setitem(__import__("sys").modules, "tqdm.auto", None)
    sweep(lambda x: x, {"x": range(3)}, progress=True)
    assert "3 of 3 points, 0 failed" in capsys.readouterr().err


def test_blocks_are_as_long_as_asked():
    seen = []
    sweep(lambda x: time.sleep(0.001) or 0.0, {"x": range(400)}, workers=1, block_seconds=0.02, progress=seen.append)
    longest = max(np.diff([one.done for one in seen]))
    assert 1 <= longest <= 20  # no point takes less than 1 ms
    seen.clear()
    sweep(lambda x: x, {"x": range(400)}, workers=1, block_seconds=10.0, progress=seen.append)
    assert [one.done for one in seen] == [0, 100, 200, 300, 400]  # four for each worker


def test_threads_end_after_the_point_they_are_at():
    calls = []

    def stop(progress):
        if progress.done:
            raise KeyboardInterrupt

    def slow(x):
        calls.append(x)
        time.sleep(0.0 if x < 10 else 0.05)
        return x

    with pytest.raises(KeyboardInterrupt):
        sweep(slow, {"x": range(200)}, block_points=10, workers=1, progress=stop, outputs={"value": "1"})
    assert len(calls) < 20


def test_a_sweep_whose_first_points_all_fail_ends_with_the_first_text():
    with pytest.raises(SweepError, match=r"3 points all over the grid fail.*ZeroDivisionError.*Mend the function"):
        sweep(lambda x: 1 / 0, {"x": [1, 2, 3]})
    result = sweep(lambda x: 1 / 0, {"x": [1, 2, 3]}, outputs={"value": "1"})
    assert (result["error"] == "ZeroDivisionError: division by zero").all()


def test_a_long_text_of_an_error_is_cut():
    def fails(x):
        raise ValueError("x" * 10_000)

    result = sweep(fails, {"x": [1]}, outputs={"value": "1"})
    assert len(result["error"].item()) == 500
