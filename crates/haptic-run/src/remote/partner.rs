//! Two devices in one run: a tissue on the first, and the drive that presses it, the second. Each has its own line and its own thread here.
//!
//! ```text
//! first    armed ─▶ started ─▶ its force has risen ─┐                                has made its samples ─┐   ┌▶ stopped from here
//! second   armed ───────────────────────────────────┴▶ started: time 0 of the run ─▶ holds on ─────────────┴▶ stopped from here
//! ```
//! - *Time* is that of the first device, and begins with tick 0 of the second. The second's ticks get the first's time by the clocks of
//!   both, which keep-alives carry ([`DeviceClock`]): as long as the run lasts, and once more when it is over.
//! - *Letting go*: the thread of one side sees before its next message that the other ended early, by a fault, a lost line or a request,
//!   and stops its device. A side that is armed and silent for three quarters of the other's watchdog time, while the other's device speaks,
//!   has ended too. If this program dies, both devices let go by their watchdogs.
//! - *Losses* are counted on each side.

use crate::ran::Aligned;
use haptic_loop::realtime::Moment;
use haptic_remote::serial::{DeviceClock, SerialLink};
use haptic_trial::ending::Ending;
use std::{
    sync::{
        Arc, OnceLock,
        atomic::{AtomicBool, AtomicU64, Ordering},
    },
    time::Duration,
};

/// A pause in which another side is looked for.
const PAUSE: Duration = Duration::from_millis(1);

/// Both devices write their times in whole µs, so that those of tick 0 are off by up to one against each other.
const STAMP_US: f64 = 1.0;

/// The two sides: of the tissue, and of the drive that moves it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Tissue,
    Drive,
}

impl Side {
    const fn other(self) -> Self {
        match self {
            Self::Tissue => Self::Drive,
            Self::Drive => Self::Tissue,
        }
    }
}

/// State of both devices that their sessions share.
#[derive(Debug, Default)]
pub(super) struct Both {
    sides: [Shown; 2],
    /// The tissue's force has risen: the drive may begin.
    risen: AtomicBool,
    /// Tick 0 of the drive on the clock of the tissue's device, s from its own tick 0.
    begun_s: OnceLock<f64>,
}

/// State of a session that the other one sees.
#[derive(Debug, Default)]
struct Shown {
    armed: AtomicBool,
    ended: AtomicBool,
    /// It made all samples that count.
    whole: AtomicBool,
    /// It lets go, with nothing left to make.
    done: AtomicBool,
    /// Messages that came from its device: while they stop, the other side counts its silence.
    heard: AtomicU64,
    /// Tick 0 by the device's own clock, µs.
    tick_0_us: OnceLock<f64>,
}

/// The clock of a device, as it becomes known.
pub(super) type Clock = Arc<dyn Fn() -> Option<DeviceClock> + Send + Sync>;

/// A session's view of the other one.
pub(super) struct Partner<'a> {
    both: &'a Both,
    pub side: Side,
    /// Clocks of the tissue's device and of the drive's.
    clocks: [Clock; 2],
    /// Silence of the other side after which this device is stopped.
    patience: Duration,
    /// Counts of messages from this side and from the other, and the silence of each, pauses of this process excluded.
    heard: [u64; 2],
    silent: [Duration; 2],
    looked: Moment,
    /// Ticks until the force has risen.
    pub rise_ticks: u64,
    /// Samples that count, from the first tick of the drive.
    pub samples: u64,
    /// Seconds to add to the drive's own time for that of the tissue's device.
    pub shift_s: f64,
    opposed_n: Arc<AtomicU64>,
}

impl<'a> Partner<'a> {
    /// Partner of a device with this watchdog time.
    pub(super) fn new(
        both: &'a Both,
        side: Side,
        clocks: [Clock; 2],
        watchdog: Duration,
        opposed_n: Arc<AtomicU64>,
    ) -> Self {
        Self {
            both,
            side,
            clocks,
            patience: watchdog * 3 / 4,
            heard: [0; 2],
            silent: [Duration::ZERO; 2],
            looked: Moment::now(),
            rise_ticks: 0,
            samples: 0,
            shift_s: 0.0,
            opposed_n,
        }
    }

    fn shown(&self, side: Side) -> &'a Shown {
        &self.both.sides[side as usize]
    }

    /// Waits until this device, which answers on its link meanwhile, may start; false if the other has ended, or somebody asked to stop.
    pub(super) fn waits(&self, link: &SerialLink, stop: &AtomicBool) -> bool {
        self.shown(self.side).armed.store(true, Ordering::Release);
        let may_start = || match self.side {
            Side::Tissue => self.shown(Side::Drive).armed.load(Ordering::Acquire),
            Side::Drive => self.both.risen.load(Ordering::Acquire),
        };
        let mut alives = link.alives();
        // Whoever has ended may have said before that its force has risen.
        while !(stop.load(Ordering::Relaxed) || self.other_ended() || self.other_is_done()) {
            if may_start() {
                return true;
            }
            if link.alives() != alives {
                alives = link.alives();
                self.hears();
            }
            std::thread::sleep(PAUSE);
        }
        false
    }

    fn other_ended(&self) -> bool {
        self.shown(self.side.other()).ended.load(Ordering::Acquire)
    }

    fn other_is_done(&self) -> bool {
        self.shown(self.side.other()).done.load(Ordering::Acquire)
    }

    /// This side has made so many of its samples.
    pub(super) fn makes(&self, made: u64, samples: u64) {
        let whole = &self.shown(self.side).whole;
        whole.store(made >= samples, Ordering::Release);
    }

    /// True once a drive that has made so many samples is not needed any more, or the tissue's device will never know when it began; and of
    /// the tissue's device, once it has made its samples and the drive has let go.
    pub(super) fn may_let_go(&self, made: u64) -> bool {
        let is_whole = self.shown(Side::Tissue).whole.load(Ordering::Acquire);
        let may = match self.side {
            Side::Tissue => is_whole && self.other_is_done(),
            Side::Drive => is_whole || made >= self.samples && self.begun_s().is_none(),
        };
        may && !self.is_done()
    }

    /// True of the side that moves the other.
    pub(super) fn is_drive(&self) -> bool {
        self.side == Side::Drive
    }

    pub(super) fn ends(&self) {
        self.shown(self.side).ended.store(true, Ordering::Release);
    }

    /// This side is over, whatever ended it: nobody waits for it any more.
    pub(super) fn leaves(&self) {
        if !self.is_done() {
            self.ends();
        }
    }

    /// This side has made all that it was to make: its silence means nothing any more.
    pub(super) fn done(&self) {
        self.shown(self.side).done.store(true, Ordering::Release);
    }

    pub(super) fn is_done(&self) -> bool {
        self.shown(self.side).done.load(Ordering::Acquire)
    }

    /// Something was heard of this device.
    pub(super) fn hears(&self) {
        self.shown(self.side).heard.fetch_add(1, Ordering::Relaxed);
    }

    /// Why there is nobody any more, if the other has ended early, is silent in the middle of its run, or is done and never told when that
    /// began: the end of this run would never come.
    pub(super) fn left(&mut self) -> Option<Ending> {
        /// A longer one is a pause of this process.
        const LOOKED: Duration = Duration::from_millis(20);
        /// Beyond that silence of this side too, it is not the other that is silent: nothing comes to this process.
        const OWN: Duration = Duration::from_millis(100);
        let other = self.shown(self.side.other());
        let heard = [self.shown(self.side), other].map(|side| side.heard.load(Ordering::Relaxed));
        let paused = self.looked.elapsed().min(LOOKED);
        self.looked = Moment::now();
        let alone = if self.silent[0] < OWN {
            paused
        } else {
            Duration::ZERO
        };
        for (side, counted) in [paused, alone].into_iter().enumerate() {
            self.silent[side] = if heard[side] == self.heard[side] {
                self.silent[side] + counted
            } else {
                Duration::ZERO
            };
        }
        self.heard = heard;
        let is_done = self.other_is_done();
        let runs = other.armed.load(Ordering::Acquire) && !is_done;
        let endless = is_done && self.side == Side::Tissue && self.begun_s().is_none();
        if self.other_ended() || endless {
            Some(Ending::OtherLeft)
        } else {
            (runs && self.silent[1] > self.patience).then_some(Ending::Silent)
        }
    }

    /// Tick 0 of this device was at this time by its own clock, of which these are the lower bits, µs.
    pub(super) fn began(&self, low_us: u32, ticks_us: f64) {
        let clock = (self.clocks[self.side as usize])();
        if let Some(clock) = clock {
            let began_us = clock.whole_us(low_us) - ticks_us;
            let _ = self.shown(self.side).tick_0_us.set(began_us);
        }
    }

    /// True if [`began`](Self::began) has been said.
    pub(super) fn has_begun(&self) -> bool {
        self.shown(self.side).tick_0_us.get().is_some()
    }

    /// The tissue opposes this force, N.
    pub(super) fn opposes(&self, force_n: f64) {
        if self.side == Side::Tissue {
            self.opposed_n.store(force_n.to_bits(), Ordering::Relaxed);
        }
    }

    /// The force of this device has risen.
    pub(super) fn risen(&self) {
        self.both.risen.store(true, Ordering::Release);
    }

    /// When the run begins, in s on the tissue's device.
    pub(super) fn begun_s(&self) -> Option<f64> {
        self.both.begun_s.get().copied()
    }

    /// Brings the drive's time to what the clocks say of its own time now, s; it never goes back by more than a part of a tick.
    pub(super) fn align(&mut self, own_s: f64) {
        let Some(aligned) = aligned(self.both, &self.clocks) else {
            return;
        };
        self.shift_s = (aligned.first_s(own_s) - own_s).max(0.0);
        let _ = self.both.begun_s.set(self.shift_s);
    }
}

/// Present relation of both clocks; `None` until both are known.
pub(super) fn aligned(both: &Both, clocks: &[Clock; 2]) -> Option<Aligned> {
    let [first, second] = clocks;
    let line = first()?.relative_to(&second()?)?;
    let [zero_us, drive_us] = [0, 1].map(|side: usize| both.sides[side].tick_0_us.get().copied());
    Some(Aligned {
        offset_s: 1e-6 * (line.at(drive_us?) - zero_us?),
        drift: line.rate - 1.0,
        residual_s: 1e-6 * (line.error_us + STAMP_US),
        tissue_tick_0_s: 1e-6 * zero_us?,
        drive_tick_0_s: 1e-6 * drive_us?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drive_lets_go_when_the_tissue_has_made_its_samples_and_the_tissue_after_it() {
        let none: Clock = Arc::new(|| None);
        let partner = |both, side| {
            let clocks = [Arc::clone(&none), Arc::clone(&none)];
            let partner = Partner::new(both, side, clocks, Duration::from_secs(1), Arc::default());
            Partner {
                samples: 100,
                ..partner
            }
        };
        let both = &Both::default();
        let [tissue, drive] = [Side::Tissue, Side::Drive].map(|side| partner(both, side));
        both.begun_s.set(0.0).expect("once");
        // However much the drive has made.
        for made in [99, 100] {
            assert!(!drive.may_let_go(150), "{made}");
            tissue.makes(made, 100);
            assert!(!tissue.may_let_go(made), "{made}");
        }
        assert!(drive.may_let_go(80));
        drive.done();
        assert!(!drive.may_let_go(81) && tissue.may_let_go(101));
        // The tissue's device will never know when this one began.
        let unknown = &Both::default();
        let drive = partner(unknown, Side::Drive);
        assert!(!drive.may_let_go(99) && drive.may_let_go(100));
    }

    /// A silence counts while this side is heard; one of both is a pause of this machine, of which each session judges its own.
    #[test]
    fn a_side_is_silent_while_the_other_speaks() {
        let both = Both::default();
        both.sides[Side::Drive as usize]
            .armed
            .store(true, Ordering::Release);
        let none: Clock = Arc::new(|| None);
        let watchdog = Duration::from_millis(400);
        let clocks = [Arc::clone(&none), none];
        let mut tissue = Partner::new(&both, Side::Tissue, clocks, watchdog, Arc::default());
        let mut looks_until_left = |most: u32, speaks: bool| {
            (0..most).find(|_| {
                std::thread::sleep(Duration::from_millis(20));
                if speaks {
                    tissue.hears();
                }
                let left = tissue.left();
                assert!(matches!(left, None | Some(Ending::Silent)), "{left:?}");
                left.is_some()
            })
        };
        assert_eq!(looks_until_left(30, false), None);
        // 100 ms of 300 ms have been counted. The first look ends the pause, each other counts 20 ms.
        assert_eq!(looks_until_left(30, true), Some(11));
    }
}
