//! A law that a pushed device feels, tried in virtual time: what a wall and a coupler share.

use crate::{
    settling::{Settling, TrialVerdict},
    setup::{TrialParts, TrialSetup},
};
use fracdiff::{Order, Scheme};
use haptic_analysis::Dynamics;
use haptic_document::{Failure, parameters::Parameter};
use haptic_loop::Environment;
use haptic_quantity::written;
use haptic_trial::preflight::PreflightVerdict;
use serde::Serialize;
use serde_json::Value;

/// A trial of a wall at one speed, or of a robot in one hand.
#[derive(Debug, Serialize)]
pub struct Hit {
    /// Mass of that hand, kg.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hand_mass_kg: Option<f64>,
    /// Its damping, N·s/m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hand_damping_n_s_per_m: Option<f64>,
    /// Its stiffness, N/m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hand_stiffness_n_per_m: Option<f64>,
    /// Speed of the hit, m/s.
    pub impact_m_per_s: f64,
    /// Verdict on the trial at this speed.
    pub verdict: TrialVerdict,
    /// The fault that ended it, in words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ended: Option<String>,
    /// Largest magnitude of the force, N.
    pub peak_force_n: f64,
}

impl Hit {
    /// The hand of a robot, or the speed of the hit, in words.
    pub fn words(&self) -> String {
        let hand = [
            ("mass_kg", self.hand_mass_kg),
            ("damping_n_s_per_m", self.hand_damping_n_s_per_m),
            ("stiffness_n_per_m", self.hand_stiffness_n_per_m),
        ];
        let hand = hand.map(|(key, value)| value.map(|value| written(key, value)));
        match hand {
            [Some(mass), Some(damping), Some(stiffness)] => {
                format!("in a hand of {mass}, {damping} and {stiffness}")
            }
            _ => format!("when it is hit at {} m/s", self.impact_m_per_s),
        }
    }
}

/// The loudest of these noises.
pub fn louder(noises: impl IntoIterator<Item = Option<f64>>) -> Option<f64> {
    noises.into_iter().flatten().reduce(f64::max)
}

/// A law on a pushed device.
pub trait PushedTrial: Clone {
    /// The law that the device feels.
    type Law: Environment<f64, 1, History: Send> + Send;
    /// Name of its table in an experiment file.
    const KIND: &'static str;
    /// Reason for a push that no rest position belongs to.
    const NO_REST: &'static str;
    /// Key with which an unstable trial is a failure.
    const MUST_BE_STABLE: Parameter;
    /// Said behind the verdict of a trial that this key refuses.
    const REFUSED: &'static str;

    /// Device, push and safety: everything but the law.
    fn setup(&self) -> &TrialSetup;

    /// Device, push and safety, to change.
    fn setup_mut(&mut self) -> &mut TrialSetup;

    /// Order and scheme of its operator.
    fn operator_choice(&self) -> (Order, Scheme);

    /// The law in words, for the line below a picture.
    fn law_in_words(&self) -> String;

    /// The loop, made of good parameters.
    ///
    /// # Errors
    /// Parameters of which no loop can be made.
    fn parts(&self) -> Result<TrialParts<Self::Law>, Failure>;

    /// Analysis of the loop with this device and `line` samples of delay on a line besides its own.
    ///
    /// # Errors
    /// Parameters outside what the analysis covers.
    fn judge(
        &self,
        samples: u64,
        dynamics: Dynamics,
        line: usize,
    ) -> Result<PreflightVerdict, Failure>;

    /// The law as its report has it, with the place at the end of an object behind it, m.
    fn law_in_rows(&self, settling: &Settling, object_m: Option<f64>) -> Value;

    /// True unless the pre-flight says something of the law that `must_be_stable` refuses beside an unstable loop.
    fn is_accepted(&self, _: &PreflightVerdict) -> bool {
        true
    }

    /// Speeds at which it is hit beside that of its plan, m/s: a device that stands here, of a law that never pulls.
    fn hits(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Runs it without log or files: does it settle, at each hit, and without friction too?
    ///
    /// # Errors
    /// As [`parts`](Self::parts): parameters of which no loop can be made.
    fn settled(&self) -> Result<Settling, Failure> {
        Ok(self.worst(self.named(self.tried()?)?)?.0)
    }

    /// The worst of this judgement and those of all further hits, and all of them if there are any.
    ///
    /// # Errors
    /// As [`parts`](Self::parts): parameters of which no loop can be made.
    fn worst(&self, recorded: Settling) -> Result<(Settling, Vec<Hit>), Failure> {
        let mut all = vec![recorded];
        let mut devices = vec![self.setup().device];
        for setup in self.setup().in_other_hands() {
            devices.push(setup.device);
            let mut other = self.clone();
            *other.setup_mut() = setup;
            all.push(other.tried()?);
        }
        for impact_m_per_s in self.hits() {
            let mut other = self.clone();
            other.setup_mut().plan.impact_m_per_s = impact_m_per_s;
            devices.push(other.setup().device);
            all.push(other.named(other.tried()?)?);
        }
        let worse = |a: Settling, b: &Settling| if b.verdict > a.verdict { *b } else { a };
        let worst = Settling {
            noise_n: louder(all.iter().map(|settling| settling.noise_n)),
            ..all.iter().fold(recorded, worse)
        };
        let tool = (self.setup().robot.as_deref()).map(|robot| robot.place.robot.tool_mass_kg());
        let of_hand = |value: f64| tool.map(|_| value);
        let several = all.len() > 1;
        let tried = all.iter().zip(&devices).filter(|_| several);
        let hits = tried.map(|(settling, hand)| Hit {
            hand_mass_kg: tool.map(|tool_kg| hand.mass.0 - tool_kg),
            hand_damping_n_s_per_m: of_hand(hand.damping.0),
            hand_stiffness_n_per_m: of_hand(hand.stiffness.0),
            impact_m_per_s: settling.impact_m_per_s,
            verdict: settling.verdict,
            ended: settling.ended.map(|ended| ended.reason(None)),
            peak_force_n: settling.peak_force_n,
        });
        Ok((worst, hits.collect()))
    }

    /// Runs it without log or files, to see if it settles.
    ///
    /// # Errors
    /// As [`parts`](Self::parts): parameters of which no loop can be made.
    fn tried(&self) -> Result<Settling, Failure> {
        self.parts().map(TrialParts::tried)
    }

    /// Changes the verdict if friction alone holds the device. Noise includes that of the device without friction: a moving hand feels it.
    ///
    /// # Errors
    /// As [`parts`](Self::parts): parameters of which no loop can be made.
    fn named(&self, settling: Settling) -> Result<Settling, Failure> {
        let Some(smooth) = self.setup().smooth().filter(|_| settling.stable) else {
            return Ok(settling);
        };
        let mut other = self.clone();
        *other.setup_mut() = smooth;
        let smooth = other.tried()?;
        if smooth.stable {
            Ok(Settling {
                noise_n: louder([settling.noise_n, smooth.noise_n]),
                ..settling
            })
        } else {
            Ok(settling.by_friction("without friction the device does not come to rest"))
        }
    }
}

/// Value to six significant digits, as a subtitle shows a number.
pub(crate) fn six_digits(value: f64) -> f64 {
    // A formatted number is a number again.
    format!("{value:.5e}").parse().unwrap_or(value)
}
