"""The example of rated tissues: what its simulated observer likes is found, and a stop changes nothing."""

import json
import os

import numpy as np
import pytest
from rated_tissue import COLUMNS, HIGH, KEYS, LOW, Observer, place, rate, solid_at

from fractional_haptics import log, records

pytestmark = pytest.mark.filterwarnings("ignore::Warning")


def rows(subject: str) -> list[dict[str, str]]:
    return records.Table("study", subject, "likeness", COLUMNS).rows


def test_the_tissue_that_an_observer_knows_is_found_within_a_tenth(tmp_path, monkeypatch) -> None:
    """`CAMPAIGN_CASES` sets how many seeds, 1 by default: nine in ten of 20 have to be."""
    monkeypatch.chdir(tmp_path)
    seeds = int(os.environ.get("CAMPAIGN_CASES", 1))
    within = 0
    for seed in range(seeds):
        known = solid_at(np.random.default_rng([seed, 2]).uniform(0.25, 0.75, 4))
        found = rate(f"s{seed}", seed, Observer(known, seed))
        errors = [abs(found[key] / known[key] - 1.0) for key in KEYS]
        print(f"seed {seed}: {np.round(errors, 3)}")
        within += max(errors) <= 0.1
        assert len(rows(f"s{seed}")) == 40
    assert within >= 0.9 * seeds, f"{within} of {seeds}"


def test_what_was_stopped_goes_on_with_the_same_tissues_and_each_rating_is_in_its_log(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    known = solid_at(np.array([0.3, 0.6, 0.4, 0.7]))
    observer = Observer(known, 1, noise=0.0)
    rate("w1", 5, observer, trials=14)
    for done in (3, 12, 14):
        rate("s1", 5, observer, trials=done)
    whole, parts = ([[row[key] for key in ("trial", *KEYS, "rating")] for row in rows(subject)] for subject in ("w1", "s1"))
    assert whole == parts and len({row["log"] for row in rows("s1")}) == 3
    # Another seed, other tissues; all of them in the region.
    rate("o1", 6, observer, trials=2)
    assert rows("o1")[0]["order"] != rows("w1")[0]["order"]
    assert all(LOW[key] <= float(row[key]) <= HIGH[key] for row in rows("w1") for key in KEYS)
    events = log.read_log(f"study/sourcedata/sub-w1/{rows('w1')[0]['log']}").attrs["events"]
    assert [json.loads(text)["rating"] for _, kind, text in events if kind == "rating"] == [float(row["rating"]) for row in rows("w1")]


def test_a_rating_that_is_none_is_asked_for_again(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    said = iter(["12", "soft", "7.3", "7.5"])
    rate("p1", 1, lambda _, __: next(said), trials=1)
    assert [row["rating"] for row in rows("p1")] == ["7.5"] and len(capsys.readouterr().out.splitlines()) == 3


def test_a_place_is_that_of_its_solid() -> None:
    for at in np.random.default_rng(1).random((20, 4)):
        assert np.abs(place(solid_at(at)) - at).max() < 1e-3
