//! What a run may change: limits only to tighter ones, and nothing that stays; forces only while they are fresh.

use crate::line::{Bench, START, spring};
use haptic_link::{
    Configuration, DeviceReport, EventKind, Field, Limits, LoopMode, Refusal, Request, Scope, State,
};
fn configure(
    bench: &mut Bench,
    configuration: Configuration,
    values: &[f32],
    scope: Scope,
) -> Result<DeviceReport, Refusal> {
    let answer = bench.configure_for(configuration, values, scope);
    answer.expect("the line works")
}

/// Configuration and coefficients in force.
fn in_force(bench: &mut Bench) -> (DeviceReport, DeviceReport) {
    (
        bench.done(Request::GetConfiguration),
        bench.done(Request::GetCoefficients { offset: 0 }),
    )
}

#[test]
fn a_run_leaves_nothing_behind() {
    let mut bench = Bench::ideal();
    bench.hello();
    let (mut set, _) = spring();
    set.operator.count = 20;
    set.limits = Limits {
        force_rate_n_per_s: 5000.0,
        ..Limits::DEFAULT
    };
    let values: Vec<f32> = (0..20).map(|n| 1.0 + n as f32).collect();
    configure(&mut bench, set, &values, Scope::Lasting).expect("good");
    let before = in_force(&mut bench);
    let mut run = set;
    run.operator.count = 2;
    run.stiffness_n_per_m = 700.0;
    run.limits.force_n = 3.0;
    run.limits.watchdog_ms = 20;
    // Three runs, each of its own connection; the last host dies in the middle.
    for number in 1..=3 {
        bench.hello();
        configure(&mut bench, run, &[1000.0, -1000.0], Scope::Run).expect("tighter");
        assert_ne!(in_force(&mut bench), before);
        // Asked again because the answer was lost.
        let digest = bench.device.borrow().configuration().1;
        let scope = Scope::Run;
        bench.done(Request::Commit { digest, scope });
        bench.arm();
        bench.done(Request::Start(START));
        bench.run_ms(50);
        if number == 3 {
            bench.host_dead = true;
            bench.run_ms(300);
            bench.host_dead = false;
            assert_eq!(bench.state(), State::Fault);
        } else {
            bench.done(Request::Disarm);
            bench.run_ms(50);
        }
        bench.host.set_keep_alive(None);
        bench.hello();
        assert_eq!(in_force(&mut bench), before, "after run {number}");
    }
}

#[test]
fn a_second_run_of_a_connection_is_held_to_what_was_set_not_to_the_first() {
    let mut bench = Bench::ideal();
    bench.hello();
    let (mut run, values) = spring();
    run.limits = Limits {
        force_n: 1.0,
        ..Limits::DEFAULT
    };
    configure(&mut bench, run, &values, Scope::Run).expect("tighter than at power-up");
    run.limits.force_n = 2.0;
    configure(&mut bench, run, &values, Scope::Run).expect("tighter than at power-up");
    // While it is armed nothing can be put back, so nothing can be staged.
    bench.arm();
    let staged = bench.refused(Request::Configure(run));
    assert_eq!(staged, Refusal::State(State::Armed));
    bench.done(Request::Disarm);
    // Set to last, it may be anything that the board allows, and stays.
    run.limits.force_n = 20.0;
    configure(&mut bench, run, &values, Scope::Lasting).expect("the board allows it");
    let after = in_force(&mut bench);
    bench.hello();
    assert_eq!(in_force(&mut bench), after);
}

/// Which limits are looser is a promise of `haptic-link`.
#[test]
fn a_run_may_not_loosen_a_limit() {
    let mut bench = Bench::ideal();
    bench.hello();
    let before = in_force(&mut bench);
    let (mut run, values) = spring();
    run.limits = Limits {
        force_n: 10.1,
        ..Limits::DEFAULT
    };
    let refused = configure(&mut bench, run, &values, Scope::Run);
    assert_eq!(refused, Err(Refusal::Looser(Field::ForceLimit)));
    assert_eq!(in_force(&mut bench), before);
    configure(&mut bench, run, &values, Scope::Lasting).expect("the board allows it");
}

/// A loop on the host that runs, with this age of a force at most.
fn host_loop(max_age_ticks: u16) -> Bench {
    let (mut configuration, values) = spring();
    configuration.loop_mode = LoopMode::Host;
    configuration.limits.max_age_ticks = max_age_ticks;
    configuration.limits.watchdog_ms = 500;
    let mut bench = Bench::configured(configuration, &values);
    bench.arm();
    bench.law = Some(|x| -500.0 * x);
    bench.done(Request::Start(START));
    bench
}

#[test]
fn a_force_that_is_one_tick_too_old_is_a_fault_and_one_that_answers_no_tick_is_none() {
    for age in [9, 10, 11, 12] {
        let mut bench = host_loop(10);
        bench.run_ms(100);
        bench.law = None;
        bench.run_ms(3);
        let fed = bench.session.fed();
        // It will be applied at the tick behind the newest.
        let tick = bench.device.borrow().newest().tick + 1 - age;
        let mut line = [0; haptic_link::FRAME_MAX];
        let mut say = |bench: &mut Bench, tick: u32| {
            let force = Request::Force {
                tick,
                force_n: [-1.0].into_iter().collect(),
            };
            let length = bench.host.tell(&force, &mut line);
            bench.to_device.send(&line[..length], bench.now_us);
        };
        // Of a run before this one, or of a tick that is still to come.
        say(&mut bench, tick + 1000);
        say(&mut bench, tick + age);
        say(&mut bench, tick);
        bench.step().expect("nothing is asked");
        let fresh = age <= 10;
        assert_eq!(bench.state() == State::Running, fresh, "{age} ticks");
        let keep_alives = bench.session.fed() - fed;
        assert!(keep_alives <= 1 + u32::from(fresh), "{age} ticks");
    }
}

#[test]
fn every_event_of_a_run_is_told_and_what_is_put_back_is_configured_again() {
    let mut bench = Bench::ideal();
    bench.hello();
    let (mut run, values) = spring();
    run.limits = Limits::DEFAULT;
    configure(&mut bench, run, &values, Scope::Run).expect("tighter");
    bench.reports.clear();
    bench.hello();
    bench.done(Request::GetCapabilities);
    bench.run_ms(1);
    assert_eq!(bench.events(), [EventKind::Configured]);
}
