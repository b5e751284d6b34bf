//! The report of a design.

mod said;

use super::super::draw::over_time;
use super::super::reports::{MarginReport, PidReport, ShapeReport};
use super::super::words::{decibel, in_degrees};
use fractional_control::PidParameters;
use fractional_control::design::{Candidate, ControlAnswer, ControlDesign, Trial, Wish, WishName};
use haptic_experiment::Failure;
use haptic_quantity::digits;
use serde::Serialize;
use std::f64::consts::LN_10;

/// Result of `control design`.
#[derive(Serialize)]
pub(super) struct Report {
    plant: String,
    sample_time_s: f64,
    scheme: String,
    controller: PidReport,
    specification: Vec<WishReport>,
    /// Null for a plant that was measured, which does not run, and where nothing is proved of the plant.
    stable: Option<bool>,
    /// Verdict and comparison in sentences.
    notes: Vec<String>,
    #[serde(flatten)]
    trial: Option<TrialReport>,
    integer: Option<IntegerReport>,
    integer_reason: Option<String>,
    step: Vec<Sample>,
    pub(super) controller_file: Option<String>,
    pub(super) files: Vec<String>,
}

/// A wish.
#[derive(Serialize)]
struct WishReport {
    name: &'static str,
    /// For people.
    #[serde(skip)]
    words: &'static str,
    wanted: f64,
    reached: f64,
    met: bool,
    integer_reached: Option<f64>,
}

/// The loop of a controller.
#[derive(Serialize)]
struct TrialReport {
    /// None of an unstable loop: they would mean nothing.
    margins: Option<MarginReport>,
    /// As in `analyze`.
    coarse: Option<f64>,
    /// The gains of the plant, over the nominal one, between which it is proved stable.
    stable_gain_low: Option<f64>,
    stable_gain_high: Option<f64>,
    /// They reach from half to double.
    robust: bool,
    /// The same of the rule that stands for the plant, whether or not that is proved of the plant.
    #[serde(skip)]
    stable_by_model: bool,
    #[serde(skip)]
    gains_by_model: Option<[f64; 2]>,
    #[serde(skip)]
    robust_by_model: bool,
    overshoot_spread: f64,
    robustness: Vec<GainReport>,
    shape: ShapeReport,
    limited_share: f64,
}

#[derive(Serialize)]
struct GainReport {
    gain_db: f64,
    stable: bool,
    shape: ShapeReport,
}

#[derive(Serialize)]
struct IntegerReport {
    controller: PidReport,
    stable: Option<bool>,
    #[serde(flatten)]
    trial: Option<TrialReport>,
}

#[derive(Serialize)]
struct Sample {
    time_s: f64,
    output: f64,
    command: f64,
}

/// Name and unit of a wish, and its value in that unit.
struct Row {
    key: &'static str,
    words: &'static str,
    in_unit: fn(f64) -> f64,
}

fn row(name: WishName) -> Row {
    let same: fn(f64) -> f64 = |value| value;
    let (key, words, in_unit): (_, _, fn(f64) -> f64) = match name {
        WishName::Crossover => ("crossover_rad_s", "crossover / rad/s", same),
        WishName::PhaseMargin => ("phase_margin_deg", "phase margin / °", f64::to_degrees),
        WishName::IsoDamping => (
            "phase_slope_deg_per_decade",
            "slope of the phase / °/decade",
            |slope| (slope * LN_10).to_degrees(),
        ),
        WishName::SensitivityPeak => ("sensitivity_peak", "largest |S|", same),
        WishName::ComplementaryPeak => ("complementary_peak", "largest |T|", same),
        WishName::Noise => ("noise", "|T| above the noise's frequency", same),
        _ => ("disturbance", "|S| below the disturbance's frequency", same),
    };
    Row {
        key,
        words,
        in_unit,
    }
}

fn trial_report(trial: &Trial, t: f64) -> TrialReport {
    let proved = trial.coarse.is_none();
    let proved_gains = trial.stable_gains.filter(|_| proved);
    TrialReport {
        margins: (proved && trial.verdict.stable).then(|| (&trial.margins).into()),
        coarse: trial.coarse,
        stable_by_model: trial.verdict.stable,
        gains_by_model: trial.stable_gains,
        robust_by_model: trial.is_robust(),
        stable_gain_low: proved_gains.map(|[low, _]| low),
        stable_gain_high: proved_gains.map(|[_, high]| high),
        robust: proved && trial.is_robust(),
        overshoot_spread: trial.overshoot_spread(),
        robustness: trial
            .robustness
            .iter()
            .map(|row| GainReport {
                gain_db: decibel(row.gain),
                stable: row.stable,
                shape: ShapeReport::new(&row.shape, t),
            })
            .collect(),
        shape: ShapeReport::new(&trial.shape, t),
        limited_share: trial.limited_share,
    }
}

fn pid_of(candidate: &Candidate) -> PidParameters {
    candidate.tuned.parameters
}

fn stable(candidate: &Candidate) -> Option<bool> {
    let proved = candidate
        .trial
        .as_ref()
        .filter(|trial| trial.coarse.is_none());
    proved.map(|trial| trial.verdict.stable)
}

fn reached(candidate: &Candidate, name: WishName) -> Option<f64> {
    let found = candidate.wishes.iter().find(|wish| wish.name == name);
    found.map(|wish| wish.reached)
}

impl Report {
    pub(super) fn new(plant_words: &str, design: &ControlDesign, answer: &ControlAnswer) -> Self {
        let (own, integer) = (&answer.fractional, answer.integer.as_ref());
        let t = design.sample_time.0;
        let wish = |wish: &Wish| {
            let row = row(wish.name);
            let integer = integer.ok().and_then(|other| reached(other, wish.name));
            WishReport {
                name: row.key,
                words: row.words,
                wanted: (row.in_unit)(wish.wanted),
                reached: (row.in_unit)(wish.reached),
                met: wish.is_met(),
                integer_reached: integer.map(row.in_unit),
            }
        };
        let report = |candidate: &Candidate| {
            let trial = candidate.trial.as_ref();
            trial.map(|trial| trial_report(trial, t))
        };
        let step = own.trial.as_ref().map(|trial| &trial.step);
        let samples = step.map(|step| {
            let output = over_time(&step.measured, t);
            let rows = output.into_iter().zip(&step.command);
            let rows = rows.map(|((time_s, output), command)| Sample {
                time_s,
                output,
                command: *command,
            });
            rows.collect()
        });
        let mut report = Self {
            plant: plant_words.to_owned(),
            sample_time_s: t,
            scheme: design.scheme.to_string(),
            controller: pid_of(own).into(),
            specification: own.wishes.iter().map(wish).collect(),
            trial: report(own),
            stable: stable(own),
            integer: integer.ok().map(|other| IntegerReport {
                controller: pid_of(other).into(),
                trial: report(other),
                stable: stable(other),
            }),
            integer_reason: (integer.err()).map(in_degrees),
            step: samples.unwrap_or_default(),
            notes: Vec::new(),
            controller_file: None,
            files: Vec::new(),
        };
        report.notes = report.sentences();
        report
    }

    /// Wishes that are not met, and a loop that is not robust, for the controller file.
    pub(super) fn note(&self) -> String {
        let unmet = Some(self.unmet()).filter(|unmet| !unmet.is_empty());
        let parts = unmet.map(|unmet| format!("not met: {unmet}"));
        let parts: Vec<String> = parts.into_iter().chain(self.fragile()).collect();
        parts.join("; ")
    }

    /// Which wishes are missed, and by how much.
    fn unmet(&self) -> String {
        let missed = self.specification.iter().filter(|wish| !wish.met);
        let words = missed.map(|wish| {
            let (wanted, reached) = (digits(wish.wanted, 4), digits(wish.reached, 4));
            let by = if wish.wanted == 0.0 {
                String::new()
            } else {
                let share = 100.0 * (wish.reached / wish.wanted - 1.0);
                format!(" ({share:+.0} %)")
            };
            format!("{} {reached} instead of {wanted}{by}", wish.words)
        });
        words.collect::<Vec<_>>().join(", ")
    }

    /// The end of the command: an error if a wish is not met, or the loop is not stable.
    pub(super) fn judge(&self) -> Result<(), Failure> {
        if self.trial.as_ref().is_some_and(|own| !own.stable_by_model) {
            return Err(Failure::Run(anyhow::anyhow!(
                "the loop is not stable: lower --crossover or shorten --sample-time"
            )));
        }
        let unmet = self.unmet();
        if unmet.is_empty() {
            return Ok(());
        }
        let flat = row(WishName::IsoDamping).key;
        let is_flat = self.specification.iter().any(|wish| wish.name == flat);
        let remedies = if is_flat {
            "move --crossover, change --phase-margin, or give --not-flat"
        } else {
            "move --crossover, or change --phase-margin"
        };
        Err(Failure::Run(anyhow::anyhow!(
            "not met: {unmet}; this is the best found: allow more, {remedies}"
        )))
    }
}
