//! Stability of the sampled loop: three ways that must agree.

use crate::characteristic::Characteristic;
use crate::jury::{Jury, jury, poles};
use crate::operator::multiply;
use crate::{AnalysisError, ForcePath, LoopOperator, Nondimensional, SampledPlant};
use certified_count::Count;
use fracdiff::parameter::range;
use num_complex::Complex;

/// A loop closed over a virtual environment, without units.
///
/// ```text
/// F(w) = A(w) + w^(d+1)·N(w)·(α + βP(w)),   stable ⇔ F has no zero in |w| ≤ 1,  w = z^(−1)
/// ```
/// - α, β: stiffness and dissipation, at least 0; δ, γ: device and hand, see [`SampledPlant`].
/// - d: whole samples of delay between measuring and acting, beside the one of the hold; up to
///   [`DELAY_MAX`](Self::DELAY_MAX). A delay that is no whole number and a current lag belong to the plant:
///   [`with_plant`](Self::with_plant).
///
/// ```
/// use fracdiff::{Order, Scheme, Seconds};
/// use haptic_analysis::{LoopOperator, Nondimensional, SampledLoop};
///
/// let damper = LoopOperator::new(Scheme::Exact, Order::new(1.0)?, Seconds(1e-3), 1e3)?;
/// let wall = |alpha| Nondimensional { alpha, beta: 1.0, delta: 0.0, gamma: 0.0 };
/// // Without damping of the device: α < 2β(2 − β)/(2 + β) = 2/3 at β = 1.
/// assert!(SampledLoop::new(wall(0.66), &damper, 0)?.verdict().stable);
/// assert!(!SampledLoop::new(wall(0.67), &damper, 0)?.verdict().stable);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
/// Source: O. Tokatlı, *Fractional Order Control in Haptics*, §4.2; the argument principle in place
/// of Routh and Hurwitz, so that irrational operators can be judged too.
#[derive(Clone, Copy, Debug)]
pub struct SampledLoop<'a> {
    pub(crate) characteristic: Characteristic<'a>,
    pub(crate) alpha: f64,
    pub(crate) beta: f64,
    /// Judged beside the zeros of F at w = 1.
    pub(crate) beside_rest: bool,
}

/// The verdict on a loop, stable or not, with its distance from the edge.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct StabilityVerdict {
    /// No zero of F in |w| ≤ 1. Not so on the boundary, where `unstable_poles` is `None`.
    pub stable: bool,
    /// Zeros of F in |w| < 1, each a pole with |z| > 1; `None` on the boundary, that is where
    /// |F| ≤ 1e-9·(n₁ + n₀) was met on the circle: a change of α by 1e-9 could take it there.
    pub unstable_poles: Option<usize>,
    /// The least |F|/(n₁ + n₀) met on the circle. It would take about this change of α, as a complex
    /// number, to reach the boundary. The margins proper are in [`Margins`](crate::Margins). Of a loop that
    /// [drifts](SampledLoop::beside_rest) over |v|^p too, as F falls towards rest.
    pub distance: f64,
    /// The angle at which that was, rad/sample.
    pub theta: f64,
    /// The largest |z| of a pole, that of a drift left out; for polynomial and rational operators with a characteristic
    /// polynomial of degree up to [`EIGENVALUE_DEGREE`](SampledLoop::EIGENVALUE_DEGREE).
    pub spectral_radius: Option<f64>,
}

/// |F|/(n₁ + n₀) at which a loop is on the boundary.
pub(crate) const BOUNDARY: f64 = 1e-9;

/// A stiffness or dissipation too small for its products to be normal numbers is none.
fn flushed(value: f64) -> f64 {
    const LEAST: f64 = 1e-200;
    if value < LEAST { 0.0 } else { value }
}

impl<'a> SampledLoop<'a> {
    /// Longest delay, samples.
    pub const DELAY_MAX: usize = ForcePath::DELAY_MAX;
    /// Largest degree for which a verdict takes the trouble to find all poles.
    pub const EIGENVALUE_DEGREE: usize = 64;

    /// Checks all parameters. An α or β below 1e-200 counts as 0.
    ///
    /// # Errors
    /// α, β, δ or γ negative or not finite; δ or γ too large for a [`SampledPlant`]; α or β above
    /// 1e12; d above the largest delay.
    pub fn new(
        parameters: Nondimensional,
        operator: &'a LoopOperator,
        delay: usize,
    ) -> Result<Self, AnalysisError> {
        let Nondimensional {
            alpha,
            beta,
            delta,
            gamma,
        } = parameters.checked()?;
        Self::with_plant(
            SampledPlant::new(delta, gamma)?.later(delay)?,
            alpha,
            beta,
            operator,
        )
    }

    /// The same on any plant, whose delay and lag are its own.
    ///
    /// # Errors
    /// α or β negative, not finite, or above 1e12.
    pub fn with_plant(
        plant: SampledPlant,
        alpha: f64,
        beta: f64,
        operator: &'a LoopOperator,
    ) -> Result<Self, AnalysisError> {
        for (what, value) in [("alpha", alpha), ("beta", beta)] {
            let kept = (0.0..=Nondimensional::WALL_MAX).contains(&value);
            range(what, value, kept, "from 0 to 1e12", "")?;
        }
        Ok(Self {
            characteristic: Characteristic {
                plant,
                operator,
                behind: None,
            },
            alpha: flushed(alpha),
            beta: flushed(beta),
            beside_rest: false,
        })
    }

    /// The plant.
    #[must_use]
    pub fn plant(&self) -> &SampledPlant {
        &self.characteristic.plant
    }

    /// F(e^(−jθ)).
    #[must_use]
    pub fn characteristic(&self, theta: f64) -> Complex<f64> {
        let node = self.characteristic.node(theta);
        node.value(self.alpha, self.beta) / node.operator.denominator.value
    }

    /// The certified verdict, by encirclement. Cost: about 100 responses of the operator, some ten
    /// more for each decade that F comes closer to zero, and n³ for the poles of a polynomial.
    #[must_use]
    pub fn verdict(&self) -> StabilityVerdict {
        let Count {
            zeros,
            closest,
            theta,
        } = self.count();
        StabilityVerdict {
            stable: zeros == Some(0),
            unstable_poles: zeros,
            distance: closest,
            theta,
            spectral_radius: self.spectral_radius(),
        }
    }

    /// The verdict alone, without looking for poles.
    #[must_use]
    pub fn is_stable(&self) -> bool {
        self.count().zeros == Some(0)
    }

    /// Nothing holds the device at rest: α + γ + βP(1) = 0, to what the boundary is known. F has a zero at w = 1 then,
    /// the pole of a position that stays where it is left, as behind a tissue that only dissipates.
    #[must_use]
    pub fn drifts(&self) -> bool {
        let scale = self.characteristic.plant.numerator_sum();
        self.characteristic(0.0).norm() <= BOUNDARY * scale
    }

    /// The same, judged beside the pole at rest if it [drifts](Self::drifts); any other loop as it is. The drift is no instability.
    #[must_use]
    pub fn beside_rest(mut self) -> Self {
        self.beside_rest = self.drifts();
        self
    }

    pub(crate) fn count(&self) -> Count {
        let circle = self.characteristic.circle();
        circle.count((self.alpha, self.beta), BOUNDARY, self.beside_rest)
    }

    /// F·D in powers of w, of w⁰ first, where P = N/D is polynomial or rational; its zeros are those
    /// of F, since D has none in |w| ≤ 1.
    #[must_use]
    pub fn characteristic_polynomial(&self) -> Option<Vec<f64>> {
        let (above, below) = self.characteristic.operator.polynomials()?;
        let plant = &self.characteristic.plant;
        let mut sum = multiply(plant.denominator(), below);
        let environment = (0..above.len().max(below.len())).map(|j| {
            let at = |polynomial: &[f64]| polynomial.get(j).copied().unwrap_or(0.0);
            self.alpha * at(below) + self.beta * at(above)
        });
        let environment: Vec<f64> = environment.collect();
        let fed_back = multiply(plant.numerator(), &environment);
        let lag = plant.path().whole_samples() + 1;
        sum.resize(sum.len().max(lag + fed_back.len()), 0.0);
        for (j, term) in fed_back.iter().enumerate() {
            sum[lag + j] += term;
        }
        Some(sum)
    }

    /// The verdict of the Schur–Cohn recursion, for polynomial and rational operators.
    #[must_use]
    pub fn jury(&self) -> Option<Jury> {
        self.characteristic_polynomial()
            .map(|polynomial| jury(&polynomial))
    }

    /// The poles in z, for polynomial and rational operators; poles at z = 0 left out.
    #[must_use]
    pub fn poles(&self) -> Option<Vec<Complex<f64>>> {
        poles(self.characteristic_polynomial()?)
    }

    fn spectral_radius(&self) -> Option<f64> {
        let polynomial = self.characteristic_polynomial()?;
        if polynomial.len() > Self::EIGENVALUE_DEGREE + 1 {
            return None;
        }
        let mut poles = poles(polynomial)?;
        if self.beside_rest {
            poles.sort_by(|a, b| (a - 1.0).norm().total_cmp(&(b - 1.0).norm()));
            poles.drain(..1);
        }
        let sizes = poles.iter().map(|pole| pole.norm());
        Some(sizes.fold(0.0, f64::max))
    }
}
