#![doc = include_str!("../README.md")]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

#[cfg(feature = "fit")]
mod binned;
#[cfg(feature = "fit")]
mod bounded;
mod contour;
mod cubic;
#[cfg(feature = "fit")]
mod doubts;
mod elements;
#[cfg(feature = "fit")]
mod history;
mod joint;
#[cfg(feature = "fit")]
mod mode;
mod modes;

pub use contour::{Contour, Quantity, oscillation};
pub use cubic::cubic;
pub use elements::{Elements, Slope, VARIABLES, is_order};
pub use joint::{ELEMENTS, Joint, join, variables};
pub use modes::{LANES, crept, decays, excess, relaxed};
#[cfg(feature = "fit")]
pub use {
    binned::Binned,
    bounded::{Effort, Minimum, Problem, Pull, minimise},
    doubts::Doubts,
    history::{History, Moved, chosen},
    mode::SpectralMode,
};
