//! Arguments and manners that all experiments share.

use super::conduct::conduct;
use super::summary::print_summary;
use super::words::{parse_scheme, roll_bytes};
use crate::choice::choice;
use crate::command::drive::DriveArguments;
use crate::command::live::LiveArguments;
use crate::command::materials::folder::library;
use crate::command::preflight::PreflightArguments;
use crate::command::realtime::RealtimeArguments;
use crate::command::remote::RemoteArguments;
use crate::command::safety::SafetyArguments;
use crate::files::{folder, overwrite_acts};
use crate::output::Output;
use crate::parameter::{help_with_default, seed_for};
use crate::picture::of_theory;
use crate::whole::whole;
use crate::within::within;
use clap::Args;
use fracdiff::Scheme;
use haptic_experiment::curves::{Published, TheoryCurves};
use haptic_experiment::failure::Failure;
use haptic_experiment::folder::FolderRequest;
use haptic_experiment::{
    Contact, ModelledTissue, Precision, Rendering, Report, Safety, Sensors, Supervisor, parameters,
};
use haptic_link::LoopMode;
use haptic_loop::Specimen;
use haptic_loop::units::{Metres, SquareMetres};
use haptic_quantity::{Area, Bytes, Force, ForceRate, Length, Time};
use haptic_tissue::Library;
use std::path::PathBuf;

/// What every run may be told: how the device is kept safe, which it is, how it is judged before, and who watches.
#[derive(Debug, Args)]
pub struct SharedArguments {
    #[command(flatten)]
    pub(super) safety: SafetyArguments,
    #[command(flatten)]
    pub(super) remote: RemoteArguments,
    #[command(flatten)]
    pub(super) preflight: PreflightArguments,
    #[command(flatten)]
    pub(super) live: LiveArguments,
}

/// What is rendered, on what, and where the files go.
#[derive(Debug, Args)]
pub struct RenderingArguments {
    #[arg(long, help = parameters::TISSUE.help, value_name = "NAME|FILE.toml", default_value = parameters::TISSUE.shown, help_heading = "Tissue")]
    tissue: String,
    #[arg(long, help = parameters::LIBRARY.help, value_name = "DIR", help_heading = "Tissue")]
    library: Option<PathBuf>,
    #[arg(long, value_parser = within::<Area>(parameters::AREA.range()), help = parameters::AREA.help, default_value = parameters::AREA.shown, allow_hyphen_values = true, help_heading = "Tissue")]
    area: Area,
    #[arg(long, value_parser = within::<Length>(parameters::THICKNESS.range()), help = parameters::THICKNESS.help, default_value = parameters::THICKNESS.shown, allow_hyphen_values = true, help_heading = "Tissue")]
    thickness: Length,
    #[arg(long, help = parameters::SCHEME.help, value_parser = parse_scheme, default_value = parameters::SCHEME.shown, help_heading = "Loop")]
    scheme: Scheme,
    #[arg(long, help = help_with_default(&parameters::PRECISION), value_parser = choice::<Precision>(), help_heading = "Loop")]
    precision: Option<Precision>,
    #[arg(long, value_parser = within::<Time>(parameters::SAMPLE_TIME.range()), help = parameters::SAMPLE_TIME.help, default_value = parameters::SAMPLE_TIME.shown, allow_hyphen_values = true, help_heading = "Loop")]
    sample_time: Time,
    #[arg(long, help = parameters::CONTACT.help, value_parser = choice::<Contact>(), default_value = parameters::CONTACT.shown, help_heading = "Rig")]
    contact: Contact,
    #[command(flatten)]
    drive: DriveArguments,
    #[arg(long, value_parser = within::<Length>(parameters::ENCODER_RESOLUTION.range()), help = parameters::ENCODER_RESOLUTION.help, value_name = "LENGTH", default_value = parameters::ENCODER_RESOLUTION.shown, allow_hyphen_values = true, help_heading = "Rig")]
    encoder_resolution: Length,
    #[arg(long, value_parser = within::<Length>(parameters::SENSOR_NOISE.range()), help = parameters::SENSOR_NOISE.help, value_name = "LENGTH", default_value = parameters::SENSOR_NOISE.shown, allow_hyphen_values = true, help_heading = "Rig")]
    sensor_noise: Length,
    #[arg(long, help = help_with_default(&parameters::SEED), value_parser = whole::<u64>(0..=u64::MAX), allow_hyphen_values = true, help_heading = "Rig")]
    seed: Option<u64>,
    #[arg(long, value_parser = within::<Force>(parameters::FORCE_LIMIT.range()), help = parameters::FORCE_LIMIT.help, value_name = "FORCE", default_value = parameters::FORCE_LIMIT.shown, allow_hyphen_values = true, help_heading = "Loop")]
    force_limit: Force,
    #[arg(long, value_parser = within::<ForceRate>(parameters::FORCE_RATE_LIMIT.range()), help = parameters::FORCE_RATE_LIMIT.help, value_name = "RATE", default_value = parameters::FORCE_RATE_LIMIT.shown, allow_hyphen_values = true, help_heading = "Loop")]
    force_rate_limit: ForceRate,
    #[command(flatten)]
    realtime: RealtimeArguments,
    #[command(flatten)]
    shared: SharedArguments,
    /// Folder for log, CSV and pictures [default: the next free results/NAME-0001]
    #[arg(long, value_name = "DIR", help_heading = "Files")]
    out: Option<PathBuf>,
    /// Replace the files of an earlier run in the folder
    #[arg(long, help_heading = "Files")]
    overwrite: bool,
    /// Size at which the log goes on in another file, as in 1GB [default: one file]
    #[arg(long, value_name = "SIZE")]
    #[arg(allow_hyphen_values = true, help_heading = "Files")]
    roll: Option<Bytes>,
}

impl RenderingArguments {
    /// Checks and gathers everything.
    ///
    /// # Errors
    /// An unknown tissue, a bad specimen, a device that is not there.
    pub fn rendering(&self) -> Result<Rendering, Failure> {
        let remote = self.shared.remote.remote(None)?;
        if remote.is_some() && (self.encoder_resolution.0 > 0.0 || self.sensor_noise.0 > 0.0) {
            return Err(Failure::bad_input(
                "--encoder-resolution and --sensor-noise are of the simulated rig: leave them away with a \
                 serial device, which has its own",
            ));
        }
        let there = (remote.as_ref()).is_some_and(|remote| remote.loop_mode == LoopMode::Device);
        if there && self.precision == Some(Precision::F64) {
            return Err(Failure::bad_input(
                "precision f64 has no effect in a loop on the device, which computes in f32: leave --precision out, or \
                 close the loop here with --loop host",
            ));
        }
        if self.scheme == Scheme::Exact {
            return Err(Failure::input(fracdiff::SchemeError::AnalysisOnly));
        }
        let library = library(self.library.as_deref())?;
        let material = modelled(&library, &self.tissue)?;
        let specimen = Specimen::new(SquareMetres(self.area.0), Metres(self.thickness.0)).map_err(
            |error| {
                Failure::input_with_advice(error, "give --area 4cm2 --thickness 20mm, for example")
            },
        )?;
        let model = self.shared.safety.device_model()?;
        let mut safety = self.shared.safety.over(Safety::default());
        if let Some(model) = &model {
            safety = safety.on_rig(&model.guarded(), remote.is_some())?;
        }
        let drive = self.drive.over(None)?;
        let judged = remote.is_some() || drive.is_some();
        let preflight = self
            .shared
            .preflight
            .wanted(judged, &safety, model.as_ref())?;
        Ok(Rendering {
            preflight,
            material,
            specimen,
            scheme: self.scheme,
            precision: self.precision.unwrap_or(Precision::F64),
            sample_time_s: self.sample_time.0,
            contact: self.contact,
            drive,
            sensors: Sensors {
                encoder_resolution_m: self.encoder_resolution.0,
                noise_m: self.sensor_noise.0,
                seed: seed_for(self.seed, self.sensor_noise.0)?,
            },
            force_limit_n: self.force_limit.0,
            force_rate_limit_n_per_s: self.force_rate_limit.0,
            safety,
            pace: self.realtime.pace(remote.is_some())?,
            remote,
        })
    }

    /// Runs an experiment in its folder with a progress bar, stoppable by Ctrl-C, and reports.
    ///
    /// # Errors
    /// As [`conduct`].
    pub fn conduct(
        &self,
        stem: &'static str,
        samples: u64,
        output: Output,
        experiment: impl FnOnce(
            &FolderRequest,
            Supervisor<'_>,
        ) -> Result<Published<Report, TheoryCurves>, Failure>,
    ) -> Result<(), Failure> {
        overwrite_acts(self.out.as_deref(), self.overwrite)?;
        let roll_bytes = roll_bytes(self.roll)?;
        let request = FolderRequest {
            roll_bytes,
            ..folder(self.out.clone(), stem, self.overwrite)
        };
        let live = self.shared.live.open(
            self.realtime.is_realtime() || self.shared.remote.is_serial(),
            output,
        )?;
        conduct(samples, output, print_summary, of_theory, |supervisor| {
            experiment(&request, supervisor.watched(&live))
        })?;
        Ok(())
    }
}

/// A tissue of the library with its model.
///
/// # Errors
/// A name that is not in it, a file that is wrong.
pub fn modelled(library: &Library, name: &str) -> Result<ModelledTissue, Failure> {
    let material = library.find(name).map_err(Failure::input)?;
    ModelledTissue::new(material)
}
