//! `control`: from wishes to a controller, its loop, and back from a record to a plant.

use crate::process::{Place, holds, keys, number};
use serde_json::Value;
use testkit::{assert_close, assert_relative, assert_says};

const OVEN: &str = "0.55exp(-s)/(62s+1)";
const PODLUBNY: &str = "1/(0.8s^2.2+0.5s^0.9+1)";

/// Keys of the report of a design.
const OF_A_DESIGN: &str = "coarse controller controller_file files integer integer_reason limited_share margins notes \
                          overshoot_spread plant robust robustness sample_time_s scheme shape specification stable \
                          stable_gain_high stable_gain_low step";

#[test]
fn a_design_meets_its_wishes_and_the_files_are_what_other_commands_take() {
    let place = Place::new();
    let line = format!(
        "control design --plant {OVEN} --crossover 0.1rad/s --phase-margin 65deg --output-limits 0:10 --out d --json"
    );
    let report = place.run(&line).succeeded().json();
    assert_eq!(keys(&report), OF_A_DESIGN);
    assert_eq!(report["stable"], true);
    let wishes = report["specification"].as_array().expect("a list");
    let names = wishes.iter().filter_map(|wish| wish["name"].as_str());
    let names: Vec<&str> = names.collect();
    let wanted = "crossover_rad_s phase_margin_deg phase_slope_deg_per_decade";
    assert_eq!(names.join(" "), wanted);
    assert!(wishes.iter().all(|wish| wish["met"] == true), "{wishes:?}");
    assert_close("wanted", number(&wishes[1], "wanted"), 65.0, 1e-9);
    assert_relative("reached", number(&wishes[1], "reached"), 65.0, 0.01);
    // Iso-damped: the integer-order PID is at least three times worse.
    let [spread, other] =
        [&report, &report["integer"]].map(|answer| number(answer, "overshoot_spread"));
    assert!(other > 3.0 * spread, "{spread} {other}");
    let files = "d/ d/controller.csv d/controller.png d/controller.svg d/controller.toml";
    assert_eq!(place.listing(), files);
    let line = format!("control analyze --plant {OVEN} --controller d/controller.toml");
    let analysis = place.json(&line);
    let margin = number(&analysis["margins"], "phase_margin_deg");
    assert_relative("margin", margin, 65.0, 0.01);
    // The step is that of the design.
    let line = format!("control simulate --plant {OVEN} --controller d/controller.toml");
    let run = place.json(&line);
    let overshoot = |report: &Value| number(&report["shape"], "overshoot");
    assert_close("overshoot", overshoot(&run), overshoot(&report), 1e-9);
    // Nothing is overwritten unasked.
    let line = format!("control design --plant {OVEN} --crossover 0.1rad/s --out d");
    place
        .run(&line)
        .refused(2, &["controller", "already exists", "--overwrite"]);
}

#[test]
fn a_wish_that_is_not_met_ends_with_1_and_says_by_how_much() {
    let place = Place::new();
    let line = format!(
        "control design --plant {OVEN} --crossover 0.1rad/s --phase-margin 65deg --sensitivity-peak 1.01 --out d --json"
    );
    let ended = place.run(&line).failed(1);
    assert_says(ended.error(), "not met: largest |S| & instead of 1.01 (+");
    // The report is there all the same, and the file says so.
    let report = ended.json();
    let wishes = report["specification"].as_array().expect("a list").iter();
    let missed: Vec<&Value> = wishes
        .filter(|wish| wish["met"] == false)
        .map(|wish| &wish["name"])
        .collect();
    assert_eq!(missed, ["sensitivity_peak"]);
    assert_says(
        &place.text("d/controller.toml"),
        "note = \"not met: largest |S|",
    );
}

/// Parts of opposite signs latched at their limit, and blew up, with "stable yes" and exit code 0.
#[test]
fn a_loop_that_does_not_end_at_its_reference_says_so_and_ends_with_1() {
    let place = Place::new();
    let on =
        |rest: &str| format!("control simulate --plant 1/(s+1) --sample-time 10ms {rest} --json");
    let run = place.run(&on(
        "--controller=-0.2+1/s --output-limits=-1:1 --step 0.9 --duration 60s",
    ));
    let run = run.succeeded_with_warnings().json();
    assert_eq!(run["at_reference"], true);
    let error = number(&run["shape"], "final_error");
    assert!(error < 1e-3, "{error}");
    // More than its limit can hold; the report is there all the same.
    let ended = place.run(&on(
        "--controller=-1+10/s^0.5 --output-limits=-1:1 --step 5 --duration 20s",
    ));
    let ended = ended.failed(1);
    assert_says(
        ended.error(),
        "ends at 1, not at its reference 5 & at a limit & --output-limits",
    );
    assert_eq!(ended.json()["at_reference"], false);
    // One that grows beyond all numbers.
    let line = "control simulate --plant 1/(s-1) --sample-time 10ms --controller 0.5+0.1/s --duration 1200s";
    let ended = place.run(line).failed(1);
    assert_says(
        ended.error(),
        "not at its reference 1 & unstable & control analyze",
    );
    assert!(!ended.error().contains("widen"), "{}", ended.error());
    // No integral: it ends where its gain lets it, which is its reference only if the gain is large.
    for gain in [20, 10, 1] {
        let run = place.run(&on(&format!("--controller {gain} --duration 20s")));
        if gain == 20 {
            assert_eq!(run.succeeded().json()["at_reference"], true);
            continue;
        }
        let ended = run.failed(1);
        assert_eq!(ended.json()["at_reference"], false, "{gain}");
        assert_says(ended.error(), "rests beside it & an integral");
    }
    // Too short to get there.
    place
        .run(&on("--controller 1+1/s --duration 0.5s"))
        .succeeded();
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_plant_comes_back_from_its_own_step() {
    let place = Place::new();
    let line = format!("control simulate --plant {PODLUBNY} --duration 20s --out r");
    place.run(&line).succeeded();
    let line = "control identify r/response.csv --columns input=command --out p.toml --json";
    let found = place.run(line).succeeded().json();
    assert_eq!(
        keys(&found),
        "begins bic candidates delay_determined delay_high_s delay_low_s delay_s files fit function input_before noise_order numbers \
         offset order_reason output_read plant_file rms_residual sample_time_s samples unstable_poles unstable_poles_reason validation \
         warnings"
    );
    assert_eq!(
        place.listing(),
        "p.png p.svg p.toml r/ r/response.csv r/response.png r/response.svg"
    );
    place.run("control analyze --plant p.toml").succeeded();
    place.run(line).refused(2, &["p.toml"]);
}

/// Three seconds of 1/(1000s + 1) determine the quotient of gain and time constant, within steps of 1e-4, and not each.
#[test]
fn what_a_record_does_not_determine_is_in_the_json() {
    let place = Place::new();
    let row = |n: i32| {
        let t = 0.01 * f64::from(n);
        // White noise: slow noise, as of few digits, would leave an integrator alone, which is determined.
        let y = 1e-4 * f64::from(n * n).sin() - f64::exp_m1(-t / 1000.0);
        format!("{t},1,{y}\n")
    };
    let rows: String = (0..300).map(row).collect();
    place.write("one.csv", format!("time_s,input,output\n{rows}"));
    let ended = place.run("control identify one.csv --model 1/(1000s+1) -q --json");
    let json = ended.succeeded_with_warnings().json();
    assert_says(
        &json["warnings"].to_string(),
        "does not determine numerator_coefficient_1",
    );
    let numbers = json["numbers"].as_array().expect("numbers");
    for determined in [false, true] {
        let some = numbers
            .iter()
            .any(|number| number["determined"] == determined);
        holds(some, &json);
    }
}

/// The integer-order PID grows, and its steps swing: the picture says what it leaves out, and of what grows no number is told.
#[test]
fn a_design_that_is_lost_at_twice_its_gain_is_warned_of_in_words_file_and_picture() {
    let place = Place::new();
    let line = "control design --plant exp(-0.1s)/(s+1) --crossover 13rad/s --phase-margin 25deg --not-flat --out late";
    let shown = place.run(line).succeeded().stdout;
    assert_says(
        &shown,
        "Warning: the sampled loop is proved stable only from",
    );
    let rows = shown
        .lines()
        .map(|line| line.split_whitespace().collect::<Vec<_>>());
    let unstable: Vec<_> = rows.filter(|row| row.len() > 2 && row[1] == "no").collect();
    assert_eq!(unstable.len(), 4, "{shown}");
    let has_value = |row: &Vec<&str>| row[2..].iter().any(|cell| *cell != "–");
    assert!(!unstable.iter().any(has_value), "{shown}");
    assert!(!shown.contains("overshoot spread"), "{shown}");
    assert_says(&place.text("late/controller.toml"), "proved stable only");
    let left_out = "left out: integer-order PID at gain +3 dB, which grows";
    assert_says(&place.text("late/controller.svg"), left_out);
}

#[test]
fn a_trajectory_of_a_table_is_followed_sample_by_sample() {
    let place = Place::new();
    place.write(
        "pid.toml",
        "[pid]\nproportional_gain = 3\nintegral_gain_per_s_lambda = 2\n\n[loop]\nsample_time_s = 0.01\n",
    );
    place.write("ramp.csv", "time_s,reference\n0,0\n1,0.5\n2,1\n4,1\n");
    let line = "control simulate --mass 500g --damping 3 --hand-stiffness 1 --controller pid.toml --reference ramp.csv --json";
    let run = place.run(line).succeeded_with_warnings().json();
    assert_eq!(run["stable"], true);
    assert!(run["shape"].is_null());
    let samples = run["step"].as_array().expect("samples");
    assert_eq!(samples.len(), 401);
    let references = [150, 200].map(|n| number(&samples[n], "reference"));
    assert_eq!(references, [0.5, 1.0]);
    place.write("gap.csv", "time_s,reference\n0,0\n1,\n2,1\n");
    let line = "control simulate --plant 1/(s+1) --controller pid.toml --reference gap.csv";
    place.refuses(&format!(
        "{line} => gap.csv: 1 row (line 3) without a reference | delete the row"
    ));
}

/// 2e^(−0.35s)/(s + 1) as a German spreadsheet saves it, an output missing.
#[test]
fn a_german_record_gives_its_plant_and_its_dead_time_back() {
    let place = Place::new();
    let row = |n: i32| {
        let t = 0.05 * f64::from(n);
        let y = -2.0 * f64::exp_m1(-(t - 0.35).max(0.0));
        let level = if n == 50 {
            String::new()
        } else {
            format!("{y:.6}")
        };
        format!("{};1;{level}\n", 50 * n).replace('.', ",")
    };
    let rows: String = (0..120).map(row).collect();
    place.write(
        "tank.csv",
        format!("Prüfstand 3;;\n\nZeit [ms];Stellgröße [%];temperatur_c\n{rows}"),
    );
    let line = "control identify tank.csv -q --json";
    let json = place.run(line).succeeded_with_warnings().json();
    holds((number(&json, "delay_s") - 0.35).abs() < 1e-3, &json);
    holds(
        number(&json, "delay_low_s") <= 0.3501 && number(&json, "delay_high_s") >= 0.3499,
        &json,
    );
    assert_says(
        &json["warnings"].to_string(),
        "1 row (line 54) without an output & straight line & column Stellgröße [%] is taken as the input & temperatur_c is taken as the output",
    );
    assert_eq!(json["delay_determined"], true);
    let two = "t,u,Temperatur,y\n0,0,0,0\n1,1,1,1\n2,1,1,1\n";
    place.write("two.csv", two);
    place.refuses(
        "control identify two.csv => more than one column is named output | give its number",
    );
    place.write("no.csv", "PK\u{3}\u{4}\u{14}");
    place.refuses("control identify no.csv => no.csv: this is no workbook | CSV");
}

#[test]
fn noise_is_no_plant_and_a_short_rise_tells_its_dead_time_only_between_two() {
    let place = Place::new();
    let mut random = testkit::Random(4);
    let mut noise = || (1..=12).map(|_| random.between(-0.5, 0.5)).sum::<f64>();
    let rows: String = (0..100)
        .map(|n| format!("{n},{},{}\n", n / 25 % 2, noise()))
        .collect();
    place.write("noise.csv", format!("time_s,input,output\n{rows}"));
    let ended = place.run("control identify noise.csv --out plant.toml");
    ended.refused(
        1,
        &["the record shows no response to its input", "--columns"],
    );
    assert_eq!(place.files(), ["noise.csv"]);
    let row = |n: i32| {
        let t = 0.1 * (f64::from(n) - 5.0);
        format!("{n},1,{}\n", -f64::exp_m1(-t.max(0.0)) + 0.1 * noise())
    };
    let rows: String = (0..40).map(row).collect();
    place.write("few.csv", format!("time_s,input,output\n{rows}"));
    let json = place.run("control identify few.csv --model 1/(10s+1) -q --json");
    let json = json.succeeded_with_warnings().json();
    assert_eq!(json["delay_determined"], false);
    assert_says(
        &json["warnings"].to_string(),
        "does not determine the dead time, from & `delay_s`",
    );
}

/// What is wrong with plants, controllers, wishes and records is tested with `control-tuning`, `control-identification` and `haptic-question`.
#[test]
fn bad_input_is_refused_with_its_place() {
    let place = Place::new();
    place.write("p.toml", "[device]\nmass_kg = 1\ndampng_n_s_per_m = 2\n");
    place.write(
        "below.csv",
        "omega_rad_s,gain,phase_deg\n1,2,0\n2,-2,0\n3,1,0\n",
    );
    let band = "omega_rad_s,gain,phase_deg\n1,2,0\n2,1,-20\n3,0.5,-40\n";
    place.write("band.csv", band);
    place.write("back.csv", "time_s,input,output\n0,1,0\n1,1,1\n0.5,1,2\n");
    place.write("clockless.csv", "input,output\n0,0\n1,0\n");
    place.refuses(
        "
        control analyze --plant p.toml => p.toml:3 | did you mean `damping_n_s_per_m`
        control analyze --plant 1/(s+1 => character 6 | closing bracket
        control design --crossover 1rad/s --plant 1/(s+1) --phase-margin 65 => 65 has no unit: write 65deg, or 65rad
        control design --crossover 1rad/s --plant 1/(s+1) --phase-margin 65rad => 3724° | 180° | --phase-margin | 60deg
        control design --crossover 1rad/s --plant exp(-10000s)/(s+1) => dead time 500000 samples | at most 10000 | lengthen --sample-time
        control design --crossover 1rad/s --plant (s^2+1)/(s^2+2s+3) => has a zero at --crossover 1 rad/s | move --crossover
        control design --crossover 1rad/s --plant 1/(s^2+1) => has an undamped pole at --crossover 1 rad/s | move --crossover
        control design --crossover 1rad/s --plant 1e-20/(s+1) => gain 7.0 | change its units
        control identify back.csv => back.csv: line 4: 0.5 s comes after 1 s | sort
        control identify clockless.csv => clockless.csv | --sample-time
        control identify clockless.csv --sample-time 0s => 1e-9 to 1e6 s | --sample-time
        control design --plant band.csv --crossover 4rad/s => crossover 4 rad/s | 1 to 3 rad/s | --crossover
        control analyze --plant below.csv => below.csv: line 3: gain -2 is below 0 | phase
        ",
    );
    assert_eq!(
        place.files(),
        [
            "back.csv",
            "band.csv",
            "below.csv",
            "clockless.csv",
            "p.toml"
        ]
    );
}

/// A lag behind a dead time beside slow noise: what is asked for narrows the search, and a second record judges what was found.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn poles_stable_validate_and_a_first_dead_time_are_heard() {
    let place = Place::new();
    let mut random = testkit::Random(88);
    let mut normal = || (0..12).map(|_| random.between(-0.5, 0.5)).sum::<f64>();
    // 2·exp(−3 s)/(10 s + 1) by its closed form, and a drift of the correlation 0.9.
    let mut table = |gain: f64| {
        let (mut y, mut drift, mut level, mut text) = (0.0, 0.0, 0.0, String::new());
        let mut inputs: Vec<f64> = Vec::new();
        text.push_str("time_s,input,output\n");
        for n in 0..200 {
            if n % 13 == 0 {
                level = normal();
            }
            inputs.push(level);
            drift = 0.9 * drift + 0.05 * normal();
            text.push_str(&format!("{n},{level},{}\n", 5.0 + y + drift));
            let acts = if n >= 3 { inputs[n - 3] } else { 0.0 };
            y += (gain * acts - y) * -(-0.1f64).exp_m1();
        }
        text
    };
    place.write("one.csv", table(2.0));
    place.write("same.csv", table(2.0));
    place.write("other.csv", table(1.0));
    let line =
        "control identify one.csv --model 1exp(-2s)/(5s+1) --validate same.csv --out p.toml --json";
    let found = place.run(line).succeeded_with_warnings().json();
    assert_close("dead time", number(&found, "delay_s"), 3.0, 0.5);
    assert!(number(&found["validation"], "fit") > 0.9, "{found}");
    assert!(number(&found, "noise_order") >= 1.0, "{found}");
    let line = "control identify one.csv --poles 1 --stable --validate other.csv --json";
    let ended = place.run(line).succeeded_with_warnings();
    let found = ended.json();
    let function = found["function"].as_str().expect("a function");
    assert!(!function.contains("s^"), "{function}");
    assert_eq!(found["unstable_poles"], 0);
    assert!(number(&found["validation"], "fit") < 0.8, "{found}");
    let said = "--validate & times as much as of its own & over the record of --validate & nearer";
    assert_says(&ended.stderr, said);
    let refused = place.run("control identify one.csv --poles 5");
    assert_says(refused.failed(2).error(), "5 & from 1 to 4");
}
