//! Surfaces that an environment lies behind: how deep a position is, and along which normal.
//!
//! ```text
//! p = max(0, depth(x))          penetration, m
//! f = n(x)·min(0, f_inner(p))   n unit normal into the environment; no friction
//! ```
//! | surface | depth | n |
//! |---|---|---|
//! | [`Plane`] | n·x − s | n |
//! | [`Ball`], solid | R − r | −(x − c)/r |
//! | [`Ball`], hollow | r − R | (x − c)/r |
//!
//! r = |x − c|. A ball is a disc with two axes and a sphere with three.

use crate::error::{Checks, LoopParameterError};
use crate::units::Metres;
use core::array;
use core::fmt::Debug;
use fracdiff::Real;
use nalgebra::SVector;

/// A surface, with an environment on its inner side.
pub trait Surface<F: Real, const D: usize>: Clone + Debug {
    /// Distance into the environment, m, negative outside. Not finite if the position is not.
    fn depth(&self, position_m: &SVector<F, D>) -> F;

    /// Depth and normal into the environment, of length 1 at most.
    fn touch(&self, position_m: &SVector<F, D>) -> (F, SVector<F, D>);
}

/// A plane; with two axes a straight line, with one a point.
///
/// ```text
/// depth = n·x − s        n unit normal into the environment, s its distance from 0 along n, m
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane<F, const D: usize> {
    normal: SVector<F, D>,
    surface: F,
}

impl<F: Real, const D: usize> Plane<F, D> {
    /// A plane with this direction into the environment, at `surface` from the origin along it.
    ///
    /// # Errors
    /// The direction must have a finite length above 0, the position must be finite.
    pub fn new(direction: [f64; D], surface: Metres) -> Result<Self, LoopParameterError> {
        let mut checks = Checks::default();
        let plane = Self::checked(direction, surface, &mut checks);
        checks.done().map(|()| plane)
    }

    /// The square of the length of a unit normal that was rounded, at least and at most.
    pub const UNIT: [f64; 2] = [1.0 - 2e-6, 1.0 + 2e-6];

    pub(crate) fn checked(direction: [f64; D], surface: Metres, checks: &mut Checks) -> Self {
        let length = libm::sqrt(direction.iter().map(|n| n * n).sum());
        checks.positive("contact normal", length, "m");
        checks.range("contact surface", surface.0, true, "finite", "m");
        Self {
            normal: SVector::from(direction.map(|n| F::from_f64(n / length))),
            surface: F::from_f64(surface.0),
        }
    }
}

impl<F: Real, const D: usize> Surface<F, D> for Plane<F, D> {
    #[inline]
    fn depth(&self, position_m: &SVector<F, D>) -> F {
        let mut depth = -self.surface;
        for (&n, &x) in self.normal.iter().zip(position_m.iter()) {
            depth += n * x;
        }
        depth
    }

    #[inline]
    fn touch(&self, position_m: &SVector<F, D>) -> (F, SVector<F, D>) {
        (self.depth(position_m), self.normal)
    }
}

/// A ball: a disc with two axes, a sphere with three. Solid, with the environment inside, or hollow, with the environment
/// around it.
///
/// ```text
/// r = |x − c|      solid: depth = R − r, n = −(x − c)/max(r, R/1024)      hollow: depth = r − R, n = (x − c)/max(r, R/1024)
/// ```
/// - *In the middle* a direction has no meaning. Within R/1024 of the centre the normal is therefore shorter than 1, and 0 at
///   the centre: the force is continuous there, bounded and without a direction of its own. A hollow ball is not felt there.
/// - *Curvature* is not felt: the environment knows how deep the hand is, not where. See [`Contact`](crate::Contact).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball<F, const D: usize> {
    centre: SVector<F, D>,
    radius: F,
    /// R/1024, m.
    core: F,
    hollow: bool,
}

impl<F: Real, const D: usize> Ball<F, D> {
    /// Smallest and largest radius, m: its square is a normal number in single precision too.
    pub const RADIUS_M: [f64; 2] = [1e-6, 1e6];

    /// The environment inside.
    ///
    /// # Errors
    /// A centre that is not finite, a radius outside 1 µm to 1000 km.
    pub fn solid(centre: [Metres; D], radius: Metres) -> Result<Self, LoopParameterError> {
        Self::new(centre, radius, false)
    }

    /// The environment around it: the hand is kept inside.
    ///
    /// # Errors
    /// As [`solid`](Self::solid).
    pub fn hollow(centre: [Metres; D], radius: Metres) -> Result<Self, LoopParameterError> {
        Self::new(centre, radius, true)
    }

    fn new(centre: [Metres; D], radius: Metres, hollow: bool) -> Result<Self, LoopParameterError> {
        let mut checks = Checks::default();
        let [least, most] = Self::RADIUS_M;
        let within = (least..=most).contains(&radius.0);
        let (what, allowed) = ("radius of the ball", "from 1e-6 to 1e6 {}");
        checks.range(what, radius.0, within, allowed, "m");
        let centre = centre.map(|x| checks.rounded("centre of the ball", x.0, "m"));
        let ball = Self {
            centre: SVector::from(centre),
            radius: F::from_f64(radius.0),
            core: F::from_f64(radius.0 / 1024.0),
            hollow,
        };
        checks.done().map(|()| ball)
    }

    /// The length of the normal at this depth, m: 1, but within R/1024 of the centre the share of that which is left.
    #[must_use]
    pub fn normal_length(&self, depth: F) -> F {
        let distance = if self.hollow {
            self.radius + depth
        } else {
            self.radius - depth
        };
        if distance < self.core {
            distance / self.core
        } else {
            F::ONE
        }
    }

    /// x − c, and its length.
    #[inline]
    fn off_centre(&self, position_m: &SVector<F, D>) -> (SVector<F, D>, F) {
        let offset: SVector<F, D> =
            SVector::from(array::from_fn(|axis| position_m[axis] - self.centre[axis]));
        let mut square = F::ZERO;
        for &axis in &offset {
            square += axis * axis;
        }
        (offset, square.sqrt())
    }

    #[inline]
    fn depth_at(&self, distance: F) -> F {
        if self.hollow {
            distance - self.radius
        } else {
            self.radius - distance
        }
    }
}

impl<F: Real, const D: usize> Surface<F, D> for Ball<F, D> {
    #[inline]
    fn depth(&self, position_m: &SVector<F, D>) -> F {
        self.depth_at(self.off_centre(position_m).1)
    }

    #[inline]
    fn touch(&self, position_m: &SVector<F, D>) -> (F, SVector<F, D>) {
        let (offset, distance) = self.off_centre(position_m);
        let length = if distance < self.core {
            self.core
        } else {
            distance
        };
        // Into the environment.
        let length = if self.hollow { length } else { -length };
        let normal = array::from_fn(|axis| offset[axis] / length);
        (self.depth_at(distance), SVector::from(normal))
    }
}

/// Kind of a [`Shape`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShapeKind {
    /// A plane, with its unit normal for a place.
    Plane,
    /// A ball with the environment inside.
    Ball,
    /// A ball with the environment around it.
    HollowBall,
}

/// A [`Shape`] as its numbers, of which [`Shape::of`] makes the same one, bit for bit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeNumbers<F, const D: usize> {
    /// Kind of the shape, by which the numbers are read.
    pub kind: ShapeKind,
    /// The unit normal of a plane, into the environment; the centre of a ball, m.
    pub place: [F; D],
    /// The distance of a plane from 0 along its normal, the radius of a ball, m.
    pub distance: F,
}

/// A surface whose kind is chosen at run time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape<F, const D: usize> {
    /// A plane, or with fewer axes a line or a point.
    Plane(Plane<F, D>),
    /// A ball, solid or hollow.
    Ball(Ball<F, D>),
}

impl<F: Real, const D: usize> Shape<F, D> {
    /// The shape of these numbers. A normal is used unchanged: to make it one again would round it
    /// again.
    ///
    /// # Errors
    /// A normal that is not of length 1; numbers of [`Plane::new`] or [`Ball::solid`] outside their ranges.
    pub fn of(numbers: &ShapeNumbers<F, D>) -> Result<Self, LoopParameterError> {
        let place = numbers.place.map(Real::to_f64);
        let distance = Metres(numbers.distance.to_f64());
        let ball = |hollow| Ball::new(place.map(Metres), distance, hollow).map(Self::Ball);
        match numbers.kind {
            ShapeKind::Ball => ball(false),
            ShapeKind::HollowBall => ball(true),
            ShapeKind::Plane => {
                let mut checks = Checks::default();
                let [least, most] = Plane::<F, D>::UNIT;
                let square: f64 = place.iter().map(|n| n * n).sum();
                let unit = (least..=most).contains(&square);
                checks.range("squared length of the normal", square, unit, "1", "");
                checks.range("contact surface", distance.0, true, "finite", "m");
                let (normal, surface) = (SVector::from(numbers.place), numbers.distance);
                let plane = Self::Plane(Plane { normal, surface });
                checks.done().map(|()| plane)
            }
        }
    }

    /// The numbers from which [`of`](Self::of) makes the same shape.
    #[must_use]
    pub fn numbers(&self) -> ShapeNumbers<F, D> {
        let (kind, place, distance) = match self {
            Self::Plane(plane) => (ShapeKind::Plane, plane.normal, plane.surface),
            Self::Ball(ball) => {
                let kind = if !ball.hollow {
                    ShapeKind::Ball
                } else {
                    ShapeKind::HollowBall
                };
                (kind, ball.centre, ball.radius)
            }
        };
        ShapeNumbers {
            kind,
            place: place.into(),
            distance,
        }
    }

    /// The length of the normal at this depth, m: the share of the inner force that acts; 1 but next to the centre of a [`Ball`].
    #[must_use]
    pub fn normal_length(&self, depth: F) -> F {
        match self {
            Self::Plane(_) => F::ONE,
            Self::Ball(ball) => ball.normal_length(depth),
        }
    }
}

impl<F: Real, const D: usize> Surface<F, D> for Shape<F, D> {
    #[inline]
    fn depth(&self, position_m: &SVector<F, D>) -> F {
        match self {
            Self::Plane(plane) => plane.depth(position_m),
            Self::Ball(ball) => ball.depth(position_m),
        }
    }

    #[inline]
    fn touch(&self, position_m: &SVector<F, D>) -> (F, SVector<F, D>) {
        match self {
            Self::Plane(plane) => plane.touch(position_m),
            Self::Ball(ball) => ball.touch(position_m),
        }
    }
}
