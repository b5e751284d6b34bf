"""Experiments on simulated or serial devices: the crate ``haptic-experiment``, what ``host-cli`` runs.

All take the keys of experiment files, with their defaults and ranges; keys carry their SI unit. A text with a unit is taken
too, and the key without its unit: ``wall(mass="65 g", …)`` is ``wall(mass_kg=0.065, …)``.

Every one releases the interpreter, reports progress, and stops on Ctrl-C: the force ramps to zero, the log is closed, then
``KeyboardInterrupt`` is raised.

A run on a device also lets go before any other signal ends or stops the process, and when Python ends while it goes on in
another thread: the force ramps to zero, the log is closed, then the signal does what it always does. A signal for which the
program has a handler of its own is left to that. Nothing can be done about ``SIGKILL``, ``SIGSTOP``, a crash or ``os._exit``.
"""

from __future__ import annotations

import atexit
import inspect
import os
import tempfile
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from fractional_haptics import _native
from fractional_haptics._values import HoldsArrays, Shown

if TYPE_CHECKING:
    import numpy as np
    import pandas
    from numpy.typing import NDArray

    from fractional_haptics.tissue import Material

__all__ = ["Answer", "Run", "RunFault", "coupler", "creep", "design", "relax", "touch", "wall", "zwidth"]

Progress = Callable[[int], object]

atexit.register(_native.let_go)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_native.forked)


def _told(progress: Any) -> Progress | None:
    """A bar of ``tqdm`` as a function of the number that is done."""
    if hasattr(progress, "update") and hasattr(progress, "n"):
        return lambda done: progress.update(done - progress.n)
    return cast("Progress | None", progress)


@dataclass(frozen=True, eq=False, repr=False)
class Run(HoldsArrays, Shown):
    """A finished run."""

    kind: str
    """The experiment."""
    columns: Mapping[str, NDArray[np.float64]]
    """Columns of its table by name, units in the names; NaN where a cell is empty. Empty for a run that was cut short."""
    report: Mapping[str, Any]
    """The report, as ``host-cli --json`` prints it."""
    folder: Path | None
    """Folder of log and table, where one was asked for."""
    against: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)
    """Record, run and difference at the times of the record, where one was laid over the run by ``against``."""

    def __getitem__(self, column: str) -> NDArray[np.float64]:
        """A column by name."""
        try:
            return self.columns[column]
        except KeyError:
            raise KeyError(f"{column!r} is none of the columns {', '.join(self.columns)}") from None

    def to_frame(self) -> pandas.DataFrame:
        """The columns as a pandas table, with the report in ``attrs``."""
        import pandas

        table = pandas.DataFrame(dict(self.columns))
        table.attrs["report"] = dict(self.report)
        return table

    def _shown(self) -> Mapping[str, Any]:
        return {"kind": self.kind, **self.report}

    def __repr__(self) -> str:
        return f"<Run '{self.kind}' of {self.report['samples']} samples: {', '.join(self.columns)}>"


class RunFault(RuntimeError):
    """A run that ended before its time, at a fault."""

    run: Run
    """Report and log of it, up to its end."""

    def __init__(self, run: Run) -> None:
        super().__init__(run)
        self.run = run

    def __str__(self) -> str:
        report = self.run.report
        return f"{report['ended_early']}: the run ended at {report['duration_s']:g} s"


class Answer(dict[str, Any], Shown):
    """The answer to a question: a dict, with the keys of ``host-cli --json``, that shows itself on one screen."""

    __str__ = Shown.__str__


def _tables(report: dict[str, Any]) -> list[dict[str, NDArray[np.float64]]]:
    """The table of a run and that of the record over it, empty where there is none."""
    paths = report.get("csv"), report.get("against", {}).get("csv")
    return [_native.table(path) if path else {} for path in paths]


def _run(
    kind: str,
    parameters: dict[str, Any],
    *,
    out: str | os.PathLike[str] | None,
    overwrite: bool,
    force_unstable: bool,
    raise_on_fault: bool,
    progress: Progress | None,
) -> Run:
    given = {key: value for key, value in parameters.items() if value is not None}
    if out is not None:
        folder = Path(out)
        report, heard = _native.run_experiment(kind, given, folder, overwrite, force_unstable, progress)
        columns, against = _tables(report)
    else:
        folder = None
        with tempfile.TemporaryDirectory(prefix="fractional-haptics-", ignore_cleanup_errors=True) as temporary:
            report, heard = _native.run_experiment(
                kind, given, Path(temporary) / kind, False, force_unstable, progress
            )
            columns, against = _tables(report)
        for gone in ("log", "logs", "csv", "fault_log"):
            report.pop(gone, None)
        report.get("against", {}).pop("csv", None)
    report["warnings"] = [*heard, *report.get("warnings", [])]
    run = Run(kind, columns, report, folder, against)
    if raise_on_fault and report["ended_early"] is not None:
        raise RunFault(run)
    return run


def _described(rows: Iterable[tuple[str, str, Any, bool, str, str]]) -> str:
    """The parameters of a table, in NumPy's style."""
    lines = []
    for _section, key, default, required, allowed, text in rows:
        if required:
            kind = "float"
        elif allowed == "a list":
            kind, allowed = "list of float, optional", ""
        elif default is None:
            kind = "float, optional"
        else:
            kind = f"{type(default).__name__}, default {default!r}"
        lines.append(f"{key} : {kind}")
        lines.append(f"    {text}{f' ({allowed})' if allowed else ''}.")
    return "\n".join(lines)


def _signature(function: Callable[..., Any], rows: Iterable[tuple[str, str, Any, bool, str, str]]) -> None:
    """Writes the parameters of the tables into signature and documentation of a function."""
    rows = list(rows)
    signature = inspect.signature(function)
    own = [p for p in signature.parameters.values() if p.kind is not inspect.Parameter.VAR_KEYWORD]
    keyword = inspect.Parameter.KEYWORD_ONLY
    listed = [
        inspect.Parameter(key, keyword, default=inspect.Parameter.empty if required else default)
        for _section, key, default, required, _allowed, _help in rows
    ]
    function.__signature__ = signature.replace(parameters=[*own, *listed])  # type: ignore[attr-defined]
    function.__doc__ = inspect.cleandoc(function.__doc__ or "").replace("<parameters>", _described(rows))


_EXPERIMENT = """{what}

Parameters
----------
out : path, optional
    Folder for log and table; without it none are kept.
overwrite : bool, default False
    Replace the files of an earlier run there.
force_unstable : bool, default False
    On a serial device: start what the pre-flight refuses, too.
raise_on_fault : bool, default True
    Raise a `RunFault` where a fault ends the run; else ``report["ended_early"]`` says it.
progress : callable, optional
    Called now and then with the number of samples done; or a bar of ``tqdm``.
<parameters>

Returns
-------
Run

Raises
------
ValueError
    A parameter that is unknown, missing or outside its range.
FileNotFoundError
    A file or folder that a parameter names.
RuntimeError
    A device or a disk that failed; as a `RunFault`, with the run in it, a fault that ended the run.
KeyboardInterrupt
    After Ctrl-C, when the force is zero and the log closed.

Notes
-----
On a serial device give ``device="serial:PATH"``: it then runs by the clock.
"""


def _experiment(kind: str, what: str) -> Callable[..., Run]:
    """The function of an experiment of a kind."""

    def function(
        *,
        out: str | os.PathLike[str] | None = None,
        overwrite: bool = False,
        force_unstable: bool = False,
        raise_on_fault: bool = True,
        progress: Progress | None = None,
        **parameters: Any,
    ) -> Run:
        return _run(
            kind,
            parameters,
            out=out,
            overwrite=overwrite,
            force_unstable=force_unstable,
            raise_on_fault=raise_on_fault,
            progress=_told(progress),
        )

    function.__name__ = function.__qualname__ = kind
    function.__doc__ = _EXPERIMENT.format(what=what)
    _signature(function, _native.experiment_parameters(kind))
    return function


relax = _experiment(
    "relax",
    "Stress relaxation: an indenter compresses a virtual tissue to a strain and holds it.",
)
creep = _experiment("creep", "Creep: an indenter pushes a virtual tissue with a constant force.")
wall = _experiment(
    "wall",
    "A wall is hit and pushed: ``report['verdict']`` says whether the device comes to rest,\n"
    "``report['analysis_agrees']`` whether the analysis says the same.",
)
coupler = _experiment("coupler", "A device, a fractional virtual coupler and an object, hit and pushed.")
touch = _experiment(
    "touch",
    "A hand moves a device of two or three axes over a plane, disc or sphere of tissue, simulated:\n"
    "``report['verdict']`` says whether the hand was given energy.",
)


def _answer(kind: str, parameters: dict[str, Any], progress: Progress | None) -> Answer:
    given = {key: value for key, value in parameters.items() if value is not None}
    return Answer(_native.answer(kind, given, _told(progress)))


def zwidth(
    *,
    orders: Iterable[float] = (0.0, 0.5, 1.0, 1.5, 2.0),
    points: int = 21,
    progress: Progress | None = None,
    **parameters: Any,
) -> Answer:
    """Z-width: the stiffest walls that a device renders, by trying.

    Parameters
    ----------
    orders : iterable of float
        Orders of the dissipation, 0 to 2.
    points : int, default 21
        Dissipations for each order, from 0 to the largest stable one.
    progress : callable, optional
        Called with the number of walls done; or a bar of ``tqdm``.
    <parameters>

    Returns
    -------
    Answer
        A dict as ``host-cli zwidth --json``: ``orders[i]["boundary"][k]`` has ``dissipation``, ``stiffness_max`` (N/m),
        ``analysis_stiffness_n_per_m`` and more. After Ctrl-C ``KeyboardInterrupt``.

    Raises
    ------
    ValueError
        A parameter that is unknown or outside its range.
    RuntimeError
        A device that failed.
    """
    return _answer("zwidth", {"orders": list(orders), "points": points, **parameters}, progress)


def design(
    *,
    wish: str = "stiffest-wall",
    tissue: Material | None = None,
    area_m2: float | None = None,
    thickness_m: float | None = None,
    frequency_hz: float | None = None,
    gain_margin: float | None = 2.0,
    orders: Iterable[float] | None = None,
    force_noise_limit_n: float | None = None,
    progress: Progress | None = None,
    **parameters: Any,
) -> Answer:
    """The best wall for a device, and the order that does it: computed, then tried.

    Parameters
    ----------
    wish : {"stiffest-wall", "most-damping", "tissue"}
        What is wanted most.
    tissue : Material, optional
        For ``tissue``: the one that is to be rendered.
    area_m2, thickness_m : float, optional
        Its specimen, a slab of the usual size unless they or ``loading`` say otherwise.
    frequency_hz : float, optional
        Frequency of ``most-damping``, and where orders are compared for a tissue (1 Hz).
    gain_margin : float or None, default 2
        Factor by which a stable wall could grow before it is unstable; None asks for passivity instead.
    orders : iterable of float, optional
        Orders to try, 0 to 2; without them 0, 0.25, … 2 and finer ones around the best.
    force_noise_limit_n : float, optional
        Largest noise of the force that encoder steps and sensor noise may make, rms; without it 5 % of the push.
    progress : callable, optional
        Called with the number of orders done; or a bar of ``tqdm``.
    <parameters>

    Returns
    -------
    Answer
        A dict as ``host-cli design --json``: ``candidates``, ``best`` (None without any), ``simulated``, ``experiment_text`` and more.

    Raises
    ------
    ValueError
        A parameter that is unknown or outside its range.
    """
    asked = {"wish": wish, "frequency_hz": frequency_hz, "gain_margin": gain_margin, **parameters}
    asked["orders"] = None if orders is None else list(orders)
    asked["require"] = "passive" if gain_margin is None else None
    asked["force_noise_limit_n"] = force_noise_limit_n
    if tissue is None:
        return _answer("design", asked, progress)
    asked.update(area_m2=area_m2, thickness_m=thickness_m)
    with tempfile.TemporaryDirectory(prefix="fractional-haptics-") as folder:
        asked["tissue"] = Path(folder) / "tissue.toml"
        asked["tissue"].write_text(tissue.to_toml(), encoding="utf-8")
        return _answer("design", asked, progress)


for _function in (zwidth, design):
    _own = inspect.signature(_function).parameters
    _rows = _native.experiment_parameters(_function.__name__)
    _signature(_function, [row for row in _rows if row[1] not in {*_own, "require", "library"}])
del _function, _own, _rows
