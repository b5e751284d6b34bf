//! Questions to records, as a whole.

mod spoilt_rows;
