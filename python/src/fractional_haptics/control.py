"""Fractional transfer functions, controllers and their tuning: the crates ``fractional-control``, ``control-tuning`` and ``control-identification``.

They go to python-control and come from there: `TransferFunction.to_control`, `TransferFunction.from_control`, `plant`, `Pid`.
"""

from __future__ import annotations

import functools
import inspect
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, ParamSpec, TypeVar, cast

import numpy as np

from fractional_haptics import _native
from fractional_haptics._native import Plant
from fractional_haptics._series import Series, longest_rows
from fractional_haptics._values import HoldsArrays, Shown, needed, which

if TYPE_CHECKING:
    from typing import TypeAlias

    import control
    from numpy.typing import ArrayLike, NDArray

    from fractional_haptics._values import AnyPath, Floats

    _Record: TypeAlias = AnyPath | tuple[ArrayLike, ArrayLike, ArrayLike]
    _Pair: TypeAlias = tuple[float, float] | str | None

__all__ = [
    "Designed",
    "Identified",
    "Pid",
    "Plant",
    "Response",
    "TransferFunction",
    "analyze",
    "design",
    "identify",
    "plant",
    "simulate",
]


class TransferFunction(_native._TransferFunction):
    __doc__ = _native._TransferFunction.__doc__

    @classmethod
    def from_control(cls, system: control.TransferFunction) -> TransferFunction:
        """A function of whole orders from python-control.

        Parameters
        ----------
        system : control.TransferFunction
            Continuous, one input, one output.

        Returns
        -------
        TransferFunction

        Raises
        ------
        ValueError
            A system in discrete time, or with more inputs or outputs.
        """
        if system.ninputs != 1 or system.noutputs != 1:
            raise ValueError(f"the system has {system.ninputs} inputs and {system.noutputs} outputs, and must have one each")
        if system.isdtime(strict=True):
            raise ValueError("the system is in discrete time, and must be continuous")

        def terms(coefficients: Floats) -> list[tuple[float, float]]:
            degree = len(coefficients) - 1
            return [(float(c), float(degree - n)) for n, c in enumerate(coefficients) if c != 0]

        return cast("TransferFunction", cls(terms(system.num[0][0]), terms(system.den[0][0])))

    def to_control(self, omega: ArrayLike | None = None) -> control.TransferFunction | control.FrequencyResponseData:
        """For python-control: a ``TransferFunction`` where all orders are whole, else frequency-response data.

        Parameters
        ----------
        omega : array_like, optional
            Frequencies of the data in rad/s; without it 1000 from 1e-4 to 1e4.

        Returns
        -------
        control.TransferFunction or control.FrequencyResponseData
            Data have no step response: `step_response` has that of any function.
        """
        control = needed("control")
        parts = (self.numerator, self.denominator)
        if omega is None and all(order == int(order) for part in parts for _coefficient, order in part):

            def coefficients(part: list[tuple[float, float]]) -> Floats:
                values = np.zeros(int(max(order for _c, order in part)) + 1)
                for coefficient, order in part:
                    values[-1 - int(order)] = coefficient
                return values

            return control.TransferFunction(coefficients(parts[0]), coefficients(parts[1]))
        grid = np.geomspace(1e-4, 1e4, 1000) if omega is None else _native.numbers("omega", omega)
        return control.FrequencyResponseData(self.response(grid), grid, name="transfer function")

    def __repr__(self) -> str:
        return f"TransferFunction({str(self)!r})"


class Pid(_native.Pid):
    __doc__ = _native.Pid.__doc__

    def to_control(
        self, band_rad_s: tuple[float, float] | None = None, sections: int | None = None
    ) -> control.StateSpace:
        """The controller for python-control, from the error to the command, in continuous time.

        Parameters
        ----------
        band_rad_s : (low, high), optional
            Frequencies between which it holds, rad/s; without it four decades up to half the sample rate.
        sections : int, optional
            Sections of each fractional order, 1 to 100; without it two for each decade from w to W.

        Returns
        -------
        control.StateSpace
            Proportional part and integral of whole order are exact.

        Raises
        ------
        ImportError
            python-control is missing.
        ValueError
            A band that does not rise, a number of sections outside its range.

        Notes
        -----
        A fractional order is Oustaloup's: for 0 < ν < 1, with N sections between w = low/100 and W = 100 high,

        ::

            s^ν = W^ν ∏ (s + z_k)/(s + p_k),   z_k, p_k = w (W/w)^((2k - 1 ∓ ν)/(2N)),   k = 1 … N

        An integral is 1/s or 1/s² of such a part, so that it holds at rest; a derivative from order 1 on has a pole at W for each
        whole order. Two sections a decade keep each of these within 1 % in the band. Set-point weights, limits and the sampling
        are not in it.

        References
        ----------
        A. Oustaloup, F. Levron, B. Mathieu, F. M. Nanot, *Frequency-band complex noninteger differentiator: characterization and
        synthesis*, IEEE Trans. Circuits and Systems I 47(1), 2000.
        """
        control = needed("control")
        from fractional_haptics import _matrices

        nyquist = np.pi / self.sample_time
        low, high = (1e-4 * nyquist, nyquist) if band_rad_s is None else map(float, band_rad_s)
        if not 0 < low < high < np.inf:
            raise ValueError(f"band_rad_s = ({low}, {high}) does not rise from above 0: give (low, high) in rad/s")
        low, high = low / 100, 100 * high
        count = int(np.ceil(2 * np.log10(high / low))) if sections is None else sections
        if not 1 <= count <= 100:
            raise ValueError(f"sections {count} is not in [1, 100]")
        a, b, c, d = _matrices.pid(self.parameters, low, high, count)
        return control.StateSpace(a, b[:, None], c[None, :], [[d]], 0, remove_useless_states=False, name="controller")


def plant(
    model: str | TransferFunction | control.TransferFunction | control.StateSpace | control.FrequencyResponseData,
    delay_s: float = 0.0,
) -> Plant:
    """A plant with a dead time.

    Parameters
    ----------
    model : str, TransferFunction, or of python-control
        ``"0.55exp(-s)/(62s+1)"``, a function, matrices without D (up to 16 states), or a measured frequency response, whose dead
        time is in it.
    delay_s : float, default 0
        Dead time in s beside.

    Returns
    -------
    Plant

    Raises
    ------
    ValueError
        What is no plant, with the reason.

    Examples
    --------
    >>> plant("0.55exp(-s)/(62s+1)").delay_s
    1.0
    """
    if isinstance(model, str):
        if delay_s:
            raise ValueError("a dead time beside a text: write it into it, as exp(-0.5s)")
        return Plant._from_text(model)
    if isinstance(model, _native._TransferFunction):
        return Plant._from_function(model, delay_s)
    if hasattr(model, "A"):
        from fractional_haptics.analysis import plant_from_control

        known = plant_from_control(model)
        states = len(known._b)
        return Plant._from_matrices(known._a.reshape(states, states), known._b, known._c, delay_s)
    if hasattr(model, "num"):
        return Plant._from_function(TransferFunction.from_control(model), delay_s)
    if hasattr(model, "complex"):
        if delay_s:
            raise ValueError("a dead time beside a measured response, which has its own: leave delay_s out")
        return Plant._from_response(model.omega, np.ravel(model.complex))
    raise ValueError(
        f"a {type(model).__name__} is no plant here: give a text, a function, or a system of python-control{which(model)}"
    )


_P = ParamSpec("_P")
_R = TypeVar("_R")


def _in_units(function: Callable[_P, _R]) -> Callable[_P, _R]:
    """Takes keys without their unit too, and texts with one for their numbers, as experiments do."""
    signature = inspect.signature(function)
    numbers = [name for name, one in signature.parameters.items() if one.annotation in ("float", "float | None")]

    @functools.wraps(function)
    def in_si(*args: Any, **named: Any) -> Any:
        given: dict[str, Any] = {}
        for name, value in [*zip(signature.parameters, args, strict=False), *named.items()]:
            key, by_place = name, name not in named
            if name in numbers or name not in signature.parameters:
                known = numbers if name in numbers else [*signature.parameters]
                if value is None:
                    continue
                key, value = _native.quantity(known, name, value, by_place)
            if key in given:
                raise TypeError(f"{key} is given twice: leave one out")
            given[key] = value
        if len(args) > len(signature.parameters):
            signature.bind(*args)
        return cast("Any", function)(**given)

    return cast("Callable[_P, _R]", in_si)


def _bound(bound: _Pair) -> str:
    """A frequency in rad/s and the largest gain from it on, or up to it, as the command takes both."""
    if bound is None or isinstance(bound, str):
        return bound or ""
    omega_rad_s, at_most = map(float, bound)
    return f"{omega_rad_s!r}rad/s:{at_most!r}"


def _limits(limits: _Pair) -> str:
    """Two limits, as the command takes them."""
    return limits if isinstance(limits, str) else ":".join(repr(float(end)) for end in limits or ())


@dataclass(frozen=True, eq=False, repr=False)
class Designed(HoldsArrays, Shown, Series):
    """A controller by wishes, with the best PID of order 1 beside it."""

    report: Mapping[str, Any]
    """What ``host-cli control design --json`` reports: gains, wishes with what is reached, verdict, margins, steps, robustness, and
    ``notes``, which one should read; of the other controller under ``integer``."""
    file: str
    """The controller file, TOML."""

    @property
    def unmet(self) -> tuple[str, ...]:
        """Wishes that are missed, by their names."""
        return tuple(wish["name"] for wish in self.report["specification"] if not wish["met"])

    def pid(self, *, integer: bool = False, **arguments: Any) -> Pid:
        """The controller, or the PID of order 1 beside it, at the sample time of the design; further arguments as in `Pid`."""
        gains = (self.report["integer"] if integer else self.report)["controller"]
        return Pid(self.report["sample_time_s"], **{**dict(zip(_GAINS, gains.values(), strict=True)), **arguments})

    def _series(self) -> Mapping[str, NDArray[Any]]:
        return longest_rows(self.report)

    def _shown(self) -> dict[str, Any]:
        return dict(self.report)


_GAINS = ("proportional", "integral", "integral_order", "derivative", "derivative_order")
"""The keywords of `Pid`, in the order of a report."""


@_in_units
def design(
    plant: Plant | AnyPath | None = None,
    crossover_rad_s: float | None = None,
    phase_margin_rad: float | None = None,
    *,
    mass_kg: float | None = None,
    damping_n_s_per_m: float | None = None,
    hand_stiffness_n_per_m: float | None = None,
    current_lag_s: float | None = None,
    delay_s: float | None = None,
    not_flat: bool = False,
    sensitivity_peak: float | str | None = None,
    complementary_peak: float | str | None = None,
    noise: _Pair = None,
    disturbance: _Pair = None,
    sample_time_s: float | None = None,
    scheme: str = "",
    output_limits: _Pair = None,
    step: float = 1.0,
    duration_s: float | None = None,
    name: str | None = None,
) -> Designed:
    """A sampled PI^λD^μ by wishes, tried and judged as ``host-cli control design`` does.

    Parameters
    ----------
    plant, mass_kg, damping_n_s_per_m, hand_stiffness_n_per_m, current_lag_s, delay_s
        As in `analyze`; a measured plant too.
    crossover_rad_s : float
        About 1.3 over the rise time.
    phase_margin_rad : float, optional
        Without it π/3.
    not_flat : bool, default False
        Do not make the phase flat: the overshoot may then change with the gain.
    sensitivity_peak, complementary_peak : float or str, optional
        Largest sensitivity and complementary sensitivity, as 1.6 or ``"4dB"``.
    noise, disturbance : (omega_rad_s, at_most) or str, optional
        Largest complementary sensitivity above a frequency, and sensitivity below one, as ``"10rad/s:-20dB"``.
    sample_time_s : float, optional
        Without it about 1/(50 crossover).
    scheme : str, optional
        ``full`` or ``full-bdf2``, each with ``:TOLERANCE``.
    output_limits : (low, high) or str, optional
        Limits of the command.
    step : float, default 1
        Height of the simulated step.
    duration_s : float, optional
        Length of the steps; without it 60 times 1/crossover.
    name : str, optional
        Of the plant, for the controller file.

    Returns
    -------
    Designed

    Raises
    ------
    OSError
        A file that cannot be read.
    ValueError
        What the command refuses; no controller with this crossover and margin.

    Examples
    --------
    >>> import math
    >>> found = design(plant("0.55exp(-s)/(62s+1)"), 0.1, math.radians(65))
    >>> found.unmet, found.report["stable"]
    ((), True)
    """
    asked = locals()
    held, _, form = _asked({key: asked.pop(key) for key in ("plant", *_DEVICE)})
    del asked["name"]
    bounds = {"noise": _bound(noise), "disturbance": _bound(disturbance), "output_limits": _limits(output_limits)}
    return Designed(*_native.design_controller(held, form, {**asked, **bounds}, name))


_DEVICE = ("mass_kg", "damping_n_s_per_m", "hand_stiffness_n_per_m", "current_lag_s", "delay_s")
"""A device in place of a plant, and what it has in common with one."""


def _asked(asked: dict[str, Any]) -> tuple[Plant | None, Pid | None, dict[str, Any]]:
    """Plant and controller as objects, and all other keys as the command takes them."""
    form = {**asked, "output_limits": _limits(asked.get("output_limits"))}
    objects: list[Any] = [None, None]
    for at, (name, kind) in enumerate((("plant", Plant), ("controller", _native.Pid))):
        given = form.pop(name, None)
        if isinstance(given, kind):
            objects[at] = given
        elif isinstance(given, str | os.PathLike):
            if isinstance(given, os.PathLike) or given.endswith((".csv", ".toml")):
                # A missing file is an error of its own, as elsewhere in Python.
                os.stat(given)
            form[name] = os.fspath(given)
        elif given is not None:
            raise ValueError(f"a {type(given).__name__} is no {name} here: give a {kind.__name__}, a text or a path{which(given)}")
    return objects[0], objects[1], form


@_in_units
def analyze(
    plant: Plant | AnyPath | None = None,
    controller: Pid | AnyPath | None = None,
    *,
    mass_kg: float | None = None,
    damping_n_s_per_m: float | None = None,
    hand_stiffness_n_per_m: float | None = None,
    current_lag_s: float | None = None,
    delay_s: float | None = None,
    sample_time_s: float | None = None,
    scheme: str = "",
    output_limits: _Pair = None,
) -> dict[str, Any]:
    """The verdict on the loop that is really run, or the poles of a plant alone, as ``host-cli control analyze`` finds them.

    Parameters
    ----------
    plant : Plant, str or path
        The plant, its notation, or its file; not a measured one.
    controller : Pid, str or path, optional
        The controller, its notation, or its file; without it the plant is looked at alone.
    mass_kg, damping_n_s_per_m, hand_stiffness_n_per_m, current_lag_s : float, optional
        A device in place of a plant, force in and position out, with the hand that holds it and the lag of its current.
    delay_s : float, optional
        Dead time, in addition to the plant's.
    sample_time_s : float, optional
        Without it that of the controller.
    scheme : str, optional
        ``full`` or ``full-bdf2``, each with ``:TOLERANCE``; without it that of the controller.
    output_limits : (low, high) or str, optional
        Limits of the command, which play no part in the verdict.

    Returns
    -------
    dict
        What ``host-cli control analyze --json`` reports: ``stable``, None where nothing is proved, ``reason``, ``margins``, ``poles``;
        and ``warnings``.

    Raises
    ------
    OSError
        A file that cannot be read.
    ValueError
        What the command refuses.

    Examples
    --------
    >>> found = analyze("0.55exp(-s)/(62s+1)", Pid(0.1, proportional=5.0))
    >>> found["stable"], found["margins"]["phase_margin_deg"] > 90
    (True, True)
    """
    return _native.analyze_loop(*_asked(locals()))


@dataclass(frozen=True, eq=False, repr=False)
class Response(HoldsArrays, Shown, Series):
    """A simulated loop."""

    report: Mapping[str, Any]
    """What ``host-cli control simulate --json`` reports, but for its samples: ``stable``, ``shape``, ``at_reference``, the PID of order 1
    under ``integer``; and ``warnings``, which one should read."""
    reference: Floats
    """At t = 0, T, 2T, …"""
    measured: Floats
    """The output there."""
    command: Floats
    """The command from there on."""

    @property
    def t(self) -> Floats:
        """Times of the samples, s."""
        return cast("Floats", np.arange(len(self.measured)) * float(self.report["sample_time_s"]))

    def _series(self) -> Mapping[str, Floats]:
        return {"time_s": self.t, "reference": self.reference, "measured": self.measured, "command": self.command}

    def _shown(self) -> dict[str, Any]:
        return dict(self.report)


@_in_units
def simulate(
    plant: Plant | AnyPath | None = None,
    controller: Pid | AnyPath | None = None,
    *,
    mass_kg: float | None = None,
    damping_n_s_per_m: float | None = None,
    hand_stiffness_n_per_m: float | None = None,
    current_lag_s: float | None = None,
    delay_s: float | None = None,
    sample_time_s: float | None = None,
    scheme: str = "",
    output_limits: _Pair = None,
    duration_s: float | None = None,
    step: float | None = None,
    reference: ArrayLike | AnyPath | None = None,
) -> Response:
    """Runs a step or a record through a loop, or a plant alone, from rest, as ``host-cli control simulate`` does.

    Parameters
    ----------
    plant, controller, mass_kg, damping_n_s_per_m, hand_stiffness_n_per_m, current_lag_s, delay_s, sample_time_s, scheme, output_limits
        As in `analyze`; the controller's own history plays no part.
    duration_s : float, optional
        Without it the length of the reference, or 60 times 1/crossover.
    step : float, default 1
        Height of the step.
    reference : array_like, shape (n,), or path, optional
        In place of a step: at t = 0, T, 2T, …, with T of a Pid or `sample_time_s`; or a CSV with ``time_s`` and ``reference``.

    Returns
    -------
    Response

    Raises
    ------
    OSError
        A file that cannot be read.
    ValueError
        What the command refuses; a plant that does not run.

    Examples
    --------
    >>> run = simulate("1/(s+1)", "2+1/s", sample_time_s=0.01, output_limits=(0, 1.5))
    >>> run.report["at_reference"], float(run.command.max())
    (True, 1.5)
    """
    asked = {key: value for key, value in locals().items() if key != "reference"}
    sample_time = controller.sample_time if sample_time_s is None and isinstance(controller, _native.Pid) else sample_time_s
    given = None if reference is None else _sampled(reference, sample_time)
    report, signals = _native.simulate_loop(*_asked(asked), given)
    return Response(report, *signals)


def _sampled(reference: ArrayLike | AnyPath, sample_time_s: float | None) -> tuple[str, bytes] | tuple[Floats, float]:
    """Name and bytes of a table, or values and their sample time."""
    if isinstance(reference, str | os.PathLike):
        return _table(reference)
    values = _native.numbers("reference", reference)
    if values.ndim != 1:
        raise ValueError(f"reference has the shape {values.shape}: give one value for each sample")
    if sample_time_s is None:
        raise ValueError("values of a reference without times: give `sample_time_s`, or a Pid")
    return values, sample_time_s


@dataclass(frozen=True, eq=False, repr=False)
class Identified(HoldsArrays, Shown, Series):
    """A plant that was found in a record, or in a frequency response."""

    report: Mapping[str, Any]
    """What ``host-cli control identify --json`` reports: function, dead time with its interval, numbers with their errors, other
    candidates, ``validation`` and ``warnings``, which one should read."""
    t: Floats
    """Times of the record as it was fitted, s; of a response its angular frequencies, rad/s."""
    u: Floats
    """Its input; nothing of a response."""
    y: NDArray[Any]
    """Its output; the response, complex."""
    model: NDArray[Any]
    """The output of the function for this input, or its response."""
    file: str
    """The plant file, TOML."""

    @property
    def function(self) -> TransferFunction:
        """The function, without its dead time."""
        return cast("TransferFunction", TransferFunction(self.report["function"]))

    @property
    def plant(self) -> Plant:
        """Function and dead time."""
        return Plant._from_function(self.function, self.report["delay_s"])

    def _series(self) -> Mapping[str, NDArray[Any]]:
        if np.iscomplexobj(self.y):
            return {"omega_rad_s": self.t, "response": self.y, "model": self.model}
        return {"time_s": self.t, "output": self.y, "model": self.model, "input": self.u}

    def _shown(self) -> dict[str, Any]:
        return dict(self.report)


def identify(
    record: _Record,
    *,
    columns: str = "",
    sample_time_s: float | None = None,
    subtract_start: bool = False,
    smooth: bool = False,
    model: str = "",
    poles: int | None = None,
    stable: bool = False,
    delay_s: float | None = None,
    validate: _Record | None = None,
    progress: Callable[[int], object] | None = None,
) -> Identified:
    """A fractional transfer function from a record of input and output or from a frequency response, found as ``host-cli control identify`` finds it.

    Parameters
    ----------
    record : path or (t, u, y)
        A CSV with a header, a frequency response as instruments write it, or times in s with the input and output there; a missing output is NaN. Sentences call the first row of
        arrays line 2, as of a table with a header.
    columns : str, optional
        Columns of a table, as in ``"input=valve,output=temperature"``, or ``"input=12@2s"`` of one set to 12 at 2 s; without it
        ``time_s``, ``input`` and ``output``.
    sample_time_s : float, optional
        Time from row to row in s, in place of a column of time.
    subtract_start : bool, default False
        Subtract the first row: the record begins at rest, but not at 0.
    smooth : bool, default False
        The input is smooth between samples, not held.
    model : str, optional
        Terms and first values as in ``"2exp(-5s)/(30s^0.9+1)"``, or parts of a sum; without it they are found.
    poles : int, optional
        Integer orders with this number of poles, 1 to 4.
    stable : bool, default False
        Only functions that come to rest by themselves.
    delay_s : float, optional
        Known dead time, s; without it it is found.
    validate : path or (t, u, y), optional
        A second record with the same columns, on which the function is tried.
    progress : callable, optional
        Called with the number of steps that are done.

    Returns
    -------
    Identified

    Raises
    ------
    OSError
        A table that cannot be read.
    ValueError
        What the command refuses, with value, range and remedy; a record without a response to its input.

    Examples
    --------
    >>> t = np.arange(80) * 0.1
    >>> found = identify((t, np.ones(80), 2 - 2 * np.exp(-t)), poles=1)
    >>> found.report["begins"], round(found.report["numbers"][0]["value"], 6)
    ('at rest', 2.0)
    """
    form = {key: value for key, value in locals().items() if key not in ("record", "validate", "progress")}
    if columns and (isinstance(record, tuple) or isinstance(validate, tuple)):
        raise ValueError("columns belong to tables: leave them out beside arrays")
    other = None if validate is None else _table(validate)
    report, signals, file = _native.identify_plant(_table(record), other, form, progress)
    t, u, y, response = signals
    return Identified(report, t, u, y, response, file)


def _table(record: _Record) -> tuple[str, bytes]:
    """Name and bytes of a table; arrays become one."""
    if not isinstance(record, tuple):
        path = Path(record)
        return path.name, path.read_bytes()
    signals = [_native.numbers(name, signal) for name, signal in zip(("t", "u", "y"), record)]
    shapes = [signal.shape for signal in signals]
    if len(record) != 3 or len(set(shapes)) > 1 or signals[0].ndim != 1:
        raise ValueError(f"the record has arrays of the shapes {shapes}: give (t, u, y), one number of each for each time")
    rows = zip(*(signal.tolist() for signal in signals), strict=True)
    lines = (",".join("" if value != value else repr(value) for value in row) for row in rows)
    return "the record", "\n".join(["time_s,input,output", *lines]).encode()
