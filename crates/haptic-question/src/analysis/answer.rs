//! Answers of analyses, and the numbers that several of them need.

use fracdiff::{Order, Scheme, Seconds};
use haptic_analysis::{LoopOperator, Polygon};
use haptic_document::Rows;
use haptic_document::parameters::{Parameter, SAMPLE_TIME};
use haptic_document::{Failure, Table};
use haptic_quantity::label;
use serde::Serialize;

/// The answer of an analysis. The keys of its report are a contract of the command line.
#[derive(Clone, Debug, Serialize)]
pub struct Analysed {
    #[serde(flatten)]
    pub(crate) report: Rows,
    /// Its table and picture; none where the report says all of it.
    #[serde(skip)]
    pub drawn: Option<Drawn>,
    /// The question in the words below a picture.
    #[serde(skip)]
    pub about: String,
}

/// Content of the table and the picture of an analysis.
#[derive(Clone, Debug)]
pub enum Drawn {
    /// The impedance of a wall over the frequency.
    Felt(Vec<FeltPoint>),
    /// The outlines of the stable walls.
    Region(Region),
    /// The difference of two laws for a hand, over the frequency.
    Difference(Vec<DifferencePoint>),
    /// |S| over the frequency.
    Sensitivity(Vec<SensitivityPoint>),
    /// A device that moves.
    Admittance {
        /// The impedance at the hand over the frequency.
        points: Vec<AdmittancePoint>,
        /// The stiffnesses of a hand that are stable.
        stable: StableHands,
        /// The virtual bodies that are stable.
        stable_bodies: StableBodies,
        /// The best body of each kind and order, if they were sought.
        bodies: Vec<BodyPoint>,
        /// The bodies that none beats, if they were sought.
        front: Vec<BodyPoint>,
    },
    /// Two hands over a line.
    Teleoperation {
        /// Values of the tissue and of what is felt, over the frequency.
        points: Vec<HandPoint>,
        /// Order and error of each best coupler.
        errors: Vec<(f64, f64)>,
    },
}

impl Analysed {
    /// A report without table and picture.
    pub(crate) fn in_numbers(report: Rows) -> Self {
        Self {
            report,
            drawn: None,
            about: String::new(),
        }
    }

    /// Verdict in words, as in `absolutely stable`, or `not passive`; empty for an analysis without a verdict.
    pub fn verdict(&self) -> String {
        let mut keys = ["stable", "passive", "absolutely_stable"].into_iter();
        let verdict = keys.find_map(|key| Some((key, self.report.get(key)?.as_bool()?)));
        verdict.map_or_else(String::new, |(key, is_so)| {
            let not = if is_so { "" } else { "not " };
            format!("{not}{}", label(key))
        })
    }
}

/// A frequency: sampled, and continuous of a closed loop.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct FeltPoint {
    /// Angular frequency, at most pi/T.
    pub omega_rad_s: f64,
    /// Positive where the wall pushes back.
    pub effective_stiffness_n_per_m: f64,
    /// Positive where the wall takes energy.
    pub effective_damping_n_s_per_m: f64,
    /// Stiffness without sampling, of a closed loop.
    pub continuous_stiffness_n_per_m: Option<f64>,
    /// Damping without sampling, of a closed loop.
    pub continuous_damping_n_s_per_m: Option<f64>,
}

/// The stable walls of a device, by outlines.
#[derive(Clone, Debug)]
pub struct Region {
    /// Outlines as points of α, β and θ, without units.
    pub parts: Vec<Polygon>,
    /// K of α = 1 and B of β = 1, of a device with units.
    pub units: Option<[f64; 2]>,
    /// β and α of the wall that was given.
    pub wall: Option<(f64, f64)>,
    /// The law in place of a wall, if it is not one. β is the factor on a controller, α a spring beside it.
    pub in_place: Option<Kind>,
}

/// The kind of a law in place of a wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "a piece of tissue, a controller")]
pub enum Kind {
    Tissue,
    Controller,
}

/// A frequency: force over velocity at the hand of a device that moves, and as the law renders it.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct AdmittancePoint {
    /// Frequency of the hand's motion.
    pub frequency_hz: f64,
    /// Impedance in the hand, in free space.
    pub free_n_s_per_m: f64,
    /// Phase of that force over the velocity.
    pub free_degrees: f64,
    /// The impedance of the body.
    pub free_virtual_n_s_per_m: f64,
    /// Impedance in the hand, in contact with the world.
    pub contact_n_s_per_m: Option<f64>,
    /// Phase of that force over the velocity.
    pub contact_degrees: Option<f64>,
    /// The impedance of body and world.
    pub contact_virtual_n_s_per_m: Option<f64>,
}

/// The body of least effort of an order.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct BodyPoint {
    /// α; 1 of a lagged mass too.
    pub body_order: f64,
    /// Lag of a lagged mass.
    pub body_lag_s: Option<f64>,
    /// m.
    pub body_inertance_n_s_mu_per_m: f64,
    /// b.
    pub body_damping_n_s_per_m: f64,
    /// Effort of a hand in free space.
    pub effort_n_s_per_m: f64,
    /// Command at half the sample rate per newton of noise, m/s.
    pub command_noise: f64,
    /// Factor on the hands for which it is proved.
    pub hand_margin: f64,
    /// True if it settled in all of its trials; null if it was not tried.
    pub settled: Option<bool>,
}

impl BodyPoint {
    /// True for a body of order 1 that does not lag.
    pub fn is_mass_and_damper(&self) -> bool {
        self.body_lag_s.is_none() && (self.body_order - 1.0).abs() < 1e-9
    }
}

/// The stiffnesses of a hand that are stable, over the spring of a wall.
#[derive(Clone, Debug)]
pub struct StableHands {
    /// Mass of the hand.
    pub mass_kg: f64,
    /// Damping of the hand.
    pub damping_n_s_per_m: f64,
    /// Springs, N/m, and the intervals of the hand's stiffness, N/m, that are stable there.
    pub springs: Vec<(f64, Vec<[f64; 2]>)>,
    /// Least and largest stiffness of a hand that were asked for.
    pub hands_n_per_m: [f64; 2],
    /// The spring that was asked for, 0 in free space, if the world is one.
    pub spring_n_per_m: Option<f64>,
}

/// The inertances of a body that are stable in each corner of the hands and at six worlds from free space on, over its damping.
#[derive(Clone, Debug)]
pub struct StableBodies {
    /// α of the body.
    pub order: f64,
    /// Dampings, N·s/m, and the intervals of the inertance, N·s^(1+α)/m.
    pub dampings: Vec<(f64, Vec<[f64; 2]>)>,
    /// Damping and inertance of the body itself.
    pub body: [f64; 2],
}

/// A frequency: differences over what a hand should notice, 1 at the threshold.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct DifferencePoint {
    /// Frequency of the hand's motion.
    pub frequency_hz: f64,
    /// Difference in phase with the displacement, of the other law.
    pub other_stiffness: Option<f64>,
    /// Difference in phase with the velocity, of the other law.
    pub other_damping: Option<f64>,
    /// Difference in phase with the displacement, of the best spring and damper.
    pub spring_and_damper_stiffness: f64,
    /// Difference in phase with the velocity, of the best spring and damper.
    pub spring_and_damper_damping: f64,
}

/// A point of a sensitivity.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SensitivityPoint {
    /// Digital frequency, rad a sample.
    pub theta: f64,
    /// The magnitude of 1/(1 + GH), dB.
    pub magnitude_db: f64,
}

impl Region {
    /// Names of the columns of its table.
    pub const COLUMNS: [&str; 4] = ["part", "alpha", "beta", "theta_rad"];

    /// Rows of its table: part, α, β and θ of each point.
    pub fn rows(&self) -> impl Iterator<Item = impl Serialize> {
        let parts = self.parts.iter().enumerate();
        parts.flat_map(|(part, polygon)| {
            let points = polygon.points.iter();
            points.map(move |at| (part, at.alpha, at.beta, at.theta))
        })
    }
}

/// A tissue and what the hand feels of it at one frequency.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct HandPoint {
    /// Frequency of the hand's motion.
    pub frequency_hz: f64,
    /// Force per displacement of the tissue.
    pub tissue_n_per_m: f64,
    /// Phase of the tissue's force over its place.
    pub tissue_degrees: f64,
    /// Force per displacement at the master.
    pub felt_n_per_m: f64,
    /// Phase of the master's force over its place.
    pub felt_degrees: f64,
    /// Ratio of Llewellyn's criterion: stable with every hand and tissue from 1 on.
    pub llewellyn_ratio: f64,
}

/// Most frequencies of a curve: more than any picture has pixels.
pub(super) const FREQUENCIES_MOST: u64 = 100_000;

/// Memory for which a full-memory operator is designed, samples: 1000 s at 1 kHz.
pub(super) const HORIZON: f64 = 1e6;

/// The operator of this order that runs, and its scheme.
pub(super) fn operator(
    table: &Table<'_>,
    key: &Parameter,
    order: Order,
    sample_time_s: Option<f64>,
) -> Result<(Scheme, LoopOperator), Failure> {
    let scheme = table.scheme(key)?;
    let sample_time = sample_time_of(scheme, sample_time_s)?;
    let operator = LoopOperator::new(scheme, order, sample_time, HORIZON);
    Ok((scheme, operator.map_err(Failure::input)?))
}

/// T^(−μ), if the sample time is in the range that operators take.
///
/// # Errors
/// If it is not.
pub fn rate(sample_time: Seconds, mu: Order) -> Result<f64, Failure> {
    let advice =
        |error| Failure::input_with_advice(error, format_args!("give {SAMPLE_TIME}, as in 1ms"));
    sample_time.rate_to_the(mu).map_err(advice)
}

/// The sample time for an operator without units, which matters only to a scheme with frequencies in
/// Hz.
///
/// # Errors
/// If such a scheme has none.
pub fn sample_time_of(scheme: Scheme, given_s: Option<f64>) -> Result<Seconds, Failure> {
    match (scheme, given_s) {
        (Scheme::Oustaloup { .. }, None) => Err(Failure::bad_input(format_args!(
            "scheme {scheme} has frequencies in Hz: give {SAMPLE_TIME}, as in 1ms"
        ))),
        _ => Ok(Seconds(given_s.unwrap_or(1.0))),
    }
}

/// An amplitude ratio in decibel.
#[must_use]
pub fn decibel(magnitude: f64) -> f64 {
    20.0 * libm::log10(magnitude)
}

/// `count` frequencies from `low` to `high`, equal steps of their logarithm.
pub fn logarithmic(low: f64, high: f64, count: usize) -> impl Iterator<Item = f64> {
    let ratio = libm::log(high / low);
    let steps = count.saturating_sub(1).max(1) as f64;
    // The last is exactly `high`.
    (0..count).map(move |i| {
        if i + 1 == count {
            high
        } else {
            low * libm::exp(ratio * i as f64 / steps)
        }
    })
}
