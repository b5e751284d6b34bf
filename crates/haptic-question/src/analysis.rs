//! Analyses of a wall, a coupler or two hands over a line: what is stable, passive and felt, before anything is tried.

mod admittance;
mod answer;
mod difference;
pub mod felt;
pub mod keys;
pub mod law;
mod map;
pub mod teleoperation;
pub mod wall;

use crate::analysis::admittance::MovingDevice;
pub(crate) use crate::analysis::admittance::{RUN_S, RobotTap};
pub use crate::analysis::answer::{
    AdmittancePoint, Analysed, BodyPoint, DifferencePoint, Drawn, FeltPoint, HandPoint, Kind,
    Region, SensitivityPoint, StableBodies, StableHands, decibel, logarithmic, rate,
    sample_time_of,
};
use crate::analysis::difference::Difference;
use crate::analysis::felt::{CouplerNeed, Felt};
pub use crate::analysis::keys::*;
use crate::analysis::teleoperation::HandsQuestion;
use crate::analysis::wall::WallLoop;
use haptic_document::Warn;
use haptic_document::parameters::KeyTable;
use haptic_document::{Failure, ReadDocument, Table};
use serde_json::Value;
use std::sync::atomic::AtomicBool;

/// Reads the table of an analysis.
type Read = fn(&Table<'_>, ReadDocument) -> Result<Inquiry, Failure>;

/// Analyses: the name of the table, its keys and its reader.
const ANALYSES: [(&str, &[KeyTable], Read); 10] = [
    ("analyze-admittance", ADMITTANCE, |table, _| {
        MovingDevice::of(table).map(|asked| Inquiry::Admittance(Box::new(asked)))
    }),
    ("analyze-environment", ENVIRONMENT, |table, _| {
        Felt::of(table).map(Inquiry::Felt)
    }),
    ("analyze-stability", STABILITY, |table, _| {
        Ok(Inquiry::Wall(WallLoop::needed(table)?, WallLoop::stability))
    }),
    ("analyze-stability-region", STABILITY, |table, _| {
        Ok(Inquiry::Wall(WallLoop::sought(table)?, WallLoop::region))
    }),
    ("analyze-passivity", STABILITY, |table, _| {
        Ok(Inquiry::Wall(WallLoop::needed(table)?, WallLoop::passivity))
    }),
    ("analyze-coupling", COUPLING, |table, _| {
        CouplerNeed::of(table).map(Inquiry::Coupling)
    }),
    ("analyze-teleoperation", HANDS, |table, _| {
        HandsQuestion::of(table).map(Inquiry::Teleoperation)
    }),
    ("analyze-transparency", TRANSPARENCY, |table, _| {
        Felt::through_device(table).map(Inquiry::Felt)
    }),
    ("analyze-difference", DIFFERENCE, |table, read| {
        Difference::of(table, read).map(|asked| Inquiry::Difference(Box::new(asked)))
    }),
    ("analyze-sensitivity", SENSITIVITY, |table, _| {
        Ok(Inquiry::Wall(
            WallLoop::needed(table)?,
            WallLoop::sensitivity,
        ))
    }),
];

/// An analysis, all of its parameters checked.
#[derive(Clone, Debug)]
pub struct Analysis(Inquiry);

#[derive(Clone, Debug)]
enum Inquiry {
    Admittance(Box<MovingDevice>),
    Felt(Felt),
    Wall(WallLoop, Asked),
    Coupling(CouplerNeed),
    Teleoperation(HandsQuestion),
    Difference(Box<Difference>),
}

/// A question to the loop of a wall.
type Asked = fn(&WallLoop, Warn<'_>) -> Result<Analysed, Failure>;

/// The keys of the analysis of this name; `None` of another name.
#[must_use]
pub fn tables(kind: &str) -> Option<&'static [KeyTable]> {
    let mut known = ANALYSES.iter();
    known.find(|known| known.0 == kind).map(|known| known.1)
}

impl Analysis {
    /// The analysis of this name by its table; `None` of another name. `read` reads the file of a law that a key names.
    ///
    /// # Errors
    /// If a key is wrong: in one line, with its place.
    #[must_use]
    pub fn read(
        kind: &str,
        table: &Table<'_>,
        read: ReadDocument,
    ) -> Option<Result<Self, Failure>> {
        let mut known = ANALYSES.iter();
        let (_, _, of) = known.find(|known| known.0 == kind)?;
        Some(of(table, read).map(Self))
    }

    /// Number of steps in the reported progress.
    #[must_use]
    pub const fn steps(&self) -> u64 {
        match &self.0 {
            Inquiry::Teleoperation(asked) => asked.steps(),
            Inquiry::Admittance(asked) => asked.steps(),
            Inquiry::Felt(_)
            | Inquiry::Wall(..)
            | Inquiry::Coupling(_)
            | Inquiry::Difference(_) => 1,
        }
    }

    /// A wall among all walls of its device: outlines of about so many points, margins, noise and curves, as a page draws them.
    ///
    /// # Errors
    /// Another question than one to the loop of a wall with units; a wall that cannot be analysed.
    pub fn wall_map(&self, points: usize, position_noise_m: f64) -> Result<Value, Failure> {
        if let Inquiry::Wall(wall, _) = &self.0 {
            return wall.map(points, position_noise_m);
        }
        Err(Failure::bad_input("only a wall has a map"))
    }

    /// Answers the question; `warn` hears what is not as asked.
    ///
    /// # Errors
    /// A loop that cannot be analysed; a search that was stopped.
    pub fn answer(
        &self,
        progress: &(dyn Fn(u64) + Sync),
        stop: &AtomicBool,
        warn: Warn<'_>,
    ) -> Result<Analysed, Failure> {
        match &self.0 {
            Inquiry::Admittance(asked) => asked.answer(progress, stop),
            Inquiry::Felt(felt) => felt.answer(warn),
            Inquiry::Wall(wall, asked) => asked(wall, warn),
            Inquiry::Coupling(coupler) => coupler.answer(),
            Inquiry::Teleoperation(asked) => asked.answer(progress, stop),
            Inquiry::Difference(asked) => asked.answer(),
        }
    }
}
