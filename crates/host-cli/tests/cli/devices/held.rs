//! A device that a controller holds, in a loop of its own.

use super::{Emulated, at};
use crate::process::column;
use fracdiff::Seconds;
use fractional_control::{Controller as _, FractionalPid};
use haptic_trial::ControllerFile;
use testkit::assert_says;

/// It reaches its upper limit on the ramp: the emulated device takes 12 mN to go at 3.3 mm/s.
const PID: &str = "[pid]\nproportional_gain = 300\nintegral_gain_per_s_lambda = 900\nintegral_order = 0.9\n\
                   derivative_gain_s_mu = 6\nderivative_order = 0.9\n\
                   [loop]\nsample_time_s = 1e-3\noutput_low = -0.004\noutput_high = 0.01\n";
const RELAX: &str = "[relax]\nramp_time_s = 0.3\nduration_s = 2\nstrain = 0.05\n\
                     [drive]\ncontroller = \"pid.toml\"\n";
const RUN: &str = "run relax.toml --device serial:device watchdog=1s --out held";

fn device(options: &str) -> Emulated {
    let device = Emulated::new(options);
    device.place.write("pid.toml", PID);
    device.place.write("relax.toml", RELAX);
    device
}

#[test]
fn a_drive_holds_the_device_itself_by_the_bits_of_the_hosts_controller() {
    // Its clock counts, not that of this machine.
    let device = device("--speed 4");
    let report = device.json(RUN);
    assert_eq!(at(&report, "/link/samples_lost"), 0.0);
    assert_eq!(report["drive"]["preflight"]["free"]["stable"], true);
    assert_eq!(report["drive"]["preflight"]["in_contact"]["stable"], true);
    // 1 mm.
    assert!(
        at(&report, "/drive/tracking_error_final") < 5e-5,
        "{report}"
    );
    assert!(at(&report, "/drive/saturated_samples") > 50.0, "{report}");
    assert_says(&report["warnings"].to_string(), "has no tissue before it");

    let file = ControllerFile::read(&device.place.path("pid.toml")).expect("valid");
    let setup = file.setup;
    let memory = setup.memory().expect("valid").fewest_modes();
    let (law, t) = (setup.pid().expect("one"), Seconds(1e-3));
    let actuator = setup.actuator().expect("valid");
    let host = FractionalPid::<f32>::new(law, setup.set_point, actuator, memory, t);
    let host = host.expect("valid");
    let mut history = host.at_rest();
    let log = device
        .place
        .run("log export held/relax.mcap -")
        .succeeded()
        .stdout;
    let single = |name| column(&log, name).into_iter().map(|value| value as f32);
    let wanted = single("environment_force_n").zip(single("applied_force_n"));
    let mut held_back = 0;
    for ((n, x), (have, applied)) in (0..2001_u16).zip(single("position_m")).zip(wanted) {
        let r = 1e-3 * (f32::from(n) / 300.0).min(1.0);
        let want = host.output(&history, r, x);
        assert_eq!(have.to_bits(), want.to_bits(), "{n}: {have} {want}");
        host.advance(&mut history, r, x, applied);
        held_back += u32::from(have.to_bits() != applied.to_bits());
    }
    // By the rise of its force.
    assert!(held_back > 300, "{held_back}");
    assert_says(
        &device.place.text("held/relax.csv"),
        "indenter_position_m,drive_force_n",
    );
    let info = device.json("device info --device serial:device");
    assert_eq!(at(&info, "/controller_sample_time_min_s"), 1e-4);
}
