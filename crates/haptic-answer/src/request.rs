//! Requests of a page: see `docs/page-protocol.md`.

#![expect(missing_docs, reason = "the protocol has them, by these names")]

use crate::feel::FeelChange;
use crate::question::PanelQuestion;
use crate::surface::SurfaceRequest;
use crate::words::{TextFile, in_a_line};
use serde::Deserialize;
use serde_json::{Map, Value};

#[derive(Debug, Deserialize)]
#[serde(tag = "do", deny_unknown_fields)]
pub enum PageRequest {
    #[serde(rename = "hello")]
    Hello { version: u32 },
    #[serde(rename = "controls.take")]
    TakeControls {
        #[serde(default)]
        force: bool,
    },
    #[serde(rename = "controls.release")]
    ReleaseControls {},
    #[serde(rename = "feel.start")]
    FeelStart(FeelChange),
    #[serde(rename = "feel.set")]
    FeelSet(FeelChange),
    #[serde(rename = "feel.hand")]
    FeelHand { position_m: f64, held: bool },
    #[serde(rename = "feel.pause")]
    FeelPause { paused: bool },
    #[serde(rename = "feel.mark")]
    FeelMark { text: String },
    #[serde(rename = "feel.record")]
    FeelRecord { on: bool },
    #[serde(rename = "feel.end")]
    FeelEnd {},
    #[serde(rename = "compare.start")]
    CompareStart(CompareStart),
    #[serde(rename = "compare.feel")]
    CompareFeel {},
    #[serde(rename = "compare.rate")]
    CompareRate { rating: f64 },
    #[serde(rename = "compare.answer")]
    CompareAnswer { stiffer: u8 },
    #[serde(rename = "compare.end")]
    CompareEnd {},
    #[serde(rename = "stop")]
    Stop {},
    #[serde(rename = "arm")]
    Arm {},
    #[serde(rename = "view")]
    View(ViewRequest),
    #[serde(rename = "view.end")]
    ViewEnd {},
    #[serde(rename = "runs.list")]
    RunsList {},
    #[serde(rename = "runs.open")]
    RunsOpen { name: String },
    #[serde(rename = "runs.table")]
    RunsTable(TableRequest),
    #[serde(rename = "runs.forms")]
    RunsForms {},
    #[serde(rename = "runs.start")]
    RunsStart(StartRun),
    #[serde(rename = "runs.stop")]
    RunsStop {},
    #[serde(rename = "tissue.keep")]
    TissueKeep { name: String, text: String },
    #[serde(rename = "file")]
    File(TextFile),
    #[serde(rename = "ask")]
    Ask {
        panel: Panel,
        question: PanelQuestion,
    },
    #[serde(rename = "quantity")]
    Quantity { key: String, text: String },
    #[serde(rename = "surface")]
    Surface(SurfaceRequest),
}

fracdiff::enumerated! {
    /// A part of the page that asks for itself.
    #[derive(Clone, Copy, Debug, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Panel {
        Design,
        Safety,
        Control,
        Loop,
        Identify,
    }
}

pub const LIVE: &str = "live";

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ViewRequest {
    pub source: String,
    pub columns: u32,
    pub from_s: Option<f64>,
    pub to_s: Option<f64>,
    pub last_s: Option<f64>,
    pub channels: Option<Vec<String>>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StartRun {
    pub kind: String,
    #[serde(default)]
    pub parameters: Map<String, Value>,
    #[serde(default)]
    pub realtime: bool,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableRequest {
    pub name: String,
    pub channels: Vec<String>,
    #[serde(default)]
    pub from_s: Option<f64>,
    #[serde(default)]
    pub to_s: Option<f64>,
}

/// Fields of `compare.start`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CompareStart {
    /// The change that makes B of what is felt.
    pub b: FeelChange,
    pub trials: f64,
    /// A code of at most 32 characters, no name.
    pub subject: String,
    pub seed: u32,
    /// Least and most of the ratings; without it nobody is asked for one.
    pub rating_scale: Option<[f64; 2]>,
}

impl PageRequest {
    /// True if only the page that holds the controls may ask for it.
    pub const fn needs_controls(&self) -> bool {
        match self {
            Self::ReleaseControls {}
            | Self::FeelStart(_)
            | Self::FeelSet(_)
            | Self::FeelHand { .. }
            | Self::FeelPause { .. }
            | Self::FeelMark { .. }
            | Self::FeelRecord { .. }
            | Self::FeelEnd {}
            | Self::CompareStart(_)
            | Self::CompareFeel {}
            | Self::CompareRate { .. }
            | Self::CompareAnswer { .. }
            | Self::CompareEnd {}
            | Self::Arm {}
            | Self::RunsStart(_)
            | Self::RunsStop {} => true,
            Self::Hello { .. }
            | Self::TakeControls { .. }
            | Self::Stop {}
            | Self::View(_)
            | Self::ViewEnd {}
            | Self::RunsList {}
            | Self::RunsOpen { .. }
            | Self::RunsTable(_)
            | Self::RunsForms {}
            | Self::TissueKeep { .. }
            | Self::File(_)
            | Self::Ask { .. }
            | Self::Quantity { .. }
            | Self::Surface(_) => false,
        }
    }

    /// True if it is answered where it is read: nothing that was asked before holds up a stop.
    pub const fn is_urgent(&self) -> bool {
        matches!(
            self,
            Self::Stop {} | Self::RunsStop {} | Self::FeelHand { .. }
        )
    }

    /// True if its answer may take long, so that the next requests do not wait for it.
    pub fn takes_long(&self) -> bool {
        let reads_a_log = matches!(self, Self::View(view) if view.source != LIVE);
        reads_a_log
            || matches!(
                self,
                Self::FeelStart(_)
                    | Self::FeelSet(_)
                    | Self::FeelRecord { .. }
                    | Self::FeelEnd {}
                    | Self::CompareStart(_)
                    | Self::CompareFeel {}
                    | Self::CompareRate { .. }
                    | Self::CompareAnswer { .. }
                    | Self::CompareEnd {}
                    | Self::Arm {}
                    | Self::RunsList {}
                    | Self::RunsOpen { .. }
                    | Self::RunsTable(_)
                    | Self::RunsStart(_)
                    | Self::TissueKeep { .. }
                    | Self::Ask { .. }
            )
    }
}

/// The text of a message as a request, with its number.
///
/// # Errors
/// The number, if there is one, and a sentence.
pub fn parse(text: &str) -> Result<(Value, PageRequest), (Value, String)> {
    let none = |error: String| (Value::Null, error);
    let value: Value = serde_json::from_str(text)
        .map_err(|error| none(format!("the message is not JSON: {error}")))?;
    let Value::Object(mut object) = value else {
        return Err(none(
            "the message is not a JSON object: send {\"id\": 1, \"do\": …}".to_owned(),
        ));
    };
    let id = object.remove("id").filter(Value::is_number);
    let Some(id) = id else {
        return Err(none("the message has no `id` that is a number".to_owned()));
    };
    match PageRequest::deserialize(Value::Object(object)) {
        Ok(request) => Ok((id, request)),
        Err(error) => {
            let reason = in_a_line(&error.to_string());
            Err((id, format!("the request is not understood: {reason}")))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn garbage_has_no_number_and_a_wrong_request_has_its_own() {
        let garbage = [
            "",
            "{",
            "7",
            "[]",
            "{}",
            r#"{"do": "stop"}"#,
            r#"{"id": "x", "do": "stop"}"#,
        ];
        for garbage in garbage {
            let (id, sentence) = parse(garbage).expect_err(garbage);
            assert!(id.is_null() && !sentence.is_empty(), "{garbage}");
        }
        let (_, sentence) = parse("[]").expect_err("no object");
        assert!(sentence.contains("not a JSON object"), "{sentence}");
        let wrong = r#"
            {"id": 7}
            {"id": 7, "do": "fly"}
            {"id": 7, "do": "feel.hand", "held": true}
            {"id": 7, "do": "feel.hand", "held": true, "position_m": "x"}
            {"id": 7, "do": "feel.hand", "held": true, "position_m": 0, "more": 1}
            {"id": 7, "do": "feel.set", "ordre": 0.3}
            {"id": 7, "do": "feel.start", "environment": {"tissue": "x", "wall": {}}}
            {"id": 7, "do": "stop", "more": 1}"#;
        for wrong in wrong.trim().lines() {
            let (id, sentence) = parse(wrong).expect_err(wrong);
            assert_eq!(id, 7, "{wrong}");
            assert!(!sentence.contains('\n'), "{sentence}");
        }
    }

    #[test]
    fn requests_are_read_as_the_protocol_writes_them() {
        let request = parse("{\"id\": 7, \"do\": \"feel.set\", \"order\": 0.3}");
        let (id, request) = request.expect("understood");
        assert_eq!(id, 7);
        assert!(request.needs_controls());
        let PageRequest::FeelSet(change) = request else {
            panic!("{request:?}");
        };
        assert_eq!(change.order, Some(0.3));
        let (_, stop) = parse("{\"id\": 8, \"do\": \"stop\"}").expect("understood");
        assert!(!stop.needs_controls(), "anybody may stop");
    }
}
