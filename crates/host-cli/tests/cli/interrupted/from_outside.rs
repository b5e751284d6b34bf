//! Runs that somebody ends, or takes the files from.

use super::{run_and_meanwhile, run_and_signal};
use crate::process::Place;

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn every_signal_that_ends_or_stops_a_program_ends_a_run_in_order() {
    // Ctrl-\, Ctrl-Z, and others that somebody may send; the last are STKFLT and the first and last of those without a name.
    const SIGNALS: [&str; 18] = [
        "QUIT", "TSTP", "TTIN", "TTOU", "ALRM", "VTALRM", "PROF", "USR1", "USR2", "XCPU", "ABRT",
        "SYS", "TRAP", "IO", "PWR", "16", "RTMIN", "RTMAX",
    ];
    let everywhere = if cfg!(target_os = "linux") { 18 } else { 13 };
    for some in SIGNALS[..everywhere].chunks(6) {
        std::thread::scope(|scope| {
            for signal in some {
                scope.spawn(move || ends_in_order(signal));
            }
        });
    }
}

fn ends_in_order(signal: &str) {
    let place = Place::new();
    let line = "relax --realtime --out run";
    let ended = run_and_signal(&place, line, "run/relax.mcap.part", signal).failed(1);
    let error = ended.error();
    assert!(error.contains("interrupted: the run ended at"), "{ended}");
    assert_eq!(place.files(), ["run/", "run/relax.mcap"], "{signal}");
}

#[test]
fn a_folder_that_is_removed_under_a_run_is_lost_data() {
    let place = Place::new();
    let log = "run/relax.mcap.part";
    for (done, what) in [
        (
            std::fs::remove_file as fn(std::path::PathBuf) -> std::io::Result<()>,
            "was removed while",
        ),
        (
            |path| std::fs::File::create(path).map(drop),
            "was emptied or cut while",
        ),
    ] {
        let path = place.path(log);
        let line = "relax --realtime --out run --overwrite";
        let ended = run_and_meanwhile(&place, line, log, "INT", || done(path).expect("is done"));
        ended.refused(4, &[log, what, "make the run again"]);
        let _ = std::fs::remove_file(place.path(log));
    }
}
