//! A device of two axes on the bench.

use crate::line::{Bench, START, VectorLaw};
use haptic_emulator::LineFaults;
use haptic_link::{
    CoefficientBlock, Configuration, DigestBuilder, Limits, LoopMode, Refusal, Report, Request,
    Scope, Simulation, WorkspaceBox,
};
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
    pub(crate) fn set_to_last() -> Self {
        let mut bench = Self::connected(LineFaults::default());
        let lasting = bench.set_within(configuration(), None, Scope::Lasting);
        lasting.expect("good");
        bench
    }

    /// Connected, configured, armed and started, with a hand that pushes along x.
    pub(crate) fn running(faults: LineFaults, law: VectorLaw) -> Self {
        let mut bench = Self::connected(faults);
        let lasting = bench.set_within(configuration(), None, Scope::Lasting);
        lasting.expect("good");
        bench.starts(law);
        bench
    }

    /// Arms and starts, with this law.
    pub(crate) fn starts(&mut self, law: VectorLaw) {
        self.arm();
        self.vector_law = Some(law);
        self.done(Request::Start(START));
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
        let committed: Result<Report, Refusal> = self.answered(Request::Commit { digest, scope });
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
