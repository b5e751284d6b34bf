//! `device emulate --kind haply-2diy`.

use crate::output::note;
use crate::within::in_range;
use clap::Args;
use haptic_devices::haply::{Model, Version};
use haptic_emulator::LineFaults;
use haptic_emulator::haply::{Board, Body, Emulated, Hand, emulate};
use haptic_experiment::failure::Failure;
use haptic_experiment::parameters::range;
use haptic_quantity::Length;
use haptic_remote::serial::Line;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// What a stroking hand does: from here, this far, in this time.
const STROKES: (f64, f64, f64) = (0.085, 0.015, 4.0);

/// Options of an emulated 2DIY.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Haply 2DIY")]
pub struct HaplyArguments {
    /// Version of the hardware, 2 or 3 [default: 3]
    #[arg(long, value_name = "VERSION", value_parser = version)]
    hardware: Option<Version>,
    /// What a hand does once the board is configured: `strokes`, `free`, `at:X:Y`, or `fixed:X:Y` whatever the motors do
    /// [default: strokes, along y from 85 mm to 100 mm and back in 4 s]
    #[arg(long, value_name = "HAND", value_parser = hand)]
    hand: Option<Held>,
}

/// A hand as it is named; the middle of the workspace is that of the hardware.
#[derive(Clone, Copy, Debug)]
enum Held {
    Strokes,
    Free,
    At([f64; 2]),
    Fixed([f64; 2]),
}

fn version(text: &str) -> Result<Version, String> {
    let found = Version::ALL
        .into_iter()
        .find(|version| version.number().to_string() == text);
    found.ok_or_else(|| format!("\"{text}\" is no version of a 2DIY: 2 or 3"))
}

fn hand(text: &str) -> Result<Held, String> {
    let place = |text: &str| {
        let (x, y) = text.split_once(':')?;
        let metres = |text: &str| text.parse::<Length>().ok();
        Some([metres(x)?, metres(y)?])
    };
    let in_reach = |[x, y]: [Length; 2]| -> Result<[f64; 2], String> {
        Ok([
            in_range(x, range::ARM_PLACES)?.0,
            in_range(y, range::ARM_PLACES)?.0,
        ])
    };
    let (kind, rest) = text.split_once(':').unwrap_or((text, ""));
    let held = match (kind, rest) {
        ("strokes", "") => Some(Held::Strokes),
        ("free", "") => Some(Held::Free),
        ("at", rest) => place(rest).map(in_reach).transpose()?.map(Held::At),
        ("fixed", rest) => place(rest).map(in_reach).transpose()?.map(Held::Fixed),
        _ => None,
    };
    held.ok_or_else(|| {
        format!("\"{text}\" is no hand: strokes, free, at:X:Y or fixed:X:Y, as fixed:19mm:90mm")
    })
}

impl HaplyArguments {
    /// True if any of them was given.
    pub(super) const fn is_given(&self) -> bool {
        self.hardware.is_some() || self.hand.is_some()
    }

    /// Runs the board until it is stopped or its time is over.
    pub(super) fn run(
        &self,
        line: Box<dyn Line>,
        (faults, seed): (LineFaults, u64),
        duration: Option<Duration>,
        stop: &AtomicBool,
        quiet: bool,
    ) -> Result<(), Failure> {
        let model = self.hardware.unwrap_or_default().model();
        let hand = self.held(&model);
        let board = Board::new(model, Body::at_home(&model, hand));
        let done = emulate(line, board, faults, seed, duration, stop).map_err(Failure::input)?;
        if !quiet {
            note("emulated", in_words(&done));
        }
        Ok(())
    }

    fn held(&self, model: &Model) -> Hand {
        match self.hand.unwrap_or(Held::Strokes) {
            Held::Free => Hand::Free,
            Held::At(place) => Hand::At(place),
            Held::Fixed(place) => Hand::Fixed(place),
            Held::Strokes => {
                let (from_m, depth_m, time_s) = STROKES;
                Hand::Strokes {
                    from: [0.5 * model.pantograph.base_m(), from_m],
                    depth_m,
                    time_s,
                }
            }
        }
    }
}

fn in_words(done: &Emulated) -> String {
    let board = done.board;
    let [x, y] = done.place_m.map(|place| 1e3 * place);
    let [first, second] = done.torques_nm;
    let lost = done.to_board.dropped + done.to_host.dropped;
    let damaged = done.to_board.corrupted + done.to_host.corrupted;
    format!(
        "{} configurations, {} frames of torques, {} resets, {} bytes skipped; handle at {x:.3} mm, {y:.3} mm; torques \
         {first:.6} N·m, {second:.6} N·m, the largest asked for {:.6} N·m; the line lost {lost} bytes, damaged {damaged}",
        board.configured, board.torques, board.resets, board.skipped, board.largest_nm
    )
}
