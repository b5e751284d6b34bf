"""Operators and controllers as matrices: ``s[n+1] = A s[n] + B x[n]``, ``y[n] = C s[n] + D x[n]``."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from fractional_haptics._native import Operator

_TAPS_OF_MODES = 16
"""The gain and the recent weights that a full memory keeps beside its modes."""
_STATES_MOST = 2048

_Matrices = tuple["NDArray[np.float64]", "NDArray[np.float64]", "NDArray[np.float64]", float]


def of(operator: Operator) -> _Matrices:
    """A, B, C and D of an operator."""
    listed = operator._list()
    if listed is None:
        raise ValueError(f"scheme {operator.scheme} is no list of coefficients: use full, or frequency_response")
    form, integer, values = listed
    if form == "taps" and len(values) > _STATES_MOST + 1:
        raise ValueError(f"scheme {operator.scheme} has {len(values) - 1} states, more than {_STATES_MOST}: use full")
    core = {"taps": _taps, "modes": _modes, "recursion": _recursion}[form](values)
    difference = (np.zeros((1, 1)), np.ones(1), -np.ones(1), 1.0)
    total = (np.ones((1, 1)), np.ones(1), np.ones(1), 1.0)
    for _ in range(abs(integer)):
        core = _series(difference, core) if integer > 0 else _series(core, total)
    return core


def _series(first: _Matrices, second: _Matrices) -> _Matrices:
    """The output of the first into the second."""
    (a1, b1, c1, d1), (a2, b2, c2, d2) = first, second
    a = np.block([[a1, np.zeros((len(b1), len(b2)))], [np.outer(b2, c1), a2]])
    return a, np.concatenate([b1, b2 * d1]), np.concatenate([d2 * c1, c2]), d1 * d2


def _beside(first: _Matrices, second: _Matrices) -> _Matrices:
    """The sum of both."""
    (a1, b1, c1, d1), (a2, b2, c2, d2) = first, second
    a = np.block([[a1, np.zeros((len(b1), len(b2)))], [np.zeros((len(b2), len(b1))), a2]])
    return a, np.concatenate([b1, b2]), np.concatenate([c1, c2]), d1 + d2


def _taps(values: NDArray[np.float64]) -> _Matrices:
    count = len(values) - 1
    b = np.zeros(count)
    b[:1] = 1.0
    return np.eye(count, k=-1), b, values[1:], float(values[0])


def _modes(values: NDArray[np.float64]) -> _Matrices:
    decay, weight = values[_TAPS_OF_MODES::2], values[_TAPS_OF_MODES + 1 :: 2]
    used = weight != 0
    bank = (np.diag(1 - decay[used]), np.ones(np.count_nonzero(used)), weight[used], 0.0)
    return _beside(_taps(values[:_TAPS_OF_MODES]), bank)


def _recursion(values: NDArray[np.float64]) -> _Matrices:
    gain, forward, backward = float(values[0]), values[1::2], values[2::2]
    a = np.eye(len(forward), k=1)
    a[:, 0] -= backward
    c = np.zeros(len(forward))
    c[:1] = 1.0
    return a, forward - backward * gain, c, gain


def pid(parameters: Mapping[str, float], low: float, high: float, sections: int) -> _Matrices:
    """A, B, C and D of ``Kp + Ki s^-lambda + Kd s^mu`` in continuous time: ``s' = A s + B e``, ``u = C s + D e``."""
    nothing: _Matrices = (np.zeros((0, 0)), np.zeros(0), np.zeros(0), parameters["proportional"])
    integrator = (np.zeros((1, 1)), np.ones(1), np.ones(1), 0.0)
    slope = (np.array([[-high]]), np.ones(1), np.array([-high * high]), high)
    total = nothing
    for gain, order, one in (
        (parameters["integral"], -parameters["integral_order"], integrator),
        (parameters["derivative"], parameters["derivative_order"], slope),
    ):
        if gain == 0:
            continue
        # Of s^-0.4 an integrator and s^0.6, of s^1.6 a slope and s^0.6.
        whole = int(np.ceil(-order) if order < 0 else np.floor(order))
        part = _power(order + whole if order < 0 else order - whole, low, high, sections)
        for _ in range(whole):
            part = _series(part, one)
        a, b, c, d = part
        total = _beside(total, (a, b, gain * c, gain * d))
    return total


def _power(order: float, low: float, high: float, sections: int) -> _Matrices:
    """``s^order`` between two frequencies, for 0 <= order < 1; 0 is exact."""
    power: _Matrices = (np.zeros((0, 0)), np.zeros(0), np.zeros(0), high**order)
    for k in range(1, sections + 1) if order > 0 else ():
        zero, pole = (low * (high / low) ** ((2 * k - 1 + sign * order) / (2 * sections)) for sign in (-1, 1))
        power = _series(power, (np.array([[-pole]]), np.ones(1), np.array([zero - pole]), 1.0))
    return power
