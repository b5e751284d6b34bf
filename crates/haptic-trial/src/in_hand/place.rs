//! A law whose surface lies somewhere else than at 0: it hears positions from there.

use haptic_loop::Environment;
use nalgebra::Vector1;

/// A law behind a surface.
pub trait Surfaced {
    /// Place of its surface, m.
    fn surface_m(&self) -> f64;
}

/// A law behind a surface, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed<E> {
    law: E,
    surface_m: f64,
}

impl<E> Placed<E> {
    /// The law, with what is 0 for it at this place.
    pub const fn new(law: E, surface_m: f64) -> Self {
        Self { law, surface_m }
    }

    /// A position as the law hears it.
    fn behind(&self, position_m: &Vector1<f64>) -> Vector1<f64> {
        Vector1::new(position_m[0] - self.surface_m)
    }
}

impl<E> Surfaced for Placed<E> {
    fn surface_m(&self) -> f64 {
        self.surface_m
    }
}

impl<E: Environment<f64, 1>> Environment<f64, 1> for Placed<E> {
    type History = E::History;

    fn at_rest(&self) -> E::History {
        self.law.at_rest()
    }

    fn settle(&self, history: &mut E::History, position_m: &Vector1<f64>) {
        self.law.settle(history, &self.behind(position_m));
    }

    #[inline]
    fn force(&self, history: &E::History, position_m: &Vector1<f64>) -> Vector1<f64> {
        self.law.force(history, &self.behind(position_m))
    }

    #[inline]
    fn advance(&self, history: &mut E::History, position_m: &Vector1<f64>) {
        self.law.advance(history, &self.behind(position_m));
    }
}
