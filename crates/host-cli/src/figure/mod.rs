//! Pictures of a run, fit to print: SVG to edit, PNG to look at.
//!
//! ```text
//! RelaxationFigure, CreepFigure, LogFigure ─▶ panels (axes, thinned curves) ─▶ page ─▶ Picture ─▶ .svg .png
//! ```
//!
//! Every picture is drawn from slices of equal length, is thinned to what its pixels can show, and
//! keeps the colours of Okabe and Ito, which people with any colour vision tell apart. The plot
//! library `kuva` and the renderer `resvg` are known to this module only. Text is set in the
//! bundled `DejaVu Sans`, so a picture does not depend on the fonts of the machine.

mod axis;
mod creep;
mod error;
mod log_plot;
mod page;
mod panel;
mod relaxation;
mod render;
mod style;
mod theory;
mod thin;

pub use creep::CreepFigure;
pub use error::FigureError;
pub use log_plot::LogFigure;
pub use relaxation::RelaxationFigure;
pub use render::{Picture, SavedPicture};
pub use theory::Conditions;
