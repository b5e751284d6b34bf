//! The shape of a step by hand.

use fractional_control::Response;

#[test]
fn the_shape_of_a_ramp_up_to_a_little_too_much() {
    // 0, 0.2, … 2.2, then 2 for ever: a step of 2.
    let rise = (0..=11).map(|n| 0.2 * f64::from(n));
    let mut run = Response::default();
    run.measured = rise.chain([2.0; 5]).collect();
    let shape = run.shape_of_step(2.0);
    assert!((shape.overshoot - 0.1).abs() < 1e-12);
    assert!(shape.rise.is_some_and(|rise| (rise - 8.0).abs() < 1e-9));
    assert_eq!(shape.settled, Some(12));
    assert!(shape.final_error < 1e-12);
    assert_eq!(run.shape_of_step(5.0).rise, None);
    assert_eq!(run.shape_of_step(5.0).settled, None);
}
