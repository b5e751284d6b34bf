//! Instructions of a tick of the whole device.
#![no_std]
#![no_main]

#[path = "support/clock.rs"]
mod clock;
#[path = "support/counted.rs"]
mod counted;
mod listed;
mod lists;
mod support;

use clock::passed;
use core::cell::Cell;
use cortex_m::peripheral::SYST;
use cortex_m_rt::entry;
use counted::{Counted, TICKS, measure};
use haptic_link::{Capabilities, Guard, GuardKind, Limits};
use haptic_loop::{Device, Fault, Reading, SafeForce};
use haptic_remote::Hardware;
use nalgebra::SVector;

/// A device without hardware: it moves into the wall and back, and looks at the clock.
#[derive(Debug, Default)]
struct Probe {
    tick: u32,
    read_at: Cell<u32>,
    /// Counts from the end of `read` to the start of `write`.
    path: Cell<u32>,
}

impl Probe {
    fn position(&self) -> f32 {
        // In by 20 µm a tick to 4 mm, then out again.
        self.tick.min(TICKS - self.tick.min(TICKS)) as f32 * 2e-5
    }
}

impl Device<f32, 1> for Probe {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, 1>, Fault> {
        let reading = Reading {
            tick: u64::from(self.tick),
            time_s: 0.0,
            position_m: SVector::from([self.position()]),
        };
        self.tick += 1;
        self.read_at.set(SYST::get_current());
        Ok(reading)
    }

    fn write(&mut self, force: SafeForce<f32, 1>) -> Result<(), Fault> {
        let now = SYST::get_current();
        self.path.set(passed(self.read_at.get(), now));
        core::hint::black_box(force);
        Ok(())
    }

    fn let_go(&mut self) {}
}

impl Hardware for Probe {
    type Setup = ();

    fn capabilities(&self) -> Capabilities {
        listed::capabilities("probe")
    }

    fn install(&mut self, (): (), _: u32) {}

    fn restart(&mut self) {
        self.tick = 0;
    }

    fn idle(&mut self) -> Result<Reading<f32, 1>, Fault> {
        self.read()
    }
}

impl Counted for Probe {
    fn path(&self) -> u32 {
        self.path.get()
    }
}

/// Energy bounding with all that it can be told of a device.
const BOUNDED: Limits = Limits {
    guard: Guard {
        kind: GuardKind::EnergyBounding,
        damping_n_s_per_m: 1.0,
        share: 0.8,
        forget_s: 0.5,
        delay_least_samples: 0.3,
        delay_most_samples: 0.5,
        lag_s: 2e-4,
        noise_m: 1e-6,
    },
    ..Limits::bare(2.0, 1000.0)
};

/// A sphere of 5 mm, pressed in by 3 mm.
const SPHERE: [f32; 8] = [200.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
/// The same in tissue that stiffens by b = 10, where e^x is taken up to x = 6.
const STIFFENING: [f32; 8] = [200.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 2000.0];

#[entry]
fn main() -> ! {
    clock::start();
    // Limits of force and rate, as every loop has them; then everything that is on by default.
    for list in lists::all() {
        let count = |name, limits, map| measure(Probe::default(), &list, name, limits, map);
        let bare = Limits::bare(2.0, 1000.0);
        count(list.name, bare, None);
        if list.name == "full 24 h" {
            count("full 24 h, whole chain", Limits::DEFAULT, None);
            count("full 24 h, energy bounding", BOUNDED, None);
            count("full 24 h, sphere", bare, Some(SPHERE));
            count("full 24 h, stiffening", bare, Some(STIFFENING));
        }
    }
    support::pass()
}
