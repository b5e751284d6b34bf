//! The difference that a hand should feel between two laws, and between a law and the best spring and damper.
//!
//! ```text
//! d(ω) = max(|Re ΔH|, |Im ΔH|) / (W·max(|H|, F₀/a)),   H of the law that is named first, ΔH = H of the other less H
//! K*, B* ≥ 0 with the least maximum of d over the band
//! ```
//! - *H* is force per displacement at the hand, N/m, with device, hold and delay: [`ClosedLoop`](haptic_analysis::ClosedLoop).
//! - *A prediction*: a hand notices d > 1 if it tells a change of a share W of the force that it meets; F₀ is the least force that it feels,
//!   a its amplitude. Without them free air or a resonance would make any difference felt. The measure is not symmetric.
//! - *Spring and damper* act on the hand beside the device, exactly: real and imaginary part of ΔH depend on K* and on B* alone, so each is
//!   the middle of what intervals about the law have in common.
//!
//! Source: W. Fu, M. M. van Paassen, M. Mulder, *IEEE Trans. Human-Machine Systems* 48(4), 2018, for thresholds of this form.

use super::answer::{Analysed, DifferencePoint, Drawn, FREQUENCIES_MOST, logarithmic};
use super::felt::Felt;
use super::keys::{
    DIFFERENCE, FELT_HIGH, FELT_LOW, HAND_AMPLITUDE, LEAST_FORCE, OF_A_LAW, POINTS, TRANSPARENCY,
    WEBER_SHARE,
};
use crate::document::Document;
use crate::document::failure::Failure;
use crate::document::parameters::{LAW, OTHER_LAW, Parameter};
use crate::document::reader::Table;
use crate::experiment::reading::with_devices;
use crate::experiment::tables;
use crate::judge::rows;
use fracdiff::num_complex::Complex;
use serde_json::{Value, json};
use std::f64::consts::TAU;

/// Kinds of tables that have a law and its device.
const LAWS: [&str; 3] = ["wall", "analyze-transparency", "analyze-difference"];

/// Two laws, or one and the best spring and damper, for a hand.
#[derive(Clone, Debug)]
pub(crate) struct Difference {
    law: Felt,
    other: Option<Felt>,
    frequencies_hz: Vec<f64>,
    /// W.
    share: f64,
    /// F₀/a, N/m.
    least_n_per_m: f64,
}

impl Difference {
    pub(super) fn of(table: &Table<'_>) -> Result<Self, Failure> {
        let law = match of_file(table, &LAW)? {
            Some(law) => {
                let mut keys = OF_A_LAW.iter().flat_map(|keys| keys.1);
                if let Some(key) = keys.find(|key| table.has(key)) {
                    let reason = format!("{LAW} has its own: omit one of them");
                    return Err(table.fail_at(key.key, reason).into());
                }
                law
            }
            None => Felt::through_device(table)?,
        };
        let [low, high] = [table.number(&FELT_LOW)?, table.number(&FELT_HIGH)?];
        let other = of_file(table, &OTHER_LAW)?;
        let times = [&law].into_iter().chain(&other).map(Felt::sample_time_s);
        let most = times.map(|t| 0.5 / t).fold(f64::INFINITY, f64::min);
        if !(low < high && high <= most) {
            let reason = format!(
                "{low} to {high} Hz do not rise within {most} Hz, half the sample rate: change {FELT_LOW} or {FELT_HIGH}"
            );
            return Err(table.fail_at(FELT_HIGH.key, reason).into());
        }
        let count = table.count_in(&POINTS, 2..=FREQUENCIES_MOST)?;
        Ok(Self {
            law,
            other,
            frequencies_hz: logarithmic(low, high, count).collect(),
            share: table.number(&WEBER_SHARE)?,
            least_n_per_m: table.number(&LEAST_FORCE)? / table.number(&HAND_AMPLITUDE)?,
        })
    }

    pub(super) fn answer(&self) -> Result<Analysed, Failure> {
        let omegas: Vec<f64> = self.frequencies_hz.iter().map(|hz| TAU * hz).collect();
        let felt = |law: &Felt| -> Result<Vec<Complex<f64>>, Failure> {
            let felt = omegas.iter();
            felt.map(|omega| law.force_per_displacement(*omega))
                .collect()
        };
        let law = felt(&self.law)?;
        let other = self.other.as_ref().map(felt).transpose()?;
        // What a hand notices, N/m.
        let noticed: Vec<f64> = law
            .iter()
            .map(|h| self.share * h.norm().max(self.least_n_per_m))
            .collect();
        // The law without the device, which spring and damper have too.
        let rendered: Vec<Complex<f64>> = (law.iter().zip(&omegas))
            .map(|(h, omega)| h - self.law.of_device(*omega))
            .collect();
        let all = 0..law.len();
        let stiffness = nearest(all.clone().map(|n| (rendered[n].re, noticed[n])));
        let damping = nearest(
            all.clone()
                .map(|n| (rendered[n].im / omegas[n], noticed[n] / omegas[n])),
        );
        let points: Vec<DifferencePoint> = all
            .map(|n| {
                let replaced = Complex::new(stiffness, omegas[n] * damping) - rendered[n];
                let changed = other.as_ref().map(|other| other[n] - law[n]);
                DifferencePoint {
                    frequency_hz: self.frequencies_hz[n],
                    other_stiffness: changed.map(|changed| changed.re.abs() / noticed[n]),
                    other_damping: changed.map(|changed| changed.im.abs() / noticed[n]),
                    spring_and_damper_stiffness: replaced.re.abs() / noticed[n],
                    spring_and_damper_damping: replaced.im.abs() / noticed[n],
                }
            })
            .collect();
        let best = most(&points, |at| {
            Some([at.spring_and_damper_stiffness, at.spring_and_damper_damping])
        });
        let asked = json!({
            "weber_share": self.share,
            "least_felt_stiffness_n_per_m": self.least_n_per_m,
            "prediction": "a hand should notice a difference above 1; only an experiment tells whether it does",
        });
        let other = most(&points, |at| Some([at.other_stiffness?, at.other_damping?]));
        let found = json!({
            "other": other,
            "spring_and_damper": best,
            "best_stiffness_n_per_m": stiffness,
            "best_damping_n_s_per_m": damping,
        });
        Ok(Analysed {
            report: rows(self.law.asked().into_iter().chain([asked, found])),
            drawn: Some(Drawn::Difference(points)),
            about: format!(
                "{} · a hand that notices {} %",
                self.law.words(),
                100.0 * self.share
            ),
        })
    }
}

/// The law of the file that a key names.
fn of_file(table: &Table<'_>, key: &Parameter) -> Result<Option<Felt>, Failure> {
    let Some(path) = table.file(key)? else {
        return Ok(None);
    };
    let document = Document::read(&path)?;
    let parsed = document.parse()?;
    let words = format!("a law has one of [{}]", LAWS.join("], ["));
    let (kind, law, _) = parsed.one_of(&LAWS, &[], "law", &words)?;
    let keys = match kind {
        "analyze-transparency" => TRANSPARENCY,
        "analyze-difference" => DIFFERENCE,
        _ => tables(kind).unwrap_or_default(),
    };
    Felt::through_device(&with_devices(law.with_keys(keys)?)?).map(Some)
}

/// The number ≥ 0 whose largest |x − number|/w is least: the middle of what the intervals x ± t·w share at the least t.
fn nearest(places: impl Iterator<Item = (f64, f64)> + Clone) -> f64 {
    let pairs = places
        .clone()
        .flat_map(|a| places.clone().map(move |b| (a.0 - b.0) / (a.1 + b.1)));
    let below = places.clone().map(|(x, w)| -x / w);
    let least = pairs.chain(below).fold(0.0, f64::max);
    let low = places
        .clone()
        .map(|(x, w)| x - least * w)
        .fold(0.0, f64::max);
    let high = places
        .map(|(x, w)| x + least * w)
        .fold(f64::INFINITY, f64::min);
    (0.5 * (low + high)).max(0.0)
}

/// The largest difference, where it is, and in what; null without one.
fn most(points: &[DifferencePoint], parts: impl Fn(&DifferencePoint) -> Option<[f64; 2]>) -> Value {
    let all = points
        .iter()
        .filter_map(|at| Some((at.frequency_hz, parts(at)?)));
    let largest = all.max_by(|a, b| a.1[0].max(a.1[1]).total_cmp(&b.1[0].max(b.1[1])));
    largest.map_or(Value::Null, |(frequency_hz, [stiffness, damping])| {
        let difference = stiffness.max(damping);
        json!({
            "difference": difference,
            "felt": difference > 1.0,
            "frequency_hz": frequency_hz,
            "part": if stiffness >= damping { "stiffness" } else { "damping" },
        })
    })
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn the_nearest_number_is_between_two_by_their_weights_and_no_other_is_nearer() {
        let two = nearest([(1.0, 1.0), (4.0, 2.0)].into_iter());
        assert!((two - 2.0).abs() < 1e-12, "{two}");
        assert!(nearest([(-3.0, 1.0), (1.0, 1.0)].into_iter()).abs() < 1e-12);
        let mut seed = 1_u64;
        let mut draw = || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        for _ in 0..200 {
            let places: Vec<(f64, f64)> =
                (0..7).map(|_| (3.0 * draw() - 1.0, 0.1 + draw())).collect();
            let largest = |at: f64| {
                places
                    .iter()
                    .map(|(x, w)| (x - at).abs() / w)
                    .fold(0.0, f64::max)
            };
            let found = nearest(places.iter().copied());
            let others = (0..=4000).map(|n| largest(5e-4 * f64::from(n)));
            assert!(
                largest(found) <= others.fold(f64::INFINITY, f64::min) + 1e-12,
                "{places:?}"
            );
        }
    }
}
