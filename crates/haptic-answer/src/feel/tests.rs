//! The loop of the thread in virtual time: what a hand is given that pushes from the first tick on.

use super::limits::limits;
use super::*;
use fracdiff::Order;
use haptic_judge::modelled_tissue::operator;
use haptic_judge::modelled_tissue::{ModelledTissue, TissuePiece};
use haptic_judge::preflight::Matter;
use haptic_loop::units::{Kilograms, Metres, Seconds};
use haptic_loop::{Controller, SafetyChain};
use haptic_loop::{Environment as _, LoopSample, Pushing, Wall};
use haptic_tissue::{FullHistory, Library, SampledModel};
use haptic_trial::DeviceValues;
use haptic_trial::in_hand::law::fading;
use nalgebra::Vector1;
use testkit::Random;

/// A pointer: where it is at a tick, m.
type Pointer = Box<dyn Fn(u32) -> f64>;

/// A tick of the loop: position, m, and force, N.
type Felt = (f64, f64);

fn settings(wall: WallNumbers, device: DeviceNumbers) -> FeelSettings {
    let library = Library::load(None).expect("built in");
    let start = FeelChange {
        environment: Some(FeltThing::Wall(wall)),
        ..FeelChange::default()
    };
    FeelSettings::new(&library, device, start).expect("in range")
}

/// The loop with a hand at this pointer, as the thread runs it.
fn ticked(
    settings: &FeelSettings,
    limits: &SafetyLimits,
    pointer: &Pointer,
    ticks: u32,
) -> Vec<LoopSample<f64, 1>> {
    let t = settings.device.sample_time();
    let chain = SafetyChain::from_limits(limits, t).expect("valid");
    let law = settings.law().expect("made");
    let mut controller = Controller::<_, 1, _>::new(fading(&law.environment, t), chain);
    let mut device = settings.device.simulated().expect("valid");
    let mut engaged = controller.engage(&mut device);
    let tick = |n| {
        engaged.device_mut().hand(pointer(n), true);
        let Ok(sample) = engaged.tick();
        sample
    };
    (0..ticks).map(tick).collect()
}

/// The same in short; with a start-up ramp, if one is given.
fn felt(wall: WallNumbers, pointer: &Pointer, rise_time: Option<Seconds>) -> Vec<Felt> {
    let settings = settings(wall, DeviceNumbers::default());
    let tighter = limits(
        Kilograms(settings.device.values.mass_kg),
        0,
        settings.device.sample_time(),
    );
    let limits = SafetyLimits {
        rise_time: rise_time.or(tighter.rise_time),
        ..tighter
    };
    let samples = ticked(&settings, &limits, pointer, TICKS).into_iter();
    samples
        .map(|sample| (sample.reading.position_m[0], sample.force.newtons()[0]))
        .collect()
}

/// The most that a touch gave at any time, J.
#[derive(Debug, Default)]
struct Given {
    /// Energy by the law: each force on the way to where it was asked for.
    law_j: f64,
    /// Energy in all: forces held over a tick, less what the damping of the device took.
    net_j: f64,
}

fn given(ticks: &[Felt]) -> Given {
    let mut most = Given::default();
    let (mut law_j, mut net_j) = (0.0, 0.0);
    for pair in ticks.windows(2) {
        let [(before_m, held_n), (now_m, force_n)] = [pair[0], pair[1]];
        let moved = now_m - before_m;
        law_j += force_n * moved;
        net_j += held_n * moved - DAMPING * moved * moved * 1e3;
        if now_m <= 0.0 {
            (law_j, net_j) = (0.0, 0.0);
        }
        most.law_j = most.law_j.max(law_j);
        most.net_j = most.net_j.max(net_j);
    }
    most
}

const DAMPING: f64 = haptic_document::parameters::DAMPING.default_number();
const TICKS: u32 = 6000;

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_wall_that_is_pressed_from_the_start_gives_nothing_back_that_it_did_not_take() {
    let mut random = Random(1);
    let mut share = move || random.share();
    let (mut were_felt, mut ramped_j) = (0, 0.0_f64);
    for case in 0..30 {
        let wall = WallNumbers {
            order: share(),
            stiffness_n_per_m: 900.0 * share(),
            dissipation_n_s_mu_per_m: 40.0 * share(),
            ..WallNumbers::default()
        };
        // In at any time, a hold of any length, out and in again within the touch.
        let (into, hold) = ((400.0 * share()) as u32, (1200.0 * share()) as u32 + 300);
        let (deep, less) = (0.002 + 0.018 * share(), share());
        let tremble = 1e-3 * share();
        let pointer: Pointer = Box::new(move |n| {
            let shake = tremble * (f64::from(n) / 17.0).sin();
            match n.saturating_sub(into) / hold {
                _ if n < into => -5e-3,
                0 | 2 => deep + shake,
                1 => deep * less + shake,
                _ => -5e-3,
            }
        });
        let ticks = felt(wall.clone(), &pointer, None);
        let most = given(&ticks);
        // Rounding.
        assert!(most.law_j < 1e-12, "case {case}, {wall:?}: {most:?}");
        assert!(most.net_j < 1e-12, "case {case}, {wall:?}: {most:?}");
        were_felt += u32::from(ticks.iter().any(|(_, force_n)| *force_n < -0.3));
        ramped_j = ramped_j.max(given(&felt(wall, &pointer, Some(Seconds(0.5)))).net_j);
    }
    assert!(were_felt > 20, "{were_felt} of 30 hands felt a wall");
    // What a ramp would give to the same hands.
    assert!(ramped_j > 2e-3, "{ramped_j} J");
}

#[test]
fn the_device_begins_where_no_force_acts() {
    let rest: Pointer = Box::new(|_| -5e-3);
    let ticks = felt(WallNumbers::default(), &rest, None);
    let clear = ticks
        .iter()
        .all(|&(place, force)| place < 0.0 && force == 0.0);
    assert!(clear);
}

/// A wall of any order and scheme, and a device that is late and reads noise.
fn any(random: &mut Random) -> (WallNumbers, DeviceNumbers) {
    let schemes = [
        "full",
        "full",
        "muir:3",
        "tustin-muir:3",
        "grunwald:80",
        "piecewise-linear",
    ];
    let order = random.between(0.0, 2.0);
    let wall = WallNumbers {
        order,
        stiffness_n_per_m: random.log_between(10.0, 1e6),
        // As much at 100 rad/s as 1 N/m to 10 kN/m.
        dissipation_n_s_mu_per_m: random.log_between(1.0, 1e4) * 100_f64.powf(-order),
        scheme: random.one_of(&schemes).to_owned(),
        signed: random.chance(0.3),
    };
    let values = DeviceValues {
        mass_kg: random.log_between(0.02, 2.0),
        damping_n_s_per_m: random.between(0.1, 10.0),
        delay_s: random.or_nothing(3e-3),
        current_lag_s: random.or_nothing(2e-3),
        encoder_resolution_m: random.or_nothing(1e-4),
        sensor_noise_m: random.or_nothing(1e-5),
        ..DeviceValues::default()
    };
    let device = DeviceNumbers {
        values,
        sample_time_s: random.one_of(&[1e-3, 2e-3, 5e-4]),
    };
    (wall, device)
}

/// c of Σ c·x that is D^μ x·T^μ of all the past, by their recurrence.
fn weights(order: f64, many: usize) -> Vec<f64> {
    let mut weight = 1.0;
    let all = (0..many).map(|n| {
        if n > 0 {
            weight *= 1.0 - (order + 1.0) / n as f64;
        }
        weight
    });
    all.collect()
}

/// Forces of the page's loop are, for every wall, those of the law of `host-cli run` for the positions that were read, which has
/// an operator for the run alone; and those of the defining sum, where the operator remembers all.
fn forces_agree(cases: u32) {
    const MANY: u32 = 400;
    let mut random = Random(60);
    let (mut pressed, mut summed) = (0, 0);
    for case in 0..cases {
        let (wall, device) = any(&mut random);
        let settings = settings(wall.clone(), device);
        let deep = random.between(1e-3, 10e-3);
        let pointer: Pointer = Box::new(move |n| match n / 150 {
            0 | 2 => deep,
            _ => -2e-3,
        });
        // What the law wants, whatever the chain makes of it: no force ends the loop.
        let samples = ticked(&settings, &settings.limits(), &pointer, MANY);
        let ended = samples.iter().position(|sample| sample.fault.is_some());
        let samples = &samples[..ended.unwrap_or(samples.len())];
        let t = settings.device.sample_time();
        let (order, scheme) = (Order::new(wall.order).expect("valid"), settings.scheme());
        let built = operator(None, scheme.expect("a scheme"), order, t, 5001.0);
        let (k, b) = (wall.stiffness_n_per_m, wall.dissipation_n_s_mu_per_m);
        let surface = (!wall.signed).then_some(Metres(0.0));
        let law = Wall::new(k, b, built.expect("made"), surface).expect("valid");
        let law = Pushing::new(law, false);
        let mut history = law.at_rest();
        law.settle(&mut history, &Vector1::new(-5e-3));
        let weights = weights(wall.order, samples.len());
        let mut heard: Vec<f64> = Vec::new();
        let rate = t.0.powf(-wall.order);
        // What a step of the largest depth would make: the errors of an operator are shares of it.
        let largest = 0.03 * (k + b * rate);
        for (n, sample) in samples.iter().enumerate() {
            let x = sample.reading.position_m;
            let (have, want) = (sample.environment_force_n[0], law.force(&history, &x)[0]);
            law.advance(&mut history, &x);
            assert!(
                (have - want).abs() < 2e-6 * largest,
                "case {case}, {wall:?}, tick {n}: {have} for {want}"
            );
            pressed += u32::from(have < -0.1);
            // A device that always stood where it begins had no derivative.
            heard.push(if wall.signed {
                x[0] + 5e-3
            } else {
                x[0].max(0.0)
            });
            if wall.scheme == "full" {
                let sum: f64 = weights
                    .iter()
                    .zip(heard.iter().rev())
                    .map(|(c, x)| c * x)
                    .sum();
                let outside = x[0] <= 0.0 && !wall.signed;
                let push = if outside {
                    0.0
                } else {
                    (k * x[0] + b * rate * sum).max(0.0)
                };
                assert!(
                    (have + push).abs() < 2e-6 * largest,
                    "case {case}, {wall:?}, tick {n}: {have} for {push}"
                );
                summed += u32::from(push > 0.1);
            }
        }
    }
    let enough = pressed > 60 * cases && summed > 15 * cases;
    assert!(enough, "{pressed} {summed}");
}

#[test]
fn the_force_of_ten_walls_is_that_of_the_command_and_of_the_sum() {
    forces_agree(10);
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_force_of_a_hundred_walls_is_that_of_the_command_and_of_the_sum() {
    forces_agree(100);
}

/// Forces of each tissue of the library are those of the sums of all elements of its model, which know nothing of modes.
#[test]
fn the_force_of_every_tissue_is_that_of_its_sums() {
    let library = Library::load(None).expect("built in");
    let mut pressed = 0;
    for material in library.materials() {
        let start = FeelChange {
            environment: Some(FeltThing::Tissue(material.name.clone())),
            ..FeelChange::default()
        };
        let settings = FeelSettings::new(&library, DeviceNumbers::default(), start);
        let settings = settings.and_then(FeelSettings::judged).expect("felt");
        let settings = settings.settings;
        let pointer: Pointer = Box::new(|n| match n / 150 {
            0 | 2 => 2e-3,
            _ => -2e-3,
        });
        let samples = ticked(&settings, &settings.limits(), &pointer, 400);
        let tissue = ModelledTissue::new(material.clone()).expect("modelled");
        let piece = TissuePiece::usual(tissue).expect("a piece");
        let model = SampledModel::new(&material.model, settings.device.sample_time());
        let mut sums = FullHistory::new(&model.expect("sampled"), 400).expect("short");
        let map = piece.specimen.depth_map();
        let shape = settings.scale * piece.shape_m();
        let (k, b) = settings.gains();
        let rate = settings.device.sample_time_s.powf(-settings.law.order);
        let largest = 2e-3 * (k + b * rate);
        for (n, sample) in samples.iter().enumerate() {
            let depth = sample.reading.position_m[0].max(0.0);
            let stress = sums.step(map.map_or(depth, |map| map.at(depth)));
            let want = if depth > 0.0 {
                (shape * stress).max(0.0)
            } else {
                0.0
            };
            let have = -sample.environment_force_n[0];
            assert!(
                (have - want).abs() <= 2e-6 * largest,
                "{}, tick {n}: {have} for {want}",
                material.name
            );
            pressed += u32::from(have > 0.01);
        }
        assert!(
            samples.iter().all(|sample| sample.fault.is_none()),
            "{}",
            material.name
        );
    }
    assert!(pressed > 1000, "{pressed}");
}

fn tissue(name: &str, scale: f64) -> FeelSettings {
    let start = FeelChange {
        environment: Some(FeltThing::Tissue(name.to_owned())),
        scale: Some(scale),
        ..FeelChange::default()
    };
    let library = Library::load(None).expect("built in");
    FeelSettings::new(&library, DeviceNumbers::default(), start).expect("in range")
}

fn wall(order: f64, stiffness_n_per_m: f64, dissipation_n_s_mu_per_m: f64) -> FeelSettings {
    let wall = WallNumbers {
        order,
        stiffness_n_per_m,
        dissipation_n_s_mu_per_m,
        ..WallNumbers::default()
    };
    settings(wall, DeviceNumbers::default())
}

#[test]
fn the_stiffer_one_of_two_is_that_at_all_speeds_of_a_hand_and_two_that_cross_have_none() {
    let by = |one: &FeelSettings, other: &FeelSettings| one.stiffer_by(other).expect("compared");
    assert_eq!(
        by(&wall(1.0, 450.0, 0.0), &wall(1.0, 300.0, 0.0)),
        Some(0.5)
    );
    // A damper is the softer one of slow motion and the stiffer one of fast.
    assert_eq!(by(&wall(1.0, 0.0, 50.0), &wall(1.0, 300.0, 0.0)), None);
    assert!(
        wall(0.5, 0.0, 0.0)
            .stiffer_by(&wall(0.5, 0.0, 0.0))
            .is_err()
    );
    // Each tissue of the library against its modulus, whatever its model.
    let library = Library::load(None).expect("built in");
    let spring = wall(1.0, 100.0, 0.0);
    for material in library.materials() {
        let felt = tissue(&material.name, 0.5);
        let piece = ModelledTissue::new(material.clone())
            .and_then(|tissue| TissuePiece::usual(tissue).map_err(haptic_document::Failure::input));
        let matter = Matter::Tissue(piece.expect("a piece"));
        let of = |hz: f64| 0.5 * matter.stiffness(std::f64::consts::TAU * hz).norm() / 100.0 - 1.0;
        let (slow, fast) = (of(0.1), of(10.0));
        match by(&felt, &spring) {
            Some(change) => testkit::assert_relative(&material.name, change, of(1.0), 1e-9),
            None => assert!(
                slow.min(fast) < 0.0 && slow.max(fast) > 0.0,
                "{}",
                material.name
            ),
        }
        let softer = by(&tissue(&material.name, 0.25), &felt).expect("one way");
        testkit::assert_relative(&material.name, softer, -0.5, 1e-12);
    }
}

#[test]
fn a_change_of_law_is_proved_as_a_session_proves_it() {
    // Both are stable, and a mix of them is not.
    let (stiff, soft) = (
        wall(1.41897, 68894.82, 2.5176),
        wall(0.069792, 537.16, 7443.1),
    );
    for law in [&stiff, &soft] {
        law.clone().judged().expect("stable");
    }
    let refused = stiff.proves_change(&soft).expect_err("a mix that grows");
    assert!(
        refused.to_string().contains("not proved stable"),
        "{refused}"
    );
    stiff.proves_change(&stiff).expect("no change");
    // Among tissues that are felt, and as a slider goes.
    let library = Library::load(None).expect("built in");
    let fitted = |name: &str| tissue(name, 1.0).judged().map(|judged| judged.settings);
    let all = library
        .materials()
        .iter()
        .flat_map(|material| fitted(&material.name));
    let all: Vec<_> = all.collect();
    for pair in all.windows(2) {
        pair[0].proves_change(&pair[1]).expect("proved");
    }
    let steps: Vec<_> = (0..=20)
        .map(|n| wall(0.05 * f64::from(n), 300.0, 30.0))
        .collect();
    for pair in steps.windows(2) {
        pair[0].proves_change(&pair[1]).expect("proved");
    }
}
