//! Instructions of a tick of a whole device, and in it from the end of its reading to its command.

use super::clock::{instructions, overhead, passed};
use super::{listed, lists};
use cortex_m::peripheral::SYST;
use cortex_m_semihosting::hprintln;
use haptic_link::{Configuration, Limits, Start};
use haptic_remote::{Hardware, TickSide, prepare};

/// Ticks of each run: the push into the wall, the saturated force, the way back out.
pub(crate) const TICKS: u32 = 400;
/// Ticks before it, in which the sensor of a robot rests.
const RESTING: u64 = 250;

/// A device that counts from the end of its reading to the start of its command.
pub(crate) trait Counted: Hardware<1, Setup = ()> {
    /// Counts of the last tick.
    fn path(&self) -> u32;
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

/// Prints what the longest tick and the longest path of a run take.
pub(crate) fn measure<H: Counted>(
    hardware: H,
    list: &lists::List,
    name: &str,
    limits: Limits,
    depth_map: Option<[f32; 8]>,
) {
    let (values, count) = list.values();
    let values = &values[..count];
    let mut device = TickSide::new(hardware).expect("a board");
    // Behind a pointer, as on a board: places in a stack frame of this size cost instructions of their own.
    let device = core::hint::black_box(&mut device);
    let capabilities = device.hardware().capabilities();
    let prepared = prepare::<H, 1>(
        configuration(list, limits, depth_map),
        values,
        &capabilities,
    )
    .expect("good");
    device.install(prepared, values).expect("idle");
    let (mut tick, mut path) = (0, 0);
    // One loop for both, as a second call would change how the tick is compiled.
    for n in 1..=RESTING + u64::from(TICKS) {
        let now_us = 1000 * n;
        device.heard(now_us, false);
        if n == RESTING {
            device.arm(0).expect("no fault");
            device.start(Start::ENDLESS).expect("armed");
        }
        while device.next_report().is_some() {}
        let before = SYST::get_current();
        device.tick(now_us);
        let after = SYST::get_current();
        // The probe looks at the clock twice itself.
        let spent = passed(before, after);
        tick = tick.max(instructions(spent.saturating_sub(3 * overhead())));
        let spent = device.hardware().path();
        path = path.max(instructions(spent.saturating_sub(overhead())));
    }
    assert_eq!(
        device.statistics().samples_dropped,
        0,
        "every tick had to keep a sample"
    );
    hprintln!("{} = {} {}", name, tick, path);
}
