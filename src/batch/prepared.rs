//! A batch from its file to its end, the same for whoever starts one: what is wrong is told before
//! anything is rendered, what is done is left out, and what becomes of jobs is noted.

use std::collections::HashMap;
use std::fmt::Write;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::check::{Inputs, ReadOptions, orders};
use super::file::JobFile;
use super::order::{Checksums, Order};
use super::results::{Record, Results, ResultsError};
use super::run::{Batch, News};
use crate::math::text::excerpt;
use crate::render::threads::Threads;

/// Most troubles of a job file that are listed.
const TOLD_MAX: usize = 1000;
/// Most characters of a path in what is said of it.
const PATH: usize = 2000;

/// What is asked for.
#[derive(Clone, Debug)]
pub struct Asked {
    /// The job file.
    pub jobs: PathBuf,
    /// Where it is noted what has been done, if not in `results.jsonl` beside the job file.
    pub results: Option<PathBuf>,
    /// Whether scenes may read, and jobs write, files outside their folders.
    pub allow_outside: bool,
}

/// All that is wrong with a job file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused {
    /// The job file.
    pub path: PathBuf,
    /// In words.
    pub wrong: Vec<String>,
}

/// A batch that may begin: what the file alone shows is good.
pub struct Prepared {
    asked: Asked,
    /// What paths are relative to.
    folder: PathBuf,
    /// The file name of the job file.
    jobs: String,
    results: PathBuf,
    orders: Vec<Order>,
    checksums: Checksums,
}

/// A batch that has begun: nobody else writes its results.
pub struct Begun {
    asked: Asked,
    folder: PathBuf,
    jobs: String,
    results: Results,
    checksums: Checksums,
    done: Vec<(Order, Record)>,
    left: Vec<Order>,
}

impl Prepared {
    /// Reads a job file and checks all that it alone shows.
    ///
    /// # Errors
    /// All that is wrong.
    pub fn read(asked: Asked, read: ReadOptions) -> Result<Self, Refused> {
        let refused = |wrong| Refused { path: asked.jobs.clone(), wrong };
        let file = JobFile::read(&asked.jobs).map_err(|wrong| refused(vec![wrong]))?;
        let beside = || file.folder.join("results.jsonl");
        let results = asked.results.clone().unwrap_or_else(beside);
        let inputs = Inputs { jobs: &asked.jobs, results: &results };
        let orders = orders(&file, &inputs, asked.allow_outside, read).map_err(refused)?;
        let jobs = asked.jobs.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let checksums = Checksums::default();
        Ok(Self { asked, folder: file.folder, jobs, results, orders, checksums })
    }

    /// The jobs in their order, with what has become of those that are done.
    pub fn look(&self) -> impl Iterator<Item = (&Order, Option<Record>)> {
        let mut records = Results::look(&self.results);
        self.orders.iter().map(move |order| {
            let record = records.remove(&order.output_name);
            let is_done = |record: &Record| order.is_done_by(record, &self.folder, &self.checksums);
            (order, record.filter(is_done))
        })
    }

    /// Takes the file of results for this process, and finds out what is left to do.
    ///
    /// # Errors
    /// When it cannot be written, or another process has it.
    pub fn begin(self) -> Result<Begun, ResultsError> {
        let Self { asked, folder, jobs, results, orders, checksums } = self;
        let mut results = Results::open(&results)?;
        let (done, left) = divided(orders, &results.records(), |order, record| {
            order.is_done_by(record, &folder, &checksums)
        });
        let name_anew = |(order, record): (Order, Record)| {
            let (jobs, index) = (jobs.clone(), order.index);
            let (name, values) = (order.name.clone(), order.values.clone());
            (order, Record { jobs, index, name, values, ..record })
        };
        let done: Vec<_> = done.into_iter().map(name_anew).collect();
        let records: Vec<Record> = done.iter().map(|(_, record)| record.clone()).collect();
        results.begin(&jobs, &records)?;
        Ok(Begun { asked, folder, jobs, results, checksums, done, left })
    }
}

impl Begun {
    /// The jobs that were done before, and what had become of them.
    pub fn done(&self) -> &[(Order, Record)] {
        &self.done
    }

    /// The jobs that are left to do.
    pub fn left(&self) -> &[Order] {
        &self.left
    }

    /// What all of these take, by the reckoning of [`Order::cost`].
    pub fn cost(&self) -> u64 {
        self.left.iter().map(Order::cost).fold(0, u64::saturating_add)
    }

    /// Does what is left, and notes what becomes of every job when it does. `facts` are what images
    /// are to say of themselves; `hear` is told what happens, on the thread of the caller, and says
    /// whether to go on: if not, jobs in work are dropped.
    pub fn run(
        &mut self,
        threads: &Arc<Threads>,
        facts: Vec<(String, String)>,
        mut hear: impl FnMut(News) -> ControlFlow<()>,
    ) {
        let batch = Batch {
            orders: &self.left,
            jobs: self.jobs.clone(),
            folder: self.folder.clone(),
            threads: Arc::clone(threads),
            allow_outside: self.asked.allow_outside,
            checksums: &self.checksums,
            facts,
        };
        let (results, mut is_told) = (&mut self.results, false);
        batch.run(|news| {
            let noted = match &news {
                News::Ended { record, .. } => results.add(record),
                News::Progress(_) | News::Unwritten(_) => Ok(()),
            };
            let told = match noted {
                Err(error) if !is_told => {
                    is_told = true;
                    hear(News::Unwritten(error))
                }
                Ok(()) | Err(_) => ControlFlow::Continue(()),
            };
            match (hear(news), told) {
                (ControlFlow::Continue(()), ControlFlow::Continue(())) => ControlFlow::Continue(()),
                _ => ControlFlow::Break(()),
            }
        });
    }
}

/// The orders that have been done, with their records, and the others.
fn divided(
    orders: Vec<Order>,
    records: &HashMap<String, Record>,
    is_done: impl Fn(&Order, &Record) -> bool,
) -> (Vec<(Order, Record)>, Vec<Order>) {
    let (mut done, mut left) = (Vec::new(), Vec::new());
    for order in orders {
        match records.get(&order.output_name) {
            Some(record) if is_done(&order, record) => done.push((order, record.clone())),
            _ => left.push(order),
        }
    }
    (done, left)
}

impl std::error::Error for Refused {}

impl std::fmt::Display for Refused {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let path = excerpt(&Path::display(&self.path).to_string(), PATH);
        let wrong = &self.wrong;
        if let [only] = &wrong[..] {
            return write!(f, "{path}: {only}");
        }
        let mut text = format!("{path}: {} things are wrong", wrong.len());
        for trouble in wrong.iter().take(TOLD_MAX) {
            write!(text, "\n  {trouble}")?;
        }
        if wrong.len() > TOLD_MAX {
            write!(text, "\n  and {} more", wrong.len() - TOLD_MAX)?;
        }
        f.write_str(&text)
    }
}
