//! Who gets in.

use crate::{options, server};
use haptic_page::OnClose;
use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use testkit::browser::{Page, get, parts};

#[test]
fn wrong_tokens_and_hosts_get_a_sentence_and_nothing_else() {
    let runs = tempfile::tempdir().expect("a folder");
    let server = server(runs.path(), OnClose::Stop);
    let (host, path) = parts(server.address());
    assert!(host.starts_with("127.0.0.1:") && path.len() == 34, "{path}");
    let own = format!("Host: {host}\r\n");
    let index = get(host, path, &own);
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
    let from_here = format!("{own}Origin: http://{host}\r\n");
    let copy = "copy the whole address";
    for (path, headers, status, words) in [
        ("/", &own, "404", copy),
        ("/0123456789abcdef0123456789abcdef/", &own, "404", copy),
        (path, &elsewhere, "403", "copy the address"),
        (&format!("{path}nothing.js"), &own, "404", "No such file"),
        (&format!("{path}../Cargo.toml"), &own, "404", ""),
        (&format!("{path}ws"), &own, "403", "another web site"),
        (&format!("{path}ws"), &from_here, "426", "a WebSocket"),
    ] {
        let answer = get(host, path, headers);
        let status = format!("HTTP/1.1 {status}");
        assert!(answer.starts_with(&status), "{path}: {answer}");
        let told = answer.contains(words) && !answer.contains("<!doctype");
        assert!(told, "{path}: {answer}");
    }
}

#[test]
fn a_file_that_the_browser_has_is_not_sent_again() {
    let runs = tempfile::tempdir().expect("a folder");
    let server = server(runs.path(), OnClose::Stop);
    let (host, path) = parts(server.address());
    let own = format!("Host: {host}\r\n");
    let index = get(host, path, &own);
    let script = index.split_once("src=\"").expect("a script").1;
    let script = script.split_once('"').expect("its name").0;
    let path = format!("{path}{script}");
    let file = get(host, &path, &own);
    assert!(file.contains("content-type: text/javascript"), "{script}");
    let tag = file.split_once("etag: ").expect("a tag").1;
    let tag = tag.split_once("\r\n").expect("a line").0;
    for (known, status, empty) in [(tag, "304", true), ("\"0\"", "200", false)] {
        let answer = get(host, &path, &format!("{own}If-None-Match: {known}\r\n"));
        assert!(answer.starts_with(&format!("HTTP/1.1 {status}")), "{known}");
        assert_eq!(answer.ends_with("\r\n\r\n"), empty, "{known}");
    }
}

#[test]
fn sockets_of_other_origins_and_a_port_that_is_taken_are_refused() {
    let runs = tempfile::tempdir().expect("a folder");
    let server = server(runs.path(), OnClose::Stop);
    let (host, path) = parts(server.address());
    for origin in [
        None,
        Some("http://evil.example"),
        Some("null"),
        Some("https://127.0.0.1"),
    ] {
        let refused = Page::from(server.address(), origin).expect_err("refused");
        assert!(refused.contains("403"), "{refused}");
    }
    let wrong = "/0123456789abcdef0123456789abcdef/";
    let wrong = server.address().replace(path, wrong);
    let refused = Page::from(&wrong, Some(&format!("http://{host}"))).expect_err("refused");
    assert!(refused.contains("404"), "{refused}");
    // A port that is taken.
    let port = host.rsplit_once(':').expect("a port").1.parse();
    let taken = options(runs.path(), OnClose::Stop, port.expect("a number"));
    let refused = haptic_page::PageServer::start(taken).expect_err("taken");
    let said = refused.to_string();
    assert!(
        said.contains("is taken by another program: take another, or 0"),
        "{said}"
    );
}

#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_a_half_open_request_and_an_idle_connection_are_closed() {
    let runs = tempfile::tempdir().expect("a folder");
    let server = server(runs.path(), OnClose::Stop);
    let (host, path) = parts(server.address());
    let whole = format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n");
    for sent in ["", "GET /", &whole[..whole.len() - 2], &whole] {
        let mut stream = TcpStream::connect(host).expect("connected");
        let most = Some(testkit::PATIENCE);
        stream.set_read_timeout(most).expect("a time limit");
        stream.write_all(sent.as_bytes()).expect("sent");
        // It ends, after an answer where there is one; a time limit would be an error.
        let ended = stream.read_to_end(&mut Vec::new());
        assert!(ended.is_ok(), "{sent:?}: {ended:?}");
    }
}

#[test]
fn a_browser_is_led_to_the_address_by_a_file_of_its_owner() {
    let runs = tempfile::tempdir().expect("a folder");
    let mut server = server(runs.path(), OnClose::Stop);
    let address = server.address().to_owned();
    let path = server.opener().expect("a file").to_owned();
    let text = std::fs::read_to_string(&path).expect("it is there");
    assert!(text.contains(&format!("url={address}\"")), "{text}");
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
