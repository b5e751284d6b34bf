//! HTTP: who may ask for what, the page's files (compiled into the program), and the headers of every answer.

use super::hub::{BUSY, Hub};
use super::response::{Answer, body, sentence, whole};
use super::{socket, tables};
use hyper::body::{Body as _, Incoming};
use hyper::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, ETAG, HOST, HeaderMap, HeaderName, HeaderValue,
    IF_NONE_MATCH, ORIGIN, REFERRER_POLICY, X_CONTENT_TYPE_OPTIONS,
};
use hyper::{Method, Request, StatusCode, Uri};
use hyper_util::rt::TokioIo;
use std::convert::Infallible;
use std::sync::Arc;
use tokio::sync::mpsc::Sender;
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::handshake::server::create_response_with_body;
use tokio_tungstenite::tungstenite::protocol::{Role, WebSocketConfig};

/// Largest message that a page may send: a record to identify.
const MESSAGE_BYTES: usize = 16 << 20;

const CONTENT_SECURITY: &str = "default-src 'self'; script-src 'self'; style-src 'self' 'unsafe-inline'; \
    img-src 'self' data: blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
const OPENER_POLICY: HeaderName = HeaderName::from_static("cross-origin-opener-policy");
const RESOURCE_POLICY: HeaderName = HeaderName::from_static("cross-origin-resource-policy");

/// A file of the page.
struct File {
    name: &'static str,
    /// MIME type, with the character set if it is a text.
    kind: &'static str,
    /// Tells it from the file of this name in another build.
    tag: &'static str,
    bytes: &'static [u8],
}

/// Written by `page/build`, as the files are.
const FILES: &[File] = include!("../../assets/files.in");
const INDEX: &str = "index.html";

#[derive(Clone, Debug)]
pub(super) struct Door {
    hosts: [String; 2],
    token: String,
}

/// The header of this name, if it is the only one.
fn only(headers: &HeaderMap, name: HeaderName) -> Option<&str> {
    let mut values = headers.get_all(name).iter();
    let value = values.next()?.to_str().ok()?;
    values.next().is_none().then_some(value)
}

impl Door {
    pub(super) fn new(port: u16, token: String) -> Self {
        let hosts = ["127.0.0.1", "localhost"].map(|name| format!("{name}:{port}"));
        Self { hosts, token }
    }

    /// True of the host, and of the authority of an address in full, which counts more than the host.
    fn knows_host(&self, uri: &Uri, headers: &HeaderMap) -> bool {
        let is = |host: &str| (self.hosts.iter()).any(|known| known.eq_ignore_ascii_case(host));
        only(headers, HOST).is_some_and(is) && uri.authority().is_none_or(|host| is(host.as_str()))
    }

    fn knows_origin(&self, headers: &HeaderMap) -> bool {
        let host = only(headers, ORIGIN).and_then(|origin| origin.strip_prefix("http://"));
        host.is_some_and(|host| self.hosts.iter().any(|known| known == host))
    }

    /// Path behind the token; `None` without the token.
    fn behind<'a>(&self, path: &'a str) -> Option<&'a str> {
        let (token, rest) = path.strip_prefix('/')?.split_once('/')?;
        same(token, &self.token).then_some(rest)
    }
}

/// Compares in a time that does not depend on where they differ.
fn same(given: &str, token: &str) -> bool {
    let differences = given.bytes().zip(token.bytes());
    let differ = differences.fold(0, |differ, (a, b)| differ | (a ^ b));
    given.len() == token.len() && differ == 0
}

pub(super) fn with_headers(mut response: Answer) -> Answer {
    let set = response.headers_mut();
    for (name, value) in [
        (CONTENT_SECURITY_POLICY, CONTENT_SECURITY),
        (X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (REFERRER_POLICY, "no-referrer"),
        (OPENER_POLICY, "same-origin"),
        (RESOURCE_POLICY, "same-origin"),
    ] {
        set.insert(name, HeaderValue::from_static(value));
    }
    set.entry(CACHE_CONTROL)
        .or_insert(HeaderValue::from_static("no-store"));
    response
}

/// The requested file, or a refusal.
pub(super) fn answer(
    door: &Door,
    hub: &Arc<Hub>,
    open: &Sender<Infallible>,
    request: Request<Incoming>,
) -> Answer {
    let headers = request.headers();
    if !door.knows_host(request.uri(), headers) {
        let text = "Use 127.0.0.1 or localhost: copy the address from the terminal.";
        return sentence(StatusCode::FORBIDDEN, text);
    }
    if request.method() != Method::GET && request.method() != Method::HEAD {
        let text = "Only GET and HEAD are allowed.";
        return sentence(StatusCode::METHOD_NOT_ALLOWED, text);
    }
    if !request.body().is_end_stream() {
        return sentence(StatusCode::BAD_REQUEST, "Requests have no body here.");
    }
    let Some(name) = door.behind(request.uri().path()) else {
        let text = "The token is missing or wrong: copy the whole address from the terminal.";
        return sentence(StatusCode::NOT_FOUND, text);
    };
    if name != "ws" {
        let file =
            asset(name, headers).or_else(|| tables::fetched(&hub.tables, name, &hub.work, BUSY));
        return file.unwrap_or_else(|| sentence(StatusCode::NOT_FOUND, "No such file."));
    }
    if !door.knows_origin(headers) {
        let text = "Refused for another web site: open the address from the terminal.";
        return sentence(StatusCode::FORBIDDEN, text);
    }
    let Ok(response) = create_response_with_body(&request, || whole(&[])) else {
        return sentence(StatusCode::UPGRADE_REQUIRED, "This is a WebSocket.");
    };
    tokio::spawn(upgraded(request, Arc::clone(hub), open.clone()));
    response
}

/// Serves the socket that a request becomes; `open` until it is closed.
async fn upgraded(request: Request<Incoming>, hub: Arc<Hub>, open: Sender<Infallible>) {
    // An error means that it has gone before.
    let Ok(stream) = hyper::upgrade::on(request).await else {
        return;
    };
    let limits = WebSocketConfig::default()
        .max_message_size(Some(MESSAGE_BYTES))
        .max_frame_size(Some(MESSAGE_BYTES));
    let stream = TokioIo::new(stream);
    let stream = WebSocketStream::from_raw_socket(stream, Role::Server, Some(limits)).await;
    socket::serve(stream, hub).await;
    drop(open);
}

fn asset(name: &str, headers: &HeaderMap) -> Option<Answer> {
    let name = if name.is_empty() { INDEX } else { name };
    let file = FILES.iter().find(|file| file.name == name)?;
    let mut response = body(file.kind, whole(file.bytes));
    if name == INDEX {
        return Some(response);
    }
    if headers
        .get(IF_NONE_MATCH)
        .is_some_and(|known| known == file.tag)
    {
        *response.status_mut() = StatusCode::NOT_MODIFIED;
        *response.body_mut() = whole(&[]);
    }
    let set = response.headers_mut();
    set.insert(CACHE_CONTROL, HeaderValue::from_static("no-cache"));
    set.insert(ETAG, HeaderValue::from_static(file.tag));
    Some(response)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn door() -> Door {
        Door::new(8123, "0123456789abcdef".to_owned())
    }

    fn with(name: HeaderName, values: &[&'static str]) -> HeaderMap {
        let mut headers = HeaderMap::new();
        for value in values {
            headers.append(name.clone(), HeaderValue::from_static(value));
        }
        headers
    }

    #[test]
    fn only_the_servers_own_names_are_hosts() {
        let knows = |uri: &'static str, hosts: &[&'static str]| {
            door().knows_host(&Uri::from_static(uri), &with(HOST, hosts))
        };
        for host in ["127.0.0.1:8123", "localhost:8123", "LOCALHOST:8123"] {
            assert!(knows("/", &[host]), "{host}");
        }
        assert!(knows("http://localhost:8123/", &["127.0.0.1:8123"]));
        assert!(!knows("http://evil.example/", &["127.0.0.1:8123"]));
        for hosts in [
            &[""][..],
            &["127.0.0.1"],
            &["127.0.0.1:8124"],
            &["evil.example:8123"],
            &["127.0.0.1:8123.evil.example"],
            &["localhost:8123", "evil.example"],
            &[],
        ] {
            assert!(!knows("/", hosts), "{hosts:?}");
        }
    }

    #[test]
    fn only_the_pages_own_origin_may_open_the_socket() {
        assert!(door().knows_origin(&with(ORIGIN, &["http://127.0.0.1:8123"])));
        for origin in [
            "null",
            "https://127.0.0.1:8123",
            "http://127.0.0.1",
            "http://evil.example",
            "http://localhost:8123/",
        ] {
            assert!(!door().knows_origin(&with(ORIGIN, &[origin])), "{origin}");
        }
        assert!(!door().knows_origin(&HeaderMap::new()));
    }

    #[test]
    fn the_token_is_all_of_the_first_part_of_the_path() {
        assert_eq!(door().behind("/0123456789abcdef/"), Some(""));
        assert_eq!(door().behind("/0123456789abcdef/a/b.js"), Some("a/b.js"));
        for path in [
            "/",
            "",
            "/0123456789abcdef",
            "/0123456789abcde/",
            "/0123456789abcdeg/",
            "//0123456789abcdef/",
        ] {
            assert_eq!(door().behind(path), None, "{path}");
        }
    }

    #[test]
    fn the_page_is_in_the_program_and_no_other_host_is_named_in_its_first_file() {
        let index = FILES.iter().find(|file| file.name == INDEX);
        let text = std::str::from_utf8(index.expect("built in").bytes).expect("is UTF-8");
        assert!(text.starts_with("<!doctype html>"));
        for elsewhere in ["http://", "https://", "src=\"/", "href=\"/"] {
            assert!(!text.contains(elsewhere), "{elsewhere}");
        }
    }
}
