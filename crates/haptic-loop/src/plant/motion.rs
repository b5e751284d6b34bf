//! The motion of a rig from sample to sample, as matrices: for whoever closes a loop around it.

use super::rig::{FORCE, IndentationRig, PUSH, SUB_STEPS};
use nalgebra::{Matrix4, Vector4};

/// x\[n+1\] = Φ·x\[n\] + `Γ_S`·S\[n\] + `Γ_f`·f\[n\], both forces held over the sample.
///
/// x = (x₁, v₁, x₂, v₂): renderer and indenter, m and m/s; S on the indenter and f on the renderer, N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigMotion {
    /// Φ.
    pub transition: Matrix4<f64>,
    /// `Γ_S`, of the force on the indenter.
    pub indenter: Vector4<f64>,
    /// `Γ_f`, of the force on the renderer.
    pub renderer: Vector4<f64>,
}

impl IndentationRig {
    /// The motion in contact, or apart, for a rig under [`RigDrive::Force`](super::RigDrive::Force): the matrices that run.
    #[must_use]
    pub fn motion(&self, touching: bool) -> RigMotion {
        let step = if touching { self.together } else { self.apart };
        let sample = (1..SUB_STEPS).fold(step, |moved, _| step * moved);
        RigMotion {
            transition: sample.fixed_view::<4, 4>(0, 0).into_owned(),
            indenter: sample.fixed_view::<4, 1>(0, PUSH).into_owned(),
            renderer: sample.fixed_view::<4, 1>(0, FORCE).into_owned(),
        }
    }
}
