//! Instructions of a tick of the whole device.
#![no_std]
#![no_main]

#[path = "support/clock.rs"]
mod clock;
mod listed;
mod lists;
mod support;

use clock::{instructions, overhead, passed};
use core::cell::Cell;
use cortex_m::peripheral::SYST;
use cortex_m_rt::entry;
use cortex_m_semihosting::hprintln;
use haptic_link::{Capabilities, Configuration, Guard, GuardKind, Limits, Start};
use haptic_loop::{Device, Fault, Reading, SafeForce};
use haptic_remote::{Hardware, TickSide, prepare};
use nalgebra::SVector;

/// Ticks of each run: the push into the wall, the saturated force, the way back out.
const TICKS: u32 = 400;

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

/// A one-sided wall of 1 N/mm with this operator, 2 N at most, so that every branch of the chain is taken.
fn configuration(list: &lists::List, limits: Limits, depth_map: Option<[f32; 8]>) -> Configuration {
    Configuration {
        stiffness_n_per_m: 1000.0,
        dissipation_n_s_mu_per_m: 5.0,
        one_sided: true,
        surface_m: 1e-3,
        operator: listed::shape(list),
        limits: Limits {
            force_n: 2.0,
            watchdog_ms: 1000,
            ..limits
        },
        depth_map,
        ..Configuration::PASSIVE
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

fn measure(list: &lists::List, name: &str, limits: Limits, depth_map: Option<[f32; 8]>) {
    let (values, count) = list.values();
    let values = &values[..count];
    let mut device = TickSide::new(Probe::default()).expect("a board");
    // Behind a pointer, as on a board: places in a stack frame of this size cost instructions of their own.
    let device = core::hint::black_box(&mut device);
    let capabilities = device.hardware().capabilities();
    let prepared = prepare::<Probe, 1>(
        configuration(list, limits, depth_map),
        values,
        &capabilities,
    )
    .expect("good");
    device.install(prepared, values).expect("idle");
    device.arm(0).expect("no fault");
    device.start(Start::ENDLESS).expect("armed");
    let (mut tick, mut path) = (0, 0);
    for n in 1..=TICKS {
        let now_us = 1000 * u64::from(n);
        device.heard(now_us, false);
        while device.next_report().is_some() {}
        let before = SYST::get_current();
        device.tick(now_us);
        let after = SYST::get_current();
        // The probe looks at the clock twice itself.
        let spent = passed(before, after);
        tick = tick.max(instructions(spent.saturating_sub(3 * overhead())));
        let spent = device.hardware().path.get();
        path = path.max(instructions(spent.saturating_sub(overhead())));
    }
    assert_eq!(
        device.statistics().samples_dropped,
        0,
        "every tick had to keep a sample"
    );
    hprintln!("{} = {} {}", name, tick, path);
}

#[entry]
fn main() -> ! {
    clock::start();
    // Limits of force and rate, as every loop has them; then everything that is on by default.
    for list in lists::all() {
        let bare = Limits::bare(2.0, 1000.0);
        measure(&list, list.name, bare, None);
        if list.name == "full 24 h" {
            measure(&list, "full 24 h, whole chain", Limits::DEFAULT, None);
            measure(&list, "full 24 h, energy bounding", BOUNDED, None);
            measure(&list, "full 24 h, sphere", bare, Some(SPHERE));
            measure(&list, "full 24 h, stiffening", bare, Some(STIFFENING));
        }
    }
    support::pass()
}
