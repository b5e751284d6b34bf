//! The keeper: the thread that takes from the loop whatever it has done, and frees what the loop needs no more.

use super::ticking::{FromLoop, Ticked};
use rtrb::Consumer;
use std::{sync::mpsc::Receiver, time::Duration};

/// Ticks that are taken at a time, at most.
const BATCH: usize = 1024;

/// Whoever sees each tick of a loop, in its order, in the thread of the keeper.
pub trait Watch: Send {
    /// A request from another thread, which is done before the next ticks are taken.
    type Task: Send;

    /// Does what was asked for.
    fn task(&mut self, task: Self::Task);

    /// Ticks that found the ring full: they come before the next.
    fn lost(&mut self, ticks: u64);

    /// Takes a tick, in the order in which the loop made it.
    fn take(&mut self, ticked: &Ticked);

    /// Keeps what came since the last time, if anything did.
    fn keep(&mut self);

    /// The loop has ended, and all of it is kept.
    fn end(&mut self);
}

/// Takes from the loop until that has ended.
#[derive(Debug)]
pub struct Keeper<W: Watch> {
    from_loop: Consumer<FromLoop>,
    tasks: Receiver<W::Task>,
    /// Pause between two looks at an empty ring.
    pause: Duration,
    watch: W,
    /// The tick that comes next, if none is lost.
    next: u64,
}

impl<W: Watch> Keeper<W> {
    /// Keeper at the other end of this ring.
    pub const fn new(
        from_loop: Consumer<FromLoop>,
        tasks: Receiver<W::Task>,
        pause: Duration,
        watch: W,
    ) -> Self {
        Self {
            from_loop,
            tasks,
            pause,
            watch,
            next: 0,
        }
    }

    /// Works until the loop has ended and all of its samples are kept.
    pub fn run(mut self) {
        loop {
            // Asked before the ring is: what was pushed until then is popped.
            let ended = self.from_loop.is_abandoned();
            while let Ok(task) = self.tasks.try_recv() {
                self.watch.task(task);
            }
            let mut taken = 0;
            while taken < BATCH
                && let Ok(entry) = self.from_loop.pop()
            {
                if let FromLoop::Tick(ticked) = entry {
                    let lost = ticked.number.saturating_sub(self.next);
                    if lost > 0 {
                        self.watch.lost(lost);
                    }
                    self.watch.take(&ticked);
                    self.next = ticked.number + 1;
                    taken += 1;
                }
            }
            self.watch.keep();
            if taken == 0 {
                if ended {
                    break;
                }
                std::thread::sleep(self.pause);
            }
        }
        self.watch.end();
    }
}
