//! The five-bar pantograph: place of the hand and Jacobian from two angles.
//!
//! ```text
//!          hand P            base joints at (0, 0) and (d, 0)
//!         /      \           elbows  A = l·(cos θ₁, sin θ₁),  B = (d, 0) + l·(cos θ₂, sin θ₂)
//!      L /        \ L        P = ½(A + B) + √(L² − ¼|AB|²)·n,  n the unit vector at +90° from AB
//!       A          B
//!      l \        / l        J = ∂P/∂θ from |PA| = |PB| = L:  (P−A)·(dP−dA) = 0,  (P−B)·(dP−dB) = 0
//!         ●──d───●           τ = Jᵀ·f
//! ```
//! *Source*: G. Campion, Q. Wang, V. Hayward, *The Pantograph Mk-II*, IROS 2005.

use nalgebra::{Matrix2, Vector2};
use thiserror::Error;

/// Below this share of L², the sine |(P−A)×(P−B)|/L² between them, the far arms count as in a line: the Jacobian has
/// no bound.
const SINE_LEAST: f64 = 0.1;
/// Below this sine the arms of one side count as in a line: the end of the workspace.
const STRAIGHT_LEAST: f64 = 0.02;

/// The lengths of a five-bar pantograph, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pantograph {
    /// l, the length from a joint at the base to its elbow.
    pub near_m: f64,
    /// L, the length from an elbow to the hand.
    pub far_m: f64,
    /// d, the distance between the two joints at the base.
    pub base_m: f64,
}

/// A posture: place of the hand, and its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Posture {
    /// Position of the hand, m.
    pub hand_m: Vector2<f64>,
    /// J = ∂(x, y)/∂(θ₁, θ₂), m/rad.
    pub jacobian: Matrix2<f64>,
}

/// A posture in which the hand's position is undefined or its Jacobian is nearly singular.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Singular {
    /// The elbows are further apart than both far arms are long: no such posture.
    #[error(
        "the elbows would be {apart_m:.4} m apart, beyond the reach of {reach_m} m of both far arms"
    )]
    OutOfReach {
        /// |AB|, m.
        apart_m: f64,
        /// 2L, m.
        reach_m: f64,
    },
    /// The far arms are in a line: stretched, or folded onto each other.
    #[error(
        "the far arms are nearly in line (sine {sine:.3}, below 0.1): every force there needs a large torque"
    )]
    Stretched {
        /// Sine of the angle between them.
        sine: f64,
    },
    /// An elbow is stretched or folded: the end of the workspace.
    #[error("arm {arm} is nearly straight (sine {sine:.3}, below 0.02): the end of the workspace")]
    Straight {
        /// 1 or 2.
        arm: u8,
        /// Sine of the angle at the elbow.
        sine: f64,
    },
    /// An angle is not a finite number.
    #[error("an angle is not a finite number")]
    NotFinite,
}

impl Pantograph {
    /// The posture for two angles, rad.
    ///
    /// *Accuracy*: rounding, 1e-15 m, in every posture that is not singular. *Cost*: four functions of angles, two roots.
    ///
    /// # Errors
    /// Angles that are not finite or do not give a posture; far arms in a line to a sine
    /// of 0.1, arms of one side to a sine of 0.02.
    pub fn posture(&self, angles: [f64; 2]) -> Result<Posture, Singular> {
        if !angles.iter().all(|angle| angle.is_finite()) {
            return Err(Singular::NotFinite);
        }
        let unit = angles.map(|angle| Vector2::new(libm::cos(angle), libm::sin(angle)));
        let elbow_a = unit[0] * self.near_m;
        let elbow_b = unit[1] * self.near_m + Vector2::new(self.base_m, 0.0);
        let across = elbow_b - elbow_a;
        let apart = libm::sqrt(across.dot(&across));
        let reach_m = 2.0 * self.far_m;
        if apart > reach_m {
            let apart_m = apart;
            return Err(Singular::OutOfReach { apart_m, reach_m });
        }
        let height = libm::sqrt((self.far_m - 0.5 * apart) * (self.far_m + 0.5 * apart));
        let sine = apart * height / (self.far_m * self.far_m);
        if sine < SINE_LEAST {
            return Err(Singular::Stretched { sine });
        }
        let upwards = Vector2::new(-across.y, across.x) / apart;
        let hand_m = elbow_a + across * 0.5 + upwards * height;
        let (u, v) = (hand_m - elbow_a, hand_m - elbow_b);
        let turned = unit.map(|unit| Vector2::new(-unit.y, unit.x) * self.near_m);
        let (along_a, along_b) = (u.dot(&turned[0]), v.dot(&turned[1]));
        for (arm, along) in [(1, along_a), (2, along_b)] {
            let sine = along.abs() / (self.near_m * self.far_m);
            if sine < STRAIGHT_LEAST {
                return Err(Singular::Straight { arm, sine });
            }
        }
        let determinant = u.x * v.y - u.y * v.x;
        let (first, second) = (along_a / determinant, along_b / determinant);
        let jacobian = Matrix2::new(first * v.y, -second * u.y, -first * v.x, second * u.x);
        Ok(Posture { hand_m, jacobian })
    }

    /// True if both elbows are on the outside, and the hand in front of the base: as the arms of a 2DIY are put together.
    pub(crate) fn is_assembled(&self, angles: [f64; 2], posture: &Posture) -> bool {
        let side = |base_m: f64, angle: f64| {
            let hand = posture.hand_m - Vector2::new(base_m, 0.0);
            hand.x * libm::sin(angle) - hand.y * libm::cos(angle)
        };
        let [first, second] = angles;
        posture.hand_m.y > 0.0 && side(0.0, first) > 0.0 && side(self.base_m, second) < 0.0
    }

    /// The angles for a position of the hand, rad, with both elbows on the outside; θ₁ in (−½π, 3/2
    /// π], θ₂ in (−3/2 π, ½π].
    ///
    /// # Errors
    /// A position that the arms do not reach.
    pub fn angles(&self, hand_m: Vector2<f64>) -> Result<[f64; 2], Singular> {
        let angle = |arm: u8, base_m: f64, side: f64| {
            let to = hand_m - Vector2::new(base_m, 0.0);
            let square = to.dot(&to);
            let distance = libm::sqrt(square);
            let (near, far) = (self.near_m, self.far_m);
            let cosine = (near * near + square - far * far) / (2.0 * near * distance);
            if cosine.is_nan() || cosine.abs() > 1.0 {
                let sine = 0.0;
                return Err(Singular::Straight { arm, sine });
            }
            Ok(libm::atan2(to.y, to.x) + side * libm::acos(cosine))
        };
        Ok([angle(1, 0.0, 1.0)?, angle(2, self.base_m, -1.0)?])
    }
}

impl Posture {
    /// The torques that cause a force at the hand, τ = Jᵀ·f, N·m.
    #[must_use]
    pub fn torques(&self, force_n: Vector2<f64>) -> Vector2<f64> {
        self.jacobian.transpose() * force_n
    }

    /// The force at the hand caused by two torques, N.
    #[must_use]
    pub fn force(&self, torques_nm: Vector2<f64>) -> Vector2<f64> {
        let j = &self.jacobian;
        let determinant = j.m11 * j.m22 - j.m12 * j.m21;
        let x = (j.m22 * torques_nm.x - j.m21 * torques_nm.y) / determinant;
        let y = (j.m11 * torques_nm.y - j.m12 * torques_nm.x) / determinant;
        Vector2::new(x, y)
    }
}
