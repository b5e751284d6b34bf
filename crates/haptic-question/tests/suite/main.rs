//! Questions to records, as a whole.

mod admittance_in_time;
mod responses;
mod spoilt_rows;
