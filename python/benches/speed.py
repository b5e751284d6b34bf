"""Promises of speed, as ratios within one run where there is something to compare with: SciPy, Rust, one thread.

::

    pip install ./python scipy
    python python/benches/speed.py

Needs the source tree and Cargo for the comparison with Rust. Prints a line for each promise, and fails if one is broken.
"""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from collections.abc import Callable
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
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return min(times)


def against_scipy() -> float:
    """Time of a record of 1e6 samples, in that of SciPy with the weights known."""
    x = np.random.default_rng(1).standard_normal(1_000_000)
    weights = grunwald_weights(0.5, x.size) * T**-0.5
    ours = best(lambda: differintegrate(x, 0.5, T), 5)
    theirs = best(lambda: fftconvolve(x, weights)[: x.size], 5)
    difference = differintegrate(x, 0.5, T) - fftconvolve(x, weights)[: x.size]
    print(f"  ours {ours * 1e3:.0f} ms, SciPy {theirs * 1e3:.0f} ms, difference {np.max(np.abs(difference)):.1e}")
    return ours / theirs


def against_rust(schemes: tuple[str, ...] = ("full", "grunwald:100", "tustin-muir:9")) -> float:
    """Time per sample of a block of 1e5, in that of Rust; the worst of some schemes."""
    samples = 100_000
    command = "cargo run --quiet --release -p fracdiff --all-features --example step_rate --".split()
    output = subprocess.run(
        [*command, str(samples), *schemes], cwd=ROOT, check=True, capture_output=True, text=True
    ).stdout
    worst = 0.0
    for line in output.splitlines():
        scheme, nanoseconds = line.split()
        operator = Operator(0.5, T, scheme)
        block = np.sin(0.01 * np.arange(samples))
        ours = best(lambda: operator.process(block)) / samples * 1e9  # noqa: B023
        print(f"  {scheme}: {ours:.1f} ns, Rust {float(nanoseconds):.1f} ns")
        worst = max(worst, ours / float(nanoseconds))
    return worst


def step() -> float:
    """Time of one `step`, the loop around it included, µs."""
    step = Operator(0.5, T).step
    count = 200_000

    def run() -> None:
        for _ in range(count):
            step(1.0)

    return best(run) / count * 1e6


def two_threads() -> float:
    """Work done by two threads in the time of one."""
    block = np.sin(0.01 * np.arange(1_000_000))
    operators = [Operator(0.5, T) for _ in range(2)]

    def both() -> None:
        threads = [threading.Thread(target=operator.process, args=(block,)) for operator in operators]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()

    return 2 * best(lambda: operators[0].process(block)) / best(both)


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
    ("two threads, in the work of one", two_threads, ">=", 1.7),
    ("region, ms", a_region, "<=", 1.0),
    ("import and first result, s", first_import, "<=", 0.3),
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
    sys.exit(", ".join(broken))


if __name__ == "__main__":
    main()
