//! What people type in their first hour: each answer names the remedy.

use crate::process::{Place, cases};
use testkit::assert_says;

/// A line as it is typed, and what its answer says.
const MISTAKES: &str = "
    run experiments/wall.toml mass=65 => 65 has no unit: write 65g, or 65kg
    design --mass 65 => --mass 65: 65 has no unit: write 65g, or 65kg
    relax --sample-time 1 => --sample-time 1: 1 has no unit: write 1ms, or 1s
    design --delay 3 => 3 has no unit: write 3ms, or 3s
    relax --thickness 10 => 10 has no unit: write 10mm, or 10m
    control design --plant 1/(s+1) --crossover 1rad/s --phase-margin 60 => 60 has no unit: write 60deg, or 60rad
    control analyze --plant 1/(0,05s+1) => character 4 | a decimal point
    relax strain=0,05 => strain=0,05 | write 0.05, without a comma
    relax --strain 0,05 => write 0.05, without a comma
    relax --strain 1,234 => write 1.234 or 1234, without a comma
    weights --order 0,5 => write 0.5, without a comma
    relax --sample-time 1MS => write 1ms
    relax --duration 60 s => write 60s, without a blank
    differintegrate --order 0.5 --sample-time 1 ms signal.csv => write 1ms, without a blank
    zwidth --orders 0.5 1 => write 0.5,1, if both are of --orders
    relax --device /dev/ttyACM0 => write serial:/dev/ttyACM0
    relax --device COM3 => write serial:COM3
    run experiments/wall.toml stifness=3 => did you mean `stiffness_n_per_m`?
    run experiments/wall.toml foo=1 => unknown key `foo` | known are
    analyze stability stifness=3 => stifness=3: unknown key | did you mean `stiffness_n_per_m`?
    relax --tissue Liver => did you mean `liver`?
    relax --tissue prostate-helthy => did you mean `prostate-healthy`?
    run comma.toml => comma.toml:2: decimals have a point, not a comma
    log info results => `results` is a folder: give results/a.mcap or results/b.mcap
    log check empty => `empty` is a folder: give a NAME.mcap
    serve --no-browser --port 0 --runs comma.toml => --runs `comma.toml` is a file: give a folder
    identify relax.csv --fix order=0,2 => decimals with a point
";

#[test]
fn each_mistake_is_answered_with_its_remedy() {
    let place = Place::with_examples();
    place.write("comma.toml", "[wall]\nstiffness_n_per_m = 1000,5\n");
    let rows = "time_s,relaxation_modulus_pa\n1,5\n2,4\n3,3\n4,2.5\n5,2.2\n";
    place.write("relax.csv", rows);
    for folder in ["results", "empty"] {
        std::fs::create_dir(place.path(folder)).expect("a folder");
    }
    for log in ["results/a.mcap", "results/b.mcap"] {
        place.write(log, "");
    }
    let complaints = cases(MISTAKES).into_iter().filter_map(|(line, wanted)| {
        let complaint = place.run(line).complaint(2, &wanted);
        complaint.map(|complaint| format!("{line}: {complaint}"))
    });
    let all = complaints.collect::<Vec<_>>().join("\n");
    assert!(all.is_empty(), "{all}");
}

/// What is written in full is taken, whatever it is.
#[test]
fn an_explicit_unit_is_taken() {
    let place = Place::with_examples();
    for line in [
        "design --mass 65kg --sample-time 1ms --orders 1",
        "analyze stability order=1 mass_kg=65 damping=1N*s/m sample-time=1s stiffness=1 dissipation=1",
        "analyze stability order=1 mass=65kg damping=1N.s/m sample-time=1s stiffness=1 dissipation=1",
        "analyze stability order=1 mass=65kg damping=1N·s/m sample-time=1s stiffness=1 dissipation=1",
    ] {
        let ended = place.run(line);
        assert_ne!(ended.code, Some(2), "{ended}");
    }
}

#[test]
fn a_text_without_end_where_a_number_is_wanted_is_refused_by_its_beginning() {
    let place = Place::new();
    let open = "[".repeat(40_000);
    place.write("x.toml", format!("[relax]\nstrain = 1{open}\n"));
    for line in [
        "relax strain=1OPEN",
        "device emulate mass=1OPEN",
        "run x.toml",
        "relax --thickness 1OPENm",
    ] {
        let ended = place.run(&line.replace("OPEN", &open));
        let error = ended.error();
        assert!(error.len() < 500, "{error:.600}");
        if line.contains("thickness") {
            assert_says(error, "1[[[[[[[[[[[[[[[[[[[… & at most 64 characters");
        }
    }
}

#[test]
fn a_file_is_read_in_the_encoding_in_which_other_programs_save_it() {
    let place = Place::new();
    let text = "# 5 µm\n[relax]\nstrain = 0.03\n";
    let wide = format!("\u{feff}{text}");
    let wide: Vec<u8> = wide.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let narrow: Vec<u8> = text.chars().map(|c| c as u8).collect();
    for (name, bytes) in [("wide", wide), ("narrow", narrow), ("utf8", text.into())] {
        place.write(&format!("{name}.toml"), bytes);
        let line = format!("run {name}.toml --write {name}-again.toml");
        place.run(&line).succeeded();
        let again = place.text(&format!("{name}-again.toml"));
        assert!(again.contains("strain = 0.03"), "{name}: {again}");
    }
    place.write("nothing.toml", [0_u8, 1, 2, 3, 4, 5, 6, 7]);
    assert_says(place.run("run nothing.toml").error(), "this is no text");
}
