//! Figures of a run, made of the entries of its log as they come.

use haptic_log::record::{BUDGET, CLOCK, Entry, EventMessage, MetadataRecord, RunEnd, TickMessage};
use haptic_loop::Limiters;
use serde::Serialize;
use std::collections::{BTreeMap, VecDeque};

/// Time that the curves show, s.
pub const WINDOW_S: f64 = 10.0;
/// Samples kept for them at most: 10 s at 10 kHz.
const KEPT_MOST: usize = 100_000;
/// Events kept.
const EVENTS_MOST: usize = 8;

/// A sample of the curves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Device time, s.
    pub time_s: f64,
    /// m.
    pub position_m: f64,
    /// N.
    pub force_n: f64,
    /// Limiters that acted.
    pub limiters: u8,
}

/// Figures of a run.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Figures {
    /// Kind of experiment, and what it is made of, as its log says.
    pub experiment: BTreeMap<String, String>,
    /// When it began, UTC.
    pub started_utc: Option<String>,
    /// Samples so far.
    pub samples: u64,
    /// Samples that are missing between those.
    pub samples_lost: u64,
    /// Number of the newest.
    pub tick: Option<u64>,
    /// Its device time, s.
    pub time_s: Option<f64>,
    /// m.
    pub position_m: Option<f64>,
    /// N.
    pub force_n: Option<f64>,
    /// Force that the environment asked for, N.
    pub environment_force_n: Option<f64>,
    /// Energy that the passivity guard has observed, J; null without one.
    pub observed_energy_j: Option<f64>,
    /// Time from a sample to the next, s.
    pub sample_time_s: Option<f64>,
    /// Limiters that acted in the newest sample.
    pub limiters: Vec<&'static str>,
    /// Samples in which each has acted so far.
    pub limited_samples: BTreeMap<&'static str, u64>,
    /// The fault that latched.
    pub fault: Option<String>,
    /// The last events.
    pub events: VecDeque<String>,
    /// Timing of the loop by parts, as the log has it.
    pub timing: BTreeMap<String, String>,
    /// Counts of the link to a device, once the run has ended.
    pub link: BTreeMap<String, String>,
    /// End of the run.
    pub end: Option<RunEnd>,
    #[serde(skip)]
    kept: VecDeque<Point>,
}

impl Figures {
    /// Takes an entry in.
    pub fn take(&mut self, entry: &Entry) {
        match entry {
            Entry::Tick(message) => self.tick(message),
            Entry::Event(event) => self.event(event),
            Entry::Metadata(record) => self.metadata(record),
            _ => {}
        }
    }

    fn tick(&mut self, message: &TickMessage) {
        if let (Some(before), Some(time_s)) = (self.tick, self.time_s)
            && let Some(ticks) = message.tick.checked_sub(before).filter(|ticks| *ticks > 0)
        {
            self.samples_lost += ticks - 1;
            self.sample_time_s = Some((message.time_s - time_s) / ticks as f64);
        }
        self.samples += 1;
        self.tick = Some(message.tick);
        self.time_s = Some(message.time_s);
        self.position_m = Some(message.position_m);
        self.force_n = Some(message.commanded_force_n);
        self.environment_force_n = Some(message.environment_force_n);
        let energy_j = message.observed_energy_j;
        self.observed_energy_j = (!energy_j.is_nan()).then_some(energy_j);
        self.limiters = names(message.limiters).collect();
        for name in names(message.limiters) {
            *self.limited_samples.entry(name).or_default() += 1;
        }
        self.kept.push_back(Point {
            time_s: message.time_s,
            position_m: message.position_m,
            force_n: message.commanded_force_n,
            limiters: message.limiters,
        });
        let oldest_s = message.time_s - WINDOW_S;
        while self.kept.len() > KEPT_MOST
            || self
                .kept
                .front()
                .is_some_and(|point| point.time_s < oldest_s)
        {
            self.kept.pop_front();
        }
    }

    fn event(&mut self, event: &EventMessage) {
        if event.kind == "fault" {
            self.fault.get_or_insert_with(|| event.text.clone());
        }
        if self.events.len() == EVENTS_MOST {
            self.events.pop_front();
        }
        self.events.push_back(format!(
            "{:.3} s  {}: {}",
            event.time_s, event.kind, event.text
        ));
    }

    fn metadata(&mut self, record: &MetadataRecord) {
        if let Some(end) = RunEnd::of(record) {
            self.end = Some(end);
            return;
        }
        match record.name.as_str() {
            "experiment" => self.experiment.clone_from(&record.values),
            // Of the last second, and of the whole run at its end.
            BUDGET | "realtime" => self.timing.clone_from(&record.values),
            "link" => self.link.clone_from(&record.values),
            CLOCK => self.started_utc = record.values.get("started_utc").cloned(),
            _ => {}
        }
    }

    /// Samples of the last [`WINDOW_S`], oldest first.
    #[must_use]
    pub const fn kept(&self) -> &VecDeque<Point> {
        &self.kept
    }

    /// Least and largest of a quantity in each of so many columns over the last [`WINDOW_S`]; `None` where there is no
    /// sample. No peak is lost.
    #[must_use]
    pub fn columns(&self, count: usize, of: impl Fn(&Point) -> f64) -> Vec<Option<(f64, f64)>> {
        let mut columns: Vec<Option<(f64, f64)>> = vec![None; count];
        let end_s = self.time_s.unwrap_or_default();
        for point in &self.kept {
            let share = 1.0 - (end_s - point.time_s) / WINDOW_S;
            let column = ((share * count as f64) as usize).min(count.saturating_sub(1));
            let value = of(point);
            if let Some(slot) = columns.get_mut(column)
                && !value.is_nan()
            {
                let (least, most) = slot.unwrap_or((value, value));
                *slot = Some((least.min(value), most.max(value)));
            }
        }
        columns
    }

    /// Share of the samples of the last second in which each limiter acted.
    #[must_use]
    pub fn limited(&self) -> [f64; 8] {
        let since_s = self.time_s.unwrap_or_default() - 1.0;
        let second = self
            .kept
            .iter()
            .rev()
            .take_while(|point| point.time_s > since_s);
        let mut counts = [0_u32; 8];
        let mut all = 0_u32;
        for point in second {
            all += 1;
            for (bit, count) in counts.iter_mut().enumerate() {
                *count += u32::from(point.limiters >> bit & 1);
            }
        }
        counts.map(|count| f64::from(count) / f64::from(all.max(1)))
    }
}

/// Names of the limiters whose bits are set.
fn names(bits: u8) -> impl Iterator<Item = &'static str> {
    let named = Limiters::NAMES.into_iter().enumerate();
    named.filter_map(move |(bit, name)| (bits >> bit & 1 == 1).then_some(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tick(tick: u64, force_n: f64, limiters: u8) -> Entry {
        Entry::Tick(TickMessage {
            tick,
            time_s: 1e-3 * tick as f64,
            commanded_force_n: force_n,
            limiters,
            observed_energy_j: f64::NAN,
            ..TickMessage::default()
        })
    }

    #[test]
    fn what_is_lost_is_counted_and_what_is_old_is_forgotten() {
        let mut figures = Figures::default();
        for n in (0..20_000).filter(|n| !(500..510).contains(n)) {
            figures.take(&tick(n, 0.0, 0));
        }
        assert_eq!((figures.samples, figures.samples_lost), (19_990, 10));
        assert_eq!(figures.kept().len(), 10_001);
        let period_s = figures.sample_time_s.expect("two samples");
        assert!((period_s - 1e-3).abs() < 1e-9);
        assert_eq!(figures.observed_energy_j, None);
    }

    #[test]
    fn a_peak_of_one_sample_is_in_its_column() {
        let mut figures = Figures::default();
        for n in 0..=10_000 {
            figures.take(&tick(n, if n == 5050 { -7.0 } else { 1.0 }, 0));
        }
        let columns = figures.columns(100, |point| point.force_n);
        let peaks: Vec<usize> = (0..100)
            .filter(|&column| columns[column].is_some_and(|(least, _)| least < 0.0))
            .collect();
        assert_eq!(peaks, [50]);
        assert_eq!(columns[50], Some((-7.0, 1.0)));
        assert_eq!(columns[99], Some((1.0, 1.0)));
    }

    #[test]
    fn limiters_are_told_by_name_and_share_of_the_last_second() {
        let mut figures = Figures::default();
        for n in 0..2000 {
            figures.take(&tick(n, 0.0, if n % 4 == 3 { 3 } else { 0 }));
        }
        assert_eq!(figures.limiters, ["magnitude", "rate"]);
        assert_eq!(figures.limited_samples["rate"], 500);
        let limited = figures.limited();
        assert!(
            (limited[0] - 0.25).abs() < 2e-3 && limited[2] < 1e-9,
            "{limited:?}"
        );
    }
}
