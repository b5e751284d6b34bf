//! Analyses of a wall, a coupler or two hands over a line: what is stable, passive and felt, before anything is tried.

mod answer;
mod difference;
pub(crate) mod felt;
pub(crate) mod keys;
pub(crate) mod law;
mod map;
pub(crate) mod teleoperation;
pub(crate) mod wall;

use crate::run::device::Warn;
pub use answer::{
    Analysed, DifferencePoint, Drawn, FeltPoint, HandPoint, Kind, Region, SensitivityPoint,
    decibel, logarithmic, rate, sample_time_of,
};
use difference::Difference;
use felt::{CouplerNeed, Felt};
use haptic_document::parameters::KeyTable;
use haptic_document::{Failure, Table};
pub use keys::*;
use std::sync::atomic::AtomicBool;
use teleoperation::HandsQuestion;
use wall::WallLoop;

/// Reads the table of an analysis.
type Read = fn(&Table<'_>) -> Result<Analysis, Failure>;

/// Analyses: the name of the table, its keys and its reader.
pub(crate) const ANALYSES: [(&str, &[KeyTable], Read); 9] = [
    ("analyze-environment", ENVIRONMENT, |table| {
        Felt::of(table).map(Analysis::Felt)
    }),
    ("analyze-stability", STABILITY, |table| {
        Ok(Analysis::Wall(
            WallLoop::needed(table)?,
            WallLoop::stability,
        ))
    }),
    ("analyze-stability-region", STABILITY, |table| {
        Ok(Analysis::Wall(WallLoop::sought(table)?, WallLoop::region))
    }),
    ("analyze-passivity", STABILITY, |table| {
        Ok(Analysis::Wall(
            WallLoop::needed(table)?,
            WallLoop::passivity,
        ))
    }),
    ("analyze-coupling", COUPLING, |table| {
        CouplerNeed::of(table).map(Analysis::Coupling)
    }),
    ("analyze-teleoperation", HANDS, |table| {
        HandsQuestion::of(table).map(Analysis::Teleoperation)
    }),
    ("analyze-transparency", TRANSPARENCY, |table| {
        Felt::through_device(table).map(Analysis::Felt)
    }),
    ("analyze-difference", DIFFERENCE, |table| {
        Difference::of(table).map(|asked| Analysis::Difference(Box::new(asked)))
    }),
    ("analyze-sensitivity", SENSITIVITY, |table| {
        Ok(Analysis::Wall(
            WallLoop::needed(table)?,
            WallLoop::sensitivity,
        ))
    }),
];

/// An analysis, all of its parameters checked.
#[derive(Clone, Debug)]
pub(crate) enum Analysis {
    Felt(Felt),
    Wall(WallLoop, Asked),
    Coupling(CouplerNeed),
    Teleoperation(HandsQuestion),
    Difference(Box<Difference>),
}

/// A question to the loop of a wall.
type Asked = fn(&WallLoop, Warn<'_>) -> Result<Analysed, Failure>;

impl Analysis {
    pub(crate) const fn steps(&self) -> u64 {
        match self {
            Self::Teleoperation(asked) => asked.steps(),
            Self::Felt(_) | Self::Wall(..) | Self::Coupling(_) | Self::Difference(_) => 1,
        }
    }

    pub(crate) fn answer(
        &self,
        progress: &(dyn Fn(u64) + Sync),
        stop: &AtomicBool,
        warn: Warn<'_>,
    ) -> Result<Analysed, Failure> {
        match self {
            Self::Felt(felt) => felt.answer(warn),
            Self::Wall(wall, asked) => asked(wall, warn),
            Self::Coupling(coupler) => coupler.answer(),
            Self::Teleoperation(asked) => asked.answer(progress, stop),
            Self::Difference(asked) => asked.answer(),
        }
    }
}
