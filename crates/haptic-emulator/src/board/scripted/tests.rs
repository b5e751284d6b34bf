//! A scripted hand against the rest of its spring.

use super::*;
use haptic_loop::{
    SafetyChain, SafetyLimits, SafetyState,
    nalgebra::SVector,
    units::{Kilograms, Newtons, NewtonsPerSecond},
};

fn script(moves: &[(f64, f64)]) -> Result<HandScript, LoopParameterError> {
    let moves = moves.iter();
    HandScript::new(moves.map(|&(place_m, time_s)| (Metres(place_m), Seconds(time_s))))
}

#[test]
fn a_hand_is_where_its_script_says_less_what_a_force_bends_and_begins_again() {
    let free = MassDamperConfig::ideal(Kilograms(0.065), NewtonSecondsPerMetre(3.5), Seconds(1e-3));
    let moves = script(&[(6e-3, 1.0), (2e-3, 0.5), (-5e-3, 1.0)]).expect("a script");
    let mut device = ScriptedDevice::new(free, moves).expect("a device");
    let limits = SafetyLimits::bare(Newtons(50.0), NewtonsPerSecond(1e6));
    let chain = SafetyChain::<f64>::from_limits(&limits, Seconds(1e-3)).expect("a chain");
    let held_n: SVector<f64, 1> = [-0.6].into();
    let mut runs = Vec::new();
    for _ in 0..2 {
        device.restart();
        let mut safety = SafetyState::default();
        let ticks = (0..4999).map(|_| {
            let Ok(reading) = device.read();
            let (force, _) = chain.apply(&mut safety, &reading.position_m, &held_n);
            let Ok(()) = device.write(force);
            reading.position_m[0]
        });
        runs.push(ticks.collect::<Vec<_>>());
        assert!((device.contact_force() - 0.6).abs() < 2e-3, "{device:?}");
    }
    // At the end of each move, twice round.
    for (tick, place_m) in [
        (990, 6e-3),
        (1490, 2e-3),
        (2490, -5e-3),
        (3490, 6e-3),
        (4990, -5e-3),
    ] {
        let rest_m = place_m - 0.6 / 300.0;
        let position_m = runs[0][tick];
        assert!((position_m - rest_m).abs() < 2e-5, "{tick}: {position_m}");
    }
    // On the way no faster than half a cosine with the swing of the grip.
    let fastest = runs[0]
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).abs())
        .fold(0.0, f64::max);
    assert!((0.02e-3..0.08e-3).contains(&fastest), "{fastest}");
    assert_eq!(runs[0], runs[1]);
}

#[test]
fn what_is_no_script_is_refused_and_one_of_no_moves_holds_the_handle() {
    assert_eq!(script(&[]).expect("nothing to do").wanted(3.0), (0.0, 0.0));
    for (moves, named) in [([(f64::NAN, 1.0)], "place"), ([(1e-3, 0.0)], "time")] {
        let refused = script(&moves).expect_err("no move");
        assert!(refused.to_string().contains(named), "{refused}");
    }
}
