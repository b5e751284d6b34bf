"""Examples of sweeps run and say what they promise."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("xarray")

EXAMPLES = Path(__file__).parent.parent / "examples"


def run(name, *arguments, cwd):
    """What an example prints."""
    environment = {**os.environ, "MPLCONFIGDIR": str(cwd)}
    done = subprocess.run(
        [sys.executable, EXAMPLES / name, *arguments], cwd=cwd, capture_output=True, text=True, timeout=120, env=environment
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_sweep_of_regions_finds_the_stiffest_wall_and_resumes(tmp_path):
    first = run("sweep_of_regions.py", cwd=tmp_path)
    assert first.startswith("delay 0.0 ms:")
    assert len(first.splitlines()) == 4
    assert run("sweep_of_regions.py", cwd=tmp_path) == first
    assert (tmp_path / "stiffest.zarr" / "_done").exists()


def test_the_robust_map_is_drawn(tmp_path):
    pytest.importorskip("matplotlib")
    shown = run("robust_stability_map.py", "--samples", "20", cwd=tmp_path)
    assert "840 walls on 20 devices" in shown
    assert "failed points: 0" in shown
    assert (tmp_path / "robust-stability.png").stat().st_size > 10_000
