//! The history of a bank as data.

use super::bank::BankHistory;
use crate::Real;
use serde::{Deserialize, Serialize};

#[derive(Serialize, Deserialize)]
#[serde(rename = "BankHistory")]
#[serde(bound = "F: Real")]
pub(super) struct Saved<F, const TAPS: usize, const MODES: usize> {
    #[serde(with = "crate::saved")]
    due: [F; TAPS],
    #[serde(with = "crate::saved")]
    states: [F; MODES],
    #[serde(with = "crate::saved")]
    carries: [F; MODES],
    turn: u32,
    past: F,
}

impl<F: Real, const TAPS: usize, const MODES: usize> From<BankHistory<F, TAPS, MODES>>
    for Saved<F, TAPS, MODES>
{
    fn from(history: BankHistory<F, TAPS, MODES>) -> Self {
        Self {
            due: history.due,
            states: history.states,
            carries: history.carries,
            // Below MODES.
            turn: history.turn as u32,
            past: history.past,
        }
    }
}

impl<F: Real, const TAPS: usize, const MODES: usize> TryFrom<Saved<F, TAPS, MODES>>
    for BankHistory<F, TAPS, MODES>
{
    type Error = &'static str;

    fn try_from(saved: Saved<F, TAPS, MODES>) -> Result<Self, &'static str> {
        let turn = saved.turn as usize;
        if turn >= MODES.max(1) {
            return Err("the turn of a history is not one of its modes");
        }
        Ok(Self {
            due: saved.due,
            states: saved.states,
            carries: saved.carries,
            turn,
            past: saved.past,
        })
    }
}
