"""`tissue` against closed forms, and records made from known models."""

import copy
import math
import pickle

import numpy as np
import pytest
from scipy.special import gamma

from fractional_haptics.tissue import MODELS, Material, Model, find, identify, identify_tables, library

MUSCLE = {
    "viscosity_pa_s_alpha": 876e3,
    "order": 0.675,
    "second_viscosity_pa_s_beta": 22.1e3,
    "second_order": 0.11,
}
SOURCE = {"citation": "me, 2026", "conditions": "21 °C", "checked": True}


def example(kind: str) -> Model:
    values = {"order": 0.7, "second_order": 0.2, "branch_moduli_pa": [3e3, 1e3], "branch_times_s": [0.1, 2.0]}
    return Model(kind, **{p.name: values.get(p.name, 2000.0) for p in MODELS[kind].parameters})


def test_a_spring_pot_is_its_power_law() -> None:
    gel = Model("spring-pot", viscosity_pa_s_alpha=8650.0, order=0.2247)
    t = np.geomspace(1e-3, 1e3, 13).reshape(1, 13)
    np.testing.assert_allclose(gel.relaxation_modulus(t), 8650.0 * t**-0.2247 / gamma(1 - 0.2247), rtol=1e-13)
    np.testing.assert_allclose(gel.creep_compliance(t), t**0.2247 / 8650.0 / gamma(1.2247), rtol=1e-13)
    np.testing.assert_allclose(gel.complex_modulus(t), 8650.0 * (1j * t) ** 0.2247, rtol=1e-13)
    assert isinstance(gel.relaxation_modulus(1.0), float)
    assert isinstance(gel.complex_modulus(1), complex)


def test_stress_of_a_ramp_is_the_integral_of_the_modulus() -> None:
    gel = Model("spring-pot", viscosity_pa_s_alpha=8650.0, order=0.2247)
    t = np.linspace(0, 1, 11)
    np.testing.assert_allclose(gel.stress(t, 0.1 * t), 865.0 * t ** (1 - 0.2247) / gamma(2 - 0.2247), rtol=1e-12)
    # And back.
    np.testing.assert_allclose(gel.strain(t, 865.0 * t), 0.1 * t**1.2247 / gamma(2.2247), rtol=1e-12)


@pytest.mark.parametrize("kind", list(MODELS))
def test_every_model_of_the_table_can_be_made_kept_and_compared(kind: str) -> None:
    model = example(kind)
    assert model.kind == kind
    assert Model(kind, **model.parameters) == model
    for kept in (pickle.loads(pickle.dumps(model)), copy.deepcopy(model), eval(repr(model))):
        assert kept == model
        assert hash(kept) == hash(model)
    assert np.isfinite(model.relaxation_modulus(1.0))


def test_the_library_has_sources() -> None:
    materials = library()
    assert list(materials)[:3] == ["prostate-cancerous", "prostate-healthy", "fish-muscle"]
    assert all(material.source["citation"] for material in materials.values())
    assert find("prostate-healthy").model.parameters["order"] == 0.2154
    assert materials["fish-muscle"].range["time_to_s"] == 981.0


def test_an_own_material_goes_through_its_file(tmp_path) -> None:
    gel = Material("gel", "a gel", example("zener"), SOURCE, {"strain_to": 0.1})
    path = tmp_path / "gel.toml"
    path.write_text(gel.to_toml())
    for same in (find(path), library(tmp_path)["gel"], pickle.loads(pickle.dumps(gel))):
        assert same == gel
        assert same.source["checked"] is True
        assert same.range["strain_to"] == 0.1
    with pytest.raises(ValueError, match="jelly"):
        find("jelly", tmp_path)


def test_what_is_no_tissue_is_skipped_with_a_warning(tmp_path) -> None:
    (tmp_path / "gel.toml").write_text(Material("gel", "a gel", example("zener"), SOURCE).to_toml())
    (tmp_path / "wall.toml").write_text("[wall]\n")
    with pytest.warns(UserWarning, match="wall.toml"):
        assert "gel" in library(tmp_path)
    with pytest.warns(UserWarning, match="wall.toml"), pytest.raises(ValueError, match="wall.toml"):
        find("wall", tmp_path)


def test_relaxation_creep_and_oscillation_give_the_model_back() -> None:
    muscle = Model("fractional-maxwell", **MUSCLE)
    t = np.geomspace(0.01, 1000, 80)
    for kind, y in (
        ("relaxation", muscle.relaxation_modulus(t)),
        ("creep", muscle.creep_compliance(t)),
        ("oscillation", muscle.complex_modulus(t)),
    ):
        found = identify(t, y, kind, models=["spring-pot", "fractional-maxwell"])
        assert found.best.kind == "fractional-maxwell"
        assert {fit.kind for fit in found.fits} == {"spring-pot", "fractional-maxwell"}
        for name, value in MUSCLE.items():
            assert math.isclose(found.best.model.parameters[name], value, rel_tol=1e-5), (kind, name)
        assert found.best.rms < 1e-8
        np.testing.assert_allclose(found.best.predicted, found.measured, rtol=1e-7)


def test_a_motion_gives_the_model_back() -> None:
    gel = Model("spring-pot", viscosity_pa_s_alpha=8650.0, order=0.2247)
    t = np.linspace(0, 5, 20 * 800 + 1)
    strain = 0.1 * np.sin(t) ** 2
    # Of a motion as smooth as this, a sample in 20 is enough.
    time, strain, stress = (values[::20] for values in (t, strain, gel.stress(t, strain)))
    found = identify(time, stress, "record", strain=strain, models=["spring-pot"])
    assert math.isclose(found.best.model.parameters["order"], 0.2247, rel_tol=1e-6)


def test_an_indentation_gives_the_model_back() -> None:
    gel = Model("spring-pot", viscosity_pa_s_alpha=3000.0, order=0.2)
    t = np.linspace(0, 5, 501)
    depth = 1e-3 * np.minimum(t, 1.0)
    # Hertz, nu = 0.5: f = (16/9) sqrt(R) E delta^1.5
    force = 16 / 9 * math.sqrt(4e-3) * gel.stress(t, depth**1.5)
    found = identify(t, force, "record", depth=depth, loading="sphere", indenter_radius_m=4e-3, models=["spring-pot"])
    assert math.isclose(found.best.model.parameters["order"], 0.2, rel_tol=1e-4)
    assert math.isclose(found.best.model.parameters["viscosity_pa_s_alpha"], 3000.0, rel_tol=1e-4)
    assert any("strain reaches 0.25" in said for said in found.warnings)


def test_motions_to_several_depths_tell_how_a_tissue_stiffens() -> None:
    gel, radius, b = Model("spring-pot", viscosity_pa_s_alpha=3000.0, order=0.2), 4e-3, 8.0
    t = np.linspace(0, 5, 251)
    depths = [radius * strain * np.minimum(t, 1.0) for strain in (0.03, 0.15)]
    # e = depth^1.5 (exp(b depth/R) - 1)/(b depth/R)
    seen = [np.sqrt(depth) * radius / b * np.expm1(b * depth / radius) for depth in depths]
    forces = [16 / 9 * math.sqrt(radius) * gel.stress(t, e) for e in seen]
    options = {"loading": "sphere", "indenter_radius_m": radius, "models": ["spring-pot"], "stiffening": True}
    best = identify([t, t], forces, "record", depth=depths, **options).best
    assert best.estimates[-1].name == "stiffening"
    assert math.isclose(best.estimates[-1].value, b, rel_tol=1e-2)
    with pytest.raises(ValueError, match="another column is not"):
        identify([t, t], forces, "record", depth=depths[:1], **options)
    with pytest.raises(ValueError, match="only motions are fitted together"):
        identify([t[1:], t[1:]], [1 / t[1:], 1 / t[1:]])


def test_bootstrap_reports_progress_and_repeats_by_its_seed() -> None:
    rng = np.random.default_rng(7)
    t = np.geomspace(0.01, 100, 50)
    y = 5000 * t**-0.2 * np.exp(0.01 * rng.standard_normal(50))
    seen: list[int] = []
    first, again = (
        identify(t, y, models=["spring-pot"], bootstrap=60, seed=3, progress=seen.append) for _ in range(2)
    )
    assert first.best.estimates == again.best.estimates
    assert seen[-1] == 60
    order = first.best.estimates[1]
    assert order.name == "order"
    assert order.low_95 < 0.2 < order.high_95


def test_what_a_callback_raises_comes_out() -> None:
    t = np.geomspace(0.01, 100, 50)
    y = 5000 * t**-0.2 * (1 + 0.01 * np.cos(37 * t))

    def stop(_done: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        identify(t, y, bootstrap=200, progress=stop)


def test_a_prony_series_says_its_error() -> None:
    muscle = find("fish-muscle").model
    series, error = muscle.prony(12, 1e-3, 1000.0)
    t = np.geomspace(1e-3, 1000, 500)
    seen = np.max(np.abs(series.relaxation_modulus(t) / muscle.relaxation_modulus(t) - 1))
    assert seen < 1.01 * error < 0.01
    assert "PRONY" in muscle.export("ansys", 12, 1e-3, 1000.0)


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: Model("maxwell", elastic_modulus_pa=1.0), "viscosity_pa_s is missing"),
        (lambda: Model("spring", elastic_modulus_pa=1.0, order=0.1), "order is not a parameter"),
        (lambda: example("zener").stress([0.0, 1.0], [0.0]), "give one for each time"),
        (lambda: Material("gel", "", example("zener"), {"citation": "x"}), "source: missing field"),
        (lambda: identify([1.0, 2.0], [2.0, 1.0], "record"), "strain is missing"),
        (lambda: identify([1.0, 2.0], [2.0, 1.0], strain=[0.0, 1.0]), "strain belongs"),
        (lambda: identify([1.0, 2.0], [2.0, 1.0], "record", depth=[0.0, 1.0]), "depth and loading belong together"),
        (lambda: identify([1.0, 2.0], [2.0, 1.0], weights="all"), "weights"),
    ],
)
def test_what_is_wrong_is_refused_with_a_reason(call, text: str) -> None:
    with pytest.raises(ValueError, match=text):
        call()


def test_a_contact_point_a_ramp_and_held_parameters_are_those_of_the_command():
    gel = Model("spring-pot", viscosity_pa_s_alpha=3000.0, order=0.2)
    t = np.linspace(0.0, 1.0, 201)
    # A sphere of 4 mm that touches at 0.1 mm: f = 16/9·√R·E ∗ d(δ^1.5), of which the spring is the simplest.
    depth = 1e-3 * t
    force = 16 / 9 * 4e-3**0.5 * 1000.0 * np.maximum(depth - 1e-4, 0.0) ** 1.5
    sphere = {"depth": depth, "loading": "sphere", "indenter_radius_m": 4e-3, "models": ["spring"]}
    for contact in (1e-4, "fit"):
        found = identify(t, force, "record", contact_point=contact, **sphere)
        assert found.best.model.parameters["elastic_modulus_pa"] == pytest.approx(1000.0, rel=1e-3)
    assert [(one.name, one.unit) for one in found.beside] == [("contact_point_m", "m")]
    assert found.beside[0].value == pytest.approx(1e-4, rel=1e-3)
    stress = gel.stress(t, np.minimum(t / 0.1, 1.0))
    found = identify(t, stress, ramp_time_s=0.1, models=["spring-pot"])
    assert found.best.model.parameters["order"] == pytest.approx(0.2, abs=1e-3)
    held = identify(t[1:], gel.relaxation_modulus(t[1:]), fix={"order": (0.21, 0.3)}, models=["spring-pot"])
    assert held.best.model.parameters["order"] == pytest.approx(0.21, abs=1e-9)
    for wrong, said in [
        ({"contact_point": 0.1}, "contact_point belongs to depth"),
        ({"kind": "creep", "ramp_time_s": 1.0}, "belongs to kind"),
    ]:
        with pytest.raises(ValueError, match=said):
            identify(t[1:], gel.relaxation_modulus(t[1:]), **wrong)


def test_tables_are_read_with_segments_and_shifted_to_a_master_curve(tmp_path):
    gel = Model("spring-pot", viscosity_pa_s_alpha=1000.0, order=0.25)
    omega = np.geomspace(1.0, 100.0, 9)
    header = "omega_rad_s,storage_modulus_pa,loss_modulus_pa"
    paths = []
    for celsius, shift in [(20.0, 0.0), (30.0, -0.4), (40.0, -0.7)]:
        modulus = gel.complex_modulus(omega * 10**shift)
        rows = [f"{w},{m.real},{m.imag}" for w, m in zip(omega, modulus, strict=True)]
        paths.append(tmp_path / f"{celsius}.csv")
        paths[-1].write_text("\n".join([header, *rows]))
    found = identify_tables(*paths, model="spring-pot", master_curve_c=20.0, temperatures_c=[20.0, 30.0, 40.0], shift_by="storage")
    assert found.best.model.parameters["order"] == pytest.approx(0.25, rel=1e-6)
    assert [one["log10_shift"] for one in found.several["shifts"]] == pytest.approx([0.0, -0.4, -0.7], abs=1e-6)
    columns = {"columns": "omega=1,storage=2,loss=3"}
    one = identify_tables(paths[0], model="spring-pot", **columns, from_=3.0)
    assert one.x.size == 2 * np.count_nonzero(omega >= 3.0) and one.notes
    for given, said in [
        ({"temperatures_c": [20.0]}, "no effect without"),
        ({"temperatures_c": [20.0], "master_curve_c": 20.0}, "there are 3 files, and not as many"),
        ({"segment": "9"}, "20.0.csv: there is no one segment"),
        ({"fix": {"order": "x"}}, "fix"),
        ({"bootstrap": 5}, "not 0 or a whole number from 40 to"),
        ({"strain": 5.0}, "`strain` = 5 is not above 0 and at most 1"),
    ]:
        with pytest.raises(ValueError, match=said):
            identify_tables(*paths, **given)
