//! A second device at a port that pushes the handle of the first: see [`haptic_judge::pushed`].

use super::law_there::no_law_there;
use crate::experiment::drive::DriveSamples;
use haptic_document::{Failure, parameters as p};
use haptic_judge::{
    pushed::{SecondDevice, unguarded},
    trial::{TrialPlan, no_wall},
};
use haptic_loop::{Controller, Environment, OwnPush};
use haptic_run::{
    Ran, Supervisor,
    remote::{PairRun, RemoteDevice, RemoteLaw, RemoteRun, blank, fits_two_devices},
};
use haptic_trial::{ending::MotorPush, safety::Safety, tick::KeptSample};
use std::sync::Arc;

/// Place, m, and force, N, of a second device at a sample of the first; asked for in their order.
pub(super) type OfDrive<'a> = Box<dyn FnMut(&KeptSample) -> [f64; 2] + 'a>;

/// Runs a law on the first device at a port, while this one makes the push of a plan.
pub(super) fn push_into<E>(
    second: (&SecondDevice, &RemoteDevice),
    plan: &TrialPlan,
    safety: &Safety,
    law: RemoteRun<'_>,
    controller: &mut Controller<f64, 1, E>,
    supervisor: Supervisor<'_>,
) -> Result<Ran, Failure>
where
    E: Environment<f64, 1, History: Send> + Send,
{
    let (second, remote) = second;
    fits_two_devices(law.schedule.samples)?;
    if !second.is_known {
        (supervisor.warn)(&format!(
            "pre-flight: the second device is judged as if it were built as the first: give {}",
            p::DRIVE_DEVICE_MODEL
        ));
    }
    let device = &RemoteDevice {
        patience: law.device.patience,
        ..remote.clone()
    };
    let push = RemoteLaw {
        push: Some(MotorPush::Own(plan.push_n)),
        ..no_law_there(
            second.limits(),
            None,
            &unguarded(safety),
            &second.device,
            0.0,
        )
    };
    let pair = PairRun {
        drive: RemoteRun::new(device, push, law.schedule, &|_| blank(0.0), law.request),
        tissue: law,
        judged: None,
        opposed_n: Arc::default(),
        // Nothing before the window is judged.
        may_rise_s: plan.duration_s - plan.window_s,
    };
    let no_law = OwnPush::new(no_wall(second.device.sample_time)?, Some(plan.push_n));
    let mut pushing = Controller::new(no_law, second.chain(safety)?);
    pair.run(controller, &mut pushing, supervisor)
}

/// Its place in a run, m, and its force, N: by its own samples, or computed again of a simulated one.
pub(super) fn driven<'a>(
    second: &SecondDevice,
    ran: &'a Ran,
    push_n: f64,
    safety: &Safety,
) -> Result<OfDrive<'a>, Failure> {
    let t = second.device.sample_time.0;
    Ok(match &ran.second {
        None => {
            let mut pusher = second.pusher(push_n, safety)?;
            Box::new(move |sample| {
                let place_m = sample.indenter_position_m;
                [place_m, pusher.push(place_m).newtons()[0]]
            })
        }
        Some(drive) => {
            let place_and_force = |sample: &KeptSample| (0.0, [sample.position_m, sample.force_n]);
            let mut samples = DriveSamples::new(drive, &ran.record, t, place_and_force);
            Box::new(move |sample| samples.at(sample.time_s).1)
        }
    })
}

#[cfg(test)]
mod tests;
