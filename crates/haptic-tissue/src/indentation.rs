//! The force of an indentation that may shrink.
//! ```text
//! δ grows      F/γ = ∫₀ᵗ  M(t − τ) d e(δ(τ))                                                E. H. Lee, J. R. M. Radok, 1960
//! δ shrinks    F/γ = ∫₀^t₁ M(t − τ) d e(δ(τ)),   t₁ from  ∫_t₁ᵗ M(t − τ) dδ(τ) = 0           T. C. T. Ting, 1966
//! ```
//! The contact at t is that of the time t₁ while it grew: where the surface is free since, the pressure that holds it is over.

use crate::model::Model;
use haptic_loop::DepthMap;

/// Times, and what a map makes of depths that are straight between them, the samples among them: so close that the depth moves
/// by its range over `points` at most from one to the next, for e to be straight in between, however few samples the way has.
pub fn mapped(
    time_s: &[f64],
    depth: &[f64],
    map: &DepthMap<f64>,
    points: usize,
) -> (Vec<f64>, Vec<f64>) {
    let [least, most] = [f64::min, f64::max].map(|end| depth.iter().copied().reduce(end));
    let range = most.zip(least).map_or(0.0, |(most, least)| most - least);
    let (mut times, mut values) = (Vec::new(), Vec::new());
    let ends = time_s.windows(2).zip(depth.windows(2));
    for (time, depth) in ends {
        let share = (depth[1] - depth[0]).abs() / range;
        // A piece shorter than the rounding error does not count. A hold, whose share may be NaN, is straight.
        let count = ((points as f64 * share - 1e-6).ceil() as usize).max(1);
        for piece in 0..count {
            let share = piece as f64 / count as f64;
            times.push(time[0] + share * (time[1] - time[0]));
            values.push(map.at(depth[0] + share * (depth[1] - depth[0])));
        }
    }
    times.extend(time_s.last());
    values.extend(depth.last().map(|depth| map.at(*depth)));
    (times, values)
}

/// The time between two samples at which the contact begins, if it does.
pub fn begin_s([earlier, time]: [f64; 2], [above, depth]: [f64; 2]) -> Option<f64> {
    let crossing = || earlier + (time - earlier) * (above / (above - depth));
    (above < 0.0 && depth > 0.0)
        .then(crossing)
        .filter(|crossing| *crossing > earlier && *crossing < time)
}

/// The samples, with the begin of each contact among them, and no depth below 0.
fn touched(time_s: &[f64], depth_m: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let (mut times, mut depths) = (Vec::new(), Vec::new());
    let mut before: Option<(f64, f64)> = None;
    for (&time, &depth) in time_s.iter().zip(depth_m) {
        let crossing = before.and_then(|(earlier, above)| begin_s([earlier, time], [above, depth]));
        if let Some(crossing) = crossing {
            times.push(crossing);
            depths.push(0.0);
        }
        times.push(time);
        depths.push(depth.max(0.0));
        before = Some((time, depth));
    }
    (times, depths)
}

/// A depth that has fallen by more than this share of its largest is a retraction, no overshoot.
const RETRACTION: f64 = 0.1;
/// A smaller fall counts as standing still.
pub const NOISE: f64 = 0.01;

/// Number of samples before a retraction, and the largest fall before it as a share of the largest depth.
pub fn growing(depth_m: &[f64]) -> (usize, f64) {
    let most = depth_m.iter().copied().fold(0.0, f64::max);
    let mut deepest = f64::NEG_INFINITY;
    let fallen = depth_m.iter().position(|&depth| {
        deepest = deepest.max(depth);
        depth < deepest - RETRACTION * most
    });
    let kept = fallen.map_or(depth_m.len(), |fallen| {
        // It began where the depth fell last without a rest.
        let near = |depth: &f64| *depth >= deepest - NOISE * most;
        let last = depth_m[..fallen].iter().rposition(near).unwrap_or(0);
        let falls = depth_m[..=last].windows(2).rev();
        last + 1 - falls.take_while(|pair| pair[1] < pair[0]).count()
    });
    let (mut deepest, mut fall) = (f64::NEG_INFINITY, 0.0_f64);
    for &depth in &depth_m[..kept] {
        deepest = deepest.max(depth);
        fall = fall.max((deepest - depth) / most);
    }
    (kept, fall)
}

/// Forces of an indentation over γ, as far as the theory goes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ting {
    /// F/γ, Pa·m, sample by sample; fewer than there are samples if the contact grows again after it shrank.
    pub force_per_shape: Vec<f64>,
    /// Number of the first sample of the retraction, or at which the contact is lost; without either, the number
    /// of samples.
    pub shrinks_from: usize,
}

/// Points of a way in from depth 0 at least.
const POINTS: usize = 4000;
/// Distance of the times at which ∫M is known, in ln t.
const SPACING: f64 = 0.02;
/// A contact that moves by less than this share of the time does not grow.
const STILL: f64 = 1e-9;

/// The force of an indentation over γ, F/γ in Pa·m: by Lee and Radok while the contact grows, by Ting while it shrinks, and 0
/// once it is lost.
///
/// Depths in m, straight between times in s that rise; a depth below 0 means no contact. `map` is e
/// of a sphere or cone, as of [`Specimen::depth_map`](haptic_loop::Specimen::depth_map); none for a
/// flat punch or a slab, whose contact is of one size until it is lost. A retraction begins where a
/// fall of the depth by 10 % of its largest begins; before, the contact is taken as if it did not
/// shrink, since an overshoot or a hand that trembles leaves it nearly as it was. Where the contact
/// grows again in a retraction, as in a second touch or a hold behind it, the theory needs more:
/// the result ends there.
///
/// Error against an independent quadrature below 1e-6 of the largest force.
/// *Cost*: [`Model::stress`] of the samples and some 4000 points between them; and for each sample of a retraction 15 ns for
/// each point before it, 0.1 s for 1000 samples.
/// ```
/// use haptic_loop::{Loading, LoadingKind, Specimen};
/// use haptic_tissue::{Model, ModelKind};
/// use haptic_tissue::indentation::ting;
///
/// let gel = Model::from_parameters(ModelKind::SpringPot, &[1000.0, 0.2])?;
/// let sphere = Loading { radius_m: Some(5e-3), ..Loading::new(LoadingKind::Sphere) };
/// let e = Specimen::new(sphere, 0.5, 0.0).expect("a sphere").depth_map();
/// let (times, depths) = ([0.0, 0.5, 1.0, 1.5, 2.0], [0.0, 5e-4, 1e-3, 5e-4, 0.0]);
/// let touch = ting(&gel, e.as_ref(), &times, &depths);
/// assert_eq!(touch.shrinks_from, 3);
/// // The surface stays behind: the sphere has left it before it is back at depth 0.
/// assert!(touch.force_per_shape[3] > 0.0 && touch.force_per_shape[4] == 0.0);
/// # Ok::<(), haptic_tissue::ModelError>(())
/// ```
/// *Source*: T. C. T. Ting, *The contact stresses between a rigid indenter and a viscoelastic half-space*, J. Appl. Mech. 33,
/// 1966.
#[must_use]
pub fn ting(model: &Model, map: Option<&DepthMap<f64>>, time_s: &[f64], depth_m: &[f64]) -> Ting {
    let count = usize::min(time_s.len(), depth_m.len());
    let (time_s, depth_m) = (&time_s[..count], &depth_m[..count]);
    let mut shrinks_from = map.map_or(count, |_| growing(depth_m).0);
    // The surface of a contact that grows is that of the deepest place so far.
    let (way_s, mut way_m) = touched(&time_s[..shrinks_from], &depth_m[..shrinks_from]);
    if map.is_some() {
        (1..way_m.len()).for_each(|n| way_m[n] = way_m[n].max(way_m[n - 1]));
    }
    let way = (way_s, way_m);
    let fine = map.map(|map| mapped(&way.0, &way.1, map, POINTS));
    let fine = fine.as_ref().unwrap_or(&way);
    let stress = model.stress(&fine.0, &fine.1);
    let at = |time: &f64| stress.get(fine.0.partition_point(|fine| fine < time));
    let force = time_s[..shrinks_from].iter().map(|time| at(time).copied());
    let mut force: Vec<f64> = force.map(|force| force.unwrap_or(f64::NAN)).collect();
    if map.is_none() {
        // Of one size, and then lost at once.
        if let Some(lost) = force.iter().position(|force| *force < 0.0) {
            let away = depth_m[lost - 1..].windows(2);
            let away = away.take_while(|pair| pair[1] <= pair[0]).count();
            force.truncate(lost);
            force.resize(lost + away, 0.0);
            shrinks_from = lost;
        }
    } else if shrinks_from < count {
        let retraction = Retraction::new(model, &way, fine, time_s);
        let (back_s, back_m) = (&time_s[shrinks_from - 1..], &depth_m[shrinks_from - 1..]);
        let mut contact = f64::INFINITY;
        for n in 1..back_s.len() {
            let next = retraction.contact(&back_s[..=n], &back_m[..=n]);
            if next > contact + STILL * (back_s[n] - time_s[0]) {
                break;
            }
            contact = next;
            force.push(retraction.force(contact, back_s[n]));
        }
    }
    Ting {
        force_per_shape: force,
        shrinks_from,
    }
}

/// The way in, and ∫M over time.
struct Retraction<'a> {
    /// Depths of the way in, straight between these times.
    way: &'a (Vec<f64>, Vec<f64>),
    fine: &'a (Vec<f64>, Vec<f64>),
    /// ln of the time of the first node.
    first_node: f64,
    integral: Vec<f64>,
}

impl<'a> Retraction<'a> {
    fn new(
        model: &Model,
        way: &'a (Vec<f64>, Vec<f64>),
        fine: &'a (Vec<f64>, Vec<f64>),
        time_s: &[f64],
    ) -> Self {
        let steps = time_s.windows(2).map(|pair| pair[1] - pair[0]);
        let least = steps.fold(f64::INFINITY, f64::min);
        let whole = time_s
            .last()
            .zip(time_s.first())
            .map_or(0.0, |(t, s)| t - s);
        let first_node = libm::log(least) - 2.0 * SPACING;
        let nodes = (libm::log(whole / least) / SPACING) as usize + 6;
        let node = |n| libm::exp(first_node + n as f64 * SPACING);
        let times: Vec<f64> = std::iter::once(0.0).chain((0..nodes).map(node)).collect();
        // The stress of a strain that grows by 1 in 1 s.
        let mut integral = model.stress(&times, &times);
        integral.remove(0);
        Self {
            way,
            fine,
            first_node,
            integral,
        }
    }

    /// Q; 0 at 0, where a dashpot still bears what it bears.
    fn integral(&self, time_s: f64) -> f64 {
        if time_s <= 0.0 {
            return 0.0;
        }
        let in_nodes = (libm::log(time_s) - self.first_node) / SPACING;
        let node = (in_nodes as usize).clamp(1, self.integral.len() - 3);
        let weights = spring_pots::cubic(in_nodes - node as f64);
        let nodes = self.integral[node - 1..].iter().zip(weights);
        nodes.map(|(value, weight)| value * weight).sum()
    }

    /// Σ slope·(Q(t − begin) − Q(t − end)) of straight pieces: ∫ M(t − τ) dy(τ).
    fn over(&self, times: &[f64], values: &[f64], now: f64) -> f64 {
        let ends = times.windows(2).zip(values.windows(2));
        let mut sum = 0.0;
        let mut early = times.first().map_or(0.0, |time| self.integral(now - time));
        for (time, value) in ends {
            let late = self.integral(now - time[1]);
            sum += (value[1] - value[0]) / (time[1] - time[0]) * (early - late);
            early = late;
        }
        sum
    }

    /// t₁ at the last of these samples, which begin at the end of the way in; before all time if the contact is lost.
    fn contact(&self, back_s: &[f64], back_m: &[f64]) -> f64 {
        let now = back_s[back_s.len() - 1];
        let mut sum = self.over(back_s, back_m, now);
        let (times, depths) = self.way;
        for (time, depth) in times.windows(2).zip(depths.windows(2)).rev() {
            let slope = (depth[1] - depth[0]) / (time[1] - time[0]);
            if slope > 0.0 {
                let [early, late] = [time[0], time[1]].map(|time| self.integral(now - time));
                let part = slope * (early - late);
                if sum + part >= 0.0 {
                    let wanted = late - sum / slope;
                    return self.place(wanted, now, [time[0], time[1]]);
                }
                sum += part;
            }
        }
        f64::NEG_INFINITY
    }

    /// The time between two at which Q(now − time) is as wanted; it falls with the time.
    fn place(&self, wanted: f64, now: f64, [mut early, mut late]: [f64; 2]) -> f64 {
        for _ in 0..64 {
            let middle = 0.5 * (early + late);
            if self.integral(now - middle) > wanted {
                early = middle;
            } else {
                late = middle;
            }
        }
        late
    }

    /// ∫ M(now − τ) de up to t₁.
    fn force(&self, contact: f64, now: f64) -> f64 {
        let (times, values) = self.fine;
        let whole = times.partition_point(|time| *time <= contact);
        if whole == 0 {
            return 0.0;
        }
        let sum = self.over(&times[..whole], &values[..whole], now);
        let Some((&end, &value)) = times.get(whole).zip(values.get(whole)) else {
            return sum;
        };
        let begin = times[whole - 1];
        let slope = (value - values[whole - 1]) / (end - begin);
        sum + slope * (self.integral(now - begin) - self.integral(now - contact))
    }
}
