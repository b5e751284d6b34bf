//! A simulated device with what holds or touches it, stepped several times a sample.

use super::advice::parameter;
use super::specification::{HandModel, HandMotion, TeleoperationExperiment};
use crate::document::failure::Failure;
use crate::experiment::trial::VirtualWall;
use fracdiff::Seconds;
use haptic_link::HandSide;
use haptic_loop::plant::{MassDamper, MassDamperConfig, SUB_STEPS};
use haptic_loop::units::{NewtonSecondsPerMetre, NewtonsPerMetre};
use haptic_loop::{Device, Environment, Reading, SafeForce};
use nalgebra::Vector1;

/// What holds or touches a device.
enum World {
    /// The hand on the master.
    Hand {
        model: HandModel,
        motion: HandMotion,
    },
    /// The remote place of the slave.
    Place {
        law: VirtualWall,
        history: <VirtualWall as Environment<f64, 1>>::History,
    },
}

/// A device in the world.
pub(super) struct Body {
    plant: MassDamper<1>,
    world: World,
    damping: f64,
    sample_time: f64,
    /// Σ f[n]·(x[n+1] − x[n]).
    pub(super) held_j: f64,
    /// Energy that its damping has taken at least.
    pub(super) damped_j: f64,
}

impl TeleoperationExperiment {
    /// The device of a side at rest.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub(super) fn body(&self, side: HandSide) -> Result<Body, Failure> {
        let t = self.sample_time();
        let step = Seconds(t.0 / SUB_STEPS as f64);
        let (device, world, held) = match side {
            HandSide::Master => {
                let (model, motion) = (self.hand, self.motion.clone());
                (&self.master, World::Hand { model, motion }, model)
            }
            HandSide::Slave => {
                let horizon = self.horizon() * SUB_STEPS as f64;
                let law = self.place.law(self.scheme, step, horizon)?;
                let history = Environment::<f64, 1>::at_rest(&law);
                (&self.slave, World::Place { law, history }, HandModel::NONE)
            }
        };
        let config = MassDamperConfig {
            damping: NewtonSecondsPerMetre(device.damping.0 + held.damping_n_s_per_m),
            stiffness: NewtonsPerMetre(held.stiffness_n_per_m),
            sample_time: step,
            ..*device
        };
        Ok(Body {
            plant: MassDamper::new(config).map_err(parameter)?,
            world,
            damping: device.damping.0,
            sample_time: t.0,
            held_j: 0.0,
            damped_j: 0.0,
        })
    }
}

impl Body {
    /// What the port reads in a tick.
    pub(super) fn reading(&self, tick: u64) -> Reading<f64, 1> {
        Reading {
            tick,
            time_s: tick as f64 * self.sample_time,
            position_m: self.plant.position(),
        }
    }

    /// Force of hand or place on the device, N.
    pub(super) fn outside_n(&self, time_s: f64) -> f64 {
        match &self.world {
            World::Hand { model, motion } => {
                let (place, speed) = motion.at(time_s);
                model.stiffness_n_per_m * (place - self.plant.position()[0])
                    + model.damping_n_s_per_m * (speed - self.plant.velocity()[0])
            }
            World::Place { law, history } => law.force(history, &self.plant.position())[0],
        }
    }

    /// A sample under a force.
    pub(super) fn advance(&mut self, time_s: f64, force: SafeForce<f64, 1>) {
        let before = self.plant.position()[0];
        let step = self.sample_time / SUB_STEPS as f64;
        for sub in 0..SUB_STEPS {
            let from = self.plant.position();
            let outside = match &mut self.world {
                // Spring and damper of the hand are part of the plant.
                World::Hand { model, motion } => {
                    let (place, speed) = motion.at(time_s + (sub as f64 + 0.5) * step);
                    model.stiffness_n_per_m * place + model.damping_n_s_per_m * speed
                }
                World::Place { law, history } => {
                    let force = law.force(history, &from)[0];
                    law.advance(history, &from);
                    force
                }
            };
            self.plant.set_external_force(Vector1::new(outside));
            let Ok(()) = self.plant.write(force);
            let moved = self.plant.position()[0] - from[0];
            // b·∫v² ≥ b·(Δx)²/Δt
            self.damped_j += self.damping * moved * moved / step;
        }
        self.held_j += force.newtons()[0] * (self.plant.position()[0] - before);
    }
}
