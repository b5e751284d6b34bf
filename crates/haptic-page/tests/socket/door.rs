//! Who gets in.

use crate::{hello, opened, options, prostate, served};
use haptic_page::{OnClose, PageServer};
use serde_json::json;
use std::io::{ErrorKind, Read as _, Write as _};
use std::net::TcpStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};
use testkit::browser::{get, parts};
use testkit::{Random, assert_refused, assert_says, cases, table, until};

#[test]
fn wrong_tokens_and_hosts_get_a_sentence_and_nothing_else() {
    let (_runs, server) = served();
    let (host, path) = parts(server.address());
    assert!(host.starts_with("127.0.0.1:") && path.len() == 34, "{path}");
    let host_line = format!("Host: {host}\r\n");
    let index = get(host, path, &host_line);
    for words in [
        "HTTP/1.1 200",
        "<!doctype html>",
        "content-security-policy: default-src 'self'",
        "x-content-type-options: nosniff",
        "referrer-policy: no-referrer",
        "cache-control: no-store",
        "content-type: text/html",
    ] {
        assert!(index.contains(words), "{words} in {index}");
    }
    let elsewhere = format!("Host: {}\r\n", host.replace("127.0.0.1", "evil.example"));
    let from_here = format!("{host_line}Origin: http://{host}\r\n");
    let copy = "copy the whole address";
    for (path, headers, status, words) in [
        ("/", &host_line, "404", copy),
        (
            "/0123456789abcdef0123456789abcdef/",
            &host_line,
            "404",
            copy,
        ),
        (path, &elsewhere, "403", "copy the address"),
        (
            &format!("{path}nothing.js"),
            &host_line,
            "404",
            "No such file",
        ),
        (&format!("{path}../Cargo.toml"), &host_line, "404", ""),
        (&format!("{path}ws"), &host_line, "403", "another web site"),
        (&format!("{path}ws"), &from_here, "426", "a WebSocket"),
    ] {
        let answer = get(host, path, headers);
        let status = format!("HTTP/1.1 {status}");
        assert!(answer.starts_with(&status), "{path}: {answer}");
        let is_plain = answer.contains(words) && !answer.contains("<!doctype");
        assert!(is_plain, "{path}: {answer}");
    }
}

#[test]
fn a_file_that_the_browser_has_is_not_sent_again() {
    let (_runs, server) = served();
    let (host, path) = parts(server.address());
    let host_line = format!("Host: {host}\r\n");
    let index = get(host, path, &host_line);
    let script = index.split_once("src=\"").expect("a script").1;
    let script = script.split_once('"').expect("its name").0;
    let path = format!("{path}{script}");
    let file = get(host, &path, &host_line);
    assert!(file.contains("content-type: text/javascript"), "{script}");
    let tag = file.split_once("etag: ").expect("a tag").1;
    let tag = tag.split_once("\r\n").expect("a line").0;
    for (known, status, empty) in [(tag, "304", true), ("\"0\"", "200", false)] {
        let answer = get(
            host,
            &path,
            &format!("{host_line}If-None-Match: {known}\r\n"),
        );
        assert!(answer.starts_with(&format!("HTTP/1.1 {status}")), "{known}");
        assert_eq!(answer.ends_with("\r\n\r\n"), empty, "{known}");
    }
}

#[test]
fn a_port_that_is_taken_is_refused() {
    let (runs, server) = served();
    let port = parts(server.address())
        .0
        .rsplit_once(':')
        .expect("a port")
        .1;
    let taken = options(runs.path(), OnClose::Stop, port.parse().expect("a number"));
    assert_refused(
        PageServer::start(taken),
        "is taken by another program: use another, or 0",
    );
}

#[test]
fn a_browser_is_led_to_the_address_by_a_file_of_its_owner() {
    let (_runs, mut server) = served();
    let address = server.address().to_owned();
    let path = server.opener().expect("a file").to_owned();
    let text = std::fs::read_to_string(&path).expect("it is there");
    assert_says(&text, &format!("url={address}\""));
    assert!(!path.to_string_lossy().contains(parts(&address).1));
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        let mode = std::fs::metadata(&path)
            .expect("it is there")
            .permissions()
            .mode();
        assert_eq!(mode & 0o777, 0o600);
    }
    server.stop();
    assert!(!path.exists());
}

/// The head of a request that opens a socket.
const SOCKET: &str = "GET {path}ws HTTP/1.1\nHost: {host}\nOrigin: http://{host}\nConnection: Upgrade\nUpgrade: websocket\n\
                      Sec-WebSocket-Version: 13\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\n\n";

/// Requests that nobody may make, behind the statuses that refuse them: none where the rest of the request is still to come. A socket
/// (101) is closed for the frames that follow, in hexadecimal digits.
const INTRUSIONS: &str = r"
    403 | GET {path} HTTP/1.1\nHost: {elsewhere}\n\n
    403 | GET {path} HTTP/1.1\n\n
    403 | GET {path} HTTP/1.1\nHost: {host}\nHost: {elsewhere}\n\n
    403 | GET {path} HTTP/1.1\nHost: {host}\nHost: {host}\n\n
    403 | GET http://evil.example{path} HTTP/1.1\nHost: {host}\n\n
    403 | GET http://{elsewhere}{path} HTTP/1.1\nHost: {host}\n\n
    403 405 | CONNECT {host} HTTP/1.1\nHost: {host}\n\n
    404 | GET {guess} HTTP/1.1\nHost: {host}\n\n
    404 | GET {guess}ws HTTP/1.1\nHost: {host}\nOrigin: http://{host}\nConnection: Upgrade\nUpgrade: websocket\n\n
    404 | HEAD {guess}table/1.csv HTTP/1.1\nHost: {host}\n\n
    403 | GET {path}ws HTTP/1.1\nHost: {host}\nOrigin: {origin}\n\n
    403 | GET {path}ws HTTP/1.1\nHost: {host}\nOrigin: http://{host}\nOrigin: {origin}\n\n
    403 | GET {path}ws HTTP/1.1\nHost: {host}\nOrigin: {origin}\nConnection: Upgrade\nUpgrade: websocket\nSec-WebSocket-Version: 13\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\n\n
    426 | GET {path}ws HTTP/1.1\nHost: {host}\nOrigin: http://{host}\nConnection: Upgrade\nUpgrade: h2c\n\n
    426 | GET {path}ws HTTP/1.1\nHost: {host}\nOrigin: http://{host}\nConnection: Upgrade\nUpgrade: websocket\nSec-WebSocket-Version: 8\nSec-WebSocket-Key: x\n\n
    400 404 | GET {path}{climb}etc/passwd HTTP/1.1\nHost: {host}\n\n
    400 404 | GET {path}table/{climb}Cargo.toml HTTP/1.1\nHost: {host}\n\n
    400 404 | GET /{climb}{guess} HTTP/1.1\nHost: {host}\n\n
    400 405 | {verb} {path} HTTP/1.1\nHost: {host}\n\n
    400 405 | {verb} {path}ws HTTP/1.1\nHost: {host}\nOrigin: http://{host}\nContent-Length: 4\n\nstop
    405 | POST {path} HTTP/1.1\nHost: {host}\nContent-Length: 4\nTransfer-Encoding: chunked\n\n0\n\nGET {path} HTTP/1.1\nHost: {host}\n\n
    405 | POST {path} HTTP/1.1\nHost: {host}\nContent-Length: 0\n\nGET {path} HTTP/1.1\nHost: {host}\n\n
    405 | POST {path} HTTP/1.1\nHost: {host}\nContent-Length: 1000000000\n\n{long}
    400 | GET {path} HTTP/1.1\nHost: {host}\nContent-Length: 4\nTransfer-Encoding: chunked\n\n0\n\nGET {path} HTTP/1.1\nHost: {host}\n\n
    400 | GET {path} HTTP/1.1\nHost: {host}\nTransfer-Encoding: chunked\n\n4\nstop\n0\n\nGET {path} HTTP/1.1\nHost: {host}\n\n
    400 | GET {path} HTTP/1.1\nHost: {host}\nContent-Length: 4\n\nstopGET {path} HTTP/1.1\nHost: {host}\n\n
    400 | GET {path} HTTP/1.1\nHost: {host}\nContent-Length: 4\nContent-Length: 5\n\nstop
    400 | GET {path} HTTP/1.1\nHost: {host}\nContent-Length: -1\n\n
    400 | GET {path} HTTP/1.1\nHost: {host}\nTransfer-Encoding: xchunked\n\n
    403 | GET {path} HTTP/1.1\nHost: {elsewhere}\n\nGET {path} HTTP/1.1\nHost: {host}\n\n
    400 431 | GET {path} HTTP/1.1\nHost: {host}\nX: {long}\n\n
    400 431 | GET {path} HTTP/1.1\nHost: {host}\n{many}\n\n
    400 404 414 431 | GET {path}{long}{long} HTTP/1.1\nHost: {host}\n\n
    400 | GET {path} HTTP/1.1\nHost : {host}\n\n
    400 | GET {path} HTTP/9.9\nHost: {host}\n\n
    400 | GET {path}\n\n
    400 | PRI * HTTP/2.0\n\nSM\n\n
    400 | {noise}\n\n
    - | G
    - | GET {path} HTTP/1.1\nHost: {host}\n\n
    - | GET {path} HTTP/1.1\nHost: {host}\nX: {long}
    - | {socket}81ffffffffffffffffff00
    - | {socket}02fe7fff01020304
    - | {socket}89fe007e01020304
    101 | {socket}81026869
    101 | {socket}f18001020304
    101 | {socket}838001020304
    101 | {socket}8b8001020304
    101 | {socket}098001020304
    101 | {socket}81ff7fffffffffffffff01020304
    101 | {socket}81ff000000000100000101020304
    101 | {socket}808001020304
    101 | {socket}0181000000007b8181000000007b
    101 | {socket}818200000000c328
    101 | {socket}88810000000003
    101 | {socket}888200000000 03ed
    101 | {socket}8882000000000000
";

/// Words that a seed chooses for the names in braces.
fn filled(row: &str, address: &str, random: &mut Random) -> String {
    let (host, path) = parts(address);
    let port = &host["127.0.0.1:".len()..];
    let mut guess = path.to_owned();
    let at = 1 + (random.bits() % 32) as usize;
    let digit = if path.as_bytes()[at] == b'0' {
        "1"
    } else {
        "0"
    };
    match random.bits() % 3 {
        0 => guess.replace_range(at..=at, digit),
        1 => guess.truncate(at),
        _ => guess.insert_str(at, digit),
    }
    let names = [
        "evil.example",
        "127.0.0.2",
        "[::1]",
        "0",
        "localhost.evil.example",
        "127.0.0.1:1",
    ];
    let origins = [
        "null",
        "file://",
        "https://localhost",
        "http://evil.example",
    ];
    let climbs = [
        "../",
        "%2e%2e/",
        "..%2f",
        "..\\",
        "%00",
        "%c0%ae%c0%ae/",
        "//",
    ];
    let verbs = [
        "POST", "PUT", "DELETE", "OPTIONS", "TRACE", "PATCH", "get", "GETX", "G\u{e9}T",
    ];
    let long = "a".repeat(1 << random.one_of(&[17, 19, 20]));
    let noise: String = (0..64)
        .map(|_| char::from(0x80 | random.bits() as u8))
        .collect();
    let words = [
        ("{socket}", SOCKET.to_owned()),
        ("{elsewhere}", format!("{}:{port}", random.one_of(&names))),
        ("{origin}", random.one_of(&origins).to_owned()),
        ("{climb}", random.one_of(&climbs).repeat(1 + at)),
        ("{verb}", random.one_of(&verbs).to_owned()),
        ("{long}", long),
        ("{many}", "X: a\n".repeat(100 + at)),
        ("{noise}", noise),
        ("{guess}", guess),
        ("{host}", host.to_owned()),
        ("{path}", path.to_owned()),
    ];
    words
        .iter()
        .fold(row.to_owned(), |row, (name, word)| row.replace(name, word))
        .replace('\n', "\r\n")
}

/// A connection to which this was sent, as far as it was taken: head and body as text, frames behind them as bytes.
fn sent(address: &str, row: &str, random: &mut Random) -> TcpStream {
    let (head, frames) = row
        .split_once("{socket}")
        .map_or((row, ""), |(_, frames)| ("{socket}", frames));
    let mut bytes = filled(head, address, random).into_bytes();
    let frames: Vec<char> = frames.chars().filter(|digit| *digit != ' ').collect();
    let byte =
        |digits: &[char]| u8::from_str_radix(&String::from_iter(digits), 16).expect("digits");
    bytes.extend(frames.chunks(2).map(byte));
    let mut stream = TcpStream::connect(parts(address).0).expect("connected");
    stream
        .set_read_timeout(Some(testkit::PATIENCE))
        .expect("a time limit");
    // Whoever is refused in the middle of it is not heard to the end.
    let _ = stream.write_all(&bytes);
    stream
}

/// The statuses of all answers of a connection to its end.
fn statuses(mut stream: TcpStream) -> Vec<String> {
    let mut answer = Vec::new();
    if let Err(error) = stream.read_to_end(&mut answer) {
        let closed = [
            ErrorKind::ConnectionReset,
            ErrorKind::ConnectionAborted,
            ErrorKind::BrokenPipe,
        ];
        assert!(closed.contains(&error.kind()), "{error}");
    }
    let answer = String::from_utf8_lossy(&answer);
    answer
        .split("HTTP/1.1 ")
        .skip(1)
        .map(|answer| answer[..3].to_owned())
        .collect()
}

/// Panics of servers from now on.
fn panics() -> Arc<AtomicU32> {
    let count = Arc::new(AtomicU32::new(0));
    let (before, counted) = (std::panic::take_hook(), Arc::clone(&count));
    std::panic::set_hook(Box::new(move |info| {
        if std::thread::current().name() == Some("page") {
            counted.fetch_add(1, Ordering::Relaxed);
        }
        before(info);
    }));
    count
}

/// Intrudes so many times; the connections that are still half-open.
fn intrude(address: &str, count: usize) -> Vec<TcpStream> {
    let rows: Vec<[String; 2]> = table(INTRUSIONS).collect();
    let (mut random, mut open, mut slowest) = (Random(65), Vec::new(), Duration::ZERO);
    for case in 0..count {
        let [wanted, row] = &rows[case % rows.len()];
        let stream = sent(address, row, &mut random);
        if wanted == "-" {
            open.push(stream);
            continue;
        }
        let began = Instant::now();
        let statuses = statuses(stream);
        slowest = slowest.max(began.elapsed());
        let refused = statuses.len() <= 1 && statuses.iter().all(|status| wanted.contains(status));
        assert!(refused, "{row}: {statuses:?}");
    }
    println!(
        "{count} intrusions, the slowest refused in {slowest:?}; {} half-open",
        open.len()
    );
    open
}

/// The server after so many intrusions beside a page that finds all as it was, and the connections that are half-open.
fn intruded(count: usize) -> (PageServer, Vec<TcpStream>) {
    let (runs, server, mut page) = opened();
    let (panics, address) = (panics(), server.address());
    let before = hello(&mut page);
    let open = std::thread::scope(|scope| {
        let intruder = scope.spawn(move || intrude(address, count));
        while !intruder.is_finished() {
            let mut still = hello(&mut page);
            for count in ["id", "watching"] {
                still[count] = before[count].clone();
            }
            assert_eq!(still, before);
        }
        intruder.join().expect("all are refused")
    });
    assert_eq!(page.ask("runs.list", json!({}))["runs"], json!([]));
    assert_eq!(std::fs::read_dir(runs.path()).expect("lists").count(), 0);
    page.ask("feel.start", prostate());
    page.status(|status| status["tick"].as_u64() > Some(0) && status["force_n"] == 0.0);
    page.ask("stop", json!({}));
    assert_eq!(panics.load(Ordering::Relaxed), 0);
    (server, open)
}

#[test]
fn an_intruder_is_refused_changes_nothing_and_is_in_nobodys_way() {
    drop(intruded(cases(110)));
}

#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_whoever_says_nothing_or_a_byte_now_and_then_is_let_go_after_some_seconds() {
    let (_server, mut open) = intruded(cases(500));
    let began = Instant::now();
    let silent = open.split_off(open.len() / 2);
    until("the end of them", || {
        open.retain_mut(|stream| stream.write_all(b"x").is_ok());
        open.is_empty().then_some(())
    });
    silent.into_iter().for_each(|stream| drop(statuses(stream)));
    let took = began.elapsed();
    assert!(took < Duration::from_secs(20), "{took:?}");
}
