"""No signal and no end of Python leaves a torque on a device: an emulated 2DIY, whose board has no watchdog, and a servo.

``host-cli`` emulates them: the built one in ``target/debug``, or ``HOST_CLI``.
"""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from random import Random

import pytest

HOST_CLI = Path(os.environ.get("HOST_CLI", Path(__file__).parents[2] / "target/debug/host-cli"))

pytestmark = pytest.mark.skipif(
    not HOST_CLI.exists() and "REQUIRE_ALL_CHECKS" not in os.environ, reason="no host-cli that emulates a device"
)

# What `host-cli` hears; those of Linux alone come last.
NAMES = "INT TERM HUP QUIT TSTP TTIN TTOU ALRM VTALRM PROF USR1 USR2 XCPU ABRT SYS TRAP IO PWR STKFLT RTMIN RTMAX"
SIGNALS = [getattr(signal, f"SIG{name}") for name in NAMES.split() if hasattr(signal, f"SIG{name}")]

CHILD = """
import sys, threading
from fractional_haptics import experiment
place, device, period_s, out = sys.argv[1:]
def run():
    experiment.relax(device=device, sample_time_s=float(period_s), watchdog_s=1.0, late_ticks=0, max_age_ticks=1000,
                     contact="rigid", force_limit_n=4.0, duration_s=300.0, out=out)
if place == "main":
    run()
threading.Thread(target=run, daemon=True).start()
sys.stdin.read() if place == "beside" else sys.stdin.readline()
"""


class Device:
    """An emulated device behind a line that keeps what a host sends."""

    def __init__(self, folder: Path, options: str) -> None:
        self.folder = folder
        self.sent = b""
        # What a host hears from now on instead of the device, over and over; nothing is a silence.
        self.flood: bytes | None = None
        self.line = folder / "line"
        # A service has a port of its own.
        listen = [] if "service_port" in options else ["--listen", "127.0.0.1:0"]
        command = [HOST_CLI, "device", "emulate", *options.split(), *listen, "--json"]
        self.emulator = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        assert self.emulator.stdout is not None
        path = json.loads(self.emulator.stdout.readline())["path"]
        self.port = int(path.rsplit(":", 1)[1])
        self.listener = socket.socket(socket.AF_UNIX)
        self.listener.bind(str(self.line))
        self.listener.listen()
        threading.Thread(target=self._pass_on, args=(self.port,), daemon=True).start()

    def _pass_on(self, port: int) -> None:
        host, _ = self.listener.accept()
        with host, socket.create_connection(("127.0.0.1", port)) as board:

            def answers() -> None:
                with contextlib.suppress(OSError):
                    while bytes_ := board.recv(4096):
                        while self.flood:
                            host.sendall(self.flood)
                        if self.flood is None:
                            host.sendall(bytes_)

            threading.Thread(target=answers, daemon=True).start()
            # Neither end has to wait until the other has read its last words.
            with contextlib.suppress(OSError):
                while bytes_ := host.recv(4096):
                    self.sent += bytes_
                    board.sendall(bytes_)
            # Closing it alone tells the board nothing while the other thread reads.
            with contextlib.suppress(OSError):
                board.shutdown(socket.SHUT_RDWR)

    def pushes(self) -> bool:
        """True if the last command on the line to a 2DIY sets torques, and not zero."""
        last = self.sent[-10:]
        return last[:2] == bytes([2, 5]) and any(last[2:])

    def ends(self) -> str:
        self.listener.close()
        self.emulator.send_signal(signal.SIGINT)
        return self.emulator.communicate(timeout=600)[1]


@pytest.fixture
def short(tmp_path_factory) -> Iterator[Path]:
    # The name of a socket has at most 107 bytes.
    yield tmp_path_factory.mktemp("s")


def started(place: str, name: str, period_s: float, folder: Path, before: Sequence[str] = ()) -> subprocess.Popen[str]:
    # A shell has what it runs in the background ignore SIGINT and SIGQUIT, and nohup SIGHUP.
    usual = ["env", "--default-signal"]
    command = [*usual, *before, sys.executable, "-c", CHILD, place, name, str(period_s), folder / "run"]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def sent(run: subprocess.Popen[str], number: int | None) -> None:
    """Sends a signal, or lets the main thread end."""
    if number is None:
        assert run.stdin is not None
        run.stdin.write("\n")
        run.stdin.flush()
    else:
        run.send_signal(number)


def ended(run: subprocess.Popen[str], within_s: float = 60.0) -> str:
    """By which signal the process is ended or stopped, or its exit code."""
    began = time.monotonic()
    while True:
        done, status = os.waitpid(run.pid, os.WNOHANG | os.WUNTRACED)
        if done != 0:
            break
        if time.monotonic() - began > within_s:
            return "not ended"
        time.sleep(0.01)
    if os.WIFSTOPPED(status):
        return "stopped"
    return f"signal {os.WTERMSIG(status)}" if os.WIFSIGNALED(status) else f"exit {os.WEXITSTATUS(status)}"


def end_of(number: int | None) -> set[str]:
    """What a signal does to any program; one that has no name in POSIX is told by the exit code."""
    if number is None:
        return {"exit 0"}
    if number in (signal.SIGTSTP, signal.SIGTTIN, signal.SIGTTOU):
        return {"stopped"}
    return {f"signal {number}"} | ({f"exit {128 + number}"} if number in SIGNALS[16:] else set())


def after(folder: Path, place: str, number: int | None) -> str:
    """What is wrong at a 2DIY after a signal while there is a torque; nothing where its torque is zero."""
    folder.mkdir()
    device = Device(folder, "--kind haply-2diy")
    run = started(place, f"haply:{device.line}", 0.01, folder)
    try:
        began = time.monotonic()
        while not device.pushes():
            if run.poll() is not None or time.monotonic() - began > 60:
                return f"no torque to take away: {run.communicate()[1]}"
            time.sleep(0.005)
        sent(run, number)
        how = ended(run, 20 if number == signal.SIGINT else 60)
        time.sleep(0.1)
        if device.pushes():
            return "the torque stays"
        if how == "not ended" and run.stdin is not None:
            # Python overlooks a signal that comes just before its main thread waits for input, until there is some.
            run.stdin.close()
            run.stdin = None
            how = ended(run)
        return "" if how in end_of(number) else f"ended otherwise: {how}"
    finally:
        run.kill()
        run.communicate()
        device.ends()


def at_all(folder: Path, place: str, numbers: list[int | None]) -> dict[int | None, str]:
    def one(number: int | None) -> str:
        # A machine that is too busy for the board's first answers, or for four in a row, says so instead: it is asked until it is not.
        tries = (after(folder / f"{place}-{number}-{n}", place, number) for n in range(100))
        return next((wrong for wrong in tries if not wrong.startswith("no torque")), "never a torque")

    with ThreadPoolExecutor(3) as pool:
        said = dict(zip(numbers, pool.map(one, numbers), strict=True))
    return {number: wrong for number, wrong in said.items() if wrong}


def test_every_signal_takes_the_torque_away_before_python_ends_or_stops(short) -> None:
    assert at_all(short, "main", list(SIGNALS)) == {}


def test_a_run_in_another_thread_lets_go_at_each_of_them_and_when_the_main_thread_ends(short) -> None:
    numbers = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT, signal.SIGALRM, signal.SIGTSTP]
    assert at_all(short, "beside", numbers) == {}
    assert at_all(short, "ends", [None]) == {}


def test_only_a_signal_that_nobody_hears_leaves_the_torque_on_a_board_without_a_watchdog(short) -> None:
    assert at_all(short, "main", [signal.SIGKILL]) == {signal.SIGKILL: "the torque stays"}


@pytest.mark.parametrize("flood", [b"", bytes(4096), b"\x5a" * 4096], ids=["silence", "zeros", "garbage"])
@pytest.mark.parametrize("stopped", [False, True], ids=["told", "stopped"])
def test_a_line_that_floods_is_told_and_ctrl_c_is_heard_meanwhile(short, flood: bytes, stopped: bool) -> None:
    device = Device(short, "")
    run = started("main", f"serial:{device.line}", 0.001, short)
    log = short / "run/relax.mcap.part"
    while not (log.exists() and log.stat().st_size > 40_000):
        assert run.poll() is None, run.communicate()[1]
        time.sleep(0.005)
    device.flood = flood
    if stopped:
        run.send_signal(signal.SIGINT)
    how = ended(run)
    said = run.communicate()[1]
    device.ends()
    assert how == (f"signal {signal.SIGINT}" if stopped else "exit 1"), said
    assert ("KeyboardInterrupt" if stopped else "no sample for 2000 ms, and the device does not answer") in said


def test_a_hangup_that_is_ignored_stays_ignored_as_after_nohup(short) -> None:
    device = Device(short, "--kind haply-2diy")
    run = started("main", f"haply:{device.line}", 0.01, short, ["sh", "-c", """trap '' HUP; exec "$@\"""", "sh"])
    while not device.pushes():
        assert run.poll() is None, run.communicate()[1]
        time.sleep(0.005)
    run.send_signal(signal.SIGHUP)
    time.sleep(0.3)
    assert run.poll() is None
    run.send_signal(signal.SIGTERM)
    assert ended(run) == "signal 15"
    run.communicate()
    device.ends()


FORKS = """
import os, signal, sys, threading, time, warnings
from fractional_haptics import experiment
device, out, log = sys.argv[1:]
run = threading.Thread(target=lambda: experiment.relax(device=device, sample_time_s=0.01, watchdog_s=1.0, late_ticks=0,
                                                       contact="rigid", duration_s=3.0, ramp_time_s=0.5, out=out))
run.start()
while not os.path.exists(log):
    time.sleep(0.01)
warnings.simplefilter("ignore")
child = os.fork()
if child == 0:
    time.sleep(60)
    sys.exit()
os.kill(child, signal.SIGTERM)
print(os.waitpid(child, 0)[1] == signal.SIGTERM, run.is_alive(), flush=True)
run.join()
os.kill(os.getpid(), signal.SIGHUP)
"""


def test_a_fork_and_whoever_drives_nothing_any_more_are_ended_by_a_signal_as_ever(short) -> None:
    device = Device(short, "--kind haply-2diy")
    log = short / "run/relax.mcap.part"
    command = [sys.executable, "-c", FORKS, f"haply:{device.line}", short / "run", log]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
    device.ends()
    assert (ran.stdout, ran.returncode) == ("True True\n", -signal.SIGHUP), ran.stderr


TAKEN_AWAY = """
import signal, sys
from fractional_haptics import experiment
device, out = sys.argv[1:]
run = lambda n: experiment.relax(device=device, sample_time_s=0.01, watchdog_s=1.0, late_ticks=0, contact="rigid",
                                 duration_s=1.0, ramp_time_s=0.5, out=f"{out}/{n}")
for n in range(2):
    try:
        run(n)
    except Exception as error:
        print(n, error)
    old = signal.signal(signal.SIGTERM, lambda *_: None)
    signal.signal(signal.SIGTERM, old)
"""


def test_a_run_is_refused_where_a_signal_would_no_longer_be_heard(short) -> None:
    device = Device(short, "--kind haply-2diy")
    command = [sys.executable, "-c", TAKEN_AWAY, f"haply:{device.line}", short / "run"]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
    device.ends()
    assert "1 SIGTERM (15) would leave the force on the device: this process had a handler" in ran.stdout, ran


# Options of the emulator, name of the device, sample time, and time of the log before the hand presses, both s.
KINDS = {
    "serial": ("", "serial:{line}", 0.001, 0.1),
    "tcp": ("", "tcp:127.0.0.1:{port}", 0.001, 0.1),
    "moteus": ("--kind moteus turn=2mm:0.5s", "moteus:{line},radius=20mm,watchdog=1s,lost=1000", 0.002, 1.4),
    "inverse3": ("--kind inverse3 service_port=0", "inverse3:127.0.0.1:{port},lost=1000", 0.001, 0.1),
}


def numbers(said: str, words: str) -> list[float]:
    return [float(number) for number in re.findall(r"-?\d+\.?\d*", said.split(words)[1].split(";")[0])]


def host(*words: object) -> tuple[int, dict]:
    ran = subprocess.run([HOST_CLI, *words, "--json"], capture_output=True, text=True, timeout=600, check=False)
    return ran.returncode, json.loads(ran.stdout or "{}")


def met(folder: Path, kind: str, number: int, wait_s: float) -> None:
    """A run on a device of a kind that a signal meets after some time of its log: no force is left, and the log is whole."""
    folder.mkdir()
    options, name, period_s, before_s = KINDS[kind]
    device = Device(folder, options)
    log = folder / "run/relax.mcap.part"
    run = started("main", name.format(line=device.line, port=device.port), period_s, folder)
    try:
        # Some 80 bytes a sample behind the head of the log.
        while not log.exists() or log.stat().st_size < 8000 + 80 * (before_s + wait_s) / period_s:
            assert run.poll() is None, run.communicate()[1]
            time.sleep(0.005)
        run.send_signal(number)
        is_deadly = number == signal.SIGKILL
        assert ended(run) in ({"signal 9"} if is_deadly else end_of(number))
        if is_deadly:
            # Its watchdog, and the time to zero force.
            time.sleep(2.0)
            code, told = host("log", "recover", log, folder / "saved.mcap")
            assert code in (0, 4) and told["samples"] > 0, told
        else:
            code, told = host("log", "check", folder / "run/relax.mcap")
            is_whole = told["complete"] and told["end"]["ended"] == "interrupted" and code in (0, 4)
            assert is_whole, (code, told)
        run.kill()
        run.communicate()
        if kind in ("serial", "tcp"):
            told = host("device", "info", "--device", f"tcp:127.0.0.1:{device.port}")[1]
            assert told["state"] == ("in a fault" if is_deadly else "idle"), told
            return
        said = device.ends()
        if kind == "moteus":
            # 11 is that of its own watchdog.
            assert numbers(said, "mode ")[0] == (11 if is_deadly else 0), said
            assert numbers(said, "torque ")[0] == 0.0 < numbers(said, "largest ")[0], said
        else:
            forces = numbers(said, "; force ")
            assert forces[:3] == [0.0] * 3 and forces[3] > 0.0, said
    finally:
        run.kill()
        run.communicate()
        if device.emulator.poll() is None:
            device.ends()


def test_no_signal_leaves_a_force_on_a_device_of_any_kind_and_the_log_is_whole(short) -> None:
    """`CAMPAIGN_CASES` sets how many, 8 by default."""
    random = Random(65)
    numbers = [*SIGNALS, signal.SIGKILL]
    kinds = list(KINDS)
    with ThreadPoolExecutor(3) as pool:
        cases = [
            pool.submit(met, short / str(case), kinds[case % len(kinds)], numbers[case % len(numbers)], random.random())
            for case in range(int(os.environ.get("CAMPAIGN_CASES", 8)))
        ]
        for case in cases:
            case.result()
