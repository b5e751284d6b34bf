//! The sensor wrappers around a simulated device.

use fracdiff::Seconds;
use haptic_loop::plant::{MassDamper, MassDamperConfig, Sensed};
use haptic_loop::units::{Kilograms, Metres, NewtonSecondsPerMetre};
use nalgebra::Vector1;
use testkit::assert_close;
use testkit::device::{read, write};

/// A free mass of 1 kg, one tick a second.
fn plant() -> MassDamper<1> {
    let ideal = MassDamperConfig::ideal(Kilograms(1.0), NewtonSecondsPerMetre(0.0), Seconds(1.0));
    MassDamper::new(ideal).expect("valid")
}

#[test]
fn an_encoder_reads_the_nearest_count() {
    let mut encoder = Sensed::new(plant(), Metres(1e-3), Metres(0.0), 0).expect("valid");
    for (x, want) in [(0.4e-3, 0.0), (0.6e-3, 1e-3), (-2.6e-3, -3e-3)] {
        let device: &mut MassDamper<1> = encoder.device_mut();
        device.set_state(Vector1::new(x), Vector1::new(0.0));
        assert_close("count", read(&mut encoder).position_m[0], want, 0.0);
    }
    write(&mut encoder, 1.0);
    assert_eq!(read::<1>(&mut encoder).tick, 1, "a write goes through");
}

#[test]
fn sensor_noise_has_its_standard_deviation_and_its_seed() {
    let sample = |seed, deviation| {
        let mut noisy = Sensed::new(plant(), Metres(0.0), Metres(deviation), seed).expect("valid");
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
