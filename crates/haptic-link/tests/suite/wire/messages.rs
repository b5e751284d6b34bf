//! One message of each kind, and more where a kind has more.

use super::CONNECTION;
use haptic_link::{
    Ack, Alive, AxisWorkspace, BATCH_MAX, Batch, BatchItem, Capabilities, CoefficientBlock,
    Configuration, Event, EventKind, FaultReport, Field, Flight, Forces, Hello, Keys, Limits,
    LoopMode, OperatorForm, OperatorShape, Outcome, Refusal, Report, Request, Sample, Scope,
    Simulation, SimulationKind, Start, State, Statistics, Status, VectorBatch, VectorFlight,
    VectorSample, WorkspaceBox,
};

pub(super) fn configuration() -> Configuration {
    Configuration {
        loop_mode: LoopMode::Host,
        tick_period_us: 500,
        stiffness_n_per_m: 1.5,
        dissipation_n_s_mu_per_m: 2.5,
        order: 0.2247,
        one_sided: true,
        surface_m: -0.5,
        operator: OperatorShape {
            form: OperatorForm::Modes,
            integer: -1,
            count: 66,
        },
        limits: Limits::DEFAULT,
        simulation: Simulation {
            kind: SimulationKind::RigidIndentation,
            depth_m: 1e-3,
            ramp_time_s: 1.0,
            ..Simulation::TESTBED
        },
    }
}

pub(super) fn status() -> Status {
    Status {
        state: State::Fault,
        fault: 2,
        faults: 0x0102,
    }
}

pub(super) fn batch(count: usize) -> Batch {
    let item = |n: usize| BatchItem {
        position_m: n as f32,
        environment_force_n: -1.0,
        force_n: f32::NAN,
        limiters: 255,
    };
    Batch {
        tick: u32::MAX,
        time_us: u32::MAX,
        every: u16::MAX,
        items: (0..count).map(item).collect(),
    }
}

/// A range of places of an axis.
fn range(axis: u8) -> AxisWorkspace {
    let axis = f32::from(axis);
    AxisWorkspace {
        low_m: -0.5 - axis,
        high_m: 0.25 + axis,
        soft_m: 0.125 + axis,
    }
}

/// A sample of so many axes.
pub(super) fn vectors(axes: usize) -> VectorSample {
    VectorSample {
        tick: 0x0403_0201,
        time_us: 0x0807_0605,
        axes: batch(axes).items.into_iter().collect(),
    }
}

pub(super) fn requests() -> Vec<Request> {
    vec![
        Request::Hello { nonce: 9 },
        Request::GetCapabilities,
        Request::Configure(configuration()),
        Request::Coefficients(CoefficientBlock::of(&[1.0, 2.0], 0)),
        Request::Commit {
            digest: 0x0403_0201,
            scope: Scope::Lasting,
        },
        Request::GetConfiguration,
        Request::GetCoefficients { offset: 16 },
        Request::Arm { faults: 1 },
        Request::Disarm,
        Request::Start(Start {
            run: 7,
            ticks: 20_001,
            every: 1,
            batch: 1,
        }),
        Request::Stop,
        Request::Force {
            tick: 9,
            force_n: -0.5,
        },
        Request::KeepAlive { token: 5 },
        Request::GetStatistics,
        Request::ReadFlight { index: 3 },
        Request::Stream {
            every: 1,
            batch: 16,
        },
        Request::GetKeys,
        Request::Forces(Forces {
            tick: 0x0403_0201,
            force_n: [-0.5, 1.5, 2.5].into_iter().collect(),
        }),
        Request::Workspace(WorkspaceBox {
            axes: (0..3).map(range).collect(),
        }),
    ]
}

pub(super) fn reports() -> Vec<Report> {
    let sample = Sample {
        tick: 1,
        time_us: 2,
        position_m: 3.0,
        environment_force_n: 4.0,
        force_n: 5.0,
        limiters: 6,
    };
    vec![
        Report::Hello(Hello {
            nonce: 9,
            connection: CONNECTION,
            firmware: [0, 1, 0],
            boot: 77,
            status: status(),
        }),
        Report::Capabilities(Capabilities {
            board: Capabilities::board_name("mps2"),
            axes: 1,
            simulated: true,
            tick_period_min_us: 100,
            tick_period_max_us: 10_000,
            force_max_n: 20.0,
            force_rate_max_n_per_s: 1e4,
            position_resolution_m: 0.0,
            coefficients_max: 256,
            modes_max: 48,
            degree_max: 16,
            flight_samples: 128,
        }),
        Report::Ack(Ack {
            sequence: 0x1234,
            request: 4,
            outcome: Outcome::Refused(Refusal::Range {
                field: Field::ForceLimit,
                value: 50.0,
                least: 0.0,
                most: 20.0,
            }),
        }),
        Report::Configuration {
            configuration: configuration(),
            digest: 1,
        },
        Report::Coefficients(CoefficientBlock::of(&[0.0; 16], 32)),
        Report::Sample(sample),
        Report::Batch(batch(BATCH_MAX)),
        Report::Event(Event {
            kind: EventKind::Finished,
            tick: 1,
            time_us: 2,
        }),
        Report::Fault(FaultReport {
            status: status(),
            tick: 1,
            time_us: 2,
        }),
        Report::Statistics(Statistics::default()),
        Report::Alive(Alive {
            token: 5,
            time_us: 6,
            status: status(),
            observed_energy_j: -0.5,
        }),
        Report::Flight(Flight {
            index: 1,
            count: 2,
            sample,
        }),
        Report::Keys(Keys::current()),
        Report::VectorSample(vectors(3)),
        Report::VectorBatch(VectorBatch {
            tick: 0x0403_0201,
            time_us: 0x0807_0605,
            every: 0x0a09,
            axes: 3,
            items: batch(15).items,
        }),
        Report::VectorFlight(VectorFlight {
            index: 0x0201,
            count: 0x0403,
            sample: vectors(2),
        }),
    ]
}
