//! The tissue library: TOML files with parameters, units in the names, and where they come from.

use crate::text_file::read_text;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::{Path, PathBuf};
use toml::Spanned;

/// Files that come with the program: name for messages, content.
const BUILT_IN: [(&str, &str); 2] = [
    (
        "materials/prostate-cancerous.toml",
        include_str!("../materials/prostate-cancerous.toml"),
    ),
    (
        "materials/prostate-healthy.toml",
        include_str!("../materials/prostate-healthy.toml"),
    ),
];

/// A tissue by name, with its source.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Material {
    /// Name on the command line: lower-case letters, digits and hyphens.
    pub name: String,
    /// A few words for people.
    pub description: String,
    /// E₀, Pa.
    pub elastic_modulus_pa: f64,
    /// η, Pa·s^α.
    pub viscosity_pa_s_alpha: f64,
    /// α.
    pub order: f64,
    /// The origin of the numbers.
    pub source: Source,
    /// The text of its file.
    #[serde(skip)]
    pub text: String,
}

/// The origin of a material's parameters.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Source {
    /// Author, title, year, and where in it.
    pub citation: String,
    /// The conditions of the measurement.
    pub conditions: String,
    /// True if the numbers were compared with the cited source itself.
    pub checked: bool,
    /// Anything else.
    #[serde(default)]
    pub note: String,
}

/// A material file as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: Spanned<String>,
    description: String,
    parameters: Spanned<Parameters>,
    source: Source,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Parameters {
    elastic_modulus_pa: Spanned<f64>,
    viscosity_pa_s_alpha: Spanned<f64>,
    order: Spanned<f64>,
}

impl Parameters {
    /// E₀, η and α within their ranges; else where in the file, if it is one of them, and why.
    fn checked(&self) -> Result<(f64, f64, f64), (Option<usize>, String)> {
        let at_least_zero = |value: &Spanned<f64>, name: &str, unit: &str| {
            let number = *value.get_ref();
            if number >= 0.0 && number.is_finite() {
                return Ok(number);
            }
            let reason = format!("{name} = {number} {unit} is not a finite number of at least 0");
            Err((Some(value.span().start), reason))
        };
        let modulus = at_least_zero(&self.elastic_modulus_pa, "elastic_modulus_pa", "Pa")?;
        let viscosity =
            at_least_zero(&self.viscosity_pa_s_alpha, "viscosity_pa_s_alpha", "Pa·s^α")?;
        let alpha = *self.order.get_ref();
        if !(0.0..=1.0).contains(&alpha) {
            let reason = format!("order = {alpha} is not in [0, 1]");
            return Err((Some(self.order.span().start), reason));
        }
        if modulus == 0.0 && viscosity == 0.0 {
            let reason =
                "viscosity of a tissue without elastic modulus 0 Pa·s^α is not above 0 Pa·s^α";
            return Err((None, reason.to_owned()));
        }
        Ok((modulus, viscosity, alpha))
    }
}

/// A material that cannot be used.
#[derive(Debug)]
pub enum MaterialError {
    /// A file that is wrong: file, line, reason.
    File {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The mistake in it.
        reason: String,
    },
    /// A file or folder that cannot be read.
    Unreadable(PathBuf, std::io::Error),
    /// A folder of tissue files that cannot be read.
    Folder(PathBuf, std::io::Error),
    /// A name that is not in the library.
    Unknown {
        /// The name.
        name: String,
        /// All there are.
        known: Vec<String>,
    },
    /// Two files with the same name for a material.
    Twice(String, PathBuf),
}

impl fmt::Display for MaterialError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File { path, line, reason } => {
                write!(f, "{}:{line}: {reason}", path.display())
            }
            Self::Unreadable(path, error) => write!(
                f,
                "cannot read the material file `{}`: {error}; give the name of a material or a path \
                 to its TOML file",
                path.display()
            ),
            Self::Folder(path, error) => write!(
                f,
                "cannot read the library folder `{}`: {error}; give a folder of tissue files (*.toml)",
                path.display()
            ),
            Self::Unknown { name, known } => write!(
                f,
                "tissue \"{}\" is not in the library: take one of {}, or give the path of a TOML \
                 file (`host-cli materials show {}` prints one to start from)",
                name,
                known.join(", "),
                known.first().map_or("NAME", String::as_str),
            ),
            Self::Twice(name, path) => write!(
                f,
                "{}: the library has a material \"{name}\" already; choose another name",
                path.display()
            ),
        }
    }
}

impl std::error::Error for MaterialError {}

impl Material {
    /// Reads one material from the text of its file; `path` is for messages.
    ///
    /// # Errors
    /// [`MaterialError::File`] with line and reason.
    pub fn parse(path: &Path, text: &str) -> Result<Self, MaterialError> {
        let fail = |offset: usize, reason: String| MaterialError::File {
            path: path.to_owned(),
            line: 1 + text[..offset.min(text.len())].matches('\n').count(),
            reason,
        };
        let file: File = toml::from_str(text).map_err(|error| {
            let offset = error.span().map_or(0, |span| span.start);
            // One line; TOML's own message may have several.
            fail(
                offset,
                error.message().lines().collect::<Vec<_>>().join("; "),
            )
        })?;
        let name = file.name.get_ref();
        let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        if name.is_empty() || !name.chars().all(plain) {
            let reason = format!(
                "name \"{}\" is not made of lower-case letters, digits and hyphens",
                name
            );
            return Err(fail(file.name.span().start, reason));
        }
        let block = file.parameters.span().start;
        let (modulus, viscosity, alpha) = (file.parameters.into_inner())
            .checked()
            .map_err(|(offset, reason)| fail(offset.unwrap_or(block), reason))?;
        Ok(Self {
            name: name.clone(),
            description: file.description,
            elastic_modulus_pa: modulus,
            viscosity_pa_s_alpha: viscosity,
            order: alpha,
            source: file.source,
            text: text.to_owned(),
        })
    }

    /// Reads a material file.
    ///
    /// # Errors
    /// If it cannot be read or is wrong.
    pub fn read(path: &Path) -> Result<Self, MaterialError> {
        let text =
            read_text(path).map_err(|error| MaterialError::Unreadable(path.to_owned(), error))?;
        Self::parse(path, &text)
    }
}

/// The materials that are known by name.
#[derive(Clone, Debug, PartialEq)]
pub struct Library {
    materials: Vec<Material>,
}

impl Library {
    /// Those that come with the program, and all `*.toml` files of a folder of the user's.
    ///
    /// # Errors
    /// If a file is wrong or a name is taken.
    pub fn load(folder: Option<&Path>) -> Result<Self, MaterialError> {
        let mut materials = Vec::new();
        for (name, text) in BUILT_IN {
            materials.push(Material::parse(Path::new(name), text)?);
        }
        for path in folder.map(toml_files).transpose()?.unwrap_or_default() {
            let material = Material::read(&path)?;
            if materials.iter().any(|known| known.name == material.name) {
                return Err(MaterialError::Twice(material.name, path));
            }
            materials.push(material);
        }
        Ok(Self { materials })
    }

    /// All, the program's own first.
    #[must_use]
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// A material by name, or from the file where `name` is a path that ends in `.toml`.
    ///
    /// # Errors
    /// If there is none of that name, or the file is wrong.
    pub fn find(&self, name: &str) -> Result<Material, MaterialError> {
        if Path::new(name).extension().is_some_and(|e| e == "toml") {
            return Material::read(Path::new(name));
        }
        let found = self.materials.iter().find(|known| known.name == name);
        found.cloned().ok_or_else(|| MaterialError::Unknown {
            name: name.to_owned(),
            known: self.materials.iter().map(|m| m.name.clone()).collect(),
        })
    }
}

/// The TOML files of a folder, by name.
fn toml_files(folder: &Path) -> Result<Vec<PathBuf>, MaterialError> {
    let fail = |error| MaterialError::Folder(folder.to_owned(), error);
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(fail)? {
        let path = entry.map_err(fail)?.path();
        if path
            .extension()
            .is_some_and(|extension| extension == "toml")
        {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "decimal input has one nearest double")]
mod tests {
    use super::*;

    const GOOD: &str = "name = \"gel\"\ndescription = \"a gel\"\n\n[parameters]\n\
        elastic_modulus_pa = 100\nviscosity_pa_s_alpha = 5.0\norder = 0.3\n\n[source]\n\
        citation = \"me, 2026\"\nconditions = \"21 °C\"\nchecked = true\n";

    fn reason(from: &str, to: &str) -> String {
        assert!(GOOD.contains(from), "{from}");
        let text = GOOD.replace(from, to);
        let error = Material::parse(Path::new("gel.toml"), &text).expect_err(to);
        let message = error.to_string();
        assert!(!message.contains('\n'), "{message}");
        message
    }

    #[test]
    fn the_library_that_comes_with_the_program_is_the_dissertations() {
        let library = Library::load(None).expect("valid");
        let numbers: Vec<_> = library
            .materials()
            .iter()
            .map(|m| {
                (
                    m.name.as_str(),
                    m.viscosity_pa_s_alpha,
                    m.order,
                    m.source.checked,
                )
            })
            .collect();
        assert_eq!(
            numbers,
            [
                ("prostate-cancerous", 8650.0, 0.2247, false),
                ("prostate-healthy", 3610.0, 0.2154, false)
            ]
        );
    }

    #[test]
    fn a_wrong_file_is_refused_with_file_line_and_reason() {
        assert!(Material::parse(Path::new("gel.toml"), GOOD).is_ok());
        for (from, to, want) in [
            (
                "order = 0.3",
                "order = 1.3",
                "gel.toml:7: order = 1.3 is not in [0, 1]",
            ),
            (
                "order = 0.3",
                "order = nan",
                "gel.toml:7: order = NaN is not in [0, 1]",
            ),
            (
                "= 5.0",
                "= -5.0",
                "gel.toml:6: viscosity_pa_s_alpha = -5 Pa·s^α is not",
            ),
            (
                "= 100",
                "= \"x\"",
                "gel.toml:5: invalid type: string \"x\", expected f64",
            ),
            ("order = 0.3\n", "", "gel.toml:4: missing field `order`"),
            (
                "order = 0.3",
                "ordre = 0.3",
                "gel.toml:7: unknown field `ordre`",
            ),
            (
                "\"gel\"",
                "\"Gel 1\"",
                "gel.toml:1: name \"Gel 1\" is not made of",
            ),
            ("[source]", "[source", "gel.toml:9:"),
        ] {
            let have = reason(from, to);
            assert!(have.starts_with(want), "have {have}\nwant {want}");
        }
    }

    #[test]
    fn a_folder_of_the_users_extends_the_library() {
        let folder = tempfile::tempdir().expect("folder");
        std::fs::write(folder.path().join("gel.toml"), GOOD).expect("writes");
        std::fs::write(folder.path().join("notes.txt"), "x").expect("writes");
        let library = Library::load(Some(folder.path())).expect("valid");
        assert_eq!(library.find("gel").expect("known").order, 0.3);
        let unknown = library.find("jelly").expect_err("unknown").to_string();
        assert!(unknown.contains("prostate-healthy, gel"), "{unknown}");
        // A second of the same name.
        std::fs::write(folder.path().join("too.toml"), GOOD).expect("writes");
        assert!(matches!(
            Library::load(Some(folder.path())),
            Err(MaterialError::Twice(_, _))
        ));
    }
}
