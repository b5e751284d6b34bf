//! Benches in virtual time: a device on a scale, or under a weight, and somebody who reads in whole grams.
//!
//! `CAMPAIGN_CASES` sets how many; 4 unless it is given, 40 at night.

use super::*;
use crate::question::calibration::CalibrationStep;
use crate::question::calibration::conduct::Axis;
use crate::question::measurement::MeasuredAxis;
use crate::question::measurement::drive::DriveError;
use fracdiff::Seconds;
use haptic_loop::plant::{ForceSensor, ForceSensorConfig, MassDamper, MassDamperConfig};
use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre, Newtons};
use haptic_loop::{Device, Reading, SafeForce};
use nalgebra::Vector1;
use std::convert::Infallible;
use std::path::Path;
use std::sync::Mutex;
use std::task::Poll;
use testkit::Random;

/// Steps of the plant in a millisecond.
const PARTS: u32 = 20;

/// A handle whose motor makes g newtons for one, above a scale that resists, or with a weight that a stop holds.
struct Bench<'a> {
    plant: MassDamper<1>,
    scale_n_per_m: f64,
    hung_n: f64,
    sensor: (ForceSensor, f64),
    /// On the scale now, N.
    shown_n: &'a Mutex<f64>,
    sensed_n: f64,
    largest_n: f64,
    tick: u64,
}

/// Stop below a hung weight, N/m.
const STOP: f64 = 2e4;

impl Bench<'_> {
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

impl Device<f64, 1> for Bench<'_> {
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

impl Axis for Bench<'_> {
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

fn calibrator(made: Made, weight_kg: Option<f64>) -> Calibrator {
    Calibrator {
        plan: MeasurePlan {
            force_limit_n: made.force_n / MeasurePlan::SHARE,
            box_m: 0.05,
            axis: MeasuredAxis::default(),
            ..MeasurePlan::default()
        },
        remote: None,
        model: None,
        weight_n: weight_kg.map(|kg| GRAVITY * kg),
        step_n: if weight_kg.is_some() {
            0.0
        } else {
            1e-3 * GRAVITY
        },
        readings: Vec::new(),
    }
}

/// The sign, then the readings.
fn calibrated(made: Made, weight_kg: Option<f64>) -> Result<CalibrationReport, Failure> {
    let calibrator = calibrator(made, weight_kg);
    let shown_n = Mutex::new(0.0);
    let bench = |hung_n: f64, scale_n_per_m: f64| {
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
        Bench {
            plant: MassDamper::new(config).expect("a plant"),
            scale_n_per_m,
            hung_n,
            sensor: (
                ForceSensor::new(sensor, Seconds(1e-3)).expect("a sensor"),
                made.sensor_gain,
            ),
            shown_n: &shown_n,
            sensed_n: f64::NAN,
            largest_n: 0.0,
            tick: 0,
        }
    };
    let (plan, stop) = (&calibrator.plan, AtomicBool::new(false));
    fn said<T>(ended: Result<T, DriveError<Infallible>>) -> Result<T, Failure> {
        ended.map_err(|error| match error {
            DriveError::Said(failure) => failure,
            DriveError::Plan(error) => Failure::input(error),
            DriveError::Device(never) => match never {},
        })
    }
    let mut free = bench(0.0, 0.0);
    let idle = held(plan, &mut free, &stop, |handle| {
        handle.goes_with_its_force()
    });
    let mut found = Found {
        idle: said(idle)?,
        ..Found::default()
    };
    let mut answer = |_: &CalibrationStep| {
        // Whole grams.
        let grams = *shown_n.lock().expect("no panic") / GRAVITY * 1e3;
        Poll::Ready(Ok(grams.round() * 1e-3 * GRAVITY))
    };
    let mut answers = Answers(&mut answer, &stop);
    match calibrator.weight_n {
        None => {
            let mut bench = bench(0.0, made.scale_n_per_m);
            let read = held(plan, &mut bench, &stop, |handle| {
                handle.reads(&mut answers, calibrator.step_n)
            });
            (found.points, found.lag_s) = said(read)?;
            assert!(bench.largest_n <= made.force_n, "{made:?}");
        }
        Some(weight_n) => {
            for hung_n in [0.0, weight_n] {
                let lifted = held(plan, &mut bench(hung_n, 0.0), &stop, |handle| {
                    handle.lifts(hung_n)
                });
                found.points.extend(said(lifted)?);
            }
        }
    }
    calibrator.report(found, &|_| ())
}

fn has(estimate: Estimate, truth: f64) -> bool {
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
        match calibrated(made, None) {
            Err(failure) => assert!(
                made.gain < 0.0 && failure.to_string() == WRONG_SIGN,
                "{made:?}: {failure}"
            ),
            Ok(report) => {
                assert!(made.gain > 0.0, "{made:?}: {report:?}");
                let known = report.calibration;
                judged += 1;
                within += usize::from(has(known.motor(), made.gain));
                assert!(known.motor().relative() < 0.5, "{made:?}: {known:?}");
                // The offset is in the sensor's own newtons, and its factor undoes its gain.
                let sensor = known.sensor_factor.expect("a sensor");
                assert!(
                    (sensor.value * made.sensor_gain - 1.0).abs() < 0.05,
                    "{made:?}: {known:?}"
                );
                if let Some(lag) = known.sensor_lag_s {
                    (lags, in_lag) = (lags + 1, in_lag + usize::from(has(lag, made.lag_s)));
                }
                println!(
                    "{made:?} {:?} {:?} {:?}",
                    known.motor_factor, known.sensor_offset_n, known.sensor_lag_s
                );
            }
        }
    }
    println!("{within} of {judged} gains in their intervals, {in_lag} of {lags} lags");
    assert!(20 * within >= 19 * judged, "{within} of {judged}");
    assert!(20 * in_lag >= 18 * lags, "{in_lag} of {lags}");
}

#[test]
fn a_weight_that_is_lifted_gives_the_gain_without_anybody_who_reads() {
    for (gain, weight_kg) in [(0.5, 0.05), (1.7, 0.2)] {
        let made = Made { gain, ..USUAL };
        let report = calibrated(made, Some(weight_kg)).expect("lifts");
        let motor = report.calibration.motor();
        assert!(has(motor, gain) && motor.relative() < 0.1, "{motor:?}");
        assert!(report.friction_n > made.friction_n);
    }
    let heavy = calibrated(USUAL, Some(0.5))
        .expect_err("5 N by 2 N at half the gain")
        .to_string();
    assert!(
        heavy.contains("does not lift within 2 N: hang less"),
        "{heavy}"
    );
    let swapped = calibrated(
        Made {
            gain: -1.0,
            ..USUAL
        },
        Some(0.1),
    )
    .expect_err("swapped")
    .to_string();
    assert_eq!(swapped, WRONG_SIGN);
    let sensor = calibrated(
        Made {
            sensor_gain: -1.0,
            ..USUAL
        },
        None,
    )
    .expect_err("swapped")
    .to_string();
    assert!(
        sensor.starts_with("the force sensor shows the opposite"),
        "{sensor}"
    );
}

#[test]
fn a_calibration_is_kept_in_the_device_file_whose_mass_was_in_newtons_of_the_device() {
    let path = Path::new("device.toml");
    let before = "[device]\nmass_kg = 0.13\ndamping_n_s_per_m = 7.0\nfriction_n = 0.1\ndelay_s = 0.001\n[intervals]\nmass_kg = [0.12, 0.14]\n";
    let device = DeviceModel::parse(path, before).expect("a device");
    let calibration = Calibration {
        date: "2026-11-29".to_owned(),
        motor_factor: Some(Estimate {
            value: 0.5,
            low: 0.45,
            high: 0.55,
        }),
        sensor_lag_s: Some(Estimate::about(1e-3, 1e-4)),
        ..Calibration::default()
    };
    let text = device.calibrated(calibration.clone()).to_toml("test", "");
    let read = DeviceModel::parse(path, &text).expect("reads what it writes");
    assert_eq!(read.calibration, Some(calibration.clone()));
    let values = read.values;
    let want = [0.065, 3.5, 0.05, 1e-3];
    let have = [
        values.mass_kg,
        values.damping_n_s_per_m,
        values.friction_n,
        values.delay_s,
    ];
    assert!(
        have.iter()
            .zip(want)
            .all(|(have, want)| (have / want - 1.0).abs() < 1e-12),
        "{have:?}"
    );
    assert!(
        (read.intervals[0].low - 0.054).abs() < 1e-12
            && (read.intervals[0].high - 0.077).abs() < 1e-12
    );
    // The same again changes nothing: the values are in true newtons.
    let again = read.clone().calibrated(calibration).values;
    assert!((again.mass_kg - 0.065).abs() < 1e-12);
    for (table, want) in [
        (
            "motor_factor = [0.5, 0.6]",
            "is not three numbers, the lowest, the likeliest and the highest",
        ),
        ("motor_factor = [0.5, 0.4, 0.6]", "is not three numbers"),
        ("motor_factor = [0.01, 0.4, 0.6]", "from 0.05 to 20"),
        ("sensor_lag = 1", "unknown key `sensor_lag`"),
    ] {
        let text = format!("{before}[calibration]\ndate = \"2026-11-29\"\n{table}\n");
        let error = DeviceModel::parse(path, &text)
            .expect_err(table)
            .to_string();
        assert!(error.contains(want), "{error}");
    }
    let words = Calibration::in_words(read.calibration.as_ref());
    assert_eq!(
        words,
        "calibrated on 2026-11-29: motor factor 0.5 (0.45 to 0.55), sensor lag 1 ms (900 µs to 1.1 ms)"
    );
    assert!(Calibration::in_words(None).starts_with("never calibrated"));
}
