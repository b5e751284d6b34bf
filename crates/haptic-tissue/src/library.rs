//! The tissue library: the files that come with the crate, and a folder of the user's.

use crate::material::{Material, MaterialError};
use measured_table::{files_in, read_text};
use std::path::{Path, PathBuf};

/// The files that come with the program.
const BUILT_IN: [&str; 16] = [
    include_str!("../materials/prostate-cancerous.toml"),
    include_str!("../materials/prostate-healthy.toml"),
    include_str!("../materials/fish-muscle.toml"),
    include_str!("../materials/mucus.toml"),
    include_str!("../materials/rat-tail-tendon.toml"),
    include_str!("../materials/passive-muscle.toml"),
    include_str!("../materials/zebrafish-gray-matter.toml"),
    include_str!("../materials/brain-cortex.toml"),
    include_str!("../materials/brain-corona-radiata.toml"),
    include_str!("../materials/liver.toml"),
    include_str!("../materials/spleen.toml"),
    include_str!("../materials/kidney.toml"),
    include_str!("../materials/pancreas.toml"),
    include_str!("../materials/spring.toml"),
    include_str!("../materials/dashpot.toml"),
    include_str!("../materials/spring-pot.toml"),
];

/// The materials that are known by name.
#[derive(Clone, Debug, PartialEq)]
pub struct Library {
    materials: Vec<Material>,
    skipped: Vec<Skipped>,
}

/// A file of the user's folder that is no tissue, or a damaged one, or a second of its name.
#[derive(Clone, Debug, PartialEq)]
struct Skipped {
    path: PathBuf,
    why: String,
    /// The name that was taken.
    taken: Option<String>,
}

impl Library {
    /// The tissues that come with the program, and all `*.toml` files in a folder of the user. A
    /// file that is not a tissue, or whose name is taken, is [skipped](Self::skipped).
    ///
    /// # Errors
    /// If the folder cannot be read.
    pub fn load(folder: Option<&Path>) -> Result<Self, MaterialError> {
        let mut library = Self {
            materials: Vec::new(),
            skipped: Vec::new(),
        };
        for text in BUILT_IN {
            let material = Material::parse(Path::new("built-in"), text)?;
            library.materials.push(material);
        }
        folder.map_or(Ok(()), |folder| library.add_folder(folder))?;
        Ok(library)
    }

    /// Takes in all `*.toml` files of a folder, as [`load`](Self::load) does.
    ///
    /// # Errors
    /// If the folder cannot be read.
    pub fn add_folder(&mut self, folder: &Path) -> Result<(), MaterialError> {
        for path in toml_files(folder)? {
            let read = Material::read(&path);
            if let Err(error) = read.and_then(|material| self.add(&path, material)) {
                self.skipped.push(Skipped {
                    path,
                    why: error.to_string(),
                    taken: if let MaterialError::Twice(name, _) = error {
                        Some(name)
                    } else {
                        None
                    },
                });
            }
        }
        Ok(())
    }

    /// Takes in a tissue; `path` is its file, for messages.
    ///
    /// # Errors
    /// If its name is taken.
    pub fn add(&mut self, path: &Path, material: Material) -> Result<(), MaterialError> {
        if self.materials.iter().any(|m| m.name == material.name) {
            return Err(MaterialError::Twice(material.name, path.to_owned()));
        }
        self.materials.push(material);
        Ok(())
    }

    /// One line for each file of the user's folder that is not a tissue: which, and why.
    pub fn skipped(&self) -> impl Iterator<Item = String> {
        let each = self.skipped.iter();
        each.map(|file| format!("skipped in the library: {}", file.why))
    }

    /// All, the program's own first.
    #[must_use]
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// A material by name, or from the file where `name` is a path that ends in `.toml`.
    ///
    /// # Errors
    /// If none or two have that name, or the file is invalid, including a skipped one of
    /// the library.
    pub fn find(&self, name: &str) -> Result<Material, MaterialError> {
        if Path::new(name).extension().is_some_and(|e| e == "toml") {
            return Material::read(Path::new(name));
        }
        let mut skipped = self.skipped.iter();
        if let Some(second) = skipped.find(|file| file.taken.as_deref() == Some(name)) {
            // Two files have this name, and neither takes precedence.
            return Err(MaterialError::Twice(name.to_owned(), second.path.clone()));
        }
        let found = self.materials.iter().find(|known| known.name == name);
        let damaged = self.skipped.iter().find(|file| file.is_of(name));
        if let (None, Some(file)) = (found, damaged) {
            return Material::read(&file.path);
        }
        found.cloned().ok_or_else(|| {
            let known = self.materials.iter().map(|m| m.name.clone());
            MaterialError::Unknown(name.to_owned(), known.collect())
        })
    }
}

impl Skipped {
    /// True if this would be the tissue of that name, were it whole: by its own word, or by the name of the file.
    fn is_of(&self, name: &str) -> bool {
        let named = read_text(&self.path).is_ok_and(|text| {
            let line = text.lines().find_map(|line| line.strip_prefix("name"));
            let value = line.and_then(|line| line.trim_start().strip_prefix('='));
            value.is_some_and(|value| value.trim().trim_matches(['"', '\'']) == name)
        });
        named || self.path.file_stem().is_some_and(|stem| stem == name)
    }
}

/// The TOML files of a folder, by name.
fn toml_files(folder: &Path) -> Result<Vec<PathBuf>, MaterialError> {
    files_in(folder, "toml").map_err(|error| MaterialError::Folder(folder.to_owned(), error))
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptic_loop::Modulus;

    const GOOD: &str = "name = \"gel\"\ndescription = \"a gel\"\n\n[parameters]\n\
        elastic_modulus_pa = 100\nviscosity_pa_s_alpha = 5.0\norder = 0.3\n\n[source]\n\
        citation = \"me, 2026\"\nconditions = \"21 °C\"\nchecked = true\n";

    #[test]
    fn the_library_that_comes_with_the_program_has_its_sources() {
        let library = Library::load(None).expect("valid");
        let names = library.materials().iter().map(|m| m.name.as_str());
        let names: Vec<_> = names.collect();
        let built_in = [
            "prostate-cancerous",
            "prostate-healthy",
            "fish-muscle",
            "mucus",
            "rat-tail-tendon",
            "passive-muscle",
            "zebrafish-gray-matter",
            "brain-cortex",
            "brain-corona-radiata",
            "liver",
            "spleen",
            "kidney",
            "pancreas",
            "spring",
            "dashpot",
            "spring-pot",
        ];
        assert_eq!(names, built_in);
        let checked = library.materials().iter().filter(|m| m.source.checked);
        let checked: Vec<_> = checked.map(|m| m.name.as_str()).collect();
        let seen = ["liver", "spleen", "kidney", "pancreas"];
        assert_eq!(checked, seen);
        // What the source does not say stays unknown.
        let unknown = library.materials().iter().filter(|m| !m.loading.is_known());
        let unknown: Vec<_> = unknown.map(|m| m.name.as_str()).collect();
        assert_eq!(unknown, built_in[..4]);
        for (name, viscosity, order) in [
            ("prostate-cancerous", 8650.0, 0.2247),
            ("prostate-healthy", 3610.0, 0.2154),
        ] {
            let prostate = library.find(name).expect("known");
            let elastic = prostate.elastic_modulus_pa();
            assert_eq!(
                (elastic, prostate.viscosity_pa_s_alpha()),
                (Some(0.0), Some(viscosity))
            );
            assert_eq!(prostate.order(), Some(order));
        }
    }

    /// The tissue of a record, the times of the record, and its other column.
    fn with_record(name: &str, record: &str) -> (Material, Vec<f64>, Vec<f64>) {
        let tissue = Library::load(None).and_then(|all| all.find(name));
        let number = |cell: &str| cell.parse::<f64>().expect("a number");
        let rows = record.lines().skip(1);
        let rows = rows.map(|line| line.split_once('\t').expect("two columns"));
        let rows = rows.map(|(time, value)| (number(time), number(value)));
        let (times, values) = rows.unzip();
        (tissue.expect("known"), times, values)
    }

    fn rms_log_error(have: &[f64], want: &[f64]) -> f64 {
        let errors = have.iter().zip(want).map(|(have, want)| have / want);
        let squares = errors.map(|ratio| libm::pow(libm::log(ratio), 2.0));
        libm::sqrt(squares.sum::<f64>() / want.len() as f64)
    }

    #[test]
    fn fish_muscle_is_within_half_a_percent_of_its_record() {
        let record = include_str!("../records/fish-muscle-relaxation.tsv");
        let (muscle, times, moduli) = with_record("fish-muscle", record);
        assert_eq!(times.len(), 566);
        let rms = rms_log_error(&muscle.model.relaxation_moduli(&times), &moduli);
        assert!(rms < 0.0046, "{rms}");
        let range = muscle.range;
        assert_eq!(range.time_from_s, times.first().copied());
        assert!(range.time_to_s >= times.last().copied().map(libm::floor));
    }

    #[test]
    fn mucus_is_within_one_percent_of_its_record() {
        let record = include_str!("../records/mucus-creep.tsv");
        let (mucus, times, compliances) = with_record("mucus", record);
        assert_eq!(times.len(), 20);
        let rms = rms_log_error(&mucus.model.creep_compliances(&times), &compliances);
        assert!(rms < 0.0085, "{rms}");
        let ends = (mucus.range.time_from_s, mucus.range.time_to_s);
        assert_eq!(ends, (times.first().copied(), times.last().copied()));
    }

    #[test]
    fn tissues_without_a_record_here_meet_samples_of_their_sources() {
        let library = Library::load(None).expect("valid");
        // Strain, time since it was reached (the middle of the tendon's slow ramp), stress in Pa.
        for (name, strain, time_s, stress) in [
            ("rat-tail-tendon", 0.05, 14.4, 15.74e6),
            ("rat-tail-tendon", 0.05, 184.3, 10.98e6),
            ("passive-muscle", 0.2377, 0.943, 7801.0),
            ("passive-muscle", 0.2377, 104.6, 5563.0),
            ("passive-muscle", 0.2377, 299.4, 5367.0),
            ("brain-cortex", 0.05, 1.0, 350.4),
            ("brain-cortex", 0.1, 1.0, 1148.4),
            ("brain-corona-radiata", 0.05, 1.0, 202.4),
            ("brain-corona-radiata", 0.1, 1.0, 759.1),
        ] {
            let tissue = library.find(name).expect("known");
            let b = tissue.stiffening;
            let seen = if b == 0.0 {
                strain
            } else {
                libm::expm1(b * strain) / b
            };
            let have = seen * tissue.model.relaxation_moduli(&[time_s])[0];
            let ratio = have / stress;
            assert!((ratio - 1.0).abs() < 0.05, "{name} at {time_s} s: {ratio}");
        }
        // Shear wave speeds in m/s, at 1000 kg/m³.
        for (name, speed) in [
            ("liver", 1.36),
            ("spleen", 2.2),
            ("kidney", 1.93),
            ("pancreas", 1.2),
        ] {
            let organ = library.find(name).expect("known");
            assert_eq!(organ.loading.modulus(), Modulus::Shear);
            let ratio = organ.model.instantaneous_modulus() / (1000.0 * speed * speed);
            assert!((ratio - 1.0).abs() < 1e-3, "{name}: {ratio}");
        }
    }

    #[test]
    fn gray_matter_of_a_zebrafish_takes_the_force_of_its_record() {
        let gray = Library::load(None).and_then(|all| all.find("zebrafish-gray-matter"));
        let gray = gray.expect("known");
        let (viscosity, order) = (gray.viscosity_pa_s_alpha(), gray.order());
        let (viscosity, order) = (viscosity.expect("one"), order.expect("one"));
        let (radius, depth, duration) = (18.64e-6_f64, 3.31e-6_f64, 0.36);
        // Lee and Radok: a sphere at constant speed into a spring-pot of Young's modulus, ν = 0.5.
        let beta = libm::tgamma(1.5) / libm::tgamma(2.5 - order);
        let elastic = 16.0 / 9.0 * libm::sqrt(radius) * libm::pow(depth, 1.5);
        let force = elastic * viscosity * 1.5 * beta * libm::pow(duration, -order);
        // 4.0 nN at the deepest point.
        assert!((force / 4.0e-9 - 1.0).abs() < 0.06, "{force}");
    }

    #[test]
    fn a_folder_of_the_users_extends_the_library() {
        let folder = tempfile::tempdir().expect("folder");
        std::fs::write(folder.path().join("gel.toml"), GOOD).expect("writes");
        std::fs::write(folder.path().join("notes.txt"), "x").expect("writes");
        let library = Library::load(Some(folder.path())).expect("valid");
        assert_eq!(library.find("gel").expect("known").order(), Some(0.3));
        let unknown = library.find("jelly").expect_err("unknown").to_string();
        assert!(unknown.contains("spring-pot, gel"), "{unknown}");
        // A second of the same name.
        std::fs::write(folder.path().join("too.toml"), GOOD).expect("writes");
        let library = Library::load(Some(folder.path())).expect("valid");
        let skipped: Vec<String> = library.skipped().collect();
        let taken = "too.toml: the library has a material \"gel\" already";
        assert_eq!(skipped.len(), 1, "{skipped:?}");
        assert!(skipped[0].contains(taken), "{skipped:?}");
        let twice = library.find("gel").expect_err("which").to_string();
        assert!(twice.contains(taken), "{twice}");
    }
}
