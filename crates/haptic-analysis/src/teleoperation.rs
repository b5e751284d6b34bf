//! Two hands over a line: what the one feels of what the other touches, and with which delay both ends stay stable.

mod line;
mod search;

pub use line::{HandCoupler, HandLine, HandMass};
pub use search::{BestCoupler, CouplerSearch, Transparency};

use crate::AnalysisError;
use crate::curve::NEAR_REST;
use crate::extremum::Grid;
use crate::transparency::{finite, turned};
use fracdiff::parameter::{not_negative, positive};
use line::Ports;
use num_complex::Complex;

/// Master, slave and the line between them.
/// ```text
/// F_h = h₁₁·V_m + h₁₂·F_e,   −V_s = h₂₁·V_m + h₂₂·F_e       F_h of the hand on the master, F_e of the slave on its environment
/// Z_i = m_i·s + b_i,   hold Ho = (1 − w)/(sT),   Δ = e^(−s(h + T))·S,   s = jω, w = e^(−sT)
///
///                      master feels F = a_m·V_m − n_m·V_s     slave is pulled by F = n_s·V_m − a_s·V_s
/// position–position    a_m = c      n_m = c·Δ                  a_s = c   n_s = c·Δ      c = Ho·(k_c + b_c·T^(−μ)(1 − w)^μ)/s
/// position–force       a_m = c·Δ²   n_m = c·Δ                  a_s = c   n_s = c·Δ
/// waves                a = b·Ho²(1 + Δ²)/(1 − Δ²),   n = b·Ho²·2Δ/(1 − Δ²)              on both sides
///
/// h₂₂ = 1/(Z_s + a_s),   h₂₁ = −n_s·h₂₂,   h₁₂ = n_m·h₂₂,   h₁₁ = Z_m + a_m − n_m·n_s·h₂₂
/// Z_t = (h₁₁ + (h₁₁h₂₂ − h₁₂h₂₁)·Z_e)/(1 + h₂₂·Z_e)         what the hand feels of an environment Z_e
/// ```
/// - *Delay*: h is that of the line; a message takes a sample T more, since what is read in one tick acts in the next at the
///   earliest. S is the playout of waves, (1/N)/(1 − (1 − 1/N)w), 1 otherwise.
/// - *Sampled*: controllers and held forces are those that run; images above π/T are not in it.
/// - *Time-domain passivity* is position–position for as long as its account is not empty.
/// - *Orders* 0 ≤ μ ≤ 1. *Range of ω*: 0 < ω ≤ π/T.
///
/// Derived anew from the two equations of motion, the result is that of theory: `Z_t` as in D. A. Lawrence, *Stability and
/// transparency in bilateral teleoperation*, IEEE Trans. Robotics and Automation 9(5), 1993.
/// ```
/// use fracdiff::Order;
/// use haptic_analysis::num_complex::Complex;
/// use haptic_analysis::{HandCoupler, HandLine, HandMass, Teleoperation};
///
/// let device = HandMass { mass_kg: 0.065, damping_n_s_per_m: 3.5 };
/// let hands = Teleoperation {
///     master: device,
///     slave: device,
///     line: HandLine::PositionPosition(HandCoupler {
///         stiffness_n_per_m: 1000.0,
///         dissipation_n_s_mu_per_m: 0.0,
///         order: Order::new(1.0)?,
///     }),
///     sample_time_s: 1e-3,
///     delay_s: 0.0,
/// };
/// // A remote spring of 1 kN/m behind a coupler as stiff, at 1 rad/s: half as stiff.
/// let felt = hands.transmitted(1.0, Complex::new(0.0, -1000.0))?;
/// assert!((felt.im + 500.0).abs() < 1.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Teleoperation {
    /// The device in the hand.
    pub master: HandMass,
    /// The remote device, which touches the environment.
    pub slave: HandMass,
    /// The laws of both sides.
    pub line: HandLine,
    /// T, s, above 0.
    pub sample_time_s: f64,
    /// h, s, at least 0: delay of the line in either direction.
    pub delay_s: f64,
}

impl Teleoperation {
    /// `Z_t`, N·s/m, for an environment of impedance `Z_e(jω)`, velocity in and force out, N·s/m.
    ///
    /// # Errors
    /// A parameter or ω outside its range, a result that is too large for a number, or a resonance without damping.
    pub fn transmitted(
        &self,
        omega_rad_s: f64,
        environment: Complex<f64>,
    ) -> Result<Complex<f64>, AnalysisError> {
        self.checked()?;
        let felt = (self.ports(turned(omega_rad_s, self.sample_time_s)?)).transmitted(environment);
        finite("transmitted impedance", felt.re + felt.im, "N·s/m")?;
        Ok(felt)
    }

    pub(crate) fn checked(&self) -> Result<(), AnalysisError> {
        for mass in [self.master, self.slave] {
            positive("mass", mass.mass_kg, "kg")?;
            not_negative("damping", mass.damping_n_s_per_m, "N·s/m")?;
        }
        positive("sample time", self.sample_time_s, "s")?;
        not_negative("delay of the line", self.delay_s, "s")?;
        self.line.check()
    }

    /// Ports for checked parameters, at 0 < θ ≤ π.
    fn ports(&self, theta: f64) -> Ports {
        self.line.ports(
            [self.master, self.slave],
            self.sample_time_s,
            self.delay_s,
            theta,
        )
    }
}

/// Llewellyn's conditions over all frequencies.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct AbsoluteStability {
    /// True if they hold at every frequency: the pair is stable with any passive hand and
    /// environment.
    pub stable: bool,
    /// Least 2 Re h₁₁ Re h₂₂/(|h₁₂h₂₁| + Re(h₁₂h₂₁)), at least 1 for stability; 0 where a real part is negative.
    pub least_ratio: f64,
    /// The frequency of that least ratio, rad/s.
    pub worst_rad_s: f64,
}

/// The delay beyond which two hands are no longer absolutely stable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LargestDelay {
    /// Not absolutely stable, even without delay.
    None,
    /// Stable for every delay that was tried up to this one, s, and not just above it.
    Below {
        /// The longest delay that held, s.
        delay_s: f64,
    },
    /// Stable for every delay that was tried up to the largest one asked for.
    Any,
}

/// Share of the limit that rounding takes.
const ROUNDING: f64 = 1e-9;
/// Delays that are tried on the way to the largest, a factor of 1.17 apart.
const TRIED: usize = 60;

impl Teleoperation {
    /// Llewellyn's conditions at one frequency: the smaller of Re h₁₁ (N·s/m) and Re h₂₂ (m/(N·s)), at least 0, and the ratio of
    /// [`AbsoluteStability::least_ratio`], at least 1.
    ///
    /// # Errors
    /// A parameter or ω outside its range.
    pub fn llewellyn(&self, omega_rad_s: f64) -> Result<(f64, f64), AnalysisError> {
        self.checked()?;
        Ok(self
            .ports(turned(omega_rad_s, self.sample_time_s)?)
            .llewellyn())
    }

    /// Llewellyn's conditions at every frequency up to π/T, by a grid that resolves the delay and golden sections in it.
    ///
    /// A wave line without playout fails near the frequencies ωh = nπ: there it has no loss, and the hold is late by half a
    /// sample. It is passive as a *sampled* port; the damping of the devices has to pay for the hold. Two samples of playout are
    /// loss enough for a b up to 0.85 of the damping `b_d` of the devices, three for all of it, whatever the delay: a device reflects
    /// |Γ|² ≤ 1 + `bθ²/b_d` near rest, the playout keeps |S|² = 1/(1 + 2N(N − 1)(1 − cos θ)) ≈ 1 − N(N − 1)θ².
    ///
    /// # Errors
    /// A parameter outside its range, or a delay of more than 1e5 samples.
    pub fn absolute_stability(&self) -> Result<AbsoluteStability, AnalysisError> {
        self.checked()?;
        let grid = self.grid()?;
        let unresolved = AnalysisError::Unresolved {
            what: "absolute stability",
            why: "a response is no number",
        };
        let worst = grid
            .maximum(f64::NEG_INFINITY, &|theta| -self.ratio(theta))
            .ok_or(unresolved)?;
        let least_ratio = -worst.value;
        Ok(AbsoluteStability {
            stable: least_ratio >= 1.0 - ROUNDING,
            least_ratio,
            worst_rad_s: worst.theta / self.sample_time_s,
        })
    }

    /// The ratio, 0 where a real part is negative.
    fn ratio(&self, theta: f64) -> f64 {
        let (real, ratio) = self.ports(theta.max(NEAR_REST)).llewellyn();
        if real < 0.0 {
            0.0
        } else if ratio > 1e12 {
            // Of no concern, and no pole in a search.
            1e12
        } else {
            ratio
        }
    }

    /// The verdict at the points of a grid alone, for searches.
    pub(super) fn is_stable_on(&self, grid: &Grid) -> bool {
        let bound = 1.0 - ROUNDING;
        grid.thetas()
            .iter()
            .all(|&theta| self.ratio(theta) >= bound)
    }

    pub(super) fn grid(&self) -> Result<Grid, AnalysisError> {
        const MOST: f64 = 1e5;
        let samples = 2.0 * (self.delay_s / self.sample_time_s + 1.0);
        if samples > MOST {
            return Err(AnalysisError::Unresolved {
                what: "absolute stability",
                why: "the delay is more than 50000 samples: use a longer sample time",
            });
        }
        Ok(Grid::new(samples as usize))
    }

    /// The largest delay with which the two hands are absolutely stable, up to `most_s`; the delay of `self` does not matter.
    ///
    /// Delays are tried from short to long, then halved: a gap between two stable delays closer than a factor of 1.17 can be missed.
    ///
    /// # Errors
    /// As [`absolute_stability`](Self::absolute_stability).
    pub fn largest_delay(&self, most_s: f64) -> Result<LargestDelay, AnalysisError> {
        fracdiff::parameter::positive("largest delay", most_s, "s")?;
        let stable = |delay_s: f64| {
            let tried = Self { delay_s, ..*self };
            Ok::<_, AnalysisError>(tried.absolute_stability()?.stable)
        };
        if !stable(0.0)? {
            return Ok(LargestDelay::None);
        }
        let mut good = 0.0;
        // From a factor of 10⁴ below the longest on.
        let first = 1e-4 * most_s;
        for n in 0..=TRIED {
            let delay_s = first * libm::pow(1e4, n as f64 / TRIED as f64);
            if stable(delay_s)? {
                good = delay_s;
                continue;
            }
            let mut bad = delay_s;
            while bad - good > 1e-6 * bad {
                let middle = 0.5 * (good + bad);
                if stable(middle)? {
                    good = middle;
                } else {
                    bad = middle;
                }
            }
            return Ok(LargestDelay::Below { delay_s: good });
        }
        Ok(LargestDelay::Any)
    }
}
