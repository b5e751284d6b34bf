//! A line that loses, damages, repeats, delays and holds back what is sent over it: by chance, but the
//! same for the same seed.

use fracdiff::parameter::range;
use haptic_loop::LoopParameterError;
use rand_distr::{Distribution as _, StandardUniform};
use rand_pcg::Pcg32;
use std::collections::VecDeque;

/// Faults of a line. All chances are per frame, in [0, 1].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LineFaults {
    /// Chance that a frame is lost.
    pub drop: f64,
    /// Chance that 1 to 8 of its bits are flipped.
    pub corrupt: f64,
    /// Chance that a frame arrives twice.
    pub duplicate: f64,
    /// Chance that it is held back until after the next one.
    pub reorder: f64,
    /// Longest delay of a frame, s; each takes a share of it by chance, without overtaking.
    pub delay_s: f64,
    /// Chance that the line stands still from this frame on.
    pub stall: f64,
    /// Duration of a standstill, s.
    pub stall_s: f64,
}

/// Counts of the frames and faults of a line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LineDamage {
    /// Frames that were put on the line, lost ones included.
    pub sent: u64,
    /// Frames that never arrive.
    pub dropped: u64,
    /// Frames that arrive with some bits flipped.
    pub corrupted: u64,
    /// Frames that arrive twice in a row.
    pub duplicated: u64,
    /// Frames held back until after the next one.
    pub reordered: u64,
    /// Times the line stood still.
    pub stalls: u64,
}

/// One direction of a line. Time is an argument, µs.
#[derive(Clone, Debug)]
pub struct FaultyLine {
    faults: LineFaults,
    random: Pcg32,
    on_the_way: VecDeque<(u64, Vec<u8>)>,
    held_back: Option<Vec<u8>>,
    stalled_until_us: u64,
    last_arrival_us: u64,
    damage: LineDamage,
}

impl LineFaults {
    /// Checks the ranges.
    ///
    /// # Errors
    /// A chance outside [0, 1], a time that is negative or not finite.
    pub fn check(&self) -> Result<(), LoopParameterError> {
        let chances = [
            ("chance of a lost frame", self.drop),
            ("chance of a damaged frame", self.corrupt),
            ("chance of a repeated frame", self.duplicate),
            ("chance of a frame out of order", self.reorder),
            ("chance of a stall", self.stall),
        ];
        for (what, value) in chances {
            range(what, value, (0.0..=1.0).contains(&value), "in [0, 1]", "")?;
        }
        for (what, value) in [
            ("delay of a frame", self.delay_s),
            ("length of a stall", self.stall_s),
        ] {
            let fits = value >= 0.0 && value.is_finite();
            range(what, value, fits, "at least 0 {}", "s")?;
        }
        Ok(())
    }
}

impl FaultyLine {
    /// A quiet line.
    ///
    /// # Errors
    /// As [`LineFaults::check`].
    pub fn new(faults: LineFaults, seed: u64) -> Result<Self, LoopParameterError> {
        faults.check()?;
        Ok(Self {
            faults,
            random: Pcg32::new(seed, 0x0da3_e39c_b94b_95bd),
            on_the_way: VecDeque::new(),
            held_back: None,
            stalled_until_us: 0,
            last_arrival_us: 0,
            damage: LineDamage::default(),
        })
    }

    /// Quiet lines to a device and to its host, with the same faults at other times.
    pub(crate) fn both_ways(
        faults: LineFaults,
        seed: u64,
    ) -> Result<[Self; 2], LoopParameterError> {
        Ok([
            Self::new(faults, seed)?,
            Self::new(faults, seed.wrapping_add(1))?,
        ])
    }

    pub(crate) fn is_ideal(&self) -> bool {
        self.faults == LineFaults::default()
    }

    /// Sets the faults of the line from now on. Frames on the way are not touched.
    ///
    /// # Errors
    /// As [`LineFaults::check`].
    pub fn set_faults(&mut self, faults: LineFaults) -> Result<(), LoopParameterError> {
        faults.check()?;
        self.faults = faults;
        Ok(())
    }

    /// Puts a frame on the line at this time and draws its faults; [`receive`](Self::receive) then
    /// delivers it.
    pub fn send(&mut self, frame: &[u8], now_us: u64) {
        self.damage.sent += 1;
        let mut frame = frame.to_vec();
        if self.happens(self.faults.drop) {
            self.damage.dropped += 1;
            return;
        }
        if self.happens(self.faults.corrupt) {
            self.damage.corrupted += 1;
            self.flip_bits(&mut frame);
        }
        if self.happens(self.faults.stall) {
            self.damage.stalls += 1;
            self.stalled_until_us = now_us + microseconds(self.faults.stall_s);
        }
        if self.held_back.is_none() && self.happens(self.faults.reorder) {
            self.damage.reordered += 1;
            self.held_back = Some(frame);
            return;
        }
        if self.happens(self.faults.duplicate) {
            self.damage.duplicated += 1;
            self.arrive(frame.clone(), now_us);
        }
        self.arrive(frame, now_us);
        if let Some(late) = self.held_back.take() {
            self.arrive(late, now_us);
        }
    }

    /// The next frame that has arrived by this time.
    pub fn receive(&mut self, now_us: u64) -> Option<Vec<u8>> {
        let arrived = self.on_the_way.front()?.0 <= now_us;
        arrived
            .then(|| self.on_the_way.pop_front())?
            .map(|(_, frame)| frame)
    }

    /// Counts of the frames and faults of the line so far.
    #[must_use]
    pub const fn damage(&self) -> LineDamage {
        self.damage
    }

    fn arrive(&mut self, frame: Vec<u8>, now_us: u64) {
        let chance: f64 = StandardUniform.sample(&mut self.random);
        let delay = microseconds(chance * self.faults.delay_s);
        let arrival = (now_us + delay)
            .max(self.stalled_until_us)
            .max(self.last_arrival_us);
        self.last_arrival_us = arrival;
        self.on_the_way.push_back((arrival, frame));
    }

    fn happens(&mut self, chance: f64) -> bool {
        // Drawn even when it cannot happen, so that one fault does not change when others come.
        let drawn: f64 = StandardUniform.sample(&mut self.random);
        drawn < chance
    }

    fn flip_bits(&mut self, frame: &mut [u8]) {
        let drawn: u32 = StandardUniform.sample(&mut self.random);
        for _ in 0..=drawn % 8 {
            let drawn: u32 = StandardUniform.sample(&mut self.random);
            let bit = drawn as usize % (8 * frame.len().max(1));
            if let Some(byte) = frame.get_mut(bit / 8) {
                *byte ^= 1 << (bit % 8);
            }
        }
    }
}

fn microseconds(seconds: f64) -> u64 {
    (seconds * 1e6) as u64
}
