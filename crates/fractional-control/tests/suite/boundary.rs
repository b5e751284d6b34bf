//! The certified verdict against simulation on both sides of the boundary.

use crate::fixture::{Draw, bdf2, held, states};
use fracdiff::Seconds;
use fractional_control::{
    Actuator, FractionalPid, FractionalTransferFunction, HeldPlant, PidParameters, Plant,
    PowerMemory, Rule, SampledControlLoop, SetPoint, StabilityVerdict, simulate,
};
use testkit::{Tested, assert_relative};

fn plant(draw: &mut Draw, index: usize, t: f64) -> Plant {
    let delay = if index.is_multiple_of(2) {
        0.0
    } else {
        draw.from(0.0, 6.0 * t)
    };
    match index % 3 {
        0 => {
            let (a, b) = (draw.from(1.1, 2.6), draw.from(0.2, 0.9));
            let text = format!(
                "1/({:.3}s^{a:.2}+{:.3}s^{b:.2}+{:.3})",
                draw.from(0.3, 2.0),
                draw.from(0.3, 2.0),
                draw.from(0.3, 2.0)
            );
            Plant::transfer(text.parse().expect("valid"), delay).expect("valid")
        }
        1 => {
            let text = format!("1/({:.3}s+1)", draw.from(0.2, 2.0));
            Plant::transfer(text.parse().expect("valid"), delay + 2.0 * t).expect("valid")
        }
        _ => {
            let (stiffness, damping) = (draw.from(0.0, 3.0), draw.from(0.2, 2.0));
            let states = states([[0.0, 1.0], [-stiffness, -damping]], [0.0, 1.0], [1.0, 0.0]);
            let states = states.behind_lag(draw.from(0.5 * t, 5.0 * t));
            Plant::state_space(states.expect("valid"), delay).expect("valid")
        }
    }
}

/// The swing of y over the last of three thirds, over that of the second.
fn growth(y: &[f64]) -> f64 {
    let third = y.len() / 3;
    let swing = |part: &[f64]| {
        let (low, high) = part
            .iter()
            .fold((f64::MAX, f64::MIN), |(l, h), y| (l.min(*y), h.max(*y)));
        high - low
    };
    swing(&y[2 * third..]) / swing(&y[third..2 * third])
}

/// A loop that is drawn, its gain at the edge of stability not yet known.
struct Candidate {
    plant: Plant,
    sampled: HeldPlant,
    gains: PidParameters,
    memory: PowerMemory,
    sample_time: Seconds,
}

impl Candidate {
    fn draw(draw: &mut Draw, index: usize) -> Self {
        let t = draw.from(0.01, 0.05);
        let plant = plant(draw, index, t);
        let gains = PidParameters {
            proportional: draw.from(0.2, 3.0),
            integral: draw.from(0.0, 1.0),
            integral_order: draw.from(0.3, 1.2),
            derivative: draw.from(0.0, 0.5),
            derivative_order: draw.from(0.3, 1.1),
        };
        let rule = if index % 4 < 2 {
            Rule::Bdf2
        } else {
            Rule::Grunwald
        };
        let memory = PowerMemory::new(rule, 1e-6, 400.0).expect("valid");
        let sampled = held(&plant, memory, t);
        Self {
            plant,
            sampled,
            gains,
            memory,
            sample_time: Seconds(t),
        }
    }

    /// The largest gain that the verdict calls stable, to 0.05 %, if there is an edge at all.
    fn edge(&self) -> Option<f64> {
        let closed = SampledControlLoop::new(self.gains.into(), self.memory, &self.sampled);
        let closed = closed.expect("valid");
        let stable = |gain: f64| closed.with_gain(gain).verdict().stable;
        let (mut low, mut high) = bracket(stable)?;
        while high / low > 1.0005 {
            let middle = (low * high).sqrt();
            if stable(middle) {
                low = middle;
            } else {
                high = middle;
            }
        }
        Some(low)
    }

    /// How much it swings at last after a tap, with its gain times this.
    fn growth(&self, gain: f64) -> f64 {
        let scaled = PidParameters {
            proportional: self.gains.proportional * gain,
            integral: self.gains.integral * gain,
            derivative: self.gains.derivative * gain,
            ..self.gains
        };
        let (set_point, actuator) = (SetPoint::ERROR, Actuator::UNLIMITED);
        let pid = FractionalPid::<f64, 64>::new(
            scaled,
            set_point,
            actuator,
            self.memory,
            self.sample_time,
        );
        let tap = |n| f64::from(u8::from(n == 0));
        let run = simulate(&pid.expect("valid"), &self.sampled, tap, 9000);
        growth(&run.measured)
    }
}

/// `CAMPAIGN_CASES`: loops to try, 100 by default.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn on_neither_side_of_the_boundary_the_verdict_is_wrong() {
    let cases: usize = testkit::cases(100);
    let mut draw = Draw(14);
    let (mut judged, mut index) = (0, 0);
    while judged < cases {
        index += 1;
        assert!(
            index < 3 * cases + 30,
            "only {judged} loops have a boundary"
        );
        let candidate = Candidate::draw(&mut draw, index);
        let Some(edge) = candidate.edge() else {
            continue;
        };
        for (share, grows) in [(0.97, false), (1.03, true)] {
            let growth = candidate.growth(edge * share);
            // A loop that has overflowed has grown.
            let grew = growth > 1.0 || growth.is_nan();
            let case = (&candidate.plant, candidate.gains, candidate.sample_time);
            assert_eq!(grew, grows, "loop {index}, {share}: {growth} {case:?}");
        }
        judged += 1;
    }
}

/// A stable gain and an unstable one, a factor 2 apart.
fn bracket(stable: impl Fn(f64) -> bool) -> Option<(f64, f64)> {
    if !stable(0.01) {
        return None;
    }
    let mut low = 0.01;
    while stable(2.0 * low) {
        low *= 2.0;
        if low > 1e4 {
            return None;
        }
    }
    Some((low, 2.0 * low))
}

/// Above and below times the same number is the same function, and the same loop, however small the number is.
#[test]
fn a_number_common_to_above_and_below_changes_no_verdict() {
    let t = Seconds(1e-9);
    let memory = bdf2(1e-6, 1.0);
    let verdict = |c: &str| {
        let plant: Plant = format!("{c}/({c}s^1.5+{c})").parse().expect("valid");
        let law: FractionalTransferFunction = format!("({c}s^0.5+{c})/({c}s^1.5+{c})")
            .parse()
            .expect("valid");
        let plant = HeldPlant::new(&plant, memory, t).expect("runs");
        let closed = SampledControlLoop::new(law.into(), memory, &plant).expect("closes");
        closed.verdict()
    };
    let usual = verdict("1");
    for c in ["1e-60", "1e-55", "1e60"] {
        let found = verdict(c);
        let stability = |answer: StabilityVerdict| (answer.stable, answer.unstable_poles);
        assert_eq!(stability(found), stability(usual), "{c}");
        assert_relative(c, found.distance, usual.distance, 1e-9);
    }
}

/// Two numbers whose ratio no loop can bear are refused where they meet, also in a controller.
#[test]
fn a_ratio_that_no_loop_can_bear_is_refused_with_the_remedy() -> Tested {
    let memory = bdf2(1e-6, 100.0);
    let plant = |text: &str| HeldPlant::new(&text.parse()?, memory, Seconds(1.0));
    for text in ["1e60/(1e-60s^1.5+1e-60)", "1e-60/(s+1e60)"] {
        let refused = plant(text).map(drop).expect_err(text).to_string();
        let remedies = ["other units", "sample faster"];
        assert!(
            remedies.iter().any(|remedy| refused.contains(remedy)),
            "{refused}"
        );
    }
    assert!(plant("1e60/(s+1e-60)").is_ok());
    let plant = plant("1/(s+1)")?;
    let law: FractionalTransferFunction = "1e60/(1e-60s^1.5+1e-60)".parse()?;
    let closed = SampledControlLoop::new(law.into(), memory, &plant);
    let refused = closed.expect_err("no numbers").to_string();
    let words = refused.starts_with("gain of the controller");
    assert!(
        words && refused.contains("from 1e-75 to 1e75 in size"),
        "{refused}"
    );
    Ok(())
}
