//! A device under a host that says anything: no panic, force within its limits, none unless a run is or was
//! under way.
#![no_main]
#![forbid(unsafe_code)]

use fractional_haptics_fuzz::{Bench, Steps};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let mut bench = Bench::default();
    for step in Steps(bytes) {
        bench.step(step);
    }
});
