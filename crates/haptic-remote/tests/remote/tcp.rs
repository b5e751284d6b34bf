//! TCP as a line: who is let in, who is told what, and the rings of a tick.

use haptic_emulator::{
    LineFaults,
    board::{Emulation, emulate},
};
use haptic_remote::{
    LinkError,
    serial::{ConnectOptions, SerialError, SerialLink, TcpListening, host_and_port},
};
use std::{
    io::{ErrorKind, Read as _, Write as _},
    net::{TcpListener, TcpStream},
    sync::atomic::{AtomicBool, Ordering},
};
use testkit::{Tested, assert_refused, assert_says};

/// An ideal board on a line without faults.
pub(crate) fn ideal() -> Emulation {
    Emulation {
        axes: 1,
        body: None,
        sensor: None,
        at_handle: None,
        robot: None,
        speed: 1.0,
        faults: LineFaults::default(),
        seed: 1,
        duration: None,
    }
}

/// Runs a device at a free port of this machine while something is done with its path.
fn with_device(done: impl FnOnce(&TcpListening)) {
    let listening = TcpListening::open("127.0.0.1:0").expect("a port is free");
    let (line, stop) = (listening.line(), AtomicBool::new(false));
    std::thread::scope(|scope| {
        let device = scope.spawn(|| emulate(line, &ideal(), &stop));
        done(&listening);
        stop.store(true, Ordering::Relaxed);
        device.join().expect("no panic").expect("a good device");
    });
}

fn connect(path: &str) -> Result<SerialLink, SerialError> {
    SerialLink::connect(path, ConnectOptions::default())
}

#[test]
fn a_device_at_an_address_is_as_one_at_a_port_and_serves_one_host_after_the_other() {
    with_device(|listening| {
        let path = listening.path();
        for _ in 0..2 {
            let link = connect(&path).expect("answers");
            assert_eq!(
                (link.capabilities().board(), link.name()),
                ("emulated", path.clone())
            );
        }
        // By a name with several addresses, of which one answers at least.
        let port = listening.address().port();
        connect(&format!("tcp:localhost:{port}")).expect("the name has this address too");
    });
}

#[test]
fn strangers_at_an_address_keep_no_host_out() {
    with_device(|listening| {
        let come = |_| TcpStream::connect(listening.address()).expect("listens");
        let _strangers: Vec<TcpStream> = (0..150).map(come).collect();
        connect(&listening.path()).expect("answers within one greeting");
    });
}

/// Something else than a device, that says this to whoever comes and then lets go.
fn answered_by(words: &'static [u8]) -> SerialError {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port is free");
    let address = listener.local_addr().expect("bound");
    let stranger = std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().expect("a host comes");
        let mut bytes = [0; 1024];
        assert!(
            stream.read(&mut bytes).is_ok_and(|count| count > 0),
            "it greets"
        );
        stream.write_all(words).expect("takes it");
    });
    let error = connect(&format!("tcp:{address}")).expect_err("no device");
    stranger.join().expect("no panic");
    error
}

#[test]
fn a_web_server_is_told_apart_from_a_device_and_a_line_that_breaks() {
    let error = answered_by(b"HTTP/1.1 400 Bad Request\r\nconnection: close\r\n\r\n").to_string();
    let end =
        "answers \"HTTP/1.1 400 Bad Request\": close the other program, or correct the address";
    assert!(
        error.ends_with(end) && error.lines().count() == 1,
        "{error}"
    );
    let error = answered_by(b"busy: it serves 127.0.0.1:1\n").to_string();
    assert_says(&error, "answers \"busy: it serves 127.0.0.1:1\": close");
    for bytes in [&b""[..], b"\x03\xff\x00\x80", b"\x1b[2J\x1b[H", b"ok\n"] {
        let gone = SerialError::Link(LinkError::Gone);
        assert_eq!(answered_by(bytes), gone, "{bytes:?} is not quoted");
    }
}

#[test]
fn a_place_where_nobody_listens_is_named_with_each_address() {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port is free");
    let port = listener.local_addr().expect("bound").port();
    let in_use = TcpListener::bind(("127.0.0.1", port)).expect_err("taken");
    let taken = TcpListening::open(&format!("127.0.0.1:{port}")).expect_err("taken");
    let message = format!(
        "cannot listen at 127.0.0.1:{port}: {in_use}; give another address, or port 0 for a free one"
    );
    assert_eq!(taken.to_string(), message);
    drop(listener);
    for host in ["127.0.0.1", "localhost"] {
        let path = format!("tcp:{host}:{port}");
        let error = connect(&path).expect_err("nobody").to_string();
        let why = format!("127.0.0.1:{port}: Connection refused");
        assert!(
            error.starts_with(&format!("nothing can be reached at {path}: ")),
            "{error}"
        );
        assert!(
            error.contains(&why) && error.lines().count() == 1,
            "{error}"
        );
    }
    assert_refused(
        connect("tcp:no-such-host.invalid:4250"),
        "the name no-such-host.invalid has no address (",
    );
}

#[test]
fn an_address_is_a_host_and_a_port() {
    for (address, parsed) in [
        ("127.0.0.1:4250", ("127.0.0.1", 4250)),
        ("board.local:0", ("board.local", 0)),
        ("[::1]:65535", ("::1", 65535)),
        ("[fe80::1%eth0]:1", ("fe80::1%eth0", 1)),
    ] {
        assert_eq!(host_and_port(address), Ok(parsed));
    }
    for bad in [
        "",
        ":",
        "host",
        "host:",
        ":4250",
        "host:65536",
        "host:-1",
        "host:x",
        "::1:4250",
        "[::1]",
        "[]:1",
        "[host]:1",
        "http://host:80",
        "user@host:80",
        "host:80/x",
        "a b:1",
        "host:4250@115200",
    ] {
        let error = host_and_port(bad).expect_err(bad).to_string();
        assert!(
            error.starts_with(&format!("\"{bad}\" is not HOST:PORT")),
            "{error}"
        );
    }
}

#[test]
fn a_host_that_breaks_off_makes_room_for_the_next() -> Tested {
    let listening = TcpListening::for_any_protocol("127.0.0.1:0")?;
    let mut device = listening.line();
    let mut bytes = [0; 64];
    let error = device.write(b"to nobody").expect_err("nobody");
    assert_eq!(error.kind(), ErrorKind::NotConnected);
    for word in [&b"first"[..], b"other"] {
        let mut host = TcpStream::connect(listening.address())?;
        host.write_all(word)?;
        let mut heard = Vec::new();
        while heard.len() < word.len() {
            if let Ok(count) = device.read(&mut bytes) {
                heard.extend_from_slice(&bytes[..count]);
            }
        }
        assert_eq!(heard, word, "nothing of the host before");
        device.write_all(b"unread")?;
        // What it has not read makes a reset of its end.
        drop(host);
    }
    // The reset is noticed, whenever it comes.
    while device.write(b"x").is_ok() {
        let _ = device.read(&mut bytes);
    }
    Ok(())
}
