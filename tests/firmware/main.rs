//! The firmware in an emulator: the same bits as here, within its budgets, and it speaks.
//!
//! Needs the Rust target thumbv7em-none-eabihf and qemu-system-arm; without them these tests are skipped, or
//! fail where `REQUIRE_ALL_CHECKS` is set. `UPDATE_FIRMWARE_TABLES=1` writes `firmware/instructions.toml`
//! and `firmware/tests/lists.txt` anew.

#![cfg(unix)]

mod board;
#[path = "../../firmware/tests/cases.rs"]
mod cases;
mod image;
#[path = "../../firmware/tests/listed.rs"]
mod listed;
#[path = "../../firmware/tests/lists.rs"]
mod lists;
#[path = "../../firmware/tests/loops.rs"]
mod loops;
mod muscle;
mod pico;
mod relaxation;
#[path = "../../firmware/tests/replayed.rs"]
mod replayed;
mod selftest;
mod tables;
mod template;

use board::{Emulator, samples};
use fracdiff::{Operator, Order, Scheme, Seconds};
use haptic_link::{
    Configuration, DeviceReport, Limits, OperatorShape, Request, Simulation, SimulationKind, Start,
    State,
};
use haptic_remote::operator_shape;
use haptic_remote::serial::SerialLink;
use image::{Image, built};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;
use tables::CONTROLLER;

/// Flash that the device may take.
const FLASH_MAX: u32 = 58 * 1024;
/// RAM that its variables may take.
const STATIC_MAX: u32 = 12 * 1024;
/// And its stack: most of it prepares a simulated plant.
const STACK_MAX: u32 = 16 * 1024;
/// RAM that a board with a motor may take, stack included.
const RAM_MAX: u32 = 18 * 1024;
/// Instructions of a whole tick with full memory.
const TICK_MAX: u32 = 1600;
/// Instructions of a PI^λD^μ with 200 s of memory: command, history, and the average by which the clock of its integral stands.
const CONTROLLER_MAX: u32 = 1300;
/// Share of a robot's tick, with a mass as its body, in that of a force device with the same law and limits.
const ROBOT_MAX: f64 = 1.5;
/// Instructions from sensor to force, with limits of force and rate.
const PATH_MAX: u32 = 200;
/// The same as the first under a sphere in tissue that stiffens: a root and an exponential.
const MAPPED_PATH_MAX: u32 = 260;
/// The same with start-up ramp, speed limit and braking too.
const WHOLE_PATH_MAX: u32 = 320;
/// The same as the first with energy bounding, told a delay, a lag and a noise.
const BOUNDED_PATH_MAX: u32 = 800;

/// The folder of the firmware.
fn firmware() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("firmware")
}

fn updating() -> bool {
    std::env::var_os("UPDATE_FIRMWARE_TABLES").is_some()
}

/// The lines `name = value` that an image prints.
fn printed(output: &str) -> BTreeMap<String, String> {
    output
        .lines()
        .filter_map(|line| line.split_once(" = "))
        .map(|(name, value)| (name.to_owned(), value.to_owned()))
        .collect()
}

#[test]
fn lists_in_the_firmware_are_what_the_schemes_make_today() {
    tables::check_lists();
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn operators_have_the_same_bits_on_the_target() {
    let Some(images) = built() else { return };
    let have = printed(&images.run(Image::Operators));
    let mut want = BTreeMap::new();
    cases::digests(|name, digest| {
        want.insert(name.to_string(), format!("{digest:#010x}"));
    });
    assert!(want.len() > 100, "the cases are there: {}", want.len());
    for (name, want) in &want {
        assert_eq!(have.get(name), Some(want), "{name}");
    }
    assert_eq!(have.len(), want.len());
    println!("{} cases, the same bits on host and target", want.len());
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn controllers_have_the_same_bits_on_the_target() {
    let Some(images) = built() else { return };
    let have = printed(&images.run(Image::Controllers));
    let mut cases = 0;
    loops::digests(|name, digest| {
        let want = format!("{digest:#010x}");
        assert_eq!(have.get(&name.to_string()), Some(&want), "{name}");
        cases += 1;
    });
    assert_eq!(cases, 3);
    println!("{cases} controllers, the same bits over 10^4 samples on host and target");
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn ticks_follow_their_period_and_one_that_takes_too_long_latches_a_fault() {
    let Some(images) = built() else { return };
    images.run(Image::Behaviour);
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_tick_takes_the_instructions_of_the_table() {
    let Some(images) = built() else { return };
    let mut have = printed(&images.run(Image::Instructions));
    have.extend(printed(&images.run(Image::Robots)));
    let controllers = printed(&images.run(Image::Controllers));
    have.extend(
        controllers
            .into_iter()
            .filter(|(name, _)| name.starts_with(CONTROLLER)),
    );
    let counts = tables::check_instructions(&have);
    for (name, count) in &counts {
        println!(
            "{name}: a tick {}, from sensor to force {}",
            count.tick, count.path
        );
        let most = match name.rsplit(", ").next() {
            Some("whole chain") => WHOLE_PATH_MAX,
            Some("energy bounding") => BOUNDED_PATH_MAX,
            Some("stiffening") => MAPPED_PATH_MAX,
            _ => PATH_MAX,
        };
        // The path of a robot ends with the command of its body.
        let robot = name.strip_prefix("robot, ");
        assert!(
            count.path <= most || robot.is_some(),
            "{name}: {} from sensor to force",
            count.path
        );
        let share = robot
            .and_then(|law| counts.get(law))
            .map(|force| f64::from(count.tick) / f64::from(force.tick));
        assert!(
            share.is_none_or(|share| share <= ROBOT_MAX),
            "{name}: {share:?} of a force device"
        );
        // The second-order rule has 28 taps a power more.
        let controller = name.starts_with(CONTROLLER) && !name.ends_with("bdf2");
        assert!(
            count.tick <= CONTROLLER_MAX || !controller,
            "{name}: {} in a tick",
            count.tick
        );
        assert!(
            count.tick <= TICK_MAX || !(name.starts_with("full") || name.starts_with("fractional")),
            "{name}: {} in a tick",
            count.tick
        );
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_device_fits_its_budget() {
    let Some(images) = built() else { return };
    let size = images.size();
    println!(
        "flash {} B of {FLASH_MAX}, variables {} B of {STATIC_MAX}, stack {} B of {STACK_MAX}",
        size.flash, size.data, size.stack
    );
    assert!(size.flash <= FLASH_MAX);
    assert!(size.data <= STATIC_MAX);
    assert!(size.stack <= STACK_MAX);
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_device_for_the_real_board_builds_and_fits() {
    let Some(images) = image::real_board() else {
        return;
    };
    let size = images.size();
    println!(
        "NUCLEO-F446RE: flash {} B, variables {} B, stack {} B",
        size.flash, size.data, size.stack
    );
    assert!(size.flash <= FLASH_MAX);
    assert!(size.data + size.stack <= RAM_MAX);
}

/// Everything that can be set, so that every path of a commit is taken.
fn configuration(operator: OperatorShape, kind: SimulationKind) -> Configuration {
    Configuration {
        stiffness_n_per_m: 100.0,
        dissipation_n_s_mu_per_m: 2.0,
        one_sided: true,
        operator,
        limits: Limits {
            // An emulator that shares its processor with others may stand still for a while.
            watchdog_ms: 1000,
            late_ticks: 0,
            ..Limits::DEFAULT
        },
        simulation: Simulation {
            kind,
            push_n: 1.0,
            hand_stiffness_n_per_m: 100.0,
            depth_m: 1e-3,
            ramp_time_s: 0.5,
            ..Simulation::TESTBED
        },
        ..Configuration::PASSIVE
    }
}

/// What a board says of itself.
fn introduces_itself(link: &SerialLink, digest: u32) {
    let Ok(DeviceReport::Keys(keys)) = link.ask(Request::GetKeys) else {
        panic!("keys");
    };
    // Those of one axis, and no others: there is no room for a message that nobody sends.
    assert_eq!(keys.first_unlike(1), None);
    assert_eq!(keys.first_unlike(2), Some("workspace"));
    let status = link.status();
    assert_eq!((status.state, status.fault), (State::Idle, 0));
    assert_eq!(link.capabilities().board(), "mps2-an386");
    assert!(link.capabilities().simulated);
    assert_eq!(link.capabilities().image_digest, digest, "this very image");
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_device_converses_runs_and_keeps_within_its_stack() {
    let Some(images) = built() else { return };
    let mut emulator = Emulator::start(&images.path(Image::Device));
    let mut link = emulator.connected().expect("answers");
    introduces_itself(&link, images.size().digest);
    let order = Order::new(0.2247).expect("valid");
    let schemes = [
        "grunwald:256",
        "tustin-muir:9",
        "oustaloup:9:0.01:100",
        "full",
    ];
    let kinds = [SimulationKind::MassDamper, SimulationKind::RigidIndentation];
    let mut heard = 0;
    for kind in kinds {
        for scheme in schemes {
            let parsed: Scheme = scheme.parse().expect("valid");
            let operator: Operator<f32> = parsed.build(order, Seconds(1e-3), 8.64e7).expect("fits");
            let (shape, values) = operator_shape(&operator).expect("short");
            link.set(configuration(shape, kind), &values).expect("good");
        }
        link.arm(Duration::from_secs(1)).expect("arms");
        let start = Start {
            ticks: 500,
            batch: 16,
            ..Start::ENDLESS
        };
        link.start(start).expect("starts");
        heard += samples(&mut link).len();
        link.disarm().expect("disarms");
        assert!(link.wait_for_rest());
    }
    let counters = link.statistics().expect("answers");
    println!("{counters:?}");
    assert_eq!(
        (counters.corrupt, counters.lost, counters.bytes_overrun),
        (0, 0, 0)
    );
    // A run sends each of its ticks once; the force then falls in a few more. What this process was too busy to read is
    // counted.
    let dropped = counters.samples_dropped as usize;
    assert!(
        heard + dropped >= 500 * kinds.len(),
        "{heard} samples, {dropped} dropped"
    );
    let stack = images.size().stack;
    let used = emulator.stack_used(stack);
    println!("stack: {used} B of {stack} used");
    // An interrupt at the deepest point takes one frame with the floating-point registers more, 104 B.
    assert!(used + 256 <= stack, "less than 256 B of the stack are left");
}
