//! The record: a file that grows by one line of JSON with every measurement that is kept.
//!
//! A line is an object with all of these keys; other keys are ignored.
//!
//! | key | value |
//! |---|---|
//! | `date` | when, as RFC 3339: `"2026-01-31T12:00:00Z"` |
//! | `commit` | what of, as git abbreviates it, with `-dirty` if files differ from it; or `null` |
//! | `cpu` | model of the processor |
//! | `processors` | how many the program may use |
//! | `threads` | how many threads it used |
//! | `version` | of the program |
//! | `bench` | which measurement: `"overhead"`, ...; `"peers"` for programs beside this one |
//! | `figures` | numbers under flat names (see [`super::figures`]) |
//!
//! Other programs may append lines of this shape.

use std::fs;
use std::io;
use std::path::Path;
use std::time::{Duration, SystemTime};

use serde::{Deserialize, Serialize};

use super::figures::Figures;
use crate::image::{OutputError, atomic};

const FORMAT: &str = "record";

/// A line of the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// When, as RFC 3339.
    pub date: String,
    /// What of; nothing if that is not known.
    #[serde(deserialize_with = "Option::deserialize")]
    pub commit: Option<String>,
    /// Model of the processor.
    pub cpu: String,
    /// Processors that the program may use.
    pub processors: usize,
    /// Threads that it used.
    pub threads: usize,
    /// Version of the program.
    pub version: String,
    /// Which measurement.
    pub bench: String,
    /// What it found.
    pub figures: Figures,
}

/// All records of a file.
pub fn read(path: &Path) -> Result<Vec<Record>, OutputError> {
    let text = fs::read_to_string(path).map_err(|error| OutputError::read(path, error))?;
    parse(&text).map_err(|reason| OutputError::malformed(path, FORMAT, reason))
}

/// Checks before a long measurement that [`append`] could do its work.
pub fn check_appendable(path: &Path) -> Result<(), OutputError> {
    // First, for it refuses what is no file and could be read for ever.
    atomic::probe_writable(path)?;
    lines_of(path).map(drop)
}

/// Adds a line to a file, or makes it. The file is replaced as a whole, so that no failure leaves
/// half a line; one with a line that is no record is left alone.
pub fn append(path: &Path, record: &Record) -> Result<(), OutputError> {
    let mut text = lines_of(path)?;
    if !text.is_empty() && !text.ends_with('\n') {
        text.push('\n');
    }
    let line = serde_json::to_string(record)
        .map_err(|error| OutputError::unwritable(path, error.to_string()))?;
    text.push_str(&line);
    text.push('\n');
    atomic::write(path, text.as_bytes())
}

/// The text of a file of records, all of which can be read; none if there is no file.
fn lines_of(path: &Path) -> Result<String, OutputError> {
    let text = match fs::read_to_string(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => String::new(),
        text => text.map_err(|error| OutputError::read(path, error))?,
    };
    parse(&text).map_err(|reason| OutputError::malformed(path, FORMAT, reason))?;
    Ok(text)
}

/// The records of all lines that are not empty, or what is wrong with which line.
fn parse(text: &str) -> Result<Vec<Record>, String> {
    let lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let record = |(index, line): (usize, &str)| {
        let wrong =
            |reason: String| format!("line {}: {reason}; mend the line or take it out", index + 1);
        let record: Record =
            serde_json::from_str(line).map_err(|error| wrong(error.to_string()))?;
        match is_rfc3339(&record.date) {
            true => Ok(record),
            false => Err(wrong(format!("the date {:?} is not RFC 3339", record.date))),
        }
    };
    lines.map(record).collect()
}

/// Whether a text has the form `2026-01-31T12:00:00`, a fraction or not, and `Z` or an offset.
fn is_rfc3339(text: &str) -> bool {
    let matches = |text: &str, pattern: &str| {
        text.len() == pattern.len()
            && (text.bytes().zip(pattern.bytes()))
                .all(|(a, b)| if b == b'0' { a.is_ascii_digit() } else { a == b })
    };
    let Some((time, rest)) = text.split_at_checked(19) else { return false };
    let fraction = rest.strip_prefix('.').unwrap_or("");
    let digits = fraction.bytes().take_while(u8::is_ascii_digit).count();
    let zone = if digits > 0 { &fraction[digits..] } else { rest };
    matches(time, "0000-00-00T00:00:00")
        && (zone == "Z" || matches(zone, "+00:00") || matches(zone, "-00:00"))
}

/// A time as RFC 3339, in UTC and whole seconds.
pub fn rfc3339(time: SystemTime) -> String {
    let since = time.duration_since(SystemTime::UNIX_EPOCH).unwrap_or(Duration::ZERO).as_secs();
    let [year, month, day] = date_of((since / 86_400) as i64);
    let [hour, minute, second] = [since / 3600 % 24, since / 60 % 60, since % 60];
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
}

/// Year, month and day of a number of days since the first of January 1970, none before it.
///
/// Years begin in March here, so that the leap day ends them; their months have 153 days in every
/// five. See Hinnant, "chrono-compatible low-level date algorithms".
fn date_of(days: i64) -> [i64; 3] {
    const DAYS_OF_ERA: i64 = 146_097; // 400 years
    let days = days + 719_468; // since the first of March of the year 0
    let (era, day) = (days / DAYS_OF_ERA, days % DAYS_OF_ERA);
    let year = (day - day / 1_460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let (month, carry) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    [year + era * 400 + carry, month, day]
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINE: &str = concat!(
        r#"{"date":"2026-01-31T12:00:00Z","commit":null,"cpu":"A","processors":2,"threads":1,"#,
        r#""version":"0.1.0","bench":"peers","figures":{"a.ratio":1.5},"note":"ignored"}"#
    );

    #[test]
    fn lines_are_read_and_wrong_ones_named() {
        let records = parse(&format!("{LINE}\n\n{LINE}")).unwrap();
        assert_eq!(records.len(), 2);
        assert_eq!(records[1].figures.0["a.ratio"], 1.5);
        for (from, to, words) in [
            ("\"cpu\":\"A\",", "", "cpu"),
            ("\"commit\":null,", "", "commit"),
            ("1.5", "null", "null"),
            ("1.5", "1e999", "out of range"),
            ("2026-01-31T12:00:00Z", "2026-01-31", "not RFC 3339"),
            (",\"note\":\"ignored\"}", "", "EOF"),
            ("\"threads\":1", "\"threads\":-1", "-1"),
        ] {
            let broken = LINE.replacen(from, to, 1);
            let error = parse(&format!("{LINE}\n{broken}\n")).expect_err(words);
            assert!(error.starts_with("line 2: ") && error.contains(words), "{words}: {error}");
        }
    }

    #[test]
    fn dates_are_those_of_the_calendar() {
        let date = |seconds: u64| rfc3339(SystemTime::UNIX_EPOCH + Duration::from_secs(seconds));
        assert_eq!(date(0), "1970-01-01T00:00:00Z");
        assert_eq!(date(951_782_399), "2000-02-28T23:59:59Z");
        assert_eq!(date(951_782_400), "2000-02-29T00:00:00Z");
        assert_eq!(date(1_709_251_199), "2024-02-29T23:59:59Z");
        assert_eq!(date(4_107_542_400), "2100-03-01T00:00:00Z");
        assert!(is_rfc3339(&date(1_785_000_000)));
        for date in ["2026-01-31T12:00:00+01:00", "2026-01-31T12:00:00.25Z"] {
            assert!(is_rfc3339(date), "{date}");
        }
        for date in ["", "2026-01-31T12:00:00", "2026-01-31T12:00:00.Z", "2026-01-31 12:00:00Z"] {
            assert!(!is_rfc3339(date), "{date}");
        }
    }
}
