//! Every wall and every tissue can be felt, with the verdict of the command: from the numbers of a page, a file, a log.

use crate::{assert_documented, has, hello, opened, options, prostate, ran};
use fracdiff::Order;
use haptic_experiment::{Dynamics, ExperimentFile};
use haptic_judge::preflight::{Preflight, WallContact};
use haptic_page::{OnClose, PageServer};
use haptic_tissue::Library;
use haptic_trial::preflight::PreflightVerdict;
use serde_json::{Value, json};
use std::path::Path;
use testkit::browser::Page;
use testkit::{Random, assert_close, assert_refused, assert_relative, assert_says};

/// The file of a wall of any order and scheme, for a device that is late.
fn any(random: &mut Random) -> String {
    let schemes = [
        "full",
        "full:1e-4",
        "muir:3",
        "tustin-muir:3",
        "grunwald:60",
        "piecewise-linear",
    ];
    let order = random.between(0.0, 2.0);
    let stiffness = random.log_between(10.0, 1e5);
    let dissipation = random.log_between(1.0, 1e4) * 100_f64.powf(-order);
    let [delay, lag] = [3e-3, 2e-3].map(|most| random.or_nothing(most));
    format!(
        "[wall]\nmass_kg = {:?}\ndamping_n_s_per_m = {:?}\nsample_time_s = {:?}\ndelay_s = {delay:?}\ncurrent_lag_s = {lag:?}\n\
         order = {order:?}\nstiffness_n_per_m = {stiffness:?}\ndissipation_n_s_mu_per_m = {dissipation:?}\nscheme = \"{}\"\n\
         contact = \"{}\"\n",
        random.log_between(0.02, 2.0),
        random.between(0.1, 10.0),
        random.one_of(&[1e-3, 2e-3, 5e-4]),
        random.one_of(&schemes),
        random.one_of(&["depth", "signed"]),
    )
}

/// The pre-flight of `host-cli run`, of the free device and of one that the page's hand holds.
fn preflight(text: &str) -> [PreflightVerdict; 2] {
    let file = ExperimentFile::parse(Path::new("wall.toml"), text).expect("a wall");
    let table: toml::Table = text.parse().expect("TOML");
    let number = |key: &str| table["wall"][key].as_float().expect("a number");
    let scheme = table["wall"]["scheme"].as_str().expect("a text");
    let preflight = Preflight {
        stiffness_n_per_m: number("stiffness_n_per_m"),
        dissipation_n_s_mu_per_m: number("dissipation_n_s_mu_per_m"),
        order: Order::new(number("order")).expect("valid"),
        model: None,
        scheme: scheme.parse().expect("a scheme"),
        sample_time_s: number("sample_time_s"),
        samples: file.samples().expect("in range"),
        map: None,
        contact: WallContact::OneSided,
        guarded: false,
    };
    let free = Dynamics {
        mass_kg: number("mass_kg"),
        damping_n_s_per_m: number("damping_n_s_per_m"),
        hand_stiffness_n_per_m: 0.0,
        delay_s: number("delay_s"),
        current_lag_s: number("current_lag_s"),
    };
    let held = Dynamics {
        damping_n_s_per_m: free.damping_n_s_per_m + 5.5,
        hand_stiffness_n_per_m: 300.0,
        ..free
    };
    [free, held].map(|dynamics| preflight.verdict(dynamics, 0).expect("judged"))
}

/// Stable walls and others, the verdict on each that of the command.
fn verdicts_agree(cases: u32) {
    let (_runs, _server, mut page) = opened();
    let mut random = Random(61);
    let (mut stable, mut unstable) = (0, 0);
    for _ in 0..cases {
        let text = any(&mut random);
        let known = preflight(&text);
        let file = json!({"environment": {"file": {"name": "wall.toml", "text": text}}});
        let edge = |verdict: &PreflightVerdict| verdict.margin.unwrap_or(f64::INFINITY);
        if let Some(unstable_one) = known.iter().find(|verdict| !verdict.stable) {
            let refused = page.refused("feel.start", file);
            assert!(refused.contains("would be unstable"), "{refused} of {text}");
            // The remedy helps.
            let most = edge(unstable_one);
            let named = refused
                .split("use at most ")
                .nth(1)
                .map(|rest| rest.split(' ').next());
            let factor = named.flatten().and_then(|text| text.parse::<f64>().ok());
            assert_eq!(factor.is_some(), most.is_finite(), "{refused}");
            assert!(
                factor.is_none_or(|factor| factor <= most && factor > 0.89 * most),
                "{refused}, {most}"
            );
            unstable += 1;
            continue;
        }
        let felt = page.ask("feel.start", file)["feel"].take();
        let verdict = &felt["verdict"];
        let nearest = if edge(&known[1]) < edge(&known[0]) {
            known[1]
        } else {
            known[0]
        };
        has(verdict, json!({"stable": true, "passive": nearest.passive}));
        let margin = verdict["margin"].as_f64().unwrap_or(f64::INFINITY);
        let off = margin / edge(&nearest) - 1.0;
        assert!(
            off.abs() < 2e-3 || margin.is_infinite() && edge(&nearest).is_infinite(),
            "{verdict} for {nearest:?} of {text}"
        );
        stable += 1;
    }
    println!("{stable} stable, {unstable} refused");
    assert!(stable.min(unstable) * 5 > cases, "{stable} of {cases}");
}

#[test]
fn the_verdict_on_ten_walls_is_that_of_the_command() {
    verdicts_agree(10);
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_verdict_on_a_hundred_walls_is_that_of_the_command() {
    verdicts_agree(100);
}

#[test]
fn every_tissue_is_felt_and_one_that_is_too_stiff_is_made_smaller_and_says_so() {
    let (_runs, _server, mut page) = opened();
    let library = Library::load(None).expect("built in");
    let mut made_smaller = Vec::new();
    for material in library.materials() {
        let start = json!({"environment": {"tissue": material.name}});
        let felt = page.ask("feel.start", start)["feel"].take();
        assert_eq!(felt["verdict"]["stable"], true, "{felt}");
        let scale = felt["scale"].as_f64().expect("a number");
        println!("{}: {scale}, {}", material.name, felt["note"]);
        assert_eq!(felt["note"].is_null(), scale >= 1.0, "{felt}");
        if scale < 1.0 {
            // Twice as much is still stable, as hits on contact that only pushes ask for.
            assert!(felt["verdict"]["margin"].as_f64() >= Some(2.0), "{felt}");
            made_smaller.push(material.name.as_str());
            // Who asks for all of it is told why not.
            let whole = page.refused("feel.set", json!({"scale": 1}));
            assert_says(&whole, "would be unstable");
        }
    }
    assert_eq!(made_smaller, ["rat-tail-tendon"]);
    assert_eq!(library.materials().len(), 16);
    // A number that somebody gives is that number, or refused with a factor that helps.
    page.ask("feel.start", prostate());
    let much = json!({"order": 1, "dissipation_n_s_mu_per_m": 2000});
    let refused = page.refused("feel.set", much);
    assert!(refused.contains("unstable") && refused.contains("of K and B"));
    let felt = hello(&mut page);
    has(&felt["feel"], json!({"order": 0.2247, "scale": 1.0}));
}

fn is_refused(page: &mut Page, start: Value, words: &str) {
    let refused = page.refused("feel.start", start);
    let is_line = !refused.contains('\n');
    assert!(refused.contains(words) && is_line, "{refused}");
}

#[test]
fn the_device_of_a_start_is_that_of_the_server_but_for_what_is_said() {
    let runs = tempfile::tempdir().expect("a folder");
    let mut options = options(runs.path(), OnClose::Stop, 0);
    options.device.values.delay_s = 1e-3;
    options.device.values.mass_kg = 0.1;
    let server = PageServer::start(options).expect("starts");
    let mut page = Page::open(server.address());
    let device = json!({"current_lag_s": 5e-4, "sensor_noise_m": 2e-6, "sample_time_s": 2e-3});
    let start = json!({"environment": {"tissue": "prostate-healthy"}, "device": device});
    let felt = page.ask("feel.start", start)["feel"].take();
    has(&felt, device);
    has(
        &felt,
        json!({"delay_s": 1e-3, "mass_kg": 0.1, "damping_n_s_per_m": 3.5}),
    );
    assert_eq!(
        page.status(|status| status["running"] == true)["sample_time_s"],
        2e-3
    );
    page.ask(
        "view",
        json!({"source": "live", "last_s": 1, "columns": 100}),
    );
    let shown = page.frame(|_| true).sample_time_s;
    assert_close("shown", shown, 2e-3, 1e-12);
    for [kind, number, words] in testkit::table(
        r#"
        device | {"mass_kg": 0} | `mass_kg` = 0 is not above 0 and at most 100
        device | {"mass_kg": null} | `mass_kg` = NaN is not above 0
        device | {"damping_n_s_per_m": -1} | `damping_n_s_per_m` = -1 is not from 0
        device | {"delay_s": 3} | `delay_s` = 3 is not from 0 to 1
        device | {"current_lag_s": 2} | `current_lag_s` = 2 is not from 0 to 1
        device | {"friction_n": -1} | `friction_n` = -1 is not from 0
        device | {"encoder_resolution_m": 1} | `encoder_resolution_m` = 1 is not from 0
        device | {"sensor_noise_m": 1} | `sensor_noise_m` = 1 is not from 0
        device | {"sample_time_s": 1} | `sample_time_s` = 1 is not from 0.0001 to 0.01
        device | {"colour": 1} | no number `colour`: give some of mass_kg
        wall | {"order": 2.1} | `order` = 2.1 is not from 0 to 2
        wall | {"stiffness_n_per_m": -1} | `stiffness_n_per_m` = -1 is not from 0
        wall | {"dissipation_n_s_mu_per_m": 1e9} | `dissipation_n_s_mu_per_m` = 1e9 is not from 0
        wall | {"scheme": "fast"} | `scheme` = fast: scheme "fast" is not one of
        wall | {"scheme": "grunwald:100000"} | `scheme` = grunwald:100000: the page judges at most
        wall | {"signed": true, "stiffness_n_per_m": 0} | `stiffness_n_per_m` = 0 of a signed wall
        "#,
    ) {
        let number: Value = number.parse().expect("JSON");
        let start = match kind.as_str() {
            "wall" => json!({"environment": {"wall": number}}),
            _ => json!({"environment": {"tissue": "prostate-healthy"}, "device": number}),
        };
        is_refused(&mut page, start, &words);
    }
    let start = json!({"environment": {"tissue": "liver"}, "device": {"sample_time_s": 2e-3}});
    page.ask("feel.start", start);
    page.refused(
        "feel.start",
        json!({"environment": {"wall": {"stiffness_n_per_m": 1e8}}}),
    );
    // What ran before goes on.
    assert_eq!(hello(&mut page)["feel"]["sample_time_s"], 2e-3);
}

#[test]
fn the_ends_of_all_ranges_are_felt_or_refused_in_a_line() {
    let (_runs, _server, mut page) = opened();
    let values = |text: &str| -> Vec<Value> {
        let rows = testkit::table::<1>(text);
        rows.map(|[row]| row.parse().expect("JSON")).collect()
    };
    for device in values(
        r#"
        {"mass_kg": 100, "damping_n_s_per_m": 1e6, "sample_time_s": 0.01}
        {"mass_kg": 1e-12, "damping_n_s_per_m": 0}
        {"delay_s": 1, "current_lag_s": 1, "sample_time_s": 1e-4}
        {"friction_n": 1e4, "encoder_resolution_m": 1e-3, "sensor_noise_m": 1e-3}
        "#,
    ) {
        for wall in values(
            r#"
            {"order": 2, "stiffness_n_per_m": 0, "dissipation_n_s_mu_per_m": 1e-9, "scheme": "oustaloup:5:1:100"}
            {"order": 0, "stiffness_n_per_m": 1e8, "dissipation_n_s_mu_per_m": 1e8}
            {"order": 2, "stiffness_n_per_m": 1e-300, "dissipation_n_s_mu_per_m": 0, "signed": true}
            "#,
        ) {
            let start = json!({"environment": {"wall": wall}, "device": device});
            let number = page.post("feel.start", start);
            let answer = page.answer(&json!(number));
            let error = answer["error"].as_str().unwrap_or_default();
            assert!(
                answer["ok"] == true || (!error.is_empty() && !error.contains('\n')),
                "{answer}"
            );
        }
    }
}

#[test]
fn a_tissue_file_is_felt_and_what_is_not_felt_says_what_to_do() {
    let (runs, _server, mut page) = opened();
    let gel = "name = \"gel\"\ndescription = \"a gel\"\n[parameters]\nelastic_modulus_pa = 2000.0\nviscosity_pa_s_alpha = 500.0\n\
               order = 0.3\n[source]\ncitation = \"x\"\nconditions = \"y\"\nchecked = false\n";
    let file =
        |name: &str, text: &str| json!({"environment": {"file": {"name": name, "text": text}}});
    let felt = page.ask("feel.start", file("gel.toml", gel))["feel"].take();
    has(
        &felt,
        json!({"title": "a gel", "order": 0.3, "environment": {"tissue": "gel"}}),
    );
    // It is known from now on.
    page.ask("feel.set", json!({"environment": {"tissue": "liver"}}));
    page.ask("feel.set", json!({"environment": {"tissue": "gel"}}));
    let tissues = hello(&mut page)["tissues"].take();
    let named = tissues.as_array().expect("a list").iter();
    assert_eq!(named.filter(|tissue| tissue["name"] == "gel").count(), 1);
    // Opened again it is the same; a name stands for one tissue.
    page.ask("feel.start", file("gel.toml", gel));
    let liver = gel.replace("\"gel\"", "\"liver\"");
    let taken = "liver.toml: the library has a material \"liver\" already; choose another name";
    page.refuses("feel.start", file("liver.toml", &liver), taken);
    for (name, text, words) in [
        (
            "relax.toml",
            "[relax]\nstrain = 0.03",
            "relax.toml: a [relax] is not felt on the page",
        ),
        (
            "coupler.toml",
            "[coupler]\n",
            "coupler.toml: a [coupler] is not felt on the page",
        ),
        (
            "pushed.toml",
            "[wall]\n[drive]\n",
            "pushed.toml: on the page a hand pushes into the wall",
        ),
        ("wall.toml", "[wall]\nmass_kg = 1000,5", "wall.toml:2"),
        ("wall.toml", "[wall]\nmass_kg = 1", "wall.toml"),
        ("device.toml", "[device]\nmass_kg = 1", "device.toml"),
        ("gel.toml", "[parameters]\norder = 7", "gel.toml"),
        ("empty.toml", "", "empty.toml"),
        ("bytes.toml", "\u{0}\u{1}", "bytes.toml"),
    ] {
        let refused = page.refused("feel.start", file(name, text));
        assert!(
            refused.contains(words) && !refused.contains('\n'),
            "{refused}"
        );
    }
    page.refuses("feel.set", file("gel.toml", gel), "only `feel.start` opens");
    // A tissue that nobody could feel is not taken in, from a page or from the folder of those that were kept.
    let odd = "name = \"odd\"\ndescription = \"odd\"\nmodel = \"fractional-kelvin-voigt\"\n[parameters]\nviscosity_pa_s_alpha = 1e3\n\
               order = 0.5\nsecond_viscosity_pa_s_beta = 500.0\nsecond_order = 1e-8\n[source]\ncitation = \"x\"\nconditions = \"y\"\n\
               checked = false\n";
    let known = hello(&mut page)["tissues"].take();
    page.refuses("feel.start", file("odd.toml", odd), "at least 1e-6");
    let after = hello(&mut page)["tissues"].take();
    assert_eq!(after, known);
    let folder = runs.path().join("tissues");
    std::fs::create_dir_all(&folder).expect("made");
    std::fs::write(folder.join("odd.toml"), odd).expect("written");
    let server = PageServer::start(options(runs.path(), OnClose::Stop, 0)).expect("starts");
    let mut page = Page::open(server.address());
    let built_in = Library::load(None).expect("built in").materials().len();
    let tissues = hello(&mut page)["tissues"].take();
    assert_eq!(tissues.as_array().map(Vec::len), Some(built_in));
    page.refuses(
        "feel.start",
        json!({"environment": {"tissue": "odd"}}),
        "at least 1e-6",
    );
}

/// The wall of a log, on its device.
#[test]
fn a_wall_that_ran_is_felt_from_its_log() {
    let (_runs, _server, mut page) = opened();
    let wall = json!({"order": 1.4, "stiffness_n_per_m": 900, "dissipation_n_s_mu_per_m": 0.1, "scheme": "tustin-muir:3"});
    let mut parameters = wall.clone();
    let device =
        json!({"mass_kg": 0.3, "damping_n_s_per_m": 2.0, "sample_time_s": 2e-3, "delay_s": 1e-3});
    for (key, value) in device.as_object().expect("an object") {
        parameters[key] = value.clone();
    }
    parameters["duration_s"] = 1.into();
    let name = ran(&mut page, "wall", parameters)["name"].take();
    let felt = page.ask("feel.start", json!({"environment": {"run": name}}))["feel"].take();
    has(&felt, device);
    for (key, value) in wall.as_object().expect("an object") {
        assert_eq!(felt[key].as_f64(), value.as_f64(), "{key} of {felt}");
        assert_eq!(felt["environment"]["wall"][key], felt[key]);
    }
    // So is what was felt and recorded, as the same.
    let name = page.ask("feel.record", json!({"on": true}))["name"].take();
    page.status(|status| status["recorded"].as_u64() > Some(20));
    page.ask("feel.record", json!({"on": false}));
    let again = page.ask("feel.start", json!({"environment": {"run": name}}))["feel"].take();
    assert_eq!(again, felt);
    page.refuses(
        "feel.start",
        json!({"environment": {"run": "nothing"}}),
        "nothing",
    );
}

#[test]
fn a_server_that_is_given_a_file_offers_its_wall_first() {
    let runs = tempfile::tempdir().expect("a folder");
    let path = runs.path().join("wall.toml");
    let start = |text: &str| {
        std::fs::write(&path, text).expect("written");
        let mut options = options(runs.path(), OnClose::Stop, 0);
        options.opens = Some(path.clone());
        PageServer::start(options)
    };
    let wall = "[wall]\nmass_kg = 0.2\ndamping_n_s_per_m = 3.5\nsample_time_s = 0.001\norder = 1.63\nstiffness_n_per_m = 1000.0\n\
                dissipation_n_s_mu_per_m = 0.01\nencoder_resolution_m = 2e-5\n";
    let server = start(wall).expect("a wall");
    let mut page = Page::open(server.address());
    let opens = hello(&mut page)["opens"].take();
    has(
        &opens,
        json!({"order": 1.63, "mass_kg": 0.2, "encoder_resolution_m": 2e-5, "scheme": "full"}),
    );
    assert_eq!(opens["environment"]["wall"]["order"], 1.63);
    for (text, words) in [
        (
            wall.replace("1000.0", "9e6"),
            "wall.toml: this would be unstable",
        ),
        (
            wall.replace("0.001", "0.02"),
            "wall.toml: `sample_time_s` = 0.02 is not from 0.0001 to 0.01",
        ),
        ("[drive]".to_owned(), "wall.toml"),
    ] {
        assert_refused(start(&text), words);
    }
    std::fs::remove_file(&path).expect("removed");
    let mut options = options(runs.path(), OnClose::Stop, 0);
    options.opens = Some(path);
    assert_refused(PageServer::start(options), "wall.toml");
}

#[test]
fn quantities_are_read_as_on_the_command_line_and_degrees_where_the_field_is_in_degrees() {
    let (_runs, _server, mut page) = opened();
    for [key, text, value] in testkit::table(
        "
        mass_kg | 45 g | 0.045
        _kg | 65 g | 0.065
        _s | 2 ms | 0.002
        margin_deg | 50 deg | 50
        margin_deg | 50 | 50
        margin_deg | 50° | 50
        margin_deg | 1 rad | 57.29577951308232
        ",
    ) {
        let read = page.ask("quantity", json!({"key": key, "text": text}));
        assert_documented("quantity", &read);
        let value = value.parse().expect("a number");
        assert_relative(
            &text,
            read["value"].as_f64().expect("a number"),
            value,
            1e-12,
        );
    }
    for (key, text, words) in [
        ("margin_deg", "50 kg", "is a mass, not an angle"),
        ("mass_kg", "45 parsecs", "is not a mass"),
    ] {
        page.refuses("quantity", json!({"key": key, "text": text}), words);
    }
}
