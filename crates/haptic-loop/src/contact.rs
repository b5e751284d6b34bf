//! One-sided environments: behind a surface, pushing but never pulling.

use crate::environment::Environment;
use crate::error::LoopParameterError;
use crate::loading::DepthMap;
use crate::surface::{Plane, Surface};
use crate::units::Metres;
use core::array;
use fracdiff::Real;
use nalgebra::SVector;

/// An environment behind a surface, a plane unless another one is given: the environment pushes but
/// never pulls.
///
/// ```text
/// p = max(0, depth(x))           penetration, m; of a plane n·x − s
/// f = n·min(0, f_inner(e(p)))    the inner environment's force on e(p), without its pull; n unit normal into it
/// ```
/// - *Map of depth*: e(p) = p, unless [a map is given](Self::with_depth_map).
/// - *One scalar operator*: the inner environment sees the penetration, zero outside, so its history forgets nothing and gains
///   nothing while the device is away. With one degree of freedom n = +1.
/// - *Round a ball* the history is that of the penetration, wherever it was: a hand that slides along at one depth feels
///   matter that relaxes as if it stood still. Real matter is fresh where the hand has not been yet.
/// - *No friction*: the force is along the normal; sliding costs nothing.
/// - *Continuous* at a first contact: p grows from 0. On a return it is too for orders up to 1, whose memory of an earlier
///   touch only pulls; above 1 that memory may push at once.
///
/// ```
/// use fracdiff::{Order, Seconds, ShortMemory};
/// use haptic_loop::units::Metres;
/// use haptic_loop::{Ball, Contact, Environment, SpringDamper};
/// use nalgebra::vector;
///
/// let operator = ShortMemory::<f64, 64>::new(Order::new(0.5)?, Seconds(1e-3))?;
/// let tissue = SpringDamper::new(500.0, 3.0, operator)?;
/// let floor = Contact::new([0.0, -1.0], Metres(0.0), tissue.clone())?;
/// let history = Environment::<f64, 2>::at_rest(&floor);
/// assert_eq!(floor.force(&history, &vector![0.3, 0.1]), vector![0.0, 0.0]); // above it
/// assert!(floor.force(&history, &vector![0.3, -1e-3])[1] > 0.5); // pushed up, never pulled
/// // A disc of 20 mm about the origin, 1 mm deep from the right: pushed to the right.
/// let disc = Contact::behind(Ball::solid([Metres(0.0); 2], Metres(0.02))?, tissue);
/// assert!(disc.force(&history, &vector![0.019, 0.0])[0] > 0.5);
/// # Ok::<(), haptic_loop::LoopParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact<F, E, const D: usize, S = Plane<F, D>> {
    inner: E,
    surface: S,
    map: Option<DepthMap<F>>,
}

impl<F: Real, E: Environment<F, 1>> Contact<F, E, 1> {
    /// A surface at this position, with the environment on its positive side.
    ///
    /// # Errors
    /// The position must be finite.
    pub fn at(surface: Metres, inner: E) -> Result<Self, LoopParameterError> {
        Self::new([1.0], surface, inner)
    }
}

impl<F: Real, E: Environment<F, 1>, const D: usize> Contact<F, E, D> {
    /// A plane with the given direction into the environment, of any length above 0, at `surface`
    /// from the origin along that direction.
    ///
    /// # Errors
    /// The direction must have a finite length above 0, the position must be finite.
    pub fn new(direction: [f64; D], surface: Metres, inner: E) -> Result<Self, LoopParameterError> {
        Plane::new(direction, surface).map(|plane| Self::behind(plane, inner))
    }

    /// Behind another plane with another map, and its environment to be changed.
    pub(crate) fn reshape(
        &mut self,
        plane: Option<Plane<F, D>>,
        map: Option<DepthMap<F>>,
    ) -> &mut E {
        if let Some(plane) = plane {
            self.surface = plane;
        }
        self.map = map;
        &mut self.inner
    }
}

impl<F: Real, E: Environment<F, 1>, const D: usize, S: Surface<F, D>> Contact<F, E, D, S> {
    /// The environment behind any surface.
    pub const fn behind(surface: S, inner: E) -> Self {
        Self::mapped(surface, None, inner)
    }

    #[inline]
    pub(crate) const fn mapped(surface: S, map: Option<DepthMap<F>>, inner: E) -> Self {
        Self {
            inner,
            surface,
            map,
        }
    }

    /// Adds a depth map, for shapes other than a slab: the environment receives e
    /// of the penetration.
    #[must_use]
    pub fn with_depth_map(self, map: Option<DepthMap<F>>) -> Self {
        Self { map, ..self }
    }

    /// The environment behind the surface.
    pub const fn inner(&self) -> &E {
        &self.inner
    }

    /// The surface in front of the environment.
    pub const fn surface(&self) -> &S {
        &self.surface
    }
}

impl<F: Real, E: Environment<F, 1>, const D: usize, S: Surface<F, D>> Contact<F, E, D, S> {
    /// The force of the environment behind, N: at most 0, out of it; and its input.
    #[inline]
    fn push(&self, history: &E::History, depth: F) -> (F, F) {
        let depth = self.penetration(depth);
        let (inner, input) = self.inner.force_and_input(history, &depth);
        // Outside nothing pushes, whatever the past; inside nothing pulls. A NaN stays a NaN.
        let outside = depth[0] <= F::ZERO || inner[0] > F::ZERO;
        (if outside { F::ZERO } else { inner[0] }, input[0])
    }

    /// e(p) of a depth, m.
    #[inline]
    fn penetration(&self, depth: F) -> SVector<F, 1> {
        SVector::from([if depth > F::ZERO {
            self.map.map_or(depth, |map| map.at(depth))
        } else if depth.is_finite() {
            F::ZERO
        } else {
            // Even −∞, which is outside, must reach the safety chain.
            F::from_f64(f64::NAN)
        }])
    }
}

impl<F: Real, E: Environment<F, 1>, const D: usize, S: Surface<F, D>> Environment<F, D>
    for Contact<F, E, D, S>
{
    type History = E::History;

    fn at_rest(&self) -> E::History {
        self.inner.at_rest()
    }

    #[inline]
    fn force(&self, history: &E::History, position_m: &SVector<F, D>) -> SVector<F, D> {
        self.force_and_input(history, position_m).0
    }

    #[inline]
    fn force_and_input(
        &self,
        history: &E::History,
        position_m: &SVector<F, D>,
    ) -> (SVector<F, D>, SVector<F, D>) {
        let (depth, normal) = self.surface.touch(position_m);
        let (push, input) = self.push(history, depth);
        let force = SVector::from(array::from_fn(|axis| normal[axis] * push));
        (force, on_first_axis(input))
    }

    #[inline]
    fn advance_input(&self, history: &mut E::History, input: &SVector<F, D>) {
        self.inner.advance_input(history, &[input[0]].into());
    }

    /// All of the push: where the normal fades, as in the middle of a ball, the next place has it.
    fn starting_force(&self, history: &E::History, position_m: &SVector<F, D>) -> SVector<F, D> {
        on_first_axis(self.push(history, self.surface.depth(position_m)).0)
    }

    #[inline]
    fn advance(&self, history: &mut E::History, position_m: &SVector<F, D>) {
        let depth = self.penetration(self.surface.depth(position_m));
        self.inner.advance(history, &depth);
    }
}

/// A number of all axes together, where there is an element for each.
#[inline]
fn on_first_axis<F: Real, const D: usize>(number: F) -> SVector<F, D> {
    let mut all = SVector::from([F::ZERO; D]);
    all[0] = number;
    all
}

/// An environment on one axis with only its force clamped, so it pushes and never pulls.
///
/// ```text
/// f = min(0, f_inner(x))         x signed: below 0 in front of the surface
/// ```
/// - *One nonlinearity*: the memory always receives x, whereas a [`Contact`] feeds it max(0, x) and
///   also clamps the force. So what is proved of a loop with one static map of slope 0 to 1 is
///   proved of what runs.
/// - *In front of the surface* it may push already: a spring and damper from x = −(B/K)·v on, v the speed of the approach,
///   and one of long memory from farther out. Without a spring it would push anywhere.
///
/// ```
/// use fracdiff::{Order, Seconds, ShortMemory};
/// use haptic_loop::{Environment, Pushing, SpringDamper};
/// use nalgebra::vector;
///
/// let operator = ShortMemory::<f64, 64>::new(Order::new(1.0)?, Seconds(1e-3))?;
/// let wall = Pushing::new(SpringDamper::new(500.0, 3.0, operator)?, false);
/// let history = wall.at_rest();
/// assert!(wall.force(&history, &vector![1e-3])[0] < -3.0); // pushed out
/// assert_eq!(wall.force(&history, &vector![-1e-3]), vector![0.0]); // never pulled in
/// # Ok::<(), haptic_loop::LoopParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pushing<E> {
    inner: E,
    may_pull: bool,
}

impl<E> Pushing<E> {
    /// The environment, clamped unless `may_pull`, so the clamp can be chosen at run time.
    pub const fn new(inner: E, may_pull: bool) -> Self {
        Self { inner, may_pull }
    }
}

impl<F: Real, E: Environment<F, 1>> Environment<F, 1> for Pushing<E> {
    type History = E::History;

    fn at_rest(&self) -> E::History {
        self.inner.at_rest()
    }

    fn settle(&self, history: &mut E::History, position_m: &SVector<F, 1>) {
        self.inner.settle(history, position_m);
    }

    #[inline]
    fn force(&self, history: &E::History, position_m: &SVector<F, 1>) -> SVector<F, 1> {
        let force = self.inner.force(history, position_m);
        // A force that is not finite must reach the safety chain.
        let pulls = force[0] > F::ZERO && force[0].is_finite();
        if pulls && !self.may_pull {
            SVector::from([F::ZERO])
        } else {
            force
        }
    }

    #[inline]
    fn advance(&self, history: &mut E::History, position_m: &SVector<F, 1>) {
        self.inner.advance(history, position_m);
    }
}
