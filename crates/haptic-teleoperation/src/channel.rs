//! A bad line in virtual time: what goes in comes out late, out of order, twice or not at all.

use fracdiff::{
    Seconds,
    parameter::{positive, range},
};
use haptic_link::HandSample;
use haptic_loop::LoopParameterError;
use rand_distr::{Distribution as _, StandardUniform};
use rand_pcg::{Pcg32, rand_core::SeedableRng as _};
use std::collections::BTreeMap;

/// Effect of one direction of a line on messages.
///
/// ```text
/// a message takes h·(1 + j·r), r uniform in [−1, 1]        h delay s, j jitter; so messages overtake each other
/// sent in tick n it is there in tick n + 1 + ⌊that/T⌋      at the earliest in the next
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelModel {
    /// h, s: 0 to 10.
    pub delay: Seconds,
    /// j, 0 to 1: the share of the delay by which a message comes earlier or later.
    pub jitter: f64,
    /// Chance that a message is lost, 0 to 1.
    pub loss: f64,
    /// Chance that a message arrives twice, each copy with its own delay, 0 to 1.
    pub duplication: f64,
}

impl ChannelModel {
    /// No more than the tick that every message takes.
    pub const IDEAL: Self = Self {
        delay: Seconds(0.0),
        jitter: 0.0,
        loss: 0.0,
        duplication: 0.0,
    };
    /// Longest delay, s: to the Moon and back takes 2.6.
    pub const DELAY_MOST_S: f64 = 10.0;

    /// Itself, if all is in its range.
    ///
    /// # Errors
    /// A delay, jitter or chance outside its range.
    pub fn checked(self) -> Result<Self, LoopParameterError> {
        let (delay, fits) = (
            self.delay.0,
            (0.0..=Self::DELAY_MOST_S).contains(&self.delay.0),
        );
        let delays = "in [0, 10]: a line takes time, it does not give it";
        range("delay of the line", delay, fits, delays, "s")?;
        for (what, value, allowed) in [
            ("jitter", self.jitter, "in [0, 1], of the delay"),
            ("chance of a lost message", self.loss, "in [0, 1]"),
            (
                "chance of a repeated message",
                self.duplication,
                "in [0, 1]",
            ),
        ] {
            range(what, value, (0.0..=1.0).contains(&value), allowed, "")?;
        }
        Ok(self)
    }

    /// Whole samples from the tick in which a message is sent to that in which it is used, without jitter.
    #[must_use]
    pub fn samples(&self, sample_time: Seconds) -> u64 {
        1 + whole(self.delay.0 / sample_time.0)
    }
}

/// Whole samples of a time; a rounding error below one is one.
fn whole(samples: f64) -> u64 {
    (samples + 1e-9) as u64
}

/// The fate of one direction's messages; those still under way are counted only in `sent`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ChannelCounts {
    /// Messages that were given to the line.
    pub sent: u64,
    /// Messages that never come out.
    pub lost: u64,
    /// Messages that arrive twice.
    pub doubled: u64,
    /// Messages that have come out, doubles included.
    pub delivered: u64,
}

/// One direction of a line. Time is an argument: the number of the tick.
#[derive(Clone, Debug)]
pub struct OneWayLine {
    model: ChannelModel,
    sample_time: f64,
    random: Pcg32,
    /// Samples by the tick of arrival and the order of sending.
    on_the_way: BTreeMap<(u64, u64), HandSample>,
    counts: ChannelCounts,
    order: u64,
}

impl OneWayLine {
    /// An empty line. The same seed gives the same line.
    ///
    /// # Errors
    /// As [`ChannelModel::checked`]; a sample time that is not above 0.
    pub fn new(
        model: ChannelModel,
        sample_time: Seconds,
        seed: u64,
    ) -> Result<Self, LoopParameterError> {
        let sample_time = positive("sample time", sample_time.0, "s")?;
        Ok(Self {
            model: model.checked()?,
            sample_time,
            random: Pcg32::seed_from_u64(seed),
            on_the_way: BTreeMap::new(),
            counts: ChannelCounts::default(),
            order: 0,
        })
    }

    /// Takes a message in tick `tick`.
    pub fn send(&mut self, tick: u64, message: HandSample) {
        self.counts.sent += 1;
        // Drawn in any case, so that one chance does not move the others.
        let (lost, doubled) = (self.drawn(), self.drawn());
        let delays = [self.delay(), self.delay()];
        if lost < self.model.loss {
            self.counts.lost += 1;
            return;
        }
        let twice = doubled < self.model.duplication;
        self.counts.doubled += u64::from(twice);
        for delay in &delays[..1 + usize::from(twice)] {
            let arrival = tick + 1 + whole(delay / self.sample_time);
            self.on_the_way.insert((arrival, self.order), message);
            self.order += 1;
        }
    }

    /// The next message that has arrived by tick `tick`.
    pub fn next(&mut self, tick: u64) -> Option<HandSample> {
        let first = self.on_the_way.first_entry();
        let first = first.filter(|first| first.key().0 <= tick)?;
        self.counts.delivered += 1;
        Some(first.remove())
    }

    /// Counts from the start of the line up to now.
    #[must_use]
    pub const fn counts(&self) -> ChannelCounts {
        self.counts
    }

    /// Uniform in [0, 1).
    fn drawn(&mut self) -> f64 {
        StandardUniform.sample(&mut self.random)
    }

    /// h·(1 + j·r), s.
    fn delay(&mut self) -> f64 {
        let r = 2.0 * self.drawn() - 1.0;
        self.model.delay.0 * (1.0 + self.model.jitter * r)
    }
}
