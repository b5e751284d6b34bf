//! The same bits on a Cortex-M4F, in QEMU, and what it takes there.

use super::{build, hash, header_of, is_here, output, source};
use std::path::Path;
use std::process::Command;

/// Flash and RAM of half a derivative over an hour: code, tables, history.
const FLASH_MOST: u32 = 3 * 1024;
const RAM_MOST: u32 = 1024;

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_microcontroller_has_the_same_bits_and_room_enough() {
    if !is_here("arm-none-eabi-gcc") || !is_here("qemu-system-arm") {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    for (scheme, order) in [("full", 0.5), ("full", -0.5), ("oustaloup:4:0.1:100", 0.6)] {
        let operator = build::<f32>(scheme, order);
        let image = compile(&header_of(&operator, folder.path()), folder.path());
        let mut qemu = Command::new("qemu-system-arm");
        qemu.args("-M mps2-an386 -icount shift=6,sleep=off -display none -monitor none".split(' '));
        qemu.args("-serial null -semihosting-config enable=on,target=native -kernel".split(' '));
        let said = output(qemu.arg(&image));
        let (have, instructions) = said.split_once('\n').expect("two lines");
        assert_eq!(have, hash(&operator), "{scheme} {order}");
        let instructions = u32::from_str_radix(instructions.trim(), 16).expect("a number");
        println!("{scheme} {order}: {instructions} instructions a step");
    }
}

#[test]
fn half_a_derivative_over_an_hour_is_small() {
    if !is_here("arm-none-eabi-gcc") {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let operator = build::<f32>("full", 0.5);
    header_of(&operator, folder.path());
    let alone = folder.path().join("alone.c");
    // Nothing but the operator: three functions that a linker would keep.
    let program = "#include \"op.h\"\nop_t axis;\nvoid begin(void);\nvoid begin(void) { op_init(&axis); }\n\
        float now(float x);\nfloat now(float x) { return op_output(&axis, x); }\n\
        void then(float x);\nvoid then(float x) { op_advance(&axis, x); }\n";
    std::fs::write(&alone, program).expect("writes");
    let object = folder.path().join("alone.o");
    output(gcc().arg("-c").arg(&alone).arg("-o").arg(&object));
    let said = output(Command::new("arm-none-eabi-size").arg(&object));
    let sizes = said.lines().nth(1).expect("a line of numbers");
    let sizes: Vec<u32> = sizes
        .split_whitespace()
        .map_while(|n| n.parse().ok())
        .collect();
    let (flash, ram) = (sizes[0] + sizes[1], sizes[1] + sizes[2]);
    println!("{flash} B of flash, {ram} B of RAM");
    assert!(flash < FLASH_MOST && ram < RAM_MOST, "{said}");
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

/// An image that runs the operator of the header.
fn compile(header: &Path, folder: &Path) -> std::path::PathBuf {
    let image = folder.join("image");
    let mut gcc = gcc();
    gcc.arg("-DREAL=float").arg("-include").arg(header);
    gcc.args([source("run.c"), source("target.c")]);
    gcc.arg("-nostdlib").arg("-T").arg(source("target.ld"));
    output(gcc.arg("-lgcc").arg("-o").arg(&image));
    image
}
