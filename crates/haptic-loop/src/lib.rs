#![doc = include_str!("../README.md")]
#![no_std]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]
#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

mod contact;
mod controller;
mod coupler;
mod device;
mod engaged;
mod environment;
mod error;
mod guard;
mod loading;
mod motion;
mod own_push;
#[cfg(feature = "plants")]
pub mod plant;
#[cfg(feature = "std")]
pub mod realtime;
mod safety;
mod surface;
mod tissue;
pub mod units;
mod wall;

pub use contact::{Contact, Pushing};
pub use controller::{Controller, LoopSample};
pub use coupler::{CoupledHistory, VirtualCoupler, VirtualObject, deflection_order};
pub use device::{Device, Reading};
pub use engaged::Engaged;
pub use environment::{Environment, SpringDamper};
pub use error::LoopParameterError;
pub use fracdiff::enumerated;
pub use fracdiff::parameter::RangeError;
pub use guard::{
    EnergyBounding, MAX_GUARD_DELAY_SAMPLES, MAX_GUARD_LAG_SAMPLES, PassivityGuard,
    PassivityObserver,
};
pub use loading::{DepthMap, INCOMPRESSIBLE, Loading, LoadingKind, Modulus, Specimen};
pub use motion::{
    Admittance, AdmittanceError, AtRest, GuardRefused, LaggedRate, LaggedRateHistory, MotionChain,
    MotionFault, MotionLimits, MotionReading, MotionStartRefused, MotionState, MovingDevice,
    SafeMotion, StuckSensor, VirtualBody,
};
pub use own_push::{OwnPush, OwnPushHistory, Tap};
pub use safety::{
    Fault, Limit, Limiters, SafeForce, SafetyChain, SafetyLimits, SafetyState, SpeedLimit,
    StartRefused, Stuck, Tighter, Workspace,
};
pub use surface::{Ball, Plane, Shape, ShapeKind, ShapeNumbers, Surface};
pub use tissue::Tissue;
pub use wall::{Wall, WallShape};

/// Vectors of axes: [`nalgebra::SVector`].
pub use nalgebra;
