//! Records of more rows than a search begins with, whose plant is faster than every tenth of them tells.

use crate::fixture::{begun, record};
use control_identification::model_search::{Found, InputOutput};
use fractional_control::num_complex::Complex;
use std::f64::consts::{PI, TAU};
use testkit::{Random, assert_close};

const T: f64 = 1.0 / 610.0;
const HZ: f64 = 68.0;
const DAMPING: f64 = 0.05;
const PERIOD: usize = 1024;
const HIGHEST: usize = 341;

/// Odd harmonics up to 203 Hz with phases of their own, repeated.
fn multisine(rows: usize, random: &mut Random) -> Vec<f64> {
    let harmonics = (1..=HIGHEST).step_by(2);
    let waves: Vec<(f64, f64)> = harmonics
        .map(|harmonic| (harmonic as f64, random.between(-PI, PI)))
        .collect();
    let at = |n: usize| -> f64 {
        let turn = TAU * n as f64 / PERIOD as f64;
        let waves = waves.iter();
        waves
            .map(|(multiple, phase)| (multiple * turn + phase).cos())
            .sum()
    };
    let period: Vec<f64> = (0..PERIOD).map(at).collect();
    period.into_iter().cycle().take(rows).collect()
}

/// ω²/(s² + 2ζωs + ω²) behind the hold, as 2·Re of the mode of its pole p, r = ω²/(p − p̄); noise of such a share of the output's deviation upon it.
fn resonator(input: Vec<f64>, noise: f64, random: &mut Random) -> InputOutput {
    let omega = TAU * HZ;
    let pole = omega * Complex::new(-DAMPING, (1.0 - DAMPING * DAMPING).sqrt());
    let step = (pole * T).exp();
    let gain = (step - 1.0) / pole * omega * omega / Complex::new(0.0, 2.0 * pole.im);
    let mut mode = Complex::new(0.0, 0.0);
    let outputs = input.iter().map(|u| {
        let now = 2.0 * mode.re;
        mode = step * mode + gain * u;
        now
    });
    let mut output: Vec<f64> = outputs.collect();
    let squares: f64 = output.iter().map(|y| y * y).sum();
    let deviation = (squares / output.len() as f64).sqrt();
    for y in &mut output {
        *y += noise * deviation * random.between(-1.0, 1.0) * 3.0_f64.sqrt();
    }
    record(T, input, output)
}

fn best(record: &mut InputOutput) -> Found {
    let found = begun(record).expect("found");
    found.into_iter().next().expect("a function")
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_long_record_keeps_a_resonance_that_every_tenth_row_loses() {
    for rows in [8000, 20_000] {
        let mut random = Random(68);
        let input = multisine(rows, &mut random);
        let mut record = resonator(input, 0.01, &mut random);
        let found = best(&mut record);
        let identified = &found.identified;
        // All but the noise: of the variance that is 0.01².
        assert!(
            identified.fit > 0.9998,
            "{rows}: {} of {}",
            identified.fit,
            identified.function
        );
        let below = identified.function.denominator().terms();
        assert_eq!(below.len(), 3, "{}", identified.function);
        let omega = (below[2].coefficient / below[0].coefficient).sqrt();
        assert_close("ω", omega, TAU * HZ, TAU * HZ * 1e-3);
    }
}
