"""Records of people: the folders of BIDS by BIDS' own validator, and what is no record."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from felt_threshold import Quest
from rated_tissue import Observer, rate, solid_at
from two_interval import measure

from fractional_haptics import records

COLUMNS = {"trial": "Number from 0 on", "peak_n": "Largest force", "stiffness_n_per_m": "Stiffness", "said": "Words"}
# What a study may leave out.
RECOMMENDED = {"JSON_KEY_RECOMMENDED", "SIDECAR_KEY_RECOMMENDED", "NO_AUTHORS", "TOO_FEW_AUTHORS"}


def found(study: Path) -> set[str]:
    """Codes of all that the validator finds."""
    validator = Path(sys.executable).with_name("bids-validator-deno")
    done = subprocess.run([validator, study, "--json"], capture_output=True, text=True)
    return {issue["code"] for issue in json.loads(done.stdout)["issues"]["issues"]}


@pytest.mark.filterwarnings("ignore::Warning")
def test_the_records_of_the_examples_are_whole_for_the_validator_and_name_nobody(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    for subject in ("p01", "p02"):
        measure(subject, 1, lambda _: 1, Quest(), trials=2)
        rate(subject, 1, Observer(solid_at([0.5] * 4), 1), trials=2)
    study = tmp_path / "study"
    assert found(study) <= RECOMMENDED
    files = {str(path.relative_to(study)) for path in study.rglob("*") if path.is_file()}
    assert files >= {
        "sub-p01/beh/sub-p01_task-likeness_beh.tsv",
        "sub-p02/beh/sub-p02_task-stiffness_beh.json",
        "sourcedata/sub-p02/sub-p02_task-stiffness_run-1.mcap",
    }
    assert (study / "participants.tsv").read_text() == "participant_id\nsub-p01\nsub-p02\n"
    for path in files:
        held = (study / path).read_bytes()
        assert str(tmp_path).encode() not in held and str(Path.home()).encode() + b"/" not in held, path
    # The validator sees what is wrong.
    (study / "sub-p01/beh/sub-p01_task-likeness_beh.tsv").rename(study / "sub-p01/beh/sub-p01_likeness.tsv")
    assert found(study) - RECOMMENDED


def test_a_row_is_on_disk_at_once_and_one_that_was_cut_off_is_none(tmp_path: Path) -> None:
    table = records.Table(tmp_path, "p07", "feel", COLUMNS)
    table.append(trial=0, peak_n=0.1, stiffness_n_per_m=300.0, said=" soft\tand\nslow ")
    table.append(trial=1, peak_n=None, stiffness_n_per_m=1 / 3, said="")
    whole = table.file.read_text("utf-8")
    assert whole.splitlines()[1:] == ["0\t0.1\t300.0\tsoft and slow", "1\tn/a\t0.3333333333333333\tn/a"]
    for cut in range(1, len("1\tn/a")):
        table.file.write_text(whole + whole.splitlines()[2][:cut], "utf-8")
        again = records.Table(tmp_path, "p07", "feel", COLUMNS)
        assert again.rows == table.rows and again.file.read_text("utf-8") == whole
    table.file.write_text("tri", "utf-8")
    assert records.Table(tmp_path, "p07", "feel", COLUMNS).rows == []
    described = json.loads(table.file.with_suffix(".json").read_text())
    assert [described[key].get("Units") for key in COLUMNS] == [None, "N", "N/m", None]
    assert table.log() == table.log()
    table.log().touch()
    assert table.log().name == "sub-p07_task-feel_run-2.mcap"


@pytest.mark.parametrize(
    ("subject", "task", "columns", "text"),
    [
        ("Anna", "feel", COLUMNS, "'Anna' may be somebody's name: give a code with a digit"),
        ("../p1", "feel", COLUMNS, "is no label: give letters and digits"),
        ("p_1", "feel", COLUMNS, "is no label"),
        ("", "feel", COLUMNS, "is no label"),
        ("p1\n", "feel", COLUMNS, "is no label"),
        ("p1", "feel-it", COLUMNS, "task 'feel-it' is no label"),
        ("p07", "feel", {"trial": "other"}, "has other columns: give another study or task"),
    ],
)
def test_what_is_no_record_is_refused(subject: str, task: str, columns: dict[str, str], text: str, tmp_path: Path) -> None:
    table = records.Table(tmp_path, "p07", "feel", COLUMNS)
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(ValueError, match=text):
        records.Table(tmp_path, subject, task, columns)
    assert sorted(tmp_path.rglob("*")) == before
    with pytest.raises(ValueError, match="missing, or no columns: give trial, peak_n"):
        table.append(trial=1, peak=2.0)
