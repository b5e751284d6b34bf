//! The commands: arguments, and what they print. The work is in the modules beside this one.

pub mod analyze;
pub mod conduct;
pub mod creep;
pub mod design;
pub mod device;
pub mod differintegrate;
pub mod experiment;
pub mod export_c;
pub mod identify;
pub mod live;
pub mod log;
pub mod materials;
pub mod plant;
pub mod preflight;
pub mod realtime;
pub mod relax;
pub mod remote;
pub mod reproduce;
pub mod rt_check;
pub mod run;
pub mod safety;
pub mod shell;
pub mod summary;
pub mod weights;
pub mod words;
pub mod zwidth;
