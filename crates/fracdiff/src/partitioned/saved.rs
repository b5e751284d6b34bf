//! The history of a level as data.

use super::FIRST;
use super::level::{LevelHistory, Schedule};
use crate::Real;
use crate::fft::{Bins, LANES};
use alloc::vec::Vec;
use serde::{Deserialize, Serialize};

/// The work done and owed follows from the tick.
#[derive(Serialize, Deserialize)]
#[serde(rename = "LevelHistory")]
#[serde(bound = "F: Real")]
pub(super) struct Saved<F> {
    before: Vec<F>,
    coming: Vec<Bins<F>>,
    work: Vec<Bins<F>>,
    going: Vec<Bins<F>>,
    spectra: Vec<Bins<F>>,
    newest: usize,
    tick: usize,
}

impl<F: Real> From<LevelHistory<F>> for Saved<F> {
    fn from(history: LevelHistory<F>) -> Self {
        Self {
            before: history.before,
            coming: history.coming,
            work: history.work,
            going: history.going,
            spectra: history.spectra,
            newest: history.newest,
            tick: history.tick,
        }
    }
}

impl<F: Real> TryFrom<Saved<F>> for LevelHistory<F> {
    type Error = &'static str;

    fn try_from(saved: Saved<F>) -> Result<Self, &'static str> {
        let length = saved.before.len();
        let blocks = length / LANES;
        if length < FIRST || !length.is_power_of_two() {
            return Err("the block of a history is not 32, 64, 128, … samples long");
        }
        if [&saved.coming, &saved.work, &saved.going]
            .iter()
            .any(|bins| bins.len() != blocks)
        {
            return Err("the blocks of a history differ in length");
        }
        let partitions = saved.spectra.len() / blocks;
        if partitions == 0 || !saved.spectra.len().is_multiple_of(blocks) {
            return Err("the spectra of a history are no whole blocks");
        }
        if saved.newest >= partitions || saved.tick >= length {
            return Err("a position of a history is outside it");
        }
        let done = saved.tick * Schedule::new(blocks, partitions).units();
        Ok(Self {
            before: saved.before,
            coming: saved.coming,
            work: saved.work,
            going: saved.going,
            spectra: saved.spectra,
            newest: saved.newest,
            tick: saved.tick,
            unit: done / length,
            owed: done % length,
        })
    }
}
