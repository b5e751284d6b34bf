//! Good files, and what is said of bad ones.

use super::{DocumentOfKind as _, ExperimentFile};
use crate::experiment::{coupler::CouplerExperiment, wall::WallExperiment};
use haptic_document::Document;
use haptic_loop::Limit;
use std::path::Path;
use testkit::{Folder, Tested};

const WALL: &str = "[wall]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 2e-3\n\
                    order = 0.5\nstiffness_n_per_m = 3_000\ndissipation_n_s_mu_per_m = 60.0\n";

fn read(text: &str) -> Result<ExperimentFile, String> {
    ExperimentFile::parse(Path::new("lab/wall.toml"), text).map_err(|error| error.to_string())
}

#[test]
fn a_wall_has_the_defaults_of_the_dissertation() {
    let file = read(WALL).expect("good");
    let wall: &WallExperiment = file.of().expect("a wall");
    let have = [
        wall.trial.stiffness_n_per_m,
        wall.trial.setup.plan.push_n,
        wall.trial.setup.plan.duration_s,
        wall.trial.setup.plan.window_s,
    ];
    assert!(
        have.iter()
            .zip([3000.0, 1.0, 5.0, 0.4])
            .all(|(a, b)| a.to_bits() == f64::to_bits(b))
    );
    assert_eq!(file.samples().expect("valid"), 2501);
}

#[test]
fn a_wall_is_judged_by_the_dissertations_rule_where_the_file_says_so_on_any_device() {
    use haptic_judge::settling::Criterion;
    let plan = |keys: &str| {
        let text = WALL.replace("[wall]\n", &format!("[wall]\n{keys}"));
        let file = read(&text).expect("good");
        let wall: &WallExperiment = file.of().expect("a wall");
        wall.trial.setup.plan()
    };
    let settling = plan("");
    assert_eq!(settling.criterion, Criterion::Settling);
    for device in ["", "device = \"serial:/dev/ttyACM0\"\n"] {
        let by_file = plan(&format!("criterion = \"dissertation\"\n{device}"));
        let want = haptic_judge::trial::TrialPlan {
            criterion: Criterion::Dissertation,
            impact_m_per_s: 0.0,
            ..settling
        };
        assert_eq!(by_file, want, "0.1 mm, pushed from rest");
        let keys = format!("criterion = \"dissertation\"\nthreshold_m = 2e-4\n{device}");
        assert_eq!(plan(&keys).threshold_m.to_bits(), 2e-4_f64.to_bits());
    }
    // Whoever asks for an impact gets it.
    let thrown = plan("criterion = \"dissertation\"\nimpact_m_per_s = 0.2\n");
    assert_eq!(thrown.impact_m_per_s.to_bits(), 0.2_f64.to_bits());
}

#[test]
fn empty_tables_are_the_commands_defaults() {
    for text in ["[relax]", "[creep]\n"] {
        let file = read(text).expect("valid");
        assert_eq!(file.samples().expect("valid"), 200_001, "{text}");
    }
}

/// What stands in [`WALL`], or `*` for all of it, what is put in its place, and the beginning of what is said behind the file.
const WRONG: &str = r#"
    = 0.065 | = -1 | 2: mass_kg = -1 is not above 0
    = 0.065 | = nan | 2: mass_kg = NaN is not above 0
    = 0.065 | = "x" | 2: mass_kg = "x" is a string, not a number
    = 0.065 | = 0x41 | 2: mass_kg is not written as a decimal number
    order = 0.5 | order = 2.5 | 5: order = 2.5 is not from 0 to 2
    order = 0.5\n |  | 1: missing key `order` in [wall]
    order = | ordre = | 5: unknown key `ordre` in [wall]: did you mean `order`?
    [wall] | [wal] | 1: unknown table [wal]: an experiment file has one of [relax], [creep], [wall], [coupler]
    [wall]\n | [wall]\nscheme = "exact"\n | 2: scheme exact is for analysis only
    [wall]\n | [wall]\nseed = -1\n | 2: seed = -1 is not a whole number
    [wall]\n | [wall]\none_sided = 1\n | 2: one_sided = 1 is an integer, not true or false
    [wall]\n | [relax]\n[wall]\n | 2: a second experiment [wall]: an experiment file has one of
    [wall]\n | [wall]\npush_n = 200\n | 2: push_n = 200 is not below force_limit_n = 100
    [wall]\n | [wall]\npush_by = "wind"\n | 2: push_by = "wind" is not one of hand, device
    [wall]\n | [wall]\nguard = "observer"\npush_by = "device"\n | 3: push_by = "device" pushes with the energy that a guard takes away
    [wall]\n | [wall]\npush_n = 0\npush_by = "device"\n | 2: push_n = 0 is not above 0
    [wall]\n | [wall]\ncriterion = "strict"\n | 2: criterion = "strict" is not one of settling, dissertation
    [wall]\n | [wall]\nguard = "on"\n | 2: guard = "on" is not one of off, observer, energy-bounding
    damping_n_s_per_m = 3.5\n | damping_n_s_per_m = 0\nguard = "energy-bounding"\n | 1: damping of the device 0 N·s/m is not above 0
    [wall]\n | [wall]\nduration_s = 0.1\n | 1: window 0.4 s is not in [0.02, 0.1] s
    [wall]\n | [wall]\ndelay_s = 1\n | 1: delay 1 s
    [wall] | [wall | 1: 
    * |  | 1: no experiment: an experiment file has one of [relax], [creep], [wall], [coupler]
    * | wall = 3 | 1: `wall` is not a table: write [wall]
    * | [relax]\nramp_time_s = 300 | 2: ramp_time_s = 300 is not below duration_s = 200
    * | [relax]\ncontact = "soft" | 2: contact = "soft" is not one of compliant, rigid
    * | [creep]\n\ntissue = "jelly" | 3: tissue "jelly" is not in the library
    * | [creep]\ntissue = "a.toml" | 2: cannot read the material file `lab/a.toml`
    order = 0.5\n | order = 0.5\norder = 0.6\n | 6: duplicate key `order`
    * | [relax]\nworkspace_low_m = 0 | 2: a workspace has two ends: give workspace_high_m too
    * | [relax]\nworkspace_high_m = 0 | 2: a workspace has two ends: give workspace_low_m too
    * | [relax]\nworkspace_low_m = 0\nworkspace_high_m = -1 | 3: workspace_high_m = -1 is not above workspace_low_m = 0
    * | [relax]\nspeed_limit_m_per_s = 5e-7 | 2: speed_limit_m_per_s = 5e-7 is not from 0.000001 to 100
    * | [relax]\nrise_time_s = 0 | 2: rise_time_s = 0 is not above 0
    [wall]\n | [wall]\njump_m = 1e-6\n | 1: jump 0.000001 m has no effect
    [wall]\n | [wall]\nstuck_time_s = 0.05\n | 1: stuck time 0.05 s has no effect
    [wall]\n | [wall]\ndevice_mass_kg = 0.065\n | 1: device mass 0.065 kg has no effect
    [wall]\n | [wall]\nguard = "observer"\ndevice_damping_n_s_per_m = 3.5\n | 1: device damping 3.5 N·s/m has no effect
    [wall]\n | [wall]\ndevice_lag_s = 1e-3\n | 1: device lag 0.001 s has no effect
    [wall]\n | [wall]\nbraking_n_s_per_m = 1000\n | 1: braking 1000 N·s/m must be at most
    * | [relax]\nstop_time_s = 2 | 2: stop_time_s = 2 is not from 0.001 to 1
    * | [relax]\nbrake_force_n = 20 | 2: brake_force_n = 20 is not from 0 to 10
    * | [relax]\njump_m = 1e-7 | 2: jump_m = 1e-7 is not 0 or from 0.000001 to 1
    * | [relax]\ndevice_delay_least_s = 2e-3\ndevice_delay_most_s = 1e-3 | 3: device_delay_most_s = 0.001 is below device_delay_least_s = 0.002
    * | [relax]\ndevice_delay_least_s = 2e-3 | 2: a delay has two ends: give device_delay_most_s too
    * | [relax]\ndevice = "serial:x"\nsensor_noise_m = 1e-6 | 1: encoder_resolution_m and sensor_noise_m are of the simulated rig
    * | [relax]\ndevice = "serial:x"\nwatchdog_s = 0.0054 | 3: watchdog_s = 0.0054 is not a whole number of milliseconds
    * | [relax]\n[drive]\n | 2: missing key `controller` in [drive]
    * | [relax]\nduration_s = 1e7 | 2: duration_s = 1e7 is 10000000001 samples of 0.001 s
"#;

#[test]
fn what_is_wrong_is_said_in_one_line_with_its_place() {
    for [from, to, want] in testkit::table(WRONG) {
        let from = if from == "*" { WALL } else { &from };
        refused(WALL, from, &to, &want);
    }
}

/// This in the place of that is refused in a line, which begins so behind the file.
fn refused(text: &str, from: &str, to: &str, want: &str) {
    assert!(text.contains(from), "{from}");
    let have = read(&text.replace(from, to)).expect_err(to);
    let message = have.strip_prefix("lab/wall.toml:").unwrap_or_default();
    assert!(message.starts_with(want), "have {have}\nwant {want}");
    assert!(!have.contains('\n'), "{have}");
}

const COUPLER: &str = "[coupler]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 1e-3\norder = 0.75\n\
                       coupler_damping_n_s_per_m = 1\ncoupler_spring_n_s_1_minus_mu_per_m = 500\n";

#[test]
fn a_coupler_has_an_object_by_default_and_no_loop_on_a_device() -> Tested {
    let file = read(COUPLER).expect("good");
    let coupler: &CouplerExperiment = file.of().expect("a coupler");
    assert_eq!(
        coupler.trial.object,
        haptic_question::design::coupler::CouplerDesign::OBJECT
    );
    assert_eq!(file.samples()?, 5001);
    // What is given over the file may still ask for a loop on the host.
    let serial = format!("{COUPLER}device = \"serial:x\"\n");
    let message = read(&serial).expect_err("no loop there");
    assert!(message.contains("give `loop` = host"), "{message}");
    let mut document = Document::of_text(Path::new("lab/wall.toml"), &serial);
    let set = document.set("coupler", "loop", "host", "--loop host");
    set?;
    let here = ExperimentFile::open(&document)?;
    assert_eq!(here.samples()?, 5001);
    for [from, to, want] in testkit::table(
        r"
        0.75 | 1.01 | 5: order = 1.01 is not from 0 to 1
        = 500 | = -5 | 7: coupler_spring_n_s_1_minus_mu_per_m = -5 is not from 0 to 1e8
        = 500 | = 500\none_sided = true | 8: unknown key `one_sided` in [coupler]
        = 1\ncoupler_spring_n_s_1_minus_mu_per_m = 500 | = 0\ncoupler_spring_n_s_1_minus_mu_per_m = 0 | 1: coupler spring of a coupler without damping 0
        = 500\n | = 500\nobject_stiffness_n_per_m = 0\nobject_mass_kg = 0\nobject_damping_n_s_per_m = 0\n | 1: object stiffness of an object without mass and damping 0 N/m is not above 0
        ",
    ) {
        refused(COUPLER, &from, &to, &want);
    }
    Ok(())
}

#[test]
fn the_pre_flight_of_a_wall_knows_delay_and_lag_of_a_device_file() {
    let folder = Folder::empty();
    let file = "[device]\nmass_kg = 0.08\ndamping_n_s_per_m = 3\ndelay_s = 0.0013\ncurrent_lag_s = 0.0005\n";
    std::fs::write(folder.join("device.toml"), file).expect("writes");
    for device in ["sim", "serial:none"] {
        let text = format!(
            "[wall]\ndevice = \"{device}\"\ndevice_model = \"device.toml\"\nsample_time_s = 0.001\norder = 1\n\
             stiffness_n_per_m = 300\ndissipation_n_s_mu_per_m = 1\n"
        );
        let parsed = ExperimentFile::parse(&folder.join("wall.toml"), &text);
        let file = parsed.expect("good");
        let wall: &WallExperiment = file.of().expect("a wall");
        let known = wall.trial.setup.dynamics();
        assert_eq!(
            (known.delay_s, known.current_lag_s),
            (0.0013, 0.0005),
            "{device}"
        );
    }
}

#[test]
fn what_a_file_says_of_the_loop_holds_for_a_device_that_is_given() -> Tested {
    let says = "watchdog_s = 0.3\nmax_age_ticks = 40\nlate_ticks = 7\nloop = \"host\"\n";
    let mut document = Document::of_text(Path::new("lab/wall.toml"), &format!("{WALL}{says}"));
    let file = ExperimentFile::open(&document)?;
    assert_eq!(file.0.conduct().remote, None);
    let set = document.set("wall", "device", "serial:here", "--device serial:here");
    set?;
    let file = ExperimentFile::open(&document)?;
    let remote = file.0.conduct().remote.as_ref().expect("serial");
    assert_eq!(remote.watchdog_ms(), 300);
    assert_eq!((remote.max_age_ticks, remote.late_ticks), (40, 7));
    assert_eq!(remote.loop_mode, haptic_link::LoopMode::Host);
    assert_eq!(remote.name.to_string(), "serial:here");
    Ok(())
}

/// The mass of the device of a wall.
fn mass_kg(document: &Document) -> f64 {
    let file = ExperimentFile::open(document).expect("good");
    let wall: &WallExperiment = file.of().expect("a wall");
    wall.trial.setup.device.mass.0
}

#[test]
fn a_device_file_lies_below_the_keys_of_the_layer_that_names_it() -> Tested {
    let folder = Folder::empty();
    let file = "[device]\nmass_kg = 0.08\ndamping_n_s_per_m = 3\n";
    std::fs::write(folder.join("device.toml"), file)?;
    let wall = folder.join("wall.toml");
    let alone = Document::of_text(&wall, WALL);
    assert_eq!(mass_kg(&alone).to_bits(), f64::to_bits(0.065));
    let named = format!("{WALL}device_model = \"device.toml\"\n");
    assert_eq!(
        mass_kg(&Document::of_text(&wall, &named)).to_bits(),
        f64::to_bits(0.065)
    );
    let path = folder.join("device.toml");
    let mut over = alone;
    let set = over.set(
        "wall",
        "device_model",
        path.to_string_lossy().as_ref(),
        "--device-model",
    );
    set?;
    assert_eq!(mass_kg(&over).to_bits(), f64::to_bits(0.08));
    over.set("wall", "mass_kg", 0.1, "--mass 100g")?;
    assert_eq!(mass_kg(&over).to_bits(), f64::to_bits(0.1));
    Ok(())
}

#[test]
fn what_is_given_is_refused_by_its_words_and_not_twice() {
    let mut document = Document::of_text(Path::new("lab/wall.toml"), WALL);
    document
        .set("wall", "order", 3.0, "--order 3")
        .expect("new");
    let error = ExperimentFile::open(&document).expect_err("an order");
    assert_eq!(
        error.to_string(),
        "--order 3: order = 3 is not from 0 to 2: change it"
    );
    let twice = document.set("wall", "order", 1.0, "order=1");
    let twice = twice.expect_err("given").to_string();
    assert!(
        twice.starts_with("order=1: order is given twice"),
        "{twice}"
    );
    let mut idle = Document::new("relax");
    idle.set("relax", "seed", 7, "seed=7").expect("new");
    let error = ExperimentFile::open(&idle)
        .expect_err("no noise")
        .to_string();
    assert!(
        error.starts_with("seed=7: seed has no effect without noise"),
        "{error}"
    );
}

#[test]
fn a_written_document_is_the_same_experiment_from_anywhere() -> Tested {
    let folder = Folder::empty();
    let wall = folder.join("wall.toml");
    let file = "[device]\nmass_kg = 0.08\ndamping_n_s_per_m = 3\nfriction_n = 0.1\n";
    std::fs::write(folder.join("device.toml"), file)?;
    let text = WALL.replace("mass_kg = 0.065\n", "");
    let mut document = Document::of_text(&wall, &format!("{text}device_model = \"device.toml\"\n"));
    let set = document.set("wall", "scheme", "grunwald:100", "--scheme grunwald:100");
    set?;
    let written = document.to_toml()?;
    assert!(
        written.contains("\nscheme = \"grunwald:100\"\n"),
        "{written}"
    );
    assert!(written.contains("\n# push_n = 1.0\n"), "{written}");
    let elsewhere = Document::of_text(Path::new("elsewhere/wall.toml"), &written);
    let debug = |document: &Document| {
        let read = ExperimentFile::open(document).expect("good");
        format!("{read:?}")
    };
    assert_eq!(debug(&document), debug(&elsewhere));
    assert_eq!(elsewhere.to_toml()?, written);
    let mut kept = std::collections::BTreeMap::new();
    document.keep_in(&mut kept)?;
    assert_eq!(kept["document"], written);
    // Beside it each key, given, of the device file or by default.
    let values = ["experiment", "scheme", "mass_kg", "push_n", "device"].map(|key| &kept[key][..]);
    assert_eq!(values, ["wall", "grunwald:100", "0.08", "1", "sim"]);
    Ok(())
}

#[test]
fn a_device_file_over_a_file_is_written_as_it_runs() -> Tested {
    let folder = Folder::empty();
    let device = folder.join("device.toml");
    let file = "[device]\nmass_kg = 0.08\ndamping_n_s_per_m = 3\ndelay_s = 0.001\n";
    std::fs::write(&device, file)?;
    let text = format!("{WALL}device_model = \"gone.toml\"\n");
    let mut document = Document::of_text(&folder.join("wall.toml"), &text);
    let path = device.to_string_lossy();
    let set = document.set("wall", "device_model", path.as_ref(), "--device-model");
    set?;
    document.set("wall", "damping_n_s_per_m", 0.1, "damping=0.1")?;
    document.set("wall", "guard", "energy-bounding", "guard=energy-bounding")?;
    // The file that nobody asks for any more need not be there.
    let file = ExperimentFile::open(&document)?;
    let wall: &WallExperiment = file.of().expect("a wall");
    let known = wall.trial.setup.dynamics();
    assert_eq!(
        (known.mass_kg, known.damping_n_s_per_m, known.delay_s),
        (0.08, 0.1, 0.001)
    );
    // A guard does not count on more damping than that.
    assert_eq!(wall.trial.setup.known.damping_n_s_per_m, Some(0.1));
    assert_eq!(wall.trial.setup.known.mass_kg, Some(0.08));
    let written = document.to_toml()?;
    for absent in ["mass_kg", "delay_s", "friction_n"] {
        assert!(
            !written.contains(&format!("{absent} =")),
            "{absent}: {written}"
        );
    }
    let again = Document::of_text(Path::new("elsewhere/wall.toml"), &written);
    let again = ExperimentFile::open(&again)?;
    assert_eq!(format!("{again:?}"), format!("{file:?}"));
    Ok(())
}

#[test]
fn a_device_file_is_no_sensor_of_the_rig() {
    let folder = Folder::empty();
    let file = "[device]\nmass_kg = 0.08\ndamping_n_s_per_m = 3\nencoder_resolution_m = 1e-5\n";
    std::fs::write(folder.join("device.toml"), file).expect("writes");
    for device in ["sim", "serial:x"] {
        let text = format!(
            "[relax]\ndevice = \"{device}\"\nguard = \"observer\"\ndevice_model = \"device.toml\"\n"
        );
        let read = ExperimentFile::parse(&folder.join("relax.toml"), &text);
        let file = read.expect("good");
        let relax = file.indentation().expect("a relaxation");
        assert!(relax.sensors.are_ideal(), "{device}");
        assert_eq!(
            relax.safety.number(Limit::DeviceMass),
            Some(0.08),
            "{device}"
        );
    }
}

#[test]
fn a_key_is_a_key_whatever_stands_in_it() {
    for key in [
        "[drive]\ncontroller",
        "\"strain\"",
        "a b",
        "strain = 1\nguard",
    ] {
        let mut document = Document::new("relax");
        document
            .set("relax", key, 0.1, &format!("{key}=0.1"))
            .expect("new");
        let error = ExperimentFile::open(&document).expect_err(key).to_string();
        assert!(
            error.contains("unknown key") && !error.contains('\n'),
            "{error}"
        );
    }
}

#[test]
fn an_error_in_a_file_points_at_a_character_of_a_line() {
    for (text, line, shown, at) in [
        ("[relax]\nstrain = 5 # %\n", 2, "strain = 5 # %", 9..10),
        (
            "# µ\r\n[relax]\r\ntissue = \"µ\"\r\n",
            3,
            "tissue = \"µ\"",
            9..10,
        ),
        ("[relax]\nµ = 1", 2, "µ = 1", 0..2),
        ("[relax]\nstrain =", 2, "strain =", 8..8),
    ] {
        let error = ExperimentFile::parse(Path::new("a.toml"), text).expect_err("wrong");
        let found = error.excerpt().expect("in a file");
        let found = (found.line, found.text.as_str(), found.at.clone());
        assert_eq!(found, (line, shown, at), "{error}");
    }
}

#[test]
fn a_log_says_when_a_file_is_not_that_of_its_run() {
    let text = |tissue: &str| {
        format!("[teleoperation]\nenvironment = \"tissue\"\ntissue = \"{tissue}\"\n")
    };
    let logged = |tissue: &str| {
        let document = Document::of_text(Path::new("far.toml"), &text(tissue));
        let mut message = ExperimentFile::open(&document).expect("good").metadata();
        document.keep_in(&mut message).expect("good");
        message
    };
    let log = |tissue: &str| {
        let logged = logged(tissue);
        Document::of_log(Path::new("far.mcap"), &text("liver"), logged)
    };
    assert_eq!(log("liver").changed_since_log(), None);
    let changed = log("kidney")
        .changed_since_log()
        .expect("not that of today");
    assert!(changed.starts_with("the file of tissue "), "{changed}");
}
