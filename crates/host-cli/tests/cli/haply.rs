//! A Haply 2DIY: the maker's own host on the emulated board, and this program's experiments on it.

use crate::emulated::Emulated;
use crate::process::{Ended, Place, number, says};
use haptic_devices::haply::Version;
use std::process::Command;
use testkit::skip;

/// An emulated 2DIY in a place, as `2diy`.
fn board(options: &str) -> Emulated {
    Emulated::at_terminal("2diy", &format!("--kind haply-2diy {options}"))
}

/// The maker's host on such a board: what it saw, and what the board said at the end. `None` where it is not installed.
fn makers_host(
    version: Version,
    hand: &str,
    force: [f64; 2],
) -> Option<(serde_json::Value, String)> {
    let number = version.number();
    let mut emulated = board(&format!("hardware={number} hand={hand}"));
    let script = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../tests/conformance/haply_2diy.py"
    );
    let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    let output = Command::new(&python)
        .arg(script)
        .arg(emulated.place.path("2diy"))
        .args([
            number.to_string(),
            force[0].to_string(),
            force[1].to_string(),
        ])
        .arg("2.5")
        .output();
    let missing = match output {
        Ok(output) if output.status.code() == Some(3) => {
            String::from_utf8_lossy(&output.stderr).trim().to_owned()
        }
        Ok(output) => {
            let said = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success() && said.is_empty(), "{said}");
            let seen = serde_json::from_slice(&output.stdout).expect("one JSON object");
            return Some((seen, emulated.ends()));
        }
        Err(error) => format!("{}: {error}", python.display()),
    };
    skip(&missing);
    None
}

/// The numbers before a word.
fn told(said: &str, before: &str, count: usize) -> Vec<f64> {
    let text = said
        .split(before)
        .nth(1)
        .unwrap_or_else(|| panic!("no {before}: {said}"));
    let words = text
        .split([' ', ',', ';'])
        .filter_map(|word| word.parse().ok());
    words.take(count).collect()
}

fn pair(seen: &serde_json::Value, key: &str) -> [f64; 2] {
    [0, 1].map(|i| {
        seen[key][i]
            .as_f64()
            .unwrap_or_else(|| panic!("{key}: {seen}"))
    })
}

/// Where a hand holds the handle, m to the right of the middle and away from the base.
const PLACES_M: [(f64, f64); 3] = [(0.0, 0.09), (-0.03, 0.11), (0.04, 0.06)];

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_makers_own_host_reads_the_place_to_a_count_and_sends_our_torques() {
    // The hand takes its time to lead the handle there, so all at once.
    std::thread::scope(|scope| {
        for version in Version::ALL {
            for place in PLACES_M {
                scope.spawn(move || reads_and_sends(version, place));
            }
        }
    });
}

fn reads_and_sends(version: Version, (x, y): (f64, f64)) {
    let model = version.model();
    let place = [0.5 * model.pantograph.base_m() + x, y];
    let force = [0.3, -0.5];
    let hand = format!("fixed:{}:{}", place[0], place[1]);
    let Some((seen, said)) = makers_host(version, &hand, force) else {
        return;
    };
    assert!(number(&seen, "answers") > 50.0, "{seen}");
    let truth = model.pantograph.angles(place.into()).expect("within reach");
    let angles = pair(&seen, "angles_deg").map(f64::to_radians);
    for joint in 0..2 {
        let count = std::f64::consts::TAU / f64::from(model.joints[joint].counts_per_turn);
        let turn = std::f64::consts::TAU;
        let off = (angles[joint] - truth[joint] + 0.5 * turn).rem_euclid(turn) - 0.5 * turn;
        // Half a count, and the rounding of a float of degrees.
        assert!(
            off.abs() < 0.51 * count,
            "{version:?} {place:?}: {off} of {count}"
        );
    }
    // The same kinematics from the same angles: the maker's cosines of cosines lose some digits.
    let posture = model.pantograph.posture(angles).expect("in order");
    let read = pair(&seen, "place_m");
    assert!(
        (read[0] - posture.hand_m.x).abs() < 1e-9,
        "{seen} {posture:?}"
    );
    assert!(
        (read[1] - posture.hand_m.y).abs() < 1e-9,
        "{seen} {posture:?}"
    );
    let ours = posture.torques(force.into());
    let theirs = pair(&seen, "torques_nm");
    // The maker takes the angle of a far arm by its cosine alone: of the wrong sign where the hand is nearer to the base than
    // an elbow. Ours is that of the golden values there too.
    let elbow = angles
        .iter()
        .fold(0.0_f64, |most, angle| most.max(0.07 * angle.sin()));
    let off = (ours.x - theirs[0]).abs().max((ours.y - theirs[1]).abs());
    let same = posture.hand_m.y > elbow;
    assert_eq!(off < 1e-9, same, "{version:?} {place:?}: {ours} {seen}");
    // At the right motors.
    let made = told(&said, "torques ", 2);
    assert!((made[0] - theirs[0]).abs() < 1e-6, "{seen} {said}");
    assert!((made[1] - theirs[1]).abs() < 1e-6, "{seen} {said}");
}

/// A soft tissue, felt along y, at the slowest rate: four ticks without an answer are a fault, and this machine may be busy.
const RELAX: &str = "relax --device haply:2diy --sample-time 10ms watchdog=1s late_ticks=0 --contact rigid \
                     --duration 3s --out run --overwrite --quiet --json";

/// The report of a run that began; a machine that is too busy to hear the board's first answers in time says so instead.
fn begun(ended: &Ended) -> Option<serde_json::Value> {
    if !ended.stdout.is_empty() {
        return Some(ended.json());
    }
    let complaint = ended.complaint(3, &["haply:2diy"]);
    assert_eq!(complaint, None, "{ended}");
    testkit::skip_for_load(ended.error());
    None
}

/// By the clock a busy machine may make a fault of it, or skip periods. How near the force is to the sum over the motion is held in
/// virtual time, by the tests of `haptic-devices`.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_relaxation_on_a_2diy_ends_well_or_as_a_fault_that_says_why() {
    let mut emulated = board("");
    let ended = emulated.place.run(RELAX);
    let Some(report) = begun(&ended) else {
        return;
    };
    println!("{report}");
    assert_eq!(report["link"]["simulated"], false);
    assert_eq!(report["link"]["board"], "Haply 2DIY v3");
    assert!(number(&report, "peak_force_n") <= 1.5, "{report}");
    let mut check = emulated.place.run("log check run/relax.mcap --json");
    if ended.code == Some(3) {
        println!("this machine was too busy for the emulated board");
        let ended = ended.failed(3);
        says(
            &ended.stderr,
            &["no whole answer for 4 ticks", "may still push"],
        );
    } else {
        let ended = ended.ended_by_the_clock();
        assert!(number(&report, "peak_force_n") > 0.01, "{report}");
        // What is missing in the log is what the run says; answers that come too late are no gap.
        if ended.code == Some(0)
            && number(&check.json(), "stale") > 0.01 * number(&report, "samples")
        {
            check = check.failed(4);
        } else {
            assert_eq!(check.code, ended.code, "{check}");
            check = check.ended_by_the_clock();
        }
    }
    let missing = number(&check.json(), "missing_samples");
    assert_eq!(missing, number(&report, "dropped_samples"), "{check}");
    let said = emulated.ends();
    assert_eq!(told(&said, "torques ", 2), [0.0, 0.0], "{said}");
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_line_that_loses_bytes_is_a_fault_that_says_so_and_no_torque() {
    // A byte in 1000, of 19 a tick: one is lost within some 50 ticks, in the run or while it is opened.
    let mut emulated = board("drop=0.1%");
    let ended = emulated.place.run(RELAX);
    let ended = ended.failed(3);
    if emulated.place.path("run/relax.mcap").exists() {
        assert!(ended.stderr.contains("a byte was lost"), "{ended}");
    } else {
        println!("lost before the run began");
    }
    let said = emulated.ends();
    // The zeros that end it may have lost bytes too: next to nothing then, and never what was there before.
    assert!(
        told(&said, "torques ", 2)
            .iter()
            .all(|torque| torque.abs() < 1e-6),
        "{said}"
    );
}

/// An edge across the way of the hand, at the slowest rate.
const EDGE: &str = "[touch]\nshape = \"plane\"\nnormal = [0.6, 0.8]\nstiffness_n_per_m = 40\ndissipation_n_s_mu_per_m = 5\norder = 0.3\n\
                    force_limit_n = 1\nsample_time_s = 0.01\nduration_s = 3\nmass_kg = 0.1\n";
const BOTH: &str = "--device haply:2diy --loop host watchdog=1s late_ticks=0 max_age_ticks=200 --out run --overwrite \
                    --quiet --json";

/// By the clock a busy machine may make a fault of it, or skip periods. How near the force is to the sum over the depth is held in
/// virtual time, by the tests of `haptic-devices`.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_touch_on_a_2diy_pushes_along_the_normal_and_lets_go_at_the_end() {
    let mut emulated = board("");
    emulated.place.write("edge.toml", EDGE);
    let ended = emulated.place.run(&format!("run edge.toml {BOTH}"));
    let Some(report) = begun(&ended) else {
        return;
    };
    println!("{report}");
    assert_eq!(report["link"]["board"], "Haply 2DIY v3");
    // The arms are lighter in one direction than in another.
    let masses = ["effective_mass_least_kg", "effective_mass_most_kg"];
    let [least, most] = masses.map(|key| number(&report, key));
    assert!(least < 0.1 && 0.1 < most, "{least} to {most} kg");
    if ended.code == Some(3) {
        println!("this machine was too busy for the emulated board");
        let ended = ended.failed(3);
        assert!(
            ended.stderr.contains("no whole answer for 4 ticks"),
            "{ended}"
        );
    } else {
        ended.ended_by_the_clock();
        assert_eq!(report["verdict"], "rendered");
        assert!(number(&report, "peak_force_n") > 0.05, "{report}");
        let table = emulated.place.text("run/touch.csv");
        let mut pushed = 0;
        for row in table.lines().skip(1) {
            let row: Vec<f64> = row
                .split(',')
                .map(|x| x.parse().unwrap_or(f64::NAN))
                .collect();
            let [_, _, _, _, _, x, y, _] = row[..] else {
                panic!("{row:?}");
            };
            // Along the normal, but for the rounding of the wire.
            assert!((0.8 * x - 0.6 * y).abs() < 1e-6, "{row:?}");
            pushed += u32::from(x.hypot(y) > 0.02);
        }
        assert!(pushed > 10, "{pushed}");
    }
    let said = emulated.ends();
    assert_eq!(told(&said, "torques ", 2), [0.0, 0.0], "{said}");
}

#[test]
fn a_box_that_the_arms_do_not_reach_and_axes_that_do_not_fit_are_refused() {
    let place = Place::new();
    place.write(
        "far.toml",
        format!("{EDGE}box_low_m = [-0.05, -0.06]\nbox_high_m = [0.05, 0.1]\n"),
    );
    place.run(&format!("run far.toml {BOTH}")).refused(
        2,
        &["not within reach", "mm, from the middle", "box_high_m"],
    );
    place.write("edge.toml", EDGE);
    let line = BOTH.replace("haply:2diy", "haply:2diy,axis=x");
    place
        .run(&format!("run edge.toml {line}"))
        .refused(2, &["axis and zero choose a line", "leave them away"]);
    place.write("space.toml", "[touch]\naxes = 3\n");
    place
        .run(&format!("run space.toml {BOTH}"))
        .refused(2, &["it has 2 axes, and 3 are asked for"]);
}
