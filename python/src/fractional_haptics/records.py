"""Records of an experiment with people, in the folders that BIDS has for behaviour (Brain Imaging Data Structure, 1.10).

::

    STUDY/dataset_description.json, participants.tsv, README
    STUDY/sub-p07/beh/sub-p07_task-stiffness_beh.tsv     a row a trial; what its columns are: beside it, .json
    STUDY/sourcedata/sub-p07/sub-p07_task-stiffness_run-1.mcap     every tick, a log a session

    table = records.Table("STUDY", "p07", "stiffness", {"trial": "Number from 0 on", "answer": "1 or 2"})
    with session.open("serial:auto", log=table.log(), ...) as s:
        ...
        table.append(trial=len(table.rows), answer=answer)
"""

from __future__ import annotations

import itertools
import json
import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fractional_haptics import _native
from fractional_haptics._series import Series, along_rows

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Table"]

_README = """Trials are in sub-CODE/beh, a row each; every tick, force and mark is in sourcedata, in the logs that the rows name
(MCAP: fractional_haptics.log.read_log, or any reader of MCAP). A code says nothing of who it is.
"""


class Table(Series):
    """A row a trial of one subject in one task, each on disk once `append` returns. A second start goes on behind the last row."""

    file: Path
    """The table."""
    rows: list[dict[str, str]]
    """Its rows, as texts; ``n/a`` where nothing is known."""

    def __init__(self, study: str | os.PathLike[str], subject: str, task: str, columns: Mapping[str, str]) -> None:
        """Opens the table, or begins it.

        Parameters
        ----------
        study : path
            Folder of the study.
        subject, task : str
            Letters and digits. The subject is a code, never a name.
        columns : dict
            What is in each column; an ending as ``_n`` or ``_s`` says its unit.

        Raises
        ------
        ValueError
            A label that is none, a code without a digit, a table with other columns.
        """
        for what, label in (("subject", subject), ("task", task)):
            if not re.fullmatch("[A-Za-z0-9]+", label):
                raise ValueError(f"{what} {label!r} is no label: give letters and digits alone, as p07")
        if subject.isalpha():
            raise ValueError(f"subject {subject!r} may be somebody's name: give a code with a digit, as p07")
        self._study, self._subject = Path(study), f"sub-{subject}"
        self._name = f"{self._subject}_task-{task}"
        self.file = self._study / self._subject / "beh" / f"{self._name}_beh.tsv"
        self._columns = list(columns)
        text = self.file.read_text("utf-8") if self.file.exists() else ""
        # What a failure of power has cut off was no row.
        whole = text[: text.rfind("\n") + 1]
        header, *lines = whole.splitlines() or ["\t".join(columns)]
        if header.split("\t") != self._columns:
            raise ValueError(f"{self.file} has other columns: give another study or task")
        self.rows = [dict(zip(columns, line.split("\t"), strict=True)) for line in lines]
        if not whole:
            self._begin(task, columns)
        if text != whole or not whole:
            self.file.write_text("\n".join([header, *lines]) + "\n", "utf-8")

    def _begin(self, task: str, columns: Mapping[str, str]) -> None:
        self.file.parent.mkdir(parents=True, exist_ok=True)
        described = {
            column: {"Description": text} | ({"Units": unit} if (unit := _native.name_and_unit(column)[1]) else {})
            for column, text in columns.items()
        }
        participants = self._study / "participants.tsv"
        known = participants.read_text("utf-8").splitlines() if participants.exists() else ["participant_id"]
        made_by = [{"Name": "fractional-haptics", "Version": _native.__version__}]
        about = {"Name": self._study.resolve().name, "BIDSVersion": "1.10.1", "DatasetType": "raw", "GeneratedBy": made_by}
        files = {
            participants: "\n".join([*known, *{self._subject} - set(known)]) + "\n",
            self.file.with_suffix(".json"): _json({"TaskName": task, **described}),
            self._study / "dataset_description.json": _json(about),
            self._study / "README": _README,
        }
        for file, text in files.items():
            if file == participants or not file.exists():
                file.write_text(text, "utf-8")

    def log(self) -> Path:
        """A place for the log of a session, where nothing is yet."""
        folder = self._study / "sourcedata" / self._subject
        folder.mkdir(parents=True, exist_ok=True)
        runs = (folder / f"{self._name}_run-{run}.mcap" for run in itertools.count(1))
        return next(run for run in runs if not run.exists())

    def append(self, **values: object) -> None:
        """Adds a row; None is a value that is not known.

        Raises
        ------
        ValueError
            A column that is missing, or one too many.
        """
        if others := set(values) ^ set(self._columns):
            raise ValueError(f"{sorted(others)} are missing, or no columns: give {', '.join(self._columns)}")
        texts = {column: "" if values[column] is None else str(values[column]) for column in self._columns}
        row = {column: " ".join(text.split()) or "n/a" for column, text in texts.items()}
        with self.file.open("a", encoding="utf-8") as file:
            file.write("\t".join(row.values()) + "\n")
        self.rows.append(row)

    def _series(self) -> Mapping[str, NDArray[Any]]:
        return along_rows(self.rows)


def _json(value: object) -> str:
    return json.dumps(value, indent=2) + "\n"
