//! A page asks, and somebody's clock turns the loop.

use haptic_answer::alone::{Alone, ToPage};
use haptic_tissue::Library;
use serde_json::{Value, json};
use testkit::assert_relative;

struct Page(Alone, f64);

impl Page {
    fn open() -> Self {
        Self(Alone::new("2026-12-01".to_owned()).expect("built in"), 0.0)
    }

    /// The texts that have come since the last look.
    fn heard(&mut self) -> Vec<Value> {
        let messages = std::iter::from_fn(|| self.0.next_message());
        let texts = messages.filter_map(|message| match message {
            ToPage::Text(text) => serde_json::from_str(&text).ok(),
            ToPage::Frame(_) => None,
        });
        texts.collect()
    }

    /// The answer, which comes last.
    fn ask(&mut self, what: &str, mut keys: Value) -> Value {
        (keys["id"], keys["do"]) = (1.into(), what.into());
        self.0.hear(&keys.to_string());
        self.heard().pop().unwrap_or_default()
    }

    /// The sentence of a refusal.
    fn refused(&mut self, what: &str, keys: Value) -> String {
        self.ask(what, keys)["error"].to_string()
    }

    /// Goes on for so long, ms, as a worker does; the newest status.
    fn status_after(&mut self, ms: u32) -> Value {
        for _ in 0..ms / 8 {
            self.1 += 8.0;
            self.0.advance(self.1);
        }
        let status = |mut message: Value| message["status"].take();
        let mut all = self.heard().into_iter().rev().map(status);
        all.find(Value::is_object).expect("a status")
    }

    fn feels_a_spring(&mut self) {
        let wall = json!({"order": 1, "stiffness_n_per_m": 500, "dissipation_n_s_mu_per_m": 2});
        self.ask("feel.start", json!({"environment": {"wall": wall}}));
        self.ask("feel.hand", json!({"position_m": 0.01, "held": true}));
    }
}

#[test]
fn a_hand_rests_where_the_two_springs_are_in_balance_and_a_stop_takes_the_force_away() {
    let mut page = Page::open();
    page.feels_a_spring();
    let status = page.status_after(4000);
    let number = |key: &str| status[key].as_f64().expect("a number");
    // 300 N/m of the hand from 10 mm, 500 N/m of the wall from 0.
    assert_relative("place", number("position_m"), 0.01 * 300.0 / 800.0, 1e-3);
    assert_relative("force", number("force_n"), -500.0 * 0.00375, 1e-3);
    // A status comes every 100 ms, and all ticks before it are there.
    assert!(number("samples_made") > 3890.0, "{status}");
    assert!(page.refused("arm", json!({})).contains("a force acts"));
    page.ask("stop", json!({}));
    let status = page.status_after(400);
    assert_eq!(
        (&status["force_n"], &status["armed"]),
        (&json!(0.0), &json!(false))
    );
    page.ask("arm", json!({}));
    assert_eq!(page.status_after(200)["armed"], true);
}

#[test]
fn a_page_that_was_hidden_goes_on_and_says_how_much_is_left_out() {
    let mut page = Page::open();
    page.feels_a_spring();
    page.status_after(800);
    page.1 += 10_000.0;
    let status = page.status_after(200);
    assert!(status["skipped"].as_u64() > Some(9700), "{status}");
    assert!(status["samples_made"].as_u64() < Some(1300), "{status}");
}

#[test]
fn the_newest_question_of_a_panel_is_answered_and_others_are_overtaken() {
    let mut page = Page::open();
    let mut ask = |crossover: f64| {
        let control = json!({"plant": "1/(s+1)", "crossover_rad_s": crossover});
        page.ask(
            "ask",
            json!({"panel": "control", "question": {"control": control}}),
        )
    };
    assert_eq!(
        (ask(1.0), ask(2.0)["ok"].take()),
        (Value::Null, json!(false))
    );
    assert!(page.0.work() && !page.0.work());
    assert_eq!(page.heard()[0]["fractional"]["stable"], true);
}

#[test]
fn what_needs_a_machine_is_refused_with_the_command_that_has_one() {
    let mut page = Page::open();
    let run = json!({"kind": "analyze-stability", "parameters": {}});
    for (what, keys, command) in [
        ("runs.start", run, "`host-cli analyze stability`"),
        ("runs.open", json!({"name": "x"}), "`host-cli serve`"),
        ("feel.record", json!({"on": true}), "`host-cli serve`"),
        ("compare.end", json!({}), "`host-cli serve`"),
        (
            "file",
            json!({"name": "x.toml", "text": "[press]"}),
            "`host-cli run x.toml`",
        ),
    ] {
        let sentence = page.refused(what, keys);
        assert!(sentence.contains(command), "{what}: {sentence}");
    }
    let wall = json!({"wall": {"device_model": "/a.toml", "points": 16, "position_noise_m": 0}});
    page.ask("ask", json!({"panel": "design", "question": wall}));
    assert!(page.0.work());
    assert!(
        page.heard()[0]["error"]
            .to_string()
            .contains("opens no file")
    );
}

#[test]
fn a_tissue_that_falls_on_the_page_is_felt_until_it_is_closed() {
    let mut page = Page::open();
    let library = Library::load(None).expect("built in");
    let text = library.find("liver").expect("known").to_toml();
    let file = json!({"name": "x.toml", "text": text});
    assert_eq!(page.ask("file", file)["is"], "tissue");
    let kept = json!({"name": "my-liver", "text": text});
    page.ask("tissue.keep", kept.clone());
    assert!(page.refused("tissue.keep", kept).contains("already"));
    let environment = json!({"environment": {"tissue": "my-liver"}});
    assert_eq!(page.ask("feel.start", environment)["ok"], true);
}

#[test]
fn a_wall_that_is_run_is_seen_listed_and_kept_as_a_table() {
    let mut page = Page::open();
    let file = json!({"name": "x.toml", "text": "[wall]\norder = 0.5\n"});
    assert_eq!(page.ask("file", file)["experiment"]["kind"], "wall");
    let law = json!({"order": 1, "stiffness_n_per_m": 1000, "dissipation_n_s_mu_per_m": 2, "duration_s": 2, "mass_kg": 0.065, "damping_n_s_per_m": 3.5, "sample_time_s": 1e-3});
    let run = |more: Value| {
        let mut parameters = law.clone();
        for (key, value) in more.as_object().expect("an object") {
            parameters[key] = value.clone();
        }
        json!({"kind": "wall", "parameters": parameters})
    };
    let long = page.refused("runs.start", run(json!({"duration_s": 2000})));
    assert!(
        long.contains("more than its 1000000") && long.contains("host-cli run"),
        "{long}"
    );
    let file = page.refused("runs.start", run(json!({"device_model": "/a.toml"})));
    assert!(file.contains("opens no file"), "{file}");
    let started = page.ask("runs.start", run(json!({})));
    assert_eq!(started["samples"], 2001);
    page.1 += 8.0;
    page.0.advance(page.1);
    let over = page
        .heard()
        .into_iter()
        .find(|message| message["run"].is_object());
    let over = over.expect("a last word")["run"].take();
    assert_eq!(
        (&over["state"], &over["verdict"]),
        (&json!("done"), &json!("stable"))
    );
    let name = started["name"].clone();
    assert_eq!(page.ask("runs.list", json!({}))["runs"][0]["name"], name);
    assert_eq!(page.ask("runs.open", json!({"name": name}))["last_s"], 2.0);
    page.0
        .hear(&json!({"id": 7, "do": "view", "source": name, "columns": 100}).to_string());
    assert!(matches!(page.0.next_message(), Some(ToPage::Frame(_))));
    let channels = ["position_m", "commanded_force_n"];
    let wanted = json!({"name": name, "channels": channels, "from_s": 2});
    let table = page.ask("runs.table", wanted)["text"].take();
    let (head, row) = table
        .as_str()
        .expect("a table")
        .trim_end()
        .split_once('\n')
        .expect("a row");
    assert_eq!(head, "time_s,position_m,commanded_force_n");
    // At rest the push of 1 N is held.
    let numbers: Vec<f64> = row
        .split(',')
        .map(|cell| cell.parse().expect("a number"))
        .collect();
    assert_relative("place", numbers[1], 1e-3, 1e-3);
    assert_relative("force", numbers[2], -1.0, 1e-3);
}
