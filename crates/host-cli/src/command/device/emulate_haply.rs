//! `device emulate --kind haply-2diy`.

use super::key_value::in_range;
use crate::output::note;
use haptic_devices::haply::{Model, Version};
use haptic_emulator::haply::{Board, Body, Hand};
use haptic_emulator::{Damage, LineFaults, emulate};
use haptic_experiment::Failure;
use haptic_experiment::parameters::range;
use haptic_remote::serial::Line;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// What a stroking hand does: from here, this far, in this time.
const STROKES: (f64, f64, f64) = (0.085, 0.015, 4.0);

/// An emulated 2DIY.
#[derive(Debug, Default)]
pub(super) struct Haply {
    pub(super) hardware: Option<Version>,
    pub(super) hand: Option<Held>,
}

/// A hand as it is named; the middle of the workspace is that of the hardware.
#[derive(Clone, Copy, Debug)]
pub(super) enum Held {
    Strokes,
    Free,
    At([f64; 2]),
    Fixed([f64; 2]),
}

pub(super) fn version(text: &str) -> Result<Version, String> {
    let found = Version::ALL
        .into_iter()
        .find(|version| version.number().to_string() == text);
    found.ok_or_else(|| "is not a version of a 2DIY: give 2 or 3".to_owned())
}

pub(super) fn hand(text: &str) -> Result<Held, String> {
    let place = |text: &str| -> Result<Option<[f64; 2]>, String> {
        let end = |text| in_range("place_m", range::ARM_PLACES, text);
        let both = text.split_once(':');
        both.map(|(x, y)| Ok([end(x)?, end(y)?])).transpose()
    };
    let (kind, rest) = text.split_once(':').unwrap_or((text, ""));
    let held = match (kind, rest) {
        ("strokes", "") => Some(Held::Strokes),
        ("free", "") => Some(Held::Free),
        ("at", rest) => place(rest)?.map(Held::At),
        ("fixed", rest) => place(rest)?.map(Held::Fixed),
        _ => None,
    };
    held.ok_or_else(|| {
        ("is not a hand: give strokes, free, at:X:Y or fixed:X:Y, as in fixed:19mm:90mm").to_owned()
    })
}

impl Haply {
    /// Runs the board until it is stopped or its time is over.
    pub(super) fn run(
        &self,
        line: Box<dyn Line>,
        faults: (LineFaults, u64),
        duration: Option<Duration>,
        stop: &AtomicBool,
        quiet: bool,
    ) -> Result<(), Failure> {
        let model = self.hardware.unwrap_or_default().model();
        let hand = self.held(&model);
        let mut board = Board::new(model, Body::at_home(&model, hand));
        let damage = emulate(line, &mut board, faults, duration, stop).map_err(Failure::input)?;
        if !quiet {
            note("emulated", in_words(&board, &damage));
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

fn in_words(board: &Board, Damage { to_device, to_host }: &Damage) -> String {
    let place_m = board.body().place_m();
    let (x, y) = (1e3 * place_m.x, 1e3 * place_m.y);
    let [first, second] = board.torques_nm();
    let lost = to_device.dropped + to_host.dropped;
    let damaged = to_device.corrupted + to_host.corrupted;
    let board = board.counted();
    format!(
        "{} configurations, {} frames of torques, {} resets, {} bytes skipped; handle at {x:.3} mm, {y:.3} mm; torques \
         {first:.6} N·m, {second:.6} N·m, the largest asked for {:.6} N·m; the line lost {lost} bytes, damaged {damaged}",
        board.configured, board.torques, board.resets, board.skipped, board.largest_nm
    )
}
