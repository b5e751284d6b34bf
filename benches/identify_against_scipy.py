"""The fit of a fractional Maxwell model to the fish muscle, 566 samples and 40 starts, by SciPy and by this project in one run.

python3 benches/identify_against_scipy.py     needs numpy, scipy, mpmath and cargo; set OPENBLAS_NUM_THREADS=1 for one core
"""

import os
import pathlib
import subprocess
import sys
import time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
ROOT = pathlib.Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "crates/haptic-tissue/tests/golden/identify"))
import make_golden  # noqa: E402

axis, wanted = make_golden.read("fish-muscle")
began = time.perf_counter()
roots = make_golden.best("relaxation", "fractional-maxwell", axis, wanted)
scipy_s = time.perf_counter() - began
print(f"SciPy: {scipy_s:.2f} s, best rms {roots.min():.6f}")
ours = subprocess.run(
    ["cargo", "run", "--release", "--quiet", "-p", "haptic-tissue", "--features", "identify", "--example", "identify_speed"],
    cwd=ROOT, check=True, capture_output=True, text=True,
).stdout
for line in ours.splitlines():
    what, seconds = line.split()
    print(f"haptic-tissue, {what}: {float(seconds):.3f} s")
    if what == "fractional-maxwell":
        print(f"SciPy takes {scipy_s / float(seconds):.0f} times as long")
