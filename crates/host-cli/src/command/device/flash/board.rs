//! The boards that `device flash` knows.

use std::ops::Range;

/// A board of `firmware/`.
#[derive(Debug)]
pub(super) struct Board {
    /// As the device calls itself; `cargo image-NAME` builds its image.
    pub(super) name: &'static str,
    /// Folder of its workspace, below that of the firmware.
    pub(super) folder: &'static str,
    pub(super) flash: Range<u32>,
    pub(super) way: Way,
}

/// How an image gets into a board.
#[derive(Debug)]
pub(super) enum Way {
    /// As probe-rs calls the chip.
    Probe(&'static str),
    /// As the boot loader calls its board, its family of images.
    Drive(&'static str, u32),
}

pub(super) const BOARDS: &[Board] = &[
    Board {
        name: "nucleo-f446re",
        folder: ".",
        flash: 0x0800_0000..0x0808_0000,
        way: Way::Probe("STM32F446RETx"),
    },
    Board {
        name: "rp2040",
        folder: "examples/rp2040",
        flash: 0x1000_0000..0x1020_0000,
        way: Way::Drive("RPI-RP2", 0xe48b_ff56),
    },
    Board {
        name: "rp2350",
        folder: "examples/rp2040",
        flash: 0x1000_0000..0x1040_0000,
        way: Way::Drive("RP2350", 0xe48b_ff59),
    },
];

pub(super) fn boards() -> Vec<(&'static Board, &'static str, &'static str)> {
    BOARDS.iter().map(|board| (board, board.name, "")).collect()
}
