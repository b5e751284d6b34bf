//! A plant with two ports: a controller at one, a sampled law at the other.

use crate::{
    ControlError,
    enclosure::{Factor, Fraction, Product, SampledLaw, SharedLaw},
    sampled_plant::DELAY_MAX,
    wide::{self, in_v},
};
use fracdiff::{
    Seconds,
    parameter::{RangeError, range},
};
use nalgebra::{DMatrix, DVector, RowDVector};
use std::{sync::Arc, vec};

/// x\[n+1\] = Φx\[n\] + `Γ_u` u\[n\] + `Γ_f` f\[n\]: the controller sees y = Cx and commands u, the law sees q = Dx and answers with f.
#[derive(Clone, Debug, PartialEq)]
pub struct TwoPort {
    /// Φ, from the states at one sample to those at the next.
    pub transition: DMatrix<f64>,
    /// `Γ_u`.
    pub command: DVector<f64>,
    /// `Γ_f`.
    pub load: DVector<f64>,
    /// C, from the states to what the controller measures.
    pub measured: RowDVector<f64>,
    /// D, from the states to what the law sees.
    pub felt: RowDVector<f64>,
}

/// A [`TwoPort`] with its law, as a controller's loop sees it. For verdicts; it does not run.
/// ```text
/// y/u = [G_yu + Z(G_yu·G_qf − G_yf·G_qu)]/(1 + Z·G_qf)
/// ```
/// ```
/// use fracdiff::Seconds;
/// use fractional_control::{LoadedPlant, PowerMemory, PidParameters, Rule, SampledLaw, SampledControlLoop, TwoPort};
/// use nalgebra::{DMatrix, DVector, RowDVector};
/// use num_complex::Complex;
/// use std::sync::Arc;
///
/// /// A spring.
/// #[derive(Debug)]
/// struct Spring(f64);
/// impl SampledLaw for Spring {
///     fn response(&self, _: f64) -> Complex<f64> {
///         self.0.into()
///     }
///     fn variation(&self, _: f64, _: f64) -> f64 {
///         0.0
///     }
/// }
///
/// // A mass of 1 kg on a damper of 1 N·s/m, 10 ms a sample, that both push and see.
/// let (t, fall) = (0.01, f64::exp(-0.01));
/// let force = DVector::from_column_slice(&[t - (1.0 - fall), 1.0 - fall]);
/// let place = RowDVector::from_row_slice(&[1.0, 0.0]);
/// let port = TwoPort {
///     transition: DMatrix::from_row_slice(2, 2, &[1.0, 1.0 - fall, 0.0, fall]),
///     command: force.clone(),
///     load: force,
///     measured: place.clone(),
///     felt: place,
/// };
/// let p = PidParameters { proportional: 50.0, ..PidParameters::NONE };
/// let memory = PowerMemory::new(Rule::Grunwald, 1e-6, 10.0)?;
/// let stable = |spring| {
///     let plant = LoadedPlant::new(&port, Arc::new(Spring(spring)), Seconds(t))?;
///     Ok::<_, fractional_control::ControlError>(SampledControlLoop::loaded(p.into(), memory, &plant)?.verdict().stable)
/// };
/// // Springs and gain add up: below 2b/T, 200 N/m, the damper holds them.
/// assert!(stable(100.0)? && !stable(160.0)?);
/// # Ok::<(), fractional_control::ControlError>(())
/// ```
#[derive(Clone, Debug)]
pub struct LoadedPlant {
    curve: Fraction,
    sample_time: Seconds,
}

impl LoadedPlant {
    /// The plant with this law at its second port.
    ///
    /// # Errors
    /// Matrices whose sizes do not fit or that are not finite, a law that nothing answers.
    pub fn new(
        port: &TwoPort,
        law: Arc<dyn SampledLaw>,
        sample_time: Seconds,
    ) -> Result<Self, ControlError> {
        sample_time.rate_to_the(fracdiff::Order::new(0.0)?)?;
        port.checked()?;
        let n = port.felt.len();
        let transition = wide::matrix(&port.transition);
        let (command, load) = (wide::column(&port.command), wide::column(&port.load));
        let felt = wide::row(&port.felt);
        // With f = −q the plant is [N_yu + R]/[…] for the same R = w·M that stands behind Z.
        let closed = &transition - &load * &felt;
        let sees = (wide::row(&port.measured), command);
        let (denominator, numerators) = in_v(&transition, &[sees.clone(), (felt, load)]);
        let (_, with_law) = in_v(&closed, &[sees]);
        let ([free, felt], [with_law]) = (&numerators[..], &with_law[..]) else {
            return Err(nothing_felt());
        };
        let rest = with_law.iter().zip(free).map(|(with, free)| with - free);
        let rest: vec::Vec<wide::Wide> = rest.collect();
        let rounded = |numbers: &[wide::Wide]| wide::rounded(numbers, n);
        let (denominator, free) = (rounded(&denominator), rounded(free));
        let (felt, rest) = (rounded(felt), rounded(&rest));
        if felt.iter().all(|power| *power == 0.0) {
            return Err(nothing_felt());
        }
        let law = Factor::Law(SharedLaw(law));
        let term = |factors| Product::new(1.0, factors);
        let late = || Factor::Delay(1);
        let above = vec![
            term(vec![Factor::InV(free), late()]),
            term(vec![Factor::InV(rest), late(), law.clone()]),
        ];
        let below = vec![
            term(vec![Factor::InV(denominator)]),
            term(vec![Factor::InV(felt), late(), law]),
        ];
        Ok(Self {
            curve: Fraction::new(above, below),
            sample_time,
        })
    }

    /// Delays the command by this number of samples.
    ///
    /// # Errors
    /// More than 10 000 samples.
    pub fn later(self, samples: usize) -> Result<Self, ControlError> {
        let (late, most) = (samples as f64, DELAY_MAX);
        let allowed = "at most 10000 {}";
        range("dead time", late, late <= most, allowed, "samples")?;
        let above = self.curve.above.with(&Factor::Delay(samples));
        let curve = Fraction {
            above,
            ..self.curve
        };
        Ok(Self { curve, ..self })
    }

    /// T, to which the matrices belong.
    #[must_use]
    pub fn sample_time(&self) -> Seconds {
        self.sample_time
    }

    pub(crate) fn curve(&self) -> &Fraction {
        &self.curve
    }
}

impl TwoPort {
    fn checked(&self) -> Result<(), ControlError> {
        let n = self.transition.nrows();
        let sizes = [
            self.transition.ncols(),
            self.command.len(),
            self.load.len(),
            self.measured.len(),
            self.felt.len(),
        ];
        let inside = n > 0 && sizes.iter().all(|size| *size == n);
        let allowed = "at least 1, the same in all matrices";
        range("number of states", n as f64, inside, allowed, "")?;
        let vectors = self.command.iter().chain(self.load.iter());
        let rows = self.measured.iter().chain(self.felt.iter());
        for value in self.transition.iter().chain(vectors).chain(rows) {
            range("element of a matrix", *value, true, "finite", "")?;
        }
        Ok(())
    }
}

fn nothing_felt() -> ControlError {
    let allowed = "other than 0: let the law see what its force moves within a sample";
    RangeError::new("answer of the plant to its load", 0.0, allowed, "").into()
}
