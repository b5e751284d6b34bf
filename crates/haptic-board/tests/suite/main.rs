//! Tests of the public face of `haptic-board`, in one binary.

mod hello;
mod quadrature;

#[test]
fn the_clock_goes_on_where_its_counter_wraps() {
    let clock = haptic_board::Clock::new();
    assert_eq!(clock.now_us(|| u32::MAX), u64::from(u32::MAX));
    assert_eq!(clock.now_us(|| 9), u64::from(u32::MAX) + 10);
}
