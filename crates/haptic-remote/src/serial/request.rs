//! Asking and setting: requests that wait for their answer.

use super::{
    error::SerialError,
    line::lock,
    link::{Command, LISTENS, STOPPED, SerialLink},
    stopping::sleep,
};
use crate::LinkError;
use haptic_link::{
    AXES_MAX, Alive, CoefficientBlock, Configuration, ControllerCost, ControllerLaw, DeviceReport,
    DigestBuilder, FaultReport, Field, Refusal, Request, Sample, Scope, Start, State, Statistics,
    SurfaceShape, WorkspaceBox, block_count,
};
use haptic_loop::realtime::Durations;
use std::{
    sync::{atomic::Ordering, mpsc::RecvTimeoutError},
    time::Duration,
    vec::Vec,
};

/// Optional parts of a run besides its configuration and coefficients.
#[derive(Clone, Copy, Debug, Default)]
pub struct Companions<'a> {
    /// A workspace of its own for each axis of a device of several.
    pub workspace: Option<&'a WorkspaceBox>,
    /// A surface in front of the law, on a device of several axes.
    pub surface: Option<&'a SurfaceShape>,
    /// A controller in place of the law of the configuration, whose operator [holds its numbers](ControllerLaw).
    pub controller: Option<&'a ControllerLaw>,
}

impl SerialLink {
    /// Asks, and waits for the answer: 1.5 s, and 0.2 s once somebody stops. A device that does not answer then is waited for no more.
    ///
    /// # Errors
    /// No answer, a refusal, a line that is gone.
    pub fn ask(&self, request: Request) -> Result<DeviceReport, SerialError> {
        self.ask_for(request, Duration::MAX)
    }

    /// Stops a run at once, or else says within 0.2 s that it was not heard, after four tries.
    ///
    /// # Errors
    /// As [`ask`](Self::ask).
    pub fn stop(&self) -> Result<(), SerialError> {
        self.ask_for(Request::Stop, STOPPED).map(drop)
    }

    /// Asks as [`ask`](Self::ask) does, but listens no longer than this for the answer.
    pub(super) fn ask_for(
        &self,
        request: Request,
        most: Duration,
    ) -> Result<DeviceReport, SerialError> {
        let commands = self.commands.as_ref().ok_or(LinkError::Gone)?;
        if self.shared.deaf.load(Ordering::Relaxed) {
            // Best effort: it may hear though it does not answer.
            let _ = commands.try_send(Command::Tell(request));
            return Err(self.shared.conversation().no_answer().into());
        }
        // An answer left in the queue belongs to an earlier request.
        while self.answers.try_recv().is_ok() {}
        commands
            .send(Command::Ask(request))
            .map_err(|_| LinkError::Gone)?;
        let mut patience = self.patience(most);
        let mut hurries = false;
        loop {
            if self.is_stopped() && !core::mem::replace(&mut hurries, true) {
                self.shared.conversation().hurry();
                patience = self.patience(patience.left().min(STOPPED));
            }
            let listened = self.shared.listened();
            match self.answers.recv_timeout(patience.left().min(LISTENS)) {
                Ok(answer) => {
                    let mute = matches!(answer, Err(LinkError::NoAnswer { .. }));
                    self.shared.mute.store(mute, Ordering::Relaxed);
                    return answer.map_err(SerialError::Link);
                }
                Err(RecvTimeoutError::Disconnected) => return Err(LinkError::Gone.into()),
                Err(RecvTimeoutError::Timeout) => patience.listened_for(listened),
            }
            if patience.is_over() {
                if hurries {
                    self.give_up();
                }
                return Err(self.shared.conversation().no_answer().into());
            }
        }
    }

    /// Sets the whole configuration in one transaction, until it is replaced.
    ///
    /// # Errors
    /// The refusal of the first invalid parameter; then nothing has changed.
    pub fn set(&mut self, configuration: Configuration, values: &[f32]) -> Result<(), SerialError> {
        self.set_for(configuration, values, Scope::Lasting)
    }

    /// Sets a configuration as [`set`](Self::set) does; with the scope of a run, the lasting settings return with the next connection after it.
    ///
    /// # Errors
    /// As [`set`](Self::set); for a run, a limit that is looser than what is set.
    pub fn set_for(
        &mut self,
        configuration: Configuration,
        values: &[f32],
        scope: Scope,
    ) -> Result<(), SerialError> {
        self.set_within(configuration, values, Companions::default(), scope)
    }

    /// The time that a controller takes on the device.
    ///
    /// # Errors
    /// As [`ask`](Self::ask); [`LinkError::NoControllers`] if the device cannot run one.
    pub fn controller_cost(&self) -> Result<ControllerCost, SerialError> {
        if !self.has_controllers {
            return Err(LinkError::NoControllers.into());
        }
        match self.ask(Request::GetControllerCost) {
            Ok(DeviceReport::ControllerCost(cost)) => Ok(cost),
            Ok(_) => Err(LinkError::Gone.into()),
            Err(SerialError::Link(LinkError::Refused {
                refusal: Refusal::Unsupported(_),
                ..
            })) => Err(LinkError::NoControllers.into()),
            Err(error) => Err(error),
        }
    }

    /// Sets a configuration as [`set_for`](Self::set_for) does for a run, with its companions.
    ///
    /// # Errors
    /// As [`set_for`](Self::set_for); an invalid box, or one outside the workspace of all
    /// axes; an invalid surface; [`LinkError::NoSurfaces`]; as
    /// [`controller_cost`](Self::controller_cost); a tick that is too short for a controller.
    pub fn set_run(
        &mut self,
        configuration: Configuration,
        values: &[f32],
        companions: Companions<'_>,
    ) -> Result<(), SerialError> {
        if companions.surface.is_some() && !self.has_surfaces {
            return Err(LinkError::NoSurfaces.into());
        }
        if companions.controller.is_some() {
            self.controller_cost()?;
        }
        self.set_within(configuration, values, companions, Scope::Run)?;
        // During the run, a reported force beyond its limit is impossible.
        self.plausible.force_most_n = configuration.limits.force_n;
        Ok(())
    }

    fn set_within(
        &mut self,
        configuration: Configuration,
        values: &[f32],
        companions: Companions<'_>,
        scope: Scope,
    ) -> Result<(), SerialError> {
        let (mut values, newtons) = (Vec::from(values), self.shared.newtons());
        let configuration = newtons.told(configuration);
        let controller = companions
            .controller
            .map(|law| newtons.told_controller(law, &mut values));
        let values = &values[..];
        let most = self.capabilities.coefficients_max;
        if values.len() > usize::from(most) {
            let refusal = Refusal::range(
                Field::CoefficientCount,
                values.len() as f32,
                1.0,
                f32::from(most),
            );
            let request = "configure";
            return Err(LinkError::Refused { request, refusal }.into());
        }
        self.plausible.force_most_n = self.capabilities.force_max_n;
        self.ask(Request::Configure(configuration))?;
        for block in 0..block_count(values.len() as u16) {
            let offset = block * haptic_link::COEFFICIENTS_PER_BLOCK as u16;
            self.ask(Request::Coefficients(CoefficientBlock::of(values, offset)))?;
        }
        let mut digest = DigestBuilder::new(&configuration).coefficients(values);
        if let Some(workspace) = companions.workspace {
            self.ask(Request::Workspace(workspace.clone()))?;
            digest = digest.workspace(workspace);
        }
        if let Some(surface) = companions.surface {
            self.ask(Request::Surface(surface.clone()))?;
            digest = digest.surface(surface);
        }
        if let Some(law) = controller {
            digest = digest.controller(&law);
            self.ask(Request::Controller(law))?;
        }
        let digest = digest.finish();
        self.ask(Request::Commit { digest, scope })?;
        self.ticks_every(configuration.tick_period_us);
        (self.plausible).limit(&configuration.limits, companions.workspace);
        Ok(())
    }

    /// The configuration in force, with its coefficients.
    ///
    /// # Errors
    /// As [`ask`](Self::ask).
    pub fn configuration(&self) -> Result<(Configuration, Vec<f32>), SerialError> {
        let DeviceReport::Configuration { configuration, .. } =
            self.ask(Request::GetConfiguration)?
        else {
            return Err(LinkError::Gone.into());
        };
        let mut values = Vec::new();
        for block in 0..block_count(configuration.operator.count) {
            let offset = block * haptic_link::COEFFICIENTS_PER_BLOCK as u16;
            if let DeviceReport::Coefficients(block) =
                self.ask(Request::GetCoefficients { offset })?
            {
                values.extend(block.values);
            }
        }
        values.truncate(usize::from(configuration.operator.count));
        Ok((self.shared.newtons().seen(configuration), values))
    }

    /// The device's counters.
    ///
    /// # Errors
    /// As [`ask`](Self::ask).
    pub fn statistics(&self) -> Result<Statistics, SerialError> {
        let DeviceReport::Statistics(statistics) = self.ask(Request::GetStatistics)? else {
            return Err(LinkError::Gone.into());
        };
        Ok(statistics)
    }

    /// Samples that the flight recorder of the device has kept around a fault, the oldest first; an error is the last.
    pub fn flight(&self) -> impl Iterator<Item = Result<Sample, SerialError>> {
        let mut count = 1;
        (0..).map_while(move |index| {
            let report = (index < count).then(|| self.ask(Request::ReadFlight { index }))?;
            match report {
                Ok(DeviceReport::Flight(flight)) => {
                    count = flight.count;
                    let sample = self.shared.newtons().read(flight.sample);
                    (count > 0).then_some(Ok(sample))
                }
                Ok(_) => None,
                Err(error) => Some(Err(error)),
            }
        })
    }

    /// Time since the device started, by its own clock: a board that was programmed has started since.
    ///
    /// # Errors
    /// As [`ask`](Self::ask).
    pub fn up_time(&self) -> Result<Duration, SerialError> {
        let alive = self.alive()?;
        Ok(Duration::from_micros(alive.time_us))
    }

    /// Time and status of the device now.
    fn alive(&self) -> Result<Alive, SerialError> {
        let DeviceReport::Alive(alive) = self.ask(Request::KeepAlive { token: 0 })? else {
            return Err(LinkError::Gone.into());
        };
        *lock(&self.shared.status) = alive.status;
        Ok(alive)
    }

    /// Sends keep-alives for this time, and returns how long their answers took, µs.
    #[must_use]
    pub fn measure_round_trip(&self, duration: Duration) -> Durations {
        self.shared.conversation().set_keep_alive(Some(5_000));
        let _ = sleep(duration, self.stop.as_ref());
        self.shared.conversation().set_keep_alive(None);
        lock(&self.shared.round_trip_us).clone()
    }

    /// Arms the device, and from then on sends a keep-alive every quarter of the watchdog time.
    /// Clears a fault that [`status`](Self::status) has shown.
    ///
    /// # Errors
    /// As [`ask`](Self::ask).
    pub fn arm(&self, watchdog: Duration) -> Result<(), SerialError> {
        let conduct = self.capabilities.lets_go_alone;
        if conduct.moves && !self.knows_robot {
            return Err(LinkError::of_robot(conduct).into());
        }
        let quiet = (watchdog / 4).as_micros() as u64;
        self.shared.conversation().set_keep_alive(Some(quiet));
        let faults = self.status().faults;
        self.ask(Request::Arm { faults })?;
        let armed_after = u32::from(faults);
        (self.shared.armed_after).store(armed_after, Ordering::Relaxed);
        self.shared.armed_anew.store(true, Ordering::Relaxed);
        Ok(())
    }

    /// Starts a run, and forgets what came before, but for the end of the line. The first that is heard of the run is
    /// an answer too: a repeated start that is refused because a fault has latched meanwhile was taken, and the fault
    /// ends the run.
    ///
    /// # Errors
    /// As [`ask`](Self::ask); [`LinkError::Faulted`] where a fault has latched since it was armed.
    pub fn start(&mut self, start: Start) -> Result<(), SerialError> {
        self.forget_until_now();
        self.fault_tick = None;
        self.plausible.begin(self.period_us());
        self.impossible = None;
        self.newest = Sample::default();
        self.newest_answers.clear();
        // Until one comes a device has none.
        self.answered([0.0; AXES_MAX]);
        let armed_after = self.shared.armed_after.load(Ordering::Relaxed);
        let was_armed = armed_after == u32::from(self.status().faults);
        let retries = || self.shared.conversation().counters().retries;
        let before = retries();
        let armed_anew = self.shared.armed_anew.swap(false, Ordering::Relaxed);
        match self.ask(Request::Start(start)) {
            Err(SerialError::Link(LinkError::Refused {
                refusal: Refusal::State(State::Fault),
                ..
            })) if was_armed || armed_anew => {
                if !was_armed || retries() == before {
                    let Alive {
                        status, time_us, ..
                    } = self.alive()?;
                    return Err(LinkError::Faulted(FaultReport {
                        status,
                        tick: 0,
                        time_us,
                    })
                    .into());
                }
            }
            answer => drop(answer?),
        }
        self.running = Some(self.alives());
        Ok(())
    }

    /// Disarms, and lets the device be quiet.
    ///
    /// # Errors
    /// As [`ask`](Self::ask).
    pub fn disarm(&self) -> Result<(), SerialError> {
        self.shared.conversation().set_keep_alive(None);
        self.ask(Request::Disarm).map(drop)
    }

    /// Asks for a stream of samples outside of runs, and watches it so that its end is noticed.
    ///
    /// # Errors
    /// As [`ask`](Self::ask).
    pub fn stream(&self, every: u16, batch: u8) -> Result<(), SerialError> {
        let quiet = (every > 0).then_some(100_000);
        self.shared.conversation().set_keep_alive(quiet);
        self.ask(Request::Stream { every, batch }).map(|_| ())
    }
}
