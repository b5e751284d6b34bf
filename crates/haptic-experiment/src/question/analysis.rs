//! Analyses of a wall, a coupler or two hands over a line: what is stable, passive and felt, before anything is tried.

pub(crate) mod felt;
pub(crate) mod teleoperation;
pub(crate) mod wall;

use crate::document::failure::Failure;
use crate::document::parameters::kind::{Parameter, parameters};
use crate::document::parameters::range::{
    ANGULAR_FREQUENCIES, DELAY_SAMPLES as SAMPLES, DELTAS, FREQUENCIES_HZ, WALL_NUMBERS,
    WALL_ORDERS,
};
use crate::document::parameters::{
    AREA, COUPLER_DAMPING, COUPLER_SPRING, CURRENT_LAG, DAMPING, DELAY, DEVICE_MODEL,
    HAND_COUPLER_DISSIPATION, HAND_COUPLER_STIFFNESS, HAND_STIFFNESS, LIBRARY, MASS, SAMPLE_TIME,
    SCHEME, THICKNESS, TISSUE,
};
use crate::document::reader::Table;
use crate::experiment::kind::Keys;
use crate::experiment::teleoperation::{
    ARCHITECTURE, HAND_COUPLER_ORDER, LINE_DELAY, SLAVE_DAMPING, SLAVE_MASS, WAVE_IMPEDANCE,
};
use crate::experiment::wall::{DISSIPATION, ORDER, STIFFNESS};
use crate::judge::Rows;
use crate::run::device::Warn;
use crate::run::folder::OutputFolder;
pub use felt::FeltPoint;
use felt::{CouplerNeed, Felt};
use fracdiff::{Order, Scheme, Seconds};
use haptic_analysis::LoopOperator;
use haptic_quantity::label;
use serde::Serialize;
use std::sync::atomic::AtomicBool;
pub use teleoperation::HandPoint;
use teleoperation::HandsQuestion;
use wall::WallLoop;
pub use wall::{Region, SensitivityPoint};

parameters! {
    ANALYSED_SCHEME = text("scheme", "exact", SCHEME.help);
    /// Order of a coupler that is analysed.
    COUPLING_ORDER = optional("order", WALL_ORDERS, "Order of the coupler: 1 a spring beside a damper, below 1 the spring creeps");
    ALPHA = optional("alpha", WALL_NUMBERS, "Without units: stiffness K T^2/m");
    BETA = optional("beta", WALL_NUMBERS, "Without units: dissipation B T^(2-mu)/m");
    DELTA = optional("delta", DELTAS, "Without units: damping of the device b T/m [default: 0]");
    GAMMA = optional("gamma", WALL_NUMBERS, "Without units: stiffness of the hand k T^2/m [default: 0]");
    DELAY_SAMPLES = optional("delay_samples", SAMPLES, "The delay in samples, whole or not");
    OMEGA_MIN = optional("omega_min_rad_s", ANGULAR_FREQUENCIES, "Lowest frequency [default: a thousandth of the highest]");
    OMEGA_MAX = optional("omega_max_rad_s", ANGULAR_FREQUENCIES, "Highest frequency [default: pi/T]");
    POINTS = count("points", 200, "200", "Number of frequencies");
    /// Number of frequencies of a sensitivity.
    SENSITIVITY_POINTS = count("points", 400, "400", "Number of frequencies");
    /// Lowest frequency of a remote tissue, Hz.
    FELT_LOW = number("low_hz", 0.5, "0.5Hz", FREQUENCIES_HZ, "Lowest frequency at which the tissue should feel right");
    /// Highest frequency of a remote tissue, Hz.
    FELT_HIGH = number("high_hz", 5.0, "5Hz", FREQUENCIES_HZ, "Highest frequency at which the tissue should feel right");
    /// Number of frequencies of a remote tissue.
    FELT_POINTS = count("points", 20, "20", "Number of frequencies");
    PLAYOUT_SAMPLES = count("playout", 2, "2", "Samples over which waves are played out");
    /// Search for the best coupler.
    BEST = flag("best", "Find the best coupler of each order, or the best wave impedance");
}

// The parts of a device that an analysis knows only if they are given.
const ANALYSED_MASS: Parameter = MASS.without_default();
const ANALYSED_DAMPING: Parameter = DAMPING.without_default();
const ANALYSED_HAND: Parameter = HAND_STIFFNESS.without_default();
const ANALYSED_SAMPLE_TIME: Parameter = SAMPLE_TIME.without_default();
const ANALYSED_DELAY: Parameter = DELAY.without_default();
const ANALYSED_LAG: Parameter = CURRENT_LAG.without_default();

#[rustfmt::skip]
const WALL: Keys = ("Wall", &[ORDER, ANALYSED_SCHEME, STIFFNESS, DISSIPATION, ANALYSED_SAMPLE_TIME]);
const ON_DEVICE: Keys = (
    "Device",
    &[
        DEVICE_MODEL,
        ANALYSED_MASS,
        ANALYSED_DAMPING,
        ANALYSED_HAND,
        ANALYSED_DELAY,
        ANALYSED_LAG,
    ],
);
const THROUGH_DEVICE: Keys = (
    "Device",
    &[
        DEVICE_MODEL,
        ANALYSED_MASS,
        ANALYSED_DAMPING,
        ANALYSED_DELAY,
        ANALYSED_LAG,
        DELAY_SAMPLES,
    ],
);
const WITHOUT_UNITS: Keys = ("Without units", &[ALPHA, BETA, DELTA, GAMMA, DELAY_SAMPLES]);
const OMEGAS: Keys = ("Frequencies", &[OMEGA_MIN, OMEGA_MAX, POINTS]);

/// Keys of an analysis of a wall on a device.
pub const ON_WALL: &[Keys] = &[WALL, ON_DEVICE, WITHOUT_UNITS];
/// Keys of a wall whose sensitivity is drawn.
pub const SENSITIVITY: &[Keys] = &[
    WALL,
    ON_DEVICE,
    WITHOUT_UNITS,
    ("Frequencies", &[SENSITIVITY_POINTS]),
];
/// Keys of the impedance of a wall alone.
pub const ENVIRONMENT: &[Keys] = &[WALL, OMEGAS];
/// Keys of the impedance of a wall behind a device.
pub const TRANSPARENCY: &[Keys] = &[WALL, THROUGH_DEVICE, OMEGAS];
/// Keys of the passivity of a coupler.
pub const COUPLING: &[Keys] = &[(
    "Coupler",
    &[
        COUPLING_ORDER,
        ANALYSED_SCHEME,
        COUPLER_DAMPING,
        COUPLER_SPRING,
        ANALYSED_SAMPLE_TIME,
        ANALYSED_DAMPING,
    ],
)];
/// Keys of a teleoperation: two hands over a line.
#[rustfmt::skip]
pub const HANDS: &[Keys] = &[
    ("Line", &[
        ARCHITECTURE, LINE_DELAY, HAND_COUPLER_STIFFNESS, HAND_COUPLER_DISSIPATION,
        HAND_COUPLER_ORDER, WAVE_IMPEDANCE, PLAYOUT_SAMPLES, BEST,
    ]),
    ("Tissue", &[TISSUE, LIBRARY, AREA, THICKNESS, FELT_LOW, FELT_HIGH, FELT_POINTS]),
    ("Devices", &[MASS, DAMPING, SLAVE_MASS, SLAVE_DAMPING, SAMPLE_TIME]),
];

/// Reads the table of an analysis.
type Read = fn(&Table<'_>) -> Result<Analysis, Failure>;

/// Analyses: the name of the table, its keys and its reader.
pub(crate) const ANALYSES: [(&str, &[Keys], Read); 8] = [
    ("analyze-environment", ENVIRONMENT, Felt::alone),
    ("analyze-stability", ON_WALL, |table| {
        WallLoop::needed(table, WallLoop::stability)
    }),
    ("analyze-stability-region", ON_WALL, WallLoop::sought),
    ("analyze-passivity", ON_WALL, |table| {
        WallLoop::needed(table, WallLoop::passivity)
    }),
    ("analyze-coupling", COUPLING, CouplerNeed::of),
    ("analyze-teleoperation", HANDS, HandsQuestion::of),
    ("analyze-transparency", TRANSPARENCY, Felt::through_device),
    ("analyze-sensitivity", SENSITIVITY, |table| {
        WallLoop::needed(table, WallLoop::sensitivity)
    }),
];

/// An analysis, all of its parameters checked.
#[derive(Clone, Debug)]
pub(crate) enum Analysis {
    Felt(Felt),
    Wall(WallLoop, Asked),
    Coupling(CouplerNeed),
    Teleoperation(HandsQuestion),
}

/// A question to the loop of a wall.
type Asked = fn(&WallLoop, Warn<'_>) -> Result<Analysed, Failure>;

impl Analysis {
    pub(crate) const fn steps(&self) -> u64 {
        match self {
            Self::Teleoperation(asked) => asked.steps(),
            Self::Felt(_) | Self::Wall(..) | Self::Coupling(_) => 1,
        }
    }

    pub(crate) fn answer(
        &self,
        progress: &(dyn Fn(u64) + Sync),
        stop: &AtomicBool,
        warn: Warn<'_>,
    ) -> Result<Analysed, Failure> {
        match self {
            Self::Felt(felt) => felt.answer(),
            Self::Wall(wall, asked) => asked(wall, warn),
            Self::Coupling(coupler) => coupler.answer(),
            Self::Teleoperation(asked) => asked.answer(progress, stop),
        }
    }
}

/// The answer of an analysis. The keys of its report are a contract of the command line.
#[derive(Clone, Debug, Serialize)]
pub struct Analysed {
    #[serde(flatten)]
    report: Rows,
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
    /// |S| over the frequency.
    Sensitivity(Vec<SensitivityPoint>),
    /// Two hands over a line.
    Teleoperation {
        /// Of the tissue and of what is felt, over the frequency.
        points: Vec<HandPoint>,
        /// Order and error of each best coupler.
        errors: Vec<(f64, f64)>,
    },
}

impl Analysed {
    /// A report without table and picture.
    fn in_numbers(report: Rows) -> Self {
        Self {
            report,
            drawn: None,
            about: String::new(),
        }
    }

    /// As in `absolutely stable`, or `not passive`; empty of an analysis without a verdict.
    pub(crate) fn verdict(&self) -> String {
        let mut keys = ["stable", "passive", "absolutely_stable"].into_iter();
        let verdict = keys.find_map(|key| Some((key, self.report.get(key)?.as_bool()?)));
        verdict.map_or_else(String::new, |(key, is_so)| {
            let not = if is_so { "" } else { "not " };
            format!("{not}{}", label(key))
        })
    }

    pub(crate) fn write_table(&self, folder: &OutputFolder) -> Result<Option<String>, Failure> {
        let write = |drawn: &Drawn| match drawn {
            Drawn::Felt(points) => folder.write_table(&[], points.iter()),
            Drawn::Region(region) => folder.write_table(&Region::COLUMNS, region.rows()),
            Drawn::Sensitivity(points) => folder.write_table(&[], points.iter()),
            Drawn::Teleoperation { points, .. } => folder.write_table(&[], points.iter()),
        };
        self.drawn.as_ref().map(write).transpose()
    }
}

/// Most frequencies of a curve: more than any picture has pixels.
const FREQUENCIES_MOST: u64 = 100_000;

/// Memory for which a full-memory operator is designed, samples: 1000 s at 1 kHz.
const HORIZON: f64 = 1e6;

/// The operator of this order that runs, and its scheme.
fn operator(
    table: &Table<'_>,
    order: Order,
    sample_time_s: Option<f64>,
) -> Result<(Scheme, LoopOperator), Failure> {
    let scheme = table.scheme(&ANALYSED_SCHEME)?;
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
    20.0 * magnitude.log10()
}

/// `count` frequencies from `low` to `high`, equal steps of their logarithm.
pub fn logarithmic(low: f64, high: f64, count: usize) -> impl Iterator<Item = f64> {
    let ratio = (high / low).ln();
    let steps = count.saturating_sub(1).max(1) as f64;
    // The last is exactly `high`.
    (0..count).map(move |i| match i + 1 == count {
        true => high,
        false => low * (ratio * i as f64 / steps).exp(),
    })
}
