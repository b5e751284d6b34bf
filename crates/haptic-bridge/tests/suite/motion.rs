//! A robot that takes a velocity, in virtual time: what it renders, and that every trouble brings its command to rest and holds it.

use crate::bench::{Bench, WATCHDOG_MS, description, stiff_wall, transaction, wall};
use haptic_bridge::{Bridge, Description, Takes};
use haptic_link::{DeviceReport, EventKind, Field, Guard, GuardKind, Refusal, Request, Start};
use haptic_loop::Fault;
use haptic_trial::robot::RobotModel;
use nalgebra::Vector3;
use std::{f64::consts::TAU, path::Path};
use testkit::Folder;

const ROBOT: &str = "[admittance]\nbandwidth_hz = 10\ndead_time_s = 0.004\nbody_inertance_n_s_mu_per_m = 8\nbody_damping_n_s_per_m = 20\n";
const T: f64 = 1e-3;
/// Limits of the model where its file says none.
const SPEED: f64 = 0.5;
const STEP: f64 = 20.0 * T;
/// Ticks from the largest speed to rest, and one in which a trouble is found.
const STOP: u32 = 26;
/// Ticks at rest before a start.
const REST: u32 = 210;

fn robot(path: &Path, axes: u32) -> Description {
    Description {
        takes: Takes::Velocity {
            robot: path.to_owned(),
        },
        force_max_n: 20.0,
        sensed_force_max_n: 50.0,
        ..description(axes)
    }
}

/// Its device file, in a folder of its own.
fn file(text: &str) -> (Folder, std::path::PathBuf) {
    let folder = Folder::empty();
    let path = folder.join("robot.toml");
    std::fs::write(&path, text).expect("writes");
    (folder, path)
}

/// The robot and a hand: 10 Hz, ζ 0.8, a dead time of 4 ms; the hand has 1 kg, damps and pushes by a constant force on each axis.
struct Plant {
    late: [[f64; 3]; 4],
    velocity: [f64; 3],
    rate: [f64; 3],
    position: [f64; 3],
    push_n: [f64; 3],
}

impl Plant {
    fn new() -> Self {
        Self {
            late: [[0.0; 3]; 4],
            velocity: [0.0; 3],
            rate: [0.0; 3],
            position: [0.0; 3],
            push_n: [0.0; 3],
        }
    }

    /// One sample under this command; the force at the sensor.
    fn step(&mut self, command: [f64; 3]) -> [f64; 3] {
        self.late.rotate_left(1);
        let held = std::mem::replace(&mut self.late[3], command);
        let (omega, fine) = (TAU * 10.0, T / 10.0);
        let mut sensed = [0.0; 3];
        for axis in 0..3 {
            for _ in 0..10 {
                let (v, a) = (self.velocity[axis], self.rate[axis]);
                self.rate[axis] += fine * (omega * omega * (held[axis] - v) - 1.6 * omega * a);
                self.velocity[axis] += fine * self.rate[axis];
                self.position[axis] += fine * self.velocity[axis];
            }
            sensed[axis] = self.push_n[axis] - self.rate[axis] - 10.0 * self.velocity[axis];
        }
        sensed
    }
}

/// A bench that has rested, its plant, and the last command.
struct Pushed {
    bench: Bench,
    plant: Plant,
    axes: usize,
}

impl Pushed {
    fn new(path: &Path, axes: u32) -> Self {
        let mut this = Self {
            bench: Bench::new(&robot(path, axes)),
            plant: Plant::new(),
            axes: axes as usize,
        };
        this.bench.sensed_n = Some([0.0; 3]);
        let (mut configuration, values) = stiff_wall();
        configuration.limits.watchdog_ms = WATCHDOG_MS;
        this.bench.configure(&configuration, &values);
        this
    }

    fn ready(path: &Path, axes: u32) -> Self {
        let mut this = Self::new(path, axes);
        this.steps(REST);
        this.drives(1);
        this
    }

    /// Arms and starts this run.
    fn drives(&mut self, run: u32) {
        self.bench.arm();
        let start = Request::Start(Start {
            run,
            ..Start::ENDLESS
        });
        self.bench.done(start);
    }

    /// One tick, whose command is within its limits.
    fn step(&mut self) {
        let before = self.bench.force_n;
        if self.bench.sensed_n.is_some() {
            self.bench.position_m = self.plant.position;
        }
        let sensed = self.plant.step(before);
        self.bench.sensed_n = Some(sensed);
        self.bench.step();
        self.holds(before);
    }

    fn holds(&self, before: [f64; 3]) {
        let command = self.bench.force_n;
        for axis in 0..3 {
            let change = (command[axis] - before[axis]).abs();
            assert!(
                command[axis].abs() <= SPEED && change <= STEP * (1.0 + 1e-5),
                "{command:?} after {before:?}"
            );
            assert!(axis < self.axes || command[axis] == 0.0);
        }
        assert!(Vector3::from(command).norm() <= SPEED * (1.0 + 1e-6));
    }

    fn steps(&mut self, count: u32) {
        for _ in 0..count {
            self.step();
        }
    }

    fn pushed(&mut self, push_n: f64) {
        self.plant.push_n = std::array::from_fn(|axis| if axis < self.axes { push_n } else { 0.0 });
    }
}

#[test]
fn a_wall_is_exact_at_the_virtual_port_on_one_to_three_axes() {
    let (_folder, path) = file(ROBOT);
    for axes in 1..=3 {
        let mut it = Pushed::ready(&path, axes);
        // The wall is on the first axis; the others go to the end of the workspace.
        it.pushed(3.0);
        it.steps(100);
        // A pause in which the robot goes on as it was told.
        for _ in 0..5 {
            it.plant.step(it.bench.force_n);
        }
        it.bench.time_us += 5_000;
        it.bench.reports.clear();
        it.steps(6000);
        assert_eq!(it.bench.handle.fault(), None);
        let sample = |report: &DeviceReport| {
            if let DeviceReport::Sample(sample) = report {
                Some(sample.clone())
            } else {
                None
            }
        };
        let newest = it.bench.reports.iter().rev().find_map(sample);
        for (axis, at) in newest.expect("samples").axes.iter().enumerate() {
            let (position_m, force_n) = (f64::from(at.position_m), f64::from(at.force_n));
            if axis == 0 {
                assert!(((position_m - 0.01) / 3e-3 - 1.0).abs() < 0.01);
                assert!((force_n / -3.0 - 1.0).abs() < 0.01);
            } else {
                assert!(position_m <= 0.1 && position_m > 0.0999, "{position_m} m");
            }
            assert!((it.plant.position[axis] - position_m).abs() < 1e-5);
        }
        assert_eq!(it.bench.allocations, 0, "allocations in ticks");
    }
}

/// Comes to rest within the stop time of this trouble, and holds for as long again.
fn rests(it: &mut Pushed, fault: Option<Fault>, mut trouble: impl FnMut(&mut Pushed)) {
    for tick in 0..4 * STOP {
        let before = it.bench.force_n;
        trouble(it);
        it.holds(before);
        assert_eq!(it.bench.handle.fault(), fault, "told at once");
        let rests = it.bench.force_n == [0.0; 3];
        assert!(tick < STOP || rests, "{tick}: {:?}", it.bench.force_n);
    }
}

/// A tick of the plant of which the program tells something else.
fn told(it: &mut Pushed, change: impl FnOnce(&mut Bench)) {
    it.bench.position_m = it.plant.position;
    it.bench.sensed_n = Some(it.plant.step(it.bench.force_n));
    change(&mut it.bench);
    it.bench.step();
}

#[test]
fn every_trouble_brings_the_command_to_rest_within_the_stop_time_and_it_stays_there() {
    type Trouble = fn(&mut Pushed);
    let sensor = Some(Fault::ForceSensor);
    let troubles: [(Option<Fault>, Trouble); 10] = [
        (sensor, |it| {
            told(it, |bench| bench.sensed_n = Some([f64::NAN; 3]));
        }),
        (sensor, |it| told(it, |bench| bench.sensed_n = None)),
        (sensor, |it| {
            told(it, |bench| {
                bench.sensed_n = Some([f64::NEG_INFINITY, 0.0, 0.0]);
            });
        }),
        (sensor, |it| {
            told(it, |bench| bench.sensed_n = Some([50.0, 0.0, 0.0]));
        }),
        (Some(Fault::HandForce), |it| {
            told(it, |bench| bench.sensed_n = Some([26.0, 0.0, 0.0]));
        }),
        (Some(Fault::Following), |it| {
            told(it, |bench| bench.position_m[0] += 0.05);
        }),
        (Some(Fault::BoardFailed), |it| {
            told(it, |bench| bench.position_m = [f64::NAN; 3]);
        }),
        // The clock stands.
        (Some(Fault::BoardFailed), |it| {
            it.bench.sensed_n = Some(it.plant.step(it.bench.force_n));
            it.bench.position_m = it.plant.position;
            it.bench.tick_after(0);
        }),
        // The thread stands still, once.
        (Some(Fault::TickOverrun), |it| {
            told(it, |bench| {
                let lives = bench.handle.fault().is_none();
                bench.time_us += if lives { 30_000 } else { 0 };
            });
        }),
        (None, |it| {
            it.bench.handle.stop();
            it.step();
        }),
    ];
    let (_folder, path) = file(ROBOT);
    for axes in 1..=3 {
        for (fault, trouble) in troubles {
            let mut it = Pushed::ready(&path, axes);
            it.pushed(8.0);
            it.steps(150);
            assert!(Vector3::from(it.bench.force_n).norm() > 0.05, "it moves");
            rests(&mut it, fault, trouble);
            // It may be had again once it has rested.
            it.pushed(0.0);
            it.steps(3 * REST);
            it.drives(2);
            it.pushed(-8.0);
            it.steps(100);
            assert!(it.bench.force_n[0] < -0.02, "it moves again");
            it.bench.reports.clear();
            it.bench.done(Request::Disarm);
            let is_over = |report: &DeviceReport| matches!(report, DeviceReport::Event(event) if event.kind == EventKind::Disarmed);
            while !it.bench.reports.iter().any(is_over) {
                it.step();
            }
            assert_eq!(it.bench.force_n, [0.0; 3], "over before it stands");
        }
    }
}

#[test]
fn a_hundred_thousand_hostile_ticks_never_leave_the_limits() {
    hostile_ticks(100_000);
}

#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_a_million_hostile_ticks_never_leave_the_limits() {
    hostile_ticks(1_000_000);
}

/// Sensors that fail or lie, a clock that jumps, a host that goes away: of three axes, at random.
fn hostile_ticks(count: u32) {
    let (_folder, path) = file(ROBOT);
    let mut random = testkit::Random(85);
    let mut it = Pushed::ready(&path, 3);
    let (mut run, mut still, mut moved) = (1, 0, 0);
    // A force that is shown twice, and one that drifts, are no faults: the limits hold all the same.
    let (mut gain, mut drift_n) = (1.0, 0.0);
    for _ in 0..count {
        let before = it.bench.force_n;
        let wild = [f64::NAN, f64::INFINITY, 49.9, -60.0, 1e300][(5.0 * random.share()) as usize];
        let axis = (3.0 * random.share()) as usize;
        let (draw, share) = ((2000.0 * random.share()) as u32, random.share());
        // Calm enough for the next run once it stands.
        if still > 0 {
            (gain, drift_n) = (1.0, 0.0);
        }
        let push = if still > 0 { 0.0 } else { 30.0 * (share - 0.5) };
        told(&mut it, |bench| {
            let sensed = bench.sensed_n.get_or_insert([0.0; 3]);
            sensed[axis] = gain * sensed[axis] + push + drift_n;
            drift_n *= 1.001;
            match draw {
                _ if still > 0 => {}
                0 => sensed[axis] = wild,
                1 => bench.position_m[axis] = wild,
                2 => bench.sensed_n = None,
                3 => bench.time_us += (60_000.0 * share) as u64,
                4 => bench.handle.stop(),
                5 => bench.is_there = false,
                6 => gain = 2.0,
                7 => drift_n = share - 0.5,
                _ => {}
            }
        });
        it.holds(before);
        let stands = it.bench.force_n == [0.0; 3];
        still = if stands { still + 1 } else { 0 };
        moved += u32::from(!stands);
        if still > 500 {
            it.bench.is_there = true;
            (gain, drift_n) = (1.0, 0.0);
            run += 1;
            // Somebody puts it out of the wall.
            it.plant = Plant::new();
            it.steps(5);
            it.drives(run);
            still = 0;
        }
    }
    assert!(
        run > count / 2000 && moved > count / 10,
        "{run} runs, {moved} ticks in motion"
    );
}

#[test]
fn it_is_not_driven_before_its_sensor_has_rested_nor_with_an_offset() {
    let (_folder, path) = file(ROBOT);
    let refused = Err(Refusal::FaultPersists(Fault::ForceSensor.code()));
    let start = |it: &mut Pushed| {
        let started = it.bench.answered(Request::Start(Start::ENDLESS));
        started.map(|_| ())
    };
    let mut it = Pushed::new(&path, 1);
    it.bench.arm();
    assert_eq!(start(&mut it), refused, "too early");
    // 5 % of 50 N are allowed.
    it.pushed(2.6);
    it.steps(2 * REST);
    assert_eq!(start(&mut it), refused, "an offset");
    // What somebody did with the handle long ago is forgotten.
    it.pushed(20.0);
    it.steps(50);
    it.pushed(2.0);
    it.steps(3 * REST);
    assert_eq!(start(&mut it), Ok(()));
    // The offset is no push: nothing moves.
    it.steps(500);
    assert!(it.plant.position[0].abs() < 1e-5);
    assert_eq!(it.bench.handle.fault(), None);
}

#[test]
fn it_says_that_it_moves_and_takes_no_guard() {
    let (_folder, path) = file(ROBOT);
    let mut it = Pushed::new(&path, 1);
    let DeviceReport::Capabilities(can) = it.bench.done(Request::GetCapabilities) else {
        panic!("no abilities");
    };
    assert!(can.lets_go_alone.moves && !can.lets_go_alone.lets_go);
    let (mut configuration, values) = wall();
    configuration.limits.guard = Guard {
        kind: GuardKind::Observer,
        damping_n_s_per_m: 1.0,
        ..Guard::OFF
    };
    let mut answers = transaction(&configuration, &values)
        .into_iter()
        .map(|request| it.bench.answered(request).map(|_| ()));
    let refused = answers.find(Result::is_err).expect("a refusal");
    assert_eq!(refused, Err(Refusal::Unsupported(Field::GuardDamping)));
}

#[test]
fn a_robot_without_bandwidth_and_dead_time_follows_forces_alone_and_shows_its_sensor() {
    let (_folder, path) = file("[admittance]\nmotion_limit_m_per_s2 = 2\n");
    let mut it = Pushed {
        bench: Bench::new(&robot(&path, 1)),
        plant: Plant::new(),
        axes: 1,
    };
    it.bench.sensed_n = Some([0.0; 3]);
    let (mut configuration, values) = wall();
    configuration.limits.force_rate_n_per_s = 150.0;
    it.bench.configure(&configuration, &values);
    let DeviceReport::Capabilities(can) = it.bench.done(Request::GetCapabilities) else {
        panic!("no abilities");
    };
    assert!(can.lets_go_alone.moves && can.lets_go_alone.to_measure);
    // 100 N·s/m at 50 mm/s, and 2 m/s².
    assert!((can.force_max_n - 5.0).abs() < 1e-4 && can.force_rate_max_n_per_s <= 200.0);
    it.steps(REST);
    it.drives(1);
    // A push of the hand moves nothing.
    it.plant.push_n[0] = 5.0;
    it.steps(200);
    assert_eq!(it.bench.force_n, [0.0; 3]);
    // Nor does it follow a hand that pushes hard.
    it.plant.push_n[0] = 13.0;
    it.steps(2);
    assert_eq!(it.bench.handle.fault(), Some(Fault::HandForce));
}

#[test]
fn a_robot_that_cannot_be_is_refused_with_its_key() {
    let (_folder, path) = file(ROBOT);
    let sound = robot(&path, 1);
    assert!(Bridge::apart(&sound).is_ok());
    let words = |description: &Description, wanted: &str| {
        let refused = Bridge::apart(description).map(|_| ());
        let reason = refused.expect_err(wanted).to_string();
        assert!(reason.contains(wanted), "{reason}: no {wanted}");
        assert!(!reason.contains('\n'), "{reason}");
    };
    let unsensed = Description {
        sensed_force_max_n: 0.0,
        ..sound.clone()
    };
    words(&unsensed, "sensed_force_max_n");
    let unmeasured = Description {
        sample_time_us: 0,
        ..sound.clone()
    };
    words(&unmeasured, "sample_time_us");
    let apart = Description {
        workspace_low_m: [0.4; 3],
        workspace_high_m: [0.5; 3],
        ..sound
    };
    words(&apart, "workspace");
    words(
        &robot(Path::new("/nowhere/robot.toml"), 1),
        "/nowhere/robot.toml",
    );
    for key in ["bandwidth_hz", "dead_time_s"] {
        let lines: Vec<&str> = ROBOT
            .lines()
            .filter(|line| !line.starts_with(key))
            .collect();
        let (_folder, path) = file(&lines.join("\n"));
        words(&robot(&path, 1), key);
    }
    let (_folder, path) = file("[device]\nmass_kg = 0.1\ndamping_n_s_per_m = 1\n");
    words(&robot(&path, 1), "[admittance]");
}

#[test]
fn each_body_moves_in_single_precision_as_its_model_does() {
    for more in [
        "",
        "body_order = 0.7\n",
        "body_lag_s = 0.05\n",
        "body_scheme = \"grunwald:100\"\n",
    ] {
        let (_folder, path) = file(&format!("{ROBOT}{more}"));
        let model = std::fs::read_to_string(&path).expect("reads");
        let model = RobotModel::parse(&path, &model, T).expect("a robot");
        let body = model.body.rendered(fracdiff::Seconds(T)).expect("a body");
        let mut history = body.at_rest::<1>();
        let mut it = Pushed::ready(&path, 1);
        for tick in 0..120 {
            let push_n = 0.3 * f64::from(tick % 7);
            told(&mut it, |bench| bench.sensed_n = Some([push_n, 0.0, 0.0]));
            let wanted = body.velocity(&history, &nalgebra::vector![push_n]);
            body.advance(&mut history, &wanted);
            let off = (it.bench.force_n[0] - wanted[0]).abs();
            assert!(
                off < 1e-6,
                "{more}{tick}: {} for {wanted}",
                it.bench.force_n[0]
            );
        }
    }
    let (_folder, path) = file(&format!("{ROBOT}body_scheme = \"grunwald:300\"\n"));
    let refused = Bridge::apart(&robot(&path, 1)).map(|_| ());
    let reason = refused.expect_err("too long").to_string();
    assert!(
        reason.contains("256 taps") && reason.contains("give full"),
        "{reason}"
    );
}
