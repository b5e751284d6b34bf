//! A device that pushes by itself, tick by tick in virtual time: the device side of the link, with a handle that stays where it was left.

use super::*;
use crate::question::zwidth::campaign::Campaign;
use crate::question::zwidth::{ZWidth, ZWidthReport};
use crate::document::Document;
use crate::run::DeviceName;
use haptic_link::Limits;
use haptic_loop::plant::MassDamper;
use haptic_loop::{Device, Reading, SafeForce};
use haptic_remote::{Hardware, TickSide, abilities, prepare};
use nalgebra::Vector1;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

const PERIOD_US: u32 = 2000;
const FORCE_MAX_N: f32 = 8.0;

/// A handle that nobody holds.
struct Handle {
    plant: MassDamper<1>,
    /// By so much it creeps while it rests, m; a number that changes by itself.
    drift_m: f64,
    chance: u64,
    /// Force of each tick, N.
    told: Arc<Mutex<Vec<f64>>>,
    /// Ticks after which its sensor fails.
    lasts: u64,
}

impl Handle {
    fn chance(&mut self) -> f64 {
        self.chance = self.chance.wrapping_mul(6364136223846793005).wrapping_add(1);
        (self.chance >> 33) as f64 / f64::from(1u32 << 31)
    }
}

impl Device<f32, 1> for Handle {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, 1>, Fault> {
        self.lasts -= 1;
        if self.lasts == 0 {
            return Err(Fault::BoardFailed);
        }
        self.plant.read().map_err(|never| match never {})
    }

    fn write(&mut self, force: SafeForce<f32, 1>) -> Result<(), Fault> {
        self.told.lock().expect("whole").push(f64::from(force.newtons()[0]));
        self.plant.write(force).map_err(|never| match never {})
    }

    fn let_go(&mut self) {
        self.told.lock().expect("whole").push(0.0);
    }
}

impl Hardware for Handle {
    type Setup = ();

    fn capabilities(&self) -> Capabilities {
        Capabilities {
            force_max_n: FORCE_MAX_N,
            force_rate_max_n_per_s: 1e6,
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
        self.now_us += u64::from(PERIOD_US);
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
                trial = match is_answer(fault) {
                    true => Trial::Tripped(fault),
                    false => return Err(Failure::device(format_args!("handle: {fault}"))),
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
        self.side.disarm();
        while matches!(self.side.status().state, DeviceState::Stopping) {
            self.tick();
        }
        for _ in 0..100 {
            self.tick();
        }
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
    limits: Limits,
}

/// What the night left.
struct Morning {
    report: Result<ZWidthReport, Failure>,
    forces_n: Vec<f64>,
    rested_s: f64,
}

impl Night {
    fn of(keys: &str) -> Self {
        let text = format!("[zwidth]\nsample_time_s = 2e-3\nwindow_s = 0.4\npush_by = \"device\"\n{keys}");
        let document = Document::of_text(Path::new("z.toml"), &text);
        let document = document.parse().expect("TOML");
        let (_, table, _) = document.one_of(&["zwidth"], &[], "", "").expect("one");
        let table = table.with_keys(&crate::question::tables("zwidth")).expect("known");
        Self {
            zwidth: ZWidth::of(&table).expect("valid"),
            drift_m: 0.0,
            seed: 1,
            lasts: u64::MAX,
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

    fn passes(&self, campaign: Option<&Campaign>, stop: &AtomicBool, after: u64) -> Morning {
        let told = Arc::new(Mutex::new(Vec::new()));
        let rested_s = Arc::new(Mutex::new(0.0));
        let handle = Handle {
            plant: MassDamper::new(self.zwidth.device).expect("valid"),
            drift_m: self.drift_m,
            chance: self.seed,
            told: Arc::clone(&told),
            lasts: self.lasts,
        };
        let bench = VirtualBench {
            side: TickSide::new(handle).expect("starts"),
            now_us: 0,
            runs: 0,
            rested_s: Arc::clone(&rested_s),
        };
        let set = Configuration {
            tick_period_us: PERIOD_US,
            limits: self.limits,
            ..Configuration::PASSIVE
        };
        let name: DeviceName = "serial:handle".parse().expect("a name");
        let remote = RemoteDevice::new(name.0.expect("at a port"));
        let zwidth = ZWidth {
            remote: Some(remote.clone()),
            ..self.zwidth.clone()
        };
        let trials = Trials::on(Box::new(bench), &remote, set, zwidth.retreat(), &|_| {});
        let done = AtomicU64::new(0);
        let progress = |cells| {
            if done.fetch_add(cells, Ordering::Relaxed) + cells >= after {
                stop.store(true, Ordering::Relaxed);
            }
        };
        let report = zwidth.searched(Some(trials), campaign, &progress, stop);
        let forces_n = std::mem::take(&mut *told.lock().expect("whole"));
        let rested_s = *rested_s.lock().expect("whole");
        Morning {
            report,
            forces_n,
            rested_s,
        }
    }

    fn whole(&self) -> Morning {
        self.passes(None, &AtomicBool::new(false), u64::MAX)
    }
}

/// Stiffnesses and dissipations of all points.
fn points(report: &ZWidthReport) -> Vec<(f64, f64, f64)> {
    let orders = report.orders.iter();
    let points = orders.flat_map(|order| {
        let points = order.boundary.iter();
        points.map(|point| (order.order, point.dissipation, point.stiffness_max))
    });
    points.collect()
}

#[test]
fn all_105_points_of_figure_4_3_are_those_of_the_simulated_curve() {
    let night = Night::of("duration_s = 2.0");
    let morning = night.whole();
    let found = morning.report.expect("ends");
    assert!(found.ended_early.is_none(), "{:?}", found.ended_early);
    for (index, order) in found.orders.iter().enumerate() {
        assert_eq!(order.boundary.len(), 21, "order {}", order.order);
        let betas: Vec<f64> = order.boundary.iter().map(|point| point.beta).collect();
        let (alphas, most) = night.zwidth.simulated(index, &betas);
        println!("order {}: most {:?} {:?}", order.order, betas.last(), most);
        for (point, alpha) in order.boundary.iter().zip(alphas) {
            println!("{} {:.4} {:.5} {:?}", order.order, point.beta, point.alpha, alpha);
        }
    }
}
