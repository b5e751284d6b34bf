//! A controller holds the indenter: how close it keeps to its way, the tissue judged over the motion that was made, the verdict before.

use super::{Drive, DriveJudge};
use crate::{
    ExperimentFile,
    experiment::{
        bounded_tests::{conducted, defaults},
        indentation::Indentation,
        kind::Experiment as _,
    },
    judge::Report,
};
use fracdiff::Seconds;
use fractional_control::{ControllerSetup, PidParameters};
use haptic_document::Failure;
use haptic_judge::{
    modelled_tissue::ModelledTissue, rendering::IndenterContact, simulated_rig::SimulatedRig,
};
use haptic_loop::{
    Device,
    plant::{HeldRig, RampHold, RigConfig, RigContact, RigDrive},
    units::{Metres, Newtons},
};
use haptic_message::TickMessage;
use haptic_trial::{
    drive_verdict::{DriveVerdict, LoopVerdict},
    simulate::Instrumented as _,
    tick::KeptSample,
};
use nalgebra::Vector1;
use std::{ops::ControlFlow, path::Path};
use testkit::{Folder, Tested, assert_close};

/// Tuned for 1/(0.092s²+4.95s): free, the indenter is 65 g on 3.5 N·s/m; in contact with the renderer twice that; between the two lie
/// 6 dB. 200 rad/s, 60°, flat, 0.003 of a disturbance at 3 rad/s.
const STIFF: PidParameters = PidParameters {
    proportional: 2085.25,
    integral: 68_324.0,
    integral_order: 1.834,
    derivative: 15.652,
    derivative_order: 0.9906,
};

/// The same for 100 rad/s and no wish about disturbances: so soft that it does not lose contact.
const SOFT: PidParameters = PidParameters {
    proportional: 48.96,
    integral: 1798.8,
    integral_order: 0.2551,
    derivative: 21.524,
    derivative_order: 0.8,
};

fn drive(gains: PidParameters) -> Drive {
    Drive {
        name: "test.toml".to_owned(),
        controller: ControllerSetup {
            scheme: "full".parse().expect("a scheme"),
            ..ControllerSetup::new(gains, Seconds(1e-3))
        }
        .into(),
        force_limit_n: 10.0,
        force_limit_reason: None,
        device: None,
    }
}

/// 1 mm of this tissue, held by this drive.
fn held(tissue: &str, drive: Drive, ramp_time_s: f64, duration_s: f64) -> Indentation {
    let library = haptic_tissue::Library::load(None).expect("the built-in one");
    let tissue = ModelledTissue::new(library.find(tissue).expect("known")).expect("a model");
    let ramp = RampHold::new(Metres(1e-3), Seconds(ramp_time_s)).expect("a ramp");
    let mut held = defaults(tissue);
    held.drive = Some(drive);
    (held.load, held.duration_s) = (RigDrive::Position(ramp), duration_s);
    held
}

/// 5 % of the cancerous prostate in 0.5 s.
fn cancerous(drive: Drive, duration_s: f64) -> Indentation {
    held("prostate-cancerous", drive, 0.5, duration_s)
}

/// Runs in a folder of its own.
fn run(folder: &Path, relaxation: &Indentation) -> Result<Report, Failure> {
    let published = conducted(folder, |watched| relaxation.run(watched))?;
    Ok(published.report)
}

/// The largest distance from the way over the last fifth, m, and the last message.
fn wandering(relaxation: &Indentation) -> f64 {
    let mut worst: f64 = 0.0;
    let from = 0.8 * relaxation.duration_s;
    let mut watch = |message: &TickMessage| {
        if message.time_s > from {
            worst = worst.max((message.reference_m[0] - message.indenter_position_m[0]).abs());
        }
        ControlFlow::Continue(())
    };
    relaxation.simulate(&mut watch).expect("runs");
    worst
}

#[test]
fn the_indenter_is_held_on_its_way_and_the_tissue_is_that_of_the_motion_really_made() -> Tested {
    let folder = Folder::empty();
    let report = run(&folder.join("held"), &cancerous(drive(STIFF), 5.0))?;
    let held = &report.results["drive"];
    let names = (&held["controller"], &held["quantity"]);
    assert_eq!(names, (&"test.toml".into(), &"position".into()));
    assert_eq!(held["preflight"]["in_contact"]["stable"], true);
    let number = |key: &str| held[key].as_f64().expect(key);
    // 1 mm in 0.5 s; what a ramp leaves fades on the hold.
    assert!(number("tracking_error_max") < 1e-4, "{held:?}");
    assert!(number("tracking_error_final") < 5e-6, "{held:?}");
    assert!(number("tracking_error_rms") < number("tracking_error_max"));
    assert_eq!(held["saturated_samples"], 0);
    // At rest the drive carries the tissue: mean force of the tissue is that of its motor.
    let peak = number("drive_force_peak_n");
    assert!(peak > report.run.peak_force_n);
    assert!(peak < 2.0 * report.run.peak_force_n + 0.05);
    // The force is that of the full history of the position really recorded.
    let error = report.results["max_relative_error"].as_f64();
    assert!(error.expect("compared") < 1e-5, "{error:?}");
    let log = std::fs::read(&report.run.log)?;
    for key in [
        "drive.file",
        "derivative_order",
        "drive.preflight.in_contact.stable",
    ] {
        let is_logged = log.windows(key.len()).any(|bytes| bytes == key.as_bytes());
        assert!(is_logged, "{key}");
    }
    let csv = std::fs::read_to_string(report.run.csv.as_ref().expect("a table"))?;
    let names = csv.lines().next().unwrap_or_default();
    assert!(
        names.ends_with("indenter_position_m,drive_force_n"),
        "{names}"
    );
    Ok(())
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_verdict_before_the_run_is_what_the_run_shows_at_either_side_of_the_edge() {
    let gains = SOFT;
    let times = |factor: f64| {
        drive(PidParameters {
            proportional: factor * gains.proportional,
            integral: factor * gains.integral,
            derivative: factor * gains.derivative,
            ..gains
        })
    };
    for tissue in ["prostate-cancerous", "fish-muscle"] {
        let relaxation = |drive| held(tissue, drive, 0.1, 2.0);
        let verdict = |drive| {
            let held = relaxation(drive);
            (held.drive_verdict(2001).expect("judged")).expect("a drive")
        };
        let at_home = verdict(times(1.0));
        let edge = at_home
            .in_contact
            .expect("judged")
            .gain_margin
            .expect("an edge");
        // The limit would hide the growth.
        let free = |factor| Drive {
            force_limit_n: 1e6,
            ..times(factor)
        };
        let (below, above) = (free(0.97 * edge), free(1.03 * edge));
        let stable = |drive| verdict(drive).in_contact.expect("judged").stable;
        assert!(stable(below.clone()), "{tissue}");
        assert!(!stable(above.clone()), "{tissue}");
        let (quiet, loud) = (wandering(&relaxation(below)), wandering(&relaxation(above)));
        assert!(quiet < 1e-4, "{tissue}: {quiet}");
        assert!(loud > 1e-3, "{tissue}: {loud}");
    }
}

#[test]
fn an_unstable_drive_is_refused_before_a_file_is_made_unless_it_is_forced() {
    let folder = Folder::empty();
    let gains = PidParameters {
        proportional: 2e5,
        derivative: 500.0,
        ..PidParameters::NONE
    };
    let mut held = cancerous(drive(gains), 2.0);
    let kept_in = folder.join("unstable");
    let refused = run(&kept_in, &held).expect_err("unstable").to_string();
    for words in ["unstable before it touches", "`controller`"] {
        assert!(refused.contains(words), "{refused}");
    }
    assert!(!kept_in.exists());
    held.conduct.force_unstable = true;
    let report = run(&kept_in, &held).expect("runs all the same");
    let held = &report.results["drive"];
    assert_eq!(held["preflight"]["in_contact"]["stable"], false, "{held:?}");
    let saturated = held["saturated_samples"].as_u64();
    assert!(saturated > Some(100), "{held:?}");
    for part in ["limit of 10 N", "unstable"] {
        let warned = report.run.warnings.iter().any(|text| text.contains(part));
        assert!(warned, "{part}: {:?}", report.run.warnings);
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_push_is_held_too_its_force_measured_between_the_actuators() {
    let gains = PidParameters {
        proportional: 0.3,
        integral: 20.0,
        integral_order: 0.9,
        ..PidParameters::NONE
    };
    let mut creep = held("prostate-healthy", drive(gains), 1.0, 3.0);
    creep.load = RigDrive::Force(Newtons(0.04));
    let verdict = (creep.drive_verdict(3001).expect("judged")).expect("a drive");
    assert!(verdict.free.is_none() && verdict.stable(), "{verdict:?}");
    // The tissue has no spring of its own; what holds it in the judgement is named.
    assert!(verdict.holding_stiffness_n_per_m.is_some_and(|k| k > 0.0));
    let (mut force, mut depth) = (0.0, 0.0);
    creep
        .simulate(&mut |sample| {
            (force, depth) = (sample.contact_force_n[0], sample.position_m[0]);
            ControlFlow::Continue(())
        })
        .expect("runs");
    let push = 100.0 * 4e-4;
    assert!((force / push - 1.0).abs() < 0.02, "{force} of {push} N");
    assert!(depth > 1e-5);
}

#[test]
fn a_drive_that_cannot_act_is_refused_with_the_remedy() {
    let gains = STIFF;
    let refused = |change: fn(&mut Indentation), words: &str| {
        let mut held = cancerous(drive(gains), 2.0);
        change(&mut held);
        let sink = &mut |_: &TickMessage| ControlFlow::Continue(());
        let wording = held.simulate(sink).expect_err("refused").to_string();
        assert!(wording.contains(words), "{wording}");
    };
    refused(
        |held| held.contact = IndenterContact::Rigid,
        "`contact` = compliant",
    );
    let weak = |held: &mut Indentation| {
        held.drive.as_mut().expect("a drive").force_limit_n = 0.0;
    };
    refused(weak, "`drive_force_limit_n`");
    let mad = |held: &mut Indentation| {
        let law = PidParameters {
            integral_order: 3.0,
            integral: 1.0,
            ..PidParameters::NONE
        };
        let drive = held.drive.as_mut().expect("a drive");
        drive.controller.setup.law = law.into();
    };
    refused(mad, "test.toml");
    refused(mad, "order of the integral");
    let slow = "made for a sample time of 0.001 s";
    refused(|held| held.actuator.sample_time = Seconds(2e-3), slow);
}

#[test]
fn a_drive_without_a_limit_has_room_for_four_peaks_and_twice_the_friction() -> Tested {
    let folder = Folder::empty();
    let path = |name: &str| folder.join(name);
    let servo = "[pid]\nproportional_gain = 8000\n[loop]\nsample_time_s = 0.001\n";
    std::fs::write(path("servo.toml"), servo)?;
    let body = "[device]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nfriction_n = 0.3\n";
    std::fs::write(path("body.toml"), body)?;
    // A spring of 500 N/m, pressed by 5 % of 20 mm; 1 kPa on 4 cm².
    let relax = "[relax]\ntissue = 'spring'\nstiffness_n_per_m = 500\nstrain = 0.05\n";
    let on_one = "device = 'serial:x'\ndevice_model = 'body.toml'\n[drive]\n";
    let second = "drive_device = 'serial:y'\n";
    for (text, limit_n, reason) in [
        (
            "[creep]\nstress_pa = 1000\n[drive]\n".to_owned(),
            1.6,
            "friction of 0 N",
        ),
        (format!("{relax}[drive]\n"), 2.0, "friction of 0 N"),
        (
            format!("{relax}{on_one}"),
            2.6,
            "peak of 500 mN, twice the friction of 300 mN",
        ),
        // The friction of the other device is not that of the drive.
        (format!("{relax}{on_one}{second}"), 2.0, "friction of 0 N"),
        (
            format!("{relax}{on_one}{second}drive_device_model = 'body.toml'\n"),
            2.6,
            "300 mN",
        ),
        (
            format!("{relax}[drive]\ndrive_force_limit_n = 7\n"),
            7.0,
            "",
        ),
    ] {
        let text = format!("{text}controller = 'servo.toml'\n");
        let file = ExperimentFile::parse(&path("bench.toml"), &text)?;
        let drive = file
            .indentation()
            .expect("one")
            .drive
            .as_ref()
            .expect("a drive");
        assert_close("limit", drive.force_limit_n, limit_n, 1e-9);
        let limit_reason = drive.force_limit_reason.clone().unwrap_or_default();
        assert!(
            limit_reason.contains(reason) && limit_reason.is_empty() == reason.is_empty(),
            "{limit_reason}"
        );
    }
    Ok(())
}

#[test]
fn the_commands_that_are_judged_are_those_that_were_given_bit_for_bit() -> Tested {
    let t = 1e-3;
    let gains: PidParameters = "900+9000/s^0.9+25s^0.9".parse()?;
    let held = Drive {
        name: "own".to_owned(),
        controller: ControllerSetup::new(gains, Seconds(t)).into(),
        force_limit_n: 0.2,
        force_limit_reason: None,
        device: None,
    };
    let stable = LoopVerdict {
        stable: true,
        ..LoopVerdict::default()
    };
    let verdict = DriveVerdict {
        free: None,
        in_contact: Some(stable),
        holding_stiffness_n_per_m: None,
    };
    let ramp = RampHold::new(Metres(1e-3), Seconds(0.05))?;
    for drive in [RigDrive::Position(ramp), RigDrive::Force(Newtons(0.1))] {
        let config = RigConfig::new(drive, RigContact::COMPLIANT, Seconds(t));
        let holder = held.holder(t)?;
        let rig = Box::new(HeldRig::new(config, holder)?);
        let mut rig = SimulatedRig::Held(rig);
        let mut judge = DriveJudge::new(&held, drive, t, Some(verdict), false)?;
        let mut peak: f64 = 0.0;
        for tick in 0..500 {
            let seen = rig.observe();
            let reading = Device::<f64, 1>::read(&mut rig)?;
            let force_n = -300.0 * reading.position_m[0];
            rig.write(testkit::device::safe(Vector1::new(force_n)))?;
            let (_, [_, judged]) = judge.add(&KeptSample {
                tick,
                time_s: reading.time_s,
                position_m: reading.position_m[0],
                force_n,
                applied_force_n: force_n,
                indenter_position_m: seen.indenter_position_m[0],
                contact_force_n: seen.contact_force_n[0],
                sensed_force_n: None,
                limiters: 0,
            });
            let SimulatedRig::Held(held) = &rig else {
                unreachable!()
            };
            assert_eq!(judged.to_bits(), held.drive_force().to_bits(), "{tick}");
            peak = peak.max(judged.abs());
        }
        let report = judge.finish();
        assert_eq!(report.drive_force_peak_n.to_bits(), peak.to_bits());
        // The ramp is steep, and the gain is large for a force: the limit acts at first.
        assert!(report.saturated_samples > 0 && report.saturated_samples <= 500);
    }
    Ok(())
}
