//! The Pico of `tests/pico`, whose forces are those of the same device half here and on a Cortex-M4F, bit for bit.

use super::board::samples;
use super::image::{Image, built};
use super::lists::LISTS;
use super::{replayed, told};
use haptic_link::Start;
use haptic_remote::serial::{ConnectOptions, SerialLink};
use std::io::Write as _;
use std::time::Duration;

/// Where the image looks for positions, as `firmware/memory/mps2-tests.x` has it.
const INPUT: u32 = 0x2100_0000;

/// The digest of the forces on these positions in QEMU.
fn on_the_cortex_m4f(positions_m: &[f32]) -> u32 {
    let images = built().expect("tests/pico/run night needs QEMU");
    let count = u32::try_from(positions_m.len()).expect("fits");
    let words = core::iter::once(count).chain(positions_m.iter().map(|x| x.to_bits()));
    let bytes: Vec<u8> = words.flat_map(u32::to_le_bytes).collect();
    let mut file = tempfile::NamedTempFile::new().expect("a file");
    file.write_all(&bytes).expect("room");
    let device = format!(
        "loader,file={},addr={INPUT:#x},force-raw=on",
        file.path().display()
    );
    let said = told(&images.run_with(Image::Replay, &["-device".to_owned(), device]));
    let digest = said["full 200 s"].trim_start_matches("0x");
    u32::from_str_radix(digest, 16).expect("a digest")
}

/// `tests/pico/run night` runs it, with a hand that swings behind the pins. The ROM's floats round as IEEE 754 demands but
/// have no subnormal numbers: a difference would begin below 1.2e-38.
#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_a_pico_has_the_forces_of_the_host_and_of_a_cortex_m4f_bit_for_bit() {
    let line = std::env::var("PICO_LINE").expect("tests/pico/run night sets PICO_LINE");
    let ticks = std::env::var("PICO_TICKS").expect("and PICO_TICKS");
    let ticks: u32 = ticks.parse().expect("a number");
    let list = LISTS.iter().find(|list| list.name == "full 200 s");
    let list = list.expect("a list");
    let options = ConnectOptions {
        patience: Duration::from_secs(20),
        ..ConnectOptions::default()
    };
    let mut link = SerialLink::connect(&line, options).expect("answers");
    let (values, count) = replayed::values(list);
    link.set(replayed::configuration(list), &values[..count])
        .expect("good");
    link.arm(Duration::from_secs(5)).expect("arms");
    let start = Start {
        ticks,
        ..Start::ENDLESS
    };
    link.start(start).expect("starts");
    let mut seen = samples(&mut link);
    assert!(seen.len() >= ticks as usize, "{} samples", seen.len());
    seen.truncate(ticks as usize);

    let positions_m: Vec<f32> = (seen.iter().zip(0..))
        .map(|(sample, tick)| {
            assert_eq!(sample.tick, tick, "a sample is missing");
            sample.axes[0].position_m
        })
        .collect();
    let mut moved = 0;
    let read = |tick: u32| positions_m[tick as usize];
    let host = replayed::forces(list, ticks, read, |tick, here| {
        let force = seen[tick as usize].axes[0].force_n;
        assert_eq!(
            force.to_bits(),
            here.to_bits(),
            "tick {tick}: {force:e}, here {here:e}"
        );
        moved += u32::from(force.abs() > 0.05);
    });
    assert!(moved > ticks / 2, "no force in most ticks");
    assert_eq!(on_the_cortex_m4f(&positions_m), host, "on the Cortex-M4F");
    println!("{ticks} ticks, {moved} of them above 50 mN: the same bits on all three");
}
