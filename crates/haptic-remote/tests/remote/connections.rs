//! Whose frames count: captures played again, frames of other connections, other spellings, a second host.
//!
//! `CAMPAIGN_CASES` sets how many frames are forged; 1 000 000 take some seconds with `--release`.

mod forger;

use self::forger::{forged, header_of};
use crate::line::{Bench, START, spring};
use haptic_link::{Configuration, FRAME_MAX, LoopMode, Refusal, Request, Start, State};
use haptic_loop::Fault;
use haptic_remote::{Conversation, Incoming};
use testkit::Random;

/// 100 N and no limits of rate and motion, in a loop on the host.
fn loose() -> (Configuration, [f32; 2]) {
    let (mut configuration, values) = spring();
    configuration.loop_mode = LoopMode::Host;
    configuration.limits = haptic_link::Limits::bare(100.0, 1e5);
    (configuration, values)
}

/// Sets, arms, starts a loop on the host, and lets go.
fn whole_session(bench: &mut Bench, configuration: Configuration, values: &[f32]) {
    bench.hello();
    bench.set(configuration, values).expect("good");
    start(bench);
    bench.run_ms(50);
    bench.done(Request::Stop);
    bench.run_ms(30);
    bench.done(Request::Disarm);
    bench.host.set_keep_alive(None);
    bench.law = None;
}

fn start(bench: &mut Bench) {
    bench.law = Some(|x| -500.0 * x - 1.0);
    bench.arm();
    bench.done(Request::Start(START));
}

/// What the attacker finds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scene {
    Idle,
    Armed,
    Running,
    Faulted,
    Rebooted,
}

const SCENES: [Scene; 5] = [
    Scene::Idle,
    Scene::Armed,
    Scene::Running,
    Scene::Faulted,
    Scene::Rebooted,
];

/// A device in this scene with tight limits, its host silent from now on, and everything that it was told in an earlier
/// session and in this one.
fn scene(scene: Scene) -> (Bench, Vec<Vec<u8>>) {
    let mut bench = Bench::ideal();
    bench.capture = Some(Vec::new());
    let (configuration, values) = loose();
    whole_session(&mut bench, configuration, &values);
    let (mut tight, values) = spring();
    tight.limits = haptic_link::Limits::bare(2.0, 100.0);
    tight.loop_mode = LoopMode::Host;
    tight.limits.watchdog_ms = 1000;
    bench.hello();
    bench.set(tight, &values).expect("good");
    match scene {
        Scene::Idle => {}
        Scene::Armed => bench.arm(),
        Scene::Running => {
            start(&mut bench);
            bench.run_ms(20);
        }
        Scene::Faulted => {
            start(&mut bench);
            bench.run_ms(20);
            bench.device.borrow_mut().trip(Fault::EmergencyStop);
            bench.run_ms(100);
        }
        Scene::Rebooted => bench.reboot(),
    }
    bench.law = None;
    bench.host.set_keep_alive(None);
    bench.run_ms(1);
    let capture = bench.capture.take().expect("kept");
    (bench, capture)
}

#[test]
fn forged_frames_do_nothing() {
    let cases = testkit::cases(5_000_u32);
    let mut refused = 0_u32;
    for (index, which) in SCENES.into_iter().enumerate() {
        let (mut bench, capture) = scene(which);
        let mut headers = capture.iter().map(|frame| header_of(frame));
        let live = headers.rfind(|(_, connection)| *connection != 0);
        let live = live.expect("the host has spoken");
        let mut random = Random(index as u64);
        let state = bench.state();
        let (configuration, digest) = {
            let device = bench.device.borrow();
            (*device.configuration().0, device.configuration().1)
        };
        let (force_n, fed) = (bench.force_n(), bench.session.fed());
        let mut line = [0; FRAME_MAX];
        for case in 0..cases / SCENES.len() as u32 {
            let frame = forged(&bench, &capture, live, &mut random);
            for &byte in &frame {
                let length = bench.tell_device(byte, &mut line);
                refused += u32::from(length > 0);
            }
            let context = || format!("{which:?}, {case}: {frame:02x?}");
            let device = bench.device.borrow();
            assert_eq!(device.status().state, state, "{}", context());
            assert_eq!(device.configuration().1, digest, "{}", context());
            assert_eq!(*device.configuration().0, configuration, "{}", context());
            drop(device);
            assert_eq!(bench.session.fed(), fed, "{}", context());
            assert_eq!(bench.force_n(), force_n, "{}", context());
        }
        // However much was said, the host was silent.
        bench.ticking = true;
        for _ in 0..1050 {
            let frame = forged(&bench, &capture, live, &mut random);
            for &byte in &frame {
                bench.tell_device(byte, &mut line);
            }
            bench.run_ms(1);
        }
        let status = bench.device.borrow().status();
        if matches!(state, State::Armed | State::Running) {
            assert_eq!(status.fault, Fault::HostSilent.code(), "{which:?}");
        } else {
            assert_eq!(status.state, state, "{which:?}");
        }
        assert_eq!(bench.force_n(), 0.0);
    }
    println!("{cases} forged frames, {refused} answered by a hello or a refusal");
}

#[test]
fn a_whole_session_that_is_played_again_does_nothing() {
    let mut bench = Bench::ideal();
    bench.capture = Some(Vec::new());
    let (configuration, values) = loose();
    whole_session(&mut bench, configuration, &values);
    let capture = bench.capture.take().expect("kept");
    assert!(capture.len() > 50);
    let (mut tight, values) = spring();
    tight.limits.force_n = 1.0;
    for reboot in [false, true] {
        if reboot {
            bench.reboot();
        }
        bench.hello();
        bench.set(tight, &values).expect("good");
        let fed = bench.session.fed();
        let mut line = [0; FRAME_MAX];
        for frame in &capture {
            for &byte in frame {
                bench.tell_device(byte, &mut line);
            }
            bench.run_ms(1);
            assert_eq!((bench.state(), bench.force_n()), (State::Idle, 0.0));
        }
        assert_eq!(bench.session.fed(), fed);
        assert_eq!(bench.device.borrow().configuration().0, &tight);
        // Who was connected still is.
        bench.done(Request::GetConfiguration);
    }
}

/// An emulated device measures the silence of its host by this count, however fast its own clock is: an arming that
/// did not count left it the watchdog time of a clock that may be 400 times as fast.
#[test]
fn who_arms_is_heard() {
    let mut bench = Bench::ideal();
    bench.hello();
    let (configuration, values) = loose();
    bench.set(configuration, &values).expect("good");
    let fed = bench.session.fed();
    bench.done(Request::Arm { faults: 0 });
    assert_eq!(bench.session.fed(), fed + 1);
}

/// Another host at the same line.
struct SecondHost(Conversation);

impl SecondHost {
    /// Says it; the answer, if the device gives one at once.
    fn say(&mut self, bench: &mut Bench, request: Request) -> Option<Incoming> {
        let mut line = [0; FRAME_MAX];
        let length = self.0.ask(request, bench.now_us, &mut line);
        let frame = line[..length].to_vec();
        let mut answer = None;
        for &byte in &frame {
            let length = bench.tell_device(byte, &mut line);
            for &byte in &line[..length] {
                answer = self.0.receive(byte, bench.now_us).or(answer);
            }
        }
        answer
    }
}

#[test]
fn a_second_host_can_bring_to_rest_and_cannot_keep_going() {
    let (configuration, values) = spring();
    let mut bench = Bench::configured(configuration, &values);
    bench.arm();
    bench.done(Request::Start(START));
    bench.run_ms(50);
    // A hello alone changes nothing, however often it comes.
    let mut second = SecondHost(Conversation::new(50_000));
    for nonce in 100..200 {
        second.say(&mut bench, Request::Hello { nonce });
        bench.run_ms(1);
        assert_eq!(bench.state(), State::Running);
    }
    bench.done(Request::GetStatistics);
    // The second host speaks: the first is not heard any more, and the second does not keep the run going.
    let refused = second.say(&mut bench, Request::Start(Start { run: 9, ..START }));
    let refusal = Refusal::Connection;
    assert_eq!(
        refused,
        Some(Incoming::Refused {
            request: "start",
            refusal
        })
    );
    for _ in 0..30 {
        let alive = second.say(&mut bench, Request::GetStatistics);
        assert!(matches!(alive, Some(Incoming::Answer(_))), "{alive:?}");
        bench.run_ms(1);
    }
    assert_eq!(
        bench.device.borrow().status().fault,
        Fault::HostSilent.code()
    );
    assert!(bench.rebooted, "the first host is told");
    bench.run_ms(100);
    let armed = second.say(&mut bench, Request::Arm { faults: 1 });
    assert!(matches!(armed, Some(Incoming::Answer(_))), "{armed:?}");
}
