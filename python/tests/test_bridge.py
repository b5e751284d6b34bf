"""A driver in Python: a device for a run, and the guide's lines beside stand-ins for the makers' libraries."""

import re
import sys
import threading
from functools import partial
from pathlib import Path
from types import SimpleNamespace

from fractional_haptics import bridge, experiment
from fractional_haptics.bridge import Bridge

AT_ANY = partial(Bridge, listen="127.0.0.1:0")
NOTHING = (0.0, 0.0, 0.0)


def test_a_run_feels_what_python_ticks(tmp_path) -> None:
    pressed, over, forces = threading.Event(), threading.Event(), []

    def haptic() -> None:
        # Time is counted, so that a busy machine is not late.
        time_us, position_m = 0, -0.002
        while not over.is_set():
            time_us += 1000
            device.wait()
            forces.append(device.tick(time_us, [position_m, 9.0, 9.0]))
            position_m = min(position_m + 1e-5, 0.002) if pressed.is_set() else position_m

    with AT_ANY(name="py", axes=1, force_max_n=3.0, force_rate_max_n_per_s=2000.0) as device:
        thread = threading.Thread(target=haptic)
        thread.start()
        # As patient as a device may be asked to be.
        patient = {"watchdog_s": 1.0, "late_ticks": 0, "max_age_ticks": 1000}
        name = f"tcp:127.0.0.1:{device.port}"
        keys = {"contact": "rigid", "force_limit_n": 2.0, "ramp_time_s": 0.1, "duration_s": 0.8, "out": tmp_path / "run", **patient}
        try:
            experiment.relax(device=name, progress=lambda _: pressed.set(), **keys)
        finally:
            over.set()
            thread.join()
        assert device.fault is None and device.reason is None
    assert 0.1 < max(abs(force[0]) for force in forces) <= 2.0
    assert all(force[1:] == NOTHING[1:] for force in forces)


def test_the_lines_of_the_guide_drive_a_device(monkeypatch) -> None:
    page = (Path(__file__).parents[2] / "docs/guide/src/bridge.md").read_text()
    first, second = re.findall(r"```python\n(.*?)```", page, re.S)
    said: list[object] = []

    def force(force) -> int:
        return said.append(tuple(force)) or 0

    def close() -> None:
        said.append("closed")

    def device(callback) -> SimpleNamespace:
        return SimpleNamespace(close=close, ticked=[callback(), callback()])

    dhd = SimpleNamespace(open=int, getButton=lambda _: len(said) > 1, getPosition=lambda _: -1, setForce=force, close=close)
    hd = SimpleNamespace(get_transform=lambda: [[1.0] * 4] * 4, set_force=force)
    for name, contents in {
        "forcedimension_core": {"dhd": dhd},
        "pyOpenHaptics": {"hd": hd},
        "pyOpenHaptics.hd_callback": {"hd_callback": lambda call: call},
        "pyOpenHaptics.hd_device": {"HapticDevice": device},
    }.items():
        monkeypatch.setitem(sys.modules, name, SimpleNamespace(**contents))
    monkeypatch.setattr(bridge, "Bridge", AT_ANY)
    known = {"input": str}
    exec(first, known)
    assert said == [NOTHING, NOTHING, NOTHING, "closed"]
    said.clear()
    exec(second, known)
    assert said == [NOTHING, NOTHING, "closed"]
