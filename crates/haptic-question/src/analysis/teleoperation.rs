//! Two hands over a line: what is stable and what is felt.

use crate::analysis::answer::{Analysed, Drawn, HandPoint, logarithmic, rate};
use crate::analysis::keys::{BEST, FELT_HIGH, FELT_LOW, FELT_POINTS, PLAYOUT_SAMPLES};
use crate::bench::for_each_order;
use fracdiff::{Order, Seconds};
use haptic_analysis::num_complex::Complex;
use haptic_analysis::{
    CouplerSearch, HandCoupler, HandLine, HandMass, LargestDelay, Teleoperation, Transparency,
};
use haptic_document::parameters::{
    DAMPING, HAND_COUPLER_DISSIPATION, HAND_COUPLER_STIFFNESS, MASS, Parameter, SAMPLE_TIME,
};
use haptic_document::{Failure, Table, rows};
use haptic_judge::preflight::Matter;
use haptic_judge::tissue_table::linear_piece;
use haptic_link::Architecture;
use haptic_quantity::{digits, written};
use haptic_trial::advice::analysed;
use haptic_trial::keys::teleoperation::{
    ARCHITECTURE, HAND_COUPLER_ORDER, LINE_DELAY, SLAVE_DAMPING, SLAVE_MASS, WAVE_IMPEDANCE,
};
use serde_json::{Value, json};
use std::f64::consts::TAU;
use std::sync::atomic::AtomicBool;

/// Longest delay that is looked for, s.
const DELAY_MOST_S: f64 = 1.0;
/// Orders that are tried: 0, 0.05, … 1.
const ORDERS: u32 = 20;

/// Two hands, the frequencies at which they are judged, and the tissue behind the second.
#[derive(Clone, Debug)]
pub(crate) struct HandsQuestion {
    architecture: Architecture,
    hands: Teleoperation,
    /// True if the best coupler of each order is sought.
    best: bool,
    omegas: Vec<f64>,
    tissue: String,
    environment: Vec<Complex<f64>>,
}

/// The best coupler or impedance of an order.
type Candidate = (HandLine, Transparency);

/// Coupler and wave impedance of a line: one of them.
const fn parts(line: HandLine) -> (Option<HandCoupler>, Option<f64>) {
    match line {
        HandLine::PositionPosition(coupler) | HandLine::PositionForce(coupler) => {
            (Some(coupler), None)
        }
        HandLine::Wave {
            impedance_n_s_per_m,
            ..
        } => (None, Some(impedance_n_s_per_m)),
    }
}

/// The law of the line by its architecture, if it is linear.
fn line(table: &Table<'_>, architecture: Architecture) -> Result<HandLine, Failure> {
    let coupler = HandCoupler {
        stiffness_n_per_m: table.number(&HAND_COUPLER_STIFFNESS)?,
        dissipation_n_s_mu_per_m: table.number(&HAND_COUPLER_DISSIPATION)?,
        order: table.order(&HAND_COUPLER_ORDER)?,
    };
    rate(Seconds(table.number(&SAMPLE_TIME)?), coupler.order)?;
    Ok(match architecture {
        Architecture::PositionPosition => HandLine::PositionPosition(coupler),
        Architecture::PositionForce => HandLine::PositionForce(coupler),
        Architecture::Wave => HandLine::Wave {
            impedance_n_s_per_m: table.number(&WAVE_IMPEDANCE)?,
            playout_samples: table.count_in(&PLAYOUT_SAMPLES, 1..=10_000)? as u32,
        },
        Architecture::TimeDomain => {
            return Err(Failure::bad_input(format_args!(
                "time-domain is not a linear law: give {}",
                ARCHITECTURE.set_to("position-position")
            )));
        }
    })
}

/// Refuses keys that this architecture does not read.
fn all_act(table: &Table<'_>, architecture: Architecture, best: bool) -> Result<(), Failure> {
    let refuse = |parameters: &[Parameter], why: &str| {
        let mut given = parameters.iter().filter(|parameter| table.has(parameter));
        given.next().map_or(Ok(()), |parameter| {
            let why = format_args!("{parameter} has no effect {why}: omit it");
            Err(Failure::bad_input(why))
        })
    };
    let coupler = [
        HAND_COUPLER_STIFFNESS,
        HAND_COUPLER_DISSIPATION,
        HAND_COUPLER_ORDER,
    ];
    let waves = [WAVE_IMPEDANCE, PLAYOUT_SAMPLES];
    match architecture {
        Architecture::Wave => refuse(&coupler, "on waves, which have no coupler")?,
        Architecture::PositionPosition | Architecture::PositionForce | Architecture::TimeDomain => {
            refuse(&waves, &format!("without {}", ARCHITECTURE.set_to("wave")))?;
        }
    }
    if best {
        let why = format!("with {BEST}, which looks for it");
        refuse(&coupler, &why)?;
        refuse(&waves[..1], &why)?;
    }
    Ok(())
}

impl HandsQuestion {
    pub(crate) fn of(table: &Table<'_>) -> Result<Self, Failure> {
        let architecture = table.choice(&ARCHITECTURE)?;
        let best = table.flag(&BEST)?;
        let line = line(table, architecture)?;
        all_act(table, architecture, best)?;
        let sample_time_s = table.number(&SAMPLE_TIME)?;
        let (low, high) = (table.number(&FELT_LOW)?, table.number(&FELT_HIGH)?);
        let most = 0.5 / sample_time_s;
        if !(low < high && high <= most) {
            return Err(Failure::bad_input(format_args!(
                "{low} to {high} Hz are not in 0 to {most} Hz: change {FELT_LOW}, {FELT_HIGH} or {SAMPLE_TIME}"
            )));
        }
        let touched = Matter::Tissue(linear_piece(table)?);
        let count = table.count_in(&FELT_POINTS, 2..=10_000)?;
        let omegas: Vec<f64> = logarithmic(TAU * low, TAU * high, count).collect();
        let environment = (omegas.iter())
            .map(|&omega| touched.stiffness(omega) / Complex::new(0.0, omega))
            .collect();
        let master = HandMass {
            mass_kg: table.number(&MASS)?,
            damping_n_s_per_m: table.number(&DAMPING)?,
        };
        let slave_damping = table.number_if(&SLAVE_DAMPING)?;
        let hands = Teleoperation {
            master,
            slave: HandMass {
                mass_kg: table.number_if(&SLAVE_MASS)?.unwrap_or(master.mass_kg),
                damping_n_s_per_m: slave_damping.unwrap_or(master.damping_n_s_per_m),
            },
            line,
            sample_time_s,
            delay_s: table.number(&LINE_DELAY)?,
        };
        Ok(Self {
            architecture,
            hands,
            best,
            omegas,
            tissue: touched.words(),
            environment,
        })
    }

    pub(crate) const fn steps(&self) -> u64 {
        if self.best { ORDERS as u64 + 1 } else { 1 }
    }

    pub(crate) fn answer(
        &self,
        progress: &(dyn Fn(u64) + Sync),
        stop: &AtomicBool,
    ) -> Result<Analysed, Failure> {
        let candidates = if self.best {
            self.candidates(progress, stop)?
        } else {
            Vec::new()
        };
        let best = (candidates.iter()).min_by(|a, b| a.1.error.total_cmp(&b.1.error));
        // Show the best candidate, if there is one.
        let hands = Teleoperation {
            line: best.map_or(self.hands.line, |best| best.0),
            ..self.hands
        };
        let stability = hands.absolute_stability().map_err(analysed)?;
        let largest = hands.largest_delay(DELAY_MOST_S).map_err(analysed)?;
        let felt = (hands.transparency(&self.omegas, &self.environment)).map_err(analysed)?;
        let points = self.points(&hands)?;
        let architecture = self.architecture.name();
        let report = json!({
            "architecture": architecture,
            "line_delay_s": hands.delay_s,
            "tissue": self.tissue,
            "absolutely_stable": stability.stable,
            "least_ratio": stability.least_ratio,
            "worst_hz": stability.worst_rad_s / TAU,
            // Null if it is not stable even without delay.
            "largest_delay_s": match largest {
                LargestDelay::None => None,
                LargestDelay::Below { delay_s } => Some(delay_s),
                LargestDelay::Any => Some(DELAY_MOST_S),
            },
            // The longest that was tried.
            "any_delay": largest == LargestDelay::Any,
            // It gives no energy at any delay.
            "passive_line": self.architecture.is_passive(),
            "error": felt.error,
            "largest_db": felt.largest_db,
            "largest_degrees": felt.largest_degrees,
            "points": points,
            "candidates": candidates.iter().map(shown).collect::<Vec<Value>>(),
            "best": best.map(shown),
        });
        let errors = candidates.iter();
        let errors =
            errors.filter_map(|(line, felt)| Some((parts(*line).0?.order.get(), felt.error)));
        Ok(Analysed {
            report: rows([report]),
            about: format!(
                "{architecture} · delay {} · {} · {}",
                written("delay_s", hands.delay_s),
                law(hands.line),
                self.tissue
            ),
            drawn: Some(Drawn::Teleoperation {
                points,
                errors: errors.collect(),
            }),
        })
    }

    /// The best of each order, or of waves.
    fn candidates(
        &self,
        progress: &(dyn Fn(u64) + Sync),
        stop: &AtomicBool,
    ) -> Result<Vec<Candidate>, Failure> {
        let search = CouplerSearch {
            hands: self.hands,
            omegas_rad_s: self.omegas.clone(),
            environment: self.environment.clone(),
            stable: true,
        };
        let is_wave = self.architecture == Architecture::Wave;
        let orders = (0..=if is_wave { 0 } else { ORDERS })
            .map(|n| Order::new(f64::from(n) / f64::from(ORDERS)));
        let orders = orders.collect::<Result<Vec<_>, _>>();
        let orders = orders.map_err(Failure::input)?;
        let found = for_each_order(&orders, stop, progress, |order| {
            search.best(order).map_err(analysed)
        })?;
        let found = found.into_iter().flatten();
        let found: Vec<Candidate> = found.map(|best| (best.line, best.transparency)).collect();
        if found.is_empty() {
            return Err(Failure::bad_input(format_args!(
                "no coupler is stable with every hand and environment: shorten {LINE_DELAY} or {SAMPLE_TIME}"
            )));
        }
        Ok(found)
    }

    fn points(&self, hands: &Teleoperation) -> Result<Vec<HandPoint>, Failure> {
        let pairs = self.omegas.iter().zip(&self.environment);
        let point = |(&omega, &impedance): (&f64, &Complex<f64>)| {
            let s = Complex::new(0.0, omega);
            let felt = hands.transmitted(omega, impedance).map_err(analysed)? * s;
            let tissue = impedance * s;
            let (real, ratio) = hands.llewellyn(omega).map_err(analysed)?;
            Ok(HandPoint {
                frequency_hz: omega / TAU,
                tissue_n_per_m: tissue.norm(),
                tissue_degrees: tissue.arg().to_degrees(),
                felt_n_per_m: felt.norm(),
                felt_degrees: felt.arg().to_degrees(),
                llewellyn_ratio: if real < 0.0 { 0.0 } else { ratio },
            })
        };
        pairs.map(point).collect()
    }
}

fn shown((line, felt): &Candidate) -> Value {
    let (coupler, impedance) = parts(*line);
    json!({
        "order": coupler.map(|coupler| coupler.order.get()),
        "coupler_stiffness_n_per_m": coupler.map(|coupler| coupler.stiffness_n_per_m),
        "coupler_dissipation_n_s_mu_per_m": coupler.map(|coupler| coupler.dissipation_n_s_mu_per_m),
        "wave_impedance_n_s_per_m": impedance,
        "error": felt.error,
        "largest_db": felt.largest_db,
        "largest_degrees": felt.largest_degrees,
    })
}

/// The law of a line, in words.
fn law(line: HandLine) -> String {
    match parts(line) {
        (Some(coupler), _) => format!(
            "spring {} · damper {} · μ = {}",
            written("stiffness_n_per_m", coupler.stiffness_n_per_m),
            written("dissipation_n_s_mu_per_m", coupler.dissipation_n_s_mu_per_m),
            digits(coupler.order.get(), 4)
        ),
        (None, impedance) => {
            let impedance = impedance.unwrap_or(f64::NAN);
            format!("b = {}", written("impedance_n_s_per_m", impedance))
        }
    }
}
