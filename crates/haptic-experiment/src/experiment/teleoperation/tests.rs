//! Two hands over a line: energy over random lines, motions and places, and what is felt against the formula.

use super::{
    HandModel, HandMotion, RemotePlace, TeleoperationExperiment,
    pair::PairTick,
    report::{FeltAt, Judge},
};
use crate::{
    ExperimentFile,
    experiment::{
        bounded_tests::conducted,
        kind::{Conduct, Experiment as _},
    },
    judge::Report,
};
use fracdiff::{Order, Seconds};
use haptic_judge::{
    modelled_tissue::{ModelledTissue, TissuePiece},
    preflight::Matter,
};
use haptic_link::Architecture;
use haptic_loop::{
    Specimen,
    plant::MassDamperConfig,
    units::{Kilograms, Metres, NewtonSecondsPerMetre, SquareMetres},
};
use haptic_teleoperation::{ChannelModel, CouplerGains};
use haptic_tissue::Library;
use haptic_trial::safety::Safety;
use std::path::Path;
use testkit::{Folder, Random};

const T: Seconds = Seconds(1e-3);
const LIMIT_N: f64 = 10.0;

fn order(mu: f64) -> Order {
    Order::new(mu).expect("valid")
}

fn tissue(library: &Library, name: &str) -> RemotePlace {
    let material = library.find(name).expect("in the library");
    let matter = Matter::Tissue(TissuePiece {
        material: Box::new(ModelledTissue::new(material).expect("a model")),
        specimen: Specimen::slab(SquareMetres(4e-4), Metres(0.02)).expect("valid"),
    });
    RemotePlace {
        matter,
        one_sided: false,
    }
}

/// K + B·D^μ that pushes and pulls.
fn wall(stiffness_n_per_m: f64, dissipation_n_s_mu_per_m: f64, mu: f64) -> RemotePlace {
    let matter = Matter::Wall {
        stiffness_n_per_m,
        dissipation_n_s_mu_per_m,
        order: order(mu),
    };
    RemotePlace {
        matter,
        one_sided: false,
    }
}

fn ideal(mass: f64, damping: f64) -> MassDamperConfig {
    MassDamperConfig::ideal(Kilograms(mass), NewtonSecondsPerMetre(damping), T)
}

fn experiment(architecture: Architecture, place: RemotePlace) -> TeleoperationExperiment {
    TeleoperationExperiment {
        master: ideal(0.065, 3.5),
        slave: ideal(0.065, 3.5),
        hand: HandModel {
            stiffness_n_per_m: 300.0,
            damping_n_s_per_m: 3.0,
        },
        motion: HandMotion {
            press_m: 0.0,
            amplitude_m: 4e-3,
            frequencies_hz: HandMotion::frequencies(0.5, 100.0, 12, 4.0),
        },
        force_sensor: None,
        place,
        architecture,
        coupler: CouplerGains {
            stiffness_n_per_m: 300.0,
            dissipation_n_s_mu_per_m: 10.0,
        },
        order: order(0.5),
        wave_impedance_n_s_per_m: 3.0,
        playout_samples: None,
        channel: ChannelModel::IDEAL,
        seed: 1,
        silence_s: 0.2,
        scheme: "full".parse().expect("a scheme"),
        duration_s: 14.0,
        window_s: 4.0,
        force_limit_n: LIMIT_N,
        force_rate_limit_n_per_s: None,
        must_be_passive: false,
        safety: Safety::default(),
        conduct: Conduct::on(None),
    }
}

/// Runs it in virtual time without log or files; `true` if it reached its end with both sides at work.
fn simulate(far: &TeleoperationExperiment, mut sink: impl FnMut(&PairTick)) -> bool {
    let mut pair = far.pair().expect("in range");
    (0..far.samples()).all(|_| {
        sink(&pair.tick());
        pair.ended().is_none()
    })
}

/// What is felt in such a run.
fn felt(far: &TeleoperationExperiment) -> Vec<FeltAt> {
    let mut judged = Judge::new(far);
    assert!(simulate(far, |tick| judged.see(tick)));
    judged.felt(far).expect("in range")
}

/// A random place, hand and motion.
fn random(random: &mut Random, tissues: &[RemotePlace]) -> TeleoperationExperiment {
    let wall = RemotePlace {
        matter: Matter::Wall {
            stiffness_n_per_m: random.or_nothing(3000.0),
            dissipation_n_s_mu_per_m: random.or_nothing(20.0),
            order: order(random.between(0.0, 1.0)),
        },
        one_sided: random.chance(0.5),
    };
    let place = if random.chance(0.5) {
        wall
    } else {
        tissues[(random.bits() % tissues.len() as u64) as usize].clone()
    };
    let count = 1 + random.bits() % 6;
    let high = random.log_between(1.0, 60.0);
    let mut device = |most| ideal(random.log_between(0.03, 0.3), random.between(0.0, most));
    let (master, slave) = (device(5.0), device(5.0));
    let architecture = random.one_of(&[Architecture::Wave, Architecture::TimeDomain]);
    TeleoperationExperiment {
        master,
        slave,
        hand: HandModel {
            stiffness_n_per_m: random.log_between(20.0, 1000.0),
            damping_n_s_per_m: random.or_nothing(5.0),
        },
        motion: HandMotion {
            press_m: random.between(-0.02, 0.02),
            amplitude_m: random.log_between(1e-4, 0.02),
            frequencies_hz: HandMotion::frequencies(0.5, high, count, 1.0),
        },
        coupler: CouplerGains {
            stiffness_n_per_m: random.or_nothing(2000.0),
            dissipation_n_s_mu_per_m: random.log_between(0.1, 30.0),
        },
        order: order(random.share()),
        wave_impedance_n_s_per_m: random.log_between(0.3, 20.0),
        channel: ChannelModel {
            delay: Seconds(random.or_nothing(0.2)),
            jitter: 0.2,
            loss: 0.05,
            duplication: 0.02,
        },
        seed: random.bits() >> 8,
        duration_s: 2.5,
        window_s: 1.0,
        ..experiment(architecture, place)
    }
}

/// `CAMPAIGN_CASES`: how many, 100 by default; a thousand each night.
fn cases() -> u64 {
    testkit::cases(100)
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn passive_lines_give_no_energy_and_no_force_is_beyond_its_limit() {
    let library = Library::load(None).expect("the library");
    let tissues: Vec<RemotePlace> = ["prostate-cancerous", "fish-muscle", "prostate-healthy"]
        .map(|name| tissue(&library, name))
        .into();
    for case in 0..cases() {
        let experiment = random(&mut Random(case), &tissues);
        let (mut exchanged, mut last) = (1e-6, [0.0; 2]);
        let whole = simulate(&experiment, |tick| {
            for (side, last) in tick.sides.iter().zip(&mut last) {
                let (force_n, at_s) = (side.force_n, tick.time_s);
                assert!(
                    force_n.abs() <= LIMIT_N,
                    "case {case} at {at_s} s: {force_n} N"
                );
                exchanged += (side.force_n * (side.position_m - *last)).abs();
                *last = side.position_m;
            }
            let (given_j, at_s) = (tick.given_j, tick.time_s);
            assert!(
                given_j <= 1e-12 * exchanged,
                "case {case} at {at_s} s: {given_j:e} of {exchanged:e} J"
            );
        });
        assert!(whole, "case {case}: a side was silent, or has a fault");
    }
}

#[test]
fn a_line_that_is_not_passive_is_seen_to_give_energy() {
    // The same measure, so that the test above is one.
    let wall = wall(500.0, 0.0, 1.0);
    let mut late = experiment(Architecture::PositionPosition, wall);
    late.coupler.dissipation_n_s_mu_per_m = 0.0;
    late.channel.delay = Seconds(0.1);
    let mut most: f64 = 0.0;
    assert!(simulate(&late, |tick| most = most.max(tick.given_j)));
    assert!(most > 1e-5, "{most:e} J");
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn what_is_felt_without_delay_is_what_the_formula_says_within_1_db() {
    let library = Library::load(None).expect("the library");
    let places = [
        tissue(&library, "prostate-cancerous"),
        tissue(&library, "fish-muscle"),
        wall(200.0, 0.0, 1.0),
        wall(50.0, 4.0, 0.5),
    ];
    for architecture in [
        Architecture::PositionPosition,
        Architecture::PositionForce,
        Architecture::Wave,
    ] {
        for place in &places {
            let experiment = experiment(architecture, place.clone());
            let felt = felt(&experiment);
            // Up to a tenth of the sample rate.
            assert!(felt.last().is_some_and(|felt| felt.frequency_hz > 99.0));
            for felt in &felt {
                let off = felt.off_formula_db.expect("a linear place");
                assert!(
                    off.abs() < 1.0,
                    "{architecture} {} at {} Hz: {off} dB, {felt:?}",
                    place.words(),
                    felt.frequency_hz
                );
            }
        }
    }
}

#[test]
fn time_domain_passivity_is_felt_as_position_position_where_it_need_not_act() {
    let library = Library::load(None).expect("the library");
    let run_of = |architecture| {
        let place = tissue(&library, "prostate-cancerous");
        let experiment = experiment(architecture, place);
        (felt(&experiment), experiment.hands())
    };
    let (limited, hands) = run_of(Architecture::TimeDomain);
    // The formula of its coupler is not its own, so it has none.
    assert!(hands.is_none());
    let (free, _) = run_of(Architecture::PositionPosition);
    for (limited, free) in limited.iter().zip(&free) {
        assert!(limited.formula_n_per_m.is_none() && limited.off_formula_db.is_none());
        let off = 20.0 * (limited.felt_n_per_m / free.felt_n_per_m).log10();
        assert!(off.abs() < 3.0, "at {} Hz: {off} dB", free.frequency_hz);
    }
}

#[test]
fn what_held_forces_give_beyond_the_damping_is_not_passive() {
    let wall = wall(200.0, 0.0, 1.0);
    // A coupler too stiff for devices that hardly dissipate; its line gives nothing.
    let mut undamped = experiment(Architecture::TimeDomain, wall);
    (undamped.master, undamped.slave) = (ideal(0.065, 0.01), ideal(0.065, 0.05));
    undamped.coupler.stiffness_n_per_m = 300.0;
    undamped.coupler.dissipation_n_s_mu_per_m = 0.0;
    undamped.force_limit_n = 100.0;
    (undamped.duration_s, undamped.window_s) = (3.0, 2.0);
    let report = reported(&undamped);
    let results = &report.results;
    let number = |key: &str| results[key].as_f64().expect("a number");
    assert!(number("given_most_j") <= 1e-12, "{report:?}");
    assert!(number("beyond_damping_most_j") > 1e-8, "{report:?}");
    assert_eq!(results["verdict"], "held-forces-gave-energy");
    assert!(results["absolutely_stable"].is_null());
}

#[test]
fn waves_that_a_device_does_not_bear_are_refused() {
    let library = Library::load(None).expect("the library");
    let mut waves = experiment(Architecture::Wave, tissue(&library, "prostate-cancerous"));
    waves.slave = ideal(0.065, 2.9);
    let refused = waves.check().expect_err("3 is above 2.9").to_string();
    assert!(
        refused.starts_with("wave impedance 3 N·s/m is above the damping of the slave, 2.9 N·s/m"),
        "{refused}"
    );
    waves.wave_impedance_n_s_per_m = 2.9;
    assert!(waves.check().is_ok());
}

#[test]
fn a_line_that_loses_everything_ends_with_both_forces_at_zero() {
    let wall = wall(500.0, 0.0, 1.0);
    for architecture in Architecture::ALL {
        let mut deaf = experiment(architecture, wall.clone());
        deaf.channel.loss = 1.0;
        let mut last = [f64::NAN; 2];
        let run = simulate(&deaf, |tick| last = tick.sides.map(|side| side.force_n));
        // Never heard, so never at work.
        assert!(run, "{architecture}");
        assert_eq!(last.map(f64::to_bits), [0; 2], "{architecture}: {last:?}");
    }
}

#[test]
fn a_line_that_never_carried_anything_is_silent_and_not_passive() {
    let library = Library::load(None).expect("loads");
    let place = tissue(&library, "prostate-cancerous");
    let mut far = experiment(Architecture::TimeDomain, place);
    (far.duration_s, far.window_s) = (5.0, 4.0);
    far.channel.loss = 1.0;
    let report = reported(&far);
    let results = &report.results;
    assert_eq!(results["verdict"], "silent");
    assert_eq!(results["back"]["delivered"], 0);
    assert_eq!(results["forth"]["delivered"], 0);
}

/// Runs it with log and report.
fn reported(far: &TeleoperationExperiment) -> Report {
    let place = Folder::empty();
    let run = conducted(&place, |watched| far.run(watched));
    run.expect("runs").report
}

#[test]
fn a_file_is_read_and_its_mistakes_are_named() {
    let read = |text: &str| {
        let text = format!("[teleoperation]\n{text}");
        ExperimentFile::parse(Path::new("far.toml"), &text)
    };
    let good = read("duration_s = 8").expect("good");
    assert_eq!(good.samples().expect("good"), 8001);
    for [text, reason] in testkit::table(
        r#"
        line_delay_s = -0.1 | far.toml:2: line_delay_s = -0.1 is not from 0 to 10: change it, or omit it for 0.02
        architecture = "waves" | far.toml:2: architecture = "waves" is not one of position-position, position-force, wave, time-domain
        order = 1.5 | far.toml:2: order = 1.5 is not from 0 to 1
        device = "sim" | far.toml:2: unknown key `device`
        high_hz = 900 | far.toml:1: highest frequency 900 Hz
        window_s = 20 | far.toml:1: window 20 s
        coupler_stiffness_n_per_m = 0\ncoupler_dissipation_n_s_mu_per_m = 0 | far.toml:1: coupler stiffness and dissipation together 0 is not above 0: change `coupler_stiffness_n_per_m` or
        line_loss = 2 | far.toml:2: line_loss = 2 is not from 0 to 1
        "#,
    ) {
        let error = read(&text).expect_err(&text).to_string();
        assert!(error.starts_with(&reason), "{text}: {error}");
    }
}
