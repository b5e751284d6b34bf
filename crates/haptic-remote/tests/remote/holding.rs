//! A controller that a device runs by itself: the bits of the host's, and every refusal before a force.

use crate::{
    line::{Bench, START, device, transaction},
    plane::Plane,
};
use fracdiff::Seconds;
use fractional_control::{
    Controller, ControllerParameters, ControllerSetup, CroneParameters, FractionalPid,
    LeadController, LeadLagParameters, PidParameters, SetPoint, TidParameters,
};
use haptic_emulator::LineFaults;
use haptic_link::{
    Configuration, ControllerLaw, DeviceReport, DigestBuilder, Field, LoopMode, Refusal, Request,
    Scope, Simulation, State,
};
use haptic_remote::{Hardware, controller_law};

const T: Seconds = Seconds(1e-3);
const REFERENCE_M: f32 = 4e-3;
const RAMP_TICKS: u32 = 300;
const PID: PidParameters = PidParameters {
    proportional: 300.0,
    integral: 900.0,
    integral_order: 0.9,
    derivative: 6.0,
    derivative_order: 0.9,
};
const CRONE: CroneParameters = CroneParameters {
    gain: 400.0,
    order: 1.3,
    low_rad_s: 20.0,
    high_rad_s: 200.0,
};

fn setup(law: impl Into<ControllerParameters>, scheme: &str) -> ControllerSetup {
    ControllerSetup {
        // Not reached by the ramp, but by its start.
        output_low: Some(-0.9),
        output_high: Some(1.2),
        scheme: scheme.parse().expect("a scheme"),
        ..ControllerSetup::new(law, T)
    }
}

/// The testbed, which a hand pushes; the force rises in half a second.
fn configuration() -> Configuration {
    Configuration {
        simulation: Simulation {
            push_n: -0.5,
            ..Simulation::TESTBED
        },
        ..Configuration::PASSIVE
    }
}

/// All of a run with this controller.
fn held(setup: &ControllerSetup) -> (Configuration, Vec<f32>, ControllerLaw) {
    let law = controller_law(setup, REFERENCE_M, RAMP_TICKS, 10.0);
    let (operator, values, law) = law.expect("a law");
    let configuration = Configuration {
        operator,
        ..configuration()
    };
    (configuration, values, law)
}

impl<H: Hardware<D>, const D: usize> Bench<H, D> {
    /// Sends a controller for a run, or to last.
    fn hold(
        &mut self,
        (configuration, values, law): &(Configuration, Vec<f32>, ControllerLaw),
        scope: Scope,
    ) -> Result<DeviceReport, Refusal> {
        for request in transaction(*configuration, values) {
            self.answered(request)?;
        }
        self.answered(Request::Controller(law.clone()))?;
        let digest = DigestBuilder::new(configuration).coefficients(values);
        let digest = digest.controller(law).finish();
        self.answered(Request::Commit { digest, scope })
    }
}

fn with_cost(cost: Option<haptic_link::ControllerCost>) -> Bench {
    let bench = Bench::with(device(), LineFaults::default(), 1);
    bench.device.borrow_mut().hardware_mut().controller_cost = cost;
    bench
}

/// Runs so many ticks, and holds each force against a controller of the host.
fn same_bits<C: Controller<f32>>(
    setup: &ControllerSetup,
    ticks: u32,
    make: impl FnOnce(&ControllerSetup) -> C,
) {
    let mut bench = with_cost(Some(haptic_remote::CONTROLLER_COST));
    bench.hello();
    bench.hold(&held(setup), Scope::Run).expect("runs");
    bench.arm();
    bench.done(Request::Start(haptic_link::Start { ticks, ..START }));
    bench.run_ms(u64::from(ticks) + 300);
    let host = make(setup);
    let mut history = host.at_rest();
    let (mut next, mut limited, mut held_back) = (0, 0, 0);
    let mut last_m = 0.0;
    for sample in bench.samples().filter(|sample| sample.tick < ticks) {
        let axis = &sample.axes[0];
        assert_eq!(sample.tick, next);
        let r = if sample.tick < RAMP_TICKS {
            REFERENCE_M * (sample.tick as f32 / RAMP_TICKS as f32)
        } else {
            REFERENCE_M
        };
        let want = host.output(&history, r, axis.position_m);
        let have = axis.environment_force_n;
        assert_eq!(have.to_bits(), want.to_bits(), "tick {next}: {have} {want}");
        host.advance(&mut history, r, axis.position_m, axis.force_n);
        limited += u32::from([-0.9, 1.2].contains(&have));
        held_back += u32::from(have != axis.force_n);
        last_m = axis.position_m;
        next += 1;
    }
    assert_eq!(next, ticks, "{:?}", bench.told_fault());
    assert!(held_back > 100, "{held_back} {limited}");
    // It holds.
    assert!((last_m - REFERENCE_M).abs() < 0.5 * REFERENCE_M, "{last_m}");
}

fn actuator_and_memory(
    design: &ControllerSetup,
) -> (
    fractional_control::Actuator,
    fractional_control::PowerMemory,
) {
    let memory = design.memory().expect("valid").fewest_modes();
    (design.actuator().expect("valid"), memory)
}

fn pid(design: &ControllerSetup) -> FractionalPid<f32> {
    let (actuator, memory) = actuator_and_memory(design);
    FractionalPid::new(PID, design.set_point, actuator, memory, T).expect("valid")
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn its_forces_have_the_bits_of_the_host_over_100_000_ticks() {
    same_bits(&setup(PID, "full-bdf2:1e-6"), 100_000, pid);
}

#[test]
fn so_have_those_of_every_controller() {
    same_bits(&setup(PID, "full:1e-4"), 5_000, pid);
    let tid = TidParameters {
        tilt: 600.0,
        tilt_divisor: 3.0,
        integral: 900.0,
        derivative: 4.0,
    };
    same_bits(&setup(tid, "full-bdf2:1e-6"), 5_000, |design| {
        let (actuator, memory) = actuator_and_memory(design);
        FractionalPid::<f32>::tid(tid, design.set_point.derivative, actuator, memory, T)
            .expect("valid")
    });
    for order in [1.3, 0.6] {
        let crone = CroneParameters { order, ..CRONE };
        same_bits(&setup(crone, "full:1e-6"), 5_000, |design| {
            let (actuator, memory) = actuator_and_memory(design);
            LeadController::<f32>::crone(crone, actuator, memory, T).expect("valid")
        });
    }
    let lead = LeadLagParameters {
        gain: 4000.0,
        lambda_s: 0.05,
        x: 0.1,
        order: 0.9,
    };
    same_bits(&setup(lead, "full:1e-6"), 5_000, |design| {
        let (actuator, memory) = actuator_and_memory(design);
        LeadController::<f32>::lead_lag(lead, actuator, memory, T).expect("valid")
    });
}

/// A handle that is elsewhere when the run starts has not come from zero in one sample.
#[test]
fn a_run_starts_where_the_device_is() {
    const PLACE_M: f32 = 2e-3;
    for text in ["300+900/s+0.5s", "300+900/s^0.9+6s^0.9"] {
        let gains: PidParameters = text.parse().expect("a controller");
        let design = ControllerSetup {
            set_point: SetPoint {
                proportional: 0.8,
                ..SetPoint::DEFAULT
            },
            ..setup(gains, "full-bdf2:1e-6")
        };
        let mut bench = with_cost(Some(haptic_remote::CONTROLLER_COST));
        bench.hello();
        bench.hold(&held(&design), Scope::Run).expect("runs");
        bench.arm();
        bench.device.borrow_mut().hardware_mut().offset_m = PLACE_M;
        bench.done(Request::Start(haptic_link::Start { ticks: 50, ..START }));
        bench.run_ms(400);
        let (actuator, memory) = actuator_and_memory(&design);
        let host = FractionalPid::<f32>::new(gains, design.set_point, actuator, memory, T);
        let host = host.expect("valid");
        let (mut history, mut ticks) = (host.settled(PLACE_M, PLACE_M, 0.0).expect("settles"), 0);
        for sample in bench.samples().filter(|sample| sample.tick < 50) {
            let axis = &sample.axes[0];
            let r = REFERENCE_M * (sample.tick as f32 / RAMP_TICKS as f32);
            let (want, have) = (
                host.output(&history, r, axis.position_m),
                axis.environment_force_n,
            );
            assert_eq!(
                have.to_bits(),
                want.to_bits(),
                "{text} {ticks}: {have} {want}"
            );
            host.advance(&mut history, r, axis.position_m, axis.force_n);
            ticks += 1;
            if sample.tick == 0 {
                // What the gain makes of the way to the reference, and no more; a derivative that came from zero is at the limit.
                assert!(
                    (have + 0.8 * 300.0 * PLACE_M).abs() < 0.01,
                    "{text}: {have}"
                );
                assert_eq!(host.output(&host.at_rest(), r, axis.position_m), -0.9);
            }
        }
        assert_eq!(ticks, 50, "{:?}", bench.told_fault());
    }
}

/// A refusal, after which what was set is in force, and nothing moves.
fn refused(
    bench: &mut Bench,
    law: &(Configuration, Vec<f32>, ControllerLaw),
    scope: Scope,
) -> Refusal {
    let before = bench.done(Request::GetConfiguration);
    let refusal = bench.hold(law, scope).expect_err("refused");
    assert_eq!(bench.done(Request::GetConfiguration), before);
    assert_eq!((bench.state(), bench.force_n()), (State::Idle, 0.0));
    refusal
}

#[test]
fn what_is_no_controller_of_this_device_is_refused_before_a_force() {
    let good = held(&setup(PID, "full-bdf2:1e-6"));
    let mut bench = with_cost(Some(haptic_remote::CONTROLLER_COST));
    bench.hello();
    type Change = fn(&mut (Configuration, Vec<f32>, ControllerLaw));
    let cases: [(Field, Change); 13] = [
        (Field::Coefficient, |(_, values, _)| values[5] = f32::NAN),
        (Field::Coefficient, |(_, values, _)| {
            values[0] = f32::INFINITY;
        }),
        // The first decay of the integral's modes, behind h, P and the I's own taps.
        (Field::Coefficient, |(_, values, _)| values[21] = 1.5),
        (Field::CoefficientCount, |(_, _, law)| {
            law.parts[1].values += 1;
        }),
        (Field::CoefficientCount, |(_, _, law)| {
            law.parts[1].values = 114;
        }),
        (Field::CoefficientCount, |(_, _, law)| {
            law.parts[1].filter += 1;
        }),
        (Field::CoefficientCount, |(_, _, law)| law.parts.clear()),
        (Field::CoefficientCount, |(_, _, law)| {
            law.form = haptic_link::ControllerForm::Lead;
        }),
        (Field::IntegerPart, |(_, _, law)| law.parts[1].integer = 3),
        (Field::Depth, |(_, _, law)| law.reference_m = f32::NAN),
        (Field::Depth, |(_, _, law)| law.reference_m = 101.0),
        (Field::ForceLimit, |(_, _, law)| law.low_n = f32::NAN),
        (Field::ForceLimit, |(_, _, law)| law.high_n = law.low_n),
    ];
    for (number, (field, change)) in cases.into_iter().enumerate() {
        let mut bad = good.clone();
        change(&mut bad);
        let refusal = refused(&mut bench, &bad, Scope::Run);
        let named = matches!(refusal, Refusal::Range { field: have, .. } if have == field);
        assert!(named, "{number}: {refusal:?}");
    }
    let unsupported = Refusal::Unsupported(Field::Other);
    let mut host_loop = good.clone();
    host_loop.0.loop_mode = LoopMode::Host;
    assert_eq!(refused(&mut bench, &host_loop, Scope::Run), unsupported);
    assert_eq!(refused(&mut bench, &good, Scope::Lasting), unsupported);
    // Damaged on the way.
    bench.done(Request::Configure(good.0));
    bench.done(Request::Controller(ControllerLaw {
        ramp_ticks: 1,
        ..good.2.clone()
    }));
    for request in transaction(good.0, &good.1).into_iter().skip(1) {
        bench.done(request);
    }
    let digest = DigestBuilder::new(&good.0).coefficients(&good.1);
    let digest = digest.controller(&good.2).finish();
    let commit = Request::Commit {
        digest,
        scope: Scope::Run,
    };
    assert_eq!(bench.refused(commit), Refusal::Digest);
    bench.hold(&good, Scope::Run).expect("good");
}

#[test]
fn a_device_takes_no_controller_that_its_tick_has_no_time_for() {
    let good = held(&setup(PID, "full-bdf2:1e-6"));
    let cost = |coefficient_ns| haptic_link::ControllerCost {
        tick_us: 200,
        coefficient_ns,
    };
    // What is left of 1 ms, for each coefficient.
    let affordable = 800_000 / good.1.len() as u32;
    let mut bench = with_cost(Some(cost(affordable)));
    bench.hello();
    assert_eq!(
        bench.done(Request::GetControllerCost),
        DeviceReport::ControllerCost(cost(affordable))
    );
    bench.hold(&good, Scope::Run).expect("fits");
    let mut bench = with_cost(Some(cost(affordable + 10)));
    bench.hello();
    let refusal = refused(&mut bench, &good, Scope::Run);
    let Refusal::Range {
        field: Field::TickPeriod,
        least,
        ..
    } = refusal
    else {
        panic!("{refusal:?}");
    };
    assert!(least > 1000.0 && least < 1010.0, "{least}");
    // A tick that is so long.
    let mut slower = good;
    slower.0.tick_period_us = least as u32;
    bench.hold(&slower, Scope::Run).expect("fits");
}

#[test]
fn a_device_without_controllers_says_so() {
    let good = held(&setup(PID, "full:1e-4"));
    let unsupported = Refusal::Unsupported(Field::Other);
    let mut bench = with_cost(None);
    bench.hello();
    assert_eq!(bench.refused(Request::GetControllerCost), unsupported);
    assert_eq!(refused(&mut bench, &good, Scope::Run), unsupported);
    let mut two = Plane::connected(LineFaults::default());
    assert_eq!(two.refused(Request::GetControllerCost), unsupported);
    assert_eq!(two.hold(&good, Scope::Run), Err(unsupported));
}

#[test]
fn a_run_with_a_controller_leaves_nothing_behind_and_starts_anew() {
    let mut bench = Bench::configured(crate::line::spring().0, &crate::line::spring().1);
    bench.device.borrow_mut().hardware_mut().controller_cost = Some(haptic_remote::CONTROLLER_COST);
    let set = bench.done(Request::GetConfiguration);
    let mut law = held(&setup(PID, "full:1e-4"));
    // Below the limit of the command.
    law.0.limits.start_force_n = 0.5;
    bench.hold(&law, Scope::Run).expect("runs");
    // Its numbers read back.
    let DeviceReport::Coefficients(block) = bench.done(Request::GetCoefficients { offset: 16 })
    else {
        panic!("no coefficients");
    };
    assert_eq!(block.values, law.1[16..32]);
    bench.arm();
    let forces = |bench: &mut Bench, run| {
        bench.reports.clear();
        bench.done(Request::Start(haptic_link::Start {
            run,
            ticks: 400,
            ..START
        }));
        bench.run_ms(700);
        let forces = bench
            .samples()
            .map(|sample| sample.axes[0].force_n.to_bits());
        forces.collect::<Vec<u32>>()
    };
    let first = forces(&mut bench, 1);
    assert!(first.len() >= 400);
    assert_eq!(forces(&mut bench, 2), first);
    // Away from where it is switched on the controller would pull at once.
    bench.device.borrow_mut().hardware_mut().offset_m = 0.01;
    let refusal = bench.refused(Request::Start(haptic_link::Start { run: 3, ..START }));
    assert!(
        matches!(refusal, Refusal::ForceNotSmall { .. }),
        "{refusal:?}"
    );
    bench.done(Request::Disarm);
    bench.host.set_keep_alive(None);
    bench.hello();
    assert_eq!(bench.done(Request::GetConfiguration), set);
}
