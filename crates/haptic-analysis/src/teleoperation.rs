//! Two hands over a line: what the one feels of what the other touches, and with which delay both ends stay stable.

mod line;
mod search;
mod stability;

pub use line::{HandCoupler, HandLine, HandMass};
pub use search::{BestCoupler, CouplerSearch, Transparency};
pub use stability::{AbsoluteStability, LargestDelay};

use crate::transparency::{finite, turned};
use crate::{AnalysisError, HybridMatrix};
use fracdiff::parameter::{not_negative, positive};
use line::Ports;
use num_complex::Complex;

/// Master, slave and the line between them.
///
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
///
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
    /// The remote device.
    pub slave: HandMass,
    /// The laws of both sides.
    pub line: HandLine,
    /// T, s, above 0.
    pub sample_time_s: f64,
    /// h, s, at least 0: delay of the line in either direction.
    pub delay_s: f64,
}

impl Teleoperation {
    /// The hybrid matrix; its p's are the h's above.
    ///
    /// # Errors
    /// A parameter or ω outside its range, or a result that is too large for a number.
    pub fn hybrid_matrix(&self, omega_rad_s: f64) -> Result<HybridMatrix, AnalysisError> {
        self.checked()?;
        let ports = self.ports(turned(omega_rad_s, self.sample_time_s)?);
        let matrix = HybridMatrix {
            p11: ports.h11,
            p12: ports.h12,
            p21: ports.h21,
            p22: ports.h22,
        };
        for p in [matrix.p11, matrix.p12, matrix.p21, matrix.p22] {
            finite("element of the hybrid matrix", p.re + p.im, "")?;
        }
        Ok(matrix)
    }

    /// `Z_t`, N·s/m, for an environment of impedance `Z_e(jω)`, velocity in and force out, N·s/m.
    ///
    /// # Errors
    /// As [`hybrid_matrix`](Self::hybrid_matrix), or a resonance without damping.
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

    /// Itself, if its parameters are in range.
    pub(crate) fn checked(&self) -> Result<(), AnalysisError> {
        for mass in [self.master, self.slave] {
            positive("mass", mass.mass_kg, "kg")?;
            not_negative("damping", mass.damping_n_s_per_m, "N·s/m")?;
        }
        positive("sample time", self.sample_time_s, "s")?;
        not_negative("delay of the line", self.delay_s, "s")?;
        self.line.check()
    }

    /// Of checked parameters, at 0 < θ ≤ π.
    fn ports(&self, theta: f64) -> Ports {
        self.line.ports(
            [self.master, self.slave],
            self.sample_time_s,
            self.delay_s,
            theta,
        )
    }
}
