//! Both sides and the line between them, tick by tick in virtual time.

use super::specification::{HandModel, HandMotion, TeleoperationExperiment};
use crate::failure::Failure;
use crate::pushed::VirtualWall;
use crate::refused::parameter;
use fracdiff::{Operator, Seconds};
use haptic_link::HandSide;
use haptic_loop::plant::{MassDamper, MassDamperConfig, SUB_STEPS};
use haptic_loop::units::{NewtonSecondsPerMetre, NewtonsPerMetre};
use haptic_loop::{Device, Environment, Limiters, Reading, SafeForce};
use haptic_teleoperation::{Channel, Port};
use nalgebra::Vector1;
use std::ops::ControlFlow;

/// One side in a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SideTick {
    /// Place of the device, m.
    pub position_m: f64,
    /// Force that its port wanted, N.
    pub wanted_n: f64,
    /// Force that was sent to it, N.
    pub force_n: f64,
    /// Limiters that acted.
    pub limiters: Limiters,
    /// Force on it from outside, N: of the hand on the master, of the remote place on the slave.
    pub outside_n: f64,
}

/// A tick of both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairTick {
    /// Its number.
    pub tick: u64,
    /// Its time, s.
    pub time_s: f64,
    /// Place of the hand, m.
    pub hand_m: f64,
    /// Master and slave.
    pub sides: [SideTick; 2],
    /// Energy that the line has given to both devices so far, J: Σ f[n]·(x[n] − x[n−1]).
    pub given_j: f64,
    /// The same with each force held until the next: Σ f[n]·(x[n+1] − x[n]), up to this tick.
    pub held_j: f64,
    /// Energy that the damping of both devices has taken at least, J, up to this tick: it has to pay for the hold.
    pub damped_j: f64,
}

/// Receiver of each tick; it may end the simulation.
pub type PairSink<'a> = &'a mut dyn FnMut(&PairTick) -> ControlFlow<()>;

/// A simulated device, stepped several times a sample.
struct Side {
    port: Port<Operator<f64>>,
    plant: MassDamper<1>,
    damping: f64,
}

impl Side {
    /// The port at work; its message is on the way.
    fn tick(
        &mut self,
        tick: u64,
        time_s: f64,
        outside_n: f64,
        way: &mut Channel,
    ) -> (SideTick, SafeForce<f64, 1>) {
        let position_m = self.plant.position();
        let begun = self.port.begin(Reading {
            tick,
            time_s,
            position_m,
        });
        let force = begun.force();
        let ticked = begun.finish();
        way.send(tick, ticked.message);
        let seen = SideTick {
            position_m: position_m[0],
            wanted_n: ticked.sample.environment_force_n[0],
            force_n: force.newtons()[0],
            limiters: ticked.sample.limiters,
            outside_n,
        };
        (seen, force)
    }
}

/// Both sides.
pub(super) struct Pair {
    sides: [Side; 2],
    hand: HandModel,
    motion: HandMotion,
    place: VirtualWall,
    history: <VirtualWall as Environment<f64, 1>>::History,
    /// From master to slave, and back.
    ways: [Channel; 2],
    sample_time: f64,
    tick: u64,
    held_j: f64,
    damped_j: f64,
}

impl TeleoperationExperiment {
    /// Both sides at rest.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub(super) fn pair(&self) -> Result<Pair, Failure> {
        self.check_times()?;
        let t = self.sample_time();
        let step = Seconds(t.0 / SUB_STEPS as f64);
        let side = |side, held: HandModel, device: &MassDamperConfig| {
            let config = MassDamperConfig {
                damping: NewtonSecondsPerMetre(device.damping.0 + held.damping_n_s_per_m),
                stiffness: NewtonsPerMetre(held.stiffness_n_per_m),
                sample_time: step,
                ..*device
            };
            Ok::<_, Failure>(Side {
                port: self.port(side)?,
                plant: MassDamper::new(config).map_err(parameter)?,
                damping: device.damping.0,
            })
        };
        let free = HandModel {
            stiffness_n_per_m: 0.0,
            damping_n_s_per_m: 0.0,
        };
        let horizon = self.horizon() * SUB_STEPS as f64;
        let place = self.place.law(self.scheme, step, horizon)?;
        // Two seeds for each one.
        let way = |n| Channel::new(self.channel, t, self.seed.wrapping_mul(2).wrapping_add(n));
        Ok(Pair {
            sides: [
                side(HandSide::Master, self.hand, &self.master)?,
                side(HandSide::Slave, free, &self.slave)?,
            ],
            hand: self.hand,
            motion: self.motion.clone(),
            history: Environment::<f64, 1>::at_rest(&place),
            place,
            ways: [way(0).map_err(parameter)?, way(1).map_err(parameter)?],
            sample_time: t.0,
            tick: 0,
            held_j: 0.0,
            damped_j: 0.0,
        })
    }

    /// Runs it in virtual time without log or files; `true` if it reached its end with both sides at work.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn simulate(&self, sink: PairSink<'_>) -> Result<bool, Failure> {
        let mut pair = self.pair()?;
        for _ in 0..self.samples() {
            if sink(&pair.tick()).is_break() || pair.ended() {
                return Ok(false);
            }
        }
        Ok(true)
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
        let outside = [self.hand_force(time_s), self.place_force()];
        let (master, first) = self.sides[0].tick(tick, time_s, outside[0], &mut self.ways[0]);
        let (slave, second) = self.sides[1].tick(tick, time_s, outside[1], &mut self.ways[1]);
        let seen = PairTick {
            tick,
            time_s,
            hand_m: self.motion.at(time_s).0,
            sides: [master, slave],
            given_j: self.given_j(),
            held_j: self.held_j,
            damped_j: self.damped_j,
        };
        self.advance(time_s, [first, second]);
        self.tick += 1;
        seen
    }

    /// Devices, hand and place until the next tick.
    fn advance(&mut self, time_s: f64, forces: [SafeForce<f64, 1>; 2]) {
        let before = [0, 1].map(|n: usize| self.sides[n].plant.position()[0]);
        let step = self.sample_time / SUB_STEPS as f64;
        for sub in 0..SUB_STEPS {
            let (place, speed) = self.motion.at(time_s + (sub as f64 + 0.5) * step);
            let pull = self.hand.stiffness_n_per_m * place + self.hand.damping_n_s_per_m * speed;
            let pushed = self.place_force();
            let position = self.sides[1].plant.position();
            self.place.advance(&mut self.history, &position);
            for (n, outside) in [pull, pushed].into_iter().enumerate() {
                let Side { plant, damping, .. } = &mut self.sides[n];
                let from = plant.position()[0];
                plant.set_external_force(Vector1::new(outside));
                let Ok(()) = plant.write(forces[n]);
                let moved = plant.position()[0] - from;
                // At least this much: b·∫v² ≥ b·(Δx)²/Δt.
                self.damped_j += *damping * moved * moved / step;
            }
        }
        for n in 0..2 {
            let moved = self.sides[n].plant.position()[0] - before[n];
            self.held_j += forces[n].newtons()[0] * moved;
        }
    }

    /// Force of the hand on the master, N.
    fn hand_force(&self, time_s: f64) -> f64 {
        let (place, speed) = self.motion.at(time_s);
        let plant = &self.sides[0].plant;
        self.hand.stiffness_n_per_m * (place - plant.position()[0])
            + self.hand.damping_n_s_per_m * (speed - plant.velocity()[0])
    }

    /// Force of the remote place on the slave, N.
    fn place_force(&self) -> f64 {
        let position = self.sides[1].plant.position();
        self.place.force(&self.history, &position)[0]
    }

    fn given_j(&self) -> f64 {
        self.sides.iter().map(|side| side.port.given_j()).sum()
    }

    /// Master and slave.
    pub(super) fn ports(&self) -> [&Port<Operator<f64>>; 2] {
        [&self.sides[0].port, &self.sides[1].port]
    }

    /// From master to slave, and back.
    pub(super) const fn ways(&self) -> &[Channel; 2] {
        &self.ways
    }

    /// Lets both forces fall to zero.
    pub(super) fn stop(&mut self) {
        for side in &mut self.sides {
            side.port.stop();
        }
    }

    /// True if a side heard nothing for too long, or has a fault.
    pub(super) fn ended(&self) -> bool {
        let over = |port: &Port<_>| port.is_silent() || port.safety().fault().is_some();
        self.ports().into_iter().any(over)
    }

    /// True if both forces are zero.
    pub(super) fn is_at_rest(&self) -> bool {
        let at_rest = |port: &Port<_>| port.safety().is_at_rest();
        self.ports().into_iter().all(at_rest)
    }
}
