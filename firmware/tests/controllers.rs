//! Controllers on the target: digests of their commands, to be compared with the host's, and the instructions of a tick.
#![no_std]
#![no_main]

#[path = "support/clock.rs"]
mod clock;
mod loops;
mod support;

use clock::{instructions, overhead, passed};
use cortex_m::peripheral::SYST;
use cortex_m_rt::entry;
use cortex_m_semihosting::hprintln;
use fractional_control::{Controller, Rule};

/// Ticks of each count: both set points, the command at its limit and within it.
const TICKS: u32 = 3200;

/// A controller in its loop: command and history together, and the command alone, which is what lies between sensor and force.
fn measure(name: &str, rule: Rule, tolerance: f64) {
    let pid = loops::pid::<f32>(rule, tolerance);
    let (mut history, mut mass) = (pid.at_rest(), loops::Mass::AT_REST);
    let (mut tick, mut path) = (0, 0);
    for n in 0..TICKS {
        let (r, y) = (loops::set_point(n) as f32, mass.position_m);
        let before = SYST::get_current();
        let command = core::hint::black_box(pid.output(&history, r, y));
        let between = SYST::get_current();
        pid.advance(&mut history, r, y, command);
        let after = SYST::get_current();
        let spent = passed(before, between).saturating_sub(overhead());
        path = path.max(instructions(spent));
        let spent = passed(before, after).saturating_sub(2 * overhead());
        tick = tick.max(instructions(spent));
        mass.push(command);
    }
    hprintln!("{} = {} {}", name, tick, path);
}

#[entry]
fn main() -> ! {
    clock::start();
    loops::digests(|name, digest| hprintln!("{} = {:#010x}", name, digest));
    for (name, rule, tolerance) in [
        ("PI^λD^μ 200 s", Rule::Grunwald, 1e-6),
        ("PI^λD^μ 200 s, 1e-4", Rule::Grunwald, 1e-4),
        ("PI^λD^μ 200 s, bdf2", Rule::Bdf2, 1e-6),
    ] {
        measure(name, rule, tolerance);
    }
    support::pass()
}
