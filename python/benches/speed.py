"""Promises of speed, as ratios within one run where there is something to compare with: SciPy, Rust, processes.

::

    pip install ./python scipy
    python python/benches/speed.py

Needs the source tree and Cargo for the comparison with Rust. Prints a line for each promise, and fails if one is broken.
What is compared runs in turns, so that a machine that is busy with other things is as slow for both, and the best of each counts;
where one thread works, by its own clock, which stands still while others have the processor.
"""

from __future__ import annotations

import multiprocessing
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np
from scipy.signal import fftconvolve

from fractional_haptics.analysis import Device, region
from fractional_haptics.operators import Operator, differintegrate, grunwald_weights

ROOT = Path(__file__).resolve().parents[2]
T = 1e-3
RUNS = 9


def best(call: Callable[[], object], runs: int = RUNS) -> float:
    """Shortest of several runs, s."""
    return min(taken(call, time.perf_counter) for _ in range(runs))


def taken(call: Callable[[], object], clock: Callable[[], float]) -> float:
    """Time of one run, s."""
    start = clock()
    call()
    return clock() - start


def in_turns(ours: Callable[[], object], theirs: Callable[[], object], clock: Callable[[], float]) -> tuple[float, float]:
    """Shortest of several runs of each, in turns, s."""
    times = [(taken(ours, clock), taken(theirs, clock)) for _ in range(RUNS)]
    return min(own for own, _ in times), min(other for _, other in times)


def against_scipy() -> float:
    """Time of a record of 1e6 samples, in that of SciPy with the weights known."""
    x = np.random.default_rng(1).standard_normal(1_000_000)
    weights = grunwald_weights(0.5, x.size) * T**-0.5
    scipys = lambda: fftconvolve(x, weights)[: x.size]  # noqa: E731
    ours, theirs = in_turns(lambda: differintegrate(x, 0.5, T), scipys, time.process_time)
    difference = differintegrate(x, 0.5, T) - scipys()
    print(f"  ours {ours * 1e3:.0f} ms, SciPy {theirs * 1e3:.0f} ms, difference {np.max(np.abs(difference)):.1e}")
    return ours / theirs


def against_rust(schemes: tuple[str, ...] = ("full", "grunwald:100", "tustin-muir:9")) -> float:
    """Time per sample of a block of 1e5, in that of Rust; the worst of some schemes."""
    samples = 100_000
    command = "cargo run --quiet --release -p fracdiff --all-features --example step_rate --".split()
    block = np.sin(0.01 * np.arange(samples))
    operators = {scheme: Operator(0.5, T, scheme) for scheme in schemes}
    ours, theirs = (dict.fromkeys(schemes, float("inf")) for _ in range(2))
    for _ in range(RUNS):
        output = subprocess.run([*command, str(samples), *schemes], cwd=ROOT, check=True, capture_output=True, text=True).stdout
        for line in output.splitlines():
            scheme, nanoseconds = line.split()
            theirs[scheme] = min(theirs[scheme], float(nanoseconds))
            operator = operators[scheme]
            ours[scheme] = min(ours[scheme], best(lambda: operator.process(block), 3) / samples * 1e9)  # noqa: B023
    for scheme in schemes:
        print(f"  {scheme}: {ours[scheme]:.1f} ns, Rust {theirs[scheme]:.1f} ns")
    return max(ours[scheme] / theirs[scheme] for scheme in schemes)


def step() -> float:
    """Time of one `step`, the loop around it included, µs."""
    step = Operator(0.5, T).step
    count = 200_000

    def run() -> None:
        for _ in range(count):
            step(1.0)

    return best(run) / count * 1e6


def two_threads() -> float:
    """Work done by two threads, in that of two processes: all that the machine can do just now, twice that of one where it is idle."""
    context = multiprocessing.get_context("spawn")
    with ExitStack() as stack:
        pairs = []
        for start in (threading.Thread, context.Process):
            ends = []
            for _ in range(2):
                here, there = context.Pipe()
                worker = start(target=blocks_on_demand, args=(there,))
                worker.start()
                stack.callback(worker.join)
                stack.callback(here.send, False)
                here.recv()
                ends.append(here)
            pairs.append(lambda ends=ends: ([end.send(True) for end in ends], [end.recv() for end in ends]))
        threads, processes = in_turns(*pairs, time.perf_counter)
    return processes / threads


def blocks_on_demand(end: Connection) -> None:
    """A block through an operator each time that it is asked for."""
    operator, block = Operator(0.5, T), np.sin(0.01 * np.arange(1_000_000))
    end.send(True)
    while end.recv():
        operator.process(block)
        end.send(True)


def first_import() -> float:
    """Import and first result in a new interpreter, less the start of the interpreter, s."""
    code = "import fractional_haptics.operators as o; o.Operator(0.5, 1e-3).step(1.0)"
    run = lambda code: best(lambda: subprocess.run([sys.executable, "-c", code], check=True), 5)  # noqa: E731
    return run(code) - run("pass")


def a_region() -> float:
    """A region of stable walls with 500 points on its boundary, ms."""
    device = Device(0.065, 3.5)
    return best(lambda: region(device, 0.5, T), 200) * 1e3


PROMISES = [
    ("differintegrate, 1e6 samples, in the time of SciPy's fftconvolve", against_scipy, "<=", 1.0),
    ("Operator.process, per sample, in the time of Rust", against_rust, "<=", 1.3),
    ("Operator.step, µs", step, "<=", 0.3),
    # Two idle cores: 1.7 times the work of one thread.
    ("two threads, in the work of two processes", two_threads, ">=", 1.7 / 2),
    ("region, ms", a_region, "<=", 1.0),
    ("import and first result, s", first_import, "<=", 0.2),
]


def main() -> None:
    broken = []
    for name, measure, sign, limit in PROMISES:
        print(name)
        have = measure()
        kept = have <= limit if sign == "<=" else have >= limit
        print(f"  {have:.3g}, promised {sign} {limit}{'' if kept else '  BROKEN'}")
        if not kept:
            broken.append(name)
    sys.exit(", ".join(broken) or None)


if __name__ == "__main__":
    main()
