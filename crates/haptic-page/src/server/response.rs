//! Bodies of HTTP answers: whole bytes of the program, or pieces as they come.

use http_body_util::combinators::UnsyncBoxBody;
use http_body_util::{BodyExt as _, Full};
use hyper::body::Bytes;
use hyper::header::{CONNECTION, CONTENT_TYPE, HeaderValue};
use hyper::{Response, StatusCode};
use std::io;

pub(super) type Answer = Response<UnsyncBoxBody<Bytes, io::Error>>;

/// An answer of this kind.
pub(super) fn body(kind: &'static str, body: UnsyncBoxBody<Bytes, io::Error>) -> Answer {
    let mut response = Response::new(body);
    let kind = HeaderValue::from_static(kind);
    response.headers_mut().insert(CONTENT_TYPE, kind);
    response
}

pub(super) fn whole(bytes: &'static [u8]) -> UnsyncBoxBody<Bytes, io::Error> {
    let body = Full::new(Bytes::from_static(bytes));
    body.map_err(|never| match never {}).boxed_unsync()
}

/// A refusal ends its connection: whatever hides behind the request is not read as another one.
pub(super) fn sentence(status: StatusCode, text: &'static str) -> Answer {
    let mut response = body("text/plain; charset=utf-8", whole(text.as_bytes()));
    *response.status_mut() = status;
    let close = HeaderValue::from_static("close");
    response.headers_mut().insert(CONNECTION, close);
    response
}
