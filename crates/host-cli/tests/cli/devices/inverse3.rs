//! An emulated Inverse Service at a port of this machine, and commands on its device.

use super::{Emulator, at};
use crate::process::{Place, column};
use testkit::assert_says;

const SERVICE: &str = "--kind inverse3 service_port=0";

#[test]
fn info_names_the_inverse3_and_what_its_service_does_to_forces() {
    let place = Place::new();
    let mut service = Emulator::start(&place, SERVICE);
    let device = service.name();
    // A machine that is busy answers late.
    let line = format!("device info --device {device},lost=1000 --json");
    let ended = place.run(&line).succeeded_with_warnings();
    assert_says(&ended.stderr, "force gate has gain 0.3 & damping to 0");
    let info = ended.json();
    assert_eq!(info["board"], "Inverse3 04BA");
    assert_eq!(at(&info, "/force_max_n"), 3.0);
    assert_eq!(info["simulated"], false);
    for (more, words) in [
        (
            "",
            "there is no Inverse3 `049D`: the Inverse Service knows 04BA",
        ),
        (
            ",axis=up",
            "axis = \"up\" is not one of x, y, z, -x, -y, -z",
        ),
    ] {
        let line = format!("device info --device {device},id=049D{more}");
        place.run(&line).refused(2, &[words]);
    }
    let message = service.ends();
    assert_says(&message, "emulated: 2 sessions, & largest 0.000000 N");
}

#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_every_sample_that_an_inverse3_loses_is_counted_and_a_spring_has_the_bits_of_its_positions()
 {
    let place = Place::new();
    for (sample_time, ticks) in [("1ms", 2000.0), ("250us", 8000.0)] {
        // The last run leaves its handle behind the plane, where a force may not begin.
        let service = Emulator::start(&place, SERVICE);
        place.write(
            "ball.toml",
            format!(
                "[touch]\ndevice = \"{},lost=1000\"\naxes = 3\nshape = \"plane\"\nnormal = [0.0, 0.0, -1.0]\nsurface_m = 0.003\n\
                 stiffness_n_per_m = 100.0\ndissipation_n_s_mu_per_m = 0.0\nforce_limit_n = 2.0\nduration_s = 2.0\nmass_kg = 0.15\n\
                 watchdog_s = 1\nlate_ticks = 0\n",
                service.name()
            ),
        );
        let line = format!("run ball.toml sample_time={sample_time} --out {sample_time} --json");
        let report = place.run(&line).ended_by_the_clock().json();
        let (samples, lost) = (at(&report, "/samples"), at(&report, "/link/samples_lost"));
        assert!(samples + lost >= ticks, "{report}");
        let log = format!("log export {sample_time}/touch.mcap -");
        // The log of such a machine is not whole, which its export says by that code too.
        let table = place.run(&log).ended_by_the_clock().stdout;
        let named = |name: &str| column(&table, name);
        assert_eq!(named("tick").len() as f64, samples);
        let (depths, forces) = (named("position_z_m"), named("environment_force_z_n"));
        for (z_m, force_n) in depths.into_iter().zip(forces) {
            // K·max(−z − surface, 0), in single precision as there.
            let depth_m = (-(z_m as f32) - 0.003).max(0.0);
            assert_eq!(
                (100.0 * depth_m).to_bits(),
                (force_n as f32).abs().to_bits()
            );
        }
    }
}
