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
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from fractional_haptics import _native
from fractional_haptics._series import Series, longest_rows
from fractional_haptics._values import HoldsArrays, Shown, needed

if TYPE_CHECKING:
    from types import ModuleType

    import pandas
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from fractional_haptics._values import AnyPath, Floats

__all__ = [
    "Answer",
    "Run",
    "RunFault",
    "analyze_admittance",
    "analyze_coupling",
    "analyze_difference",
    "analyze_environment",
    "analyze_passivity",
    "analyze_sensitivity",
    "analyze_stability",
    "analyze_stability_region",
    "analyze_teleoperation",
    "analyze_transparency",
    "calibrate",
    "coupler",
    "creep",
    "design",
    "press",
    "relax",
    "run",
    "teleoperation",
    "touch",
    "wall",
    "zwidth",
]

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
class Run(HoldsArrays, Shown, Series):
    """A finished run."""

    kind: str
    """The experiment."""
    columns: Mapping[str, Floats]
    """Columns of its table by name, units in the names; NaN where a cell is empty. Empty for a run that was cut short."""
    report: Mapping[str, Any]
    """The report, as ``host-cli --json`` prints it."""
    folder: Path | None
    """Folder of log and table, where one was asked for."""
    against: Mapping[str, Floats] = field(default_factory=dict)
    """Record, run and difference at the times of the record, where one was laid over the run by ``against``."""

    def __getitem__(self, column: str) -> Floats:
        """A column by name."""
        try:
            return self.columns[column]
        except KeyError:
            raise KeyError(f"{column!r} is not one of the columns {', '.join(self.columns)}") from None

    def to_frame(self) -> pandas.DataFrame:
        """The columns as a pandas table, with the report in ``attrs``."""
        table = needed("pandas", "log").DataFrame(dict(self.columns))
        table.attrs["report"] = dict(self.report)
        return cast("pandas.DataFrame", table)

    def _series(self) -> Mapping[str, Floats]:
        return self.columns

    def _drawn(self, plot: ModuleType, ax: Axes | None) -> Axes:
        if self.kind == "relax" and "closed_form_force_n" in self.columns:
            return plot.relaxation(self, ax)  # type: ignore[no-any-return]
        # A closed form stands beside the column that it is of.
        names = [name for name in self.columns if f"closed_form_{name.removeprefix('simulated_')}" in self.columns]
        beside = [f"closed_form_{name.removeprefix('simulated_')}" for name in names]
        return plot.columns(self, *names, *beside, ax=ax)  # type: ignore[no-any-return]

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


class Answer(dict[str, Any], Shown, Series):
    """The answer to a question: a dict, with the keys of ``host-cli --json``, that shows itself on one screen.

    Its columns are those of its longest list of rows, as the frequencies of ``analyze_transparency``."""

    __str__ = Shown.__str__

    def _series(self) -> Mapping[str, NDArray[Any]]:
        return longest_rows(self)


def _tables(report: dict[str, Any]) -> list[dict[str, Floats]]:
    """The table of a run and that of the record over it, empty where there is none."""
    paths = report.get("csv"), report.get("against", {}).get("csv")
    return [_native.table(path) if path else {} for path in paths]


def _temporary() -> tempfile.TemporaryDirectory[str]:
    return tempfile.TemporaryDirectory(prefix="fractional-haptics-", ignore_cleanup_errors=True)


def _run(
    kind: str,
    parameters: dict[str, Any],
    *,
    file: AnyPath | None = None,
    out: AnyPath | None,
    overwrite: bool,
    force_unstable: bool,
    raise_on_fault: bool,
    progress: Progress | None,
) -> Run:
    given = {key: value for key, value in parameters.items() if value is not None}
    with _temporary() if out is None else nullcontext(out) as folder:
        place = Path(folder, "run") if out is None else Path(folder)
        kind, report, heard = _native.run_experiment(kind, file, given, place, overwrite, force_unstable, _told(progress))
        columns, against = _tables(report)
    if out is None:
        for gone in ("log", "logs", "csv", "fault_log"):
            report.pop(gone, None)
        report.get("against", {}).pop("csv", None)
    report["warnings"] = [*heard, *report.get("warnings", [])]
    run = Run(kind, columns, report, None if out is None else Path(out), against)
    if raise_on_fault and report["ended_early"] is not None:
        raise RunFault(run)
    return run


def _described(rows: Iterable[tuple[str, str, Any, bool, str, str]]) -> str:
    """The parameters of a table, in NumPy's style."""
    lines = []
    for _section, key, default, required, allowed, text in rows:
        if required:
            kind = "float"
        elif allowed.startswith("a list"):
            kind, allowed = "list of float, optional", allowed.removeprefix("a list").removeprefix(" of numbers ")
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
        out: AnyPath | None = None,
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
            progress=progress,
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
press = _experiment(
    "press",
    "The position loop of a device presses a specimen and holds it: ``report`` says how deep and how hard.",
)
teleoperation = _experiment("teleoperation", "Two hands over a line, simulated: a slave follows a master into a remote tissue.")


def run(
    file: AnyPath,
    *,
    out: AnyPath | None = None,
    overwrite: bool = False,
    force_unstable: bool = False,
    raise_on_fault: bool = True,
    progress: Progress | None = None,
    **parameters: Any,
) -> Run:
    """Runs an experiment file, or the experiment of a log again, as ``host-cli run``.

    Parameters
    ----------
    file : path
        An experiment file, TOML, or the log of a run, MCAP. Paths in the file start from its folder.
    out, overwrite, force_unstable, raise_on_fault, progress
        As in `relax`.
    **parameters
        Keys that take precedence over those of the file.

    Returns
    -------
    Run

    Raises
    ------
    FileNotFoundError
        The file is not there.
    ValueError
        A file that is no experiment, or a key that is unknown, missing or outside its range.
    """
    os.stat(file)
    return _run("run", **locals())


@contextmanager
def _files(tables: Iterable[Mapping[str, Any]]) -> Iterator[list[dict[str, Any]]]:
    """Keys, with a file for each `tissue.Material`, which is there as long as they are read."""
    with _temporary() as folder:
        plain = [dict(table) for table in tables]
        for place, table in enumerate(plain):
            tissue: Any = table.get("tissue")
            if hasattr(tissue, "to_toml"):
                table["tissue"] = Path(folder) / f"{place}.toml"
                table["tissue"].write_text(tissue.to_toml(), encoding="utf-8")
        yield plain


def _answer(kind: str, parameters: dict[str, Any], progress: Progress | None) -> Answer:
    given = {key: value for key, value in parameters.items() if value is not None}
    with _files([given]) as (plain,):
        report, heard = _native.answer(kind, plain, progress)
    return Answer({**report, "warnings": [*heard, *report.get("warnings", [])]})


_QUESTION = """{what}

Parameters
----------
progress : callable, optional
    Called with the number of steps done; or a bar of ``tqdm``.
<parameters>

Returns
-------
Answer
    A dict as ``host-cli {command} --json``, and its ``warnings``, which one should read. After Ctrl-C ``KeyboardInterrupt``.

Raises
------
ValueError
    A parameter that is unknown, missing or outside its range.
RuntimeError
    A device that failed.

Notes
-----
A tissue is a name, a file or a `Material`.
"""


def _question(kind: str, what: str) -> Callable[..., Answer]:
    """The function of a question of a kind."""

    def function(*, progress: Progress | None = None, **parameters: Any) -> Answer:
        return _answer(kind, parameters, _told(progress))

    function.__name__ = function.__qualname__ = kind.replace("-", "_")
    function.__doc__ = _QUESTION.format(what=what, command=kind.replace("analyze-", "analyze "))
    _signature(function, _native.experiment_parameters(kind))
    return function


zwidth = _question("zwidth", "Z-width: the stiffest walls that a device renders, by trying.")
design = _question("design", "The best wall or coupler for a device, and the order that does it: computed, then tried.")
analyze_environment = _question("analyze-environment", "Stiffness and damping of a wall alone, over the frequency.")
analyze_stability = _question("analyze-stability", "The verdict on a wall: is it stable, and by which margins?")
analyze_stability_region = _question("analyze-stability-region", "All stable walls of an order on a device.")
analyze_passivity = _question("analyze-passivity", "The verdict on a wall: is it passive, and which damping does that need?")
analyze_coupling = _question("analyze-coupling", "The verdict on a virtual coupler: is it passive, and which damping does that need?")
analyze_teleoperation = _question("analyze-teleoperation", "Two hands over a line: up to which delay are they stable, and what is felt?")
analyze_transparency = _question("analyze-transparency", "Stiffness and damping of a wall as they are felt through a device.")
analyze_admittance = _question("analyze-admittance", "Is a robot that moves stable for all of these hands and walls, and what is felt?")
analyze_difference = _question("analyze-difference", "Does a hand feel the difference of two laws, or of a law and a spring and damper?")
analyze_sensitivity = _question("analyze-sensitivity", "By how much a loop amplifies errors of its model, over the frequency.")


def calibrate(read: Callable[[str, float | None], float | None], **parameters: Any) -> Answer:
    """Newtons of a device, checked against a scale, a balance or a weight.

    Parameters
    ----------
    read : callable
        Called on a thread of its own with the words for a person, and with the force that is held, N, or None while something
        is put in place; returns the force that the instrument shows, N.
    <parameters>

    Returns
    -------
    Answer
        A dict as ``host-cli device calibrate --json``, its ``warnings``, and ``device_file``: the text of the device file
        with the calibration.
    """
    report, file, heard = _native.calibrate({key: value for key, value in parameters.items() if value is not None}, read)
    return Answer({**report, "device_file": file, "warnings": heard})


_signature(calibrate, _native.experiment_parameters("calibrate"))
