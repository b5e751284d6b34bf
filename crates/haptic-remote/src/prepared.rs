//! Controller from a configuration on the wire: everything that can be refused is refused here.

use crate::{
    hardware::{Hardware, PlantSetup as _},
    limits::{Fields, chain_limits},
    records::FLIGHT_SAMPLES,
};
use fracdiff::{
    PortableOperator,
    portable::{Form, ListError},
};
use haptic_link::{
    Capabilities, Conduct, Configuration, DigestBuilder, Field, GuardKind, Limits, OperatorForm,
    Refusal,
};
use haptic_loop::{
    DepthMap, OwnPush, SafetyChain, Tap, Wall, WallShape,
    units::{Metres, Seconds},
};

/// Most coefficients of an operator on a device: taps of a finite memory.
pub const COEFFICIENTS_MAX: usize = 256;
/// Most modes of a full memory.
pub const MODES_MAX: usize = 48;
/// Largest degree of a recursion, most sections.
pub const DEGREE_MAX: usize = 16;

/// Abilities of a real board with `axes` axes, as far as this crate knows them. The board adds its own: forces, in N and
/// N/s, the sensor's resolution, in m, the range of a force sensor, in N, other periods than 100 µs to 10 ms, and that it holds the last force where nothing lets go.
#[must_use]
pub const fn abilities(board: &str, axes: u8) -> Capabilities {
    Capabilities {
        board: Capabilities::board_name(board),
        axes,
        simulated: false,
        tick_period_min_us: 100,
        tick_period_max_us: 10_000,
        force_max_n: 0.0,
        force_rate_max_n_per_s: 0.0,
        position_resolution_m: 0.0,
        sensed_force_max_n: 0.0,
        coefficients_max: COEFFICIENTS_MAX as u16,
        modes_max: MODES_MAX as u16,
        degree_max: DEGREE_MAX as u16,
        flight_samples: FLIGHT_SAMPLES as u16,
        image_digest: 0,
        lets_go_alone: Conduct {
            lets_go: true,
            moves: false,
            to_measure: false,
        },
    }
}

/// The time allowed for a controller in a process of a computer, ten times the most that was
/// measured.
#[cfg(feature = "std")]
pub const CONTROLLER_COST: haptic_link::ControllerCost = haptic_link::ControllerCost {
    tick_us: 100,
    coefficient_ns: 50,
};

/// The operator of a device.
pub type DeviceOperator = PortableOperator<f32, COEFFICIENTS_MAX, MODES_MAX, DEGREE_MAX>;
/// The environment of a device.
pub type DeviceWall = OwnPush<f32, Wall<f32, DeviceOperator>>;

/// A good configuration, ready to take effect. Operator and history are built in place, so memory
/// for a second copy is never needed.
#[derive(Clone, Debug)]
pub struct Prepared<S> {
    pub(super) configuration: Configuration,
    pub(super) digest: u32,
    pub(super) law: Law,
    pub(super) chain: SafetyChain<f32>,
    pub(super) setup: S,
    /// Surface in front of the law.
    #[cfg(feature = "several-axes")]
    pub(super) surface: Option<haptic_link::SurfaceShape>,
    /// Controller in the place of the law.
    #[cfg(feature = "controllers")]
    pub(super) controller: Option<haptic_link::ControllerLaw>,
}

/// A law that was checked: all that its wall is made of, but the coefficients.
#[derive(Clone, Copy, Debug)]
pub(super) struct Law {
    shape: WallShape<f32>,
    form: Form,
    integer: i8,
    own_push_n: Option<f32>,
    tap: Tap<f32>,
}

impl<S> Prepared<S> {
    /// Its safety chain, for [`TickSide::asleep`](crate::TickSide::asleep).
    #[must_use]
    pub const fn chain(&self) -> SafetyChain<f32> {
        self.chain
    }
}

impl Law {
    /// Makes a wall one of this law, in its place.
    #[inline(never)]
    pub(super) fn put(&self, wall: &mut DeviceWall, coefficients: &[f32]) {
        let wall = wall.reshape(self.own_push_n, self.tap);
        let operator = wall.reshape(self.shape, || DeviceOperator::SILENT);
        // They were checked.
        let _ = operator.replace(self.form, self.integer, coefficients);
    }

    pub(super) fn none() -> DeviceWall {
        OwnPush::new(Wall::of(WallShape::NONE, DeviceOperator::SILENT), None)
    }
}

/// Checks a configuration and prepares what a controller needs from it; nothing takes effect yet.
/// *Cost*: the checks, and the plant; no copy of the coefficients, no allocation.
///
/// # Errors
/// The first parameter that is not as this board needs it.
#[inline(never)]
pub fn prepare<H: Hardware<D>, const D: usize>(
    configuration: Configuration,
    coefficients: &[f32],
    capabilities: &Capabilities,
) -> Result<Prepared<H::Setup>, Refusal> {
    let limits = checked(&configuration, capabilities)?;
    // The setup needs the most memory. It comes first, while nothing else is there.
    let setup = H::Setup::prepare(&configuration.simulation, configuration.tick_period_us)?;
    let (law, chain) = built(&configuration, coefficients, &limits)?;
    Ok(Prepared {
        configuration,
        digest: digest(&configuration, coefficients).finish(),
        law,
        chain,
        setup,
        #[cfg(feature = "several-axes")]
        surface: None,
        #[cfg(feature = "controllers")]
        controller: None,
    })
}

/// Checks everything but coefficients and plant. Not generic, so that firmware compiled for speed has it small.
#[inline(never)]
pub(super) fn checked(
    configuration: &Configuration,
    capabilities: &Capabilities,
) -> Result<haptic_loop::SafetyLimits, Refusal> {
    let mut fields = Fields::default();
    let limits = &configuration.limits;
    let period = configuration.tick_period_us;
    let shortest = capabilities.tick_period_min_us as f32;
    let longest = capabilities.tick_period_max_us as f32;
    fields.within(Field::TickPeriod, period as f32, shortest, longest);
    let operator = configuration.operator;
    // As in the wire's table of forms.
    let most = match operator.form {
        OperatorForm::Taps => u32::from(capabilities.coefficients_max),
        OperatorForm::Modes => 16 + 2 * u32::from(capabilities.modes_max),
        OperatorForm::Recursion => 1 + 2 * u32::from(capabilities.degree_max),
    };
    let count = f32::from(operator.count);
    fields.within(Field::CoefficientCount, count, 1.0, most as f32);
    let [shortest, longest] = [Limits::WATCHDOG_MIN_MS, Limits::WATCHDOG_MAX_MS].map(f32::from);
    let (watchdog, age) = (limits.watchdog_ms.into(), limits.max_age_ticks.into());
    fields.within(Field::Watchdog, watchdog, shortest, longest);
    fields.within(Field::MaxAge, age, 1.0, Limits::MAX_AGE_TICKS.into());
    let chain = chain_limits(limits, period, capabilities, &mut fields);
    // It promises nothing where the device does not damp.
    if capabilities.lets_go_alone.moves && limits.guard.kind != GuardKind::Off {
        fields.refuse(Refusal::Unsupported(Field::GuardDamping));
    }
    let (stiffness, dissipation) = (
        configuration.stiffness_n_per_m,
        configuration.dissipation_n_s_mu_per_m,
    );
    fields.within(Field::Stiffness, stiffness, 0.0, f32::MAX);
    fields.within(Field::Dissipation, dissipation, 0.0, f32::MAX);
    fields.within(Field::Surface, configuration.surface_m, -f32::MAX, f32::MAX);
    own_push(configuration, &chain, &mut fields);
    if let Some(numbers) = configuration.depth_map {
        depth_map(&numbers, configuration.one_sided, &mut fields);
    }
    fields.done().map(|()| chain)
}

/// Checks the push of the device's own motor, alone and with its tap: below the largest force, in a workspace, below a speed.
#[inline(never)]
fn own_push(configuration: &Configuration, chain: &haptic_loop::SafetyLimits, fields: &mut Fields) {
    let (push, tap) = (configuration.own_push_n, configuration.tap_n);
    let most = configuration.limits.force_n;
    fields.within(Field::OwnPush, push, -most, most);
    fields.within(Field::OwnPush, push + tap, -most, most);
    let is_pushed = push.abs() + tap.abs() != 0.0;
    if is_pushed && (chain.workspace.is_none() || chain.speed.is_none()) {
        fields.refuse(Refusal::Unsupported(Field::OwnPush));
    }
}

/// Checks a map of the depth: its scale and the sum of its terms above 0, and a surface to measure the depth from.
#[inline(never)]
fn depth_map(numbers: &[f32; 8], one_sided: bool, fields: &mut Fields) {
    for &number in numbers {
        fields.within(Field::DepthMap, number, 0.0, f32::MAX);
    }
    let [per_scale, terms @ .., _] = numbers;
    for above_zero in [*per_scale, terms.iter().sum()] {
        fields.within(Field::DepthMap, above_zero, f32::MIN_POSITIVE, f32::MAX);
    }
    if !one_sided {
        fields.refuse(Refusal::Unsupported(Field::DepthMap));
    }
}

#[inline(never)]
fn built(
    configuration: &Configuration,
    coefficients: &[f32],
    limits: &haptic_loop::SafetyLimits,
) -> Result<(Law, SafetyChain<f32>), Refusal> {
    let integer = configuration.operator.integer;
    let form = match configuration.operator.form {
        OperatorForm::Taps => Form::Taps,
        OperatorForm::Modes => Form::Modes,
        OperatorForm::Recursion => Form::Recursion,
    };
    DeviceOperator::check(form, integer, coefficients).map_err(refused)?;
    let surface = f64::from(configuration.surface_m);
    let surface = configuration.one_sided.then_some(Metres(surface));
    let stiffness = f64::from(configuration.stiffness_n_per_m);
    let dissipation = f64::from(configuration.dissipation_n_s_mu_per_m);
    // Everything was checked above; whatever a constructor finds beyond that has no field of its own.
    let shape = WallShape::new(stiffness, dissipation, surface)
        .map_err(|_| Refusal::Unsupported(Field::Other))?
        .with_depth_map(configuration.depth_map.and_then(DepthMap::of));
    let sample_time = Seconds(f64::from(configuration.tick_period_us) * 1e-6);
    let chain = safety_chain(limits, sample_time)?;
    let law = Law {
        shape,
        form,
        integer,
        own_push_n: Some(configuration.own_push_n).filter(|push| *push != 0.0),
        tap: Tap {
            force_n: configuration.tap_n,
            ticks: configuration.tap_ticks,
        },
    };
    Ok((law, chain))
}

/// The digest so far, before what is staged beside a configuration.
#[inline(never)]
pub(super) fn digest(configuration: &Configuration, coefficients: &[f32]) -> DigestBuilder {
    DigestBuilder::new(configuration).coefficients(coefficients)
}

/// The chain in single precision. Not generic, so that it is compiled here, for size, and not with the tick.
#[inline(never)]
pub(super) fn safety_chain(
    limits: &haptic_loop::SafetyLimits,
    sample_time: Seconds,
) -> Result<SafetyChain<f32>, Refusal> {
    SafetyChain::from_limits(limits, sample_time).map_err(|_| Refusal::Unsupported(Field::Other))
}

/// The coefficients of an operator as they go over the wire.
///
/// # Errors
/// More of them than the wire can count: a memory too long for any device. The scheme
/// `full-bdf2`, which devices do not know.
#[cfg(feature = "std")]
pub fn operator_shape(
    operator: &fracdiff::Operator<f32>,
) -> Result<(haptic_link::OperatorShape, std::vec::Vec<f32>), haptic_loop::LoopParameterError> {
    let Some(list) = operator.list() else {
        let what = "convergence order of the scheme";
        let allowed = "1, as of all that a device runs: use full in place of full-bdf2";
        return Err(haptic_loop::RangeError::new(what, 2.0, allowed, "").into());
    };
    let count = list.values.len();
    let shape = haptic_link::OperatorShape {
        form: match list.form {
            Form::Taps => OperatorForm::Taps,
            Form::Modes => OperatorForm::Modes,
            Form::Recursion => OperatorForm::Recursion,
        },
        integer: list.integer,
        count: u16::try_from(count).map_err(|_| {
            let what = "number of coefficients for a device";
            let allowed = "at most 65535: use a full memory";
            haptic_loop::RangeError::new(what, count as f64, allowed, "")
        })?,
    };
    Ok((shape, list.values))
}

#[inline(never)]
pub(super) fn refused(error: ListError) -> Refusal {
    match error {
        ListError::IntegerPart(integer) => {
            Refusal::range(Field::IntegerPart, f32::from(integer), -2.0, 2.0)
        }
        ListError::Count { count, most } => {
            Refusal::range(Field::CoefficientCount, count as f32, 1.0, most as f32)
        }
        ListError::Value { value, .. } => {
            Refusal::range(Field::Coefficient, value as f32, -f32::MAX, f32::MAX)
        }
        ListError::Decay { value, .. } => {
            // The least number above 0: a range of the wire has its ends in it.
            Refusal::range(Field::Coefficient, value as f32, f32::from_bits(1), 1.0)
        }
        _ => Refusal::Unsupported(Field::Coefficient),
    }
}
