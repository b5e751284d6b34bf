//! Through the functions in C, over TCP. Virtual time stands while an answer is on its way: every second tick the program waits
//! twice as long, so that no watchdog ends before a line that a busy machine serves late.
#![expect(unsafe_code, reason = "tests call as C does")]

use crate::{
    bad_input::device,
    bench::{STOP_TICKS, WATCHDOG_MS, transaction, wall},
};
use haptic_bridge::*;
use haptic_link::{DeviceReport, FRAME_MAX, Request, Start};
use haptic_remote::{Conversation, Incoming};
use nalgebra::Vector3;
use std::{
    ffi::{CStr, c_int},
    io::{ErrorKind, Read as _, Write as _},
    net::TcpStream,
    ptr,
    time::Duration,
};

/// Time for the threads of the line after the first call that waits for an answer.
const PAUSE: Duration = Duration::from_millis(1);
/// Ticks after which a greeting is said again.
const AGAIN: u32 = 6;

struct Program {
    bridge: *mut HbBridge,
    time_us: u64,
    position_m: [f64; 3],
    force_n: [f64; 3],
}

impl Program {
    fn open() -> Self {
        // SAFETY: what lives here.
        let bridge = unsafe {
            hb_open(
                &device(c"program"),
                c"127.0.0.1:0".as_ptr(),
                ptr::null_mut(),
                0,
            )
        };
        assert!(!bridge.is_null());
        Self {
            bridge,
            time_us: 0,
            position_m: [0.0; 3],
            force_n: [0.0; 3],
        }
    }

    fn port(&self) -> u16 {
        // SAFETY: it is open.
        unsafe { hb_port(self.bridge) }
    }

    fn tick_after(&mut self, time_us: u64) -> c_int {
        self.time_us += time_us;
        let force_n = self.force_n.as_mut_ptr();
        // SAFETY: it is open, and the arrays are of three.
        unsafe { hb_tick(self.bridge, self.time_us, self.position_m.as_ptr(), force_n) }
    }

    fn norm_n(&self) -> f64 {
        Vector3::from(self.force_n).norm()
    }

    fn until_a_fault(&mut self, most_ticks: u16) {
        let mut ticks = 0;
        while self.tick_after(1000) == 0 {
            ticks += 1;
            assert!(ticks <= most_ticks, "{:?}", self.force_n);
        }
    }

    /// The force never grows in the stop time, with this fault or 0, and is zero after it.
    fn fades(&mut self, code: c_int) {
        let mut before = self.norm_n();
        for _ in 0..STOP_TICKS {
            assert_eq!([self.tick_after(100), self.tick_after(900)], [code; 2]);
            assert!(self.norm_n() <= before);
            before = self.norm_n();
        }
        assert_eq!(self.force_n, [0.0; 3]);
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // SAFETY: it is open, and not used after this.
        unsafe { hb_close(self.bridge) };
    }
}

struct Host {
    stream: TcpStream,
    conversation: Conversation,
}

impl Host {
    fn connect(port: u16) -> Self {
        let stream = TcpStream::connect(("127.0.0.1", port)).expect("listens");
        stream.set_nonblocking(true).expect("may");
        Self {
            stream,
            // Again only after hours of the device: nothing is lost here.
            conversation: Conversation::new(1 << 40),
        }
    }

    fn done(&mut self, request: Request, program: &mut Program) -> DeviceReport {
        let mut frame = [0; FRAME_MAX];
        let length = self.conversation.ask(request.clone(), 0, &mut frame);
        self.stream.write_all(&frame[..length]).expect("is taken");
        for ticks in 1..u32::from(WATCHDOG_MS) {
            program.tick_after(1000);
            std::thread::sleep(PAUSE * (1 << (ticks / 2)));
            // What the host before has left over may take a greeting with it.
            if ticks.is_multiple_of(AGAIN) && matches!(request, Request::Hello { .. }) {
                let length = self.conversation.ask(request.clone(), 0, &mut frame);
                self.stream.write_all(&frame[..length]).expect("is taken");
            }
            let mut bytes = [0; 4096];
            loop {
                let count = match self.stream.read(&mut bytes) {
                    Ok(0) => panic!("{request:?}: the line is closed"),
                    Ok(count) => count,
                    Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                    Err(error) => panic!("{error}"),
                };
                for &byte in &bytes[..count] {
                    match self.conversation.receive(byte, 0) {
                        Some(Incoming::Answer(report) | Incoming::Begun(report)) => return report,
                        Some(Incoming::Refused { request, refusal }) => {
                            panic!("{request}: {refusal:?}")
                        }
                        _ => {}
                    }
                }
            }
        }
        panic!("no answer to {request:?}");
    }

    /// Greets, configures, arms, starts; the program presses into the wall.
    fn run(&mut self, program: &mut Program, nonce: u32, faults: u16) {
        program.position_m = [0.0; 3];
        self.done(Request::Hello { nonce }, program);
        let (configuration, values) = wall();
        for request in transaction(&configuration, &values) {
            self.done(request, program);
        }
        self.done(Request::Arm { faults }, program);
        self.done(
            Request::Start(Start {
                run: nonce,
                every: 10,
                batch: 5,
                ..Start::ENDLESS
            }),
            program,
        );
        for step in 0..WATCHDOG_MS - 10 {
            program.position_m = [1e-4 * f64::from(step); 3];
            assert_eq!(program.tick_after(1000), 0);
        }
        assert!(program.norm_n() > 0.01, "{:?}", program.force_n);
    }
}

#[test]
fn a_host_arms_pushes_and_is_killed_and_the_next_one_finds_a_device() {
    let mut program = Program::open();
    for faults in 0..3 {
        let mut host = Host::connect(program.port());
        host.run(&mut program, 1 + u32::from(faults), faults);
        drop(host);
        program.until_a_fault(WATCHDOG_MS);
        program.fades(2);
        // SAFETY: it is open.
        let reason = unsafe { CStr::from_ptr(hb_reason(program.bridge)) };
        assert!(reason.to_bytes().ends_with(b"watchdog time"), "{reason:?}");
    }
}

#[test]
fn a_program_that_does_not_call_hb_tick_is_named_at_once() {
    let program = Program::open();
    let path = format!("tcp:127.0.0.1:{}", program.port());
    let began = haptic_loop::realtime::Moment::now();
    let options = haptic_remote::serial::ConnectOptions::default();
    let refused = haptic_remote::serial::SerialLink::connect(&path, options);
    let message = refused.expect_err("nobody answers").to_string();
    let words = "answers \"waiting: the program does not call hb_tick: start its haptic thread\"";
    assert_eq!(message, format!("{path} {words}"));
    // Not after all the time in which a device may be found.
    assert!(began.elapsed() < haptic_remote::serial::GREETING);
}

#[test]
fn other_threads_stop_it_and_see_its_fault() {
    struct Shared(*const HbBridge);
    // SAFETY: `hb_stop` and `hb_fault` are for any thread.
    unsafe impl Sync for Shared {}
    impl Shared {
        fn stop(&self) {
            // SAFETY: it is open until this thread has ended.
            unsafe { hb_stop(self.0.cast_mut()) };
        }
    }
    let mut program = Program::open();
    let mut host = Host::connect(program.port());
    host.run(&mut program, 1, 0);
    let shared = Shared(program.bridge);
    std::thread::scope(|scope| {
        scope.spawn(|| shared.stop());
        // SAFETY: it is open.
        assert_eq!(unsafe { hb_fault(shared.0) }, 0);
    });
    program.fades(0);
}

#[test]
fn a_host_that_reads_nothing_and_says_much_holds_nobody_up() {
    let mut program = Program::open();
    let mut host = Host::connect(program.port());
    host.run(&mut program, 1, 0);
    let mut frame = [0; FRAME_MAX];
    // Thousands of answers of hundred bytes that nobody reads: more than the buffers on their way hold.
    for messages in 0..20_000 {
        let length = host.conversation.tell(&Request::GetKeys, &mut frame);
        let mut rest = &frame[..length];
        while !rest.is_empty() {
            match host.stream.write(rest) {
                Ok(count) => rest = &rest[count..],
                Err(_) => std::thread::yield_now(),
            }
        }
        if messages % 20 == 0 {
            std::thread::sleep(PAUSE);
            // On a busy machine the line may already be too late for the watchdog.
            assert!([0, 2].contains(&program.tick_after(1000)));
        }
    }
    // Answers on their way feed the watchdog.
    program.until_a_fault(9999);
    program.fades(2);
    drop(host);
    Host::connect(program.port()).run(&mut program, 2, 1);
}
