//! Tables by their public reading.

mod shapes;
mod units;
#[cfg(feature = "workbook")]
mod workbook;
