"""`analysis` against closed forms, simulation in the small, and python-control."""

import math

import control
import numpy as np
import pytest

from fractional_haptics.analysis import (
    Coupler,
    Device,
    LinearPlant,
    Loop,
    Port,
    coupled,
    plant_from_control,
    region,
    transparency,
)

T = 1e-3
DEVICE = Device(0.065, 3.5)


def matrices(mass: float = 0.065, damping: float = 3.5) -> tuple[list, list, list]:
    return [[0.0, 1.0], [0.0, -damping / mass]], [0.0, 1 / mass], [1.0, 0.0]


def test_poles_are_those_of_the_closed_loop() -> None:
    a, b, c = matrices()
    plant = control.sample_system(control.ss(a, np.transpose([b]), [c], 0), T)
    stiffness, damping = 1000.0, 5.0
    # The force for a position acts from the next sample on; a backward difference for the damper.
    wall = control.tf([stiffness + damping / T, -damping / T], [1, 0], T)
    want = control.feedback(plant, control.ss(wall)).poles()
    have = Loop(DEVICE, stiffness, damping, 1.0, T, "grunwald:2").poles()
    assert have is not None
    for pole in have:
        assert np.min(np.abs(np.concatenate([want, [0]]) - pole)) < 1e-6
    assert Loop(DEVICE, stiffness, damping, 0.5, T).poles() is None


def test_margins_agree_with_python_control() -> None:
    loop = Loop(DEVICE, 2000.0, 5.0, 1.0, T)
    margins = loop.margins()
    data = loop.to_control(np.geomspace(1.0, np.pi / T, 20_000))
    gain, _phase, _stability, omega_gain, *_ = control.stability_margins(data)
    assert margins.gain_up is not None
    assert math.isclose(gain, margins.gain_up.value, rel_tol=1e-3)
    assert math.isclose(omega_gain, margins.gain_up.omega_rad_s, rel_tol=1e-3)
    peak = loop.sensitivity(np.geomspace(1.0, np.pi / T, 20_000)).max()
    assert math.isclose(peak, margins.sensitivity.value, rel_tol=1e-4)
    assert loop.sensitivity_peak() == margins.sensitivity
    assert margins.delay_s is not None
    late = Device(0.065, 3.5, delay_s=1.001 * margins.delay_s.value)
    assert not Loop(late, 2000.0, 5.0, 1.0, T).verdict().stable


def test_the_slope_proved_for_every_motion_holds_the_inequality_of_its_multiplier() -> None:
    loop = Loop(DEVICE, 2000.0, 5.0, 1.0, T)
    limit = loop.slope_limit()
    margin = loop.margins().gain_up
    assert margin is not None
    assert math.isclose(limit.linear, margin.value, rel_tol=1e-6)
    assert 0.99 * limit.provable <= limit.proved <= limit.provable <= limit.linear
    omega = np.geomspace(1.0, np.pi / T, 20_000)
    multiplier = 1 - sum(h * np.exp(-1j * i * omega * T) for i, h in limit.multiplier)
    assert np.min((multiplier * (1 / limit.proved + loop.loop_gain(omega))).real) > 0


@pytest.mark.parametrize("scheme", ["exact", "full", "grunwald:50", "muir:3", "tustin-muir:5"])
def test_a_region_is_where_verdicts_are_stable(scheme: str) -> None:
    found = region(DEVICE, 0.5, T, scheme, 1000)
    assert not found.is_empty
    points = found.polygons[0]
    stiffness = np.array([0.3, 0.9, 1.1]) * found.stiffness_max_n_per_m
    dissipation = found.dissipation_at_stiffness_max_n_s_mu_per_m
    inside = found.contains(stiffness, dissipation)
    assert inside.tolist() == [True, True, False]
    for k, want in zip(stiffness, inside, strict=True):
        assert Loop(DEVICE, k, dissipation, 0.5, T, scheme).verdict().stable == want
    assert math.isclose(points[:, 0].max(), found.stiffness_max_n_per_m, rel_tol=1e-5)
    assert math.isclose(points[:, 1].max(), found.dissipation_max_n_s_mu_per_m, rel_tol=1e-5)
    # Shoelace: the outer boundary runs anticlockwise.
    x, y = points.T
    area = 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))
    assert math.isclose(area, found.areas[0], rel_tol=1e-4)
    assert len(found.omega_rad_s[0]) == len(points)


def test_matrices_and_python_controls_plant_are_the_device() -> None:
    a, b, c = matrices()
    system = control.ss(a, np.transpose([b]), [c], 0)
    wall = (2000.0, 5.0, 0.5, T)
    want = Loop(DEVICE, *wall).margins()
    for plant in (LinearPlant(a, b, c), LinearPlant(a, b, c, mass_kg=0.065), system, plant_from_control(system)):
        have = Loop(plant, *wall).margins()
        assert math.isclose(have.gain_up.value, want.gain_up.value, rel_tol=1e-8)
        assert math.isclose(region(plant, 0.5, T).stiffness_max_n_per_m, region(DEVICE, 0.5, T).stiffness_max_n_per_m, rel_tol=1e-7)
    felt, known = (transparency(plant, *wall, [1.0, 100.0]) for plant in (system, DEVICE))
    np.testing.assert_allclose(felt.stiffness_n_per_m, known.stiffness_n_per_m, rtol=1e-9)
    np.testing.assert_allclose(felt.damping_n_s_per_m, known.damping_n_s_per_m, rtol=1e-9)


def test_loop_gain_is_plant_times_wall() -> None:
    a, b, c = matrices()
    plant = control.sample_system(control.ss(a, np.transpose([b]), [c], 0), T)
    omega = np.geomspace(1, 3000, 9)
    z = np.exp(1j * omega * T)
    wall = 1000.0 + 3.0 * ((1 - 1 / z) / T) ** 0.5
    have = Loop(DEVICE, 1000.0, 3.0, 0.5, T).loop_gain(omega)
    # One sample from the measurement to the force is in the hold alone here.
    np.testing.assert_allclose(np.abs(have), np.abs(plant(z) * wall), rtol=1e-8)
    np.testing.assert_allclose(Loop(DEVICE, 1000.0, 3.0, 0.5, T).sensitivity(omega), np.abs(1 / (1 + have)), rtol=1e-9)


def test_passivity_is_colgates() -> None:
    port = Port(1.0, T)
    assert math.isclose(port.required_damping(4000.0, 0.5), 4000.0 * T / 2 + 0.5, rel_tol=1e-10)
    assert math.isclose(port.largest_stiffness(3.5, 0.5), 6000.0, rel_tol=1e-10)
    assert math.isclose(port.largest_dissipation(3.5, 4000.0), 1.5, rel_tol=1e-10)
    assert Port(0.5, T, delay_s=0.4e-3).required_damping(1000.0, 0.0) > Port(0.5, T).required_damping(1000.0, 0.0)


def test_couplers_are_judged() -> None:
    spring = Coupler(1.0, T, 0.0, 1000.0)
    assert math.isclose(spring.least_damping(), 1000.0 * T / 8, rel_tol=1e-10)
    assert math.isclose(spring.sampled_damping(), 1000.0 * T / 2, rel_tol=1e-9)
    assert Coupler(1.5, T, 1.0, 100.0).least_damping() == math.inf
    steady = coupled(DEVICE, spring, object_mass_kg=0.2, object_damping_n_s_per_m=1.0)
    assert steady.stable
    assert steady.gain_up.value > 1
    assert not coupled(Device(0.065, 0.0), Coupler(1.0, T, 0.0, 5e5), object_mass_kg=0.2).stable


def test_a_hand_feels_what_the_formula_says() -> None:
    omega = np.array([10.0, 100.0])
    felt = transparency(DEVICE, 500.0, 0.0, 0.5, T, omega)
    np.testing.assert_allclose(felt.stiffness_n_per_m, -0.065 * omega**2 + 500 * np.cos(omega * T / 2), rtol=1e-12)
    np.testing.assert_allclose(felt.damping_n_s_per_m, 3.5 - 500 / omega * np.sin(omega * T / 2), rtol=1e-12)


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: Loop("device", 1.0, 1.0, 0.5, T), "a str is no plant"),
        (lambda: Loop(DEVICE, 1.0, 1.0, 0.5, T).loop_gain([1.0, 0.0]), r"omega\[1\] = 0"),
        (lambda: LinearPlant([[1.0, 2.0]], [1.0], [1.0]), r"a of shape \(1, 2\)"),
        (lambda: LinearPlant([1.0], [1.0], [1.0]), "a has the shape"),
        (lambda: plant_from_control(control.ss([[1]], [[1]], [[1]], [[1]])), "direct path"),
        (lambda: plant_from_control(control.ss([[0.5]], [[1]], [[1]], [[0]], T)), "discrete"),
        (lambda: plant_from_control(control.ss([[1]], [[1, 1]], [[1]], [[0, 0]])), "2 inputs"),
    ],
)
def test_what_is_wrong_is_refused_with_a_reason(call, text: str) -> None:
    with pytest.raises(ValueError, match=text):
        call()
