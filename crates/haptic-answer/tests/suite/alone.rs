//! A page asks, and somebody's clock turns the loop.

use haptic_answer::alone::{Alone, ToPage};
use serde_json::{Value, json};
use testkit::assert_relative;

struct Page {
    server: Alone,
    next: u64,
    now_ms: f64,
    heard: Vec<Value>,
}

impl Page {
    fn open() -> Self {
        let server = Alone::new("2026-12-01".to_owned()).expect("built in");
        Self {
            server,
            next: 0,
            now_ms: 0.0,
            heard: Vec::new(),
        }
    }

    fn send(&mut self, what: &str, mut keys: Value) -> u64 {
        self.next += 1;
        (keys["id"], keys["do"]) = (self.next.into(), what.into());
        self.server.hear(&keys.to_string());
        self.next
    }

    /// All that has come.
    fn hear(&mut self) {
        while let Some(message) = self.server.next_message() {
            if let ToPage::Text(text) = message {
                self.heard.push(serde_json::from_str(&text).expect("JSON"));
            }
        }
    }

    fn answer(&mut self, id: u64) -> Value {
        self.hear();
        let known = self.heard.iter().find(|message| message["id"] == id);
        known.expect("an answer").clone()
    }

    fn ask(&mut self, what: &str, keys: Value) -> Value {
        let id = self.send(what, keys);
        let answer = self.answer(id);
        assert_eq!(answer["ok"], true, "{answer}");
        answer
    }

    fn refused(&mut self, what: &str, keys: Value) -> String {
        let id = self.send(what, keys);
        let answer = self.answer(id);
        assert_eq!(answer["ok"], false, "{answer}");
        answer["error"].as_str().expect("a sentence").to_owned()
    }

    /// Goes on for so long, ms, as a worker does; the newest status.
    fn status_after(&mut self, ms: u32) -> Value {
        for _ in 0..ms / 8 {
            self.now_ms += 8.0;
            self.server.advance(self.now_ms);
        }
        self.hear();
        let mut all = self.heard.iter().rev();
        let found = all.find(|message| !message["status"].is_null());
        found.expect("a status")["status"].clone()
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
    assert!(
        number("samples_made") > 3890.0 && number("lost") == 0.0,
        "{status}"
    );
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
    page.now_ms += 10_000.0;
    let status = page.status_after(200);
    assert_eq!(status["late"], 1);
    let made = status["samples_made"].as_u64().expect("a count");
    let skipped = status["skipped"].as_u64().expect("a count");
    assert!(made < 1300 && skipped > 9700, "{status}");
    assert_eq!(page.status_after(100)["late"], 1);
}

#[test]
fn the_newest_question_of_a_panel_is_answered_and_others_are_overtaken() {
    let mut page = Page::open();
    let question = |crossover: f64| {
        let control = json!({"plant": "1/(s+1)", "crossover_rad_s": crossover});
        json!({"panel": "control", "question": {"control": control}})
    };
    let old = page.send("ask", question(1.0));
    let new = page.send("ask", question(2.0));
    while page.server.work() {}
    assert_eq!(page.answer(old)["ok"], false);
    let answer = page.answer(new);
    assert_eq!(
        (&answer["ok"], &answer["fractional"]["stable"]),
        (&json!(true), &json!(true))
    );
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
            "view",
            json!({"source": "x", "columns": 9}),
            "`host-cli serve`",
        ),
        (
            "file",
            json!({"name": "x.toml", "text": "[relax]"}),
            "`host-cli run x.toml`",
        ),
    ] {
        let sentence = page.refused(what, keys);
        assert!(sentence.contains(command), "{what}: {sentence}");
    }
    let wall =
        json!({"wall": {"device_model": "/etc/device.toml", "points": 16, "position_noise_m": 0}});
    let id = page.send("ask", json!({"panel": "design", "question": wall}));
    assert!(page.server.work() && !page.server.work());
    assert!(
        page.answer(id)["error"]
            .to_string()
            .contains("opens no file")
    );
    page.server.hear("no JSON");
    page.hear();
    assert!(page.heard.pop().expect("an answer")["id"].is_null());
}

#[test]
fn a_tissue_that_falls_on_the_page_is_felt_until_it_is_closed() {
    let mut page = Page::open();
    let text = "name = \"gel\"\ndescription = \"a gel\"\n\n[parameters]\nelastic_modulus_pa = 100\nviscosity_pa_s_alpha = 5.0\n\
                order = 0.3\n\n[source]\ncitation = \"me, 2026\"\nconditions = \"21 °C\"\nchecked = true\n";
    let file = json!({"name": "gel.toml", "text": text});
    assert_eq!(page.ask("file", file)["is"], "tissue");
    page.ask("tissue.keep", json!({"name": "my-gel", "text": text}));
    assert!(
        page.refused("tissue.keep", json!({"name": "my-gel", "text": text}))
            .contains("already")
    );
    let felt = page.ask("feel.start", json!({"environment": {"tissue": "my-gel"}}));
    assert_eq!(felt["feel"]["order"], 0.3);
}
