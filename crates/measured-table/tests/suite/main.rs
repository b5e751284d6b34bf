//! Tables by their public reading.

mod shapes;
mod units;
