//! `log`: what is in a log, whether it is whole, and what a cut one still holds.

mod checked;
mod damaged;
mod runs;

use crate::process::{Place, SHORT};

/// A place with `run/relax.mcap` of 3001 samples.
fn with_log() -> Place {
    let place = Place::new();
    place.run(SHORT).succeeded();
    place
}
