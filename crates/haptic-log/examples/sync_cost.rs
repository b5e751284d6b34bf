//! Cost of bringing a growing log to the disk: 10 s of ticks at 1 kHz, without syncs and with those of a run. The disk is that of
//! the temporary folder (`TMPDIR`): `cargo run -p haptic-log --example sync_cost`.

use haptic_log::record::{
    FinishedLog, LogWriter, RecordError, RollingLog, SYNC_INTERVAL, TickMessage,
};
use hdrhistogram::Histogram;
use std::collections::BTreeMap;
use std::error::Error;
use std::thread::sleep;
use std::time::{Duration, Instant};

const TICK: Duration = Duration::from_millis(1);

fn main() -> Result<(), Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let mut plain = LogWriter::create(&folder.path().join("plain.mcap"))?;
    let times = ticks(|message| plain.tick(message))?;
    report("never", &times, &plain.finish()?);
    let path = folder.path().join("synced.mcap");
    let mut synced = RollingLog::create(&path, BTreeMap::new(), false)?;
    let times = ticks(|message| synced.tick(message))?;
    report(
        &format!("every {SYNC_INTERVAL:?}"),
        &times,
        &synced.finish()?,
    );
    Ok(())
}

/// Times that the writer takes for a tick, ns.
fn ticks(
    mut write: impl FnMut(&TickMessage) -> Result<(), RecordError>,
) -> Result<Histogram<u64>, Box<dyn Error>> {
    let mut times = Histogram::new(3)?;
    let began = Instant::now();
    for tick in 0..10_000_u32 {
        sleep((began + tick * TICK).saturating_duration_since(Instant::now()));
        let before = Instant::now();
        write(&TickMessage {
            tick: u64::from(tick),
            time_s: 1e-3 * f64::from(tick),
            position_m: f64::from(tick).sin().into(),
            commanded_force_n: f64::from(tick).cos().into(),
            ..TickMessage::default()
        })?;
        times.saturating_record(before.elapsed().as_nanos() as u64);
    }
    Ok(times)
}

fn report(interval: &str, times: &Histogram<u64>, log: &FinishedLog) {
    let syncs = log.syncs;
    println!(
        "{interval}: {} syncs, {:?} each, longest {:?}; a tick for the writer {} µs at 99.9 %, {} µs longest",
        syncs.count,
        syncs.total / syncs.count.max(1),
        syncs.longest,
        times.value_at_quantile(0.999) / 1000,
        times.max() / 1000
    );
}
