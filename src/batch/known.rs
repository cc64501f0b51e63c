//! What has been done of a batch: by whoever wrote `results.jsonl`, and by tasks, each of which
//! writes a file of its own, so that machines need no locks among each other.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::{fs, io};

use super::order::{Checksums, Order};
use super::results::{Found, Record, Results};
use super::share::Share;
use crate::math::text::counted;

const LINES: [&str; 2] = ["line", "lines"];

/// All records of every output, in the order in which they were found.
#[derive(Default)]
pub struct Known {
    records: HashMap<String, Vec<Record>>,
    /// In words: files, and lines of them, that could not be read.
    unread: Vec<String>,
}

/// Whether files of tasks may be written at this moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tasks {
    /// They are at work.
    AtWork,
    /// They have ended; a line that is cut off will not be whole any more.
    Ended,
}

impl Known {
    /// These, of the file of results.
    pub fn of_results(
        records: impl IntoIterator<Item = Record>,
        results: &Path,
        broken: usize,
    ) -> Self {
        let mut known = Self::default();
        records.into_iter().for_each(|record| known.add(record));
        known.note_broken(results, broken);
        known
    }

    /// What stands in the file of results, for who does not write it.
    pub fn look(results: &Path) -> Self {
        let mut known = Self::default();
        known.read(results, Tasks::AtWork);
        known
    }

    /// Adds those of the tasks beside the results, which are those of the job file of this name.
    pub fn with_tasks(mut self, results: &Path, jobs: &str, tasks: Tasks) -> Self {
        // Without the folder there is nothing in it.
        for path in
            files_of_tasks(results, |name| Share::is_file_name(name, jobs)).unwrap_or_default()
        {
            self.read(&path, tasks);
        }
        self
    }

    fn read(&mut self, path: &Path, tasks: Tasks) {
        match Results::look(path) {
            Ok(Found { records, broken, is_cut }) => {
                records.into_iter().for_each(|record| self.add(record));
                let in_writing = is_cut && tasks == Tasks::AtWork;
                self.note_broken(path, broken - usize::from(in_writing));
            }
            Err(error) => self.unread.push(format!("cannot read {}: {error}", path.display())),
        }
    }

    fn note_broken(&mut self, path: &Path, broken: usize) {
        if broken > 0 {
            let lines = counted(broken, LINES);
            let text = "cannot be read; what only they tell of is done again";
            self.unread.push(format!("{}: {lines} {text}", path.display()));
        }
    }

    fn add(&mut self, record: Record) {
        self.records.entry(record.output.clone()).or_default().push(record);
    }

    /// In words: files, and lines of them, that could not be read.
    pub fn unread(&self) -> &[String] {
        &self.unread
    }

    /// Whether anything is known of the output of this name.
    pub fn tells_of(&self, output_name: &str) -> bool {
        self.records.contains_key(output_name)
    }

    /// What is known of an output.
    fn of(&self, order: &Order) -> &[Record] {
        self.records.get(&order.output_name).map_or(&[], Vec::as_slice)
    }

    /// The record by which an order has been done, with everything still as it says.
    pub fn done(&self, order: &Order, folder: &Path, checksums: &Checksums) -> Option<&Record> {
        self.of(order).iter().rev().find(|record| order.is_done_by(record, folder, checksums))
    }

    /// Why an order has failed, the last time that it did.
    pub fn error(&self, order: &Order) -> Option<&str> {
        let key = order.key();
        let failed = |record: &&Record| record.error.is_some() && record.key == key;
        self.of(order).iter().rev().find(failed)?.error.as_deref()
    }

    /// Whether an order has been done at some time, with the options and the program of now.
    pub fn was_done(&self, order: &Order) -> bool {
        let key = order.key();
        self.of(order).iter().any(|record| record.error.is_none() && record.key == key)
    }
}

/// The folder of the files of tasks, beside the results.
pub fn folder_of_tasks(results: &Path) -> PathBuf {
    let mut folder = results.as_os_str().to_owned();
    folder.push(".tasks");
    folder.into()
}

/// Those whose names are so.
fn files_of_tasks(results: &Path, is_it: impl Fn(&str) -> bool) -> io::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder_of_tasks(results))? {
        let path = entry?.path();
        if path.file_name().and_then(OsStr::to_str).is_some_and(&is_it) {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

/// The file names of all job files that results, or tasks beside them, tell of, each with the
/// outputs that it has made or tried to.
pub fn job_files(results: &Path) -> BTreeMap<String, BTreeSet<String>> {
    let of_tasks = files_of_tasks(results, |name| name.ends_with(".jsonl")).unwrap_or_default();
    let files = std::iter::once(results).chain(of_tasks.iter().map(PathBuf::as_path));
    let found = files.filter_map(|path| Results::look(path).ok()).flat_map(|it| it.records);
    let mut outputs: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for record in found {
        outputs.entry(record.jobs).or_default().insert(record.output);
    }
    // Whatever somebody has written there leads nowhere else.
    outputs.retain(|name, _| Path::new(name).file_name() == Some(OsStr::new(name)));
    outputs
}

/// Removes the files of tasks, when all that they tell stands in the results, and their folder
/// unless another batch has some in it.
///
/// # Errors
/// When one is left.
pub fn remove_files_of_tasks(results: &Path, jobs: &str) -> io::Result<()> {
    let files = match files_of_tasks(results, |name| Share::is_file_name(name, jobs)) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        files => files?,
    };
    files.iter().try_for_each(fs::remove_file)?;
    match fs::remove_dir(folder_of_tasks(results)) {
        Err(error) if error.kind() != io::ErrorKind::DirectoryNotEmpty => Err(error),
        Ok(()) | Err(_) => Ok(()),
    }
}
