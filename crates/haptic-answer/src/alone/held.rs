//! A loop in virtual time, which goes on as somebody's clock says.

use crate::feel::ghost::Company;
use crate::feel::state::POSITION;
use crate::feel::{FeelSettings, JudgedFeel};
use crate::pyramid::Pyramid;
use haptic_document::Failure;
use haptic_loop::Fault;
use haptic_trial::in_hand::hand::{HAND_M, HeldDevice};
use haptic_trial::in_hand::running::{Running, Working};
use haptic_trial::in_hand::ticking::{FeltController, FromLoop, LoopCounts, LoopOrder, rings};
use rtrb::{Consumer, Producer};
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// Ticks that are made at a time, at most: those of a page that was hidden for longer are left out.
const AT_A_TIME: u64 = 250;

#[derive(Debug)]
pub(super) struct HeldLoop {
    pub(super) felt: JudgedFeel,
    pub(super) company: Company,
    orders: Producer<LoopOrder>,
    from_loop: Consumer<FromLoop>,
    counts: Arc<LoopCounts>,
    running: Running,
    engaged: Working<HeldDevice, FeltController>,
    /// The clock at the next tick, ms.
    next_ms: Option<f64>,
}

impl HeldLoop {
    /// The loop, its tissue untouched, whose samples are kept here.
    pub(super) fn start(felt: JudgedFeel, pyramid: &mut Pyramid) -> Result<Self, Failure> {
        let (controller, device, ghosts) = felt.settings.untouched()?;
        let engaged = controller.into_engaged(device);
        pyramid.clear();
        let mut company = Company::new(felt.settings.device.sample_time());
        company.draw(ghosts, pyramid);
        let (orders, ends, from_loop) = rings();
        let counts = Arc::<LoopCounts>::default();
        Ok(Self {
            running: Running::new(ends, Arc::clone(&counts)),
            felt,
            company,
            orders,
            from_loop,
            counts,
            engaged,
            next_ms: None,
        })
    }

    fn give(&mut self, order: LoopOrder) -> Result<(), Failure> {
        let full = |_| Failure::bad_input("the loop does not go on: show the page, and try again");
        self.orders.push(order).map_err(full)
    }

    /// The place that the hand goes to, m.
    pub(super) fn hand(&mut self, position_m: f64, held: bool) -> Result<f64, Failure> {
        let goes_to_m = position_m.clamp(HAND_M.0, HAND_M.1);
        self.give(LoopOrder::Hand(goes_to_m, held))?;
        Ok(goes_to_m)
    }

    pub(super) fn pause(&mut self, paused: bool) -> Result<(), Failure> {
        self.give(LoopOrder::Pause(paused))
    }

    pub(super) fn is_paused(&self) -> bool {
        self.counts.paused.load(Ordering::Relaxed)
    }

    pub(super) fn made(&self) -> u64 {
        self.counts.made.load(Ordering::Relaxed)
    }

    /// The force falls to zero, the hand lets go.
    pub(super) fn stop(&self) {
        self.counts.stops.fetch_add(1, Ordering::Relaxed);
    }

    pub(super) fn arm(&mut self) -> Result<(), Failure> {
        if self.counts.acts.load(Ordering::Relaxed) {
            return Err(Failure::bad_input(
                "a force acts, or falls to zero: `stop` first, and arm again in a moment",
            ));
        }
        let stops = self.counts.stops.load(Ordering::Relaxed);
        let law = self.felt.settings.law()?;
        self.give(LoopOrder::Arm(Box::new(law.into()), stops))
    }

    /// Another law is felt, which hears the past first.
    pub(super) fn change(&mut self, next: FeelSettings, pyramid: &Pyramid) -> Result<(), Failure> {
        let next = next.judged()?;
        self.felt.settings.proves_change(&next.settings)?;
        let mut past = Vec::new();
        let from = self.counts.remembers_from.load(Ordering::Relaxed);
        let first = pyramid.samples_from(from, POSITION, &mut past);
        let (law, ghosts) = next.settings.laws_after(first, &past)?;
        self.give(LoopOrder::Change(Box::new(law.into())))?;
        self.company.draw(ghosts, pyramid);
        self.felt = next;
        Ok(())
    }

    /// Makes the ticks until this time, ms; a fault that came.
    pub(super) fn advance(&mut self, now_ms: f64, pyramid: &mut Pyramid) -> Option<Fault> {
        let period_ms = 1e3 * self.felt.settings.device.sample_time_s;
        let next_ms = *self.next_ms.get_or_insert(now_ms);
        let due = ((now_ms - next_ms) / period_ms).max(0.0).floor() as u64;
        self.next_ms = Some(next_ms + due as f64 * period_ms);
        let left_out = due.saturating_sub(AT_A_TIME);
        let was_well = self.company.state.fault.is_none();
        for tick in left_out..due {
            self.running.obeys(&mut self.engaged);
            // Virtual time takes none.
            let skipped = if tick == left_out { left_out } else { 0 };
            self.running.tick(&mut self.engaged, || 0, (0, skipped));
            while let Ok(news) = self.from_loop.pop() {
                if let FromLoop::Tick(ticked) = news {
                    pyramid.push(&self.company.take(&ticked));
                }
            }
        }
        self.company.settle(pyramid);
        self.company.state.fault.filter(|_| was_well)
    }
}
