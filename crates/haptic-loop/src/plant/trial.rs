//! A wall on a simulated axis, with a push of its own or without, tick by tick, with every type known.

use super::{MassDamper, Sensed};
use crate::{Controller, OwnPush, Pushing, Wall};
use fracdiff::Operator;

/// A wall that only pushes or pulls too, with a push of its own or without.
type PushedWall = OwnPush<f64, Pushing<Wall<f64, Operator<f64>>>>;

/// Runs the loop of a wall on a simulated axis in virtual time:
/// [`Engaged::run`](crate::Engaged::run), compiled here once and optimised even in a development
/// build, because a search for the stiffest wall ticks it millions of times.
///
/// `see` looks at time, s, position, m, and force, N, of each sample, and ends the run by false. `true` if it reached the end
/// without a fault. No force remains.
pub fn run_wall(
    controller: &mut Controller<f64, 1, PushedWall>,
    device: &mut Sensed<MassDamper<1>>,
    ticks: u64,
    see: &mut dyn FnMut(f64, f64, f64) -> bool,
) -> bool {
    let Ok(whole) = controller.engage(device).run(ticks, |sample| {
        let reading = &sample.reading;
        see(
            reading.time_s,
            reading.position_m[0],
            sample.force.newtons()[0],
        )
    });
    whole
}
