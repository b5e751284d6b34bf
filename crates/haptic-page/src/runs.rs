//! Runs.
use crate::Announce;
use crate::pyramid::{Columns, Span};
use haptic_experiment::Failure;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::path::PathBuf;

#[derive(Debug)]
pub(crate) struct Runs;
pub(crate) struct ShownRun {
    pub(crate) channels: Vec<&'static str>,
    pub(crate) columns: Columns,
    pub(crate) sample_time_s: f64,
}
impl Runs {
    pub(crate) fn new(_: PathBuf, _: BTreeMap<String, String>, _: Announce) -> Self { Self }
    pub(crate) fn stop(&self) {}
    pub(crate) async fn end(&self) {}
    pub(crate) fn list(&self) -> Result<Value, Failure> { Ok(json!({"runs": []})) }
    pub(crate) fn open(&self, _: &str) -> Result<Value, Failure> { Err(Failure::bad_input("not yet")) }
    pub(crate) fn forms(&self) -> Value { json!({"forms": []}) }
    pub(crate) fn start(&self, _: &str, _: &Map<String, Value>, _: bool) -> Result<Value, Failure> { Err(Failure::bad_input("not yet")) }
    pub(crate) fn columns(&self, _: &str, _: impl Fn(u64, f64) -> Result<Span, Failure>) -> Result<ShownRun, Failure> { Err(Failure::bad_input("not yet")) }
}
