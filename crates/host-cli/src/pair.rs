//! Pairs of quantities on the command line: the ends of a workspace, the interval of a delay.

use crate::within::in_range;
use haptic_experiment::parameters::range;
use haptic_quantity::{Length, Time};

/// Two ends of a workspace, `LOW:HIGH`, low below high.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Workspace {
    /// Lowest position, m.
    pub low_m: f64,
    /// Highest position, m.
    pub high_m: f64,
}

impl std::str::FromStr for Workspace {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let ends = text.split_once(':');
        let (low, high) =
            ends.ok_or_else(|| format!("\"{text}\" is not LOW:HIGH, as in -10mm:20mm"))?;
        let end = |text: &str| {
            let place = text.parse::<Length>().map_err(|error| error.to_string())?;
            in_range(place, range::PLACES)
        };
        let (low_m, high_m) = (end(low)?.0, end(high)?.0);
        if low_m < high_m {
            Ok(Self { low_m, high_m })
        } else {
            Err(format!(
                "the low end {low} is not below the high end {high}"
            ))
        }
    }
}

/// A delay, or the interval in which it surely lies, `LEAST:MOST`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Delay {
    /// The least it can be, s, at least 0.
    pub least_s: f64,
    /// The most it can be, s.
    pub most_s: f64,
}

impl std::str::FromStr for Delay {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (least, most) = text.split_once(':').unwrap_or((text, text));
        let end = |text: &str| {
            let delay = text.parse::<Time>().map_err(|error| error.to_string())?;
            in_range(delay, range::DEVICE_TIMES)
        };
        let (least_s, most_s) = (end(least)?.0, end(most)?.0);
        if least_s <= most_s {
            Ok(Self { least_s, most_s })
        } else {
            Err(format!(
                "\"{text}\" is not lowest first: give TIME, or LEAST:MOST as in 0.2ms:1ms"
            ))
        }
    }
}
