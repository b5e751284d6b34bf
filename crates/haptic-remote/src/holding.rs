//! A controller that holds a device of one axis on its way, in place of a wall.
//!
//! ```text
//! r[n] = r·(n/N) for n < N, then r        N ticks of the ramp, r m
//! f[n] = C(r[n], x[n])                    within the limits of the law, N; what was really sent goes into the history
//! ```
//! *Start-up*: as if the device had stood where it is for ever, held there by no force; n = 0. *Cost* of a tick: that of the [`PortableController`].

use crate::{
    limits::{FAR, Fields},
    prepared::{MODES_MAX, Prepared, refused},
};
use fractional_control::{
    PortableController, PortableControllerHistory, PortableForm, PortablePart,
};
use haptic_link::{
    CONTROLLER_PARTS, Capabilities, ControllerCost, ControllerLaw, Field, LoopMode, OperatorForm,
    Refusal,
};

#[derive(Debug)]
pub(crate) struct Holding {
    controller: PortableController<f32, MODES_MAX>,
    reference_m: f32,
    ramp_ticks: u32,
}

/// History of [`Holding`].
#[derive(Clone, Debug)]
pub(crate) struct HoldingHistory {
    past: PortableControllerHistory<f32, MODES_MAX>,
    tick: u32,
}

impl Holding {
    /// # Errors
    /// Coefficients that are not those of the law.
    #[inline(never)]
    pub(crate) fn new(law: &ControllerLaw, values: &[f32]) -> Result<Self, Refusal> {
        let mut parts = [PortablePart::default(); CONTROLLER_PARTS];
        for (part, layout) in parts.iter_mut().zip(&law.parts) {
            *part = PortablePart {
                integer: layout.integer,
                values: usize::from(layout.values),
                filter: usize::from(layout.filter),
            };
        }
        let form = match law.form {
            haptic_link::ControllerForm::Parallel => PortableForm::Parallel,
            haptic_link::ControllerForm::Lead => PortableForm::Lead { sections: 0 },
            haptic_link::ControllerForm::LeadOfOne => PortableForm::Lead { sections: 1 },
            haptic_link::ControllerForm::LeadOfTwo => PortableForm::Lead { sections: 2 },
        };
        let parts = parts.get(..law.parts.len()).unwrap_or_default();
        let limits = [law.low_n, law.high_n];
        let controller = PortableController::new(form, parts, values, limits).map_err(refused)?;
        Ok(Self {
            controller,
            reference_m: law.reference_m,
            ramp_ticks: law.ramp_ticks,
        })
    }

    #[inline(never)]
    pub(crate) fn at_rest(&self) -> HoldingHistory {
        HoldingHistory {
            past: self.controller.at_rest(),
            tick: 0,
        }
    }

    /// See [`Environment::settle`](haptic_loop::Environment::settle).
    #[inline(never)]
    pub(crate) fn settle(&self, history: &mut HoldingHistory, position_m: f32) {
        let settled = (self.controller).settled(position_m, position_m, 0.0);
        // No error, so every form rests.
        if let Some(settled) = settled {
            history.past = settled;
        }
    }

    #[inline]
    fn reference_m(&self, tick: u32) -> f32 {
        if tick < self.ramp_ticks {
            self.reference_m * (tick as f32 / self.ramp_ticks as f32)
        } else {
            self.reference_m
        }
    }

    #[inline]
    pub(crate) fn force_n(&self, history: &HoldingHistory, position_m: f32) -> f32 {
        let reference_m = self.reference_m(history.tick);
        self.controller
            .output(&history.past, reference_m, position_m)
    }

    #[inline]
    pub(crate) fn advance(&self, history: &mut HoldingHistory, position_m: f32, applied_n: f32) {
        let reference_m = self.reference_m(history.tick);
        (self.controller).advance(&mut history.past, reference_m, position_m, applied_n);
        history.tick = history.tick.saturating_add(1);
    }
}

impl<S> Prepared<S> {
    /// Replaces the law by a controller; `values` are its coefficients, and `digest` covers all.
    #[inline(never)]
    pub(crate) fn holding(
        self,
        law: ControllerLaw,
        values: &[f32],
        digest: u32,
        capabilities: &Capabilities,
        cost: Option<ControllerCost>,
    ) -> Result<Self, Refusal> {
        let configuration = &self.configuration;
        let operator = configuration.operator;
        let fits =
            configuration.loop_mode == LoopMode::Device && operator.form == OperatorForm::Taps;
        let Some(cost) = cost.filter(|_| fits) else {
            return Err(Refusal::Unsupported(Field::Other));
        };
        let mut fields = Fields::default();
        fields.within(
            Field::TickPeriod,
            configuration.tick_period_us as f32,
            cost.tick_period_min_us(operator.count) as f32,
            capabilities.tick_period_max_us as f32,
        );
        let most = 16 + 2 * capabilities.modes_max;
        for part in &law.parts {
            let count = f32::from(part.values);
            fields.within(Field::CoefficientCount, count, 0.0, f32::from(most));
        }
        fields.within(Field::Depth, law.reference_m, -FAR, FAR);
        fields.within(Field::ForceLimit, law.low_n, -f32::MAX, f32::MAX);
        fields.within(Field::ForceLimit, law.high_n, law.low_n.next_up(), f32::MAX);
        fields.done()?;
        // Nothing is kept of it: it is made anew in its place.
        Holding::new(&law, values)?;
        Ok(Self {
            digest,
            controller: Some(law),
            ..self
        })
    }
}

/// A controller as it goes over the wire: the shape of its coefficients, these, and the rest of it. The limits of the command are
/// those of the setup, within the force limit, N; the reference rises to `reference_m` in `ramp_ticks` ticks.
///
/// # Errors
/// A parameter of the controller outside its range; a controller that is given as a transfer function.
#[cfg(feature = "std")]
pub fn controller_law(
    setup: &fractional_control::ControllerSetup,
    reference_m: f32,
    ramp_ticks: u32,
    force_limit_n: f32,
) -> Result<
    (
        haptic_link::OperatorShape,
        std::vec::Vec<f32>,
        ControllerLaw,
    ),
    fractional_control::ControlError,
> {
    let list = fractional_control::ControllerList::<f32>::new(setup)?;
    let (form, parts, values) = list.portable();
    let parts = parts.iter().map(|part| haptic_link::ControllerPart {
        integer: part.integer,
        // Of some hundred at most.
        values: part.values as u16,
        filter: part.filter as u8,
    });
    let [low_n, high_n] = list.limits.map(|limit| limit as f32);
    let law = ControllerLaw {
        form: match form {
            PortableForm::Parallel => haptic_link::ControllerForm::Parallel,
            PortableForm::Lead { sections: 0 } => haptic_link::ControllerForm::Lead,
            PortableForm::Lead { sections: 1 } => haptic_link::ControllerForm::LeadOfOne,
            PortableForm::Lead { .. } => haptic_link::ControllerForm::LeadOfTwo,
        },
        reference_m,
        ramp_ticks,
        low_n: low_n.max(-force_limit_n),
        high_n: high_n.min(force_limit_n),
        parts: parts.collect(),
    };
    let shape = haptic_link::OperatorShape {
        form: OperatorForm::Taps,
        integer: 0,
        count: values.len() as u16,
    };
    Ok((shape, values, law))
}
