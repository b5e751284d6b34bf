#![doc = include_str!("../README.md")]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

mod axis;
mod chart;
mod clip;
mod curve;
mod drawing;
mod error;
mod marker;
mod motion;
mod over_time;
mod page;
mod panel;
mod picture;
mod plane;
#[cfg(feature = "png")]
mod png;
mod style;
mod superscript;
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
