//! A plant from a record of its input and output: the command, the page and Python read, fit and report by this.
//!
//! A form holds the values that somebody gives, by the names of keys; a question is a form that is understood.

pub mod keys;
mod record_check;
pub mod report;
pub mod response;

use super::tissue::parts;
use crate::plant::record_check::{
    check_signals, fill_gaps, leave_out_lone_outputs, one_row_a_time,
};
use control_identification::DeadTime;
use control_identification::model_search::{
    Found, InputOutput, Wanted, candidates, candidates_of, dead_time_evidence, find_start,
    identify, nearer_in_simulation, validate,
};
use fracdiff::Seconds;
use fractional_control::{ControlError, Plant, SumOfParts};
use haptic_document::Failure;
use haptic_document::parameters::Parameter;
use haptic_quantity::{digits, number, parse_for_key, short};
use haptic_trial::advice::refused;
use haptic_trial::plant_file::{MeasuredPoints, function_file};
use keys::{FIRST_ROW, MODEL, PLANT_COLUMNS, POLES, PlantForm, ROW_TIME, SMOOTH, STABLE, VALIDATE};
use measured_table::{
    Choice, ResponseColumn, has_frequencies, read_record, read_response, rows_named,
};
use report::{PlantReport, Tried, counted_from, nearer, remedies, rounded};
use response::{ResponseAnswer, ResponseReport};
use serde::Serialize;
use std::sync::atomic::{AtomicBool, Ordering};

/// Signals, and the columns that they are in.
const SIGNALS: [(&str, &str); 3] = [("time", "time_s"), ("input", "input"), ("output", "output")];

/// A column of a record, by its index in [`SIGNALS`], or of a frequency response.
#[derive(Clone, Debug)]
enum Named {
    Signal(usize, String),
    Response(ResponseColumn, Choice),
}

impl Named {
    fn of(text: &str) -> Result<Self, String> {
        let split = text.split_once('=').and_then(|(name, column)| {
            let (name, column) = (name.trim(), column.trim().to_owned());
            let signal = SIGNALS.iter().position(|signal| signal.0 == name);
            let response = |column| {
                Some(Self::Response(
                    ResponseColumn::named(name)?,
                    Choice::Name(column),
                ))
            };
            match signal {
                Some(index) => Some(Self::Signal(index, column)),
                None => response(column),
            }
        });
        split.ok_or_else(|| {
            "is not time=COLUMN, input=COLUMN or output=COLUMN, or of a response frequency, gain, phase, real or imaginary".to_owned()
        })
    }
}

/// An input that was set once, and is in no column.
#[derive(Clone, Copy, Debug)]
struct Jump {
    to: f64,
    at_s: f64,
}

impl Jump {
    /// Jump of a value and a time, `12@2s`.
    fn of(text: &str) -> Option<Self> {
        let (to, at) = text.split_once('@')?;
        let at_s = parse_for_key("at_s", at.trim()).ok()?;
        Some(Self {
            to: number(to.trim())?,
            at_s,
        })
    }

    /// The input so long after the first row.
    fn at(self, time_s: f64) -> f64 {
        if time_s < self.at_s { 0.0 } else { self.to }
    }
}

/// A function to begin from, and its dead time, if it has one.
#[derive(Clone, Debug)]
struct Begun {
    sum: SumOfParts,
    delay: Option<Seconds>,
}

impl Begun {
    fn of(text: &str) -> Result<Self, Failure> {
        let refused = |error: &dyn std::fmt::Display| {
            Failure::bad_input(format_args!("model \"{text}\": {error}; change {MODEL}"))
        };
        let plant: Plant = text.parse().map_err(|error| refused(&error))?;
        let sum = SumOfParts::of_plant(text).map_err(|error| refused(&error))?;
        if sum.function().denominator().degree() == 0.0 {
            return Err(refused(
                &"its denominator has no power of s: give one, as in 2/(30s^0.9+1)",
            ));
        }
        let late = plant.delay_s();
        Ok(Self {
            sum,
            delay: (late > 0.0).then_some(Seconds(late)),
        })
    }
}

/// A part of the work, of how many steps it is, and how many more of them are done.
pub type Steps<'a> = &'a (dyn Fn(&'static str, usize, usize) + Sync);

/// A record that can be one of a plant, and sentences about its rows.
#[derive(Clone, Debug)]
pub struct PlantRecord {
    /// Times, input and output, as they are fitted.
    pub record: InputOutput,
    notes: Vec<String>,
}

/// A record, or a frequency response.
#[derive(Clone, Debug)]
pub enum PlantData {
    /// Input and output over time.
    Record(PlantRecord),
    /// ω in rad/s and the response.
    Response(MeasuredPoints),
}

/// A plant that was found in either of them.
#[derive(Clone, Debug)]
#[expect(missing_docs, reason = "as of the data")]
pub enum PlantFound {
    Record(Box<PlantAnswer>),
    Response(Box<ResponseAnswer>),
}

/// The report on a record or on a response; written as that one, without a tag.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(untagged)]
#[expect(missing_docs, reason = "as of the data")]
pub enum FoundReport<'a> {
    Record(&'a PlantReport),
    Response(&'a ResponseReport),
}

impl PlantFound {
    /// The report that was made with the answer.
    #[must_use]
    pub fn report(&self) -> FoundReport<'_> {
        match self {
            Self::Record(answer) => FoundReport::Record(&answer.report),
            Self::Response(answer) => FoundReport::Response(&answer.report),
        }
    }

    /// Sentences that one should read.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        match self {
            Self::Record(answer) => &answer.report.warnings,
            Self::Response(answer) => &answer.report.warnings,
        }
    }

    /// The plant file: what was found in the table of this name, by this program.
    #[must_use]
    pub fn to_toml(&self, program: &str, name: &str) -> String {
        match self {
            Self::Record(answer) => answer.to_toml(program, name),
            Self::Response(answer) => answer.to_toml(program, name),
        }
    }
}

/// A record to be read and fitted.
///
/// ```
/// use haptic_question::plant::PlantQuestion;
/// use haptic_question::plant::keys::PlantForm;
/// use std::sync::atomic::AtomicBool;
///
/// // 2/(s + 1) after a step of its input.
/// let rows = (0..60).map(|n| format!("{},1,{}\n", 0.1 * f64::from(n), 2.0 - 2.0 * (-0.1 * f64::from(n)).exp()));
/// let table = format!("time_s,valve,output\n{}", rows.collect::<String>());
/// let form: PlantForm = serde_json::from_str("{\"columns\": \"input=valve\", \"poles\": 1}")?;
/// let question = PlantQuestion::of(&form)?;
/// let record = question.read(&question.columns, table.as_bytes()).expect("a record");
/// let answer = question.answer(record.clone(), None, &AtomicBool::new(false), &|_, _, _| {})?;
/// assert_eq!(answer.report.begins, "at rest");
/// assert!((answer.report.numbers[0].value - 2.0).abs() < 1e-6);
/// // Nobody recorded that the valve was set to 1 at once.
/// let alone = table.replace(",1,", ",");
/// let form: PlantForm = serde_json::from_str("{\"columns\": \"input=1@0s\", \"poles\": 1}")?;
/// let question = PlantQuestion::of(&form)?;
/// let set = question.read(&question.columns, alone.replace("valve,", "").as_bytes()).expect("a record");
/// assert_eq!(set.record, record.record);
/// let wrong = PlantForm { poles: Some(5.0), ..PlantForm::default() };
/// let refused = PlantQuestion::of(&wrong).expect_err("five poles").to_string();
/// assert_eq!(refused, "`poles` = 5 is not from 1 to 4: change it");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct PlantQuestion {
    /// Names of the columns of time, input and output.
    pub columns: [String; 3],
    /// Columns of a frequency response.
    response: Vec<(ResponseColumn, Choice)>,
    names_signals: bool,
    /// A key that is given, and of records alone.
    only_of_records: Option<Parameter>,
    sample_time_s: Option<f64>,
    subtract_start: bool,
    held: bool,
    model: Option<Begun>,
    wanted: Wanted,
    delay: Option<Seconds>,
}

impl PlantQuestion {
    /// Understands a form.
    ///
    /// # Errors
    /// A text that its key does not allow, a number outside its range, keys that exclude each other.
    pub fn of(form: &PlantForm) -> Result<Self, Failure> {
        let mut columns = SIGNALS.map(|(_, column)| column.to_owned());
        let (mut names_signals, mut response) = (false, Vec::new());
        for named in parts(PLANT_COLUMNS, &form.columns, Named::of)? {
            match named {
                Named::Signal(index, name) => {
                    names_signals = true;
                    columns[index] = name;
                }
                Named::Response(column, choice) => response.push((column, choice)),
            }
        }
        if let Some(index) =
            (1..columns.len()).find(|&index| columns[..index].contains(&columns[index]))
        {
            return Err(Failure::bad_input(format_args!(
                "column {} is used for two signals: give each its own with {PLANT_COLUMNS}",
                short(&columns[index])
            )));
        }
        form.check()?;
        if let Some(poles) = form.poles.filter(|poles| poles.fract() != 0.0) {
            return Err(Failure::bad_input(format_args!(
                "{POLES} = {poles} is not a whole number: change it"
            )));
        }
        if form.poles.is_some() && !form.model.is_empty() {
            return Err(Failure::bad_input(format_args!(
                "{MODEL} and {POLES} exclude each other: omit one"
            )));
        }
        let model = Some(&*form.model).filter(|model| !model.is_empty());
        let of_records = [
            (POLES, form.poles.is_some()),
            (STABLE, form.stable),
            (SMOOTH, form.smooth),
            (FIRST_ROW, form.subtract_start),
            (ROW_TIME, form.sample_time_s.is_some()),
            (VALIDATE, !form.validate.is_empty()),
        ];
        let given = of_records.into_iter().find(|(_, is_given)| *is_given);
        Ok(Self {
            columns,
            response,
            names_signals,
            only_of_records: given.map(|given| given.0),
            sample_time_s: form.sample_time_s,
            subtract_start: form.subtract_start,
            held: !form.smooth,
            model: model.map(Begun::of).transpose()?,
            wanted: Wanted {
                poles: form.poles.map(|poles| poles as usize),
                is_stable: form.stable,
            },
            delay: form.delay_s.map(Seconds),
        })
    }

    /// The record in a table with columns of these names, or the frequency response in it.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn data(&self, columns: &[String; 3], bytes: &[u8]) -> Result<PlantData, String> {
        if self.response.is_empty() {
            let record = self.read(columns, bytes).map(PlantData::Record);
            if record.is_ok() || self.names_signals || !has_frequencies(bytes) {
                return record;
            }
        }
        let table = read_response(bytes, &self.response);
        let table = table.map_err(|error| {
            with_columns(&short(&error.to_string()), "frequency=1,gain=2,phase=3")
        })?;
        MeasuredPoints::of(table).map(PlantData::Response)
    }

    /// Finds the function of a record, and tries it on another, or of a frequency response.
    ///
    /// # Errors
    /// As [`answer`](Self::answer).
    pub fn found(
        &self,
        data: PlantData,
        other: Option<PlantData>,
        stop: &AtomicBool,
        steps: Steps<'_>,
    ) -> Result<PlantFound, Failure> {
        match (data, other) {
            (PlantData::Response(points), None) => {
                if let Some(key) = self.only_of_records {
                    return Err(Failure::bad_input(format_args!(
                        "{key} has no effect on a frequency response: omit it"
                    )));
                }
                let late = |plant: &Begun| match (self.delay, plant.delay) {
                    (Some(known), _) => DeadTime::Known(known),
                    (None, first) => first.map_or(DeadTime::NONE, DeadTime::From),
                };
                let model = self.model.as_ref().map(|plant| (&plant.sum, late(plant)));
                let answer = ResponseAnswer::find(model, points)?;
                Ok(PlantFound::Response(Box::new(answer)))
            }
            (PlantData::Record(record), None) => {
                let answer = self.answer(record, None, stop, steps)?;
                Ok(PlantFound::Record(Box::new(answer)))
            }
            (PlantData::Record(record), Some(PlantData::Record(other))) => {
                let answer = self.answer(record, Some(other), stop, steps)?;
                Ok(PlantFound::Record(Box::new(answer)))
            }
            _ => Err(Failure::bad_input(format_args!(
                "a function is tried on a second record in time alone: omit {VALIDATE}"
            ))),
        }
    }

    /// The record in a table with columns of these names.
    ///
    /// # Errors
    /// What is wrong with it, with line and column.
    pub fn read(&self, columns: &[String; 3], bytes: &[u8]) -> Result<PlantRecord, String> {
        let wrong = |error: String| with_columns(&error, "time=1,input=2,output=3");
        let remedy =
            |error: &str| wrong(format!("{error}; a table without times takes {ROW_TIME}"));
        let [time, signals @ ..] = columns.each_ref().map(String::as_str);
        // Steps that are given are the times, whatever else the table has.
        let time = self.sample_time_s.map_or(time, |_| "");
        let jump = Jump::of(signals[0]);
        // A command that nobody recorded stands for itself.
        let input = jump.as_ref().map_or(signals[0], |_| signals[1]);
        let found = read_record(bytes, [time, input, signals[1]])
            .map_err(|error| remedy(&short(&error.to_string())))?;
        let gaps = found.gaps().map(|rows| {
            format!("{rows} without an output: it is put on a straight line between its neighbours")
        });
        let (mut lines, [mut time_s, mut input, output]) = (found.lines, found.columns);
        match (self.sample_time_s, time_s.is_empty()) {
            (None, false) => {}
            (None, true) => return Err(remedy(&format!("no column {time}"))),
            (Some(step), _) => time_s = (0..lines.len()).map(|n| step * n as f64).collect(),
        }
        if let Some(jump) = jump {
            let begin = time_s[0];
            input = time_s.iter().map(|time| jump.at(time - begin)).collect();
        }
        let mut record = InputOutput {
            time_s,
            input,
            output,
            ..InputOutput::default()
        };
        let repeated = one_row_a_time(&mut record, &mut lines)
            .map_err(|error| wrong(format!("{error}; the time is column {}", short(time))))?;
        let repeated = rows_named(&repeated).map(|rows| {
            format!("{rows} at the time of the row before: of one time the first output counts and the last input, which acts from then on")
        });
        let impossible = leave_out_lone_outputs(&mut record, &lines).map(|rows| {
            format!("{rows} with an output far from both neighbours, which are alike: it is left out, and put on a straight line")
        });
        fill_gaps(&mut record, &lines, signals).map_err(wrong)?;
        if self.subtract_start {
            record.subtract_start();
        }
        check_signals(&record, &lines, signals).map_err(wrong)?;
        let left_out = gaps.into_iter().chain(repeated).chain(impossible);
        let notes = found.notes.into_iter().chain(left_out).collect();
        Ok(PlantRecord { record, notes })
    }

    /// Finds the function of a record, and tries it on another, if there is one. A set `stop` ends it after the part that goes on.
    ///
    /// # Errors
    /// No function that fits, a record without a response to its input, a stop.
    pub fn answer(
        &self,
        PlantRecord { mut record, notes }: PlantRecord,
        other: Option<PlantRecord>,
        stop: &AtomicBool,
        steps: Steps<'_>,
    ) -> Result<PlantAnswer, Failure> {
        let found = self.search(&mut record, stop, steps)?;
        let [best, ..] = &found[..] else {
            return Err(Failure::run(format_args!(
                "no function was found: give {MODEL} with other terms"
            )));
        };
        // A calmer function may stand first; the closest one tells what the record shows.
        let closest = found.iter().min_by(|a, b| a.bic.total_cmp(&b.bic));
        if !closest.unwrap_or(best).shows_a_response(&record) {
            return Err(Failure::run(format_args!(
                "the record shows no response to its input: {} explains {} % of the output's variance, and as much as chance would; move the input more, or check {PLANT_COLUMNS}",
                rounded(&best.identified),
                digits(100.0 * best.identified.fit, 2)
            )));
        }
        let evidence = self.delay.is_none().then(|| {
            steps("dead time", 1, 0);
            dead_time_evidence(&found, &record, self.held)
        });
        let tried = other.and_then(|other| {
            let validation = validate(best, record.start, &other.record, self.held)?;
            Some(Tried {
                record: other.record,
                validation,
            })
        });
        let report = PlantReport::of(&found, best, &record, evidence.flatten(), tried.as_ref());
        let mut report = report.warned(notes);
        let second = tried.as_ref().map(|tried| &tried.record);
        let instead = |other| nearer_in_simulation(&found, &record, other, self.held);
        let own = instead(None).map(|instead| nearer(best, instead, "this record"));
        let second = second.and_then(|second| instead(Some(second)));
        let name = format!("the record of {VALIDATE}");
        let second = second.map(|instead| nearer(best, instead, &name));
        report.warnings.extend(own.into_iter().chain(second));
        let best = best.clone();
        Ok(PlantAnswer {
            report,
            begins: counted_from(&record, &best.identified),
            record: record.as_recorded(),
            tried,
            best,
        })
    }

    /// The functions that fit, the one to take first.
    fn search(
        &self,
        record: &mut InputOutput,
        stop: &AtomicBool,
        steps: Steps<'_>,
    ) -> Result<Vec<Found>, Failure> {
        let going = || {
            if stop.load(Ordering::Relaxed) {
                Err(Failure::interrupted())
            } else {
                Ok(())
            }
        };
        let (held, delay) = (self.held, self.delay);
        steps("first guesses", 1, 0);
        find_start(record, held, delay);
        let guesses = match &self.model {
            Some(plant) => candidates_of(&plant.sum, record, held, delay, plant.delay),
            None => candidates(record, held, delay, self.wanted),
        };
        going()?;
        let (what, all) = ("functions", guesses.len());
        steps(what, all, 0);
        let done = |done| steps(what, all, done);
        let found = identify(record, &guesses, held, self.wanted, &done);
        going()?;
        found.map_err(|error| {
            let is_found = !matches!(error, ControlError::NotFound { .. });
            let is_asked = self.wanted != Wanted::default();
            // With a model that was given the error names it.
            if is_found || (self.model.is_some() && !is_asked) {
                return refused(error);
            }
            let other = remedies();
            Failure::run(if is_asked { format!("no function that was asked for fits the record: leave {POLES} or {STABLE} out, or {other}") } else { format!("no function fits the record: {other}") })
        })
    }
}

/// A plant that was found.
#[derive(Clone, Debug)]
pub struct PlantAnswer {
    /// Function, dead time and how certain they are, with warnings.
    pub report: PlantReport,
    /// The record, its input as it was recorded.
    pub record: InputOutput,
    /// The function on the second record.
    pub tried: Option<Tried>,
    best: Found,
    /// The state of the plant at the beginning of the record, in words.
    begins: String,
}

/// The fault of the columns of a table, and how they are named.
fn with_columns(wrong: &str, as_in: &str) -> String {
    format!("{wrong}; name the columns in {PLANT_COLUMNS}, as in {as_in}")
}

impl PlantAnswer {
    /// The function, its numbers with five digits.
    #[must_use]
    pub fn function(&self) -> String {
        rounded(&self.best.identified)
    }

    /// The output of the function at the times of the record.
    #[must_use]
    pub fn model(&self) -> &[f64] {
        &self.best.identified.model
    }

    /// The plant file: what was found in the record of this name, by this program.
    #[must_use]
    pub fn to_toml(&self, program: &str, name: &str) -> String {
        let (identified, samples) = (&self.best.identified, self.report.samples);
        let rms = digits(identified.rms_residual, 4);
        let begins = &self.begins;
        let note = format!("identified from {name}, {samples} samples, rms {rms}{begins}");
        let delay_s = identified.dead_time.seconds();
        function_file(&self.report.function, delay_s, program, &note)
    }
}
