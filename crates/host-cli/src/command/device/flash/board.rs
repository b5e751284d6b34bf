//! The boards that `device flash` knows.

use haptic_experiment::Failure;
use std::ops::Range;

/// A board of `firmware/`.
#[derive(Debug)]
pub(super) struct Board {
    /// Name by which the device calls itself; `cargo image-NAME` builds its image.
    pub(super) name: &'static str,
    /// Name under which it is sold; empty if there is no other name.
    pub(super) sold_as: &'static str,
    /// Folder of its workspace, below that of the firmware.
    pub(super) folder: &'static str,
    pub(super) flash: Range<u32>,
    pub(super) way: Way,
}

/// Way to load an image into a board.
#[derive(Debug)]
pub(super) enum Way {
    /// Name by which probe-rs calls the chip.
    Probe(&'static str),
    /// Name by which the boot loader calls its board, and its family of images.
    Drive(&'static str, u32),
}

pub(super) const BOARDS: &[Board] = &[
    Board {
        name: "nucleo-f446re",
        sold_as: "",
        folder: ".",
        flash: 0x0800_0000..0x0808_0000,
        way: Way::Probe("STM32F446RETx"),
    },
    Board {
        name: "rp2040",
        sold_as: "pico",
        folder: "examples/rp2040",
        flash: 0x1000_0000..0x1020_0000,
        way: Way::Drive("RPI-RP2", 0xe48b_ff56),
    },
    Board {
        name: "rp2350",
        sold_as: "pico2",
        folder: "examples/rp2040",
        flash: 0x1000_0000..0x1040_0000,
        way: Way::Drive("RP2350", 0xe48b_ff59),
    },
];

/// Each board by each of its names.
pub(super) fn boards() -> Vec<(&'static Board, &'static str, &'static str)> {
    let names = |board: &'static Board| [(board, board.name, ""), (board, board.sold_as, "")];
    let named = BOARDS.iter().flat_map(names);
    named.filter(|(_, name, _)| !name.is_empty()).collect()
}

impl Board {
    /// The board to program where none is named: that of the one boot loader whose drive is among these; without any, the first.
    pub(super) fn at(drives: &[String]) -> Result<&'static Self, Failure> {
        let shows = |board: &Self| match board.way {
            Way::Probe(_) => false,
            Way::Drive(id, _) => drives.iter().any(|drive| drive == id),
        };
        let mut shown = BOARDS.iter().filter(|board| shows(board));
        match (shown.next(), shown.next()) {
            (None, _) => Ok(&BOARDS[0]),
            (Some(board), None) => Ok(board),
            (Some(one), Some(other)) => Err(Failure::device(format_args!(
                "drives of {} and {} are mounted: choose with --board, or unplug one",
                one.name, other.name
            ))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mounted_drive_chooses_the_board_and_each_is_found_by_the_name_it_is_sold_under() {
        for (drives, chosen) in [
            ("", "nucleo-f446re"),
            ("OTHER", "nucleo-f446re"),
            ("OTHER RP2350", "rp2350"),
            ("RPI-RP2 RPI-RP2", "rp2040"),
            ("RPI-RP2 RP2350", "rp2040 and rp2350"),
        ] {
            let ids: Vec<String> = drives.split(' ').map(str::to_owned).collect();
            let name = Board::at(&ids).map_or_else(|no| no.to_string(), |it| it.name.to_owned());
            assert!(name.contains(chosen), "{drives}: {name}");
        }
        let pico = boards().into_iter().find(|board| board.1 == "pico");
        assert_eq!(pico.expect("known").0.name, "rp2040");
    }
}
