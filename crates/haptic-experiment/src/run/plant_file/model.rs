//! A plant as its file says it.

use fracdiff::parameter::{Shown, range};
use fractional_control::{ControlError, FractionalTransferFunction, Plant, StateSpace};
use nalgebra::{DMatrix, DVector, RowDVector};
use num_complex::Complex;
use std::str::FromStr;

/// A plant that can be read, and where it comes from.
///
/// ```
/// use haptic_experiment::run::PlantFile;
/// use std::path::Path;
///
/// let text = "[device]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\ndelay_s = 0.001";
/// let file = PlantFile::parse(Path::new("lab/arm.toml"), text)?;
/// // A mass of 65 g: |x/f| is 1/(m·ω²) at high frequency.
/// let far = file.plant()?.response(1e4).expect("at any frequency");
/// assert!((far.norm() * 0.065 * 1e8 - 1.0).abs() < 1e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct PlantFile {
    /// The plant.
    pub model: PlantModel,
    /// Of a device that was measured: between which numbers its values lie.
    pub intervals: Vec<Interval>,
    /// The program that made the file.
    pub program: String,
    /// Anything else.
    pub note: String,
}

/// A plant as its file says it.
#[derive(Clone, Debug, PartialEq)]
pub enum PlantModel {
    /// `[transfer_function]`.
    Function {
        /// G(s) without the dead time.
        function: Box<FractionalTransferFunction>,
        /// Dead time, s.
        delay_s: f64,
    },
    /// `[device]`: m·ẍ + b·ẋ + k·x = f.
    Device(DeviceValues),
    /// `[state_space]`.
    StateSpace {
        /// A, a list of rows.
        a: Vec<Vec<f64>>,
        /// B.
        b: Vec<f64>,
        /// C.
        c: Vec<f64>,
        /// Dead time, s.
        delay_s: f64,
        /// Time constant of the actuator before it, s.
        current_lag_s: f64,
    },
    /// `[measured_response]`: ω in rad/s and G(jω).
    Measured(Vec<(f64, Complex<f64>)>),
}

/// Two numbers between which a value of a device lies in 95 of 100 cases.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Key of the value.
    pub key: &'static str,
    /// Low end.
    pub low: f64,
    /// High end.
    pub high: f64,
}

/// A device with a hand: force in, position out. Friction, encoder and noise are no part of the linear plant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DeviceValues {
    /// m.
    pub mass_kg: f64,
    /// b.
    pub damping_n_s_per_m: f64,
    /// k of the hand.
    pub hand_stiffness_n_per_m: f64,
    /// Delay beside the hold, s.
    pub delay_s: f64,
    /// Time constant of the actuator's current, s.
    pub current_lag_s: f64,
    /// Coulomb friction, N.
    pub friction_n: f64,
    /// Encoder resolution, m per count; 0 for none.
    pub encoder_resolution_m: f64,
    /// Standard deviation of the sensor's noise, m; 0 for none.
    pub sensor_noise_m: f64,
}

impl FromStr for PlantModel {
    type Err = ControlError;

    /// As a [`Plant`]: a transfer function in notation, perhaps with `exp(-0.5s)` as a factor.
    fn from_str(text: &str) -> Result<Self, ControlError> {
        let plant: Plant = text.parse()?;
        let empty = ControlError::Empty { what: "numerator" };
        Ok(Self::Function {
            function: Box::new(*plant.function().ok_or(empty)?),
            delay_s: plant.delay_s(),
        })
    }
}

impl PlantModel {
    /// The plant.
    ///
    /// # Errors
    /// A value outside its range, matrices whose sizes do not fit.
    pub fn plant(&self) -> Result<Plant, ControlError> {
        match self {
            Self::Function { function, delay_s } => Plant::transfer(**function, *delay_s),
            Self::Device(own) => own.plant(),
            Self::StateSpace {
                a,
                b,
                c,
                delay_s,
                current_lag_s,
            } => {
                let columns = a.first().map_or(0, Vec::len);
                // A ragged matrix has a size that does not fit.
                let even = a.iter().all(|row| row.len() == columns);
                let rows = if even { a.len() } else { 0 };
                let at = |i: usize, j: usize| a.get(i).and_then(|row| row.get(j)).copied();
                let matrix = DMatrix::from_fn(rows, columns, |i, j| at(i, j).unwrap_or(f64::NAN));
                let (b, c) = (DVector::from_column_slice(b), RowDVector::from_row_slice(c));
                let states = StateSpace::new(matrix, b, c)?.behind_lag(*current_lag_s)?;
                Plant::state_space(states, *delay_s)
            }
            Self::Measured(points) => Plant::measured(points),
        }
    }

    /// The plant in a few words: its notation where it has one.
    #[must_use]
    pub fn in_words(&self) -> String {
        match self {
            Self::Function { function, delay_s } if *delay_s > 0.0 => {
                if (1e-6..1e15).contains(delay_s) {
                    format!("exp(-{delay_s}s)*{function}")
                } else {
                    format!("exp(-{delay_s:e}s)*{function}")
                }
            }
            Self::Function { function, .. } => function.to_string(),
            Self::Device(own) => own.in_words(),
            Self::StateSpace { a, delay_s, .. } => {
                let plural = if a.len() == 1 { "" } else { "s" };
                format!("{} state{plural}, delay {delay_s} s", a.len())
            }
            Self::Measured(points) => format!("measured at {} frequencies", points.len()),
        }
    }
}

impl DeviceValues {
    /// A mass with damping and nothing else.
    #[must_use]
    pub fn ideal(mass_kg: f64, damping_n_s_per_m: f64) -> Self {
        Self {
            mass_kg,
            damping_n_s_per_m,
            ..Self::default()
        }
    }

    /// As matrices.
    ///
    /// # Errors
    /// A mass below 1e-15 kg, a negative lag or delay.
    pub fn plant(&self) -> Result<Plant, ControlError> {
        let (m, b, k) = (
            self.mass_kg,
            self.damping_n_s_per_m,
            self.hand_stiffness_n_per_m,
        );
        // Less would move faster than numbers go.
        range("mass", m, m >= 1e-15, "at least 1e-15", "kg")?;
        fracdiff::parameter::not_negative("damping", b, "N·s/m")?;
        fracdiff::parameter::not_negative("hand stiffness", k, "N/m")?;
        let states = StateSpace::new(
            DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -k / m, -b / m]),
            DVector::from_column_slice(&[0.0, 1.0 / m]),
            RowDVector::from_row_slice(&[1.0, 0.0]),
        )?;
        Plant::state_space(states.behind_lag(self.current_lag_s)?, self.delay_s)
    }

    fn in_words(&self) -> String {
        format!(
            "device of {} kg, {} N·s/m, hand {} N/m, delay {} s, current lag {} s",
            Shown(self.mass_kg),
            Shown(self.damping_n_s_per_m),
            Shown(self.hand_stiffness_n_per_m),
            Shown(self.delay_s),
            Shown(self.current_lag_s)
        )
    }
}
