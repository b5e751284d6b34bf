//! `weights`, `differintegrate`, `materials`, `completions`, `man`: numbers and text in and out.

use crate::process::{Place, cases, number};
use serde_json::Value;
use testkit::{assert_close, assert_relative, assert_says};

/// A tissue file that is right; its order is in line 7.
pub(crate) const GEL: &str = "name = \"gel\"\ndescription = \"a gel\"\n\n[parameters]\n\
    elastic_modulus_pa = 100\nviscosity_pa_s_alpha = 5.0\norder = 0.3\n\n[source]\n\
    citation = \"me, 2026\"\nconditions = \"21 °C\"\nchecked = true\n";

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
fn weights_as_json_have_the_contracts_keys() {
    let line = "weights --order 0.5 --scheme grunwald:5 --count 5 --json";
    let report = Place::new().run(line).succeeded().json();
    assert_eq!(report["order"], Value::from(0.5));
    assert_eq!(report["scheme"], "grunwald:5");
    assert_eq!(report["weights"], Value::from(HALF.to_vec()));
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    // No pipefail in sh: the exit code goes through a file.
    let script = "(\"$0\" weights --order 0.5 --count 1000000; echo $? > code) | head -n 1";
    let place = Place::new();
    let ended = place.shell(script).succeeded();
    assert_eq!(ended.stdout, "lag,weight\n");
    assert_eq!(place.text("code"), "0\n");
}

#[test]
fn any_column_can_be_taken() {
    let place = Place::new();
    place.write(
        "log.csv",
        "time_s,position_m,x\n0,1,9\n0.25,3,9\n0.5,2.5,9\n",
    );
    let line = "differintegrate --order 1 --sample-time 0.25s log.csv";
    let run = |options: &str| place.run(&format!("{line} {options}"));
    let columns = |options: &str| run(options).succeeded().table("x,y");
    let rates = [[1.0, 4.0], [3.0, 8.0], [2.5, -2.0]];
    assert_eq!(columns("--column position_m"), rates);
    assert_eq!(columns(""), columns("--column x"));
    let words = ["no column force_n", "time_s,position_m,x", "--column"];
    run("--column force_n").refused(2, &words);
}

#[test]
fn a_scheme_that_forgets_says_for_how_long_it_remembers() {
    let rows: String = (0..8).map(|n| format!("{n}\n")).collect();
    let warned = |options: &str| {
        let line = format!("differintegrate --sample-time 1ms {options}");
        let run = Place::new().run_with(&line, format!("x\n{rows}").as_bytes());
        run.succeeded_with_warnings()
            .stderr
            .contains("remembers 0.004 s, the table lasts 0.008 s")
    };
    assert!(warned("--order 0.5 --scheme muir:3"));
    assert!(warned("--order=-1 --scheme grunwald:4"));
    // The last two samples are all that a difference needs; full memory forgets nothing.
    assert!(!warned("--order 1 --scheme muir:3"));
    assert!(!warned("--order 0.5"));
}

#[test]
fn a_sample_time_other_than_that_of_the_table_is_refused() {
    let place = Place::new();
    let line = "differintegrate --order 0.5 in.csv --sample-time";
    for (time, right, wrong, message) in [
        ("time_s", "0.25s", "0.5s", "steps of 250 ms"),
        ("t (ms)", "0.25ms", "0.25s", "steps of 250 µs"),
    ] {
        // Rounded to a digit.
        place.write(
            "in.csv",
            format!("{time},x\n0,1\n0.3,2\n0.5,3\n0.8,4\n1,5\n"),
        );
        place.run(&format!("{line} {right}")).succeeded();
        let refused = place.run(&format!("{line} {wrong}"));
        refused.refused(2, &["in.csv", message, "change --sample-time"]);
    }
}

#[test]
fn uneven_times_are_taken_as_they_are_or_refused() {
    let place = Place::new();
    // t^1.5 on uneven times, in ms and unsorted further down: its half derivative is t·Γ(2.5)/Γ(2).
    let time = |n: u32| 0.01 * f64::from(n * n);
    let rows: Vec<String> = (0..=60)
        .map(|n| format!("{},{}", 1e3 * time(n), time(n).powf(1.5)))
        .collect();
    place.write("uneven.csv", format!("time_ms,x\n{}\n", rows.join("\n")));
    let line = "differintegrate --order 0.5 uneven.csv";
    let run = place.run(&format!("{line} --scheme piecewise-linear"));
    let last = run.succeeded().table("time_s,x,y")[60].clone();
    let y = last[2];
    assert_eq!(last[0], time(60));
    let want = 36.0 * libm::tgamma(2.5);
    // The straight lines between the samples leave the curve by so much.
    assert_relative("y", y, want, 1e-3);
    for scheme in ["full", "exact", "grunwald:9", "full-bdf2", "muir:3"] {
        let refused = place.run(&format!("{line} --scheme {scheme}"));
        refused.refused(2, &["uneven.csv", "uneven", "piecewise-linear", "resample"]);
    }
    let first_order = line.replace("0.5", "1");
    for scheme in ["", "--scheme piecewise-linear"] {
        let run = place.run(&format!("{first_order} {scheme}"));
        run.refused(2, &["uneven.csv", "order 1 ", "below 1"]);
    }
    // A sample time would have no effect.
    let refused = place.run(&format!("{line} --sample-time 1s"));
    refused.refused(2, &["uneven.csv", "line ", "omit --sample-time"]);
    // Without an option the times are those of the table, and what was taken is told.
    let run = place.run("differintegrate --order 0.5 uneven.csv");
    let parts = [
        "warning: the times are uneven, most of all at line ",
        ": straight lines between the rows (piecewise-linear)\n",
    ];
    assert!(
        parts.iter().all(|part| run.stderr.contains(part)),
        "{}",
        run.stderr
    );
    assert_eq!(run.table("time_s,x,y")[60][2], y);
    let run = place
        .run("differintegrate --order 0.5 uneven.csv --json")
        .json();
    assert_eq!(
        (&run["scheme"], run["sample_time_s"].is_null()),
        (&"piecewise-linear:1e-6".into(), true)
    );
    assert_eq!(run["time_s"][60], time(60));
    place.write("even.csv", "time_ms,x\n0,0\n2,1\n4,2\n");
    let even = place.run("differintegrate --order 1 even.csv").succeeded();
    assert_eq!(even.table("x,y")[2], [2.0, 500.0]);
    place.write("none.csv", "x\n0\n1\n");
    place
        .run("differintegrate --order 1 none.csv")
        .refused(2, &["none.csv", "no times", "--sample-time"]);
    for (name, table, words) in [
        (
            "hole",
            "0,1\n1,2\n2,3\n4,4\n5,5",
            "the times are uneven, most of all at line 5",
        ),
        (
            "falls",
            "0,1\n1,2\n0.5,3\n2,4",
            "line 4: 500 ms does not come after 1 s",
        ),
        (
            "twice",
            "0,1\n1,2\n1,3\n2,4",
            "line 4: 1 s does not come after 1 s",
        ),
        ("jitter", "0,1\n1,2\n2.00001,3\n3,4", "the times are uneven"),
        (
            "no number",
            "0,1\nx,2\n2,3",
            "line 3, column t: \"x\" is not a finite number",
        ),
    ] {
        place.write("t.csv", format!("t,x\n{table}\n"));
        let refused = place.run("differintegrate --order 0.5 --scheme full t.csv");
        let refused = refused.refused(2, &["t.csv", words]);
        assert!(refused.stdout.is_empty(), "{name}");
    }
    // A jump at the first of them has no finite derivative.
    place.write("t.csv", "t,x\n0,1\n1,2\n3,4\n");
    let line = "differintegrate --order 0.5 --scheme piecewise-linear t.csv";
    place
        .run(line)
        .refused(2, &["jumps from 0 to 1", "--caputo"]);
    // D^0.5 of t from 0 on: 2·√(t/π).
    let y = place
        .run(&format!("{line} --caputo"))
        .succeeded()
        .table("time_s,x,y");
    near(
        &[y[2][2]],
        &[2.0 * (3.0 / std::f64::consts::PI).sqrt()],
        1e-12,
    );
}

#[test]
fn caputo_beyond_the_first_order_is_refused() {
    for order in ["1.5", "2", "0", "-0.5"] {
        let line = format!("differintegrate --caputo --sample-time 1s --order={order}");
        let ended = Place::new().run_with(&line, b"x\n1\n2\n");
        ended.refused(2, &["--caputo", order, "above 0 and at most 1"]);
    }
    let line = "differintegrate --caputo --sample-time 1s --order 1";
    let ended = Place::new().run_with(line, b"x\n1\n2\n").succeeded();
    assert_eq!(ended.table("x,y"), [[1.0, 0.0], [2.0, 1.0]]);
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
    assert_eq!((rows.len(), rows[1][0]), (3, -2.5));
    let dash = place.run_with(&format!("{options} -"), input.as_bytes());
    assert_eq!(dash.succeeded().stdout, file.stdout);
    let json = place.json(&format!("{options} in.csv"));
    for (n, row) in rows.iter().enumerate() {
        assert_eq!(
            [&json["x"][n], &json["y"][n]],
            [row[0], row[1]].map(Value::from).each_ref()
        );
    }
    assert_eq!(number(&json, "order"), 0.5);
}

#[test]
fn a_csv_that_is_wrong_is_refused_with_its_line() {
    let options = "differintegrate --order 0.5 --sample-time 1ms";
    let place = Place::new();
    for (input, wanted) in [
        ("t,x\n0,1\n1,\n2,3\n", ["line 3", "no value"]),
        ("t,x\n0,1\n1,NaN\n", ["line 3", "NaN"]),
        ("\"a\nb\",x\n1,2\n3,z\n", ["line 4", "\"z\""]),
        ("t,y\n0,1\n", ["no column x", "t,y"]),
        ("x\n1\n\n3\n", ["line 3", "no value"]),
        ("x\n", ["no rows", "header"]),
    ] {
        place.write("in.csv", input);
        let words = [wanted[0], wanted[1], "in.csv"];
        place.run(&format!("{options} in.csv")).refused(2, &words);
    }
    let piped = place.run_with(options, b"x\n1\n\xff\n");
    piped.refused(2, &["line 3", "standard input"]);
}

#[test]
fn completions_name_the_commands() {
    for shell in ["bash", "zsh", "fish"] {
        let script = Place::new().run(&format!("completions {shell}"));
        let script = script.succeeded().stdout;
        assert_says(&script, "relax & differintegrate & overwrite");
    }
}

#[test]
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
    let report = place.json("man pages/man1");
    let pages = report["pages"].as_array().expect("a list").clone();
    for name in ["host-cli", "host-cli-relax", "host-cli-log-recover"] {
        let page = format!("pages/man1/{name}.1");
        assert!(pages.contains(&Value::from(page.clone())), "{page}");
        assert_says(&place.text(&page), ".TH & .SH NAME");
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
    let words = ["`pages/host-cli-relax.1` already exists", "--overwrite"];
    place.run("man pages").refused(2, &words);
    assert_eq!(place.text("pages/host-cli-relax.1"), "my notes");
    assert_eq!(place.files().len(), 3, "{:?}", place.files());
    let report = place.json("man pages --overwrite");
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
    for line in ["device monitor --help", "teleoperate --help"] {
        let help = place.run(line).succeeded();
        assert!(help.stdout.contains("--roll"), "{help}");
    }
    // A screen each.
    for (line, most) in [("relax -h", 30), ("relax --help", 60), ("help relax", 60)] {
        let help = place.run(line).succeeded().stdout;
        assert!(help.lines().count() <= most, "{help}");
        assert_eq!(help.contains("--roll"), most == 60, "{help}");
    }
}

#[test]
fn the_long_help_of_a_command_is_all_of_it() {
    let place = Place::new();
    for (line, words) in cases(
        "
        run --help => [coupler], required: | object_stiffness_n_per_m = 500, from 0 to 1e8
        device emulate --help => the firmware's state machine | line_seed
        identify --help => relaxation | Usage: host-cli identify
        ",
    ) {
        // Lines are broken to fit a terminal.
        let help = place.run(line).succeeded().stdout;
        let text: String = help.split_whitespace().collect::<Vec<_>>().join(" ");
        for word in &words {
            assert!(text.contains(word), "{line}: no \"{word}\" in {help}");
        }
    }
}

#[test]
fn materials_are_listed_with_those_of_the_user() {
    let place = Place::new();
    std::fs::create_dir(place.path("mine")).expect("makes the folder");
    place.write("mine/gel.toml", GEL);
    let names = |line: &str| -> Vec<String> {
        let list = place.run(line).succeeded().json();
        let list = list["materials"].as_array().expect("a list").clone();
        let name = |m: &Value| m["name"].as_str().expect("a name").to_owned();
        list.iter().map(name).collect()
    };
    let built_in = names("materials list --json");
    let first = ["prostate-cancerous", "prostate-healthy", "fish-muscle"];
    assert_eq!(built_in[..3], first);
    let with_gel = names("materials list --library mine --json");
    assert_eq!(with_gel, [&built_in[..], &["gel".to_owned()]].concat());
    let text = place.run("materials list --library mine").succeeded();
    let muscle = text.stdout.split("fish-muscle").nth(1).expect("a row");
    assert_says(
        muscle,
        "fractional-maxwell & 13.9 ms to 981 s & no & pyRheo",
    );
    assert!(text.stdout.contains("gel"), "{text}");
}

#[test]
fn a_material_is_shown_with_its_source() {
    let place = Place::new();
    place.write("gel.toml", GEL);
    let gel = place.json("materials show gel.toml");
    assert_eq!(number(&gel, "viscosity_pa_s_alpha"), 5.0);
    assert_eq!(gel["model"], "fractional-kelvin-voigt");
    assert_eq!(number(&gel["parameters"], "second_order"), 0.0);
    assert_eq!(gel["source"]["checked"], true);
    let muscle = place.json("materials show fish-muscle");
    assert_eq!(muscle["order"], Value::Null);
    assert_eq!(number(&muscle["parameters"], "second_order"), 0.1102);
    let show = place.json("materials show prostate-cancerous");
    assert_eq!(number(&show, "order"), 0.2247);
    assert_eq!(show["source"]["checked"], false);
    assert_says(&show["source"]["citation"].to_string(), "Tokatlı");
}

#[test]
fn what_show_prints_of_a_tissue_that_comes_along_is_a_file_to_start_from() {
    let place = Place::new();
    let shown = place.run("materials show prostate-healthy").succeeded();
    place.write("copy.toml", shown.stdout);
    let printed = |tissue: &str| place.json(&format!("materials show {tissue}"));
    assert_eq!(printed("copy.toml"), printed("prostate-healthy"));
}

#[test]
fn a_tissue_is_exported_for_finite_elements_with_its_error() {
    let place = Place::new();
    let table = place.run("materials export fish-muscle --prony 12");
    let table = table.succeeded().stdout;
    assert_says(
        &table,
        "for t from 0.0139 s to 981 s & G here is the Young's modulus, as assumed",
    );
    let beyond = place.run("materials export fish-muscle --horizon 1962s");
    assert_says(&beyond.stderr, "come from 0.0139 to 981 s & 2 times later");
    let rows = table.lines().filter(|line| !line.starts_with('#'));
    let rows: Vec<&str> = rows.collect();
    assert_eq!(rows[0], "branch,modulus_pa,relaxation_time_s");
    assert!(rows.len() <= 14, "{table}");
    assert_says(&table, "# largest relative error of G over this band: ");
    let line = "materials export fish-muscle --format febio --out muscle.xml";
    let message = place.run(line).succeeded().stdout;
    assert_says(&message, "muscle.xml & max relative error");
    assert_says(&place.text("muscle.xml"), "<g0>1</g0>");
    place.run(line).refused(2, &["muscle.xml"]);
    place.run(&format!("{line} --overwrite")).succeeded();
    let json = place.json("materials export prostate-healthy --format abaqus");
    assert!(number(&json, "max_relative_error") < 0.01);
    let lengths =
        ["branch_moduli_pa", "branch_times_s"].map(|key| json[key].as_array().map(Vec::len));
    assert_eq!(lengths[0], lengths[1]);
    assert_eq!(json["file"], Value::Null);
    let few = place.run("materials export fish-muscle --format febio --prony 7");
    few.refused(2, &["use --prony", "6"]);
    // The card of a motion begins at its first step.
    let rows = (0..40).map(|n| {
        let [t, e] = [0.05 * f64::from(n), 0.05 * (0.5 * f64::from(n)).min(1.0)];
        format!("{t},{e},{}\n", 3e3 * e * (t + 0.05).powf(-0.2))
    });
    let motion = format!("time_s,strain,stress_pa\n{}", rows.collect::<String>());
    place.write("motion.csv", motion);
    let fitted = place.run("identify motion.csv --model spring-pot --out my-gel.toml");
    assert_says(&fitted.stdout, "my-gel.toml");
    let card = place.run("materials export ./my-gel.toml --format abaqus --card material");
    assert_says(
        &card.succeeded().stdout,
        "for t from 0.05 s to 1.9 & *MATERIAL, NAME=my_gel\n*ELASTIC, MODULI=INSTANTANEOUS\n",
    );
}

#[test]
fn what_is_no_tissue_is_named_with_its_reason_and_skipped() {
    let place = Place::new();
    std::fs::create_dir_all(place.path("mine/folder.toml")).expect("makes folders");
    place.write("mine/gel.toml", GEL);
    place.write("mine/wall.toml", GEL.replace("order = 0.3", "order = 1.3"));
    place.write("mine/bytes.toml", "\u{0}\u{1}");
    // A pipe that nobody writes to must not be waited for.
    place.shell("mkfifo mine/pipe.toml").succeeded();
    let ended = place.run("materials list --library mine");
    let skipped = ended.stderr.matches("warning: skipped").count();
    assert_eq!(skipped, 4, "{ended}");
    for file in ["folder", "wall", "bytes", "pipe"] {
        assert_says(&ended.stderr, &format!("mine/{file}.toml"));
    }

    assert_says(
        &ended.stderr,
        "it is not a regular file & mine/wall.toml:7: order = 1.3 is not in [0, 1]",
    );
    ended.succeeded_with_warnings();
    let line =
        "export-c --tissue mine/gel.toml --sample-time 1ms --horizon 10s --name gel --out gel.h";
    place.run(line).succeeded();
}

#[test]
fn a_header_is_written_once_and_compiles() {
    let place = Place::new();
    let command = "export-c --order 0.5 --sample-time 1ms --horizon 1h --name half --out half.h";
    place.run(command).succeeded();
    let header = place.text("half.h");

    assert_says(
        &header,
        "static inline float half_step(half_t *self, float x) & D^0.5 x, sample time 0.001 s",
    );
    assert_says(&header, "Error up to 3600 s");
    place.write(
        "main.c",
        "#include \"half.h\"\n#include <stdio.h>\nint main(void) { half_t h; half_init(&h); \
         printf(\"%.9g\\n\", (double)half_step(&h, 1.0f)); return 0; }\n",
    );
    let ran = place.shell("cc -std=c99 -Wall -Wextra -Werror main.c -o main && ./main");
    // The first output is T^(−1/2).
    let first: f64 = ran.succeeded().stdout.trim().parse().expect("a number");
    assert_close("first", first, 1000f64.sqrt(), 1e-5);
    let words = ["half.h", "already exists", "--overwrite"];
    place.run(command).refused(2, &words);
    place.run(&format!("{command} --overwrite")).succeeded();
}

#[test]
fn a_header_of_a_tissue_under_a_sphere_has_its_map() {
    let place = Place::new();
    let line = "export-c --tissue liver --sample-time 1ms --name liver --precision f64";
    let command = format!("{line} --loading sphere --indenter-radius 5mm --out liver.h");
    place.run(&command).succeeded();
    let header = place.text("liver.h");

    assert_says(
        &header,
        "The tissue liver, sphere, 0.005 m indenter radius, sample time 0.001 s & f = -(K e(x) + B y) & --loading sphere --indenter-radius 0.005m --sample-time 0.001s",
    );
    place.refuses(
        r#"
        export-c --tissue liver --sample-time 1ms --loading sphere => needs | --indenter-radius
        export-c --tissue liver --sample-time 1ms --half-angle 1 => --half-angle
        export-c --order 0.5 --sample-time 1ms --bonded => --bonded | --order
        export-c --controller 2+3/s --sample-time 10ms area=4cm2 => --area | --controller
        export-c --sample-time 1ms --thickness 2cm => no order | --tissue
        export-c --tissue liver --sample-time 1ms bonde=true => bonded
        "#,
    );
}

#[test]
fn a_controller_is_exported_with_what_its_file_says() {
    let place = Place::new();
    place.write(
        "pi.toml",
        "[pid]\nproportional_gain = 2\nintegral_gain_per_s_lambda = 3\nintegral_order = 0.5\n\
         [loop]\nsample_time_s = 0.01\nscheme = \"full\"\noutput_high = 2\n",
    );
    place
        .run("export-c --controller pi.toml --out pi.h")
        .succeeded();
    assert_says(
        &place.text("pi.h"),
        "C(s) = 2+3/s^0.5. & Limits -inf to 2, sample time 0.01 s",
    );
    let json = place.json("export-c --controller 2+3/s^0.5 --sample-time 10ms --horizon 1min");
    assert_eq!(json["horizon_s"], 60.0);
    assert_says(
        json["header"].as_str().expect("text"),
        "full-bdf2 & u = C(s) of b r - y",
    );
    place.refuses(
        r#"
        export-c --controller 1/(s^0.5+2) --sample-time 10ms => transfer function | --controller
        export-c --controller 2+3/s --sample-time 10ms --scheme grunwald:9 => grunwald | full-bdf2
        export-c --controller pi.toml --order 0.5 => --controller | --order
        export-c --order 0.5 => --sample-time
        "#,
    );
}

#[test]
fn without_a_file_the_header_is_printed_and_what_gives_none_is_refused() {
    let place = Place::new();
    let line = "export-c --order 1 --sample-time 1ms --scheme grunwald:2";
    let printed = place.run(&format!("{line} --precision f64")).succeeded();
    assert_says(&printed.stdout, "double operator_d_output(");
    let json = place.json(line);
    assert_eq!(json["coefficients"], 2);
    assert_says(&json["header"].to_string(), "#endif");
    assert!(json["file"].is_null() && json["error_bound"].is_null());
    place.refuses(
        r#"
        export-c --order 0.5 --sample-time 1ms --name int => "int" | C identifier | --name
        export-c --order 0.5 --sample-time 1ms --out no/where/half.h => no/where/half.h | folder
        "#,
    );
}
