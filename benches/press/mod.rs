//! A loop that presses into tissue.

use crate::input::{BATCH, SAMPLE_TIME, order, ramp_and_hold};
use fractional_haptics::fracdiff::{Differintegrator, Operator, Real, Scheme};
use fractional_haptics::haptic_loop::units::{
    Kilograms, Metres, NewtonSecondsPerMetre, Pascals, SquareMetres,
};
use fractional_haptics::haptic_loop::{
    Contact, Device, EnergyBounding, Modulus, PassivityGuard, PassivityObserver, Reading,
    SafeForce, SafetyLimits, Specimen, SpringDamper, Tissue, Workspace,
};
use nalgebra::SVector;
use std::convert::Infallible;
use std::error::Error;

/// None, and both: the bounding has work, for the tissue is some three times stiffer than 2ρb/T = 80 N/m.
pub(crate) fn guards() -> [(&'static str, Option<PassivityGuard>); 3] {
    let (mass, damping) = (Kilograms(0.065), NewtonSecondsPerMetre(0.05));
    let observer = PassivityObserver::bearable(mass, SAMPLE_TIME);
    let bounding = EnergyBounding::of(damping);
    [
        ("no guard", None),
        ("observer", Some(PassivityGuard::Observer(observer))),
        (
            "energy bounding",
            Some(PassivityGuard::EnergyBounding(bounding)),
        ),
    ]
}

/// Every limit that there is.
pub(crate) fn whole(guard: Option<PassivityGuard>) -> SafetyLimits {
    SafetyLimits {
        workspace: Some(Workspace {
            low: Metres(-0.05),
            high: Metres(0.05),
            soft: Metres(0.01),
        }),
        guard,
        ..SafetyLimits::default()
    }
}

pub(crate) fn operator<F: Real>(scheme: &str, horizon: f64) -> Result<Operator<F>, Box<dyn Error>> {
    Ok(scheme
        .parse::<Scheme>()?
        .build(order(), SAMPLE_TIME, horizon)?)
}

pub(crate) fn tissue<F: Real, O: Differintegrator<F>>(
    operator: O,
) -> Result<SpringDamper<F, O>, Box<dyn Error>> {
    let prostate = Tissue::new(Pascals(0.0), 8650.0, order())?;
    let specimen = Specimen::slab(SquareMetres(4e-4), Metres(0.02))?;
    let shape = specimen.shape(Modulus::Young);
    let (stiffness, dissipation) = (
        prostate.elastic_modulus().0,
        prostate.viscosity_pa_s_alpha(),
    );
    Ok(SpringDamper::new(
        shape * stiffness,
        shape * dissipation,
        operator,
    )?)
}

pub(crate) fn contact<F: Real, O: Differintegrator<F>, const D: usize>(
    direction: [f64; D],
    operator: O,
) -> Result<Contact<F, SpringDamper<F, O>, D>, Box<dyn Error>> {
    Ok(Contact::new(direction, Metres(0.0), tissue(operator)?)?)
}

/// A device that goes its own way and keeps the force.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scripted<F, const D: usize> {
    script: [F; BATCH],
    tick: usize,
    force: SVector<F, D>,
}

impl<F: Real, const D: usize> Scripted<F, D> {
    pub(crate) fn new() -> Self {
        Self {
            script: ramp_and_hold(),
            tick: 0,
            force: SVector::from([F::ZERO; D]),
        }
    }
}

impl<F: Real, const D: usize> Device<F, D> for Scripted<F, D> {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<F, D>, Infallible> {
        Ok(Reading {
            tick: self.tick as u64,
            time_s: self.tick as f64 * SAMPLE_TIME.0,
            position_m: SVector::from([self.script[self.tick]; D]),
        })
    }

    fn write(&mut self, force: SafeForce<F, D>) -> Result<(), Infallible> {
        self.force = *force.newtons();
        self.tick = (self.tick + 1) % BATCH;
        Ok(())
    }
}
