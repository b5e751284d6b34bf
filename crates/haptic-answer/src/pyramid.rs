//! Samples of a loop in levels of minimum and maximum, in bounded memory: zooming out costs what zooming in does.
//! ```text
//! level 0   x x x x x x x x x x x x x x x x      each sample, the newest of them
//! level 1   [·····] [·····] [·····] [·····]      least and largest of 4
//! level 2   [·····························]      of 16, and so on: the coarser, the further back
//! ```
//! - *No peak is lost*: an entry holds the least and the largest number of all its samples, NaN left out.
//! - *Pairs stay pairs*: a channel that follows another holds its numbers at the two samples where the other is least and largest.
//!   Extremes of two channels are of different moments, and a curve of one over the other through them goes where no sample was.
//! - *Every sample counts*: an entry that is not yet full is seen too.
//! - *Memory* is taken and touched at the start and does not grow. A level is a ring: it forgets its oldest entry.
//! - *Cost*: a sample some comparisons for each channel; a view at most [`ENTRIES_MOST`] entries a column.

use std::ops::Range;

/// Samples of an entry, from one level to the next.
pub const FACTOR: u64 = 4;
/// Entries of a level that a column is made of, at most.
pub const ENTRIES_MOST: u64 = 16;

/// Size of the levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PyramidSize<'a> {
    /// Numbers of a sample.
    pub channels: usize,
    /// The channels that the last ones of a sample follow.
    pub follows: &'a [usize],
    /// Samples that level 0 remembers, at least 1.
    pub samples: usize,
    /// Entries that each coarser level remembers, at least 1.
    pub entries: usize,
    /// Levels above level 0, at most 12.
    pub coarser: u32,
}

impl PyramidSize<'_> {
    /// 8.7 minutes of samples and 9.3 hours of entries at 1 kHz; 6.3 MB a channel.
    pub const fn usual(channels: usize) -> Self {
        Self {
            channels,
            follows: &[],
            samples: 1 << 19,
            entries: 1 << 17,
            coarser: 4,
        }
    }
}

/// The levels. Samples have ticks 0, 1, 2, …
#[derive(Clone, Debug)]
pub struct Pyramid {
    levels: Vec<Level>,
    made: u64,
    begun: u64,
}

impl Pyramid {
    /// An empty one. Its memory is touched here, so that it does not grow later.
    pub fn new(size: PyramidSize<'_>) -> Self {
        let coarser = size.coarser.min(12);
        let level = |number: u32| {
            let entries = if number == 0 {
                size.samples
            } else {
                size.entries
            };
            Level::new(size, entries.max(1), FACTOR.pow(number))
        };
        Self {
            levels: (0..=coarser).map(level).collect(),
            made: 0,
            begun: 0,
        }
    }

    /// Forgets all samples; the next has tick 0. What stands in the entries is seen no more: each is begun anew with its first sample.
    pub const fn clear(&mut self) {
        self.made = 0;
        self.begun += 1;
    }

    /// Number of restarts with an empty memory: ticks of equal number belong to equal samples only if this is equal too.
    pub const fn begun(&self) -> u64 {
        self.begun
    }

    /// Takes a sample in. Channels that are missing are NaN, those too many are left out.
    pub fn push(&mut self, sample: &[f32]) {
        for level in &mut self.levels {
            level.push(self.made, sample);
        }
        self.made += 1;
    }

    /// Samples so far, forgotten ones too.
    pub const fn made(&self) -> u64 {
        self.made
    }

    /// Samples of a channel from a tick on, as far as level 0 has them, put into `out`; the tick of the first of them.
    pub fn samples_from(&self, tick: u64, channel: usize, out: &mut Vec<f32>) -> u64 {
        out.clear();
        let first = tick
            .max(self.levels[0].first_tick(self.made))
            .min(self.made);
        out.extend((first..self.made).map(|tick| self.levels[0].entry(tick, channel).0));
        first
    }

    /// Least and largest of each channel in columns of the same width.
    ///
    /// Of the levels that reach back as far as the span does, the coarsest is taken that gives at least [`ENTRIES_MOST`]`/`[`FACTOR`]
    /// entries a column, so a width is rounded up by a quarter at most; where none reaches so far, the one that reaches furthest.
    pub fn columns(&self, span: ViewSpan) -> ViewColumns {
        let end = span.end.min(self.made);
        let start = span.start.min(end);
        let wanted = span.width();
        let fine =
            |level: &&Level| level.ticks == 1 || level.ticks * (ENTRIES_MOST / FACTOR) <= wanted;
        let reaches = |level: &&Level| level.first_tick(self.made) <= start;
        let level = self.levels.iter().rev().filter(fine).find(reaches);
        // A start that this level has forgotten is looked for in coarser ones, finest first.
        let level = level.or_else(|| self.levels.iter().find(reaches));
        let level = level.or_else(|| {
            self.levels
                .iter()
                .min_by_key(|level| level.first_tick(self.made))
        });
        match level {
            Some(level) => {
                let width = wanted.div_ceil(level.ticks) * level.ticks;
                level.columns(start.max(span.since.min(end))..end, width, self.made)
            }
            None => ViewColumns::empty(0, 1, 0, self.levels[0].channels),
        }
    }
}

/// A span of ticks, and the number of columns wished for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ViewSpan {
    start: u64,
    end: u64,
    columns: u64,
    /// No column that ends before this tick.
    since: u64,
}

impl ViewSpan {
    /// Span from `start` on, before `end`, in `columns` columns or a few less; 0 counts as 1.
    pub fn new(start: u64, end: u64, columns: u32) -> Self {
        Self {
            start,
            end: end.max(start),
            columns: u64::from(columns.max(1)),
            since: 0,
        }
    }

    /// Span with only those of the same columns from that of this tick on.
    pub const fn since(self, tick: u64) -> Self {
        Self {
            since: tick,
            ..self
        }
    }

    /// Ticks of a column as wished, at least 1.
    fn width(self) -> u64 {
        (self.end - self.start).div_ceil(self.columns).max(1)
    }
}

/// Least and largest of each channel, column by column.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewColumns {
    /// First tick of the first column, a multiple of the width.
    pub first_tick: u64,
    /// Ticks of a column.
    pub width: u64,
    /// The number of columns.
    pub count: usize,
    /// The number of channels.
    pub channels: usize,
    /// Numbers of each channel: first all least, then all largest.
    pub numbers: Vec<f32>,
}

impl ViewColumns {
    /// `count` columns without a number.
    fn empty(first_tick: u64, width: u64, count: usize, channels: usize) -> Self {
        Self {
            first_tick,
            width,
            count,
            channels,
            numbers: vec![f32::NAN; 2 * channels * count],
        }
    }

    /// The least of a channel in each column; NaN in an empty one.
    pub fn least(&self, channel: usize) -> &[f32] {
        &self.numbers[2 * channel * self.count..][..self.count]
    }

    /// The largest numbers of a channel.
    pub fn largest(&self, channel: usize) -> &[f32] {
        &self.numbers[(2 * channel + 1) * self.count..][..self.count]
    }

    /// These channels alone, in this order; one that there is not is left out.
    pub fn chosen(&self, channels: &[usize]) -> Self {
        let known = channels.iter().filter(|&&channel| channel < self.channels);
        let numbers = known.clone().flat_map(|&channel| {
            let both = self.least(channel).iter().chain(self.largest(channel));
            both.copied()
        });
        Self {
            numbers: numbers.collect(),
            channels: known.count(),
            ..*self
        }
    }
}

/// Least and largest of the numbers of a sample or entry; NaN counts as none.
#[inline]
fn widen((least, largest): (f32, f32), (low, high): (f32, f32)) -> (f32, f32) {
    // `f32::min` and `max` give the other of a NaN and a number.
    (least.min(low), largest.max(high))
}

/// Numbers of a channel where the one that it follows is least and largest, if that had `of` before and `now` comes.
#[inline]
fn followed(held: (f32, f32), new: (f32, f32), of: (f32, f32), now: (f32, f32)) -> (f32, f32) {
    let less = now.0 < of.0 || of.0.is_nan();
    let more = now.1 > of.1 || of.1.is_nan();
    (
        if less { new.0 } else { held.0 },
        if more { new.1 } else { held.1 },
    )
}

const NOTHING: (f32, f32) = (f32::NAN, f32::NAN);

#[derive(Clone, Debug)]
struct Level {
    ticks: u64,
    channels: usize,
    follows: Vec<usize>,
    capacity: u64,
    /// Entry by entry, in it channel by channel.
    entries: Vec<(f32, f32)>,
}

impl Level {
    fn new(size: PyramidSize<'_>, capacity: usize, ticks: u64) -> Self {
        Self {
            ticks,
            channels: size.channels,
            follows: size.follows.to_vec(),
            capacity: capacity as u64,
            // Numbers other than zero, so that the system has to give the memory now.
            entries: vec![NOTHING; size.channels * capacity],
        }
    }

    /// The channel that this one follows, which comes before it.
    #[inline]
    fn leader(&self, channel: usize) -> Option<usize> {
        let own = self.channels - self.follows.len();
        let follower = channel.checked_sub(own)?;
        self.follows.get(follower).copied()
    }

    fn place(&self, entry: u64) -> usize {
        (entry % self.capacity) as usize * self.channels
    }

    /// Takes the sample of a tick into its entry, which is begun anew with its first.
    #[inline]
    fn push(&mut self, tick: u64, sample: &[f32]) {
        let place = self.place(tick / self.ticks);
        if tick.is_multiple_of(self.ticks) {
            self.entries[place..][..self.channels].fill(NOTHING);
        }
        let number = |channel: usize| {
            let number = sample.get(channel).copied().unwrap_or(f32::NAN);
            (number, number)
        };
        // Followers are last: each is taken before the channel that it follows.
        for channel in (0..self.channels).rev() {
            let held = self.entries[place + channel];
            self.entries[place + channel] = match self.leader(channel) {
                None => widen(held, number(channel)),
                Some(of) => followed(held, number(channel), self.entries[place + of], number(of)),
            };
        }
    }

    /// First tick that is remembered, of `made` samples.
    fn first_tick(&self, made: u64) -> u64 {
        let entries = made.div_ceil(self.ticks);
        entries.saturating_sub(self.capacity) * self.ticks
    }

    /// Least and largest of the entry of a tick.
    #[inline]
    fn entry(&self, tick: u64, channel: usize) -> (f32, f32) {
        self.entries[self.place(tick / self.ticks) + channel]
    }

    /// Columns of `width` ticks, a multiple of an entry's, that hold the ticks of the span which are remembered.
    fn columns(&self, span: Range<u64>, width: u64, made: u64) -> ViewColumns {
        let start = span.start.max(self.first_tick(made));
        if start >= span.end {
            return ViewColumns::empty(0, 1, 0, self.channels);
        }
        let (first, last) = (start / width, (span.end - 1) / width);
        let count = (last - first + 1) as usize;
        let mut columns = ViewColumns::empty(first * width, width, count, self.channels);
        let known = self.first_tick(made)..made;
        for column in 0..count {
            let begin = (first + column as u64) * width;
            let ticks = begin.max(known.start)..(begin + width).min(known.end);
            let entries = ticks.start / self.ticks..ticks.end.div_ceil(self.ticks);
            for entry in entries {
                let place = self.place(entry);
                let entry = &self.entries[place..][..self.channels];
                for (channel, &new) in entry.iter().enumerate().rev() {
                    let ends = |channel: usize| {
                        let least = 2 * channel * count + column;
                        (least, least + count)
                    };
                    let numbers = &mut columns.numbers;
                    let (least, largest) = ends(channel);
                    let held = (numbers[least], numbers[largest]);
                    let both = match self.leader(channel) {
                        None => widen(held, new),
                        Some(of) => {
                            let (low, high) = ends(of);
                            followed(held, new, (numbers[low], numbers[high]), entry[of])
                        }
                    };
                    (numbers[least], numbers[largest]) = both;
                }
            }
        }
        columns
    }
}

#[cfg(test)]
mod tests;
