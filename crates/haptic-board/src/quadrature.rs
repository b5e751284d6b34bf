//! An encoder without a counter: counts from samples of its two channels.

use core::sync::atomic::{AtomicU8, Ordering};
use haptic_loop::Fault;

/// Counts an encoder's steps from samples of its channels A and B, for a chip that has no counter for them, but
/// something that samples pins (a PIO, an SPI, a timer with DMA).
///
/// ```text
/// A  _/‾‾‾\___/‾‾‾\_      one way: A leads, B and A 00 01 11 10, count up
/// B  ___/‾‾‾\___/‾‾‾      four counts a line; the other way they go down
/// ```
/// - *Sampled often enough*: at least once a count, so counts a second below samples a second. Both channels changed
///   between two samples are a fault, as the count is wrong from then on: [`lost`](Self::lost).
/// - *Wire off*: from the ring. A channel that is off stands still, and the count goes to and fro by one while the shaft turns. Where in
///   ticks one channel changes and the other does not, changes, 4 a tick at most, less one a tick add up to 16: a fault. A hand
///   changes both; a loop that shakes an edge needs two ticks for two changes. Changes at uneven times, as of a channel that chatters on its
///   edge, count once a tick; chatter in step with a PWM looks like a wire that is off. A board that counts in hardware sees no channels.
/// - *Start-up*: count 0 wherever the encoder stands. It wraps at ±2³¹.
///
/// ```
/// use haptic_board::Quadrature;
///
/// let mut encoder = Quadrature::new();
/// let forward = 0b10_11_01_00; // the oldest sample is lowest, A is its lower bit
/// encoder.take(forward, 4)?;
/// assert_eq!(encoder.count(), 3);
/// # Ok::<(), haptic_board::haptic_loop::Fault>(())
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Quadrature {
    count: i32,
    /// Quarter of the line, 0 to 3; `None` before the first sample.
    quarter: Option<u8>,
    /// Place in a ring of the next samples.
    next: usize,
    /// Byte of a ring in which all samples are the last one; `None` before the first.
    still: Option<u8>,
    /// Changes of A and B since a ring was last taken in.
    changes: [u8; 2],
    /// The channel that has changed alone since then, and by how much more than once a tick.
    alone: (usize, u8),
    /// Samples so far, those at the last change, and the fewest and most between two changes of a tick.
    samples: u32,
    changed_at: u32,
    dwells: (u32, u32),
    lost: Option<Fault>,
}

/// Changes of a tick that count, and those beyond one a tick that are too many.
const CHANGES_MOST: u8 = 4;
const ALONE_MOST: u8 = 16;
const NO_DWELL: (u32, u32) = (u32::MAX, 0);
/// A turning shaft changes evenly; if one dwell is this many times another, a channel chatters on its edge.
const UNEVEN: u32 = 4;

impl Quadrature {
    /// Counter at count 0.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            count: 0,
            quarter: None,
            next: 0,
            still: None,
            changes: [0; 2],
            alone: (0, 0),
            samples: 0,
            changed_at: 0,
            dwells: NO_DWELL,
            lost: None,
        }
    }

    /// Takes in up to 16 samples of two bits, the oldest lowest.
    ///
    /// # Errors
    /// Both channels have changed between two samples. The samples after it are counted all the same.
    pub fn take(&mut self, samples: u32, number: u32) -> Result<(), Fault> {
        let number = number.min(16);
        let followed = self.follow(samples, number, self.samples);
        self.samples = self.samples.wrapping_add(number);
        followed
    }

    /// Takes in samples as [`take`](Self::take) does, behind `before_them` samples.
    #[inline]
    fn follow(&mut self, samples: u32, number: u32, before_them: u32) -> Result<(), Fault> {
        let mut followed = Ok(());
        for index in 0..number {
            let pins = (samples >> (2 * index)) as u8 & 0b11;
            // Gray code, B and A, to binary: 00 01 11 10 are the quarters 0 1 2 3.
            let quarter = pins ^ pins >> 1;
            let before = self.quarter.unwrap_or(quarter);
            let moved = quarter.wrapping_sub(before) & 0b11;
            if moved & 1 != 0 {
                // A between the quarters 0 and 1, and 2 and 3; else B.
                let channel = usize::from(quarter ^ before == 0b11);
                self.changes[channel] = self.changes[channel].saturating_add(1);
                let now = before_them.wrapping_add(index);
                let dwell = now.wrapping_sub(self.changed_at);
                let (least, most) = self.dwells;
                self.dwells = (least.min(dwell), most.max(dwell));
                self.changed_at = now;
            }
            self.quarter = Some(quarter);
            self.count = match moved {
                0 => self.count,
                1 => self.count.wrapping_add(1),
                3 => self.count.wrapping_sub(1),
                _ => {
                    followed = Err(self.lose(Fault::PositionJump));
                    self.count
                }
            };
        }
        followed
    }

    /// Takes in what has come into a ring, which a DMA fills from its beginning on, four samples a
    /// byte, up to `end`, the place of the next byte: so the position is current, not that of the
    /// last full word. To be called before it has come round.
    ///
    /// # Errors
    /// As [`take`](Self::take); and a wire that is off, where it is called once a tick.
    #[inline]
    pub fn take_ring(&mut self, ring: &[AtomicU8], end: usize) -> Result<(), Fault> {
        let (mut followed, mut taken) = (Ok(()), self.samples);
        // An end at the length of the ring is its beginning.
        let end = end.checked_rem(ring.len()).unwrap_or(0);
        let parts = match core::mem::replace(&mut self.next, end) {
            next if next <= end => [next..end, 0..0],
            next => [next..ring.len(), 0..end],
        };
        let mut still = self.still.map_or(u32::MAX, u32::from);
        for part in parts {
            for samples in ring.get(part).unwrap_or_default() {
                let samples = u32::from(samples.load(Ordering::Relaxed));
                // Most bytes of most ticks: a shaft is slow.
                if samples != still {
                    followed = followed.and(self.follow(samples, 4, taken));
                    still = (samples >> 6) * 0b01_01_01_01;
                }
                taken = taken.wrapping_add(4);
            }
        }
        self.still = u8::try_from(still).ok();
        self.samples = taken;
        followed.and(self.both_channels())
    }

    /// Judges the changes of a tick.
    fn both_channels(&mut self) -> Result<(), Fault> {
        let mut changes = core::mem::take(&mut self.changes);
        let (least, most) = core::mem::replace(&mut self.dwells, NO_DWELL);
        if least < most / UNEVEN {
            changes = changes.map(|count| count.min(1));
        }
        let [a, b] = changes;
        let (channel, alone) = self.alone;
        self.alone = match (a, b) {
            (0, 0) => (channel, alone),
            (_, 0) if channel == 0 => (0, alone + a.min(CHANGES_MOST)),
            (0, _) if channel == 1 => (1, alone + b.min(CHANGES_MOST)),
            // The other one is there too.
            _ => (1 - channel, 0),
        };
        self.alone.1 = self.alone.1.saturating_sub(1);
        if self.alone.1 < ALONE_MOST {
            return Ok(());
        }
        self.alone.1 = 0;
        Err(self.lose(Fault::EncoderWire))
    }

    /// Counts were missed, here or on the way here: remembers the first fault that did it, and returns this one.
    #[cold]
    pub fn lose(&mut self, fault: Fault) -> Fault {
        self.lost.get_or_insert(fault);
        fault
    }

    /// The fault after which the count is wrong and zero has moved. It lasts until a restart;
    /// return it from [`persisting_fault`](haptic_remote::Hardware::persisting_fault): otherwise a
    /// wall would stand in the wrong place.
    #[must_use]
    pub const fn lost(&self) -> Option<Fault> {
        self.lost
    }

    /// Counts since the start; it wraps at ±2³¹.
    #[must_use]
    pub const fn count(&self) -> i32 {
        self.count
    }
}
