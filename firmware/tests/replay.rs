//! Forces of the device half on positions that another board has read, which QEMU puts into memory: a digest, to be compared
//! with the host's and the other board's.
#![no_std]
#![no_main]

mod listed;
mod lists;
mod replayed;
mod support;

use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m_rt::entry;
use cortex_m_semihosting::hprintln;

/// Number of ticks, then the bits of the position of each, m.
#[expect(unsafe_code, reason = "a section is named")]
// SAFETY: the linker script has the section, which is not loaded, and any words are allowed.
#[unsafe(link_section = ".positions")]
static POSITIONS: [AtomicU32; 200_001] = [const { AtomicU32::new(0) }; 200_001];

fn word(index: u32) -> u32 {
    POSITIONS[index as usize].load(Ordering::Relaxed)
}

#[entry]
fn main() -> ! {
    for list in lists::LISTS.iter().filter(|list| list.name == "full 200 s") {
        let position_m = |tick| f32::from_bits(word(1 + tick));
        let digest = replayed::forces(list, word(0), position_m, |_, _| {});
        hprintln!("{} = {:#010x}", list.name, digest);
    }
    support::pass()
}
