//! A robot that takes a velocity and measures a force, and the force of a hand as the law gets it.

use crate::AnalysisError;
use crate::ForcePath;
use crate::linear::{Matrices, Sampled, balance, poles};
use core::f64::consts::PI;
use fracdiff::parameter::{not_negative, positive, range};
use nalgebra::{DMatrix, DVector, RowDVector};
use num_complex::Complex;

/// The robot's own loop: from a velocity command to the velocity of the handle, ẋ = Ax + Bu, v = Cx, both in m/s.
#[derive(Clone, Debug, PartialEq)]
pub struct VelocityLoop {
    a: DMatrix<f64>,
    b: DVector<f64>,
    c: RowDVector<f64>,
}

impl VelocityLoop {
    /// Most states of a loop.
    pub const STATES_MAX: usize = 6;

    /// ω²/(s² + 2ζωs + ω²), ω = 2πf; f from 0.01 Hz to 100 kHz, ζ from 0.05 to 10.
    ///
    /// # Errors
    /// Either outside its range.
    pub fn second_order(
        natural_frequency_hz: f64,
        damping_ratio: f64,
    ) -> Result<Self, AnalysisError> {
        let (f, zeta) = (natural_frequency_hz, damping_ratio);
        let what = "natural frequency of the robot's loop";
        range(
            what,
            f,
            (0.01..=1e5).contains(&f),
            "from 0.01 to 100000 {}",
            "Hz",
        )?;
        let what = "damping ratio of the robot's loop";
        range(
            what,
            zeta,
            (0.05..=10.0).contains(&zeta),
            "from 0.05 to 10",
            "",
        )?;
        let omega = 2.0 * PI * f;
        Self::from_matrices(
            &[0.0, omega, -omega, -2.0 * zeta * omega],
            &[0.0, omega],
            &[1.0, 0.0],
        )
    }

    /// Any stable loop: `a`, n×n by rows in 1/s, `b` and `c` n long, n from 1 to 6.
    ///
    /// # Errors
    /// Sizes that do not fit, numbers that are not finite, a loop that is not stable by itself, or that does not follow a velocity: its gain at rest
    /// has to be from 0.5 to 2.
    pub fn from_matrices(a: &[f64], b: &[f64], c: &[f64]) -> Result<Self, AnalysisError> {
        let n = b.len();
        let most = Self::STATES_MAX;
        let what = "states of the robot's loop";
        range(what, n as f64, (1..=most).contains(&n), "from 1 to 6", "")?;
        for (what, length, wanted) in [
            ("entries of the robot's A", a.len(), n * n),
            ("entries of the robot's C", c.len(), n),
        ] {
            let allowed = "as many as the entries of B ask for";
            range(what, length as f64, length == wanted, allowed, "")?;
        }
        for &value in a.iter().chain(b).chain(c) {
            range("entry of the robot's matrices", value, true, "finite", "")?;
        }
        let matrix = DMatrix::from_row_slice(n, n, a);
        let slowest = poles(&matrix).into_iter().map(|pole| pole.re);
        let slowest = slowest.fold(f64::NEG_INFINITY, f64::max);
        let what = "real part of the slowest pole of the robot's loop";
        range(
            what,
            slowest,
            slowest < 0.0,
            "below 0: the loop is stable by itself",
            "1/s",
        )?;
        let (b, c) = (DVector::from_column_slice(b), RowDVector::from_row_slice(c));
        let made = Self { a: matrix, b, c };
        let gain = made.response(0.0).re;
        let what = "gain at rest of the robot's loop";
        range(
            what,
            gain,
            (0.5..=2.0).contains(&gain),
            "from 0.5 to 2: velocity per commanded velocity",
            "",
        )?;
        Ok(made)
    }

    /// G(jω).
    fn response(&self, omega: f64) -> Complex<f64> {
        let n = self.b.len();
        let system = DMatrix::from_fn(n, n, |row, column| {
            let turn = if row == column { omega } else { 0.0 };
            Complex::new(-self.a[(row, column)], turn)
        });
        let moved = system.lu().solve(&self.b.map(|b| Complex::new(b, 0.0)));
        let nan = Complex::new(f64::NAN, f64::NAN);
        moved.map_or(nan, |x| {
            (self.c.iter().zip(x.iter())).map(|(c, x)| x * *c).sum()
        })
    }
}

/// First-order lags in a row through which a measured force passes, all of the same corner frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceFilter {
    /// Corner of each lag, Hz, from 0.01 to 100 000.
    pub cutoff_hz: f64,
    /// Number of lags, from 0 (none, whatever the corner) to 4.
    pub lags: usize,
}

impl ForceFilter {
    /// A sensor that tells the force at once.
    pub const NONE: Self = Self {
        cutoff_hz: 1.0,
        lags: 0,
    };
}

/// The device below a law for motion: the robot's loop behind a hold and a dead time, and its force sensor.
/// ```text
/// v = G(s)·e^(−sτ)·u,  u held over T      f_m = H(s)·f
/// L(w) = m·L_m + b·L_b + k·L_k            sampled force over the command, of a hand m·s + b + k/s on the handle
/// ```
/// *Exact*: the matrix exponential of loop, filter and, for `L_k`, the position. The mass of a tool between sensor and hand stands in m.
#[derive(Clone, Debug)]
pub struct Robot {
    motion: VelocityLoop,
    filter: ForceFilter,
    tool_mass_kg: f64,
    sample_time_s: f64,
    path: ForcePath,
    /// A/(1 − w), in powers of v = 1 − w.
    pub(super) denominator_in_v: Vec<f64>,
    /// Numerators over A of mass and damping, without their factor 1 − w, and of stiffness.
    pub(super) numerators: [Numerator; 3],
}

/// A numerator in powers of w and of v.
#[derive(Clone, Debug)]
pub(super) struct Numerator {
    pub(super) in_w: Vec<f64>,
    pub(super) in_v: Vec<f64>,
}

impl Robot {
    /// Robot of a loop, a dead time of 0 to 10 000 samples, and a sensor; `tool_mass_kg`, at least 0, is beyond the sensor.
    ///
    /// # Errors
    /// A number outside its range; a loop and sensor without a lag between a command and the force of a mass, which follows the acceleration.
    pub fn new(
        motion: VelocityLoop,
        dead_time_s: f64,
        filter: ForceFilter,
        tool_mass_kg: f64,
        sample_time_s: f64,
    ) -> Result<Self, AnalysisError> {
        let t = positive("sample time", sample_time_s, "s")?;
        not_negative("dead time of the robot", dead_time_s, "s")?;
        not_negative("tool mass", tool_mass_kg, "kg")?;
        let cutoff = filter.cutoff_hz;
        let what = "corner frequency of the force filter";
        range(
            what,
            cutoff,
            (0.01..=1e5).contains(&cutoff),
            "from 0.01 to 100000 {}",
            "Hz",
        )?;
        let what = "lags of the force filter";
        range(
            what,
            filter.lags as f64,
            filter.lags <= 4,
            "from 0 to 4",
            "",
        )?;
        let path = ForcePath::new(dead_time_s / t, 0.0)?;
        let chain = Chain::new(&motion, filter, t);
        let jump = (&chain.c * &chain.b)[0];
        let size = chain.c.norm() * chain.b.norm();
        let what = "acceleration at once after a command";
        let allowed = "0: a lag in the robot's loop or in its sensor";
        range(what, jump, jump.abs() <= 1e-12 * size, allowed, "")?;
        let sampled = |matrices: Matrices| {
            let (mut a, mut b, mut c) = matrices;
            balance(&mut a, &mut b, &mut c);
            Sampled::new(&(a, b, c), path.fraction())
        };
        let rate =
            RowDVector::from_iterator(chain.b.len(), (&chain.c * &chain.a).iter().map(|x| x / t));
        let of_mass = sampled((chain.a.clone(), chain.b.clone(), rate))?;
        let of_damping = sampled((chain.a.clone(), chain.b.clone(), chain.c.clone()))?;
        let of_stiffness = sampled(chain.with_position(t))?;
        let denominator_in_v = of_damping.denominator_in_v.clone();
        let numerators = [of_mass, of_damping, of_stiffness].map(|sampled| Numerator {
            in_v: crate::plant::in_powers_of_v(&sampled.numerator),
            in_w: sampled.numerator,
        });
        Ok(Self {
            motion,
            filter,
            tool_mass_kg,
            sample_time_s: t,
            path,
            denominator_in_v,
            numerators,
        })
    }

    /// The robot with another dead time.
    pub(super) fn delayed_by(&self, samples: f64) -> Result<Self, AnalysisError> {
        let dead = samples * self.sample_time_s;
        let motion = self.motion.clone();
        Self::new(
            motion,
            dead,
            self.filter,
            self.tool_mass_kg,
            self.sample_time_s,
        )
    }

    /// T, s.
    #[must_use]
    pub fn sample_time_s(&self) -> f64 {
        self.sample_time_s
    }

    /// Mass of the tool, kg.
    #[must_use]
    pub fn tool_mass_kg(&self) -> f64 {
        self.tool_mass_kg
    }

    /// The dead time as whole samples and a fraction.
    #[must_use]
    pub fn dead_time(&self) -> ForcePath {
        self.path
    }

    /// G·H·e^(−sτ) behind the hold at ω > 0, rad/s: the law's motion in the hand, and the hand's force on its way back.
    #[must_use]
    pub fn way(&self, omega: f64) -> Complex<f64> {
        let theta = omega * self.sample_time_s;
        let half = 0.5 * theta;
        let (sin, cos) = libm::sincos(half);
        let held = Complex::new(cos, -sin) * (sin / half);
        let lag = Complex::new(1.0, omega / (2.0 * PI * self.filter.cutoff_hz));
        let filtered = (0..self.filter.lags).fold(Complex::new(1.0, 0.0), |way, _| way / lag);
        self.motion.response(omega) * filtered * held * self.path.continuous(theta)
    }
}

/// Loop and filter in units of a sample, from the command to the filtered velocity.
struct Chain {
    a: DMatrix<f64>,
    b: DVector<f64>,
    c: RowDVector<f64>,
}

impl Chain {
    fn new(motion: &VelocityLoop, filter: ForceFilter, t: f64) -> Self {
        let (n, lags) = (motion.b.len(), filter.lags);
        let corner = 2.0 * PI * filter.cutoff_hz * t;
        let mut a = DMatrix::zeros(n + lags, n + lags);
        let mut b = DVector::zeros(n + lags);
        let mut c = RowDVector::zeros(n + lags);
        for row in 0..n {
            b[row] = motion.b[row] * t;
            for column in 0..n {
                a[(row, column)] = motion.a[(row, column)] * t;
            }
        }
        for lag in n..n + lags {
            a[(lag, lag)] = -corner;
            if lag > n {
                a[(lag, lag - 1)] = corner;
            } else {
                for (column, weight) in motion.c.iter().enumerate() {
                    a[(lag, column)] = corner * weight;
                }
            }
        }
        if lags > 0 {
            c[n + lags - 1] = 1.0;
        } else {
            c.columns_mut(0, n).copy_from(&motion.c);
        }
        Self { a, b, c }
    }

    /// From the command to the filtered position, m.
    fn with_position(&self, t: f64) -> Matrices {
        let n = self.b.len();
        let mut a = DMatrix::zeros(n + 1, n + 1);
        a.view_mut((0, 0), (n, n)).copy_from(&self.a);
        a.view_mut((n, 0), (1, n)).copy_from(&(&self.c * t));
        let mut b = DVector::zeros(n + 1);
        b.rows_mut(0, n).copy_from(&self.b);
        let mut c = RowDVector::zeros(n + 1);
        c[n] = 1.0;
        (a, b, c)
    }
}
