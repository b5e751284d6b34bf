//! Both sides and the line between them, tick by tick in virtual time.

use super::advice::parameter;
use super::body::Body;
use super::specification::TeleoperationExperiment;
use crate::document::failure::Failure;
use crate::run::ending::Ending;
use fracdiff::Operator;
use haptic_link::HandSide;
use haptic_loop::{Limiters, SafeForce};
use haptic_teleoperation::{Channel, Port};
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
    /// Master and slave.
    pub sides: [SideTick; 2],
    /// Energy that the line has given to both devices so far, J: `Σ f[n]·(x[n] − x[n−1])`.
    pub given_j: f64,
    /// The same with each force held until the next: `Σ f[n]·(x[n+1] − x[n])`, up to this tick.
    pub held_j: f64,
    /// Energy that the damping of both devices has taken at least, J, up to this tick: it has to pay for the hold.
    pub damped_j: f64,
}

/// Receiver of each tick; it may end the simulation.
pub type PairSink<'a> = &'a mut dyn FnMut(&PairTick) -> ControlFlow<()>;

/// A port and its device.
struct Side {
    port: Port<Operator<f64>>,
    body: Body,
}

impl Side {
    /// The port at work; its message is on the way.
    fn tick(&mut self, tick: u64, way: &mut Channel) -> (SideTick, SafeForce<f64, 1>) {
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
        };
        (seen, force)
    }
}

/// Both sides.
pub(super) struct Pair {
    sides: [Side; 2],
    /// From master to slave, and back.
    ways: [Channel; 2],
    sample_time: f64,
    tick: u64,
}

impl TeleoperationExperiment {
    /// Both sides at rest.
    ///
    /// # Errors
    /// A parameter outside its range.
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
        let way = |n| Channel::new(self.channel, t, self.seed.wrapping_mul(2).wrapping_add(n));
        Ok(Pair {
            sides: [side(HandSide::Master)?, side(HandSide::Slave)?],
            ways: [way(0).map_err(parameter)?, way(1).map_err(parameter)?],
            sample_time: t.0,
            tick: 0,
        })
    }

    /// Runs it in virtual time without log or files; `true` if it reached its end with both sides at work.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn simulate(&self, sink: PairSink<'_>) -> Result<bool, Failure> {
        let mut pair = self.pair()?;
        for _ in 0..self.samples() {
            if sink(&pair.tick()).is_break() || pair.ended().is_some() {
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
