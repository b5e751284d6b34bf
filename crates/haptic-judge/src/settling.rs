//! Judging a trial: does a device that hits a wall and is pushed into it come to rest?
//!
//! ```text
//! over the last window (0.4 s of 5 s), std = standard deviation:
//! std of the position ≤ max(2 q, 1 % of push/(K + k))      q: encoder step, m
//! std of the force    ≤ max(min((K + B·T^(−μ))·q, 25 % of the push), 5 % of the push)
//!                                                (K + B·T^(−μ))·q: one encoder step through the law
//! largest − least force ≤ the push
//! force at its limit for more than 50 ms:  saturated, whatever the rest says
//! ```
//! - A buzzing wall moves a stiff device by little and its force by much, so both are judged. A threshold
//!   for the position alone, like the dissertation's 0.1 mm, is half the deflection of a wall of 5 kN/m and
//!   ten times that of one of 100 kN/m: a wall that buzzes against the force limit passes it.
//! - *Saturated*: one impact may reach the limit; a share of the samples would allow a longer trial more of it.
//! - *Untouched*: a wall that makes no force over the window proves nothing. Nobody may have pushed a real device.
//! - *One encoder step* through the law is the least force that such a wall can change by, so a wall at
//!   rest may vary by it; but by at most a quarter of the push. A wall whose own step is larger shakes the hand,
//!   whatever the encoder has to do with it: it is stable only if it hardly makes such a step.
//! - *A standard deviation hides rare swings*: a force that swings by more than the push from end to end lets go of the
//!   device now and then, however small its deviation.
//! - *Noise* of the sensor counts as an encoder whose steps have the same rms: q = √12·σ.
//! - *Without a spring* (K + k = 0) the device gives way for ever, and the force alone is judged, however far it has gone.
//! - *A law that integrates* brings the device back to its start, by powers of time. There the force alone is judged, and law and hand have to
//!   hold the push up to 5 %, so that a device that drifts is not at rest.
//! - *[`Criterion::Dissertation`]* is the old rule: the position alone against one threshold. Friction may hold the device.
//!
//! - *A wall that never pulls* may settle after one hit and grow after another: it is hit at several speeds, and the worst of these
//!   trials is the verdict.
//!
//! Source of the old rule: O. Tokatlı, *Fractional Order Control in Haptics*, section 4.4, figure 4.3.

use crate::swings::{Swings, Taps};
use haptic_document::named;
use haptic_trial::{
    ending::{AT_LIMIT, Ending, MotorPush},
    tap::TappedLaw,
};
use serde::Serialize;

/// Time for which the force may be at its limit, s, in any run: a share of it would allow a longer one more.
pub const SATURATED_S: f64 = 0.05;

/// Rule by which a trial is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Criterion {
    /// Position, force and the force limit.
    Settling,
    /// That of the dissertation's figure 4.3: a push from rest, and the standard deviation of the position against a threshold.
    Dissertation,
}

named! { Criterion:
    Settling = "settling", "Position and force come to rest";
    Dissertation = "dissertation", "The position varies by little, after a push from rest";
}

/// Everything about a wall that its tolerance depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrialScales {
    /// Push into the wall, N.
    pub push_n: f64,
    /// Wall and hand together, N/m.
    pub spring_n_per_m: f64,
    /// K + B·T^(−μ), N/m: force of a step of the position.
    pub step_n_per_m: f64,
    /// Encoder step, or what stands for noise, m.
    pub encoder_step_m: f64,
    /// Standard deviation of the position that the dissertation's rule allows, m.
    pub threshold_m: f64,
}

/// Largest variation of a wall at rest; `None` for any.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tolerance {
    position_std_m: Option<f64>,
    force_std_n: Option<f64>,
    /// Difference of the least and the largest force, N.
    force_range_n: Option<f64>,
    /// Time at the force limit, s.
    limited_s: Option<f64>,
}

/// Share of the deflection by which a position at rest may vary.
const POSITION_SHARE: f64 = 0.01;

/// Encoder steps by which it may vary.
const STEPS: f64 = 2.0;

/// A wall at rest lets the force swing by this share of the push from end to end: a force that is half the push too
/// large or too small has let go of the device, however rarely.
const FORCE_RANGE_SHARE: f64 = 1.0;
/// Share of the push by which a force at rest may vary.
const FORCE_SHARE: f64 = 0.05;

/// Share of the push beyond which one encoder step is no excuse.
const FORCE_STEP_SHARE: f64 = 0.25;

impl Tolerance {
    /// The tolerance by this criterion.
    pub fn new(criterion: Criterion, scales: TrialScales) -> Self {
        match criterion {
            Criterion::Dissertation => Self {
                position_std_m: Some(scales.threshold_m),
                ..Self::default()
            },
            Criterion::Settling => {
                let step = scales.encoder_step_m;
                let held = scales.spring_n_per_m > 0.0;
                let deflection = scales.push_n / scales.spring_n_per_m;
                let force_step = (scales.step_n_per_m * step).min(FORCE_STEP_SHARE * scales.push_n);
                Self {
                    position_std_m: held.then(|| (STEPS * step).max(POSITION_SHARE * deflection)),
                    force_std_n: Some(force_step.max(FORCE_SHARE * scales.push_n)),
                    force_range_n: Some(FORCE_RANGE_SHARE * scales.push_n),
                    limited_s: Some(SATURATED_S),
                }
            }
        }
    }
}

/// A device this far away has left, m: it will not come to rest.
pub const GONE_M: f64 = 1.0;

/// The outcome of a trial, from the best to the worst.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum TrialVerdict {
    /// Device at rest, and not by friction alone.
    Stable,
    /// Device at rest, but perhaps only because friction holds it: without friction it is not, or taps are too small beside friction to tell.
    HeldByFriction,
    /// Not at rest, or swinging in a way that does not die.
    Unstable,
    /// The force was at its limit for too long: the limit was tried, not the wall.
    Saturated,
    /// No force was made at the end: nothing was tried.
    Untouched,
    /// The device was farther away than [`GONE_M`].
    Gone,
    /// A fault or an interruption ended the trial.
    Unfinished,
}

impl TrialVerdict {
    /// The outcome in words.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Stable => "stable",
            Self::HeldByFriction => "held by friction",
            Self::Unstable => "unstable",
            Self::Saturated => "saturated",
            Self::Untouched => "untouched",
            Self::Gone => "gone",
            Self::Unfinished => "not finished",
        }
    }
}

/// State of the device at the end, and whether it is at rest. Its fields are keys of reports.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Settling {
    /// True if it is at rest, and not by friction alone.
    pub stable: bool,
    /// The outcome; `stable` is true for the best one only.
    pub verdict: TrialVerdict,
    /// The rule by which it is judged.
    pub criterion: Criterion,
    /// Speed at which the device hit the wall, m/s; 0 for a push from rest.
    pub impact_m_per_s: f64,
    /// Standard deviation of the position over the window, m; null if the device has left or the trial did
    /// not reach its end.
    pub position_std_m: Option<f64>,
    /// The largest motion that counts as rest, m; null without a spring, because the device then
    /// never stops giving way.
    pub position_std_limit_m: Option<f64>,
    /// Standard deviation of the force over the window, N.
    pub force_std_n: Option<f64>,
    /// The largest force that counts as rest, N; null if the criterion ignores it.
    pub force_std_limit_n: Option<f64>,
    /// Difference between the largest and the least force in the window, N.
    pub force_range_n: Option<f64>,
    /// The largest such range that counts as rest, N; null if the criterion ignores it.
    pub force_range_limit_n: Option<f64>,
    /// Time for which the force was at its limit, s.
    pub saturated_s: f64,
    /// Mean of the position over the window, m.
    pub deflection_m: Option<f64>,
    /// Position at which the push is in balance with wall and hand, m; null without a spring.
    pub expected_deflection_m: Option<f64>,
    /// Decay of the swings after taps.
    #[serde(flatten)]
    pub swings: Option<Swings>,
    /// Why friction alone may hold it, where no swing was judged.
    #[serde(skip)]
    pub held_because: &'static str,
    /// The fault that ended a trial in virtual time, if one did.
    #[serde(skip)]
    pub ended: Option<Ending>,
    /// Largest magnitude of the force, N.
    #[serde(skip)]
    pub peak_force_n: f64,
    /// Largest standard deviation of the force over the second half of all hits, N: over the window it scatters.
    #[serde(skip)]
    pub noise_n: Option<f64>,
    /// Largest force into the wall, N, and the position there, m.
    #[serde(skip)]
    pub largest_pull: (f64, f64),
}

impl Settling {
    /// Changes the verdict to rest by friction, for this reason.
    pub fn by_friction(self, why: &'static str) -> Self {
        Self {
            stable: false,
            verdict: TrialVerdict::HeldByFriction,
            held_because: why,
            ..self
        }
    }

    /// Why it is not stable, in words; `None` if it is.
    pub fn reason(&self) -> Option<String> {
        match self.verdict {
            TrialVerdict::Stable => None,
            TrialVerdict::HeldByFriction => Some(match &self.swings {
                None => self.held_because.to_owned(),
                Some(swings) => format!(
                    "a tap of {:.3} N is too small beside friction to tell; one of 25 times the friction, {:.3} N, tells",
                    swings.tap_n,
                    25.0 * swings.friction_n
                ),
            }),
            TrialVerdict::Saturated => Some(format!(
                "the force was at its limit for {:.0} ms, more than {} ms",
                1e3 * self.saturated_s,
                1e3 * SATURATED_S
            )),
            TrialVerdict::Untouched => Some(
                "nothing touched it at the end: push the device into it all the time".to_owned(),
            ),
            TrialVerdict::Gone => Some(format!("the device was more than {GONE_M} m away")),
            TrialVerdict::Unfinished => {
                let ended = self.ended.map(|ended| format!(": {}", ended.reason(None)));
                Some("the trial did not reach its end".to_owned() + &ended.unwrap_or_default())
            }
            TrialVerdict::Unstable if self.force_range_n.is_none() => Some(format!(
                "{}; what followed was not judged",
                Ending::Swing.reason(None)
            )),
            TrialVerdict::Unstable => {
                if let Some(swings) = self.swings.filter(|swings| swings.dies == Some(false)) {
                    return Some(format!(
                        "after a tap {:.4} [{:.4}, {:.4}] of each swing is left in the next, more than {:.4}",
                        swings.swing_ratio,
                        swings.swing_ratio_from,
                        swings.swing_ratio_to,
                        swings.swing_ratio_limit
                    ));
                }
                let (position, force, range) = (
                    (self.position_std_m, self.position_std_limit_m),
                    (self.force_std_n, self.force_std_limit_n),
                    (self.force_range_n, self.force_range_limit_n),
                );
                let all = [
                    ("the position varies by", position, "m"),
                    ("the force varies by", force, "N"),
                    ("the force swings over", range, "N"),
                ];
                let over = all.into_iter().filter_map(|(what, (have, most), unit)| {
                    let (have, most) = (have?, most?);
                    (have > most)
                        .then(|| format!("{what} {have:.3e} {unit}, more than {most:.3e} {unit}"))
                });
                let over: Vec<String> = over.collect();
                Some(format!("at the end {}", over.join(", and ")))
            }
        }
    }
}

/// Running mean and variance (B. P. Welford, *Technometrics* 4(3), 1962).
#[derive(Clone, Copy, Debug, Default)]
struct Moments {
    count: f64,
    mean: f64,
    squares: f64,
}

impl Moments {
    fn add(&mut self, value: f64) {
        self.count += 1.0;
        let change = value - self.mean;
        self.mean += change / self.count;
        self.squares += change * (value - self.mean);
    }

    fn deviation(&self) -> f64 {
        (self.squares / self.count).sqrt()
    }
}

/// Looks on while a device is tried.
#[derive(Clone, Debug)]
pub struct Judge {
    criterion: Criterion,
    impact_m_per_s: f64,
    tolerance: Tolerance,
    /// Begin of the window, s.
    from_s: f64,
    /// Begin of the second half, s.
    half_s: f64,
    force_limit_n: f64,
    push: Option<MotorPush>,
    taps: Option<Taps>,
    /// Push, N, and spring of a hand, N/m, which a law that integrates balances at rest.
    balanced: Option<[f64; 2]>,
    last_s: f64,
    limited_s: f64,
    position: Moments,
    force: Moments,
    /// Moments of the force in the second half.
    late_force: Moments,
    /// Least and largest force in the window, N.
    force_ends_n: (f64, f64),
    /// Largest magnitude of the force, N.
    peak_force_n: f64,
    /// Largest force into the wall, N, and the position there, m.
    largest_pull: (f64, f64),
    gone: bool,
    swung: bool,
}

impl Judge {
    /// Judge of a trial that has not begun.
    pub fn new(
        criterion: Criterion,
        impact_m_per_s: f64,
        tolerance: Tolerance,
        from_s: f64,
        half_s: f64,
        force_limit_n: f64,
    ) -> Self {
        Self {
            criterion,
            impact_m_per_s,
            tolerance,
            from_s,
            half_s,
            force_limit_n,
            push: None,
            taps: None,
            balanced: None,
            last_s: 0.0,
            limited_s: 0.0,
            position: Moments::default(),
            force: Moments::default(),
            late_force: Moments::default(),
            force_ends_n: (f64::INFINITY, f64::NEG_INFINITY),
            peak_force_n: 0.0,
            largest_pull: (0.0, 0.0),
            gone: false,
            swung: false,
        }
    }

    /// Judges the law that a motor pushes into: of the forces that it sees all but the push of the device's own motor.
    pub fn behind(self, push: Option<MotorPush>) -> Self {
        Self { push, ..self }
    }

    /// Takes note that a swing ended the run: the limit of the device may be below the one that was asked for.
    pub const fn swung(&mut self) {
        self.swung = true;
    }

    /// Judges the swings after the taps of a law, if there are some, and the rest over the end of the time after the last one. A step of the
    /// encoder, m, makes so much force through the law, N/m.
    pub fn tapped(self, law: Option<&TappedLaw>, encoder_step_m: f64, step_n_per_m: f64) -> Self {
        let Some(law) = law else {
            return self;
        };
        let (ticks, t) = (law.ticks(), law.device.sample_time.0);
        let quiet_s = 0.25 * f64::from(ticks) * t;
        let taps = Taps {
            ticks: ticks as usize,
            settles_in: law.samples as f64,
            hand_n_per_m: law.device.stiffness.0,
            friction_n: law.device.friction.0,
            encoder_step_m,
            step_n: step_n_per_m * encoder_step_m,
            tick_m_per_n: t * t / law.device.mass.0,
            seen: Vec::new(),
        };
        Self {
            taps: Some(taps),
            from_s: self.from_s.max(2.0 * self.half_s - quiet_s),
            ..self
        }
    }

    /// Judges a law that brings the device back to its start, however slowly: at rest it holds the push, less what a hand's spring does.
    pub fn balancing(self, push_n: f64, hand_n_per_m: f64) -> Self {
        Self {
            balanced: Some([push_n, hand_n_per_m]),
            ..self
        }
    }

    fn is_balanced(&self) -> bool {
        self.balanced.is_none_or(|[push_n, hand_n_per_m]| {
            let left_n = push_n + self.force.mean - hand_n_per_m * self.position.mean;
            left_n.abs() <= FORCE_SHARE * push_n
        })
    }

    /// True if the device should stay where it is: without a spring it gives way, the farther the longer it is pushed.
    fn is_held(&self) -> bool {
        self.tolerance.position_std_m.is_some() || self.balanced.is_some()
    }

    /// One sample; `false` if the device has left, or has swung while a motor pushed, so that nothing more can come of it.
    pub fn see(&mut self, time_s: f64, position_m: f64, force_n: f64) -> bool {
        if force_n.abs() >= AT_LIMIT * self.force_limit_n {
            self.limited_s += time_s - self.last_s;
        }
        self.last_s = time_s;
        let swings =
            |push: MotorPush| push.swings(force_n, self.force_limit_n, self.taps.is_some());
        self.swung |= self.push.is_some_and(swings);
        if let Some(taps) = &mut self.taps {
            taps.seen.push((position_m, force_n));
        }
        let force_n = force_n - self.push.map_or(0.0, MotorPush::own_n);
        self.peak_force_n = self.peak_force_n.max(force_n.abs());
        if force_n > self.largest_pull.0 {
            self.largest_pull = (force_n, position_m);
        }
        self.gone |= position_m.is_nan() || self.is_held() && position_m.abs() > GONE_M;
        if time_s >= self.half_s {
            self.late_force.add(force_n);
        }
        if time_s >= self.from_s {
            self.position.add(position_m);
            self.force.add(force_n);
            let (least, most) = self.force_ends_n;
            self.force_ends_n = (least.min(force_n), most.max(force_n));
        }
        !(self.gone || self.swung)
    }

    /// The judgement of a trial that reached its end, or did not.
    pub fn settling(&self, whole: bool, expected_deflection_m: Option<f64>) -> Settling {
        let seen = whole && !(self.gone || self.swung) && self.position.count > 0.0;
        let deviations = seen.then(|| (self.position.deviation(), self.force.deviation()));
        let range = self.force_ends_n.1 - self.force_ends_n.0;
        let within = |have: f64, most: Option<f64>| most.is_none_or(|most| have <= most);
        let swings = self.taps.as_ref().filter(|_| seen).and_then(Taps::swings);
        let window = self.position.count as usize;
        let falls = (self.taps.as_ref()).is_some_and(|taps| taps.falls(window));
        let rests = deviations.is_some_and(|(position, force)| {
            within(position, self.tolerance.position_std_m)
                && within(force, self.tolerance.force_std_n)
                && within(range, self.tolerance.force_range_n)
                && self.is_balanced()
        });
        let verdict = match deviations {
            _ if self.gone => TrialVerdict::Gone,
            _ if self.swung => TrialVerdict::Unstable,
            None => TrialVerdict::Unfinished,
            Some(_) if !within(self.limited_s, self.tolerance.limited_s) => TrialVerdict::Saturated,
            // After taps what still falls rests in the end.
            Some(_) if rests || falls => {
                match (&self.taps, swings.and_then(|swings| swings.dies)) {
                    _ if self.force_ends_n == (0.0, 0.0) => TrialVerdict::Untouched,
                    (None, _) | (_, Some(true)) => TrialVerdict::Stable,
                    (_, Some(false)) => TrialVerdict::Unstable,
                    (_, None) => TrialVerdict::HeldByFriction,
                }
            }
            Some(_) => TrialVerdict::Unstable,
        };
        Settling {
            stable: verdict == TrialVerdict::Stable,
            verdict,
            criterion: self.criterion,
            impact_m_per_s: self.impact_m_per_s,
            position_std_m: deviations.map(|(position, _)| position),
            position_std_limit_m: self.tolerance.position_std_m,
            force_std_n: deviations.map(|(_, force)| force),
            force_std_limit_n: self.tolerance.force_std_n,
            force_range_n: seen.then_some(range),
            force_range_limit_n: self.tolerance.force_range_n,
            saturated_s: self.limited_s,
            deflection_m: seen.then_some(self.position.mean),
            expected_deflection_m,
            swings,
            held_because: "the trial is too short for taps: make it longer",
            ended: None,
            peak_force_n: self.peak_force_n,
            noise_n: deviations.map(|_| self.late_force.deviation()),
            largest_pull: self.largest_pull,
        }
    }
}

#[cfg(test)]
mod tests {
    //! Motions that rest, buzz, slide or leave.

    use crate::settling::*;

    /// 1 N into 100 kN/m through an encoder of 1 µm, 50 N/m of dissipation a step.
    const STIFF: TrialScales = TrialScales {
        push_n: 1.0,
        spring_n_per_m: 1e5,
        step_n_per_m: 5e4,
        encoder_step_m: 1e-6,
        threshold_m: 1e-4,
    };

    fn judge(criterion: Criterion, scales: TrialScales) -> Judge {
        let tolerance = Tolerance::new(criterion, scales);
        Judge::new(criterion, 0.1, tolerance, 4.6, 2.5, 3.3)
    }

    /// Judges 5 s at 1 kHz of these positions and forces, the window being the last 0.4 s.
    fn seen(mut judge: Judge, motion: impl Fn(u32) -> (f64, f64)) -> Settling {
        for n in 0..5001 {
            let (position, force) = motion(n);
            judge.see(1e-3 * f64::from(n), position, force);
        }
        judge.settling(true, None)
    }

    fn judged(
        criterion: Criterion,
        scales: TrialScales,
        motion: impl Fn(u32) -> (f64, f64),
    ) -> Settling {
        seen(judge(criterion, scales), motion)
    }

    fn sign(n: u32) -> f64 {
        if n.is_multiple_of(2) { 1.0 } else { -1.0 }
    }

    #[test]
    fn a_wall_that_buzzes_below_a_tenth_of_a_millimetre_is_not_stable() {
        let buzzing = |n| (10e-6 + 9e-6 * sign(n), -1.0 + 2.3 * sign(n));
        let new = judged(Criterion::Settling, STIFF, buzzing);
        assert_eq!(new.verdict, TrialVerdict::Saturated);
        let old = judged(Criterion::Dissertation, STIFF, buzzing);
        assert_eq!(old.verdict, TrialVerdict::Stable);
    }

    #[test]
    fn a_wall_rests_whose_position_and_force_vary_by_no_more_than_its_encoder_and_a_share_of_the_push()
     {
        let encoder = |encoder_step_m| TrialScales {
            encoder_step_m,
            ..STIFF
        };
        // 2 N into 650 kN/m of dissipation a step and 4 µm: 2.6 N a step, 0.5 N allowed.
        let coarse = TrialScales {
            push_n: 2.0,
            step_n_per_m: 6.5e5,
            ..encoder(4e-6)
        };
        let without_spring = TrialScales {
            spring_n_per_m: 0.0,
            ..STIFF
        };
        let buzzes = |m: f64, n: f64| move |tick| (10e-6 + m * sign(tick), -1.0 + n * sign(tick));
        let rarely = |n: f64| {
            move |tick: u32| {
                let swing_n = if tick.is_multiple_of(50) { n } else { 0.0 };
                (10e-6, swing_n - 1.0)
            }
        };
        let hits = |samples| move |n| (10e-6, if n < samples { -3.3 } else { -1.0 });
        let slides = |n| (1e-3 * f64::from(n), -1.0);
        let left = |n| if n == 3 { (1e-6, -0.1) } else { (-1e-3, 0.0) };
        type Motion<'a> = &'a dyn Fn(u32) -> (f64, f64);
        use TrialVerdict::{Saturated, Stable, Unstable, Untouched};
        for (scales, motion, verdict) in [
            (STIFF, &buzzes(3e-6, 0.0) as Motion<'_>, Unstable),
            (STIFF, &buzzes(0.0, 0.06), Unstable),
            (STIFF, &buzzes(1.9e-6, 0.049), Stable),
            // One step of the encoder through the operator: 50 kN/m of dissipation a step and 2 µm, 0.1 N.
            (encoder(2e-6), &buzzes(0.0, 0.09), Stable),
            (STIFF, &buzzes(0.0, 0.09), Unstable),
            // A step of more than a quarter of the push is no excuse.
            (coarse, &buzzes(0.0, 1.3), Unstable),
            (coarse, &buzzes(0.0, 0.51), Unstable),
            (coarse, &buzzes(0.0, 0.49), Stable),
            // A standard deviation of 0.25 N is excused: one sample of fifty swings by 1.1 N, 0.15 N rms, more than the push.
            (encoder(5e-6), &rarely(1.1), Unstable),
            (encoder(5e-6), &rarely(0.9), Stable),
            // An impact may reach the limit for 50 ms.
            (STIFF, &hits(50), Stable),
            (STIFF, &hits(52), Saturated),
            (STIFF, &left, Untouched),
            // Without a spring the force alone is judged.
            (without_spring, &slides, Stable),
        ] {
            let settling = judged(Criterion::Settling, scales, motion);
            assert_eq!(settling.verdict, verdict, "{settling:?}");
            assert_eq!(settling.stable, verdict == Stable);
            assert_eq!(settling.reason().is_none(), settling.stable);
        }
        assert!(!judged(Criterion::Dissertation, without_spring, slides).stable);
    }

    #[test]
    fn what_leaves_or_never_ends_is_not_stable() {
        let mut judge = judge(Criterion::Settling, STIFF);
        assert!(judge.see(0.0, 0.0, 0.0));
        assert_eq!(judge.settling(true, None).verdict, TrialVerdict::Unfinished);
        assert!(!judge.see(1.0, f64::NAN, 0.0));
        assert_eq!(judge.settling(true, None).verdict, TrialVerdict::Gone);
    }

    #[test]
    fn a_law_that_integrates_is_at_rest_when_it_holds_the_push_beside_the_hand() {
        let scales = TrialScales {
            spring_n_per_m: 0.0,
            ..STIFF
        };
        for (force_n, position_m, rests) in [
            (-0.96, 0.0, true),
            (-0.94, 0.0, false),
            // A drift against hardly any force.
            (-1e-3, 0.1, false),
            // A hand of 50 N/m holds a half.
            (-0.5, 0.01, true),
            (-1.0, 0.01, false),
        ] {
            let judge = judge(Criterion::Settling, scales).balancing(1.0, 50.0);
            let settling = seen(judge, |_| (position_m, force_n));
            assert_eq!(settling.stable, rests, "{force_n}");
        }
    }
}
