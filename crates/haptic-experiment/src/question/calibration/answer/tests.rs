//! Benches in virtual time: a device on a scale, or under a weight, and somebody who reads in whole grams.
//!
//! `CAMPAIGN_CASES` sets how many; 4 unless it is given, 40 at night.

use super::*;
use crate::question::calibration::conduct::Axis;
use fracdiff::Seconds;
use haptic_loop::{
    Device, Reading, SafeForce,
    plant::{ForceSensor, ForceSensorConfig, MassDamper, MassDamperConfig},
    units::{Kilograms, NewtonSecondsPerMetre, Newtons},
};
use haptic_measurement::drive::DriveError;
use nalgebra::Vector1;
use std::{
    convert::Infallible,
    path::Path,
    sync::{Arc, Mutex},
};
use testkit::Random;

/// Steps of the plant in a millisecond.
const PARTS: u32 = 20;

/// A handle whose motor makes g newtons for one, above a scale that resists, or with a weight that a stop holds.
struct Board {
    plant: MassDamper<1>,
    scale_n_per_m: f64,
    hung_n: f64,
    sensor: (ForceSensor, f64),
    /// Force on the scale now, N.
    shown_n: Arc<Mutex<f64>>,
    sensed_n: f64,
    largest_n: f64,
    tick: u64,
}

/// Stop below a hung weight, N/m.
const STOP: f64 = 2e4;

impl Board {
    fn outside_n(&self) -> f64 {
        let x = self.plant.position()[0];
        let stop = if self.hung_n > 0.0 {
            STOP * (-x).max(0.0)
        } else {
            0.0
        };
        stop - self.hung_n - self.scale_n_per_m * x.max(0.0)
    }
}

impl Device<f64, 1> for Board {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<f64, 1>, Infallible> {
        let mut sensed = [self.outside_n()];
        *self.shown_n.lock().expect("no panic") = 0.0 - sensed[0];
        let (sensor, gain) = &mut self.sensor;
        sensor.read(&mut sensed);
        self.sensed_n = *gain * sensed[0];
        // 10 µm of encoder.
        let counts = (self.plant.position()[0] * 1e5).round();
        Ok(Reading {
            tick: self.tick,
            time_s: self.tick as f64 * 1e-3,
            position_m: Vector1::new(counts / 1e5),
        })
    }

    fn write(&mut self, force: SafeForce<f64, 1>) -> Result<(), Infallible> {
        for _ in 0..PARTS {
            self.plant.set_external_force([self.outside_n()].into());
            self.plant.write(force)?;
        }
        self.tick += 1;
        self.largest_n = self.largest_n.max(force.newtons()[0].abs());
        Ok(())
    }
}

impl Axis for Board {
    fn forces_n(&self, sent: f64) -> [f64; 2] {
        [sent, self.sensed_n]
    }
}

/// What a bench is.
#[derive(Clone, Copy, Debug)]
struct Made {
    gain: f64,
    friction_n: f64,
    lag_s: f64,
    sensor_gain: f64,
    offset_n: f64,
    scale_n_per_m: f64,
    force_n: f64,
}

const USUAL: Made = Made {
    gain: 0.5,
    friction_n: 0.05,
    lag_s: 2e-3,
    sensor_gain: 1.1,
    offset_n: 0.2,
    scale_n_per_m: 2e4,
    force_n: 2.0,
};

fn board(made: &Made, shown_n: &Arc<Mutex<f64>>, hung_n: f64, scale_n_per_m: f64) -> Board {
    let ideal = MassDamperConfig::ideal(
        Kilograms(0.065 + hung_n / GRAVITY),
        NewtonSecondsPerMetre(3.5),
        Seconds(1e-3 / f64::from(PARTS)),
    );
    let config = MassDamperConfig {
        gain: made.gain,
        friction: Newtons(made.friction_n),
        current_lag: Seconds(0.5e-3),
        ..ideal
    };
    let sensor = ForceSensorConfig {
        range: Newtons(100.0),
        noise: Newtons(1e-3),
        lag: Seconds(made.lag_s),
        offset: Newtons(made.offset_n),
        seed: 1,
    };
    let sensor = ForceSensor::new(sensor, Seconds(1e-3)).expect("a sensor");
    Board {
        plant: MassDamper::new(config).expect("a plant"),
        scale_n_per_m,
        hung_n,
        sensor: (sensor, made.sensor_gain),
        shown_n: Arc::clone(shown_n),
        sensed_n: f64::NAN,
        largest_n: 0.0,
        tick: 0,
    }
}

/// The tasks of a calibration, one after another, by somebody who reads whole grams.
fn calibrated(made: Made, weight: &str) -> Result<CalibrationReport, Failure> {
    let file = DeviceModel::find(Path::new("laboratory")).expect("built in");
    let text = format!(
        "[calibrate]\ndevice = \"serial:none\"\ndevice_model = \"laboratory\"\nforce_limit_n = {:?}\nbox_m = 0.05\n{weight}",
        made.force_n / MeasurePlan::SHARE
    );
    let document = Document::of_text(Path::new("bench.toml"), &text);
    let calibrator = Calibrator::open(&document).expect("valid");
    assert_eq!(calibrator.model, file);
    let shown_n = Arc::new(Mutex::new(0.0));
    let seen = Arc::clone(&shown_n);
    let person: Person = Arc::new(move |_, _| {
        let grams = *seen.lock().expect("no panic") / GRAVITY * 1e3;
        Ok(grams.round() * 1e-3 * GRAVITY)
    });
    let bench = Bench {
        plan: calibrator.plan,
        person: &person,
        step_n: calibrator.step_n,
        stop: &AtomicBool::new(false),
    };
    let mut found = Found::default();
    for (_, task) in calibrator.tasks() {
        let scale_n_per_m = task.map_or(made.scale_n_per_m, |_| 0.0);
        let mut board = board(&made, &shown_n, task.unwrap_or(0.0), scale_n_per_m);
        let ended = done(&bench, &mut board, task, &mut found);
        assert!(board.largest_n <= made.force_n, "{made:?}");
        ended.map_err(|error| match error {
            DriveError::Said(failure) => failure,
            DriveError::Plan(error) => Failure::input(error),
            DriveError::Device(never) => match never {},
        })?;
    }
    calibrator.report("bench".to_owned(), found, &|_| ())
}

fn has(estimate: MeasuredNumber, truth: f64) -> bool {
    (estimate.low..=estimate.high).contains(&truth)
}

/// The figure that has to be reached: the gain is within its interval in 38 of 40, a wrong sign is always said.
#[test]
fn the_gain_of_made_benches_lies_in_its_interval_and_a_wrong_sign_is_said() {
    let cases = testkit::cases(4);
    let mut random = Random(82);
    let (mut judged, mut within, mut lags, mut in_lag) = (0, 0, 0, 0);
    for case in 0..cases {
        let size = random.log_between(0.3, 3.0);
        let made = Made {
            gain: if case % 4 == 3 { -size } else { size },
            friction_n: random.between(0.0, 0.3),
            lag_s: random.between(0.0, 12e-3),
            sensor_gain: random.between(0.8, 1.2),
            offset_n: random.between(-0.3, 0.3),
            scale_n_per_m: random.log_between(2e3, 5e4),
            force_n: random.between(2.0, 8.0),
        };
        match calibrated(made, "") {
            Err(failure) => assert!(
                made.gain < 0.0 && failure.to_string().contains("moved against a force"),
                "{made:?}: {failure}"
            ),
            Ok(report) => {
                assert!(made.gain > 0.0, "{made:?}: {report:?}");
                let known = report.calibration;
                judged += 1;
                within += usize::from(has(known.factor(&MOTOR_FACTOR), made.gain));
                assert!(
                    known.factor(&MOTOR_FACTOR).relative() < 0.5,
                    "{made:?}: {known:?}"
                );
                // The offset is in the sensor's own newtons, and its factor undoes its gain.
                let sensor = known.found[SENSOR_FACTOR.key];
                assert!(
                    (sensor.value * made.sensor_gain - 1.0).abs() < 0.05,
                    "{made:?}: {known:?}"
                );
                if let Some(&lag) = known.found.get(SENSOR_LAG.key) {
                    (lags, in_lag) = (lags + 1, in_lag + usize::from(has(lag, made.lag_s)));
                }
                println!("{made:?} {:?}", known.found);
            }
        }
    }
    println!("{within} of {judged} gains in their intervals, {in_lag} of {lags} lags");
    assert!(20 * within >= 19 * judged, "{within} of {judged}");
    assert!(20 * in_lag >= 18 * lags, "{in_lag} of {lags}");
}

#[test]
fn a_weight_that_is_lifted_gives_the_gain_without_anybody_who_reads() {
    for (gain, weight) in [(0.5, "weight_kg = 0.05"), (1.7, "weight_kg = 0.2")] {
        let report = calibrated(Made { gain, ..USUAL }, weight).expect("lifts");
        let motor = report.calibration.factor(&MOTOR_FACTOR);
        assert!(has(motor, gain) && motor.relative() < 0.1, "{motor:?}");
    }
    let swapped = Made {
        gain: -1.0,
        ..USUAL
    };
    let turned = Made {
        sensor_gain: -1.0,
        ..USUAL
    };
    for (made, weight, want) in [
        // 5 N by 2 N at half the gain.
        (
            USUAL,
            "weight_kg = 0.5",
            "does not lift within 2 N: free it, hang less",
        ),
        (swapped, "weight_kg = 0.1", "moved against a force"),
        (turned, "", "the force sensor shows the opposite"),
        (
            turned,
            "weight_kg = 0.05",
            "the force sensor shows the opposite",
        ),
        (
            Made {
                gain: 0.02,
                ..USUAL
            },
            "",
            "does not lift within",
        ),
    ] {
        let error = calibrated(made, weight).expect_err(want).to_string();
        assert!(error.contains(want), "{error}");
    }
}

#[test]
fn a_calibration_is_kept_in_the_device_file_whose_mass_was_in_newtons_of_the_device() {
    let path = Path::new("device.toml");
    let before = "[device]\nmass_kg = 0.13\ndamping_n_s_per_m = 7.0\nfriction_n = 0.1\ndelay_s = 0.001\n[intervals]\nmass_kg = [0.12, 0.14]\n";
    let device = DeviceModel::parse(path, before).expect("a device");
    let newton = MeasuredNumber::about(0.5, 0.05);
    let calibration = Calibration {
        date: "2026-11-29".to_owned(),
        device: "one".to_owned(),
        found: [
            (MOTOR_FACTOR.key, newton),
            (SENSOR_LAG.key, MeasuredNumber::about(1e-3, 1e-4)),
        ]
        .into(),
    };
    let text = device
        .calibrated(newton, calibration.clone())
        .to_toml("test", "");
    let read = DeviceModel::parse(path, &text).expect("reads what it writes");
    assert_eq!(read.calibration, Some(calibration));
    let values = read.values;
    let [interval] = &read.intervals[..] else {
        panic!("one interval");
    };
    for (have, want) in [
        (values.mass_kg, 0.065),
        (values.damping_n_s_per_m, 3.5),
        (values.friction_n, 0.05),
        (values.delay_s, 1e-3),
        (interval.low, 0.054),
        (interval.high, 0.077),
    ] {
        assert!((have / want - 1.0).abs() < 1e-12, "{have} {want}");
    }
    for [table, want] in testkit::table(
        r#"
        motor_factor = [0.5, 0.6] | is not three numbers, the lowest, the likeliest and the highest
        motor_factor = [0.5, 0.4, 0.6] | is not three numbers
        motor_factor = [0.01, 0.4, 0.6] | from 0.05 to 20
        sensed_lag = 1 | unknown key `sensed_lag`
        "#,
    ) {
        let text = format!("{before}[calibration]\ndate = \"2026-11-29\"\n{table}\n");
        let error = DeviceModel::parse(path, &text)
            .expect_err(&table)
            .to_string();
        assert!(error.contains(&want), "{error}");
    }
    assert_eq!(
        Calibration::in_words(read.calibration.as_ref()),
        "calibrated on 2026-11-29: motor factor 0.5 (0.45 to 0.55), sensed lag 1 ms (900 µs to 1.1 ms)"
    );
    assert!(Calibration::in_words(None).starts_with("never calibrated"));
}
