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
    /// ANSYS Mechanical APDL, `TB,PRONY,,,N,SHEAR`: relative moduli α_i = E_i/G(0) and τ_i; the elastic modulus is the instantaneous one.
    Ansys,
    /// Abaqus, `*VISCOELASTIC, TIME=PRONY`: g_i = E_i/G(0), k_i = 0 (no relaxation in bulk), τ_i, with `MODULI=INSTANTANEOUS`.
    Abaqus,
    /// FEBio, material `viscoelastic`: g_0 = 1, g_i = E_i/E, t_i, up to six; the elastic material inside has the long-term modulus E.
    Febio,
}

impl ExportFormat {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Table, Self::Ansys, Self::Abaqus, Self::Febio];

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
        let mut comments = vec![
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
        ];
        let instantaneous = self.instantaneous_modulus_pa();
        let relative = |to: f64| -> Vec<(f64, f64)> {
            let each = self.branches.iter();
            each.map(|one| (one.elastic_modulus_pa / to, one.relaxation_time_s))
                .collect()
        };
        let mut text = String::new();
        match format {
            ExportFormat::Table => {
                comments.push("branch 0 is the spring E".to_owned());
                commented(&mut text, "# ", "", &comments);
                text += "branch,modulus_pa,relaxation_time_s\n";
                let _ = writeln!(text, "0,{:?},inf", self.elastic_modulus_pa);
                for (at, one) in self.branches.iter().enumerate() {
                    let (modulus, time) = (one.elastic_modulus_pa, one.relaxation_time_s);
                    let _ = writeln!(text, "{},{modulus:?},{time:?}", at + 1);
                }
            }
            ExportFormat::Ansys => {
                comments.push(format!(
                    "alpha_i = E_i/G(0) and tau_i in s; the elastic modulus is the instantaneous one, G(0) = {instantaneous:?} Pa"
                ));
                commented(&mut text, "! ", "", &comments);
                let _ = writeln!(text, "TB,PRONY,1,1,{},SHEAR", self.branches.len());
                // TBDATA takes six constants a line.
                for (line, three) in relative(instantaneous).chunks(3).enumerate() {
                    let _ = write!(text, "TBDATA,{}", 1 + 6 * line);
                    for (alpha, tau) in three {
                        let _ = write!(text, ",{alpha:.12e},{tau:.12e}");
                    }
                    text.push('\n');
                }
            }
            ExportFormat::Abaqus => {
                comments.push(format!(
                    "g_i = E_i/G_0, k_i = 0 (no relaxation in bulk), tau_i in s; use with *ELASTIC, MODULI=INSTANTANEOUS, G_0 = {instantaneous:?} Pa"
                ));
                commented(&mut text, "** ", "", &comments);
                text += "*VISCOELASTIC, TIME=PRONY\n";
                for (g, tau) in relative(instantaneous) {
                    let _ = writeln!(text, "{g:.12e}, 0., {tau:.12e}");
                }
            }
            ExportFormat::Febio => {
                if self.branches.len() > FEBIO_TERMS {
                    return Err(ExportError::Terms {
                        given: self.branches.len(),
                        most: FEBIO_TERMS,
                    });
                }
                if self.elastic_modulus_pa <= 0.0 {
                    return Err(ExportError::NoLongTermModulus);
                }
                comments.push(format!(
                    "g_i = E_i/E and t_i in s; put the elastic material inside, with the long-term modulus E = {:?} Pa",
                    self.elastic_modulus_pa
                ));
                // No comment of XML has two hyphens.
                let comments: Vec<String> = (comments.iter())
                    .map(|line| line.replace("--", "- -"))
                    .collect();
                commented(&mut text, "<!-- ", " -->", &comments);
                text += "<g0>1</g0>\n";
                for (at, (g, t)) in relative(self.elastic_modulus_pa).iter().enumerate() {
                    let n = at + 1;
                    let _ = writeln!(text, "<g{n}>{g:.12e}</g{n}><t{n}>{t:.12e}</t{n}>");
                }
            }
        }
        Ok(text)
    }
}

fn commented(text: &mut String, before: &str, after: &str, lines: &[String]) {
    for line in lines {
        let _ = writeln!(text, "{before}{line}{after}");
    }
}
