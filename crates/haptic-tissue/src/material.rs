//! Tissues: a model, where its parameters come from, and where they hold; and their files, TOML with units in the names.

use crate::model::{
    Form, Joint, Model, ModelError, ModelKind, ModelParameter, TWO_ELEMENTS, out_of_range,
};
use fracdiff::parameter::Shown;
use haptic_loop::{INCOMPRESSIBLE, LoadingKind, Modulus, Specimen};
use haptic_quantity::{did_you_mean, digits};
use measured_table::read_text;
use serde::ser::SerializeMap as _;
use serde::{Deserialize, Serialize, Serializer};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use toml::Spanned;

/// A tissue by name, with its source.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name on the command line: lower-case letters, digits and hyphens.
    pub name: String,
    /// A few words for people.
    pub description: String,
    /// The model with its parameters.
    pub model: Model,
    /// b of matter that stiffens, see `haptic_loop::loading`; 0 if it does not.
    pub stiffening: f64,
    /// Loading and modulus of the measurement.
    pub loading: MeasuredLoading,
    /// Times, frequencies and strains of the measurement: beyond them the model is a guess.
    pub range: ValidRange,
    /// The origin of the numbers.
    pub source: Source,
    /// The text of its file.
    pub text: String,
    /// E₀, η and α as a file without `model` has them.
    two_elements: Option<[f64; 3]>,
}

/// Loading of the specimen, and the modulus that the parameters of a tissue are; `None` where the source says nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(try_from = "WrittenLoading")]
pub struct MeasuredLoading {
    /// Kind of loading of the specimen.
    pub kind: Option<LoadingKind>,
    /// The modulus that the parameters are.
    pub modulus: Option<Modulus>,
    /// ν, from 0 to 0.5.
    pub poisson_ratio: Option<f64>,
}

impl MeasuredLoading {
    /// The modulus: as stated, or the default of the kind of loading; Young's if neither is known.
    #[must_use]
    pub fn modulus(&self) -> Modulus {
        let of_kind = self.kind.map(LoadingKind::modulus);
        self.modulus.or(of_kind).unwrap_or(Modulus::Young)
    }

    /// False if the modulus is assumed.
    #[must_use]
    pub const fn is_known(&self) -> bool {
        self.modulus.is_some() || self.kind.is_some()
    }

    /// ν: as stated, or that of incompressible matter.
    #[must_use]
    pub fn poisson_ratio(&self) -> f64 {
        self.poisson_ratio.unwrap_or(INCOMPRESSIBLE)
    }

    fn lines(&self) -> String {
        let word = |key: &str, name: Option<&str>| {
            name.map_or(String::new(), |name| format!("{key} = \"{name}\"\n"))
        };
        let ratio = self.poisson_ratio;
        word("kind", self.kind.map(LoadingKind::name))
            + &word("modulus", self.modulus.map(Modulus::name))
            + &ratio.map_or(String::new(), |ratio| {
                format!("poisson_ratio = {ratio:?}\n")
            })
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenLoading {
    kind: Option<String>,
    modulus: Option<String>,
    poisson_ratio: Option<f64>,
}

impl TryFrom<WrittenLoading> for MeasuredLoading {
    type Error = String;

    fn try_from(written: WrittenLoading) -> Result<Self, String> {
        let ratio = written.poisson_ratio;
        if let Some(ratio) = ratio.filter(|ratio| !(0.0..=INCOMPRESSIBLE).contains(ratio)) {
            let value = Shown(ratio);
            return Err(format!(
                "poisson_ratio = {value} is not from 0 to {INCOMPRESSIBLE}"
            ));
        }
        Ok(Self {
            kind: named(
                "kind",
                written.kind,
                &LoadingKind::ALL.map(|kind| (kind, kind.name())),
            )?,
            modulus: named(
                "modulus",
                written.modulus,
                &Modulus::ALL.map(|kind| (kind, kind.name())),
            )?,
            poisson_ratio: ratio,
        })
    }
}

/// The remedy for a name that the library has not: of a table the command that makes a tissue of it, else the nearest name.
fn advice(name: &str, known: &[String]) -> String {
    let of_table = ["csv", "tsv", "txt", "dat", "xlsx"];
    let extension = Path::new(name).extension();
    if extension.is_some_and(|ending| {
        of_table
            .iter()
            .any(|table| ending.eq_ignore_ascii_case(table))
    }) {
        return "`identify` makes one of a table".to_owned();
    }
    did_you_mean(name, known.iter().map(String::as_str))
}

/// One of several by its name.
fn named<T: Copy>(key: &str, name: Option<String>, all: &[(T, &str)]) -> Result<Option<T>, String> {
    let Some(name) = name else { return Ok(None) };
    let found = all.iter().find(|one| one.1 == name);
    found.map(|one| Some(one.0)).ok_or_else(|| {
        let known: Vec<&str> = all.iter().map(|one| one.1).collect();
        format!(
            "{key} = \"{name}\" is not known: use one of {}, or omit it if the source does not say",
            known.join(", ")
        )
    })
}

/// Null where nothing is known.
impl Serialize for MeasuredLoading {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(3))?;
        map.serialize_entry("kind", &self.kind.map(LoadingKind::name))?;
        map.serialize_entry("modulus", &self.modulus.map(Modulus::name))?;
        map.serialize_entry("poisson_ratio", &self.poisson_ratio)?;
        map.end()
    }
}

/// The times, frequencies and strains of the measurement; `None` where the source says nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ValidRange {
    /// Shortest time after a step, s.
    pub time_from_s: Option<f64>,
    /// Longest time after a step, s.
    pub time_to_s: Option<f64>,
    /// Lowest angular frequency, rad/s.
    pub omega_from_rad_s: Option<f64>,
    /// Highest angular frequency, rad/s.
    pub omega_to_rad_s: Option<f64>,
    /// Largest strain of the specimen; a linear law rarely holds beyond 0.2.
    pub strain_to: Option<f64>,
}

/// The origin of a material's parameters.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Source {
    /// Author, title, year, and where in it.
    pub citation: String,
    /// The conditions of the measurement.
    pub conditions: String,
    /// True if the numbers were compared with the cited source itself.
    pub checked: bool,
    /// Anything else that a reader of the numbers should know.
    #[serde(default)]
    pub note: String,
    /// The day of the measurement or of the fit; empty where unknown, as all below.
    #[serde(default)]
    pub date: String,
    /// The specimen: kind, number, size, preparation.
    #[serde(default)]
    pub sample: String,
    /// The temperature of the specimen, with its unit, as `21 °C`.
    #[serde(default)]
    pub temperature: String,
    /// Distance of the model from the record.
    #[serde(default)]
    pub residual: String,
}

/// A material that cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MaterialError {
    /// A mistake in a file; lines count from 1.
    #[error("{}:{line}: {reason}", path.display())]
    File {
        /// The name as it was given.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The mistake with its value, and the remedy.
        reason: String,
    },
    /// A file or folder that cannot be read.
    #[error("cannot read the material file `{file}`: {1}; give a name or a TOML file", file = .0.display())]
    Unreadable(PathBuf, #[source] std::io::Error),
    /// A folder of tissue files that cannot be read.
    #[error("cannot read the library folder `{folder}`: {1}; give a folder of TOML files", folder = .0.display())]
    Folder(PathBuf, #[source] std::io::Error),
    /// A name that is not in the library, and all that are.
    #[error("tissue \"{0}\" is not in the library, nor a TOML file: {advice}", advice = advice(.0, .1))]
    Unknown(String, Vec<String>),
    /// A tissue that is not one spring-pot beside a spring.
    #[error("tissue \"{0}\" is a {1}, which has no single order")]
    Elements(String, ModelKind),
    /// A tissue without a spring-pot, of which one number alone was to be changed.
    #[error("tissue \"{0}\" has no spring-pot")]
    NoSpringPot(String),
    /// Numbers that a model refuses.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A name that is not made of lower-case letters, digits and hyphens.
    #[error("name \"{0}\" is not made of lower-case letters, digits and hyphens")]
    Name(String),
    /// Two files with the same name for a material.
    #[error("{file}: the library has a material \"{0}\" already; choose another name", file = .1.display())]
    Twice(String, PathBuf),
}

impl Material {
    /// A tissue of a model.
    ///
    /// # Errors
    /// A name that is not made of lower-case letters, digits and hyphens.
    pub fn new(
        name: &str,
        description: &str,
        model: Model,
        source: Source,
    ) -> Result<Self, MaterialError> {
        check_name(name)?;
        let material = Self {
            name: name.to_owned(),
            description: description.to_owned(),
            model,
            stiffening: 0.0,
            loading: MeasuredLoading::default(),
            range: ValidRange::default(),
            source,
            text: String::new(),
            two_elements: None,
        };
        Ok(material.with_range(ValidRange::default()))
    }

    /// Replaces the loading of the measurement and b.
    #[must_use]
    pub fn with_loading(mut self, loading: MeasuredLoading, stiffening: f64) -> Self {
        (self.loading, self.stiffening) = (loading, stiffening);
        self.text = self.to_toml();
        self
    }

    /// Replaces the range in which the model holds.
    #[must_use]
    pub fn with_range(mut self, range: ValidRange) -> Self {
        self.range = range;
        self.text = self.to_toml();
        self
    }

    /// E₀, η and α of a spring beside a spring-pot.
    fn kelvin_voigt(&self) -> Option<[f64; 3]> {
        self.two_elements.or_else(|| match self.model.form() {
            Form::One(one) => Some([0.0, one.size, one.order]),
            Form::Two(two) if two.joint == Joint::KelvinVoigt && two.second.is_spring() => {
                Some([two.second.size, two.first.size, two.first.order])
            }
            Form::Two(_) | Form::Branches(..) => None,
        })
    }

    /// Replaces the given numbers of its spring and its spring-pot, E₀ in Pa, η in Pa·s^α and α. The result was not measured:
    /// its name and description say so, and it has no range.
    ///
    /// # Errors
    /// A model of other elements, an order or a size of a spring-pot that has only the one, a number outside its range.
    pub fn with_elements(&self, given: [Option<f64>; 3]) -> Result<Self, MaterialError> {
        let spring = match self.model.form() {
            Form::One(one) if one.is_spring() => Some([one.size, 0.0, 0.0]),
            Form::One(_) | Form::Two(_) | Form::Branches(..) => None,
        };
        let known = self.two_elements.or(spring).or(self.kelvin_voigt());
        let known =
            known.ok_or_else(|| MaterialError::Elements(self.name.clone(), self.model.kind()))?;
        let elements: [f64; 3] = std::array::from_fn(|n| given[n].unwrap_or(known[n]));
        if elements.map(f64::to_bits) == known.map(f64::to_bits) {
            return Ok(self.clone());
        }
        if known[1] == 0.0 && given[1].is_some() != given[2].is_some()
            || elements[1] == 0.0 && given[2].is_some()
        {
            return Err(MaterialError::NoSpringPot(self.name.clone()));
        }
        let (kind, values) = two_elements(elements);
        let words =
            TWO_ELEMENTS
                .iter()
                .zip(elements)
                .zip(given)
                .filter_map(|((one, value), given)| {
                    given.map(|_| format!("{} = {}", one.name, Shown(value)))
                });
        let words: Vec<String> = words.collect();
        let changed = Self {
            name: format!("{}-changed", self.name),
            description: format!("{}, changed to {}", self.description, words.join(", ")),
            model: Model::from_parameters(kind, &values)?,
            two_elements: Some(elements),
            ..self.clone()
        };
        Ok(changed.with_range(ValidRange::default()))
    }

    /// A sentence that says how far these times, s, lie outside the record; `None` if they do not.
    #[must_use]
    pub fn beyond(&self, (from_s, to_s): (f64, f64)) -> Option<String> {
        let [first_s, last_s] = self.range.times_s();
        // A hundredth is no matter.
        let above_1 = |ratio: Option<f64>| ratio.filter(|ratio| *ratio > 1.01);
        let by = [
            (above_1(first_s.map(|first_s| first_s / from_s)), "earlier"),
            (above_1(last_s.map(|last_s| to_s / last_s)), "later"),
        ];
        let by = by
            .iter()
            .filter_map(|(ratio, word)| Some((digits((*ratio)?, 3), word)));
        let by: Vec<String> = by
            .map(|(ratio, word)| format!("{ratio} times {word}"))
            .collect();
        let end = |time_s: Option<f64>| time_s.map_or("?".to_owned(), |time_s| digits(time_s, 4));
        (!by.is_empty()).then(|| {
            format!(
                "the numbers of {} come from {} to {} s; this asks for {} to {} s, {}",
                self.name,
                end(first_s),
                end(last_s),
                digits(from_s, 4),
                digits(to_s, 4),
                by.join(" and ")
            )
        })
    }

    /// E₀ in Pa, if the model is a spring beside a spring-pot; 0 without the spring.
    #[must_use]
    pub fn elastic_modulus_pa(&self) -> Option<f64> {
        self.kelvin_voigt().map(|[modulus, ..]| modulus)
    }

    /// η in Pa·s^α, if the model is a spring beside a spring-pot.
    #[must_use]
    pub fn viscosity_pa_s_alpha(&self) -> Option<f64> {
        self.kelvin_voigt().map(|[_, viscosity, _]| viscosity)
    }

    /// α, if the model is a spring beside a spring-pot.
    #[must_use]
    pub fn order(&self) -> Option<f64> {
        self.kelvin_voigt().map(|[.., order]| order)
    }

    /// Reads one material from the text of its file; `path` is for messages.
    ///
    /// # Errors
    /// [`MaterialError::File`] with line and reason.
    pub fn parse(path: &Path, text: &str) -> Result<Self, MaterialError> {
        parse(text).map_err(|(offset, reason)| MaterialError::File {
            path: path.to_owned(),
            line: 1 + text[..offset.min(text.len())].matches('\n').count(),
            reason,
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

    /// The text of a material file, which reads back to exactly the same numbers. Comments of the
    /// file that it was read from are not in it; [`Material::text`] has them.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let quoted = |words: &str| toml::Value::from(words).to_string();
        let mut text = format!("name = {}\n", quoted(&self.name));
        text += &format!("description = {}\n", quoted(&self.description));
        // `{:?}` of a number is the shortest text that reads back to the same bits.
        let line = |name: &str, value: f64| format!("{name} = {value:?}\n");
        if let Some(values) = self.two_elements {
            text += "\n[parameters]\n";
            text.extend(
                (TWO_ELEMENTS.iter().zip(values)).map(|(one, value)| line(one.name, value)),
            );
        } else {
            let _ = write!(text, "model = \"{}\"\n\n[parameters]\n", self.model.kind());
            text.extend(self.model.columns().map(|(parameter, all)| match all[..] {
                [value] if !parameter.for_each_branch => line(parameter.name, value),
                _ => format!("{} = {all:?}\n", parameter.name),
            }));
        }
        if self.stiffening != 0.0 {
            text += &line(STIFFENING, self.stiffening);
        }
        if self.loading != MeasuredLoading::default() {
            text += "\n[loading]\n";
            text += &self.loading.lines();
        }
        if self.range != ValidRange::default() {
            text += "\n[range]\n";
            let known = self.range.named();
            text.extend(
                known.map(|(name, value)| value.map_or(String::new(), |it| line(name, it))),
            );
        }
        let source = &self.source;
        text += "\n[source]\n";
        text += &format!("citation = {}\n", quoted(&source.citation));
        text += &format!("conditions = {}\n", quoted(&source.conditions));
        text += &format!("checked = {}\n", source.checked);
        for (name, words) in [
            ("note", &source.note),
            ("date", &source.date),
            ("sample", &source.sample),
            ("temperature", &source.temperature),
            ("residual", &source.residual),
        ] {
            if !words.is_empty() {
                text += &format!("{name} = {}\n", quoted(words));
            }
        }
        text
    }
}

impl ValidRange {
    /// The shortest and the longest time, s: as stated, or 1/ω of the frequencies.
    #[must_use]
    pub fn times_s(&self) -> [Option<f64>; 2] {
        let inverse =
            |omega: Option<f64>| omega.filter(|omega| *omega > 0.0).map(|omega| 1.0 / omega);
        [
            self.time_from_s.or_else(|| inverse(self.omega_to_rad_s)),
            self.time_to_s.or_else(|| inverse(self.omega_from_rad_s)),
        ]
    }

    /// Ends by name, each pair side by side.
    fn named(&self) -> [(&'static str, Option<f64>); 5] {
        [
            ("time_from_s", self.time_from_s),
            ("time_to_s", self.time_to_s),
            ("omega_from_rad_s", self.omega_from_rad_s),
            ("omega_to_rad_s", self.omega_to_rad_s),
            ("strain_to", self.strain_to),
        ]
    }

    fn check(&self) -> Result<(), String> {
        let known = self.named();
        for (name, value) in known {
            if let Some(value) = value.filter(|value| !(*value >= 0.0 && value.is_finite())) {
                let value = Shown(value);
                return Err(format!(
                    "{name} = {value} is not a finite number of at least 0"
                ));
            }
        }
        for pair in known.as_chunks::<2>().0 {
            if let [(from_name, Some(from)), (to_name, Some(to))] = *pair
                && from > to
            {
                let (from, to) = (Shown(from), Shown(to));
                return Err(format!(
                    "{to_name} = {to} is below {from_name} = {from}: swap them"
                ));
            }
        }
        Ok(())
    }
}

/// `model` by name, `parameters` by name and number, those of branches as lists; and E₀, η and α of a spring beside a
/// spring-pot, null for other models.
impl Serialize for Material {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("name", &self.name)?;
        map.serialize_entry("description", &self.description)?;
        map.serialize_entry("elastic_modulus_pa", &self.elastic_modulus_pa())?;
        map.serialize_entry("viscosity_pa_s_alpha", &self.viscosity_pa_s_alpha())?;
        map.serialize_entry("order", &self.order())?;
        map.serialize_entry("model", self.model.kind().name())?;
        map.serialize_entry("parameters", &Parameters(&self.model))?;
        map.serialize_entry("stiffening", &self.stiffening)?;
        map.serialize_entry("loading", &self.loading)?;
        map.serialize_entry("range", &self.range)?;
        map.serialize_entry("source", &self.source)?;
        map.end()
    }
}

/// The numbers of a model by their names.
struct Parameters<'a>(&'a Model);

impl Serialize for Parameters<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(
            self.0
                .columns()
                .map(|(parameter, values)| match values[..] {
                    [value] if !parameter.for_each_branch => (parameter.name, Numbers::One(value)),
                    _ => (parameter.name, Numbers::Many(values)),
                }),
        )
    }
}

/// A number or a list of them.
#[derive(Deserialize, Serialize)]
#[serde(untagged, expecting = "expected a number or a list of numbers")]
enum Numbers {
    One(f64),
    Many(Vec<f64>),
}

/// A tissue file as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: Spanned<String>,
    description: String,
    model: Option<Spanned<String>>,
    parameters: Spanned<BTreeMap<String, Spanned<Numbers>>>,
    loading: Option<MeasuredLoading>,
    range: Option<Spanned<ValidRange>>,
    source: Source,
}

/// Place in the text, and reason.
type Wrong = (usize, String);

fn parse(text: &str) -> Result<Material, Wrong> {
    let file: File = toml::from_str(text).map_err(|error| {
        let offset = error.span().map_or(0, |span| span.start);
        // One line; TOML's own message may have several.
        (
            offset,
            // A word between backticks would be a key of ours.
            error
                .message()
                .lines()
                .collect::<Vec<_>>()
                .join("; ")
                .replace('`', "\""),
        )
    })?;
    let name = file.name.get_ref();
    check_name(name).map_err(|error| (file.name.span().start, error.to_string()))?;
    let kind = match &file.model {
        None => None,
        Some(name) => Some(ModelKind::from_name(name.get_ref()).ok_or_else(|| {
            let known = ModelKind::ALL.map(ModelKind::name).join(", ");
            let reason = format!(
                "model \"{}\" is not known: use one of {known}",
                name.get_ref()
            );
            (name.span().start, reason)
        })?),
    };
    let columns = columns(&file, kind)?;
    let block = file.parameters.span().start;
    let (kind, values, two_elements) = match (kind, &columns[..]) {
        (None, [modulus, viscosity, order]) => {
            let written = [modulus[0], viscosity[0], order[0]];
            let (kind, values) = two_elements(written);
            (kind, values, Some(written))
        }
        (Some(ModelKind::Prony), [spring, moduli, times]) => {
            if moduli.len() != times.len() {
                let [first, second] = [1, 2].map(|at| ModelKind::Prony.parameters()[at].name);
                let (one, other) = (moduli.len(), times.len());
                let counts = format!("{first} has {one} numbers and {second} {other}");
                return Err((block, format!("{counts}: each branch has one of each")));
            }
            let pairs = moduli.iter().zip(times).flat_map(|(e, tau)| [*e, *tau]);
            (
                ModelKind::Prony,
                spring.iter().copied().chain(pairs).collect(),
                None,
            )
        }
        (Some(kind), columns) => (kind, columns.concat(), None),
        (None, columns) => {
            let count = columns.len();
            return Err((block, format!("{count} numbers are not E₀, η and α")));
        }
    };
    let model =
        Model::from_parameters(kind, &values).map_err(|error| (block, error.to_string()))?;
    let range = match &file.range {
        None => ValidRange::default(),
        Some(range) => {
            let checked = range.get_ref().check();
            checked.map_err(|reason| (range.span().start, reason))?;
            *range.get_ref()
        }
    };
    Ok(Material {
        name: name.clone(),
        description: file.description,
        model,
        stiffening: stiffening(file.parameters.get_ref())?,
        loading: file.loading.unwrap_or_default(),
        range,
        source: file.source,
        text: text.to_owned(),
        two_elements,
    })
}

/// The key of b, beside the parameters of any model.
pub const STIFFENING: &str = "stiffening";

fn stiffening(given: &BTreeMap<String, Spanned<Numbers>>) -> Result<f64, Wrong> {
    let Some(value) = given.get(STIFFENING) else {
        return Ok(0.0);
    };
    match *value.get_ref() {
        Numbers::One(number) if (0.0..=Specimen::STIFFENING_MAX).contains(&number) => Ok(number),
        Numbers::One(_) | Numbers::Many(_) => {
            let most = Specimen::STIFFENING_MAX;
            let reason = format!("{STIFFENING} is not one number from 0 to {most}");
            Err((value.span().start, reason))
        }
    }
}

/// E₀, η and α as the model that they are: either element may be missing, and D⁰ is the identity.
fn two_elements([modulus, viscosity, alpha]: [f64; 3]) -> (ModelKind, Vec<f64>) {
    if viscosity == 0.0 {
        (ModelKind::Spring, vec![modulus])
    } else if modulus == 0.0 {
        (ModelKind::SpringPot, vec![viscosity, alpha])
    } else if alpha == 0.0 {
        (ModelKind::Spring, vec![modulus + viscosity])
    } else {
        let values = vec![viscosity, alpha, modulus, 0.0];
        (ModelKind::FractionalKelvinVoigt, values)
    }
}

/// The numbers of each parameter of a kind, or of E₀, η and α, within their ranges: one, or one for each branch.
fn columns(file: &File, kind: Option<ModelKind>) -> Result<Vec<Vec<f64>>, Wrong> {
    let known = kind.map_or(&TWO_ELEMENTS[..], ModelKind::parameters);
    let whose = kind.map_or_else(
        || "a tissue without `model`".to_owned(),
        |kind| format!("the model {kind}"),
    );
    let given = file.parameters.get_ref();
    for (name, value) in given {
        if name != STIFFENING && !known.iter().any(|one| one.name == name) {
            let names = known.iter().map(|one| one.name).chain([STIFFENING]);
            let names: Vec<&str> = names.collect();
            let names = names.join(", ");
            let reason = format!("{name} is not a parameter of {whose}, which has {names}");
            return Err((value.span().start, reason));
        }
    }
    let column = |parameter: &ModelParameter| {
        let name = parameter.name;
        let block = file.parameters.span().start;
        let missing = || (block, format!("missing field `{name}` of {whose}"));
        let value = given.get(name).ok_or_else(missing)?;
        let wrong = |reason: String| (value.span().start, reason);
        let numbers = match value.get_ref() {
            Numbers::One(number) if !parameter.for_each_branch => vec![*number],
            Numbers::Many(numbers) if parameter.for_each_branch => numbers.clone(),
            Numbers::One(_) => {
                let remedy = "is not a list: give one number for each branch";
                return Err(wrong(format!("{name} {remedy}")));
            }
            Numbers::Many(_) => return Err(wrong(format!("{name} is a list: give one number"))),
        };
        let outside = numbers
            .iter()
            .find(|number| !parameter.range.contains(**number));
        if let Some(number) = outside {
            let error = out_of_range(parameter, *number, parameter.range.words());
            return Err(wrong(error.to_string()));
        }
        Ok(numbers)
    };
    known.iter().map(column).collect()
}

/// Accepts lower-case letters, digits and hyphens.
fn check_name(name: &str) -> Result<(), MaterialError> {
    let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    if !name.is_empty() && name.chars().all(plain) {
        return Ok(());
    }
    Err(MaterialError::Name(name.to_owned()))
}
