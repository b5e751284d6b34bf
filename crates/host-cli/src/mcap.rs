//! Logs as tables: ticks of ours, or a topic that somebody else wrote.

use crate::output::warn;
use haptic_experiment::Failure;
use haptic_log::record::{Condition, Entry, LogFiles, RecordError, Topic};
use std::path::Path;

/// True if a log has ticks of ours, or no messages at all.
pub(crate) fn is_ours(path: &Path) -> Result<bool, Failure> {
    let mut log = LogFiles::open(path)?;
    let has_ticks = log.any(|entry| matches!(entry, Ok(Entry::Tick(_)) | Err(_)));
    Ok(has_ticks || log.condition().foreign_topics.is_empty())
}

/// The table of a log; `None` for another file. Names of columns as `/topic.field` become those of the table.
pub(crate) fn table(path: &Path, mut names: Vec<&mut String>) -> Result<Option<Vec<u8>>, Failure> {
    if path.extension().is_none_or(|end| end != "mcap") {
        return Ok(None);
    }
    let wanted: Vec<&str> = names.iter().map(|name| name.as_str()).collect();
    let mut topic = read(path, &wanted)?;
    let stamp = topic
        .columns
        .iter()
        .find(|(name, _)| name.ends_with("stamp_s"));
    if let Some((stamp, _)) = stamp.filter(|_| !wanted.iter().any(|name| name.ends_with("_s"))) {
        let time = &topic.columns[0].0;
        warn(&format!(
            "{time} is the time of recording: give --columns time={stamp} for that of the messages"
        ));
    }
    for name in &mut names {
        **name = field(name, &topic).to_owned();
    }
    // A record whose clock was set back, as was said: whoever reads it asks for other times.
    if !topic.columns[0].1.is_sorted() {
        topic.columns.remove(0);
    }
    let mut bytes = Vec::new();
    topic.write_csv(&mut bytes, path)?;
    Ok(Some(bytes))
}

/// Says that ticks stood behind later ones.
pub(crate) fn warn_of_order(condition: &Condition) {
    if condition.sorted > 0 {
        let sorted = condition.sorted;
        warn(&format!(
            "{sorted} ticks stood behind later ones: they are sorted by their numbers"
        ));
    }
}

/// `/topic.field` without the topic.
fn field<'a>(name: &'a str, topic: &Topic) -> &'a str {
    let rest = name.strip_prefix(&topic.name).unwrap_or(name);
    rest.strip_prefix('.').unwrap_or(rest)
}

/// A topic, and what was left out of it on standard error.
fn read(path: &Path, names: &[&str]) -> Result<Topic, Failure> {
    let topic = Topic::read(path, names).map_err(|error| {
        if !matches!(error, RecordError::Topics { .. }) {
            return error.into();
        }
        let advice = "name columns of one topic of numbers (ROS 1, ROS 2 or JSON; convert others to JSON) as /topic.field, with --columns or --column";
        Failure::input_with_advice(error, advice)
    })?;
    if !topic.condition.complete {
        warn("the log is not whole: the table is what could be read");
    }
    for what in &topic.notes {
        warn(&format!("{}: {what}", topic.name));
    }
    Ok(topic)
}

/// A topic with these of its columns, or with all, behind the time of recording.
pub(crate) fn chosen(path: &Path, names: &[&str]) -> Result<Topic, Failure> {
    let mut topic = read(path, names)?;
    let wanted = names.iter().map(|name| field(name, &topic));
    let columns = wanted.filter(|name| !name.is_empty()).map(|wanted| {
        let found = topic.columns.iter().find(|(name, _)| name == wanted);
        found.cloned().ok_or_else(|| {
            let found: Vec<&str> = topic
                .columns
                .iter()
                .map(|(name, _)| name.as_str())
                .collect();
            let (name, found) = (&topic.name, found.join(", "));
            let what = format!("{name} has no column {wanted}: give --columns some of {found}");
            Failure::bad_input(what)
        })
    });
    let columns = columns.collect::<Result<Vec<_>, _>>()?;
    if !columns.is_empty() {
        topic.columns.truncate(1);
        topic.columns.extend(columns);
    }
    Ok(topic)
}
