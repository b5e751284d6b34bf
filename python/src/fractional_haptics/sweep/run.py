"""A sweep from its arguments to its result."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Mapping
from contextlib import closing
from dataclasses import dataclass
from errno import ENOENT
from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as installed_version
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import xarray as xr

from .blocks import LARGEST_BLOCK, Blocks, shape_of
from .errors import SweepError
from .folder import Done, Folder, check_files, read_journal, read_manifest
from .grid import Grid
from .identity import identity
from .outputs import Output, Outputs, as_outputs, outputs_from
from .progress import Meter, Report
from .results import InMemory, Results, Stored
from .threads import Threads
from .work import Probe, Work, work_of

if TYPE_CHECKING:
    from distributed import Client

    from .cluster import Cluster

StoreFormat = Literal["zarr", "parquet"]

BLOCK_SECONDS = 1.0
"""Time of a block that is aimed at: far above what a task costs, short enough to lose."""

BLOCKS_PER_SECOND = 50.0
"""Blocks that one scheduler and one writer are given at most: many workers get longer blocks."""

_PROBED = 32  # points tried at most
_PROBE_SECONDS = 0.3
_BLOCKS_PER_WORKER = 4  # at least, so that all workers end at about the same time


def sweep(
    function: Callable[..., Any],
    grid: Grid | Mapping[str, Any],
    client: Client | None = None,
    store: str | os.PathLike[str] | None = None,
    *,
    outputs: Mapping[str, Output | str] | None = None,
    seed: int = 0,
    version: str | None = None,
    block_points: int | None = None,
    block_seconds: float | None = None,
    workers: int | None = None,
    store_format: StoreFormat | None = None,
    retry_failed: bool = False,
    progress: Report | bool | None = None,
    timeout: float = 300.0,
) -> xr.Dataset:
    """Computes a function at each point of a grid.

    Parameters
    ----------
    function : callable
        Called with the coordinates of a point by name, and with ``rng``, a `numpy.random.Generator`, if it names it.
        Returns a number, a small array, or a mapping of names to these.
    grid : Grid or mapping
        Points; a mapping is ``Grid(**mapping)``.
    client : dask.distributed.Client, optional
        Cluster that computes; without one, threads of this process.
    store : path, optional
        Folder that keeps each block as it is done. A sweep that was stopped goes on there; another one is refused.
    outputs : mapping, optional
        Variables of the result: an `Output` or a unit for each name. Without it the first points tell the names.
    seed : int
        Seed of all random numbers. The same seed gives the same numbers for any number of workers and any blocks.
    version : str, optional
        Version of whatever the function uses that its own code does not show; kept with the store and compared.
    block_points : int, optional
        Points of a block at most. Without it as many as take `block_seconds` by the time of the first points.
    block_seconds : float, optional
        Time of a block that is aimed at, 1 s by default, longer for more than 50 workers.
    workers : int, optional
        Threads without a client; as many as processors by default.
    store_format : {"zarr", "parquet"}, optional
        Format of a new store, Zarr by default: arrays with names and units, which can be opened at any time.
    retry_failed : bool
        Computes blocks with failed points again.
    progress : callable or bool, optional
        Called with a `Progress` after each block; True for a bar; by default a bar at a terminal.
    timeout : float
        Seconds that a scheduler may be silent or without workers.

    Returns
    -------
    xarray.Dataset
        A variable for each output along the dimensions of the grid, NaN where a point failed, and ``error`` with the
        texts of the errors. From a Zarr store it is read when it is looked at.

    Raises
    ------
    TypeError, ValueError
        A function, grid or output that cannot be, before anything is computed.
    StoreMismatch
        A store of another grid, function, seed or version; the text names each difference.
    StoreInUse
        A store that another sweep writes.
    ClusterLost
        A scheduler that is gone or has no workers. What is done is in the store.
    SweepError
        All first points fail, or the workers cannot load the function.
    KeyboardInterrupt
        Ctrl-C, at once: each thread ends by itself after its present point. What is done is in the store.

    Notes
    -----
    A point costs about 1 µs of Python beside the function, 11 µs more if it takes ``rng``; a block on a cluster some
    milliseconds. ``python/benches/sweep_overhead.py`` measures them.
    """
    grid = grid if isinstance(grid, Grid) else Grid(**grid)
    work = work_of(function, grid, seed)
    declared = None if outputs is None else as_outputs(outputs, grid)
    cut = _Cut(block_points, block_seconds)
    pool = _Pool(client, workers, timeout)
    if store is None:
        kept, shape = _plan(work, grid, declared, cut, pool)
        in_memory = InMemory(grid, kept)
        _compute(work, Blocks(grid, shape), kept, in_memory, None, pool, {}, progress)
        return in_memory.dataset(_attributes(work))
    if store_format not in (None, "zarr", "parquet"):
        raise ValueError(f'store_format is "zarr" or "parquet", not {store_format!r}')
    with closing(Folder(store)) as folder:
        manifest = _agreed(folder, work, grid, declared, version, store_format)
        if manifest is None:
            kept, shape = _plan(work, grid, declared, cut, pool)
            manifest = _manifest(work, grid, kept, version, store_format or "zarr", shape)
            folder.begin(manifest)
        kept = {name: Output.from_json(one) for name, one in manifest["outputs"].items()}
        blocks = Blocks(grid, tuple(manifest["block_shape"]))
        done = folder.done()
        results = _results(folder.path, manifest["store_format"], blocks, kept, fresh=not done)
        done = _whole(results, blocks, done)
        if retry_failed:
            done = {number: one for number, one in done.items() if one.failed == 0}
        _compute(work, blocks, kept, results, folder, pool, done, progress)
        return results.dataset(_attributes(work))


def open_sweep(store: str | os.PathLike[str]) -> xr.Dataset:
    """Opens what a store holds so far, also while a sweep writes it; NaN where nothing is yet.

    Parameters
    ----------
    store : path
        Folder of a sweep whose format is Zarr; the files of a Parquet store are read by pandas or a database.

    Raises
    ------
    FileNotFoundError
        No such folder.
    ValueError
        No sweep there, or one in Parquet; links or pipes in it.
    SweepError
        Blocks that were written are lost.
    """
    if Path(store).is_dir():
        check_files(store)
    manifest = read_manifest(Path(store))
    if manifest is None:
        if not Path(store).exists():
            raise FileNotFoundError(ENOENT, "no such store", os.fspath(store))
        raise ValueError(f"{os.fspath(store)} holds no sweep: give the folder that a sweep was given as store")
    if manifest["store_format"] != "zarr":
        raise ValueError(f'{os.fspath(store)} holds Parquet: read it by pandas.read_parquet("{os.fspath(store)}")')
    from .in_zarr import chunks_of, read

    done = len(read_journal(Path(store)))
    if done > (kept := chunks_of(Path(store), manifest["outputs"])):
        raise SweepError(
            f"{done - kept} of {done} blocks that were written to {os.fspath(store)} are lost: call the sweep again, "
            "which computes them anew"
        )
    return read(Path(store))


@dataclass(frozen=True)
class _Cut:
    """Wishes for the size of a block."""

    points: int | None
    seconds: float | None

    def __post_init__(self) -> None:
        if self.points is not None and not 1 <= self.points <= LARGEST_BLOCK:
            raise ValueError(f"block_points is from 1 to {LARGEST_BLOCK}, not {self.points!r}")
        if self.seconds is not None and not 0 < self.seconds < np.inf:
            raise ValueError(f"block_seconds is a positive time, not {self.seconds!r}")

    def points_of(self, tried: Probe, grid: Grid, width: int) -> int:
        """Points of a block by the time that points took."""
        if self.points is not None:
            return int(self.points)
        seconds = self.seconds if self.seconds is not None else max(BLOCK_SECONDS, width / BLOCKS_PER_SECOND)
        # The first call also loads what the function uses.
        measured = tried.seconds[1:] or tried.seconds
        cost = max(float(np.mean(measured)), 1e-6)
        return int(max(1, min(seconds / cost, ceil(grid.size / (_BLOCKS_PER_WORKER * width)))))


class _Pool:
    """Threads, or the cluster, made when they are needed: a finished store needs neither."""

    def __init__(self, client: Client | None, workers: int | None, timeout: float) -> None:
        if client is not None and workers is not None:
            raise ValueError("workers is for threads without a client: a cluster has the workers it was made with")
        self._made: Threads | Cluster | None = Threads(workers) if client is None else None
        self._client, self._timeout = client, timeout

    def get(self) -> Threads | Cluster:
        """The threads or the cluster."""
        if self._made is None:
            assert self._client is not None
            try:
                from .cluster import Cluster
            except ImportError:
                raise TypeError(
                    "the client is a dask.distributed.Client, which needs: pip install 'fractional-haptics[sweep]'"
                ) from None
            self._made = Cluster(self._client, self._timeout)
        return self._made


def _plan(
    work: Work, grid: Grid, declared: dict[str, Output] | None, cut: _Cut, pool: _Pool
) -> tuple[dict[str, Output], tuple[int, ...]]:
    """Outputs and shape of a block of a sweep that begins; tries some points for what is not given."""
    if declared is not None and cut.points is not None:
        return declared, shape_of(grid, int(cut.points))
    workers = pool.get()
    chosen = np.linspace(0, grid.size - 1, min(_PROBED, grid.size)).astype(np.int64)
    single = Blocks(grid, (1,) * len(grid.shape))
    tried = workers.probe(work, [single.part(int(index)) for index in chosen], _PROBE_SECONDS)
    if not tried.kinds and declared is None:
        raise SweepError(
            f"{len(chosen)} points all over the grid fail, so nothing is known of the result; the first: "
            f"{tried.error}. Mend the function, or give outputs"
        )
    if any(kinds != tried.kinds[0] for kinds in tried.kinds) and declared is None:
        raise SweepError("the first points return variables of different names or shapes: give outputs")
    kept = as_outputs(outputs_from(tried.kinds[0]), grid) if declared is None else declared
    return kept, shape_of(grid, cut.points_of(tried, grid, workers.width))


def _compute(
    work: Work,
    blocks: Blocks,
    outputs: Outputs,
    results: Results,
    folder: Folder | None,
    pool: _Pool,
    done: Mapping[int, Done],
    progress: Report | bool | None,
) -> None:
    """Computes and writes all blocks that are not done."""
    points = sum(one.points for one in done.values())
    failed = sum(one.failed for one in done.values())
    meter = Meter(blocks.grid.size, points, failed, progress)
    with closing(meter):
        if len(done) == len(blocks):
            return
        with closing(pool.get().blocks(work, outputs, blocks.parts(done))) as finished:
            for part, block in finished:
                results.write(part, block)
                if folder is not None and block.complete:
                    folder.mark(part.number, Done(part.size, len(block.errors), block.checksum()))
                meter.add(part.size, len(block.errors))


def _whole(results: Stored, blocks: Blocks, done: dict[int, Done]) -> dict[int, Done]:
    """The blocks of the journal that are read as they were written; says how many are not."""

    def is_whole(number: int) -> bool:
        try:
            return results.read(blocks.part(number)).checksum() == done[number].checksum
        except Exception:  # whatever a format calls what it cannot read
            return False

    said = [number for number in done if number < len(blocks)]
    whole = {number: done[number] for number in said if is_whole(number)}
    if lost := len(said) - len(whole):
        warnings.warn(
            f"{lost} of {len(blocks)} blocks in the store were lost or damaged and are computed again", stacklevel=3
        )
    return whole


def _agreed(
    folder: Folder,
    work: Work,
    grid: Grid,
    declared: dict[str, Output] | None,
    version: str | None,
    store_format: StoreFormat | None,
) -> dict[str, Any] | None:
    """Manifest of the store's sweep, which is the same as this one; None if there is none yet."""
    manifest = folder.manifest(_same(work, grid, version))
    if manifest is not None and declared is not None:
        folder.compare({"outputs": manifest["outputs"]}, {"outputs": _outputs_json(declared)})
    if manifest is not None and store_format is not None:
        folder.compare({"store_format": manifest["store_format"]}, {"store_format": store_format})
    return manifest


def _manifest(
    work: Work, grid: Grid, outputs: Outputs, version: str | None, store_format: str, shape: tuple[int, ...]
) -> dict[str, Any]:
    return {
        "same": _same(work, grid, version),
        "outputs": _outputs_json(outputs),
        "store_format": store_format,
        "block_shape": list(shape),
    }


def _same(work: Work, grid: Grid, version: str | None) -> dict[str, Any]:
    """What makes two sweeps the same."""
    return {
        "grid": grid.summary(),
        "function": identity(work.function, version),
        "seed": work.seed,
        "fractional_haptics": package_version(),
    }


def _outputs_json(outputs: Outputs) -> dict[str, Any]:
    return {name: one.to_json() for name, one in outputs.items()}


def _results(path: Path, store_format: str, blocks: Blocks, outputs: Outputs, *, fresh: bool) -> Stored:
    if store_format == "parquet":
        from .in_parquet import InParquet

        return InParquet(path, blocks, outputs)
    from .in_zarr import InZarr

    return InZarr(path, blocks, outputs, fresh=fresh)


def _attributes(work: Work) -> dict[str, Any]:
    name = getattr(work.function, "func", work.function)
    return {
        "function": f"{getattr(name, '__module__', '?')}.{getattr(name, '__qualname__', type(name).__name__)}",
        "seed": work.seed,
        "fractional_haptics": package_version(),
        "numpy": np.__version__,
    }


def package_version() -> str:
    """Version of this package as it is installed."""
    try:
        return installed_version("fractional-haptics")
    except PackageNotFoundError:
        return "not installed"
