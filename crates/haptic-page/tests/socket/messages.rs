//! The page's types of messages are those that the server sends: an example of each, which the compiler of the page checks.

use crate::{ended, hello, opened, prostate, question, ran};
use serde_json::{Value, json};
use std::collections::HashSet;
use std::fs;
use std::path::Path;
use testkit::browser::Page;

/// Variable with which the examples are written, not compared.
const UPDATE: &str = "UPDATE_MESSAGES";

const HEAD: &str = r#"// Examples of messages, which the types of the page must fit: every field of a type is in its example.
// Made from what the server sends: UPDATE_MESSAGES=1 cargo test -p haptic-page --test socket messages

import type { Designed } from "../src/control";
import type { Explained, Identified } from "../src/identify";
import type { Answered } from "../src/loop";
import type { FoundPlant } from "../src/plant-record";
import type { Answer, Form, Hello, Judged, OpenRun, Parameter, RecordParameter, RunEntry, Unasked } from "../src/protocol";

type Whole<T> = T extends object ? { readonly [K in keyof T]-?: Whole<Exclude<T[K], undefined>> } : T;

"#;

/// What an example has shown so far of things in lists.
type Seen = HashSet<String>;

/// Its fields, with values that say their types alone; of all lists a thing of each kind once, of metadata, which are named freely, none.
/// A point or a row of a curve keeps its length.
fn bare(key: &str, value: &Value, seen: &mut Seen) -> Value {
    match value {
        Value::Number(_) => json!(0),
        Value::Bool(_) => json!(false),
        Value::String(_) if key != "state" => json!(""),
        Value::Null | Value::String(_) => value.clone(),
        Value::Array(items) if items.len() <= 5 && items.iter().all(Value::is_number) => {
            json!(vec![0; items.len()])
        }
        Value::Array(items) => {
            let mut kinds = Vec::new();
            for item in items {
                let item = bare("", item, seen);
                let new = !item.is_object() || seen.insert(item.to_string());
                if new && !kinds.contains(&item) {
                    kinds.push(item);
                }
            }
            kinds.into()
        }
        Value::Object(_) if key == "metadata" => json!({}),
        Value::Object(fields) => {
            let fields = fields
                .iter()
                .filter(|(key, _)| *key != "id" && *key != "ok");
            let fields = fields.map(|(key, value)| (key.clone(), bare(key, value, seen)));
            Value::Object(fields.collect())
        }
    }
}

/// The name of each type, and an example of it.
fn examples(page: &mut Page, runs: &Path) -> Vec<(&'static str, Value)> {
    hello(page);
    page.ask("feel.start", prostate());
    let compared = json!({"b": {"scale": 0.9}, "trials": 1, "subject": "p00", "seed": 1});
    page.ask("compare.start", compared);
    let mut status =
        page.status(|status| status["tick_p50_us"].is_number() && status["compare"].is_object());
    page.ask("compare.end", json!({}));
    // Those that act at the moment.
    status["limiters"].take();
    page.ask("feel.mark", json!({"text": "here"}));
    let mark = page.wait("mark", |_| true);
    page.ask("feel.set", json!({"scale": 0.9}));
    let feel = page.wait("feel", |_| true);
    let hello = hello(page);
    page.ask("feel.end", json!({}));
    ran(page, "relax", json!({"duration_s": 2}));
    let before = runs.join("relax-0001/relax.mcap").display().to_string();
    let mut run = ran(page, "relax", json!({"duration_s": 2, "against": before}));
    ran(page, "design", json!({"orders": [1], "scheme": "muir:3"}));
    let long = json!({"orders": [1], "points": 1000, "scheme": "muir:3"});
    page.ask("runs.start", json!({"kind": "zwidth", "parameters": long}));
    let going = page.ask("runs.open", json!({"name": "zwidth-0001/zwidth"}));
    page.ask("runs.stop", json!({}));
    ended(page, |run| run["kind"] == "zwidth");
    let mut answer = page.ask("runs.open", json!({"name": "design-0001/design"}));
    // Any report is shown by its lines; the page takes it as it comes.
    run["report"] = json!({});
    answer["report"] = json!({});
    answer["experiment"]["parameters"] = json!({});
    let unasked = json!({"status": status, "feel": feel, "mark": mark, "run": run, "notice": ""});
    let forms = page.ask("runs.forms", json!({}));
    let wall = json!({
        "order": 0.5, "stiffness_n_per_m": 3000, "dissipation_n_s_mu_per_m": 100, "mass_kg": 0.065,
        "damping_n_s_per_m": 3.5, "sample_time_s": 1e-3, "position_noise_m": 0, "points": 16,
    });
    let plant = json!({"plant": "0.55exp(-s)/(62s+1)", "crossover_rad_s": 0.1, "controller_file": {
        "name": "p.toml", "text": "[pid]\nproportional_gain = 5.0\n[loop]\nsample_time_s = 0.5\n"}});
    let own_loop = json!({"plant": "1/(s+1)", "controller": "2+1/s", "sample_time_s": 0.1});
    let rows = (1..30).map(|n| {
        let t = 0.1 * f64::from(n);
        format!("{t},1,{},{}\n", -f64::exp_m1(-t), t.powf(-0.2))
    });
    let text = format!(
        "time_s,input,output,relaxation_modulus_pa\n{}",
        rows.collect::<String>()
    );
    let record = json!({"name": "x.csv", "text": text, "model": "spring-pot"});
    let again = json!([{"name": "y.csv", "text": text}]);
    let tank = json!({"text": text, "more": again, "poles": 1});
    vec![
        ("Hello", hello),
        ("Unasked", unasked),
        ("{ runs: RunEntry[] }", page.ask("runs.list", json!({}))),
        (
            "OpenRun",
            page.ask("runs.open", json!({"name": "relax-0002/relax"})),
        ),
        ("Pick<Answer, \"name\" | \"kind\" | \"running\">", going),
        ("Omit<Answer, \"running\">", answer),
        (
            "{ forms: Form[]; record: RecordParameter[]; control_design: Parameter[]; control_loop: Parameter[]; plant_record: Parameter[] }",
            forms,
        ),
        ("Judged", page.ask("ask", question("design", "wall", wall))),
        (
            "Designed",
            page.ask("ask", question("control", "control", plant)),
        ),
        (
            "Answered",
            page.ask("ask", question("loop", "simulate", own_loop)),
        ),
        (
            "Identified",
            page.ask("ask", question("identify", "record", record.clone())),
        ),
        (
            "Explained",
            page.ask("ask", question("identify", "explain_record", record)),
        ),
        (
            "FoundPlant",
            page.ask("ask", question("identify", "plant_record", tank)),
        ),
    ]
}

#[test]
fn the_types_of_the_page_have_an_example_of_each_message() {
    let (runs, _server, mut page) = opened();
    let mut made = HEAD.to_owned();
    for (number, (name, example)) in examples(&mut page, runs.path()).iter().enumerate() {
        let example = bare("", example, &mut Seen::new());
        made += &format!(
            "\nexport const example{number} = {example} as const;\nexample{number} satisfies Whole<{name}>;\n"
        );
    }
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../page/tests/messages.ts");
    if std::env::var_os(UPDATE).is_some() {
        fs::write(&file, &made).expect("writes");
    }
    let shown = fs::read_to_string(&file).expect("the examples");
    let stale = made.lines().filter(|line| !shown.contains(line));
    let stale: Vec<&str> = stale.filter_map(|line| line.split(" = ").next()).collect();
    assert!(
        shown == made,
        "page/tests/messages.ts is stale at {stale:?}: make it anew with {UPDATE}=1 in the environment, and look at what changed"
    );
}
