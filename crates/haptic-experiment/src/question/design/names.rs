//! Aims and requirements by name, as questions have them.

use crate::document::named::Named;

/// What is wanted most.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WishName {
    StiffestWall,
    MostDamping,
    Tissue,
    Coupler,
}

impl Named for WishName {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (Self::StiffestWall, "stiffest-wall", "The largest stiffness"),
        (
            Self::MostDamping,
            "most-damping",
            "The largest effective damping at a frequency",
        ),
        (
            Self::Tissue,
            "tissue",
            "A specimen of a tissue: does it fit, and how large may it be",
        ),
        (
            Self::Coupler,
            "coupler",
            "The virtual coupler that feels stiffest at a frequency",
        ),
    ];
}

/// What a wall or coupler must be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RequireName {
    Stable,
    Passive,
}

impl Named for RequireName {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (
            Self::Stable,
            "stable",
            "Stable with a gain margin; a coupler passes Llewellyn's criterion too",
        ),
        (
            Self::Passive,
            "passive",
            "Passive, for the operator that really runs",
        ),
    ];
}
