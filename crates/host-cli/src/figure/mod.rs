//! Pictures of a run, fit to print: SVG to edit, PNG to look at.
//!
//! ```text
//! TheoryFigure, LogFigure ─▶ panels (axes, thinned curves) ─▶ page ─▶ Picture ─▶ .svg .png
//! ChartPage: charts of named series ─┘
//! ```
//!
//! Every picture is drawn from slices, is thinned to what its pixels can show, and keeps the colours of Okabe and Ito, which people with any colour vision tell apart. The plot
//! library `kuva` and the renderer `resvg` are known to this module only. Text is set in the
//! bundled `DejaVu Sans`, so a picture does not depend on the fonts of the machine. In all of it
//! `^μ` (any Greek letter) and `^{2−μ}` are superscripts, as Unicode has none for μ.

mod axis;
mod chart;
mod clip;
mod curve;
mod error;
mod log_plot;
mod page;
mod panel;
mod render;
mod style;
mod superscript;
mod theory;
mod thin;

pub use axis::Scale;
pub use chart::{AxisSpec, Chart, ChartPage, Look, Series};
pub use error::FigureError;
pub use log_plot::LogFigure;
pub use render::{Picture, SavedPicture};
pub use theory::{Conditions, Origin, Quantity, TheoryFigure};
