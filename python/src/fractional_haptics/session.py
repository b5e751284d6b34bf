"""A person feels walls: the crate ``haptic-experiment``, its room ``live``.

::

    with session.open("serial:auto", force_limit="1 N", log="p07.mcap") as s:
        s.allow(walls)                      # each judged now
        felt = s.feel(walls[0], seconds=3)
        s.rest()
        s.mark("answer", "second")

A wall is a dict with the keys of a ``[wall]`` for its law: ``order``, ``stiffness_n_per_m``, ``dissipation_n_s_mu_per_m``, or
``tissue``, a name, a file or a `tissue.Material`, with ``area_m2`` and the like of the piece; and perhaps ``scheme`` and
``contact``. It only pushes. The device is armed once, with its loop on this computer; between two walls
there is no force. After Ctrl-C, a signal or the end of Python the force ramps to zero and the log is closed, as for a run of
`experiment`.
"""

from __future__ import annotations

import json
import math
import os
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, SupportsFloat

from fractional_haptics import _native
from fractional_haptics._values import Shown
from fractional_haptics.experiment import Progress, _files, _told

if TYPE_CHECKING:
    from types import TracebackType
    from typing import Self

    from fractional_haptics._values import Quantity

__all__ = ["Felt", "Session", "open"]

_LOOKS_EVERY_S = 0.02
"""Time between two calls of ``until``, s."""


@dataclass(frozen=True)
class Felt(Shown):
    """What was felt of a wall, in SI units."""

    touched: bool
    """The handle was behind the surface; if it was not, this was no trial: feel it again."""
    tick: int
    """The first tick, in the log."""
    time_s: float
    """Its time there."""
    duration_s: float
    """For how long the wall was there to be felt."""
    contacts: int
    """How often the handle went behind its surface."""
    dwell_s: float
    """For how long it was there."""
    peak_force_n: float | None
    """Largest force in contact; None without contact."""
    mean_force_n: float | None
    """Mean over the contact."""
    rms_force_n: float | None
    """Root of the mean square over the contact."""
    deepest_m: float
    """Largest depth behind the surface; 0 without contact."""
    speed_m_per_s: float
    """Mean speed of the handle, in contact or not."""
    exact_share: float | None
    """Share of the ticks with a force, asked or sent, whose force was the wall's to 1e-8 N; None without a force."""
    fade_ticks: int
    """Ticks whose force another wall had a part in."""
    energy_ticks: int
    """Ticks whose force the energy of the touch reduced."""
    limit_ticks: int
    """Ticks whose force a limit changed."""
    least_factor: float
    """Least factor by which energy reduced the force; 1 if it did not."""
    largest_step_n: float
    """Largest change of the force in a tick that the wall itself did not make."""

    __str__ = Shown.__str__


def _seconds(name: str, time: Quantity) -> float:
    value = _native.quantity(["time_s"], "time_s", time, False)[1]
    if not 0.0 <= value < 1e9:
        raise ValueError(f"{name} = {value} is not a time from 0 s to 1e9 s: change it")
    return value


def _text(value: Any) -> str:
    # Numbers of NumPy are those of Python.
    return repr(float(value)) if isinstance(value, SupportsFloat) else value.to_toml() if hasattr(value, "to_toml") else str(value)


def _key(wall: Mapping[str, Any]) -> tuple[tuple[str, str], ...]:
    return tuple(sorted((key, _text(value)) for key, value in wall.items()))


class Session:
    """An open session; made by `open`, and closed by ``with`` or `close`."""

    log: Path
    """The log."""
    report: Mapping[str, Any] | None = None
    """Once closed: samples, those that are missing, warnings."""

    def __init__(self, native: _native.Session, log: Path) -> None:
        self._native = native
        self._allowed: dict[tuple[tuple[str, str], ...], int] = {}
        # Questions about what was felt last; None before.
        self._rated: set[str] | None = None
        self.log = log

    def allow(self, walls: Iterable[Mapping[str, Any]]) -> None:
        """Judges walls on this device, free and in a hand. All of them may be felt, or none.

        Raises
        ------
        ValueError
            The first that may not be felt, by its place from 0 on, and why.
        """
        new = [dict(wall) for wall in walls]
        with _files(new) as plain:
            first = self._native.allow(plain)
        self._allowed.update({_key(wall): first + place for place, wall in enumerate(new)})

    def allow_between(self, first: Mapping[str, Any], second: Mapping[str, Any]) -> None:
        """Proves all walls between two stable, free and in a hand, and all that is felt while one becomes another; any of them may be felt
        then. Passivity, in every hand there may be, is not proved.

        Between two walls lie their orders, stiffnesses and dissipations; between two tissues of one model the numbers of the model.

        Raises
        ------
        ValueError
            Two walls of different kinds; a region that is not proved, with the largest part of it that is.
        """
        with _files([first, second]) as (one, other):
            self._native.allow_between(one, other)

    def feel(
        self,
        wall: Mapping[str, Any],
        *,
        seconds: Quantity | None = None,
        until: Callable[[], object] | None = None,
        surface: Quantity = 0.0,
        patience: Quantity = 30.0,
        progress: Progress | None = None,
    ) -> Felt:
        """Makes a wall be felt, and sums what is felt of it. The wall stays until `rest`, `pause` or the next one.

        Where no wall was, it begins with an empty memory, as soon as the handle is in front of it. Where one is felt, this takes its
        place without a bump, held or not, and has heard the same positions; it waits until no other fades, and is whole after its own
        fade, or a warning says that the energy of the touch was not enough for that.

        Parameters
        ----------
        wall : dict
            One of those that were allowed, or one between two that were.
        seconds : float or str, optional
            For how long.
        until : callable, optional
            Called each 20 ms; a true value ends it. With `seconds` too, whichever comes first.
        surface : float or str, default 0
            Place of its surface, m.
        patience : float or str, default 30 s
            For how long it waits for a handle that is behind the surface of a first wall, as one that was just switched on.
        progress : callable, optional
            Called now and then with the ticks felt; or a bar of ``tqdm``.

        Raises
        ------
        ValueError
            A wall that was not allowed, with the nearest that was; or one that the wall that is felt cannot become without a mix that may
            be unstable. The session goes on.
        TimeoutError
            The handle was still behind the surface after the patience. The wall does not come any more.
        RuntimeError
            A fault, a lost device or a stop: the session has ended, its log is kept. A call from another thread, or from ``progress``.
        """
        if seconds is None and until is None:
            raise ValueError("the end of feel is missing: give seconds or until")
        number = self._allowed.get(_key(wall))
        if number is None:
            with _files([wall]) as (plain,):
                number = self._native.inside(plain)
            self._allowed[_key(wall)] = number
        _, surface_m = _native.quantity(["surface_m"], "surface", surface, isinstance(surface, int | float))
        sample_time = self._native.sample_time
        ticks = None if seconds is None else max(round(_seconds("seconds", seconds) / sample_time), 1)
        patience_s = _seconds("patience", patience)
        if not self._native.feel(number, surface_m, ticks, patience_s):
            raise TimeoutError(
                f"the handle is not in front of the surface at {surface_m:g} m after {patience_s:g} s: ask for it to be moved out, then feel again"
            )
        told = _told(progress)
        if until is None:
            assert ticks is not None
            self._native.go_on(ticks, told)
        else:
            step, felt = max(round(_LOOKS_EVERY_S / sample_time), 1), 0
            while (ticks is None or felt < ticks) and not until():
                felt = felt + step if ticks is None else min(felt + step, ticks)
                self._native.go_on(felt, told)
        result = Felt(**self._native.felt())
        self._rated = set() if result.touched else None
        if result.energy_ticks:
            warnings.warn(
                f"the wall was felt at down to {result.least_factor:.3f} of its force, in {result.energy_ticks} ticks: the touch in which it "
                "came had no more energy for it; rest, and let it be touched anew",
                RuntimeWarning,
                stacklevel=2,
            )
        return result

    def rest(self, patience: Quantity = 30.0) -> None:
        """Waits until the handle has left the wall, which then goes.

        Raises
        ------
        TimeoutError
            The handle was still in the wall after the patience, s. The wall stays until the handle leaves.
        """
        patience_s = _seconds("patience", patience)
        if not self._native.rest(patience_s):
            raise TimeoutError(f"the handle is still in the wall after {patience_s:g} s: ask for it to be moved out, then rest again")

    def pause(self) -> None:
        """Takes the wall away, held or not: its force fades. The session goes on."""
        self._native.pause()

    def hand(self, path: Sequence[tuple[float, float]]) -> None:
        """Moves the hand on the simulated device: places in m at times in s from now on, evenly in between."""
        self._native.hand([(float(time), float(place)) for time, place in path])

    def mark(self, kind: str, text: str = "") -> None:
        """Puts a mark into the log, with its time. An ``"answer"`` needs a wall that was felt since the last one."""
        self._native.mark(kind, text)

    def rate(
        self, rating: float | str, question: str = "rating", *, scale: tuple[float, float] | None = None, step: float | None = None
    ) -> float:
        """Puts a rating of what was felt last into the log, as a mark ``"rating"`` with a JSON text, and returns it.

        Parameters
        ----------
        rating : float or str
            A number, or what somebody wrote.
        question : str
            What was asked, as ``"softness"``; once for each wall.
        scale : tuple, optional
            Its ends. Without them any number above 0 will do: the estimate of a magnitude.
        step : float, optional
            Marks of the scale, from its low end on: nothing in between.

        Raises
        ------
        ValueError
            No number, one that is not on the scale, a scale that is none, nothing felt, a question that was answered. Ask again.
        """
        low, high = (0.0, math.inf) if scale is None else map(float, scale)
        ends = f"from {low:g} to {high:g}" if scale else "above 0"
        if not low < high or not math.isfinite(low) or (scale is not None and math.isinf(high)):
            raise ValueError(f"scale {scale} has no low end below a high one: give it as (0, 10)")
        if step is not None and (scale is None or not 0.0 < step <= high - low):
            raise ValueError(f"step {step} is none of the scale {scale}: give one from 0 to its length")
        try:
            number = float(rating)
        except (TypeError, ValueError):
            raise ValueError(f"rating {rating!r} is no number: give one {ends}") from None
        marks = 0.0 if step is None else (number - low) / step
        if isinstance(rating, bool) or not low <= number < math.inf or number > high or (scale is None and number == 0.0):
            raise ValueError(f"rating {rating} is not {ends}: give one that is")
        if abs(marks - round(marks)) > 1e-6:
            raise ValueError(f"rating {rating} is between the marks of its scale: give {ends} in steps of {step:g}")
        if self._rated is None or question in self._rated:
            raise ValueError(f"nothing was felt since the last {question}: feel a wall first, then rate it")
        said = {"question": question, "rating": number, "scale": scale, "step": step}
        self.mark("rating", json.dumps(said))
        self._rated.add(question)
        return number

    def stop(self) -> None:
        """Ends the session at once, from any thread, but not from ``progress``: the force ramps to zero, the log is kept."""
        self._native.stop()

    def close(self) -> None:
        """Ends the session: the force falls to zero, the device lets go, the log is closed."""
        self.report = self._native.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        try:
            if error is not None:
                self.stop()
            self.close()
        except RuntimeError:
            # What ended the session has been said already.
            if error is None:
                raise


def open(
    device: str = "sim",
    *,
    log: str | os.PathLike[str],
    force_limit: Quantity | None = None,
    realtime: bool = False,
    **parameters: Any,
) -> Session:
    """Opens a session on a device, which is armed when this returns: its force may be whole.

    Parameters
    ----------
    device : str, default "sim"
        As for `experiment.wall`; ``"sim"`` is simulated, with a hand that `Session.hand` moves.
    log : path
        The log of all that happens, ``NAME.mcap``; it must not be there yet.
    force_limit : float or str
        Largest force on the person, N.
    realtime : bool, default False
        By the clock on the simulated device too, which else has virtual time.
    **parameters
        Keys of a ``[wall]`` for the device, its loop and its safety chain, as ``mass="65 g"`` or ``device_model="mine.toml"``. A real
        device needs its mass and damping, or its file from ``host-cli device measure``.

    Raises
    ------
    ValueError
        A parameter that is wrong or missing, a log that exists, a device that has a session already.
    RuntimeError
        A device that cannot be used.
    """
    given = {key: value for key, value in parameters.items() if value is not None}
    if force_limit is not None:
        given["force_limit"] = force_limit
    drives = device != "sim"
    if drives:
        given["device"] = device
    path = Path(log)
    return Session(_native.open_session(given, path, realtime or drives, drives), path)
