//! What has been done of a batch: by whoever wrote `results.jsonl`, and by tasks, each of which
//! writes a file of its own, so that machines need no locks among each other.

use std::collections::HashMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::{fs, io};

use super::order::{Checksums, Order};
use super::results::{Record, Results};
use super::share::Share;

/// All records of every output, in the order in which they were found.
#[derive(Default)]
pub struct Known(HashMap<String, Vec<Record>>);

impl Known {
    /// These, and those of the tasks beside the results, which are those of the job file of this
    /// name.
    pub fn with_tasks(
        records: impl IntoIterator<Item = Record>,
        results: &Path,
        jobs: &str,
    ) -> Self {
        let mut known = Self::default();
        records.into_iter().for_each(|record| known.add(record));
        // Without the folder there is nothing in it.
        for path in files_of_tasks(results, jobs).unwrap_or_default() {
            Results::look(&path).into_iter().for_each(|record| known.add(record));
        }
        known
    }

    fn add(&mut self, record: Record) {
        self.0.entry(record.output.clone()).or_default().push(record);
    }

    /// What is known of an output.
    fn of(&self, order: &Order) -> &[Record] {
        self.0.get(&order.output_name).map_or(&[], Vec::as_slice)
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

fn files_of_tasks(results: &Path, jobs: &str) -> io::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder_of_tasks(results))? {
        let path = entry?.path();
        if path.file_name().and_then(OsStr::to_str).is_some_and(|it| Share::is_file_name(it, jobs))
        {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

/// Removes the files of tasks, when all that they tell stands in the results, and their folder
/// unless another batch has some in it.
///
/// # Errors
/// When one is left.
pub fn remove_files_of_tasks(results: &Path, jobs: &str) -> io::Result<()> {
    let files = match files_of_tasks(results, jobs) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        files => files?,
    };
    files.iter().try_for_each(fs::remove_file)?;
    match fs::remove_dir(folder_of_tasks(results)) {
        Err(error) if error.kind() != io::ErrorKind::DirectoryNotEmpty => Err(error),
        Ok(()) | Err(_) => Ok(()),
    }
}
