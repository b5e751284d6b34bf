//! Runs in virtual time: their samples are kept as long as the page is there, and made again for a table.

use super::absent::{NO_FILES, needs};
use crate::channels::{Channels, places};
use crate::form::{document, form_of};
use crate::pyramid::Pyramid;
use crate::request::{StartRun, TableRequest};
use haptic_document::Failure;
use haptic_document::parameters::KeyTable;
use haptic_judge::indentation::{IndentationTrial, creep, relax};
use haptic_judge::pushed::PushedLoop;
use haptic_judge::pushed_trial::PushedTrial as _;
use haptic_judge::rendering::{CREEP_TABLES, RELAX_TABLES};
use haptic_judge::setup::Beside;
use haptic_judge::wall::{WallTrial, wall};
use haptic_message::TickMessage;
use haptic_question::choices::choices;
use haptic_trial::device_table::with_devices;
use haptic_trial::ending::Ending;
use haptic_trial::keys::wall::WALL_TABLES;
use haptic_trial::simulate::to_the_end;
use serde_json::{Value, json};
use std::ops::ControlFlow;

/// The kinds that are run here, and their tables.
const KINDS: [(&str, &[KeyTable]); 3] = [
    ("relax", RELAX_TABLES),
    ("creep", CREEP_TABLES),
    ("wall", WALL_TABLES),
];

/// The kind of this name, if it is run here.
pub(super) fn kind(name: &str) -> Option<(&'static str, &'static [KeyTable])> {
    KINDS.into_iter().find(|(known, _)| *known == name)
}

#[derive(Debug)]
enum Trial {
    Wall(Box<WallTrial>),
    Indentation(Box<IndentationTrial>),
}

/// Samples of a run at most: a page stands still while they are made.
const SAMPLES_MOST: u64 = 1_000_000;

/// A run, before its first tick or after its last.
#[derive(Debug)]
pub(super) struct VirtualRun {
    pub(super) name: String,
    kind: &'static str,
    trial: Trial,
    sample_time_s: f64,
    pub(super) samples: u64,
    pub(super) channels: Channels,
    /// Empty before the first tick.
    pub(super) pyramid: Pyramid,
    verdict: Option<String>,
    ended: Option<Ending>,
}

/// The forms of the runs.
pub(super) fn run_forms() -> Value {
    let forms = KINDS.into_iter();
    forms
        .map(|(kind, tables)| form_of(kind, tables, choices))
        .collect()
}

impl VirtualRun {
    /// The run of a form, read as the command reads its file.
    pub(super) fn of(form: &StartRun, number: usize) -> Result<Self, Failure> {
        let Some((kind, tables)) = kind(&form.kind) else {
            let kind = form.kind.replacen('-', " ", 1);
            let command = match &*form.kind {
                "coupler" | "touch" | "teleoperation" => "run FILE.toml",
                _ => &kind,
            };
            return Err(needs(&format!(
                "{kind} is not one of its runs: use `host-cli {command}`"
            )));
        };
        if form.realtime {
            return Err(needs(
                "no clock that ticks each millisecond: omit `realtime`, or use `host-cli serve`",
            ));
        }
        let document = document(kind, tables, &form.parameters, &NO_FILES)?;
        let parsed = document.parse()?;
        let (_, table, _) = parsed.one_of(&[kind], &[], "experiment", kind)?;
        let table = table.with_keys(tables)?;
        let (trial, samples, sample_time_s) = match kind {
            "wall" => {
                let trial = wall(&with_devices(table)?, Beside::default(), [None; 2])?;
                let (samples, t) = (trial.parts()?.samples, trial.setup().device.sample_time.0);
                (Trial::Wall(Box::new(trial)), samples, t)
            }
            indentation => {
                let trial = match indentation {
                    "relax" => relax(&table, None, false)?,
                    _ => creep(&table, None, false)?,
                };
                let (samples, t) = (trial.samples()?, trial.actuator.sample_time.0);
                (Trial::Indentation(Box::new(trial)), samples, t)
            }
        };
        if samples > SAMPLES_MOST {
            return Err(needs(&format!(
                "{samples} samples are more than its {SAMPLES_MOST}: shorten `duration_s`, or use `host-cli run`"
            )));
        }
        let channels = Channels::of(1);
        Ok(Self {
            name: format!("{kind}-{number:04}/{kind}"),
            kind,
            trial,
            sample_time_s,
            samples,
            pyramid: channels.pyramid(samples),
            channels,
            verdict: None,
            ended: None,
        })
    }

    /// Makes the ticks, as the log of the command has them; why they ended early.
    fn ticks(&self, mut see: impl FnMut(&TickMessage)) -> Result<Option<Ending>, Failure> {
        let sink = &mut |tick: &TickMessage| {
            see(tick);
            ControlFlow::Continue(())
        };
        match &self.trial {
            Trial::Indentation(trial) => trial.run(sink),
            Trial::Wall(trial) => {
                let mut parts = trial.parts()?;
                let mut world = PushedLoop::new(&mut parts.controller, &mut parts.device);
                Ok(to_the_end(&mut world, self.samples, sink))
            }
        }
    }

    /// The verdict on a wall; a tissue has none.
    fn judged(&self) -> Result<Option<String>, Failure> {
        match &self.trial {
            Trial::Wall(trial) => Ok(Some(trial.settled()?.verdict.words().to_owned())),
            Trial::Indentation(_) => Ok(None),
        }
    }

    /// Runs it; the last word on it.
    pub(super) fn run(&mut self) -> Value {
        let mut pyramid = self.channels.pyramid(self.samples);
        let made = self.ticks(|tick| pyramid.push(&self.channels.row(tick)));
        let judged = made.and_then(|ended| Ok((ended, self.judged()?)));
        self.pyramid = pyramid;
        let (state, error) = match judged {
            Ok((ended, verdict)) => {
                (self.ended, self.verdict) = (ended, verdict);
                let error = ended.map(|ended| ended.reason(None));
                (if ended.is_none() { "done" } else { "failed" }, error)
            }
            Err(failure) => ("failed", Some(failure.to_string())),
        };
        json!({"run": {
            "name": self.name,
            "kind": self.kind,
            "state": state,
            "samples_done": self.pyramid.made(),
            "samples": self.samples,
            "verdict": self.verdict,
            "error": error,
            "report": {},
        }})
    }

    /// Sample time and number of samples, for a view.
    pub(super) fn span(&self) -> (u64, f64) {
        (self.pyramid.made().max(1), self.sample_time_s)
    }

    /// A row of the list.
    pub(super) fn entry(&self) -> Value {
        json!({
            "name": self.name,
            "kind": self.kind,
            "started_utc": null,
            "duration_s": self.last_s(),
            "samples": self.pyramid.made(),
            "size_bytes": 0,
            "verdict": self.verdict,
            "running": false,
        })
    }

    fn last_s(&self) -> f64 {
        self.pyramid.made().saturating_sub(1) as f64 * self.sample_time_s
    }

    /// The law in words, for the head of its report.
    fn law(&self) -> String {
        match &self.trial {
            Trial::Wall(trial) => trial.law_in_words(),
            Trial::Indentation(trial) => trial.piece.material.name.clone(),
        }
    }

    /// The answer to `runs.open`.
    pub(super) fn answer(&self) -> Value {
        let end = self
            .ended
            .map(|ended| json!({"ended": ended.kind(), "reason": ended.reason(None)}));
        json!({
            "name": self.name,
            "channels": self.channels.names(),
            "axes": 1,
            "samples": self.pyramid.made(),
            "sample_time_s": self.sample_time_s,
            "first_s": 0.0,
            "last_s": self.last_s(),
            "started_utc": null,
            "complete": true,
            "running": false,
            "damage": [],
            "missing_samples": 0,
            "metadata": {"experiment": {"experiment": self.kind, "law": self.law()}},
            "events": [],
            "end": end,
            "curves": null,
        })
    }

    /// The samples of some channels as a table; every number has all of its digits.
    pub(super) fn table(&self, request: &TableRequest) -> Result<String, Failure> {
        let wanted = places(&request.channels, &self.channels.names())?;
        let span_s =
            request.from_s.unwrap_or(f64::NEG_INFINITY)..=request.to_s.unwrap_or(f64::INFINITY);
        let mut table = Channels::head(&request.channels);
        self.ticks(|tick| {
            if span_s.contains(&tick.time_s) {
                self.channels.line(&mut table, tick, &wanted);
            }
        })?;
        Ok(table)
    }
}
