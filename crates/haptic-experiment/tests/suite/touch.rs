//! A hand over a shape: against the wall of one axis, turned, limited, faulted; its energy, its log.
#![expect(clippy::float_cmp, reason = "exact results are compared exactly")]

use haptic_experiment::ended::LetGo;
use haptic_experiment::folder::FolderRequest;
use haptic_experiment::touch::{TouchReport, TouchVerdict};
use haptic_experiment::{ExperimentFile, Supervisor, TouchExperiment};
use haptic_log::record::{Entry, LogReader, VectorTick};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use testkit::assert_close;

fn experiment(text: &str) -> ExperimentFile {
    match ExperimentFile::parse(Path::new("lab.toml"), text) {
        Ok(experiment) => experiment,
        Err(error) => panic!("{error}"),
    }
}

fn touch(keys: &str) -> TouchExperiment {
    match experiment(&format!("[touch]\n{keys}")) {
        ExperimentFile::Touch(touch) => *touch,
        other => panic!("{other:?}"),
    }
}

fn request(folder: &Path, stem: &str) -> FolderRequest {
    FolderRequest {
        out: Some(folder.to_owned()),
        stem: stem.to_owned(),
        overwrite: false,
        roll_bytes: None,
        provenance: Default::default(),
    }
}

fn supervised<T>(run: impl FnOnce(Supervisor<'_>) -> T) -> T {
    let stop = AtomicBool::new(false);
    run(Supervisor {
        stop: &stop,
        progress: &|_| {},
        live: None,
        warn: &|_| {},
    })
}

/// Runs it in a folder of its own: the report, and the ticks of its log.
fn run(touch: &TouchExperiment) -> (TouchReport, Vec<VectorTick>) {
    let folder = tempfile::tempdir().expect("a folder");
    let published =
        supervised(|supervisor| touch.run(&request(folder.path(), "touch"), supervisor));
    let report = published.expect("runs").report;
    let entries = LogReader::open(Path::new(&report.run.log)).expect("opens");
    let ticks = entries.filter_map(|entry| match entry.expect("reads") {
        Entry::Vector(tick) => Some(tick),
        _ => None,
    });
    let ticks = ticks.collect();
    (report, ticks)
}

/// A finger on the surface of a sphere at the origin, 1 N into it: the wall of one axis from rest.
#[test]
fn a_sphere_pressed_along_a_line_is_the_one_sided_wall() {
    let law = "stiffness_n_per_m = 800\ndissipation_n_s_mu_per_m = 12\norder = 0.4\nmass_kg = 0.065\n\
               damping_n_s_per_m = 3.5\nsample_time_s = 0.001\nduration_s = 1\nforce_limit_n = 100\n";
    let wall = experiment(&format!(
        "[wall]\n{law}one_sided = true\nimpact_m_per_s = 0\npush_n = 1\n"
    ));
    let ExperimentFile::Wall(wall) = wall else {
        panic!("a wall");
    };
    let folder = tempfile::tempdir().expect("a folder");
    let published = supervised(|supervisor| wall.run(&request(folder.path(), "wall"), supervisor));
    let log = published.expect("runs").report.trial.run.log;
    let one: Vec<_> = LogReader::open(Path::new(&log))
        .expect("opens")
        .filter_map(|entry| match entry.expect("reads") {
            Entry::Tick(tick) => Some(tick),
            _ => None,
        })
        .collect();
    for (axes, keys) in [
        (3, "centre_m = [0, 0, 0.25]\nway_points = [[0, 0, 0, 1]]"),
        (2, "centre_m = [0, 0.25]\nway_points = [[0, 0, 1]]"),
    ] {
        let (report, ticks) = run(&touch(&format!(
            "{law}axes = {axes}\nradius_m = 0.25\nhand = \"force\"\n{keys}"
        )));
        assert_eq!((report.axes, report.verdict), (axes, TouchVerdict::Passive));
        assert_eq!(ticks.len(), one.len());
        for (tick, one) in ticks.iter().zip(&one) {
            let last = axes - 1;
            let (place, force) = (tick.position_m.as_slice(), tick.force_n.as_slice());
            assert!(place[..last].iter().all(|x| *x == 0.0));
            // The depth, R − |x − c|, is rounded to that of R.
            assert_close("place", place[last], one.position_m, 1e-13);
            assert_close("force", force[last], one.force_n, 1e-11);
        }
        let deepest = one.iter().map(|tick| tick.position_m).fold(0.0, f64::max);
        assert_close("depth", report.largest_depth_m, deepest, 1e-13);
    }
}

#[test]
fn turning_the_edge_and_the_path_turns_the_force() {
    let angle = 0.7_f64;
    let (sin, cos) = angle.sin_cos();
    let turn = |[x, y]: [f64; 2]| [cos * x - sin * y, sin * x + cos * y];
    let points = [[-0.004, 0.0], [0.003, 0.002], [0.001, 0.02], [-0.002, 0.01]];
    let keys = |normal: [f64; 2], points: [[f64; 2]; 4]| {
        let rows: Vec<String> = (points.iter().enumerate())
            .map(|(n, [x, y])| format!("[{}, {x:?}, {y:?}]", 0.3 * n as f64))
            .collect();
        format!(
            "shape = \"plane\"\nnormal = {normal:?}\nstiffness_n_per_m = 500\nduration_s = 1\nway_points = [{}]",
            rows.join(", ")
        )
    };
    let (_, straight) = run(&touch(&keys([1.0, 0.0], points)));
    let (_, turned) = run(&touch(&keys(turn([1.0, 0.0]), points.map(turn))));
    let mut most = 0.0_f64;
    for (straight, turned) in straight.iter().zip(&turned) {
        for (what, straight, turned) in [
            ("force", straight.force_n, turned.force_n),
            ("place", straight.position_m, turned.position_m),
        ] {
            let (straight, turned) = (straight.as_slice(), turned.as_slice());
            let want = turn([straight[0], straight[1]]);
            // Places are mm, forces below 1 N.
            assert_close(what, turned[0], want[0], 1e-12);
            assert_close(what, turned[1], want[1], 1e-12);
        }
        most = most.max(straight.force_n.norm());
    }
    assert!(most > 0.3, "it was touched: {most} N");
}

/// Through the middle of a ball the force fades, and the comparison knows it.
#[test]
fn a_touch_through_the_centre_is_compared_with_the_law_that_was_run() {
    for axes in [2, 3] {
        let rest = ", 0".repeat(axes - 2);
        let (report, ticks) = run(&touch(&format!(
            "axes = {axes}\nradius_m = 0.01\ncentre_m = [0, 0.01{rest}]\nstiffness_n_per_m = 4\ndissipation_n_s_mu_per_m = 0.2\nmass_kg = 0.05\n\
             force_limit_n = 10\nforce_rate_limit_n_per_s = 1e6\nsample_time_s = 0.001\nduration_s = 3\n\
             hand_stiffness_n_per_m = 5000\nway_points = [[0, 0, -0.002{rest}], [3, 0, 0.022{rest}]]"
        )));
        let y = |tick: &VectorTick| tick.position_m.as_slice()[1];
        let core = ticks
            .iter()
            .filter(|tick| (y(tick) - 0.01).abs() < 0.01 / 1024.0);
        assert!(core.count() > 0, "the centre was passed");
        let error = report.errors.max_relative_error;
        assert!(
            error.is_some_and(|error| error < 1e-3),
            "{:?}",
            report.errors
        );
    }
}

/// The example of the repository: round a disc of tissue.
#[test]
fn a_finger_round_a_disc_is_held_against_the_full_history() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments/touch-disc.toml");
    let Ok(ExperimentFile::Touch(disc)) = ExperimentFile::read(&path) else {
        panic!("a touch");
    };
    let (report, ticks) = run(&disc);
    assert_eq!(report.verdict, TouchVerdict::Passive);
    assert_eq!(report.run.samples, 5001);
    assert_eq!(report.run.limited_samples, 0);
    // The tolerance of the full memory is 1e-6 of its output.
    let error = report.errors.max_relative_error.expect("compared");
    assert!(error < 2e-6, "{error:e}");
    let given = report.given_j.zip(report.given_most_j);
    assert!(given.is_some_and(|(all, most)| all < 0.0 && most < 1e-12));
    assert!(
        (0.3e-3..2e-3).contains(&report.largest_depth_m),
        "{}",
        report.largest_depth_m
    );
    // Outwards along the normal, all the way round.
    let mut quarters = [false; 4];
    for tick in &ticks {
        let (place, force) = (tick.position_m.as_slice(), tick.force_n.as_slice());
        let across = place[0] * force[1] - place[1] * force[0];
        assert!(across.abs() < 1e-13, "{place:?} {force:?}");
        if tick.force_n.norm() > 0.1 {
            assert!(place[0] * force[0] + place[1] * force[1] > 0.0);
            quarters[2 * usize::from(force[0] > 0.0) + usize::from(force[1] > 0.0)] = true;
        }
    }
    assert_eq!(quarters, [true; 4]);
    // Every normal comes up: from the one axis to the other.
    let posture = &report.posture;
    assert_eq!(
        [
            posture.effective_mass_least_kg,
            posture.effective_mass_most_kg
        ],
        [0.065, 0.12]
    );
    let verdict = report.run.preflight.expect("one");
    assert!(verdict.stable && verdict.passive);
    // α = KT²/m of the mass that was judged: here the margin is smaller for the one or the other.
    assert_close(
        "δ",
        verdict.delta,
        3.5 * 1e-3 / posture.judged_mass_kg,
        1e-15,
    );
}

#[test]
fn the_pre_flight_of_a_plane_is_of_the_mass_along_its_normal() {
    let plane = touch(
        "shape = \"plane\"\nnormal = [3, 4]\nmass_kg = [0.05, 0.2]\nway_points = [[0, -0.01, 0]]\nduration_s = 0.1",
    );
    let (report, _) = run(&plane);
    let along = 1.0 / (0.36 / 0.05 + 0.64 / 0.2);
    assert_close("mass", report.posture.judged_mass_kg, along, 1e-15);
    assert_close("mass", report.posture.effective_mass_least_kg, along, 1e-15);
}

#[test]
fn the_force_stays_within_the_limit_of_its_norm() {
    let (report, ticks) = run(&touch(
        "axes = 3\nstiffness_n_per_m = 2000\nforce_limit_n = 0.5\nhand_stiffness_n_per_m = 600\nradius_m = 0.02\n\
         circle_radius_m = 0.015\nduration_s = 2",
    ));
    let most = ticks
        .iter()
        .map(|tick| tick.force_n.norm())
        .fold(0.0, f64::max);
    let wanted = ticks.iter().map(|tick| tick.environment_force_n.norm());
    assert!(wanted.fold(0.0, f64::max) > 1.0);
    assert!(most <= 0.5 && most > 0.499, "{most}");
    assert_eq!(report.verdict, TouchVerdict::Saturated);
    assert_eq!(report.errors.max_relative_error, None);
}

#[test]
fn a_wall_that_shakes_gives_the_hand_energy_and_a_guard_takes_it_back() {
    // 2b/T = 7000 N/m: beyond what any hand may hold.
    let shaking = |guard: &str| {
        touch(&format!(
            "shape = \"plane\"\nstiffness_n_per_m = 60000\ndissipation_n_s_mu_per_m = 0\nduration_s = 2\n\
             force_limit_n = 50\nway_points = [[0, -0.005, 0], [0.5, 0.005, 0], [2, 0.005, 0.02]]\n{guard}"
        ))
    };
    let (report, _) = run(&shaking(""));
    assert_eq!(report.verdict, TouchVerdict::GaveEnergy);
    let most_j = report.given_most_j.expect("a simulated hand");
    assert!(most_j > 1e-6, "{most_j}");
    assert!(!report.run.preflight.expect("one").stable);
    let said = report.run.warnings.join("; ");
    assert!(
        said.contains("pre-flight") && said.contains("the hand was given"),
        "{said}"
    );
    let (report, ticks) = run(&shaking("guard = \"energy-bounding\""));
    assert_eq!(
        report.verdict,
        TouchVerdict::Passive,
        "{:?}",
        report.given_most_j
    );
    // No friction from the guard: the hand slides along the second axis.
    assert!(ticks.iter().all(|tick| tick.force_n.as_slice()[1] == 0.0));
}

#[test]
fn a_shape_that_grows_stiff_while_it_is_pressed_is_told_as_that() {
    // Pressed within the first tenth of a second, while the force rises for two seconds; or touched afterwards.
    let risen = |touched_s: f64| {
        let (in_s, out_s) = (touched_s + 0.1, touched_s + 2.9);
        touch(&format!(
            "shape = \"plane\"\nstiffness_n_per_m = 1000\ndissipation_n_s_mu_per_m = 0\nduration_s = 6\nrise_time_s = 2\n\
             way_points = [[0, -0.001, 0], [{touched_s}, -0.001, 0], [{in_s}, 0.008, 0], [{out_s}, 0.008, 0]]"
        ))
    };
    let (report, _) = run(&risen(0.01));
    assert_eq!(report.verdict, TouchVerdict::GaveEnergy);
    let said = report.run.warnings.join("; ");
    assert!(
        said.contains("take a shorter `rise_time_s`") && !said.contains("softer K"),
        "{said}"
    );
    let (report, _) = run(&risen(2.5));
    assert_ne!(report.verdict, TouchVerdict::GaveEnergy);
}

#[test]
fn leaving_the_box_is_a_fault_that_ends_the_run() {
    let (report, ticks) = run(&touch(
        "axes = 3\nshape = \"plane\"\nsurface_m = 1\nway_points = [[0, 0, 0, 0], [1, 0, 0.04, 0]]\n\
         box_low_m = [-0.01, -0.01, -0.01]\nbox_high_m = [0.1, 0.02, 0.1]\nduration_s = 2",
    ));
    assert_eq!(report.verdict, TouchVerdict::Unfinished);
    let reason = report.run.ended_early.expect("a fault");
    assert!(reason.contains("workspace"), "{reason}");
    assert!(report.run.fault_log.is_some());
    let last = ticks.last().expect("ticks").position_m;
    assert!((0.02..0.03).contains(&last.as_slice()[1]), "{last:?}");
}

#[test]
fn what_is_told_of_a_run_that_a_fault_ended_is_what_its_log_shows() {
    // Pressed 20 mm deep when it leaves its box.
    let pressed = |safety: &str| {
        touch(&format!(
            "shape = \"plane\"\nstiffness_n_per_m = 200\ndissipation_n_s_mu_per_m = 0\nforce_limit_n = 50\nduration_s = 2\n\
             way_points = [[0, -0.005, 0], [0.5, 0.06, 0]]\nbox_low_m = [-0.1, -0.1]\nbox_high_m = [0.02, 0.1]\n{safety}"
        ))
    };
    for (safety, let_go) in [
        ("", LetGo::InOneSample),
        ("force_rate_limit_n_per_s = 200", LetGo::Ramped),
        ("braking_n_s_per_m = 8\nbrake_force_n = 8", LetGo::Ramped),
    ] {
        let (report, ticks) = run(&pressed(safety));
        let run = &report.run;
        assert_eq!(run.let_go, Some(let_go), "{safety}: {run:?}");
        let norms: Vec<f64> = ticks.iter().map(|tick| tick.force_n.norm()).collect();
        let most = norms.iter().copied().fold(0.0, f64::max);
        assert!(most > 3.0, "{most} N");
        assert_eq!(run.peak_force_n, most, "{safety}");
        assert_eq!(norms.last(), Some(&0.0));
        // The last sample that counts is that before the fault; the force at the end is its, before it falls.
        let counts = |tick: &&VectorTick| tick.time_s <= run.duration_s;
        let last = ticks.iter().rfind(counts).expect("ticks");
        assert_eq!(run.final_force_n, last.force_n.norm(), "{safety}");
        assert!(run.final_force_n > 3.0, "{safety}: {}", run.final_force_n);
        // The tick of the fault is the first outside, so it is deeper than all that count.
        let depths = ticks.iter().map(|tick| tick.position_m.as_slice()[0]);
        assert_eq!(report.largest_depth_m, depths.fold(0.0, f64::max));
        assert!(report.largest_depth_m > 0.02, "{}", report.largest_depth_m);
    }
}

#[test]
fn what_is_wrong_is_refused_with_its_line() {
    for (keys, reason) in [
        ("axes = 4", "2: axes = 4 is not 2 or 3"),
        ("axes = 1", "one axis is a [wall]"),
        (
            "radius_m = 0",
            "2: radius_m = 0 is not from 0.000001 to 1000",
        ),
        (
            "centre_m = [0]",
            "2: centre_m has 1 numbers, not one for each of 2 axes",
        ),
        (
            "mass_kg = [0.1, 0]",
            "2: mass_kg has 0, which is not above 0",
        ),
        (
            "mass_kg = [1, 2, 3]",
            "3 numbers, not one for all or each of 2 axes",
        ),
        (
            "centre_m = [1e300, 0]",
            "2: centre_m has 1e300, which is not from -1000 to 1000: change it",
        ),
        (
            "way_points = [[0, 1e308, 0]]",
            "2: way_points has 1e308, which is not from -10000 to 1e7",
        ),
        (
            "normal = [1, 0]",
            "2: normal has no effect with a ball: change that, or leave normal out",
        ),
        ("surface_m = 0", "2: surface_m has no effect with a ball"),
        (
            "shape = \"plane\"\nradius_m = 0.02",
            "3: radius_m has no effect with shape = \"plane\": change that",
        ),
        (
            "shape = \"plane\"\ncentre_m = [0, 0]",
            "3: centre_m has no effect with shape = \"plane\"",
        ),
        (
            "tissue = \"prostate-cancerous\"\nstiffness_n_per_m = 300",
            "3: stiffness_n_per_m has no effect with `tissue`",
        ),
        (
            "area_m2 = 1e-4",
            "2: area_m2 has no effect without `tissue`",
        ),
        (
            "way_points = [[0, 1, 1]]\ncircle_radius_m = 0.01",
            "3: circle_radius_m has no effect with `way_points`",
        ),
        (
            "hand = \"force\"\nhand_stiffness_n_per_m = 300\nway_points = [[0, 1, 1]]",
            "3: hand_stiffness_n_per_m has no effect with hand = \"force\"",
        ),
        ("shape = \"cube\"", "is not one of plane, ball, hollow-ball"),
        ("shape = \"plane\"\nnormal = [0, 0]", "change `normal`"),
        ("way_points = []", "`way_points` is empty"),
        ("way_points = [[0, 1]]", "row 1 of `way_points`"),
        (
            "way_points = [[1, 1, 1], [1, 0, 0]]",
            "row 2 of `way_points`",
        ),
        ("hand = \"force\"", "goes `way_points` in N"),
        ("box_low_m = [0, 0]", "give box_high_m too"),
        (
            "box_low_m = [0, 0]\nbox_high_m = [1, 0]",
            "`box_high_m` has 0, which is not above 0",
        ),
        (
            "box_low_m = [-1, -1]\nbox_high_m = [1, 1]\nworkspace_low_m = -1\nworkspace_high_m = 1",
            "leave one of them out",
        ),
        (
            "duration_s = 2000",
            "2000001 samples, which is not in [10, 1e6]",
        ),
        ("device = \"usb:1\"", "is not one of sim, serial:PATH"),
        ("device = \"serial:x\"", "give `loop` = host"),
        (
            "device = \"haply:x\"\nloop = \"host\"\nbox_low_m = [-0.05, -0.05]\nbox_high_m = [0.05, 0.1]",
            "the box is not within reach of the 2DIY",
        ),
        ("tissue = \"granite\"", "granite"),
    ] {
        let error = ExperimentFile::parse(Path::new("lab.toml"), &format!("[touch]\n{keys}"))
            .expect_err(keys)
            .to_string();
        assert!(
            error.contains(reason) && !error.contains('\n'),
            "{keys}: {error}"
        );
    }
}

#[test]
fn a_simulated_hand_that_begins_inside_is_refused_before_a_file_is_made() {
    let folder = tempfile::tempdir().expect("a folder");
    let inside = touch("circle_start_radius_m = 0.01");
    let refused = supervised(|supervisor| inside.run(&request(folder.path(), "touch"), supervisor));
    let said = refused.expect_err("inside").to_string();
    assert!(said.contains("would be a blow"), "{said}");
    let left = std::fs::read_dir(folder.path()).expect("a folder").count();
    assert_eq!(left, 0);
}
