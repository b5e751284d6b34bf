//! A device of two axes on the bench.

use crate::line::{Bench, START};
use haptic_emulator::LineFaults;
use haptic_link::{
    CoefficientBlock, Configuration, DeviceReport, DigestBuilder, Limits, LoopMode, Refusal,
    Request, Sample, Scope, Simulation, State, WorkspaceBox,
};
use haptic_loop::Fault;
use haptic_remote::{SimulatedAxes, TickSide};

/// Largest norm of the force, N.
pub(crate) const FORCE_N: f32 = 2.0;

pub(crate) type Plane = Bench<SimulatedAxes<2>, 2>;

impl Plane {
    /// Connected, and nothing more.
    pub(crate) fn connected(faults: LineFaults) -> Self {
        let device = TickSide::new(SimulatedAxes::new("plane")).expect("starts");
        let mut bench = Self::with(device, faults, 1);
        bench.hello();
        bench
    }

    /// Connected, and configured until something else is set.
    pub(crate) fn set_to_last(faults: LineFaults) -> Self {
        let mut bench = Self::connected(faults);
        let lasting = bench.set_within(configuration(), None, Scope::Lasting);
        lasting.expect("good");
        bench
    }

    /// Connected, configured, armed and started, with a hand that pushes along x.
    pub(crate) fn running(law: impl FnMut(&Sample) -> Request + 'static) -> Self {
        Self::on_line(LineFaults::default(), law)
    }

    /// Bench as by [`running`](Self::running), on a line with faults.
    pub(crate) fn on_line(
        faults: LineFaults,
        law: impl FnMut(&Sample) -> Request + 'static,
    ) -> Self {
        let mut bench = Self::set_to_last(faults);
        bench.starts(law);
        bench
    }

    /// Arms and starts, with this law.
    pub(crate) fn starts(&mut self, law: impl FnMut(&Sample) -> Request + 'static) {
        self.arm();
        self.vector_law = Some(Box::new(law));
        self.done(Request::Start(START));
    }

    /// It runs into this fault, from which on the force only falls.
    pub(crate) fn falls_to_zero(&mut self, fault: Fault) {
        while self.state() == State::Running {
            assert!(self.norms.len() < 2000, "no fault");
            self.step().expect("goes on");
        }
        assert_eq!(self.fault(), Some(fault));
        self.only_falls(self.norms.len() - 1);
    }

    /// Asserts that from here on the norm never grows, and is zero after the stop time, 0.1 s.
    pub(crate) fn only_falls(&mut self, from: usize) {
        self.run_ms(150);
        let norms = &self.norms[from - 1..];
        assert!(norms[0] > 0.5, "there was a force");
        for pair in norms.windows(2) {
            assert!(pair[1] <= pair[0], "{pair:?}");
        }
        assert_eq!(norms[103], 0.0);
    }

    /// Sets a configuration without a law, and a box.
    pub(crate) fn set_within(
        &mut self,
        configuration: Configuration,
        workspace: Option<WorkspaceBox>,
        scope: Scope,
    ) -> Result<(), Refusal> {
        self.answered(Request::Configure(configuration))?;
        let block = CoefficientBlock::of(&[0.0], 0);
        self.answered(Request::Coefficients(block))?;
        let mut digest = DigestBuilder::new(&configuration).coefficients(&[0.0]);
        if let Some(workspace) = workspace {
            digest = digest.workspace(&workspace);
            self.answered(Request::Workspace(workspace))?;
        }
        let digest = digest.finish();
        let committed: Result<DeviceReport, Refusal> =
            self.answered(Request::Commit { digest, scope });
        committed.map(drop)
    }
}

pub(crate) fn configuration() -> Configuration {
    Configuration {
        loop_mode: LoopMode::Host,
        limits: Limits {
            watchdog_ms: 20,
            ..Limits::bare(FORCE_N, 1000.0)
        },
        simulation: Simulation {
            push_n: 1.0,
            ..Simulation::TESTBED
        },
        ..Configuration::PASSIVE
    }
}
