//! A Prony series as the text that a finite-element program reads.

use super::fit::{ExportError, PronyFit};
use std::fmt::Write as _;

/// FEBio's material `viscoelastic` has parameters up to `g6`, `t6`.
const FEBIO_TERMS: usize = 6;

/// The programs whose conventions are known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ExportFormat {
    /// A table in SI units: modulus and relaxation time of each branch, the spring as branch 0.
    Table,
    /// ANSYS Mechanical APDL, `TB,PRONY,,,N,SHEAR`: relative moduli `α_i = E_i/G(0)` and `τ_i`; the elastic modulus is the
    /// instantaneous one.
    Ansys,
    /// Abaqus, `*VISCOELASTIC, TIME=PRONY`: `g_i = E_i/G(0)`, `k_i = 0` (no relaxation in bulk), `τ_i`, with
    /// `MODULI=INSTANTANEOUS`.
    Abaqus,
    /// FEBio, material `viscoelastic`: `g0 = 1`, `g_i = E_i/E`, `t_i`, up to six; the elastic material inside has the long-term
    /// modulus E. Source: `FEViscoElasticMaterial.cpp` of FEBio.
    Febio,
}

impl ExportFormat {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Table, Self::Ansys, Self::Abaqus, Self::Febio];

    /// The branches of a series for it, unless more or fewer are asked for: 12, or the most that it takes.
    #[must_use]
    pub const fn branches(self) -> usize {
        match self {
            Self::Febio => FEBIO_TERMS,
            _ => 12,
        }
    }

    /// The name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Table => "table",
            Self::Ansys => "ansys",
            Self::Abaqus => "abaqus",
            Self::Febio => "febio",
        }
    }
}

impl PronyFit {
    /// The series in the convention of a program, with comments that say what it is. `title` is one line for people.
    ///
    /// # Errors
    /// More branches than the program takes; a convention that needs a long-term modulus, and a series without one.
    pub fn text(&self, format: ExportFormat, title: &str) -> Result<String, ExportError> {
        if format == ExportFormat::Febio {
            if self.branches.len() > FEBIO_TERMS {
                return Err(ExportError::Terms {
                    given: self.branches.len(),
                    most: FEBIO_TERMS,
                });
            }
            if self.elastic_modulus_pa <= 0.0 {
                return Err(ExportError::NoLongTermModulus);
            }
        }
        let body = match format {
            ExportFormat::Table => self.table(),
            ExportFormat::Ansys => self.ansys(),
            ExportFormat::Abaqus => self.abaqus(),
            ExportFormat::Febio => self.febio(),
        };
        Ok(self.comments(format, title) + &body)
    }

    fn comments(&self, format: ExportFormat, title: &str) -> String {
        let instantaneous = self.instantaneous_modulus_pa();
        let (before, after, convention) = match format {
            ExportFormat::Table => ("# ", "", "branch 0 is the spring E".to_owned()),
            ExportFormat::Ansys => (
                "! ",
                "",
                format!(
                    "alpha_i = E_i/G(0) and tau_i in s; the elastic modulus is the instantaneous one, G(0) = {instantaneous:?} Pa"
                ),
            ),
            ExportFormat::Abaqus => (
                "** ",
                "",
                format!(
                    "g_i = E_i/G_0, k_i = 0 (no relaxation in bulk), tau_i in s; use with *ELASTIC, MODULI=INSTANTANEOUS, \
                     G_0 = {instantaneous:?} Pa"
                ),
            ),
            ExportFormat::Febio => (
                "<!-- ",
                " -->",
                format!(
                    "g_i = E_i/E and t_i in s; put the elastic material inside, with the long-term modulus E = {:?} Pa",
                    self.elastic_modulus_pa
                ),
            ),
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
                "largest relative error of G over this band: {:.2e}; beyond it the series is no model of the tissue",
                self.max_relative_error
            ),
            "G is stress over strain as in the tissue's source, in simple shear or along one axis"
                .to_owned(),
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
        let mut text = format!("TB,PRONY,1,1,{},SHEAR\n", self.branches.len());
        // TBDATA takes six constants a line.
        let relative = self.relative(self.instantaneous_modulus_pa());
        for (line, three) in relative.chunks(3).enumerate() {
            let _ = write!(text, "TBDATA,{}", 1 + 6 * line);
            for (alpha, tau) in three {
                let _ = write!(text, ",{alpha:.12e},{tau:.12e}");
            }
            text.push('\n');
        }
        text
    }

    fn abaqus(&self) -> String {
        let mut text = "*VISCOELASTIC, TIME=PRONY\n".to_owned();
        for (g, tau) in self.relative(self.instantaneous_modulus_pa()) {
            let _ = writeln!(text, "{g:.12e}, 0., {tau:.12e}");
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
