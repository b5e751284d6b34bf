//! A server for one page, without a machine: messages come in and go out, and time is what whoever turns it says.
//!
//! ```text
//! text, acknowledgement ─▶ hear ─┐                            ┌─▶ answers, frames, status
//! clock, ms ─────────────▶ advance ─▶ loop in virtual time ───┤
//!                          work ────▶ one question of a panel ┘
//! ```
//! It has no device and no disk, and runs tissues and walls in virtual time alone: it refuses the rest with the command that has it.

mod absent;
mod held;
mod ran;

use crate::dropped::{looked_at, named, of_file};
use crate::feel::state::idle;
use crate::feel::{CHANNELS, DeviceNumbers, FeelChange, FeelSettings, felt, pyramid_size};
use crate::form::{Asker, forms};
use crate::hello::Known;
use crate::live::{Acknowledged, FRAMES_PER_S, LivePicture, ShownLoop, frame};
use crate::pyramid::Pyramid;
use crate::question::PanelQuestion;
use crate::request::{LIVE, PageRequest, Panel, ViewRequest, parse};
use crate::surface::{TissueSurface, pushed};
use crate::words::answered;
use absent::{NO_FILES, needs};
use haptic_document::Failure;
use haptic_quantity::parse_for_key;
use haptic_tissue::{Library, MaterialError};
use held::HeldLoop;
use ran::{VirtualRun, kind, run_forms};
use serde_json::{Value, json};
use std::collections::VecDeque;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// Time between two messages of the status, with a loop and without one, ms.
const STATUS_MS: (f64, f64) = (100.0, 1000.0);
const PROGRAM: &str = concat!("haptic-answer ", env!("CARGO_PKG_VERSION"));
const NO_FOLDER: &str = "kept until the page is closed";
/// Runs that are kept, of which the oldest goes when another one comes.
const RUNS: usize = 8;

/// A message to the page.
#[derive(Clone, Debug, PartialEq)]
pub enum ToPage {
    /// An answer, or something that was not asked for.
    Text(String),
    /// A picture of the loop, byte by byte as the protocol says.
    Frame(Vec<u8>),
}

/// The server of a page that has nothing else, a state machine between its messages.
#[derive(Debug)]
pub struct Alone {
    library: Library,
    day: String,
    held: Option<HeldLoop>,
    /// Its samples; memory that only who feels something needs.
    kept: Option<Pyramid>,
    live: LivePicture,
    acknowledged: Acknowledged,
    surface: Option<TissueSurface>,
    /// The run that begins at the next turn, those that are over, oldest first, and the number of all.
    to_run: Option<VirtualRun>,
    ran: VecDeque<VirtualRun>,
    runs: usize,
    /// The newest question of each panel that waits.
    asked: [Option<(Value, PanelQuestion)>; Panel::ALL.len()],
    out: VecDeque<ToPage>,
    /// The clock at the last frame and the last status, ms.
    sent_ms: (f64, f64),
}

impl Alone {
    /// A server with the built-in tissues; files say that they were made on this day.
    ///
    /// # Errors
    /// Tissues that are wrong, which a test of theirs excludes.
    pub fn new(day: String) -> Result<Self, MaterialError> {
        let acknowledged = Acknowledged::default();
        Ok(Self {
            library: Library::load(None)?,
            day,
            held: None,
            kept: None,
            live: LivePicture::new(acknowledged.clone()),
            acknowledged,
            surface: None,
            to_run: None,
            ran: VecDeque::new(),
            runs: 0,
            asked: Default::default(),
            out: VecDeque::new(),
            sent_ms: (f64::NEG_INFINITY, f64::NEG_INFINITY),
        })
    }

    /// The next message to the page.
    pub fn next_message(&mut self) -> Option<ToPage> {
        self.out.pop_front()
    }

    fn say(&mut self, value: &Value) {
        self.out.push_back(ToPage::Text(value.to_string()));
    }

    fn answer(&mut self, id: &Value, result: Result<Value, Failure>) {
        self.say(&answered(id, result));
    }

    /// Hears an acknowledgement of frames.
    pub fn hear_bytes(&mut self, bytes: &[u8]) {
        self.acknowledged.take(bytes);
    }

    /// Hears a request. A question of a panel is answered by [`work`](Self::work).
    pub fn hear(&mut self, text: &str) {
        match parse(text) {
            Err((id, error)) => self.answer(&id, Err(Failure::bad_input(error))),
            Ok((id, PageRequest::Ask { panel, question })) => {
                let waiting = &mut self.asked[panel as usize];
                if let Some((old, _)) = waiting.replace((id, question)) {
                    let newer = "a newer question from this panel has replaced this one";
                    self.answer(&old, Err(Failure::bad_input(newer)));
                }
            }
            Ok((id, request)) => {
                let result = self.done(&id, request);
                self.answer(&id, result);
            }
        }
    }

    /// Answers a question of a panel, if one waits; false if none does.
    pub fn work(&mut self) -> bool {
        let Some((id, question)) = self.asked.iter_mut().find_map(Option::take) else {
            return false;
        };
        let result = question.answer(&Asker {
            program: PROGRAM,
            day: self.day.clone(),
            files: &NO_FILES,
            given_up: &AtomicBool::new(false),
        });
        self.answer(&id, result);
        true
    }

    /// Goes on until this time, ms.
    pub fn advance(&mut self, now_ms: f64) {
        let (frame_ms, status_ms) = self.sent_ms;
        if let Some(mut run) = self.to_run.take() {
            let over = run.run();
            self.say(&over);
            self.ran.push_back(run);
            if self.ran.len() > RUNS {
                self.ran.pop_front();
            }
        }
        if let Some(held) = &mut self.held {
            if let Some(fault) = held.advance(now_ms, kept(&mut self.kept)) {
                let notice = json!({"notice": format!("stopped: {fault}")});
                self.out.push_back(ToPage::Text(notice.to_string()));
            }
            if self.live.is_on() && now_ms >= frame_ms + 1e3 / f64::from(FRAMES_PER_S) {
                self.sent_ms.0 = now_ms;
                let t = held.company.state.sample_time_s;
                let frame = self.live.next_frame(kept(&mut self.kept), t);
                self.out.extend(frame.map(ToPage::Frame));
            }
        }
        let (often, seldom) = STATUS_MS;
        let pause_ms = if self.held.is_some() { often } else { seldom };
        if now_ms >= status_ms + pause_ms {
            self.sent_ms.1 = now_ms;
            let status = self.status();
            self.say(&json!({"status": status}));
        }
    }

    fn status(&mut self) -> Value {
        let mut status = idle();
        status["watching"] = 0.into();
        status["controls"] = true.into();
        for sent in ["samples_sent", "samples_missed", "picture_late_s"] {
            status[sent] = 0.into();
        }
        let Some(held) = &self.held else {
            return status;
        };
        let made = held.made();
        let of_loop = held.company.state.status((made, 0), made);
        for (key, value) in of_loop.as_object().into_iter().flatten() {
            status[key] = value.clone();
        }
        // Virtual time is never late.
        for timing in [
            "tick_p50_us",
            "tick_p999_us",
            "tick_max_us",
            "late_p50_us",
            "late_p999_us",
        ] {
            status[timing] = Value::Null;
        }
        status["paused"] = held.is_paused().into();
        let t = held.company.state.sample_time_s;
        self.live.add_to(&mut status, kept(&mut self.kept), t);
        status
    }

    fn held(&mut self) -> Result<&mut HeldLoop, Failure> {
        self.held.as_mut().ok_or_else(none_felt)
    }

    fn felt(&mut self) -> Result<Value, Failure> {
        let answer = felt(&self.held()?.felt);
        self.say(&answer);
        Ok(answer)
    }

    fn done(&mut self, id: &Value, request: PageRequest) -> Result<Value, Failure> {
        Ok(match request {
            PageRequest::Hello { version } => {
                let known = Known {
                    controls: true,
                    watching: 0,
                    sample_time_s: self.sample_time_s(),
                    feel: self
                        .held
                        .as_ref()
                        .map(|held| felt(&held.felt)["feel"].take()),
                    opens: None,
                    device: DeviceNumbers::default(),
                    runs_folder: NO_FOLDER.to_owned(),
                };
                known.hello(version, &self.library)?
            }
            PageRequest::TakeControls { .. } => json!({"controls": true}),
            PageRequest::ReleaseControls {} | PageRequest::RunsStop {} => Value::Null,
            PageRequest::FeelStart(start) => self.start(start)?,
            PageRequest::FeelSet(change) => {
                let felt = self.held()?.felt.settings.clone();
                let next = felt.changed(&self.library, &change)?;
                let held = self.held.as_mut().ok_or_else(none_felt)?;
                held.change(next, kept(&mut self.kept))?;
                self.felt()?
            }
            PageRequest::FeelHand { position_m, held } => {
                json!({"position_m": self.held()?.hand(position_m, held)?})
            }
            PageRequest::FeelPause { paused } => json!(self.held()?.pause(paused)?),
            PageRequest::FeelMark { text } => {
                let state = &self.held()?.company.state;
                let mark = json!({"tick": state.tick, "time_s": state.time_s, "text": text});
                self.say(&json!({"mark": mark}));
                Value::Null
            }
            PageRequest::FeelEnd {} => {
                self.held = None;
                Value::Null
            }
            PageRequest::Stop {} => json!(self.held.as_ref().map(HeldLoop::stop)),
            PageRequest::Arm {} => json!(self.held()?.arm()?),
            PageRequest::View(view) => self.view(id, &view)?,
            PageRequest::ViewEnd {} => json!(self.live.show(None)),
            PageRequest::RunsList {} => {
                let newest_first = self.ran.iter().rev().map(VirtualRun::entry);
                json!({"runs": newest_first.collect::<Vec<_>>()})
            }
            PageRequest::RunsForms {} => {
                let mut forms = forms();
                forms["forms"] = run_forms();
                forms
            }
            PageRequest::RunsStart(form) => {
                let run = VirtualRun::of(&form, self.runs + 1)?;
                self.runs += 1;
                let started = json!({"name": run.name, "samples": run.samples});
                self.to_run = Some(run);
                started
            }
            PageRequest::RunsOpen { name } => self.run_of(&name)?.answer(),
            PageRequest::RunsTable(table) => {
                json!({"text": self.run_of(&table.name)?.table(&table)?})
            }
            PageRequest::TissueKeep { name, text } => {
                self.keep(&name, &text)?;
                json!({"path": "this page, until it is closed"})
            }
            PageRequest::File(file) => match looked_at(&file)? {
                Some(known) => known,
                None => {
                    let experiment = of_file(&file.text);
                    if experiment["kind"].as_str().and_then(kind).is_none() {
                        let name = &file.name;
                        return Err(needs(&format!(
                            "this is not one of its runs: use `host-cli run {name}`"
                        )));
                    }
                    json!({"is": "experiment", "experiment": experiment})
                }
            },
            PageRequest::Quantity { key, text } => {
                json!({"value": parse_for_key(&key, &text).map_err(Failure::bad_input)?})
            }
            PageRequest::Surface(surface) => {
                json!({"surface_m": pushed(&mut self.surface, surface)?})
            }
            PageRequest::FeelRecord { .. } => {
                return Err(needs(
                    "a recording is a log on a disk: use `host-cli serve`",
                ));
            }
            PageRequest::CompareStart(_)
            | PageRequest::CompareFeel {}
            | PageRequest::CompareRate { .. }
            | PageRequest::CompareAnswer { .. }
            | PageRequest::CompareEnd {} => {
                return Err(needs(
                    "a comparison is a table on a disk: use `host-cli serve`",
                ));
            }
            // It waits for `work`.
            PageRequest::Ask { .. } => Value::Null,
        })
    }

    fn sample_time_s(&self) -> f64 {
        let usual = DeviceNumbers::default().sample_time_s;
        let held = self.held.as_ref();
        held.map_or(usual, |held| held.company.state.sample_time_s)
    }

    fn start(&mut self, start: FeelChange) -> Result<Value, Failure> {
        let settings = FeelSettings::new(&self.library, DeviceNumbers::default(), start)?;
        self.held = Some(HeldLoop::start(settings.judged()?, kept(&mut self.kept))?);
        self.felt()
    }

    fn view(&mut self, id: &Value, view: &ViewRequest) -> Result<Value, Failure> {
        let number = view.number(id)?;
        if view.source != LIVE {
            let run = self.run_of(&view.source)?;
            let (samples, sample_time_s) = run.span();
            let columns = run.pyramid.columns(view.span(samples, sample_time_s)?);
            let (channels, columns) = view.chosen(run.channels.drawn(), columns)?;
            let frame = frame(number, &columns, sample_time_s);
            self.out.push_back(ToPage::Frame(frame));
            return Ok(json!({"channels": channels}));
        }
        let t = self.sample_time_s();
        match view.of_loop(number, kept(&mut self.kept), t)? {
            ShownLoop::Frame(frame) => self.out.push_back(ToPage::Frame(frame)),
            ShownLoop::Live(live) => self.live.show(Some(live)),
        }
        Ok(json!({"channels": CHANNELS}))
    }

    fn run_of(&self, name: &str) -> Result<&VirtualRun, Failure> {
        let found = self.ran.iter().find(|run| run.name == name);
        found.ok_or_else(|| needs("a log lies on a disk: use `host-cli serve`"))
    }

    /// Keeps a tissue under a name of its own, as long as the page is there.
    fn keep(&mut self, name: &str, text: &str) -> Result<(), Failure> {
        let path = Path::new("the tissue");
        let tissue = named(path, name, text)?;
        self.library.add(path, tissue).map_err(Failure::input)
    }
}

fn kept(pyramid: &mut Option<Pyramid>) -> &mut Pyramid {
    pyramid.get_or_insert_with(|| Pyramid::new(pyramid_size()))
}

fn none_felt() -> Failure {
    Failure::bad_input("nothing is felt yet: send `feel.start`")
}
