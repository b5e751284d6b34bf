//! Logs that are cut or damaged.

use super::with_log;
use crate::process::number;

const WALL: &str = "[wall]\nsample_time_s = 0.002\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\norder = 0.5\n\
    stiffness_n_per_m = 3000.0\ndissipation_n_s_mu_per_m = 100.0\nduration_s = 1.0\n";
const GEL: &str = "name = \"gel\"\ndescription = \"a gel\"\n\n[parameters]\nelastic_modulus_pa = 100\n\
    viscosity_pa_s_alpha = 5.0\norder = 0.3\n\n[source]\ncitation = \"me\"\nconditions = \"21 °C\"\nchecked = true\n";
const TABLE: &str =
    "Time [s];Modulus [Pa]\n0,1;500\n0,2;435,3\n0,4;379\n0,8;330\n1,6;287\n3,2;250\n";

/// Time of a processor that ended children of this process have taken, s.
fn children_s() -> f64 {
    let message = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = message.rsplit(") ").next().unwrap_or_default().split(' ');
    let ticks = fields.skip(13).take(2).flat_map(str::parse::<f64>);
    ticks.sum::<f64>() / 100.0
}

/// `CAMPAIGN_CASES`: broken files, 8 by default, each given to all that reads its kind.
#[test]
fn a_broken_file_of_any_kind_ends_in_one_line_and_no_loss_is_silent() {
    let place = with_log();
    let log = [
        "log check broken.mcap",
        "log info broken.mcap",
        "log export broken.mcap broken.csv --overwrite",
        "log recover broken.mcap saved.mcap --overwrite",
        "log plot broken.mcap --out pictures --overwrite",
        "identify broken.mcap --area 4cm2 --thickness 20mm",
        "run broken.mcap --out again --overwrite",
    ];
    let whole = place.read("run/relax.mcap");
    let kinds = [
        ("broken.mcap", &whole[..], &log[..]),
        (
            "wall.toml",
            WALL.as_bytes(),
            &["run wall.toml --out again --overwrite"],
        ),
        (
            "gel.toml",
            GEL.as_bytes(),
            &["relax --tissue gel.toml --duration 2s --out again --overwrite"],
        ),
        (
            "table.csv",
            TABLE.as_bytes(),
            &["identify table.csv --model spring-pot"],
        ),
    ];
    for (name, whole, lines) in kinds {
        place.write(name, whole);
        for line in lines {
            place.run(line).succeeded_with_warnings();
        }
    }
    let (mut random, mut codes, mut slowest_s) = (testkit::Random(65), [0; 5], 0.0_f64);
    let cases = testkit::cases(8);
    for case in 0..cases {
        let (name, whole, lines) = kinds[case % kinds.len()];
        place.write(name, testkit::broken(whole, &mut random));
        for line in lines {
            let before_s = children_s();
            let ended = place.run(&format!("{line} --json"));
            slowest_s = slowest_s.max(children_s() - before_s);
            let code = ended.code.filter(|code| [0, 1, 2, 4].contains(code));
            let code = code.unwrap_or_else(|| panic!("{case}: {ended}"));
            codes[code as usize] += 1;
            if code > 0 {
                ended.failed(code);
                continue;
            }
            let message = ended.succeeded_with_warnings().json();
            let counts = ["log check", "log export", "log recover"];
            if counts.iter().any(|start| line.starts_with(start)) {
                assert_eq!(number(&message, "samples"), 3001.0, "{case}: {line}");
            }
        }
    }
    println!("{cases} broken files, exit codes {codes:?}, slowest {slowest_s} s");
    assert!(codes[0] < codes[2] + codes[4], "{codes:?}");
}
