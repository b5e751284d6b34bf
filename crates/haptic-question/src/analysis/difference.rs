//! The difference that a hand should feel between two laws, and between a law and the best spring and damper.
//!
//! ```text
//! d(ω) = max(|Re ΔH|, |Im ΔH|) / (W·max(|H|, F₀/a)),   H of the law that is named first, ΔH = H of the other less H
//! K*, B* ≥ 0 of the law K + B·D¹ with the least maximum of d over the band
//! ```
//! - *H* is force per displacement at the hand, N/m, with device, hold and delay: [`ClosedLoop`](haptic_analysis::ClosedLoop).
//! - *A prediction*: a hand notices d > 1 if it tells a change of a share W of the force that it meets; F₀ is the least force that it feels,
//!   a its amplitude. Without them free air or a resonance would make any difference felt. The measure is not symmetric.
//! - *Spring and damper* are entered as the law is: sampled by its scheme, held and delayed. So the best of a spring and damper is that law
//!   itself, and whether it can be rendered is judged with it.
//!
//! Source: W. Fu, M. M. van Paassen, M. Mulder, *IEEE Trans. Human-Machine Systems* 48(4), 2018, for thresholds of this form.

use crate::analysis::answer::{Analysed, DifferencePoint, Drawn, FREQUENCIES_MOST, logarithmic};
use crate::analysis::felt::Felt;
use crate::analysis::keys::{
    DIFFERENCE, FELT_HIGH, FELT_LOW, HAND_AMPLITUDE, LEAST_FORCE, OF_A_LAW, POINTS, TRANSPARENCY,
    WEBER_SHARE,
};
use fracdiff::num_complex::Complex;
use haptic_analysis::{WantedNumber, nearest};
use haptic_document::parameters::{LAW, OTHER_LAW, Parameter};
use haptic_document::{Failure, ReadDocument, Table, rows};
use haptic_trial::device_table::with_devices;
use haptic_trial::keys::wall::WALL_TABLES;
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
    /// W, the share of a force by which it must change to be felt.
    share: f64,
    /// F₀/a, N/m: it takes the place of a smaller |H|.
    least_n_per_m: f64,
}

impl Difference {
    pub(super) fn of(table: &Table<'_>, read: ReadDocument) -> Result<Self, Failure> {
        let law = match of_file(table, &LAW, read)? {
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
        let other = of_file(table, &OTHER_LAW, read)?;
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

    pub(crate) fn answer(&self) -> Result<Analysed, Failure> {
        let omegas: Vec<f64> = self.frequencies_hz.iter().map(|hz| TAU * hz).collect();
        let felt = |law: &Felt| -> Result<Vec<Complex<f64>>, Failure> {
            let felt = omegas.iter();
            felt.map(|omega| law.force_per_displacement(*omega))
                .collect()
        };
        let law = felt(&self.law)?;
        let other = self.other.as_ref().map(felt).transpose()?;
        // The least change that a hand notices, N/m.
        let noticed: Vec<f64> = law
            .iter()
            .map(|h| self.share * h.norm().max(self.least_n_per_m))
            .collect();
        let damper = self.law.damper()?;
        let rendered = omegas
            .iter()
            .map(|omega| self.law.rendered(&damper, *omega));
        let rendered = rendered.collect::<Result<Vec<_>, Failure>>()?;
        let wanted: Vec<WantedNumber> = (rendered.iter().zip(&noticed))
            .flat_map(|([law, spring, damper], weight)| {
                let row = |part: fn(&Complex<f64>) -> f64| WantedNumber {
                    parts: [part(spring), part(damper)],
                    value: part(law),
                    weight: *weight,
                };
                [row(|h| h.re), row(|h| h.im)]
            })
            .collect();
        let [stiffness, damping] = nearest(&wanted);
        let all = 0..law.len();
        let points: Vec<DifferencePoint> = all
            .map(|n| {
                let [entered, spring, damper] = rendered[n];
                let replaced = spring * stiffness + damper * damping - entered;
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
            // In the same loop; a law that cannot be rendered is no rival.
            "best_stable": self.law.bears(&damper, [stiffness, damping])?,
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
fn of_file(
    table: &Table<'_>,
    key: &Parameter,
    read: ReadDocument,
) -> Result<Option<Felt>, Failure> {
    let Some(path) = table.file(key)? else {
        return Ok(None);
    };
    let document = read(&path)?;
    let parsed = document.parse()?;
    let words = format!("a law has one of [{}]", LAWS.join("], ["));
    let (kind, law, _) = parsed.one_of(&LAWS, &[], "law", &words)?;
    let keys = match kind {
        "analyze-transparency" => TRANSPARENCY,
        "analyze-difference" => DIFFERENCE,
        _ => WALL_TABLES,
    };
    Felt::through_device(&with_devices(law.with_keys(keys)?)?).map(Some)
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
