//! The trends in a record: how each figure has come to where it is.
//!
//! Figures of different processors, or of different numbers of threads, have nothing to do with
//! each other and are kept apart.

use std::collections::BTreeMap;
use std::fmt;

use serde::Serialize;

use super::column_width;
use super::figures::more_is_better;
use super::plot::{Axis, Curve, Panel, Point};
use super::record::Record;

/// All trends of a record.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct History {
    /// One entry for each processor and number of threads, in the order of their first records.
    pub machines: Vec<MachineHistory>,
}

/// What one machine has found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MachineHistory {
    /// Model of the processor.
    pub cpu: String,
    /// Processors that the program may use.
    pub processors: usize,
    /// Threads that it used.
    pub threads: usize,
    /// Date of the first record.
    pub first_date: String,
    /// Date of the latest record.
    pub latest_date: String,
    /// Figures by name.
    pub trends: Vec<Trend>,
}

/// How a figure has changed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Trend {
    /// Its name.
    pub figure: String,
    /// Records that hold it.
    pub records: usize,
    /// Value of the first record.
    pub first: f64,
    /// Value of the record before the latest, if there are two.
    pub previous: Option<f64>,
    /// Value of the latest record.
    pub latest: f64,
    /// The best value: the least, or the greatest where more is better.
    pub best: f64,
    /// The latest against the previous in percent; nothing if that is zero.
    pub since_previous_percent: Option<f64>,
    /// The latest against the first in percent; nothing if that is zero or the same record.
    pub since_first_percent: Option<f64>,
    /// All values in the order of the records.
    pub values: Vec<f64>,
}

impl Trend {
    fn new(figure: &str, values: Vec<f64>) -> Self {
        let (first, latest) = (values[0], values[values.len() - 1]);
        let previous = values.len().checked_sub(2).map(|index| values[index]);
        let best = values.iter().copied().fold(
            first,
            match more_is_better(figure) {
                true => f64::max,
                false => f64::min,
            },
        );
        let percent =
            |before: f64| (before != 0.0).then(|| 100.0 * (latest - before) / before.abs());
        Self {
            figure: figure.to_owned(),
            records: values.len(),
            first,
            previous,
            latest,
            best,
            since_previous_percent: previous.and_then(percent),
            since_first_percent: previous.and(percent(first)),
            values,
        }
    }
}

/// Whose trends to tell.
#[derive(Clone, Copy, Debug, Default)]
pub struct Choice<'a> {
    /// What the names of the figures begin with, one of these; any, if there are none.
    pub figures: &'a [String],
    /// What the model of the processor contains.
    pub cpu: Option<&'a str>,
}

impl History {
    /// The trends in records that are in the order in which they were made.
    pub fn new(records: &[Record], choice: Choice) -> Self {
        let mut machines: Vec<(MachineHistory, BTreeMap<&str, Vec<f64>>)> = Vec::new();
        for record in records.iter().filter(|record| choice.takes(record)) {
            let index = machines.iter().position(|(machine, _)| machine.is_of(record));
            let index = index.unwrap_or_else(|| {
                machines.push((MachineHistory::new(record), BTreeMap::new()));
                machines.len() - 1
            });
            let (machine, values) = &mut machines[index];
            machine.latest_date.clone_from(&record.date);
            for (name, &value) in &record.figures.0 {
                if choice.takes_figure(name) {
                    values.entry(name).or_default().push(value);
                }
            }
        }
        let finish = |(machine, values): (MachineHistory, BTreeMap<&str, Vec<f64>>)| {
            let trends = values.into_iter().map(|(name, values)| Trend::new(name, values));
            MachineHistory { trends: trends.collect(), ..machine }
        };
        Self { machines: machines.into_iter().map(finish).collect() }
    }

    /// One panel a machine: figures relative to their first values.
    pub fn panels(&self) -> Vec<Panel> {
        let curve = |trend: &Trend| Curve {
            name: trend.figure.clone(),
            points: (1..)
                .zip(&trend.values)
                .map(|(number, value)| Point::new(f64::from(number), value / trend.first))
                .collect(),
        };
        let panel = |machine: &MachineHistory| Panel {
            title: machine.to_string(),
            x: Axis::linear("record"),
            y: Axis::linear("relative to the first"),
            curves: machine.trends.iter().map(curve).collect(),
        };
        self.machines.iter().map(panel).collect()
    }
}

impl Choice<'_> {
    fn takes(&self, record: &Record) -> bool {
        self.cpu.is_none_or(|cpu| record.cpu.contains(cpu))
            && record.figures.0.keys().any(|name| self.takes_figure(name))
    }

    fn takes_figure(&self, name: &str) -> bool {
        self.figures.is_empty() || self.figures.iter().any(|prefix| name.starts_with(prefix))
    }
}

impl MachineHistory {
    fn new(record: &Record) -> Self {
        Self {
            cpu: record.cpu.clone(),
            processors: record.processors,
            threads: record.threads,
            first_date: record.date.clone(),
            latest_date: record.date.clone(),
            trends: Vec::new(),
        }
    }

    fn is_of(&self, record: &Record) -> bool {
        self.cpu == record.cpu
            && self.processors == record.processors
            && self.threads == record.threads
    }

    fn write_trends(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = column_width(self.trends.iter().map(|trend| trend.figure.as_str()), 6);
        write!(
            f,
            "\n{:<width$} {:>7} {:>10} {:>10} {:>10} {:>10} {:>11} {:>9}",
            "figure", "records", "first", "previous", "latest", "best", "of previous", "of first"
        )?;
        let percent =
            |change: Option<f64>| change.map_or("-".into(), |change| format!("{change:+.1} %"));
        for trend in &self.trends {
            write!(
                f,
                "\n{:<width$} {:>7} {:>10} {:>10} {:>10} {:>10} {:>11} {:>9}",
                trend.figure,
                trend.records,
                digits(trend.first),
                trend.previous.map_or("-".into(), digits),
                digits(trend.latest),
                digits(trend.best),
                percent(trend.since_previous_percent),
                percent(trend.since_first_percent),
            )?;
        }
        Ok(())
    }
}

/// A value with four digits or so.
fn digits(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        0.001..10.0 => format!("{value:.4}"),
        10.0..1e5 => format!("{value:.1}"),
        _ => format!("{value:.3e}"),
    }
}

impl fmt::Display for MachineHistory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {} processors, {} threads", self.cpu, self.processors, self.threads)
    }
}

impl fmt::Display for History {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, machine) in self.machines.iter().enumerate() {
            let separator = if index == 0 { "" } else { "\n\n" };
            let MachineHistory { first_date, latest_date, .. } = machine;
            writeln!(f, "{separator}{machine}: {first_date} to {latest_date}")?;
            machine.write_trends(f)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::figures::Figures;

    fn record(cpu: &str, threads: usize, figures: &[(&str, f64)]) -> Record {
        let mut kept = Figures::default();
        figures.iter().for_each(|(name, value)| kept.add(&[name], *value));
        Record {
            date: "2026-01-31T12:00:00Z".into(),
            commit: None,
            cpu: cpu.into(),
            processors: 2,
            threads,
            version: "0.1.0".into(),
            bench: "overhead".into(),
            figures: kept,
        }
    }

    #[test]
    fn trends_follow_from_the_records() {
        let records = [
            record("A", 2, &[("a.ratio", 2.0), ("a.speedup", 1.0)]),
            record("B", 2, &[("a.ratio", 100.0)]),
            record("A", 2, &[("a.ratio", 1.0), ("a.speedup", 4.0)]),
            record("A", 1, &[("a.ratio", 50.0)]),
            record("A", 2, &[("a.ratio", 1.5), ("a.speedup", 2.0)]),
        ];
        let history = History::new(&records, Choice::default());
        let machines: Vec<String> = history.machines.iter().map(|m| m.to_string()).collect();
        let words = ["A, 2 processors, 2 threads", "B, 2 processors, 2 threads"];
        assert_eq!(machines[..2], words);
        assert_eq!(machines.len(), 3);
        let [ratio, speedup] = &history.machines[0].trends[..] else { panic!("two figures") };
        assert_eq!((ratio.records, ratio.first, ratio.latest), (3, 2.0, 1.5));
        assert_eq!((ratio.previous, ratio.best, speedup.best), (Some(1.0), 1.0, 4.0));
        assert_eq!(ratio.since_previous_percent, Some(50.0));
        assert_eq!(ratio.since_first_percent, Some(-25.0));
        let alone = &history.machines[1].trends[0];
        assert_eq!((alone.previous, alone.since_first_percent), (None, None));
        let choice = Choice { figures: &["a.sp".into()], cpu: Some("A") };
        let chosen = History::new(&records, choice);
        assert_eq!((chosen.machines.len(), chosen.machines[0].trends.len()), (1, 1));
        assert_eq!(chosen.machines[0].trends[0].figure, "a.speedup");
    }
}
