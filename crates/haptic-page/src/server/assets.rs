//! The files of the page, which are in the program.

use axum::body::Bytes;
use axum::http::header::{
    ACCEPT_ENCODING, CACHE_CONTROL, CONTENT_ENCODING, CONTENT_TYPE, ETAG, IF_NONE_MATCH, VARY,
};
use axum::http::{HeaderMap, HeaderValue, StatusCode};
use axum::response::{IntoResponse as _, Response};
use std::hash::{DefaultHasher, Hash as _, Hasher as _};

/// Name and content of each, sorted by name.
const ASSETS: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/assets.rs"));

/// The file of an empty name.
const INDEX: &str = "index.html";

fn content(name: &str) -> Option<&'static [u8]> {
    let place = ASSETS
        .binary_search_by(|(known, _)| (*known).cmp(name))
        .ok()?;
    Some(ASSETS[place].1)
}

fn media_type(name: &str) -> &'static str {
    match name.rsplit_once('.').map_or("", |(_, end)| end) {
        "html" => "text/html; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "js" | "mjs" => "text/javascript; charset=utf-8",
        "json" | "map" => "application/json",
        "wasm" => "application/wasm",
        "svg" => "image/svg+xml",
        "png" => "image/png",
        "ico" => "image/x-icon",
        "woff2" => "font/woff2",
        "txt" => "text/plain; charset=utf-8",
        _ => "application/octet-stream",
    }
}

/// True if the browser takes this encoding.
fn takes(headers: &HeaderMap, encoding: &str) -> bool {
    let accepted = headers.get_all(ACCEPT_ENCODING).iter();
    accepted
        .filter_map(|value| value.to_str().ok())
        .any(|value| {
            value.split(',').any(|part| {
                let (name, weight) = part.split_once(';').unwrap_or((part, ""));
                let refused = matches!(weight.trim(), "q=0" | "q=0.0" | "q=0.00" | "q=0.000");
                name.trim() == encoding && !refused
            })
        })
}

/// A file by its name, the shorter one where there is one and the browser takes it; `None` if there is none.
pub(super) fn file(name: &str, headers: &HeaderMap) -> Option<Response> {
    let name = if name.is_empty() { INDEX } else { name };
    let plain = content(name)?;
    let shorter = [("br", ".br"), ("gzip", ".gz")]
        .into_iter()
        .find_map(|(encoding, end)| {
            let content = content(&format!("{name}{end}"))?;
            takes(headers, encoding).then_some((encoding, content))
        });
    let (encoding, bytes) = shorter.map_or((None, plain), |(name, bytes)| (Some(name), bytes));
    // Of this build: a file that changes is in another program.
    let mut hasher = DefaultHasher::new();
    bytes.hash(&mut hasher);
    let tag = format!("\"{:016x}\"", hasher.finish());
    let is_index = name == INDEX;
    let known = headers
        .get(IF_NONE_MATCH)
        .is_some_and(|known| known.as_bytes() == tag.as_bytes());
    let mut response = if known && !is_index {
        StatusCode::NOT_MODIFIED.into_response()
    } else {
        Bytes::from_static(bytes).into_response()
    };
    let set = response.headers_mut();
    set.insert(CONTENT_TYPE, HeaderValue::from_static(media_type(name)));
    set.insert(VARY, HeaderValue::from_static("accept-encoding"));
    let caching = if is_index { "no-store" } else { "no-cache" };
    set.insert(CACHE_CONTROL, HeaderValue::from_static(caching));
    if let Some(encoding) = encoding {
        set.insert(CONTENT_ENCODING, HeaderValue::from_static(encoding));
    }
    if let (false, Ok(tag)) = (is_index, HeaderValue::from_str(&tag)) {
        set.insert(ETAG, tag);
    }
    Some(response)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_is_in_the_program_and_no_other_host_is_named_in_its_first_file() {
        let index = content(INDEX).expect("built in");
        let text = std::str::from_utf8(index).expect("is UTF-8");
        assert!(text.starts_with("<!doctype html>"));
        for elsewhere in ["http://", "https://", "src=\"/", "href=\"/"] {
            assert!(!text.contains(elsewhere), "{elsewhere}");
        }
        assert!(ASSETS.is_sorted_by_key(|(name, _)| *name));
    }

    #[test]
    fn encodings_are_taken_as_the_browser_says() {
        let mut headers = HeaderMap::new();
        assert!(!takes(&headers, "br"));
        headers.insert(
            ACCEPT_ENCODING,
            HeaderValue::from_static("gzip, br;q=0, zstd;q=0.5"),
        );
        assert!(takes(&headers, "gzip") && takes(&headers, "zstd") && !takes(&headers, "br"));
    }
}
