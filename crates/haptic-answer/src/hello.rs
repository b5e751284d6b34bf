//! The first answer: what there is to be felt, and within which numbers.

use crate::feel::{CHANNELS, DeviceNumbers, FeelSettings, SLIDERS};
use haptic_document::Failure;
use haptic_judge::modelled_tissue::{ModelledTissue, TissuePiece};
use haptic_loop::Limiters;
use haptic_tissue::{Library, Material};
use serde_json::{Value, json};
use std::collections::BTreeMap;

const VERSION: u32 = 1;
/// Columns of a view, at most.
pub const COLUMNS_MOST: u32 = 8192;

/// Facts that a server says of itself.
#[derive(Debug)]
pub struct Known<'a> {
    /// True if this page has the controls.
    pub controls: bool,
    /// The number of pages besides the first.
    pub watching: usize,
    /// T of the loop, s.
    pub sample_time_s: f64,
    /// Settings of the loop, as the protocol has them.
    pub feel: Option<Value>,
    /// Settings of the first loop.
    pub opens: Option<&'a FeelSettings>,
    /// The device, but for what a page asks for.
    pub device: DeviceNumbers,
    /// The folder of the runs.
    pub runs_folder: String,
}

impl Known<'_> {
    /// The answer to a page of this version.
    ///
    /// # Errors
    /// Another version.
    pub fn hello(self, version: u32, library: &Library) -> Result<Value, Failure> {
        if version != VERSION {
            return Err(Failure::bad_input(format_args!(
                "this page speaks version {version}, the server {VERSION}: reload the page"
            )));
        }
        // A file of the folder that cannot be felt does not hide the others; the reason comes when it is asked for.
        let tissues: Vec<Value> = library.materials().iter().flat_map(tissue).collect();
        Ok(json!({
            "version": VERSION,
            "controls": self.controls,
            "watching": self.watching,
            "sample_time_s": self.sample_time_s,
            "channels": CHANNELS,
            "limiters": Limiters::NAMES,
            "tissues": tissues,
            "ranges": SLIDERS.into_iter().collect::<BTreeMap<_, _>>(),
            "feel": self.feel,
            "opens": self.opens,
            "device": self.device,
            "view_columns_most": COLUMNS_MOST,
            "runs_folder": self.runs_folder,
        }))
    }
}

fn tissue(material: &Material) -> Result<Value, Failure> {
    let tissue = ModelledTissue::new(material.clone())?;
    let piece = TissuePiece::usual(tissue).map_err(Failure::input)?;
    let (stiffness, dissipation) = piece.spring_and_damper();
    let tissue = &piece.material;
    Ok(json!({
        "name": material.name,
        "title": material.description,
        "model": material.model.kind().name(),
        "order": tissue.order().get(),
        "order_free": tissue.composed().is_none(),
        "stiffness_n_per_m": stiffness,
        "dissipation_n_s_mu_per_m": dissipation,
    }))
}
