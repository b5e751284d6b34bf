//! A robot in its own ticks: what it renders, that silence stops it, and that one without a body follows forces alone.

use super::*;
use haptic_link::{Configuration, LoopMode, OperatorForm, OperatorShape, Start, State};
use haptic_loop::{
    plant::{RobotHand, RobotLoop},
    units::{
        Hertz, Metres, MetresPerSecond, MetresPerSecondSquared, NewtonSecondsPerMetre, Newtons,
        Seconds,
    },
};
use haptic_remote::{TickSide, prepare};

const PUSH_N: f32 = 3.0;
/// Ticks from the largest speed to rest, and some.
const STOP: u64 = 30;

fn emulated(body: bool) -> EmulatedRobot {
    let motion = RobotLoop::second_order(Hertz(10.0), 0.8).expect("a loop");
    let t = Seconds(1e-3);
    let (speed, acceleration) = (MetresPerSecond(0.5), MetresPerSecondSquared(20.0));
    let ends = [[Metres(-0.1)], [Metres(0.1)]];
    EmulatedRobot {
        robot: SimulatedRobotConfig {
            dead_time: Seconds(4e-3),
            ..SimulatedRobotConfig::of(t, motion, RobotHand::relaxed())
        },
        body: body.then(|| {
            let damping = NewtonSecondsPerMetre(60.0);
            VirtualBody::new(0.0, damping, DeviceOperator::SILENT).expect("a damper")
        }),
        limits: MotionLimits::of(speed, acceleration, ends[0], ends[1], Newtons(50.0)),
    }
}

struct Bench {
    device: TickSide<MovingBoard>,
    now_us: u64,
}

impl Bench {
    /// A board with a wall of 1 kN/m at 0, whose hand pushes.
    fn new(body: bool, loop_mode: LoopMode) -> Self {
        let board = MovingBoard::new("robot", &emulated(body)).expect("a robot");
        let mut device = TickSide::new(board).expect("starts");
        let mut configuration = Configuration {
            loop_mode,
            stiffness_n_per_m: 1000.0,
            operator: OperatorShape {
                form: OperatorForm::Taps,
                integer: 0,
                count: 1,
            },
            simulation: Simulation {
                push_n: PUSH_N,
                ..Simulation::TESTBED
            },
            ..Configuration::PASSIVE
        };
        let can = device.hardware().capabilities();
        let limits = &mut configuration.limits;
        limits.force_n = 20_f32.min(can.force_max_n);
        limits.force_rate_n_per_s = 1e4_f32.min(can.force_rate_max_n_per_s);
        (limits.watchdog_ms, limits.max_age_ticks) = (100, 20);
        let prepared = prepare::<MovingBoard, 1>(configuration, &[0.0], &can);
        device
            .install(prepared.expect("good"), &[0.0])
            .expect("idle");
        let mut bench = Self { device, now_us: 0 };
        bench.ticks(450, |_| ());
        bench
    }

    fn start(&mut self, run: u32) {
        self.device.heard(self.now_us, true);
        let faults = self.device.status().faults;
        self.device.arm(faults).expect("rests");
        let start = Start {
            run,
            ..Start::ENDLESS
        };
        self.device.start(start).expect("rests");
    }

    fn ticks(&mut self, count: u64, mut each: impl FnMut(&mut Self)) {
        for _ in 0..count {
            self.now_us += 1000;
            self.device.tick(self.now_us);
            each(self);
        }
    }

    fn hear(&mut self) {
        self.device.heard(self.now_us, true);
    }
}

#[test]
fn a_wall_is_exact_at_the_command_and_the_robot_stands_there_in_each_run() {
    let mut it = Bench::new(true, LoopMode::Device);
    for run in 1..=2 {
        it.start(run);
        it.ticks(3000, Bench::hear);
        let newest = it.device.newest();
        let depth_m = f64::from(PUSH_N) / 1000.0;
        assert!((f64::from(newest.position_m[0]) / depth_m - 1.0).abs() < 1e-4);
        assert!((it.device.hardware().place()[0] / depth_m - 1.0).abs() < 1e-3);
        it.device.disarm();
        it.ticks(500, Bench::hear);
        let place = it.device.hardware().place();
        assert!(
            place.iter().all(|x| x.abs() < 1e-15),
            "at its start: {place:?}"
        );
    }
}

#[test]
fn a_silent_host_brings_the_robot_to_rest() {
    let mut it = Bench::new(true, LoopMode::Device);
    it.start(1);
    it.ticks(30, Bench::hear);
    assert!(it.device.hardware().place()[1] > 1e-3, "on its way");
    // Nobody is heard any more: the watchdog, then the way to rest. What its own loop still does is not commanded.
    let mut rested = 0;
    it.ticks(100 + STOP, |it| {
        rested = if it.device.hardware().moves() {
            0
        } else {
            rested + 1
        };
    });
    assert_eq!(it.device.status().state, State::Fault);
    assert_eq!(it.device.status().fault, Fault::HostSilent.code());
    assert!(rested > 0, "the command stands");
}

#[test]
fn a_robot_to_be_measured_follows_forces_and_no_hand_and_shows_its_sensor() {
    let mut it = Bench::new(false, LoopMode::Host);
    assert!(it.device.hardware().capabilities().lets_go_alone.to_measure);
    it.start(1);
    // The hand pushes by 3 N, which 100 N·s/m would make 30 mm/s of.
    it.ticks(50, |it| {
        let tick = it.device.newest().tick;
        it.hear();
        it.device.command(tick, [0.0]);
    });
    assert!(it.device.hardware().place()[0].abs() < 1e-9);
    // 1 N is 10 mm/s.
    it.ticks(900, |it| {
        let tick = it.device.newest().tick;
        it.device.command(tick, [1.0]);
        it.hear();
    });
    let [place_m, speed] = it.device.hardware().place();
    assert!((speed - 0.01).abs() < 1e-5, "{speed} m/s");
    let shown = f64::from(it.device.newest().position_m[0]);
    assert!((shown - place_m).abs() < 1.1e-5, "{shown} {place_m}");
    // Whatever it is asked for, it is no faster than 50 mm/s.
    it.ticks(1200, |it| {
        let tick = it.device.newest().tick;
        it.device.command(tick, [20.0]);
        it.hear();
        assert!(it.device.hardware().place()[1] < 0.051);
    });
}
