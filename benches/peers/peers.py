"""Python's side of the comparison with peers, and the table. See `run`, which does it all.

    peers.py export OUT            taps and the fitted constants of fracmem, for peers.c
    peers.py measure OUT           SciPy, CMSIS-DSP, differint, pycaputo
    peers.py table OUT DOCUMENT    writes the table between the marks of the document
"""

import json
import math
import os
import shutil
import sys
import time
from datetime import date
from importlib.metadata import version
from pathlib import Path

import numpy as np

SAMPLES = 200_000
MU = 0.2247
T = 1e-3
RUNS = 7
# Quadratic methods get a shorter record.
SHORT = 10_000


def signal(count=SAMPLES):
    """0 to 1 in the first second, then held."""
    return np.minimum(np.arange(count) * T, 1.0)


def weights(count):
    j = np.arange(1, count)
    return np.concatenate([[1.0], np.cumprod(1.0 - (MU + 1.0) / j)])


def closed_form(count=SAMPLES):
    """D^mu of the ramp, less that of the ramp from 1 s on (Caputo = Grünwald, as x starts at 0)."""
    t = np.arange(count) * T
    p = 1.0 - MU
    return (t**p - np.maximum(t - 1.0, 0.0) ** p) / math.gamma(2.0 - MU)


def put(out, name, y, ns, size, no_std, takes):
    slug = "".join(c if c.isalnum() else "_" for c in name) + ".f64"
    np.asarray(y, dtype="<f8").tofile(out / slug)
    row = dict(name=name, file=slug, ns=ns, bytes=size, no_std=no_std, takes=takes)
    with open(out / "results.jsonl", "a") as lines:
        lines.write(json.dumps(row) + "\n")
    print(f"{name}: {ns:.2f} ns")


def missing(out, name, why):
    with open(out / "results.jsonl", "a") as lines:
        lines.write(json.dumps(dict(name=name, missing=str(why))) + "\n")
    print(f"{name}: not measured, {why}")


def least(run, count, runs=RUNS):
    best = math.inf
    for _ in range(runs):
        start = time.thread_time_ns()
        y = run()
        best = min(best, time.thread_time_ns() - start)
    return y, best / count


def export(out):
    import fracmem
    from fracmem.embedded import export_c

    (T**-MU * weights(1024)).astype("<f8").tofile(out / "taps.f64")
    fitted = fracmem.CompressedFractionalFilter.from_analytic(alpha=MU, h=T, L=64, p=32, j_max=SAMPLES)
    export_c(fitted, str(out / "filt.c"))
    sources = Path(fracmem.__file__).parent / "embedded" / "c"
    for name in ("fracmemfilter.c", "fracmemfilter.h"):
        shutil.copy(sources / name, out / name)
    (out / "filt.h").write_text('#include "fracmemfilter.h"\nextern FracmemFilter filt;\nvoid filtSetup(void);\n')


def measure(out):
    x = signal()
    from scipy.signal import fftconvolve

    w = T**-MU * weights(SAMPLES)
    y, ns = least(lambda: fftconvolve(x, w)[:SAMPLES], SAMPLES)
    put(out, f"SciPy {version('scipy')} fftconvolve, f64", y, ns, None, False, "record")
    million, wide = signal(1_000_000), T**-MU * weights(1_000_000)
    y, ns = least(lambda: fftconvolve(million, wide)[:1_000_000], 1_000_000)
    put(out, "SciPy fftconvolve, 10^6 samples, weights not counted, f64", y, ns, None, False, "record")

    try:
        import cmsisdsp

        taps = np.ascontiguousarray((T**-MU * weights(1024))[::-1].astype(np.float32))
        single, block = x.astype(np.float32), 1000

        def fir():
            state = cmsisdsp.arm_fir_instance_f32()
            cmsisdsp.arm_fir_init_f32(state, 1024, taps, np.zeros(1024 + block - 1, np.float32))
            parts = [cmsisdsp.arm_fir_f32(state, single[n : n + block]) for n in range(0, SAMPLES, block)]
            return np.concatenate(parts)

        y, ns = least(fir, SAMPLES)
        name = f"CMSIS-DSP {version('cmsisdsp')} arm_fir_f32 1024, from Python in blocks of 1000"
        put(out, name, y, ns, 4 * (1024 + 2023), True, "block")
    except Exception as error:
        missing(out, "CMSIS-DSP", error)

    try:
        from differint.differint import GL

        y, ns = least(lambda: GL(MU, list(x), 0.0, (SAMPLES - 1) * T, SAMPLES), SAMPLES, 3)
        put(out, f"differint {version('differint')} GL, f64", y, ns, None, False, "record")
    except Exception as error:
        missing(out, "differint GL", error)

    try:
        from pycaputo import differentiation
        from pycaputo.differentiation import caputo, grunwald_letnikov
        from pycaputo.grid import make_uniform_points

        grid, short = make_uniform_points(SHORT, a=0.0, b=(SHORT - 1) * T), signal(SHORT)
        for name, method in (
            ("caputo.L1", caputo.L1(MU)),
            ("GrunwaldLetnikov", grunwald_letnikov.GrunwaldLetnikov(MU)),
        ):
            try:
                y, ns = least(lambda: differentiation.diff(method, short, grid), SHORT, 1)
                name = f"pycaputo {version('pycaputo')} {name}, {SHORT} samples, f64"
                put(out, name, y, ns, None, False, "record")
            except Exception as error:
                missing(out, f"pycaputo {name}", error)
    except Exception as error:
        missing(out, "pycaputo", error)


def relative(y, want, part):
    return float(np.max(np.abs(y[part] / want[part] - 1.0))) if len(y) >= part.stop else None


def number(value, digits=2):
    if value is None:
        return "–"
    if not math.isfinite(value):
        return "not finite"
    return f"{value:.{digits - 1}e}" if value < 0.1 or value >= 10 else f"{value:.2g}"


def size(count):
    if count is None:
        return "–"
    return f"{count} B" if count < 10_000 else f"{count / 1024:.0f} KiB"


def conditions():
    cpu = next(line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name"))
    rustc = os.popen("rustc --version").read().split()[1]
    cc = os.popen("cc --version").read().splitlines()[0]
    load = os.getloadavg()[0]
    return (
        f"**Conditions.** {cpu}, virtual machine with {os.cpu_count()} shared cores, load {load:.1f} when the table was made; "
        f"rustc {rustc} (release, thin LTO), {cc} (-O3), Python {sys.version.split()[0]}; default target x86-64 (SSE2) unless a row "
        f"says native; {date.today().isoformat()}. Input 0 to 1 in 1 s, held to 200 s; μ = {MU}, 1 kHz, {SAMPLES} samples. CPU time of the "
        "thread, the shortest batch of 4096 samples in nine runs (whole records: the shortest of seven). Errors are relative, "
        "against the closed form: first, the first sample after zero; ramp, the largest from 10 ms to 1 s; hold, the largest from 1 s to "
        "200 s; end, at 200 s. A Grünwald sum itself differs from the closed form by its sampling. Memory: coefficients and state of one axis."
    )


def table(out, document):
    rows = [json.loads(line) for line in open(out / "results.jsonl")]
    lines = [
        conditions(),
        "",
        "| what | ns a sample | first | ramp | hold | end | memory | takes | `no_std` |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    absent = []
    for row in rows:
        if "missing" in row:
            absent.append(f"- {row['name']}: {row['missing']}")
            continue
        y = np.fromfile(out / row["file"])
        want = closed_form(len(y))
        with np.errstate(all="ignore"):
            errors = [
                relative(y, want, slice(1, 2)),
                relative(y, want, slice(10, 1000)),
                relative(y, want, slice(1000, SAMPLES)),
                relative(y, want, slice(SAMPLES - 1, SAMPLES)),
            ]
        ns = f"{row['ns']:.1f}" if row["ns"] < 1000 else f"{row['ns']:.0f}"
        cells = [row["name"], ns, *map(number, errors), size(row["bytes"])]
        cells += [row["takes"], "yes" if row["no_std"] else "no"]
        lines.append("| " + " | ".join(cells) + " |")
    if absent:
        lines += ["", "Not measured:", "", *absent]
    start, end = "<!-- peers: written by benches/peers/run -->", "<!-- peers: end -->"
    text = Path(document).read_text()
    head, rest = text.split(start)
    tail = rest.split(end)[1]
    Path(document).write_text(head + start + "\n" + "\n".join(lines) + "\n" + end + tail)


if __name__ == "__main__":
    command, folder, *rest = sys.argv[1:]
    {"export": export, "measure": measure, "table": table}[command](Path(folder), *rest)
