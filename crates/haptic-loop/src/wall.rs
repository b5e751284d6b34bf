//! A spring and a fractional damper on one axis, with or without a surface.

use crate::environment::Gains;
use crate::error::Checks;
use crate::loading::DepthMap;
use crate::surface::Plane;
use crate::units::Metres;
use crate::{Contact, Environment, LoopParameterError, SpringDamper};
use fracdiff::{Differintegrator, Real};
use nalgebra::SVector;

/// A wall whose kind is chosen at run time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wall<F, O> {
    /// Pushes and pulls, as theory assumes.
    Linear(SpringDamper<F, O>),
    /// Pushes behind its surface and never pulls.
    OneSided(Contact<F, SpringDamper<F, O>, 1>),
}

/// All of a [`Wall`] but its operator, checked and rounded: the operator, up to kilobytes of it, is then moved once, into
/// its place.
#[derive(Clone, Copy, Debug)]
pub struct WallShape<F> {
    gains: Gains<F>,
    plane: Option<Plane<F, 1>>,
    map: Option<DepthMap<F>>,
}

impl<F: Real> WallShape<F> {
    /// A wall that makes no force.
    pub const NONE: Self = Self {
        gains: Gains::NONE,
        plane: None,
        map: None,
    };

    /// # Errors
    /// As [`Wall::new`].
    #[inline(never)]
    pub fn new(
        stiffness: f64,
        dissipation: f64,
        surface: Option<Metres>,
    ) -> Result<Self, LoopParameterError> {
        let mut checks = Checks::default();
        let shape = Self {
            gains: Gains::new(stiffness, dissipation, &mut checks),
            plane: surface.map(|surface| Plane::checked([1.0], surface, &mut checks)),
            map: None,
        };
        checks.done().map(|()| shape)
    }

    /// Adds a map of depth, which a wall without a surface ignores.
    #[must_use]
    pub fn with_depth_map(self, map: Option<DepthMap<F>>) -> Self {
        Self { map, ..self }
    }
}

impl<F: Real, O: Differintegrator<F>> Wall<F, O> {
    /// K in N/m and B in N·s^μ/m; with a surface the wall begins there and is one-sided.
    ///
    /// # Errors
    /// As [`SpringDamper::new`] and [`Contact::at`].
    pub fn new(
        stiffness: f64,
        dissipation: f64,
        operator: O,
        surface: Option<Metres>,
    ) -> Result<Self, LoopParameterError> {
        WallShape::new(stiffness, dissipation, surface).map(|shape| Self::of(shape, operator))
    }

    /// Around a shape that is checked already.
    pub fn of(shape: WallShape<F>, operator: O) -> Self {
        match shape.plane {
            Some(plane) => {
                let inner = SpringDamper::of(shape.gains, operator);
                Self::OneSided(Contact::mapped(plane, shape.map, inner))
            }
            None => Self::Linear(SpringDamper::of(shape.gains, operator)),
        }
    }

    /// Becomes a wall around another shape, and gives its operator to be changed: in its place, on a stack without room for
    /// another one. A wall of the other kind begins with the operator that `other` makes.
    pub fn reshape(&mut self, shape: WallShape<F>, other: impl FnOnce() -> O) -> &mut O {
        let is_one_sided = matches!(self, Self::OneSided(_));
        if is_one_sided != shape.plane.is_some() {
            self.begin(shape, other);
        }
        match self {
            Self::Linear(wall) => wall.reshape(shape.gains),
            Self::OneSided(contact) => {
                let inner = contact.reshape(shape.plane, shape.map);
                inner.reshape(shape.gains)
            }
        }
    }

    /// Makes it a wall of the other kind, in a function of its own, so that what that needs of the stack is free again; each kind written
    /// in its place, not by way of [`of`](Self::of), which would move the operator once more.
    #[inline(never)]
    fn begin(&mut self, shape: WallShape<F>, operator: impl FnOnce() -> O) {
        match shape.plane {
            Some(plane) => {
                let inner = SpringDamper::of(shape.gains, operator());
                *self = Self::OneSided(Contact::mapped(plane, shape.map, inner));
            }
            None => *self = Self::Linear(SpringDamper::of(shape.gains, operator())),
        }
    }

    /// The operator D^μ of the dissipation.
    pub const fn operator(&self) -> &O {
        match self {
            Self::Linear(wall) => wall.operator(),
            Self::OneSided(contact) => contact.inner().operator(),
        }
    }
}

impl<F: Real, O: Differintegrator<F>> Environment<F, 1> for Wall<F, O> {
    type History = [O::History; 1];

    fn at_rest(&self) -> Self::History {
        // The surface has no past. Not through either kind: each would move the history, kilobytes, once more.
        [self.operator().at_rest()]
    }

    fn rest(&self, history: &mut Self::History) {
        self.operator().rest(&mut history[0]);
    }

    /// A linear wall is felt wherever the device is; a one-sided one is entered from outside.
    fn settle(&self, history: &mut Self::History, position_m: &SVector<F, 1>) {
        match self {
            Self::Linear(wall) => wall.settle(history, position_m),
            Self::OneSided(_) => {}
        }
    }

    #[inline]
    fn force(&self, history: &Self::History, position_m: &SVector<F, 1>) -> SVector<F, 1> {
        match self {
            Self::Linear(wall) => wall.force(history, position_m),
            Self::OneSided(contact) => contact.force(history, position_m),
        }
    }

    #[inline]
    fn force_and_input(
        &self,
        history: &Self::History,
        position_m: &SVector<F, 1>,
    ) -> (SVector<F, 1>, SVector<F, 1>) {
        match self {
            Self::Linear(wall) => wall.force_and_input(history, position_m),
            Self::OneSided(contact) => contact.force_and_input(history, position_m),
        }
    }

    #[inline]
    fn advance_input(&self, history: &mut Self::History, input: &SVector<F, 1>) {
        // Behind either kind is the same operator, and the input is its own.
        self.operator().advance(&mut history[0], input[0]);
    }

    #[inline]
    fn advance(&self, history: &mut Self::History, position_m: &SVector<F, 1>) {
        match self {
            Self::Linear(wall) => wall.advance(history, position_m),
            Self::OneSided(contact) => contact.advance(history, position_m),
        }
    }
}
