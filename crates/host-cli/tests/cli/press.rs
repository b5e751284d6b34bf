//! A specimen on an emulated board is measured, and its tissue felt on the same board.

use crate::devices::{Emulated, at};

/// True if the truth lies within twice the interval: the clock draws the readings of the tare, so of four intervals of 95 % one run in five would miss one,
/// and of twice their width one in some thousands.
fn holds(found: &serde_json::Value, name: &str, truth: f64) -> bool {
    let of = |key: &str| at(found, &format!("/parameters/{name}/{key}"));
    (of("value") - truth).abs() < of("high_95") - of("low_95")
}

/// Forces by the motor and by a sensor with an offset, noise and lag, on a device that holds its handle from its first tick on.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_tissue_at_the_handle_of_a_board_is_measured_and_then_felt_on_it() {
    for (sensor, source) in [
        ("", "motor"),
        ("sensed_range=20N sensed_offset=0.3N", "sensor"),
    ] {
        let device = Emulated::new(&format!("--speed 8 specimen=prostate-cancerous {sensor}"));
        let press = "press --device serial:device watchdog=1s mass=65g damping=3.5 --depth 2mm --hold-time 5s --out p --quiet";
        let pressed = device.json(press);
        assert_eq!(pressed["force_source"], source, "{pressed}");
        assert_eq!(at(&pressed, "/link/samples_lost"), 0.0);
        let found = device.json("identify p/press.mcap --model spring-pot --out gel.toml");
        // The library's 8650 Pa·s^α and 0.2247, integrated apart from what is fitted.
        assert!(
            holds(&found, "viscosity_pa_s_alpha", 8650.0) && holds(&found, "order", 0.2247),
            "{found}"
        );
        let felt = "relax --tissue gel.toml --device serial:device watchdog=1s --contact rigid --duration 2s --out felt --quiet";
        let felt = device.json(felt);
        assert_eq!(felt["tissue"], "gel");
        assert!(at(&felt, "/max_relative_error") < 1e-3, "{felt}");
    }
}
