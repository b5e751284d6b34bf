//! Devices that move: borders and boxes of theory, F against its definition, proofs against their members.

use core::f64::consts::PI;
use fracdiff::{FrequencyResponse, Order, Scheme, Seconds};
use haptic_analysis::num_complex::Complex;
use haptic_analysis::{
    AdmittanceBody, AdmittanceBox, AdmittanceLoop, AdmittanceNumber, AdmittanceWorld, BoxVerdict,
    EffortWeight, ForceFilter, HandImpedance, LoopOperator, Robot, VelocityLoop,
};

const T: f64 = 2e-3;
const HAND: HandImpedance = HandImpedance {
    mass_kg: 1.5,
    damping_n_s_per_m: 20.0,
    stiffness_n_per_m: 300.0,
};

/// G of 10 Hz and ζ 0.8, two samples of dead time, two lags of 30 Hz.
fn robot() -> Robot {
    let motion = VelocityLoop::second_order(10.0, 0.8).expect("in range");
    let filter = ForceFilter {
        cutoff_hz: 30.0,
        lags: 2,
    };
    Robot::new(motion, 2.0 * T, filter, 0.0, T).expect("in range")
}

fn operator(order: f64) -> LoopOperator {
    let order = Order::new(order).expect("in range");
    LoopOperator::new(Scheme::Exact, order, Seconds(T), 1e5).expect("in range")
}

fn body(operator: &LoopOperator, m: f64, b: f64) -> AdmittanceBody<'_> {
    AdmittanceBody {
        inertance_n_s_alpha_per_m: m,
        damping_n_s_per_m: b,
        operator,
    }
}

fn wall(operator: &LoopOperator, stiffness_n_per_m: f64) -> AdmittanceWorld<'_> {
    AdmittanceWorld {
        stiffness_n_per_m,
        dissipation_n_s_mu_per_m: 0.0,
        operator,
        delay_samples: 0,
    }
}

fn near(have: f64, want: f64, share: f64, what: &str) {
    assert!(
        (have - want).abs() <= share * want.abs(),
        "{what}: {have} for {want}"
    );
}

#[test]
fn borders_of_a_hand_in_free_space() {
    let robot = robot();
    for (order, m, b, most) in [
        (0.8, 1.16, 1.0, 2176.953),
        (1.0, 0.523, 7.37, 2241.629),
        (0.4, 2.56, 11.0, 4521.731),
        (1.2, 0.352, 24.4, 2418.541),
        (0.7, 1.72, 0.0, 2344.115),
    ] {
        let operator = operator(order);
        let subject =
            AdmittanceLoop::new(&robot, body(&operator, m, b), HAND, None).expect("in range");
        let stable = subject.stable_values(AdmittanceNumber::HandStiffness, [0.0, 1e5]);
        assert_eq!(stable.len(), 1, "{order}: {stable:?}");
        assert_eq!(stable[0][0].to_bits(), 0);
        near(stable[0][1], most, 3e-7, "largest stiffness of the hand");
    }
}

#[test]
fn the_force_of_a_hand_is_that_of_the_sampled_chain() {
    let (robot, operator) = (robot(), operator(0.8));
    let hand = HandImpedance {
        stiffness_n_per_m: 500.0,
        ..HAND
    };
    let subject =
        AdmittanceLoop::new(&robot, body(&operator, 1.16, 1.0), hand, None).expect("in range");
    let found = subject.hand_response(0.1);
    let want = Complex::new(33.85156587, -33.93447137);
    assert!((found - want).norm() < 1e-7, "{found}");
}

#[test]
fn free_space_is_not_the_robot() {
    let robot = robot();
    let spring = operator(0.0);
    // Unstable against walls from 132 N/m to 29 kN/m, and from 230 N/m to 10 kN/m.
    for (order, m, b, low, high) in [
        (1.0, 0.523, 7.37, 132.0, 29e3),
        (0.8, 1.16, 1.0, 230.0, 10e3),
    ] {
        let operator = operator(order);
        let subject = AdmittanceLoop::new(
            &robot,
            body(&operator, m, b),
            HAND,
            Some(wall(&spring, 1.0)),
        )
        .expect("in range");
        let stable = subject.stable_values(AdmittanceNumber::WorldStiffness, [0.0, 1e5]);
        assert!(subject.verdict().stable);
        near(stable[0][1], low, 0.06, "softest wall that is not stable");
        near(stable[1][0], high, 0.06, "stiffest wall that is not stable");
    }
}

#[test]
fn the_characteristic_function_is_that_of_its_definition() {
    // Both operators have a denominator, and the world is late.
    let rational = |order: f64, degree: usize| {
        let order = Order::new(order).expect("in range");
        LoopOperator::new(Scheme::TustinMuir { degree }, order, Seconds(T), 1e5).expect("in range")
    };
    let (robot, alpha, mu) = (robot(), rational(0.8, 5), rational(0.4, 3));
    let world = AdmittanceWorld {
        dissipation_n_s_mu_per_m: 30.0,
        delay_samples: 2,
        ..wall(&mu, 1000.0)
    };
    let subject =
        AdmittanceLoop::new(&robot, body(&alpha, 1.16, 1.0), HAND, Some(world)).expect("in range");
    for theta in [1e-3, 0.1, 1.0, 3.0] {
        let w = Complex::from_polar(1.0, -theta);
        let m = alpha.response(theta) * 1.16 * T.powf(-0.8) + 1.0;
        let e = w * w * (mu.response(theta) * 30.0 * T.powf(-0.4) + 1000.0);
        let want = (m + subject.hand_response(theta)) * (1.0 - w) / T + w * e;
        let found = subject.characteristic(theta);
        assert!(
            (found - want).norm() < 1e-9 * want.norm(),
            "{theta}: {found} {want}"
        );
        let rendered = subject.virtual_impedance(theta / T).expect("in range");
        let want = m + w * e * T / (1.0 - w);
        assert!(
            (rendered - want).norm() < 1e-9 * want.norm(),
            "{theta}: {rendered} {want}"
        );
    }
}

#[test]
fn nothing_that_damps_or_holds_is_never_stable() {
    let (robot, mass) = (robot(), operator(1.0));
    let free = HandImpedance {
        mass_kg: 0.0,
        damping_n_s_per_m: 0.0,
        stiffness_n_per_m: 0.0,
    };
    let judged = |damping: f64| {
        let subject = AdmittanceLoop::new(&robot, body(&mass, 2.0, damping), free, None);
        let subject = subject.expect("in range");
        // One that may damp, or not, is not proved either.
        let all = AdmittanceBox::around(&subject).with(AdmittanceNumber::Damping, [damping, 2.0]);
        (subject.verdict().stable, all.expect("in range").is_proved())
    };
    assert_eq!([judged(0.0), judged(1.0)], [(false, false), (true, true)]);
}

#[test]
fn efforts_and_noise_of_a_mass_with_a_damper() {
    let (robot, operator) = (robot(), operator(1.0));
    let subject =
        AdmittanceLoop::new(&robot, body(&operator, 0.558, 4.52), HAND, None).expect("in range");
    // Integrals by the trapezoid rule over 4000 points, in Python.
    near(
        subject.effort(EffortWeight::Hand).expect("a rate"),
        5.558656,
        1e-4,
        "effort",
    );
    near(
        subject.effort(EffortWeight::Flat).expect("a rate"),
        9.785863,
        1e-4,
        "flat effort",
    );
    near(
        subject.command_noise(),
        1.0 / (0.558 * 2.0 / T + 4.52),
        1e-12,
        "noise",
    );
}

#[test]
fn boxes_of_hands_and_their_largest_stiffness() {
    let robot = robot();
    for (order, m, b, most) in [(1.0, 2.0, 10.0, 465.727), (0.7, 4.0, 0.5, 599.057)] {
        let operator = operator(order);
        let subject =
            AdmittanceLoop::new(&robot, body(&operator, m, b), HAND, None).expect("in range");
        let hands = AdmittanceBox::around(&subject)
            .with(AdmittanceNumber::HandMass, [0.5, 3.0])
            .and_then(|hands| hands.with(AdmittanceNumber::HandDamping, [5.0, 60.0]))
            .and_then(|hands| hands.with(AdmittanceNumber::HandStiffness, [0.0, 100.0]))
            .expect("in range");
        assert_eq!(hands.verdict(), BoxVerdict::Proved);
        let found = hands
            .largest(AdmittanceNumber::HandStiffness, 1e4)
            .expect("in range");
        near(
            found.unwrap_or(0.0),
            most,
            1e-5,
            "largest stiffness of a box",
        );
        let beyond = hands
            .with(AdmittanceNumber::HandStiffness, [0.0, 1.01 * most])
            .expect("in range");
        assert!(
            matches!(beyond.verdict(), BoxVerdict::Unstable(_)),
            "{:?}",
            beyond.verdict()
        );
    }
}

#[test]
fn a_light_body_bears_no_heavy_hand_without_damping() {
    let (robot, operator) = (robot(), operator(0.8));
    let subject =
        AdmittanceLoop::new(&robot, body(&operator, 1.16, 1.0), HAND, None).expect("in range");
    let hands = AdmittanceBox::around(&subject)
        .with(AdmittanceNumber::HandMass, [0.5, 3.0])
        .and_then(|hands| hands.with(AdmittanceNumber::HandDamping, [0.0, 60.0]))
        .and_then(|hands| hands.with(AdmittanceNumber::HandStiffness, [0.0, 300.0]))
        .expect("in range");
    let BoxVerdict::Unstable(member) = hands.verdict() else {
        panic!("{:?}", hands.verdict());
    };
    let hand = HandImpedance {
        mass_kg: member[2],
        damping_n_s_per_m: member[3],
        stiffness_n_per_m: member[4],
    };
    let member =
        AdmittanceLoop::new(&robot, body(&operator, 1.16, 1.0), hand, None).expect("in range");
    assert!(!member.verdict().stable);
}

#[test]
fn margins_are_where_the_verdict_turns() {
    let light = margins(1.16, 1.0);
    // The second one bears more than a whole sample.
    let heavy = margins(6.0, 10.0);
    assert!(light < 1.0 && heavy > 1.0, "{light} {heavy}");
}

/// The margin of dead time, samples, all margins checked.
fn margins(m: f64, b: f64) -> f64 {
    let (robot, operator) = (robot(), operator(0.8));
    let subject = AdmittanceLoop::new(&robot, body(&operator, m, b), HAND, None).expect("in range");
    let margins = subject.margins().expect("stable");
    let heavier = |factor: f64| {
        let hand = HandImpedance {
            mass_kg: factor * 1.5,
            damping_n_s_per_m: factor * 20.0,
            stiffness_n_per_m: factor * 300.0,
        };
        AdmittanceLoop::new(&robot, body(&operator, m, b), hand, None)
            .expect("in range")
            .verdict()
            .stable
    };
    let up = margins.hand_up.expect("a limit").value;
    assert!(heavier(0.999 * up) && !heavier(1.001 * up), "{up}");
    let later = |samples: f64| {
        let motion = VelocityLoop::second_order(10.0, 0.8).expect("in range");
        let filter = ForceFilter {
            cutoff_hz: 30.0,
            lags: 2,
        };
        let robot = Robot::new(motion, (2.0 + samples) * T, filter, 0.0, T).expect("in range");
        AdmittanceLoop::new(&robot, body(&operator, m, b), HAND, None)
            .expect("in range")
            .verdict()
            .stable
    };
    let dead = margins.dead_time.expect("a limit").value;
    assert!(later(0.999 * dead) && !later(1.001 * dead), "{dead}");
    let grid = (1..100_000).map(|i| {
        let theta = PI * f64::from(i) / 100_000.0;
        let m = subject.virtual_impedance(theta / T).expect("in range");
        (m / (m + subject.hand_response(theta))).norm()
    });
    let peak = grid.fold(0.0, f64::max);
    near(margins.sensitivity.value, peak, 1e-4, "sensitivity");
    dead
}

#[test]
fn what_no_robot_is() {
    let refused = |made: Result<Robot, haptic_analysis::AnalysisError>| {
        made.map(|_| ()).expect_err("refused").to_string()
    };
    let first = VelocityLoop::from_matrices(&[-20.0], &[20.0], &[1.0]).expect("a lag");
    let none = refused(Robot::new(first.clone(), 0.0, ForceFilter::NONE, 0.0, T));
    assert!(
        none.contains("a lag in the robot's loop or in its sensor"),
        "{none}"
    );
    let late = refused(Robot::new(first, -1.0, ForceFilter::NONE, 0.0, T));
    assert!(late.contains("dead time"), "{late}");
    for (matrices, words) in [
        ([1.0, 20.0, 1.0], "below 0"),
        ([-20.0, 200.0, 1.0], "from 0.5 to 2"),
        ([f64::NAN, 20.0, 1.0], "finite"),
    ] {
        let [a, b, c] = matrices.map(|x| [x]);
        let why = VelocityLoop::from_matrices(&a, &b, &c)
            .expect_err("refused")
            .to_string();
        assert!(why.contains(words), "{why}");
    }
}
