//! Who gets in.

use crate::{options, server};
use haptic_page::OnClose;
use testkit::browser::{Page, get, parts};

#[test]
fn wrong_tokens_and_hosts_get_a_sentence_and_nothing_else() {
    let runs = tempfile::tempdir().expect("a folder");
    let server = server(runs.path(), OnClose::Stop);
    let (host, path) = parts(server.address());
    assert!(
        host.starts_with("127.0.0.1:") && path.len() == 34,
        "{}",
        server.address()
    );
    let own = format!("Host: {host}\r\n");
    let index = get(host, path, &own);
    assert!(
        index.starts_with("HTTP/1.1 200") && index.contains("<!doctype html>"),
        "{index}"
    );
    for header in [
        "content-security-policy: default-src 'self'",
        "x-content-type-options: nosniff",
        "referrer-policy: no-referrer",
        "cache-control: no-store",
        "content-type: text/html",
    ] {
        assert!(index.contains(header), "{header} in {index}");
    }
    let elsewhere = format!("Host: {}\r\n", host.replace("127.0.0.1", "evil.example"));
    for (path, headers, status, words) in [
        ("/", &own, "404", "copy the whole address"),
        (
            "/0123456789abcdef0123456789abcdef/",
            &own,
            "404",
            "copy the whole address",
        ),
        (path, &elsewhere, "403", "copy the address"),
        (&format!("{path}nothing.js"), &own, "404", "No such file"),
        (&format!("{path}../Cargo.toml"), &own, "404", ""),
        (&format!("{path}ws"), &own, "403", "another web site"),
    ] {
        let answer = get(host, path, headers);
        assert!(
            answer.starts_with(&format!("HTTP/1.1 {status}")),
            "{path}: {answer}"
        );
        assert!(
            answer.contains(words) && !answer.contains("<!doctype"),
            "{path}: {answer}"
        );
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
    let wrong = server
        .address()
        .replace(path, "/0123456789abcdef0123456789abcdef/");
    let origin = format!("http://{host}");
    assert!(
        Page::from(&wrong, Some(&origin))
            .expect_err("refused")
            .contains("404")
    );
    // A port that is taken.
    let port = host
        .rsplit_once(':')
        .expect("a port")
        .1
        .parse()
        .expect("a number");
    let taken = options(runs.path(), OnClose::Stop, port);
    let error = haptic_page::PageServer::start(taken)
        .expect_err("taken")
        .to_string();
    assert!(
        error.contains("is taken by another program: take another, or 0"),
        "{error}"
    );
}
