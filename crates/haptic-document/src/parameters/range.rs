//! Ranges of numbers: finite, each by what it is a number of, with its reason.
//!
//! A range is wide enough for anything that a laboratory has, and narrow enough to catch a wrong unit and to keep every formula
//! far from where numbers end. A constructor may ask for less; then it says so itself.

use fracdiff::{Seconds, parameter::Shown};
use haptic_analysis::{ForcePath, Nondimensional, SampledPlant};
use haptic_loop::Limit;
use haptic_teleoperation::ChannelModel;
use std::fmt;

/// Range of a number, which must be finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    /// low ≤ x ≤ high.
    Within(f64, f64),
    /// low < x ≤ high.
    AboveUpTo(f64, f64),
    /// 0, or low ≤ x ≤ high with low above 0.
    ZeroOr(f64, f64),
}

impl Range {
    /// The range of what is no number: nothing is in it.
    pub const EMPTY: Self = Self::Within(f64::NAN, f64::NAN);

    /// True if a number is in it. A number that is not finite never is.
    #[must_use]
    pub fn contains(self, x: f64) -> bool {
        match self {
            Self::Within(low, high) => (low..=high).contains(&x),
            Self::AboveUpTo(low, high) => x > low && x <= high,
            Self::ZeroOr(low, high) => x == 0.0 || (low..=high).contains(&x),
        }
    }

    /// The range in which a document asks for a limit: 0 only where it is a limit too, or switches off what a device has
    /// unless it is asked.
    #[must_use]
    pub const fn of(limit: Limit) -> Self {
        let [least, most] = limit.range();
        match limit {
            Limit::Force
            | Limit::ForceRate
            | Limit::StartForce
            | Limit::RiseTime
            | Limit::Braking => above_0(most),
            Limit::StuckForce | Limit::Jump => Self::Within(least, most).or_0(),
            Limit::Speed
            | Limit::VelocityBandwidth
            | Limit::StopTime
            | Limit::BrakeForce
            | Limit::StuckTime
            | Limit::DeviceMass => Self::Within(least, most),
        }
    }

    /// Adds 0 to the range, for a value that 0 switches off.
    #[must_use]
    pub const fn or_0(self) -> Self {
        match self {
            Self::AboveUpTo(0.0, high) => up_to(high),
            Self::Within(low, high) if low > 0.0 => Self::ZeroOr(low, high),
            Self::Within(..) | Self::AboveUpTo(..) | Self::ZeroOr(..) => self,
        }
    }

    /// Both ends, for messages: they include an excluded bound.
    #[must_use]
    pub const fn ends(self) -> [f64; 2] {
        match self {
            Self::Within(low, high) | Self::AboveUpTo(low, high) => [low, high],
            Self::ZeroOr(_, high) => [0.0, high],
        }
    }
}

/// Shows a range, as in `from 0 to 1000`, or `above 0 and at most 1000`.
impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (Self::Within(low, high) | Self::AboveUpTo(low, high) | Self::ZeroOr(low, high)) =
            *self;
        let (low, high) = (Shown(low), Shown(high));
        match self {
            Self::Within(..) => write!(f, "from {low} to {high}"),
            Self::AboveUpTo(..) => write!(f, "above {low} and at most {high}"),
            Self::ZeroOr(..) => write!(f, "0 or from {low} to {high}"),
        }
    }
}

/// The range of an angle in degrees, shown after the one in rad; empty for other keys.
#[must_use]
pub fn in_degrees(key: &str, range: Range) -> String {
    let [low, high] = range.ends().map(f64::to_degrees);
    match haptic_quantity::kind_of_key(key) {
        "ANGLE" => format!(" ({low:.2} to {high:.2} degrees)"),
        _ => String::new(),
    }
}

const fn up_to(most: f64) -> Range {
    Range::Within(0.0, most)
}

const fn above_0(most: f64) -> Range {
    Range::AboveUpTo(0.0, most)
}

/// −most ≤ x ≤ most.
pub const fn either_sign(most: f64) -> Range {
    Range::Within(-most, most)
}

/// Sample times that operators take, s.
pub const SAMPLE_TIMES: Range = Range::Within(Seconds::MIN_SAMPLE_TIME, Seconds::MAX_SAMPLE_TIME);
/// Lengths of runs and of what happens in them, s: four months.
pub const DURATIONS: Range = above_0(1e7);
/// Pasts that are remembered, s: that of the longest sample time with the longest memory.
pub const MEMORIES: Range = above_0(1e15);
/// Times of a safety chain, s: who waits a minute for a force forgets it.
pub const SAFETY_TIMES: Range = above_0(60.0);
/// Delays and lags of a device, s: through more nobody feels anything, and 1.3 was to be 1.3 ms.
pub const DEVICE_TIMES: Range = up_to(1.0);
/// Dead times and delays of any plant, s: a day.
pub const DEAD_TIMES: Range = up_to(86_400.0);
/// Masses, kg: more no hand moves.
pub const MASSES: Range = above_0(100.0);
/// Masses of an object, kg, which may weigh nothing.
pub const OBJECT_MASSES: Range = up_to(100.0);
/// Viscous damping, N·s/m: the heaviest mass to rest within 0.1 ms.
pub const DAMPINGS: Range = up_to(1e6);
/// Viscous damping of a device or line that needs some, N·s/m.
pub const DAMPINGS_ABOVE_0: Range = above_0(1e6);
/// Stiffnesses, N/m: a bar of steel, 1 cm² across and 20 cm long.
pub const STIFFNESSES: Range = up_to(1e8);
/// Stiffnesses of a hand that holds, N/m.
pub const STIFFNESSES_ABOVE_0: Range = above_0(1e8);
/// Dissipations, N·s^μ/m, whose unit lies between those of stiffness, damping and mass.
pub const DISSIPATIONS: Range = up_to(1e8);
/// Forces that are pushed with or that rub, N: ten times what a person can do.
pub const FORCES: Range = up_to(1e4);
/// Forces of a push that has to be there, N.
pub const FORCES_ABOVE_0: Range = above_0(1e4);
/// Offsets of a force sensor, N.
pub const OFFSETS: Range = either_sign(1e4);
/// Limits of a force, N: so high a one limits nothing any more.
pub const FORCE_LIMITS: Range = Range::of(Limit::Force);
/// Limits of its rate, N/s: that force within 0.1 ms.
pub const FORCE_RATES: Range = Range::of(Limit::ForceRate);
/// Speeds of an impact, m/s: ten times what a hand does.
pub const IMPACTS: Range = up_to(10.0);
/// Steps of an encoder and noise, m: a ruler is finer than 1 mm.
pub const SENSOR_STEPS: Range = up_to(1e-3);
/// Distances above 0, m.
pub const REACHES_ABOVE_0: Range = above_0(1.0);
/// Places of a hand on a device that stands on a table, m.
pub const ARM_PLACES: Range = either_sign(1.0);
/// Sizes of a specimen, m or m²: it stands on a table.
pub const SPECIMENS: Range = above_0(10.0);
/// Speeds of a robot's command, m/s.
pub const MOTION_SPEEDS: Range = above_0(10.0);
/// Accelerations of it, m/s².
pub const ACCELERATIONS: Range = above_0(1e4);
/// Ends of a workspace, m.
pub const WORKSPACES: Range = either_sign(haptic_link::Limits::PLACE_MOST_M as f64);
/// Places, m: where no hand comes any more.
pub const PLACES: Range = either_sign(1e3);
/// Radii, m: from a grain of dust to what is a plane to a hand.
pub const RADII: Range = Range::Within(1e-6, 1e3);
/// Half angles of a cone, rad: below π/2, which is no cone.
pub const HALF_ANGLES: Range = Range::Within(1e-3, 1.57);
/// Poisson's ratios of what can be measured.
pub const POISSON_RATIOS: Range = up_to(haptic_loop::INCOMPRESSIBLE);
/// Strains that are held: all of the thickness.
pub const STRAINS: Range = above_0(1.0);
/// Stresses, Pa: tissue is gone long before.
pub const STRESSES: Range = above_0(1e9);
/// Frequencies, Hz: ten times what is felt.
pub const FREQUENCIES_HZ: Range = above_0(1e4);
/// Angular frequencies of a controller or a curve, rad/s: the slowest turns once in 200 000 years.
pub const ANGULAR_FREQUENCIES: Range = Range::Within(1e-12, 1e9);
/// Gains, limits and entries of a matrix, in any unit that a plant has.
pub const NUMBERS: Range = either_sign(1e12);
/// Ratios, as of a margin.
pub const RATIOS: Range = above_0(1e6);
/// Delays of a loop, samples.
pub const DELAY_SAMPLES: Range = up_to(ForcePath::DELAY_MAX);
/// Times of a line to a device, s.
pub const LINE_TIMES: Range = up_to(ChannelModel::DELAY_MOST_S);
/// Shares of a whole, 1.
pub const SHARES: Range = up_to(1.0);
/// Orders of the dissipation of a wall.
pub const WALL_ORDERS: Range = up_to(2.0);
/// Orders of a coupler that gives no energy by itself.
pub const COUPLER_ORDERS: Range = up_to(1.0);
/// α, β and γ of the analysis.
pub const WALL_NUMBERS: Range = up_to(Nondimensional::WALL_MAX);
/// Dimensionless sample times T·b/m.
pub const DELTAS: Range = up_to(SampledPlant::DELTA_MAX);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_has_its_ends_as_it_says_and_nothing_that_is_not_finite() {
        let both = Range::Within(-1.0, 2.0);
        let upper = Range::AboveUpTo(0.0, 1e6);
        assert!(both.contains(-1.0) && both.contains(2.0) && !both.contains(2.1));
        assert!(!upper.contains(0.0) && upper.contains(1e-300) && upper.contains(1e6));
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(!both.contains(x) && !upper.contains(x), "{x}");
        }
        for x in [f64::NAN, 0.0, 1.0] {
            assert!(!Range::EMPTY.contains(x), "{x}");
        }
        assert!(upper.or_0().contains(0.0) && !upper.or_0().contains(-1e-300));
        assert_eq!((both.or_0(), upper.or_0().ends()), (both, upper.ends()));
        let off = Range::Within(1e-6, 1.0).or_0();
        assert!(off.contains(0.0) && off.contains(1e-6) && !off.contains(1e-7));
        assert_eq!(off.to_string(), "0 or from 0.000001 to 1");
        assert_eq!(both.to_string(), "from -1 to 2");
        assert_eq!(upper.to_string(), "above 0 and at most 1e6");
    }
}
