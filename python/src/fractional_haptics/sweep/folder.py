"""Folder of a sweep: its manifest, its journal and its lock, whatever the format of the results beside them.

======================  ==============================================================================================
``_sweep.json``         manifest: grid, function, seed, versions, outputs, shape of a block; written once, by renaming
``_done``               journal: a line for each block that is written, ``number points failed checksum``; only appended to
``_lock``               locked while a sweep writes; the system takes the lock away when a process dies
======================  ==============================================================================================

Names begin with _, so that readers of Zarr and Parquet pass over them. A block counts as done when its line in the
journal ends; its results are written before. A kill at any moment leaves at most results without a line, which are
written again; and so is a block whose results are not those of its checksum any more.
"""

from __future__ import annotations

import fcntl
import json
import os
import socket
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from .errors import StoreInUse, StoreMismatch

MANIFEST, JOURNAL, LOCK = "_sweep.json", "_done", "_lock"
_FORM = 2


class Done(NamedTuple):
    """What the journal says of a block."""

    points: int
    failed: int
    checksum: int


class Folder:
    """A locked folder of one sweep.

    Parameters
    ----------
    path : str or path
        Made if missing.

    Raises
    ------
    TypeError, ValueError, OSError
        No path; a folder with other things in it, or with links and pipes; one that cannot be written.
    StoreInUse
        Another sweep writes there.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        if not isinstance(path, str | os.PathLike):
            raise TypeError(f"a store is the path of a folder, not {type(path).__name__}: give a text or a Path")
        self.path = Path(path)
        try:
            self.path.mkdir(parents=True, exist_ok=True)
        except FileExistsError:
            raise ValueError(f"the store {self.path} is a file: name a new folder") from None
        except OSError as error:
            raise type(error)(error.errno, f"the store cannot be made: {error.strerror}", str(self.path)) from None
        if not (self.path / MANIFEST).exists() and (found := self._strangers()):
            raise ValueError(f"the store {self.path} holds {found[0]!r}, but no sweep: name a new folder")
        check_files(self.path)
        self._lock = self._take_lock()
        self._journal: int | None = None

    def manifest(self, same: Mapping[str, Any]) -> dict[str, Any] | None:
        """Manifest of the folder, None if it holds no sweep yet.

        Parameters
        ----------
        same : mapping
            What identifies a sweep, as it goes into JSON.

        Raises
        ------
        StoreMismatch
            The sweep in the folder is another one; each difference by name.
        """
        known = read_manifest(self.path)
        if known is not None:
            self.compare(known["same"], same)
        return known

    def compare(self, then: Any, now: Any) -> None:
        """Refuses what differs from the sweep in the folder."""
        if found := list(differences(then, json.loads(json.dumps(now)))):
            raise StoreMismatch(
                f"the store {self.path} holds another sweep:\n  " + "\n  ".join(found) + "\n"
                "Name a new store, or go back to what this one was made with."
            )

    def begin(self, manifest: Mapping[str, Any]) -> None:
        """Writes the manifest, which makes the folder that of this sweep."""
        temporary = self.path / f"{MANIFEST}.new"
        text = json.dumps({"format": _FORM, **manifest}, indent=1, ensure_ascii=False)
        temporary.write_text(text + "\n", encoding="utf-8")
        temporary.replace(self.path / MANIFEST)

    def done(self) -> dict[int, Done]:
        """What the journal says of each block that is written."""
        return read_journal(self.path)

    def mark(self, number: int, done: Done) -> None:
        """Says that a block is written."""
        if self._journal is None:
            self._journal = self._open_journal()
        os.write(self._journal, " ".join(map(str, (number, *done))).encode() + b"\n")

    def close(self) -> None:
        """Gives the lock back."""
        if self._journal is not None:
            os.close(self._journal)
            self._journal = None
        os.close(self._lock)

    def _open_journal(self) -> int:
        path = self.path / JOURNAL
        if path.exists():  # a line that a kill cut off goes
            whole = path.read_bytes()
            if not whole.endswith(b"\n"):
                os.truncate(path, whole.rfind(b"\n") + 1)
        return os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o666)

    def _take_lock(self) -> int:
        path = self.path / LOCK
        try:
            lock = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        except OSError as error:
            raise type(error)(error.errno, f"the store cannot be written: {error.strerror}", str(self.path)) from None
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            holder = os.read(lock, 200).decode(errors="replace").strip() or "another process"
            os.close(lock)
            raise StoreInUse(
                f"the store {self.path} is being written by {holder}: wait for it, or end it, or name another store"
            ) from None
        os.truncate(lock, 0)
        os.write(lock, f"process {os.getpid()} on {socket.gethostname()}\n".encode())
        return lock

    def _strangers(self) -> list[str]:
        lock = self.path / LOCK
        ours = lock.is_file() and lock.read_bytes()[:8] in (b"", b"process ")
        known = (f"{MANIFEST}.new", LOCK if ours else "")
        return sorted(one.name for one in self.path.iterdir() if one.name not in known)


def check_files(path: str | os.PathLike[str]) -> None:
    """Refuses a folder in which anything is neither a file nor a folder.

    A pipe is waited for without an end, and a link leads to what is not of the sweep.
    """
    with os.scandir(path) as entries:
        for entry in entries:
            if entry.is_dir(follow_symlinks=False):
                check_files(entry.path)
            elif not entry.is_file(follow_symlinks=False):
                raise ValueError(
                    f"{entry.path} is a link, a pipe or a device, which no sweep makes: remove it, or name a new store"
                )


def read_manifest(path: Path) -> dict[str, Any] | None:
    """Manifest in a folder; None if there is none.

    Raises
    ------
    ValueError
        A manifest that is none, or of a later form.
    """
    try:
        manifest = json.loads((path / MANIFEST).read_text(encoding="utf-8"))
    except FileNotFoundError:
        return None
    except ValueError as error:
        raise ValueError(f"{path / MANIFEST} is damaged ({error}): name a new store") from None
    if not isinstance(manifest, dict) or manifest.get("format") != _FORM:
        raise ValueError(f"{path / MANIFEST} is not of the form {_FORM} that this version reads: name a new store")
    return manifest


def read_journal(path: Path) -> dict[int, Done]:
    """Each block that a folder's journal says is written. What no line of it says is not done: a cut or damaged one."""
    try:
        lines = (path / JOURNAL).read_bytes().split(b"\n")[:-1]  # what follows the last end of a line was cut off
    except FileNotFoundError:
        return {}
    words = [line.split() for line in lines]
    whole = ([int(word) for word in line] for line in words if len(line) == 4 and all(map(bytes.isdigit, line)))
    return {number: Done(points, failed, checksum) for number, points, failed, checksum in whole}


def differences(then: Any, now: Any, name: str = "") -> Iterator[str]:
    """Sentences that say where two manifests differ."""
    if isinstance(then, dict) and isinstance(now, dict):
        for key in [*then, *(key for key in now if key not in then)]:
            label = f"{name}: {key}" if name else key
            if key not in then:
                yield f"{label} is new: {now[key]!r}"
            elif key not in now:
                yield f"{label} is gone; in the store it is {then[key]!r}"
            else:
                yield from differences(then[key], now[key], label)
    elif then != now:
        yield f"{name} is {then!r} in the store and {now!r} now"
