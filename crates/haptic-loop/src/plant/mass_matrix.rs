//! Mass that is felt along a direction.

use crate::LoopParameterError;
use crate::units::Kilograms;
use fracdiff::parameter::{RangeError, positive, range};
use nalgebra::{Cholesky, Const, SMatrix, SVector};

/// The mass matrix of a device in one posture.
///
/// ```text
/// M·x'' = f        pushed along n the device answers with x''·n = f·(nᵀ M⁻¹ n), as a mass of 1/(nᵀ M⁻¹ n) would
/// ```
/// - *Postures*: M of a linkage changes with its place; make one for each place. A device whose
///   axes have independent masses, as [`Axes`](super::Axes), has one for all,
///   [`of_axes`](Self::of_axes).
/// - *Along the axes of M* the effective mass is an eigenvalue; any other lies between the least and the largest.
/// - *Sideways* a device with unequal masses moves too when it is pushed along n. A loop along n does not see that.
///
/// Source: O. Khatib, "Inertial properties in robotic manipulation: an object-level framework", Int. J. Robotics Research
/// 14(1), 1995, for the effective mass in a direction.
#[derive(Clone, Debug)]
pub struct MassMatrix<const D: usize> {
    root: Cholesky<f64, Const<D>>,
}

impl<const D: usize> MassMatrix<D> {
    /// M, kg.
    ///
    /// # Errors
    /// M must be finite, symmetric to 1e-9 of its largest entry, and positive definite.
    pub fn new(mass_kg: SMatrix<f64, D, D>) -> Result<Self, LoopParameterError> {
        let largest = mass_kg.iter().fold(0.0, |most: f64, m| most.max(m.abs()));
        let skew = (mass_kg - mass_kg.transpose()).abs().max();
        let symmetric = skew <= 1e-9 * largest;
        let (what, allowed) = (
            "asymmetry of the mass matrix",
            "at most 1e-9 of its largest entry",
        );
        range(what, skew, symmetric, allowed, "kg")?;
        let (what, allowed) = (
            "largest entry of the mass matrix",
            "that of a positive definite one",
        );
        let indefinite = RangeError::new(what, largest, allowed, "kg");
        let root = Cholesky::new(mass_kg).ok_or(indefinite)?;
        Ok(Self { root })
    }

    /// A device whose axes have independent masses.
    ///
    /// # Errors
    /// Each must be finite and above 0.
    pub fn of_axes(masses: [Kilograms; D]) -> Result<Self, LoopParameterError> {
        for mass in masses {
            positive("mass", mass.0, "kg")?;
        }
        Self::new(SMatrix::from_diagonal(&SVector::from(
            masses.map(|mass| mass.0),
        )))
    }

    /// 1/(nᵀ M⁻¹ n), for a direction of any length above 0.
    ///
    /// # Errors
    /// A direction without a finite length above 0.
    pub fn along(&self, direction: &SVector<f64, D>) -> Result<Kilograms, LoopParameterError> {
        let length = libm::sqrt(direction.dot(direction));
        positive("length of the direction", length, "")?;
        let normal = direction / length;
        Ok(Kilograms(1.0 / normal.dot(&self.root.solve(&normal))))
    }
}
