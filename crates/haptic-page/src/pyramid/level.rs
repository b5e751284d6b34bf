//! One level: a ring of entries, each the least and largest of some samples.

use super::column::Columns;
use std::ops::Range;

/// Least and largest of the numbers of a sample or entry; NaN counts as none.
#[inline]
fn widen((least, largest): (f32, f32), (low, high): (f32, f32)) -> (f32, f32) {
    // `f32::min` and `max` give the other of a NaN and a number.
    (least.min(low), largest.max(high))
}

/// Nothing seen yet.
const NOTHING: (f32, f32) = (f32::NAN, f32::NAN);

#[derive(Clone, Debug)]
pub(super) struct Level {
    /// Samples of an entry.
    pub(super) ticks: u64,
    channels: usize,
    capacity: u64,
    /// Entry by entry, in it channel by channel.
    entries: Vec<(f32, f32)>,
}

impl Level {
    pub(super) fn new(channels: usize, capacity: usize, ticks: u64) -> Self {
        Self {
            ticks,
            channels,
            capacity: capacity as u64,
            // Numbers other than zero, so that the system has to give the memory now.
            entries: vec![NOTHING; channels * capacity],
        }
    }

    pub(super) fn clear(&mut self) {
        self.entries.fill(NOTHING);
    }

    fn place(&self, entry: u64) -> usize {
        (entry % self.capacity) as usize * self.channels
    }

    /// Takes the sample of a tick into its entry, which is begun anew with its first.
    #[inline]
    pub(super) fn push(&mut self, tick: u64, sample: &[f32]) {
        let place = self.place(tick / self.ticks);
        let begins = tick.is_multiple_of(self.ticks);
        let entry = &mut self.entries[place..place + self.channels];
        let numbers = sample.iter().copied().chain(std::iter::repeat(f32::NAN));
        for (held, number) in entry.iter_mut().zip(numbers) {
            let before = if begins { NOTHING } else { *held };
            *held = widen(before, (number, number));
        }
    }

    /// First tick that is remembered, of so many samples.
    pub(super) fn first_tick(&self, made: u64) -> u64 {
        let entries = made.div_ceil(self.ticks);
        entries.saturating_sub(self.capacity) * self.ticks
    }

    /// Least and largest of the entry of a tick.
    #[inline]
    pub(super) fn entry(&self, tick: u64, channel: usize) -> (f32, f32) {
        self.entries[self.place(tick / self.ticks) + channel]
    }

    /// Columns of `width` ticks, a multiple of an entry's, that hold the ticks of the span which are remembered.
    pub(super) fn columns(&self, span: Range<u64>, width: u64, made: u64) -> Columns {
        let start = span.start.max(self.first_tick(made));
        if start >= span.end {
            return Columns::none(self.channels);
        }
        let (first, last) = (start / width, (span.end - 1) / width);
        let count = (last - first + 1) as usize;
        let mut columns = Columns::empty(first * width, width, count, self.channels);
        let known = self.first_tick(made)..made;
        for column in 0..count {
            let begin = (first + column as u64) * width;
            let ticks = begin.max(known.start)..(begin + width).min(known.end);
            let entries = ticks.start / self.ticks..ticks.end.div_ceil(self.ticks);
            for entry in entries {
                let place = self.place(entry);
                for (channel, &held) in self.entries[place..][..self.channels].iter().enumerate() {
                    let (least, largest) = (
                        2 * channel * count + column,
                        (2 * channel + 1) * count + column,
                    );
                    let numbers = &mut columns.numbers;
                    let both = widen((numbers[least], numbers[largest]), held);
                    (numbers[least], numbers[largest]) = both;
                }
            }
        }
        columns
    }
}
