"""``D^μ`` of whole records and of streams: the crate ``fracdiff``.

::

    y[n] = T^(-order) * sum_j w_j (x[n-j] - reference)

Schemes, that is how the weights ``w_j`` are made:

============================  =====================================================================
``grunwald:N``                the N newest samples
``muir:N``                    Muir polynomial of degree N
``tustin-muir:N``             recursive form of degree N
``oustaloup:N:LOW_HZ:HIGH_HZ``  N first-order sections between two corners
``full[:TOLERANCE]``          full memory, Grünwald weights
``piecewise-linear[:TOLERANCE]``  full memory, exact for straight lines (Caputo L1)
``full-bdf2[:TOLERANCE]``     full memory, of second order in T
``exact``                     (1 - w)^order itself: whole records and analysis only
============================  =====================================================================
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from fractional_haptics import _native
from fractional_haptics._native import Operator

# NumPy takes most of the time of an import, and a stream of single samples does without.
if TYPE_CHECKING:
    import control
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

__all__ = ["Operator", "differintegrate", "frequency_response", "grunwald_weights", "state_space", "to_control"]


def differintegrate(
    x: ArrayLike,
    order: float,
    sample_time: float,
    scheme: str = "exact",
    axis: int = -1,
    *,
    reference: float | None = 0.0,
) -> NDArray[np.float64]:
    """``D^order`` of whole records, all samples at once.

    Parameters
    ----------
    x : array_like
        Samples along `axis`; every other axis is a channel. Integers are converted, masked arrays refused.
    order : float
        Order, -2 to 2: positive differentiates, negative integrates.
    sample_time : float
        Time between samples in s, 1e-9 to 1e6.
    scheme : str, default "exact"
        See the module. Full memories are summed over the whole record, by FFT, so a tolerance plays no part; ``grunwald:N``
        over its N newest samples. The others are run sample by sample.
    axis : int, default -1
        Axis of time: the last, as in NumPy and SciPy.
    reference : float or None, default 0
        The value at which the signal stood before the record; None takes the first sample of each channel: the
        Caputo derivative, for an order above 0 and at most 1.

    Returns
    -------
    ndarray, shape of `x`
        The derivative in the unit of x, times s^(-order).

    Raises
    ------
    ValueError
        A parameter outside its range, an unknown scheme, no axis, no real numbers; a sample that is not finite, with its index.

    Notes
    -----
    Releases the interpreter. O(n log n) in time, about 1e-15 of the largest value in error, 1e-12 at most.

    References
    ----------
    I. Podlubny, *Fractional Differential Equations*, Academic Press, 1999, chapter 7.

    Examples
    --------
    The half derivative of a ramp is ``2 sqrt(t/pi)``:

    >>> import numpy as np
    >>> t = np.arange(1000) * 1e-3
    >>> y = differintegrate(t, 0.5, 1e-3, "piecewise-linear")
    >>> bool(abs(y[-1] - 2 * np.sqrt(t[-1] / np.pi)) < 1e-10)
    True
    """
    import numpy as np

    # The mask stays, for the refusal.
    samples = x if isinstance(x, np.ma.MaskedArray) else np.asarray(x)
    if samples.ndim == 0:
        raise ValueError("x is a single number, and must have an axis of time")
    if not -samples.ndim <= axis < samples.ndim:
        raise ValueError(f"axis {axis} is not one of the {samples.ndim} of x, whose shape is {samples.shape}")
    last = np.moveaxis(samples, axis, -1)
    channels = list(last.reshape(-1, last.shape[-1])) if last.size else []
    outputs = _native.differintegrate(channels, order, sample_time, scheme, reference)
    if not outputs:
        return np.empty(samples.shape)
    # One channel as it is: a copy of a long record costs as much as a tenth of its derivative.
    y = outputs[0] if len(outputs) == 1 else np.stack(outputs)
    return np.moveaxis(y.reshape(last.shape), -1, axis)


def grunwald_weights(order: float, count: int) -> NDArray[np.float64]:
    """The first weights ``c_0, c_1, …`` of ``(1 - w)^order``.

    Parameters
    ----------
    order : float
        Order, -2 to 2.
    count : int
        Number of weights.

    Returns
    -------
    ndarray, shape (count,)
        Without unit: ``D^order x`` is ``T^(-order)`` times their convolution with x.

    Raises
    ------
    ValueError
        The order is outside its range; a negative count, or one that memory has no room for.

    References
    ----------
    I. Podlubny, *Fractional Differential Equations*, Academic Press, 1999, eq. 7.23.

    Examples
    --------
    >>> grunwald_weights(2.0, 4).tolist()
    [1.0, -2.0, 1.0, 0.0]
    """
    return _native.grunwald_weights(order, count)


def frequency_response(
    omega: ArrayLike,
    order: float,
    sample_time: float,
    scheme: str = "exact",
    horizon: float = 3600.0,
) -> NDArray[np.complex128]:
    """Frequency response of an operator, ``exact`` too.

    Parameters
    ----------
    omega : array_like
        Frequencies in rad/s, 0 to pi/T, of any shape.
    order, sample_time, scheme, horizon
        As in `Operator`.

    Returns
    -------
    ndarray of complex, shape of `omega`
        ``T^(-order) P(exp(-j omega T))`` in s^(-order).

    Raises
    ------
    ValueError
        A frequency above half the sample rate, with its index; a parameter outside its range.

    Examples
    --------
    >>> H = frequency_response([10.0], 0.5, 1e-3)
    >>> bool(abs(abs(H[0]) - 10.0**0.5) < 1e-4)
    True
    """
    return _native.frequency_response(omega, order, sample_time, scheme, horizon)


def state_space(operator: Operator) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], float]:
    """An operator as matrices: ``s[n+1] = A s[n] + B x[n]``, ``y[n] = C s[n] + D x[n]``.

    Parameters
    ----------
    operator : Operator
        Of any scheme but ``full-bdf2``; of ``grunwald:N`` with N up to 2049.

    Returns
    -------
    a : ndarray, shape (n, n)
    b, c : ndarray, shape (n,)
    d : float
        Of a full memory: recent increments in a shift register, then a state for each mode.

    Raises
    ------
    ValueError
        A scheme without such matrices, or too many states.
    """
    from fractional_haptics import _matrices

    if not isinstance(operator, Operator):
        from fractional_haptics._values import which

        raise ValueError(f"a {type(operator).__name__} is no operator: give an Operator of order and sample time{which(operator)}")
    return _matrices.of(operator)


def to_control(operator: Operator) -> control.StateSpace:
    """An operator for python-control, exactly as it runs.

    Parameters
    ----------
    operator : Operator
        As in `state_space`.

    Returns
    -------
    control.StateSpace
        At the sample time of the operator.

    Raises
    ------
    ValueError
        As `state_space`.
    """
    from fractional_haptics._values import needed

    control = needed("control")
    a, b, c, d = state_space(operator)
    return control.StateSpace(a, b[:, None], c[None, :], [[d]], operator.sample_time, remove_useless_states=False)
