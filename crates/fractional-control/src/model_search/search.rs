//! A record as candidates are fitted to it and judged by it.

use super::found::{Found, less_sure, unexplained};
use super::record::{InputOutput, bic, independent, left, neighbours, resolved};
use crate::{DeadTime, FractionalTransferFunction, Identified, Record, identify_coefficients};

pub(super) struct Search<'a> {
    pub(super) record: &'a InputOutput,
    pub(super) held: bool,
    /// True if the dead time is known.
    pub(super) told: bool,
    /// The samples that count: fewer where what is left is alike from one to the next.
    samples: f64,
}

impl<'a> Search<'a> {
    pub(super) fn new(record: &'a InputOutput, held: bool, told: bool) -> Self {
        Self {
            record,
            held,
            told,
            samples: record.output.len() as f64,
        }
    }

    pub(super) fn behind(&self, dead_time: DeadTime) -> Record<'a> {
        self.record.as_record(self.held, dead_time)
    }

    /// The coefficients of a function that fit best, from these on.
    pub(super) fn coefficients(
        &self,
        function: &FractionalTransferFunction,
        dead_time: DeadTime,
    ) -> Option<Found> {
        let fit = identify_coefficients(function, &self.behind(dead_time)).ok()?;
        Some(self.judged(fit))
    }

    pub(super) fn judged(&self, mut identified: Identified) -> Found {
        let left = left(self.record, &identified.model);
        let neighbours = neighbours(&left);
        let less_sure = less_sure(neighbours, left.len());
        let errors = identified.standard_errors.iter_mut();
        errors.for_each(|(_, error)| *error *= less_sure);
        let mut found = Found {
            bic: 0.0,
            neighbours,
            unexplained: unexplained(self.record, &left),
            identified,
        };
        found.bic = self.bic(&found, resolved(self.record));
        found
    }

    /// The criterion of a function; what is left below the floor is nothing.
    pub(super) fn bic(&self, found: &Found, floor: f64) -> f64 {
        let own = &found.identified;
        let numbers = (found.numbers() + own.start_numbers) as f64;
        bic(self.samples, own.rms_residual, numbers, floor)
    }

    /// Counts the samples anew, by the function that leaves least: what is left of it is the most like noise.
    pub(super) fn count_samples<'f>(&mut self, found: impl Iterator<Item = &'f Found>) {
        let rms = |own: &&Found| own.identified.rms_residual;
        let least = found.min_by(|a, b| rms(a).total_cmp(&rms(b)));
        let noisy = least.filter(|least| rms(least) > resolved(self.record));
        if let Some(least) = noisy {
            self.samples = independent(&left(self.record, &least.identified.model));
        }
    }
}
