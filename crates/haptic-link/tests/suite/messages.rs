//! Messages of every kind, with values that differ from field to field.

use haptic_link::{
    Ack, Alive, AxisWorkspace, BATCH_MAX, BatchItem, Capabilities, CoefficientBlock, Conduct,
    Configuration, ControllerCost, ControllerForm, ControllerLaw, ControllerPart, DeviceReport,
    Event, EventKind, FaultReport, Field, Flight, Guard, GuardKind, Hello, Keys, Limits, LoopMode,
    OperatorForm, OperatorShape, Outcome, Reason, Refusal, Request, SENSED_MAX, Sample,
    SampleBatch, Scope, SerialNumber, Simulation, SimulationKind, Start, State, Statistics, Status,
    SurfaceKind, SurfaceShape, Trouble, WorkspaceBox,
};

pub(crate) fn status() -> Status {
    Status {
        state: State::Stopping,
        fault: 2,
        faults: 0x0403,
        reason: Reason {
            trouble: Trouble::Slow,
            measured_us: 0x0807_0605,
            told_us: 0x0c0b_0a09,
        },
    }
}

pub(crate) fn block() -> CoefficientBlock {
    CoefficientBlock {
        offset: 0x0201,
        values: core::array::from_fn(|i| i as f32 + 0.5),
    }
}

/// Every field another value.
pub(crate) fn configuration() -> Configuration {
    Configuration {
        loop_mode: LoopMode::Host,
        tick_period_us: 0x0403_0201,
        stiffness_n_per_m: 1.25,
        dissipation_n_s_mu_per_m: 2.25,
        order: 3.25,
        one_sided: true,
        surface_m: -4.25,
        operator: OperatorShape {
            form: OperatorForm::Recursion,
            integer: -2,
            count: 0x0605,
        },
        limits: Limits {
            force_n: 5.25,
            force_rate_n_per_s: 6.25,
            watchdog_ms: 0x0807,
            late_ticks: 0x0a09,
            max_age_ticks: 0x0c0b,
            start_force_n: 13.25,
            rise_time_s: 14.25,
            workspace_low_m: -15.25,
            workspace_high_m: 16.25,
            workspace_soft_m: 17.25,
            speed_soft_m_per_s: 18.25,
            speed_hard_m_per_s: 19.25,
            velocity_bandwidth_hz: 20.25,
            braking_n_s_per_m: 21.25,
            stop_time_s: 22.25,
            brake_force_n: 26.25,
            device_mass_kg: 27.25,
            device_delay_ticks: 4,
            stuck_force_n: 28.25,
            stuck_time_s: 29.25,
            jump_m: 30.25,
            guard: Guard {
                kind: GuardKind::EnergyBounding,
                damping_n_s_per_m: 23.25,
                share: 24.25,
                forget_s: 25.25,
                delay_least_samples: 26.25,
                delay_most_samples: 27.25,
                lag_s: 28.25,
                noise_m: 29.25,
            },
        },
        simulation: Simulation {
            kind: SimulationKind::RigidIndentation,
            mass_kg: 7.25,
            damping_n_s_per_m: 8.25,
            hand_stiffness_n_per_m: 9.25,
            push_n: 10.25,
            depth_m: 11.25,
            ramp_time_s: 12.25,
            start_ticks: 13.25,
        },
        own_push_n: 14.25,
        tap_n: 15.25,
        tap_ticks: 0x0403_0201,
        depth_map: Some(core::array::from_fn(|n| n as f32 + 31.25)),
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

/// A part of a controller.
fn part(number: u8) -> ControllerPart {
    ControllerPart {
        integer: -2 + number as i8,
        values: 0x0201 + u16::from(number),
        filter: 5 + number,
    }
}

/// A sample of so many axes.
pub(crate) fn sample(axes: usize) -> Sample {
    Sample {
        tick: 0x0403_0201,
        time_us: 0x0807_0605,
        axes: batch(1, axes).items.into_iter().collect(),
        sensed_force_n: batch(1, axes).sensed_force_n.into_iter().collect(),
    }
}

pub(crate) fn requests() -> Vec<Request> {
    vec![
        Request::Hello { nonce: 0x0403_0201 },
        Request::GetCapabilities,
        Request::Configure(configuration()),
        Request::Coefficients(block()),
        Request::Commit {
            digest: 0x0403_0201,
            scope: Scope::Lasting,
        },
        Request::GetConfiguration,
        Request::GetCoefficients { offset: 0x0201 },
        Request::Arm { faults: 0x0201 },
        Request::Disarm,
        Request::Start(Start {
            run: 0x0403_0201,
            ticks: 0x0807_0605,
            every: 0x0a09,
            batch: 11,
        }),
        Request::Stop,
        Request::Force {
            tick: 0x0403_0201,
            force_n: [-0.5, 1.5, 2.5].into_iter().collect(),
        },
        Request::KeepAlive { token: 0x0403_0201 },
        Request::GetStatistics,
        Request::ReadFlight { index: 0x0201 },
        Request::Stream {
            every: 0x0201,
            batch: 3,
        },
        Request::GetKeys,
        Request::Workspace(WorkspaceBox {
            axes: (0..3).map(range).collect(),
        }),
        Request::GetControllerCost,
        Request::Controller(ControllerLaw {
            form: ControllerForm::LeadOfTwo,
            reference_m: 1.25,
            ramp_ticks: 0x0403_0201,
            low_n: -2.25,
            high_n: 3.25,
            parts: (0..3).map(part).collect(),
        }),
        Request::Surface(SurfaceShape {
            kind: SurfaceKind::HollowBall,
            distance_m: 1.25,
            axes: [-0.5, 1.5, 2.5].into_iter().collect(),
        }),
    ]
}

/// A batch of what is hard to carry: numbers at their ends, and NaN.
pub(crate) fn extreme_batch() -> SampleBatch {
    let item = BatchItem {
        position_m: f32::MIN,
        environment_force_n: f32::INFINITY,
        force_n: f32::NAN,
        limiters: u8::MAX,
        flaws: u8::MAX,
    };
    SampleBatch {
        tick: u32::MAX,
        time_us: u32::MAX,
        every: u16::MAX,
        axes: 1,
        items: [item; BATCH_MAX].into_iter().collect(),
        sensed_force_n: heapless::Vec::new(),
    }
}

/// A batch of so many items, with sensed forces where they fit.
pub(crate) fn batch(axes: u8, count: usize) -> SampleBatch {
    let item = |n: usize| BatchItem {
        position_m: n as f32 + 0.5,
        environment_force_n: n as f32 + 100.5,
        force_n: n as f32 + 200.5,
        limiters: n as u8,
        flaws: (n as u8).wrapping_add(1),
    };
    SampleBatch {
        tick: 0x0403_0201,
        time_us: 0x0807_0605,
        every: 0x0a09,
        axes,
        items: (0..count).map(item).collect(),
        sensed_force_n: (0..count)
            .filter(|_| count <= SENSED_MAX)
            .map(|n| n as f32 + 300.5)
            .collect(),
    }
}

pub(crate) fn statistics() -> Statistics {
    Statistics {
        ticks: 1,
        overruns: 2,
        tick_cycles_max: 3,
        tick_cycles_last: 4,
        stale_forces: 5,
        samples_dropped: 6,
        sent: 7,
        received: 8,
        corrupt: 9,
        oversize: 10,
        foreign: 11,
        lost: 12,
        duplicate: 13,
        late: 14,
        bytes_overrun: 15,
        strangers: 16,
        unanswered: 17,
        forces_not_taken: 18,
        period_ns: 19,
    }
}

pub(crate) fn ack(outcome: Outcome) -> DeviceReport {
    DeviceReport::Ack(Ack {
        sequence: 0x0201,
        request: 4,
        outcome,
    })
}

pub(crate) fn reports() -> Vec<DeviceReport> {
    let time_us = 0x0807_0605_0403_0201;
    vec![
        DeviceReport::Hello(Hello {
            nonce: 0x0403_0201,
            connection: 0x0807_0605,
            firmware: [1, 2, 3],
            boot: 0x0403_0201,
            status: status(),
            serial_number: SerialNumber::named("thirty-two.letters:and+digits_01")
                .expect("a number")
                .bytes(),
        }),
        DeviceReport::Capabilities(Capabilities {
            board: Capabilities::board_name("sixteen letters!"),
            axes: 2,
            simulated: true,
            tick_period_min_us: 0x0403_0201,
            tick_period_max_us: 0x0807_0605,
            force_max_n: 1.5,
            force_rate_max_n_per_s: 2.5,
            position_resolution_m: 3.5,
            sensed_force_max_n: 4.5,
            coefficients_max: 0x0201,
            modes_max: 0x0403,
            degree_max: 0x0605,
            flight_samples: 0x0807,
            image_digest: 0x0c0b_0a09,
            lets_go_alone: Conduct {
                lets_go: true,
                moves: true,
                to_measure: false,
            },
        }),
        ack(Outcome::Done),
        DeviceReport::Configuration {
            configuration: configuration(),
            digest: 0x0403_0201,
        },
        DeviceReport::Coefficients(block()),
        DeviceReport::Sample(sample(3)),
        DeviceReport::Batch(batch(2, SENSED_MAX)),
        DeviceReport::Event(Event {
            kind: EventKind::Stopped,
            tick: 0x0403_0201,
            time_us,
        }),
        DeviceReport::Fault(FaultReport {
            status: status(),
            tick: 0x0403_0201,
            time_us,
        }),
        DeviceReport::Statistics(statistics()),
        DeviceReport::Alive(Alive {
            token: 0x0403_0201,
            time_us,
            status: status(),
            observed_energy_j: -4.5,
        }),
        DeviceReport::Flight(Flight {
            index: 0x0201,
            count: 0x0403,
            sample: sample(2),
        }),
        DeviceReport::Keys(Keys::current()),
        DeviceReport::ControllerCost(ControllerCost {
            tick_us: 0x0403_0201,
            coefficient_ns: 0x0807_0605,
        }),
    ]
}

pub(crate) fn refusals() -> Vec<Refusal> {
    vec![
        Refusal::State(State::Running),
        Refusal::Range {
            field: Field::ForceLimit,
            value: 50.0,
            least: 0.5,
            most: 20.0,
        },
        Refusal::Digest,
        Refusal::Incomplete,
        Refusal::Unsupported(Field::Every),
        Refusal::UnknownFault,
        Refusal::ForceNotZero,
        Refusal::ForceNotSmall {
            wanted_n: 2.0,
            allowed_n: 1.0,
        },
        Refusal::FaultPersists(4),
        Refusal::Connection,
        Refusal::Looser(Field::RiseTime),
    ]
}
