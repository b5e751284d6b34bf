//! A wall that a device hits and is pushed into.

use crate::{
    modelled_tissue::TissuePiece,
    position_controller::PositionController,
    position_law::PositionLaw,
    preflight::{Preflight, WallContact},
    pushed_trial::{PushedTrial, six_digits},
    robot,
    settling::Settling,
    setup::{Beside, TrialParts, TrialSetup, setup},
    tissue_table::{linear_piece, scheme},
    trial::{VirtualWall, thrown, wall_at_start},
};
use fracdiff::{Differintegrator as _, FrequencyResponse as _, Operator, Order, Scheme};
use haptic_analysis::{AdmittanceWorld, Dynamics};
use haptic_document::{
    Failure, FileError, Table, bad_input,
    parameters::{LOOP, Parameter, UNNAMED_PIECE},
};
use haptic_link::LoopMode;
use haptic_loop::{Controller, Limit, OwnPush, Pushing, plant::run_wall};
use haptic_tissue::Model;
use haptic_trial::{
    GuardChoice,
    device_table::encoder_step,
    keys::wall::{
        DISSIPATION, MUST_BE_STABLE, ONE_SIDED, ORDER, STIFFNESS, WALL_CONTACT, WALL_TISSUE,
    },
    preflight::PreflightVerdict,
    tap::TappedLaw,
};
use serde_json::{Value, json};

/// A wall on a device that hits it and is pushed into it.
#[derive(Clone, Debug)]
pub struct WallTrial {
    /// Device, trial, safety and pace.
    pub setup: TrialSetup,
    /// μ, 0 to 2.
    pub order: Order,
    /// The model whose memory the operator is, for slow motion of the order μ; `None` for D^μ.
    pub model: Option<Model>,
    /// The piece of tissue that the law is of, if it is of one.
    pub tissue: Option<TissuePiece>,
    /// The controller in place of it all, for which μ = 1 and B = T only set the unit: of a design.
    pub controller: Option<Box<PositionController>>,
    /// Numerical scheme of the operator.
    pub scheme: Scheme,
    /// K, N/m, at least 0.
    pub stiffness_n_per_m: f64,
    /// B, N·s^μ/m, at least 0.
    pub dissipation_n_s_mu_per_m: f64,
    /// It pulls, or only pushes.
    pub contact: WallContact,
}

/// The contact that a table asks for.
///
/// # Errors
/// Two keys that contradict each other.
pub fn contact(table: &Table<'_>) -> Result<WallContact, FileError> {
    let one_sided = table.flag(&ONE_SIDED)?;
    let contact = table.choice(&WALL_CONTACT)?;
    if contact == WallContact::OneSided {
        return Ok(WallContact::of(one_sided));
    }
    if table.has(&ONE_SIDED) && !one_sided {
        return Err(table.fail_at(
            WALL_CONTACT.key,
            "contact = \"signed\" never pulls, and one_sided = false does: omit one",
        ));
    }
    Ok(contact)
}

/// The piece of tissue that a table asks for in place of order, K and B; one that is given over a file takes the place of what that says.
fn tissue(table: &Table<'_>) -> Result<Option<TissuePiece>, FileError> {
    let is_tissue = !table.text(&WALL_TISSUE)?.is_empty();
    let over = table.is_given(&WALL_TISSUE);
    let (idle, why) = if is_tissue {
        let why = format!("with {WALL_TISSUE}, which brings its own: omit one of them");
        (&[ORDER, STIFFNESS, DISSIPATION][..], why)
    } else {
        (
            UNNAMED_PIECE,
            format!("without {WALL_TISSUE}: give that, or omit it"),
        )
    };
    let is_idle = |key: &&Parameter| table.is_given(key) || table.has(key) && !over;
    if let Some(Parameter { key, .. }) = idle.iter().find(is_idle) {
        return Err(table.fail_at(key, format_args!("{key} has no effect {why}")));
    }
    is_tissue.then(|| linear_piece(table)).transpose()
}

/// `[wall]`: device, wall and trial, with the table of a second device that pushes.
///
/// # Errors
/// A missing or wrong key, or values of which no loop can be made: with file and line.
pub fn wall(
    table: &Table<'_>,
    beside: Beside<'_>,
    at_port: [Option<LoopMode>; 2],
) -> Result<WallTrial, FileError> {
    let setup = setup(table, &MUST_BE_STABLE, beside, at_port)?;
    let piece = tissue(table)?;
    let material = piece.as_ref().map(|piece| &piece.material);
    let order = match material {
        Some(material) => material.order(),
        None => table.order(&ORDER)?,
    };
    let (t, duration_s) = (setup.device.sample_time.0, setup.plan.duration_s);
    let model = material.and_then(|material| material.composed()).cloned();
    let scheme = scheme(table, model.as_ref(), order, t, duration_s)?;
    let (stiffness, dissipation) = match &piece {
        Some(piece) => piece.spring_and_damper(),
        None => (table.required(&STIFFNESS)?, table.required(&DISSIPATION)?),
    };
    let contact = contact(table)?;
    if contact == WallContact::Signed {
        let key = WALL_CONTACT.key;
        if stiffness <= 0.0 {
            let reason = "contact = \"signed\" without stiffness would push anywhere in front of the wall: give stiffness_n_per_m above 0 N/m";
            return Err(table.fail_at(key, reason));
        }
        if setup.at_port == Some(LoopMode::Device) {
            let host = LOOP.set_to("host");
            return Err(table.fail_at(
                key,
                format_args!(
                    "no board runs contact = \"signed\" in its own loop: give {host}, or omit it"
                ),
            ));
        }
    }
    let wall = WallTrial {
        contact,
        model,
        tissue: piece,
        ..WallTrial::linear(setup, order, scheme, stiffness, dissipation)
    };
    (wall.parts()).map_err(|error| table.fail(error))?;
    Ok(wall)
}

impl WallTrial {
    /// A linear wall of K in N/m and B in N·s^μ/m, and nothing else.
    pub const fn linear(
        setup: TrialSetup,
        order: Order,
        scheme: Scheme,
        stiffness_n_per_m: f64,
        dissipation_n_s_mu_per_m: f64,
    ) -> Self {
        Self {
            setup,
            order,
            model: None,
            tissue: None,
            controller: None,
            scheme,
            stiffness_n_per_m,
            dissipation_n_s_mu_per_m,
            contact: WallContact::Linear,
        }
    }

    /// The loop as the analysis sees it, with a memory for so many samples.
    #[must_use]
    pub fn look(&self, samples: u64) -> Preflight<'_> {
        Preflight {
            stiffness_n_per_m: self.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: self.dissipation_n_s_mu_per_m,
            order: self.order,
            model: self.model.as_ref(),
            scheme: self.scheme,
            sample_time_s: self.setup.device.sample_time.0,
            samples,
            map: None,
            contact: self.contact,
            guarded: self.setup.safety.guard == GuardChoice::EnergyBounding,
        }
    }

    /// The law with this operator.
    fn pushing(&self, operator: Operator<f64>) -> Result<Pushing<VirtualWall>, Failure> {
        let (k, b) = (self.stiffness_n_per_m, self.dissipation_n_s_mu_per_m);
        let wall = wall_at_start(k, b, operator, self.contact).map_err(Failure::input)?;
        Ok(Pushing::new(wall, self.contact == WallContact::Linear))
    }

    /// The wall as the motor taps it that renders it and pushes, in the device's own loop.
    #[must_use]
    pub fn tapped(&self) -> Option<TappedLaw> {
        let setup = &self.setup;
        let wall = [self.stiffness_n_per_m, self.dissipation_n_s_mu_per_m];
        let there = setup.at_port == Some(LoopMode::Device);
        let tapped = (setup.plan()).tapped(&setup.device, wall, self.order, self.contact);
        // The swing of a tapped K + B·D^μ is known, that of a model is not.
        tapped.filter(|_| there && self.model.is_none())
    }

    /// The law for so many samples, and its verdict on such a device.
    ///
    /// # Errors
    /// As [`Preflight::verdict`]; parameters of which no law can be made.
    pub fn judged_law(
        &self,
        samples: u64,
        dynamics: Dynamics,
        line: usize,
    ) -> Result<(Pushing<VirtualWall>, PreflightVerdict), Failure> {
        let look = self.look(samples);
        let law = self.pushing(look.operator()?)?;
        Ok((law, look.verdict(dynamics, line)?))
    }

    /// The loop of a controller.
    fn parts_of(
        &self,
        controller: &PositionController,
    ) -> Result<TrialParts<OwnPush<f64, PositionLaw>>, Failure> {
        let (setup, plan) = (&self.setup, self.setup.plan());
        let t = setup.device.sample_time;
        let standing = controller.stiffness_n_per_m(plan.window_s)?;
        let hand = setup.device.stiffness.0;
        let encoder_step_m = encoder_step(setup.sensors);
        let judge = PositionLaw::judge(controller, [1.0, standing], &plan, hand, encoder_step_m);
        let judge = judge.ok_or_else(|| Failure::run("it pushes the device away"))?;
        let spring = standing + hand;
        let law = PositionLaw::new(controller, 1.0).map_err(Failure::input)?;
        Ok(TrialParts {
            controller: Controller::new(OwnPush::new(law, plan.own_push_n()), setup.chain()?),
            device: setup.sensed()?,
            samples: plan.samples(t)?,
            judge,
            rest_m: if controller.integrates {
                Some(0.0)
            } else {
                (spring > 0.0).then(|| plan.push_n / spring)
            },
        })
    }

    /// push/(K + k + B·T^(−μ)·P(1)), m: P(1), the gain of the operator at rest, is 1 for the identity, 0
    /// for a good derivative, and something else for one that forgets.
    fn expected_deflection(&self, operator: &Operator<f64>) -> Result<Option<f64>, Failure> {
        let rate = self.setup.device.sample_time.rate_to_the(self.order);
        let at_rest = operator.response(0.0).re * rate.map_err(Failure::input)?;
        let spring = self.stiffness_n_per_m
            + self.setup.device.stiffness.0
            + self.dissipation_n_s_mu_per_m * at_rest;
        Ok(Some(self.setup.plan.push_n / spring).filter(|x| x.is_finite() && spring > 0.0))
    }
}

impl PushedTrial for WallTrial {
    type Law = OwnPush<f64, Pushing<VirtualWall>>;
    const KIND: &'static str = "wall";
    const NO_REST: &'static str = "no spring holds the push, so there is no rest position";
    const MUST_BE_STABLE: Parameter = MUST_BE_STABLE;
    const REFUSED: &'static str = " and analysis do not both call the wall stable";

    fn setup(&self) -> &TrialSetup {
        &self.setup
    }

    fn setup_mut(&mut self) -> &mut TrialSetup {
        &mut self.setup
    }

    fn judge(
        &self,
        samples: u64,
        dynamics: Dynamics,
        line: usize,
    ) -> Result<PreflightVerdict, Failure> {
        let look = self.look(samples);
        let Some(robot) = &self.setup.robot else {
            return look.proved(dynamics, line);
        };
        let operator = look.loop_operator()?;
        let world = AdmittanceWorld {
            stiffness_n_per_m: self.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: self.dissipation_n_s_mu_per_m,
            operator: &operator,
            delay_samples: line,
        };
        robot::verdict(robot, world)
    }

    fn tried(&self) -> Result<Settling, Failure> {
        if let Some(controller) = &self.controller {
            return self.parts_of(controller).map(TrialParts::tried);
        }
        let mut parts = self.parts()?;
        if self.setup.second.is_some() || self.setup.robot.is_some() {
            return Ok(parts.tried());
        }
        // A design tries hundreds of walls alone on the device: by the loop that is compiled for them, optimised in every build.
        let thrown = thrown(self.setup.device, &self.setup.plan())?;
        let mut device = self.setup.sensors.before(thrown)?;
        let see = &mut |time_s, x, f| parts.judge.see(time_s, x, f);
        let whole = run_wall(&mut parts.controller, &mut device, parts.samples, see);
        Ok(parts.judge.settling(whole, parts.rest_m))
    }

    fn operator_choice(&self) -> (Order, Scheme) {
        (self.order, self.scheme)
    }

    fn law_in_words(&self) -> String {
        let name = (self.tissue.as_ref()).map(|piece| format!("{} · ", piece.material.name));
        name.unwrap_or_default()
            + &format!(
                "order μ = {} · K = {} N/m · B = {} N·s^μ/m",
                self.order,
                six_digits(self.stiffness_n_per_m),
                six_digits(self.dissipation_n_s_mu_per_m)
            )
            + match self.contact {
                WallContact::Linear => "",
                WallContact::OneSided => " · only pushes",
                WallContact::Signed => " · only pushes, signed",
            }
    }

    fn hits(&self) -> Vec<f64> {
        let TrialSetup { plan, at_port, .. } = &self.setup;
        let most = self.setup.safety.number(Limit::Speed);
        let hits = plan.hits(self.contact);
        // A serial device and a robot cannot be thrown, and beyond its speed limit a hit is a fault.
        let is_thrown = at_port.is_none() && self.setup.robot.is_none();
        let may_be = |hit: &f64| is_thrown && most.is_none_or(|most| *hit < most);
        hits.filter(may_be).collect()
    }

    fn parts(&self) -> Result<TrialParts<Self::Law>, Failure> {
        let t = self.setup.device.sample_time;
        if self.order.get() < 0.0 {
            return Err(bad_input!(
                "order {} is not in [0, 2]: a wall has no integral",
                self.order
            ));
        }
        let plan = self.setup.plan();
        let samples = plan.samples(t)?;
        let device = self.setup.sensed()?;
        let operator = self.look(samples).operator()?;
        // B of a slow element may be large beside what its memory resists in a sample.
        let rate = match self.model {
            Some(_) => operator.direct_gain(),
            None => t.rate_to_the(self.order).map_err(Failure::input)?,
        };
        let (k, b) = (self.stiffness_n_per_m, self.dissipation_n_s_mu_per_m);
        let known = &self.setup.device;
        let step_m = self.setup.step_m(k + known.stiffness.0);
        let step = k + b * rate;
        let judge = plan.judge(k + known.stiffness.0, step, step_m, t.0);
        let judge = judge.tapped(self.tapped().as_ref(), step_m, step);
        let rest_m = self.expected_deflection(&operator)?;
        let law = OwnPush::new(self.pushing(operator)?, plan.own_push_n());
        Ok(TrialParts {
            controller: Controller::new(law, self.setup.chain()?),
            device,
            samples,
            judge,
            rest_m,
        })
    }

    fn law_in_rows(&self, settling: &Settling, _: Option<f64>) -> Value {
        let (pull_n, position_m) = settling.largest_pull;
        // A tap pulls, too.
        let pulls = self.contact == WallContact::Linear && settling.swings.is_none();
        json!({
            "stiffness_n_per_m": self.stiffness_n_per_m,
            "dissipation_n_s_mu_per_m": self.dissipation_n_s_mu_per_m,
            "contact": self.contact,
            // Largest force with which a linear wall pulled the device in, and where: below 0 in front of the wall.
            "largest_pull_n": pulls.then_some(pull_n),
            "largest_pull_position_m": (pulls && pull_n > 0.0).then_some(position_m),
        })
    }
}

#[cfg(test)]
mod tests;
