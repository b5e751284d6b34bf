//! A controller and its plant, or a plant alone: the command, the page and Python judge them and run them by this.

pub mod analysis;
pub mod run;

use super::controller::{CommandLimits, controller_scheme, read};
use super::form::form;
use crate::words::loose_factor;
use fracdiff::Seconds;
use fracdiff::parameter::Shown;
use fractional_control::{
    ControllerParameters, ControllerSetup, FractionalTransferFunction, PidParameters, Plant,
    SetPoint,
};
use haptic_document::parameters::Paths;
use haptic_document::parameters::range::{
    DAMPINGS, DEAD_TIMES, DEVICE_TIMES, DURATIONS, MASSES, NUMBERS, SAMPLE_TIMES, STIFFNESSES,
};
use haptic_document::{Failure, short};
use haptic_trial::ControllerFile;
use haptic_trial::advice::{in_degrees, refused};
use haptic_trial::plant_file::{DeviceValues, PlantModel, TABLES};
use measured_table::is_file;
use std::path::Path;

form! {
    /// A plant, its controller, and a run of both, by the names of keys; numbers in SI units.
    LoopForm, CONTROL_LOOP:
    "Plant"
    PLANT = plant: text("", "Transfer function, as in 0.55exp(-s)/(62s+1), plant file (.toml), or, for control design only, measured response (.csv, .txt and such: frequency with gain and phase, or real and imaginary)");
    LOOP_MASS = mass_kg: optional(MASSES, "Mass of a device in place of a plant: force in, position out");
    LOOP_DAMPING = damping_n_s_per_m: optional(DAMPINGS, "Viscous damping of the device");
    LOOP_HAND = hand_stiffness_n_per_m: optional(STIFFNESSES, "Stiffness of the hand that holds the device");
    LOOP_LAG = current_lag_s: optional(DEVICE_TIMES, "Time constant of the actuator's current");
    FURTHER_DELAY = delay_s: optional(DEAD_TIMES, "Dead time, in addition to the plant's");
    "Controller"
    LOOP_CONTROLLER = controller: file("", Paths::Toml, None, "Controller file (.toml), or notation, as in 2+3/s^0.9+0.1s^0.5");
    CONTROLLER_TIME = sample_time_s: optional(SAMPLE_TIMES, "Sample time [default: from the controller file]");
    LOOP_SCHEME = scheme: text("", "Scheme: full or full-bdf2, each with :TOLERANCE [default: from the controller file, else full-bdf2]");
    COMMAND_LIMITS = output_limits: text("", "Limits of the command, as in -10:10 [default: from the controller file, else none]");
    "Trial"
    RUN_LENGTH = duration_s: optional(DURATIONS, "Length [default: 60 times 1/crossover]");
    STEP_HEIGHT = step: number(1.0, "1", NUMBERS, "Height of the step");
    REFERENCE = reference: text("", "CSV with time_s and reference, in place of a step");
}

/// A plant and its name.
#[derive(Clone, Debug)]
pub struct NamedPlant {
    /// The plant, with all of its dead time.
    pub plant: Plant,
    /// The plant for sentences; names the dead time that a form adds.
    pub words: String,
    /// A sentence on its notation, where that can be read in two ways.
    pub hint: Option<String>,
}

impl NamedPlant {
    /// The plant of a file or of a notation.
    ///
    /// # Errors
    /// A value outside its range, matrices whose sizes do not fit.
    pub fn of(model: &PlantModel) -> Result<Self, Failure> {
        Ok(Self {
            plant: model.plant().map_err(refused)?,
            words: model.in_words(),
            hint: None,
        })
    }

    /// True if it was measured: it can be tuned for, not run.
    fn is_measured(&self) -> bool {
        self.plant.band().1.is_finite()
    }
}

/// Parts of a form that are files or objects: each is taken in place of its text.
#[derive(Clone, Debug, Default)]
#[expect(missing_docs, reason = "each field is in place of the key of its name")]
pub struct FormParts {
    pub plant: Option<NamedPlant>,
    pub controller: Option<ControllerSetup>,
}

/// The path in a text: one that ends so, or of a file that is there.
fn path<'t>(text: &'t str, endings: &[&str]) -> Option<&'t Path> {
    let path = Path::new(text);
    let ending = path.extension().unwrap_or_default();
    let mut endings = endings.iter();
    let is_path = endings.any(|known| ending.eq_ignore_ascii_case(known)) || is_file(path);
    is_path.then_some(path)
}

impl LoopForm {
    /// Plant and controller of the files that are named. Not for a page, whose texts are no paths.
    ///
    /// # Errors
    /// A file that cannot be read or is wrong.
    pub fn files(&self) -> Result<FormParts, Failure> {
        let plant = path(&self.plant, &[&TABLES[..], &["toml"]].concat());
        let plant = plant.map(|path| NamedPlant::of(&PlantModel::read(path)?));
        let controller = path(&self.controller, &["toml"]);
        let controller = controller.map(|path| Ok::<_, Failure>(ControllerFile::read(path)?.setup));
        Ok(FormParts {
            plant: plant.transpose()?,
            controller: controller.transpose()?,
        })
    }

    /// The plant: the one that is held, that of the notation, or a device of this mass.
    ///
    /// # Errors
    /// No plant, or two; a number outside its range.
    pub fn plant(&self, held: Option<NamedPlant>) -> Result<NamedPlant, Failure> {
        self.check()?;
        let of_device = [
            (LOOP_MASS, self.mass_kg),
            (LOOP_DAMPING, self.damping_n_s_per_m),
            (LOOP_HAND, self.hand_stiffness_n_per_m),
            (LOOP_LAG, self.current_lag_s),
        ];
        let delay_s = self.delay_s.unwrap_or(0.0);
        if let Some((key, _)) = of_device.iter().find(|(_, number)| number.is_some()) {
            if self.mass_kg.is_none() || held.is_some() || !self.plant.is_empty() {
                return Err(Failure::bad_input(format_args!(
                    "{key} belongs to a device: give {LOOP_MASS} and no {PLANT}, or omit it"
                )));
            }
            let numbers = of_device.map(|(_, number)| number.unwrap_or(0.0));
            let [
                mass_kg,
                damping_n_s_per_m,
                hand_stiffness_n_per_m,
                current_lag_s,
            ] = numbers;
            let device = NamedPlant::of(&PlantModel::Device(DeviceValues {
                mass_kg,
                damping_n_s_per_m,
                hand_stiffness_n_per_m,
                delay_s,
                current_lag_s,
                ..DeviceValues::default()
            }));
            return device
                .map_err(|failure| failure.and(&format!("change {LOOP_MASS} or {LOOP_LAG}")));
        }
        let mut named = held.map_or_else(|| self.notation(), Ok)?;
        if delay_s > 0.0 {
            let plant = named.plant.delayed(delay_s);
            let advice = format!("change {FURTHER_DELAY}");
            named.plant = plant.map_err(|error| Failure::input_with_advice(error, advice))?;
            named.words += &format!(", {} s more dead time", Shown(delay_s));
        }
        Ok(named)
    }

    fn notation(&self) -> Result<NamedPlant, Failure> {
        let text = &*self.plant;
        if text.is_empty() {
            return Err(Failure::bad_input(format_args!(
                "no plant: give {PLANT}, as in 1/(62s+1) or plant.toml, or {LOOP_MASS} of a device"
            )));
        }
        let model: PlantModel = text.parse().map_err(|error| {
            let (shown, error) = (short(text), in_degrees(&error));
            Failure::bad_input(if text.starts_with("s^") && !text.contains('/') { format!("plant \"{shown}\": an operator alone is no plant: give it to {LOOP_CONTROLLER}") } else { format!("plant \"{shown}\": {error}; write a power as s^2, a number for any letter but s, or a file that ends in .toml or .csv") })
        })?;
        Ok(NamedPlant {
            hint: loose_factor("plant", text),
            ..NamedPlant::of(&model)?
        })
    }
}

/// The controller of a file or of a notation, at this sample time.
///
/// # Errors
/// A file or a notation that is wrong; a notation without a sample time.
pub fn controller_of(text: &str, sample_time_s: Option<f64>) -> Result<ControllerSetup, Failure> {
    let Some(path) = path(text, &["toml"]) else {
        return noted(text, sample_time_s);
    };
    let mut setup = ControllerFile::read(path)?.setup;
    setup.sample_time_s = sample_time_s.unwrap_or(setup.sample_time_s);
    Ok(setup)
}

fn noted(text: &str, sample_time_s: Option<f64>) -> Result<ControllerSetup, Failure> {
    let law = law(text)?;
    let Some(sample_time_s) = sample_time_s else {
        return Err(Failure::bad_input(format_args!(
            "a controller in notation has no sample time: give {CONTROLLER_TIME}, as in 1ms"
        )));
    };
    Ok(ControllerSetup {
        // On the error, as it is written.
        set_point: SetPoint::ERROR,
        ..ControllerSetup::new(law, Seconds(sample_time_s))
    })
}

/// A PI^λD^μ, or any proper function.
fn law(text: &str) -> Result<ControllerParameters, Failure> {
    if let Ok(pid) = text.parse::<PidParameters>() {
        return Ok(pid.into());
    }
    let function = text.parse::<FractionalTransferFunction>();
    function.map(Into::into).map_err(|error| {
        let read = loose_factor("controller", text).map(|read| format!("; {read}"));
        let (text, error, read) = (short(text), in_degrees(&error), read.unwrap_or_default());
        Failure::bad_input(format_args!(
            "controller \"{text}\": {error}{read}; change {LOOP_CONTROLLER}, as in 2+3/s^0.9+0.1s^0.5"
        ))
    })
}

/// A loop, or a plant alone, to be judged or run.
///
/// ```
/// use haptic_question::control_loop::{ControlLoop, FormParts, LoopForm};
///
/// let form = "{\"plant\": \"1/(s+1)\", \"controller\": \"2+1/s\", \"sample_time_s\": 0.01}";
/// let form: LoopForm = serde_json::from_str(form)?;
/// let asked = ControlLoop::of(form, FormParts::default())?;
/// let judged = asked.analysed()?.report;
/// assert!(judged["reason"].as_str().is_some_and(|reason| reason.starts_with("Stable, proved.")));
/// assert_eq!(asked.simulated(None)?.report["at_reference"], true);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct ControlLoop {
    /// The plant, with the dead time that the form adds.
    pub plant: NamedPlant,
    /// The controller; a plant without one is looked at alone.
    pub controller: Option<ControllerSetup>,
    /// The form as it was given; a run takes its step and length from it.
    pub form: LoopForm,
    warnings: Vec<String>,
}

impl ControlLoop {
    /// Understands a form, with what is held of it.
    ///
    /// # Errors
    /// As [`LoopForm::plant`] and [`controller_of`]; keys without an effect.
    pub fn of(form: LoopForm, held: FormParts) -> Result<Self, Failure> {
        let mut plant = form.plant(held.plant)?;
        let mut warnings = Vec::from_iter(plant.hint.take());
        let scheme = read(LOOP_SCHEME, &form.scheme, controller_scheme)?;
        let limits = read(COMMAND_LIMITS, &form.output_limits, CommandLimits::parse)?;
        let mut controller = held.controller;
        if controller.is_none() && !form.controller.is_empty() {
            controller = Some(noted(&form.controller, form.sample_time_s)?);
            warnings.extend(loose_factor("controller", &form.controller));
        }
        if let Some(setup) = &mut controller {
            setup.sample_time_s = form.sample_time_s.unwrap_or(setup.sample_time_s);
            setup.scheme = scheme.unwrap_or(setup.scheme);
            if let Some(limits) = limits {
                (setup.output_low, setup.output_high) = (Some(limits.low), Some(limits.high));
            }
            setup.check().map_err(refused)?;
        } else if scheme.is_some() || limits.is_some() {
            let key = scheme.map_or(COMMAND_LIMITS, |_| LOOP_SCHEME);
            return Err(Failure::bad_input(format_args!(
                "{key} has no effect without a controller: give {LOOP_CONTROLLER} too, or omit it"
            )));
        }
        Ok(Self {
            plant,
            controller,
            form,
            warnings,
        })
    }
}
