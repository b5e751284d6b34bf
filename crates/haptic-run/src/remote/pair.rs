//! A run on two devices: both connected, configured and judged, then conducted by a thread each, see [`partner`](super::partner).

use super::{
    partner::{Both, Partner, Side, aligned},
    run::RemoteRun,
    session::Ready,
};
use crate::{
    ran::{DriveRan, Ran},
    recorder,
    supervisor::Supervisor,
};
use fracdiff::Real;
use haptic_document::{
    Failure, bad_input,
    parameters::{
        DEVICE, DEVICE_MODEL, DRIVE_DEVICE, DRIVE_DEVICE_MODEL, SAMPLE_TIME, TRIAL_DURATION,
    },
};
use haptic_loop::{Controller, Environment};
use haptic_trial::{
    drive_verdict::DriveVerdict,
    preflight::note_findings,
    samples::{WHOLE_MOST, keeps_all},
};
use std::sync::{Arc, atomic::AtomicU64};

/// The verdict on a controller that drives, alone and in contact, with loops this many seconds later than their devices; `None` if one is
/// unknown.
type Judged<'a> = &'a dyn Fn([f64; 2]) -> Result<Option<DriveVerdict>, Failure>;

/// Refuses more samples than a run on two devices keeps.
///
/// # Errors
/// If there are more: the limit, and the keys to change.
pub fn fits_two_devices(samples: u64) -> Result<(), Failure> {
    if keeps_all(samples) {
        Ok(())
    } else {
        Err(bad_input!(
            "a run on two devices has at most {WHOLE_MOST} samples: use a shorter {TRIAL_DURATION}, or a longer {SAMPLE_TIME}"
        ))
    }
}

/// A run on two devices.
pub struct PairRun<'a> {
    /// The device that renders the tissue.
    pub tissue: RemoteRun<'a>,
    /// The device that presses it.
    pub drive: RemoteRun<'a>,
    /// `None` of a drive that only pushes.
    pub judged: Option<Judged<'a>>,
    /// Newest force that the tissue opposes, N, as its bits.
    pub opposed_n: Arc<AtomicU64>,
    /// See [`DriveRan::may_rise_s`].
    pub may_rise_s: f64,
}

impl std::fmt::Debug for PairRun<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("PairRun")
            .field("tissue", &self.tissue)
            .field("drive", &self.drive)
            .finish_non_exhaustive()
    }
}

impl PairRun<'_> {
    /// Both are connected, configured and judged before any file is made, and any force. The controllers close what loops run here.
    ///
    /// # Errors
    /// As [`RemoteRun::steered`], on either device.
    pub fn run<F, E, G>(
        self,
        of_tissue: &mut Controller<F, 1, E>,
        of_drive: &mut Controller<f64, 1, G>,
        supervisor: Supervisor<'_>,
    ) -> Result<Ran, Failure>
    where
        F: Real + Send,
        E: Environment<F, 1> + Send,
        E::History: Send,
        G: Environment<f64, 1>,
    {
        let (stop, warn) = (supervisor.stop, supervisor.warn);
        let (request, device) = (self.tissue.request, self.drive.device.name.to_string());
        let watchdogs = [self.tissue.device.watchdog(), self.drive.device.watchdog()];
        let samples = self.tissue.schedule.samples;
        let name = DEVICE.set_to(&self.tissue.device.name);
        let tissue = self.tissue.ready::<1>(supervisor);
        let mut tissue = tissue.map_err(|failure| failure.and(&name))?;
        let warn_of_drive = |text: &str| warn(&format!("drive: {text}"));
        let drive_supervisor = Supervisor {
            warn: &warn_of_drive,
            ..supervisor
        };
        let mut drive = self.drive;
        // It lets go when the tissue is done, however far the clocks of both were off; at the latest, here.
        drive.schedule.samples = samples.saturating_mul(2).min(WHOLE_MOST);
        let drive = drive.ready::<1>(drive_supervisor);
        let mut drive = drive.map_err(|failure| failure.and(&DRIVE_DEVICE.set_to(&device)))?;
        // Its push meets no law of its own that could swing.
        drive.push = None;
        // One that only pushes needs a device that it meets.
        let simulates = |ready: &&Ready<'_, _>| ready.link.capabilities().simulated;
        let simulated = [&tissue, &drive].into_iter().find(simulates);
        if let (None, Some(ready)) = (&self.judged, simulated) {
            return Err(bad_input!(
                "{} simulates a mass of its own, which no other device touches: name two real devices, or two emulated ones that face each other",
                ready.device.name
            ));
        }
        // Before, nobody knows their clocks.
        let delays_s = [tissue.measured_delay_s(), drive.measured_delay_s()];
        let judged = self.judged.map(|judged| judged(delays_s)).transpose()?;
        let described = (drive.metadata.iter()).filter(|(key, _)| !key.contains("preflight"));
        let described = described.map(|(key, value)| (format!("drive.{key}"), value.clone()));
        tissue.metadata.extend(described);
        match &judged {
            Some(Some(judged)) => note_findings(&mut tissue.metadata, DriveVerdict::KEY, judged),
            None => {}
            Some(None) => warn(&format!(
                "pre-flight: the drive and its contact are not judged, a device is unknown: give {DEVICE_MODEL} and {DRIVE_DEVICE_MODEL}"
            )),
        }
        let folder = request.prepare()?;
        let metadata = tissue.metadata.clone();
        let mut recorder = recorder(request, &folder, metadata, false, supervisor)?;
        let drive_recorder = recorder.second();

        let both = &Both::default();
        let clocks = [tissue.link.clock(), drive.link.clock()];
        let partner = |side: Side| {
            let (clocks, opposed_n) = (clocks.clone(), Arc::clone(&self.opposed_n));
            let mut partner = Partner::new(both, side, clocks, watchdogs[side as usize], opposed_n);
            partner.rise_ticks = tissue.rise_ticks;
            partner.samples = samples;
            partner
        };
        let (first, second) = (partner(Side::Tissue), partner(Side::Drive));
        let mut tissue = tissue.session::<1>(recorder, Some(first))?;
        let mut drive = drive.session::<1>(drive_recorder, Some(second))?;
        // The drive's thread is this one, which may report the progress.
        let mut tissue = std::thread::scope(|scope| {
            let first = scope.spawn(move || {
                let supervisor = Supervisor {
                    stop,
                    progress: &|_| (),
                    live: None,
                    warn,
                };
                tissue.conduct(of_tissue, &mut (), supervisor);
                tissue
            });
            drive.conduct(of_drive, &mut (), drive_supervisor);
            match first.join() {
                Ok(tissue) => tissue,
                // A panic there is a defect; let it be seen as one.
                Err(panic) => std::panic::resume_unwind(panic),
            }
        });
        let aligned = aligned(both, &clocks);
        tissue.note(CLOCKS, &aligned);
        let (record, recorded) = drive.finish_drive();
        let recorded = recorded?;
        let mut ran = tissue.finish(folder)?;
        ran.live_warnings.extend(recorded.warnings);
        Ok(Ran {
            drive: judged.flatten(),
            second: Some(DriveRan {
                device,
                record,
                aligned,
                fault_log: recorded.fault_log,
                may_rise_s: self.may_rise_s,
            }),
            ..ran
        })
    }
}

/// Name of the metadata record that says how the clocks of both devices stood to each other.
const CLOCKS: &str = "drive.clock";
