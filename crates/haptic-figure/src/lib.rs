#![doc = include_str!("../README.md")]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

mod axis;
mod chart;
mod clip;
mod curve;
mod drawing;
mod error;
#[cfg(feature = "png")]
mod lettering;
mod marker;
mod motion;
mod once;
mod over_time;
mod page;
mod panel;
mod picture;
#[cfg(feature = "png")]
mod pixels;
mod plane;
#[cfg(feature = "png")]
mod png;
mod style;
mod superscript;
mod svg;
mod theory;
mod thin;
mod tick;

pub use axis::Scale;
pub use chart::{AxisSpec, Chart, ChartPage, Look, Series};
pub use error::FigureError;
pub use motion::MotionFigure;
pub use picture::Picture;
pub use plane::PlaneFigure;
pub use style::{GRID, INK, SERIES_COLOURS};
pub use theory::{Conditions, HeldPanels, TheoryFigure};
