//! `results.jsonl`: a line for every job that has come to an end, written when it does.
//!
//! Of several lines of one output the last counts; lines that cannot be read, as those that are cut
//! off, count for nothing and are counted. Who writes holds the file's lock; a task, who writes a
//! file of its own, needs none.

use std::collections::{BTreeMap, HashMap};
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::values::Values;
use crate::image::{OutputError, atomic, folder_of, read_bytes};

/// What every line begins with.
const FIRST_KEY: &[u8] = b"{\"jobs\":";
/// Most bytes of a file that is looked at.
const BYTES_MAX: u64 = 1 << 31;

/// What has become of a job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// The file name of the job file.
    pub jobs: String,
    /// Its place among the jobs, from 0.
    pub index: usize,
    /// What it is called.
    pub name: String,
    /// The values of the sweep, by the names of its axes.
    pub values: Values,
    /// Where the image is, as the job file has it.
    pub output: String,
    /// How long it took, from its scene to its file.
    pub seconds: f64,
    /// Why there is no image.
    pub error: Option<String>,
    /// The SHA-256 of the image's file, or of its files in turn.
    pub checksum: Option<String>,
    /// What has decided on the image beside the files that were read.
    pub key: String,
    /// These, with their checksums.
    pub inputs: BTreeMap<String, String>,
}

/// The file, open for more.
pub struct Results {
    path: PathBuf,
    file: File,
    /// Whether the file ends within a line.
    is_cut: bool,
    /// What is there.
    lines: Vec<Line>,
}

/// What a file holds for those who only look at it.
#[derive(Default)]
pub struct Found {
    /// The records in their order.
    pub records: Vec<Record>,
    /// How many lines are none.
    pub broken: usize,
    /// Whether the last one of these ends within: it may be in the writing.
    pub is_cut: bool,
}

/// A line that is there.
struct Line {
    text: String,
    /// Nothing where another program has written it.
    record: Option<Record>,
}

/// Results that cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum ResultsError {
    /// Somebody else writes them.
    #[error("{}: another batch is at work on it; wait for its end", .0.display())]
    Taken(PathBuf),
    /// The system refuses.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The file is something else.
    #[error("{}: holds no results of a batch; name another file, or remove it", .0.display())]
    NotResults(PathBuf),
    /// They cannot be replaced.
    #[error(transparent)]
    Replace(#[from] OutputError),
}

impl Results {
    /// Opens the file, which is made if it is not there, for this process alone.
    ///
    /// # Errors
    /// When it cannot be written, or another process has it.
    pub fn open(path: &Path) -> Result<Self, ResultsError> {
        Self::of(path, lock(path)?)
    }

    /// Opens the file of a task, which is made with its folder if it is not there. Nobody else
    /// writes it, or else lines are lost, and what they tell is done again.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn open_of_task(path: &Path) -> Result<Self, ResultsError> {
        let failed = |source| ResultsError::Write { path: path.to_owned(), source };
        fs::create_dir_all(folder_of(path)).map_err(failed)?;
        Self::of(path, open(path).map_err(failed)?)
    }

    fn of(path: &Path, mut file: File) -> Result<Self, ResultsError> {
        let failed = |source| ResultsError::Write { path: path.to_owned(), source };
        let mut bytes = Vec::new();
        // Who wants no results may name a device, of which there may be no end.
        if file.metadata().is_ok_and(|found| found.is_file()) {
            file.read_to_end(&mut bytes).map_err(failed)?;
        }
        let (lines, is_cut) = lines_of(&bytes);
        // Of the first line there may be but a beginning.
        let holds_results = lines.iter().any(|line| line.record.is_some())
            || FIRST_KEY.starts_with(&bytes[..bytes.len().min(FIRST_KEY.len())]);
        if !holds_results {
            return Err(ResultsError::NotResults(path.to_owned()));
        }
        Ok(Self { path: path.to_owned(), file, is_cut, lines })
    }

    /// What a file holds, to be looked at; nothing if it is not there, or a device.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn look(path: &Path) -> io::Result<Found> {
        match fs::metadata(path) {
            Ok(found) if found.is_file() => {}
            Ok(_) => return Ok(Found::default()),
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Found::default()),
            Err(error) => return Err(error),
        }
        let (lines, is_cut) = lines_of(&read_bytes(path, BYTES_MAX)?);
        let broken = broken_in(&lines);
        let is_cut = is_cut && lines.last().is_some_and(Line::is_broken);
        Ok(Found {
            records: lines.into_iter().filter_map(|it| it.record).collect(),
            broken,
            is_cut,
        })
    }

    /// The latest record of every output, by job file and index, and the number of lines that are
    /// none.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn latest_in(path: &Path) -> io::Result<(Vec<Record>, usize)> {
        let (lines, _) = lines_of(&read_bytes(path, BYTES_MAX)?);
        let broken = broken_in(&lines);
        let records = lines.into_iter().filter_map(|line| line.record);
        let latest: HashMap<String, Record> =
            records.map(|record| (record.output.clone(), record)).collect();
        let mut records: Vec<Record> = latest.into_values().collect();
        records.sort_by(|a, b| (&a.jobs, a.index, &a.output).cmp(&(&b.jobs, b.index, &b.output)));
        Ok((records, broken))
    }

    /// What it held when it was opened.
    pub fn records(&self) -> impl Iterator<Item = Record> {
        self.lines.iter().filter_map(|line| line.record.clone())
    }

    /// How many lines are no records.
    pub fn broken(&self) -> usize {
        broken_in(&self.lines)
    }

    /// Makes these records all that there is, but for those of others that are to stay.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn begin(
        &mut self,
        records: &[Record],
        stays: impl Fn(&Record) -> bool,
    ) -> Result<(), ResultsError> {
        let foreign = |line: &&Line| line.record.as_ref().is_some_and(&stays);
        let kept = self.lines.iter().filter(foreign).map(|line| line.text.clone());
        let kept: Vec<String> = kept.chain(records.iter().map(line_of)).collect();
        let is_same = !self.is_cut && kept.iter().eq(self.lines.iter().map(|line| &line.text));
        if is_same {
            return Ok(());
        }
        let text: String = kept.iter().map(|line| format!("{line}\n")).collect();
        atomic::write(&self.path, text.as_bytes())?;
        self.file = lock(&self.path)?;
        self.is_cut = false;
        Ok(())
    }

    /// Adds a line at once.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn add(&mut self, record: &Record) -> Result<(), ResultsError> {
        let mut text = line_of(record);
        if self.is_cut {
            text.insert(0, '\n');
        }
        text.push('\n');
        let written = self.file.write_all(text.as_bytes());
        self.is_cut = written.is_err();
        written.map_err(|source| ResultsError::Write { path: self.path.clone(), source })
    }
}

fn line_of(record: &Record) -> String {
    // Nothing in a record is no JSON.
    serde_json::to_string(record).unwrap_or_default()
}

fn open(path: &Path) -> io::Result<File> {
    OpenOptions::new().create(true).read(true).append(true).open(path)
}

/// Opens and locks the file that has the name, and not one that has just been replaced.
fn lock(path: &Path) -> Result<File, ResultsError> {
    const TRIED: usize = 100;
    let failed = |source| ResultsError::Write { path: path.to_owned(), source };
    for _ in 0..TRIED {
        let file = open(path).map_err(failed)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(ResultsError::Taken(path.to_owned())),
            // A file system without locks: whoever starts two batches there has been warned.
            Err(TryLockError::Error(_)) => return Ok(file),
        }
        if is_at(&file, path) {
            return Ok(file);
        }
    }
    Err(ResultsError::Taken(path.to_owned()))
}

#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let of = |found: &std::fs::Metadata| (found.dev(), found.ino());
    matches!((file.metadata(), path.metadata()), (Ok(a), Ok(b)) if of(&a) == of(&b))
}

#[cfg(not(unix))]
fn is_at(_: &File, _: &Path) -> bool {
    true
}

impl Line {
    fn is_broken(&self) -> bool {
        self.record.is_none() && !self.text.trim().is_empty()
    }
}

fn broken_in(lines: &[Line]) -> usize {
    lines.iter().filter(|line| line.is_broken()).count()
}

/// The lines, and whether the last has no end; it is one nevertheless if it is whole.
fn lines_of(bytes: &[u8]) -> (Vec<Line>, bool) {
    let text = String::from_utf8_lossy(bytes);
    let line = |text: &str| Line { text: text.to_owned(), record: serde_json::from_str(text).ok() };
    (text.lines().map(line).collect(), bytes.last().is_some_and(|last| *last != b'\n'))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(jobs: &str, output: &str, seconds: f64) -> Record {
        let (error, checksum) = (None, Some("0".to_owned()));
        let (jobs, name, output) = (jobs.to_owned(), String::new(), output.to_owned());
        let (values, inputs, key) = (Values::default(), BTreeMap::new(), String::new());
        Record { jobs, index: 0, name, values, output, seconds, error, checksum, key, inputs }
    }

    #[test]
    fn what_holds_no_results_is_left_alone() {
        let path = std::env::temp_dir().join(format!("sunstone-notes-{}", std::process::id()));
        for (text, is_good) in [
            ("my notes\n", false),
            ("{\"asset\": {}}", false),
            ("", true),
            ("{\"jobs\":\"a", true),
            ("{\"jo", true),
        ] {
            std::fs::write(&path, text).unwrap();
            assert_eq!(Results::open(&path).is_ok(), is_good, "{text}");
            assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
        }
        assert!(line_of(&record("j.toml", "a", 1.0)).as_bytes().starts_with(FIRST_KEY));
        std::fs::remove_file(&path).unwrap();
    }

    #[test]
    fn lines_that_are_cut_off_do_no_harm() {
        let folder = std::env::temp_dir().join(format!("sunstone-results-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("results.jsonl");
        let [a, b, c] = [("a", 1.0), ("b", 2.0), ("a", 3.0)].map(|(o, s)| record("j.toml", o, s));
        let other = record("other.toml", "x", 1.0);
        let text = format!("{}\nnonsense\n{}\n{}", line_of(&a), line_of(&other), line_of(&b));
        // Cut off within the last.
        std::fs::write(&path, &text[..text.len() - 5]).unwrap();
        let mut results = Results::open(&path).unwrap();
        assert!(matches!(Results::open(&path), Err(ResultsError::Taken(_))));
        assert_eq!(results.records().collect::<Vec<_>>(), [a, other.clone()]);
        let found = Results::look(&path).unwrap();
        assert_eq!((results.broken(), found.broken, found.is_cut), (2, 2, true));
        results.add(&b).unwrap();
        results.add(&c).unwrap();
        let found = Results::look(&path).unwrap();
        assert_eq!(found.records[2..], [b.clone(), c.clone()]);
        assert_eq!((found.broken, found.is_cut), (2, false));
        results.begin(std::slice::from_ref(&c), |it| it.jobs == "other.toml").unwrap();
        results.add(&b).unwrap();
        drop(results);
        let lines = [line_of(&other), line_of(&c), line_of(&b)].map(|line| line + "\n").concat();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), lines);
        // Whole, and without an end, as editors may leave it.
        std::fs::write(&path, lines.trim_end()).unwrap();
        let mut results = Results::open(&path).unwrap();
        assert_eq!((results.records().count(), results.broken()), (3, 0));
        results.add(&b).unwrap();
        drop(results);
        assert_eq!(Results::look(&path).unwrap().records.len(), 4);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
