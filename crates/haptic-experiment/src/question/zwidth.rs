//! Z-width on a device at a port, or on the simulated one: see [`haptic_question::zwidth`].

mod trials;

use crate::experiment::reading::remote;
use haptic_document::Warn;
use haptic_document::parameters::CAMPAIGN;
use haptic_document::{Failure, Table};
use haptic_judge::trial::force_and_rate;
use haptic_link::{OperatorForm, OperatorShape};
use haptic_log::record::{LineFile, NewFileError};
use haptic_question::zwidth::campaign::Campaign;
use haptic_question::zwidth::rig::Rig;
use haptic_question::zwidth::{AtPort, ZWidth, ZWidthReport};
use haptic_run::remote::{RemoteDevice, RemoteLaw, held};
use haptic_trial::ending::MotorPush;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};
use trials::Trials;

/// Damping of the way out of a wall, of m/T: far below what a sampled damper bears.
const RETREAT_DAMPING: f64 = 0.1;

/// A question for a Z-width, and the device at a port that is tried.
#[derive(Clone, Debug)]
pub(crate) struct ZWidthSearch {
    pub(crate) zwidth: ZWidth,
    /// `None` for the simulated device.
    pub(crate) remote: Option<RemoteDevice>,
}

impl ZWidthSearch {
    /// Reads and checks `[zwidth]`.
    pub(crate) fn of(table: &Table<'_>) -> Result<Self, Failure> {
        let remote = remote(table)?;
        let at_port = remote.as_ref().map(|remote| AtPort {
            name: remote.name.to_string(),
            calibration: remote.calibration_in_words(),
        });
        Ok(Self {
            zwidth: ZWidth::of(table, at_port)?,
            remote,
        })
    }

    /// Runs the search; `progress` hears of each cell that is done, `stop` ends it with those, and `warn` hears what a
    /// user should know before the end.
    pub(crate) fn run(
        &self,
        progress: &(dyn Fn(u64) + Sync),
        stop: &Arc<AtomicBool>,
        warn: Warn<'_>,
    ) -> Result<ZWidthReport, Failure> {
        let trials = (self.remote.as_ref())
            .map(|remote| Trials::new(remote, retreat(&self.zwidth), warn, stop))
            .transpose()?;
        let rig = trials.as_ref().map(|trials| trials as &dyn Rig);
        self.zwidth.searched(rig, &campaign, progress, stop)
    }
}

/// Opens the campaign of this question, from a file that may be there already.
fn campaign(path: &Path, question: &str) -> Result<Campaign, Failure> {
    let opened = LineFile::open(path, &Campaign::first_line(question)?);
    if let Err(NewFileError::Foreign(_)) = &opened {
        return Err(Failure::bad_input(format_args!(
            "`{}` is not of this search (line 1): give the keys, device and limits with which it began, or another {CAMPAIGN}",
            path.display()
        )));
    }
    let (file, found) = opened?;
    let file = Mutex::new(file);
    let keep = move |line: &str| {
        let mut file = file.lock().unwrap_or_else(PoisonError::into_inner);
        Ok(file.add(line)?)
    };
    Campaign::found(path, &found, Box::new(keep))
}

/// The way of the handle out of a wall into which the device pushes by itself: the push turned round, through a damper.
fn retreat(zwidth: &ZWidth) -> Option<RemoteLaw> {
    let plan = zwidth.plan();
    let push_n = plan.own_push_n()?;
    let t = zwidth.device.sample_time;
    let derivative = OperatorShape {
        form: OperatorForm::Taps,
        integer: 0,
        count: 2,
    };
    Some(RemoteLaw {
        dissipation_n_s_mu_per_m: RETREAT_DAMPING * zwidth.device.mass.0 / t.0,
        order: 1.0,
        operator: (derivative, vec![t.0.recip() as f32, -t.0.recip() as f32]),
        held_push_n: push_n,
        push: Some(MotorPush::Own(-push_n)),
        ..RemoteLaw::bare(
            force_and_rate(plan.force_limit_n, None, t),
            held(&zwidth.device, 0.0),
        )
    })
}
