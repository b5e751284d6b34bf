"""Fits by SciPy and by this project in one run, 40 starts each: a fractional Maxwell model of the fish muscle, 566 samples, and a
fractional Zener model of an indentation by a sphere, ramp and hold, 2000 samples. Times are processor time of one thread.

python3 benches/identify_against_scipy.py     needs numpy, scipy, mpmath and cargo
"""

import os
import pathlib
import resource
import subprocess
import sys
import time

os.environ["OPENBLAS_NUM_THREADS"] = "1"
import numpy as np  # noqa: E402

ROOT = pathlib.Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "crates/tissue-identification/tests/golden/identify"))
import make_golden  # noqa: E402

EXAMPLE = ["cargo", "build", "--release", "--quiet", "--manifest-path", "benches/Cargo.toml", "--example", "identify_speed"]
TRIES = 5  # of identify_speed


def indentation(moduli_and_orders):
    """A record of identify_speed.rs as starts and a residual: stress of e = depth^1.5 that is linear between samples."""
    step_s, count = 0.01, 2000
    t = step_s * np.arange(count)
    e = np.minimum(2.0 * t, 1.0) ** 1.5
    rate = np.diff(e) / step_s

    def stress(x):
        # The integral of the relaxation modulus, whose transform is M/s^2.
        ln_s = np.log(make_golden.Z)[:, None] - np.log(t[1:])[None, :]
        m = make_golden.modulus("fractional-zener", x, ln_s)
        integral = t[1:] * ((make_golden.C / make_golden.Z)[:, None] * m).sum(axis=0).real
        weights = np.diff(integral, prepend=0.0)
        size = 2 * count
        return np.fft.irfft(np.fft.rfft(weights, size) * np.fft.rfft(rate, size), size)[: count - 1]

    truth = np.array(moduli_and_orders)
    truth[0::2] = np.log(truth[0::2])
    measured = stress(truth) * (1 + 0.01 * np.sin(37.0 * np.arange(1, count)))
    scale = measured.max()

    def residual(x):
        with np.errstate(all="ignore"):
            return np.nan_to_num((stress(x) - measured) / scale, nan=1e9, posinf=1e9, neginf=-1e9)

    return t[1:], np.log(measured / e[1:]), residual


def scipy_s(*record, **options):
    began = time.process_time()
    roots = make_golden.best(*record, **options)
    return time.process_time() - began, roots.min()


def own_s(what):
    def user():
        return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime

    began = user()
    subprocess.run([ROOT / "benches/target/release/examples/identify_speed", what], check=True, capture_output=True)
    return (user() - began) / TRIES


subprocess.run(EXAMPLE, cwd=ROOT, check=True)
def zener(*moduli_and_orders):
    axis, wanted, residual = indentation(moduli_and_orders)
    return scipy_s("record", "fractional-zener", axis, wanted, residual=residual)


for what, theirs in {
    "fractional-maxwell": lambda: scipy_s("relaxation", "fractional-maxwell", *make_golden.read("fish-muscle")),
    "indentation": lambda: zener(1500.0, 0.7, 3000.0, 0.15, 400.0),
    "flat-valley": lambda: zener(3000.0, 0.5, 2000.0, 0.2, 100.0),
}.items():
    (theirs_s, rms), ours_s = theirs(), own_s(what)
    print(f"{what}: SciPy {theirs_s:.2f} s, best rms {rms:.6f}; tissue-identification {ours_s:.3f} s; {theirs_s / ours_s:.0f} times")
for what in ("auto", "indentation-stiffening"):
    print(f"{what}: tissue-identification {own_s(what):.3f} s")
