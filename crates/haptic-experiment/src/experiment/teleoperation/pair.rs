//! Both sides and the line between them, tick by tick in virtual time; each a simulated device with what holds or touches it.

use super::{HandModel, HandMotion, TeleoperationExperiment};
use fracdiff::{Operator, Seconds};
use haptic_document::Failure;
use haptic_judge::trial::VirtualWall;
use haptic_link::HandSide;
use haptic_loop::{
    Device, Environment, Limiters, Reading, SafeForce,
    plant::{ForceSensor, MassDamper, MassDamperConfig, SUB_STEPS},
    units::{NewtonSecondsPerMetre, NewtonsPerMetre},
};
use haptic_message::PerAxis;
use haptic_teleoperation::{OneWayLine, Port};
use haptic_trial::{advice::parameter, ending::Ending};
use nalgebra::Vector1;

/// Hand or environment at a device.
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
    /// Force sensor of the slave, at its place.
    sensor: Option<ForceSensor>,
    damping: f64,
    sample_time: f64,
    /// Σ f[n]·(x[n+1] − x[n]).
    held_j: f64,
    /// Energy that its damping has taken at least.
    damped_j: f64,
}

impl TeleoperationExperiment {
    /// The device of a side at rest.
    pub(super) fn body(&self, side: HandSide) -> Result<Body, Failure> {
        let t = self.sample_time();
        let step = Seconds(t.0 / SUB_STEPS as f64);
        let (device, world, held) = match side {
            HandSide::Master => {
                let (model, motion) = (self.hand, self.motion.clone());
                (&self.master, World::Hand { model, motion }, model)
            }
            HandSide::Slave => {
                let steps = self.samples() * SUB_STEPS as u64;
                let law = self.place.law(self.scheme, step, steps)?;
                let history = Environment::<f64, 1>::at_rest(&law);
                (
                    &self.slave,
                    World::Place { law, history },
                    HandModel::default(),
                )
            }
        };
        let sensor = (self.force_sensor).filter(|_| side == HandSide::Slave);
        let sensor = sensor.map(|sensor| ForceSensor::new(sensor, t));
        let config = MassDamperConfig {
            damping: NewtonSecondsPerMetre(device.damping.0 + held.damping_n_s_per_m),
            stiffness: NewtonsPerMetre(held.stiffness_n_per_m),
            sample_time: step,
            ..*device
        };
        Ok(Body {
            plant: MassDamper::new(config).map_err(parameter)?,
            world,
            sensor: sensor.transpose().map_err(Failure::input)?,
            damping: device.damping.0,
            sample_time: t.0,
            held_j: 0.0,
            damped_j: 0.0,
        })
    }
}

impl Body {
    /// Reading of the port in a tick.
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
                let (hand_m, speed) = motion.at(time_s);
                model.stiffness_n_per_m * (hand_m - self.plant.position()[0])
                    + model.damping_n_s_per_m * (speed - self.plant.velocity()[0])
            }
            World::Place { law, history } => law.force(history, &self.plant.position())[0],
        }
    }

    /// Its sensor shows the force on the place as it is, N; `None` without one.
    pub(super) fn sensed_n(&mut self, force_n: f64) -> Option<PerAxis> {
        let sensor = self.sensor.as_mut()?;
        let mut forces_n = [force_n];
        sensor.read(&mut forces_n);
        Some(PerAxis::new(&forces_n))
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
                    let (hand_m, speed) = motion.at(time_s + (sub as f64 + 0.5) * step);
                    model.stiffness_n_per_m * hand_m + model.damping_n_s_per_m * speed
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

/// One side in a tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SideTick {
    /// Place of the device, m.
    pub position_m: f64,
    /// Force that its port wanted, N.
    pub wanted_n: f64,
    /// Force that was sent to the device, N.
    pub force_n: f64,
    pub limiters: Limiters,
    /// External force on the device, N: from the hand on the master, from the remote environment on
    /// the slave.
    pub outside_n: f64,
    /// Force on the place of the slave by its sensor, N.
    pub sensed_n: Option<PerAxis>,
}

/// A tick of both sides.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairTick {
    pub tick: u64,
    pub time_s: f64,
    pub sides: [SideTick; 2],
    /// Energy that the line has given to both devices so far, J: `Σ f[n]·(x[n] − x[n−1])`.
    pub given_j: f64,
    /// That energy with each force held until the next: `Σ f[n]·(x[n+1] − x[n])`, up to this tick, J.
    pub held_j: f64,
    /// Least energy that the damping of both devices has absorbed so far, J; it must cover what
    /// holding the force adds.
    pub damped_j: f64,
}

/// A port and its device.
struct Side {
    port: Port<Operator<f64>>,
    body: Body,
}

impl Side {
    /// The port at work; its message is on the way.
    fn tick(&mut self, tick: u64, way: &mut OneWayLine) -> (SideTick, SafeForce<f64, 1>) {
        let reading = self.body.reading(tick);
        let outside_n = self.body.outside_n(reading.time_s);
        let begun = self.port.begin(reading);
        let force = begun.force();
        let ticked = begun.finish();
        way.send(tick, ticked.message);
        let seen = SideTick {
            position_m: reading.position_m[0],
            wanted_n: ticked.sample.environment_force_n[0],
            force_n: force.newtons()[0],
            limiters: ticked.sample.limiters,
            outside_n,
            sensed_n: self.body.sensed_n(0.0 - outside_n),
        };
        (seen, force)
    }
}

pub(super) struct Pair {
    sides: [Side; 2],
    /// Ways from master to slave, and back.
    ways: [OneWayLine; 2],
    sample_time: f64,
    tick: u64,
}

impl TeleoperationExperiment {
    pub(super) fn pair(&self) -> Result<Pair, Failure> {
        self.check_times()?;
        let t = self.sample_time();
        let side = |side| {
            Ok::<_, Failure>(Side {
                port: self.port(side)?,
                body: self.body(side)?,
            })
        };
        // Two seeds for each one.
        let way = |n| OneWayLine::new(self.channel, t, self.seed.wrapping_mul(2).wrapping_add(n));
        Ok(Pair {
            sides: [side(HandSide::Master)?, side(HandSide::Slave)?],
            ways: [way(0).map_err(parameter)?, way(1).map_err(parameter)?],
            sample_time: t.0,
            tick: 0,
        })
    }
}

impl Pair {
    /// One tick of both sides, and the motion until the next.
    pub(super) fn tick(&mut self) -> PairTick {
        let tick = self.tick;
        let time_s = tick as f64 * self.sample_time;
        for (side, way) in self.sides.iter_mut().zip(self.ways.iter_mut().rev()) {
            while let Some(message) = way.next(tick) {
                side.port.receive(&message);
            }
        }
        let (master, first) = self.sides[0].tick(tick, &mut self.ways[0]);
        let (slave, second) = self.sides[1].tick(tick, &mut self.ways[1]);
        let sum = |of: fn(&Side) -> f64| self.sides.iter().map(of).sum();
        let seen = PairTick {
            tick,
            time_s,
            sides: [master, slave],
            given_j: sum(|side| side.port.given_j()),
            held_j: sum(|side| side.body.held_j),
            damped_j: sum(|side| side.body.damped_j),
        };
        self.sides[0].body.advance(time_s, first);
        self.sides[1].body.advance(time_s, second);
        self.tick += 1;
        seen
    }

    pub(super) fn ports(&self) -> [&Port<Operator<f64>>; 2] {
        [&self.sides[0].port, &self.sides[1].port]
    }

    /// Ways from master to slave, and back.
    pub(super) const fn ways(&self) -> &[OneWayLine; 2] {
        &self.ways
    }

    /// Lets both forces fall to zero.
    pub(super) fn stop(&mut self) {
        for side in &mut self.sides {
            side.port.stop();
        }
    }

    /// Why it does not go on: a side has a fault, or heard nothing for too long.
    pub(super) fn ended(&self) -> Option<Ending> {
        let over = |port: &Port<_>| {
            let fault = port.safety().fault().map(Ending::Fault);
            fault.or_else(|| port.is_silent().then_some(Ending::Silent))
        };
        self.ports().into_iter().find_map(over)
    }

    /// True if both forces are zero.
    pub(super) fn is_at_rest(&self) -> bool {
        let at_rest = |port: &Port<_>| port.safety().is_at_rest();
        self.ports().into_iter().all(at_rest)
    }
}
