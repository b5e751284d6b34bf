//! Models for programs that know Prony series only: finite-element programs, above all.
//! ```text
//! G(t) ≈ E + Σ E_i·e^(−t/τ_i),   E, E_i ≥ 0,   shortest ≤ t ≤ horizon
//! ```

use crate::material::MeasuredLoading;
use crate::model::{Form, MaxwellBranch, Model, ModelError, ModelKind};
use crate::sampled::{Branch, Part};
use fracdiff::enumerated;
use fracdiff::full_memory::non_negative_least_squares;
use fracdiff::parameter::Shown;
use haptic_loop::Modulus;
use haptic_quantity::Key;
use std::fmt::Write as _;
use std::ops::RangeInclusive;

const BRANCHES: Key = Key("branches");
const CARD: Key = Key("card");
const HORIZON: Key = Key("horizon_s");
const SHORTEST: Key = Key("shortest_s");

/// Times of the fit for each decade; the error is looked for at four times as many.
const TIMES_A_DECADE: f64 = 20.0;
const DECADES_MOST: f64 = 30.0;

/// A Prony series over a band of times.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PronyFit {
    /// The spring that is left at the end of the band, Pa; 0 without one.
    pub elastic_modulus_pa: f64,
    /// Fastest first; none for a spring, and fewer than requested where least squares sets some to
    /// 0.
    pub branches: Vec<MaxwellBranch>,
    /// Shortest time of the band, s.
    pub shortest_s: f64,
    /// Longest time of the band, s.
    pub horizon_s: f64,
    /// Largest relative error of G over the band.
    pub max_relative_error: f64,
}

/// Why this band or model has no such series.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// A number of branches outside [`PronyFit::BRANCHES`].
    #[error(
        "{BRANCHES} {0} is not from {least} to {most}: 2 per decade reach about 1 %",
        least = PronyFit::BRANCHES.start(), most = PronyFit::BRANCHES.end()
    )]
    Branches(usize),
    /// Times that are no band: shortest and longest, s.
    #[error(
        "{SHORTEST} {} s must be above 0 s, and {HORIZON} {} s from 0 to {DECADES_MOST} decades longer",
        Shown(*.0), Shown(*.1)
    )]
    Band(f64, f64),
    /// A dashpot beside the rest: its stress is an impulse, which no branch has.
    #[error(
        "{0} has a parallel dashpot, which no Prony series can hold: give the dashpot separately"
    )]
    Impulse(ModelKind),
    /// G has fallen to nothing within the band, at this time, s.
    #[error("the modulus has decayed to zero by {} s: use a {HORIZON} below it", Shown(*.0))]
    Vanished(f64),
    /// More terms than the format has: their number, and the most.
    #[error(
        "the format takes {1} branches, the series has {0}: use {fewer}",
        fewer = BRANCHES.set_to(.1)
    )]
    Terms(usize, usize),
    /// A format that refers to the long-term modulus, and a series without one.
    #[error("the format needs a long-term modulus: use the format table")]
    NoLongTermModulus,
    /// A format without whole materials.
    #[error("the format {0} has no card of a whole material: use ansys or abaqus, or omit {CARD}")]
    Card(&'static str),
    /// A series that is no model.
    #[error(transparent)]
    Model(#[from] ModelError),
}

impl PronyFit {
    /// The numbers of branches that a fit takes: two for each decade of time give about 1 %.
    pub const BRANCHES: RangeInclusive<usize> = 1..=100;

    /// Fits at most `branches` branches to G(t), `shortest_s` ≤ t ≤ `horizon_s`.
    ///
    /// Relaxation times at even distances in log τ; moduli by least squares of the relative error
    /// without negative ones, so there may be fewer branches than requested. The first and the last
    /// τ are those with the least largest error. A Prony series with no more branches stays
    /// unchanged, as does a classical model that is one. Cost: 10 ms.
    /// ```
    /// use haptic_tissue::{Library, PronyFit};
    ///
    /// let muscle = Library::load(None)?.find("fish-muscle")?;
    /// let series = PronyFit::new(&muscle.model, 12, 1e-3, 1000.0)?;
    /// assert!(series.max_relative_error < 0.01);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`ExportError`] says.
    pub fn new(
        model: &Model,
        branches: usize,
        shortest_s: f64,
        horizon_s: f64,
    ) -> Result<Self, ExportError> {
        if !Self::BRANCHES.contains(&branches) {
            return Err(ExportError::Branches(branches));
        }
        let decades = libm::log10(horizon_s / shortest_s);
        let is_band = shortest_s > 0.0 && horizon_s.is_finite();
        if !(is_band && decades > 0.0 && decades <= DECADES_MOST) {
            return Err(ExportError::Band(shortest_s, horizon_s));
        }
        if has_impulse(model) {
            return Err(ExportError::Impulse(model.kind()));
        }
        if let Some((elastic_modulus_pa, series)) = exact(model)
            && series.len() <= branches
        {
            return Ok(Self {
                elastic_modulus_pa,
                branches: series,
                shortest_s,
                horizon_s,
                max_relative_error: 0.0,
            });
        }
        let band = Band::new(model, shortest_s, horizon_s, decades)?;
        Ok(band.best(branches))
    }

    /// The series as a model.
    ///
    /// # Errors
    /// A series with neither a spring nor a branch.
    pub fn model(&self) -> Result<Model, ExportError> {
        let branches = self.branches.iter();
        let pairs = branches.flat_map(|one| [one.elastic_modulus_pa, one.relaxation_time_s]);
        let values: Vec<f64> = std::iter::once(self.elastic_modulus_pa)
            .chain(pairs)
            .collect();
        Ok(Model::from_parameters(ModelKind::Prony, &values)?)
    }

    /// G(0) of the series, Pa.
    #[must_use]
    pub fn instantaneous_modulus_pa(&self) -> f64 {
        let moduli = self.branches.iter().map(|one| one.elastic_modulus_pa);
        moduli.fold(self.elastic_modulus_pa, |sum, one| sum + one)
    }
}

fn has_impulse(model: &Model) -> bool {
    let is_dashpot = |branch: &Branch| matches!(branch, Branch::Pot(one) if one.is_dashpot());
    Part::of(model.form()).branches.iter().any(is_dashpot)
}

/// Spring and branches of a model that is a Prony series, whatever its name.
fn exact(model: &Model) -> Option<(f64, Vec<MaxwellBranch>)> {
    if let Form::Branches(beside, branches) = model.form()
        && beside.is_spring()
    {
        return Some((beside.size, branches.clone()));
    }
    let whole = Part::of(model.form());
    let branches = whole.branches.iter().map(|branch| {
        let (elastic_modulus_pa, viscosity_pa_s) = branch.maxwell()?;
        Some(MaxwellBranch {
            elastic_modulus_pa,
            relaxation_time_s: viscosity_pa_s / elastic_modulus_pa,
        })
    });
    Some((whole.spring_pa, branches.collect::<Option<_>>()?))
}

struct Band {
    shortest_s: f64,
    horizon_s: f64,
    times: Vec<f64>,
    moduli: Vec<f64>,
    fine_times: Vec<f64>,
    fine_moduli: Vec<f64>,
}

impl Band {
    fn new(
        model: &Model,
        shortest_s: f64,
        horizon_s: f64,
        decades: f64,
    ) -> Result<Self, ExportError> {
        let times = |a_decade: f64| -> Vec<f64> {
            let count = libm::ceil(decades * a_decade).max(8.0);
            (0..=count as usize)
                .map(|at| shortest_s * libm::pow(10.0, decades * at as f64 / count))
                .collect()
        };
        let (times, fine_times) = (times(TIMES_A_DECADE), times(4.0 * TIMES_A_DECADE));
        let fine_moduli = model.relaxation_moduli(&fine_times);
        let vanished = |g: &f64| !(*g > 1e-250 && g.is_finite());
        if let Some(at) = fine_moduli.iter().position(vanished) {
            return Err(ExportError::Vanished(fine_times[at]));
        }
        Ok(Self {
            shortest_s,
            horizon_s,
            moduli: model.relaxation_moduli(&times),
            times,
            fine_times,
            fine_moduli,
        })
    }

    /// The first and the last τ, in decades from the ends of the band: coarse steps, then finer ones about the best.
    fn best(&self, branches: usize) -> PronyFit {
        let (mut best, mut ends) = (self.fit(branches, 0.0, 0.0), [0.0, 0.0]);
        for step in [0.3, 0.1, 0.03] {
            let centre = ends;
            for first in -4..=4 {
                for last in -4..=4 {
                    let first = centre[0] + step * f64::from(first);
                    let last = centre[1] + step * f64::from(last);
                    let fit = self.fit(branches, first, last);
                    if fit.max_relative_error < best.max_relative_error {
                        (best, ends) = (fit, [first, last]);
                    }
                }
            }
        }
        best
    }

    fn fit(&self, branches: usize, first: f64, last: f64) -> PronyFit {
        let low = libm::log10(self.shortest_s) + first;
        let high = libm::log10(self.horizon_s) + last;
        let steps = branches.max(2) - 1;
        let relaxation_times: Vec<f64> = (0..branches)
            .map(|at| {
                let share = if branches == 1 {
                    0.5
                } else {
                    at as f64 / steps as f64
                };
                libm::pow(10.0, low + (high - low) * share)
            })
            .collect();
        // Columns: the spring, then the branches; each row divided by G, so the residuals are relative.
        let relative = |value: &dyn Fn(f64) -> f64| -> Vec<f64> {
            let rows = self.times.iter().zip(&self.moduli);
            rows.map(|(&t, g)| value(t) * (self.moduli[0] / g))
                .collect()
        };
        let mut columns = vec![relative(&|_| 1.0)];
        columns.extend(
            relaxation_times
                .iter()
                .map(|tau| relative(&|t| libm::exp(-t / tau))),
        );
        let target = vec![1.0; self.times.len()];
        let shares = non_negative_least_squares(columns, target);
        let moduli: Vec<f64> = shares.iter().map(|share| share * self.moduli[0]).collect();
        let found = relaxation_times.iter().zip(&moduli[1..]);
        let branches = found
            .filter(|(tau, modulus)| **modulus > 0.0 && **tau > 0.0)
            .map(|(&relaxation_time_s, &elastic_modulus_pa)| MaxwellBranch {
                elastic_modulus_pa,
                relaxation_time_s,
            })
            .collect();
        let mut fit = PronyFit {
            elastic_modulus_pa: moduli[0],
            branches,
            shortest_s: self.shortest_s,
            horizon_s: self.horizon_s,
            max_relative_error: 0.0,
        };
        fit.max_relative_error = self.error(&fit);
        fit
    }

    fn error(&self, fit: &PronyFit) -> f64 {
        let rows = self.fine_times.iter().zip(&self.fine_moduli);
        rows.fold(0.0, |most, (&t, g)| {
            let sum = fit
                .branches
                .iter()
                .fold(fit.elastic_modulus_pa, |sum, one| {
                    sum + one.elastic_modulus_pa * libm::exp(-t / one.relaxation_time_s)
                });
            f64::max(most, (sum / g - 1.0).abs())
        })
    }
}

/// FEBio's material `viscoelastic` has parameters up to `g6`, `t6`.
const FEBIO_TERMS: usize = 6;

enumerated! {
    /// The programs whose conventions are known.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum ExportFormat {
        /// A table in SI units: modulus and relaxation time of each branch, the spring as branch 0.
        Table "table",
        /// ANSYS Mechanical APDL, `TB,PRONY,,,N,SHEAR` and the same of `BULK`, for Poisson's ratio is constant: relative moduli
        /// `α_i = E_i/G(0)` and `τ_i`; the elastic modulus is the instantaneous one. A spring has no card.
        Ansys "ansys",
        /// Abaqus, `*VISCOELASTIC, TIME=PRONY`: `g_i = k_i = E_i/G(0)`, for Poisson's ratio is constant, `τ_i`, with
        /// `MODULI=INSTANTANEOUS`. A spring has no card.
        Abaqus "abaqus",
        /// FEBio, material `viscoelastic`: `g0 = 1`, `g_i = E_i/E`, `t_i`, up to six; the elastic material inside has the long-term
        /// modulus E. Source: `FEViscoElasticMaterial.cpp` of FEBio.
        Febio "febio",
    }
}

impl ExportFormat {
    /// Default number of branches of a series for it: 12, or the most that it takes.
    #[must_use]
    pub const fn branches(self) -> usize {
        match self {
            Self::Febio => FEBIO_TERMS,
            Self::Table | Self::Ansys | Self::Abaqus => 12,
        }
    }
}

enumerated! {
    /// Part of a material that a text has.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum Card {
        /// The series, for a material whose elasticity stands elsewhere.
        #[default]
        Series "series" "the Prony series alone",
        /// The elasticity too: a material that is ready.
        Material "material" "a whole material, of ansys and abaqus",
    }
}

/// Ansys takes no Poisson's ratio of 0.5.
const ANSYS_RATIO: f64 = 0.4999;

impl PronyFit {
    /// The series in the convention of a program, with comments that describe it, including which
    /// modulus it is. `title` is one line of text, whose first word names the material.
    ///
    /// # Errors
    /// More branches than the program takes; a convention that needs a long-term modulus, and a series without one; a whole material
    /// of a format without.
    pub fn text(
        &self,
        format: ExportFormat,
        card: Card,
        title: &str,
        loading: &MeasuredLoading,
    ) -> Result<String, ExportError> {
        if format == ExportFormat::Febio {
            if self.branches.len() > FEBIO_TERMS {
                return Err(ExportError::Terms(self.branches.len(), FEBIO_TERMS));
            }
            if self.elastic_modulus_pa <= 0.0 {
                return Err(ExportError::NoLongTermModulus);
            }
        }
        let body = match format {
            ExportFormat::Table => self.table(),
            ExportFormat::Ansys | ExportFormat::Abaqus if self.branches.is_empty() => String::new(),
            ExportFormat::Ansys => self.ansys(),
            ExportFormat::Abaqus => self.abaqus(),
            ExportFormat::Febio => self.febio(),
        };
        let head = match card {
            Card::Series => String::new(),
            Card::Material => self.material(format, title, loading)?,
        };
        Ok(self.comments(format, title, loading) + &head + &body)
    }

    /// Young's modulus over the modulus of the series.
    fn young(loading: &MeasuredLoading) -> f64 {
        match loading.modulus() {
            Modulus::Young => 1.0,
            Modulus::Shear => 2.0 * (1.0 + loading.poisson_ratio()),
        }
    }

    /// Lines above the series of a whole material: its name and its elasticity.
    fn material(
        &self,
        format: ExportFormat,
        title: &str,
        loading: &MeasuredLoading,
    ) -> Result<String, ExportError> {
        let modulus = Self::young(loading) * self.instantaneous_modulus_pa();
        let ratio = loading.poisson_ratio();
        let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
        let name = title.split_whitespace().next().unwrap_or("tissue");
        let name: String = name.chars().map(plain).collect();
        let instantaneous = if self.branches.is_empty() {
            ""
        } else {
            ", MODULI=INSTANTANEOUS"
        };
        let is_incompressible = ratio > ANSYS_RATIO;
        let [hybrid, mixed] = [
            "** nu = 0.5 needs hybrid elements\n",
            "! nu = 0.5 is written 0.4999: use elements with u-P formulation\n",
        ]
        .map(|note| if is_incompressible { note } else { "" });
        match format {
            ExportFormat::Abaqus => Ok(format!(
                "{hybrid}*MATERIAL, NAME={name}\n*ELASTIC{instantaneous}\n{modulus:.12e}, {ratio:?}\n"
            )),
            ExportFormat::Ansys => Ok(format!(
                "{mixed}MP,EX,1,{modulus:.12e}\nMP,PRXY,1,{:?}\n",
                ratio.min(ANSYS_RATIO)
            )),
            ExportFormat::Table | ExportFormat::Febio => Err(ExportError::Card(format.name())),
        }
    }

    fn comments(&self, format: ExportFormat, title: &str, loading: &MeasuredLoading) -> String {
        // Elastic materials of these programs take Young's modulus.
        let young = Self::young(loading);
        let instantaneous = young * self.instantaneous_modulus_pa();
        let convention = match format {
            ExportFormat::Table => "branch 0 is the spring E".to_owned(),
            ExportFormat::Ansys | ExportFormat::Abaqus if self.branches.is_empty() => format!(
                "a spring does not relax, so there is no card; Young's modulus = {instantaneous:?} Pa"
            ),
            ExportFormat::Ansys => format!(
                "alpha_i = E_i/G(0) of shear and bulk, tau_i in s; Young's modulus at 0 = {instantaneous:?} Pa"
            ),
            ExportFormat::Abaqus => format!(
                "g_i = k_i = E_i/G_0, tau_i in s; MODULI=INSTANTANEOUS, Young's modulus at 0 = {instantaneous:?} Pa"
            ),
            ExportFormat::Febio => format!(
                "g_i = E_i/E, t_i in s; elastic material of Young's modulus {:?} Pa",
                young * self.elastic_modulus_pa
            ),
        };
        let [before, after] = match format {
            ExportFormat::Table => ["# ", ""],
            ExportFormat::Ansys => ["! ", ""],
            ExportFormat::Abaqus => ["** ", ""],
            ExportFormat::Febio => ["<!-- ", " -->"],
        };
        let lines = [
            title.replace('\n', " "),
            format!(
                "G(t) = E + sum E_i exp(-t/tau_i), {} branches, for t from {} s to {} s",
                self.branches.len(),
                self.shortest_s,
                self.horizon_s
            ),
            format!(
                "largest relative error of G over this band: {:.2e}; not beyond it",
                self.max_relative_error
            ),
            format!(
                "G here is the {}{}; E = 2(1 + nu) times the shear modulus, nu = {:?}",
                match loading.modulus() {
                    Modulus::Shear => "shear modulus",
                    Modulus::Young => "Young's modulus",
                },
                if loading.is_known() {
                    ""
                } else {
                    ", as assumed: the tissue's file does not say"
                },
                loading.poisson_ratio()
            ),
            convention,
        ];
        // No comment of XML has two hyphens.
        let line = |line: &String| format!("{before}{}{after}\n", line.replace("--", "- -"));
        lines.iter().map(line).collect()
    }

    /// `E_i` over a modulus, and `τ_i`.
    fn relative(&self, modulus_pa: f64) -> Vec<(f64, f64)> {
        let each = self.branches.iter();
        each.map(|one| (one.elastic_modulus_pa / modulus_pa, one.relaxation_time_s))
            .collect()
    }

    fn table(&self) -> String {
        let mut text = format!(
            "branch,modulus_pa,relaxation_time_s\n0,{:?},inf\n",
            self.elastic_modulus_pa
        );
        for (at, one) in self.branches.iter().enumerate() {
            let (modulus, time) = (one.elastic_modulus_pa, one.relaxation_time_s);
            let _ = writeln!(text, "{},{modulus:?},{time:?}", at + 1);
        }
        text
    }

    fn ansys(&self) -> String {
        let mut text = String::new();
        let relative = self.relative(self.instantaneous_modulus_pa());
        for part in ["SHEAR", "BULK"] {
            let _ = writeln!(text, "TB,PRONY,1,1,{},{part}", relative.len());
            // TBDATA takes six constants a line.
            for (line, three) in relative.chunks(3).enumerate() {
                let _ = write!(text, "TBDATA,{}", 1 + 6 * line);
                for (alpha, tau) in three {
                    let _ = write!(text, ",{alpha:.12e},{tau:.12e}");
                }
                text.push('\n');
            }
        }
        text
    }

    fn abaqus(&self) -> String {
        let mut text = "*VISCOELASTIC, TIME=PRONY\n".to_owned();
        for (g, tau) in self.relative(self.instantaneous_modulus_pa()) {
            let _ = writeln!(text, "{g:.12e}, {g:.12e}, {tau:.12e}");
        }
        text
    }

    fn febio(&self) -> String {
        let mut text = "<g0>1</g0>\n".to_owned();
        for (at, (g, t)) in self.relative(self.elastic_modulus_pa).iter().enumerate() {
            let n = at + 1;
            let _ = writeln!(text, "<g{n}>{g:.12e}</g{n}><t{n}>{t:.12e}</t{n}>");
        }
        text
    }
}
