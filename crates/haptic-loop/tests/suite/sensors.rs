//! The sensor wrappers around a simulated device.

use fracdiff::Seconds;
use haptic_loop::plant::{ForceSensor, ForceSensorConfig, MassDamper, Sensed};
use haptic_loop::units::{Metres, Newtons};
use nalgebra::Vector1;
use testkit::device::{ideal, plant, read, write};
use testkit::{assert_close, assert_refused, assert_relative};

/// A free mass of 1 kg, one tick a second.
fn free() -> MassDamper<1> {
    plant(ideal(1.0, 0.0, 1.0))
}

#[test]
fn an_encoder_reads_the_nearest_count() {
    let mut encoder = Sensed::new(free(), Metres(1e-3), Metres(0.0), 0).expect("valid");
    for (x, want) in [(0.4e-3, 0.0), (0.6e-3, 1e-3), (-2.6e-3, -3e-3)] {
        let device: &mut MassDamper<1> = encoder.device_mut();
        device.set_state(Vector1::new(x), Vector1::new(0.0));
        assert_close("count", read(&mut encoder).position_m[0], want, 0.0);
    }
    write(&mut encoder, 1.0);
    assert_eq!(read::<1>(&mut encoder).tick, 1, "a write goes through");
}

const FORCE_SENSOR: ForceSensorConfig = ForceSensorConfig {
    range: Newtons(5.0),
    noise: Newtons(0.0),
    lag: Seconds(0.01),
    offset: Newtons(0.25),
    seed: 1,
};

/// A step from rest: F·(1 − exp(−t/τ)) in the closed form of a first-order lag.
#[test]
fn a_force_sensor_lags_as_its_closed_form_and_ends_at_its_range() {
    let mut sensor = ForceSensor::new(FORCE_SENSOR, Seconds(1e-3)).expect("valid");
    for n in 1..=100 {
        let mut forces = [2.0, -3.0, 40.0];
        sensor.read(&mut forces);
        let share = 1.0 - (-f64::from(n) / 10.0).exp();
        for (have, force) in forces.into_iter().zip([2.0, -3.0, 40.0]) {
            let want = (0.25 + share * force).min(5.0);
            assert!((have - want).abs() < 1e-12, "{n}: {have} {want}");
        }
    }
}

#[test]
fn a_force_sensor_has_its_noise_and_cannot_be_beyond_its_range() {
    let noisy = ForceSensorConfig {
        noise: Newtons(0.1),
        ..FORCE_SENSOR
    };
    let mut sensor = ForceSensor::new(noisy, Seconds(1e-3)).expect("valid");
    let squares = (0..20_000).map(|_| {
        let mut force = [0.0];
        sensor.read(&mut force);
        (force[0] - 0.25).powi(2)
    });
    // Of 20 000 draws the deviation is known within 0.5 %.
    let deviation = (squares.sum::<f64>() / 20_000.0).sqrt();
    assert_relative("deviation", deviation, 0.1, 0.02);
    for (range, noise, lag, offset, word) in [
        (0.0, 0.0, 0.0, 0.0, "range"),
        (f64::INFINITY, 0.0, 0.0, 0.0, "range"),
        (5.0, -1.0, 0.0, 0.0, "noise"),
        (5.0, 0.0, f64::NAN, 0.0, "lag"),
        (5.0, 0.0, 0.0, -5.0, "offset"),
    ] {
        let config = ForceSensorConfig {
            range: Newtons(range),
            noise: Newtons(noise),
            lag: Seconds(lag),
            offset: Newtons(offset),
            seed: 1,
        };
        assert_refused(ForceSensor::new(config, Seconds(1e-3)), word);
    }
}

#[test]
fn sensor_noise_has_its_standard_deviation_and_its_seed() {
    let sample = |seed, deviation| {
        let mut noisy = Sensed::new(free(), Metres(0.0), Metres(deviation), seed).expect("valid");
        (0..10_000)
            .map(|_| read::<1>(&mut noisy).position_m[0])
            .collect::<Vec<f64>>()
    };
    let noise = sample(1, 2e-6);
    let mean = noise.iter().sum::<f64>() / 1e4;
    let variance = noise.iter().map(|x| x * x).sum::<f64>() / 1e4;
    // Four standard errors: σ/√n of the mean, σ/√(2n) of the deviation.
    assert_close("mean", mean, 0.0, 4.0 * 2e-6 / 100.0);
    assert_close("deviation", variance.sqrt(), 2e-6, 4.0 * 2e-6 / 141.0);
    assert_eq!(noise, sample(1, 2e-6));
    assert_ne!(noise, sample(2, 2e-6));
    assert!(
        sample(1, 0.0).iter().all(|x| x.to_bits() == 0),
        "σ = 0 is exact"
    );
}
