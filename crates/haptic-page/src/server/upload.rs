//! A log that a person dropped on the page: `PUT /TOKEN/log/NAME.mcap`, with the bytes of the file.

use super::http::Door;
use super::hub::Hub;
use super::response::{Answer, said, sentence};
use crate::dropped::DroppedLog;
use haptic_experiment::Failure;
use http_body_util::BodyExt as _;
use hyper::body::Incoming;
use hyper::{Request, StatusCode};
use serde_json::json;
use std::io::Write as _;

const FOLDER: &str = "log/";
/// Largest log that is taken, bytes: 9 hours at 1 kHz.
const LARGEST: u64 = 4 << 30;

/// Takes a log from the page itself: its name as JSON, or a sentence.
pub(super) async fn kept(door: &Door, hub: &Hub, request: Request<Incoming>) -> Answer {
    if let Some(refusal) = door.refusal_of_others(request.headers()) {
        return refusal;
    }
    let path = request.uri().path().to_owned();
    let Some(name) = door
        .behind(&path)
        .and_then(|rest| rest.strip_prefix(FOLDER))
    else {
        return sentence(StatusCode::NOT_FOUND, "Only a log can be put here.");
    };
    match taken(hub, name, request.into_body()).await {
        Ok(name) => said(StatusCode::OK, json!({"name": name}).to_string()),
        Err(failure) => said(StatusCode::BAD_REQUEST, failure.to_string()),
    }
}

async fn taken(hub: &Hub, name: &str, mut body: Incoming) -> Result<String, Failure> {
    let Some(mut log) = DroppedLog::begin(&hub.options.runs, name)? else {
        return Err(Failure::bad_input(format_args!(
            "{name:?} cannot name a log: rename it to letters and digits, as run.mcap"
        )));
    };
    let mut bytes = 0;
    while let Some(frame) = body.frame().await {
        let cut = |error| Failure::bad_input(format_args!("{name} did not arrive: {error}"));
        let Ok(piece) = frame.map_err(cut)?.into_data() else {
            continue;
        };
        bytes += piece.len() as u64;
        if bytes > LARGEST {
            return Err(Failure::bad_input(format_args!(
                "{name} is larger than {} GB: copy it into the folder of the runs",
                LARGEST >> 30
            )));
        }
        let full = |error| Failure::data_lost(format_args!("{name} was not kept: {error}"));
        tokio::task::block_in_place(|| log.file.write_all(&piece)).map_err(full)?;
    }
    tokio::task::block_in_place(|| log.end())
}
