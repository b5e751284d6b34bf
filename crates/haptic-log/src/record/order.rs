//! Ticks by their numbers, which need not be the order of their messages: a tick ahead of the next one is held back until that
//! has come, or too many are held. An ordinary log holds back none. Memory: [`HELD_MOST`] entries, given out together, 50 MB.

use super::Entry;
use std::collections::{BTreeMap, VecDeque};

/// Entries that are held back.
const HELD_MOST: usize = 1 << 16;

#[derive(Debug, Default)]
pub(super) struct InOrder {
    /// Entries by their tick, or the one that they stand behind; those of one tick as they came.
    held: BTreeMap<(u64, u64), Entry>,
    came: u64,
    /// The tick that is next, and the highest one that came.
    next: u64,
    highest: u64,
    /// Ticks that came behind a later one: those put in their place, and those whose place had passed or was taken.
    pub sorted: u64,
    pub out_of_order: u64,
}

impl InOrder {
    /// Takes in the next entry of the file, and gives what is next by the numbers.
    pub(super) fn take(&mut self, entry: Entry, ready: &mut VecDeque<Entry>) {
        self.came += 1;
        let tick = match &entry {
            Entry::Tick(message) | Entry::Drive(message) => Some(message.tick),
            Entry::Event(_) | Entry::Metadata(_) => None,
        };
        if let Some(tick) = tick {
            self.sorted += u64::from((self.next..self.highest).contains(&tick));
            self.highest = self.highest.max(tick);
        }
        // An ordinary log never enters the map, which would allocate for each of its entries.
        if tick.map_or(self.held.is_empty(), |tick| tick <= self.next) {
            ready.push_back(entry);
            tick.into_iter().for_each(|tick| self.pass(tick));
        } else {
            let place = (tick.unwrap_or(self.highest), self.came);
            self.held.insert(place, entry);
        }
        self.give(HELD_MOST, ready);
    }

    /// Gives what is next, and what is more than may be held: all of it at the end of the log.
    pub(super) fn give(&mut self, held_most: usize, ready: &mut VecDeque<Entry>) {
        while let Some((&(behind, _), entry)) = self.held.first_key_value() {
            if behind > self.next && self.held.len() <= held_most {
                break;
            }
            if matches!(entry, Entry::Tick(_) | Entry::Drive(_)) {
                self.pass(behind);
            }
            ready.extend(self.held.pop_first().map(|(_, entry)| entry));
        }
    }

    fn pass(&mut self, tick: u64) {
        self.out_of_order += u64::from(tick < self.next);
        self.next = self.next.max(tick.saturating_add(1));
    }
}
