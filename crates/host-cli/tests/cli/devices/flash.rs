//! Images and the program that brings them onto a board.

use super::Emulated;
use crate::process::Place;

#[test]
fn an_image_of_another_board_is_not_programmed() {
    let place = Place::new();
    place.write("probe-rs", "#!/bin/sh\nexit 0\n");
    let probe = place.path("probe-rs");
    let mode = std::os::unix::fs::PermissionsExt::from_mode(0o755);
    std::fs::set_permissions(&probe, mode).expect("can be set");
    let flash = |image: &str, device: &str| {
        let mut command = place.command("device flash --image");
        command.args([image, "--device", device]);
        let output = command.env("PATH", place.path("")).output().expect("runs");
        (
            output.status.code(),
            String::from_utf8_lossy(&output.stderr).into_owned(),
        )
    };
    place.write(
        "mps2",
        "haptic-device image\0mps2-an386\0\0\0\0\0\0\0\x01\x00",
    );
    let (code, error) = flash("mps2", "serial:nowhere");
    assert_eq!(code, Some(2), "{error}");
    assert!(
        error.contains("board mps2-an386 with firmware 0.1.0"),
        "{error}"
    );
    assert!(error.contains("nucleo-f446re"), "{error}");
    // The right image, but what answers is another board.
    place.write(
        "nucleo",
        "haptic-device image\0nucleo-f446re\0\0\0\0\x01\x00",
    );
    let device = Emulated::new("");
    let port = format!("serial:{}", device.place.path("device").display());
    let (code, error) = flash("nucleo", &port);
    assert_eq!(code, Some(3), "{error}");
    assert!(
        error.contains("board emulated with firmware 0.1.0 answers"),
        "{error}"
    );
}

#[test]
fn flashing_without_probe_rs_says_how_to_get_it() {
    let place = Place::new();
    // A path without anything in it.
    let mut command = place.command("device flash");
    let output = command.env("PATH", place.path("")).output().expect("runs");
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(3), "{error}");
    assert!(error.contains("cargo install probe-rs-tools"), "{error}");
}
