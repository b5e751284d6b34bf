//! The questions of a page's panels.

#![expect(missing_docs, reason = "the protocol has them, by these names")]

use crate::control::{ControlRequest, designed};
use crate::form::Asker;
use crate::identify::{RecordRequest, explained, identified, plant};
use crate::wall::WallQuestion;
use haptic_document::Failure;
use serde::Deserialize;
use serde_json::Value;

/// A question of a panel.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PanelQuestion {
    Wall(WallQuestion),
    Control(ControlRequest),
    Analyze(ControlRequest),
    Simulate(ControlRequest),
    Record(Box<RecordRequest>),
    ExplainRecord(Box<RecordRequest>),
    PlantRecord(Box<RecordRequest>),
}

impl PanelQuestion {
    /// The answer, unless the asker gives it up.
    ///
    /// # Errors
    /// What is wrong with it, in a line.
    pub fn answer(&self, asker: &Asker<'_>) -> Result<Value, Failure> {
        match self {
            Self::Wall(wall) => wall.answer(asker.files),
            Self::Control(plant) => designed(plant),
            Self::Analyze(asked) => asked.analysed(),
            Self::Simulate(asked) => asked.simulated(),
            Self::Record(record) => identified(record, asker),
            Self::ExplainRecord(record) => explained(record),
            Self::PlantRecord(record) => plant(record, asker),
        }
    }
}
