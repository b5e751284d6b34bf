//! Tables that a page may fetch, each once, at an address of its own.

use super::response::{Answer, body, sentence};
use crate::runs::Table;
use futures_util::stream;
use haptic_experiment::live::locked;
use http_body_util::{BodyExt as _, StreamBody};
use hyper::StatusCode;
use hyper::body::{Bytes, Frame};
use hyper::header::{CONTENT_DISPOSITION, HeaderValue};
use std::collections::VecDeque;
use std::io;
use std::sync::{Arc, Mutex};
use tokio::sync::{Semaphore, mpsc};
use tokio::task::spawn_blocking;

/// Tables that wait to be fetched; the oldest goes first.
const WAITING: usize = 64;
const AHEAD: usize = 4;
const FOLDER: &str = "table/";

#[derive(Debug, Default)]
pub(super) struct Tables(Mutex<(u64, VecDeque<(u64, Table)>)>);

impl Tables {
    /// The address at which a table can be fetched, relative to that of the page.
    pub(super) fn offer(&self, table: Table) -> String {
        let (next, waiting) = &mut *locked(&self.0);
        *next += 1;
        waiting.push_back((*next, table));
        if waiting.len() > WAITING {
            waiting.pop_front();
        }
        format!("{FOLDER}{next}.csv")
    }

    fn take(&self, name: &str) -> Option<Table> {
        let number = name.strip_prefix(FOLDER)?.strip_suffix(".csv")?;
        let (_, waiting) = &mut *locked(&self.0);
        let index = (waiting.iter()).position(|(known, _)| known.to_string() == number)?;
        waiting.remove(index).map(|(_, table)| table)
    }
}

/// The table of this name, read by work that has a permit; `busy` if none is free, `None` if there is no such table.
pub(super) fn fetched(
    tables: &Tables,
    name: &str,
    work: &Arc<Semaphore>,
    busy: &'static str,
) -> Option<Answer> {
    let Ok(permit) = Arc::clone(work).try_acquire_owned() else {
        return Some(sentence(StatusCode::SERVICE_UNAVAILABLE, busy));
    };
    let table = tables.take(name)?;
    let (out, pieces) = mpsc::channel::<io::Result<Frame<Bytes>>>(AHEAD);
    // It ends when its pieces are no longer taken.
    spawn_blocking(move || {
        let read = table.pieces(|piece| out.blocking_send(Ok(Frame::data(piece.into()))).is_ok());
        if let Err(error) = read {
            // A table that is cut off is no whole download.
            let _ = out.blocking_send(Err(io::Error::other(error.to_string())));
        }
        drop(permit);
    });
    let pieces = stream::unfold(pieces, async |mut pieces| {
        pieces.recv().await.map(|piece| (piece, pieces))
    });
    let pieces = StreamBody::new(pieces).boxed_unsync();
    let mut response = body("text/csv; charset=utf-8", pieces);
    let attachment = HeaderValue::from_static("attachment");
    (response.headers_mut()).insert(CONTENT_DISPOSITION, attachment);
    Some(response)
}
