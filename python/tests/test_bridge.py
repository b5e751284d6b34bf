"""A driver in Python: a device for a run, and the guide's lines beside stand-ins for the makers' libraries."""

import math
import re
import statistics
import sys
import threading
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import pytest

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


class Robot:
    """That of the example in C++: a speed loop of 10 Hz that is 4 ms late, a hand of 1 kg and 10 N·s/m, in samples of 1 ms."""

    def __init__(self) -> None:
        self.late = [0.0] * 4
        self.position = self.velocity = self.rate = 0.0

    def step(self, command: float) -> None:
        self.late.append(command)
        held, natural, fine = self.late.pop(0), 2 * math.pi * 10, 1e-4
        for _ in range(10):
            self.rate += fine * natural * (natural * (held - self.velocity) - 1.6 * self.rate)
            self.velocity += fine * self.rate
            self.position += fine * self.velocity

    def force(self, push: float) -> float:
        return push - self.rate - 10 * self.velocity


def test_a_robot_that_python_ticks_rests_where_its_wall_says(tmp_path) -> None:
    file, wall = tmp_path / "robot.toml", tmp_path / "wall.toml"
    body = "body_inertance_n_s_mu_per_m = 8\nbody_damping_n_s_per_m = 60\nhand_stiffness_n_per_m = [0, 300]\n"
    file.write_text(f"[admittance]\nbandwidth_hz = 10\ndead_time_s = 0.004\n{body}")
    wall.write_text(
        "[wall]\norder = 1\nstiffness_n_per_m = 1000\ndissipation_n_s_mu_per_m = 10\nduration_s = 3\nsample_time_s = 0.001\n"
    )
    robot, pushed, over, places = Robot(), threading.Event(), threading.Event(), []

    def haptic() -> None:
        time_us = 0
        while not over.is_set():
            time_us += 1000
            # Nobody pushes while its sensor rests, nor waits for it.
            time_us < 300_000 or device.wait()
            device.sense([robot.force(2.0 if pushed.is_set() else 0.0), 0.0, 0.0])
            velocity = device.tick_motion(time_us, [robot.position, 0.0, 0.0])
            robot.step(velocity[0])
            places.append((robot.position, velocity[0]))

    limits = {"force_max_n": 20.0, "force_rate_max_n_per_s": 1e4, "sensed_force_max_n": 50.0}
    with AT_ANY(name="py robot", robot=file, **limits) as device:
        with pytest.raises(ValueError, match="call tick_motion"):
            device.tick(0, [0.0] * 3)
        thread = threading.Thread(target=haptic)
        thread.start()
        patient = {"watchdog_s": 1.0, "late_ticks": 0, "max_age_ticks": 1000, "device_model": file}
        name = f"tcp:127.0.0.1:{device.port}"
        try:
            experiment.run(wall, device=name, progress=lambda _: pushed.set(), out=tmp_path / "run", **patient)
        finally:
            pushed.clear()
            over.set()
            thread.join()
        assert device.fault is None and device.reason is None
    # At the end of the run the command rests at 2 N over 1 kN/m, and the robot with it.
    # A place where it only turns is one of few.
    rested = statistics.median(place for place, velocity in places if abs(velocity) < 1e-6 and place > 1e-3)
    assert abs(rested / 2e-3 - 1) < 0.01
    assert places[-1][1] == 0.0
    with AT_ANY(name="py", force_max_n=1.0, force_rate_max_n_per_s=1e3) as device, pytest.raises(ValueError, match="call tick, or give robot"):
        device.tick_motion(0, [0.0] * 3)


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
