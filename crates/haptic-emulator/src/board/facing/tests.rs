//! Two boards in virtual time, against the simulation of both and each other.

use super::*;
use fracdiff::{Order, Scheme};
use haptic_link::{Configuration, Limits, LoopMode, Refusal, Simulation, Start, State};
use haptic_loop::{
    Controller, SafetyChain, SpringDamper,
    plant::{HeldRig, Holder, RampHold, RigDrive},
    units::{Metres, Newtons},
};
use haptic_remote::{TickSide, operator_shape, prepare};

type Side = TickSide<Embodied<FacingBoard, 1>>;

const T: Seconds = Seconds(1e-3);
/// Gain of the controller of the indenter, N/m.
const GAIN: f32 = 400.0;
/// Where that wants it, m.
const WANTED: f32 = 2e-3;

/// Ticked in virtual time.
struct Pair {
    now: TickTime,
    /// Time of the last tick of each, µs.
    times: [u64; 2],
    sides: [Side; 2],
    config: FacingConfig,
}

fn bodies() -> [Body; 2] {
    let body = |mass, damping| Body {
        plant: MassDamperConfig::ideal(Kilograms(mass), NewtonSecondsPerMetre(damping), T),
        encoder_resolution: Metres(0.0),
        noise: (Metres(0.0), 0),
    };
    [body(0.065, 3.5), body(0.2, 2.0)]
}

impl Pair {
    fn new(contact: FacingContact) -> Self {
        Self::sensing(contact, [None; 2])
    }

    fn sensing(contact: FacingContact, sensors: [Option<ForceSensorConfig>; 2]) -> Self {
        let bodies = bodies();
        let now = TickTime::default();
        let boards = facing(bodies.map(Some), sensors, contact, &now).expect("good ones");
        Self {
            now,
            times: [0; 2],
            sides: boards.map(|board| TickSide::new(board).expect("starts")),
            config: FacingConfig {
                devices: bodies.map(|body| body.plant),
                contact,
            },
        }
    }

    /// A law on the renderer, and forces from here on the indenter; both at their sample times, started.
    fn run(&mut self, law: &Configuration, values: &[f32], periods_us: [u32; 2]) {
        let host = Configuration {
            loop_mode: LoopMode::Host,
            ..Configuration::PASSIVE
        };
        let laws = [(*law, values), (host, &[0.0][..])];
        for ((side, (law, values)), period_us) in self.sides.iter_mut().zip(laws).zip(periods_us) {
            let law = Configuration {
                tick_period_us: period_us,
                limits: Limits::bare(50.0, 1e6),
                ..law
            };
            let can = side.hardware().capabilities();
            let prepared = prepare::<Embodied<FacingBoard, 1>, 1>(law, values, &can);
            side.install(prepared.expect("good"), values).expect("idle");
            side.arm(0).expect("nothing is wrong");
        }
        for side in &mut self.sides {
            side.start(Start::ENDLESS).expect("armed");
        }
    }

    fn tick(&mut self, side: FacingSide) {
        let side = side as usize;
        let period_us = u64::from(self.sides[side].configuration().0.tick_period_us);
        self.times[side] += period_us;
        let now_us = self.times[side];
        self.now.set(now_us);
        self.sides[side].heard(now_us, true);
        self.sides[side].tick(now_us);
    }

    /// A tick of both at once; the indenter answers to where it was in the tick before. Positions and forces.
    fn tick_both(&mut self) -> [(f32, f32); 2] {
        self.tick(FacingSide::Renderer);
        self.tick(FacingSide::Indenter);
        let newest = self.sides.each_ref().map(|side| *side.newest());
        let [_, indenter] = &newest;
        let force = GAIN * (WANTED - indenter.position_m[0]);
        assert!(self.sides[1].command(indenter.tick, [force]));
        newest.map(|tick| (tick.position_m[0], tick.force_n[0]))
    }
}

/// A spring on the renderer, N/m.
fn spring(stiffness: f32) -> Configuration {
    Configuration {
        stiffness_n_per_m: stiffness,
        ..Configuration::PASSIVE
    }
}

/// The same controller, a tick late.
#[derive(Debug, Default)]
struct Late(f64);

impl Holder for Late {
    fn force(&mut self, _: f64, measured: f64) -> f64 {
        std::mem::replace(&mut self.0, f64::from(GAIN * (WANTED - measured as f32)))
    }

    fn restart(&mut self) {
        self.0 = 0.0;
    }
}

#[test]
fn two_boards_and_the_simulation_of_both_make_the_same_forces() {
    for (gap, friction) in [(0.0, 0.0), (0.5e-3, 0.0), (0.5e-3, 0.1)] {
        let contact = FacingContact {
            gap: Metres(gap),
            friction: Newtons(friction),
            ..FacingContact::COMPLIANT
        };
        let order = Order::new(0.4).expect("an order");
        let scheme: Scheme = "grunwald:64".parse().expect("a scheme");
        let operator = scheme.build::<f32>(order, T, 1.0).expect("made");
        let (shape, values) = operator_shape(&operator).expect("for a device");
        let law = Configuration {
            dissipation_n_s_mu_per_m: 20.0,
            order: 0.4,
            operator: shape,
            ..spring(150.0)
        };
        let mut pair = Pair::new(contact);
        pair.run(&law, &values, [1000, 1000]);

        let tissue = SpringDamper::new(150.0, 20.0, operator).expect("a tissue");
        let limits = haptic_loop::SafetyLimits::bare(
            haptic_loop::units::Newtons(50.0),
            haptic_loop::units::NewtonsPerSecond(1e6),
        );
        let chain = SafetyChain::<f32>::from_limits(&limits, T).expect("a chain");
        let way = RampHold::new(Metres(1e-3), Seconds(0.1)).expect("a ramp");
        let rig = HeldRig::between(pair.config, RigDrive::Position(way), T, Late::default());
        let mut rig = rig.expect("a rig");
        let mut controller = Controller::new(tissue, chain);
        let mut engaged = controller.engage(&mut rig);
        let mut largest: f32 = 0.0;
        for n in 0..3000 {
            let [(depth, force), (way, push)] = pair.tick_both();
            let want = engaged.tick().expect("runs");
            let devices = engaged.device().devices();
            // A position of some mm in f32, a force of some N.
            assert!(
                (depth - want.reading.position_m[0]).abs() < 1e-9,
                "{gap} {friction} {n}: {depth} {want:?}"
            );
            assert!(
                (force - want.force.newtons()[0]).abs() < 2e-6,
                "{n}: {force} {want:?}"
            );
            if n > 0 {
                let drive = engaged.device().drive_force() as f32;
                assert!((push - drive).abs() < 2e-6, "{n}: {push} {drive}");
            }
            assert!(devices.contact_force() >= 0.0 && way.is_finite());
            largest = largest.max(force.abs());
        }
        assert!(largest > 0.2, "{largest}");
    }
}

#[test]
fn boards_of_other_sample_times_and_phases_share_one_world() {
    let mut pair = Pair::new(FacingContact::COMPLIANT);
    pair.run(&spring(600.0), &[0.0], [700, 1000]);
    let mut forces = [0.0_f32; 2];
    for n in 0..40_000 {
        let [first, second] = pair.times;
        let next = [first + 700, second + 1000];
        if next[0] <= next[1] {
            pair.tick(FacingSide::Renderer);
        } else {
            pair.tick(FacingSide::Indenter);
            let newest = *pair.sides[1].newest();
            let force = GAIN * (WANTED - newest.position_m[0]);
            assert!(pair.sides[1].command(newest.tick, [force]), "{n}");
        }
        forces = pair.sides.each_ref().map(|side| side.newest().force_n[0]);
    }
    // At rest F = 600·x₁ = 400·(2 mm − x₂) with x₂ = x₁ + F/1e5.
    let want = 400.0 * 2e-3 / (1.0 + 400.0 / 600.0 + 400.0 / 1e5);
    assert!((forces[1] - want).abs() < 1e-5 * want, "{forces:?}");
    assert!((forces[0] + forces[1]).abs() < 1e-5, "{forces:?}");
}

#[test]
fn a_start_puts_both_back_unless_the_other_makes_a_force() {
    let mut pair = Pair::new(FacingContact::COMPLIANT);
    pair.run(&spring(600.0), &[0.0], [1000, 1000]);
    for _ in 0..3000 {
        pair.tick_both();
    }
    let depth = pair.sides[0].newest().position_m[0];
    assert!(depth > 5e-4);
    let again = |side: &mut Side| {
        side.arm(0).expect("armed");
        let start = Start {
            run: side.newest().tick,
            ..Start::ENDLESS
        };
        side.start(start).expect("starts");
    };
    // The indenter ends, and begins again while the renderer renders.
    pair.sides[1].stop().expect("stops");
    for _ in 0..3 {
        pair.tick(FacingSide::Renderer);
        pair.tick(FacingSide::Indenter);
    }
    while pair.sides[1].status().state != State::Armed {
        pair.tick(FacingSide::Renderer);
        pair.tick(FacingSide::Indenter);
    }
    let before = pair.sides[1].newest().position_m[0];
    again(&mut pair.sides[1]);
    pair.tick(FacingSide::Indenter);
    let after = pair.sides[1].newest().position_m[0];
    assert!((after / before - 1.0).abs() < 0.1, "{after} {before}");
    // Both end.
    for side in &mut pair.sides {
        side.stop().expect("stops");
    }
    while pair
        .sides
        .iter()
        .any(|side| side.status().state != State::Armed)
    {
        pair.tick(FacingSide::Renderer);
        pair.tick(FacingSide::Indenter);
    }
    pair.tick(FacingSide::Renderer);
    pair.tick(FacingSide::Indenter);
    again(&mut pair.sides[0]);
    pair.tick(FacingSide::Renderer);
    let newest = pair.sides[0].newest().position_m[0];
    assert_eq!(newest.to_bits(), 0, "{newest}");
}

/// Balance at rest: what touches a mass is what its motor makes, with the other sign; and one mass pushes the other as it is pushed.
#[test]
fn both_boards_sense_their_contact_and_one_without_a_sensor_nothing() {
    let ideal = ForceSensorConfig {
        range: Newtons(20.0),
        noise: Newtons(0.0),
        lag: Seconds(0.0),
        offset: Newtons(0.0),
        seed: 1,
    };
    let mut pair = Pair::sensing(FacingContact::COMPLIANT, [Some(ideal); 2]);
    let most = pair
        .sides
        .each_ref()
        .map(|side| side.hardware().capabilities().sensed_force_max_n);
    assert_eq!(most.map(f32::to_bits), [20.0_f32.to_bits(); 2]);
    pair.run(&spring(150.0), &[0.0], [1000, 1000]);
    let mut last = [(0.0, 0.0); 2];
    for _ in 0..3000 {
        last = pair.tick_both();
    }
    let sensed = pair
        .sides
        .each_ref()
        .map(|side| side.newest().sensed_force_n[0]);
    assert!(sensed[0] > 0.1, "{sensed:?}");
    for (sensed, (_, made)) in sensed.iter().zip(last) {
        assert!((sensed + made).abs() < 1e-4, "{sensed} {made}");
    }
    let mut blind = Pair::sensing(FacingContact::COMPLIANT, [Some(ideal), None]);
    blind.run(&spring(150.0), &[0.0], [1000, 1000]);
    blind.tick_both();
    let [seeing, blind] = blind
        .sides
        .each_ref()
        .map(|side| side.newest().sensed_force_n[0]);
    assert!(seeing.is_finite() && blind.is_nan(), "{seeing} {blind}");
}

#[test]
fn a_plant_that_a_host_asks_for_and_axes_are_refused() {
    let pair = Pair::new(FacingContact::COMPLIANT);
    let asked = Configuration {
        simulation: Simulation::TESTBED,
        ..Configuration::PASSIVE
    };
    let can = pair.sides[0].hardware().capabilities();
    assert!(!can.simulated);
    let refused = prepare::<Embodied<FacingBoard, 1>, 1>(asked, &[0.0], &can);
    assert!(matches!(refused, Err(Refusal::Unsupported(_))));
}
