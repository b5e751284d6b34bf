//! The laws of both sides at one frequency, without cancellation near rest.

use crate::AnalysisError;
use fracdiff::Order;
use fracdiff::parameter::{not_negative, positive, range};
use num_complex::Complex;
use std::f64::consts::PI;

/// A device: a mass on a damper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandMass {
    /// m, kg, above 0.
    pub mass_kg: f64,
    /// b, N·s/m, at least 0.
    pub damping_n_s_per_m: f64,
}

/// A coupler `k_c` + `b_c·D^μ` from position to force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandCoupler {
    /// `k_c`, N/m, at least 0.
    pub stiffness_n_per_m: f64,
    /// `b_c`, N·s^μ/m, at least 0; one of the two must be above 0.
    pub dissipation_n_s_mu_per_m: f64,
    /// μ, 0 to 1.
    pub order: Order,
}

/// The laws of both sides of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HandLine {
    /// Each side is pulled to the place of the other.
    PositionPosition(HandCoupler),
    /// The slave is pulled to the place of the master, which feels that force.
    PositionForce(HandCoupler),
    /// Waves (b·v + F)/√(2b).
    Wave {
        /// b, N·s/m, above 0.
        impedance_n_s_per_m: f64,
        /// N, at least 1: samples of playout.
        playout_samples: u32,
    },
}

/// A two port at one frequency.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ports {
    pub(super) h11: Complex<f64>,
    pub(super) h12: Complex<f64>,
    pub(super) h21: Complex<f64>,
    pub(super) h22: Complex<f64>,
}

impl Ports {
    /// `Z_t`.
    pub(super) fn transmitted(&self, environment: Complex<f64>) -> Complex<f64> {
        // (h₁₁ + (h₁₁h₂₂ − h₁₂h₂₁)Z_e)/(1 + h₂₂Z_e) = h₁₁ − h₁₂h₂₁Z_e/(1 + h₂₂Z_e)
        self.h11 - self.h12 * self.h21 * environment / (1.0 + self.h22 * environment)
    }

    /// Least of the real parts, and 2 Re h₁₁ Re h₂₂/(|h₁₂h₂₁| + Re(h₁₂h₂₁)): at least 0 and 1.
    pub(super) fn llewellyn(&self) -> (f64, f64) {
        // |p| + Re p = 2|p|·sin²(φ/2) with φ the phase of −p = h₁₂·(−h₂₁): exact where it vanishes.
        let phase = self.h12.arg() + (-self.h21).arg();
        let sine = libm::sin(0.5 * phase);
        let taken = 2.0 * self.h12.norm() * self.h21.norm() * sine * sine;
        let ratio = 2.0 * self.h11.re * self.h22.re / taken;
        // Nothing taken at all is no danger.
        let ratio = if taken > 0.0 { ratio } else { f64::INFINITY };
        (self.h11.re.min(self.h22.re), ratio)
    }
}

impl HandLine {
    pub(super) fn check(&self) -> Result<(), AnalysisError> {
        match self {
            Self::PositionPosition(coupler) | Self::PositionForce(coupler) => coupler.check(),
            Self::Wave {
                impedance_n_s_per_m,
                playout_samples,
            } => {
                positive("wave impedance", *impedance_n_s_per_m, "N·s/m")?;
                positive("playout", f64::from(*playout_samples), "samples")?;
                Ok(())
            }
        }
    }

    pub(super) fn ports(
        &self,
        masses: [HandMass; 2],
        sample_time: f64,
        delay: f64,
        theta: f64,
    ) -> Ports {
        let t = sample_time;
        let omega = theta / t;
        let [zm, zs] =
            masses.map(|mass| Complex::new(mass.damping_n_s_per_m, mass.mass_kg * omega));
        // (1 − w)/(jθ) = sin(θ/2)/(θ/2)·e^(−jθ/2)
        let half = 0.5 * theta;
        let hold = Complex::from_polar(libm::sin(half) / half, -half);
        let psi = omega * (delay + t);
        let at = Frequency {
            zm,
            zs,
            hold,
            omega,
            psi,
        };
        match self {
            Self::PositionPosition(coupler) => at.position_position(coupler.response(t, theta)),
            Self::PositionForce(coupler) => at.position_force(coupler.response(t, theta)),
            Self::Wave {
                impedance_n_s_per_m,
                playout_samples,
            } => at.wave(*impedance_n_s_per_m, *playout_samples, theta),
        }
    }
}

/// Both devices and the line at a frequency.
struct Frequency {
    /// Impedances of master and slave.
    zm: Complex<f64>,
    zs: Complex<f64>,
    /// (1 − w)/(jθ).
    hold: Complex<f64>,
    omega: f64,
    /// Δ = e^(−jψ) without playout.
    psi: f64,
}

impl Frequency {
    /// Δ = e^(−jψ), the delay of the line without playout.
    fn late(&self) -> Complex<f64> {
        Complex::from_polar(1.0, -self.psi)
    }

    /// c, the coupler as an impedance, and 1 + `Z_s`/c.
    fn coupled(&self, response: Complex<f64>) -> (Complex<f64>, Complex<f64>) {
        let c = self.hold * response / Complex::new(0.0, self.omega);
        (c, 1.0 + self.zs / c)
    }

    fn position_position(&self, response: Complex<f64>) -> Ports {
        let (c, spread) = self.coupled(response);
        let through = self.late() / spread;
        // 1 − Δ² = 2j·sin(ψ)·e^(−jψ)
        let lost = Complex::new(0.0, 2.0 * libm::sin(self.psi)) * self.late();
        Ports {
            // Z_m + (c·Z_s + c²(1 − Δ²))/(Z_s + c)
            h11: self.zm + (self.zs + c * lost) / spread,
            h12: through,
            h21: -through,
            h22: 1.0 / (self.zs + c),
        }
    }

    fn position_force(&self, response: Complex<f64>) -> Ports {
        let (c, spread) = self.coupled(response);
        let through = self.late() / spread;
        Ports {
            // Z_m + Δ²·c·Z_s/(Z_s + c)
            h11: self.zm + self.late() * self.late() * self.zs / spread,
            h12: through,
            h21: -through,
            h22: 1.0 / (self.zs + c),
        }
    }

    fn wave(&self, impedance_n_s_per_m: f64, playout_samples: u32, theta: f64) -> Ports {
        let b = impedance_n_s_per_m * self.hold * self.hold;
        // σ = ln(1/Δ) = jψ + ln(1 + (N − 1)(1 − w)), since 1/S = N − (N − 1)w; then a = b·coth σ, n = b/sinh σ.
        let one_less_w = Complex::new(0.0, theta) * self.hold;
        let x = one_less_w * (f64::from(playout_samples) - 1.0);
        let damped = 0.5 * libm::log1p(2.0 * x.re + x.norm_sqr());
        let (sin, cos) = libm::sincos(self.psi + libm::atan2(x.im, 1.0 + x.re));
        let (sinh, cosh) = (libm::sinh(damped), libm::cosh(damped));
        let (sinh, cosh) = (
            Complex::new(sinh * cos, cosh * sin),
            Complex::new(cosh * cos, sinh * sin),
        );
        // n/(Z_s + a) = b/(Z_s·sinh + b·cosh)
        let through = b / (self.zs * sinh + b * cosh);
        Ports {
            // Z_m + a − n²/(Z_s + a) = Z_m + (a·Z_s + b²)/(Z_s + a)
            h11: self.zm + (self.zs * cosh + b * sinh) * through,
            h12: through,
            h21: -through,
            h22: through * sinh / b,
        }
    }
}

impl HandCoupler {
    fn check(&self) -> Result<(), AnalysisError> {
        let (k, b) = (self.stiffness_n_per_m, self.dissipation_n_s_mu_per_m);
        not_negative("coupler stiffness", k, "N/m")?;
        not_negative("coupler dissipation", b, "N·s^μ/m")?;
        positive("coupler stiffness and dissipation together", k + b, "")?;
        let mu = self.order.get();
        let creeps = (0.0..=1.0).contains(&mu);
        range("order of the coupler", mu, creeps, "in [0, 1]", "")?;
        Ok(())
    }

    /// `k_c` + `b_c·T^(−μ)(1` − w)^μ, N/m.
    fn response(&self, t: f64, theta: f64) -> Complex<f64> {
        let mu = self.order.get();
        let size = libm::pow(2.0 * libm::sin(0.5 * theta) / t, mu);
        let power = Complex::from_polar(size, 0.5 * mu * (PI - theta));
        self.stiffness_n_per_m + power * self.dissipation_n_s_mu_per_m
    }
}
