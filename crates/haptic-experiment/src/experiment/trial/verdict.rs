//! A run that reached its end, sample by sample: its table, its curves, and each force against theory.

use crate::document::failure::Failure;
use crate::judge::decimated::Decimated;
use crate::judge::report::Files;
use crate::judge::{Compared, Reference};
use crate::run::Ran;
use crate::run::record::Record;
use crate::run::samples::Samples;
use crate::run::tick::KeptSample;
use fracdiff::Order;
use fracdiff::full_memory::Kernel;

/// Results of a run that reached its end.
pub(crate) struct Verdict<const N: usize> {
    pub(super) files: Files,
    pub(super) curves: Decimated<N>,
    /// See [`Errors::max_relative_error`](crate::judge::report::Errors::max_relative_error).
    pub(super) operator_error: Compared,
}

/// Writes the table, time and these quantities, and keeps the largest error of a force, N. `sample` tells the error and the
/// quantities of each; `reason` says why the errors have no meaning.
///
/// # Errors
/// A log that cannot be read again.
pub(crate) fn verdict<const N: usize>(
    ran: &Ran,
    names: [&str; N],
    reason: Option<&'static str>,
    mut sample: impl FnMut(&KeptSample) -> (f64, [f64; N]),
) -> Result<Verdict<N>, Failure> {
    let record = &ran.record;
    let header: Vec<&str> = ["time_s"].into_iter().chain(names).collect();
    let mut table = ran.folder.named_table_beside_log("csv", &header);
    let mut curves = Decimated::of(record);
    let mut seen = Seen::default();
    Samples::of(record, &ran.log.paths).for_each(|kept| {
        let (error, values) = sample(kept);
        seen.add(kept, error);
        curves.add(kept.time_s, values);
        table.row((kept.time_s, values.as_slice()));
        Ok(())
    })?;
    curves.finish();
    let operator_error = match reason {
        None => seen.over(record),
        Some(reason) => Compared::without_meaning(reason.to_owned()),
    };
    Ok(Verdict {
        files: Files::of_run(ran, Some(table)),
        curves,
        operator_error,
    })
}

/// The largest error of the forces that can be compared, over the largest force of the run.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Seen {
    off_n: f64,
    from_s: Option<f64>,
    to_s: f64,
    samples: u64,
}

impl Seen {
    /// A sample whose force is off by so much, N.
    pub(crate) fn add(&mut self, sample: &KeptSample, off_n: f64) {
        if sample.is_comparable() {
            self.off_n = self.off_n.max(off_n);
            self.from_s = self.from_s.or(Some(sample.time_s));
            self.to_s = sample.time_s;
            self.samples += 1;
        }
    }

    /// Of a whole run.
    pub(crate) fn over(self, record: &Record) -> Compared {
        match self.from_s {
            Some(from_s) => Compared::of_window(
                self.off_n / record.largest_force_n(),
                [from_s, self.to_s],
                self.samples,
            ),
            None => Compared::without_meaning(
                "the safety chain limited the force in each sample".to_owned(),
            ),
        }
    }
}

/// A law that a limited force moves on is not compared any more.
pub(crate) fn limited(record: &Record) -> Option<&'static str> {
    (record.limited > 0).then_some("the safety chain limited the force")
}

/// A force without a full history of this order, or without any force, has nothing to be compared with.
pub(crate) fn incomparable(
    reference: Reference,
    order: Order,
    record: &Record,
) -> Option<&'static str> {
    if reference == Reference::Kernel(Kernel::PiecewiseLinear) && order.get() >= 1.0 {
        Some("the weights of this kernel are known in closed form below order 1 only")
    } else if record.largest_force_n() == 0.0 {
        Some("no force was commanded")
    } else {
        None
    }
}
