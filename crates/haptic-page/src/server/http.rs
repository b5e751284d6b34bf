//! HTTP: who may ask for what, and with which headers it is answered.

use super::assets;
use super::hub::{BUSY, Hub};
use super::socket;
use super::tables;
use axum::Router;
use axum::extract::State;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::ws::rejection::WebSocketUpgradeRejection;
use axum::http::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE, HOST, HeaderName, ORIGIN,
    REFERRER_POLICY, X_CONTENT_TYPE_OPTIONS,
};
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, Uri};
use axum::response::{IntoResponse as _, Response};
use std::sync::Arc;

/// Largest message that a page may send: a record to identify.
const MESSAGE_BYTES: usize = 16 << 20;

const CONTENT_SECURITY: &str = "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self' \
    'unsafe-inline'; img-src 'self' data: blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; \
    frame-ancestors 'none'";
const OPENER_POLICY: HeaderName = HeaderName::from_static("cross-origin-opener-policy");
const RESOURCE_POLICY: HeaderName = HeaderName::from_static("cross-origin-resource-policy");

/// Who may ask: the address of the page.
#[derive(Clone, Debug)]
pub(super) struct Door {
    pub(super) port: u16,
    pub(super) token: String,
}

impl Door {
    fn hosts(&self) -> [String; 2] {
        ["127.0.0.1", "localhost"].map(|name| format!("{name}:{}", self.port))
    }

    /// True if a browser asked for this server by one of its own names.
    fn knows_host(&self, headers: &HeaderMap) -> bool {
        let mut hosts = headers.get_all(HOST).iter();
        let (Some(host), None) = (hosts.next(), hosts.next()) else {
            return false;
        };
        let own = self.hosts();
        own.iter()
            .any(|own| host.as_bytes().eq_ignore_ascii_case(own.as_bytes()))
    }

    /// True if the page that asks is one of ours.
    fn knows_origin(&self, headers: &HeaderMap) -> bool {
        let mut origins = headers.get_all(ORIGIN).iter();
        let (Some(origin), None) = (origins.next(), origins.next()) else {
            return false;
        };
        let own = self.hosts();
        own.iter()
            .any(|own| origin.as_bytes() == format!("http://{own}").as_bytes())
    }

    /// What comes behind the token; `None` without it.
    fn behind<'a>(&self, path: &'a str) -> Option<&'a str> {
        let (token, rest) = path.strip_prefix('/')?.split_once('/')?;
        same(token, &self.token).then_some(rest)
    }
}

/// Compares in a time that does not depend on where they differ.
fn same(given: &str, own: &str) -> bool {
    let differences = given.bytes().zip(own.bytes());
    let differ = differences.fold(0, |differ, (a, b)| differ | (a ^ b));
    given.len() == own.len() && differ == 0
}

/// The service.
pub(super) fn router(door: Door, hub: Arc<Hub>) -> Router {
    Router::new()
        .fallback(answer)
        .with_state((Arc::new(door), hub))
}

async fn answer(
    State((door, hub)): State<(Arc<Door>, Arc<Hub>)>,
    method: Method,
    uri: Uri,
    headers: HeaderMap,
    upgrade: Result<WebSocketUpgrade, WebSocketUpgradeRejection>,
) -> Response {
    let mut response = allowed(&door, hub, &method, &uri, &headers, upgrade);
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

fn allowed(
    door: &Door,
    hub: Arc<Hub>,
    method: &Method,
    uri: &Uri,
    headers: &HeaderMap,
    upgrade: Result<WebSocketUpgrade, WebSocketUpgradeRejection>,
) -> Response {
    if !door.knows_host(headers) {
        return sentence(
            StatusCode::FORBIDDEN,
            "Use 127.0.0.1 or localhost: copy the address from the terminal.",
        );
    }
    if method != Method::GET && method != Method::HEAD {
        return sentence(
            StatusCode::METHOD_NOT_ALLOWED,
            "Only GET and HEAD are allowed.",
        );
    }
    let Some(name) = door.behind(uri.path()) else {
        return sentence(
            StatusCode::NOT_FOUND,
            "The token is missing or wrong: copy the whole address from the terminal.",
        );
    };
    if name != "ws" {
        let file = assets::file(name, headers)
            .or_else(|| tables::fetched(&hub.tables, name, &hub.work, BUSY));
        return file.unwrap_or_else(|| sentence(StatusCode::NOT_FOUND, "No such file."));
    }
    if !door.knows_origin(headers) {
        return sentence(
            StatusCode::FORBIDDEN,
            "Refused for another web site: open the address from the terminal.",
        );
    }
    match upgrade {
        Ok(upgrade) => upgrade
            .max_message_size(MESSAGE_BYTES)
            .max_frame_size(MESSAGE_BYTES)
            .on_upgrade(move |stream| socket::serve(stream, hub)),
        Err(_) => sentence(StatusCode::UPGRADE_REQUIRED, "This is a WebSocket."),
    }
}

fn sentence(status: StatusCode, text: &'static str) -> Response {
    let kind = (
        CONTENT_TYPE,
        HeaderValue::from_static("text/plain; charset=utf-8"),
    );
    (status, [kind], text).into_response()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn door() -> Door {
        Door {
            port: 8123,
            token: "0123456789abcdef".to_owned(),
        }
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
        for host in ["127.0.0.1:8123", "localhost:8123", "LOCALHOST:8123"] {
            assert!(door().knows_host(&with(HOST, &[host])), "{host}");
        }
        for host in [
            "",
            "127.0.0.1",
            "127.0.0.1:8124",
            "evil.example:8123",
            "127.0.0.1:8123.evil.example",
        ] {
            assert!(!door().knows_host(&with(HOST, &[host])), "{host}");
        }
        assert!(!door().knows_host(&HeaderMap::new()));
        assert!(!door().knows_host(&with(HOST, &["localhost:8123", "evil.example"])));
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
}
