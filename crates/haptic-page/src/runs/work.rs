//! What goes on in a thread: an experiment, which is drawn while it goes, or a question, which is answered at its end.

use super::channels::Channels;
use haptic_experiment::Failure;
use haptic_log::live::LiveStreams;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Debug;
use std::sync::atomic::AtomicBool;

/// How far a piece of work is, in its steps; heard from any thread.
pub(super) type Progress<'a> = &'a (dyn Fn(u64) + Sync);

/// Who looks after it.
#[derive(Clone, Copy)]
pub(super) struct Attendant<'a> {
    /// Set to end it.
    pub(super) stop: &'a AtomicBool,
    pub(super) progress: Progress<'a>,
    /// Hears a sentence for people.
    pub(super) warn: &'a (dyn Fn(&str) + Sync),
    /// See the samples of an experiment.
    pub(super) live: &'a LiveStreams,
}

/// What is drawn of a run while it goes.
#[derive(Clone, Debug)]
pub(super) struct Drawn {
    pub(super) channels: Channels,
    pub(super) sample_time_s: f64,
    /// The record `experiment` of its log, as far as it is known before.
    pub(super) metadata: BTreeMap<String, String>,
}

/// Results.
pub(super) struct Finished {
    pub(super) report: Value,
    pub(super) curves: Value,
    pub(super) verdict: Option<String>,
    pub(super) ended_early: Option<String>,
}

/// A piece of work with its place.
pub(super) trait Work: Debug + Send {
    fn kind(&self) -> &str;

    /// As in the list of runs.
    fn name(&self) -> &str;

    /// Samples of an experiment, steps of a question.
    fn steps(&self) -> u64;

    /// `None` for what has nothing to draw.
    fn drawn(&self) -> Option<Drawn>;

    /// Does it.
    ///
    /// # Errors
    /// Its own.
    fn run(&self, attendant: Attendant<'_>) -> Result<Finished, Failure>;
}
