//! A bridge against hosts of every kind: in virtual time without a line, and through its functions in C over TCP.
#![expect(
    clippy::float_cmp,
    reason = "a force is that of the loop to the last bit, and zero is zero"
)]

mod bad_input;
mod bench;
mod calls;
mod cost;
mod cpp;
mod enemies;
mod host;
mod motion;
mod mutants;
mod over_tcp;
mod period;
mod same_force;

use std::{
    alloc::{GlobalAlloc, Layout, System},
    cell::Cell,
};

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

/// Allocations of this thread so far.
fn allocations() -> u64 {
    ALLOCATIONS.with(Cell::get)
}

/// The allocator of the system, which counts.
struct Counting;

#[expect(unsafe_code, reason = "it hands on to the allocator of the system")]
// SAFETY: as that of the system, to which each call goes as it is.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // A thread that ends has no counter any more.
        let _ = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(memory, layout) };
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;
