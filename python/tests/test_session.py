"""Sessions: walls that a hand feels on the simulated device and on emulated ones."""

from __future__ import annotations

import itertools
import json
import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from fractional_haptics import experiment, log, session, tissue
from test_signals import HOST_CLI, Device

WALLS = [
    {"order": 0.5, "stiffness": "300 N/m", "dissipation_n_s_mu_per_m": 5.0},
    {"order": 1.0, "stiffness_n_per_m": 150.0, "dissipation_n_s_mu_per_m": 2.0, "contact": "signed"},
]
PRESS = [(0.0, -5e-3), (0.2, 5e-3), (0.7, 5e-3), (0.9, -5e-3)]


def opened(folder: Path, name: str = "p07.mcap", **keys: object) -> session.Session:
    return session.open(force_limit="2 N", log=folder / name, **keys)


def test_what_is_felt_is_what_the_log_has(tmp_path: Path) -> None:
    seen: list[int] = []
    with opened(tmp_path) as s:
        s.allow(WALLS)
        s.hand(PRESS)
        first = s.feel(WALLS[0], seconds=0.5, surface="1 mm", progress=seen.append)
        # Another wall takes its place in the hand.
        second = s.feel(WALLS[1], seconds="0.1 s", surface="1 mm")
        s.rest()
        s.hand(PRESS)
        calls = itertools.count()
        third = s.feel(WALLS[1], until=lambda: next(calls) == 20, surface=1e-3)
        s.pause()
        s.mark("answer", "second")
    table = log.read_log(tmp_path / "p07.mcap")
    assert s.report is not None and s.report["samples"] == len(table) and s.report["dropped_samples"] == 0
    assert table.attrs["complete"] is True
    assert table.attrs["metadata"]["experiment"]["experiment"] == "session"
    assert "document" not in table.attrs["metadata"]["experiment"]
    events = [(kind, text) for _, kind, text in table.attrs["events"]]
    whole = ["feel", "certificate"]
    assert [kind for kind, _ in events] == [*whole, *whole, "rest", *whole, "pause", "answer"]
    assert events[-1][1] == "second" and "surface 0.001 m" in events[0][1]
    for felt in (first, second, third):
        ticks = round(felt.duration_s / 1e-3)
        part = table[felt.tick : felt.tick + ticks]
        inside = part["position_m"] > 1e-3
        force_n = part["commanded_force_n"].abs()[inside]
        assert felt.contacts == 1 and felt.dwell_s == pytest.approx(1e-3 * inside.sum())
        assert felt.peak_force_n == force_n.max() > 0.1
        assert felt.mean_force_n == pytest.approx(force_n.mean())
        assert felt.rms_force_n == pytest.approx(np.sqrt((force_n**2).mean()))
        assert felt.deepest_m == pytest.approx(part["position_m"].max() - 1e-3)
        assert "peak force" in str(felt) and felt.touched
        # The fade takes longer than the second was felt, and ends with the touch.
        exact = 0.0 if felt is second else 1.0
        assert felt.exact_share == exact and (felt.largest_step_n > 0.0) == (felt is second)
    assert [round(felt.duration_s, 6) for felt in (first, second, third)] == [0.5, 0.1, 0.4]
    # Two ticks after the last of the first: its certificate comes before.
    assert second.tick == first.tick + 502 and seen[-1] == 500


def test_a_rating_is_a_number_of_its_scale_and_stands_in_the_log_once(tmp_path: Path) -> None:
    with opened(tmp_path) as s:
        s.allow(WALLS[:1])
        s.hand(PRESS)
        s.feel(WALLS[0], seconds=0.5)
        for rating, scale, step, text in [
            ("much", (0, 10), None, "'much' is no number: give one from 0 to 10"),
            (None, None, None, "None is no number: give one above 0"),
            (10.5, (0, 10), None, "10.5 is not from 0 to 10"),
            (-1e-9, (0, 10), 0.5, "is not from 0 to 10"),
            (float("nan"), (0, 10), None, "nan is not from 0 to 10"),
            (True, (0, 10), None, "True is not"),
            (0, None, None, "0 is not above 0"),
            (float("inf"), None, None, "inf is not above 0"),
            (4.2, (1, 7), 1, "between the marks of its scale: give from 1 to 7 in steps of 1"),
            (4, (7, 1), None, "no low end below a high one"),
            (4, (0, float("inf")), None, "no low end below a high one"),
            (4, None, 1, "step 1 is none of the scale"),
            (4, (1, 7), 8, "step 8 is none of the scale"),
        ]:
            with pytest.raises(ValueError, match=text):
                s.rate(rating, scale=scale, step=step)
        assert s.rate(" 6.5 ", "softness", scale=(0, 10), step=0.5) == 6.5
        assert s.rate(np.float64(40.0), "size") == 40.0
        with pytest.raises(ValueError, match="nothing was felt since the last softness"):
            s.rate(6, "softness", scale=(0, 10))
        s.rest()
        # Nobody touched it.
        s.feel(WALLS[0], seconds=0.1)
        with pytest.raises(ValueError, match="nothing was felt"):
            s.rate(6)
    marks = [json.loads(text) for _, kind, text in log.read_log(s.log).attrs["events"] if kind == "rating"]
    assert marks == [
        {"question": "softness", "rating": 6.5, "scale": [0, 10], "step": 0.5},
        {"question": "size", "rating": 40.0, "scale": None, "step": None},
    ]


def test_the_same_session_is_the_same_log_bit_for_bit(tmp_path: Path) -> None:
    def run(name: str) -> np.ndarray:
        with opened(tmp_path, name, sensor_noise_m=1e-6, seed=3) as s:
            s.allow(WALLS)
            s.hand(PRESS)
            for wall in WALLS:
                s.feel(wall, seconds=0.45)
        return log.read_log(tmp_path / name)["commanded_force_n"].to_numpy()

    first, again = run("first.mcap"), run("again.mcap")
    assert np.array_equal(first, again) and first.min() < -0.5


@pytest.mark.parametrize(
    ("call", "error", "text"),
    [
        (lambda s: s.allow([WALLS[0], {**WALLS[0], "stiffness": "900 kN/m"}]), ValueError, "^wall 1: this would be unstable"),
        (lambda s: s.allow([{**WALLS[0], "mass": "1 kg"}]), ValueError, "mass_kg is not a key of a wall to feel"),
        (lambda s: s.allow([{"order": 0.5}]), ValueError, "missing"),
        (lambda s: s.feel(WALLS[1], seconds=1), ValueError, "was not allowed"),
        (lambda s: s.feel(WALLS[0]), ValueError, "give seconds or until"),
        (lambda s: s.feel(WALLS[0], seconds=-1.0), ValueError, "seconds = -1"),
        (lambda s: s.feel(WALLS[0], seconds=1, surface="-8 mm", patience="0.1 s"), TimeoutError, "not in front of the surface at -0.008 m after 0.1 s"),
        (lambda s: on_thread(lambda: s.mark("a")), RuntimeError, "of the thread that opened it"),
        (lambda s: s.mark("answer", "first"), ValueError, "nothing was felt"),
        (lambda s: s.mark("", "first"), ValueError, "the kind of a mark"),
        (lambda s: s.rate(5), ValueError, "nothing was felt since the last rating"),
        (lambda s: s.hand([(0.0, 1.0)]), ValueError, "the path of the hand"),
        (lambda s: session.open(force_limit="2 N", log=s.log), ValueError, "by another run"),
        (lambda s: session.open(log=s.log), ValueError, "`force_limit_n` is missing"),
        (lambda s: session.open(log=s.log, force_limit=2.0, order=0.5), ValueError, "order is of a wall"),
        (lambda s: session.open(log=s.log, force_limit=0.0), ValueError, "force_limit_n = 0"),
        (lambda s: session.open(log=s.log.with_suffix(".csv"), force_limit=2.0), ValueError, "p07.mcap"),
        (lambda s: session.open("serial:/dev/no-such-port", log=s.log.with_name("b.mcap"), force_limit=1.0), RuntimeError, "no-such-port"),
    ],
)
def test_what_is_wrong_is_refused_in_a_line_and_without_a_force(call, error: type, text: str, tmp_path: Path) -> None:
    with opened(tmp_path) as s:
        s.allow(WALLS[:1])
        with pytest.raises(error, match=text) as caught:
            call(s)
        assert "\n" not in str(caught.value)
    assert not log.read_log(s.log)["commanded_force_n"].any()
    with pytest.raises(ValueError, match="already exists"):
        session.open(force_limit="2 N", log=s.log)
    for late in (
        lambda: s.feel(WALLS[0], seconds=1), lambda: s.allow(WALLS), s.rest, s.pause, lambda: s.hand(PRESS), lambda: s.mark("a")
    ):  # fmt: skip
        with pytest.raises(RuntimeError, match="^the session is closed$"):
            late()


def on_thread(call) -> None:
    """Calls on another thread, and raises here what that raised."""
    with ThreadPoolExecutor() as pool:
        pool.submit(call).result()


def test_a_stop_from_progress_is_refused_and_ends_the_session_and_one_from_a_thread_is_obeyed(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError, match="^progress cannot call"):
        with opened(tmp_path) as s:
            s.allow(WALLS)
            s.feel(WALLS[0], seconds=1e6, progress=lambda _: s.stop())
    with pytest.raises(RuntimeError, match="interrupted.*its log"):
        with opened(tmp_path, "p08.mcap") as s:
            s.allow(WALLS)
            timer = threading.Timer(0.2, s.stop)
            timer.start()
            s.feel(WALLS[0], seconds=1e6)
    for name in ("p07.mcap", "p08.mcap"):
        assert log.read_log(tmp_path / name).attrs["metadata"]["end"]["ended"] == "interrupted"


def test_a_wall_that_the_touch_cannot_pay_for_is_said_to_be_softer(tmp_path: Path) -> None:
    springs = [{"order": 1.0, "stiffness_n_per_m": stiffness, "dissipation_n_s_mu_per_m": 0.0} for stiffness in (100.0, 300.0)]
    with session.open(force_limit="4 N", log=tmp_path / "p07.mcap") as s:
        s.allow(springs)
        s.hand([(0.0, -5e-3), (0.2, 8e-3)])
        s.feel(springs[0], seconds=1.0)
        with pytest.warns(RuntimeWarning, match="felt at down to 0.5"):
            felt = s.feel(springs[1], seconds=1.0)
        assert felt.energy_ticks > 800 and 0.5 < felt.least_factor < 0.6
        # Touched anew it is whole.
        s.hand([(0.0, 8e-3), (0.3, -5e-3), (0.6, 8e-3)])
        s.rest()
        again = s.feel(springs[1], seconds=0.5)
        assert again.exact_share == 1.0
    assert any("energy of their touch" in warning for warning in s.report["warnings"])
    certificates = [text for _, kind, text in log.read_log(s.log).attrs["events"] if kind == "certificate"]
    assert [text.split(";")[0] for text in certificates][::2] == ["exact 100.00 %"] * 2


def test_a_wall_that_nobody_touches_was_no_trial(tmp_path: Path) -> None:
    with opened(tmp_path) as s:
        s.allow(WALLS)
        felt = s.feel(WALLS[0], seconds=0.5)
        assert not felt.touched and felt.exact_share is None and felt.peak_force_n is None


SIMULATED = """
import sys
from fractional_haptics import session
wall = {"order": 0.5, "stiffness_n_per_m": 300.0, "dissipation_n_s_mu_per_m": 5.0}
with session.open(force_limit="2 N", log=sys.argv[1]) as s:
    s.allow([wall])
    print("felt", flush=True)
    s.feel(wall, seconds=1e6)
"""

FORKED = """
import os, sys
from fractional_haptics import session
with session.open(force_limit="2 N", log=sys.argv[1]) as s:
    child = os.fork()
    if child == 0:
        try:
            s.pause()
        except RuntimeError as error:
            print(error, flush=True)
    else:
        os.waitpid(child, 0)
        s.mark("parent")
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no forks here")
def test_a_fork_has_no_session_and_its_parent_keeps_it(tmp_path: Path) -> None:
    ended = subprocess.run([sys.executable, "-W", "ignore", "-c", FORKED, tmp_path / "p07.mcap"], capture_output=True, text=True, timeout=120)
    assert ended.stdout.startswith("this session is of the process"), ended.stderr
    assert ended.stderr.strip().splitlines()[-1].startswith("RuntimeError: this session is of the process")
    assert ended.returncode == 0
    assert log.read_log(tmp_path / "p07.mcap").attrs["metadata"]["end"]["ended"] == "finished"


@pytest.mark.skipif(sys.platform == "win32", reason="no signals here")
@pytest.mark.parametrize("number", ["SIGTERM", "SIGHUP", "SIGQUIT"])
def test_a_signal_closes_the_log_of_a_simulation_too(number: str, tmp_path: Path) -> None:
    person = subprocess.Popen([sys.executable, "-c", SIMULATED, tmp_path / "p07.mcap"], stdout=subprocess.PIPE, text=True)
    assert person.stdout is not None and person.stdout.readline() == "felt\n"
    person.send_signal(getattr(signal, number))
    person.communicate(timeout=60)
    assert person.returncode == -getattr(signal, number)
    assert log.read_log(tmp_path / "p07.mcap").attrs["metadata"]["end"]["ended"] == "interrupted"


def test_a_fault_ends_the_session_and_keeps_its_log(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError, match="faster than its limit.*the session ended at.*its log"):
        with opened(tmp_path, speed_limit_m_per_s=0.02) as s:
            s.allow(WALLS)
            s.hand(PRESS)
            s.feel(WALLS[0], seconds=3)
    table = log.read_log(tmp_path / "p07.mcap")
    assert table.attrs["metadata"]["end"]["ended"] == "fault" and table.attrs["complete"] is True


def test_a_handle_that_stays_is_waited_for_with_patience(tmp_path: Path) -> None:
    with opened(tmp_path) as s:
        s.allow(WALLS)
        s.hand([(0.0, -5e-3), (0.2, 5e-3), (2.0, 5e-3), (2.2, -5e-3)])
        s.feel(WALLS[0], seconds=0.5)
        with pytest.raises(TimeoutError, match="still in the wall after 0.3 s"):
            s.rest(patience="300 ms")
        s.rest()
        with pytest.raises(ValueError, match="nothing was felt"):
            s.mark("answer", "first")
            s.mark("answer", "twice")


def test_ctrl_c_lets_go_and_closes_the_log(tmp_path: Path) -> None:
    timer = threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        with opened(tmp_path, realtime=True) as s:
            s.allow(WALLS)
            s.hand(PRESS)
            s.feel(WALLS[0], until=lambda: False)
    assert time.monotonic() - began < 20
    table = log.read_log(tmp_path / "p07.mcap")
    assert table.attrs["metadata"]["end"]["ended"] == "interrupted" and table["commanded_force_n"].iloc[-1] == 0.0


on_emulated = pytest.mark.skipif(
    not HOST_CLI.exists() and "REQUIRE_ALL_CHECKS" not in os.environ, reason="no host-cli that emulates a device"
)
BUSY = {"watchdog_s": 1.0, "late_ticks": 0, "max_age_ticks": 1000}


@on_emulated
def test_a_board_is_armed_once_and_a_wall_that_comes_around_the_hand_pushes_nobody_out(tmp_path_factory) -> None:
    folder = tmp_path_factory.mktemp("s")
    board = Device(folder, "--kind own")
    name = f"tcp:127.0.0.1:{board.port}"
    try:
        # The board's own hand pulls the handle towards 8 mm: the second wall begins behind it. Its damping keeps that wall
        # stable behind the line of a busy machine too.
        hand = {"hand_stiffness_n_per_m": 100.0, "push_n": 0.8, "mass": "65 g", "damping_n_s_per_m": 20.0}
        with session.open(name, force_limit="2 N", log=folder / "p.mcap", **hand, **BUSY) as s:
            s.allow(WALLS)
            with pytest.raises(ValueError, match="a session on tcp:.* is open already"):
                session.open(name, force_limit="2 N", log=folder / "q.mcap")
            felt = s.feel(WALLS[0], seconds=0.2, surface="12 mm")
            assert felt.contacts == 0 and felt.peak_force_n is None
            with pytest.warns(RuntimeWarning, match="no more energy"):
                changed = s.feel(WALLS[0], seconds=0.6, surface="3 mm")
            assert changed.touched and changed.energy_ticks > 0
            s.mark("answer", "second")
            with pytest.raises(TimeoutError):
                s.rest(patience=0.1)
            s.pause()
            with pytest.raises(TimeoutError, match="not in front of the surface"):
                s.feel(WALLS[0], seconds=0.1, surface="3 mm", patience=0.2)
        table = log.read_log(folder / "p.mcap")
        kinds = [kind for _, kind, _ in table.attrs["events"] if kind != "lost"]
        assert kinds == ["feel", "certificate", "feel", "answer", "certificate", "pause"]
        assert table.attrs["metadata"]["end"]["ended"] == "finished"
        # The wall had taken no energy: it resists what goes deeper, and nothing comes back of more than that.
        assert table["position_m"].iloc[-1] > 7.5e-3 and table["applied_force_n"].iloc[-1] == 0.0
    finally:
        board.ends()


@on_emulated
def test_a_motor_that_gives_half_its_newtons_is_found_on_a_scale(tmp_path_factory) -> None:
    folder = tmp_path_factory.mktemp("s")
    board = Device(folder, "--kind own --device-model laboratory motor_gain=0.5 specimen=spring")
    model = folder / "device.toml"
    model.write_text("[device]\nmass_kg = 0.13\ndamping_n_s_per_m = 7.0\n")
    held = [0.0]
    heard: list[str] = []

    def read(words: str, force_n: float | None) -> float | None:
        heard.append(words)
        if force_n is None:
            return None
        # 50 mN of friction are missing on the way up, and too much on the way down; a scale shows grams.
        friction_n = 0.05 if force_n > held[-1] else -0.05
        held.append(force_n)
        return round((0.5 * force_n - friction_n) / 9.80665, 3) * 9.80665

    try:
        calibrated = experiment.calibrate(read, device=f"tcp:127.0.0.1:{board.port}", device_model=str(model), watchdog_s=1.0, max_age_ticks=1000)
    finally:
        board.ends()
    factor = calibrated["motor_factor"]
    assert factor["low"] < 0.5 < factor["high"] < factor["low"] + 0.1
    assert len(held) == 6 and len(heard) > 5
    assert "motor_factor" in calibrated["device_file"] and "mass_kg" in calibrated["device_file"]


@on_emulated
def test_a_servo_that_a_hand_turns_feels_the_wall_it_meets(tmp_path_factory) -> None:
    folder = tmp_path_factory.mktemp("s")
    board = Device(folder, "--kind moteus turn=2mm:0.5s")
    name = f"moteus:{board.line},radius=20mm,watchdog=1s,lost=1000"
    # Whoever turns it does not care for its damping; a line of a busy machine is late.
    device = {"mass": "1 kg", "damping_n_s_per_m": 100.0, "sample_time_s": 2e-3}
    try:
        with session.open(name, force_limit="0.5 N", log=folder / "p.mcap", **device, **BUSY) as s:
            s.allow(WALLS[:1])
            felt = s.feel(WALLS[0], seconds=1.2, surface="1 mm")
        assert felt.contacts >= 1 and felt.peak_force_n is not None and 0.0 < felt.peak_force_n <= 0.5
    finally:
        board.ends()


@on_emulated
def test_a_real_device_of_which_nobody_says_anything_gets_no_wall(tmp_path_factory) -> None:
    folder = tmp_path_factory.mktemp("s")
    board = Device(folder, "--kind moteus")
    try:
        with pytest.raises(ValueError, match="the device is unknown, so no wall can be judged: give"):
            name = f"moteus:{board.line},radius=20mm,watchdog=1s,lost=1000"
            session.open(name, force_limit="0.5 N", log=folder / "p.mcap", sample_time_s=2e-3, **BUSY)
    finally:
        board.ends()


LOST = """
import sys
from fractional_haptics import session
wall = {"order": 0.5, "stiffness_n_per_m": 300.0, "dissipation_n_s_mu_per_m": 5.0}
device, log = sys.argv[1:]
# So much damping that the wall is stable behind the line of a busy machine too.
patient = {"damping_n_s_per_m": 100.0, "watchdog_s": 1.0, "late_ticks": 0, "max_age_ticks": 1000}
with session.open(device, force_limit="2 N", log=log, **patient) as s:
    s.allow([wall])
    print("felt", flush=True)
    s.feel(wall, seconds=600, surface="5 mm")
"""


@on_emulated
@pytest.mark.parametrize("number", [None, signal.SIGTERM])
def test_a_lost_board_or_a_signal_ends_the_trial_and_keeps_the_log(number: int | None, tmp_path_factory) -> None:
    folder = tmp_path_factory.mktemp("s")
    board = Device(folder, "--kind own")
    log_file = folder / "p.mcap"
    command = [sys.executable, "-c", LOST, f"tcp:127.0.0.1:{board.port}", log_file]
    try:
        person = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        assert person.stdout is not None and person.stdout.readline() == "felt\n"
        time.sleep(0.2)
        if number is None:
            board.emulator.kill()
            _, said = person.communicate(timeout=60)
            last = said.strip().splitlines()[-1]
            assert last.startswith("RuntimeError: ") and "its log" in last, said
        else:
            person.send_signal(number)
            person.communicate(timeout=60)
            assert person.returncode == -number
        ended = log.read_log(log_file).attrs["metadata"]["end"]["ended"]
        assert ended == ("link" if number is None else "interrupted")
    finally:
        board.ends()


def solid(order: float, spring_pa: float, branch_pa: float, time_s: float) -> tissue.Material:
    model = tissue.Model("fractional-zener", viscosity_pa_s_alpha=branch_pa * time_s**order, order=order,
                         second_viscosity_pa_s_beta=branch_pa, second_order=0.0, elastic_modulus_pa=spring_pa)  # fmt: skip
    return tissue.Material("solid", "a solid", model, {"citation": "none", "conditions": "none", "checked": True, "residual": "none"})


def test_any_tissue_between_two_that_are_proved_is_felt(tmp_path: Path) -> None:
    with opened(tmp_path) as s:
        s.allow_between({"tissue": solid(0.2, 2e3, 2e3, 0.01)}, {"tissue": solid(0.9, 2e4, 3e4, 1.0)})
        s.allow([{"tissue": solid(0.5, 5e3, 1e4, 0.1), "scheme": "grunwald:300"}, {"tissue": "prostate-healthy"}])
        s.hand([(0.0, -5e-3), (0.3, 3e-3), (6.0, 3e-3)])
        for stimulus in ({"tissue": "prostate-healthy"}, {"tissue": solid(0.45, 5e3, 1e4, 0.1)}, {"tissue": solid(0.5, 5e3, 1e4, 0.1), "scheme": "grunwald:300"}):
            felt = s.feel(stimulus, seconds=1.0)
            assert felt.touched and felt.exact_share is not None and felt.exact_share > 0.7
        with pytest.raises(ValueError, match="the nearest inside has order = 0.9 for 0.95"):
            s.feel({"tissue": solid(0.95, 5e3, 1e4, 0.1)}, seconds=1.0)
        with pytest.raises(ValueError, match="not all of this region is proved stable"):
            s.allow_between({"tissue": solid(0.2, 2e3, 2e3, 0.01)}, {"tissue": solid(0.9, 2e4, 3e7, 1.0)})
        assert s.feel({"tissue": "prostate-healthy"}, seconds=0.1).touched
    # What was felt stands in the log, number by number.
    texts = " ".join(text for _, kind, text in log.read_log(s.log).attrs["events"] if kind == "feel")
    assert "tissue solid (fractional-zener: viscosity_pa_s_alpha" in texts and "order 0.45," in texts
