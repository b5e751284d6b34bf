//! Runs in virtual time: their samples are kept as long as the page is there, and made again for a table.

use super::{NO_FILES, needs};
use crate::channels::{Channels, places};
use crate::form::{document, parameter, suggested};
use crate::pyramid::Pyramid;
use crate::request::{StartRun, TableRequest};
use haptic_document::Failure;
use haptic_judge::pushed::PushedLoop;
use haptic_judge::pushed_trial::PushedTrial as _;
use haptic_judge::setup::Beside;
use haptic_judge::wall::{WallTrial, wall};
use haptic_message::TickMessage;
use haptic_question::choices::choices;
use haptic_trial::device_table::with_devices;
use haptic_trial::ending::Ending;
use haptic_trial::keys::wall::WALL_TABLES;
use haptic_trial::simulate::World;
use serde_json::{Value, json};

/// The kind that is run here.
pub(super) const KIND: &str = "wall";
/// Samples of a run at most: a page stands still while they are made.
const SAMPLES_MOST: u64 = 1_000_000;

/// A run, before its first tick or after its last.
#[derive(Debug)]
pub(super) struct VirtualRun {
    pub(super) name: String,
    trial: WallTrial,
    pub(super) samples: u64,
    pub(super) channels: Channels,
    /// Empty before the first tick.
    pub(super) pyramid: Pyramid,
    verdict: Option<String>,
    ended: Option<Ending>,
}

/// The form of the runs.
pub(super) fn run_forms() -> Value {
    let tables = WALL_TABLES.iter().map(|(title, table)| {
        let field = |one| {
            let suggested = suggested(KIND, one);
            parameter(
                one,
                *title == "required" || suggested.is_some(),
                suggested,
                &choices(one),
            )
        };
        json!({"title": title, "parameters": table.iter().map(field).collect::<Vec<_>>()})
    });
    json!([{"kind": KIND, "tables": tables.collect::<Vec<_>>()}])
}

impl VirtualRun {
    /// The run of a form, read as the command reads its file.
    pub(super) fn of(form: &StartRun, number: usize) -> Result<Self, Failure> {
        if form.kind != KIND {
            let kind = form.kind.replacen('-', " ", 1);
            let command = match &*form.kind {
                "coupler" | "touch" | "teleoperation" => "run FILE.toml",
                _ => &kind,
            };
            return Err(needs(&format!(
                "{kind} is none of its runs: use `host-cli {command}`"
            )));
        }
        if form.realtime {
            return Err(needs(
                "no clock that ticks each millisecond: omit `realtime`, or use `host-cli serve`",
            ));
        }
        let document = document(KIND, WALL_TABLES, &form.parameters, &NO_FILES)?;
        let parsed = document.parse()?;
        let (_, table, _) = parsed.one_of(&[KIND], &[], "experiment", KIND)?;
        let table = with_devices(table.with_keys(WALL_TABLES)?)?;
        let trial = wall(&table, Beside::default(), [None; 2])?;
        let samples = trial.parts()?.samples;
        if samples > SAMPLES_MOST {
            return Err(needs(&format!(
                "{samples} samples are more than its {SAMPLES_MOST}: shorten `duration_s`, or use `host-cli run`"
            )));
        }
        let channels = Channels::of(1);
        Ok(Self {
            name: format!("{KIND}-{number:04}/{KIND}"),
            trial,
            samples,
            pyramid: channels.pyramid(samples),
            channels,
            verdict: None,
            ended: None,
        })
    }

    /// Makes the ticks, as the log of the command has them; why they ended early.
    fn ticks(&self, mut see: impl FnMut(&TickMessage)) -> Result<Option<Ending>, Failure> {
        let mut parts = self.trial.parts()?;
        let mut world = PushedLoop::new(&mut parts.controller, &mut parts.device);
        let (mut tick, mut ended) = (0, None);
        // One that was ended goes on until the force is zero.
        while tick < self.samples || ended.is_some() {
            see(&world.tick());
            tick += 1;
            if ended.is_some() {
                if world.is_at_rest() {
                    break;
                }
                continue;
            }
            ended = world.ended();
            if ended.is_some() {
                world.stop();
            }
        }
        Ok(ended)
    }

    /// Runs it; the last word on it.
    pub(super) fn run(&mut self) -> Value {
        let mut pyramid = self.channels.pyramid(self.samples);
        let made = self.ticks(|tick| pyramid.push(&self.channels.row(tick)));
        let judged = made.and_then(|ended| Ok((ended, self.trial.settled()?)));
        self.pyramid = pyramid;
        let (state, error) = match judged {
            Ok((ended, settling)) => {
                (self.ended, self.verdict) = (ended, Some(settling.verdict.words().to_owned()));
                let error = ended.map(|ended| ended.reason(None));
                (if ended.is_none() { "done" } else { "failed" }, error)
            }
            Err(failure) => ("failed", Some(failure.to_string())),
        };
        json!({"run": {
            "name": self.name,
            "kind": KIND,
            "state": state,
            "samples_done": self.pyramid.made(),
            "samples": self.samples,
            "verdict": self.verdict,
            "error": error,
            "report": {},
        }})
    }

    fn sample_time_s(&self) -> f64 {
        self.trial.setup().device.sample_time.0
    }

    /// Sample time and number of samples, for a view.
    pub(super) fn span(&self) -> (u64, f64) {
        (self.pyramid.made().max(1), self.sample_time_s())
    }

    /// A row of the list.
    pub(super) fn entry(&self) -> Value {
        json!({
            "name": self.name,
            "kind": KIND,
            "started_utc": null,
            "duration_s": self.last_s(),
            "samples": self.pyramid.made(),
            "size_bytes": 0,
            "verdict": self.verdict,
            "running": false,
        })
    }

    fn last_s(&self) -> f64 {
        self.pyramid.made().saturating_sub(1) as f64 * self.sample_time_s()
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
            "sample_time_s": self.sample_time_s(),
            "first_s": 0.0,
            "last_s": self.last_s(),
            "started_utc": null,
            "complete": true,
            "running": false,
            "damage": [],
            "missing_samples": 0,
            "metadata": {"experiment": {"experiment": KIND, "law": self.trial.law_in_words()}},
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
