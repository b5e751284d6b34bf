"""Logs of runs as pandas tables: the crate ``haptic-log``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fractional_haptics import _native

if TYPE_CHECKING:
    import os

    import pandas

__all__ = ["read_log"]


def read_log(path: str | os.PathLike[str]) -> pandas.DataFrame:
    """A log of a run (MCAP), whole or cut, with the files that it goes on in.

    Parameters
    ----------
    path : path
        ``run.mcap``; of a run that was killed ``run.mcap.part``.

    Returns
    -------
    pandas.DataFrame
        A row for each tick, indexed by the device's time ``time_s`` in s; columns carry their units. Of a device with two or
        three axes a vector is a column an axis, as ``position_x_m`` and ``position_y_m``. In ``attrs``:

        ``metadata`` : dict of dict of str
            Parameters, versions and results by the name of their record, as ``experiment`` and ``end``.
        ``events`` : list of (time_s, kind, text)
            What happened.
        ``complete`` : bool
            The log was finished by its writer and nothing of it is damaged.
        ``damage`` : list of str
            What could not be read.
        ``started`` : str or None
            When the device's time was 0, RFC 3339 in UTC.

    Raises
    ------
    FileNotFoundError, PermissionError, OSError
        A file that is not there or cannot be read.
    ValueError
        A file that is no log. A cut or damaged log is no error: see ``complete``.
    """
    import pandas

    log = _native.read_log(path)
    table = pandas.DataFrame(log["columns"]).set_index("time_s")
    for name in ("metadata", "events", "complete", "damage", "started"):
        table.attrs[name] = log[name]
    return table
