//! Every model is rendered: relaxation and creep on the simulated rig against their closed forms.

use super::Indentation;
use crate::experiment::bounded_tests::defaults;
use fracdiff::{Differintegrator as _, FullMemory, Seconds};
use haptic_analysis::Dynamics;
use haptic_document::Document;
use haptic_judge::{
    modelled_tissue::{ModelledTissue, TissuePiece},
    preflight::{Preflight, WallContact},
    rendering::{IndenterContact, Precision},
};
use haptic_loop::{
    Loading, LoadingKind,
    plant::{RampHold, RigDrive},
    units::{Metres, Newtons},
};
use haptic_tissue::{
    Material, MeasuredLoading, Model, ModelKind, SampledModel, Source, ValidRange,
};
use std::{ops::ControlFlow, path::Path};
use testkit::{
    Random, Tested,
    device::{DAMPING, MASS, plant, read, with_hand, write},
    tissue::{KINDS, models, of_two},
};

fn tissue(model: Model) -> ModelledTissue {
    let gel = Material::new("gel", "a gel", model, Source::default());
    ModelledTissue::new(gel.expect("a name")).expect("sampled")
}

fn relaxation(model: Model, precision: Precision) -> Indentation {
    let mut relaxation = defaults(tissue(model));
    relaxation.contact = IndenterContact::Rigid;
    relaxation.precision = precision;
    // Far from the limits of the safety chain.
    relaxation.force_limit_n = 1e5;
    relaxation.force_rate_limit_n_per_s = 1e9;
    relaxation
}

/// Largest errors on the hold from 0.1 s after the ramp to 200 s, at every hundredth sample: as they are, and less what a
/// backward difference costs, which is half a sample late at most.
fn hold_errors(relaxation: &Indentation) -> [f64; 2] {
    let (mut worst, mut compared, mut peak) = ([0.0; 2], 0, 0.0);
    let half = 0.5 * relaxation.actuator.sample_time.0;
    let reached = relaxation.simulate(&mut |sample| {
        let force = -sample.commanded_force_n[0];
        peak = f64::max(peak, force);
        if sample.time_s >= 1.1 && sample.tick.is_multiple_of(100) {
            let want = relaxation.closed_form(sample.time_s);
            let late = (relaxation.closed_form(sample.time_s - half) - want).abs();
            // Of what has relaxed to next to nothing digits are left, but no share of it.
            let size = want.max(1e-6 * peak);
            let error = (force - want).abs();
            worst[0] = f64::max(worst[0], error / size);
            worst[1] = f64::max(worst[1], (error - late) / size);
            compared += 1;
        }
        ControlFlow::Continue(())
    });
    assert!(reached.expect("valid"), "no fault");
    assert_eq!(compared, 1990);
    worst
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn relaxation_of_each_model_is_its_closed_form() {
    for (name, model) in models(876e3, 22.1e3, &KINDS) {
        let [double, single] = [Precision::F64, Precision::F32]
            .map(|precision| hold_errors(&relaxation(model.clone(), precision)));
        for [plain, error] in [double, single] {
            // An exponential fades as (1 + T/τ)^(−n), late by the share T/2τ of the time.
            assert!(error <= 5e-5, "{name}: {error:e} beyond half a sample");
            // High orders beside the rest change so fast at first that half a sample is felt.
            let fast = ["of spring-pots", "with a spring"]
                .map(|orders| format!("fractional-kelvin-voigt {orders}"));
            let fast = fast.contains(&name);
            let most = if fast { 1e-3 } else { 1e-4 };
            assert!(plain <= most, "{name}: {plain:e}");
        }
    }
}

fn muscle() -> Model {
    testkit::tissue::model(ModelKind::FractionalMaxwell, &[876e3, 0.675, 22.1e3, 0.11])
}

/// A piece of the fish muscle that is loaded like this and stiffens so.
fn piece(loading: Loading, stiffening: f64) -> TissuePiece {
    let gel = Material::new("gel", "a gel", muscle(), Source::default()).expect("a name");
    let measured = MeasuredLoading {
        kind: Some(LoadingKind::Shear),
        ..MeasuredLoading::default()
    };
    let gel = gel.with_loading(measured, stiffening);
    TissuePiece::new(ModelledTissue::new(gel).expect("sampled"), loading).expect("fits")
}

/// Indenters and slabs, each with a stiffening.
fn pressed() -> Vec<(Loading, f64)> {
    let sphere = Loading {
        radius_m: Some(5e-3),
        ..Loading::new(LoadingKind::Sphere)
    };
    let layer = Loading {
        bonded: true,
        thickness_m: Some(4e-3),
        ..sphere
    };
    let cone = Loading {
        half_angle_rad: Some(1.2),
        ..Loading::new(LoadingKind::Cone)
    };
    let slab = Loading {
        area_m2: Some(4e-4),
        thickness_m: Some(0.01),
        ..Loading::new(LoadingKind::Compression)
    };
    vec![
        (sphere, 0.0),
        (sphere, 3.0),
        (layer, 0.0),
        (cone, 0.0),
        (slab, 10.0),
    ]
}

#[test]
fn a_piece_pressed_through_a_map_relaxes_and_creeps_as_lee_and_radok_say() -> Tested {
    for (loading, stiffening) in pressed() {
        let mut relaxation = relaxation(muscle(), Precision::F64);
        relaxation.piece = piece(loading, stiffening);
        let ramp = RampHold::new(Metres(1e-3), Seconds(1.0))?;
        relaxation.load = RigDrive::Position(ramp);
        relaxation.duration_s = 10.0;
        let piece = relaxation.piece.clone();
        let (mut closed, mut worst) = (piece.relaxation(1e-3, 1.0, Seconds(1e-3), 0.0), 0.0);
        let reached = relaxation.simulate(&mut |sample| {
            let want = closed(sample.tick, sample.time_s);
            if sample.time_s >= 1.1 {
                let error = (-sample.commanded_force_n[0] / want - 1.0).abs();
                worst = f64::max(worst, error);
            }
            ControlFlow::Continue(())
        });
        assert!(reached? && worst > 0.0);
        assert!(worst < 1e-4, "{loading:?} {stiffening}: {worst:e}");
        let mut creep = relaxation;
        (creep.load, creep.duration_s) = (RigDrive::Force(Newtons(1.0)), 5.0);
        creep.contact = IndenterContact::Ideal;
        let mut closed = piece.creep(1.0, Seconds(1e-3));
        let mut worst = 0.0;
        let reached = creep.simulate(&mut |sample| {
            let want = closed(sample.tick, sample.time_s);
            if sample.time_s >= 0.1 {
                worst = f64::max(worst, (sample.position_m[0] / want - 1.0).abs());
            }
            let force = -sample.commanded_force_n[0];
            assert!((force - 1.0).abs() < 1e-5, "the push is carried: {force}");
            ControlFlow::Continue(())
        });
        assert!(reached? && worst > 0.0);
        // The kernel is a sample late at most: T·J'/J = 1e-3·0.675/t at most, halved by the slope of e or more.
        assert!(worst < 5e-3, "{loading:?} {stiffening}: {worst:e}");
    }
    Ok(())
}

#[test]
fn a_shear_modulus_is_three_times_as_stiff_in_compression() {
    let slab = |kind| Loading {
        area_m2: Some(4e-4),
        thickness_m: Some(0.02),
        ..Loading::new(kind)
    };
    let [shear, compression] =
        [LoadingKind::Shear, LoadingKind::Compression].map(|kind| piece(slab(kind), 0.0));
    assert!((compression.shape_m() / shear.shape_m() - 3.0).abs() < f64::EPSILON);
}

#[test]
fn a_run_beyond_the_record_says_by_how_much_and_a_run_within_is_quiet() {
    let mut muscle = piece(pressed()[0].0, 0.0);
    assert!(
        muscle.leaves((1e-3, 1e6), 0.9e-3).is_empty(),
        "no range, small"
    );
    let material = (*muscle.material).clone();
    let range = ValidRange {
        time_from_s: Some(0.01),
        omega_from_rad_s: Some(1e-3),
        strain_to: Some(0.1),
        ..ValidRange::default()
    };
    let material = Material::clone(&material).with_range(range);
    *muscle.material = ModelledTissue::new(material).expect("sampled");
    assert!(muscle.leaves((0.01, 1000.0), 0.5e-3).is_empty());
    let message = muscle.leaves((1e-3, 5000.0), 1.5e-3).join("; ");
    // The record's strain is that of shear, which says nothing of a sphere.
    assert_eq!(
        message,
        "the numbers of gel come from 0.01 to 1000 s; this asks for 0.001 to 5000 s, 10 times earlier and 5 times later; \
         the strain reaches 30 %; small strain, as this model assumes, holds up to 20 %"
    );
    muscle.material = {
        let indented = MeasuredLoading {
            kind: Some(LoadingKind::Sphere),
            ..MeasuredLoading::default()
        };
        let material = Material::clone(&muscle.material).with_loading(indented, 0.0);
        Box::new(ModelledTissue::new(material).expect("sampled"))
    };
    let message = muscle.leaves((0.01, 1.0), 1e-3).join("; ");
    assert_eq!(
        message,
        "the strain reaches 20 %; the numbers of gel hold up to 10 %"
    );
}

/// A push of 100 Pa on the rig against the closed form, from 1 s on.
#[test]
fn creep_of_each_model_is_its_closed_form() {
    // A dashpot beside the rest that this rig can bear; elsewhere so much that the rig's own is felt little.
    let is_kelvin = |name: &str| name.starts_with("fractional-kelvin");
    let soft = models(3e3, 5e3, &KINDS)
        .into_iter()
        .filter(|(name, _)| is_kelvin(name));
    let stiff = models(1e5, 1e4, &KINDS)
        .into_iter()
        .filter(|(name, _)| !is_kelvin(name));
    for (name, model) in soft.chain(stiff) {
        let mut creep = defaults(tissue(model));
        (creep.force_limit_n, creep.force_rate_limit_n_per_s) = (1e5, 1e9);
        (creep.load, creep.duration_s) = (RigDrive::Force(Newtons(0.04)), 20.0);
        let mut worst = 0.0;
        let mut sink = |sample: &haptic_message::TickMessage| {
            if sample.time_s >= 5.0 && sample.tick.is_multiple_of(100) {
                let strain = (creep.piece.specimen).strain(Metres(sample.position_m[0]));
                let model = &creep.piece.material.model;
                let want = 100.0 * model.creep_compliances(&[sample.time_s])[0];
                worst = f64::max(worst, (strain / want - 1.0).abs());
            }
            ControlFlow::Continue(())
        };
        assert!(creep.simulate(&mut sink).expect("valid"), "no fault");
        // The masses and the damping of the rig, 7 N·s/m, are not in the closed form.
        assert!(worst < 1e-2, "{name}: {worst:e}");
    }
}

#[test]
fn full_and_short_memories_alone_render_models_of_more_elements() {
    let muscle = || relaxation(muscle(), Precision::F64);
    let refused = |scheme: &str| {
        let mut muscle = muscle();
        muscle.scheme = scheme.parse().expect("a scheme");
        let error = muscle.simulate(&mut |_| ControlFlow::Continue(()));
        error.expect_err("not of this model").to_string()
    };
    for scheme in "muir:3 tustin-muir:9 oustaloup:5:0.1:100 piecewise-linear".split(' ') {
        let error = refused(scheme);
        assert!(
            error.contains("`scheme` = full, or a short memory, as in `scheme` = grunwald:1000"),
            "{error}"
        );
        assert_eq!(error.lines().count(), 1);
    }
    assert!(refused("exact").contains("for analysis only"));
}

/// A model drawn at random, a piece of it, and a hand on the device.
struct Drawn {
    model: Model,
    shape: f64,
    hand: f64,
}

fn drawn(random: &mut Random, case: usize) -> Drawn {
    let beta = random.or_nothing(0.6);
    let alpha = random.between(beta + 0.05, 1.0);
    let [v, g, elastic_modulus_pa] = [(); 3].map(|()| random.log_between(1e2, 1e5));
    Drawn {
        model: of_two(case, [v, alpha, g, beta, elastic_modulus_pa]),
        shape: random.log_between(1e-2, 1e2),
        hand: random.log_between(10.0, 1e3),
    }
}

const T: Seconds = Seconds(1e-3);

/// Largest deflection after a short push, in the second twentieth of a run of 10 s and in the last; infinite if the device
/// goes far away.
fn deflections(drawn: &Drawn) -> [f64; 2] {
    let sampled = SampledModel::new(&drawn.model, T).expect("valid");
    let design = sampled.design::<16, 112>(1e-6, 2e4).expect("modes");
    let memory = FullMemory::<f64, 16, 112>::new(&design, T).expect("valid");
    let mut history = memory.at_rest();
    let (k, b) = (
        drawn.shape * sampled.elastic_modulus_pa(),
        drawn.shape * sampled.viscosity_pa_s_mu(),
    );
    let mut device = plant(with_hand(MASS, DAMPING, drawn.hand, T.0));
    let mut largest = [0.0; 2];
    for n in 0..10_000 {
        let x = read(&mut device).position_m[0];
        let push = if n < 20 { 1.0 } else { 0.0 };
        // The push moves it by centimetres.
        if x.abs() > 10.0 {
            return [largest[0], f64::INFINITY];
        }
        write(&mut device, push - k * x - b * memory.step(&mut history, x));
        match n {
            500..1000 => largest[0] = f64::max(largest[0], x.abs()),
            9500.. => largest[1] = f64::max(largest[1], x.abs()),
            _ => {}
        }
    }
    largest
}

/// The analysis of the loop and a run of it agree, off the edge. More of them: `CAMPAIGN_CASES=200`.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn random_models_are_stable_as_the_analysis_says() -> Tested {
    let cases = testkit::cases(40);
    let mut random = Random(20_261_120);
    let (mut stable, mut unstable) = (0, 0);
    for case in 0..cases {
        let drawn = drawn(&mut random, case);
        let sampled = SampledModel::new(&drawn.model, T)?;
        let loop_ = Preflight {
            stiffness_n_per_m: drawn.shape * sampled.elastic_modulus_pa(),
            dissipation_n_s_mu_per_m: drawn.shape * sampled.viscosity_pa_s_mu(),
            order: sampled.order(),
            model: Some(&drawn.model),
            scheme: "full".parse()?,
            sample_time_s: T.0,
            samples: 10_000,
            map: None,
            contact: WallContact::OneSided,
            guarded: false,
        };
        let device = Dynamics {
            mass_kg: MASS,
            damping_n_s_per_m: DAMPING,
            hand_stiffness_n_per_m: drawn.hand,
            delay_s: 0.0,
            current_lag_s: 0.0,
        };
        let verdict = loop_.verdict(device, 0)?;
        let [early, late] = deflections(&drawn);
        let margin = verdict.margin;
        // Passive is stable with anything; so with this hand too.
        assert!(!verdict.passive || verdict.stable, "{case}: {verdict:?}");
        if verdict.stable && margin.is_none_or(|margin| margin > 1.05) {
            assert!(late < early, "{case}: {early:e} {late:e} {verdict:?}");
            stable += 1;
        } else if margin.is_some_and(|margin| margin < 0.95) && !verdict.stable {
            assert!(late.is_infinite(), "{case}: {early:e} {late:e} {verdict:?}");
            unstable += 1;
        }
    }
    assert!(5 * stable > cases && 5 * unstable > cases);
    Ok(())
}

/// The force of `[relax]` with these keys, N, by its closed form.
fn force_of(keys: &str, time_s: f64) -> Result<f64, String> {
    let text = format!("[relax]\n{keys}");
    let document = Document::of_text(Path::new("relax.toml"), &text);
    let parsed = document.parse().map_err(|error| error.to_string())?;
    let (_, table, _) = (parsed.one_of(&["relax"], &[], "", "")).map_err(|e| e.to_string())?;
    let relaxation = super::relax(&table, None).map_err(|error| error.to_string())?;
    Ok(relaxation.closed_form(time_s))
}

/// K·x + B·D^μ x of a ramp to 1 mm in 1 s, held until t: D^μ t = t^(1−μ)/Γ(2−μ).
fn held(stiffness: f64, dissipation: f64, order: f64, time_s: f64) -> f64 {
    let slope = |t: f64| libm::pow(t, 1.0 - order) / libm::tgamma(2.0 - order);
    1e-3 * (stiffness + dissipation * (slope(time_s) - slope(time_s - 1.0)))
}

#[test]
fn a_piece_has_the_stiffness_dissipation_and_order_that_are_given() {
    for (keys, want) in [
        ("tissue = 'spring'", held(1000.0, 0.0, 0.0, 5.0)),
        ("tissue = 'spring-pot'", held(0.0, 400.0, 0.5, 5.0)),
        (
            "tissue = 'spring'\nstiffness_n_per_m = 70",
            held(70.0, 0.0, 0.0, 5.0),
        ),
        (
            "tissue = 'spring-pot'\ndissipation_n_s_mu_per_m = 60\norder = 0.3",
            held(0.0, 60.0, 0.3, 5.0),
        ),
        ("order = 0.5", held(0.0, 8650.0 * 0.02, 0.5, 5.0)),
        (
            "tissue = 'dashpot'\nstiffness_n_per_m = 500\norder = 0.7",
            held(500.0, 100.0, 0.7, 5.0),
        ),
        // Young's modulus of the file against sheared plates: γ = A/(3h).
        (
            "tissue = 'spring'\nloading = 'shear'\nstiffness_n_per_m = 70",
            held(70.0, 0.0, 0.0, 5.0),
        ),
    ] {
        let have = force_of(keys, 5.0).expect(keys);
        assert!((have / want - 1.0).abs() < 1e-9, "{keys}: {have} {want}");
    }
    for (keys, refused) in [
        (
            "tissue = 'fish-muscle'\norder = 0.5",
            "relax.toml:3: tissue \"fish-muscle\" is a fractional-maxwell, which has no single order: prostate-cancerous, prostate-healthy,",
        ),
        (
            "tissue = 'spring'\norder = 0.5",
            "give `dissipation_n_s_mu_per_m` and `order` together, or use the tissue spring-pot",
        ),
        (
            "tissue = 'passive-muscle'\nstiffness_n_per_m = 5",
            "not linear in its depth",
        ),
        ("order = 1.2", "order = 1.2 is not from 0 to 1: change it"),
    ] {
        let error = force_of(keys, 5.0).expect_err(keys);
        assert!(error.contains(refused), "{keys}: {error}");
    }
}
