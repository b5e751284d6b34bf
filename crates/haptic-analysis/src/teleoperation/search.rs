//! The coupler that makes a remote tissue feel right.

use super::{HandCoupler, HandLine, Teleoperation};
use crate::AnalysisError;
use crate::extremum::Grid;
use fracdiff::Order;
use fracdiff::parameter::positive;
use num_complex::Complex;

/// How near the transmitted impedance is to the true one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Transparency {
    /// Root mean square of |ln(Z_t/Z_e)| over the band: 0 is perfect; 0.1 is 10 % or 6°.
    pub error: f64,
    /// Largest | 20·log₁₀|Z_t/Z_e| |, dB.
    pub largest_db: f64,
    /// Largest phase between both, °.
    pub largest_degrees: f64,
}

/// A question for the coupler of an order that makes an environment feel right.
#[derive(Clone, Debug, PartialEq)]
pub struct CouplerSearch {
    /// Devices, sample time, delay, and the kind of line; its coupler or impedance does not matter.
    pub hands: Teleoperation,
    /// Frequencies at which the environment is to feel right, rad/s.
    pub omegas_rad_s: Vec<f64>,
    /// Z_e at each, N·s/m.
    pub environment: Vec<Complex<f64>>,
    /// True if a coupler has to be absolutely stable; false for a line that is passive by its energy.
    pub stable: bool,
}

/// The best coupler of an order.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct BestCoupler {
    /// The line with it.
    pub line: HandLine,
    /// How near it comes.
    pub transparency: Transparency,
}

/// Stiffness of couplers that are tried, N/m: of its spring, and of its damper at the middle of the band.
const STIFFNESS: [f64; 2] = [1.0, 1e5];
/// Steps of that, in the logarithm.
const STEPS: i32 = 24;

impl Teleoperation {
    /// How near the hand feels these impedances at these frequencies.
    ///
    /// # Errors
    /// A parameter or frequency outside its range, no frequency, or an impedance of 0.
    pub fn transparency(
        &self,
        omegas_rad_s: &[f64],
        environment: &[Complex<f64>],
    ) -> Result<Transparency, AnalysisError> {
        let (mut sum, mut db, mut degrees) = (0.0, 0.0_f64, 0.0_f64);
        for (&omega, &impedance) in omegas_rad_s.iter().zip(environment) {
            let log = (self.transmitted(omega, impedance)? / impedance).ln();
            sum += log.norm_sqr();
            db = db.max(log.re.abs() * 20.0 / std::f64::consts::LN_10);
            degrees = degrees.max(log.im.abs().to_degrees());
        }
        let error = libm::sqrt(sum / omegas_rad_s.len() as f64);
        if !error.is_finite() {
            return Err(AnalysisError::Unresolved {
                what: "transparency",
                why: "there is no frequency, or no impedance at one",
            });
        }
        Ok(Transparency {
            error,
            largest_db: db,
            largest_degrees: degrees,
        })
    }
}

impl CouplerSearch {
    /// The best coupler of this order; `None` if none that was tried is absolutely stable. For waves, whose order does not
    /// matter, the best impedance up to the smaller damping of both devices, which a sampled device bears.
    ///
    /// A grid in the logarithms of both gains, then smaller and smaller steps from the best point of it.
    ///
    /// # Errors
    /// A parameter or frequency outside its range.
    pub fn best(&self, order: Order) -> Result<Option<BestCoupler>, AnalysisError> {
        let first = self.omegas_rad_s.first().copied().unwrap_or_default();
        let last = self.omegas_rad_s.last().copied().unwrap_or_default();
        let middle = positive("frequencies of the band", libm::sqrt(first * last), "rad/s")?;
        let search = Search {
            question: self,
            grid: self.hands.grid()?,
            order,
            per_stiffness: libm::pow(middle, -order.get()),
        };
        // Without a spring, without a damper, or with both.
        let mut best = None;
        for k in 0..=STEPS {
            for b in 0..=STEPS {
                search.improve(&mut best, [f64::from(k), f64::from(b)])?;
            }
        }
        let mut step = 0.5;
        while step > 1e-3 {
            let Some(Found { place: [k, b], .. }) = best else {
                return Ok(None);
            };
            let mut better = false;
            for (dk, db) in [
                (1, 0),
                (-1, 0),
                (0, 1),
                (0, -1),
                (1, 1),
                (-1, -1),
                (1, -1),
                (-1, 1),
            ] {
                let place = [k + step * f64::from(dk), b + step * f64::from(db)];
                better |= search.improve(&mut best, place)?;
            }
            if !better {
                step *= 0.5;
            }
        }
        Ok(best.map(|found| BestCoupler {
            line: found.line,
            transparency: found.transparency,
        }))
    }
}

/// A point of the search.
#[derive(Clone, Copy)]
struct Found {
    place: [f64; 2],
    line: HandLine,
    transparency: Transparency,
}

struct Search<'a> {
    question: &'a CouplerSearch,
    grid: Grid,
    order: Order,
    /// b_c of a damper as stiff as 1 N/m at the middle of the band.
    per_stiffness: f64,
}

impl Search<'_> {
    /// Tries a place; true if it is the best so far.
    fn improve(&self, best: &mut Option<Found>, place: [f64; 2]) -> Result<bool, AnalysisError> {
        let line = self.line(place);
        let hands = Teleoperation {
            line,
            ..self.question.hands
        };
        let CouplerSearch {
            omegas_rad_s,
            environment,
            ..
        } = self.question;
        let transparency = hands.transparency(omegas_rad_s, environment)?;
        let better = best.is_none_or(|best| transparency.error < best.transparency.error);
        // The dear question last.
        if !better {
            return Ok(false);
        }
        let stable = |hands: &Teleoperation| {
            Ok::<_, AnalysisError>(
                hands.is_stable_on(&self.grid) && hands.absolute_stability()?.stable,
            )
        };
        if self.question.stable && !stable(&hands)? {
            return Ok(false);
        }
        *best = Some(Found {
            place,
            line,
            transparency,
        });
        Ok(true)
    }

    fn line(&self, [k, b]: [f64; 2]) -> HandLine {
        // 0 is none at all.
        let stiffness = |steps: f64| {
            let share = (steps - 1.0).clamp(0.0, f64::from(STEPS - 1)) / f64::from(STEPS - 1);
            let size = STIFFNESS[0] * libm::pow(STIFFNESS[1] / STIFFNESS[0], share);
            if steps < 1.0 { 0.0 } else { size }
        };
        let damped = self.per_stiffness * stiffness(b);
        let coupler = HandCoupler {
            stiffness_n_per_m: if damped > 0.0 {
                stiffness(k)
            } else {
                stiffness(k.max(1.0))
            },
            dissipation_n_s_mu_per_m: damped,
            order: self.order,
        };
        match self.question.hands.line {
            HandLine::PositionPosition(_) => HandLine::PositionPosition(coupler),
            HandLine::PositionForce(_) => HandLine::PositionForce(coupler),
            HandLine::Wave {
                playout_samples, ..
            } => {
                let hands = &self.question.hands;
                let most = (hands.master.damping_n_s_per_m).min(hands.slave.damping_n_s_per_m);
                let share = k.clamp(0.0, f64::from(STEPS)) / f64::from(STEPS);
                HandLine::Wave {
                    impedance_n_s_per_m: most * libm::pow(1e-2, 1.0 - share),
                    playout_samples,
                }
            }
        }
    }
}
