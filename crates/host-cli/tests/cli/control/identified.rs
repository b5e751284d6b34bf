//! Plants out of records: what they are called, and what is said of what is left.

use crate::process::{Place, number};

/// A record of a unit step.
fn record(place: &Place, name: &str, samples: i32, t: f64, output: impl Fn(f64) -> f64) {
    let rows: String = (0..samples)
        .map(|n| {
            let time = f64::from(n) * t;
            format!("{time:?},1,{:?}\n", output(time))
        })
        .collect();
    place.write(name, format!("time_s,input,output\n{rows}"));
}

/// The steps of 9.04/(s² − 0.4s + 9.04), 9.0001/(s² + 0.02s + 9.0001) and 9/(s² + 9).
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_swing_is_called_what_it_is() {
    let place = Place::new();
    let swing = |rate: f64| {
        move |t: f64| 1.0 - f64::exp(rate * t) * ((3.0 * t).cos() - rate / 3.0 * (3.0 * t).sin())
    };
    for (name, rate, said) in [
        ("grows.csv", 0.2, Some("does not hold itself")),
        ("calms.csv", -0.01, None),
        ("stays.csv", 0.0, Some("swings for ever")),
    ] {
        record(&place, name, 600, 0.05, swing(rate));
        let ended = place.run(&format!("control identify {name}")).succeeded();
        assert!(
            said.is_none_or(|said| ended.stdout.contains(said)),
            "{ended}"
        );
        assert!(!ended.stdout.contains("adds up"), "{ended}");
        let json = place.run(&format!("control identify {name} -q --json"));
        let json = json.succeeded().json();
        assert!(number(&json, "fit") > 1.0 - 1e-9, "{json}");
        assert_eq!(json["warnings"].as_array().map(Vec::len), Some(0), "{json}");
        let poles = match rate {
            0.2 => Some(2),
            -0.01 => Some(0),
            _ => None,
        };
        assert_eq!(json["unstable_poles"].as_u64(), poles, "{json}");
    }
}

/// sin 3t² of a step is the answer of no linear plant.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn what_is_left_unexplained_is_said_in_words_and_json() {
    let place = Place::new();
    record(&place, "chirp.csv", 400, 0.01, |t| (3.0 * t * t).sin());
    let ended = place
        .run("control identify chirp.csv -q --json")
        .succeeded_with_warnings();
    let said = ended.error();
    assert!(
        said.contains("of the output unexplained") && said.contains("--delay"),
        "{said}"
    );
    let warnings = ended.json()["warnings"].clone();
    assert!(
        warnings[0].as_str().is_some_and(|text| said.contains(text)),
        "{warnings}"
    );
}

/// Steps of 2/((s − 0.4)(s + 1)): after 30 s both poles are found; after 80 s the slower one is below the rounding of the end, but not of
/// the beginning.
#[test]
fn a_record_that_grows_too_far_says_where_it_is_not_explained() {
    let place = Place::new();
    let step = |t: f64| (0.4 * t).exp_m1() / 0.28 + (-t).exp_m1() / 0.7;
    record(&place, "far.csv", 600, 0.05, step);
    let json = place.run("control identify far.csv -q --json").succeeded();
    assert_eq!(json.json()["function"], "5/(2.5s^2+1.5s-1)", "{json}");
    record(&place, "too-far.csv", 1600, 0.05, step);
    let ended = place
        .run("control identify too-far.csv -q --json")
        .succeeded_with_warnings();
    let said = ended.error();
    assert!(
        said.contains("from 0 to") && said.contains("that is no noise"),
        "{said}"
    );
}

/// Of 1/(1000s + 1) three seconds tell the quotient of gain and time constant, within steps of 1e-4, and not each.
#[test]
fn what_a_record_does_not_determine_is_in_the_json() {
    let place = Place::new();
    record(&place, "one.csv", 300, 0.01, |t| {
        (-1e4 * f64::exp_m1(-t / 1000.0)).round() / 1e4
    });
    let ended = place
        .run("control identify one.csv --model 1/(1000s+1) -q --json")
        .succeeded_with_warnings();
    let json = ended.json();
    let text = json["warnings"].to_string();
    assert!(
        text.contains("does not determine numerator_coefficient_1"),
        "{json}"
    );
    let numbers = json["numbers"].as_array().expect("numbers");
    assert!(
        numbers.iter().any(|number| number["determined"] == false),
        "{json}"
    );
    assert!(
        numbers.iter().any(|number| number["determined"] == true),
        "{json}"
    );
}

/// A quarter of a slow answer in noise: a function that rests and one that adds up fit nearly alike, and that is said.
#[test]
fn a_record_that_ends_too_soon_does_not_make_an_integrator() {
    let place = Place::new();
    let mut noise = 7_u64;
    let mut draw = || {
        noise = noise
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (noise >> 11) as f64 / 2_f64.powi(53) - 0.5
    };
    let mut text = String::from("time_s,input,output\n");
    for n in 0..100 {
        let t = 0.15 * f64::from(n);
        // A standard deviation of 0.01.
        let noise = 0.01 * (0..12).map(|_| draw()).sum::<f64>();
        text += &format!("{t},1,{}\n", 1.0 - (-t / 62.0).exp() + noise);
    }
    place.write("oven.csv", &text);
    let ended = place
        .run("control identify oven.csv")
        .succeeded_with_warnings();
    assert!(
        ended
            .error()
            .contains("does not tell whether the plant comes to rest: 0.7"),
        "{ended}"
    );
    assert!(!ended.stdout.contains("adds up"), "{ended}");
}
