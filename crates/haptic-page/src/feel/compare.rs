//! Compare: two walls or tissues under one handle, blind; which of the two is the stiffer?
//! ```text
//! each trial: wall 1 ─the handle leaves─▶ wall 2 ─▶ answer ─▶ a row of the table      B is 1 or 2: drawn from the seed
//!               └ rating                    └ rating                                  if a scale was given
//! ```
//! - *A* is what was felt before, *B* that with a change, or another tissue. Both are judged before the first trial.
//! - *A wall begins* with an empty memory, as soon as the handle is in front of it and free of force; until then the one before it is felt.
//! - *The stiffer one* is that at all speeds of a hand; if neither is, no answer is right, and those cells are empty.
//! - *A row* is on the disk with its answer; the log has every tick.

use crate::folder::next_folder;
use fracdiff::Seconds;
use haptic_answer::feel::{FeelSettings, FeltThing};
use haptic_answer::request::CompareStart;
use haptic_experiment::Failure;
use haptic_experiment::live::{Finished, Recording, Ticked};
use haptic_experiment::parameters::Range;
use haptic_judge::felt::{FeltSummary, Tally};
use haptic_log::record::LineFile;
use haptic_quantity::short;
use rand_pcg::Pcg32;
use rand_pcg::rand_core::{Rng as _, SeedableRng as _};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;

const TRIALS: Range = Range::Within(1.0, 1000.0);
/// Columns of the table, as those of the guide's threshold.
const COLUMNS: &str = "subject,trial,catch,difference,stiffer,answer,correct,log,answered_s,\
                       first_tick,first_peak_n,first_deepest_m,second_tick,second_peak_n,second_deepest_m,\
                       first_rating,second_rating";

/// A comparison that goes on, or its result.
#[derive(Debug)]
pub(crate) struct Comparison {
    /// A and B.
    walls: [FeelSettings; 2],
    /// Difference of B's stiffness over that of A; `None` if neither is the stiffer one.
    difference: Option<f64>,
    /// Least and most of a rating.
    scale: Option<[f64; 2]>,
    subject: String,
    /// True if B is the second wall, trial by trial.
    b_is_second: Vec<bool>,
    trial: usize,
    right: usize,
    /// Sums over each wall of this trial.
    felt: Vec<Tally>,
    /// A rating of each wall that was felt.
    ratings: Vec<f64>,
    /// The walls that were asked for so far.
    number: u64,
    /// Newest time of the loop, s.
    time_s: f64,
    name: String,
    table: LineFile,
    /// `None` after the end.
    recording: Option<Recording>,
}

/// Text of a cell of the table, empty without a number.
fn cell(number: Option<impl ToString>) -> String {
    number.map_or_else(String::new, |number| number.to_string())
}

impl Comparison {
    /// Begins a table and a log in the next free folder of the runs; these metadata are of A.
    pub(super) fn start(
        start: CompareStart,
        walls: [FeelSettings; 2],
        mut metadata: BTreeMap<String, String>,
        (runs, provenance): (&Path, &BTreeMap<String, String>),
    ) -> Result<Self, Failure> {
        let CompareStart {
            trials,
            subject,
            seed,
            rating_scale: scale,
            ..
        } = start;
        if !(TRIALS.contains(trials) && trials.fract() == 0.0) {
            return Err(Failure::bad_input(format_args!(
                "`trials` = {trials} is not a whole number {TRIALS}: change it"
            )));
        }
        let is_code = |c: char| c.is_ascii_alphanumeric() || "-_".contains(c);
        if subject.is_empty() || subject.len() > 32 || !subject.chars().all(is_code) {
            return Err(Failure::bad_input(format_args!(
                "`subject` = {} is not a code of 1 to 32 letters, digits, - or _: use one as p07",
                short(&subject)
            )));
        }
        if let Some([least, most]) = scale
            && least >= most
        {
            return Err(Failure::bad_input(format_args!(
                "`rating_scale` = [{least}, {most}] does not rise: give its least and its most"
            )));
        }
        let difference = walls[1].stiffer_by(&walls[0])?;
        let mut chance = Pcg32::seed_from_u64(seed.into());
        let b_is_second = (0..trials as usize).map(|_| chance.next_u32() >> 31 == 1);
        let (request, name) = next_folder(runs, "compare", provenance)?;
        for (key, value) in [("experiment", "compare"), ("subject", &subject)] {
            metadata.insert(key.to_owned(), value.to_owned());
        }
        metadata.insert("seed".to_owned(), seed.to_string());
        // It is no wall that could be run again.
        metadata.remove("document");
        let recording = Recording::start(&request, name.clone(), metadata)?;
        let (table, _) = LineFile::open(&runs.join(format!("{name}.csv")), COLUMNS)?;
        Ok(Self {
            walls,
            difference,
            scale,
            subject,
            b_is_second: b_is_second.collect(),
            trial: 0,
            right: 0,
            felt: Vec::new(),
            ratings: Vec::new(),
            number: 0,
            time_s: 0.0,
            name,
            table,
            recording: Some(recording),
        })
    }

    pub(super) const fn goes_on(&self) -> bool {
        self.recording.is_some()
    }

    /// Takes a tick; the end of the log, if its writer has ended.
    pub(super) fn tick(
        &mut self,
        ticked: &Ticked,
        energy_j: f64,
    ) -> Option<Result<Finished, Failure>> {
        let recording = self.recording.as_mut()?;
        if !recording.tick(ticked, energy_j) {
            return self.end();
        }
        let reading = &ticked.sample.reading;
        self.time_s = reading.time_s;
        let at = recording.at(ticked);
        let force_n = ticked.sample.force.newtons()[0];
        for tally in &mut self.felt {
            tally.see(ticked.stimulus, at, reading.position_m[0], force_n);
        }
        None
    }

    /// The wall that is next in this trial, and its number among all.
    pub(super) fn next(&mut self, t: Seconds) -> Result<(FeelSettings, u64), Failure> {
        let wall = self.felt.len();
        if wall == 2 {
            return Err(Failure::bad_input(
                "both walls were there: send `compare.answer`",
            ));
        }
        self.judged()?;
        self.number += 1;
        self.felt.push(Tally::of(self.number, 0.0, None, t));
        let is_b = (wall == 1) == self.b_is_second[self.trial];
        let settings = self.walls[usize::from(is_b)].clone();
        let ((k, b), law) = (settings.gains(), &settings.law);
        let tissue = match &settings.environment {
            FeltThing::Tissue(name) => format!("tissue {name}, "),
            FeltThing::Wall(_) | FeltThing::File(_) | FeltThing::Run(_) => String::new(),
        };
        let text = format!(
            "trial {}, wall {}: {tissue}order {}, K {k} N/m, B {b} N·s^μ/m",
            self.trial,
            wall + 1,
            law.order
        );
        self.event("feel", text);
        Ok((settings, self.number))
    }

    fn event(&mut self, kind: &str, text: String) {
        if let Some(recording) = &mut self.recording {
            recording.event(self.time_s, kind, text);
        }
    }

    /// Refuses to go on before the newest wall was touched.
    fn touched(&self) -> Result<(), Failure> {
        match self.felt.last() {
            Some(tally) if tally.summary().contacts == 0 => Err(Failure::bad_input(format_args!(
                "wall {} was not touched yet: press it first",
                self.felt.len()
            ))),
            _ => Ok(()),
        }
    }

    /// Refuses to go on before the newest wall was touched and, with a scale, rated.
    fn judged(&self) -> Result<(), Failure> {
        self.touched()?;
        if self.scale.is_some() && self.ratings.len() < self.felt.len() {
            return Err(Failure::bad_input(format_args!(
                "wall {} was not rated yet: send `compare.rate`",
                self.felt.len()
            )));
        }
        Ok(())
    }

    /// Takes the rating of the newest wall.
    pub(super) fn rate(&mut self, rating: f64) -> Result<(), Failure> {
        let Some([least, most]) = self.scale else {
            return Err(Failure::bad_input(
                "this comparison asks for no ratings: give `compare.start` a `rating_scale`",
            ));
        };
        self.touched()?;
        let wall = self.felt.len();
        if self.ratings.len() == wall {
            return Err(Failure::bad_input(if wall == 0 {
                "a rating before a wall was felt: send `compare.feel`"
            } else {
                "this wall has its rating: send `compare.feel` or `compare.answer`"
            }));
        }
        if !(least..=most).contains(&rating) {
            return Err(Failure::bad_input(format_args!(
                "`rating` = {rating} is not in [{least}, {most}]: give one that is"
            )));
        }
        let said = json!({"question": "rating", "rating": rating, "scale": [least, most]});
        self.event("rating", said.to_string());
        self.ratings.push(rating);
        Ok(())
    }

    /// The trial begins with its first wall again.
    pub(super) fn again(&mut self) {
        self.felt.clear();
        self.ratings.clear();
    }

    /// Writes the row of this trial; true if it was the last.
    pub(super) fn answer(&mut self, answer: u8) -> Result<bool, Failure> {
        if !(1..=2).contains(&answer) {
            return Err(Failure::bad_input(format_args!(
                "`stiffer` = {answer} is not 1 or 2: answer with the number of a wall"
            )));
        }
        let &[first, second] = &self.felt[..] else {
            return Err(Failure::bad_input(
                "an answer before both walls were felt: send `compare.feel`",
            ));
        };
        self.judged()?;
        self.event("answer", answer.to_string());
        let [first, second] = [first.summary(), second.summary()];
        let is_second = self.b_is_second[self.trial];
        let stiffer = (self.difference).map(|by| 1 + u8::from(is_second == (by > 0.0)));
        let is_right = stiffer.map(|stiffer| answer == stiffer);
        let felt = |felt: FeltSummary| {
            let peak_n = felt.peak_force_n.unwrap_or(0.0);
            format!("{},{peak_n},{}", felt.tick, felt.deepest_m)
        };
        let rated = |wall: usize| cell(self.ratings.get(wall));
        let log = self.name.rsplit('/').next().unwrap_or_default();
        let row = format!(
            "{},{},0,{},{},{answer},{},{log}.mcap,{},{},{},{},{}",
            self.subject,
            self.trial,
            cell(self.difference),
            cell(stiffer),
            cell(is_right.map(u8::from)),
            second.time_s + second.duration_s,
            felt(first),
            felt(second),
            rated(0),
            rated(1)
        );
        self.table.add(&row)?;
        self.trial += 1;
        self.right += usize::from(is_right == Some(true));
        self.again();
        Ok(self.trial == self.b_is_second.len())
    }

    /// Closes the log, if it is open: its samples.
    pub(super) fn end(&mut self) -> Option<Result<Finished, Failure>> {
        Some(self.recording.take()?.finish())
    }

    /// Facts for the page: none of the order, and before the end no count of right answers.
    pub(crate) fn status(&self) -> Value {
        let goes_on = self.goes_on();
        json!({
            "running": goes_on,
            "trial": self.trial,
            "trials": self.b_is_second.len(),
            "wall": self.felt.len(),
            "touched": self.touched().is_ok(),
            "rating_scale": self.scale,
            "rated": self.ratings.len(),
            "right": self.difference.filter(|_| !goes_on).map(|_| self.right),
            "table": format!("{}.csv", self.name),
        })
    }
}
