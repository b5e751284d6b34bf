//! Forces of the device half on positions that another board has read, which QEMU puts into memory: a digest, to be compared
//! with the host's and the other board's.
#![no_std]
#![no_main]

mod listed;
mod lists;
mod replayed;
mod support;

use cortex_m_rt::entry;
use cortex_m_semihosting::hprintln;

/// Memory of the machine in which the image has nothing, 16 MiB: number of ticks, then the bits of the position of each, m.
const INPUT: usize = 0x2100_0000;
/// Ticks that fit.
const TICKS_MOST: usize = 1_000_000;

#[entry]
fn main() -> ! {
    #[expect(unsafe_code, reason = "memory that QEMU has filled")]
    // SAFETY: it is there and aligned, nobody writes it, and any words are allowed.
    let words = unsafe { core::slice::from_raw_parts(INPUT as *const u32, 1 + TICKS_MOST) };
    for list in lists::all().filter(|list| list.name == "full 200 s") {
        let position_m = |tick| f32::from_bits(words[1 + tick as usize]);
        let digest = replayed::forces(&list, words[0], position_m, |_, _| {});
        hprintln!("{} = {:#010x}", list.name, digest);
    }
    support::pass()
}
