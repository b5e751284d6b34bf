"""The examples of a threshold: their simulated observer is found, and a stop loses nothing."""

import os
import re
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from felt_threshold import Quest
from rated_tissue import COLUMNS as RATED
from rated_tissue import rate
from test_session import on_emulated
from test_signals import Device
from two_interval import COLUMNS, Observer, measure

from fractional_haptics import log, records, session

pytestmark = pytest.mark.filterwarnings("ignore::Warning")

THRESHOLD, SLOPE = 0.1, 2.5
SHARED = ("trial", "catch", "difference", "stiffer", "answer", "correct")


def rows(subject: str) -> list[dict[str, str]]:
    return records.Table("study", subject, "stiffness", COLUMNS).rows


def read_log(subject: str, run: int = 1, task: str = "stiffness"):
    return log.read_log(f"study/sourcedata/sub-{subject}/sub-{subject}_task-{task}_run-{run}.mcap")


def test_the_threshold_of_an_observer_is_within_its_own_interval(tmp_path, monkeypatch) -> None:
    """`CAMPAIGN_CASES` sets how many seeds, 3 by default: nine in ten of 20 have to be."""
    monkeypatch.chdir(tmp_path)
    seeds = int(os.environ.get("CAMPAIGN_CASES", 3))
    within = 0
    for seed in range(seeds):
        quest = Quest()
        measure(f"s{seed}", seed, Observer(THRESHOLD, SLOPE, seed), quest)
        middle, low, high = quest.interval()
        print(f"seed {seed}: {middle:.3f} in [{low:.3f}, {high:.3f}]")
        within += low <= THRESHOLD <= high
        # It says something at all.
        assert high / low < 6
    assert within >= 0.9 * seeds - 0.7, f"{within} of {seeds}"


def test_a_staircase_of_psychopy_is_that_of_its_observer_and_goes_on_after_a_stop() -> None:
    """In a process of its own: PsychoPy sets a timeout for every socket of its process, and puts paths into `sys.path` that mypy refuses."""
    checks = Path(__file__).with_name("staircase_checks.py")
    arguments = ["-m", "pytest", "--quiet", "-p", "no:cacheprovider", "-W", "ignore", str(checks)]
    ended = subprocess.run([sys.executable, *arguments], cwd=checks.parent, capture_output=True, text=True)
    assert ended.returncode == 0, ended.stdout + ended.stderr


def restless(chance: np.random.Generator, seen: set[str]):
    """`Session.hand` of a hand that does what hands do."""
    moves = session.Session.hand

    def hand(self: session.Session, path: list[tuple[float, float]]) -> None:
        deep_m = path[1][1]
        kind = str(chance.choice(["as asked", "roves", "leaves", "holds", "jumps", "absent", "shakes", "inside", "sulks"]))
        seen.add(kind)
        # From where the one before has left it.
        goes = {
            "roves": [(0.3 * n, float(chance.uniform(-8e-3, 8e-3))) for n in range(30)] + [(9.3, -3e-3)],
            "leaves": [(0.0, -3e-3), (0.02, deep_m), (0.05, -8e-3)],
            "holds": [(0.0, -3e-3), (0.1, deep_m), (40.0, deep_m), (40.1, -3e-3)],
            "jumps": [(0.0, -3e-3), (0.001, 3e-2), (0.15, 3e-2), (0.151, -3e-2)],
            "absent": [(0.0, -3e-3)],
            "shakes": [(n / 100, float(chance.uniform(-6e-3, deep_m))) for n in range(30)] + [(0.3, -3e-3)],
            "inside": [(0.0, 6e-3), (3.0, 6e-3), (3.1, -3e-3), (3.2, 6e-3), (3.4, -3e-3)],
            "sulks": [(0.0, 6e-3), (50.0, 6e-3), (50.1, -3e-3)],
        }
        moves(self, goes.get(kind, path))

    return hand


def test_whatever_hands_do_each_row_is_of_walls_that_were_touched(tmp_path, monkeypatch) -> None:
    """`CAMPAIGN_CASES` sets how many hands, 4 by default; the campaign has 500. Every other one rates tissues."""
    monkeypatch.chdir(tmp_path)
    seen: set[str] = set()
    trials = left = 0
    hands = int(os.environ.get("CAMPAIGN_CASES", 4))
    for hand in range(hands):
        subject, rates = f"h{hand}", hand % 2 == 1
        task, columns = ("likeness", RATED) if rates else ("stiffness", COLUMNS)
        with monkeypatch.context() as patched:
            patched.setattr(session.Session, "hand", restless(np.random.default_rng([86, hand]), seen))
            try:
                if rates:
                    rate(subject, hand, lambda _, __: 5.0, trials=3)
                else:
                    measure(subject, hand, lambda _: 1, Quest(), trials=3)
            except TimeoutError as error:
                # Nobody is there, and that is said.
                assert "nobody touched the wall" in str(error) or "out" in str(error)
                stayed = False
            else:
                stayed = True
            left += not stayed
        kept = records.Table("study", subject, task, columns).rows
        felt = read_log(subject, task=task)
        answers = [kind for _, kind, _ in felt.attrs["events"]].count("rating" if rates else "answer")
        assert answers == len(kept) and felt.attrs["complete"] is True
        assert len(kept) == 3 or not stayed
        for row in kept:
            for which in ("",) if rates else ("first_", "second_"):
                tick, peak_n = int(row[f"{which}tick"]), float(row[f"{which}peak_n"])
                assert peak_n > 0 and float(row[f"{which}deepest_m"]) > 0
                assert felt["commanded_force_n"].abs().iloc[tick : tick + 300].max() == peak_n
        trials += len(kept)
    print(f"{hands} hands, {trials} trials, {left} that were said to be away or in the wall: {sorted(seen)}")
    assert len(seen) > 4


class Sharp:
    """Takes the stiffer wall for the stiffer one, and goes away at a trial."""

    def __init__(self, leaves: int) -> None:
        self.left = leaves

    def __call__(self, felt) -> int:
        if self.left == 0:
            raise KeyboardInterrupt
        self.left -= 1
        first, second = (one.peak_force_n / one.deepest_m for one in felt)
        return 1 if first > second else 2


def test_what_was_stopped_goes_on_with_the_same_trials_and_each_row_is_in_its_log(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    stopped_goes_on(Quest)


def stopped_goes_on(method) -> None:
    measure("w1", 4, Sharp(-1), method(), trials=12)
    with pytest.raises(KeyboardInterrupt):
        measure("s1", 4, Sharp(5), method(), trials=12)
    assert len(rows("s1")) == 5
    measure("s1", 4, Sharp(-1), method(), trials=12)
    assert [[row[key] for key in SHARED] for row in rows("w1")] == [[row[key] for key in SHARED] for row in rows("s1")]
    assert {row["log"] for row in rows("s1")} == {f"sub-s1_task-stiffness_run-{run}.mcap" for run in (1, 2)}
    # The order is blind, and one in ten is a catch trial.
    assert {row["stiffer"] for row in rows("w1")} == {"1", "2"}
    assert [int(row["trial"]) for row in rows("w1") if row["catch"] == "1"] == [9]
    forces = read_log("w1")["commanded_force_n"].abs()
    for row in rows("w1"):
        for which in ("first", "second"):
            tick = int(row[f"{which}_tick"])
            assert forces.iloc[tick : tick + 300].max() == float(row[f"{which}_peak_n"])


@on_emulated
def test_the_guides_experiment_is_rehearsed_on_an_emulated_board_and_goes_on_after_a_stop(tmp_path, tmp_path_factory, monkeypatch) -> None:
    """`CAMPAIGN_CASES` sets how many trials a start has, 1 by default."""
    monkeypatch.chdir(tmp_path)
    root = Path(__file__).parents[2]
    page = (root / "docs/guide/src/experiment-with-people.md").read_text("utf-8")
    (address, options), = re.findall(r"\nhost-cli device emulate --listen (\S+) (.+)\n", page)
    (command,) = re.findall(rf"\npython (\S+ p00 tcp:{address} .+)\n", page)
    board = Device(tmp_path_factory.mktemp("s"), options)
    example, *arguments = shlex.split(command.replace(address, f"127.0.0.1:{board.port}"))
    trials = int(os.environ.get("CAMPAIGN_CASES", 1))
    try:
        for start in (1, 2):
            person = subprocess.Popen(
                [sys.executable, root / "python/examples" / example, *arguments],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            )  # fmt: skip
            asked = 0
            while asked < trials:
                # What is asked stands in front of what the next trial says.
                words = person.stdout.readline()
                assert words, person.communicate()[1]
                if "wall 2: press" in words:
                    person.stdin.write("1\n")
                    person.stdin.flush()
                asked += words.startswith("Which")
            person.send_signal(signal.SIGINT)
            person.communicate(timeout=60)
            assert len(rows("p00")) == start * trials
            table = read_log("p00", start)
            kinds = [kind for _, kind, _ in table.attrs["events"]]
            assert table.attrs["metadata"]["end"]["ended"] == "interrupted" and kinds.count("answer") == trials
    finally:
        board.ends()
    # The hand wants 6 mm and the wall gives 300 N/m or more: each pushes the other out.
    assert all(1.5e-3 < float(row["first_deepest_m"]) < 5e-3 and float(row["second_peak_n"]) > 0.3 for row in rows("p00"))
