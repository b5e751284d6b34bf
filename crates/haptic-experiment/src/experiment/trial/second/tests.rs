//! A second device pushes: the depth in closed form, verdicts beside those of the device's own push, how both let go, and what is refused.

use super::*;
use crate::experiment::bounded_tests::conducted;
use crate::experiment::coupler::CouplerExperiment;
use crate::experiment::kind::Experiment;
use crate::experiment::trial::Trial as _;
use crate::experiment::wall::WallExperiment;
use crate::open::ExperimentFile;
use haptic_judge::settling::{Settling, TrialVerdict};
use haptic_trial::keys::trial::PushBy;
use serde_json::json;
use std::path::Path;
use testkit::{Folder, Random};

/// A wall of K, N/m, and B, N·s^μ/m, with further lines of `[wall]` and of `[drive]`.
fn text((mu, k, b): (f64, f64, f64), wall: &str, drive: &str) -> String {
    format!(
        "[wall]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 0.001\norder = {mu:?}\n\
         stiffness_n_per_m = {k:?}\ndissipation_n_s_mu_per_m = {b:?}\n{wall}\n[drive]\n{drive}\n"
    )
}

fn read(text: &str) -> Result<WallExperiment, String> {
    read_as(text)
}

fn read_as<T: Experiment + Clone>(text: &str) -> Result<T, String> {
    let file = ExperimentFile::parse(Path::new("lab.toml"), text);
    let file = file.map_err(|error| error.to_string())?;
    Ok(file.of::<T>().expect("of this kind").clone())
}

fn tried(wall: &WallExperiment) -> Settling {
    wall.tried().expect("runs")
}

/// The one device alone, whose own motor makes this push.
fn by_itself(wall: &WallExperiment) -> WallExperiment {
    let mut alone = wall.clone();
    alone.setup.second = None;
    alone.setup.plan = TrialPlan {
        push_by: PushBy::Device,
        ..wall.setup.plan
    };
    alone
}

/// True if the analysis calls the wall stable on what pushes and is pushed.
fn analysed(wall: &WallExperiment) -> bool {
    let verdict = wall.judge(5000, wall.setup.dynamics(), 0);
    verdict.expect("judges").stable
}

/// Balance at rest: the force between both, the push and the wall's are one: x = F/K of a damper, F/(K + B) of a spring; other orders creep there
/// for longer than the trial lasts. Walls within half the region of the one device alone are stable for both pushers, walls beyond twice that of
/// both as one body for neither.
#[test]
fn a_second_device_comes_to_rest_at_the_push_over_the_stiffness_and_is_judged_as_the_own_motor_is()
{
    let mut random = Random(6902);
    let (mut stable, mut unstable, mut rested) = (0, 0, 0);
    while rested < 10 || stable < 20 || unstable < 20 {
        let mu = if random.chance(0.5) {
            random.between(0.0, 1.4)
        } else {
            f64::from(random.chance(0.5))
        };
        let k = random.log_between(200.0, 6e4);
        let b = random.between(0.0, 4.0);
        let push_n = random.log_between(0.2, 5.0);
        let at = |scale: f64| {
            let law = (mu, scale * k, scale * b);
            read(&text(law, &format!("push_n = {push_n:?}"), "")).expect("good")
        };
        let wall = at(1.0);
        let single = by_itself(&wall);
        let [within, beyond] = [by_itself(&at(2.0)), at(0.5)];
        if analysed(&within) && analysed(&wall) {
            let pushed = tried(&wall);
            assert_eq!(pushed.verdict, TrialVerdict::Stable, "{pushed:?} {wall:?}");
            assert_eq!(tried(&single).verdict, pushed.verdict, "{wall:?}");
            let want = match mu {
                0.0 => push_n / (k + b),
                1.0 => push_n / k,
                _ => f64::NAN,
            };
            // The window begins after 4.6 s: what is left of the motion is below 1e-6 of it.
            let off = (pushed.deflection_m.expect("rests") / want - 1.0).abs();
            assert!(off.is_nan() || off < 1e-6, "{off} {wall:?}");
            rested += u32::from(!off.is_nan());
            stable += 1;
        } else if !analysed(&beyond) && !analysed(&by_itself(&beyond)) {
            let pushed = tried(&wall);
            assert!(!pushed.stable, "{pushed:?} {wall:?}");
            assert_eq!(tried(&single).verdict, pushed.verdict, "{wall:?}");
            unstable += 1;
        }
    }
}

/// x = F/k + F/K of the object: the spring of the coupler and that of the object bear the push one after the other. The analysis has the damping
/// of both devices.
#[test]
fn a_second_device_pushes_a_coupler_as_far_as_both_springs_give() {
    let mut random = Random(6912);
    for _ in 0..20 {
        let [spring, ground] = [(); 2].map(|()| random.log_between(200.0, 1000.0));
        let push_n = random.log_between(0.2, 5.0);
        let text = format!(
            "[coupler]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 0.001\norder = 1.0\npush_n = {push_n:?}\n\
             coupler_damping_n_s_per_m = 2.0\ncoupler_spring_n_s_1_minus_mu_per_m = {spring:?}\n\
             object_mass_kg = 0.05\nobject_damping_n_s_per_m = 2.0\nobject_stiffness_n_per_m = {ground:?}\n[drive]\n"
        );
        let coupler: CouplerExperiment = read_as(&text).expect("good");
        let pushed = coupler.tried().expect("runs");
        assert_eq!(pushed.verdict, TrialVerdict::Stable, "{pushed:?} {text}");
        let want = push_n * (1.0 / spring + 1.0 / ground);
        let off = (pushed.deflection_m.expect("rests") / want - 1.0).abs();
        assert!(off < 1e-6, "{off} {text}");
        let analysed = coupler.look().expect("judges").coupler.expect("one");
        assert!((analysed.damping_n_s_per_m - 7.0).abs() < 1e-12, "{text}");
    }
}

/// Ticks of the run, the first swing in the last of them.
#[test]
fn the_first_swing_ends_the_trial() {
    let wall = read(&text((1.0, 2e5, 0.0), "", "")).expect("good");
    let mut parts = wall.parts().expect("good");
    let mut ticks = 0;
    let judge = &mut parts.judge;
    let mut engaged = parts.controller.engage(&mut parts.device);
    let Ok(_) = engaged.run(parts.samples, |sample| {
        ticks += 1;
        haptic_judge::trial::seen(judge, sample)
    });
    assert!(ticks < 100, "{ticks}");
    let settling = judge.settling(false, None);
    assert_eq!(settling.verdict, TrialVerdict::Unstable);
    let why = settling.reason().expect("a reason");
    assert!(why.ends_with("what followed was not judged"), "{why}");
    // It holds 1 N with at most twice that.
    assert!(settling.peak_force_n > 2.0, "{settling:?}");
}

/// Whatever ends it, a stop or a fault of either device, both forces fall and stay at zero.
#[test]
fn both_devices_let_go_after_a_stop_and_after_a_fault_of_either() {
    let soft = (1.0, 50.0, 1.0);
    let near = "workspace_low_m = -0.01\nworkspace_high_m = 0.01";
    for (case, first, second) in [
        ("stop", "", ""),
        ("both", near, near),
        ("first", near, ""),
        ("second", "", near),
    ] {
        // Forces that fall over ticks.
        let limited = |limits| format!("force_rate_limit_n_per_s = 100.0\n{limits}");
        let [wall, of_second] =
            [first, second].map(|limits| read(&text(soft, &limited(limits), "")).expect("good"));
        let mut parts = wall.parts().expect("good");
        if let Pushed::Pair(pair) = parts.device.device_mut() {
            pair.pusher.chain = of_second.setup.chain().expect("good");
        }
        let mut world = PushedLoop::new(&mut parts.controller, &mut parts.device);
        let mut ended_at = None;
        let mut before = [f64::INFINITY; 2];
        for tick in 0..5000 {
            let message = world.tick();
            let Pushed::Pair(pair) = world.0.device() else {
                panic!("a pair");
            };
            let second_n = pair.world.commanded(FacingSide::Indenter);
            let forces = [message.applied_force_n[0].abs(), second_n];
            if let Some(from) = ended_at
                && tick > from
            {
                let grows = forces.iter().zip(before).any(|(now, before)| *now > before);
                assert!(!grows, "{case} {tick}: {forces:?} {before:?}");
            }
            before = forces;
            if case == "stop" && tick == 20 {
                world.stop();
                ended_at = Some(tick);
            }
            if world.ended().is_some() && ended_at.is_none() {
                assert!(before.iter().sum::<f64>() > 1.0, "{case}: {before:?}");
                ended_at = Some(tick);
            }
            if ended_at.is_some() && world.is_at_rest() {
                break;
            }
        }
        assert!(ended_at.is_some() && world.is_at_rest(), "{case}");
        assert!(before.iter().all(|force| *force == 0.0), "{case}");
    }
}

#[test]
fn the_report_names_the_second_device_and_the_log_has_the_force_between_both() {
    let folder = Folder::empty();
    let wall = read(&text((1.0, 1000.0, 2.0), "duration_s = 2.0", "")).expect("good");
    let ran = conducted(&folder, |watched| wall.recorded(watched)).expect("runs");
    let (report, _) = wall.report(&ran).expect("judges");
    let law = json!(report.law);
    assert_eq!(law["push_by"], "second_device", "{law}");
    assert_eq!(law["push_n"], 1.0, "{law}");
    let margin_of = law["preflight_reason"].to_string();
    assert!(
        margin_of.contains("both devices as one body"),
        "{margin_of}"
    );
    let last = ran.record.whole.as_deref().and_then(<[_]>::last);
    let last = last.expect("kept");
    assert!((last.contact_force_n - 1.0).abs() < 1e-6, "{last:?}");
    assert!((last.force_n + 1.0).abs() < 1e-6, "{last:?}");
    assert_eq!(wall.metadata()["impact_m_per_s"], "0");
    let csv = std::fs::read_to_string(folder.join("run.csv")).expect("a table");
    let (names, rows) = csv.split_once('\n').expect("rows");
    assert!(
        names.ends_with(",indenter_position_m,drive_force_n"),
        "{names}"
    );
    // The push from the first sample on; in the end the contact gives by the push over its stiffness.
    let mut last = [0.0; 5];
    for row in rows.lines() {
        let mut values = row
            .split(',')
            .map(|value| value.parse::<f64>().expect("a number"));
        last = std::array::from_fn(|_| values.next().expect("a column"));
        assert!((last[4] - 1.0).abs() < 1e-12, "{row}");
    }
    assert!((last[3] - last[1] - 1e-5).abs() < 1e-9, "{last:?}");
}

#[test]
fn a_push_that_a_second_device_cannot_make_is_refused_in_one_line() {
    let law = (1.0, 1000.0, 2.0);
    for (wall, drive, words) in [
        ("push_by = 'device'", "", "push_by"),
        ("impact_m_per_s = 0.1", "", "from rest"),
        ("device = 'serial:x'", "", "give `drive_device`"),
        (
            "device = 'serial:x'",
            "drive_device = 'serial:x'",
            "may be the same device",
        ),
        (
            "device = 'serial:x'",
            "drive_device = 'serial:y'\ncontact_damping_n_s_per_m = 1.0",
            "contact_damping_n_s_per_m has no effect",
        ),
        ("", "controller = 'c.toml'", "controller"),
        ("", "drive_device = 'serial:y'", "both devices of a drive"),
        ("", "drive_loop = 'host'", "drive_loop"),
        (
            "push_n = 2.0",
            "drive_force_limit_n = 1.5",
            "drive_force_limit_n = 1.5 N is below the push of 2 N",
        ),
        ("", "contact_stiffness_n_per_m = 0.0", "contact stiffness"),
        ("", "drive_device_model = 'none.toml'", "none.toml"),
    ] {
        let error = read(&text(law, wall, drive)).expect_err(words);
        assert!(error.contains(words), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
    let touch = "[touch]\n[drive]\n";
    let error = ExperimentFile::parse(Path::new("lab.toml"), touch).expect_err("no drive");
    assert!(error.to_string().contains("not [touch]"), "{error}");
}
