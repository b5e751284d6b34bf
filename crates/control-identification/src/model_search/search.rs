//! A record as candidates are fitted to it and judged by it.
//!
//! ```text
//! criterion = n·ln(variance of what the filter of the noise leaves) + (numbers + order of the noise)·ln n
//! ```
//! Noise whose samples are alike makes a plain sum of squares prefer functions that draw it. So each candidate is fitted, its residual is taken for an
//! autoregression, and both are found again through its filter, some rounds. Where what the closest candidate leaves is white, all are judged
//! as in white noise: a function that lacks something leaves what is alike, too.

use super::found::{Found, unexplained};
use super::record::{InputOutput, count_of, left, neighbours, resolved};
use crate::autoregression::Autoregression;
use crate::identify::{Free, UNFIT, identify_by};
use crate::{DeadTime, Identified, InputOutputRecord};
use core::f64::consts::{E, PI, SQRT_2};
use core::slice::from_ref;
use fractional_control::{ControlError, FractionalTransferFunction};
use rayon::prelude::*;

fn rms(signal: &[f64]) -> f64 {
    libm::sqrt(signal.iter().map(|x| x * x).sum::<f64>() / signal.len() as f64)
}

#[derive(Clone, Copy)]
pub(super) struct Search<'a> {
    pub(super) record: &'a InputOutput,
    pub(super) held: bool,
    /// True if the dead time is known.
    pub(super) dead_time_is_known: bool,
    /// True if what candidates leave is made white.
    is_alike: bool,
    /// q of an output in counts, or 0.
    count: f64,
}

/// Largest number of fits through the filter of the previous residual, and the change of the criterion that ends them.
const ROUNDS: usize = 4;
/// Samples from which on a function of free orders, which runs for long, is refitted once.
const LONG: usize = 2000;
const SETTLED: f64 = 0.01;
/// Largest input before a record, over the span of 0 and those that it has.
const LEVELS: f64 = 10.0;

/// Fits to what each row in counts can have been, and the share of a count within which that is.
const ROUNDS_WITHIN: usize = 12;
const INSIDE: f64 = 0.45;
/// Least noise of an output in counts, over a count, and steps of the search for its deviation.
const LEAST: f64 = 0.2;
const STEPS: usize = 40;

/// −2·ln of the likelihood of residuals r of an output in counts of q, with the noise that makes it largest, on the scale of n·ln σ².
/// ```text
/// −2·Σ ln(Φ((r + q/2)/σ) − Φ((r − q/2)/σ)) − n·ln(2πe/q²)
/// ```
/// Within half a count all models are alike, but none goes further from a row without noise, which n·ln of a variance does not see.
fn deviance_of_counts(left: &[f64], count: f64) -> f64 {
    let of = |logarithm: f64| {
        let unit = SQRT_2 * libm::exp(logarithm);
        let half = |distance: f64| libm::erfc(distance / unit);
        let terms = left.iter().map(|r| {
            let r = r.abs();
            libm::log(0.5 * (half(r - 0.5 * count) - half(r + 0.5 * count)))
        });
        -2.0 * terms.sum::<f64>()
    };
    let most = 2.0 * rms(left).max(count);
    let [mut low, mut high] = [LEAST * count, most].map(libm::log);
    // By thirds; where the likelihood is 0, at both, the noise is larger.
    for _ in 0..STEPS {
        let third = (high - low) / 3.0;
        if of(low + third) < of(high - third) {
            high -= third;
        } else {
            low += third;
        }
    }
    let scale = libm::log(2.0 * PI * E / (count * count));
    of(0.5 * (low + high)) - left.len() as f64 * scale
}

impl<'a> Search<'a> {
    pub(super) fn new(record: &'a InputOutput, held: bool, dead_time_is_known: bool) -> Self {
        Self {
            record,
            held,
            dead_time_is_known,
            is_alike: false,
            count: count_of(&record.output),
        }
    }

    pub(super) fn fitted(
        &self,
        function: &FractionalTransferFunction,
        dead_time: DeadTime,
        freedom: Free,
    ) -> Result<Found, ControlError> {
        self.sum_fitted(from_ref(function), dead_time, freedom)
    }

    /// Fits the parts of a sum, as [`fitted`](Self::fitted) fits one function.
    pub(super) fn sum_fitted(
        &self,
        parts: &[FractionalTransferFunction],
        dead_time: DeadTime,
        freedom: Free,
    ) -> Result<Found, ControlError> {
        let record = self.record.as_record(self.held, dead_time);
        let fit = identify_by(parts, &record, freedom)?;
        let fit = self.within_counts(fit, freedom);
        // An input that nobody recorded explains any output, if it may be as large as that takes.
        if fit.input_before.abs() > LEVELS * self.record.input_span() {
            return Err(UNFIT);
        }
        Ok(self.whitened(self.judged(fit, freedom)))
    }

    /// The fit to an output in counts by what each row can have been: a row counts from where its model leaves it. Least squares, for which a count
    /// that stays for long is as wrong as many, begin it.
    fn within_counts(&self, fit: Identified, freedom: Free) -> Identified {
        let (output, half) = (&self.record.output, INSIDE * self.count);
        if half == 0.0 || fit.noise.order() > 0 || freedom == Free::All {
            return fit;
        }
        let mut best = fit.clone();
        for _ in 0..ROUNDS_WITHIN {
            let pairs = best.model.iter().zip(output);
            let nearest = pairs.map(|(model, y)| model.clamp(y - half, y + half));
            let nearest: Vec<f64> = nearest.collect();
            if nearest == best.model {
                break;
            }
            let record = InputOutputRecord {
                output: &nearest,
                ..self.record.as_record(self.held, best.dead_time)
            };
            let Ok(next) = identify_by(&best.parts, &record, freedom) else {
                break;
            };
            best = next;
        }
        let deviance =
            |fit: &Identified| deviance_of_counts(&left(self.record, &fit.model), self.count);
        if deviance(&best) >= deviance(&fit) {
            return fit;
        }
        let rms_residual = rms(&left(self.record, &best.model));
        // Between fit and rows there is less than between the function and the plant.
        let more = (rms_residual / best.rms_residual).max(1.0);
        let errors = best.standard_errors.iter_mut();
        errors.for_each(|(_, error)| *error *= more);
        let left = rms_residual / fit.rms_residual;
        Identified {
            fit: 1.0 - (1.0 - fit.fit) * left * left,
            covariance: &best.covariance * (more * more),
            rms_residual,
            ..best
        }
    }

    /// The coefficients of a function that fit best, from these on.
    pub(super) fn coefficients(
        &self,
        function: &FractionalTransferFunction,
        dead_time: DeadTime,
    ) -> Option<Found> {
        self.fitted(function, dead_time, Free::Coefficients).ok()
    }

    fn judged(&self, mut identified: Identified, freedom: Free) -> Found {
        let left = left(self.record, &identified.model);
        let white = identified.noise.whitened(&left);
        let unexplained = unexplained(self.record, &left);
        if unexplained.is_some() {
            // An unexplained residual is not noise: its autocorrelation widens the errors.
            let white = Autoregression::of(&[&left]).whitened(&left);
            // At most as if all samples were one.
            let more = (rms(&left) / rms(&white)).min(libm::sqrt(left.len() as f64));
            let errors = identified.standard_errors.iter_mut();
            errors.for_each(|(_, error)| *error *= more.max(1.0));
        }
        let mut found = Found {
            bic: 0.0,
            neighbours: neighbours(&white),
            unexplained,
            identified,
            freedom,
        };
        found.bic = self.bic(&found, resolved(self.record));
        found
    }

    /// Refits a function through the whitening filter of its residual.
    fn whitened(&self, mut found: Found) -> Found {
        if !self.is_alike {
            return found;
        }
        let is_long = found.freedom == Free::All && self.record.output.len() > LONG;
        for _ in 0..if is_long { 1 } else { ROUNDS } {
            let model = &found.identified;
            let noise = Autoregression::of(&[&left(self.record, &model.model)]);
            if noise == model.noise {
                break;
            }
            let record = InputOutputRecord {
                noise,
                ..self.record.as_record(self.held, model.dead_time)
            };
            let Ok(next) = identify_by(&model.parts, &record, found.freedom) else {
                break;
            };
            let before = found.bic;
            found = self.judged(next, found.freedom);
            if (found.bic - before).abs() < SETTLED {
                break;
            }
        }
        found
    }

    /// The criterion of a function; residuals below the floor count as the floor.
    pub(super) fn bic(&self, found: &Found, floor: f64) -> f64 {
        let model = &found.identified;
        let numbers = found.numbers() + model.start_numbers + model.noise.order();
        let left = left(self.record, &model.model);
        let price = numbers as f64 * libm::log(left.len() as f64);
        let counted = Some(self.count).filter(|count| *count > 0.0 && model.noise.order() == 0);
        let deviance = counted.map(|count| deviance_of_counts(&left, count));
        deviance.unwrap_or_else(|| model.noise.deviance(&[&left], floor)) + price
    }

    /// True if what the closest of them leaves is alike from sample to sample.
    pub(super) fn leaves_alike<'f>(&self, found: impl Iterator<Item = &'f Found>) -> bool {
        let rms = |candidate: &&Found| candidate.identified.rms_residual;
        let least = found.min_by(|a, b| rms(a).total_cmp(&rms(b)));
        let noisy = least.filter(|least| !self.is_exact(&least.identified));
        noisy.is_some_and(|least| {
            let left = left(self.record, &least.identified.model);
            Autoregression::of(&[&left]).order() > 0
        })
    }

    /// True if it leaves what a model does not resolve, or no more of any row than its count.
    pub(super) fn is_exact(&self, fit: &Identified) -> bool {
        let mut left = left(self.record, &fit.model).into_iter();
        fit.rms_residual <= resolved(self.record) || left.all(|left| left.abs() <= 0.5 * self.count)
    }

    /// Judges these and all others from now on by what the filter of their noise leaves.
    pub(super) fn whiten(&mut self, found: &mut [Found]) {
        self.is_alike = true;
        let search = *self;
        let all = found.par_iter_mut();
        all.for_each(|found| *found = search.whitened(found.clone()));
    }
}
