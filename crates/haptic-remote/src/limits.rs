//! The limits of a safety chain on the wire and in the chain.

use haptic_link::{Capabilities, Field, GuardKind, Refusal};
use haptic_loop::{
    EnergyBounding, Limit, MAX_GUARD_DELAY_SAMPLES, MAX_GUARD_LAG_SAMPLES, PassivityGuard,
    PassivityObserver, SafetyLimits, Workspace,
    units::{Metres, MetresPerSecond, NewtonSecondsPerMetre, Newtons, NewtonsPerSecond, Seconds},
};

/// Narrowest zone of braking, m or m/s: a share of a narrower one would have no digits.
const ZONE_MIN: f32 = 1e-6;
/// Furthest end of a workspace from zero, m.
pub(super) const FAR: f32 = haptic_link::Limits::PLACE_MOST_M;
/// Most noise of a position, m: with more of it nothing can be guarded.
const NOISE_MAX: f32 = 0.01;

/// The fields of a configuration; the first refusal is kept and returned at the end: each early return costs 20 B
/// of flash.
#[derive(Debug, Default)]
pub(super) struct Fields {
    first: Option<Refusal>,
}

impl Fields {
    #[inline(never)]
    pub(super) fn within(&mut self, field: Field, value: f32, least: f32, most: f32) -> f32 {
        let accepted = value >= least && value <= most;
        if !accepted {
            self.refuse(Refusal::range(field, value, least, most));
        }
        value
    }

    pub(super) fn refuse(&mut self, refusal: Refusal) {
        self.first.get_or_insert(refusal);
    }

    pub(super) fn done(self) -> Result<(), Refusal> {
        self.first.map_or(Ok(()), Err)
    }
}

/// The limits of the chain of a device, each within the range that its field states, or refused.
pub(super) fn chain_limits(
    limits: &haptic_link::Limits,
    tick_period_us: u32,
    capabilities: &Capabilities,
    fields: &mut Fields,
) -> SafetyLimits {
    let mut numbers = *limits;
    let mut chain = SafetyLimits::bare(Newtons(0.0), NewtonsPerSecond(0.0));
    for limit in Limit::ALL {
        let (value, field) = numbers.number(limit);
        let value = *value;
        // Braking within what the mass bears, as soon as that is known.
        if limit == Limit::Braking {
            continue;
        }
        let most = if limit == Limit::Force {
            capabilities.force_max_n
        } else if limit == Limit::ForceRate {
            capabilities.force_rate_max_n_per_s
        } else {
            limit.range()[1] as f32
        };
        fields.within(field, value, limit.least_for(value), most);
        limit.set(&mut chain, (value > 0.0).then_some(f64::from(value)));
    }
    let several = cfg!(feature = "several-axes") && capabilities.axes > 1;
    chain.norm = several.then_some(chain.force);
    chain.workspace = workspace(limits, fields);
    speed_zone(&mut chain, limits, fields);
    chain.device_delay_samples = u32::from(limits.device_delay_ticks);
    chain.guard = guard(&limits.guard, tick_period_us, fields);
    let most = chain.braking_max(Seconds(f64::from(tick_period_us) * 1e-6));
    let asked = limits.braking_n_s_per_m;
    let braking = fields.within(Field::Braking, asked, 0.0, most.0 as f32);
    // Rounding the bound may have taken it up.
    chain.braking = (braking > 0.0).then(|| NewtonSecondsPerMetre(f64::from(braking).min(most.0)));
    chain
}

/// 0, or at least as wide as the narrowest zone.
fn zone(field: Field, width: f32, most: f32, fields: &mut Fields) -> f32 {
    let least = if width > 0.0 { ZONE_MIN } else { 0.0 };
    fields.within(field, width, least, most)
}

fn workspace(limits: &haptic_link::Limits, fields: &mut Fields) -> Option<Workspace> {
    let (low, high) = (limits.workspace_low_m, limits.workspace_high_m);
    if low.abs() + high.abs() <= 0.0 {
        zone(Field::WorkspaceSoft, limits.workspace_soft_m, 0.0, fields);
        return None;
    }
    let soft = limits.workspace_soft_m;
    Some(range([low, high], soft, [-FAR, FAR], fields))
}

/// A range of places with its zones, within `allowed`, m.
fn range(ends: [f32; 2], soft: f32, allowed: [f32; 2], fields: &mut Fields) -> Workspace {
    let [least, most] = allowed;
    let low = fields.within(Field::WorkspaceLow, ends[0], least, most);
    let high = fields.within(Field::WorkspaceHigh, ends[1], low.next_up(), most);
    let half = 0.5 * (f64::from(high) - f64::from(low));
    let soft = zone(Field::WorkspaceSoft, soft, half as f32, fields);
    Workspace {
        low: Metres(f64::from(low)),
        high: Metres(f64::from(high)),
        // Half the workspace may have been rounded up.
        soft: Metres(f64::from(soft).min(half)),
    }
}

/// The ranges of a box, each in the workspace of all axes, if there is one. Missing axes have those of the last.
#[cfg(all(feature = "several-axes", feature = "std"))]
pub(super) fn box_ranges(
    limits: &haptic_link::Limits,
    workspace: &haptic_link::WorkspaceBox,
    fields: &mut Fields,
) -> Option<[Workspace; 3]> {
    let (low, high) = (limits.workspace_low_m, limits.workspace_high_m);
    let allowed = if low < high { [low, high] } else { [-FAR, FAR] };
    let mut ranges = workspace
        .axes
        .iter()
        .map(|axis| range([axis.low_m, axis.high_m], axis.soft_m, allowed, fields));
    let first = ranges.next()?;
    let second = ranges.next().unwrap_or(first);
    let third = ranges.next().unwrap_or(second);
    Some([first, second, third])
}

/// The zone below the speed limit, which the table has set.
fn speed_zone(chain: &mut SafetyLimits, limits: &haptic_link::Limits, fields: &mut Fields) {
    let hard = limits.speed_hard_m_per_s;
    // At the largest speeds single precision has no room for the narrowest zone.
    let most = (hard - ZONE_MIN).min(hard.next_down());
    let most = if chain.speed.is_some() { most } else { 0.0 };
    let soft = fields.within(Field::SpeedSoft, limits.speed_soft_m_per_s, 0.0, most);
    if let Some(speed) = &mut chain.speed {
        speed.soft = MetresPerSecond(f64::from(soft));
    }
}

fn guard(
    guard: &haptic_link::Guard,
    tick_period_us: u32,
    fields: &mut Fields,
) -> Option<PassivityGuard> {
    if guard.kind == GuardKind::Off {
        return None;
    }
    let damping = fields.within(Field::GuardDamping, guard.damping_n_s_per_m, 1e-6, 1e6);
    let damping = NewtonSecondsPerMetre(f64::from(damping));
    // Rounded up, to be at least the sample time in double precision too.
    let tick = (tick_period_us as f32 * 1e-6).next_up();
    let bounding = guard.kind == GuardKind::EnergyBounding;
    let at_once = bounding && guard.forget_s.abs() <= 0.0;
    let least = if at_once { 0.0 } else { tick };
    let forget = fields.within(Field::GuardForget, guard.forget_s, least, 3600.0);
    let forget = Seconds(f64::from(forget));
    if !bounding {
        return Some(PassivityGuard::Observer(PassivityObserver {
            damping_max: damping,
            forget,
        }));
    }
    let share = fields.within(Field::GuardShare, guard.share, 1e-3, 1.0);
    let longest = MAX_GUARD_DELAY_SAMPLES as f32;
    let (least, most) = (guard.delay_least_samples, guard.delay_most_samples);
    let most = fields.within(Field::GuardDelayMost, most, 0.0, longest);
    let least = fields.within(Field::GuardDelayLeast, least, 0.0, most);
    let slowest = MAX_GUARD_LAG_SAMPLES as f32 * tick;
    let lag = fields.within(Field::GuardLag, guard.lag_s, 0.0, slowest);
    let noise = fields.within(Field::GuardNoise, guard.noise_m, 0.0, NOISE_MAX);
    // Whole ticks have no rounding this way.
    let sample_time = f64::from(tick_period_us) * 1e-6;
    let delay = |samples: f32| Seconds(f64::from(samples) * sample_time);
    Some(PassivityGuard::EnergyBounding(EnergyBounding {
        device_damping: damping,
        share: f64::from(share),
        forget,
        delay_least: delay(least),
        delay_most: delay(most),
        current_lag: Seconds(f64::from(lag)),
        noise: Metres(f64::from(noise)),
    }))
}

/// Limits for the wire, with the watchdog and late ticks of
/// [`Limits::DEFAULT`](haptic_link::Limits::DEFAULT). A limit on the norm becomes the force limit,
/// which there also limits the norm.
#[must_use]
pub fn wire_limits(limits: &SafetyLimits, sample_time: Seconds) -> haptic_link::Limits {
    let norm = limits.norm.map_or(f64::INFINITY, |norm| norm.0);
    let workspace = limits.workspace.map(|w| (w.low.0, w.high.0, w.soft.0));
    let (low, high, soft) = workspace.unwrap_or_default();
    let guard = limits.guard.as_ref();
    let mut wire = haptic_link::Limits {
        workspace_low_m: low as f32,
        workspace_high_m: high as f32,
        workspace_soft_m: soft as f32,
        speed_soft_m_per_s: limits.speed.map_or(0.0, |speed| speed.soft.0 as f32),
        // More than the wire can say is more than anybody waits for.
        device_delay_ticks: u8::try_from(limits.device_delay_samples).unwrap_or(u8::MAX),
        guard: guard.map_or(haptic_link::Guard::OFF, |guard| {
            wire_guard(guard, sample_time)
        }),
        ..haptic_link::Limits::bare(0.0, 0.0)
    };
    for limit in Limit::ALL {
        if let Some(number) = limit.get(limits) {
            *wire.number(limit).0 = number as f32;
        }
    }
    wire.force_n = limits.force.0.min(norm) as f32;
    wire
}

/// Guard for the wire, for a tick of this time.
#[must_use]
pub fn wire_guard(guard: &PassivityGuard, sample_time: Seconds) -> haptic_link::Guard {
    match guard {
        PassivityGuard::Observer(observer) => haptic_link::Guard {
            kind: GuardKind::Observer,
            damping_n_s_per_m: observer.damping_max.0 as f32,
            forget_s: observer.forget.0 as f32,
            ..haptic_link::Guard::OFF
        },
        PassivityGuard::EnergyBounding(bounding) => haptic_link::Guard {
            kind: GuardKind::EnergyBounding,
            damping_n_s_per_m: bounding.device_damping.0 as f32,
            share: bounding.share as f32,
            forget_s: bounding.forget.0 as f32,
            delay_least_samples: (bounding.delay_least.0 / sample_time.0) as f32,
            delay_most_samples: (bounding.delay_most.0 / sample_time.0) as f32,
            lag_s: bounding.current_lag.0 as f32,
            noise_m: bounding.noise.0 as f32,
        },
    }
}
