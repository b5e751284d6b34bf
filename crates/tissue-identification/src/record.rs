//! Validated records of a specimen, in SI units.

use super::commanded::{self, Level};
use super::error::IdentifyError;
use crate::keys::{
    CONTACT_POINT, FROM, KIND, MASTER_CURVE, RAMP_ENDS, RAMP_TIME, REPLICATES, STRAIN,
    SUBTRACT_START, THICKNESS, WEIGHTS,
};
use fracdiff::enumerated;
use fracdiff::parameter::Shown;
use haptic_loop::{DepthMap, LoadingKind, Specimen};
use haptic_tissue::indentation::{NOISE, begin_s, growing};
use spring_pots::chosen;

/// A longer record is refused; every second sample carries nearly as much information.
pub const SAMPLES_MOST: usize = measured_table::ROWS_MOST;

enumerated! {
    /// The four kinds of records.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum RecordKind {
        /// Time after a step of strain, and stress over strain.
        Relaxation "relaxation" "stress after a step of strain",
        /// Time after a step of stress, and strain over stress.
        Creep "creep" "strain after a step of stress",
        /// Angular frequency, storage and loss modulus.
        Oscillation "oscillation" "storage and loss modulus over frequency",
        /// Time, any strain that begins at rest, and stress.
        History "record" "strain and stress of any motion from rest",
    }
}

enumerated! {
    /// A part of the force that is not the tissue's.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Baseline {
        /// f₀ alone, as a load cell shows that was not set to 0.
        Constant "constant" "an offset",
        /// f₀ and the drift f₁ of a load cell that warms up.
        Linear "linear" "an offset and a drift",
    }
}

/// Depth at which an indenter touches.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ContactPoint {
    /// Contact at 0. A record that fits far better with another one gets a warning.
    #[default]
    Zero,
    /// Contact at this depth of the file's own axis, m.
    At(f64),
    /// The depth at which the record fits best.
    Fitted,
}

/// The growing contact of an indenter, from which a record is made for any contact point.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Touch {
    pub(super) contact: ContactPoint,
    /// Depth on the axis of the file at 0 of `depth_m`, m.
    pub(super) zero_m: f64,
    pub(super) time_s: Vec<f64>,
    pub(super) depth_m: Vec<f64>,
    pub(super) force_n: Vec<f64>,
    /// Errors of the force, N, if they are known.
    error_n: Vec<f64>,
    pub(super) specimen: Specimen,
    /// Sentences about what is left out of it.
    left_out: Vec<String>,
}

impl Touch {
    /// Touch with at most `most` of its samples, each unchanged.
    pub(super) fn thinned(&self, most: usize) -> Self {
        let chosen: Vec<usize> = (0..1)
            .chain(chosen(&self.time_s, self.time_s[0], most))
            .collect();
        let chosen_of = |values: &[f64]| {
            chosen
                .iter()
                .filter_map(|&i| values.get(i).copied())
                .collect()
        };
        Self {
            error_n: chosen_of(&self.error_n),
            time_s: chosen_of(&self.time_s),
            depth_m: chosen_of(&self.depth_m),
            force_n: chosen_of(&self.force_n),
            left_out: self.left_out.clone(),
            ..*self
        }
    }
}

/// A motion of a history.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Motion {
    pub(super) samples: usize,
    /// Times, s, and strains straight between them where the samples do not give the motion; `None` if they do.
    pub(super) way: Option<(Vec<f64>, Vec<f64>)>,
    /// Map from its strain to the strain that the memory sees; `None` if they are equal.
    pub(super) map: Option<DepthMap<f64>>,
    /// True if its strain grows with the depth, so that tissue can stiffen by it.
    can_stiffen: bool,
    /// Its standard deviation, Pa, if it is known.
    pub(super) noise: Option<f64>,
}

/// Samples that a model can be fitted to: its constructors refuse invalid samples, naming the
/// sample and the remedy.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    pub(super) kind: RecordKind,
    /// Times in s, or angular frequencies in rad/s, each at least the one before: rounding makes two of a modulus or compliance equal.
    pub(super) x: Vec<f64>,
    /// Modulus, compliance, storage modulus, or strain.
    pub(super) first: Vec<f64>,
    pub(super) second: Vec<f64>,
    /// Errors of the values that are fitted, in their unit, all of `first` before those of `second`; none if they are not known.
    pub(super) errors: Vec<f64>,
    /// Correlation of the errors of storage and loss modulus of each sample; none where they are independent.
    pub(super) shared: Vec<f64>,
    /// The number of each sample among those that were given, and their unit over that of the values that are fitted.
    given: Vec<usize>,
    per: f64,
    /// The motions of a history.
    pub(super) motions: Vec<Motion>,
    /// Contact in one motion of an indenter.
    pub(super) touch: Option<Touch>,
    /// Columns of which any sum may be in the stress beside the model's, such as a baseline; one number a sample.
    pub(super) nuisance: Vec<Vec<f64>>,
    /// Columns, over the noise, of which a sum with normal shares of deviation 1 is in the stress: what its instrument leaves open.
    pub(super) bounded: Vec<Vec<f64>>,
    /// Residual that the means of such shares make, in its unit, a number for each sample; none where they are 0.
    pub(super) expected: Vec<f64>,
    /// Least and largest time by which a sensor shows the stress later, s; `None` if it does not.
    pub(super) lag_s: Option<[f64; 2]>,
    /// Steps of a creep whose stress was commanded: time since the first step, s, and size over the largest stress of each step; and
    /// the same with the steps a row later, where the rows leave that open.
    pub(super) steps: Vec<[f64; 2]>,
    later: Vec<[f64; 2]>,
    /// True if the residuals of a creep by steps are differences, as of noise of one size, not those of logarithms.
    is_absolute: bool,
    /// Largest strain, if it is known.
    strain_to: Option<f64>,
    /// True if it is a log of our own, whose samples a loop may have rendered.
    pub(super) is_own_log: bool,
    /// Why the times of a motion are numbers of samples, if they are: only what has no memory is known then.
    pub(super) untimed: Option<String>,
    /// Sentences that a user should know.
    pub(super) warnings: Vec<String>,
}

impl Record {
    /// Stress relaxation: times after the step, s, and the relaxation modulus, Pa.
    ///
    /// # Errors
    /// Times or moduli that are not positive, times that fall, columns of different length, a modulus that is constant or grows.
    pub fn relaxation(time_s: Vec<f64>, modulus_pa: Vec<f64>) -> Result<Self, IdentifyError> {
        let kind = RecordKind::Relaxation;
        let mut record = Self::of_logarithms(kind, time_s, modulus_pa, Vec::new())?;
        record.leave_out_the_unmeasurable();
        let most = |a: usize, b: usize| {
            if record.first[b] > record.first[a] {
                b
            } else {
                a
            }
        };
        let peak = (0..record.first.len()).fold(0, most);
        let values = &record.first;
        let is_ramp = peak > 0 && values[peak] > RISE * values[0].max(values[values.len() - 1]);
        if record.growth() > GROWTH && is_ramp {
            return Err(IdentifyError::Record(format!(
                "the modulus rises until {end} s and falls from there, as in a ramp to the held strain: give {RAMP_TIME} = {end}s, or a strain column",
                end = Shown(record.x[peak])
            )));
        }
        if record.growth() > GROWTH {
            return Err(IdentifyError::Record(format!(
                "the modulus grows with time, as only a compliance does: give {}",
                KIND.set_to("creep")
            )));
        }
        let pairs = record.first.windows(2);
        let rises = pairs.take_while(|pair| pair[1] > pair[0]).count();
        if rises >= FEW_RISES && record.first[rises] > RISE * record.first[0] {
            record.warnings.push(format!(
                "the modulus rises {rises} times before it falls, as in a ramp to the held strain: give {RAMP_TIME}, or a strain column"
            ));
        }
        Ok(record)
    }

    /// Stress relaxation with the ramp to the held strain: the strain rises from 0 to the held one within the time of the ramp, which ends at
    /// this time of the clock, and stays there. Times, s, and stresses, Pa.
    ///
    /// # Errors
    /// As [`history`](Self::history); a ramp that is not above 0 s, or longer than the record; samples before it.
    pub fn ramp(
        mut time_s: Vec<f64>,
        mut stress_pa: Vec<f64>,
        strain: f64,
        ramp_s: f64,
        ends_s: f64,
    ) -> Result<Self, IdentifyError> {
        lengths(&time_s, &stress_pa, None)?;
        time_s.iter_mut().for_each(|time| *time += ramp_s - ends_s);
        let (first, last) = (time_s[0], time_s[time_s.len() - 1]);
        if !(ramp_s > 0.0 && ramp_s < last && first >= 0.0) {
            return Err(IdentifyError::Record(format!(
                "{RAMP_TIME} {} s is not above 0 s and below the last time {} s, or samples from {} s on begin before the ramp, at {} s: change it, or {RAMP_ENDS}",
                Shown(ramp_s),
                Shown(last - ramp_s + ends_s),
                Shown(first - ramp_s + ends_s),
                Shown(ends_s - ramp_s)
            )));
        }
        if first > 0.0 {
            time_s.insert(0, 0.0);
            stress_pa.insert(0, 0.0);
        }
        let at = |time: &f64| strain * (time / ramp_s).min(1.0);
        // The end of the ramp is one of the samples, or between two of them.
        let mut way = time_s.clone();
        let near = |time: &f64| (time - ramp_s).abs() <= 1e-9 * ramp_s;
        if !way.iter().any(near) {
            way.insert(way.partition_point(|time| *time < ramp_s), ramp_s);
        }
        let strains = time_s.iter().map(at).collect();
        let mut record = Self::motion(time_s, strains, stress_pa, REST)?;
        let strains = way.iter().map(at).collect();
        record.motions[0].way = Some((way, strains));
        Ok(record)
    }

    /// Creep: times after the step, s, and the creep compliance, 1/Pa.
    ///
    /// # Errors
    /// As [`relaxation`](Self::relaxation); a compliance that falls.
    pub fn creep(time_s: Vec<f64>, compliance_per_pa: Vec<f64>) -> Result<Self, IdentifyError> {
        let record = Self::of_logarithms(RecordKind::Creep, time_s, compliance_per_pa, Vec::new())?;
        if record.growth() < -GROWTH {
            return Err(IdentifyError::Record(format!(
                "the compliance falls with time, as only a relaxation modulus does: give {}",
                KIND.set_to("relaxation")
            )));
        }
        Ok(record)
    }

    /// Creep under a stress that was commanded and stays at levels, as in a step, a staircase or a recovery: times, s, strains, and stresses,
    /// Pa, which count by the mean of each level. A first row at rest is the start; without one the step is at the time 0. What is fitted is
    /// the strain over the largest stress, by differences or logarithms, as its noise is.
    ///
    /// # Errors
    /// Times that fall, numbers that are not finite, a stress that is not held.
    pub fn creep_under(
        time_s: Vec<f64>,
        strain: Vec<f64>,
        stress_pa: Vec<f64>,
    ) -> Result<Self, IdentifyError> {
        lengths(&time_s, &strain, Some(&stress_pa))?;
        let finite = [&time_s, &strain, &stress_pa];
        let wrong = (0..time_s.len()).find(|&n| !finite.iter().all(|column| column[n].is_finite()));
        without(wrong, |_| {
            "a number is not finite; omit the sample".to_owned()
        })?;
        increasing(&time_s, "time", "s", |before, after| before > after)?;
        let Some(levels) = commanded::levels(&stress_pa) else {
            return Err(IdentifyError::Record(format!(
                "the stress is not held at levels, as that of a creep is: give {}",
                KIND.set_to("record")
            )));
        };
        let size = |a: f64, b: &Level| {
            if b.value.abs() > f64::abs(a) {
                b.value
            } else {
                a
            }
        };
        let held = levels.iter().fold(0.0, size);
        let (mut before, mut steps) = (0.0, Vec::new());
        for Level { rows, value } in levels {
            let (change, first) = ((value - before) / held, rows.start);
            before = value;
            if change != 0.0 {
                let late = time_s[first];
                let early = first
                    .checked_sub(1)
                    .map_or(late.min(0.0), |row| time_s[row]);
                // One row at rest is the start of the test.
                let late = if first < 2 { early } else { late };
                steps.push([early, late, change]);
            }
        }
        let begin = steps[0][0];
        let times_and_sizes = |n: usize| {
            steps
                .iter()
                .map(|step| [step[n] - begin, step[2]])
                .collect()
        };
        let (early, late): (Vec<_>, Vec<_>) = (times_and_sizes(0), times_and_sizes(1));
        let rows = time_s.partition_point(|time| *time <= begin);
        let most = strain.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let since = time_s[rows..].iter().map(|time| time - begin).collect();
        let compliance: Vec<f64> = strain[rows..].iter().map(|strain| strain / held).collect();
        let mut record = Self::plain(RecordKind::Creep, since, compliance, Vec::new());
        (record.later, record.steps) = (late, early);
        (record.given, record.per) = ((rows..time_s.len()).collect(), held.abs());
        record.is_absolute = true;
        Ok(record.with_strain_to(most))
    }

    /// The ways in which a record may be read, among which its fits decide.
    pub(super) fn readings(&self) -> Vec<Self> {
        let mut all = vec![self.clone()];
        if self.has_open_instants() {
            let steps = self.later.clone();
            all.push(Self {
                steps,
                ..self.clone()
            });
        }
        // Errors say of what kind the noise is.
        if self.has_steps() && self.errors.is_empty() && self.first.iter().all(|value| *value > 0.0)
        {
            let logarithmic = |one: &Self| Self {
                is_absolute: false,
                ..one.clone()
            };
            all.extend(all.clone().iter().map(logarithmic));
        }
        all
    }

    /// True of a creep of which a step lies between two rows.
    pub(super) fn has_open_instants(&self) -> bool {
        self.later != self.steps
    }

    /// The times of the rows between which each step lies.
    pub(super) fn instants(&self) -> impl Iterator<Item = [f64; 2]> {
        let pairs = self.steps.iter().zip(&self.later);
        pairs.map(|(early, late)| [early[0], late[0]])
    }

    /// True of a creep whose stress was commanded.
    pub(super) const fn has_steps(&self) -> bool {
        !self.steps.is_empty()
    }

    /// True if residuals are differences in the unit of the values, not those of logarithms.
    pub(super) fn is_absolute(&self) -> bool {
        self.is_absolute || self.kind == RecordKind::History
    }

    /// Oscillation: angular frequencies, rad/s, storage and loss modulus, Pa, in any order.
    ///
    /// # Errors
    /// Frequencies or moduli that are not positive, columns of different length.
    pub fn oscillation(
        omega_rad_s: Vec<f64>,
        storage_modulus_pa: Vec<f64>,
        loss_modulus_pa: Vec<f64>,
    ) -> Result<Self, IdentifyError> {
        let kind = RecordKind::Oscillation;
        let mut record =
            Self::of_logarithms(kind, omega_rad_s, storage_modulus_pa, loss_modulus_pa)?;
        if let [first, .., last] = record.x[..]
            && last <= ONE_FREQUENCY * first
        {
            record.warnings.push(format!(
                "all samples are of one frequency, {} rad/s, as in a sweep of amplitude or time: no other frequency is known from them; give a sweep of frequency",
                Shown(first)
            ));
        }
        Ok(record)
    }

    /// Any motion from rest: times, s, strain and stress, Pa; the strain is linear in between. A
    /// strain above 0.2 is reported. Of a motion with equal times only models without memory can be fitted.
    ///
    /// # Errors
    /// Times that fall, numbers that are not finite, a strain that does not begin at rest or is constant.
    pub fn history(
        time_s: Vec<f64>,
        strain: Vec<f64>,
        stress_pa: Vec<f64>,
    ) -> Result<Self, IdentifyError> {
        let (time_s, untimed) = distinct(time_s);
        let record = Self::motion(time_s, strain, stress_pa, REST)?;
        Ok(Self { untimed, ..record })
    }

    /// A motion; a strain up to `rest` of its range counts as rest.
    fn motion(
        time_s: Vec<f64>,
        strain: Vec<f64>,
        stress_pa: Vec<f64>,
        rest: f64,
    ) -> Result<Self, IdentifyError> {
        lengths(&time_s, &strain, Some(&stress_pa))?;
        let is_finite = |n: &usize| {
            let columns = [&time_s, &strain, &stress_pa];
            columns.iter().all(|column| column[*n].is_finite())
        };
        let wrong = (0..time_s.len()).find(|n| !is_finite(n));
        without(wrong, |_| {
            "a number is not finite; omit the sample".to_owned()
        })?;
        increasing(&time_s, "time", "s", |before, after| before >= after)?;
        let reach = strain.iter().map(|x| (x - strain[0]).abs());
        let range = reach.fold(0.0, f64::max);
        if range == 0.0 {
            return Err(IdentifyError::Record(format!(
                "the strain stays at {}: give {} and {STRAIN}, or begin the record earlier",
                Shown(strain[0]),
                KIND.set_to("relaxation")
            )));
        }
        if strain[0].abs() > rest * range {
            return Err(IdentifyError::Record(format!(
                "the strain begins at {}, not at 0: begin the record earlier, or give {SUBTRACT_START} if the tissue was at rest there",
                strain[0]
            )));
        }
        constant(&stress_pa, "the stress", "Pa")?;
        // A passive body takes work in over the whole motion, so strain and stress have the same sign.
        let together: f64 = strain.iter().zip(&stress_pa).map(|(e, s)| e * s).sum();
        if together <= 0.0 {
            return Err(IdentifyError::Record(
                "strain and stress have opposite signs: change the sign of one column".to_owned(),
            ));
        }
        let motion = Motion {
            samples: time_s.len(),
            way: None,
            map: None,
            can_stiffen: true,
            noise: None,
        };
        let most = strain.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let mut record = Self::plain(RecordKind::History, time_s, strain, stress_pa);
        record.motions = vec![motion];
        Ok(record.with_strain_to(most))
    }

    /// Any motion of a specimen from rest: times, s, depths, m, and forces, N; the depth is linear in between.
    /// ```text
    /// σ = f/(γℓ),  ε = δ/ℓ,  σ = M ∗ de/dt,  e/ℓ a map of ε       M the modulus in which the loading is reported
    /// ```
    /// ℓ is the length of the nominal strain, under a cone the scale of its map. A depth below 0
    /// means no contact; the last sample before a touch is taken at its time. Under a sphere or a
    /// cone the law holds while the contact grows: the record ends where a fall of the depth by 10
    /// % of its largest begins, which is reported; so is a smaller fall, as of an overshoot, which
    /// is kept. So is a strain above 0.2. A slab gives the stress and the strain of
    /// [`history`](Self::history).
    ///
    /// # Errors
    /// As [`history`](Self::history); an indenter whose depth is never above 0; a depth beyond the thickness of a layer or of a slab that is compressed.
    pub fn pressed(
        time_s: Vec<f64>,
        depth_m: Vec<f64>,
        force_n: Vec<f64>,
        specimen: &Specimen,
    ) -> Result<Self, IdentifyError> {
        Self::pressed_from(ContactPoint::Zero, time_s, depth_m, force_n, specimen)
    }

    /// Record like that of [`pressed`](Self::pressed), of a depth axis whose 0 is elsewhere.
    ///
    /// # Errors
    /// As [`pressed`](Self::pressed); a contact point that is not finite; one to be fitted of a slab.
    pub fn pressed_from(
        contact: ContactPoint,
        time_s: Vec<f64>,
        mut depth_m: Vec<f64>,
        force_n: Vec<f64>,
        specimen: &Specimen,
    ) -> Result<Self, IdentifyError> {
        lengths(&time_s, &depth_m, Some(&force_n))?;
        let loading = specimen.loading();
        if loading.kind.is_slab() && contact != ContactPoint::Zero {
            return Err(IdentifyError::Record(format!(
                "{CONTACT_POINT} has no effect on a slab, whose strain begins at rest: omit it"
            )));
        }
        let zero_m = match contact {
            ContactPoint::Zero => 0.0,
            ContactPoint::At(depth) => depth,
            ContactPoint::Fitted => depth_m.iter().copied().fold(f64::INFINITY, f64::min),
        };
        depth_m.iter_mut().for_each(|depth| *depth -= zero_m);
        if let Some(thickness) = loading.thickness_m {
            within(&depth_m, thickness, loading.kind)?;
        }
        let (time_s, untimed) = distinct(time_s);
        let mut touch = Touch {
            contact,
            zero_m,
            time_s,
            depth_m,
            force_n,
            error_n: Vec::new(),
            specimen: *specimen,
            left_out: Vec::new(),
        };
        if matches!(loading.kind, LoadingKind::Sphere | LoadingKind::Cone) {
            let inside: Vec<f64> = touch.depth_m.iter().map(|depth| depth.max(0.0)).collect();
            let (count, (kept, fall)) = (inside.len(), growing(&inside));
            if fall > NOISE {
                touch.left_out.push(format!(
                    "the depth falls back by {:.1} % of its largest, as an overshoot does: the contact is taken as if it did not shrink",
                    100.0 * fall
                ));
            }
            if kept < count {
                touch.left_out.push(format!(
                    "the contact shrinks from {} on: {} samples of {count} are left out, because only growing contact is fitted",
                    match untimed {
                        None => format!("{} s", Shown(touch.time_s[kept - 1])),
                        Some(_) => format!("sample {kept}"),
                    },
                    count - kept
                ));
            }
            for column in [&mut touch.time_s, &mut touch.depth_m, &mut touch.force_n] {
                column.truncate(kept);
            }
        }
        let rest = match contact {
            ContactPoint::Fitted => REST_OF_FIT,
            ContactPoint::Zero | ContactPoint::At(_) => REST,
        };
        let mut record = Self::touching(&touch, 0.0, rest)?;
        record.untimed = untimed;
        record.touch = Some(touch).filter(|_| !loading.kind.is_slab());
        Ok(record)
    }

    /// An indenter that touches at a depth of the touch, with the rest of a motion that is not at rest.
    pub(super) fn touching(
        touch: &Touch,
        contact_m: f64,
        rest: f64,
    ) -> Result<Self, IdentifyError> {
        let specimen = &touch.specimen;
        let (mut time_s, mut force_n) = (touch.time_s.clone(), touch.force_n.clone());
        let depths = touch.depth_m.iter().map(|depth| depth - contact_m);
        let mut depth_m: Vec<f64> = depths.collect();
        let mut warnings = touch.left_out.clone();
        if !specimen.loading().kind.is_slab() {
            let most = depth_m.iter().copied().fold(0.0, f64::max);
            if depth_m[0] > rest * (most - depth_m[0]) {
                return Err(IdentifyError::Record(format!(
                    "the depth begins at {} m, where an indenter is in contact: begin the record earlier, or give {CONTACT_POINT}",
                    Shown(depth_m[0])
                )));
            }
            if depth_m.iter().all(|depth| *depth <= 0.0) {
                return Err(IdentifyError::Record(format!(
                    "the depth is never above 0: change its sign, for it is counted into the tissue, or give {CONTACT_POINT}"
                )));
            }
            for n in 1..depth_m.len() {
                let begin = begin_s([time_s[n - 1], time_s[n]], [depth_m[n - 1], depth_m[n]]);
                time_s[n - 1] = begin.unwrap_or(time_s[n - 1]);
            }
            let apart = depth_m.iter_mut().filter(|depth| **depth < 0.0);
            let count = apart.map(|depth| *depth = 0.0).count();
            if count > 0 {
                warnings.push(format!(
                    "{count} samples with a depth below 0 are taken as without contact"
                ));
            }
        }
        let length = length(specimen);
        depth_m.iter_mut().for_each(|depth| *depth /= length);
        let area = area(specimen);
        force_n.iter_mut().for_each(|force| *force /= area);
        let mut record = Self::motion(time_s, depth_m, force_n, rest)?;
        let motion = &mut record.motions[0];
        motion.map = specimen.depth_map().and_then(|map| {
            let mut numbers = map.numbers();
            numbers[0] *= length;
            numbers[7] *= length;
            DepthMap::new(numbers).ok()
        });
        motion.can_stiffen = specimen.length().is_some();
        if !motion.can_stiffen {
            record.forget_strain();
        }
        record.per = area;
        record.errors = touch.error_n.iter().map(|error| error / area).collect();
        record.warnings.extend(warnings);
        Ok(record)
    }

    /// Several motions of the same tissue, such as presses to several depths, fitted together.
    /// Their noise is assumed to be equal, unless the residuals of a first fit show otherwise:
    /// then errors count relative to the noise of their own motion. Each begins at the time 0.
    ///
    /// # Errors
    /// A missing record, or one without motion; more samples than [`SAMPLES_MOST`].
    pub fn together(records: Vec<Self>) -> Result<Self, IdentifyError> {
        let mut records = records.into_iter();
        let Some(mut all) = records.next() else {
            return Err(IdentifyError::Record(NO_SAMPLES.to_owned()));
        };
        if let Some(&begin) = all.x.first().filter(|_| records.len() > 0) {
            all.x.iter_mut().for_each(|x| *x -= begin);
        }
        for other in records {
            let touches = [&all.touch, &other.touch].into_iter();
            if touches
                .flatten()
                .any(|touch| touch.contact == ContactPoint::Fitted)
            {
                return Err(IdentifyError::Record(format!(
                    "{CONTACT_POINT} is fitted to one motion, and there are several: give it as a length, or {REPLICATES}"
                )));
            }
            all.touch = None;
            if [all.kind, other.kind] != [RecordKind::History; 2] {
                let both = [all.kind, other.kind].into_iter();
                let kind = both.filter(|kind| *kind != RecordKind::History);
                return Err(IdentifyError::Record(format!(
                    "only motions are fitted together, and a record is of kind {}: give them one by one, or {REPLICATES} for several specimens, or {MASTER_CURVE} for several temperatures",
                    kind.map(RecordKind::name).next().unwrap_or_default()
                )));
            }
            let [before, behind] = [all.x.len(), other.x.len()].map(|count| vec![0.0; count]);
            (all.bounded.iter_mut()).for_each(|column| column.extend(&behind));
            all.bounded.extend(
                other
                    .bounded
                    .iter()
                    .map(|column| [&before[..], column].concat()),
            );
            all.lag_s = match (all.lag_s, other.lag_s) {
                (Some(a), Some(b)) => Some([a[0].min(b[0]), a[1].max(b[1])]),
                (a, b) => a.or(b),
            };
            if all.errors.is_empty() != other.errors.is_empty() {
                let some = "some of the motions have errors and some have none: they do not count";
                all.warnings.push(some.to_owned());
            }
            all.errors.extend(other.errors);
            all.x.extend(other.x.iter().map(|x| x - other.x[0]));
            all.first.extend(other.first);
            all.second.extend(other.second);
            all.motions.extend(other.motions);
            all.strain_to = (all.strain_to.zip(other.strain_to)).map(|(a, b)| a.max(b));
            all.untimed = all.untimed.or(other.untimed);
            all.is_own_log &= other.is_own_log;
            all.warnings.extend(other.warnings);
        }
        lengths(&all.x, &all.first, None)?;
        if all.errors.len() < all.x.len() {
            all.errors.clear();
        }
        Ok(all)
    }

    /// Record with an error of each sample that was given, in its unit: of the modulus, compliance, strain of a creep, stress or force, and of the
    /// loss modulus beside the storage modulus. They weigh the samples against each other, so that standard deviations and standard errors are
    /// alike; no numbers mean that there are no errors.
    ///
    /// # Errors
    /// Another number of errors than of samples; one that is not above 0 and finite.
    pub fn with_errors(mut self, errors: &[f64], of_loss: &[f64]) -> Result<Self, IdentifyError> {
        if errors.is_empty() && of_loss.is_empty() {
            return Ok(self);
        }
        let whole: Vec<usize> = (0..self.x.len()).collect();
        let given = if self.given.is_empty() {
            &whole
        } else {
            &self.given
        };
        let is_sweep = self.kind == RecordKind::Oscillation;
        let parts = [Some(errors), is_sweep.then_some(of_loss)];
        for part in parts.into_iter().flatten() {
            are_errors(part, given)?;
            self.errors
                .extend(given.iter().map(|n| part[*n] / self.per));
        }
        if let Some(touch) = &mut self.touch {
            touch.error_n = errors[..touch.force_n.len()].to_vec();
        }
        Ok(self)
    }

    /// Oscillation with an error of the size |G*|, Pa, and of the phase δ, rad, of each sample, as a rheometer shows them. G′ and G″ share both:
    /// ```text
    /// s′² = (u·cos δ)² + (v·sin δ)²     s″² = (u·sin δ)² + (v·cos δ)²     ρ = (u² − v²)·sin δ·cos δ/(s′·s″)     v = |G*|·(error of δ)
    /// ```
    ///
    /// # Errors
    /// A record of another kind; otherwise those of [`with_errors`](Self::with_errors).
    pub fn with_polar_errors(
        self,
        of_size_pa: &[f64],
        of_phase_rad: &[f64],
    ) -> Result<Self, IdentifyError> {
        if self.kind != RecordKind::Oscillation {
            return Err(IdentifyError::Record(format!(
                "errors of |G*| and of its phase are those of an oscillation, and the record is of kind {}: give those of its values",
                self.kind.name()
            )));
        }
        are_errors(of_size_pa, &self.given)?;
        are_errors(of_phase_rad, &self.given)?;
        let mut errors = [(); 2].map(|()| vec![1.0; of_size_pa.len()]);
        let mut shared = Vec::with_capacity(self.given.len());
        let moduli = self.first.iter().zip(&self.second);
        for (row, (storage, loss)) in self.given.iter().zip(moduli) {
            let size = libm::hypot(*storage, *loss);
            let (cos, sin) = (storage / size, loss / size);
            let (along, across) = (of_size_pa[*row], size * of_phase_rad[*row]);
            errors[0][*row] = libm::hypot(along * cos, across * sin);
            errors[1][*row] = libm::hypot(along * sin, across * cos);
            let product = (along - across) * (along + across) * sin * cos;
            shared.push(product / (errors[0][*row] * errors[1][*row]));
        }
        let record = self.with_errors(&errors[0], &errors[1])?;
        Ok(Self { shared, ..record })
    }

    /// Record with what the instrument of a motion leaves open of its force: columns, a number for each sample, over the noise, of which a sum with
    /// normal shares of deviation 1 is in it; between which times, s, a sensor shows it later; and the samples in which it is known at all, in
    /// order, or `None` for all. Choice and intervals know all three.
    #[must_use]
    pub fn with_doubts(
        mut self,
        columns: Vec<Vec<f64>>,
        lag_s: Option<[f64; 2]>,
        known: Option<&[usize]>,
    ) -> Self {
        let [motion] = &mut self.motions[..] else {
            return self;
        };
        let count = self.x.len();
        let columns = columns.into_iter().filter(|column| column.len() >= count);
        self.bounded = columns.collect();
        self.lag_s = lag_s;
        let whole: Vec<usize> = (0..count).collect();
        let known = known.unwrap_or(&whole);
        let known = &known[..known.partition_point(|n| *n < count)];
        if known.len() < count {
            // The motion stays that of all samples.
            motion.way = Some((self.x.clone(), self.first.clone()));
            motion.samples = known.len();
        }
        let all = [&mut self.x, &mut self.first, &mut self.second];
        for values in all.into_iter().chain(&mut self.bounded) {
            *values = known.iter().map(|&n| values[n]).collect();
        }
        self
    }

    /// Record as one of our own logs, in which a model may stand as a loop renders it: what sampling does to the model is then no misfit.
    #[must_use]
    pub const fn of_own_log(mut self) -> Self {
        self.is_own_log = true;
        self
    }

    /// This record for tissue that stiffens by b.
    pub(super) fn stiffened(&self, stiffening: f64) -> Self {
        let mut record = self.clone();
        for motion in &mut record.motions {
            let straight = [1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
            let mut numbers = motion.map.map_or(straight, |map| map.numbers());
            numbers[7] = stiffening;
            motion.map = DepthMap::new(numbers).ok();
        }
        record
    }

    /// Reverses the sign of strain and stress, for records in which compression is negative.
    pub(super) fn turned(&self) -> Self {
        let mut record = self.clone();
        let ways = record
            .motions
            .iter_mut()
            .filter_map(|motion| motion.way.as_mut());
        let strains = ways.map(|way| &mut way.1);
        for values in strains.chain([&mut record.first, &mut record.second]) {
            values.iter_mut().for_each(|value| *value = -*value);
        }
        let warning = "strain and stress are read with the other sign, in which tissue stiffens";
        record.warnings.push(warning.to_owned());
        record
    }

    /// True if its tissue can be seen to stiffen.
    pub(super) fn can_stiffen(&self) -> bool {
        !self.motions.is_empty() && self.motions.iter().all(|motion| motion.can_stiffen)
    }

    /// Sets the largest strain of the specimen, with a warning if it is not small.
    pub(super) fn with_strain_to(mut self, strain: f64) -> Self {
        self.strain_to = Some(strain);
        if strain > SMALL {
            self.warnings.push(format!(
                "the strain reaches {}: a linear law holds to about {SMALL}",
                Shown(strain)
            ));
        }
        self
    }

    /// Leaves out a strain that is not that of the specimen, and what was said of it.
    pub(super) fn forget_strain(&mut self) {
        (self.strain_to, self.warnings) = (None, Vec::new());
    }

    /// The kind decides what is compared: logarithms, or stresses of a motion.
    #[must_use]
    pub const fn kind(&self) -> RecordKind {
        self.kind
    }

    /// Number of samples that the constructor kept.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.x.len()
    }

    /// Times in s, or angular frequencies in rad/s.
    #[must_use]
    pub fn x(&self) -> &[f64] {
        &self.x
    }

    /// Relaxation modulus in Pa, creep compliance in 1/Pa, storage modulus in Pa, or strain.
    #[must_use]
    pub fn first(&self) -> &[f64] {
        &self.first
    }

    /// Loss modulus in Pa, or stress in Pa; empty for relaxation and creep.
    #[must_use]
    pub fn second(&self) -> &[f64] {
        &self.second
    }

    /// Largest strain of the specimen, if the record gives it.
    #[must_use]
    pub const fn strain_to(&self) -> Option<f64> {
        self.strain_to
    }

    fn of_logarithms(
        kind: RecordKind,
        x: Vec<f64>,
        first: Vec<f64>,
        second: Vec<f64>,
    ) -> Result<Self, IdentifyError> {
        let oscillation = kind == RecordKind::Oscillation;
        lengths(&x, &first, oscillation.then_some(&second))?;
        let (what, unit) = if oscillation {
            ("angular frequency", "rad/s")
        } else {
            ("time", "s")
        };
        let (one, other, of) = match kind {
            RecordKind::Creep => ("compliance", "", "1/Pa"),
            RecordKind::Oscillation => ("storage modulus", "loss modulus", "Pa"),
            RecordKind::Relaxation | RecordKind::History => ("modulus", "", "Pa"),
        };
        let mut x = x;
        let begin = if oscillation { None } else { late_clock(&x) };
        let warning = begin.map(|begin| {
            let warning = format!(
                "the times are taken from {} s of the clock on, {} s before the first row, from where they are spread evenly in the logarithm",
                Shown(begin),
                Shown(digits(x[0] - begin))
            );
            x.iter_mut().for_each(|time| *time -= begin);
            warning
        });
        positive(&x, what, unit)?;
        positive(&first, one, of)?;
        positive(&second, other, of)?;
        let mut record = Self::plain(kind, x, first, second);
        if oscillation {
            // Sweeps may go up or down.
            let mut order: Vec<usize> = (0..record.x.len()).collect();
            order.sort_by(|&a, &b| record.x[a].total_cmp(&record.x[b]));
            for column in [&mut record.x, &mut record.first, &mut record.second] {
                *column = order.iter().map(|&i| column[i]).collect();
            }
            record.given = order;
        }
        increasing(&record.x, what, unit, |before, after| before > after)?;
        constant(&record.first, one, of)?;
        record.warnings.extend(warning);
        Ok(record)
    }

    /// A modulus that has decayed by [`RESOLVED`] is rounding, of the model too: its logarithm would outweigh all others.
    fn leave_out_the_unmeasurable(&mut self) {
        let least = RESOLVED * self.first.iter().copied().fold(0.0, f64::max);
        let is_kept = |n: &usize| self.first[*n] >= least;
        let kept: Vec<usize> = (0..self.x.len()).filter(is_kept).collect();
        let left_out = self.x.len() - kept.len();
        if left_out > 0 && kept.len() >= FEW_RESOLVED {
            self.warnings.push(format!(
                "{left_out} samples are below {RESOLVED:e} of the largest modulus, which no instrument resolves: they do not count"
            ));
            for column in [&mut self.x, &mut self.first] {
                *column = kept.iter().map(|&n| column[n]).collect();
            }
            self.given = kept;
        }
    }

    const fn plain(kind: RecordKind, x: Vec<f64>, first: Vec<f64>, second: Vec<f64>) -> Self {
        Self {
            kind,
            given: Vec::new(),
            shared: Vec::new(),
            per: 1.0,
            errors: Vec::new(),
            x,
            first,
            second,
            motions: Vec::new(),
            touch: None,
            nuisance: Vec::new(),
            bounded: Vec::new(),
            expected: Vec::new(),
            lag_s: None,
            steps: Vec::new(),
            later: Vec::new(),
            is_absolute: false,
            strain_to: None,
            is_own_log: false,
            untimed: None,
            warnings: Vec::new(),
        }
    }

    /// Least-squares slope of ln first over ln x.
    pub(super) fn growth(&self) -> f64 {
        let points = || {
            let pairs = self.x.iter().zip(&self.first);
            pairs.map(|(&x, &y)| (libm::log(x), libm::log(y)))
        };
        let n = self.x.len() as f64;
        let (x, y) = points().fold((0.0, 0.0), |sum, p| (sum.0 + p.0 / n, sum.1 + p.1 / n));
        let (xx, xy) = points().fold((0.0, 0.0), |sum, p| {
            (sum.0 + (p.0 - x) * (p.0 - x), sum.1 + (p.0 - x) * (p.1 - y))
        });
        if xx > 0.0 { xy / xx } else { 0.0 }
    }
}

/// A log slope that noise cannot explain: the record is of the other kind.
const GROWTH: f64 = 0.02;
/// Share of the largest modulus that an instrument may resolve; and samples above it without which none is left out.
const RESOLVED: f64 = 1e-9;
const FEW_RESOLVED: usize = 8;
/// Initial rises of a modulus, and their factor, that suggest a ramp.
const FEW_RISES: usize = 2;
const RISE: f64 = 1.05;
/// Ratio of the highest to the lowest frequency below which a record is not a sweep.
const ONE_FREQUENCY: f64 = 1.01;
/// A strain below this share of its range counts as rest.
const REST: f64 = 0.01;
/// Share that counts as rest while the contact point is sought, which may be a little before the record.
pub(super) const REST_OF_FIT: f64 = 0.05;
/// Strain up to which a linear law is believed.
const SMALL: f64 = 0.2;

/// ℓ of a nominal strain δ/ℓ, m; under a cone the scale of its map.
pub(super) fn length(specimen: &Specimen) -> f64 {
    let map = specimen.depth_map();
    let scale = map.map_or(1.0, |map| 1.0 / map.numbers()[0]);
    specimen.length().map_or(scale, |length| length.0)
}

/// γℓ, m²: the force of a specimen over its stress, in the modulus of its loading. Of a slab that slides on its plates the
/// area itself, to the bit.
pub(super) fn area(specimen: &Specimen) -> f64 {
    let shape = specimen.shape(specimen.loading().kind.modulus());
    match specimen.slab_sizes() {
        Some((area, thickness)) => area.0 * (shape / (area.0 / thickness.0)),
        None => shape * length(specimen),
    }
}

/// Refuses what is pressed through.
pub(super) fn within(
    depth_m: &[f64],
    thickness_m: f64,
    kind: LoadingKind,
) -> Result<(), IdentifyError> {
    let bounded = !matches!(kind, LoadingKind::Shear | LoadingKind::Tension);
    let beyond = |depth: &f64| bounded && *depth > thickness_m;
    without(depth_m.iter().position(beyond), |index| {
        format!(
            "depth {} m is beyond the thickness {} m: change {THICKNESS}, or cut the record with {FROM}",
            Shown(depth_m[index]),
            Shown(thickness_m)
        )
    })
}

/// Origin of a clock whose times are evenly spaced in the logarithm from there on, if it is far from 0 and close to the first time, as on the
/// clock of a whole test: the one with the straightest ln(t − origin), at the roundest number near it.
fn late_clock(time_s: &[f64]) -> Option<f64> {
    const LEAST: usize = 8;
    const LATE: f64 = 10.0;
    /// Largest deviation from a straight line, over that with the origin at 0.
    const STRAIGHT: f64 = 0.05;
    /// Steps of the search, and how near the round number is, over the first time.
    const STEPS: i32 = 400;
    const NEAR: f64 = 0.05;
    let first = *time_s.first().filter(|first| **first > 0.0)?;
    let count = time_s.len() as f64;
    if time_s.len() < LEAST || time_s.windows(2).any(|pair| pair[1] <= pair[0]) {
        return None;
    }
    // Root of the mean square beside the straight line.
    let bend = |before: f64| {
        let logs: Vec<f64> = time_s
            .iter()
            .map(|time| libm::log(time - first + before))
            .collect();
        let mean = logs.iter().sum::<f64>() / count;
        let middle = 0.5 * (count - 1.0);
        let pairs = || {
            logs.iter()
                .enumerate()
                .map(|(n, y)| (n as f64 - middle, y - mean))
        };
        let [xx, xy, yy] = [
            pairs().map(|(x, _)| x * x).sum::<f64>(),
            pairs().map(|(x, y)| x * y).sum(),
            pairs().map(|(_, y)| y * y).sum(),
        ];
        libm::sqrt((yy - xy * xy / xx).max(0.0) / count)
    };
    let least = 0.1 * (time_s[1] - first);
    let places =
        (0..=STEPS).map(|n| least * libm::pow(first / least, f64::from(n) / f64::from(STEPS)));
    let best = places.map(|before| (bend(before), before));
    let (left, before) = best.min_by(|a, b| a.0.total_cmp(&b.0))?;
    if LATE * before > first || left > STRAIGHT * bend(first) {
        return None;
    }
    let begin = first - before;
    let round = (-9..=9).rev().map(|power| {
        let unit = libm::pow(10.0, f64::from(power));
        libm::round(begin / unit) * unit
    });
    round
        .into_iter()
        .find(|round| (round - begin).abs() <= NEAR * before)
}

/// Times that rise; or numbers of the samples, and why, where some are equal. Times that fall stay, and are refused.
fn distinct(time_s: Vec<f64>) -> (Vec<f64>, Option<String>) {
    let mut pairs = time_s.windows(2);
    let equal = pairs.clone().position(|pair| pair[1] <= pair[0]);
    let Some(equal) = equal.filter(|_| pairs.all(|pair| pair[1] >= pair[0])) else {
        return (time_s, None);
    };
    let why = if time_s.first() >= time_s.last() {
        "the samples have no times".to_owned()
    } else {
        format!(
            "samples {} and {} have the same time, {} s",
            equal + 1,
            equal + 2,
            Shown(time_s[equal])
        )
    };
    let numbers = (0..time_s.len()).map(|n| n as f64);
    (numbers.collect(), Some(why))
}

const NO_SAMPLES: &str =
    "there are no samples: give at least one more than the model has parameters";

fn lengths(x: &[f64], first: &[f64], second: Option<&Vec<f64>>) -> Result<(), IdentifyError> {
    let n = x.len();
    if first.len() != n || second.is_some_and(|second| second.len() != n) {
        return Err(IdentifyError::Record(
            "the columns have different lengths: give one number of each per sample".to_owned(),
        ));
    }
    match n {
        0 => Err(IdentifyError::Record(NO_SAMPLES.to_owned())),
        1..=SAMPLES_MOST => Ok(()),
        n => Err(IdentifyError::Record(format!(
            "{n} samples are more than {SAMPLES_MOST}: omit every second one, or cut the record"
        ))),
    }
}

/// Refuses the first sample that is wrong, if there is one.
fn without(wrong: Option<usize>, reason: impl Fn(usize) -> String) -> Result<(), IdentifyError> {
    wrong.map_or(Ok(()), |index| {
        let reason = reason(index);
        Err(IdentifyError::Sample { index, reason })
    })
}

/// Refuses errors of fewer samples than were given, and such as are not above 0.
fn are_errors(errors: &[f64], given: &[usize]) -> Result<(), IdentifyError> {
    if given.iter().any(|n| *n >= errors.len()) {
        return Err(IdentifyError::Record(
            "there is not an error for each sample: give one for each, or none".to_owned(),
        ));
    }
    let wrong = errors
        .iter()
        .position(|error| !(*error > 0.0 && error.is_finite()));
    without(wrong, |index| {
        format!(
            "the error {} is not above 0 and finite: correct it, omit the row, or give {}, which leaves all errors out",
            Shown(errors[index]),
            WEIGHTS.set_to("equal")
        )
    })
}

fn positive(values: &[f64], what: &str, unit: &str) -> Result<(), IdentifyError> {
    let wrong = values.iter().position(|&x| !(x > 0.0 && x.is_finite()));
    without(wrong, |index| {
        format!(
            "{what} {} {unit} is not above 0 {unit}: correct it, or omit the rows up to it",
            values[index]
        )
    })
}

fn increasing(
    x: &[f64],
    what: &str,
    unit: &str,
    wrong: impl Fn(f64, f64) -> bool,
) -> Result<(), IdentifyError> {
    let wrong = (1..x.len()).find(|&index| wrong(x[index - 1], x[index]));
    without(wrong, |index| {
        format!(
            "{what} {} {unit} comes after {} {unit} and is not above it: sort the rows",
            x[index],
            x[index - 1]
        )
    })
}

fn constant(values: &[f64], what: &str, unit: &str) -> Result<(), IdentifyError> {
    if values.len() > 1 && values.iter().all(|x| x.to_bits() == values[0].to_bits()) {
        return Err(IdentifyError::Record(format!(
            "{what} is {} {unit} in every sample: check that this is the right column",
            values[0]
        )));
    }
    Ok(())
}

/// Value to three digits, for a sentence.
pub(super) fn digits(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}
