"""The table of docs/performance.md. See `run`, which does it all.

    table.py export OUT            taps and the fitted constants of fracmem, for peers.c
    table.py measure OUT DOCUMENT  runs all programs in turns and writes the document's last part
"""

import json
import math
import os
import platform
import resource
import shutil
import subprocess
import sys
import time
from datetime import date
from pathlib import Path

import numpy as np

SAMPLES = 200_000
MU = 0.2247
T = 1e-3
# Each program runs once in a round, and the shortest time of all rounds counts.
ROUNDS = 5
MARK = "<!-- from here on by benches/table/run -->\n"
# Peers, each with ours that does the same.
PEERS = {
    "fracmem C step, 64 taps, 32 modes, f32": "FullMemory 1e-6, 200 s, f32",
    "liquid-dsp firfilt 1024, f32": "ShortMemory 1024, f32",
    "oxictl GrunwaldLeibniz 1024, f32": "ShortMemory 1024, f32",
    "oxictl TustinFrac 9, f32": "TustinMuir 9, f32",
    "biquad, Oustaloup 9 in 5 sections, f32": "Oustaloup 9, f32",
    "idsp, Oustaloup 9 in 5 sections, f32": "Oustaloup 9, f32",
    "SciPy fftconvolve, f64": "batch, full history, f64",
    "SciPy fftconvolve, 10^6 samples, weights known, f64": "batch, full history, 10^6 samples, f64",
}
UNITS = ((1e9, "s"), (1e6, "ms"), (1e3, "µs"), (1.0, "ns"))


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


def export(out):
    (T**-MU * weights(1024)).astype("<f8").tofile(out / "taps.f64")
    import fracmem
    from fracmem.embedded import export_c

    fitted = fracmem.CompressedFractionalFilter.from_analytic(alpha=MU, h=T, L=64, p=32, j_max=SAMPLES)
    export_c(fitted, str(out / "filt.c"))
    sources = Path(fracmem.__file__).parent / "embedded" / "c"
    for name in ("fracmemfilter.c", "fracmemfilter.h"):
        shutil.copy(sources / name, out / name)
    (out / "filt.h").write_text('#include "fracmemfilter.h"\nextern FracmemFilter filt;\nvoid filtSetup(void);\n')


def scipy_alone(out):
    """Whole records in this process."""
    try:
        from scipy.signal import fftconvolve
    except ImportError:
        return

    for name, count, known in (
        ("SciPy fftconvolve, f64", SAMPLES, False),
        ("SciPy fftconvolve, 10^6 samples, weights known, f64", 1_000_000, True),
    ):
        x, least = signal(count), math.inf
        w = T**-MU * weights(count)
        for _ in range(5):
            start = time.thread_time_ns()
            y = fftconvolve(x, w if known else T**-MU * weights(count))[:count]
            least = min(least, time.thread_time_ns() - start)
        file = f"scipy_{count}.f64"
        y.astype("<f8").tofile(out / file)
        row = dict(name=name, build="default", ns=least / count, file=file, bytes=None)
        with open(out / "results.jsonl", "a") as lines:
            lines.write(json.dumps(row) + "\n")


def ticks():
    """Ticks in which the processors worked, and all."""
    times = [int(field) for field in open("/proc/stat").readline().split()[1:9]]
    return sum(times) - times[3] - times[4], sum(times)


def own():
    """Processor time of this process and of those it has waited for, s."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(usage.ru_utime + usage.ru_stime for usage in used)


def measure(out, document):
    """Everything in turns; the share of the processors that others had meanwhile."""
    run = out / "run"
    core = str(max(os.sched_getaffinity(0)))
    default, native = (str(out / folder / "release/table") for folder in ("cargo", "cargo-native"))
    programs = [
        ["taskset", "-c", core, default, str(run), "default"],
        ["taskset", "-c", core, native, str(run), "native"],
    ]
    if (run / "peers").exists():
        programs.append(["taskset", "-c", core, str(run / "peers"), str(run), str(run / "taps.f64")])
    programs.append(["taskset", "-c", core, sys.executable, __file__, "scipy", str(run)])
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
    before, (busy, all_ticks) = own(), ticks()
    for _ in range(ROUNDS):
        for program in programs:
            subprocess.run(program, check=True, env=environment)
    (busy_after, all_after), spent = ticks(), own() - before
    whole = all_after - all_ticks
    others = max(0.0, (busy_after - busy - spent * os.sysconf("SC_CLK_TCK")) / whole)
    rows = [json.loads(line) for line in open(run / "results.jsonl")]
    text = document.read_text().split(MARK)[0]
    document.write_text(text + MARK + "\n".join(written(run, rows, others)) + "\n")


def written(run, rows, others):
    """The lines of the document's last part."""
    kernels = {row["kernels"] for row in rows if "kernels" in row}
    assert len(kernels) == 1, "the code was changed during the run"
    rows = [row for row in rows if "name" in row]
    least, first = {}, {}
    for row in rows:
        key = row["name"], row["build"]
        least[key] = min(least.get(key, math.inf), row["ns"])
        first.setdefault(row["name"], row)
    operators = [name for name, row in first.items() if "file" in row and name not in PEERS]
    lines = [
        f"\n**Conditions.** {conditions(others)} Kernels `{kernels.pop()}`.\n",
        "| operator | ns a sample | native | ramp | hold | end | memory |",
        "|---|---|---|---|---|---|---|",
    ]
    for name in operators:
        cells = [name, f"{least[name, 'default']:.1f}", over(least, name), *errors(run, first[name]), size(first[name]["bytes"])]
        lines.append("| " + " | ".join(cells) + " |")
    lines += ["\n| peer | ns a sample | ours | times faster | ramp | hold | end |", "|---|---|---|---|---|---|---|"]
    for name, ours in PEERS.items():
        if name not in first:
            lines.append(f"| {name} | not run here | {ours} | – | – | – | – |")
            continue
        ns = least[name, "default"]
        cells = [name, f"{ns:.1f}", ours, f"{ns / least[ours, 'default']:.2f}", *errors(run, first[name])]
        lines.append("| " + " | ".join(cells) + " |")
    lines += ["\n| whole task | time | native |", "|---|---|---|"]
    for name in first:
        if "file" not in first[name]:
            unit, word = next(unit for unit in UNITS if least[name, "default"] >= unit[0])
            lines.append(f"| {name} | {least[name, 'default'] / unit:.3g} {word} | {over(least, name)} |")
    return lines


def over(least, name):
    """The native build's time in that of the default one."""
    if (name, "native") not in least:
        return "–"
    return f"{least[name, 'native'] / least[name, 'default']:.2f}"


def errors(run, row):
    y = np.fromfile(run / row["file"])
    with np.errstate(all="ignore"):
        off = np.abs(y / closed_form(len(y)) - 1.0)
    return [number(float(np.max(off[part]))) for part in (slice(10, 1000), slice(1000, SAMPLES), slice(SAMPLES - 1, SAMPLES))]


def number(value):
    return f"{value:.1e}" if value < 0.1 else f"{value:.2g}"


def size(count):
    return f"{count} B" if count < 10_000 else f"{count / 1024:.0f} KiB"


def first_line(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()[0]


def conditions(others):
    cpu = next(line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name"))
    numbers = [line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith(("cpu family", "model\t"))][:2]
    compiler = first_line("cc", "--version") if shutil.which("cc") else "no C compiler"
    return (
        f"{cpu} (family {numbers[0]}, model {numbers[1]}), {os.cpu_count()} cores, of which other jobs had {100 * others:.0f} % during "
        f"the run; Linux {platform.release()}; {' '.join(first_line('rustc', '--version').split()[:2])} "
        f"(release, thin LTO; default: {platform.machine()} without flags, native: `-C target-cpu=native`); {compiler} (-O3); "
        f"Python {platform.python_version()}, NumPy {np.__version__}; {date.today().isoformat()}."
    )


if __name__ == "__main__":
    command, *paths = sys.argv[1:]
    {"export": export, "scipy": scipy_alone, "measure": measure}[command](*map(Path, paths))
