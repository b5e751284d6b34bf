"""Ready-made sweeps, small: against verdicts, closed forms, and their own parts."""

import functools

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

pytest.importorskip("xarray")

from fractional_haptics.analysis import Device, Loop
from fractional_haptics.experiment import zwidth
from fractional_haptics.sweep.maps import UncertainDevice, cohort_bootstrap, robust_stability_map, zwidth_map
from fractional_haptics.sweep.work import random_numbers
from fractional_haptics.tissue import Model

T = 1e-3
DEVICES = UncertainDevice(mass_kg=(0.05, 0.08), damping_n_s_per_m=(1.0, 5.0), delay_s=(0.0, 1e-3))


def test_the_share_is_that_of_certified_verdicts():
    orders, stiffness, number = [0.5, 1.0], np.geomspace(100.0, 2e4, 9), 12
    dissipation = [10.0, 2.0]
    found = robust_stability_map(
        orders, stiffness, DEVICES, dissipation=dissipation, sample_time=T, number=number, seed=3
    )
    verdicts = np.array(
        [
            [
                [Loop(DEVICES(random_numbers(3, draw)), k, b, order, T).verdict().stable for k in stiffness]
                for draw in range(number)
            ]
            for order, b in zip(orders, dissipation, strict=True)
        ]
    )
    assert 0 < verdicts.mean() < 1
    assert_array_equal(found["stable"], verdicts)
    assert_allclose(found["share"], verdicts.mean(axis=1), rtol=1e-15)
    assert found["stiffness"].attrs["units"] == "N/m"
    assert found["dissipation"].dims == ("order",)


def test_the_share_of_springs_is_that_of_the_closed_form():
    """A spring without delay on a device without damping is never stable; without uncertainty all shares are 0 or 1."""
    certain = UncertainDevice(mass_kg=(0.065, 0.065), damping_n_s_per_m=(3.5, 3.5))
    stiffness = np.array([100.0, 5000.0, 6900.0, 7100.0])
    found = robust_stability_map([1.0], stiffness, certain, dissipation=[0.0], sample_time=T, number=3)
    verdicts = [Loop(Device(0.065, 3.5), k, 0.0, 1.0, T).verdict().stable for k in stiffness]
    assert_array_equal(found["share"].values[0], np.array(verdicts, dtype=float))


def test_the_interval_of_a_share_is_wilsons():
    """n = 10, 5 stable: 0.2366 to 0.7634 (Wilson 1927, by hand: (0.5 + z²/20 ± z √(0.025 + z²/400))/(1 + z²/10))."""
    half = iter([True, False] * 5)
    rare = UncertainDevice(mass_kg=(0.065, 0.065), damping_n_s_per_m=(3.5, 3.5))

    def every_other(rng):
        rare(rng)
        return Device(0.065, 3.5 if next(half) else 0.0)

    found = robust_stability_map(
        [1.0], [500.0], every_other, dissipation=[0.0], sample_time=T, number=10, workers=1, block_points=10
    )
    assert found["share"] == 0.5
    assert_allclose(found["share_low"], 0.236593, atol=1e-6)
    assert_allclose(found["share_high"], 0.763407, atol=1e-6)


def test_devices_that_cannot_be_are_failed_points_and_are_left_out_of_the_share():
    def some(rng):
        return Device(0.065 if rng.uniform() < 0.5 else -1.0, 3.5)

    found = robust_stability_map([1.0], [500.0], some, dissipation=[1.0], sample_time=T, number=40)
    failed = found["error"] != ""
    assert 5 < int(failed.sum()) < 35
    assert (found["stable"].isnull().all("stiffness") == failed).all()
    assert found["share"] == 1.0


def test_limits_of_devices_are_checked():
    with pytest.raises(
        ValueError, match=r"mass_kg goes from a least value of at least 0 to a largest, not \(2.0, 1.0\)"
    ):
        UncertainDevice(mass_kg=(2.0, 1.0), damping_n_s_per_m=(1.0, 2.0))
    rng = np.random.default_rng(1)
    drawn = [DEVICES(rng) for _ in range(200)]
    for name in ("mass_kg", "damping_n_s_per_m", "delay_s"):
        low, high = getattr(DEVICES, name)
        values = np.array([getattr(one, name) for one in drawn])
        assert ((low <= values) & (values <= high)).all()
        assert_allclose(values.mean(), (low + high) / 2, atol=(high - low) / 8)  # four standard errors


def test_zwidth_over_devices_is_that_of_each():
    devices = {
        "light": {"mass_kg": 0.065, "damping_n_s_per_m": 3.5},
        "heavy": {"mass_kg": 0.2, "damping_n_s_per_m": 3.5},
    }
    found = zwidth_map([0.5, 1.0], devices, [0.0, 2e-3], points=3, common={"sample_time_s": 2e-3})
    assert (found["error"] == "").all()
    tried = zwidth(orders=[1.0], points=3, delay_s=2e-3, sample_time_s=2e-3, **devices["heavy"])
    largest = max(one["stiffness_max"] for one in tried["orders"][0]["boundary"])
    assert found["stiffness"].sel(order=1.0, device="heavy", delay=2e-3) == largest
    assert (found["stiffness"].sel(delay=0.0) > found["stiffness"].sel(delay=2e-3)).all()
    with pytest.raises(ValueError, match="delay_s is an axis of this map"):
        zwidth_map([0.5], {"a": {"delay_s": 0.0}}, [0.0])


def cohort(noise):
    """Six specimens of spring-pots around 4 kPa·s^0.2 whose orders spread by 0.02."""
    rng = np.random.default_rng(7)
    t = np.geomspace(0.01, 100.0, 40)
    for order in 0.2 + 0.02 * np.array([-1.2, -0.7, -0.2, 0.3, 0.6, 1.2]):
        model = Model("spring-pot", viscosity_pa_s_alpha=4000.0 * np.exp(0.1 * rng.standard_normal()), order=order)
        yield t, model.relaxation_modulus(t) * np.exp(noise * rng.standard_normal(t.size))


def test_the_bootstrap_of_a_cohort_spreads_as_its_mean_does():
    specimens = list(cohort(noise=0.01))
    found = cohort_bootstrap(specimens, "spring-pot", number=400, starts=1)
    assert (found["error"] == "").all()
    assert found["order"].attrs["units"] == "1"
    assert found["viscosity_pa_s_alpha"].attrs["units"] == "Pa·s^α"
    orders = 0.2 + 0.02 * np.array([-1.2, -0.7, -0.2, 0.3, 0.6, 1.2])
    # The mean of six drawn with repetition has the spread of the cohort over the root of six. Noise adds 1e-3 of it;
    # the spread of a spread of 400 is 3.5 %, four of which are allowed.
    assert_allclose(found["order"].std(), orders.std() / np.sqrt(6), rtol=0.14)
    assert_allclose(found["order_cohort"], orders.mean(), atol=1e-3)
    assert_allclose(found["order"].mean(), found["order_cohort"], atol=4 * orders.std() / np.sqrt(6 * 400) + 1e-3)


def test_the_bootstrap_is_the_same_for_any_blocks():
    draw = functools.partial(cohort_bootstrap, list(cohort(noise=0.02)), "spring-pot", number=12, starts=1, seed=5)
    assert_array_equal(draw(workers=1, block_points=12)["order"], draw(workers=3, block_points=5)["order"])


def test_cohorts_that_cannot_be():
    specimens = list(cohort(noise=0.01))
    with pytest.raises(ValueError, match="a cohort has at least two specimens, not 1"):
        cohort_bootstrap(specimens[:1], "spring-pot")
    with pytest.raises(ValueError, match="no model is called 'jelly'; known are"):
        cohort_bootstrap(specimens, "jelly")
    with pytest.raises(ValueError, match='kind is "relaxation" or "creep"'):
        cohort_bootstrap(specimens, "spring-pot", kind="record")
    with pytest.raises(ValueError, match="specimen 1: "):
        cohort_bootstrap([specimens[0], ([1.0, 2.0, 3.0], [1.0, -1.0, np.nan])], "spring-pot")
