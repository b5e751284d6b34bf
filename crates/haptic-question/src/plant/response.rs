//! A plant from its frequency response, as an impedance is measured, and the report on it.

use super::keys::{MODEL, PLANT_COLUMNS};
use super::report::{CandidateRow, DIGITS, NumberRow, shown};
use control_identification::{
    DeadTime, IdentifiedResponse, identify_response, kramers_kronig, search_response,
};
use fractional_control::{ControlError, SumOfParts};
use haptic_document::Failure;
use haptic_quantity::digits;
use haptic_trial::advice::refused;
use haptic_trial::plant_file::{MeasuredPoints, function_file};
use num_complex::Complex;
use serde::Serialize;
use std::f64::consts::TAU;

/// The report. The keys are a contract of the command line.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ResponseReport {
    /// The function in notation, as the sum of its parts, without its dead time.
    pub function: String,
    /// The dead time that was found or given.
    pub delay_s: f64,
    /// Frequencies fitted, without those of too low a coherence.
    pub frequencies: usize,
    /// The lowest frequency that was fitted.
    pub lowest_frequency_hz: f64,
    /// The highest frequency that was fitted.
    pub highest_frequency_hz: f64,
    /// Root mean square of what the function leaves of a part of the response, over the size of that.
    pub relative_residual: f64,
    /// Schwarz's criterion: the lower, the better.
    pub bic: f64,
    /// True if the response can be of a linear, steady system, by Kramers' and Kronig's relations; null where that is not tested.
    pub kramers_kronig: Option<bool>,
    /// The residual of a positive spectrum, or why it is not tested.
    pub kramers_kronig_reason: String,
    /// The numbers of the function.
    pub numbers: Vec<NumberRow>,
    /// Functions that fit, the chosen one first.
    pub candidates: Vec<CandidateRow>,
    /// Sentences that one should read.
    pub warnings: Vec<String>,
}

/// A plant that was found in a frequency response.
#[derive(Clone, Debug)]
pub struct ResponseAnswer {
    /// Function and parts, and how certain they are, with warnings.
    pub report: ResponseReport,
    /// ω in rad/s and the response.
    pub points: Vec<(f64, Complex<f64>)>,
    best: IdentifiedResponse,
}

impl ResponseAnswer {
    /// The function, its numbers with five digits.
    #[must_use]
    pub fn function(&self) -> String {
        shown(self.best.sum.parts(), 5)
    }

    /// The response of the function at the same frequencies.
    #[must_use]
    pub fn model(&self) -> &[Complex<f64>] {
        &self.best.model
    }

    /// The plant file: what was found in the response of this name, by this program.
    #[must_use]
    pub fn to_toml(&self, program: &str, name: &str) -> String {
        let report = &self.report;
        let note = format!(
            "identified from {name}, {} frequencies, relative residual {}",
            report.frequencies,
            digits(report.relative_residual, 4)
        );
        function_file(&report.function, report.delay_s, program, &note)
    }
}

/// A residual over the size of the response that is much.
const MUCH: f64 = 0.05;

impl ResponseAnswer {
    /// Finds the function of a frequency response: the parts that are given, behind a dead time, or a sum of a resistance, arcs and a power of s.
    ///
    /// # Errors
    /// No such function, or points that cannot be a response.
    pub fn find(
        model: Option<(&SumOfParts, DeadTime)>,
        MeasuredPoints {
            points,
            incoherent,
            notes,
            ..
        }: MeasuredPoints,
    ) -> Result<Self, Failure> {
        let found = match model {
            Some((sum, late)) => identify_response(sum, late, &points).map(|found| vec![found]),
            None => search_response(&points),
        };
        let found = found.map_err(|error| {
            let is_unfit = matches!(error, ControlError::NotFound { .. });
            if !is_unfit || model.is_some() {
                return refused(error);
            }
            Failure::run(format_args!(
                "no sum of a resistance, arcs and a power of s fits the response: give {MODEL}"
            ))
        })?;
        let Some(best) = found.first().cloned() else {
            return Err(Failure::run(format_args!(
                "no function was found: give {MODEL}"
            )));
        };
        let errors = best.standard_errors.iter();
        let numbers = errors.map(|(part, number, error)| {
            let late = best.dead_time.seconds();
            NumberRow::of(best.sum.parts(), *part, late, *number, *error)
        });
        let numbers: Vec<NumberRow> = numbers.collect();
        let mut warnings = notes;
        warnings.extend(measured_table::passed(
            &incoherent,
            "a coherence that is too low",
        ));
        let tested = kramers_kronig(&points);
        warnings.extend(tested.filter(|tested| !tested.holds).map(|tested| if tested.is_turned { format!("the response obeys Kramers' and Kronig's relations with the other sign of its imaginary part: write a minus before the name of that column, or see {PLANT_COLUMNS}") } else { "no sum of relaxations leaves noise alone: the system was not linear and steady, or it swings; repeat the lowest frequencies with less amplitude".to_owned() }));
        if best.rms_residual > MUCH {
            warnings.push(format!(
                "the function leaves {} % of the response: give {MODEL} with other parts",
                digits(100.0 * best.rms_residual, 3)
            ));
        }
        let loose = numbers.iter().filter(|number| !number.determined);
        let loose: Vec<&str> = loose.map(|number| &*number.name).collect();
        if !loose.is_empty() {
            warnings.push(format!(
                "the response does not determine {}: measure more frequencies, or give {MODEL} with fewer parts",
                loose.join(", ")
            ));
        }
        let omegas = || points.iter().map(|point| point.0);
        let candidates = found.iter().map(|found| CandidateRow {
            function: shown(found.sum.parts(), DIGITS),
            rms_residual: found.rms_residual,
            bic: found.bic,
        });
        let report = ResponseReport {
            function: shown(best.sum.parts(), DIGITS),
            delay_s: best.dead_time.seconds(),
            frequencies: points.len(),
            lowest_frequency_hz: omegas().fold(f64::INFINITY, f64::min) / TAU,
            highest_frequency_hz: omegas().fold(0.0, f64::max) / TAU,
            relative_residual: best.rms_residual,
            bic: best.bic,
            kramers_kronig: tested.map(|tested| tested.holds),
            kramers_kronig_reason: match tested {
                Some(tested) => format!(
                    "a positive spectrum of relaxations leaves {} %",
                    digits(100.0 * tested.rms_residual, 3)
                ),
                None => {
                    "not tested: below ten frequencies, or a real part of both signs".to_owned()
                }
            },
            numbers,
            candidates: candidates.collect(),
            warnings,
        };
        Ok(Self {
            report,
            points,
            best,
        })
    }
}
