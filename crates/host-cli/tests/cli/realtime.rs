//! Runs by the clock, and `rt-check`. Nothing here depends on how fast or busy the machine is.

use crate::process::{Place, holds, number};
use serde_json::Value;
use testkit::{assert_relative, assert_says};

/// A run of 301 ticks by the clock.
const SHORT: &str = "relax --realtime --duration 0.3s --ramp-time 0.1s --out run --json";

/// Percentiles that are numbers and in order.
fn are_percentiles(us: &Value) {
    let all = ["p50", "p99", "p999", "max"].map(|key| number(us, key));
    assert!(all[0] >= 0.0 && all.is_sorted(), "{us}");
}

#[test]
fn rt_check_reports_the_contracts_keys() {
    let report = Place::new().json("rt-check --duration 50ms");
    let rates = report["rates"].as_array().expect("a list");
    let hz: Vec<f64> = rates.iter().map(|rate| number(rate, "hz")).collect();
    assert_eq!(hz, [1e3, 4e3, 10e3]);
    for rate in rates {
        are_percentiles(&rate["lateness_us"]);
        assert!(rate["overruns"].is_u64(), "{rate}");
        // 999 of 1000 cycles are not seen in 50, but one that is late is.
        let (cycles, late) = (number(rate, "cycles"), rate["overruns"] != 0);
        assert_eq!(rate["fit"].is_null(), cycles < 1e3 && !late, "{rate}");
        let reason = &rate["fit_reason"];
        if rate["fit"].is_null() {
            assert_says(reason.as_str().expect("a reason"), "a verdict needs 1000");
        } else {
            assert!(rate["fit"].is_boolean() && reason.is_null(), "{rate}");
        }
        // Each period has a cycle or is counted.
        let periods = number(rate, "cycles") + number(rate, "skipped_periods");
        assert!(periods >= 0.05 * number(rate, "hz"), "{rate}");
    }
    let advice = report["advice"].as_array().expect("a list");
    assert!(advice.iter().all(Value::is_string), "{report}");
}

/// The times of a run are complete, and their parts agree.
fn is_whole(report: &Value) {
    let realtime = &report["realtime"];
    for part in ["lateness_us", "compute_us", "tick_us"] {
        are_percentiles(&realtime[part]);
    }
    let late = number(realtime, "late_by_wake_up") + number(realtime, "late_by_compute");
    assert_eq!(number(report, "missed_deadlines"), late);
    assert!(number(realtime, "skipped_periods") >= late, "{realtime}");
    let worst = &realtime["worst_cycle"];
    holds(number(worst, "number") < number(report, "samples"), &worst);
    let tick = number(worst, "lateness_us") + number(worst, "compute_us");
    // The histogram has three digits.
    assert_relative("longest", tick, number(&realtime["tick_us"], "max"), 2e-3);
    // Of the loop's work, the tick is a part.
    let tick_us = 1e-3 * number(&report["tick_ns"], "p50");
    holds(
        number(&realtime["compute_us"], "p50") >= 0.99 * tick_us,
        report,
    );
}

#[test]
fn a_run_by_the_clock_says_where_its_time_went_and_keeps_it_in_the_log() {
    let place = Place::new();
    let report = place.run(SHORT).succeeded_with_warnings().json();
    is_whole(&report);
    let info = place.json("log info run/relax.mcap");
    let records = info["metadata"].as_array().expect("a list");
    let kept = records.iter().find(|record| record["name"] == "realtime");
    let kept = &kept.expect("metadata of the clock")["values"];
    for name in ["lateness", "compute", "tick"] {
        let histogram = kept[format!("{name}_histogram")].as_str().expect("a text");
        let counts = histogram.split(' ').map(|pair| {
            let (_, count) = pair.split_once(':').expect("bound:count");
            count.parse::<u64>().expect("a count")
        });
        assert_eq!(counts.sum::<u64>(), 301, "{name}: {histogram}");
        let p999 = number(&report["realtime"][format!("{name}_us")], "p999");
        assert_eq!(kept[format!("{name}_us_p999")], p999.to_string());
    }
}

/// Runs without the privileges of a superuser, whoever starts this.
#[test]
#[cfg(target_os = "linux")]
fn a_run_that_may_not_have_a_priority_goes_on_and_says_once_how_to_get_it() {
    use testkit::skip;
    let place = Place::new();
    let limited = "ulimit -r 0; exec setpriv --bounding-set=-sys_nice --inh-caps=-sys_nice";
    if place.shell(&format!("{limited} true")).code != Some(0) {
        return skip("setpriv cannot take privileges away here");
    }
    let ended = place.shell(&format!("{limited} \"$0\" {SHORT} --priority 60"));
    let ended = ended.succeeded_with_warnings();
    let report = ended.json();
    assert_eq!(report["realtime"]["priority"], Value::Null);
    is_whole(&report);
    let mut refused = ended
        .stderr
        .lines()
        .filter(|line| line.contains("no real-time priority"));
    let refusal = refused.next().unwrap_or_default();
    assert_says(
        refusal,
        "priority 60 & ulimit -r 60 & limits.d & setcap cap_sys_nice",
    );
    assert_eq!(refused.next(), None, "{ended}");
}

/// A process that is stopped for 200 ms is late, whatever the machine: what it reports is what happened.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn periods_that_a_stop_took_are_skipped_and_counted_but_every_tick_runs() {
    let place = Place::new();
    let line = "relax --realtime --duration 2s --ramp-time 0.5s --out run --json";
    let script = format!(
        "\"$0\" {line} & until test -s run/relax.mcap.part; do sleep 0.05; done; sleep 0.5; \
         kill -STOP $!; sleep 0.2; kill -CONT $!; wait $!"
    );
    let ended = place.shell(&script).succeeded_with_warnings();
    let report = ended.json();
    is_whole(&report);
    assert_eq!(number(&report, "samples"), 2001.0);
    assert!(number(&report, "missed_deadlines") >= 1.0, "{report}");
    let skipped = number(&report["realtime"], "skipped_periods");
    assert!(skipped >= 190.0, "{report}");
    let words = ["warning: ", "late:", "periods were skipped"];
    let names_all = |line: &str| words.iter().all(|word| line.contains(word));
    assert!(ended.stderr.lines().any(names_all), "{ended}");
    // Device time has no gap.
    let check = place.json("log check run/relax.mcap");
    assert_eq!(check["gaps"], Value::Array(Vec::new()), "{check}");
}
