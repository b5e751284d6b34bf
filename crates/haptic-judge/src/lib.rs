#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![warn(unreachable_pub)]

pub mod compared;
pub mod controller_holder;
pub mod coupler;
pub mod curves;
pub mod decimated;
pub mod felt;
pub mod indentation;
pub mod law_region;
pub mod modelled_tissue;
pub mod position_controller;
pub mod position_law;
pub mod preflight;
pub mod pushed;
pub mod pushed_trial;
pub mod reference;
pub mod rendering;
pub mod robot;
pub mod sensed;
pub mod settling;
pub mod setup;
pub mod simulated_rig;
pub mod swings;
pub mod tissue_table;
pub mod trial;
pub mod wall;
