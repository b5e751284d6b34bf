//! The remote place: a tissue of the library, or a wall.

use crate::document::failure::Failure;
use crate::document::named::Named;
use crate::experiment::trial::{VirtualWall, wall_at_start};
use crate::judge::modelled_tissue::{TissuePiece, operator};
use fracdiff::num_complex::Complex;
use fracdiff::{Order, Scheme, Seconds};
use haptic_tissue::Model;

/// Kinds of remote places.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlaceName {
    /// A tissue of the library.
    Tissue,
    /// K + B·D^μ.
    Wall,
}

impl Named for PlaceName {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (
            Self::Tissue,
            "tissue",
            "A tissue of the library, to which the slave is joined",
        ),
        (Self::Wall, "wall", "A spring and a fractional damper"),
    ];
}

/// What the slave touches, from its start on.
#[derive(Clone, Debug)]
pub enum RemotePlace {
    /// A piece of tissue that the slave is joined to.
    Tissue(TissuePiece),
    /// K + B·D^μ.
    Wall {
        /// K, N/m, at least 0.
        stiffness_n_per_m: f64,
        /// B, N·s^μ/m, at least 0.
        dissipation_n_s_mu_per_m: f64,
        /// μ, 0 to 2.
        order: Order,
        /// It pushes but never pulls.
        one_sided: bool,
    },
}

/// A remote place as spring and damper.
pub(super) struct PlaceConstants<'a> {
    pub(super) stiffness_n_per_m: f64,
    pub(super) dissipation_n_s_mu_per_m: f64,
    pub(super) order: Order,
    /// The model whose memory the damper is; `None` for D^μ.
    pub(super) model: Option<&'a Model>,
    one_sided: bool,
}

impl RemotePlace {
    pub(super) fn constants(&self) -> PlaceConstants<'_> {
        match self {
            Self::Tissue(piece) => {
                let (stiffness, dissipation) = piece.spring_and_damper();
                PlaceConstants {
                    stiffness_n_per_m: stiffness,
                    dissipation_n_s_mu_per_m: dissipation,
                    order: piece.material.order(),
                    model: piece.material.composed(),
                    one_sided: false,
                }
            }
            Self::Wall {
                stiffness_n_per_m,
                dissipation_n_s_mu_per_m,
                order,
                one_sided,
            } => PlaceConstants {
                stiffness_n_per_m: *stiffness_n_per_m,
                dissipation_n_s_mu_per_m: *dissipation_n_s_mu_per_m,
                order: *order,
                model: None,
                one_sided: *one_sided,
            },
        }
    }

    /// Its law, stepped with `step`.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub(super) fn law(
        &self,
        scheme: Scheme,
        step: Seconds,
        horizon: f64,
    ) -> Result<VirtualWall, Failure> {
        let law = self.constants();
        let operator = operator(law.model, scheme, law.order, step, horizon)?;
        let (k, b) = (law.stiffness_n_per_m, law.dissipation_n_s_mu_per_m);
        wall_at_start(k, b, operator, law.one_sided).map_err(Failure::input)
    }

    /// Force for a place at a frequency, N/m; `None` where it is not linear.
    #[must_use]
    pub fn stiffness(&self, omega_rad_s: f64) -> Option<Complex<f64>> {
        let s = Complex::new(0.0, omega_rad_s);
        match self {
            Self::Tissue(piece) => Some(piece.material.model.modulus(s) * piece.shape_m()),
            Self::Wall {
                one_sided: true, ..
            } => None,
            Self::Wall {
                stiffness_n_per_m,
                dissipation_n_s_mu_per_m,
                order,
                ..
            } => Some(s.powf(order.get()) * *dissipation_n_s_mu_per_m + *stiffness_n_per_m),
        }
    }

    /// In a few words.
    #[must_use]
    pub fn words(&self) -> String {
        match self {
            Self::Tissue(piece) => piece.material.name.clone(),
            Self::Wall {
                stiffness_n_per_m,
                dissipation_n_s_mu_per_m,
                order,
                one_sided,
            } => {
                let kind = if *one_sided { "one-sided wall" } else { "wall" };
                format!(
                    "{kind} of {stiffness_n_per_m} N/m and {dissipation_n_s_mu_per_m} N·s^{order}/m"
                )
            }
        }
    }
}
