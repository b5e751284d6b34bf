//! What is touched: a shape, and the law behind its surface.

use crate::document::advice::parameter;
use crate::document::failure::Failure;
use crate::document::named::Named;
use crate::experiment::touch::keys::{TOUCH_CENTRE, TOUCH_NORMAL, TOUCH_RADIUS, TOUCH_SURFACE};
use crate::judge::modelled_tissue::{TissuePiece, operator};
use fracdiff::{Operator, Order, Scheme, Seconds};
use haptic_loop::units::Metres;
use haptic_loop::{Ball, Contact, Plane, Shape, SpringDamper};
use haptic_tissue::Model;

/// Kinds of shapes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ShapeName {
    /// A plane.
    Plane,
    /// A ball.
    Ball,
    /// A room in the form of a ball.
    HollowBall,
}

impl Named for ShapeName {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Plane, "plane", "A plane"),
        (
            Self::Ball,
            "ball",
            "A disc with two axes, a sphere with three",
        ),
        (Self::HollowBall, "hollow-ball", "A room inside a ball"),
    ];
}

/// A shape.
#[derive(Clone, Debug, PartialEq)]
pub enum TouchShape {
    /// A plane.
    Plane {
        /// Direction into it, a number an axis, of any length above 0.
        normal: Vec<f64>,
        /// Its distance from 0 along that, m.
        surface_m: f64,
    },
    /// A ball.
    Ball {
        /// Its centre, a number an axis, m.
        centre_m: Vec<f64>,
        /// Its radius, m.
        radius_m: f64,
        /// The matter is around it, not inside.
        hollow: bool,
    },
}

impl TouchShape {
    /// For so many axes as it is asked for.
    ///
    /// # Errors
    /// Another number of axes, a size outside its range.
    pub(super) fn of<const D: usize>(&self) -> Result<Shape<f64, D>, Failure> {
        match self {
            Self::Plane { normal, surface_m } => {
                let normal = per_axis("normal", normal)?;
                let plane = Plane::new(normal, Metres(*surface_m)).map_err(|error| {
                    Failure::input_with_advice(
                        error,
                        format_args!("change {TOUCH_NORMAL} or {TOUCH_SURFACE}"),
                    )
                })?;
                Ok(Shape::Plane(plane))
            }
            Self::Ball {
                centre_m,
                radius_m,
                hollow,
            } => {
                let centre = per_axis("centre_m", centre_m)?.map(Metres);
                let ball = match hollow {
                    false => Ball::solid(centre, Metres(*radius_m)),
                    true => Ball::hollow(centre, Metres(*radius_m)),
                };
                let ball = ball.map_err(|error| {
                    Failure::input_with_advice(
                        error,
                        format_args!("change {TOUCH_CENTRE} or {TOUCH_RADIUS}"),
                    )
                })?;
                Ok(Shape::Ball(ball))
            }
        }
    }

    /// In a few words.
    #[must_use]
    pub(crate) fn words(&self) -> String {
        match self {
            Self::Plane { normal, .. } if normal.len() == 2 => "straight edge".to_owned(),
            Self::Plane { .. } => "plane".to_owned(),
            Self::Ball {
                centre_m,
                radius_m,
                hollow,
            } => {
                let round = if centre_m.len() == 2 {
                    "disc"
                } else {
                    "sphere"
                };
                let room = if *hollow { "room, a " } else { "" };
                format!("{room}{round} of {} mm", 1e3 * radius_m)
            }
        }
    }
}

/// A number an axis.
///
/// # Errors
/// Fewer or more numbers.
pub(super) fn per_axis<const D: usize>(key: &str, numbers: &[f64]) -> Result<[f64; D], Failure> {
    numbers.try_into().map_err(|_| {
        Failure::bad_input(format_args!(
            "`{key}` has {} numbers, not one for each of {D} axes",
            numbers.len()
        ))
    })
}

/// The matter behind the surface.
#[derive(Clone, Debug)]
pub enum TouchLaw {
    /// A piece of tissue under every place of the surface.
    Tissue(TissuePiece),
    /// K + B·D^μ.
    Wall {
        /// K, N/m, at least 0.
        stiffness_n_per_m: f64,
        /// B, N·s^μ/m, at least 0.
        dissipation_n_s_mu_per_m: f64,
        /// μ, 0 to 2.
        order: Order,
    },
}

/// A shape with the law behind it.
pub(super) type Touched<const D: usize> =
    Contact<f64, SpringDamper<f64, Operator<f64>>, D, Shape<f64, D>>;

impl TouchLaw {
    /// K in N/m, and B in N·s^μ/m.
    #[must_use]
    pub(crate) fn spring_and_damper(&self) -> (f64, f64) {
        match self {
            Self::Tissue(piece) => piece.spring_and_damper(),
            Self::Wall {
                stiffness_n_per_m,
                dissipation_n_s_mu_per_m,
                ..
            } => (*stiffness_n_per_m, *dissipation_n_s_mu_per_m),
        }
    }

    /// μ.
    #[must_use]
    pub const fn order(&self) -> Order {
        match self {
            Self::Tissue(piece) => piece.material.order(),
            Self::Wall { order, .. } => *order,
        }
    }

    /// The model whose memory the operator is; `None` for D^μ.
    #[must_use]
    pub const fn model(&self) -> Option<&Model> {
        match self {
            Self::Tissue(piece) => piece.material.composed(),
            Self::Wall { .. } => None,
        }
    }

    /// Behind this surface.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub(super) fn behind<const D: usize>(
        &self,
        surface: Shape<f64, D>,
        scheme: Scheme,
        t: Seconds,
        horizon: f64,
    ) -> Result<Touched<D>, Failure> {
        let operator = operator(self.model(), scheme, self.order(), t, horizon)?;
        let (k, b) = self.spring_and_damper();
        let law = SpringDamper::new(k, b, operator).map_err(parameter)?;
        Ok(Contact::behind(surface, law))
    }

    /// In a few words.
    #[must_use]
    pub(crate) fn words(&self) -> String {
        if let Self::Tissue(piece) = self {
            return piece.material.name.clone();
        }
        let ((k, b), order) = (self.spring_and_damper(), self.order());
        format!("{k} N/m and {b} N·s^{order}/m")
    }
}
