//! The certified verdict on a controller that holds an indenter.

use haptic_document::{
    Failure, bad_input,
    parameters::{CONTROLLER, FORCE_UNSTABLE},
};
use serde::Serialize;

/// The certified verdict on one loop of a drive, and how far it is from the edge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct LoopVerdict {
    /// No pole on or outside the unit circle, proved.
    pub stable: bool,
    /// Phase margin, rad; null if |L| is never 1, and of an unstable loop, which has no margins.
    pub phase_margin_rad: Option<f64>,
    /// The crossover of that phase margin, rad/s; null without one.
    pub crossover_rad_s: Option<f64>,
    /// The least gain above 1 at which the loop is at the edge; null if none is.
    pub gain_margin: Option<f64>,
    /// The least further time by which the force of the drive may act later at which it is, s: a force is held, and switches inside a sample.
    /// Null if none is.
    pub delay_margin_s: Option<f64>,
    /// Gain, as a multiple of the present one, beyond which an unstable loop is stable:
    /// below it if it is below 1, above it if it is above 1. Null if no such gain exists within a
    /// factor of a hundred, or if the loop is stable.
    pub stable_beyond_gain: Option<f64>,
}

impl LoopVerdict {
    /// The gain that would make an unstable loop stable, in words.
    fn remedy(&self) -> String {
        match self.stable_beyond_gain {
            Some(gain) if gain < 1.0 => {
                // Rounded down, so that what is proposed is accepted.
                format!("with {:.2e} of its gain it is stable", 0.99 * gain)
            }
            Some(gain) => format!("with more than {gain:.3} times its gain it is stable"),
            None => "no other gain makes it stable".to_owned(),
        }
    }
}

/// The verdict on a drive.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct DriveVerdict {
    /// Before contact; null where a force is the set point.
    pub free: Option<LoopVerdict>,
    /// Verdict in contact with the tissue; null on a device whose tissue is a chain of parts.
    pub in_contact: Option<LoopVerdict>,
    /// The spring that holds a tissue without one in this judgement, N/m; null if it is judged
    /// without one.
    pub holding_stiffness_n_per_m: Option<f64>,
}

impl DriveVerdict {
    /// Its place in the metadata of a log.
    pub const KEY: &str = "drive.preflight";

    /// Both, with where each holds.
    fn loops(&self) -> impl Iterator<Item = (LoopVerdict, &'static str)> {
        let free = self
            .free
            .map(|verdict| (verdict, "before it touches the tissue"));
        let contact = self.in_contact;
        let contact = contact.map(|verdict| (verdict, "in contact with the tissue"));
        free.into_iter().chain(contact)
    }

    /// True if both loops are stable.
    pub fn stable(&self) -> bool {
        self.loops().all(|(looked_at, _)| looked_at.stable)
    }

    /// Refuses what is unstable, unless it is forced.
    ///
    /// # Errors
    /// Says which loop would be unstable, and which gain would not.
    pub fn require_stable(&self, force: bool) -> Result<(), Failure> {
        let unstable = self.loops().find(|(looked_at, _)| !looked_at.stable);
        let Some((unstable, whether)) = unstable.filter(|_| !force) else {
            return Ok(());
        };
        let remedy = unstable.remedy();
        Err(bad_input!(
            "pre-flight: the loop of the drive would be unstable {whether}; {remedy}: use another {CONTROLLER}, or {FORCE_UNSTABLE}"
        ))
    }
}
