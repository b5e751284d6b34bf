//! The page's server without a machine.

mod alone;
