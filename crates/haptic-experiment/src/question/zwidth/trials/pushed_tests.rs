//! A device that pushes by itself, tick by tick in virtual time: the device side of the link, with a handle that stays where it was left.

use super::*;
use crate::question::zwidth::{campaign, retreat};
use haptic_document::Document;
use haptic_emulator::LineFaults;
use haptic_emulator::board::{Body, Emulation, emulate};
use haptic_link::Limits;
use haptic_loop::plant::{MassDamper, MassDamperConfig};
use haptic_loop::units::Seconds;
use haptic_loop::units::{Metres, Newtons};
use haptic_loop::{Device, Reading, SafeForce};
use haptic_question::zwidth::{AtPort, ZWidth, ZWidthReport};
use haptic_remote::serial::Pipe;
use haptic_remote::{Hardware, TickSide, abilities, prepare};
use haptic_run::DeviceName;
use haptic_trial::Sensors;
use nalgebra::Vector1;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use testkit::assert_relative;

const PERIOD_US: u32 = 2000;
const FORCE_MAX_N: f32 = 8.0;

/// A handle that nobody holds.
struct Handle {
    plant: MassDamper<1>,
    /// Distance by which it creeps at most while it rests, m, times a number that changes by itself.
    drift_m: f64,
    chance: u64,
    /// Force of each tick, N.
    sent_n: Arc<Mutex<Vec<f64>>>,
    /// Ticks after which its sensor fails.
    lasts: u64,
    force_max_n: f32,
    /// Step of its encoder, m; 0 for none.
    step_m: f32,
}

impl Handle {
    fn chance(&mut self) -> f64 {
        self.chance = self
            .chance
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1);
        (self.chance >> 33) as f64 / f64::from(1u32 << 31)
    }
}

impl Device<f32, 1> for Handle {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, 1>, Fault> {
        self.lasts = self.lasts.saturating_sub(1);
        if self.lasts == 0 {
            return Err(Fault::BoardFailed);
        }
        let Ok(mut reading) = Device::<f32, 1>::read(&mut self.plant);
        if self.step_m > 0.0 {
            reading.position_m = reading
                .position_m
                .map(|m| (m / self.step_m).round() * self.step_m);
        }
        Ok(reading)
    }

    fn write(&mut self, force: SafeForce<f32, 1>) -> Result<(), Fault> {
        self.sent_n
            .lock()
            .expect("whole")
            .push(f64::from(force.newtons()[0]));
        self.plant.write(force).map_err(|never| match never {})
    }

    fn let_go(&mut self) {
        self.sent_n.lock().expect("whole").push(0.0);
    }
}

impl Hardware for Handle {
    type Setup = ();

    fn capabilities(&self) -> Capabilities {
        Capabilities {
            force_max_n: self.force_max_n,
            force_rate_max_n_per_s: 1e6,
            position_resolution_m: self.step_m,
            ..abilities("handle", 1)
        }
    }

    fn install(&mut self, (): (), _: u32) {}

    fn restart(&mut self) {
        let creep = self.drift_m * (2.0 * self.chance() - 1.0);
        let place = self.plant.position() + Vector1::new(creep);
        self.plant.set_state(place, Vector1::zeros());
    }

    fn idle(&mut self) -> Result<Reading<f32, 1>, Fault> {
        self.read()
    }
}

/// The device side of the link without a line.
struct VirtualBench {
    side: TickSide<Handle>,
    now_us: u64,
    runs: u32,
    rested_s: Arc<Mutex<f64>>,
}

impl VirtualBench {
    fn tick(&mut self) {
        self.now_us += u64::from(self.side.configuration().0.tick_period_us);
        self.side.heard(self.now_us, false);
        self.side.tick(self.now_us);
        while self.side.next_report().is_some() {}
    }
}

impl Bench for VirtualBench {
    fn path(&self) -> String {
        "handle".to_owned()
    }

    fn capabilities(&self) -> Capabilities {
        self.side.hardware().capabilities()
    }

    fn run(
        &mut self,
        configuration: Configuration,
        coefficients: &[f32],
        ticks: u64,
        see: See<'_>,
        _: Warn<'_>,
    ) -> Result<Trial, Failure> {
        let refused = |refusal: Refusal| Failure::bad_input(format_args!("{refusal:?}"));
        let capabilities = self.capabilities();
        let prepared = prepare::<Handle, 1>(configuration, coefficients, &capabilities);
        let prepared = prepared.map_err(refused)?;
        self.side.install(prepared, coefficients).map_err(refused)?;
        self.side.arm(self.side.status().faults).map_err(refused)?;
        self.runs += 1;
        let start = Start {
            run: self.runs,
            ticks: ticks as u32,
            every: 1,
            batch: 1,
        };
        self.side.start(start).map_err(refused)?;
        let mut trial = Trial::Whole;
        for _ in 0..ticks {
            self.tick();
            if let Some(fault) = Fault::from_code(self.side.status().fault) {
                trial = if is_answer(fault) {
                    Trial::Tripped(fault)
                } else {
                    return Err(Failure::device(format_args!("handle: {fault}")));
                };
                break;
            }
            let newest = self.side.newest();
            let (position_m, force_n) = (newest.position_m[0], newest.force_n[0]);
            if !see(newest.tick.into(), position_m.into(), force_n.into()) {
                trial = Trial::Seen;
                break;
            }
        }
        let mut last_n = self.side.newest().force_n[0].abs();
        self.side.disarm();
        for _ in 0..100 {
            self.tick();
            let force_n = self.side.newest().force_n[0].abs();
            assert!(force_n <= last_n, "{force_n} N after {last_n} N");
            last_n = force_n;
        }
        assert!(last_n <= 0.0, "{last_n} N");
        Ok(trial)
    }

    fn rest(&mut self, time_s: f64) {
        *self.rested_s.lock().expect("whole") += time_s;
    }

    fn at_line(&self, failure: Failure) -> Failure {
        failure
    }
}

/// A campaign on an emulated board.
struct Night {
    zwidth: ZWidth,
    /// m.
    drift_m: f64,
    seed: u64,
    lasts: u64,
    force_max_n: f32,
    limits: Limits,
}

/// Report, forces and rests of a night.
struct Morning {
    report: Result<ZWidthReport, Failure>,
    forces_n: Vec<f64>,
    rested_s: f64,
}

fn at_port() -> AtPort {
    AtPort {
        name: "serial:handle".to_owned(),
        calibration: String::new(),
    }
}

impl Night {
    fn of(keys: &str) -> Self {
        let text = format!("[zwidth]\nwindow_s = 0.4\npush_by = \"device\"\n{keys}");
        let text = if keys.contains("sample_time_s") {
            text
        } else {
            text + "\nsample_time_s = 2e-3"
        };
        let document = Document::of_text(Path::new("z.toml"), &text);
        let document = document.parse().expect("TOML");
        let (_, table, _) = document.one_of(&["zwidth"], &[], "", "").expect("one");
        let table = table
            .with_keys(&crate::question::tables("zwidth"))
            .expect("known");
        Self {
            zwidth: ZWidth::of(&table, Some(at_port())).expect("valid"),
            drift_m: 0.0,
            seed: 1,
            lasts: u64::MAX,
            force_max_n: FORCE_MAX_N,
            limits: Limits {
                force_n: 6.0,
                rise_time_s: 0.1,
                workspace_low_m: -0.3,
                workspace_high_m: 0.3,
                workspace_soft_m: 0.05,
                ..Limits::DEFAULT
            },
        }
    }

    /// The device's own settings.
    fn set(&self) -> Configuration {
        Configuration {
            tick_period_us: (1e6 * self.zwidth.device.sample_time.0).round() as u32,
            limits: self.limits,
            ..Configuration::PASSIVE
        }
    }

    /// The search on this bench, which is stopped after so many points.
    fn searched(&self, bench: Box<dyn Bench>, after: u64) -> Result<ZWidthReport, Failure> {
        let name: DeviceName = "serial:handle".parse().expect("a name");
        let remote = RemoteDevice::new(name.0.expect("at a port"));
        // The search knows of it what a device file says.
        let zwidth = ZWidth {
            device: MassDamperConfig {
                friction: Newtons(0.0),
                delay: Seconds(0.0),
                current_lag: Seconds(0.0),
                ..self.zwidth.device
            },
            sensors: Sensors::NONE,
            at_port: Some(at_port()),
            ..self.zwidth.clone()
        };
        let trials = Trials::on(bench, &remote, self.set(), retreat(&zwidth), &|_| {});
        let (done, stop) = (AtomicU64::new(0), AtomicBool::new(false));
        let progress = |cells| {
            if done.fetch_add(cells, Ordering::Relaxed) + cells >= after {
                stop.store(true, Ordering::Relaxed);
            }
        };
        zwidth.searched(Some(&trials), &campaign, &progress, &stop)
    }

    /// Report of a board that is emulated by the clock.
    fn by_the_clock(&self) -> ZWidthReport {
        let (here, far_end) = Pipe::pair();
        let board = Emulation {
            axes: 1,
            body: Some(Body {
                plant: self.zwidth.device,
                encoder_resolution: Metres(self.zwidth.sensors.encoder_resolution_m),
                noise: (Metres(0.0), 0),
            }),
            sensor: None,
            at_handle: None,
            robot: None,
            speed: 1.0,
            faults: LineFaults::default(),
            seed: 1,
            duration: None,
        };
        let over = AtomicBool::new(false);
        let report = std::thread::scope(|scope| {
            scope.spawn(|| emulate(Box::new(far_end), &board, &over));
            let link = SerialLink::to_line(Box::new(here), "board", None);
            let report = link.map_err(Failure::input).and_then(|mut link| {
                (link.set(self.set(), &[0.0])).map_err(Failure::input)?;
                let bench = LinkedBench {
                    link,
                    watchdog: Duration::from_secs(1),
                    told_too_deep: false,
                    runs: 0,
                };
                self.searched(Box::new(bench), u64::MAX)
            });
            over.store(true, Ordering::Relaxed);
            report
        });
        report.expect("ends")
    }

    fn passes(&self, after: u64) -> Morning {
        let sent_n = Arc::new(Mutex::new(Vec::new()));
        let rested_s = Arc::new(Mutex::new(0.0));
        let handle = Handle {
            plant: MassDamper::new(self.zwidth.device).expect("valid"),
            drift_m: self.drift_m,
            chance: self.seed,
            sent_n: Arc::clone(&sent_n),
            lasts: self.lasts,
            force_max_n: self.force_max_n,
            step_m: self.zwidth.sensors.encoder_resolution_m as f32,
        };
        let bench = VirtualBench {
            side: TickSide::new(handle).expect("starts"),
            now_us: 0,
            runs: 0,
            rested_s: Arc::clone(&rested_s),
        };
        let report = self.searched(Box::new(bench), after);
        let forces_n = std::mem::take(&mut *sent_n.lock().expect("whole"));
        let rested_s = *rested_s.lock().expect("whole");
        Morning {
            report,
            forces_n,
            rested_s,
        }
    }

    fn whole(&self) -> Morning {
        self.passes(u64::MAX)
    }

    /// The edge of the simulated device at 1, 0.95 and 1.05 times this dissipation.
    fn edges(&self, index: usize, beta: f64) -> [Option<f64>; 3] {
        let never = AtomicBool::new(false);
        [1.0, 0.95, 1.05].map(|scale| self.zwidth.simulated(index, scale * beta, 0, &never))
    }
}

impl Morning {
    fn found(self) -> ZWidthReport {
        let found = self.report.expect("ends");
        assert!(found.ended_early.is_none(), "{:?}", found.ended_early);
        found
    }
}

/// Holds each point against the simulated curve: made weaker by 5 % in K, or in K and B together, it is below, made stronger above.
fn follow_the_simulated_curve(keys: &str, points: usize) {
    let night = Night::of(keys);
    let found = night.whole().found();
    let mut seen = 0;
    for (index, order) in found.orders.iter().enumerate() {
        for point in &order.boundary {
            let [at, weaker, stronger] = night.edges(index, point.beta);
            let below = |edge: Option<f64>, scale: f64| {
                edge.is_some_and(|edge| scale * point.alpha <= edge)
            };
            let in_k = below(at, 0.95) && !below(at, 1.05);
            let in_both = below(weaker, 0.95) && !below(stronger, 1.05);
            let order = order.order;
            assert!(in_k || in_both, "order {order}: {point:?}, {at:?}");
            seen += 1;
        }
    }
    assert_eq!(seen, points);
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn fifteen_points_are_those_of_the_simulated_curve() {
    follow_the_simulated_curve("orders = [0, 1, 2]\npoints = 5", 15);
}

#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_all_105_points_of_figure_4_3_are_those_of_the_simulated_curve() {
    follow_the_simulated_curve("", 105);
}

#[test]
fn a_specimen_on_the_device_is_as_large_as_the_simulated_one() {
    for tissue in ["fish-muscle", "liver"] {
        let night = Night::of(&format!("tissue = \"{tissue}\""));
        let scale = |report: &ZWidthReport| report.scales.expect("some").largest_scale;
        let never = AtomicBool::new(false);
        let simulated = night.zwidth.searched(None, &campaign, &|_| {}, &never);
        let simulated = scale(&simulated.expect("ends"));
        let morning = night.whole();
        assert!(morning.forces_n.iter().all(|force| *force <= 6.0));
        // A specimen that grows too large swings up to the limit after a tap, which ends its trial.
        let limited = (morning.forces_n.iter()).filter(|force| force.abs() >= 6.0);
        let limited = limited.count() as u64;
        let found = morning.found();
        assert!(limited <= 2 * found.runs, "{limited}");
        assert_relative(tissue, scale(&found), simulated, 0.05);
        // Somebody pushes each.
        assert!(found.runs < 25, "{}", found.runs);
    }
}

/// No push takes the device beyond a limit, with any push and however far the handle creeps between two trials; it comes back by itself,
/// and its motor stays as cool as if it always held half its largest force.
#[test]
fn nobody_is_needed_whatever_the_push_and_the_drift() {
    let mut random = testkit::Random(69);
    for seed in 0..testkit::cases(6) {
        let push = random.between(0.3, 5.5);
        let mut night = Night::of(&format!(
            "orders = [{}]\npoints = 2\nduration_s = 1.0\npush_n = {push}",
            random.between(0.0, 2.0)
        ));
        night.seed = seed as u64;
        night.drift_m = random.between(0.0, 2e-3);
        let morning = night.whole();
        let forces = &morning.forces_n;
        let most = forces
            .iter()
            .fold(0.0, |most: f64, force| most.max(force.abs()));
        assert!(most <= f64::from(night.limits.force_n), "{seed}: {most} N");
        assert!(most > 0.9 * push, "{seed}: {most} N of {push} N");
        let t = 1e-6 * f64::from(PERIOD_US);
        let heat: f64 = forces.iter().map(|force| force * force * t).sum();
        let rms_n = (heat / (forces.len() as f64 * t + morning.rested_s)).sqrt();
        assert!(rms_n <= 0.5 * f64::from(FORCE_MAX_N), "{seed}: {rms_n} N");
        let found = morning.found();
        assert_eq!(
            (
                found.push_by,
                found.rise_time_s,
                found.orders[0].boundary.len()
            ),
            ("device", Some(0.1), 2),
            "{seed}"
        );
    }
}

#[test]
fn a_push_that_heats_the_motor_is_followed_by_a_rest() {
    let mut night = Night::of("orders = [1]\npoints = 2\nduration_s = 1.0\npush_n = 5.9");
    night.force_max_n = 6.2;
    assert!(night.whole().rested_s > 0.0);
    night = Night::of("orders = [1]\npoints = 2\nduration_s = 1.0\npush_n = 0.5");
    assert!(night.whole().rested_s <= 0.0);
}

/// Points of a device, nearly to the last digit: of each order all but the last, which is at the very edge.
fn alphas(report: &ZWidthReport) -> Vec<f64> {
    let points = report.orders.iter();
    let points = points.flat_map(|order| &order.boundary[..order.boundary.len() - 1]);
    points.map(|point| (1e9 * point.alpha).round()).collect()
}

#[test]
fn a_search_that_was_stopped_or_whose_device_was_lost_goes_on_where_it_was() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut night = Night::of("orders = [0.5, 1]\npoints = 4\nduration_s = 1.0");
    let whole = night.whole().found();
    let ticks = night.whole().forces_n.len() as u64;
    for (lasts, after) in [(u64::MAX, 3), (ticks / 2, u64::MAX)] {
        let path = folder.path().join(format!("{after}.jsonl"));
        (night.lasts, night.zwidth.campaign) = (lasts, Some(path.clone()));
        let cut = night.passes(after).report.expect("some points");
        night.lasts = u64::MAX;
        let why = cut.ended_early.expect("a reason").to_string();
        assert_eq!(why == "interrupted", after == 3, "{why}");
        let kept = cut
            .orders
            .iter()
            .map(|order| order.boundary.len())
            .sum::<usize>();
        assert!((1..8).contains(&kept), "{kept}");
        // Switched off in the middle of a line.
        let text = std::fs::read_to_string(&path).expect("text");
        std::fs::write(&path, format!("{text}{{\"point\":[1,")).expect("written");
        let resumed = night.whole().found();
        assert_eq!(alphas(&resumed), alphas(&whole));
        assert!(
            resumed.runs < whole.runs,
            "{} of {}",
            resumed.runs,
            whole.runs
        );
        // Nothing is left to try.
        let again = night.whole();
        assert!(again.forces_n.is_empty());
        assert_eq!(alphas(&again.found()), alphas(&whole));
    }
}

#[test]
fn a_file_of_another_search_is_refused_and_stays_as_it_is() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("campaign");
    for (text, words) in [
        (
            "{\"campaign\":\"other\"}\n",
            "is not of this search (line 1)",
        ),
        ("notes of mine\n", "is not of this search (line 1)"),
        ("notes of mine", "is not of this search (line 1)"),
        ("", "is not of this search (line 1)"),
        (
            "{\"campaign\":\"this\"}\n{\"point\":[0,1]}\nmine",
            "line 2, is not of a search",
        ),
    ] {
        std::fs::write(&path, text).expect("written");
        let error = campaign(&path, "this").expect_err(text).to_string();
        assert!(
            error.contains(words) && error.contains("`campaign`"),
            "{error}"
        );
        assert_eq!(std::fs::read_to_string(&path).expect("text"), text);
    }
    let error = campaign(folder.path(), "this").expect_err("a folder");
    assert!(!error.to_string().contains('\n'), "{error}");
}

/// The n-th device as people have them: friction up to 0.3 N, an encoder, a delay; the force rises in 5 ms to 1 s. The first three are
/// devices of the guide, with a board's own rise.
fn drawn(random: &mut testkit::Random, n: usize, keys: &str) -> Night {
    let t = [5e-4, 1e-3, 2e-3][random.between(0.0, 3.0) as usize];
    let mass = random.log_between(0.03, 0.4);
    let friction = 0.3 * random.between(0.0, 1.0).powi(2);
    // A step of the encoder makes at most 0.05 N through the stiffest damper.
    let step_m = [0.0, 0.05, 0.5][random.between(0.0, 3.0) as usize] * 0.1 * t * t / mass;
    let drawn = format!(
        "sample_time_s = {t}\nmass_kg = {mass}\ndamping_n_s_per_m = {}\nfriction_n = {friction}\ndelay_s = {}\n\
         encoder_resolution_m = {step_m}",
        mass * random.log_between(6.0, 60.0),
        t * [0.0, 0.5, 1.0, 1.5][random.between(0.0, 4.0) as usize],
    );
    let laboratory =
        "friction_n = 0.05\ndelay_s = 0.0005\ncurrent_lag_s = 0.001\nencoder_resolution_m = 1e-6";
    let guide = [laboratory, "friction_n = 0.01", ""];
    let guide = guide.get(n);
    let device = guide.map_or(drawn, |keys| format!("sample_time_s = 0.001\n{keys}"));
    let mut night = Night::of(&format!("{device}\norders = [1]\n{keys}"));
    let (rise, force) = (random.between(0.0, 4.0) as usize, random.between(2.0, 8.0));
    night.limits = Limits {
        force_n: guide.map_or(force as f32, |_| 4.0),
        rise_time_s: guide.map_or([0.005, 0.1, 0.5, 1.0][rise], |_| 0.5),
        force_rate_n_per_s: guide.map_or(1e6, |_| 1e3),
        workspace_low_m: -0.04,
        workspace_high_m: 0.04,
        workspace_soft_m: 0.005,
        ..night.limits
    };
    night
}

/// Where the tap can be 25 times the friction, the edge is that of the simulated device without friction; elsewhere it is that, or said to be
/// held by friction with that device's edge beside it; and nothing beyond that edge is called stable. Counts the points where the tap is large,
/// and those of them that are near the edge.
fn end_where_they_would_without(night: &Night, found: &ZWidthReport) -> [u32; 2] {
    let device = &night.zwidth.device;
    let friction = device.friction.0;
    let [force, stuck] = [night.limits.force_n, night.limits.stuck_force_n].map(f64::from);
    // A larger step looks like a sensor that is stuck.
    let is_large = (0.75 * force).min(force - 1.0).min(0.9 * stuck) >= 25.0 * friction;
    let mut smooth = Night::of("");
    smooth.zwidth = night.zwidth.clone();
    smooth.zwidth.device.friction = Newtons(0.0);
    let mut near = 0;
    let points = &found.orders[0].boundary;
    for point in points {
        // Of K, and of K and B together.
        let edges = smooth.edges(0, point.beta);
        let [at, weaker, stronger] = edges.map(|edge| edge.unwrap_or(0.0));
        let (alpha, held) = (point.alpha, point.held_by_friction_up_to_n_per_m.is_some());
        let told = format!("{device:?}: {point:?}, {at}");
        assert!(0.95 * alpha <= at.max(weaker), "{told}");
        // Just beyond the largest dissipation the simulated device has no stable wall.
        let simulated = point.simulated_without_friction_n_per_m;
        assert!(
            !held || simulated.is_some() || at.min(stronger) <= 0.0,
            "{told}"
        );
        // A wall is held if one a tenth stiffer rests, and found within 0.8 %.
        assert!(held || 1.11 * alpha > at.min(stronger), "{told}");
        println!("{told}");
        near += u32::from(is_large && 1.05 * alpha > at.min(stronger));
    }
    [if is_large { points.len() as u32 } else { 0 }, near]
}

#[test]
fn a_night_on_a_device_with_friction_ends_where_it_would_without() {
    let mut random = testkit::Random(82);
    let (mut large, mut near) = (0, 0);
    for n in 0..testkit::cases(4).min(60) {
        let night = drawn(&mut random, n, "points = 3");
        let found = end_where_they_would_without(&night, &night.whole().found());
        (large, near) = (large + found[0], near + found[1]);
    }
    println!("{near} of {large} points near the edge");
    assert!(10 * near >= 9 * large, "{near} of {large}");
}

/// Twenty of them side by side.
#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_a_night_by_the_clock_ends_where_it_would_without_friction() {
    let mut random = testkit::Random(82);
    let nights = (0..testkit::cases(20)).map(|n| drawn(&mut random, n, "points = 2"));
    let nights: Vec<Night> = nights.collect();
    std::thread::scope(|scope| {
        for night in &nights {
            scope.spawn(|| end_where_they_would_without(night, &night.by_the_clock()));
        }
    });
}
