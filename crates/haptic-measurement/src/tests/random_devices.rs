//! Random simulated devices are measured, and what is found is held against what they are.
//!
//! `CAMPAIGN_CASES` sets how many; 10 unless it is given, 500 at night.

use super::measured;
use crate::{
    MeasurePlan,
    estimate::{Measured, MeasuredNumber, estimate},
};
use fracdiff::Seconds;
use haptic_loop::{
    plant::MassDamperConfig,
    units::{Kilograms, NewtonSecondsPerMetre, Newtons},
};
use haptic_trial::Sensors;
use rayon::prelude::*;
use testkit::Random;

/// A device, and what was found.
struct Case {
    number: u64,
    device: MassDamperConfig,
    sensors: Sensors,
    found: Measured,
}

/// Devices of 30 to 200 g, 1 to 8 N·s/m, with 0.02 to 0.2 N of friction, an encoder of 10 µm and up to 3 µm of noise; 0 to 3 samples of
/// delay, one in eight without; 0 to 3 ms of lag, one in eight without and one in four below 0.3 ms.
fn random_device(case: u64) -> (MassDamperConfig, Sensors) {
    let mut random = Random(0x6d65_6173 + 7919 * case);
    let t = 1e-3;
    let ideal = MassDamperConfig::ideal(
        Kilograms(random.log_between(0.03, 0.2)),
        NewtonSecondsPerMetre(random.log_between(1.0, 8.0)),
        Seconds(t),
    );
    let friction = Newtons(random.log_between(0.02, 0.2));
    let delay = random.between(0.0, 3.0);
    let most = random.one_of(&[0.0, 0.3e-3, 0.3e-3, 3e-3, 3e-3, 3e-3, 3e-3, 3e-3]);
    let device = MassDamperConfig {
        friction,
        delay: Seconds(if random.share() < 0.125 {
            0.0
        } else {
            t * delay
        }),
        current_lag: Seconds(random.between(0.0, most)),
        ..ideal
    };
    let sensors = Sensors {
        encoder_resolution_m: 10e-6,
        noise_m: random.between(0.0, 3e-6),
        seed: case,
    };
    (device, sensors)
}

fn measure(number: u64) -> Case {
    let (device, sensors) = random_device(number);
    let plan = MeasurePlan::default();
    let record = measured(&plan, device, sensors);
    assert!(record.largest_force_n() <= plan.force_n());
    let (low, high) = record.reach_m();
    assert!(-low <= plan.box_m && high <= plan.box_m);
    let found = estimate(&record, false).expect("finds it");
    Case {
        number,
        device,
        sensors,
        found,
    }
}

impl Case {
    /// Each number: what it is, and what was found.
    fn numbers(&self) -> [(&'static str, f64, MeasuredNumber); 7] {
        let Self {
            device,
            sensors,
            found,
            ..
        } = self;
        [
            ("mass", device.mass.0, found.mass_kg),
            ("damping", device.damping.0, found.damping_n_s_per_m),
            ("friction", device.friction.0, found.friction_n),
            ("delay", device.delay.0, found.delay_s),
            ("lag", device.current_lag.0, found.current_lag_s),
            ("noise", sensors.noise_m, found.sensor_noise_m),
            ("bias", 0.0, found.bias_n),
        ]
    }

    /// True if what is late is found within a tenth of a sample, or a sentence says that something is unsure.
    fn is_right(&self) -> bool {
        let found = self.found.delay_s.value + self.found.current_lag_s.value;
        let has = self.device.delay.0 + self.device.current_lag.0;
        (found - has).abs() < 1e-4 || !self.found.warnings.is_empty()
    }

    /// Off by more than three half-widths of its interval, and not a word of it.
    fn is_confidently_wrong(&self, truth: f64, found: MeasuredNumber) -> bool {
        let half = 0.5 * (found.high - found.low);
        (truth - found.value).abs() > 3.0 * half && self.found.warnings.is_empty()
    }
}

/// 93 to 97 % of so many. Of fewer than 500 chance takes its share: three standard deviations of a count.
fn is_as_promised(inside: usize, numbers: usize) -> bool {
    let (inside, numbers) = (inside as f64, numbers as f64);
    let chance = 3.0 * (0.95 * 0.05 * numbers).sqrt();
    let slack = if numbers < 500.0 {
        chance
    } else {
        0.02 * numbers
    };
    (inside - 0.95 * numbers).abs() <= slack
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn intervals_of_random_devices_hold_what_they_promise() {
    let cases: u64 = testkit::cases(10);
    let all: Vec<Case> = (0..cases).into_par_iter().map(measure).collect();
    let (mut inside, mut numbers, mut wrong) = (0, 0, 0);
    for index in 0..7 {
        let what = all[0].numbers()[index].0;
        let mut covered = 0;
        for case in &all {
            let (_, truth, found) = case.numbers()[index];
            let [low, value, high] = [found.low, found.value, found.high];
            let is_wrong = case.is_confidently_wrong(truth, found);
            wrong += usize::from(is_wrong);
            if found.covers(truth) {
                covered += 1;
            } else {
                let words = if is_wrong { ", without a word" } else { "" };
                println!(
                    "device {}: {what} {truth:.5e} found as {value:.5e}, {low:.5e} to {high:.5e}{words}",
                    case.number
                );
            }
        }
        println!("{what}: in its interval in {covered} of {cases}");
        // Of a number that cannot be below 0, and is none, all but one half of the rest are in it.
        assert!(
            covered as f64 >= 0.92 * cases as f64 - 2.0,
            "{what}: {covered} of {cases}"
        );
        inside += covered;
        numbers += all.len();
    }
    let warned = all.iter().filter(|case| !case.found.warnings.is_empty());
    let warned = warned.count();
    let late = all.iter().filter(|case| !case.is_right()).count();
    println!(
        "{inside} of {numbers} inside, {warned} of {cases} devices with a warning, {late} with another lateness"
    );
    // A warning is for few.
    assert!(
        20 * warned as u64 <= cases + 20,
        "{warned} of {cases} warned"
    );
    assert_eq!(
        late, 0,
        "devices whose lateness is off by a tenth of a sample"
    );
    assert_eq!(wrong, 0, "far outside their intervals, without a warning");
    assert!(is_as_promised(inside, numbers), "{inside} of {numbers}");
}
