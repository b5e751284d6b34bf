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

import numpy as np

from fractional_haptics import _native
from fractional_haptics._native import Operator

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

__all__ = ["Operator", "differintegrate", "frequency_response", "grunwald_weights"]


def differintegrate(
    x: ArrayLike,
    order: float,
    sample_time: float,
    scheme: str = "exact",
    axis: int = 0,
    *,
    reference: float | None = 0.0,
) -> NDArray[np.float64]:
    """``D^order`` of whole records, all samples at once.

    Parameters
    ----------
    x : array_like
        Samples along `axis`; every other axis is a channel. Integers are converted.
    order : float
        Order, -2 to 2: positive differentiates, negative integrates.
    sample_time : float
        Time between samples in s, 1e-9 to 1e6.
    scheme : str, default "exact"
        See the module. Full memories are summed over the whole record, by FFT, so a tolerance plays no part; ``grunwald:N``
        over its N newest samples. The others are run sample by sample.
    axis : int, default 0
        Axis of time.
    reference : float or None, default 0
        The value at which the signal stood before the record; None takes the first sample of each channel (Caputo).

    Returns
    -------
    ndarray, shape of `x`
        The derivative in the unit of x, times s^(-order). Outputs that a NaN or an infinity in x reaches are NaN.

    Raises
    ------
    ValueError
        A parameter outside its range, an unknown scheme, no axis, no real numbers.

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
    samples = np.asarray(x)
    if samples.ndim == 0:
        raise ValueError("x is a single number, and must have an axis of time")
    if not -samples.ndim <= axis < samples.ndim:
        raise ValueError(f"axis {axis} is not one of the {samples.ndim} of x, whose shape is {samples.shape}")
    last = np.moveaxis(samples, axis, -1)
    channels = list(last.reshape(-1, last.shape[-1])) if last.size else []
    outputs = _native.differintegrate(channels, order, sample_time, scheme, reference)
    y = np.reshape(outputs, last.shape) if outputs else np.empty(last.shape)
    return np.moveaxis(y, -1, axis)


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
        The order is outside its range.

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
