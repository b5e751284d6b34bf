//! The coupler that makes a remote tissue feel right.

use super::{HandCoupler, HandLine, Teleoperation};
use crate::AnalysisError;
use crate::extremum::Grid;
use fracdiff::Order;
use fracdiff::parameter::positive;
use num_complex::Complex;

/// Closeness of the transmitted impedance to the true one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Transparency {
    /// Root mean square of |`ln(Z_t/Z_e)`| over the band: 0 is perfect; 0.1 is 10 % or 6°.
    pub error: f64,
    /// Largest | `20·log₁₀|Z_t/Z_e`| |, dB.
    pub largest_db: f64,
    /// Largest phase difference between the two, °.
    pub largest_degrees: f64,
}

/// A question for the coupler of an order that makes an environment feel right.
#[derive(Clone, Debug, PartialEq)]
pub struct CouplerSearch {
    /// Devices, sample time, delay, and the kind of line; its coupler or impedance does not matter.
    pub hands: Teleoperation,
    /// Frequencies at which the environment should feel right, rad/s.
    pub omegas_rad_s: Vec<f64>,
    /// `Z_e` at each, N·s/m.
    pub environment: Vec<Complex<f64>>,
    /// True if a coupler must be absolutely stable; false for a line that is passive by its energy.
    pub stable: bool,
}

/// The best coupler of an order.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct BestCoupler {
    /// The line with the best coupler, or the best impedance.
    pub line: HandLine,
    /// Closeness of the felt impedance to the environment's.
    pub transparency: Transparency,
}

/// Stiffness of couplers that are tried, N/m: of its spring, and of its damper at the middle of the band.
const STIFFNESS: [f64; 2] = [1.0, 1e5];
/// Steps of that, in the logarithm.
const STEPS: u32 = 40;
/// Steps from a spring alone to a damper alone.
const MIXES: u32 = 20;

impl Teleoperation {
    /// Compares the felt impedances with these, at these frequencies.
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
    /// For each mix of spring and damper the best size by a grid in its logarithm and smaller and smaller steps, then the same of
    /// the mix: the best couplers lie at the edge of stability, which no search along the axes of both gains can follow.
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
        let mut best: Option<Found> = None;
        for n in 0..=MIXES {
            search.improve(&mut best, f64::from(n) / f64::from(MIXES))?;
        }
        let mut step = 0.5 / f64::from(MIXES);
        while step > 2e-3 {
            let Some(Found { mix, .. }) = best else {
                return Ok(None);
            };
            let left = search.improve(&mut best, (mix - step).max(0.0))?;
            if !left && !search.improve(&mut best, (mix + step).min(1.0))? {
                step *= 0.5;
            }
        }
        Ok(best.map(|found| BestCoupler {
            line: found.line,
            transparency: found.transparency,
        }))
    }
}

#[derive(Clone, Copy)]
struct Found {
    mix: f64,
    line: HandLine,
    transparency: Transparency,
}

struct Search<'a> {
    question: &'a CouplerSearch,
    grid: Grid,
    order: Order,
    /// `b_c` of a damper as stiff as 1 N/m at the middle of the band.
    per_stiffness: f64,
}

impl Search<'_> {
    /// Looks along a mix for the best size; true if it is better than the best so far.
    fn improve(&self, best: &mut Option<Found>, mix: f64) -> Result<bool, AnalysisError> {
        let mut size = None;
        let mut better = false;
        let mut here: Option<f64> = None;
        let mut try_size = |steps: f64, here: &mut Option<f64>| {
            let line = self.line(mix, steps);
            let question = self.question;
            let hands = Teleoperation {
                line,
                ..question.hands
            };
            let transparency = hands.transparency(&question.omegas_rad_s, &question.environment)?;
            if here.is_some_and(|least| transparency.error >= least) {
                return Ok::<_, AnalysisError>(false);
            }
            // The dear question last.
            if question.stable
                && !(hands.is_stable_on(&self.grid) && hands.absolute_stability()?.stable)
            {
                return Ok(false);
            }
            *here = Some(transparency.error);
            if best.is_none_or(|best| transparency.error < best.transparency.error) {
                better = true;
                *best = Some(Found {
                    mix,
                    line,
                    transparency,
                });
            }
            Ok(true)
        };
        for n in 0..=STEPS {
            if try_size(f64::from(n), &mut here)? {
                size = Some(f64::from(n));
            }
        }
        let mut step = 0.5;
        while let (true, Some(at)) = (step > 1e-3, size) {
            if try_size(at + step, &mut here)? {
                size = Some(at + step);
            } else if try_size(at - step, &mut here)? {
                size = Some(at - step);
            } else {
                step *= 0.5;
            }
        }
        Ok(better)
    }

    /// The line with this share of its stiffness in the damper, and this size.
    fn line(&self, mix: f64, steps: f64) -> HandLine {
        let share = steps.clamp(0.0, f64::from(STEPS)) / f64::from(STEPS);
        let size = STIFFNESS[0] * libm::pow(STIFFNESS[1] / STIFFNESS[0], share);
        let coupler = HandCoupler {
            stiffness_n_per_m: (1.0 - mix) * size,
            dissipation_n_s_mu_per_m: mix * size * self.per_stiffness,
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
                HandLine::Wave {
                    impedance_n_s_per_m: most * libm::pow(1e-2, 1.0 - share),
                    playout_samples,
                }
            }
        }
    }
}
