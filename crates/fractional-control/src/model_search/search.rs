//! A record as candidates are fitted to it and judged by it.
//!
//! ```text
//! criterion = n·ln(variance of what the filter of the noise leaves) + (numbers + order of the noise)·ln n
//! ```
//! Noise whose samples are alike makes a plain sum of squares prefer functions that draw it. So each candidate is fitted, its residual is taken for an
//! autoregression, and both are found again through its filter, some rounds. Where what the closest candidate leaves is white, all are judged
//! as in white noise: a function that lacks something leaves what is alike, too.

use super::found::{Found, unexplained};
use super::record::{InputOutput, left, neighbours, resolved};
use crate::autoregression::Autoregression;
use crate::identify::{Free, UNFIT, identify_by};
use crate::{ControlError, DeadTime, FractionalTransferFunction, Identified, InputOutputRecord};
use core::slice::from_ref;
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
}

/// Largest number of fits through the filter of the previous residual, and the change of the criterion that ends them.
const ROUNDS: usize = 4;
/// Samples from which on a function of free orders, which runs for long, is refitted once.
const LONG: usize = 2000;
const SETTLED: f64 = 0.01;
/// Largest input before a record, over the span of 0 and those that it has.
const LEVELS: f64 = 10.0;

impl<'a> Search<'a> {
    pub(super) fn new(record: &'a InputOutput, held: bool, dead_time_is_known: bool) -> Self {
        Self {
            record,
            held,
            dead_time_is_known,
            is_alike: false,
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

    /// As [`fitted`](Self::fitted), the parts of a sum.
    pub(super) fn sum_fitted(
        &self,
        parts: &[FractionalTransferFunction],
        dead_time: DeadTime,
        freedom: Free,
    ) -> Result<Found, ControlError> {
        let record = self.record.as_record(self.held, dead_time);
        let fit = identify_by(parts, &record, freedom)?;
        // An input that nobody recorded explains any output, if it may be as large as that takes.
        if fit.input_before.abs() > LEVELS * self.record.input_span() {
            return Err(UNFIT);
        }
        Ok(self.whitened(self.judged(fit, freedom)))
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
        model.noise.deviance(&[&left], floor) + numbers as f64 * libm::log(left.len() as f64)
    }

    /// True if what the closest of them leaves is alike from sample to sample.
    pub(super) fn leaves_alike<'f>(&self, found: impl Iterator<Item = &'f Found>) -> bool {
        let rms = |candidate: &&Found| candidate.identified.rms_residual;
        let least = found.min_by(|a, b| rms(a).total_cmp(&rms(b)));
        let noisy = least.filter(|least| rms(least) > resolved(self.record));
        noisy.is_some_and(|least| {
            let left = left(self.record, &least.identified.model);
            Autoregression::of(&[&left]).order() > 0
        })
    }

    /// Judges these and all others from now on by what the filter of their noise leaves.
    pub(super) fn whiten(&mut self, found: &mut [Found]) {
        self.is_alike = true;
        let search = *self;
        let all = found.par_iter_mut();
        all.for_each(|found| *found = search.whitened(found.clone()));
    }
}
