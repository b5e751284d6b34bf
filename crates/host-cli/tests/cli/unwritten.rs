//! Results that find no place: looked for before the work, and told behind the result if they find none after it.

use crate::interrupted::with_short_files;
use crate::process::{Ended, Place, number};
use testkit::assert_says;

/// A record of a step of 2/(0.3s + 1).
fn record() -> String {
    let row = |n: i32| {
        let t = 0.02 * f64::from(n);
        format!("{t},1,{}\n", 2.0 * -(-t / 0.3).exp_m1())
    };
    std::iter::once("time_s,input,output\n".to_owned())
        .chain((0..200).map(row))
        .collect()
}

/// What is there already, and a line that would write it. Each has a second fault, which shows only when the work begins.
const TAKEN: &str = "
    z/zwidth.csv | zwidth --device serial:none --out z
    z/zwidth.png | zwidth --orders 3 --out z
    d.svg | device measure --device serial:none --out d.toml
    d.png | device measure --device serial:none --out d.toml
    d.toml | device measure --device serial:none --out d.toml
    p.png | control identify none.csv --out p.toml
    t.svg | identify none.csv --out t.toml
    c/controller.toml | control design --plant none.toml --crossover 1rad/s --out c
    d/design.toml | design --wish tissue --tissue none --out d
    d/design.csv | design --wish coupler --require stable --out d
    r/region.csv | analyze stability-region --order 1 --scheme oustaloup:5:1:100 --out r
    r/figure-7.2.csv | reproduce --out r
    r/report.md | reproduce --out r
";

#[test]
fn a_place_that_is_taken_is_told_before_the_work() {
    for [taken, line] in testkit::table(TAKEN) {
        let place = Place::new();
        if let Some((folder, _)) = taken.split_once('/') {
            std::fs::create_dir(place.path(folder)).expect("makes");
        }
        place.write(&taken, "mine");
        let before = place.files();
        place.run(&line).refused(2, &[&taken, "already exists"]);
        assert_eq!(place.files(), before, "{line}");
        assert_eq!(place.text(&taken), "mine");
    }
    // A folder that nobody can make, and a look that leaves none behind.
    let place = Place::new();
    let at = |line: &str, out: &str| place.run(&format!("{line} --device serial:none --out {out}"));
    at("zwidth", "/proc/none").refused(2, &["/proc/none"]);
    at("zwidth", "new/z").refused(3, &["none"]);
    at("device measure", "/proc/none.toml").refused(2, &["/proc/none.toml"]);
    assert_eq!(place.files(), [""; 0]);
}

/// Runs where the drawing of this name meets a full disk, and is told so behind the result; nothing where no disk can be full.
fn without_a_drawing(place: &Place, name: &str, line: &str, result: &str) -> Option<Ended> {
    let words: Vec<String> = line.split(' ').map(|word| format!("'{word}'")).collect();
    // Above the tables, at most 59 kB, and below the pictures, at least 54 kB; the region has the largest of both.
    let blocks = if name == "r/region" { 120 } else { 100 };
    let ended =
        with_short_files(place, blocks, &format!("exec \"$0\" {}", words.join(" ")))?.failed(4);
    assert_says(ended.error(), "File too large");
    assert_says(ended.error(), &format!("{name}.png"));
    assert_says(&ended.stdout, result);
    assert!(!ended.stdout.contains(".png"), "{ended}");
    assert!(
        !place.path(&format!("{name}.svg")).exists(),
        "one without the other"
    );
    Some(ended)
}

/// The name of a drawing, the line that makes it, what is told, and the file that is kept.
const DRAWN: &str = "
    z/zwidth | zwidth --orders 1 --points 2 duration=1s --out z | stiffness max | z/zwidth.csv
    r/region | analyze stability-region --order 1 --delta 0.1 --out r | area | r/region.csv
    s/sensitivity | analyze sensitivity --order 1 --alpha 0.1 --beta 0.1 --delta 0.1 --out s | peak | s/sensitivity.csv
    d/design | design --orders 1 --out d | best | d/design.toml
    p | control identify step.csv --model 1/(s+1) --out p.toml | rms residual | p.toml
    device | device measure --device sim --duration 1s --out device.toml | mass | device.toml
";

#[test]
fn what_cannot_be_written_is_told_behind_the_result() {
    let place = Place::new();
    place.write("step.csv", record());
    for [name, line, result, kept] in testkit::table(DRAWN) {
        if without_a_drawing(&place, &name, &line, &result).is_some() {
            assert!(!place.text(&kept).is_empty(), "{line}");
        }
    }
    // For programs the same, and a file that is not there is not named.
    let line = "device measure --device sim --duration 1s --out again.toml --json";
    let Some(report) = without_a_drawing(&place, "again", line, "mass_kg") else {
        return;
    };
    let report = report.json();
    assert_eq!(report["model"], "again.toml");
    assert!(report["figure"].is_null(), "{report}");
}

#[test]
fn a_table_without_space_is_told_behind_the_report() {
    let place = Place::new();
    let experiments = concat!(env!("CARGO_MANIFEST_DIR"), "/../../experiments");
    // Blocks of 512 bytes above the log and the pictures, and below the table.
    for (stem, file, blocks) in [
        ("relax", "relax", 420),
        ("wall", "wall", 2150),
        ("teleoperation", "teleoperation", 2600),
        ("touch", "touch-disc", 1300),
    ] {
        let line = match stem {
            "relax" => "relax --duration 2s --ramp-time 1s".to_owned(),
            // Its log is the larger one, so that has several files.
            "wall" => format!("run {experiments}/{file}.toml duration=60s --roll 1MB"),
            _ => format!("run {experiments}/{file}.toml"),
        };
        let line = format!("exec \"$0\" {line} --out {stem} --overwrite --json");
        std::fs::create_dir(place.path(stem)).expect("makes");
        // That of an earlier run would pass for this one's.
        place.write(&format!("{stem}/{stem}.csv"), "of an earlier run");
        let Some(ended) = with_short_files(&place, blocks, &line) else {
            return;
        };
        let ended = ended.failed(4);
        let words = format!("{stem}.csv & the log is whole & File too large");
        assert_says(ended.error(), &words);
        let report = ended.json();
        assert!(report["csv"].is_null(), "{report}");
        assert!(number(&report, "peak_force_n") > 0.0, "{report}");
        let mut files = place.files();
        files.retain(|file| file.starts_with(&format!("{stem}/{stem}.")));
        let kept = ["mcap", "png", "svg"].map(|extension| format!("{stem}/{stem}.{extension}"));
        assert_eq!(files, kept, "{line}");
    }
}
