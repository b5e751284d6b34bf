//! Bad input through the functions in C: each is one line with value, range and remedy, and never a force.
#![expect(unsafe_code, reason = "tests call as C does")]

use haptic_bridge::*;
use std::{
    ffi::{CStr, CString, c_char},
    ptr,
};
use testkit::assert_says;

pub(crate) fn device(name: &CStr) -> HbDevice {
    HbDevice {
        size: size_of::<HbDevice>(),
        name: name.as_ptr(),
        axes: 3,
        sample_time_us: 1000,
        force_max_n: 3.0,
        force_rate_max_n_per_s: 1000.0,
        position_resolution_m: 0.0,
        workspace_low_m: [0.0; 3],
        workspace_high_m: [0.0; 3],
        watchdog_ms: 0,
        sensed_force_max_n: 0.0,
        serial_number: ptr::null(),
        takes: HB_FORCE,
        robot: ptr::null(),
    }
}

/// Why it cannot be opened.
fn refused(what: *const HbDevice, listen: Option<&CStr>, room: usize) -> String {
    let mut error = vec![0x55_u8; room + 1];
    let listen = listen.map_or(ptr::null(), CStr::as_ptr);
    // SAFETY: pointers to what lives here, or null.
    let bridge = unsafe { hb_open(what, listen, error.as_mut_ptr().cast::<c_char>(), room) };
    assert!(bridge.is_null(), "it is open");
    assert_eq!(error[room], 0x55, "beyond the room");
    let text = CStr::from_bytes_until_nul(&error).expect("ends");
    text.to_str().expect("whole characters").to_owned()
}

const PORT: &CStr = c"127.0.0.1:0";

#[test]
fn a_device_that_cannot_be_is_refused_with_value_range_and_remedy() {
    assert!(refused(ptr::null(), Some(PORT), 500).contains("NULL"));
    type Change = fn(&mut HbDevice);
    let cases: [(Change, &[&str]); 20] = [
        (|it| it.size = 8, &["size = 8", "sizeof(hb_device)"]),
        (|it| it.name = ptr::null(), &["name = \"\"", "1 to 16"]),
        (
            |it| it.name = c"a name of seventeen".as_ptr(),
            &["seventeen", "16"],
        ),
        (|it| it.name = c"F\xe9".as_ptr(), &["UTF-8"]),
        (|it| it.axes = 0, &["axes", "0", "1, 2 or 3"]),
        (|it| it.axes = 4, &["axes", "4", "1, 2 or 3"]),
        (
            |it| it.sample_time_us = 1,
            &["sample_time_us", "100 to 10000, or 0"],
        ),
        (|it| it.force_max_n = 0.0, &["force_max_n", "above 0"]),
        (
            |it| it.force_max_n = f64::NAN,
            &["force_max_n", "NaN", "above 0"],
        ),
        (|it| it.force_max_n = 1e39, &["force_max_n", "finite"]),
        (
            |it| it.force_rate_max_n_per_s = -1.0,
            &["force_rate_max_n_per_s", "-1"],
        ),
        (
            |it| it.sensed_force_max_n = f64::INFINITY,
            &["sensed_force_max_n", "0 to 1e6"],
        ),
        (
            |it| it.position_resolution_m = -1e-3,
            &["position_resolution_m", "0 to 0.1"],
        ),
        (
            |it| {
                it.workspace_low_m = [0.0, 0.0, 0.2];
                it.workspace_high_m = [0.1; 3];
            },
            &["workspace_low_m = 0.2 m on axis 2", "0.1"],
        ),
        (|it| it.takes = 2, &["takes = 2", "HB_VELOCITY (1)"]),
        (
            |it| it.takes = HB_VELOCITY,
            &["robot = NULL", "[admittance]"],
        ),
        (
            |it| it.robot = c"robot.toml".as_ptr(),
            &["robot = \"robot.toml\"", "HB_FORCE"],
        ),
        (
            |it| it.watchdog_ms = 5000,
            &["watchdog_ms", "5000", "5 to 1000"],
        ),
        (
            |it| it.serial_number = c"123456789".as_ptr(),
            &["serial_number = \"123456789\"", "counts up", "give"],
        ),
        (
            |it| it.serial_number = c"my Falcon".as_ptr(),
            &["serial_number = \"my Falcon\"", "6 to 32"],
        ),
    ];
    for (change, words) in cases {
        let mut case = device(c"Falcon");
        change(&mut case);
        let reason = refused(&case, Some(PORT), 500);
        assert!(!reason.contains('\n'), "{reason}");
        for word in words {
            assert!(reason.contains(word), "{reason}: no {word}");
        }
    }
}

#[test]
fn an_address_that_cannot_be_listened_at_is_named() {
    let good = device(c"Falcon");
    for address in [
        c"",
        c"4250",
        c"127.0.0.1",
        c"127.0.0.1:99999",
        c"192.0.2.1:4250",
    ] {
        let reason = refused(&good, Some(address), 500);
        let address = address.to_str().expect("a text");
        assert!(
            reason.contains(address) && reason.contains("give"),
            "{reason}"
        );
    }
}

#[test]
fn a_reason_is_cut_to_its_room_and_ends_with_a_zero() {
    let good = device(c"Falcon");
    let whole = refused(&good, Some(c"nowhere µ"), 500);
    for room in 1..60 {
        let cut = refused(&good, Some(c"nowhere µ"), room);
        assert!(
            whole.starts_with(&cut) && cut.len() + 2 >= room.min(whole.len()),
            "{cut}"
        );
    }
    // SAFETY: null, with any room.
    let bridge = unsafe { hb_open(&good, c"nowhere".as_ptr(), ptr::null_mut(), 99) };
    assert!(bridge.is_null());
}

#[test]
fn a_port_that_is_taken_is_named() {
    // SAFETY: pointers to what lives here, or null.
    unsafe {
        let first = hb_open(&device(c"one"), PORT.as_ptr(), ptr::null_mut(), 0);
        assert!(!first.is_null());
        let port = hb_port(first);
        assert_ne!(port, 0);
        let address = CString::new(format!("127.0.0.1:{port}")).expect("no zero");
        let reason = refused(&device(c"two"), Some(&address), 500);
        let named = format!("cannot listen at 127.0.0.1:{port}: ");
        let remedy = "; give another address, or port 0 for a free one";
        assert!(
            reason.starts_with(&named) && reason.ends_with(remedy),
            "{reason}"
        );
        hb_close(first);
        // Its port is free again.
        let second = hb_open(&device(c"two"), address.as_ptr(), ptr::null_mut(), 0);
        assert!(!second.is_null());
        hb_close(second);
    }
}

#[test]
fn null_is_never_followed_and_never_a_force() {
    let (position, mut force) = ([0.0; 3], [7.0; 3]);
    // SAFETY: null, or what lives here.
    unsafe {
        assert_eq!(
            hb_tick(ptr::null_mut(), 1, position.as_ptr(), force.as_mut_ptr()),
            HB_NULL
        );
        assert_eq!(force, [0.0; 3]);
        assert_eq!(
            hb_tick(ptr::null_mut(), 1, ptr::null(), ptr::null_mut()),
            HB_NULL
        );
        assert_eq!((hb_fault(ptr::null()), hb_port(ptr::null())), (HB_NULL, 0));
        assert_eq!(hb_wait(ptr::null_mut()), 0);
        assert!(
            CStr::from_ptr(hb_reason(ptr::null()))
                .to_bytes()
                .starts_with(b"the bridge is NULL")
        );
        hb_stop(ptr::null_mut());
        hb_close(ptr::null_mut());
        for (number, missing) in [(1, true), (2, false)] {
            let bridge = hb_open(&device(c"one"), PORT.as_ptr(), ptr::null_mut(), 0);
            force = [7.0; 3];
            let code = if missing {
                hb_tick(bridge, number, ptr::null(), force.as_mut_ptr())
            } else {
                hb_tick(bridge, number, position.as_ptr(), ptr::null_mut())
            };
            assert_eq!(code, 12);
            assert_eq!(hb_fault(bridge), 12);
            assert_eq!(force, if missing { [0.0; 3] } else { [7.0; 3] });
            let reason = CStr::from_ptr(hb_reason(bridge)).to_str().expect("a text");
            assert_says(&reason, "arrays of three numbers");
            hb_close(bridge);
        }
    }
}

#[test]
fn a_position_and_a_force_in_one_array_are_what_they_are_in_two() {
    // SAFETY: what lives here.
    unsafe {
        let bounded = HbDevice {
            workspace_low_m: [-0.1; 3],
            workspace_high_m: [0.1; 3],
            ..device(c"one")
        };
        let bridge = hb_open(&bounded, PORT.as_ptr(), ptr::null_mut(), 0);
        // Outside its workspace, which the middle of it is not.
        let mut both = [0.0, 0.2, 0.0];
        let both_m = both.as_mut_ptr();
        assert_eq!(hb_tick(bridge, 1000, both_m, both_m), 6);
        assert_eq!(both, [0.0; 3]);
        hb_close(bridge);
    }
}

#[test]
fn the_call_of_the_other_kind_gives_zero_and_says_so() {
    let robot = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/robot.toml");
    let robot = CString::new(robot).expect("no zero");
    let moving = HbDevice {
        takes: HB_VELOCITY,
        robot: robot.as_ptr(),
        sensed_force_max_n: 50.0,
        ..device(c"robot")
    };
    // SAFETY: what lives here.
    unsafe {
        for (what, is_robot) in [(moving, true), (device(c"one"), false)] {
            let bridge = hb_open(&what, PORT.as_ptr(), ptr::null_mut(), 0);
            assert!(!bridge.is_null());
            for (moves, code) in [(is_robot, 0), (!is_robot, HB_OTHER)] {
                let (position, mut output) = ([0.0; 3], [7.0; 3]);
                let tick = if moves { hb_tick_motion } else { hb_tick };
                let told = tick(bridge, 1000, position.as_ptr(), output.as_mut_ptr());
                assert_eq!((told, output), (code, [0.0; 3]));
            }
            assert_eq!(hb_fault(bridge), 0);
            hb_close(bridge);
        }
        let mut output = [7.0; 3];
        let told = hb_tick_motion(ptr::null_mut(), 1, output.as_ptr(), output.as_mut_ptr());
        assert_eq!((told, output), (HB_NULL, [0.0; 3]));
    }
}
