"""Stores of sweeps: resumed after any end, refused for another sweep, written by one sweep at a time."""

import os
import shutil
import signal
import subprocess
import sys
import textwrap
import time
import warnings
from random import Random

import numpy as np
import pytest
from numpy.testing import assert_array_equal

xr = pytest.importorskip("xarray")
zarr = pytest.importorskip("zarr")

from fractional_haptics.sweep import Grid, StoreInUse, StoreMismatch, SweepError, axis, open_sweep, samples, sweep, together

FORMATS = ["zarr", "parquet"]


def drawn(x, draw, rng):
    return {"y": x + rng.standard_normal(), "pair": [x, draw], "matrix": [[x, 1, 2], [draw, 4, 5]]}


GRID = Grid(x=axis([0.0, 1.0, 2.0, 3.0, 4.0], "m"), draw=samples(6))


class Stopped(Exception):
    pass


def stop_after(blocks):
    """A callback that ends the sweep after so many blocks."""
    left = [blocks + 1]  # the first call is before any block

    def report(progress):
        left[0] -= 1
        if left[0] == 0:
            raise Stopped

    return report


def same(a, b):
    for name in a.data_vars:
        assert_array_equal(a[name].values, b[name].values)
        assert a[name].attrs == b[name].attrs
    for name in a.coords:
        assert_array_equal(a[name].values, b[name].values)
        assert a[name].attrs == b[name].attrs
    assert a.attrs == b.attrs


@pytest.mark.parametrize("store_format", FORMATS)
def test_a_stopped_sweep_goes_on_and_does_nothing_twice(tmp_path, store_format):
    whole = sweep(drawn, GRID)
    options = {"store": tmp_path / "s", "store_format": store_format, "workers": 1}
    with pytest.raises(Stopped):
        sweep(drawn, GRID, block_points=4, progress=stop_after(3), **options)
    seen = []
    resumed = sweep(drawn, GRID, block_points=9, progress=seen.append, **options)
    same(resumed, whole)
    lines = (tmp_path / "s" / "_done").read_text().splitlines()
    assert len(lines) == len(set(lines))
    assert [one.done for one in seen][0] == 9  # three blocks of 3 points
    assert resumed["draw"].dtype == np.int64


@pytest.mark.parametrize("store_format", FORMATS)
def test_a_finished_sweep_calls_nothing(tmp_path, store_format):
    grid = {"x": [1.0, 2.0, 3.0]}
    calls = tmp_path / "calls"

    def counted(x):
        with calls.open("a") as file:
            file.write("x")
        return x

    first = sweep(counted, grid, store=tmp_path / "s", store_format=store_format).load()
    size = calls.stat().st_size
    same(sweep(counted, grid, store=tmp_path / "s"), first)
    assert calls.stat().st_size == size


@pytest.mark.parametrize("store_format", FORMATS)
def test_every_kind_of_coordinate_and_error_comes_back(tmp_path, store_format):
    grid = Grid(device=together(name=axis(["a", "µ"]), mass=axis([1.0, 2.0], "kg")), on=[True, False], n=[1, 2, 3])

    def function(name, mass, on, n):
        if name == "µ" and n == 2:
            raise ValueError("zwölf")
        return mass * n + on

    memory = sweep(function, grid)
    kept = sweep(function, grid, store=tmp_path / "s", store_format=store_format, block_points=2)
    same(kept, memory)
    assert set(kept.coords) == {"name", "mass", "on", "n"}
    assert int((kept["error"] == "ValueError: zwölf").sum()) == 2


def test_a_zarr_store_is_opened_by_anybody_at_any_time(tmp_path):
    with pytest.raises(Stopped):
        sweep(drawn, GRID, store=tmp_path / "s", workers=1, block_points=6, progress=stop_after(2))
    for found in (xr.open_zarr(tmp_path / "s"), open_sweep(tmp_path / "s")):
        assert found["y"].dims == ("x", "draw")
        assert int(found["y"].notnull().sum()) == 12
        assert found["x"].attrs["units"] == "m"


def test_a_parquet_store_is_a_table_with_a_row_for_each_point(tmp_path):
    pd = pytest.importorskip("pandas")
    result = sweep(drawn, GRID, store=tmp_path / "s", store_format="parquet", block_points=4)
    table = pd.read_parquet(tmp_path / "s")
    assert len(table) == 30
    row = table[(table["x"] == 3.0) & (table["draw"] == 2)].iloc[0]
    assert row["y"] == result["y"].sel(x=3.0, draw=2)
    assert list(row["pair"]) == [3.0, 2.0]
    assert [list(one) for one in row["matrix"]] == [[3.0, 1.0, 2.0], [2.0, 4.0, 5.0]]
    with pytest.raises(ValueError, match="holds Parquet: read it by pandas"):
        open_sweep(tmp_path / "s")


@pytest.mark.parametrize("store_format", FORMATS)
def test_failed_points_are_tried_again_when_asked(tmp_path, store_format):
    missing = tmp_path / "missing"
    missing.touch()

    def reads(x):
        if x > 3 and missing.exists():
            raise OSError("no such file")
        return x

    options = {"store": tmp_path / "s", "outputs": {"value": "1"}}
    seen = []
    first = sweep(reads, {"x": range(6)}, block_points=2, store_format=store_format, **options).load()
    assert int((first["error"] != "").sum()) == 2
    missing.unlink()
    assert int((sweep(reads, {"x": range(6)}, **options)["error"] != "").sum()) == 2
    again = sweep(reads, {"x": range(6)}, retry_failed=True, progress=seen.append, **options)
    assert [one.done for one in seen] == [4, 6]
    assert_array_equal(again["value"], np.arange(6.0))
    assert (again["error"] == "").all()


CHANGES = {
    "values": ({"x": axis([0.0, 1.0, 2.5], "m")}, {}, "grid: axes: x: last is 2.0 in the store and 2.5 now"),
    "inner value": ({"x": axis([0.0, 1.5, 2.0], "m")}, {}, "grid: axes: x: sha256 is"),
    "number": ({"x": axis([0.0, 1.0], "m")}, {}, "grid: axes: x: length is 3 in the store and 2 now"),
    "unit": ({"x": axis([0.0, 1.0, 2.0], "mm")}, {}, "grid: axes: x: unit is 'm' in the store and 'mm' now"),
    "kind": ({"x": axis([0, 1, 2], "m")}, {}, "grid: axes: x: kind is 'f' in the store and 'i' now"),
    "another axis": ({"x": axis([0.0, 1.0, 2.0], "m"), "draw": samples(2)}, {}, "grid: axes: draw is new"),
    "seed": ({}, {"seed": 4}, "seed is 0 in the store and 4 now"),
    "version": ({}, {"version": "2"}, "function: version is '' in the store and '2' now"),
    "outputs": ({}, {"outputs": {"value": "m"}}, "outputs: value: unit is '1' in the store and 'm' now"),
    "format": ({}, {"store_format": "parquet"}, "store_format is 'zarr' in the store and 'parquet' now"),
}


@pytest.mark.parametrize("change", CHANGES)
def test_another_sweep_is_refused_with_what_differs(tmp_path, change):
    def function(x, draw=0):
        return x

    grid = {"x": axis([0.0, 1.0, 2.0], "m")}
    sweep(function, grid, store=tmp_path / "s")
    other, options, text = CHANGES[change]
    with pytest.raises(StoreMismatch, match="holds another sweep") as refused:
        sweep(function, other or grid, store=tmp_path / "s", **options)
    assert text in str(refused.value)
    sweep(function, grid, store=tmp_path / "s")


def test_another_function_or_package_is_refused(tmp_path, monkeypatch):
    grid = {"x": [1.0]}
    gain = 2.0
    sweep(lambda x: gain * x, grid, store=tmp_path / "s")
    gain = 3.0
    with pytest.raises(StoreMismatch, match="gain of .* is '2.0' in the store and '3.0' now"):
        sweep(lambda x: gain * x, grid, store=tmp_path / "s")
    gain = 2.0
    with pytest.raises(StoreMismatch, match="code of"):
        sweep(lambda x: gain + x, grid, store=tmp_path / "s")
    monkeypatch.setattr("fractional_haptics.sweep.run.package_version", lambda: "9.9")
    with pytest.raises(StoreMismatch, match="fractional_haptics is '.*' in the store and '9.9' now"):
        sweep(lambda x: gain * x, grid, store=tmp_path / "s")


def test_stores_that_cannot_be(tmp_path):
    grid = {"x": [1.0]}
    with pytest.raises(TypeError, match="a store is the path of a folder, not MemoryStore"):
        sweep(lambda x: x, grid, store=zarr.storage.MemoryStore())
    (tmp_path / "file").touch()
    with pytest.raises(ValueError, match="is a file: name a new folder"):
        sweep(lambda x: x, grid, store=tmp_path / "file")
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "thesis.tex").touch()
    with pytest.raises(ValueError, match="holds 'thesis.tex', but no sweep: name a new folder"):
        sweep(lambda x: x, grid, store=tmp_path / "full")
    (tmp_path / "full" / "thesis.tex").rename(tmp_path / "full" / "_lock").write_text("mine")
    with pytest.raises(ValueError, match="holds '_lock', but no sweep"):
        sweep(lambda x: x, grid, store=tmp_path / "full")
    assert (tmp_path / "full" / "_lock").read_text() == "mine"
    with pytest.raises(FileNotFoundError, match="no such store"):
        open_sweep(tmp_path / "nowhere")
    with pytest.raises(ValueError, match="holds no sweep"):
        open_sweep(tmp_path / "full")
    with pytest.raises(OSError, match="the store cannot be made"):
        sweep(lambda x: x, grid, store="/proc/nothing/here")
    with pytest.raises(ValueError, match="'value' is complex, which Parquet has no type for: use Zarr"):
        sweep(lambda x: x * 1j, grid, store=tmp_path / "c", store_format="parquet")


@pytest.mark.parametrize("text", ["", "{", "[]", '{"format": 99}'])
def test_a_damaged_manifest_is_refused(tmp_path, text):
    sweep(lambda x: x, {"x": [1.0]}, store=tmp_path / "s")
    (tmp_path / "s" / "_sweep.json").write_text(text)
    with pytest.raises(ValueError, match="name a new store"):
        sweep(lambda x: x, {"x": [1.0]}, store=tmp_path / "s")


def test_a_store_that_is_taken_away_meanwhile_is_an_error(tmp_path):
    def take_away(progress):
        if progress.done:
            shutil.rmtree(tmp_path / "s", ignore_errors=True)

    with pytest.raises((OSError, ValueError)):
        sweep(
            lambda x: x,
            {"x": range(5)},
            store=tmp_path / "s",
            store_format="parquet",
            block_points=1,
            progress=take_away,
        )


def test_a_line_that_a_kill_cut_off_is_computed_again(tmp_path):
    options = {"store": tmp_path / "s", "block_points": 1, "workers": 1}
    first = sweep(lambda x: x, {"x": range(12)}, **options).load()
    journal = tmp_path / "s" / "_done"
    whole = journal.read_bytes()
    for cut in (1, 3, 4):
        journal.write_bytes(whole[: len(whole) - cut])
        seen = []
        again = sweep(lambda x: x, {"x": range(12)}, progress=seen.append, **options)
        assert_array_equal(again["value"], first["value"])
        assert seen[0].done == 11
        assert journal.read_bytes() == whole


SLOW = """
import sys, time
from fractional_haptics.sweep import Grid, axis, samples, sweep

def slow(x, draw, rng):
    time.sleep(0.01)
    return {"y": x + rng.standard_normal()}

sweep(slow, Grid(x=axis([0.0, 1.0, 2.0, 3.0], "m"), draw=samples(50)), store=sys.argv[1], block_points=10,
      store_format=sys.argv[2])
"""


def started(tmp_path, store_format, blocks):
    """A process that sweeps, after that many blocks."""
    script = tmp_path / "slow.py"
    script.write_text(textwrap.dedent(SLOW))
    process = subprocess.Popen(
        [sys.executable, script, tmp_path / "s", store_format], stderr=subprocess.PIPE, start_new_session=True
    )
    journal = tmp_path / "s" / "_done"
    give_up = time.monotonic() + 60
    while not (journal.exists() and journal.read_bytes().count(b"\n") >= blocks):
        assert process.poll() is None, process.stderr.read()
        assert time.monotonic() < give_up
        time.sleep(0.01)
    return process, script


@pytest.mark.parametrize(
    ("end", "store_format"), [(signal.SIGKILL, "zarr"), (signal.SIGKILL, "parquet"), (signal.SIGINT, "zarr")]
)
def test_a_killed_or_interrupted_sweep_is_resumed_to_the_same_numbers(tmp_path, store_format, end):
    process, script = started(tmp_path, store_format, 3)
    with pytest.raises(StoreInUse, match=f"is being written by process {process.pid} on .*: wait for it, or end it"):
        sweep(lambda x: x, {"x": [1.0]}, store=tmp_path / "s")
    process.send_signal(end)
    _, errors = process.communicate(timeout=600)
    assert process.returncode == (-signal.SIGKILL if end == signal.SIGKILL else -signal.SIGINT), errors
    if end == signal.SIGINT:
        assert errors.rstrip().endswith(b"KeyboardInterrupt")
    before = (tmp_path / "s" / "_done").read_text().splitlines()
    assert 3 <= len(before) < 20
    subprocess.run([sys.executable, script, tmp_path / "s", store_format], check=True, timeout=600)
    assert (tmp_path / "s" / "_done").read_text().splitlines()[: len(before)] == before

    namespace = {}
    exec(SLOW.split("sweep(slow")[0].replace("time.sleep(0.01)", "pass"), namespace)
    whole = sweep(namespace["slow"], Grid(x=axis([0.0, 1.0, 2.0, 3.0], "m"), draw=samples(50)), workers=1)
    if store_format == "zarr":
        assert_array_equal(open_sweep(tmp_path / "s")["y"], whole["y"])
    else:
        table = pytest.importorskip("pandas").read_parquet(tmp_path / "s").sort_values(["x", "draw"])
        assert_array_equal(table["y"], whole["y"].values.ravel())


def broken(x):
    if x == 3:
        raise ValueError("three")
    return {"y": 2.0 * x, "none": float("nan"), "zero": 0.0}


OF_ZARR = ["y/c/1", "none/c/1", "zero/c/1", "error/c/1"]
OF_PARQUET = ["part-00000001.parquet"]
FILES = [("zarr", file) for file in OF_ZARR] + [("parquet", file) for file in OF_PARQUET]


def stored(tmp_path, store_format):
    """A finished sweep of four blocks, the second with a point that failed; its options and results."""
    options = {"store": tmp_path / "s", "block_points": 2, "workers": 1, "store_format": store_format}
    return options, sweep(broken, {"x": range(8)}, **options).load()


def mended(options, first):
    """Only the block that is not whole is computed again, with a warning; then all are whole."""
    seen = []
    with pytest.warns(UserWarning, match="1 of 4 blocks .*lost or damaged.*computed again"):
        again = sweep(broken, {"x": range(8)}, progress=seen.append, **options)
    same(again.load(), first)
    assert seen[0].done == 6
    same(sweep(broken, {"x": range(8)}, **options).load(), first)


@pytest.mark.parametrize(("store_format", "file"), FILES)
def test_a_lost_chunk_is_not_done(tmp_path, store_format, file):
    options, first = stored(tmp_path, store_format)
    (tmp_path / "s" / file).unlink()
    if store_format == "zarr" and not file.startswith("error"):
        with pytest.raises(SweepError, match="1 of 4 blocks .* call the sweep again"):
            open_sweep(tmp_path / "s")
    mended(options, first)


@pytest.mark.parametrize(("store_format", "file"), FILES)
def test_a_flipped_bit_is_seen(tmp_path, store_format, file):
    path = tmp_path / "s" / file
    options, first = stored(tmp_path, store_format)
    whole = path.read_bytes()
    seen = 0
    # One of them may mean nothing, as the writer's name in a table: then no number changes.
    for place in range(0, len(whole), max(1, len(whole) // 4)):
        flipped = bytearray(whole)
        flipped[place] ^= 0x10
        path.write_bytes(flipped)
        if store_format == "zarr":
            try:
                same(open_sweep(tmp_path / "s").load().assign_attrs(first.attrs), first)
            except AssertionError:
                raise
            except Exception:
                seen += 1
        with warnings.catch_warnings(record=True) as warned:
            warnings.simplefilter("always")
            same(sweep(broken, {"x": range(8)}, **options).load(), first)
        seen += bool(warned)
    assert seen > 1


@pytest.mark.parametrize("store_format", FORMATS)
def test_a_damaged_line_of_the_journal_is_not_done(tmp_path, store_format):
    options, first = stored(tmp_path, store_format)
    journal = tmp_path / "s" / "_done"
    lines = journal.read_bytes().splitlines()
    for damaged in (b"1 2 \xff 7", b"", b"1", b"9 2 0 77", b"-1 2 0 77"):
        journal.write_bytes(b"\n".join([lines[0], damaged, *lines[2:], b""]))
        seen = []
        same(sweep(broken, {"x": range(8)}, progress=seen.append, **options).load(), first)
        assert seen[0].done == 6, damaged


@pytest.mark.parametrize("store_format", FORMATS)
def test_pipes_and_links_in_a_store_are_refused(tmp_path, store_format):
    store, precious = tmp_path / "s", tmp_path / "precious"
    options = {"store": store, "store_format": store_format}
    sweep(drawn, GRID, **options)
    precious.write_text("precious")
    files = [file for file in store.rglob("*") if file.is_file()]
    assert len(files) > 4
    for file in files:
        aside = tmp_path / "aside"
        file.rename(aside)
        for odd in (os.mkfifo, lambda file: file.symlink_to("/dev/zero"), lambda file: file.symlink_to(precious)):
            odd(file)
            for opened in (lambda: sweep(drawn, GRID, **options), lambda: open_sweep(store)):
                with pytest.raises(ValueError, match="is a link, a pipe or a device") as refused:
                    opened()
                assert str(file) in str(refused.value)
            file.unlink()
        aside.rename(file)
    assert precious.read_text() == "precious"
    sweep(drawn, GRID, **options)


def damaged(whole, random):
    """The bytes of a file with one damage: cut, grown, flipped, a part moved, or filled."""
    place = random.randrange(len(whole) + 1)
    before, part, rest = whole[:place], whole[place : place + 8], whole[place + 8 :]
    flipped = bytes(byte ^ 1 << random.randrange(8) for byte in part)
    changes = (b"", random.randbytes(9) + part + rest, flipped + rest, rest + part, b"\xff" * len(part) + rest)
    return before + random.choice(changes)


@pytest.mark.parametrize("store_format", FORMATS)
@pytest.mark.filterwarnings("ignore")
def test_a_broken_store_is_refused_or_computed_again(tmp_path, store_format):
    """Of `CAMPAIGN_CASES` broken files, 20 by default, none changes a number."""
    whole, store, random = sweep(drawn, GRID), tmp_path / "s", Random(65)
    options = {"store": store, "store_format": store_format, "block_points": 6}
    sweep(drawn, GRID, **options)
    files = sorted(file for file in store.rglob("*") if file.is_file() and file.stat().st_size)
    for _ in range(int(os.environ.get("CAMPAIGN_CASES", 20))):
        file = random.choice(files)
        sound = file.read_bytes()
        file.write_bytes(damaged(sound, random))
        try:
            same(sweep(drawn, GRID, **options), whole)
        except AssertionError:
            raise AssertionError(file) from None
        except Exception as error:
            assert str(error), file
        shutil.rmtree(store)
        sweep(drawn, GRID, **options)
