//! The rig of a relaxation or creep test in virtual time: two actuators that face each other, or the tissue alone.

use crate::{controller_holder::ControllerHolder, modelled_tissue::Sampled};
use fracdiff::{Real, Seconds};
use haptic_loop::{
    DepthMap, Device, Reading, SafeForce,
    plant::{FacingSide, HeldRig, IndentationRig},
};
use haptic_message::TickMessage;
use haptic_trial::simulate::Instrumented;
use nalgebra::SVector;
use std::convert::Infallible;

/// The rig of a relaxation or creep test.
#[derive(Debug)]
pub enum SimulatedRig {
    /// Two actuators that face each other, the indenter led by its own servo.
    Plain(Box<IndentationRig>),
    /// Both actuators, the indenter held by a controller.
    Held(Box<HeldRig<ControllerHolder>>),
    /// A push on the tissue alone.
    Ideal(Box<Massless>),
}

/// A constant push on a tissue, without a mass between: the depth is that whose force is the push.
///
/// ```text
/// F₀ = g·e(δ[n]) + S[n]    ⇒    e(δ[n]) = (F₀ − S[n])/g
/// ```
/// It holds a tissue of its own, with all of the past; the force that is written is not needed.
#[derive(Debug)]
pub struct Massless {
    tissue: Sampled,
    map: Option<DepthMap<f64>>,
    force_n: f64,
    sample_time_s: f64,
    /// The tick that is read next.
    tick: u64,
    /// e(δ) of that tick, m.
    effective: f64,
}

impl Massless {
    /// A push F₀, N, on a tissue at rest.
    pub fn new(
        tissue: Sampled,
        map: Option<DepthMap<f64>>,
        force_n: f64,
        sample_time: Seconds,
    ) -> Self {
        let effective = force_n / tissue.gain();
        Self {
            tissue,
            map,
            force_n,
            sample_time_s: sample_time.0,
            tick: 0,
            effective,
        }
    }

    /// δ of the tick that is read next, m.
    fn depth(&self) -> f64 {
        (self.map).map_or(self.effective, |map| map.depth(self.effective))
    }

    fn advance(&mut self) {
        self.tissue.advance(self.effective);
        self.tick += 1;
        // The force at a depth of zero is the past alone.
        self.effective = (self.force_n - self.tissue.force(0.0)) / self.tissue.gain();
    }

    /// δ of a tick after the other, m.
    pub fn step(&mut self) -> f64 {
        let depth = self.depth();
        self.advance();
        depth
    }
}

impl<F: Real> Device<F, 1> for SimulatedRig {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<F, 1>, Infallible> {
        match self {
            Self::Plain(rig) => rig.read(),
            Self::Held(rig) => rig.read(),
            Self::Ideal(rig) => Ok(Reading {
                tick: rig.tick,
                time_s: rig.tick as f64 * rig.sample_time_s,
                position_m: SVector::from([F::from_f64(rig.depth())]),
            }),
        }
    }

    fn write(&mut self, force: SafeForce<F, 1>) -> Result<(), Infallible> {
        match self {
            Self::Plain(rig) => rig.write(force),
            Self::Held(rig) => rig.write(force),
            Self::Ideal(rig) => {
                rig.advance();
                Ok(())
            }
        }
    }
}

impl Instrumented for SimulatedRig {
    type Message = TickMessage;

    fn observe(&self) -> TickMessage {
        match self {
            Self::Plain(rig) => rig.observe(),
            Self::Ideal(rig) => {
                let depth = rig.depth();
                TickMessage {
                    reference_m: depth.into(),
                    indenter_position_m: depth.into(),
                    contact_force_n: rig.force_n.into(),
                    ..TickMessage::unknown(1)
                }
            }
            Self::Held(held) => {
                let devices = held.devices();
                let indenter_m = devices.position(FacingSide::Indenter);
                TickMessage {
                    reference_m: held.reference().unwrap_or(indenter_m).into(),
                    indenter_position_m: indenter_m.into(),
                    contact_force_n: devices.contact_force().into(),
                    ..TickMessage::unknown(1)
                }
            }
        }
    }
}
