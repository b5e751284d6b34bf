//! A second device pushes: the depth in closed form, verdicts beside those of the device's own push, and how both let go.

use super::*;
use crate::{
    coupler::{COUPLER, COUPLER_REQUIRED, coupler},
    pushed_trial::PushedTrial as _,
    settling::{Settling, TrialVerdict},
    setup::Beside,
    trial::TrialPlan,
    wall::{WallTrial, wall},
};
use haptic_document::{Document, parameters::KeyTable};
use haptic_trial::{
    keys::{drive::DRIVE, trial::PushBy, wall::WALL_TABLES},
    safety::keys::SAFETY,
};
use std::path::Path;
use testkit::{Random, Tested};

const COUPLER_TABLES: [KeyTable; 3] = [
    ("required", COUPLER_REQUIRED),
    ("coupler", COUPLER),
    ("safety", SAFETY),
];

/// Reads the law of a table and its drive, both simulated.
type Of<T> = fn(&Table<'_>, Beside<'_>, [Option<LoopMode>; 2]) -> Result<T, FileError>;

fn of_table<T>(text: &str, kind: &str, keys: &[KeyTable], of: Of<T>) -> Result<T, FileError> {
    let document = Document::of_text(Path::new("lab.toml"), text);
    let document = document.parse()?;
    let (_, table, mut beside) = document.one_of(&[kind], &["drive"], "experiment", kind)?;
    let drive = beside
        .remove("drive")
        .map(|drive| drive.with_keys(&[("drive", DRIVE)]));
    let drive = drive.transpose()?;
    let beside = Beside {
        drive: drive.as_ref(),
        admittance: None,
    };
    of(&table.with_keys(keys)?, beside, [None, None])
}

/// A wall of K, N/m, and B, N·s^μ/m, with further lines of `[wall]` and of `[drive]`.
fn text((mu, k, b): (f64, f64, f64), wall: &str, drive: &str) -> String {
    format!(
        "[wall]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 0.001\norder = {mu:?}\n\
         stiffness_n_per_m = {k:?}\ndissipation_n_s_mu_per_m = {b:?}\n{wall}\n[drive]\n{drive}\n"
    )
}

fn read(text: &str) -> Result<WallTrial, FileError> {
    of_table(text, "wall", WALL_TABLES, wall)
}

fn tried(wall: &WallTrial) -> Settling {
    wall.tried().expect("runs")
}

/// The one device alone, whose own motor makes this push.
fn by_itself(wall: &WallTrial) -> WallTrial {
    let mut alone = wall.clone();
    alone.setup.second = None;
    alone.setup.plan = TrialPlan {
        push_by: PushBy::Device,
        ..wall.setup.plan
    };
    alone
}

/// True if the analysis calls the wall stable on what pushes and is pushed.
fn analysed(wall: &WallTrial) -> bool {
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
fn a_second_device_pushes_a_coupler_as_far_as_both_springs_give() -> Tested {
    let mut random = Random(6912);
    for _ in 0..20 {
        let [spring, ground] = [(); 2].map(|()| random.log_between(200.0, 1000.0));
        let push_n = random.log_between(0.2, 5.0);
        let text = format!(
            "[coupler]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 0.001\norder = 1.0\npush_n = {push_n:?}\n\
             coupler_damping_n_s_per_m = 2.0\ncoupler_spring_n_s_1_minus_mu_per_m = {spring:?}\n\
             object_mass_kg = 0.05\nobject_damping_n_s_per_m = 2.0\nobject_stiffness_n_per_m = {ground:?}\n[drive]\n"
        );
        let coupler = of_table(&text, "coupler", &COUPLER_TABLES, coupler)?;
        let pushed = coupler.tried()?;
        assert_eq!(pushed.verdict, TrialVerdict::Stable, "{pushed:?} {text}");
        let want = push_n * (1.0 / spring + 1.0 / ground);
        let off = (pushed.deflection_m.expect("rests") / want - 1.0).abs();
        assert!(off < 1e-6, "{off} {text}");
        let analysed = coupler
            .judge(5000, coupler.setup.dynamics(), 0)?
            .coupler
            .expect("one");
        assert!((analysed.damping_n_s_per_m - 7.0).abs() < 1e-12, "{text}");
    }
    Ok(())
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
        crate::trial::seen(judge, sample)
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

/// A wall of a tissue, in place of order, K and B.
fn of_tissue(tissue: &str, more: &str) -> Result<WallTrial, FileError> {
    read(&format!(
        "[wall]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 0.001\ntissue = \"{tissue}\"\n{more}\n"
    ))
}

#[test]
fn a_wall_of_a_tissue_is_the_wall_of_its_numbers() -> Tested {
    // A slab of 4 cm² and 20 mm.
    let slab = of_tissue("prostate-healthy", "")?;
    let numbers = (
        slab.order.get(),
        slab.stiffness_n_per_m,
        slab.dissipation_n_s_mu_per_m,
    );
    let piece = slab.tissue.clone().expect("a tissue");
    assert_eq!(
        (numbers.1, numbers.2),
        piece.material.spring_and_damper(0.02)
    );
    let given = read(&text(numbers, "", "")).map(|wall| by_itself(&wall))?;
    let twice = of_tissue("prostate-healthy", "area_m2 = 8e-4")?;
    assert!((twice.dissipation_n_s_mu_per_m / numbers.2 - 2.0).abs() < 1e-12);
    let (a, b) = (tried(&slab), tried(&given));
    assert_eq!((a.verdict, a.largest_pull), (b.verdict, b.largest_pull));
    // Elements in series, with all of their past and with the newest of it.
    for scheme in ["full", "grunwald:500"] {
        let muscle = of_tissue("fish-muscle", &format!("scheme = \"{scheme}\""))?;
        assert!(muscle.model.is_some() && tried(&muscle).stable, "{scheme}");
    }
    Ok(())
}

#[test]
fn a_tissue_and_numbers_of_a_wall_do_not_go_together() {
    for (more, words) in [
        ("order = 0.5", "order has no effect with `tissue`"),
        ("stiffness_n_per_m = 300", "stiffness_n_per_m has no effect"),
        ("scheme = \"muir:3\"", "grunwald:1000"),
        ("contact = \"signed\"", "without stiffness"),
        (
            "loading = \"sphere\"\nindenter_radius_m = 0.005",
            "not linear",
        ),
    ] {
        let refused = of_tissue("fish-muscle", more).expect_err(more).to_string();
        assert!(refused.contains(words), "{more}: {refused}");
    }
    let alone = read(&text((0.5, 300.0, 5.0), "area_m2 = 4e-4", ""));
    let refused = alone.expect_err("no tissue").to_string();
    assert!(
        refused.contains("area_m2 has no effect without `tissue`"),
        "{refused}"
    );
}
