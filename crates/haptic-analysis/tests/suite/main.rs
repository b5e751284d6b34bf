//! Tests of the public face of `haptic-analysis`, in one binary.

mod admittance;
mod coupled;
mod coupling;
mod hand_port;
mod lateness;
mod law_set;
mod margin;
mod own_operator;
mod passivity;
mod passivity_path;
mod path;
mod plant;
mod region;
mod slope;
mod stability;
mod teleoperation;
mod transparency;
