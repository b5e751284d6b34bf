//! Commands on serial devices: an emulated one behind a pseudo-terminal.

mod doors;
mod facing;
mod gone;
mod held;
mod inverse3;
mod lines;
mod makers;
mod middle;
mod promises;
mod remembered;
mod unheard;

pub(crate) use crate::emulated::{Emulated, Emulator};
pub(crate) use makers::numbers_after;
use serde_json::Value;

const RELAX: &str = "relax --device serial:device watchdog=1s --contact rigid --duration 4s --ramp-time \
                     0.5s --out run --quiet";

pub(crate) fn at(value: &Value, path: &str) -> f64 {
    let found = value.pointer(path).and_then(Value::as_f64);
    found.unwrap_or_else(|| panic!("no number {path} in {value}"))
}

#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_a_relaxation_in_the_hosts_loop_loses_nothing_and_follows_theory() {
    let device = Emulated::new("");
    device.loosen();
    let line = RELAX.replace("--duration 4s", "--duration 2s");
    // A machine that is busy answers late.
    let report = device.json(&format!("{line} --loop host max_age_ticks=1000"));
    assert_eq!(at(&report, "/link/samples_lost"), 0.0);
    // Where it answers ten ticks late and more, the log has the forces that the device went on with.
    let late = at(&report, "/link/stale_forces") >= 10.0;
    let follows = at(&report, "/max_relative_error") < 1e-6;
    assert!(late || follows, "{report}");
    let in_closed_form = at(&report, "/closed_form_error") < 2e-4;
    assert!(late || in_closed_form, "{report}");
    assert_eq!(report["precision"], "f64");
    assert_eq!(report["link"]["loop"], "host");
}
