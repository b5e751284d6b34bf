#![doc = include_str!("../README.md")]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

mod axis;
mod chart;
mod curve;
mod drawing;
mod error;
#[cfg(feature = "png")]
mod lettering;
mod page;
mod panel;
#[cfg(feature = "png")]
mod pdf;
mod picture;
#[cfg(feature = "png")]
mod pixels;
mod plane;
mod sheet;
mod style;
mod superscript;
mod svg;
mod thin;

pub use axis::Scale;
pub use chart::{AxisSpec, Chart, ChartPage, Look, Series};
pub use error::FigureError;
pub use picture::Picture;
pub use plane::PlaneFigure;
pub use sheet::Sheet;
pub use style::{GRID, INK, SERIES_COLOURS};
pub use thin::envelope;
