//! Columns of a view: its span, and least and largest of each channel.

/// A span of ticks, and the number of columns wished for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    pub(super) start: u64,
    pub(super) end: u64,
    columns: u64,
}

impl Span {
    /// From `start` on, before `end`, in so many columns or a few less; none counts as one.
    #[must_use]
    pub fn new(start: u64, end: u64, columns: u32) -> Self {
        Self {
            start,
            end: end.max(start),
            columns: u64::from(columns.max(1)),
        }
    }

    /// Ticks of a column as wished, at least 1.
    pub(super) fn width(self) -> u64 {
        (self.end - self.start).div_ceil(self.columns).max(1)
    }
}

/// Least and largest of each channel, column by column.
#[derive(Clone, Debug, PartialEq)]
pub struct Columns {
    pub(super) first_tick: u64,
    pub(super) width: u64,
    pub(super) count: usize,
    pub(super) channels: usize,
    /// Of each channel first all least, then all largest.
    pub(super) numbers: Vec<f32>,
}

impl Columns {
    /// No column.
    pub(super) const fn none(channels: usize) -> Self {
        Self {
            first_tick: 0,
            width: 1,
            count: 0,
            channels,
            numbers: Vec::new(),
        }
    }

    /// So many columns without a number.
    pub(super) fn empty(first_tick: u64, width: u64, count: usize, channels: usize) -> Self {
        Self {
            first_tick,
            width,
            count,
            channels,
            numbers: vec![f32::NAN; 2 * channels * count],
        }
    }

    /// The first tick of the first column, a multiple of [`width`](Self::width).
    #[must_use]
    pub const fn first_tick(&self) -> u64 {
        self.first_tick
    }

    /// Ticks of a column.
    #[must_use]
    pub const fn width(&self) -> u64 {
        self.width
    }

    /// Columns.
    #[must_use]
    pub const fn count(&self) -> usize {
        self.count
    }

    /// Channels.
    #[must_use]
    pub const fn channels(&self) -> usize {
        self.channels
    }

    /// The least of a channel in each column; NaN where there is none.
    #[must_use]
    pub fn least(&self, channel: usize) -> &[f32] {
        &self.numbers[2 * channel * self.count..][..self.count]
    }

    /// The largest.
    #[must_use]
    pub fn largest(&self, channel: usize) -> &[f32] {
        &self.numbers[(2 * channel + 1) * self.count..][..self.count]
    }

    /// Of each channel first all least, then all largest.
    #[must_use]
    pub fn numbers(&self) -> &[f32] {
        &self.numbers
    }

    /// These channels alone, in this order; one that there is not is left out.
    #[must_use]
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
