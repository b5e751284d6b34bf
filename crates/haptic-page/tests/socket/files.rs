//! Files that a person gives the page: plants, controllers, tissues, experiments; and logs that another program writes.

use crate::{assert_documented, has, hello, opened, prostate, question, ran};
use haptic_log::record::LogWriter;
use haptic_message::TickMessage;
use serde_json::{Value, json};
use std::fs;
use testkit::{assert_relative, assert_says};

fn control(more: &Value) -> Value {
    let mut asked = json!({"plant": "0.55exp(-s)/(62s+1)", "crossover_rad_s": 0.1,
        "phase_margin_rad": 65_f64.to_radians(), "not_flat": false});
    for (key, value) in more.as_object().expect("an object") {
        asked[key] = value.clone();
    }
    question("control", "control", asked)
}

fn file(name: &str, text: &str) -> Value {
    json!({"name": name, "text": text})
}

const PID: &str = "[pid]\nproportional_gain = 5.0\nintegral_gain_per_s_lambda = 0.1\nintegral_order = 1.0\n\
    derivative_gain_s_mu = 0.0\nderivative_order = 1.0\n\n[loop]\nsample_time_s = 0.5\n";

#[test]
fn a_plant_and_a_controller_may_be_files() {
    let (_runs, _server, mut page) = opened();
    let typed = page.ask("ask", control(&json!({})));
    assert_documented("control", &typed);
    let plant = "[transfer_function]\nfunction = \"0.55/(62s+1)\"\ndelay_s = 1.0\n";
    let both = json!({"plant": "", "plant_file": file("tank.toml", plant), "controller_file": file("my.toml", PID)});
    let read = page.ask("ask", control(&both));
    assert_eq!(read["plant"], typed["plant"]);
    assert_eq!(read["fractional"], typed["fractional"]);
    // A load moves the output by what the integral takes away again: −1 on the command of a PI in the end.
    let law = &read["own"];
    has(law, json!({"stable": true}));
    assert_eq!(law["gains"]["proportional_gain"], 5.0);
    let loaded = law["loaded"].as_array().expect("a curve");
    let most = loaded.iter().filter_map(Value::as_f64);
    let most = most.fold(0.0_f64, f64::max);
    assert!(most > 0.01 && most < 0.55, "{most}");
    let last = loaded.last().and_then(Value::as_f64).expect("a number");
    assert!(last.abs() < 0.05 * most, "{last} of {most}");
    let gains = typed["fractional"]["robustness"]
        .as_array()
        .expect("a family");
    let stable = |one: &Value| one["stable"] == true;
    assert!(gains.len() == 5 && gains.iter().all(stable), "{gains:?}");
    // A device in place of a plant, as for the command.
    let device = json!({"plant": "", "mass_kg": 0.065, "damping_n_s_per_m": 3.5, "delay_s": 0.001, "crossover_rad_s": 50});
    let held = page.ask("ask", control(&device));
    has(&held["fractional"], json!({"stable": true}));
    let words = held["plant"].as_str().expect("words");
    assert_says(&words, "0.065");
    for [wrong, words] in testkit::table(
        r#"
        {"mass_kg": 0.065} | `mass_kg` belongs to a device
        {"plant_file": {"name": "tank.toml", "text": "[dance]"}} | tank.toml
        {"plant_file": {"name": "tank.csv", "text": "a,b"}} | tank.csv
        {"controller_file": {"name": "my.toml", "text": "[pid]"}} | my.toml
        {"plant": "1/(s+"} | plant "1/(s+":
        {"plant": "1e30/(s+1)"} | is not from
        {"noise": "10"} | `noise`: "10" is not FREQUENCY:GAIN
        {"plant": ""} | no plant: give `plant`
        {"crossover_rad_s": 1e300} | is not from
        "#,
    ) {
        let wording = page.refused("ask", control(&wrong.parse().expect("JSON")));
        assert!(
            wording.contains(&words) && !wording.contains('\n'),
            "{wording}"
        );
    }
}

/// Rows of a spring-pot's relaxation, 1000·t^(−0.2)/Γ(0.8), its time in ms and its modulus in kPa, under a header that says nothing.
fn unnamed() -> String {
    let rows = (0..60).map(|n| {
        let t = 10.0_f64.powf(-1.0 + f64::from(n) / 20.0);
        format!("{},{}\n", 1e3 * t, t.powf(-0.2) / 1.164_229_713_725_303)
    });
    format!("a,b\n{}", rows.collect::<String>())
}

#[test]
fn columns_and_units_are_chosen_and_the_tissue_is_kept_and_felt() {
    let (runs, _server, mut page) = opened();
    let asked = |columns: &str, units: &str| {
        let record = json!({"name": "My gel.csv", "text": unnamed(), "model": "spring-pot", "columns": columns, "units": units});
        question("identify", "record", record)
    };
    let found = page.ask("ask", asked("time=1, modulus=b", "time=ms,modulus=kPa"));
    assert_documented("record", &found);
    let parameters = &found["report"]["candidates"][0]["parameters"];
    let [modulus, order] = ["viscosity_pa_s_alpha", "order"].map(|name| &parameters[name]);
    assert_relative(
        "order",
        order["value"].as_f64().expect("a number"),
        0.2,
        1e-6,
    );
    assert_relative(
        "modulus",
        modulus["value"].as_f64().expect("a number"),
        1000.0,
        1e-6,
    );
    let [low, high] = ["low_95", "high_95"].map(|end| order[end].as_f64().expect("an end"));
    assert!(low <= 0.2 + 1e-9 && high >= 0.2 - 1e-9, "{order}");
    for (columns, units, words) in [
        ("", "", "My gel.csv: "),
        ("time=1,modulus=9", "", "My gel.csv: "),
        (
            "time=1,colour=2",
            "",
            "`columns`: \"colour=2\" is not NAME=VALUE",
        ),
        (
            "time=1,modulus=2",
            "ms",
            "`units`: \"ms\" is not NAME=VALUE",
        ),
        ("time=1,modulus=2", "time=parsec", "My gel.csv: "),
    ] {
        let wording = page.refused("ask", asked(columns, units));
        assert!(
            wording.starts_with(words) && !wording.contains('\n'),
            "{wording}"
        );
    }
    for none in ["", "a,b\n1,2\n", "\u{0}\u{1}\u{2}", "time_s\n1\n2\n"] {
        let record = json!({"name": "x.csv", "text": none});
        let refused = page.refused("ask", question("identify", "record", record));
        let is_line = refused.starts_with("x.csv") && !refused.contains('\n');
        assert!(is_line, "{refused}");
    }
    let tissue = &found["tissue"];
    assert_eq!(tissue["name"], "my-gel");
    let text = tissue["text"].as_str().expect("a file");
    assert_says(&text, "fit by a test to the relaxation of My gel.csv");
    let kept = page.ask("tissue.keep", json!({"name": "my-gel", "text": text}));
    assert_documented("tissue.keep", &kept);
    let path = runs.path().join("tissues/my-gel.toml");
    assert_eq!(kept["path"], path.display().to_string());
    page.refuses(
        "tissue.keep",
        json!({"name": "my-gel", "text": text}),
        "already",
    );
    page.refuses(
        "tissue.keep",
        json!({"name": "My gel", "text": text}),
        "lower-case",
    );
    page.refuses(
        "tissue.keep",
        json!({"name": "other", "text": "no tissue"}),
        "the tissue:1",
    );
    let tissues = hello(&mut page)["tissues"].take();
    let tissues = tissues.as_array().expect("a list");
    assert!(tissues.iter().any(|tissue| tissue["name"] == "my-gel"));
    let felt = page.ask("feel.start", json!({"environment": {"tissue": "my-gel"}}));
    assert_relative(
        "order",
        felt["feel"]["order"].as_f64().expect("a number"),
        0.2,
        1e-6,
    );
    page.ask("feel.start", prostate());
}

#[test]
fn a_file_is_said_to_be_what_it_is() {
    let (_runs, _server, mut page) = opened();
    let wall = page.ask("file", file("w.toml", "[wall]\norder = 0.5\n"));
    assert_documented("file", &wall);
    has(&wall, json!({"is": "experiment"}));
    has(
        &wall["experiment"],
        json!({"kind": "wall", "parameters": {"order": 0.5}}),
    );
    has(
        &page.ask("file", file("c.toml", PID)),
        json!({"is": "controller"}),
    );
    page.refuses("file", file("d.toml", "[dance]\n"), "d.toml");
    page.refuses("file", file("d.toml", "[["), "d.toml: not TOML");
}

fn log_of(path: &std::path::Path, ticks: u64) -> LogWriter<std::io::BufWriter<fs::File>> {
    fs::create_dir_all(path.parent().expect("a folder")).expect("made");
    let mut log = LogWriter::create(path).expect("made");
    for tick in 0..ticks {
        let time_s = tick as f64 * 1e-3;
        let message = TickMessage {
            tick,
            time_s,
            ..TickMessage::at_rest(1)
        };
        log.tick(&message).expect("written");
    }
    log
}

#[test]
fn the_list_has_what_another_program_writes_and_the_verdict_of_every_run() {
    let (runs, _server, mut page) = opened();
    let done = ran(&mut page, "relax", json!({"duration_s": 2}));
    let verdict = done["verdict"].as_str().expect("a verdict").to_owned();
    let mut writing = log_of(&runs.path().join("beside/wall.mcap"), 300);
    // Closes a chunk.
    writing
        .metadata(
            "experiment",
            [("experiment".to_owned(), "wall".to_owned())].into(),
        )
        .expect("written");
    let cut = log_of(&runs.path().join("cut/wall.mcap"), 300);
    drop(cut);
    let listed = |page: &mut crate::Page, name: &str| -> Value {
        let runs = page.ask("runs.list", json!({}))["runs"].take();
        let runs = runs.as_array().expect("a list").clone();
        runs.into_iter()
            .find(|run| run["name"] == name)
            .expect(name)
    };
    has(
        &listed(&mut page, "beside/wall"),
        json!({"running": true, "kind": "wall", "verdict": null}),
    );
    has(
        &listed(&mut page, "cut/wall"),
        json!({"running": false, "verdict": "cut off or damaged"}),
    );
    has(
        &page.ask("runs.open", json!({"name": "beside/wall"})),
        json!({"running": true, "samples": 300}),
    );
    writing.finish().expect("finished");
    has(&listed(&mut page, "beside/wall"), json!({"running": false}));
    // The verdict is in the log: a server that has not run it says it too.
    has(
        &listed(&mut page, "relax-0001/relax"),
        json!({"verdict": verdict}),
    );
    let (other, _server, mut later) = opened();
    fs::create_dir(other.path().join("old")).expect("made");
    let log = runs.path().join("relax-0001/relax.mcap");
    fs::copy(log, other.path().join("old/relax.mcap")).expect("copied");
    has(
        &listed(&mut later, "old/relax"),
        json!({"verdict": verdict}),
    );
    let opened = later.ask("runs.open", json!({"name": "old/relax"}));
    assert_eq!(opened["metadata"]["verdict"]["verdict"], verdict);
}

/// Options of a record, as JSON, and what is answered: a pointer and its value, or the refusal.
const OPTIONS: &str = r#"
    {"master_curve": "293.15K"} | /report/shifts/2/temperature_c | 40.0
    {"master_curve": 20, "shift_by": "loss"} | /report/reference_temperature_c | 20.0
    {"segment": "2"} | /report/samples | 5
    {"segment": "1", "fix": "order=0.3"} | /report/parameters/order/value | 0.3
    {} | refused | gel.csv: 3 segments could be meant
    {"segment": "1", "contact_point_m": "1 mm"} | refused | gel.csv: `contact_point_m` has no effect
    {"segment": "1", "fix": "order"} | refused | `fix`: "order" is not PARAMETER=VALUE
    {"shift_by": "loss"} | refused | `shift_by` has no effect without `master_curve`
"#;

#[test]
fn a_record_is_asked_with_the_options_of_the_command() {
    let (_runs, _server, mut page) = opened();
    let rows = [20.0, 30.0, 40.0_f64].into_iter().flat_map(|celsius| {
        (0..5).map(move |n| {
            let omega = 10_f64.powf(f64::from(n) / 2.0);
            let modulus = 1e3 * omega.powf(0.25) * 10_f64.powf(0.01 * (20.0 - celsius));
            format!("{omega},{modulus},{},{celsius}\n", 0.414_213_56 * modulus)
        })
    });
    let text = format!(
        "omega_rad_s,storage_modulus_pa,loss_modulus_pa,temperature_c\n{}",
        rows.collect::<String>()
    );
    for [options, place, wanted] in testkit::table(OPTIONS) {
        let mut record: Value = serde_json::from_str(&options).expect("options");
        record["name"] = json!("gel.csv");
        record["text"] = json!(text);
        record["model"] = json!("spring-pot");
        let asked = question("identify", "record", record);
        if place == "refused" {
            let wording = page.refused("ask", asked);
            assert!(wording.starts_with(&wanted), "{options}: {wording}");
            continue;
        }
        let found = page.ask("ask", asked);
        assert_documented("record", &found);
        let value = found.pointer(&place).and_then(Value::as_f64);
        let value = value.unwrap_or_else(|| panic!("{options}: {found}"));
        assert_relative(&options, value, wanted.parse().expect("a number"), 1e-9);
    }
}

#[test]
fn a_contact_point_that_was_found_is_in_the_report() {
    let (_runs, _server, mut page) = opened();
    // A sphere of 4 mm on a spring of 1 kPa, which it touches at 0.1 mm: F = 16/9 √R E δ^1.5.
    let rows = (0..=200).map(|n| {
        let depth = 5e-6 * f64::from(n);
        let force = 16.0 / 9.0 * 4e-3_f64.sqrt() * 1e3 * (depth - 1e-4).max(0.0).powf(1.5);
        format!("{},{depth},{force}\n", 5e-3 * f64::from(n))
    });
    let text = format!("time_s,position_m,force_n\n{}", rows.collect::<String>());
    let record = json!({
        "name": "sphere.csv", "text": text, "loading": "sphere", "indenter_radius_m": 4e-3,
        "model": "spring", "contact_point_m": "fit",
    });
    let found = page.ask("ask", question("identify", "record", record));
    let contact = &found["report"]["parameters"]["contact_point_m"]["value"];
    assert_relative("contact", contact.as_f64().expect("found"), 1e-4, 1e-3);
    let lines = found["lines"].to_string();
    assert_says(&lines, "contact_point");
}
