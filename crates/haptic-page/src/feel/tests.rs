//! The loop of the thread in virtual time: what a hand is given that pushes from the first tick on.

use super::settings::WallNumbers;
use super::*;
use haptic_experiment::Imperfections;
use haptic_loop::units::Seconds;
use haptic_tissue::Library;
use testkit::Random;

/// A pointer: where it is at a tick, m.
type Pointer = Box<dyn Fn(u32) -> f64>;

/// A tick of the loop: position, m, and force, N.
type Felt = (f64, f64);

/// The loop with a hand at this pointer, as the thread runs it; with a start-up ramp, if one is given.
fn felt(wall: WallNumbers, pointer: &Pointer, rise_time: Option<Seconds>) -> Vec<Felt> {
    let library = Library::load(None).expect("built in");
    let start = FeelChange {
        environment: Some(FeltThing::Wall(wall)),
        ..FeelChange::default()
    };
    let numbers = DeviceNumbers::default();
    let settings = FeelSettings::new(&library, numbers, Imperfections::NONE, start);
    let settings = settings.expect("in range");
    let mass = Kilograms(numbers.mass_kg);
    let own = limits(mass, 0);
    let limits = Limits {
        rise_time: rise_time.or(own.rise_time),
        ..own
    };
    let chain = SafetyChain::from_limits(&limits, SAMPLE_TIME).expect("valid");
    let law = settings.law().expect("made");
    let mut controller = Controller::<_, 1, _>::new(fading(&law.environment), chain);
    let mut device = HeldDevice::new(numbers, &Imperfections::NONE).expect("valid");
    let mut engaged = controller.engage(&mut device);
    let tick = |n| {
        engaged.device_mut().hand(pointer(n), true);
        let Ok(sample) = engaged.tick();
        let force_n = sample.force.newtons()[0];
        engaged.controller_mut().law_mut().1.sent(force_n);
        (sample.reading.position_m[0], force_n)
    };
    (0..TICKS).map(tick).collect()
}

/// The most that a touch gave at any time, J.
#[derive(Debug, Default)]
struct Given {
    /// By the law: each force on the way to where it was asked for.
    law_j: f64,
    /// In all, forces held over a tick, less what the damping of the device took.
    net_j: f64,
}

fn given(ticks: &[Felt]) -> Given {
    let mut most = Given::default();
    let (mut law_j, mut net_j) = (0.0, 0.0);
    for pair in ticks.windows(2) {
        let [(before_m, held_n), (now_m, force_n)] = [pair[0], pair[1]];
        let moved = now_m - before_m;
        law_j += force_n * moved;
        net_j += held_n * moved - DAMPING * moved * moved / SAMPLE_TIME.0;
        if now_m <= 0.0 {
            (law_j, net_j) = (0.0, 0.0);
        }
        most.law_j = most.law_j.max(law_j);
        most.net_j = most.net_j.max(net_j);
    }
    most
}

const DAMPING: f64 = RANGES.damping_n_s_per_m.default;
const TICKS: u32 = 6000;

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_wall_that_is_pressed_from_the_start_gives_nothing_back_that_it_did_not_take() {
    let mut random = Random(1);
    let mut share = move || random.share();
    let (mut were_felt, mut ramped_j) = (0, 0.0_f64);
    for case in 0..30 {
        let wall = WallNumbers {
            order: share(),
            stiffness_n_per_m: 900.0 * share(),
            dissipation_n_s_mu_per_m: 40.0 * share(),
        };
        // In at any time, a hold of any length, out and in again within the touch.
        let (into, hold) = ((400.0 * share()) as u32, (1200.0 * share()) as u32 + 300);
        let (deep, less) = (0.002 + 0.018 * share(), share());
        let tremble = 1e-3 * share();
        let pointer: Pointer = Box::new(move |n| {
            let shake = tremble * (f64::from(n) / 17.0).sin();
            match n.saturating_sub(into) / hold {
                _ if n < into => -5e-3,
                0 | 2 => deep + shake,
                1 => deep * less + shake,
                _ => -5e-3,
            }
        });
        let ticks = felt(wall, &pointer, None);
        let most = given(&ticks);
        // Rounding.
        assert!(most.law_j < 1e-12, "case {case}, {wall:?}: {most:?}");
        assert!(most.net_j < 1e-12, "case {case}, {wall:?}: {most:?}");
        were_felt += u32::from(ticks.iter().any(|(_, force_n)| *force_n < -0.3));
        ramped_j = ramped_j.max(given(&felt(wall, &pointer, Some(Seconds(0.5)))).net_j);
    }
    assert!(were_felt > 20, "{were_felt} of 30 hands felt a wall");
    // What a ramp would give to the same hands.
    assert!(ramped_j > 2e-3, "{ramped_j} J");
}

#[test]
fn the_device_begins_where_no_force_acts() {
    let rest: Pointer = Box::new(|_| -5e-3);
    let ticks = felt(WallNumbers::default(), &rest, None);
    let clear = ticks
        .iter()
        .all(|&(place, force)| place < 0.0 && force == 0.0);
    assert!(clear);
}
