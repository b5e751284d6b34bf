//! Several axes: no limit of the chain turns a force, and the rate is that of the whole force.

use fracdiff::{Real, Seconds};
use haptic_loop::units::{Newtons, NewtonsPerSecond};
use haptic_loop::{Fault, Limiters, SafetyChain, SafetyLimits, SafetyState};
use nalgebra::SVector;
use proptest::prelude::*;

const T: Seconds = Seconds(1e-3);
/// 5 N/s at 1 kHz.
const STEP_N: f64 = 5e-3;

fn chain<F: Real>(norm: Option<Newtons>) -> SafetyChain<F> {
    let limits = SafetyLimits {
        norm,
        ..SafetyLimits::bare(Newtons(4.0), NewtonsPerSecond(STEP_N / T.0))
    };
    SafetyChain::from_limits(&limits, T).expect("valid")
}

/// A force along a line: a direction and a size for each tick, now and then a stop or a fault, which the next clear ends.
#[derive(Clone, Debug)]
struct Line<const D: usize> {
    direction: [f64; D],
    ticks: Vec<(f64, u8)>,
}

fn lines<const D: usize>() -> impl Strategy<Value = Line<D>> {
    let direction = proptest::collection::vec(-1.0_f64..1.0, D);
    let direction = direction.prop_filter_map("too short", |axes| {
        let axes: [f64; D] = axes.try_into().ok()?;
        let length = axes.iter().map(|axis| axis * axis).sum::<f64>().sqrt();
        (length > 0.1).then(|| axes.map(|axis| axis / length))
    });
    let sizes = prop_oneof![-0.03..0.03, -30.0..30.0, Just(0.0)];
    let ticks = proptest::collection::vec((sizes, 0_u8..40), 1..200);
    (direction, ticks).prop_map(|(direction, ticks)| Line { direction, ticks })
}

/// The force stays on its line, changes by a step at most, and after a stop or a fault never grows; without braking that is from the
/// first tick on.
fn stays_on_its_line<F: Real, const D: usize>(
    line: &Line<D>,
    norm: Option<Newtons>,
    relative: f64,
) -> Result<(), TestCaseError> {
    let chain = chain::<F>(norm);
    let mut state = SafetyState::<F, D>::default();
    let direction = SVector::from(line.direction);
    let mut last = SVector::<f64, D>::zeros();
    let mut released = false;
    for &(along, event) in &line.ticks {
        match event {
            0 => state.stop(),
            1 => state.trip(Fault::HostSilent),
            2..6 => state.clear(),
            _ => {}
        }
        released = (released || event < 2) && !(2..6).contains(&event);
        let wanted = (direction * along).map(F::from_f64);
        let (force, _) = chain.apply(
            &mut state,
            &SVector::<f64, D>::zeros().map(F::from_f64),
            &wanted,
        );
        let now = force.newtons().map(F::to_f64);
        let tolerance = 16.0 * relative * (1.0 + last.norm().max(now.norm()));
        let off = now - direction * direction.dot(&now);
        // Each tick adds a rounding of its own.
        let all = line.ticks.len() as f64 * tolerance;
        prop_assert!(off.norm() <= all, "off its line by {}", off.norm());
        let change = (now - last).norm();
        let falls = released && now.norm() <= last.norm();
        prop_assert!(falls || change <= STEP_N + tolerance, "{change} N");
        prop_assert!(!released || now.norm() <= last.norm() + tolerance, "grew");
        prop_assert!(now.iter().all(|axis| axis.abs() <= 4.0));
        prop_assert!(norm.is_none_or(|norm| now.norm() <= norm.0));
        last = now;
    }
    Ok(())
}

/// Any wanted forces: the whole change is a step at most, towards what is allowed of the wanted force.
fn moves_straight<const D: usize>(
    wanted: &[[f64; 3]],
    norm: Option<Newtons>,
) -> Result<(), TestCaseError> {
    let chain = chain::<f64>(norm);
    let mut state = SafetyState::<f64, D>::default();
    let mut last = SVector::<f64, D>::zeros();
    for wanted in wanted {
        let wanted = SVector::<f64, D>::from_fn(|axis, _| wanted[axis]);
        let (force, limiters) = chain.apply(&mut state, &SVector::zeros(), &wanted);
        let now = *force.newtons();
        let change = now - last;
        prop_assert!(change.norm() <= STEP_N * (1.0 + 1e-9), "{}", change.norm());
        if limiters == Limiters::RATE {
            let way = wanted - last;
            let share = change.norm() / way.norm();
            prop_assert!((change - way * share).norm() < 1e-12, "it turned");
            prop_assert!((change.norm() - STEP_N).abs() < 1e-12, "not a whole step");
        }
        last = now;
    }
    Ok(())
}

proptest! {
    #[test]
    fn a_force_along_a_line_of_one_two_or_three_axes_stays_on_it(
        one in lines::<1>(),
        two in lines::<2>(),
        three in lines::<3>(),
        norm in prop_oneof![Just(None), Just(Some(Newtons(3.0)))],
    ) {
        stays_on_its_line::<f64, 1>(&one, norm, f64::EPSILON)?;
        stays_on_its_line::<f64, 2>(&two, norm, f64::EPSILON)?;
        stays_on_its_line::<f64, 3>(&three, norm, f64::EPSILON)?;
        stays_on_its_line::<f32, 2>(&two, norm, f64::from(f32::EPSILON))?;
        stays_on_its_line::<f32, 3>(&three, norm, f64::from(f32::EPSILON))?;
    }

    #[test]
    fn a_limited_force_moves_straight_towards_the_wanted_one(
        wanted in proptest::collection::vec(proptest::array::uniform3(-2.0..2.0), 1..200),
        norm in prop_oneof![Just(None), Just(Some(Newtons(3.8)))],
    ) {
        moves_straight::<1>(&wanted, norm)?;
        moves_straight::<2>(&wanted, norm)?;
        moves_straight::<3>(&wanted, norm)?;
    }
}

/// Sizes near the end of the number type: within the limits, on the way, and along the wanted line.
#[test]
fn no_wanted_force_is_too_large_to_keep_its_direction() {
    let wanted = SVector::from([f32::MAX, 0.5 * f32::MAX]);
    for (most, norm) in [(4.0, Some(Newtons(3.0))), (4.0, None), (3e38, None)] {
        let limits = SafetyLimits {
            norm,
            ..SafetyLimits::bare(Newtons(most), NewtonsPerSecond(STEP_N / T.0))
        };
        let chain = SafetyChain::<f32>::from_limits(&limits, T).expect("valid");
        let mut state = SafetyState::<f32, 2>::default();
        let (mut x, mut y) = (0.0, 0.0);
        for _ in 0..1000 {
            let (force, _) = chain.apply(&mut state, &SVector::zeros(), &wanted);
            [x, y] = (*force.newtons()).into();
        }
        assert!((y / x - 0.5).abs() < 1e-3 && x > 2.0, "{x} {y}");
    }
}
