//! The same bits on a Cortex-M4F, in QEMU, and what it takes there.

use super::{
    build,
    controller::{self, Case},
    hash, header_of, is_here, output, source,
};
use std::{path::Path, process::Command};
use testkit::Folder;

/// Flash and RAM of half a derivative over an hour, and of a PI^λD^μ over 200 s: code, tables, history. A quarter of a KiB of the
/// controller is what it makes of the command that was applied.
const FLASH_MOST: u32 = 3 * 1024 + 256;
const RAM_MOST: u32 = 1024;
/// Instructions of a sample of that PI^λD^μ.
const TICK_MOST: u32 = 1200;

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_microcontroller_has_the_same_bits() {
    if !is_here("arm-none-eabi-gcc") || !is_here("qemu-system-arm") {
        return;
    }
    let folder = Folder::empty();
    for (scheme, order) in [("full", 0.5), ("full", -0.5), ("oustaloup:4:0.1:100", 0.6)] {
        let operator = build::<f32>(scheme, order);
        let header = header_of(&operator, &folder);
        let instructions = run(&header, "run.c", "", &hash(&operator));
        println!("{scheme} {order}: {instructions} instructions a step");
    }
    for case in Case::on_target() {
        let header = controller::header_of::<f32>(&case.setup, &folder);
        let want = controller::hash::<f32>(&case);
        let instructions = run(&header, "controller.c", case.change, &want);
        println!(
            "{} {}: {instructions} instructions a sample",
            case.name, case.setup.scheme
        );
        assert!(
            case.name != "pid" || instructions <= TICK_MOST,
            "{instructions}"
        );
    }
}

#[test]
fn half_a_derivative_over_an_hour_is_small() {
    let folder = Folder::empty();
    header_of(&build::<f32>("full", 0.5), &folder);
    // Nothing but the operator: three functions that a linker would keep.
    is_small(
        &folder,
        "op_t axis;\nvoid begin(void);\nvoid begin(void) { op_init(&axis); }\n\
         float now(float x);\nfloat now(float x) { return op_output(&axis, x); }\n\
         void then(float x);\nvoid then(float x) { op_advance(&axis, x); }\n",
    );
}

#[test]
fn a_controller_over_200_s_is_small() {
    let folder = Folder::empty();
    controller::header_of::<f32>(&Case::on_target()[0].setup, &folder);
    is_small(
        &folder,
        "op_t c;\nvoid begin(void);\nvoid begin(void) { op_init(&c); }\n\
         float now(float r, float y);\nfloat now(float r, float y) { return op_output(&c, r, y); }\n\
         void then(float r, float y, float u);\n\
         void then(float r, float y, float u) { op_advance(&c, r, y, u); }\n\
         void by_hand(float r, float y, float u);\n\
         void by_hand(float r, float y, float u) { op_follow(&c, r, y, u); }\n",
    );
}

/// These functions around the header in the folder fit.
fn is_small(folder: &Path, functions: &str) {
    if !is_here("arm-none-eabi-gcc") {
        return;
    }
    let alone = folder.join("alone.c");
    std::fs::write(&alone, format!("#include \"op.h\"\n{functions}")).expect("writes");
    let object = folder.join("alone.o");
    output(gcc().arg("-c").arg(&alone).arg("-o").arg(&object));
    let message = output(Command::new("arm-none-eabi-size").arg(&object));
    let sizes = message.lines().nth(1).expect("a line of numbers");
    let sizes: Vec<u32> = sizes
        .split_whitespace()
        .map_while(|n| n.parse().ok())
        .collect();
    let (flash, ram) = (sizes[0] + sizes[1], sizes[1] + sizes[2]);
    println!("{flash} B of flash, {ram} B of RAM");
    assert!(flash < FLASH_MOST && ram < RAM_MOST, "{message}");
}

/// The compiler of the target.
fn gcc() -> Command {
    let mut gcc = Command::new("arm-none-eabi-gcc");
    gcc.args("-std=c99 -O2 -mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16".split(' '));
    gcc.args(
        "-ffp-contract=off -ffreestanding -Wall -Wextra -Wpedantic -Wconversion -Werror".split(' '),
    );
    gcc
}

/// Runs a header with this program, whose hash is known; the instructions of its dearest sample.
fn run(header: &Path, program: &str, change: &str, want: &str) -> u32 {
    let image = header.with_extension("image");
    let mut gcc = gcc();
    gcc.arg("-DREAL=float").arg("-include").arg(header);
    if !change.is_empty() {
        gcc.arg(format!("-DCHANGE={change}"));
    }
    gcc.args([source(program), source("target.c")]);
    gcc.arg("-nostdlib").arg("-T").arg(source("target.ld"));
    output(gcc.arg("-lgcc").arg("-o").arg(&image));
    let mut qemu = Command::new("qemu-system-arm");
    qemu.args("-M mps2-an386 -icount shift=6,sleep=off -display none -monitor none".split(' '));
    qemu.args("-serial null -semihosting-config enable=on,target=native -kernel".split(' '));
    let message = output(qemu.arg(&image));
    let (have, instructions) = message.split_once('\n').expect("two lines");
    assert_eq!(have, want, "{}", header.display());
    u32::from_str_radix(instructions.trim(), 16).expect("a number")
}
