"""Costs of a sweep beside its function: of a point, of a block, of a block on a cluster; and what they add up to.

    python python/benches/sweep_overhead.py [--pairs 3] [--blocks 20]

The overhead of Dask is a paired measurement: the same blocks of 1 s on two processes, by turns through a client into a
store and by ``concurrent.futures`` without scheduler or store. Their points sleep, so that other jobs on the machine
take little part.
"""

import argparse
import functools
import logging
import os
import pickle
import platform
import statistics
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
from distributed import Client, LocalCluster

from fractional_haptics.sweep import Grid, sweep
from fractional_haptics.sweep.blocks import Blocks
from fractional_haptics.sweep.in_zarr import InZarr
from fractional_haptics.sweep.outputs import Output
from fractional_haptics.sweep.threads import Threads
from fractional_haptics.sweep.work import Block, run, work_of

ONE = {"value": Output()}
WORKERS = 2


def nothing(x):
    """A point without cost."""
    return 1.0


def drawn(x, rng):
    """A point that asks for random numbers and draws none."""
    return 1.0


def sleeps(x):
    """A tenth of a second that takes no processor."""
    time.sleep(0.1)
    return 1.0


def seconds(task: Callable[[], object], clock: Callable[[], float] = time.perf_counter) -> float:
    """Time of a task."""
    started = clock()
    task()
    return clock() - started


def cost_of_a_point(function: Callable[..., float], points: int = 100_000) -> float:
    """Processor time of a point in one block, least of five."""
    grid = Grid(x=np.arange(float(points)))
    work, part = work_of(function, grid, 0), Blocks(grid, (points,)).part(0)
    return min(seconds(lambda: run(work, ONE, part), time.thread_time) for _ in range(5)) / points


def cost_of_a_block(store_format: str | None, points: int, blocks: int = 200) -> float:
    """Processor time of this process for a block without cost, beside that of its points."""
    grid = Grid(x=np.arange(float(points * blocks)))
    options = {"outputs": ONE, "block_points": points, "workers": 1}
    with tempfile.TemporaryDirectory() as folder:
        if store_format:
            options |= {"store": Path(folder) / "s", "store_format": store_format}
        whole = seconds(lambda: sweep(nothing, grid, **options), time.process_time)
    return whole / blocks - points * cost_of_a_point(nothing)


def cost_of_a_task(client: Client, blocks: int = 2000, **options) -> tuple[float, float]:
    """Time, and processor time of client and scheduler, for a block of one point."""
    grid = Grid(x=np.arange(float(blocks)))
    task = functools.partial(sweep, nothing, grid, client, outputs=ONE, block_points=1, **options)
    times = []
    busy = seconds(lambda: times.append(seconds(task)), time.process_time)
    return times[0] / blocks, busy / blocks


def rate_of_large_blocks(blocks: int = 10, points: int = 500_000) -> float:
    """Bytes that this process passes on in a second of processor: unpickled as from a worker, and written to Zarr."""
    cut = Blocks(Grid(x=np.arange(float(points * blocks))), (points,))
    values = np.random.default_rng(0).standard_normal(points)
    sent = [pickle.dumps(Block(number, {"value": values}, {}, 0.0), protocol=5) for number in range(blocks)]
    with tempfile.TemporaryDirectory() as folder:
        results = InZarr(Path(folder), cut, ONE, fresh=True)
        spent = seconds(
            lambda: [results.write(cut.part(n), pickle.loads(one)) for n, one in enumerate(sent)], time.process_time
        )
    return blocks * values.nbytes / spent


def overhead(client: Client, pairs: int, blocks: int) -> tuple[list[float], float]:
    """Time of blocks of 1 s by the client over that by plain processes, less one: of each pair, and of the shortest."""
    grid = Grid(x=np.arange(10.0 * blocks))
    work, parts = work_of(sleeps, grid, 0), list(Blocks(grid, (10,)).parts(()))
    times: list[tuple[float, float]] = []
    with ProcessPoolExecutor(WORKERS) as pool, tempfile.TemporaryDirectory() as folder:
        list(pool.map(abs, range(WORKERS)))  # started
        for pair in range(pairs):
            store = Path(folder) / str(pair)
            plain = seconds(lambda: list(pool.map(functools.partial(run, work, ONE), parts)))
            by_client = seconds(
                functools.partial(sweep, sleeps, grid, client, store, outputs=ONE, block_points=10, progress=False)
            )
            times.append((by_client, plain))
    shortest = min(one for one, _ in times) / min(one for _, one in times) - 1
    return [one / other - 1 for one, other in times], shortest


def main() -> None:
    """Measures and prints."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=int, default=3)
    parser.add_argument("--blocks", type=int, default=20)
    arguments = parser.parse_args()
    print(f"Python {platform.python_version()}, {os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}")
    print(f"a point: {1e6 * cost_of_a_point(nothing):.2f} µs; with rng {1e6 * cost_of_a_point(drawn):.1f} µs")
    for store_format in (None, "zarr", "parquet"):
        costs = [1e3 * cost_of_a_block(store_format, points) for points in (1, 1000, 10_000)]
        print(
            f"a block, {store_format or 'memory'}, of 1, 1000, 10 000 points: {', '.join(f'{c:.2f}' for c in costs)} ms"
        )
    print(f"large blocks, Zarr, random numbers: {1e-6 * rate_of_large_blocks():.0f} MB/s")
    print(f"threads by default: {Threads().width}")
    with (
        LocalCluster(
            n_workers=WORKERS, threads_per_worker=1, dashboard_address=":0", silence_logs=logging.CRITICAL
        ) as cluster,
        Client(cluster) as client,
    ):
        cost_of_a_task(client, 200)
        for name, options in {"memory": {}, "Zarr": {"store": Path(tempfile.mkdtemp()) / "s"}}.items():
            wall, busy = cost_of_a_task(client, **options)
            print(
                f"a task, {name}: {1e3 * wall:.2f} ms, of which client and scheduler {1e3 * busy:.2f} ms of processor"
            )
        found, shortest = overhead(client, arguments.pairs, arguments.blocks)
        shown = ", ".join(f"{100 * one:.1f}" for one in found)
        print(
            f"blocks of 1 s: Dask takes {shown} % longer, median {100 * statistics.median(found):.1f} %, "
            f"shortest by shortest {100 * shortest:.1f} %"
        )


if __name__ == "__main__":
    main()
