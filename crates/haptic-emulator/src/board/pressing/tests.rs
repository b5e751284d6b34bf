//! A board with a specimen in virtual time, against the rest of a spring and against a board without a specimen.

use super::*;
use crate::board::{Body, Embodied, Touched};
use haptic_loop::{
    Controller, Environment, SafetyChain, SafetyLimits,
    nalgebra::SVector,
    plant::{ForceSensorConfig, SpecimenMatter},
    units::{Metres, Newtons, NewtonsPerSecond},
};

/// Stiffness of the specimen, N/m.
const STIFFNESS: f64 = 200.0;

fn spring() -> PressedSpecimen {
    PressedSpecimen {
        matter: SpecimenMatter::SpringPot {
            size: 1e4,
            order: 0.0,
        },
        shape_m: STIFFNESS / 1e4,
        map: None,
    }
}

/// A force, whatever the position, N.
struct Constant(f32);

impl Environment<f32, 1> for Constant {
    type History = ();

    fn at_rest(&self) {}

    fn force(&self, (): &(), _: &SVector<f32, 1>) -> SVector<f32, 1> {
        [self.0].into()
    }

    fn advance(&self, (): &mut (), _: &SVector<f32, 1>) {}
}

/// A second with a force of 0.5 N at 1 kHz, from the start of a run: the last position and sensed force, and the sensed force before.
fn commanded<H: Hardware<Setup: FitsDevice> + Touched<1>>(
    board: &mut Embodied<H, 1>,
    simulation: &Simulation,
) -> [f32; 3] {
    let mut setup = PlantSetup::prepare(simulation, 1000).expect("a plant");
    board.fit(&mut setup).expect("fits");
    board.install(setup, 1000);
    board.restart();
    board.idle().expect("idle");
    let [idle_n] = board.sense();
    let limits = SafetyLimits::bare(Newtons(50.0), NewtonsPerSecond(1e6));
    let chain = SafetyChain::from_limits(&limits, Seconds(1e-3)).expect("a chain");
    let mut controller = Controller::new(Constant(0.5), chain);
    let mut engaged = controller.engage(&mut *board);
    let ticks = (0..1000).map(|_| engaged.tick().expect("runs").reading.position_m[0]);
    let position_m = ticks.last().expect("a thousand");
    drop(engaged);
    [position_m, board.sense()[0], idle_n]
}

const FREE: Simulation = Simulation {
    kind: SimulationKind::MassDamper,
    mass_kg: 0.065,
    damping_n_s_per_m: 10.0,
    ..Simulation::REAL
};

#[test]
fn a_free_handle_presses_the_specimen_and_one_with_a_hand_does_not() {
    let sensor = Some(ForceSensorConfig {
        range: Newtons(20.0),
        noise: Newtons(0.0),
        lag: Seconds(0.0),
        offset: Newtons(0.25),
        seed: 1,
    });
    let body = Body {
        plant: MassDamperConfig {
            friction: Newtons(0.0),
            ..MassDamperConfig::ideal(Kilograms(0.1), NewtonSecondsPerMetre(10.0), Seconds(1e-3))
        },
        encoder_resolution: Metres(0.0),
        noise: (Metres(0.0), 0),
    };
    for body in [None, Some(body)] {
        let board = PressingBoard::new("test", &AtHandle::Specimen(spring())).expect("a board");
        let mut board = Embodied::new(board, body, sensor).expect("a board");
        // Twice: the specimen of the second run was never pressed.
        for _ in 0..2 {
            let [position_m, sensed_n, idle_n] = commanded(&mut board, &FREE);
            let rest_m = 0.5 / STIFFNESS;
            assert!(
                (f64::from(position_m) - rest_m).abs() < 1e-6,
                "{position_m}"
            );
            // It pushes the handle out; idle the sensor shows its offset.
            assert!((sensed_n - (0.25 - 0.5)).abs() < 1e-4, "{sensed_n}");
            assert!((idle_n - 0.25).abs() < 1e-6, "{idle_n}");
        }
        // A hand pushes from the start: as on a board without a specimen, to the bit.
        let pushed = Simulation {
            push_n: -1.0,
            ..FREE
        };
        let plain = Embodied::new(SimulatedPlant::new("test", || 0), body, sensor);
        let mut plain = plain.expect("a board");
        let [with, without] = [
            commanded(&mut board, &pushed),
            commanded(&mut plain, &pushed),
        ];
        assert_eq!(with.map(f32::to_bits), without.map(f32::to_bits));
        assert!(with[0] < 0.0, "{with:?}");
    }
}

#[test]
fn a_specimen_without_a_size_is_refused() {
    let flat = PressedSpecimen {
        shape_m: 0.0,
        ..spring()
    };
    let refused = PressingBoard::new("test", &AtHandle::Specimen(flat)).expect_err("no size");
    assert!(
        refused.to_string().contains("shape of the specimen"),
        "{refused}"
    );
}
