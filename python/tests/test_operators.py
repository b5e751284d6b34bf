"""`operators` against defining sums and closed forms."""

import copy
import math
import pickle
import threading

import control
import numpy as np
import pytest
from scipy.signal import fftconvolve

from fractional_haptics.operators import (
    Operator,
    differintegrate,
    frequency_response,
    grunwald_weights,
    state_space,
    to_control,
)

T = 1e-3
SCHEMES = [
    "grunwald:100",
    "grunwald:5000",
    "muir:7",
    "tustin-muir:9",
    "oustaloup:5:0.1:100",
    "full",
    "piecewise-linear:1e-4",
    "full-bdf2",
]


def noise(*shape: int) -> np.ndarray:
    return np.random.default_rng(20261120).standard_normal(shape)


def weights_by_recurrence(order: float, count: int) -> np.ndarray:
    """The first Grünwald weights in long double."""
    j = np.arange(1, count, dtype=np.longdouble)
    return np.concatenate([[1.0], np.cumprod((j - 1 - np.longdouble(order)) / j)])


@pytest.mark.parametrize("order", [-1.3, -0.5, 0.0, 0.2247, 0.5, 1.0, 1.7])
def test_a_record_is_its_defining_sum(order: float) -> None:
    x = noise(500)
    weights = weights_by_recurrence(order, 500)
    np.testing.assert_allclose(grunwald_weights(order, 500), weights.astype(float), rtol=1e-13)
    want = np.array([weights[: n + 1] @ x[n::-1] for n in range(500)], dtype=float) * T**-order
    have = differintegrate(x, order, T)
    assert np.max(np.abs(have - want)) < 1e-12 * T**-order * np.sum(np.abs(weights)) * np.max(np.abs(x))


def test_channels_lie_along_any_axis() -> None:
    x = noise(3, 50, 2)
    y = differintegrate(x, 0.3, T, axis=1)
    assert y.shape == x.shape
    for i in range(3):
        for k in range(2):
            np.testing.assert_allclose(y[i, :, k], differintegrate(x[i, :, k], 0.3, T), rtol=1e-13, atol=1e-10)
    assert np.array_equal(differintegrate(x, 0.3, T, axis=-2), y)
    # By default along the last one, as NumPy and SciPy have it.
    for i, k in np.ndindex(3, 50):
        np.testing.assert_allclose(differintegrate(x, 0.3, T)[i, k], differintegrate(x[i, k], 0.3, T), rtol=1e-13, atol=1e-10)


def test_an_empty_record_has_an_empty_derivative() -> None:
    assert differintegrate(np.empty((0, 3)), 0.5, T).shape == (0, 3)
    assert differintegrate([], 0.5, T).shape == (0,)


def test_caputo_starts_without_a_jump() -> None:
    y = differintegrate(np.full(10, 2.0), 0.5, T, reference=None)
    assert np.array_equal(y, np.zeros(10))
    assert np.allclose(differintegrate(np.full(10, 2.0), 0.5, T, reference=2.0), 0.0)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_stream_is_the_same_by_samples_blocks_and_phases(scheme: str) -> None:
    x = noise(300)
    by_block, by_sample, by_phase = (Operator(0.4, T, scheme) for _ in range(3))
    whole = by_block.process(x)
    assert np.array_equal(whole, [by_sample.step(value) for value in x])
    outputs = []
    for value in x:
        outputs.append(by_phase.output(value))
        by_phase.advance(value)
    assert np.array_equal(whole, outputs)
    by_block.reset()
    assert np.array_equal(whole, np.concatenate([by_block.process(x[:7]), by_block.process(x[7:])]))


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_stream_is_the_convolution_with_its_weights(scheme: str) -> None:
    x = noise(400)
    operator = Operator(0.4, T, scheme)
    want = fftconvolve(x, operator.weights(400))[:400]
    np.testing.assert_allclose(operator.process(x), want, rtol=0, atol=1e-11 * np.max(np.abs(want)))


@pytest.mark.parametrize("scheme", ["muir:7", "tustin-muir:9", "oustaloup:5:0.1:100"])
def test_a_recursion_over_a_record_is_its_stream(scheme: str) -> None:
    x = noise(100, 2)
    y = differintegrate(x, 0.4, T, scheme, axis=0, reference=None)
    for k in range(2):
        operator = Operator(0.4, T, scheme)
        operator.reset(x[0, k])
        assert np.array_equal(y[:, k], operator.process(x[:, k]))


@pytest.mark.parametrize("scheme", SCHEMES)
def test_pickling_mid_stream_goes_on_to_the_bit(scheme: str) -> None:
    x = noise(500)
    operator = Operator(-0.4, T, scheme, 60.0)
    operator.reset(0.25)
    operator.process(x[:123])
    copies = [pickle.loads(pickle.dumps(operator, protocol)) for protocol in (2, 5)] + [copy.deepcopy(operator)]
    want = operator.process(x[123:])
    for restored in copies:
        assert (restored.order, restored.scheme, restored.horizon) == (-0.4, operator.scheme, 60.0)
        assert restored.reference == 0.25
        assert np.array_equal(restored.process(x[123:]), want)


def test_a_damaged_or_foreign_history_is_refused() -> None:
    operator = Operator(0.5, T, "grunwald:10")
    state = operator.__reduce__()[2]
    with pytest.raises(ValueError, match="history"):
        operator.__setstate__((state[0][:5], 0.0))
    with pytest.raises(ValueError, match="another scheme"):
        Operator(0.5, T, "full").__setstate__(state)


def test_response_is_that_of_the_weights() -> None:
    operator = Operator(0.4, T, "grunwald:200")
    omega = np.linspace(0, math.pi / T, 12).reshape(3, 4)
    want = np.exp(-1j * omega[..., None] * T * np.arange(200)) @ operator.weights(200)
    np.testing.assert_allclose(operator.frequency_response(omega), want, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(
        frequency_response(omega, 0.4, T), ((1 - np.exp(-1j * omega * T)) / T) ** 0.4, rtol=1e-11, atol=1e-9
    )
    assert np.array_equal(frequency_response(omega, 0.4, T, "grunwald:200"), operator.frequency_response(omega))


@pytest.mark.parametrize("scheme", [scheme for scheme in SCHEMES if scheme not in ("grunwald:5000", "full-bdf2")])
@pytest.mark.parametrize("order", [-1.4, -0.4, 0.0, 0.4, 1.0, 1.4])
def test_python_control_runs_the_same_operator(scheme: str, order: float) -> None:
    operator = Operator(order, T, scheme)
    system = to_control(operator)
    x = noise(60)
    _time, y = control.forced_response(system, np.arange(60) * T, x)
    want = operator.process(x)
    np.testing.assert_allclose(y, want, rtol=0, atol=1e-11 * np.max(np.abs(want)))
    assert system.dt == T


def test_what_has_no_matrices_says_so() -> None:
    for scheme in ("full-bdf2", "grunwald:5000"):
        with pytest.raises(ValueError, match="use full"):
            state_space(Operator(0.5, T, scheme))


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_sample_of_a_record_that_is_not_finite_is_refused_with_its_index(bad: float) -> None:
    for scheme in ("exact", "grunwald:5", "muir:3"):
        for x, place in (([0.0, 1.0, bad], "sample 2 of channel 0"), (np.array([[0.0, 1.0], [bad, 1.0]]), "sample 0 of channel 1")):
            with pytest.raises(ValueError, match=f"{place} of x is .*: fill the gap"):
                differintegrate(x, 0.5, T, scheme)


def test_any_layout_and_any_real_type_is_taken() -> None:
    x = np.arange(20.0)
    frozen = x.copy()
    frozen.setflags(write=False)
    spread = np.zeros(40)
    spread[::2] = x
    want = differintegrate(x, 0.5, T)
    for same in (frozen, spread[::2], x.astype(np.int32), x.astype(np.uint8), x.tolist(), x[::-1].copy()[::-1]):
        assert np.array_equal(differintegrate(same, 0.5, T), want)
        assert np.array_equal(Operator(0.5, T).process(same), Operator(0.5, T).process(x))
    big_endian = x.astype(">f8")
    assert np.array_equal(Operator(0.5, T).process(big_endian), Operator(0.5, T).process(x))
    fortran = np.asfortranarray(noise(30, 3))
    assert np.array_equal(differintegrate(fortran, 0.5, T), differintegrate(np.ascontiguousarray(fortran), 0.5, T))


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: differintegrate([1.0], 2.5, T), r"order 2\.5 is not in \[-2, 2\]"),
        (lambda: differintegrate(1.0, 0.5, T), "must have an axis"),
        (lambda: differintegrate([1.0], 0.5, T, axis=1), "axis 1 is not one of the 1"),
        (lambda: differintegrate([1j], 0.5, T), "complex128"),
        (lambda: differintegrate(["a"], 0.5, T), "astype"),
        (lambda: differintegrate([[1.0], [1.0, 2.0]], 0.5, T), "."),
        (lambda: Operator(0.5, T).process([[1.0]]), r"block has the shape \(1, 1\)"),
        (lambda: Operator(0.5, T).process([True]), "bool"),
        (lambda: Operator(0.5, T).process(None), "block"),
        (lambda: Operator(0.5, T).frequency_response([0.0, 4e3]), r"omega\[1\] = 4000 rad/s"),
    ],
)
def test_what_is_wrong_is_refused_with_a_reason(call, text: str) -> None:
    with pytest.raises(ValueError, match=text):
        call()


def test_what_is_no_number_at_all_is_a_type_error() -> None:
    with pytest.raises(TypeError):
        Operator("half", T)
    with pytest.raises(TypeError):
        Operator(0.5, T).step("x")
    with pytest.raises(TypeError):
        Operator(0.5, T).weights(1.5)


def test_an_operator_in_two_threads_at_once_is_refused_not_torn() -> None:
    operator = Operator(0.5, T)
    block = noise(2_000_000)
    started = threading.Event()

    def run() -> None:
        started.set()
        operator.process(block)

    thread = threading.Thread(target=run)
    thread.start()
    started.wait()
    refused = 0
    while thread.is_alive():
        try:
            operator.output(1.0)
        except RuntimeError:
            refused += 1
    thread.join()
    assert refused > 0
