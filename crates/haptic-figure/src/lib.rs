#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod axis;
mod chart;
mod clip;
mod curve;
mod error;
mod motion;
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
pub use motion::MotionFigure;
pub use render::Picture;
pub use theory::{Conditions, Origin, Quantity, TheoryFigure};
