//! Tests of the public face of `haptic-loop`, in one binary.

mod begin;
mod controller;
mod coupler;
mod environments;
mod extraction;
mod guard;
mod held_rig;
mod lets_go;
mod plant_parameters;
mod plants;
mod release;
mod rig;
mod safety;
mod sensors;
mod straight;
mod surfaces;
