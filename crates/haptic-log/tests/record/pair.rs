//! Logs of two devices: a tissue's, and that of the drive that presses it.

use super::{TICK_S, end};
use haptic_log::record::{Entry, LogFiles, LogWriter, RollingLog, export_csv, inspect, recover};
use haptic_message::{DRIVE_END, END, TickMessage};
use std::{fs::File, io::BufWriter, ops::Range, path::Path};
use testkit::{Folder, Tested};

const TICKS: u64 = 1000;

/// A tick without flaws, which would be reasons too.
fn tick(number: u64) -> TickMessage {
    TickMessage {
        flaws: 0,
        ..super::tick(number)
    }
}

/// A tick of the drive, 0.3 ms after that of the first device.
fn driven(number: u64) -> TickMessage {
    let first = tick(number);
    TickMessage {
        time_s: first.time_s + 0.3 * TICK_S,
        position_m: 0.5.into(),
        ..first
    }
}

/// An unfinished log of both devices, which lacks these ticks of the drive.
fn begun(path: &Path, lost: &Range<u64>) -> LogWriter<BufWriter<File>> {
    let mut writer = LogWriter::create(path).expect("creates");
    for number in 0..TICKS {
        writer.tick(&tick(number)).expect("takes");
        if !lost.contains(&number) {
            writer.drive_tick(&driven(number)).expect("takes");
        }
    }
    writer
}

#[test]
fn ticks_of_both_devices_come_back_and_a_table_has_those_of_the_first() -> Tested {
    let folder = Folder::empty();
    let path = folder.join("pair.mcap");
    begun(&path, &(0..0)).finish()?;
    let (mut first, mut drive) = (0, 0);
    for entry in LogFiles::open(&path)? {
        match entry? {
            Entry::Tick(message) => {
                assert_eq!(message, tick(first));
                first += 1;
            }
            Entry::Drive(message) => {
                assert_eq!(message, driven(drive));
                drive += 1;
            }
            Entry::Event(_) | Entry::Metadata(_) | _ => panic!("no tick"),
        }
    }
    assert_eq!((first, drive), (TICKS, TICKS));
    let summary = inspect(&path)?;
    assert_eq!(summary.drive_samples, Some(TICKS));
    assert!(summary.complete && summary.reasons().is_empty());
    let table = folder.join("pair.csv");
    let exported = export_csv(&path, &table, false)?;
    assert_eq!(exported.rows, TICKS);
    Ok(())
}

#[test]
fn what_the_drive_lost_is_told_in_the_middle_and_at_the_end() -> Tested {
    let folder = Folder::empty();
    for (n, (lost, made, missing)) in [
        (400..407, TICKS, 7),
        (0..0, TICKS + 5, 5),
        (990..TICKS, TICKS, 10),
    ]
    .into_iter()
    .enumerate()
    {
        let path = folder.join(format!("{n}.mcap"));
        let mut writer = begun(&path, &lost);
        writer.metadata(END, end(TICKS, TICKS).metadata())?;
        writer.metadata(DRIVE_END, end(TICKS, made).metadata())?;
        writer.finish()?;
        let summary = inspect(&path)?;
        assert_eq!(summary.missing_samples, 0);
        assert_eq!(summary.drive_missing_samples, Some(missing));
        assert_eq!(
            summary.reasons(),
            [format!("{missing} ticks of the drive missing")]
        );
        // A copy says it too.
        let saved = recover(&path, &folder.join(format!("{n}-saved.mcap")), false);
        let saved = saved?;
        assert!(!saved.complete, "{saved:?}");
        let words = format!("{missing} ticks of the drive are missing");
        assert!(saved.missing.contains(&words), "{saved:?}");
    }
    Ok(())
}

#[test]
fn a_cut_log_keeps_both_devices_and_a_log_in_files_announces_both_in_each() -> Tested {
    let folder = Folder::empty();
    let path = folder.join("cut.mcap");
    drop(begun(&path, &(0..0)));
    let saved = folder.join("saved.mcap");
    recover(&folder.join("cut.mcap.part"), &saved, false)?;
    let summary = inspect(&saved)?;
    assert_eq!(
        (summary.samples, summary.drive_samples),
        (TICKS, Some(TICKS))
    );

    let first = folder.join("day.mcap");
    let mut log = RollingLog::create(&first, [].into(), false)?;
    log.roll_at(0);
    let ticks = 15 * TICKS;
    for number in 0..ticks {
        log.tick(&tick(number))?;
        log.drive_tick(&driven(number))?;
    }
    assert!(log.finish()?.paths.len() > 1);
    let summary = inspect(&first)?;
    assert_eq!(
        (summary.samples, summary.drive_samples),
        (ticks, Some(ticks))
    );
    assert!(summary.foreign_topics.is_empty() && summary.reasons().is_empty());
    Ok(())
}
