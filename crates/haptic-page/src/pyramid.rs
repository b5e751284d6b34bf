//! Samples of a loop in levels of minimum and maximum, in bounded memory: zooming out costs what zooming in does.
//!
//! ```text
//! level 0   x x x x x x x x x x x x x x x x      each sample, the newest of them
//! level 1   [·····] [·····] [·····] [·····]      least and largest of 4
//! level 2   [·····························]      of 16, and so on: the coarser, the further back
//! ```
//! - *No peak is lost*: an entry holds the least and the largest number of all its samples, NaN left out.
//! - *Every sample counts*: an entry that is not yet full is seen too.
//! - *Memory* is taken and touched at the start and does not grow. A level is a ring: it forgets its oldest entry.
//! - *Cost*: a sample some comparisons for each channel; a view at most [`ENTRIES_MOST`] entries a column.

mod column;
mod level;
#[cfg(test)]
mod tests;

pub use column::{Columns, Span};
use level::Level;

/// Samples of an entry, from one level to the next.
pub const FACTOR: u64 = 4;
/// Entries of a level that a column is made of, at most.
pub const ENTRIES_MOST: u64 = 16;

/// Lengths of a pyramid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PyramidSize {
    /// Channels of a sample.
    pub channels: usize,
    /// Samples that level 0 remembers, at least 1.
    pub samples: usize,
    /// Entries that each coarser level remembers, at least 1.
    pub entries: usize,
    /// Levels above level 0, at most 12.
    pub coarser: u32,
}

impl PyramidSize {
    /// 8.7 minutes of samples and 9.3 hours of entries at 1 kHz; 6.3 MB a channel.
    #[must_use]
    pub const fn usual(channels: usize) -> Self {
        Self {
            channels,
            samples: 1 << 19,
            entries: 1 << 17,
            coarser: 4,
        }
    }
}

/// The levels. Samples have ticks 0, 1, 2, …
///
/// ```
/// use haptic_page::pyramid::{Pyramid, PyramidSize, Span};
///
/// let mut pyramid = Pyramid::new(PyramidSize::usual(1));
/// for tick in 0..10_000 {
///     pyramid.push(&[if tick == 7123 { 5.0 } else { 0.0 }]);
/// }
/// let columns = pyramid.columns(Span::new(0, 10_000, 10));
/// let peak = (7123 / columns.width()) as usize;
/// assert_eq!((columns.count(), columns.largest(0)[peak]), (10, 5.0));
/// ```
#[derive(Clone, Debug)]
pub struct Pyramid {
    size: PyramidSize,
    levels: Vec<Level>,
    /// Samples so far.
    made: u64,
}

impl Pyramid {
    /// An empty one. Its memory is touched here, so that it does not grow later.
    #[must_use]
    pub fn new(size: PyramidSize) -> Self {
        let coarser = size.coarser.min(12);
        let level = |number: u32| {
            let entries = if number == 0 {
                size.samples
            } else {
                size.entries
            };
            Level::new(size.channels, entries.max(1), FACTOR.pow(number))
        };
        Self {
            size,
            levels: (0..=coarser).map(level).collect(),
            made: 0,
        }
    }

    /// Forgets all samples; the next has tick 0.
    pub fn clear(&mut self) {
        self.levels.iter_mut().for_each(Level::clear);
        self.made = 0;
    }

    /// Takes a sample in. Channels that are missing are NaN, those too many are left out.
    pub fn push(&mut self, sample: &[f32]) {
        for level in &mut self.levels {
            level.push(self.made, sample);
        }
        self.made += 1;
    }

    /// Samples so far, forgotten ones too.
    #[must_use]
    pub const fn made(&self) -> u64 {
        self.made
    }

    /// Channels of a sample.
    #[must_use]
    pub const fn channels(&self) -> usize {
        self.size.channels
    }

    /// First tick that level 0 still has.
    #[must_use]
    pub fn first_sample(&self) -> u64 {
        self.levels[0].first_tick(self.made)
    }

    /// First tick that any level still has.
    #[must_use]
    pub fn first_tick(&self) -> u64 {
        let firsts = self.levels.iter().map(|level| level.first_tick(self.made));
        firsts.min().unwrap_or(self.made)
    }

    /// Samples of a channel from a tick on, as far as level 0 has them, put into `out`; the tick of the first of them.
    pub fn samples_from(&self, tick: u64, channel: usize, out: &mut Vec<f32>) -> u64 {
        out.clear();
        let first = tick.max(self.first_sample()).min(self.made);
        out.extend((first..self.made).map(|tick| self.levels[0].entry(tick, channel).0));
        first
    }

    /// Least and largest of each channel in columns of the same width.
    ///
    /// Of the levels that reach back as far as the span does, the coarsest is taken that gives at least
    /// [`ENTRIES_MOST`]`/`[`FACTOR`] entries a column, so a width is rounded up by a quarter at most; where none reaches so far, the one that
    /// reaches furthest.
    #[must_use]
    pub fn columns(&self, span: Span) -> Columns {
        let end = span.end.min(self.made);
        let start = span.start.min(end);
        let wanted = span.width();
        let fine =
            |level: &&Level| level.ticks == 1 || level.ticks * (ENTRIES_MOST / FACTOR) <= wanted;
        let reaches = |level: &&Level| level.first_tick(self.made) <= start;
        let level = self.levels.iter().rev().filter(fine).find(reaches);
        // What is forgotten there is looked for in coarser ones, finest first.
        let level = level.or_else(|| self.levels.iter().find(reaches));
        let level = level.or_else(|| {
            self.levels
                .iter()
                .min_by_key(|level| level.first_tick(self.made))
        });
        match level {
            Some(level) => {
                let width = wanted.div_ceil(level.ticks) * level.ticks;
                level.columns(start..end, width, self.made)
            }
            None => Columns::none(self.size.channels),
        }
    }
}
