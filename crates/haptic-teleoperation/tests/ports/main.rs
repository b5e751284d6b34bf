//! Ports over a bad line: energy, order of messages, silence.

#![expect(clippy::float_cmp, reason = "exact results are compared exactly")]

mod greeting;

use fracdiff::{Differintegrator, Order, Seconds, ShortMemory};
use haptic_link::{Architecture, HandSample, HandSide, HandState};
use haptic_loop::{
    Fault, Reading, SafetyChain,
    units::{Newtons, NewtonsPerSecond},
};
use haptic_teleoperation::{ChannelModel, CouplerGains, OneWayLine, Port, PortLaw, Settings};
use testkit::{Random, assert_close};

const T: Seconds = Seconds(1e-3);
const LIMIT_N: f64 = 8.0;
type Operator = ShortMemory<f64, 64>;

fn law(architecture: Architecture, order: f64, playout_samples: u32) -> PortLaw<Operator> {
    let operator = Operator::new(Order::new(order).expect("valid"), T).expect("valid");
    let gains = CouplerGains {
        stiffness_n_per_m: 400.0,
        dissipation_n_s_mu_per_m: 6.0,
    };
    match architecture {
        Architecture::PositionPosition => PortLaw::PositionPosition(gains, operator),
        Architecture::PositionForce => PortLaw::PositionForce(gains, operator),
        Architecture::Wave => PortLaw::Wave {
            impedance_n_s_per_m: 5.0,
            playout_samples,
        },
        Architecture::TimeDomain => PortLaw::TimeDomain {
            gains,
            operator,
            playout_samples,
        },
    }
}

fn port(law: PortLaw<Operator>, side: HandSide, silence: f64) -> Port<Operator> {
    let settings = Settings {
        side,
        sample_time: T,
        silence: Seconds(silence),
    };
    // A rate that limits nothing: the force may cross all of its range in a sample.
    let rate = NewtonsPerSecond(2.0 * LIMIT_N / T.0);
    let chain = SafetyChain::new(Newtons(LIMIT_N), rate, T).expect("valid");
    Port::new(law, settings, chain).expect("valid")
}

fn reading(tick: u64, x: f64) -> Reading<f64, 1> {
    Reading {
        tick,
        time_s: tick as f64 * T.0,
        position_m: [x].into(),
    }
}

/// Two ports and the line between them.
struct Line<O: Differintegrator<f64>> {
    ports: [Port<O>; 2],
    ways: [OneWayLine; 2],
    tick: u64,
}

impl Line<Operator> {
    fn new(architecture: Architecture, model: ChannelModel, seed: u64) -> Self {
        let playout = 2 + (2.0 * model.jitter * model.delay.0 / T.0) as u32;
        let side = |side| port(law(architecture, 0.4, playout), side, 10.0);
        let way = |n| OneWayLine::new(model, T, 2 * seed + n).expect("valid");
        Self {
            ports: [side(HandSide::Master), side(HandSide::Slave)],
            ways: [way(0), way(1)],
            tick: 0,
        }
    }

    /// Forces of both.
    fn tick(&mut self, places: [f64; 2]) -> [f64; 2] {
        let tick = self.tick;
        for side in 0..2 {
            while let Some(message) = self.ways[1 - side].next(tick) {
                self.ports[side].receive(&message);
            }
        }
        let mut forces = [0.0; 2];
        for side in 0..2 {
            let begun = self.ports[side].begin(reading(tick, places[side]));
            forces[side] = begun.force().newtons()[0];
            self.ways[side].send(tick, begun.finish().message);
        }
        self.tick += 1;
        forces
    }

    fn given_j(&self) -> f64 {
        self.ports[0].given_j() + self.ports[1].given_j()
    }
}

/// A motion that seeks what a line could give: random pushes, and now and then along the force.
fn most_given(architecture: Architecture, model: ChannelModel, seed: u64) -> (f64, f64) {
    let mut random = Random(seed);
    let mut line = Line::new(architecture, model, seed);
    let (mut x, mut v, mut forces) = ([0.0; 2], [0.0; 2], [0.0; 2]);
    let (mut most, mut scale): (f64, f64) = (0.0, 1e-3);
    for tick in 0..4000_u64 {
        let greedy = (tick / 400) % 3 == 1;
        for side in 0..2 {
            let wish: f64 = if greedy {
                0.1 * f64::signum(forces[side])
            } else {
                random.between(-0.2, 0.2)
            };
            v[side] += 0.2 * (wish - v[side]);
            x[side] += v[side] * T.0;
        }
        forces = line.tick(x);
        assert!(forces.iter().all(|force| force.abs() <= LIMIT_N));
        most = most.max(line.given_j());
        scale += forces.iter().map(|f| f.abs()).sum::<f64>() * 0.2 * T.0;
    }
    (most, scale)
}

#[test]
fn passive_lines_give_no_energy_whatever_line_and_motion() {
    let mut seed = 1;
    for delay in [0.0, 1e-3, 37e-3, 0.2] {
        for (jitter, loss, duplication) in [(0.0, 0.0, 0.0), (0.2, 0.05, 0.05), (1.0, 0.5, 0.5)] {
            let model = ChannelModel {
                delay: Seconds(delay),
                jitter,
                loss,
                duplication,
            };
            for architecture in [Architecture::Wave, Architecture::TimeDomain] {
                seed += 1;
                let (most, scale) = most_given(architecture, model, seed);
                assert!(
                    most <= 1e-12 * scale,
                    "{architecture} {model:?}: {most:e} J of {scale:e} J"
                );
            }
            // The others do give energy, so the motions are bad enough.
            if delay > 0.01 {
                for architecture in [Architecture::PositionPosition, Architecture::PositionForce] {
                    let (most, scale) = most_given(architecture, model, seed);
                    assert!(most > 1e-3 * scale, "{architecture} {model:?}: {most:e} J");
                }
            }
        }
    }
}

/// The master is held 10 mm away; the slave is a mass of 0.1 kg with some damping (N·s/m) that follows. Its place, m.
fn follows(line: &mut Line<Operator>, damping: f64, ticks: u64) -> f64 {
    let (mut x, mut v, m) = (0.0_f64, 0.0_f64, 0.1);
    for tick in 0..ticks {
        let master = 0.01 * (tick as f64 / 500.0).min(1.0);
        let force = line.tick([master, x])[1];
        v += (force - damping * v) / m * T.0;
        x += v * T.0;
    }
    x
}

#[test]
fn without_delay_a_wave_line_holds_two_hands_together() {
    let mut line = Line::new(Architecture::Wave, ChannelModel::IDEAL, 1);
    // Damped, as the hold asks for: a wave line itself has no loss.
    let x = follows(&mut line, 15.0, 3000);
    assert_close("x", x, 0.01, 1e-6);
}

#[test]
fn a_lost_message_loses_no_displacement() {
    let model = ChannelModel {
        delay: Seconds(0.01),
        loss: 0.4,
        jitter: 0.5,
        duplication: 0.2,
    };
    for architecture in [Architecture::PositionPosition, Architecture::Wave] {
        let mut line = Line::new(architecture, model, 7);
        let x = follows(&mut line, 3.0, 6000);
        assert!((x - 0.01).abs() < 2e-4, "{architecture}: {x}");
    }
}

#[test]
fn what_comes_late_or_twice_is_refused_and_counted() {
    let mut port = port(
        law(Architecture::PositionForce, 0.5, 1),
        HandSide::Master,
        1.0,
    );
    let message = |sequence, force_n| HandSample {
        sequence,
        time_s: 0.0,
        state: HandState::Force { force_n },
    };
    assert!(port.receive(&message(5, 1.0)));
    assert!(!port.receive(&message(5, 2.0)));
    assert!(!port.receive(&message(4, 3.0)));
    assert!(port.receive(&message(8, 1.5)));
    let wave = HandState::Wave {
        sum: 9.0,
        energy_j: 9.0,
    };
    let foreign = HandSample {
        sequence: 9,
        time_s: 0.0,
        state: wave,
    };
    assert!(!port.receive(&foreign));
    let counts = port.counts();
    assert_eq!((counts.missing, counts.duplicate), (2, 1));
    assert_eq!((counts.stale, counts.foreign), (1, 1));
    let begun = port.begin(reading(0, 0.0));
    assert_eq!(begun.force().newtons()[0], -1.5);
}

#[test]
fn silence_takes_the_force_to_zero_and_it_never_grows() {
    for architecture in Architecture::ALL {
        let mut line = Line::new(architecture, ChannelModel::IDEAL, 3);
        let silence = 0.05;
        line.ports[0] = port(law(architecture, 0.5, 1), HandSide::Master, silence);
        for tick in 0..200 {
            line.tick([1e-4 * tick as f64, 0.0]);
        }
        // The other side is gone; the hand goes on.
        let mut last = f64::INFINITY;
        for tick in 200..400_u64 {
            let begun = line.ports[0].begin(reading(tick, 1e-4 * tick as f64));
            let force = begun.force().newtons()[0].abs();
            let _ = begun.finish();
            // The last message came in tick 199, and silence counts from there.
            if tick >= 199 + 50 {
                assert!(line.ports[0].is_silent(), "{architecture} at {tick}");
                assert!(force <= last, "{architecture}: {force} after {last}");
            } else {
                assert!(!line.ports[0].is_silent(), "{architecture} at {tick}");
            }
            // A stop time of 0.1 s, and a tick.
            assert!(force == 0.0 || tick <= 199 + 50 + 101, "{architecture}");
            last = force;
        }
    }
}

/// Messages as of a process that was stopped while they came: the newest of them may be as old as the stop was long.
#[test]
fn a_port_that_stood_still_for_as_long_as_a_silence_lets_go() {
    for architecture in Architecture::ALL {
        for (missed, is_silent) in [(49, false), (50, true), (1000, true)] {
            let mut line = Line::new(architecture, ChannelModel::IDEAL, 3);
            line.ports[0] = port(law(architecture, 0.5, 1), HandSide::Master, 0.05);
            let mut last = 0.0;
            for tick in 0..200 {
                last = line.tick([1e-4 * tick as f64, 0.0])[0].abs();
            }
            // The other side goes on, its messages wait, and the hand has moved on.
            line.tick = 200 + missed;
            for tick in line.tick..line.tick + 120 {
                let force = line.tick([1e-4 * tick as f64, 0.0])[0].abs();
                assert_eq!(line.ports[0].is_silent(), is_silent, "{architecture}");
                if is_silent {
                    assert!(force <= last, "{architecture}: {force} after {last}");
                }
                last = force;
            }
            assert_eq!(last == 0.0, is_silent, "{architecture}");
        }
    }
}

#[test]
fn no_force_before_the_other_side_is_heard() {
    for architecture in Architecture::ALL {
        let mut port = port(law(architecture, 0.5, 1), HandSide::Slave, 0.05);
        for tick in 0..500 {
            let begun = port.begin(reading(tick, 1e-3 * tick as f64));
            assert_eq!(begun.force().newtons()[0], 0.0);
            let _ = begun.finish();
        }
        assert!(!port.is_silent());
    }
}

#[test]
fn a_position_that_is_no_number_is_a_fault_and_leaves_the_books_alone() {
    for architecture in Architecture::ALL {
        let mut line = Line::new(architecture, ChannelModel::IDEAL, 3);
        for tick in 0..50 {
            line.tick([1e-4 * tick as f64, 0.0]);
        }
        let forces = line.tick([f64::NAN, 0.0]);
        assert_eq!(forces[0], 0.0);
        assert_eq!(line.ports[0].safety().fault(), Some(Fault::NonFiniteForce));
        for _ in 0..10 {
            assert!(line.tick([0.0, 0.0]).iter().all(|force| force.is_finite()));
        }
    }
}

#[test]
fn a_debt_of_the_safety_chain_is_paid_back() {
    // A rate so slow that the force lags behind what is wanted.
    let settings = Settings {
        side: HandSide::Master,
        sample_time: T,
        silence: Seconds(1.0),
    };
    let chain = SafetyChain::new(Newtons(LIMIT_N), NewtonsPerSecond(20.0), T).expect("valid");
    let mut port = Port::new(law(Architecture::Wave, 0.5, 1), settings, chain).expect("valid");
    let (mut sum, mut energy) = (0.0, 0.0);
    let (mut debt, mut x): (f64, f64) = (0.0, 0.0);
    for tick in 0..2000_u64 {
        // Waves come in all the time, and the hand turns round.
        let wave = 0.5;
        sum += wave * T.0;
        energy += 0.5 * wave * wave * T.0;
        let state = HandState::Wave {
            sum,
            energy_j: energy,
        };
        port.receive(&HandSample {
            sequence: tick as u32 + 1,
            time_s: 0.0,
            state,
        });
        x += if tick < 1000 {
            0.5 * (0.02 * tick as f64).sin() * T.0
        } else {
            0.0
        };
        let _ = port.begin(reading(tick, x)).finish();
        debt = debt.min(port.balance_j().expect("a passive law"));
    }
    assert!(debt < -1e-6, "the test makes no debt: {debt:e}");
    assert!(port.balance_j().expect("a passive law") >= 0.0);
}

#[test]
fn settings_outside_their_range_are_refused_by_name() {
    let settings = Settings {
        side: HandSide::Master,
        sample_time: T,
        silence: Seconds(0.1),
    };
    let chain = || SafetyChain::new(Newtons(1.0), NewtonsPerSecond(1e3), T).expect("valid");
    let wave = |impedance_n_s_per_m, playout_samples| PortLaw::<Operator>::Wave {
        impedance_n_s_per_m,
        playout_samples,
    };
    let refused = |law, settings| {
        let error = Port::new(law, settings, chain()).expect_err("out of range");
        error.to_string()
    };
    assert!(refused(wave(0.0, 1), settings).starts_with("wave impedance 0 N·s/m"));
    assert!(refused(wave(1.0, 0), settings).starts_with("playout 0 samples"));
    let silence = Settings {
        silence: Seconds(0.0),
        ..settings
    };
    assert!(refused(wave(1.0, 1), silence).starts_with("silence 0 s"));
    let model = ChannelModel {
        delay: Seconds(-0.1),
        ..ChannelModel::IDEAL
    };
    let error = OneWayLine::new(model, T, 1)
        .expect_err("negative")
        .to_string();
    assert!(
        error.starts_with("delay of the line -0.1 s is not in [0, 10]"),
        "{error}"
    );
}
