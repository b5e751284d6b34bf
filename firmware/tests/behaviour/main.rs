//! Behaviour of the device on the target: the safety chain, the link, ticks that take too long.
#![no_std]
#![no_main]

mod link;
mod overrun;
mod safety;
#[path = "../support/mod.rs"]
mod support;

use cortex_m_rt::entry;
use cortex_m_semihosting::hprintln;

/// A test and its name.
type Test = (&'static str, fn());

#[entry]
fn main() -> ! {
    for (name, test) in safety::TESTS
        .iter()
        .chain(&link::TESTS)
        .chain(&overrun::TESTS)
    {
        hprintln!("{}", name);
        test();
    }
    support::pass()
}
