//! The straight line through the readings of an instrument, with one offset for each way of the force.

use super::CALIBRATE_FORCE;
use crate::document::failure::Failure;
use crate::run::plant_file::calibration::Estimate;
use serde::Serialize;

/// A reading of the instrument.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(super) struct Point {
    /// Force that the device says it made, N.
    pub commanded_n: f64,
    /// Force that the instrument showed, N.
    pub force_n: f64,
    /// Reading of the device's sensor, N; NaN without one.
    pub sensed_n: f64,
    /// The force was reached from above.
    pub falling: bool,
    /// Friction held the handle where it was: the reading says nothing of this force.
    pub held: bool,
}

impl Point {
    pub(super) fn rising(commanded_n: f64, force_n: f64) -> Self {
        Self {
            commanded_n,
            force_n,
            sensed_n: f64::NAN,
            ..Self::default()
        }
    }
}

/// A line through readings.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub slope: Estimate,
    /// Reading of a sensor without force, N.
    pub zero: Estimate,
    /// Half of what lies between the way up and the way down, N of the instrument.
    pub friction_n: f64,
}

/// Student's t for 95 %, for 1 to 9 degrees of freedom.
const STUDENT: [f64; 9] = [
    12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262,
];
/// Half the width of an interval over its value, beyond which it tells no factor.
const TELLS: f64 = 0.5;

/// The line through the readings of an instrument with this step, N; friction of `known_n` is where one way alone was read.
///
/// # Errors
/// Readings that tell no slope, each with its remedy; `falls` is that for a force that falls where the command grows.
pub(super) fn line(
    points: &[Point],
    step_n: f64,
    known_n: f64,
    falls: &str,
) -> Result<Line, Failure> {
    let ways = [false, true].map(|falling| {
        let used = points
            .iter()
            .filter(|point| !point.held && point.falling == falling);
        let used: Vec<[f64; 2]> = used
            .map(|point| [point.commanded_n, point.force_n])
            .collect();
        let mean =
            |part: usize| used.iter().map(|pair| pair[part]).sum::<f64>() / used.len() as f64;
        let [commanded_n, force_n] = [mean(0), mean(1)];
        let away = used.iter().map(|[u, f]| [u - commanded_n, f - force_n]);
        (away.collect::<Vec<_>>(), commanded_n, force_n)
    });
    let away: Vec<[f64; 2]> = ways.iter().flat_map(|way| &way.0).copied().collect();
    let sum = |of: &dyn Fn(&[f64; 2]) -> f64| away.iter().map(of).sum::<f64>();
    let (squares, sizes) = (sum(&|[u, _]| u * u), sum(&|[u, _]| u.abs()));
    let slope = sum(&|[u, f]| u * f) / squares;
    if slope <= 0.0 {
        return Err(Failure::bad_input(falls));
    }
    let offsets = ways.iter().filter(|way| !way.0.is_empty());
    let offsets: Vec<f64> = offsets
        .map(|(_, commanded_n, force_n)| force_n - slope * commanded_n)
        .collect();
    let friction_n = match offsets[..] {
        [up, down] => 0.5 * (down - up).abs(),
        _ => offsets.first().map_or(f64::NAN, |offset| offset.abs()),
    };
    let freedom = away.len().saturating_sub(offsets.len() + 1);
    // Friction may be anywhere between its ends, unless scatter shows it.
    let (deviation, hidden_n) = match freedom {
        0 => (0.0, f64::max(known_n, friction_n)),
        _ => {
            let variance = sum(&|[u, f]| (f - slope * u) * (f - slope * u)) / freedom as f64;
            (
                STUDENT.get(freedom - 1).unwrap_or(&2.26) * libm::sqrt(variance),
                0.0,
            )
        }
    };
    let about = |value: f64, of_scatter: f64, of_each: f64| {
        let half = libm::hypot(of_scatter * deviation, 0.5 * step_n * of_each) + hidden_n * of_each;
        Estimate::about(value, half)
    };
    let found = Line {
        slope: about(slope, 1.0 / libm::sqrt(squares), sizes / squares),
        zero: {
            let (count, middle) = (away.len() as f64, ways[0].1);
            let of_scatter = libm::sqrt(1.0 / count + middle * middle / squares) / slope;
            about(
                offsets.first().map_or(f64::NAN, |offset| offset / slope),
                of_scatter,
                1.0 / slope,
            )
        },
        friction_n,
    };
    match found.slope.relative() <= TELLS {
        true => Ok(found),
        false => Err(Failure::bad_input(format_args!(
            "the readings tell no factor (within ±{TELLS}): read forces that differ more, with a larger {CALIBRATE_FORCE} where friction hides them, or on a finer instrument",
        ))),
    }
}
