"""A log of a run as a pandas table: whole, and cut in the middle as after a crash.

::

    python reading_a_log.py [LOG.mcap]
"""

import sys
import tempfile
from pathlib import Path

from fractional_haptics import experiment
from fractional_haptics.log import read_log

if len(sys.argv) > 1:
    path = Path(sys.argv[1])
else:
    folder = Path(tempfile.mkdtemp())
    experiment.relax(duration_s=3.0, ramp_time_s=0.5, out=folder)
    path = folder / "relax.mcap"

table = read_log(path)
print(table[["position_m", "commanded_force_n"]].describe())
print("whole:", table.attrs["complete"], "· began", table.attrs["started"])
print("tissue:", table.attrs["metadata"]["experiment"].get("tissue"))

# The device's time is the index: resample it as any series.
print(table["commanded_force_n"].groupby(table.index // 0.5 * 0.5).mean())

# Half of the file is still half of a log.
cut = Path(tempfile.mkdtemp()) / "cut.mcap"
cut.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
part = read_log(cut)
print(len(part), "of", len(table), "ticks;", part.attrs["damage"])
assert 0 < len(part) < len(table)
