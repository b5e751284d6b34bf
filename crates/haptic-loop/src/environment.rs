//! Virtual environments: control laws from position to force.

use crate::error::{Checks, ParameterError};
use crate::units::Metres;
use core::array;
use core::fmt::Debug;
use fracdiff::{Differintegrator, Real};
use nalgebra::SVector;

/// A virtual environment with D degrees of freedom: position in, force on the device out.
///
/// - *Units*: position m, force N. *Sign*: a positive displacement into the environment is pushed
///   back, f = −H x.
/// - *Two phases*: [`force`](Self::force) costs the same whatever the memory and leaves the history
///   alone; [`advance`](Self::advance) takes the position into the history after the force is sent.
/// - *Not finite*: a position that is not finite makes a force that is not finite, which the safety
///   chain turns into a fault. Nothing here panics.
///
/// ```
/// use haptic_loop::{Environment, SpringDamper};
/// use fracdiff::{Order, Seconds, ShortMemory};
/// use nalgebra::{Vector1, vector};
///
/// let damper = ShortMemory::<f64, 8>::new(Order::new(1.0)?, Seconds(1e-3))?;
/// let wall = SpringDamper::new(100.0, 2.0, damper)?;
/// let mut history = Environment::<f64, 1>::at_rest(&wall);
/// let x: Vector1<f64> = vector![1e-3];
/// // From rest to 1 mm in 1 ms is 1 m/s: 0.1 N of the spring, 2 N of the damper.
/// assert!((wall.force(&history, &x)[0] + 2.1).abs() < 1e-12);
/// wall.advance(&mut history, &x);
/// assert!((wall.force(&history, &x)[0] + 0.1).abs() < 1e-12);
/// # Ok::<(), haptic_loop::ParameterError>(())
/// ```
pub trait Environment<F: Real, const D: usize> {
    /// The motion so far, as far as the environment remembers it.
    type History: Clone + Debug;

    /// The history of a device that always rested at zero.
    fn at_rest(&self) -> Self::History;

    /// Makes a history that of a device that always rested at zero, as [`at_rest`](Self::at_rest), in its place where an
    /// environment can: for a stack without room for another one.
    fn rest(&self, history: &mut Self::History) {
        *history = self.at_rest();
    }

    /// The force on the device at this position, N.
    fn force(&self, history: &Self::History, position_m: &SVector<F, D>) -> SVector<F, D>;

    /// Takes this tick's position into the history.
    fn advance(&self, history: &mut Self::History, position_m: &SVector<F, D>);
}

/// A spring and a fractional damper, the same on each axis.
///
/// ```text
/// f = −(K·x + B·D^μ x)        K N/m ≥ 0,   B N·s^μ/m ≥ 0,   μ the operator's order
/// ```
/// At μ = 1 a spring and a viscous damper, at μ = 0 two springs, at μ = 2 a spring and a mass.
/// *Cost*: `force` two multiply-adds an axis, `advance` that of the operator.
///
/// Source: O. Tokatlı, *Fractional Order Control in Haptics*, eq. 3.8.
///
/// ```
/// use fracdiff::{Order, Seconds, ShortMemory};
/// use haptic_loop::SpringDamper;
///
/// let operator = ShortMemory::<f32, 256>::new(Order::new(0.5)?, Seconds(1e-3))?;
/// let wall = SpringDamper::new(500.0, 3.0, operator.clone())?; // K = 500 N/m, B = 3 N·s^0.5/m
/// let refused = SpringDamper::new(-1.0, 3.0, operator).unwrap_err();
/// assert_eq!(refused.to_string(), "stiffness -1 N/m is not at least 0 N/m");
/// # let _ = wall;
/// # Ok::<(), haptic_loop::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringDamper<F, O> {
    stiffness: F,
    dissipation: F,
    operator: O,
}

/// K and B of a [`SpringDamper`], checked and rounded.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gains<F> {
    stiffness: F,
    dissipation: F,
}

impl<F: Real> Gains<F> {
    pub(crate) const NONE: Self = Self {
        stiffness: F::ZERO,
        dissipation: F::ZERO,
    };

    /// Refuses as [`SpringDamper::new`].
    pub(crate) fn new(stiffness: f64, dissipation: f64, checks: &mut Checks) -> Self {
        checks.not_negative("stiffness", stiffness, "N/m");
        checks.not_negative("dissipation", dissipation, "N·s^μ/m");
        Self {
            stiffness: checks.rounded("stiffness", stiffness, "N/m"),
            dissipation: checks.rounded("dissipation", dissipation, "N·s^μ/m"),
        }
    }
}

impl<F: Real, O: Differintegrator<F>> SpringDamper<F, O> {
    /// K in N/m and B in N·s^μ/m. Plain numbers, because the unit of B depends on μ.
    ///
    /// # Errors
    /// Both must be finite and at least zero, in the precision of the loop too.
    pub fn new(stiffness: f64, dissipation: f64, operator: O) -> Result<Self, ParameterError> {
        let mut checks = Checks::default();
        let gains = Gains::new(stiffness, dissipation, &mut checks);
        checks.done().map(|()| Self::of(gains, operator))
    }

    #[inline]
    pub(crate) fn of(gains: Gains<F>, operator: O) -> Self {
        Self {
            stiffness: gains.stiffness,
            dissipation: gains.dissipation,
            operator,
        }
    }

    /// D^μ.
    pub const fn operator(&self) -> &O {
        &self.operator
    }

    /// With other gains, and its operator to be changed.
    pub(crate) const fn reshape(&mut self, gains: Gains<F>) -> &mut O
    where
        F: Copy,
    {
        self.stiffness = gains.stiffness;
        self.dissipation = gains.dissipation;
        &mut self.operator
    }
}

impl<F: Real, O: Differintegrator<F>, const D: usize> Environment<F, D> for SpringDamper<F, O> {
    type History = [O::History; D];

    fn at_rest(&self) -> Self::History {
        array::from_fn(|_| self.operator.at_rest())
    }

    #[inline]
    fn force(&self, history: &Self::History, position_m: &SVector<F, D>) -> SVector<F, D> {
        SVector::from(array::from_fn(|axis| {
            let x = position_m[axis];
            // f = −(K·x + B·D^μ x)
            -(self.stiffness * x + self.dissipation * self.operator.output(&history[axis], x))
        }))
    }

    #[inline]
    fn advance(&self, history: &mut Self::History, position_m: &SVector<F, D>) {
        for (history, &x) in history.iter_mut().zip(position_m.iter()) {
            self.operator.advance(history, x);
        }
    }
}

/// A half-space that pushes but never pulls: another environment behind a plane.
///
/// ```text
/// p = max(0, n·x − s)          penetration, m; n unit normal into the half-space, s its distance from 0
/// f = n·min(0, f_inner(p))     the inner environment's force on p, without its pull
/// ```
/// The inner environment sees the penetration: zero outside, so its history forgets nothing and gains
/// nothing while the device is away. With one degree of freedom n = +1.
///
/// ```
/// use fracdiff::{Order, Seconds, ShortMemory};
/// use haptic_loop::units::Metres;
/// use haptic_loop::{Contact, Environment, SpringDamper};
/// use nalgebra::vector;
///
/// let operator = ShortMemory::<f64, 64>::new(Order::new(0.5)?, Seconds(1e-3))?;
/// let floor = Contact::new([0.0, -1.0], Metres(0.0), SpringDamper::new(500.0, 3.0, operator)?)?;
/// let history = Environment::<f64, 2>::at_rest(&floor);
/// assert_eq!(floor.force(&history, &vector![0.3, 0.1]), vector![0.0, 0.0]); // above it
/// assert!(floor.force(&history, &vector![0.3, -1e-3])[1] > 0.5); // pushed up, never pulled
/// # Ok::<(), haptic_loop::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact<F, E, const D: usize> {
    inner: E,
    normal: SVector<F, D>,
    surface: F,
}

/// The surface of a [`Contact`], checked and rounded.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plane<F, const D: usize> {
    normal: SVector<F, D>,
    surface: F,
}

impl<F: Real, const D: usize> Plane<F, D> {
    /// Refuses as [`Contact::new`].
    pub(crate) fn new(direction: [f64; D], surface: Metres, checks: &mut Checks) -> Self {
        let length = libm::sqrt(direction.iter().map(|n| n * n).sum());
        checks.positive("length of the contact's normal", length, "m");
        checks.range("contact surface", surface.0, true, "finite", "m");
        Self {
            normal: SVector::from(direction.map(|n| F::from_f64(n / length))),
            surface: F::from_f64(surface.0),
        }
    }
}

impl<F: Real, E: Environment<F, 1>> Contact<F, E, 1> {
    /// A surface at this position, the environment above it.
    ///
    /// # Errors
    /// The position must be finite.
    pub fn at(surface: Metres, inner: E) -> Result<Self, ParameterError> {
        Self::new([1.0], surface, inner)
    }
}

impl<F: Real, E: Environment<F, 1>, const D: usize> Contact<F, E, D> {
    /// A plane with the given direction into the environment, of any length above 0, at `surface`
    /// from the origin along that direction.
    ///
    /// # Errors
    /// The direction must have a finite length above 0, the position must be finite.
    pub fn new(direction: [f64; D], surface: Metres, inner: E) -> Result<Self, ParameterError> {
        let mut checks = Checks::default();
        let plane = Plane::new(direction, surface, &mut checks);
        checks.done().map(|()| Self::of(plane, inner))
    }

    #[inline]
    pub(crate) fn of(plane: Plane<F, D>, inner: E) -> Self {
        Self {
            inner,
            normal: plane.normal,
            surface: plane.surface,
        }
    }

    /// The environment behind the surface.
    pub const fn inner(&self) -> &E {
        &self.inner
    }

    /// Behind another surface, and its environment to be changed.
    pub(crate) fn reshape(&mut self, plane: Option<Plane<F, D>>) -> &mut E {
        if let Some(plane) = plane {
            self.normal = plane.normal;
            self.surface = plane.surface;
        }
        &mut self.inner
    }

    /// p, m.
    #[inline]
    fn penetration(&self, position_m: &SVector<F, D>) -> SVector<F, 1> {
        let mut depth = -self.surface;
        for (&n, &x) in self.normal.iter().zip(position_m.iter()) {
            depth += n * x;
        }
        SVector::from([if !depth.is_finite() {
            // Even −∞, which is outside, must reach the safety chain.
            F::from_f64(f64::NAN)
        } else if depth < F::ZERO {
            F::ZERO
        } else {
            depth
        }])
    }
}

impl<F: Real, E: Environment<F, 1>, const D: usize> Environment<F, D> for Contact<F, E, D> {
    type History = E::History;

    fn at_rest(&self) -> E::History {
        self.inner.at_rest()
    }

    #[inline]
    fn force(&self, history: &E::History, position_m: &SVector<F, D>) -> SVector<F, D> {
        let depth = self.penetration(position_m);
        let inner = self.inner.force(history, &depth)[0];
        // Outside nothing pushes, whatever the past; inside nothing pulls. A NaN stays a NaN.
        let push = if depth[0] <= F::ZERO || inner > F::ZERO {
            F::ZERO
        } else {
            inner
        };
        SVector::from(array::from_fn(|axis| self.normal[axis] * push))
    }

    #[inline]
    fn advance(&self, history: &mut E::History, position_m: &SVector<F, D>) {
        self.inner.advance(history, &self.penetration(position_m));
    }
}
