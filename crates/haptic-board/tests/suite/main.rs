//! Tests of the public face of `haptic-board`, in one binary.

mod hello;
mod quadrature;

#[test]
fn the_clock_goes_on_where_its_counter_wraps() {
    let clock = haptic_board::Clock::new();
    assert_eq!(clock.now_us(|| u32::MAX), u64::from(u32::MAX));
    assert_eq!(clock.now_us(|| 9), u64::from(u32::MAX) + 10);
}

#[test]
fn parts_of_an_image_have_the_order_and_size_that_a_linker_gives_them() {
    let parts = haptic_board::Image::parts;
    let good = [0x100, 0x900, 0x900, 0xa00, 0xa10, 0x2000_0000, 0x2000_0030];
    let expected = [(0x100, 0x800), (0x900, 0x100), (0xa10, 0x30)];
    assert_eq!(parts(good), Some(expected));
    // Text, constants or values that end before they begin; more than any flash; nowhere.
    for (bound, address) in [
        (1, 0xff),
        (3, 0x8ff),
        (6, 0x1fff_ffff),
        (1, usize::MAX),
        (0, 0),
    ] {
        let mut bad = good;
        bad[bound] = address;
        assert_eq!(parts(bad), None, "{bound}");
    }
}
