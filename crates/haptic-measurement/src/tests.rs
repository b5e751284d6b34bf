//! Random simulated devices are measured, and what is found is held against what they are.
//!
//! `CAMPAIGN_CASES` sets how many; 10 unless it is given, 500 at night.

mod random_devices;

use crate::{
    MEASURE_BOX, MEASURE_DURATION, MEASURE_FORCE_LIMIT, MEASURE_SAMPLE_TIME, MEASURE_SPEED,
    MEASUREMENT, MeasurePlan, MeasuredAxis, MotionRecord, OwnLimits, TABLES,
    drive::{DriveOutcome, Driven, drive, on_simulated},
    estimate::{MeasureError, Measured, device_model, estimate},
    response::{coherent, response},
};
use fracdiff::Seconds;
use haptic_document::Document;
use haptic_loop::{
    Device, Fault, Reading, SafeForce,
    plant::{MassDamper, MassDamperConfig},
    units::{Kilograms, NewtonSecondsPerMetre, Newtons, NewtonsPerMetre},
};
use haptic_trial::{DeviceModel, Sensors};
use nalgebra::Vector1;
use num_complex::Complex;
use std::{
    convert::Infallible,
    path::Path,
    sync::atomic::{AtomicBool, Ordering},
};
use testkit::Tested;

/// A device whose plant is stepped `parts` times a sample, so that its friction is not that of the model, with an encoder, and all that was done
/// to it.
struct Fine {
    plant: MassDamper<1>,
    parts: u32,
    step_m: f64,
    /// −1 where the encoder's channels are swapped.
    counts: f64,
    tick: u64,
    written_n: Vec<f64>,
    /// Ticks after which the stop flag is set.
    stop_after: Option<(usize, &'static AtomicBool)>,
}

impl Fine {
    fn new(config: MassDamperConfig, parts: u32) -> Self {
        let sample_time = Seconds(config.sample_time.0 / f64::from(parts));
        let config = MassDamperConfig {
            sample_time,
            ..config
        };
        Self {
            plant: MassDamper::new(config).expect("valid"),
            parts,
            step_m: 10e-6,
            counts: 1.0,
            tick: 0,
            written_n: Vec::new(),
            stop_after: None,
        }
    }

    fn drive(&mut self, plan: &MeasurePlan) -> Driven {
        let never = AtomicBool::new(false);
        let stop = self.stop_after.map_or(&never, |(_, stop)| stop);
        let driven = drive(plan, self, &mut |_, sent| sent, &|_| {}, stop);
        let driven = driven.unwrap_or_else(|_| panic!("a simulated device"));
        // Whatever happened, no force was beyond the limit, and none is left.
        assert!(
            self.written_n
                .iter()
                .all(|force| force.abs() <= plan.force_n())
        );
        assert_eq!(self.written_n.last(), Some(&0.0));
        driven
    }
}

impl Device<f64, 1> for Fine {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<f64, 1>, Infallible> {
        let counts = self.counts * (self.plant.position()[0] / self.step_m).round();
        Ok(Reading {
            tick: self.tick,
            time_s: self.tick as f64 * 1e-3,
            position_m: Vector1::new(counts * self.step_m),
        })
    }

    fn write(&mut self, force: SafeForce<f64, 1>) -> Result<(), Infallible> {
        for _ in 0..self.parts {
            self.plant.write(force)?;
        }
        self.tick += 1;
        self.written_n.push(force.newtons()[0]);
        if let Some((ticks, stop)) = self.stop_after {
            stop.store(self.written_n.len() >= ticks, Ordering::Relaxed);
        }
        Ok(())
    }
}

/// 65 g, 3.5 N·s/m, 0.05 N of friction, 1.3 samples and 0.5 ms late.
fn usual() -> MassDamperConfig {
    MassDamperConfig {
        friction: Newtons(0.05),
        delay: Seconds(1.3e-3),
        current_lag: Seconds(0.5e-3),
        ..MassDamperConfig::ideal(Kilograms(0.065), NewtonSecondsPerMetre(3.5), Seconds(1e-3))
    }
}

/// The motion of a simulated device that is less than ideal.
fn measured(plan: &MeasurePlan, device: MassDamperConfig, sensors: Sensors) -> MotionRecord {
    let never = AtomicBool::new(false);
    on_simulated(plan, device, sensors, &|_| {}, &never).expect("measures")
}

impl Default for MeasurePlan {
    fn default() -> Self {
        Self {
            sample_time_s: MEASURE_SAMPLE_TIME.default_number(),
            force_limit_n: MEASURE_FORCE_LIMIT.default_number(),
            box_m: MEASURE_BOX.default_number(),
            duration_s: MEASURE_DURATION.default_number(),
            speed_m_per_s: MEASURE_SPEED.default_number(),
            hand: false,
            axis: MeasuredAxis::default(),
            own: OwnLimits::NONE,
        }
    }
}

fn short() -> MeasurePlan {
    MeasurePlan {
        duration_s: 4.0,
        ..MeasurePlan::default()
    }
}

fn is_usual(found: &Measured) {
    let within = |have: f64, want: f64, share: f64| (have / want - 1.0).abs() <= share;
    assert!(within(found.mass_kg.value, 0.065, 0.05), "{found:?}");
    assert!(
        within(found.damping_n_s_per_m.value, 3.5, 0.05),
        "{found:?}"
    );
    assert!(within(found.friction_n.value, 0.05, 0.1), "{found:?}");
    assert!((found.delay_s.value - 1.3e-3).abs() <= 1e-4, "{found:?}");
    assert!(within(found.current_lag_s.value, 0.5e-3, 0.2), "{found:?}");
}

fn found(record: &MotionRecord, hand: bool) -> Measured {
    estimate(record, hand).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn friction_of_another_make_is_found_too_and_lost_samples_do_no_harm() {
    let driven = Fine::new(usual(), 16).drive(&short());
    assert_eq!(driven.outcome, DriveOutcome::Complete);
    let mut record = driven.record;
    let measured = found(&record, false);
    is_usual(&measured);
    assert!(measured.mass_kg.covers(0.065) && measured.damping_n_s_per_m.covers(3.5));
    assert!(measured.friction_n.covers(0.05), "{measured:?}");
    assert!(measured.delay_s.covers(1.3e-3) && measured.current_lag_s.covers(0.5e-3));
    let (up, down) = record.breakaway_n.expect("it moved both ways");
    assert!(up > 0.05 && up < 0.15 && down < -0.05 && down > -0.15);
    // One sample in forty is lost.
    for n in (0..record.position_m.len()).step_by(40) {
        record.position_m[n] = f64::NAN;
    }
    is_usual(&found(&record, false));
    for n in (0..record.position_m.len()).step_by(15) {
        record.position_m[n] = f64::NAN;
    }
    let lost = estimate(&record, false).expect_err("too many");
    assert!(matches!(lost, MeasureError::Lost { .. }), "{lost}");
    record.force_n[77] = f64::INFINITY;
    record.position_m.fill(0.0);
    let wrong = estimate(&record, false).expect_err("no force");
    assert!(
        matches!(wrong, MeasureError::NotFinite { tick: 77, .. }),
        "{wrong}"
    );
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_motor_slower_than_the_device_is_not_taken_for_its_mass() {
    // m/b = 3.75 ms, or 18.6 ms; the lag is longer, and exchanged with it the motion is all but the same.
    for (mass, damping, lag_s, friction_n) in [(0.03, 8.0, 5e-3, 0.02), (0.065, 3.5, 25e-3, 0.0)] {
        let damped = NewtonSecondsPerMetre(damping);
        let device = MassDamperConfig {
            friction: Newtons(friction_n),
            delay: Seconds(1e-3),
            current_lag: Seconds(lag_s),
            ..MassDamperConfig::ideal(Kilograms(mass), damped, Seconds(1e-3))
        };
        let sensors = Sensors {
            encoder_resolution_m: 1e-6,
            noise_m: 1e-6,
            seed: 1,
        };
        let plan = MeasurePlan::default();
        let record = measured(&plan, device, sensors);
        let found = found(&record, false);
        let is_warned = found
            .warnings
            .iter()
            .any(|message| message.contains("apart"));
        let right = (found.mass_kg.value / mass - 1.0).abs() < 0.05;
        assert!(right || is_warned, "{found:?}");
        let slack = 0.01 * mass;
        let (low, high) = (found.mass_kg.low - slack, found.mass_kg.high + slack);
        assert!(low <= mass && mass <= high, "{:?}", found.mass_kg);
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_interval_of_a_lag_that_is_not_there_holds_zero() {
    let ideal =
        MassDamperConfig::ideal(Kilograms(0.065), NewtonSecondsPerMetre(3.5), Seconds(1e-3));
    for plan in [short(), MeasurePlan::default()] {
        let found = found(&measured(&plan, ideal, Sensors::NONE), false);
        let [delay, lag] = [found.delay_s, found.current_lag_s];
        assert!(delay.covers(0.0) && lag.covers(0.0), "{delay:?} {lag:?}");
        assert!(lag.high < 1e-6, "{lag:?}");
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_hand_and_a_slope_are_found() {
    let held = MassDamperConfig {
        stiffness: NewtonsPerMetre(150.0),
        ..usual()
    };
    let plan = MeasurePlan {
        hand: true,
        ..short()
    };
    let mut device = Fine::new(held, 1);
    device.plant.set_external_force(Vector1::new(0.03));
    let driven = device.drive(&plan);
    let found = found(&driven.record, true);
    is_usual(&found);
    let hand = found.hand_stiffness_n_per_m.expect("looked for");
    assert!((hand.value / 150.0 - 1.0).abs() < 0.05, "{hand:?}");
    assert!(
        (found.bias_n.value - 0.03).abs() < 0.005,
        "{:?}",
        found.bias_n
    );
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn nothing_is_made_of_an_ideal_device() {
    let ideal = MassDamperConfig {
        friction: Newtons(0.0),
        delay: Seconds(0.0),
        current_lag: Seconds(0.0),
        ..usual()
    };
    // With longer samples the lag could be taken for the mass: a device of 0.1 mg moves alike within a tenth of a nanometre.
    for sample_time_s in [1e-3, 3e-3, 7e-3] {
        let plan = MeasurePlan {
            sample_time_s,
            ..short()
        };
        let ideal = MassDamperConfig {
            sample_time: Seconds(sample_time_s),
            ..ideal
        };
        let found = found(&measured(&plan, ideal, Sensors::NONE), false);
        let near = |have: f64, want: f64| (have / want - 1.0).abs() < 1e-4;
        assert!(near(found.mass_kg.value, 0.065), "{found:?}");
        assert!(near(found.damping_n_s_per_m.value, 3.5), "{found:?}");
        assert!(found.friction_n.value < 1e-3, "{found:?}");
        let late_s = found.delay_s.value + found.current_lag_s.value;
        assert!(late_s < 0.005 * sample_time_s, "{found:?}");
        assert!(
            found.encoder_resolution_m <= 0.0 && found.sensor_noise_m.value < 1e-7,
            "{found:?}"
        );
    }
}

#[test]
fn the_frequency_response_is_that_of_the_device_and_its_coherence_tells_friction() {
    let plan = MeasurePlan::default();
    let (delay, lag, mass, damping) = (1.3e-3, 0.5e-3, 0.065, 3.5);
    let lines = |friction| {
        let device = MassDamperConfig {
            friction: Newtons(friction),
            ..usual()
        };
        let record = Fine::new(device, 16).drive(&plan).record;
        response(&record, &plan)
    };
    let free = lines(0.0);
    assert_eq!(free.len(), 20);
    assert!(coherent(&free).count() >= 18, "{free:?}");
    for line in coherent(&free) {
        let s = Complex::new(0.0, line.omega_rad_s);
        let moves = s * (mass * s + damping) * (1.0 + lag * s);
        let want = (-delay * s).exp() / moves;
        let have = Complex::from_polar(line.gain, line.phase_deg.to_radians());
        let off = (have / want - 1.0).norm();
        let allowed = if line.omega_rad_s < 900.0 { 0.04 } else { 0.06 };
        assert!(off < allowed, "{off}: {line:?}");
    }
    // Without a jump by a turn.
    assert!(
        free.windows(2)
            .all(|pair| (pair[1].phase_deg - pair[0].phase_deg).abs() < 40.0)
    );
    // Rubbing follows the whole motion, so no line tells its own.
    let rubbing = lines(0.5);
    let coherence = |lines: &[crate::response::ResponseLine]| {
        (lines.iter()).fold(1.0, |least, line| f64::min(least, line.coherence))
    };
    assert!(coherence(&rubbing) < coherence(&free) - 0.02, "{rubbing:?}");
    // Of a short record no coherence is told.
    let short = Fine::new(usual(), 1).drive(&short()).record;
    assert!(response(&short, &plan).is_empty());
}

/// Why a motion is not used.
fn refusal(driven: &Driven, plan: &MeasurePlan) -> String {
    let refused = driven.outcome.require_complete(plan);
    refused.expect_err("refused").to_string()
}

#[test]
fn a_device_that_is_blocked_or_moves_by_itself_is_let_go_and_the_reason_said() {
    let plan = short();
    let blocked = MassDamperConfig {
        friction: Newtons(2.5),
        ..usual()
    };
    let driven = Fine::new(blocked, 1).drive(&plan);
    assert_eq!(driven.outcome, DriveOutcome::Blocked(None));
    assert_eq!(
        refusal(&driven, &plan),
        "the device does not move under 2 N, and the force is zero: free it, or give `force_limit_n` = 20"
    );

    let mut sliding = Fine::new(usual(), 1);
    sliding.plant.set_external_force(Vector1::new(0.5));
    let driven = sliding.drive(&plan);
    assert_eq!(driven.outcome, DriveOutcome::MovesByItself);
    assert!(driven.record.largest_force_n() <= 0.0);
    assert!(refusal(&driven, &plan).starts_with("the device moves by itself"));
}

#[test]
fn what_friction_holds_is_told_the_friction_and_a_force_that_moves_it() {
    let mut told = 0;
    for (mass, friction) in [
        (0.03, 0.05),
        (0.065, 0.05),
        (0.065, 0.3),
        (0.3, 0.3),
        (0.5, 1.0),
    ] {
        let device = MassDamperConfig {
            mass: Kilograms(mass),
            friction: Newtons(friction),
            ..usual()
        };
        for share in [1.05, 1.15, 1.3, 1.6, 2.0] {
            let mut plan = MeasurePlan {
                force_limit_n: 5.0 * share * friction,
                ..short()
            };
            loop {
                let driven = Fine::new(device, 4).drive(&plan);
                let DriveOutcome::Blocked(began_n) = driven.outcome else {
                    assert_eq!(
                        driven.outcome,
                        DriveOutcome::Complete,
                        "{mass} {friction} {share}"
                    );
                    break;
                };
                told += 1;
                let message = refusal(&driven, &plan);
                // It was told a force that is three times what it began to move at.
                assert!(plan.force_n() < 2.5 * friction, "{message}");
                let began = began_n.map_or(1.0, |began_n| began_n / friction);
                assert!(
                    (0.999..plan.force_n() / friction).contains(&began),
                    "{message}"
                );
                let (_, limit) = message
                    .split_once("give `force_limit_n` = ")
                    .expect("a force");
                plan.force_limit_n = limit.parse().expect("a number");
            }
        }
    }
    assert!(told > 2, "{told}");
    // Where the device's own limits are in the way, that is said too, and what is said helps.
    let rubbing = MassDamperConfig {
        friction: Newtons(0.3),
        ..usual()
    };
    let driven = |own| {
        let plan = MeasurePlan {
            force_limit_n: 6.0,
            ..short().within(own)
        };
        let driven = Fine::new(rubbing, 4).drive(&plan);
        (driven.outcome != DriveOutcome::Complete).then(|| refusal(&driven, &plan))
    };
    let none = OwnLimits::NONE;
    for (force_n, force_rate_n_per_s, words) in [
        (
            0.35,
            none.force_rate_n_per_s,
            "1.1 N instead of its own 350 mN",
        ),
        (none.force_n, 20.0, "120 N/s instead of its own 20 N/s"),
        (none.force_n, 120.0, ""),
    ] {
        let told = driven(OwnLimits {
            force_n,
            force_rate_n_per_s,
            ..none
        });
        let wanted = format!("the device {words} (`host-cli device set`)");
        match &told {
            None => assert_eq!(words, ""),
            Some(told) => assert!(told.ends_with(&wanted), "{told}"),
        }
    }
}

#[test]
fn a_device_that_counts_the_wrong_way_is_said_to_before_it_has_gone_far() {
    let mut reversed = Fine::new(usual(), 4);
    reversed.counts = -1.0;
    for own in [OwnLimits::NONE, beside_an_end()] {
        let plan = short().within(own);
        let driven = reversed.drive(&plan);
        assert!(
            matches!(driven.outcome, DriveOutcome::Against(_)),
            "{driven:?}"
        );
        let message = refusal(&driven, &plan);
        assert!(
            message.contains("moved against a force") && message.contains("swap"),
            "{message}"
        );
        let (low, high) = driven.record.reach_m();
        assert!(high - low < 1.5e-3, "{low} {high}");
    }
}

/// A workspace whose end is 2 mm from where the device is.
fn beside_an_end() -> OwnLimits {
    OwnLimits {
        workspace_m: [-0.02, 0.002],
        ..OwnLimits::NONE
    }
}

#[test]
fn a_device_is_measured_about_the_middle_of_its_box_and_the_box_is_within_its_workspace() {
    for friction in [0.0, 0.05, 0.3] {
        for (own, middle_m) in [(OwnLimits::NONE, 0.0), (beside_an_end(), -3e-3)] {
            let device = MassDamperConfig {
                friction: Newtons(friction),
                ..usual()
            };
            let plan = short().within(own);
            let driven = Fine::new(device, 4).drive(&plan);
            assert_eq!(
                driven.outcome,
                DriveOutcome::Complete,
                "{friction} {middle_m}"
            );
            let from_m = driven.record.position_m[driven.record.driven_from];
            assert!(
                (from_m - middle_m).abs() < 1e-3,
                "{friction}: from {from_m} m"
            );
            let mut positions = driven.record.position_m.iter();
            let [low, high] = [middle_m - 5e-3, middle_m + 5e-3];
            assert!(
                positions.all(|x| (low..=high).contains(x)),
                "{friction} {middle_m}"
            );
        }
    }
}

#[test]
fn a_device_that_flies_off_ends_in_a_fault_without_force_and_the_reason_said() {
    let plan = short();
    let light = MassDamperConfig {
        mass: Kilograms(0.002),
        damping: NewtonSecondsPerMetre(0.0),
        friction: Newtons(0.0),
        ..usual()
    };
    let driven = Fine::new(light, 1).drive(&plan);
    let DriveOutcome::Fault(fault) = driven.outcome else {
        panic!("{:?}", driven.outcome);
    };
    assert!(
        [Fault::Workspace, Fault::Velocity, Fault::PositionJump].contains(&fault),
        "{fault}"
    );
    let message = refusal(&driven, &plan);
    assert!(
        message.contains("the force is zero") && message.contains("smaller `force_limit_n`"),
        "{message}"
    );
}

#[test]
fn a_stop_lets_the_force_fall_to_zero() {
    static STOP: AtomicBool = AtomicBool::new(false);
    let mut stopped = Fine::new(usual(), 1);
    stopped.stop_after = Some((3000, &STOP));
    let driven = stopped.drive(&short());
    assert_eq!(driven.outcome, DriveOutcome::Interrupted);
    // 0.1 s of falling force and a tick.
    assert!(
        stopped.written_n.len() < 3105,
        "{}",
        stopped.written_n.len()
    );
}

#[test]
fn a_plan_outside_its_ranges_is_refused() -> Tested {
    for [line, want] in testkit::table(
        r#"
        force_limit_n = nan | force_limit_n = NaN is not
        box_m = -1 | box_m = -1 is not
        duration_s = 0.1 | duration_s = 0.1 is not
        sample_time_s = 1 | sample_time_s = 1 is not
        "#,
    ) {
        let document = Document::of_text(Path::new("m.toml"), &format!("[measure]\n{line}\n"));
        let parsed = document.parse()?;
        let table = parsed.one_of(&[MEASUREMENT], &[], "measurement", "");
        let table = table?.1.with_keys(&TABLES);
        let refused = MeasurePlan::read(&table?).expect_err(&want);
        let message = refused.to_string();
        assert!(
            message.starts_with(&format!("m.toml:2: {want}")),
            "{message}"
        );
    }
    Ok(())
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_device_file_says_what_was_measured_and_refuses_what_cannot_be() {
    let driven = Fine::new(usual(), 1).drive(&short());
    let found = found(&driven.record, false);
    let written = device_model(&found);
    let path = Path::new("lab/device.toml");
    let text = written.to_toml("a test", "on \"sim\"");
    assert!(
        text.ends_with("program = \"a test\"\nnote = 'on \"sim\"'\n"),
        "{text}"
    );
    let read = DeviceModel::parse(path, &text).expect("reads what it writes");
    assert_eq!(read, written);
    assert!((read.values.mass_kg / found.mass_kg.value - 1.0).abs() < 1e-5);
    let guarded = read.guarded();
    assert!(guarded.mass_kg.expect("known") <= read.values.mass_kg);
    let (least, most) = guarded.delay_s.expect("known");
    assert!(least <= read.values.delay_s && read.values.delay_s <= most);

    // `@` stands for the device.
    const DEVICE: &str = "[device]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\n";
    for [text, want] in testkit::table(
        r#"
        [device]\nmass_kg = -1\ndamping_n_s_per_m = 3.5\n | 2: mass_kg = -1 is not above 0
        [device]\nmass_kg = nan\ndamping_n_s_per_m = 3.5\n | 2: mass_kg = NaN is not above 0
        @delay_s = 1.3\n | 4: delay_s = 1.3 is not from 0 to 1: change it, or omit it for 0
        @friction_n = -0.1\n | 4: friction_n = -0.1 is not from 0 to 10000
        @sensor_noise_m = inf\n | 4: sensor_noise_m = inf is not from 0 to 0.001
        @[intervals]\nmass_kg = [0.07, 0.08]\n | 5: mass_kg = [0.07, 0.08] is not an interval
        @[intervals]\nmass_kg = [0.06]\n | 5: mass_kg has 1 numbers, not two
        @[intervals]\nmas_kg = [0.06, 0.07]\n | 5: unknown key `mas_kg` in [intervals]: did you mean `mass_kg`?
        [transfer_function]\nfunction = "1/(s+1)"\n | 1: no [device] in it
        [transfer_function]\nfunction = "1/(s+1)"\n[intervals]\n | 3: [intervals] belongs to a [device]
        "#,
    ) {
        let read = DeviceModel::parse(path, &text.replace('@', DEVICE));
        let message = read.expect_err(&want).to_string();
        let is_explained =
            message.starts_with(&format!("lab/device.toml:{want}")) && !message.contains('\n');
        assert!(is_explained, "{message}");
    }
}
