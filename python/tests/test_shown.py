"""Every value shows itself on one screen, in text and in a notebook; and what people type first is read or answered."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Callable
from html.parser import HTMLParser
from typing import Any

import control as ct
import numpy as np
import pytest
import xarray as xr
from test_values import HOLD_ARRAYS, IMMUTABLE

from fractional_haptics import analysis, control, experiment, operators, plot, tissue

T = 1e-3
FISH = tissue.find("fish-muscle").model
TIMES = np.geomspace(0.02, 900.0, 200)
ANSWERS: dict[str, Callable[[], Any]] = {
    "zwidth": lambda: experiment.zwidth(orders=[0.5], points=3),
    "relax": lambda: experiment.relax(duration_s=2.0),
    "identify": lambda: tissue.identify(TIMES, FISH.relaxation_modulus(TIMES)),
    "slope": lambda: analysis.Loop(analysis.Device(0.065, 3.5), 1000.0, 3.0, 0.5, T).slope_limit(),
    "model": lambda: tissue.MODELS["zener"],
    "operator": lambda: operators.Operator(0.5, T),
    "pid": lambda: control.Pid(T, proportional=2.0, integral=1.0),
}
NO_VALUES = {"Grid", "Output"}
SHOWN = {**{name: make for name, make in {**IMMUTABLE, **HOLD_ARRAYS}.items() if name not in NO_VALUES}, **ANSWERS}


class _Tags(HTMLParser):
    """Refuses HTML whose elements are not closed in order."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.seen: list[str] = []

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.open.append(tag)
        self.seen.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


@pytest.mark.parametrize("name", SHOWN)
def test_every_value_fits_on_a_screen(name: str) -> None:
    value = SHOWN[name]()
    text = value.summary()
    lines = text.split("\n")
    assert 1 <= len(lines) <= 41
    assert max(map(len, lines)) <= 140
    assert " object at 0x" not in text + str(value) + repr(value)
    assert len(str(value).split("\n")) <= 41
    if not isinstance(value, dict):
        assert len(repr(value)) < 1000
    tags = _Tags()
    tags.feed(value._repr_html_())
    tags.close()
    assert not tags.open
    assert set(tags.seen) <= {"table", "tr", "th", "td", "small"}


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: analysis.Device(0.065, 3.5), ["mass", "65 g", "3.5 N·s/m"]),
        (lambda: analysis.Loop(analysis.Device(0.065, 3.5), 1000.0, 3.0, 0.5, T), ["1 kN/m", "sample time", "1 ms"]),
        (lambda: analysis.Loop(analysis.Device(0.065, 3.5), 1000.0, 3.0, 0.5, T).margins(), ["gain up", "rad/s)"]),
        (ANSWERS["identify"], ["least 20 ms, largest 900 s", "kPa  (200 values)", "fractional-maxwell", "Pa·s^α", "low 95", "candidates", "spring-pot"]),
        (ANSWERS["relax"], ["prostate-cancerous", "peak force", "mN"]),
        (ANSWERS["pid"], ["proportional", "2", "1 ms"]),
        (lambda: control.plant("0.55exp(-s)/(62s+1)"), ["0.55exp(-s)/(62s+1)", "delay", "1 s"]),
        (lambda: tissue.find("liver"), ["1.85 kPa", "elastography", "spring"]),
        (HOLD_ARRAYS["Felt"], ["least 1 rad/s", "largest 10 rad/s", "2 values"]),
        (lambda: experiment.zwidth(orders=[0.5], points=3), ["boundary", "stiffness"]),
    ],
)
def test_a_summary_says_numbers_with_their_units(make: Callable[[], Any], said: list[str]) -> None:
    text = make().summary()
    for words in said:
        assert words in text, text


def test_a_summary_is_as_the_command_prints_it() -> None:
    run = ANSWERS["relax"]()
    rows = dict(line.split("  ", 1) for line in run.summary().split("\n") if "  " in line)
    assert rows["sample time"].strip() == "1 ms"
    assert rows["samples"].strip() == "2001"


def test_texts_are_escaped_in_html() -> None:
    gel = tissue.Material("gel", "<b>soft & \"wet\"</b>", FISH, {"citation": "<script>", "conditions": "x", "checked": False})
    html = gel._repr_html_()
    assert "<b>" not in html
    assert "<script>" not in html
    assert "&lt;b&gt;soft &amp; &quot;wet&quot;&lt;/b&gt;" in html


def test_numbers_that_are_none_are_shown() -> None:
    text = tissue.Model("spring-pot", viscosity_pa_s_alpha=5.0, order=0.3).summary()
    assert "instantaneous modulus  –  (infinite)" in text
    felt = analysis.Felt(np.array([1.0]), np.array([np.nan]), np.array([1.0 + 0j]))
    assert "1 values" in felt.summary()


@pytest.mark.parametrize(
    "device",
    [
        lambda: analysis.Device("65 g"),
        lambda: analysis.Device("65g", 0.0),
        lambda: analysis.Device(mass="65g"),
        lambda: analysis.Device(mass=0.065),
        lambda: analysis.Device(mass_kg="0.065"),
        lambda: analysis.Device("65 g", damping=0, delay="0 ms", current_lag_s=0),
    ],
)
def test_a_device_is_read_with_its_units(device: Callable[[], analysis.Device]) -> None:
    assert device() == analysis.Device(0.065, 0.0)


def test_every_part_of_a_device_is_read() -> None:
    read = analysis.Device("65 g", "3.5 N·s/m", hand_stiffness="0.1 kN/m", delay="500us", current_lag="1ms")
    assert read == analysis.Device(0.065, 3.5, 100.0, 5e-4, 1e-3)


@pytest.mark.parametrize(
    ("call", "error", "text"),
    [
        (lambda: analysis.Device("65 mm"), ValueError, 'mass_kg: "65 mm" is a length, not a mass: .* kg, g'),
        (lambda: analysis.Device(65), ValueError, "mass_kg: 65 has no unit: write 65g, or 65kg if it is that"),
        (lambda: analysis.Device(mass=65.0), ValueError, "mass_kg: 65 has no unit"),
        (lambda: analysis.Device(*[0.1] * 6), TypeError, "has 5 numbers"),
        (lambda: analysis.Device(), TypeError, r'needs its mass: Device\("65 g"\)'),
        (lambda: analysis.Device("65 g", mas="65 g"), TypeError, "did you mean `mass_kg`"),
        (lambda: analysis.Device("65 g", mass="65 g"), TypeError, "mass_kg is given twice"),
        (lambda: analysis.Device("65 g", stifness=3), TypeError, "unexpected keyword stifness"),
        (lambda: analysis.Device([0.065]), TypeError, "list|real number"),
    ],
)
def test_a_device_that_cannot_be_read_says_why(call: Callable[[], Any], error: type[Exception], text: str) -> None:
    with pytest.raises(error, match=text):
        call()


def test_experiments_take_texts_with_units_and_keys_without() -> None:
    wall = {"damping_n_s_per_m": 3.5, "order": 0.5, "dissipation_n_s_mu_per_m": 3.0, "duration_s": 2.0}
    plain = experiment.wall(mass_kg=0.065, sample_time_s=1e-3, stiffness_n_per_m=1000.0, **wall)
    typed = experiment.wall(mass="65 g", sample_time="1ms", stiffness="1 kN/m", **wall)
    assert typed["position_m"].tolist() == plain["position_m"].tolist()
    loop = {**wall, "sample_time_s": 1e-3, "stiffness_n_per_m": 1000.0}
    for mass in ("65", 65, 65.0):
        with pytest.raises(ValueError, match="mass_kg: 65 has no unit: write 65g, or 65kg if it is that"):
            experiment.wall(mass=mass, **loop)
    heavy = experiment.wall(mass_kg=65, **loop)["position_m"].tolist()
    assert heavy == experiment.wall(mass="65 kg", **loop)["position_m"].tolist()


@pytest.mark.parametrize("key", ["tissue", "against", "library", "device_model"])
def test_a_file_that_an_experiment_names_is_not_found(key: str) -> None:
    with pytest.raises(FileNotFoundError, match=f'{key} = "nofile.toml"'):
        experiment.relax(**{key: "nofile.toml"})


def test_an_order_and_a_stiffness_are_those_of_the_piece() -> None:
    run = experiment.relax(tissue="spring", stiffness="500 N/m", duration_s=3.0, contact="ideal")
    assert abs(run["closed_form_force_n"][-1] / 0.5 - 1) < 1e-12
    run = experiment.relax(order=0.5, duration_s=3.0)
    assert run.report["order"] == 0.5
    assert run.report["tissue"] == "prostate-cancerous-changed"


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: control.plant(operators.Operator(0.5, T)), "an Operator is D^μ alone"),
        (lambda: control.plant(analysis.Device("65 g")), "a Device is what analysis.Loop"),
        (lambda: analysis.region(control.plant("1/(s+1)"), 0.5, T), "a control.Plant is what control.design"),
        (lambda: analysis.Loop(control.TransferFunction("1/(s+1)"), 1.0, 1.0, 0.5, T), "becomes what they take by control.plant"),
        (lambda: analysis.Loop(tissue.find("liver"), 1.0, 1.0, 0.5, T), "a Material is what a wall renders"),
        (lambda: operators.state_space(0.5), "a float is no operator"),
    ],
)
def test_one_thing_in_place_of_another_says_which_is_which(call: Callable[[], Any], text: str) -> None:
    with pytest.raises(ValueError, match=re.escape(text)):
        call()


PIDS = [
    {"proportional": 2.0},
    {"proportional": 2.0, "integral": 3.0},
    {"proportional": 2.0, "integral": 3.0, "integral_order": 0.6, "derivative": 0.01, "derivative_order": 0.7},
    {"integral": 3.0, "integral_order": 1.4},
    {"derivative": 0.02, "derivative_order": 1.3},
    {"integral": 1.0, "integral_order": 2.0, "derivative": 0.001, "derivative_order": 2.0},
]


@pytest.mark.parametrize("gains", PIDS)
def test_a_controller_for_python_control_has_the_response_of_its_own(gains: dict[str, float]) -> None:
    pid = control.Pid(T, **gains)
    system = pid.to_control()
    assert isinstance(system, ct.StateSpace)
    assert system.dt == 0
    nyquist = np.pi / T
    omega = np.geomspace(1e-4 * nyquist, nyquist, 200)
    error = np.abs(system(1j * omega) / pid.response(omega) - 1).max()
    # Each fractional part and each whole slope is within 1 %; these have two at most.
    assert error < 0.0202
    if set(gains) <= {"proportional", "integral"}:
        assert error < 1e-12


def test_more_sections_are_nearer_and_the_band_is_where_it_holds() -> None:
    pid = control.Pid(T, proportional=1.0, integral=2.0, integral_order=0.5)
    omega = np.geomspace(1.0, 10.0, 20)
    errors = [np.abs(pid.to_control((1e-2, 1e3), n)(1j * omega) / pid.response(omega) - 1).max() for n in (2, 5, 10)]
    assert errors[0] > errors[1] > errors[2]
    # An integral holds at rest: the loop on a plant of finite gain has no error.
    loop = ct.feedback(pid.to_control() * ct.tf([1], [0.1, 1]))
    assert abs(ct.dcgain(loop) - 1) < 1e-9
    for band, sections, text in [((1.0, 1.0), None, "does not rise"), ((0.0, 1.0), None, "above 0"), (None, 0, "sections 0"), (None, 101, "sections 101")]:
        with pytest.raises(ValueError, match=text):
            pid.to_control(band, sections)


def test_without_python_control_the_extra_is_named() -> None:
    code = (
        "import sys; sys.modules['control'] = None\n"
        "from fractional_haptics.control import Pid\n"
        "from fractional_haptics.operators import Operator, to_control\n"
        "for call in (Pid(1e-3, proportional=1.0).to_control, lambda: to_control(Operator(0.5, 1e-3))):\n"
        "    try: call()\n"
        "    except ImportError as error: print(error)\n"
    )
    ran = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert ran.stdout.split("\n")[:2] == ["control is missing: pip install 'fractional-haptics[control]'"] * 2


def test_quantiles_of_a_sweep_are_drawn_as_bands() -> None:
    samples = np.arange(101.0)
    values = np.array([1.0, 2.0, 3.0])[:, None] * samples
    values[2, :50] = np.nan
    result = xr.DataArray(
        values, dims=("order", "sample"), coords={"order": ("order", [0.0, 0.5, 1.0], {"units": "1"})},
        name="stiffness", attrs={"units": "N/m"},
    )
    ax = plot.quantiles(result)
    np.testing.assert_allclose(ax.lines[0].get_ydata(), [50.0, 100.0, 225.0])
    # The outer band at the first order: 5 and 95 of 0 to 100.
    vertices = ax.collections[0].get_paths()[0].vertices
    assert {5.0, 95.0} <= set(vertices[vertices[:, 0] == 0.0][:, 1].round(9))
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["90 % of samples", "50 % of samples", "median"]
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("order", "stiffness / (N/m)")
    assert plot.quantiles(2 * result, ax=ax, label="twice") is ax
    assert ax.lines[1].get_color() != ax.lines[0].get_color()
    for call, text in (
        (lambda: plot.quantiles(result, over="draw"), "name another one in over"),
        (lambda: plot.quantiles(result.expand_dims(delay=2)), "choose with result.sel"),
        (lambda: plot.quantiles(result, shares=(0.1, 0.5)), "do not mirror"),
        (lambda: plot.quantiles(result, shares=()), "do not mirror"),
    ):
        with pytest.raises(ValueError, match=text):
            call()


def test_what_is_longer_than_a_screen_is_cut_and_says_so() -> None:
    long = experiment.Answer({f"key_{number}": number for number in range(100)})
    lines = str(long).split("\n")
    assert (len(lines), lines[0].split(), lines[-1]) == (41, ["key", "0", "0"], "… and 60 more lines")
    assert long._repr_html_().count("<tr>") == 41
    wide = experiment.Answer({"rows": [{"a": "x" * 200, "b": 1}], "text": "word " * 100})
    assert max(map(len, str(wide).split("\n"))) == 140
    assert str(wide).count("word") == 100
