//! The plane of a 2DIY: where its places count from, which of them the arms reach, and how heavy the handle is there.

use super::kinematics::Singular;
use super::model::Model;
use super::name::Axis;
use nalgebra::{Matrix2, Vector2};
use thiserror::Error;

/// Places of a box that are looked at are at most so far apart, m.
const GRID_M: f64 = 1e-3;
/// A longer side of a box than any arm reaches, m.
const SIDE_MOST_M: f64 = 0.5;

/// The plane of a device, with its places from the middle of the workspace: x along the base to the right, y away from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    model: Model,
}

/// A box that the handle cannot fill.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Unreachable {
    /// A place in it that the arms do not reach, or next to which they are in a line.
    #[error("at ({x_mm:.0}, {y_mm:.0}) mm, from the middle of the workspace, {singular}")]
    Place {
        /// x, mm.
        x_mm: f64,
        /// y, mm.
        y_mm: f64,
        /// Why.
        singular: Singular,
    },
    /// A place behind the base, or one that the arms reach only turned over.
    #[error(
        "at ({x_mm:.0}, {y_mm:.0}) mm, from the middle of the workspace, the arms would be turned over"
    )]
    TurnedOver {
        /// x, mm.
        x_mm: f64,
        /// y, mm.
        y_mm: f64,
    },
    /// A side that is none.
    #[error("a side of {side_m} m is not in (0, 0.5] m")]
    Side {
        /// Its length, m.
        side_m: f64,
    },
}

/// The middle between the arms at the base, m.
pub(super) fn middle(model: &Model) -> Vector2<f64> {
    Vector2::new(0.5 * model.pantograph.base_m(), 0.0)
}

impl Plane {
    /// Lowest and highest place between which both motors make the largest force, m.
    pub const HANDY_M: ([f64; 2], [f64; 2]) = ([-0.05, -0.05], [0.05, 0.04]);

    /// Of a device.
    #[must_use]
    pub const fn of(model: Model) -> Self {
        Self { model }
    }

    /// The place that is zero, in the coordinates of the maker, m.
    #[must_use]
    pub fn centre(&self) -> Vector2<f64> {
        middle(&self.model) + Axis::Y.across_and_along(Axis::Y.zero_m())
    }

    /// The derivatives ∂(x, y)/∂(θ₁, θ₂) of the posture at a place, m/rad.
    fn jacobian(&self, place_m: Vector2<f64>) -> Result<Matrix2<f64>, Unreachable> {
        let pantograph = &self.model.pantograph;
        let (x_mm, y_mm) = (1e3 * place_m.x, 1e3 * place_m.y);
        let hand_m = self.centre() + place_m;
        let angles = pantograph.angles(hand_m);
        let posture = angles.and_then(|angles| Ok((angles, pantograph.posture(angles)?)));
        let (angles, posture) = posture.map_err(|singular| Unreachable::Place {
            x_mm,
            y_mm,
            singular,
        })?;
        // The angles of a place behind the base have their hand in front of it.
        let same = (posture.hand_m - hand_m).norm() < GRID_M;
        if same && pantograph.is_assembled(angles, &posture) {
            Ok(posture.jacobian)
        } else {
            Err(Unreachable::TurnedOver { x_mm, y_mm })
        }
    }

    /// The least and the largest mass that the handle has along any direction at any place of a box, for one that has 1 kg in the
    /// middle of the workspace, in the mean of its directions; kg.
    ///
    /// ```text
    /// M = I·(J·Jᵀ)⁻¹,   mass along n  1/(nᵀ·M⁻¹·n) = I/|Jᵀ·n|²  in [I/σ₁², I/σ₂²],  σ the singular values of J
    /// ```
    /// Both arms count as the same inertia I about their base joints. Places are looked at on a grid of 1 mm.
    ///
    /// # Errors
    /// A box with a place that the arms do not reach, or where they are next to a singular posture.
    pub fn masses(&self, low_m: [f64; 2], high_m: [f64; 2]) -> Result<[f64; 2], Unreachable> {
        let [across, away] = [high_m[0] - low_m[0], high_m[1] - low_m[1]];
        for side_m in [across, away] {
            if !(side_m > 0.0 && side_m <= SIDE_MOST_M) {
                return Err(Unreachable::Side { side_m });
            }
        }
        let inertia = self.jacobian(Vector2::zeros())?.determinant().abs();
        let steps = |side_m: f64| (side_m / GRID_M).ceil() as u32;
        let (columns, rows) = (steps(across), steps(away));
        let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
        for row in 0..=rows {
            for column in 0..=columns {
                let share = |n: u32, of: u32| f64::from(n) / f64::from(of);
                let place = Vector2::new(
                    low_m[0] + across * share(column, columns),
                    low_m[1] + away * share(row, rows),
                );
                let values = self.jacobian(place)?.singular_values();
                least = least.min(inertia / values.max().powi(2));
                most = most.max(inertia / values.min().powi(2));
            }
        }
        Ok([least, most])
    }
}
