//! Questions to records, as a whole.

mod admittance_in_time;
mod spoilt_rows;
