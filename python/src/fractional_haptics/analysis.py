"""What is stable, passive and transparent, before any hardware: the crate ``haptic-analysis``.

A *plant* is a `Device` (mass, damper, hand, delay, lag), a `LinearPlant` of any matrices, or a continuous
``control.StateSpace`` from force in N to position in m. A *wall* is ``K + B D^order`` with K in N/m and B in N·s^order/m.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np

from fractional_haptics import _native
from fractional_haptics._native import Coupler, LinearPlant, Port, Region
from fractional_haptics._series import Series
from fractional_haptics._values import HoldsArrays, Shown, needed, which

if TYPE_CHECKING:
    import control
    from numpy.typing import ArrayLike, NDArray
    from typing import TypeAlias

    from fractional_haptics._values import Floats, Quantity

    Plant: TypeAlias = "Device | LinearPlant | control.StateSpace"

__all__ = [
    "AtFrequency",
    "Coupled",
    "Coupler",
    "Device",
    "Felt",
    "LinearPlant",
    "Loop",
    "Margins",
    "Port",
    "Region",
    "SlopeLimit",
    "Verdict",
    "coupled",
    "plant_from_control",
    "region",
    "transparency",
]


class AtFrequency(NamedTuple):
    """A value, and the frequency at which it arises."""

    value: float
    omega_rad_s: float


class Device(_native.Device):
    """A device as every analysis takes it: mass, damper, hand, delay and lag of the force.

    ::

        m x'' + b x' + k x = f,    tau f' = u(t - delay) - f

    Parameters
    ----------
    mass_kg : float or str
        m of device and hand, above 0. Each of these may be a text with a unit, ``"65 g"``, and be named without its unit, ``mass=``.
        A number without a unit that no device has is asked for it: ``Device(65)``, but not ``Device(mass_kg=65)``.
    damping_n_s_per_m : float or str, default 0
        b of device and hand, at least 0.
    hand_stiffness_n_per_m : float or str, default 0
        k of the hand.
    delay_s : float or str, default 0
        From a measurement to the force that answers it, beside the hold of one sample; not necessarily whole samples.
    current_lag_s : float or str, default 0
        tau, time constant of the motor current.

    Notes
    -----
    The longest delay and lag, 10 000 and 1e6 sample times, are checked where it is used.

    Raises
    ------
    ValueError
        A parameter outside its range, a text that is no such quantity.
    TypeError
        No mass, a name that is none of these or is given twice.

    Examples
    --------
    >>> Device(0.065, 3.5).mass_kg
    0.065
    >>> Device("65 g", damping="3.5 N.s/m") == Device(0.065, 3.5)
    True
    """

    # Only here it can be seen whether a number was named with its unit.
    def __new__(cls, *given: Quantity | None, **named: Quantity | None) -> Device:
        keys = ["mass_kg", "damping_n_s_per_m", "hand_stiffness_n_per_m", "delay_s", "current_lag_s"]
        if len(given) > len(keys):
            raise TypeError(f"a Device has {len(keys)} numbers, {', '.join(keys)}: {len(given)} are given")
        numbers: dict[str, float] = {}
        for name, value in [*zip(keys, given, strict=False), *named.items()]:
            if value is None:
                continue
            key, number = _native.quantity(keys, name, value, name not in named)
            if key in numbers:
                raise TypeError(f"{key} is given twice: leave one out")
            numbers[key] = number
        if "mass_kg" not in numbers:
            raise TypeError('a Device needs its mass: Device("65 g")')
        return super().__new__(cls, *(numbers.get(key, 0.0) for key in keys))


@dataclass(frozen=True)
class Verdict(Shown):
    """The certified verdict on a loop."""

    stable: bool
    """All poles are within the unit circle."""
    unstable_poles: int | None
    """Poles outside; None on the boundary."""
    distance: float
    """Distance of the characteristic function from zero on the circle, in units of the dimensionless stiffness."""
    omega_rad_s: float
    """The frequency of that."""
    spectral_radius: float | None
    """Largest pole in magnitude, for polynomial and rational operators of moderate degree."""
    drifts: bool
    """Nothing holds the plant at rest, which is no instability: it was judged beside that pole."""


@dataclass(frozen=True)
class Margins(Shown):
    """The margins of a stable loop."""

    gain_up: AtFrequency | None
    """Least factor above 1 on the wall that takes the loop to the boundary; None if none does."""
    gain_down: AtFrequency | None
    """Largest factor below 1 that does."""
    delay_s: AtFrequency | None
    """Least additional delay that does, s."""
    sensitivity: AtFrequency
    """Largest ``abs(1/(1 + GH))``; 1 over it is the distance from -1."""


@dataclass(frozen=True)
class SlopeLimit(Shown):
    """How steep contact may be, as factors on the wall."""

    linear: float
    """A linear wall is stable below this; infinite if every one is, 0 if none is."""
    provable: float
    """No multiplier proves more than this."""
    proved: float
    """Proved for every motion of contact that may pull and is nowhere steeper. 0 if nothing is."""
    multiplier: list[tuple[int, float]]
    """Lags and weights of the Zames-Falb multiplier that proves it."""


@dataclass(frozen=True, eq=False, repr=False)
class Felt(HoldsArrays, Shown, Series):
    """The closed loop as a hand feels it."""

    omega_rad_s: Floats
    stiffness_n_per_m: Floats
    """Effective stiffness; positive pushes back."""
    damping_n_s_per_m: Floats
    """Effective damping; positive takes energy."""

    def _series(self) -> Mapping[str, Floats]:
        return vars(self)


@dataclass(frozen=True)
class Coupled(Shown):
    """A device, a coupler and an object, really sampled."""

    stable: bool
    unstable_poles: int | None
    gain_up: AtFrequency | None
    """Least factor above 1 on the coupler that takes the loop to the boundary."""


def _at(pair: tuple[float, float] | None) -> AtFrequency | None:
    return None if pair is None else AtFrequency(*pair)


def plant_from_control(system: control.StateSpace, *, delay_s: float = 0.0, current_lag_s: float = 0.0) -> LinearPlant:
    """A plant from python-control's state space.

    Parameters
    ----------
    system : control.StateSpace
        Continuous, one input in N, one output in m, D = 0.
    delay_s, current_lag_s : float, default 0
        As in `Device`.

    Returns
    -------
    LinearPlant

    Raises
    ------
    ValueError
        A system in discrete time, with more than one input or output, or with a direct path.
    """
    if system.ninputs != 1 or system.noutputs != 1:
        raise ValueError(f"the plant has {system.ninputs} inputs and {system.noutputs} outputs, and must have one each")
    if system.isdtime(strict=True):
        raise ValueError("the plant is in discrete time: give the continuous one, it is sampled exactly here")
    if np.any(system.D != 0):
        raise ValueError("the plant has a direct path D from force to position, and must have none")
    return LinearPlant(system.A, system.B, system.C, delay_s, current_lag_s)


def _plant(plant: Plant) -> Device | LinearPlant:
    """A plant of ours, from one of python-control's too."""
    if isinstance(plant, Device | LinearPlant):
        return plant
    if all(hasattr(plant, name) for name in ("A", "B", "C", "D", "ninputs")):
        return plant_from_control(plant)
    raise ValueError(
        f"a {type(plant).__name__} is no plant here: give a Device, a LinearPlant or a control.StateSpace{which(plant)}"
    )


def _impedance(plant: Device | LinearPlant, omega: Floats) -> NDArray[np.complex128]:
    """Velocity in, force out, without hand: ``jωm + b``, or ``1/(jω C (jω - A)^-1 B)``; NaN where it has none."""
    if isinstance(plant, Device):
        return cast("NDArray[np.complex128]", plant.damping_n_s_per_m + 1j * omega * plant.mass_kg)
    states = len(plant._b)
    matrices = 1j * omega[:, None, None] * np.eye(states) - plant._a.reshape(states, states)
    inputs = np.broadcast_to(plant._b[:, None].astype(complex), (len(omega), states, 1))
    with np.errstate(all="ignore"):
        response = np.linalg.solve(matrices, inputs)[..., 0] @ plant._c
        return 1 / (1j * omega * response)


class Loop(_native.Loop):
    __doc__ = _native.Loop.__doc__

    def __new__(
        cls,
        plant: Plant,
        stiffness_n_per_m: float,
        dissipation_n_s_mu_per_m: float,
        order: float,
        sample_time: float,
        scheme: str = "exact",
        horizon: float = 3600.0,
    ) -> Loop:
        arguments = (_plant(plant), stiffness_n_per_m, dissipation_n_s_mu_per_m, order, sample_time, scheme, horizon)
        return cast("Loop", super().__new__(cls, *arguments))

    def verdict(self) -> Verdict:
        """Is the loop stable, and how far from the boundary?

        Returns
        -------
        Verdict
        """
        return Verdict(**self._verdict())

    def margins(self) -> Margins:
        """Gain, delay and sensitivity margins; no crossing is missed.

        Returns
        -------
        Margins

        Raises
        ------
        ValueError
            The loop is not stable.
        """
        found = self._margins()
        crossings: dict[str, Any] = {name: _at(pair) for name, pair in found.items()}
        return Margins(**crossings)

    def slope_limit(self) -> SlopeLimit:
        """How steep contact that may pull, one-sided or stiffening, may be for stability under every motion.

        Contact acts before the memory; a clamp behind it that keeps tissue from pulling is not covered, and
        hard hits can grow behind it.

        Returns
        -------
        SlopeLimit
            Factors on the wall, of which 1 is the wall itself.
        """
        return SlopeLimit(**self._slope_limit())

    def sensitivity_peak(self) -> AtFrequency:
        """The largest sensitivity.

        Returns
        -------
        AtFrequency

        Raises
        ------
        ValueError
            The loop is not stable.
        """
        return AtFrequency(*self._sensitivity_peak())

    def to_control(self, omega: ArrayLike | None = None) -> control.FrequencyResponseData:
        """The loop gain for python-control: ``control.bode_plot``, ``control.margin``, ``control.nyquist_plot``.

        Parameters
        ----------
        omega : array_like, optional
            Frequencies in rad/s; without it 1000 over five decades up to half the sample rate.

        Returns
        -------
        control.FrequencyResponseData
            GH, without unit; without a time base, so that it combines with systems of any sample time. Data have no step response.
        """
        control = needed("control")
        nyquist = np.pi / self.sample_time
        grid = np.geomspace(1e-5 * nyquist, nyquist, 1000) if omega is None else _native.numbers("omega", omega)
        # Its figures of data want a name, and have no frequencies of a sampled system.
        return control.FrequencyResponseData(self.loop_gain(grid), grid, None, name="loop gain")


def region(
    plant: Plant,
    order: float,
    sample_time: float,
    scheme: str = "exact",
    points: int = 500,
    horizon: float = 3600.0,
) -> Region:
    """All stable walls of an order on a plant.

    Parameters
    ----------
    plant : Device, LinearPlant or control.StateSpace
        The plant.
    order : float
        0 to 2.
    sample_time : float
        T in s.
    scheme : str, default "exact"
        The operator that runs, see `fractional_haptics.operators`.
    points : int, default 500
        About so many points on the boundary.
    horizon : float, default 3600
        As in `Operator`.

    Returns
    -------
    Region

    Raises
    ------
    ValueError
        A parameter outside its range; pieces that do not close to polygons.

    Notes
    -----
    By D-decomposition: points on the boundary to about 1e-12, extremes to 1e-10.

    Examples
    --------
    >>> found = region(Device(0.065, 3.5), 0.5, 1e-3)
    >>> found.polygons[0].shape[1], bool(found.contains(1000.0, 3.0))
    (2, True)
    """
    return _native.stability_region(_plant(plant), order, sample_time, scheme, points, horizon)


def transparency(
    plant: Plant,
    stiffness_n_per_m: float,
    dissipation_n_s_mu_per_m: float,
    order: float,
    sample_time: float,
    omega: ArrayLike,
    scheme: str = "exact",
    horizon: float = 3600.0,
) -> Felt:
    """Stiffness and damping of the closed loop as a hand feels them.

    Parameters
    ----------
    plant, stiffness_n_per_m, dissipation_n_s_mu_per_m, order, sample_time, scheme, horizon
        As in `Loop`. The stiffness of a device's hand plays no part: the hand is what feels.
    omega : array_like, shape (n,)
        Frequencies in rad/s, above 0 up to pi/T.

    Returns
    -------
    Felt

    Raises
    ------
    ValueError
        A frequency outside its range, with its index.

    References
    ----------
    O. Tokatlı, *Fractional Order Control in Haptics*, eqs. 6.1, 6.2.

    Examples
    --------
    A spring less the inertia, and a hold that takes KT/2 of the damping away:

    >>> felt = transparency(Device(0.065, 3.5), 500.0, 0.0, 0.5, 1e-3, [10.0])
    >>> round(float(felt.stiffness_n_per_m[0]), 1), round(float(felt.damping_n_s_per_m[0]), 2)
    (493.5, 3.25)
    """
    frequencies = np.atleast_1d(_native.numbers("omega", omega))
    own = _plant(plant)
    stiffness, damping = _native.transparency(
        frequencies,
        _impedance(own, frequencies),
        own,
        (stiffness_n_per_m, dissipation_n_s_mu_per_m, order),
        (sample_time, scheme, horizon),
    )
    return Felt(frequencies, stiffness, damping)


def coupled(
    device: Device,
    coupler: Coupler,
    *,
    object_mass_kg: float = 0.0,
    object_damping_n_s_per_m: float = 0.0,
    object_stiffness_n_per_m: float = 0.0,
    scheme: str = "full",
    horizon: float = 3600.0,
) -> Coupled:
    """A device, a coupler of order 0 to 1 and an object behind it, as they are really sampled.

    Parameters
    ----------
    device : Device
        The device.
    coupler : Coupler
        The coupler; it runs an operator of order 1 less its own on its deflection.
    object_mass_kg, object_damping_n_s_per_m, object_stiffness_n_per_m : float, default 0
        The object, under Tustin's rule; one of them above 0.
    scheme : str, default "full"
        The operator that runs.
    horizon : float, default 3600
        As in `Operator`.

    Returns
    -------
    Coupled

    Raises
    ------
    ValueError
        A parameter outside its range.
    """
    impedance = (object_mass_kg, object_damping_n_s_per_m, object_stiffness_n_per_m)
    found = coupler._with_object(device, impedance, scheme, horizon)
    return Coupled(found["stable"], found["unstable_poles"], _at(found["gain_up"]))
