//! Hosts whose frames are whole and whose messages are not what anybody would send.

use crate::bench::{Bench, description, transaction, wall};
use haptic_bridge::{Reason, Trouble};
use haptic_link::{
    AxisWorkspace, ControllerForm, ControllerLaw, DeviceReport, Direction, FRAME_MAX, Receiver,
    Request, Start, SurfaceKind, SurfaceShape, WorkspaceBox,
};
use testkit::Random;

/// Content of a frame without its CRC.
fn content(frame: &[u8]) -> Vec<u8> {
    let mut content = Vec::new();
    let mut rest = &frame[..frame.len() - 1];
    while let Some((&code, after)) = rest.split_first() {
        let (run, next) = after.split_at(usize::from(code) - 1);
        content.extend(run);
        if code < 255 && !next.is_empty() {
            content.push(0);
        }
        rest = next;
    }
    content.truncate(content.len() - 4);
    content
}

/// A frame of this content, with a CRC that is right.
pub(crate) fn framed(mut content: Vec<u8>) -> Vec<u8> {
    let mut crc = u32::MAX;
    for &byte in &content {
        crc ^= u32::from(byte);
        for _ in 0..8 {
            crc = if crc & 1 == 1 {
                (crc >> 1) ^ 0xEDB8_8320
            } else {
                crc >> 1
            };
        }
    }
    content.extend((!crc).to_le_bytes());
    // COBS, by its definition: each zero becomes the distance to the next.
    let mut frame = Vec::new();
    for run in content.split(|&byte| byte == 0) {
        let mut run = run;
        while run.len() >= 254 {
            frame.push(255);
            frame.extend(&run[..254]);
            run = &run[254..];
        }
        frame.push(run.len() as u8 + 1);
        frame.extend(run);
    }
    frame.push(0);
    frame
}

/// Tick of the newest sample; 0 before the first.
pub(crate) fn newest(reports: &[DeviceReport]) -> u32 {
    let tick = reports.iter().rev().find_map(|report| {
        let DeviceReport::Sample(sample) = report else {
            return None;
        };
        Some(sample.tick)
    });
    tick.unwrap_or(0)
}

fn any(random: &mut Random, axes: usize, faults: u16, reports: &[DeviceReport]) -> Request {
    let number = |random: &mut Random| random.one_of(&[0.0_f32, 1e-3, -1.0, 5.0, 1e30, f32::NAN]);
    match random.bits() % 13 {
        0 => Request::Arm { faults },
        1 | 2 => Request::Start(Start {
            run: random.bits() as u32 % 100,
            ..Start::ENDLESS
        }),
        3 => Request::Stop,
        4 => Request::Disarm,
        5 | 6 => Request::Force {
            tick: newest(reports),
            force_n: (0..axes).map(|_| number(random)).collect(),
        },
        7 => Request::Stream {
            every: random.bits() as u16 % 20,
            batch: random.bits() as u8 % 20,
        },
        8 => Request::ReadFlight {
            index: random.bits() as u16,
        },
        9 => Request::Workspace(WorkspaceBox {
            axes: (0..axes)
                .map(|_| AxisWorkspace {
                    low_m: number(random),
                    high_m: number(random),
                    soft_m: 0.0,
                })
                .collect(),
        }),
        10 => Request::Surface(SurfaceShape {
            kind: SurfaceKind::Ball,
            distance_m: number(random),
            axes: (0..axes).map(|_| number(random)).collect(),
        }),
        11 => Request::Controller(ControllerLaw {
            form: random.one_of(&[
                ControllerForm::Parallel,
                ControllerForm::Lead,
                ControllerForm::LeadOfTwo,
            ]),
            reference_m: number(random),
            ramp_ticks: random.bits() as u32,
            low_n: number(random),
            high_n: number(random),
            parts: [].into_iter().collect(),
        }),
        _ => Request::GetStatistics,
    }
}

fn mutated(frame: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = content(frame);
    let message = bytes.len() - 9;
    for _ in 0..random.bits() % 3 {
        let place = 9 + random.bits() as usize % message;
        bytes[place] = match random.bits() % 4 {
            0 => random.bits() as u8,
            1 => bytes[place] ^ (1 << (random.bits() % 8)),
            2 => 0xff,
            _ => 0,
        };
    }
    framed(bytes)
}

fn campaign(rounds: u32) {
    for axes in 1..=3 {
        let mut random = Random(59 + u64::from(axes));
        let mut bench = Bench::armed(&description(axes));
        let (mut pushed, mut faults) = (0, 0);
        let mut phase = 0.0;
        for round in 0..rounds {
            let mut frame = [0; FRAME_MAX];
            if bench.handle.fault().is_some() && round % 150 == 0 {
                bench.position_m = [0.0; 3];
                bench.steps(150);
                bench.arm();
            }
            let request = match round % 400 {
                0 => Request::Disarm,
                1 => Request::Configure(wall().0),
                2 => Request::Arm { faults },
                3 => Request::Start(Start {
                    run: round,
                    ..Start::ENDLESS
                }),
                _ => any(&mut random, axes as usize, faults, &bench.reports),
            };
            let length = bench.host.tell(&request, &mut frame);
            let bytes = mutated(&frame[..length], &mut random);
            let mut receiver = Receiver::<Request>::new(Direction::FromHost);
            let heard = bytes.iter().find_map(|&byte| receiver.push(byte));
            // What is set has to be committed by its own digest.
            if let Some((_, Request::Configure(configuration))) = heard {
                for request in transaction(&configuration, &wall().1) {
                    let length = bench.host.tell(&request, &mut frame);
                    bench.line.take(&frame[..length]);
                    bench.step();
                }
            } else {
                bench.line.take(&bytes);
            }
            phase += 0.002;
            bench.position_m = [0.01 * f64::sin(phase); 3];
            bench.step();
            for report in &bench.reports {
                if let DeviceReport::Fault(fault) = report {
                    faults = fault.status.faults;
                }
            }
            assert_ne!(
                bench.handle.reason(),
                Some(Reason::of(Trouble::Library)),
                "{round}: {heard:?}"
            );
            let norm_n = bench.norm_n();
            assert!(norm_n <= 3.0 * (1.0 + 1e-6), "{round}: {norm_n} N");
            pushed += u32::from(norm_n > 0.0);
            bench
                .reports
                .drain(..bench.reports.len().saturating_sub(50));
        }
        assert!(pushed > rounds / 20, "{pushed}");
        assert_eq!(bench.allocations, 0);
    }
}

#[test]
fn messages_that_nobody_would_send_are_no_panic_and_no_force_beyond_the_limits() {
    campaign(3000);
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn many_messages_that_nobody_would_send_are_no_panic_and_no_force_beyond_the_limits() {
    campaign(100_000);
}
