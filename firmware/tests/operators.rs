//! Digests of what the operators answer, to be compared with the host's.
#![no_std]
#![no_main]

mod cases;
mod lists;
mod support;

use cortex_m_rt::entry;
use cortex_m_semihosting::hprintln;

#[entry]
fn main() -> ! {
    cases::digests(|name, digest| hprintln!("{} = {:#010x}", name, digest));
    support::pass()
}
