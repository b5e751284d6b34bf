//! No force before it is armed, and no start.

use super::bench::{Bench, Broken};
use super::promise::{Check, Promise};
use std::time::Duration;

const PROMISED: &str = "no force and no start before it is armed";
/// Time to look at a device that nobody has armed.
const LOOK: Duration = Duration::from_millis(200);

pub(super) fn check(bench: &mut Bench<'_>) -> Result<Check, Broken> {
    bench.trying(Promise::Arm)?;
    let followed = bench.listen(LOOK)?;
    let (samples, most_n) = (followed.samples.len(), followed.largest_n());
    let started = bench.start()?;
    let seen = match &started {
        Some(refused) => format!("{samples} samples, at most {most_n} N; {refused}"),
        None => {
            bench.calm()?;
            format!("{samples} samples, at most {most_n} N; it started all the same")
        }
    };
    let certain = most_n > 0.0 || most_n.is_nan() || started.is_none();
    let ok = samples > 0 && !certain;
    Ok(Check::judged(Promise::Arm, PROMISED, seen, ok).certain(certain))
}
