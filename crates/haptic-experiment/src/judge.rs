//! Reports of runs, and what a run leaves besides.

pub(crate) mod against;
pub(crate) mod beginning;
pub(crate) mod report;
pub(crate) mod warnings;

pub use haptic_document::{Rows, rows};
use haptic_judge::curves::Curves;
use haptic_run::{Ran, folder::OutputFolder, record::RunRecord};
pub use report::{Report, RunReport};

/// Origin of the force of a run: `simulated` without a link, or by a device that simulates its plant; `rendered` by a device's own record of
/// what it commanded and read. No instrument measured it.
pub(crate) fn origin(record: &RunRecord) -> &'static str {
    if record.link.as_ref().is_none_or(|link| link.simulated) {
        "simulated"
    } else {
        "rendered"
    }
}

/// Results of an experiment: a report, and the folder of its other files.
#[derive(Debug)]
pub struct Published<R> {
    /// The report; the code that saves a picture enters its name there.
    pub report: R,
    /// Curves to draw; `None` for a run that was cut short.
    pub curves: Option<Curves>,
    /// The folder of the log.
    pub folder: OutputFolder,
}

impl<R> Published<R> {
    pub(crate) fn new(report: R, curves: Option<Curves>, ran: Ran) -> Self {
        Self {
            report,
            curves,
            folder: ran.folder,
        }
    }
}
