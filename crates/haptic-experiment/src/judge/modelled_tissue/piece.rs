//! A piece of tissue that is touched.

use super::ModelledTissue;
use haptic_loop::Specimen;

/// A piece of tissue that is touched.
#[derive(Clone, Debug)]
pub struct TissuePiece {
    /// The tissue.
    pub material: Box<ModelledTissue>,
    /// The piece.
    pub specimen: Specimen,
}

impl TissuePiece {
    /// A/ℓ, m.
    #[must_use]
    pub(crate) fn shape_m(&self) -> f64 {
        self.specimen.area().0 / self.specimen.thickness().0
    }

    /// K in N/m and B in N·s^μ/m.
    #[must_use]
    pub(crate) fn spring_and_damper(&self) -> (f64, f64) {
        self.material.spring_and_damper(self.shape_m())
    }
}
