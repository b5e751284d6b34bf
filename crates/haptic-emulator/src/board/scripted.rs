//! A hand that follows a script, to rehearse an experiment with people.
//!
//! ```text
//! m·x'' + (b + b_h)·x' + k_h·x = f + k_h·x_h + b_h·v_h
//! ```
//! - *Symbols*: m, b device; f its force; `x_h`, `v_h` place and speed that the hand wants, held over a sample; `k_h`, `b_h` its grip, part of the
//!   plant and so exact between samples.
//! - *Start of a run*: at rest at 0, with the first move; after the last the script begins again, until the run ends.

use crate::lead::lead;
use core::convert::Infallible;
use fracdiff::{
    Real,
    parameter::{positive, range},
};
use haptic_loop::{
    Device, LoopParameterError, Reading, SafeForce,
    plant::{MassDamper, MassDamperConfig},
    units::{Metres, NewtonSecondsPerMetre, NewtonsPerMetre, Seconds},
};

/// `k_h`, N/m, and `b_h`, N·s/m: those of a finger, as in a simulated session.
const GRIP: (f64, f64) = (300.0, 5.5);
/// Time in which a hand goes from one place to the next, s, if its move is not shorter.
const LEAD_S: f64 = 0.3;

/// Places that a hand goes to, each with the time until it leaves it, over and over.
///
/// ```
/// use haptic_emulator::board::HandScript;
/// use haptic_loop::units::{Metres, Seconds};
///
/// let script = HandScript::new([(Metres(3e-3), Seconds(2.0)), (Metres(-5e-3), Seconds(1.0))])?;
/// assert_eq!(script.wanted(1.0), (3e-3, 0.0));
/// assert_eq!(script.wanted(5.9), (-5e-3, 0.0));
/// # Ok::<(), haptic_loop::LoopParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct HandScript {
    /// Places, m, and times, s.
    moves: Vec<(f64, f64)>,
    period_s: f64,
}

impl HandScript {
    /// A script of these moves; one without any holds the handle at 0.
    ///
    /// # Errors
    /// A place that is not finite, a time that is not above 0.
    pub fn new(
        moves: impl IntoIterator<Item = (Metres, Seconds)>,
    ) -> Result<Self, LoopParameterError> {
        let checked = moves.into_iter().map(|(place, time)| {
            let place_m = range("place of the hand", place.0, true, "finite", "m")?;
            Ok((place_m, positive("time of a move", time.0, "s")?))
        });
        let moves = checked.collect::<Result<Vec<_>, LoopParameterError>>()?;
        Ok(Self {
            period_s: moves.iter().map(|(_, time_s)| time_s).sum(),
            moves,
        })
    }

    /// Place and speed that the hand wants at a time of the run, m and m/s.
    #[must_use]
    pub fn wanted(&self, time_s: f64) -> (f64, f64) {
        let last_m = self.moves.last().map_or(0.0, |(place_m, _)| *place_m);
        let mut from_m = if time_s < self.period_s { 0.0 } else { last_m };
        let mut since_s = libm::fmod(time_s, self.period_s);
        for &(place_m, move_s) in &self.moves {
            if since_s < move_s {
                let (share, rate) = lead(since_s, LEAD_S.min(move_s));
                let way_m = place_m - from_m;
                return (from_m + way_m * share, way_m * rate);
            }
            since_s -= move_s;
            from_m = place_m;
        }
        (last_m, 0.0)
    }
}

/// A device of one axis in this hand.
#[derive(Clone, Debug)]
pub(super) struct ScriptedDevice {
    plant: MassDamper<1>,
    script: HandScript,
    ticks: u64,
}

impl ScriptedDevice {
    /// A device at rest, its stiffness that of the hand.
    ///
    /// # Errors
    /// As [`MassDamper::new`].
    pub(super) fn new(
        free: MassDamperConfig,
        script: HandScript,
    ) -> Result<Self, LoopParameterError> {
        let (stiffness, damping) = GRIP;
        let held = MassDamperConfig {
            stiffness: NewtonsPerMetre(stiffness),
            damping: NewtonSecondsPerMetre(free.damping.0 + damping),
            ..free
        };
        Ok(Self {
            plant: MassDamper::new(held)?,
            script,
            ticks: 0,
        })
    }

    /// Force of the hand on the handle now, N.
    pub(super) fn contact_force(&self) -> f64 {
        self.plant.contact_force()[0] - GRIP.1 * self.plant.velocity()[0]
    }

    pub(super) fn restart(&mut self) {
        self.ticks = 0;
        self.plant.restart();
        self.plant.set_external_force([0.0].into());
    }
}

impl<F: Real> Device<F, 1> for ScriptedDevice {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<F, 1>, Infallible> {
        self.plant.read()
    }

    fn write(&mut self, force: SafeForce<F, 1>) -> Result<(), Infallible> {
        let time_s = self.ticks as f64 * self.plant.config().sample_time.0;
        let (place_m, speed_m_per_s) = self.script.wanted(time_s);
        let pull_n = GRIP.0 * place_m + GRIP.1 * speed_m_per_s;
        self.plant.set_external_force([pull_n].into());
        self.ticks += 1;
        self.plant.write(force)
    }
}

#[cfg(test)]
mod tests;
