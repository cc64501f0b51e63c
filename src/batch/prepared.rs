//! A batch from its file to its end, the same for whoever starts one: what is wrong is told before
//! anything is rendered, what is done is left out, and what becomes of jobs is noted.

use std::collections::{HashMap, HashSet};
use std::fmt::Write;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::check::{Inputs, ReadOptions, orders};
use super::file::{Farm, JobFile};
use super::known::{Known, Tasks, folder_of_tasks, remove_files_of_tasks};
use super::leftovers::Leftovers;
use super::merging::Merging;
use super::order::{Checksums, Order};
use super::results::{Record, Results, ResultsError};
use super::run::{Batch, How, News};
use super::share::Share;
use crate::math::text::excerpt;
use crate::render::threads::Threads;

/// Most troubles of a job file that are listed.
const TOLD_MAX: usize = 1000;
/// The name of results beside a job file.
const RESULTS: &str = "results.jsonl";
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
    /// What of the batch is to be done.
    pub work: Work,
}

/// What of a batch is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Work {
    /// All of it.
    All,
    /// What one task of many does, of images or of so many parts of each, by default as many as the
    /// job file says.
    Share(Share, Option<u32>),
    /// What tasks have done becomes one batch; with the parts of each image.
    Merge(Option<u32>),
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
    file: Place,
    farm: Farm,
    results: PathBuf,
    orders: Vec<Order>,
    /// What a share has of these.
    pieces: Option<Vec<Order>>,
    parts: u32,
    checksums: Checksums,
}

/// Where a job file is.
#[derive(Clone, Debug)]
struct Place {
    /// What its paths are relative to.
    folder: PathBuf,
    /// Its file name.
    jobs: String,
}

/// A batch that has begun: nobody else writes its results.
pub struct Begun {
    asked: Asked,
    file: Place,
    path: PathBuf,
    results: Results,
    parts: u32,
    checksums: Checksums,
    known: Known,
    /// Parts of images, unless it makes some itself.
    leftovers: Option<Leftovers>,
    /// The images that are made of parts although no merge was asked for, by index, with how many
    /// parts they have.
    whole: HashMap<usize, u32>,
    notes: Vec<String>,
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
        // No dot before what lies in the current folder.
        let beside = || match file.folder == Path::new(".") {
            true => PathBuf::from(RESULTS),
            false => file.folder.join(RESULTS),
        };
        let results = asked.results.clone().unwrap_or_else(beside);
        let parts = match asked.work {
            Work::All => 1,
            Work::Share(_, parts) | Work::Merge(parts) => parts.unwrap_or(file.farm.parts),
        };
        let inputs = Inputs { jobs: &asked.jobs, results: &results, parts };
        let orders = orders(&file, &inputs, asked.allow_outside, read).map_err(refused)?;
        let pieces = match asked.work {
            Work::Share(share, _) => {
                let pieces = share.pieces(&orders, parts);
                Some(pieces.map_err(|error| refused(vec![error.to_string()]))?)
            }
            Work::All | Work::Merge(_) => None,
        };
        let jobs = asked.jobs.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let (JobFile { folder, farm, .. }, checksums) = (file, Checksums::default());
        let file = Place { folder, jobs };
        Ok(Self { asked, file, farm, results, orders, pieces, parts, checksums })
    }

    /// The jobs.
    pub fn orders(&self) -> &[Order] {
        &self.orders
    }

    /// What paths are relative to.
    pub fn folder(&self) -> &Path {
        &self.file.folder
    }

    /// Where it is noted what has been done.
    pub fn results(&self) -> &Path {
        &self.results
    }

    /// How a farm divides it, by the job file.
    pub fn farm(&self) -> Farm {
        self.farm
    }

    /// Parts of each image; one where images are rendered as a whole.
    pub fn parts(&self) -> u32 {
        self.parts
    }

    /// What there is to do in its order, with what has become of that which is done; of parts whose
    /// image is there, with that of the image. Before it, in words, what of the results cannot be
    /// read.
    pub fn look(&self) -> (Vec<String>, impl Iterator<Item = (&Order, Option<Record>)>) {
        let known = self.with_tasks(Known::look(&self.results), Tasks::AtWork);
        let unread = known.unread().to_vec();
        (unread, self.all().iter().map(move |order| (order, self.done_by(&known, order).cloned())))
    }

    fn all(&self) -> &[Order] {
        self.pieces.as_deref().unwrap_or(&self.orders)
    }

    fn with_tasks(&self, known: Known, tasks: Tasks) -> Known {
        known.with_tasks(&self.results, &self.file.jobs, tasks)
    }

    /// By what an order is done: a part is not needed either when its image is there.
    fn done_by<'k>(&self, known: &'k Known, order: &Order) -> Option<&'k Record> {
        let of = |order| known.done(order, &self.file.folder, &self.checksums);
        let image = || order.settings.part.and_then(|_| of(&self.orders[order.index]));
        image().or_else(|| of(order))
    }

    /// Takes the file of results for this process, and finds out what is left to do.
    ///
    /// # Errors
    /// When it cannot be written, or another process has it.
    pub fn begin(self) -> Result<Begun, ResultsError> {
        let mut results = match self.asked.work {
            Work::All | Work::Merge(_) => Results::open(&self.results)?,
            // Nobody else writes the file of a share.
            Work::Share(share, _) => {
                let name = share.file_name(&self.file.jobs);
                Results::open_of_task(&folder_of_tasks(&self.results).join(name))?
            }
        };
        let path = &self.results;
        let known = match self.asked.work {
            Work::All => Known::of_results(results.records(), path, results.broken()),
            // What failed is told by tasks; errors in the results are those of former merges.
            Work::Merge(_) => {
                let good = results.records().filter(|it| it.error.is_none());
                Known::of_results(good, path, results.broken())
            }
            Work::Share(..) => Known::look(path),
        };
        let tasks = match self.asked.work {
            Work::All | Work::Merge(_) => Tasks::Ended,
            Work::Share(..) => Tasks::AtWork,
        };
        let known = self.with_tasks(known, tasks);
        let (done, left) = self.divided(&known);
        let mut notes = known.unread().iter().map(|text| format!("warning: {text}")).collect();
        let (leftovers, whole) = self.leftovers(&known, &left, &mut notes);
        if self.pieces.is_none() {
            let records: Vec<Record> = done.iter().map(|(_, record)| record.clone()).collect();
            let outputs: HashSet<&str> = self.orders.iter().map(|it| &*it.output_name).collect();
            // Of a job file that has been renamed, what is noted goes with it.
            let is_there = |record: &Record| self.file.folder.join(&record.jobs).is_file();
            results.begin(&records, |record| {
                record.jobs != self.file.jobs
                    && (!outputs.contains(&*record.output) || is_there(record))
            })?;
        }
        let Self { asked, file, results: path, parts, checksums, .. } = self;
        Ok(Begun {
            asked,
            file,
            path,
            results,
            parts,
            checksums,
            known,
            leftovers,
            whole,
            notes,
            done,
            left,
        })
    }

    /// Parts of images that are of use, or in the way; the images that are left and can be made of
    /// them without a merge; and what there is to say of that.
    fn leftovers(
        &self,
        known: &Known,
        left: &[Order],
        notes: &mut Vec<String>,
    ) -> (Option<Leftovers>, HashMap<usize, u32>) {
        let mut leftovers = match self.asked.work {
            Work::Share(..) => return (None, HashMap::new()),
            Work::Merge(_) => return (Some(Leftovers::find(&self.orders)), HashMap::new()),
            Work::All => Leftovers::find(&self.orders),
        };
        let strange = leftovers.keep_noted(&self.orders, known);
        let whole = leftovers.whole(left, known, (&self.file.folder, &self.checksums));
        if let Some(parts) = leftovers.incomplete(left, &whole) {
            notes.push(format!(
                "note: tasks have rendered {parts} and not all of any: these are rendered as a \
                 whole, and the parts removed; to use them, end this, run the tasks that are left \
                 (--task) and then --merge"
            ));
        }
        if let [first, more @ ..] = &strange[..] {
            let more = match more.len() {
                0 => String::new(),
                count => format!(" and {count} more parts"),
            };
            notes.push(format!(
                "note: beside the images are left: {}{more}; no task has noted that it made them: \
                 remove them if they are of no use",
                first.display()
            ));
        }
        (Some(leftovers), whole)
    }

    /// The orders that have been done, with their records, and the others.
    fn divided(&self, known: &Known) -> (Vec<(Order, Record)>, Vec<Order>) {
        let (mut done, mut left) = (Vec::new(), Vec::new());
        for order in self.all() {
            match self.done_by(known, order) {
                Some(record) => {
                    let Order { index, name, values, .. } = order.clone();
                    let jobs = self.file.jobs.clone();
                    done.push((
                        order.clone(),
                        Record { jobs, index, name, values, ..record.clone() },
                    ));
                }
                None => left.push(order.clone()),
            }
        }
        (done, left)
    }
}

impl Begun {
    /// What there is to know before it goes on, in words behind "note: " or "warning: ".
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

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
        let Self { asked, file, path, results, parts, checksums, known, .. } = self;
        let Self { leftovers, whole, done, left, .. } = self;
        let of =
            |parts: &u32| leftovers.as_ref().map(|there| Merging { known, parts: *parts, there });
        let merging = of(parts);
        let whole = whole.iter().filter_map(|(index, parts)| Some((*index, of(parts)?))).collect();
        let how = match (&merging, asked.work) {
            (Some(merging), Work::Merge(_)) => How::Merging(merging),
            (_, Work::Share(..)) => How::Again,
            (_, Work::All | Work::Merge(_)) => How::Once(&whole),
        };
        let batch = Batch {
            orders: left,
            how,
            jobs: file.jobs.clone(),
            folder: file.folder.clone(),
            threads: Arc::clone(threads),
            allow_outside: asked.allow_outside,
            checksums,
            facts,
        };
        let mut notes = Notes { results, leftovers: leftovers.as_ref(), made: 0, is_told: false };
        let left_over = done.iter().filter_map(|(order, _)| notes.removed(order));
        if left_over.map(&mut hear).any(|answer| answer.is_break()) {
            return;
        }
        batch.run(|news| {
            let more = notes.note(&news).map_or(ControlFlow::Continue(()), &mut hear);
            if hear(news).is_break() { ControlFlow::Break(()) } else { more }
        });
        // What tasks have noted stands in the results now.
        if leftovers.is_some()
            && notes.made == left.len()
            && let Err(error) = remove_files_of_tasks(path, &file.jobs)
        {
            let _ = hear(News::Left(error));
        }
    }
}

/// What is written down of a batch on its way.
struct Notes<'a> {
    results: &'a mut Results,
    leftovers: Option<&'a Leftovers>,
    /// Images, or parts, that were made and noted.
    made: usize,
    /// Whether it has been told that something could not be noted.
    is_told: bool,
}

impl Notes<'_> {
    /// Notes what has become of a job; says what went wrong in that.
    fn note(&mut self, news: &News) -> Option<News<'static>> {
        let News::Ended { order, record, .. } = news else { return None };
        match self.results.add(record) {
            Ok(()) if record.error.is_none() => {
                self.made += 1;
                self.removed(order)
            }
            Ok(()) => None,
            Err(error) => {
                let was_told = std::mem::replace(&mut self.is_told, true);
                (!was_told).then_some(News::Unwritten(error))
            }
        }
    }

    /// Removes what is no longer needed when an image is there; says so if it cannot be.
    fn removed(&self, order: &Order) -> Option<News<'static>> {
        self.leftovers?.remove(&order.output).err().map(News::Left)
    }
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
