//! The stable walls of a device of one's own: motor and handle with a springy shaft between them.
//!
//! ```text
//! m₁x₁'' = f − b₁x₁' − k(x₁ − x₂) − c(x₁' − x₂'),   m₂x₂'' = k(x₁ − x₂) + c(x₁' − x₂') − b₂x₂',   the encoder sees x₁
//! cargo run -p haptic-analysis --example own_plant
//! ```

use fracdiff::{Order, Scheme, Seconds};
use haptic_analysis::{
    ForcePath, LoopOperator, Nondimensional, SampledLoop, SampledPlant, StabilityRegion,
};
use std::error::Error;

const SAMPLE_TIME_S: f64 = 1e-3;
const MOTOR_KG: f64 = 0.05;
const HANDLE_KG: f64 = 0.04;

/// A shaft of stiffness k, N/m, and damping c, N·s/m.
fn device(k: f64, c: f64, path: ForcePath) -> Result<SampledPlant, Box<dyn Error>> {
    let (b1, b2) = (2.0, 1.5);
    // States: x₁, v₁, x₂, v₂.
    #[rustfmt::skip]
    let a = [
        0.0,            1.0,                   0.0,            0.0,
        -k / MOTOR_KG,  -(b1 + c) / MOTOR_KG,  k / MOTOR_KG,   c / MOTOR_KG,
        0.0,            0.0,                   0.0,            1.0,
        k / HANDLE_KG,  c / HANDLE_KG,         -k / HANDLE_KG, -(b2 + c) / HANDLE_KG,
    ];
    let b = [0.0, 1.0 / MOTOR_KG, 0.0, 0.0];
    let c = [1.0, 0.0, 0.0, 0.0];
    // The mass only scales: α = KT²/m.
    Ok(SampledPlant::linear(
        &a,
        &b,
        &c,
        SAMPLE_TIME_S,
        MOTOR_KG,
        path,
    )?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let order = Order::new(0.8)?;
    let operator = LoopOperator::new(Scheme::Exact, order, Seconds(SAMPLE_TIME_S), 1e4)?;
    // A third of a sample late, and a motor current that follows within half a sample.
    let path = ForcePath::new(0.33, 0.5)?;
    for (name, k, c) in [("stiff shaft", 200e3, 5.0), ("springy shaft", 5e3, 0.5)] {
        let plant = device(k, c, path)?;
        let region = StabilityRegion::new(plant, &operator, 0, 1000)?;
        let area = region.bounded().ok_or("no wall is stable")?;
        let stiffest = area.alpha_max * MOTOR_KG / (SAMPLE_TIME_S * SAMPLE_TIME_S);
        println!(
            "{name}: the stiffest wall has K = {:.2} kN/m",
            1e-3 * stiffest
        );
        // The region agrees with a verdict on either side of its edge.
        for (share, stable) in [(0.99, true), (1.01, false)] {
            let (alpha, beta) = (share * area.alpha_max, area.beta_at_alpha_max);
            let subject = SampledLoop::with_plant(plant, alpha, beta, &operator)?;
            assert_eq!(subject.is_stable(), stable, "{name}, {share} of the edge");
        }
    }
    // A rigid shaft is a single mass.
    let rigid = device(2e7, 50.0, path)?;
    let both = MOTOR_KG + HANDLE_KG;
    let wall = Nondimensional {
        alpha: 0.1,
        beta: 0.3,
        delta: 3.5 * SAMPLE_TIME_S / both,
        gamma: 0.0,
    };
    let single = SampledPlant::behind(wall.delta, 0.0, path)?;
    let one = SampledLoop::with_plant(single, wall.alpha, wall.beta, &operator)?.verdict();
    let scale = MOTOR_KG / both;
    let gains = (wall.alpha / scale, wall.beta / scale);
    let two = SampledLoop::with_plant(rigid, gains.0, gains.1, &operator)?.verdict();
    println!(
        "as one mass: {}, through a rigid shaft: {}",
        one.stable, two.stable
    );
    assert_eq!(one.stable, two.stable);
    Ok(())
}

#[test]
fn it_runs() {
    main().expect("runs");
}
