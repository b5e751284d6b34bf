//! Records that somebody measured.

use crate::{assert_documented, opened};
use serde_json::json;

#[test]
fn a_record_is_identified_and_one_that_is_none_is_refused() {
    let (_runs, _server, mut page) = opened();
    // G(t) = 1000·t^(−0.2)/Γ(0.8): a spring-pot.
    let mut text = "time_s,relaxation_modulus_pa\n".to_owned();
    for n in 0..60 {
        let t = 10.0_f64.powf(-1.0 + f64::from(n) / 20.0);
        text += &format!("{t},{}\n", 1000.0 * t.powf(-0.2) / 1.164_229_713_725_303);
    }
    let found = page.ask(
        "identify",
        json!({"name": "gel.csv", "text": text, "model": "spring-pot"}),
    );
    assert_documented("identify", &found);
    assert_eq!(
        (&found["kind"], &found["best"]),
        (&json!("relaxation"), &json!("spring-pot"))
    );
    let order = &found["models"][0]["parameters"][1];
    assert!(
        (order["value"].as_f64().expect("a number") - 0.2).abs() < 1e-6,
        "{order}"
    );
    for none in ["", "a,b\n1,2\n", "\u{0}\u{1}\u{2}", "time_s\n1\n2\n"] {
        let refused = page.refused("identify", json!({"name": "x.csv", "text": none}));
        assert!(
            refused.starts_with("x.csv") && !refused.contains('\n'),
            "{refused}"
        );
    }
}
