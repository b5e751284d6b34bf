"""`control` against closed forms and python-control."""

import math
import pickle

import control as ct
import numpy as np
import pytest
from scipy.special import erfc, gamma

from fractional_haptics.analysis import Device, Loop
from fractional_haptics.control import (
    Pid,
    TransferFunction,
    analyze,
    design,
    identify,
    plant,
    simulate,
)
from fractional_haptics.operators import Operator, to_control


def test_a_function_is_read_printed_kept_and_evaluated() -> None:
    text = TransferFunction("1/(0.8s^2.2+0.5s^0.9+1)")
    terms = TransferFunction([(1.0, 0.0)], [(0.8, 2.2), (0.5, 0.9), (1.0, 0.0)])
    assert text == terms == TransferFunction(str(text)) == pickle.loads(pickle.dumps(text))
    assert hash(text) == hash(terms)
    assert text.denominator == [(0.8, 2.2), (0.5, 0.9), (1.0, 0.0)]
    omega = np.geomspace(0.01, 100, 6).reshape(2, 3)
    s = 1j * omega
    np.testing.assert_allclose(text.response(omega), 1 / (0.8 * s**2.2 + 0.5 * s**0.9 + 1), rtol=1e-12)


def test_a_step_is_its_closed_form() -> None:
    # 1/(s^0.5 + 1): 1 − e^t·erfc(√t).
    t = np.arange(400) * 0.005
    y = TransferFunction("1/(s^0.5+1)").step_response(0.005, 400)
    np.testing.assert_allclose(y[40:], 1 - np.exp(t[40:]) * erfc(np.sqrt(t[40:])), atol=2e-4)
    # The response to t² of 1/s^0.5 is Γ(3)/Γ(3.5)·t^2.5.
    y = TransferFunction("1/s^0.5").respond(t**2, 0.005)
    np.testing.assert_allclose(y, 2 / gamma(3.5) * t**2.5, atol=1e-4)


def test_poles_of_a_commensurate_function() -> None:
    oscillator = TransferFunction("1/(s^1.5-2s^0.5+5)")
    for pole in oscillator.poles():
        assert abs(1 / oscillator.response(1.0)) > 0
        assert abs(pole**1.5 - 2 * pole**0.5 + 5) < 1e-9
    assert TransferFunction("1/(s^0.5-1)").unstable_poles() == 1
    assert TransferFunction("1/(s^0.5+1)").unstable_poles() == 0


def test_whole_orders_go_to_python_control_and_back() -> None:
    system = ct.tf([2.0, 1.0], [1.0, 0.0, 3.0])
    ours = TransferFunction.from_control(system)
    assert ours.numerator == [(2.0, 1.0), (1.0, 0.0)]
    back = ours.to_control()
    assert isinstance(back, ct.TransferFunction)
    assert np.isclose(back(2j), system(2j))
    fractional = TransferFunction("1/(s^0.5+1)").to_control([1.0, 2.0, 4.0])
    assert isinstance(fractional, ct.FrequencyResponseData)
    assert np.isclose(fractional(2j), 1 / (np.sqrt(2j) + 1))


@pytest.mark.parametrize(
    ("system", "has_steps"),
    [
        (lambda: to_control(Operator(0.5, 1e-3)), True),
        (lambda: to_control(Operator(-0.5, 1e-3, "grunwald:20")), True),
        (lambda: to_control(Operator(0.5, 1e-3, "oustaloup:5:0.1:100")), True),
        (lambda: TransferFunction("(2s+1)/(s^2+s+1)").to_control(), True),
        (lambda: TransferFunction("1/(s^0.5+1)").to_control(), False),
        (lambda: Loop(Device(0.065, 3.5), 1000.0, 3.0, 0.5, 1e-3).to_control(), False),
        (lambda: Loop(Device(0.065, 3.5), 1000.0, 3.0, 0.5, 1e-3).to_control([1.0, 10.0, 100.0]), False),
    ],
)
# Of a pole next to 1, and of data that do not reach down to 0: remarks of the figure, which is right.
@pytest.mark.filterwarnings("ignore:indented contour:UserWarning", "ignore:number of encirclements:UserWarning")
def test_what_goes_to_python_control_is_drawn_and_steps(system, has_steps: bool) -> None:
    own = system()
    bode = ct.bode_plot(own)
    magnitude = bode.lines[0, 0][0]
    omega = magnitude.get_xdata()[1]
    want = own(np.exp(1j * omega * own.dt)) if own.isdtime(strict=True) else own(1j * omega)
    assert np.isclose(magnitude.get_ydata()[1], abs(want), rtol=1e-6)
    assert ct.nyquist_plot(own).lines.size > 0
    if has_steps:
        response = ct.step_response(own)
        assert np.isfinite(response.outputs).all()
        assert len(response.time) > 10


def test_every_way_to_a_plant_gives_the_same_one() -> None:
    omega = np.geomspace(0.01, 1, 200)
    want = 0.55 * np.exp(-1j * omega) / (62j * omega + 1)
    states = ct.ss([[-1 / 62]], [[1.0]], [[0.55 / 62]], [[0.0]])
    for model in (
        plant("0.55exp(-s)/(62s+1)"),
        plant(TransferFunction("0.55/(62s+1)"), 1.0),
        plant(ct.tf([0.55], [62, 1]), 1.0),
        plant(states, 1.0),
        plant(ct.FrequencyResponseData(want, omega)),
    ):
        np.testing.assert_allclose(model.response(omega[1:-1]), want[1:-1], rtol=1e-9)
    assert plant(states, 1.0).delay_s == 1.0
    assert np.isnan(plant(ct.FrequencyResponseData(want, omega)).response(100.0))


def test_an_integer_pid_is_a_pid() -> None:
    dt = 0.01
    pid = Pid(dt, proportional=2.0, integral=3.0, derivative=0.5, derivative_weight=1.0, rule="grunwald")
    error = np.sin(np.arange(50) * 0.3)
    have = [pid.step(e, 0.0) for e in error]
    want = 2 * error + 3 * dt * np.cumsum(error) + 0.5 * np.diff(error, prepend=0) / dt
    np.testing.assert_allclose(have, want, rtol=1e-9, atol=1e-9)
    pid.reset()
    assert pid.step(error[0], 0.0) == have[0]


def test_a_tuned_loop_has_its_margin_and_keeps_its_overshoot() -> None:
    oven = plant("0.55exp(-s)/(62s+1)")
    tuned = design(oven, 0.05, math.radians(70), sample_time_s=0.1)
    assert tuned.unmet == ()
    # All on the error, as the open loop has it.
    pid = tuned.pid(horizon=1000.0, derivative_weight=1.0)
    margins = analyze(oven, pid)["margins"]
    # But for (ωT)² of the sampled powers of s.
    assert margins["crossover_rad_s"] == pytest.approx(0.05, rel=1e-5)
    assert margins["phase_margin_deg"] == pytest.approx(70, rel=1e-5)
    overshoots = []
    for gain in (0.7, 1.0, 1.4):
        other = plant(f"{0.55 * gain}exp(-s)/(62s+1)")
        assert analyze(other, pid)["stable"]
        run = simulate(other, pid, reference=np.ones(4000))
        overshoots.append(run.measured.max())
    assert max(overshoots) - min(overshoots) < 0.02
    assert analyze(oven, pid)["reason"].startswith("Stable, proved.")
    assert not analyze("5500exp(-s)/(62s+1)", pid)["stable"]
    assert tuned.pid(integer=True).parameters["integral_order"] == 1.0


def test_a_design_is_that_of_the_command_and_says_what_it_misses() -> None:
    oven = plant("0.55exp(-s)/(62s+1)")
    wishes = {"noise": (10.0, 0.1), "disturbance": "0.01rad/s:0dB", "output_limits": (0.0, 10.0), "step": 2.0}
    found = design(oven, 0.1, math.radians(65), **wishes)
    assert found.report["stable"] is True
    assert 0.0 <= min(row["command"] for row in found.report["step"]) <= max(row["command"] for row in found.report["step"]) <= 10.0
    assert "output_high = 10" in found.file
    assert "margins" in found.report and found.report["notes"]
    assert design(oven, 0.1, math.radians(65), sensitivity_peak=1.01).unmet == ("sensitivity_peak",)
    # A notation that can be read in two ways, and a device in place of a plant.
    typed = design("1/2(s+2)/(s^2+s+1)", 1.0)
    assert typed.report["notes"][0].startswith('plant "1/2(s+2)')
    device = design(crossover_rad_s=50.0, mass_kg=0.065, damping_n_s_per_m=3.5, delay_s=1e-3)
    assert device.report["stable"] is True and "0.065" in device.report["plant"]


def test_a_wish_is_taken_with_its_unit_and_without_that_of_its_key() -> None:
    found = design("0.55exp(-s)/(62s+1)", crossover="0.1 rad/s", phase_margin="65deg")
    same = design("0.55exp(-s)/(62s+1)", 0.1, math.radians(65))
    assert found == same
    for given, error, text in [
        ({"crossover_rad_s": 0.1, "phase_margin": 65}, ValueError, "write 65deg"),
        ({"bandwidth": 0.1}, TypeError, "did you mean `crossover_rad_s`"),
        ({"crossover": 0.1, "crossover_rad_s": 0.1}, TypeError, "given twice"),
    ]:
        with pytest.raises(error, match=text):
            design("0.55exp(-s)/(62s+1)", **given)
    with pytest.raises(FileNotFoundError):
        design("none.toml", 0.1)


def test_a_loop_is_that_of_the_command_however_its_parts_are_given(tmp_path) -> None:
    (tmp_path / "ramp.csv").write_text("time_s,reference\n0,0\n1,0.5\n2,1\n4,1\n")
    (tmp_path / "pi.toml").write_text("[pid]\nproportional_gain = 2\nintegral_gain_per_s_lambda = 1\n[loop]\nsample_time_s = 0.01\n")
    (tmp_path / "lag.toml").write_text('[transfer_function]\nfunction = "1/(s+1)"\n')
    pid = Pid(0.01, proportional=2.0, integral=1.0, high=0.8)
    # 1/(s + 1) with 2 + 1/s: the ramp of the table, sample by sample.
    ramp = np.minimum(np.floor(np.arange(401) / 100 + 1e-9), 2) / 2
    runs = [
        simulate(plant("1/(s+1)"), pid, reference=ramp),
        simulate(tmp_path / "lag.toml", tmp_path / "pi.toml", output_limits=(-1e12, 0.8), reference=tmp_path / "ramp.csv"),
    ]
    for run in runs:
        assert run.report["shape"] is None
        assert run.command.max() == 0.8
        np.testing.assert_array_equal(run.reference, ramp)
        np.testing.assert_allclose(run.measured, runs[0].measured, atol=1e-6)
        assert run.t[-1] == pytest.approx(4.0)
    # No integral: it rests beside the reference, which is said.
    beside = simulate("1/(s+1)", "1", sample_time_s=0.01, duration_s=20.0, step=2.0)
    assert beside.measured[-1] == pytest.approx(1.0, abs=1e-3)
    assert beside.report["at_reference"] is False
    assert "rests beside it" in beside.report["warnings"][-1]
    # A mass of 0.5 kg with a damper of 1 N·s/m and a hand of 8 N/m: poles at −1 ± j√15.
    alone = analyze(mass_kg=0.5, damping_n_s_per_m=1.0, hand_stiffness_n_per_m=8.0)
    assert sorted(pole["im"] for pole in alone["poles"]) == pytest.approx([-math.sqrt(15), math.sqrt(15)])
    read = "1/2s/(s^2+s+1)"
    assert analyze(read, pid)["warnings"][0].startswith(f'plant "{read}"')
    with pytest.raises(FileNotFoundError):
        analyze(tmp_path / "none.toml", pid)


def test_a_plant_comes_back_from_arrays_and_from_a_table_and_is_tried_on_another(tmp_path) -> None:
    t = np.arange(120) * 0.05
    u = np.ones(120)
    # 2·exp(-0.35 s)/(s + 1) after a step.
    y = -2.0 * np.expm1(-np.maximum(t - 0.35, 0.0))
    gap = np.where(np.arange(120) == 50, math.nan, y)
    seen: list[int] = []
    found = identify((t, u, gap), poles=1, validate=(t, 2 * u, 2 * y), progress=seen.append)
    assert found.report["delay_s"] == pytest.approx(0.35, abs=1e-3) == found.plant.delay_s
    assert found.report["validation"]["fit"] > 0.999
    assert any("1 row (line 52) without an output" in said for said in found.report["warnings"])
    assert seen
    np.testing.assert_allclose(found.model, y, atol=1e-3)
    np.testing.assert_allclose(found.function.response(1.0), 2 / (1j + 1), rtol=1e-3)
    table = tmp_path / "tank.csv"
    table.write_text("\n".join(["time_s;valve;output", *(f"{a};{b};{c}" for a, b, c in zip(t, u, y, strict=True))]))
    again = identify(table, columns="input=valve", poles=1)
    assert again.report["function"] == identify((t, u, y), poles=1).report["function"]
    (tmp_path / "plant.toml").write_text(again.file)
    assert "[transfer_function]" in again.file
    assert "delay_s" in again.summary()


def test_a_cell_comes_back_from_its_impedance(tmp_path) -> None:
    hz = np.logspace(-3, 3, 40)
    z = 0.02 + 0.05 / (2j * math.pi * hz) ** 0.7
    table = tmp_path / "cell.txt"
    table.write_text("\n".join(["Freq (Hz)\tZ' (ohm)\t-Z'' (ohm)", *(f"{f}\t{x.real}\t{-x.imag}" for f, x in zip(hz, z, strict=True))]))
    found = identify(table)
    assert found.report["kramers_kronig"]
    assert [row["value"] for row in found.report["numbers"]] == pytest.approx([0.02, 0.05, 0.7])
    np.testing.assert_allclose(found.model, z, rtol=1e-6)
    np.testing.assert_allclose(found.t, 2 * math.pi * hz)


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"columns": "input=valve"}, "columns belong to tables"),
        ({"validate": ([0.0, 1.0], [1.0])}, "give \\(t, u, y\\)"),
    ],
)
def test_a_record_of_a_plant_is_refused_as_the_command_refuses_it(given, text: str) -> None:
    t = np.arange(20) * 0.1
    with pytest.raises(ValueError, match=text):
        identify((t, np.ones(20), 1 - np.exp(-t)), **given)


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: TransferFunction("1/s", [(1.0, 1.0)]), "leave denominator out"),
        (lambda: TransferFunction([(1.0, 0.0)]), "denominator is missing"),
        (lambda: TransferFunction("1/(s^0.5+1)").step_response(0.1, 10, "tustin"), "rule"),
        (lambda: TransferFunction.from_control(ct.tf([1], [1, 1], 0.1)), "discrete"),
        (lambda: plant(3), "a int is no plant"),
        (lambda: plant("1/(s+1)", 1.0), "dead time"),
        (lambda: simulate("1/(s+1)", Pid(0.01, proportional=1.0), reference=[[1.0]]), "reference has the shape"),
        (lambda: analyze("1/(s+1)", mass_kg=1.0), "`mass_kg` belongs to a device"),
        (lambda: analyze(3), "a int is no plant here: give a Plant, a text or a path"),
    ],
)
def test_what_is_wrong_is_refused_with_a_reason(call, text: str) -> None:
    with pytest.raises(ValueError, match=text):
        call()


def test_a_controller_starts_beside_a_plant_that_runs() -> None:
    gains = {"proportional": 2.0, "integral": 1.0, "derivative": 0.5, "low": -10.0, "high": 10.0}
    pid = Pid(0.01, **gains)
    assert pid.settle(20.0) == 0.0
    assert {pid.step(20.0, 20.0) for _ in range(1000)} == {0.0}
    # From rest the derivative sees the measurement jump by 20.
    pid.reset()
    assert [pid.step(20.0, 20.0) for _ in range(2)] != [0.0, 0.0]
    # A command that stood goes on.
    assert abs(pid.settle(18.0, reference=20.0, command=4.5)) < 1e-12
    assert abs(pid.output(20.0, 18.0) - 4.5) < 1e-12
    # Of an order below 1 too, and what is not known counts as the command: nothing moves.
    pid = Pid(0.01, **gains | {"integral_order": 0.7})
    for unknown in (math.nan, math.inf):
        pid.settle(20.0, command=unknown)
        assert pid.settle(20.0, command=4.5) == 0.0
        for _ in range(1000):
            assert abs(pid.output(20.0, 20.0) - 4.5) < 1e-6
            pid.advance(20.0, 20.0, unknown)
    # Without an integral it fades in a second.
    pid = Pid(0.01, proportional=2.0)
    assert pid.settle(18.0, reference=20.0, command=1.0) == 0.0
    assert abs([pid.step(20.0, 18.0) for _ in range(2000)][-1] - 4.0) < 1e-6
    with pytest.raises(ValueError, match="measured NaN is not finite"):
        pid.settle(math.nan)


def test_a_reading_that_is_no_number_holds_the_command() -> None:
    pid = Pid(0.01, proportional=2.0, integral=1.0)
    command = pid.step(1.0, 0.25)
    assert pid.missed == 0
    assert [pid.step(1.0, math.nan) for _ in range(9)] == [command] * 9
    assert pid.missed == 9
    assert pid.step(1.0, math.inf) == 0.0
    assert math.isfinite(pid.step(1.0, 0.25))
    assert pid.missed == 0
