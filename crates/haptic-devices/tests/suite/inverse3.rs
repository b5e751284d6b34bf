//! The Inverse3 behind the device's side of the link, on the emulated service: in virtual time, and over sockets as far as time does not
//! matter.

use haptic_devices::{
    ForeignName,
    inverse3::{InTime, Inverse3, Inverse3Name, Inverse3OpenError, Inverse3Trouble},
};
use haptic_emulator::{
    AtLine as _,
    inverse3::{Body, Connection, Hand, SILENCE_US, Service, serve},
};
use haptic_link::{
    Configuration, Limits, LoopMode, NOT_TAKEN, OperatorShape, Start, State, UNANSWERED,
};
use haptic_loop::Fault;
use haptic_remote::{Hardware as _, TickSide, prepare, serial::ServedHardware as _};
use nalgebra::Vector3;
use std::{
    collections::VecDeque,
    io::{ErrorKind, Read, Result, Write},
    net::TcpListener,
    sync::{
        Arc, Mutex, MutexGuard,
        atomic::{AtomicBool, Ordering},
    },
};
use testkit::{assert_close, assert_refused, assert_says};

const ID: &str = "04BA";
const STIFFNESS: f32 = 100.0;

/// Does something to the bytes of an answer.
type Harm = Box<dyn FnMut(&mut Vec<u8>) + Send>;

/// The service and a connection to it.
struct World {
    connection: Connection,
    now_us: u64,
    /// Time from a message to its answer, µs.
    round_trip_us: u64,
    to_host: VecDeque<(u64, u8)>,
    harm: Option<Harm>,
    gone: bool,
    /// Each read takes so long, µs, and gives so many bytes at most.
    read_us: u64,
    bytes: usize,
}

/// The host's end of the connection.
#[derive(Clone)]
struct Wire {
    world: Arc<Mutex<World>>,
    service: Arc<Mutex<Service>>,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().expect("nobody panicked with it")
}

impl Wire {
    fn to(service: Service) -> Self {
        let service = Arc::new(Mutex::new(service));
        let world = World {
            connection: Connection::new(Arc::clone(&service)),
            now_us: 0,
            round_trip_us: 0,
            to_host: VecDeque::new(),
            harm: None,
            gone: false,
            read_us: 0,
            bytes: usize::MAX,
        };
        let world = Arc::new(Mutex::new(world));
        Self { world, service }
    }

    fn held_by(hand: Hand) -> Self {
        Self::to(service([ID], hand))
    }

    fn open<const D: usize>(&self, name: &str) -> core::result::Result<Axes<D>, Inverse3OpenError> {
        let name = Inverse3Name::parse(name).expect("a name");
        let (device, greeting) = Inverse3::greet(self.clone(), &name, || false)?;
        assert_says(&greeting, "gain 0.3");
        Ok(device)
    }

    fn force_n(&self) -> Vector3<f64> {
        lock(&self.service).first().expect("a device").1.into()
    }
}

fn service<const N: usize>(ids: [&str; N], hand: Hand) -> Service {
    Service::new("3.5.0", ids.map(|id| (id.to_owned(), Body::held_by(hand))))
}

impl std::fmt::Debug for Wire {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Wire")
    }
}

impl Read for Wire {
    fn read(&mut self, into: &mut [u8]) -> Result<usize> {
        let mut world = lock(&self.world);
        world.now_us += world.read_us;
        let (now_us, mut count) = (world.now_us, 0);
        while count < into.len().min(world.bytes)
            && let Some((_, byte)) = world.to_host.front().filter(|(at, _)| *at <= now_us)
        {
            into[count] = *byte;
            count += 1;
            world.to_host.pop_front();
        }
        match count {
            0 if world.gone => Ok(0),
            0 => Err(ErrorKind::WouldBlock.into()),
            count => Ok(count),
        }
    }
}

impl Write for Wire {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        let mut guard = lock(&self.world);
        let world = &mut *guard;
        if world.gone {
            return Err(ErrorKind::BrokenPipe.into());
        }
        let (now_us, mut answer) = (world.now_us, Vec::new());
        world.connection.advance(now_us);
        for &byte in bytes {
            world.connection.receive(byte, now_us, &mut answer);
        }
        if let Some(harm) = &mut world.harm {
            harm(&mut answer);
        }
        let arrival_us = now_us + world.round_trip_us;
        (world.to_host).extend(answer.into_iter().map(|byte| (arrival_us, byte)));
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<()> {
        Ok(())
    }
}

type Axes<const D: usize> = Inverse3<Wire, D>;

/// A device that renders springs along its axes.
struct Rig<const D: usize> {
    wire: Wire,
    device: TickSide<Axes<D>, D>,
    period_us: u64,
}

impl<const D: usize> Rig<D> {
    fn at(wire: Wire, name: &str, period_us: u32) -> Self {
        let device = wire.open::<D>(name).expect("it answers");
        let capabilities = device.capabilities();
        let mut device = TickSide::new(device).expect("no configuration is refused");
        // A vector of forces comes from the host.
        let loop_mode = if D == 1 {
            LoopMode::Device
        } else {
            LoopMode::Host
        };
        let configuration = Configuration {
            tick_period_us: period_us,
            stiffness_n_per_m: STIFFNESS,
            loop_mode,
            operator: OperatorShape {
                count: 1,
                ..Configuration::PASSIVE.operator
            },
            limits: Limits {
                force_n: 2.0,
                start_force_n: 0.0,
                rise_time_s: 0.0,
                max_age_ticks: 1000,
                ..Limits::DEFAULT
            },
            ..Configuration::PASSIVE
        };
        let prepared = prepare::<Axes<D>, D>(configuration, &[0.0], &capabilities);
        device
            .install(prepared.expect("good"), &[0.0])
            .expect("idle");
        let period_us = u64::from(period_us);
        Self {
            wire,
            device,
            period_us,
        }
    }

    fn running(hand: Hand, period_us: u32) -> Self {
        let mut rig = Self::at(Wire::held_by(hand), "", period_us);
        rig.tick();
        rig.device.arm(0).expect("nothing is wrong");
        rig.device.start(Start::ENDLESS).expect("it is armed");
        rig
    }

    fn tick(&mut self) {
        let now_us = {
            let mut world = lock(&self.wire.world);
            world.now_us += self.period_us;
            world.now_us
        };
        self.device.heard(now_us, true);
        self.device.tick(now_us);
    }

    fn fault(&self) -> Option<Fault> {
        Fault::from_code(self.device.status().fault)
    }

    fn trouble(&self) -> String {
        let trouble = self.device.hardware().trouble();
        trouble.map_or_else(String::new, |trouble| trouble.words)
    }
}

#[test]
fn with_one_axis_the_force_is_that_of_the_position_bit_for_bit_and_arrives_along_the_line() {
    for period_us in [1000, 250] {
        let mut rig = Rig::<1>::running(Hand::Strokes, period_us);
        let ticks = 1_500_000 / period_us;
        let mut deepest_m = 0.0_f32;
        for _ in 0..ticks {
            rig.tick();
            let sample = *rig.device.newest();
            assert_eq!(rig.fault(), None, "{}", rig.trouble());
            let (x_m, force_n) = (sample.position_m[0], sample.force_n[0]);
            assert_eq!(
                force_n.to_bits(),
                (-STIFFNESS * x_m).to_bits(),
                "{sample:?}"
            );
            // Downwards is positive, and the force goes up.
            let made = rig.wire.force_n();
            let across = [made.x, made.y].map(|axis| axis.abs().to_bits());
            assert_eq!(across, [0, 0]);
            assert_eq!((made.z as f32).to_bits(), (-force_n).to_bits());
            deepest_m = deepest_m.max(x_m);
        }
        // The hand of 400 N/m leads it 15 mm deep, less what 100 N/m hold back.
        assert!((0.008..0.012).contains(&deepest_m), "{deepest_m} m");
        let statistics = rig.device.statistics();
        assert_eq!((statistics.unanswered, statistics.forces_not_taken), (0, 0));
        assert_eq!(statistics.ticks, ticks + 1);
    }
}

#[test]
fn with_three_axes_a_vector_arrives_and_positions_count_from_the_middle_of_the_workspace() {
    let mut rig = Rig::<3>::running(Hand::At([0.01, -0.02, 0.005]), 1000);
    for _ in 0..1500 {
        rig.tick();
        let tick = rig.device.newest().tick;
        assert!(rig.device.command(tick, [0.25, -0.5, 1.0]), "taken");
        assert_eq!(rig.fault(), None, "{}", rig.trouble());
    }
    assert_eq!(rig.wire.force_n(), Vector3::new(0.25, -0.5, 1.0));
    // A hand of 400 N/m gives way.
    let wanted = [
        0.01 + 0.25 / 400.0,
        -0.02 - 0.5 / 400.0,
        0.005 + 1.0 / 400.0,
    ];
    for (have, want) in rig.device.newest().position_m.iter().zip(wanted) {
        assert_close("position", f64::from(*have), want, 1e-4);
    }
}

#[test]
fn each_answer_that_is_late_is_flagged_and_counted_and_no_force_waits_in_a_queue() {
    // At 4 kHz over a line of 0.6 ms every third tick has an answer.
    let mut rig = Rig::<1>::running(Hand::Strokes, 250);
    lock(&rig.wire.world).round_trip_us = 600;
    let before = *rig.device.statistics();
    let mut flagged = [0; 2];
    let messages = lock(&rig.wire.service).counted().messages;
    for _ in 0..3000 {
        rig.tick();
        let flaws = rig.device.newest().flaws;
        flagged[0] += u32::from(flaws & UNANSWERED != 0);
        flagged[1] += u32::from(flaws & NOT_TAKEN != 0);
    }
    assert_eq!(rig.fault(), None, "{}", rig.trouble());
    let counted = rig.device.statistics().since(&before);
    assert_eq!([counted.unanswered, counted.forces_not_taken], flagged);
    let sent = lock(&rig.wire.service).counted().messages - messages;
    assert_eq!(sent, 1000);
    assert!((1999..=2000).contains(&flagged[0]), "{flagged:?}");
    assert!((1998..=2000).contains(&flagged[1]), "{flagged:?}");
}

/// Bytes of answers that are damaged at random end the run or do no harm; never a force beyond the limit.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn damaged_answers_are_a_fault_or_do_no_harm() {
    let mut ended = 0;
    for seed in 0..60 {
        let mut rig = Rig::<1>::running(Hand::At([0.0, 0.0, -0.03]), 1000);
        for _ in 0..200 {
            rig.tick();
        }
        let mut random = testkit::Random(seed);
        lock(&rig.wire.world).harm = Some(Box::new(move |bytes| {
            // Not always the same part of it.
            if random.chance(0.025)
                && let Some(byte) = bytes.get_mut((random.bits() % 1024) as usize)
            {
                *byte ^= 1 << (random.bits() % 8);
            }
        }));
        for _ in 0..200 {
            rig.tick();
            let force_n = rig.wire.force_n();
            assert!(force_n.iter().all(|axis| axis.abs() <= 2.0), "{force_n:?}");
        }
        ended += u32::from(rig.fault().is_some());
        assert!(rig.fault().is_none() || rig.wire.force_n() == Vector3::zeros());
    }
    // Most bytes are of numbers that nobody reads.
    assert!((5..60).contains(&ended), "{ended} of 60");
}

/// The words for what happens to a device that pushes; the force at the service soon after.
fn trouble_of(happens: impl FnOnce(&mut Rig<1>)) -> (String, Vector3<f64>) {
    let mut rig = Rig::<1>::running(Hand::At([0.0, 0.0, -0.03]), 1000);
    for _ in 0..400 {
        rig.tick();
    }
    assert!(rig.wire.force_n()[2] > 0.5, "it pushes: {}", rig.trouble());
    happens(&mut rig);
    for _ in 0..40 {
        rig.tick();
    }
    assert_eq!(rig.fault(), Some(Fault::BoardFailed), "{}", rig.trouble());
    assert_eq!(rig.device.status().state, State::Fault);
    let faults = rig.device.status().faults;
    rig.device.arm(faults).expect_err("it must be opened anew");
    let force_n = lock(&rig.wire.service)
        .first()
        .map_or([0.0; 3], |first| first.1);
    (rig.trouble(), force_n.into())
}

/// Changes the text of each answer, whose length stays.
fn replace(from: &'static str, to: &'static str) -> Harm {
    assert_eq!(from.len(), to.len());
    Box::new(move |bytes| {
        // The head of a frame is not text, and a farewell is no answer.
        let at = (bytes.windows(from.len())).position(|some| some == from.as_bytes());
        if let Some(at) = at {
            bytes[at..at + from.len()].copy_from_slice(to.as_bytes());
        }
    })
}

#[test]
fn each_trouble_is_a_fault_with_a_reason_and_no_force_remains() {
    let has = |happened: (String, Vector3<f64>), words: &str| {
        assert!(happened.0.contains(words), "{happened:?}");
        assert!(happened.0.starts_with("Inverse3 04BA: "), "{happened:?}");
        assert_eq!(happened.1, Vector3::zeros(), "{happened:?}");
    };
    let none = "tells no position of it";
    let unreadable = "is not JSON with a list `inverse3`";
    for (from, to, words) in [
        ("\"cursor_position\"", "\"cursor_location\"", none),
        ("\"x\":0.0,\"y\":0.0", "\"x\":null,\"y\":0 ", none),
        ("\"x\":0.0", "\"x\":NaN", unreadable),
        ("\"x\":0.0", "\"x\":9e9", "faster than a hand"),
        ("{\"session_id\"", "[\"session_id\"", unreadable),
        ("\"inverse3\"", "\"minverse\"", unreadable),
        ("\"04BA\"", "\"049D\"", "does not list it any more"),
    ] {
        let harmed = |rig: &mut Rig<1>| lock(&rig.wire.world).harm = Some(replace(from, to));
        has(trouble_of(harmed), words);
    }
    let unplugged = |rig: &mut Rig<1>| lock(&rig.wire.service).unplug(ID);
    has(trouble_of(unplugged), "check its cable and power");
    let moved = |rig: &mut Rig<1>| {
        let mut service = lock(&rig.wire.service);
        service.body(ID).expect("there").place([0.0, 0.0, 0.05]);
    };
    has(trouble_of(moved), "another program changed its mount");
    let mute = |rig: &mut Rig<1>| lock(&rig.wire.world).harm = Some(Box::new(Vec::clear));
    has(trouble_of(mute), "did not answer for 20 ticks in a row");
}

#[test]
fn a_service_that_is_gone_takes_its_force_with_it() {
    let gone = |rig: &mut Rig<1>| lock(&rig.wire.world).gone = true;
    let (words, _) = trouble_of(gone);
    assert_says(
        &words,
        "has closed the connection & cannot be told to let go",
    );
}

fn command(socket: &mut tungstenite::WebSocket<Wire>, force: &str) {
    let message = format!(
        r#"{{"inverse3":[{{"device_id":"04BA","commands":{{"set_cursor_force":{force}}}}}]}}"#
    );
    let sent = socket.send(tungstenite::Message::text(message));
    sent.expect("taken");
}

#[test]
fn an_emulated_force_ends_with_silence_and_with_the_session() {
    let wire = Wire::held_by(Hand::Free);
    let push = r#"{"vector":{"x":0,"y":0,"z":1.5}}"#;
    let (mut socket, _) = tungstenite::client("ws://localhost/", wire.clone()).expect("opens");
    command(&mut socket, push);
    assert_eq!(wire.force_n(), Vector3::new(0.0, 0.0, 1.5));
    lock(&wire.service).advance(SILENCE_US - 1);
    assert_eq!(wire.force_n(), Vector3::new(0.0, 0.0, 1.5));
    lock(&wire.service).advance(SILENCE_US);
    assert_eq!(wire.force_n(), Vector3::zeros());
    command(&mut socket, push);
    assert_eq!(wire.force_n(), Vector3::new(0.0, 0.0, 1.5));
    socket.close(None).expect("told");
    assert_eq!(wire.force_n(), Vector3::zeros());
}

#[test]
fn an_emulated_service_makes_the_force_of_a_command_or_counts_that_it_cannot_read_it() {
    let wire = Wire::held_by(Hand::Free);
    let (mut socket, _) = tungstenite::client("ws://localhost/", wire.clone()).expect("opens");
    let (some, none) = (Vector3::new(0.25, -0.5, 1.5), Vector3::zeros());
    let mut unreadable = 0;
    for (force, force_n) in [
        (r#"{"vector":{"x":0.25,"y":-0.5,"z":1.5}}"#, Some(some)),
        (r#"{"vector":{"x":0,"y":0,"z":0}}"#, Some(none)),
        (r#"{"values":{"x":0.25,"y":-0.5,"z":1.5}}"#, Some(some)),
        (
            r#"{"vector":{"x":0,"y":0,"z":0},"values":{"x":9,"y":9,"z":9}}"#,
            Some(none),
        ),
        (r#"{"force":{"x":0.25,"y":-0.5,"z":1.5}}"#, None),
        (r#"{"vector":{"x":0.25,"y":-0.5}}"#, None),
        (r#"{"vector":[0.25,-0.5,1.5]}"#, None),
        (r#"{"values":{"x":"1","y":0,"z":0}}"#, None),
        ("7", None),
    ] {
        let before = (wire.force_n(), lock(&wire.service).counted().forces);
        command(&mut socket, force);
        let counted = lock(&wire.service).counted();
        unreadable += u64::from(force_n.is_none());
        let counted = (wire.force_n(), counted.forces, counted.unreadable);
        let made = before.1 + u64::from(force_n.is_some());
        let wanted = (force_n.unwrap_or(before.0), made, unreadable);
        assert_eq!(counted, wanted, "{force}");
    }
}

#[test]
fn a_device_is_chosen_by_its_number_and_looked_at_before_it_counts() {
    let refused = |service: Service, name: &str| {
        let error = Wire::to(service).open::<1>(name).expect_err("refused");
        error.to_string()
    };
    let two = || service(["049D", "04BA"], Hand::Free);
    assert_eq!(
        refused(two(), ""),
        "which Inverse3 is not said: the Inverse Service knows 049D, 04BA; give one of them as id=ID"
    );
    assert_eq!(
        refused(two(), ",id=A14"),
        "there is no Inverse3 `A14`: the Inverse Service knows 049D, 04BA; give one of them as id=ID"
    );
    Wire::to(two()).open::<3>(",id=049D").expect("there");
    let none = refused(service([], Hand::Free), "");
    assert_says(&none, "knows no Inverse3: plug it in");
    let mut lost = two();
    lost.forget_calibration("04BA");
    let lost = refused(lost, ",id=04BA");
    assert_says(&lost, "Inverse3 04BA is not calibrated");
}

#[test]
fn damping_that_another_program_left_is_set_to_none_and_read_back() {
    // A service that does not take it.
    let wire = Wire::held_by(Hand::Free);
    let set = "\"damping\":{\"scalar\":0.0}";
    lock(&wire.world).harm = Some(replace(set, "\"damping\":{\"scalar\":5.0}"));
    assert_refused(
        wire.open::<1>(""),
        "has damping = 5.0 after it was told another",
    );
}

#[test]
fn a_greeting_that_drips_or_is_repeated_ends_after_its_time() {
    const LIMIT_US: u64 = 2_000_000;
    let name = Inverse3Name::parse("").expect("a name");
    // Over HTTP, then over the WebSocket: byte by byte, nothing at all, and whole answers that never have what was asked for.
    let mute: fn() -> Harm = || Box::new(Vec::clear);
    let damped = || replace("\"scalar\":0.0", "\"scalar\":7.0");
    for (over_http, read_us, bytes, harm) in [
        (true, 100_000, 1, damped()),
        (true, 20_000, 1, mute()),
        (false, 100_000, 1, damped()),
        (false, 20_000, 1, mute()),
        (false, 900_000, 4096, damped()),
    ] {
        let wire = Wire::held_by(Hand::Free);
        let world = Arc::clone(&wire.world);
        {
            let mut world = lock(&world);
            (world.read_us, world.bytes, world.harm) = (read_us, bytes, Some(harm));
        }
        let clock = Arc::clone(&world);
        let is_late = move || lock(&clock).now_us >= LIMIT_US;
        let error = if over_http {
            name.check_version(InTime::new(wire, is_late))
        } else {
            Inverse3::<_, 3>::greet(wire, &name, is_late).map(drop)
        };
        let error = error.expect_err("too slow").to_string();
        let wanted = "localhost:10001 did not finish its greeting within 2 s: restart";
        assert!(error.starts_with(wanted), "{error}");
        let took_us = lock(&world).now_us;
        assert!(
            (LIMIT_US..LIMIT_US + read_us).contains(&took_us),
            "{took_us}"
        );
    }
}

#[test]
fn of_what_a_service_says_an_error_repeats_200_characters_in_one_line() {
    let long = |before: &str| format!("{before}\u{1b}[2J\n{}", "9".repeat(100_000));
    let fours = "4".repeat(100_000);
    let shown = format!("{}… (100000 characters)", &fours[..80]);
    for (version, wording) in [
        ("3.1.1.0", "3.1.1.0, and this program needs 3.5"),
        ("4.0", "4.0, and"),
        (&fours, &shown),
        (&long("3.1"), "3.1"),
        (&long("99.0"), "99.0"),
    ] {
        let wire = Wire::to(Service::new(version, []));
        let name = Inverse3Name::parse("").expect("a name");
        let error = name.check_version(InTime::new(wire, || false));
        let error = error.expect_err("another version").to_string();
        assert_says(&error, &format!("is version {wording}"));
        assert_says(&error, "install one");
        assert!(error.chars().count() < 320, "{} characters", error.len());
        assert!(!error.contains(char::is_control), "{error}");
    }
    let ids = ["a", "b"].map(|id| (long(id), Body::held_by(Hand::Free)));
    let error = Wire::to(Service::new("3.5.0", ids)).open::<1>("");
    let error = error.expect_err("two").to_string();
    assert!(error.contains("knows a [2J") && error.chars().count() < 320);
    assert!(!error.contains(char::is_control), "{error}");
}

/// The error of opening a name at a port where this is said to whoever connects.
fn opened_at(wording: &'static str) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address");
    let thread = std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().expect("somebody");
        let _ = stream.read(&mut [0; 1024]);
        let _ = stream.write_all(wording.as_bytes());
    });
    let name: ForeignName = format!("inverse3:{address}").parse().expect("a name");
    let error = name.open_with(3, &|_| {}, None).expect_err("no service");
    thread.join().expect("answers");
    error.to_string().replace(&address.to_string(), "ADDRESS")
}

#[test]
fn what_is_no_service_is_named() {
    for (answer, wording) in [
        (
            "HTTP/1.1 404 Not Found\r\n\r\n<html>{no}</html>",
            "says `HTTP/1.1 404 Not Found`",
        ),
        (
            "HTTP/1.1 200 OK\r\n\r\n<html></html>",
            "says `HTTP/1.1 200 OK`",
        ),
        ("SSH-2.0-OpenSSH_9.2\r\n", "says `SSH-2.0-OpenSSH_9.2`"),
        ("", "says ``"),
    ] {
        let error = opened_at(answer);
        let wanted = format!("ADDRESS is not an Inverse Service: it {wording}");
        assert!(error.starts_with(&wanted), "{error}");
    }
    // Nobody is there any more.
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address");
    drop(listener);
    let name: ForeignName = format!("inverse3:{address}").parse().expect("a name");
    for (axes, wording, may_pass) in [
        (1, "no Inverse Service at 127.0.0.1:", true),
        (2, "it has 3 axes, but 2 are needed", false),
    ] {
        let error = name.open_with(axes, &|_| {}, None).expect_err(wording);
        assert!(error.to_string().starts_with(wording), "{error}");
        assert_eq!(error.may_pass(), may_pass, "{error}");
    }
}

#[test]
fn over_a_socket_the_service_is_opened_with_all_axes() {
    static STOP: AtomicBool = AtomicBool::new(false);
    let serving = |listener: TcpListener| {
        let service = Arc::new(Mutex::new(service([ID], Hand::Free)));
        serve(&listener, &service, None, &STOP).expect("serves");
    };
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address");
    let thread = std::thread::spawn(move || serving(listener));
    // A busy machine may be late.
    let name: ForeignName = format!("inverse3:{address},lost=1000")
        .parse()
        .expect("a name");
    let warnings = Mutex::new(String::new());
    let link = name
        .open_with(3, &|words| lock(&warnings).push_str(words), None)
        .expect("opens");
    assert_eq!(link.capabilities().axes, 3);
    assert_eq!(link.capabilities().board(), "Inverse3 04BA");
    assert!(lock(&warnings).contains("force gate has gain 0.3"));
    drop(link);
    STOP.store(true, Ordering::Relaxed);
    thread.join().expect("ends");
}

#[test]
fn troubles_say_where_to_look() {
    use haptic_remote::serial::TroubleCause;
    assert_eq!(Inverse3Trouble::Gone.cause(), TroubleCause::Gone);
    assert_eq!(Inverse3Trouble::NoPosition.cause(), TroubleCause::Board);
}
