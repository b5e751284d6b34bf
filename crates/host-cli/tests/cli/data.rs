//! `weights`, `differintegrate`, `materials`, `completions`, `man`: numbers and text in and out.

mod materials;

use crate::process::{Ended, Place, number, says};
use serde_json::Value;

/// A tissue file that is right; its order is in line 7.
pub(crate) const GEL: &str = "name = \"gel\"\ndescription = \"a gel\"\n\n[parameters]\n\
    elastic_modulus_pa = 100\nviscosity_pa_s_alpha = 5.0\norder = 0.3\n\n[source]\n\
    citation = \"me, 2026\"\nconditions = \"21 °C\"\nchecked = true\n";

/// The weights that `weights OPTIONS` prints, lags checked.
fn weights(options: &str) -> Vec<f64> {
    let ended = Place::new().run(&format!("weights {options}")).succeeded();
    let rows = ended.table("lag,weight");
    for (lag, row) in rows.iter().enumerate() {
        assert_eq!(row[0], lag as f64, "lag of {options}");
    }
    rows.iter().map(|row| row[1]).collect()
}

fn near(have: &[f64], want: &[f64], tolerance: f64) {
    assert_eq!(have.len(), want.len(), "{have:?}");
    for (n, (have, want)) in have.iter().zip(want).enumerate() {
        let most = tolerance * want.abs().max(1.0);
        assert!((have - want).abs() <= most, "{n}: {have} {want}");
    }
}

/// (1 − w)^(1/2), exact in binary.
const HALF: [f64; 5] = [1.0, -0.5, -0.125, -0.0625, -0.039_062_5];

#[test]
fn weights_are_the_binomial_series() {
    assert_eq!(weights("--order 0.5 --count 5"), HALF);
    assert_eq!(weights("--order 1 --count 4"), [1.0, -1.0, 0.0, 0.0]);
    assert_eq!(weights("--order 2 --count 4"), [1.0, -2.0, 1.0, 0.0]);
    assert_eq!(weights("--order -1 --count 3"), [1.0, 1.0, 1.0]);
    assert_eq!(weights("--order 0 --count 3"), [1.0, 0.0, 0.0]);
    assert_eq!(weights("--order 0.5").len(), 10, "the default count");
}

#[test]
fn weights_of_each_scheme_are_what_it_is_made_of() {
    let of = |scheme: &str| weights(&format!("--order 0.5 --count 5 --scheme {scheme}"));
    near(&of("full"), &HALF, 1e-6);
    assert_eq!(of("grunwald:5"), HALF);
    // The ring buffer ends after its taps.
    assert_eq!(of("grunwald:3"), [1.0, -0.5, -0.125, 0.0, 0.0]);
    // Caputo L1: b_j = (j+1)^p − j^p, p = 1/2; w_j = (b_j − b_{j−1})/Γ(3/2).
    let b = |j: i32| f64::from(j + 1).sqrt() - f64::from(j).sqrt();
    let gamma = 0.5 * std::f64::consts::PI.sqrt();
    let l1 = [0, 1, 2, 3, 4].map(|j| (b(j) - if j > 0 { b(j - 1) } else { 0.0 }) / gamma);
    near(&of("piecewise-linear"), &l1, 1e-6);
    // Muir: A_0 = 1, A_n(w) = A_{n−1}(w) − c_n·w^n·A_{n−1}(1/w), c_n = μ/n for odd n, else 0.
    // A_1 = 1 − w/2; A_3 = A_1 − w³·A_1(1/w)/6 = 1 − w/2 + w²/12 − w³/6.
    near(
        &of("muir:3"),
        &[1.0, -0.5, 1.0 / 12.0, -1.0 / 6.0, 0.0],
        1e-15,
    );
    // 2^μ·A_1(w)/A_1(−w) = √2·(1 − w/2)/(1 + w/2) = √2·(1 − w + w²/2 − w³/4 + w⁴/8 …).
    let root = std::f64::consts::SQRT_2;
    near(
        &of("tustin-muir:1"),
        &[1.0, -1.0, 0.5, -0.25, 0.125].map(|w| root * w),
        1e-15,
    );
    // A band-limited filter is no series of closed form; it must begin near the series it imitates.
    let oustaloup = of("oustaloup:9:0.0001:0.4 --sample-time 1s");
    assert!((oustaloup[0] - 1.0).abs() < 0.2, "{oustaloup:?}");
    assert!(
        oustaloup[1..].iter().all(|w| *w < 0.0),
        "a memory that fades: {oustaloup:?}"
    );
}

#[test]
fn weights_as_json_have_the_contracts_keys() {
    let line = "weights --order 0.5 --scheme grunwald:5 --count 5 --json";
    let report = Place::new().run(line).succeeded().json();
    assert_eq!(report["order"], Value::from(0.5));
    assert_eq!(report["scheme"], "grunwald:5");
    assert_eq!(report["weights"], Value::from(HALF.to_vec()));
}

#[test]
#[cfg(unix)]
fn a_reader_that_goes_away_is_no_error() {
    // No pipefail in sh: the exit code goes through a file.
    let script = "(\"$0\" weights --order 0.5 --count 1000000; echo $? > code) | head -n 1";
    let place = Place::new();
    let ended = place.shell(script).succeeded();
    assert_eq!(ended.stdout, "lag,weight\n");
    assert_eq!(place.text("code"), "0\n");
}

/// `differintegrate OPTIONS` of a signal by standard input, as columns x and y.
fn differintegrate(options: &str, x: &[f64]) -> Vec<f64> {
    let rows: Vec<String> = x.iter().map(f64::to_string).collect();
    let input = format!("x\n{}\n", rows.join("\n"));
    let line = format!("differintegrate {options}");
    let ended = Place::new().run_with(&line, input.as_bytes()).succeeded();
    let rows = ended.table("x,y");
    let given: Vec<f64> = rows.iter().map(|row| row[0]).collect();
    assert_eq!(given, x, "column x");
    rows.iter().map(|row| row[1]).collect()
}

#[test]
fn whole_orders_are_identity_differences_and_sums() {
    // Quarters and T = 1/4 s: every result is exact.
    let x = [1.0, 3.0, 2.5, -4.0];
    let of = |order: &str| differintegrate(&format!("--order {order} --sample-time 0.25s"), &x);
    assert_eq!(of("0"), x);
    assert_eq!(of("1"), [4.0, 8.0, -2.0, -26.0]);
    assert_eq!(of("-1"), [0.25, 1.0, 1.625, 0.625]);
    assert_eq!(of("2"), [16.0, 16.0, -40.0, -96.0]);
}

#[test]
fn the_half_derivative_of_a_ramp_is_its_closed_form() {
    // D^(1/2) t = 2·√(t/π): exact for the piecewise-linear kernel, of first order for Grünwald's, where
    // the error is some T/t.
    let t: Vec<f64> = (0..2000).map(|n| f64::from(n) * 1e-3).collect();
    let closed = |t: f64| 2.0 * (t / std::f64::consts::PI).sqrt();
    for (scheme, steps) in [("piecewise-linear", 0.0), ("full", 1.0)] {
        let options = format!("--order 0.5 --sample-time 1ms --scheme {scheme}");
        let y = differintegrate(&options, &t);
        for (&t, &y) in t.iter().zip(&y).skip(1) {
            let allowed = 1e-5 + steps * 1e-3 / t;
            let error = (y / closed(t) - 1.0).abs();
            assert!(error <= allowed, "{scheme} at {t} s: {error:e} {allowed:e}");
        }
    }
}

#[test]
fn any_column_can_be_taken() {
    let place = Place::new();
    place.write(
        "log.csv",
        "time_s,position_m,x\n0,1,9\n0.25,3,9\n0.5,2.5,9\n",
    );
    let line = "differintegrate --order 1 --sample-time 0.25s log.csv";
    let of = |options: &str| {
        place
            .run(&format!("{line} {options}"))
            .succeeded()
            .table("x,y")
    };
    assert_eq!(
        of("--column position_m"),
        [[1.0, 4.0], [3.0, 8.0], [2.5, -2.0]]
    );
    assert_eq!(of(""), of("--column x"));
    let refused = place.run(&format!("{line} --column force_n")).failed(2);
    says(
        refused.error(),
        &["no column force_n", "time_s,position_m,x", "--column"],
    );
}

#[test]
fn caputo_ignores_where_the_signal_begins() {
    let x = [5.0, 5.5, 6.5, 6.0];
    let y = differintegrate("--order 0.5 --sample-time 1s --caputo", &x);
    let shifted = x.map(|x| x - 5.0);
    let want = differintegrate("--order 0.5 --sample-time 1s", &shifted);
    near(&y, &want, 1e-15);
    assert_eq!(y[0], 0.0);
}

#[test]
fn a_file_standard_input_and_json_give_the_same() {
    let place = Place::new();
    // Other columns, Windows line ends, blanks, a byte-order mark: all as spreadsheets write them.
    let input = "\u{feff}t, x ,note\r\n0,1,a\r\n1, -2.5e0 ,\r\n2,4,c\r\n";
    place.write("in.csv", input);
    let options = "differintegrate --order 0.5 --sample-time 1s";
    let file = place.run(&format!("{options} in.csv")).succeeded();
    let rows = file.table("x,y");
    assert_eq!(rows.len(), 3);
    assert_eq!(rows[1][0], -2.5);
    let dash = place.run_with(&format!("{options} -"), input.as_bytes());
    assert_eq!(dash.succeeded().stdout, file.stdout);
    let json = place.run(&format!("{options} in.csv --json")).succeeded();
    let json = json.json();
    for (n, row) in rows.iter().enumerate() {
        assert_eq!(json["x"][n], Value::from(row[0]));
        assert_eq!(json["y"][n], Value::from(row[1]));
    }
    assert_eq!(number(&json, "order"), 0.5);
}

#[test]
fn a_csv_that_is_wrong_is_refused_with_its_line() {
    let mut complaints = Vec::new();
    for (input, wanted) in [
        ("t,x\n0,1\n1,\n2,3\n", ["line 3", "no value"]),
        ("t,x\n0,1\n1\n2,3\n", ["line 3", "no value"]),
        ("t,x\n0,1\n1,   \n2,3\n", ["line 3", "no value"]),
        ("x\n1\n\n3\n", ["line 3", "no value"]),
        ("t,x\n0,1\n1,abc\n", ["line 3", "\"abc\""]),
        ("t,x\n0,1\n\n\n1,2\n", ["line 3", "no value"]),
        ("t,x\n0,1\n1,NaN\n", ["line 3", "NaN"]),
        ("x\n1\ninf\n", ["line 3", "inf"]),
        ("x\n1e400\n", ["line 2", "1e400"]),
        ("x\n1,5\n", ["line 2", "header"]),
        ("x\n\"1\n2\"\n", ["line 2", "not a finite number"]),
        ("\"a\nb\",x\n1,2\n3,z\n", ["line 4", "\"z\""]),
        ("t,y\n0,1\n", ["no column x", "t,y"]),
        ("1\n2\n", ["no column x", "\"1\""]),
        ("x\n", ["no rows", "header"]),
        ("", ["empty", "x"]),
    ] {
        let place = Place::new();
        place.write("in.csv", input);
        let options = "differintegrate --order 0.5 --sample-time 1ms";
        let file = place.run(&format!("{options} in.csv"));
        let named = |ended: Ended, name: &str| {
            let words = [wanted[0], wanted[1], name];
            let complaint = ended.complaint(2, &words);
            complaint.map(|complaint| format!("{input:?}: {complaint}"))
        };
        complaints.extend(named(file, "in.csv"));
        let piped = place.run_with(options, input.as_bytes());
        complaints.extend(named(piped, "standard input"));
    }
    let all = complaints.join("\n");
    assert!(all.is_empty(), "{} complaints:\n{all}", complaints.len());
}

#[test]
fn a_csv_that_is_no_text_or_not_there_is_refused() {
    let place = Place::new();
    place.write("in.csv", b"x\n1\n\xff\n");
    let options = "differintegrate --order 0.5 --sample-time 1ms";
    let ended = place.run(&format!("{options} in.csv"));
    ended.refused(2, &["in.csv", "line 3"]);
    let ended = place.run(&format!("{options} nowhere.csv"));
    ended.refused(2, &["nowhere.csv"]);
}

#[test]
fn completions_name_the_commands() {
    for shell in ["bash", "zsh", "fish"] {
        let script = Place::new().run(&format!("completions {shell}"));
        let script = script.succeeded().stdout;
        says(&script, &["relax", "differintegrate", "overwrite"]);
    }
}

#[test]
#[cfg(unix)]
fn bash_completes_with_the_script() {
    // The function that the script defines completes `host-cli rel`.
    let script = "command -v bash >/dev/null || exit 77
        \"$0\" completions bash > script && exec bash -c '
            source ./script
            complete=($(complete -p host-cli))
            for ((i = 0; i < ${#complete[@]}; i++)); do
                test \"${complete[i]}\" = -F && function=${complete[i + 1]}
            done
            COMP_WORDS=(host-cli rel) COMP_CWORD=1
            $function host-cli rel host-cli
            echo \"${COMPREPLY[@]}\"'";
    let ended = Place::new().shell(script);
    if ended.code == Some(77) {
        return testkit::skip("there is no bash");
    }
    assert_eq!(ended.succeeded().stdout, "relax\n");
}

#[test]
fn man_writes_a_page_for_each_command() {
    let place = Place::new();
    let report = place.run("man pages/man1 --json").succeeded().json();
    let pages = report["pages"].as_array().expect("a list").clone();
    for name in ["host-cli", "host-cli-relax", "host-cli-log-recover"] {
        let page = format!("pages/man1/{name}.1");
        assert!(pages.contains(&Value::from(page.clone())), "{page}");
        let text = place.text(&page);
        assert!(
            text.contains(".TH") && text.contains(".SH NAME"),
            "{page}: {text}"
        );
    }
    // All that was written was named.
    assert_eq!(pages.len(), place.files().len() - 2);
}

#[test]
fn man_replaces_nothing_unless_it_is_told_to() {
    let place = Place::new();
    std::fs::create_dir(place.path("pages")).expect("makes");
    place.write("pages/host-cli-relax.1", "my notes");
    place.write("pages/other.1", "another program");
    let ended = place.run("man pages");
    assert_eq!(ended.code, Some(2), "{ended}");
    let said = ended.error();
    assert!(
        said.contains("`pages/host-cli-relax.1` already exists"),
        "{said}"
    );
    assert!(said.contains("--overwrite"), "{said}");
    assert_eq!(place.text("pages/host-cli-relax.1"), "my notes");
    assert_eq!(place.files().len(), 3, "{:?}", place.files());
    let report = place.run("man pages --overwrite --json").succeeded().json();
    assert!(place.text("pages/host-cli-relax.1").contains(".TH"));
    assert_eq!(place.text("pages/other.1"), "another program");
    let pages = report["pages"].as_array().expect("a list").clone();
    assert!(!pages.contains(&Value::from("pages/other.1")));
}

#[test]
fn help_and_version_are_success_on_standard_output() {
    let place = Place::new();
    let version = place.run("--version").succeeded();
    let want = concat!("host-cli ", env!("CARGO_PKG_VERSION"), "\n");
    assert_eq!(version.stdout, want);
    for line in ["--help", "relax --help", "log recover --help"] {
        let help = place.run(line).succeeded();
        assert!(help.stdout.contains("Example"), "{help}");
    }
    assert!(place.run("--help").stdout.contains("Exit codes"));
}
