//! Jobs side by side: every thread takes the next when it is done with one, and all render on the
//! same threads, so that these are busy whatever the sizes of the jobs.

use std::collections::{BTreeMap, HashMap};
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};
use std::{fs, io, thread};

use super::crash::{Failures, InWork};
use super::gate::Gate;
use super::merging::{Merged, Merging, MergingError};
use super::order::{Checksums, Order};
use super::results::{Record, ResultsError};
use super::scenes::{LARGE, Scenes};
use crate::files;
use crate::film::Developed;
use crate::image::{self, OutputError};
use crate::render::doubts::doubts;
use crate::render::memory::triangles_of;
use crate::render::threads::Threads;
use crate::render::{PartError, PlacedWorld, RenderError, Renderer, Stop};

/// Pixels in work for every thread, beyond which jobs wait for others: their films take memory.
const PIXELS_OF_THREAD: u64 = 1 << 16;
/// Pixels of an image that is packed by one thread.
const SMALL: u64 = 1 << 13;
/// Jobs in work beside one for every thread, so that threads render while files are written.
const MORE: usize = 2;
/// Time between two looks at whether to end.
const POLL: Duration = Duration::from_millis(50);
/// Time before a second try: a server may have been busy for a moment.
const PAUSE: Duration = Duration::from_secs(3);
/// Bytes that a pixel takes in the file of a part, or more.
const BYTES_OF_PIXEL: u64 = 64;

/// What all jobs of a batch share.
pub struct Batch<'a> {
    /// The jobs to be done, or parts of them.
    pub orders: &'a [Order],
    /// How.
    pub how: How<'a>,
    /// The file name of the job file.
    pub jobs: String,
    /// What its paths are relative to.
    pub folder: PathBuf,
    /// What renders.
    pub threads: Arc<Threads>,
    /// Whether scenes may read files outside their folders.
    pub allow_outside: bool,
    /// Checksums of what scenes are read from.
    pub checksums: &'a Checksums,
    /// What images are to say of themselves: keys and values.
    pub facts: Vec<(String, String)>,
}

/// How jobs are done.
#[derive(Clone, Copy)]
pub enum How<'a> {
    /// Rendered, but for those, by index, of which tasks have rendered all parts.
    Once(&'a HashMap<usize, Merging<'a>>),
    /// Rendered, and once more where that fails for what may pass.
    Again,
    /// Put together of what others have rendered.
    Merging(&'a Merging<'a>),
}

/// What a batch tells on its way.
pub enum News<'a> {
    /// A job has come to an end.
    Ended {
        /// Which.
        order: &'a Order,
        /// What has become of it.
        record: Box<Record>,
        /// What is to be known of its image and its scene.
        warnings: Vec<String>,
        /// Whether it has failed and may not when it is tried another time, or elsewhere.
        may_pass: bool,
        /// Whether it has failed and what has its name is of a former run.
        is_former: bool,
    },
    /// A job has failed and is tried again.
    Again {
        /// Which.
        order: &'a Order,
        /// Why.
        error: String,
    },
    /// So many samples have been rendered, by the reckoning of [`Order::cost`].
    Progress(u64),
    /// What has become of a job could not be noted. It is told once.
    Unwritten(ResultsError),
    /// What is no longer needed could not be removed.
    Left(io::Error),
}

/// Why a job has no image.
#[derive(Debug, thiserror::Error)]
enum JobError {
    #[error(transparent)]
    Render(#[from] RenderError),
    #[error(transparent)]
    Image(#[from] OutputError),
    #[error("cannot read what the scene is made of: {0}")]
    Inputs(io::Error),
    #[error("cannot read the image again: {0}")]
    Again(io::Error),
    #[error("the output is a file of the scene, {}", .0.display())]
    OverScene(PathBuf),
    #[error(transparent)]
    Part(#[from] PartError),
    #[error(transparent)]
    Merging(#[from] MergingError),
    #[error("the program failed: {0}")]
    Failed(String),
}

impl JobError {
    /// Whether the same job may not fail a moment later, or on another machine.
    fn may_pass(&self) -> bool {
        match self {
            Self::Render(RenderError::Scene(error)) => error.may_pass(),
            Self::Render(RenderError::Memory(_)) => true,
            Self::Image(error)
            | Self::Part(PartError::File(error))
            | Self::Merging(MergingError::Part(PartError::File(error))) => {
                error.of_system().is_some_and(|error| files::may_pass(error.kind()))
            }
            Self::Inputs(error) | Self::Again(error) => files::may_pass(error.kind()),
            Self::Render(RenderError::Settings(_))
            | Self::OverScene(_)
            | Self::Part(_)
            | Self::Merging(_)
            | Self::Failed(_) => false,
        }
    }
}

/// What is known of a job in work.
#[derive(Default)]
struct Account {
    /// Samples of it that have been counted.
    counted: AtomicU64,
    inputs: BTreeMap<String, String>,
    warnings: Vec<String>,
    /// What others have spent on it.
    seconds: f64,
}

/// What is in work.
struct Work<'a> {
    batch: &'a Batch<'a>,
    scenes: Scenes,
    gate: Gate,
    /// The jobs in the order in which they are begun.
    queue: Vec<&'a Order>,
    /// How many of them are done while no other is.
    alone: usize,
    /// When those are done.
    are_done: OnceLock<()>,
    next: AtomicUsize,
    /// Samples so far.
    samples: AtomicU64,
    /// Ends all of it.
    stop: Stop,
}

impl Batch<'_> {
    /// Does all jobs. `hear` is told what happens, on the thread of the caller, and says whether to
    /// go on; if not, jobs in work are dropped.
    pub fn run(&self, mut hear: impl FnMut(News) -> ControlFlow<()>) {
        let count = self.threads.count();
        let is_suspect = |order: &&Order| Failures::known().is_suspect(&order.output_name);
        let (mut queue, others): (Vec<_>, Vec<_>) = self.orders.iter().partition(is_suspect);
        let alone = queue.len();
        queue.extend(others);
        let work = Work {
            batch: self,
            scenes: Scenes::new(self.allow_outside),
            gate: Gate::new(count as u64 * PIXELS_OF_THREAD),
            queue,
            alone,
            are_done: OnceLock::new(),
            next: AtomicUsize::new(0),
            samples: AtomicU64::new(0),
            stop: Stop::default(),
        };
        let (sender, told) = mpsc::channel();
        thread::scope(|scope| {
            for started in 0..(count + MORE).min(self.orders.len()) {
                let (work, of_thread) = (&work, sender.clone());
                let take = move || work.take_all(started == 0, &of_thread);
                if thread::Builder::new().spawn_scoped(scope, take).is_err() {
                    // The system has no more of them.
                    if started == 0 {
                        work.take_all(true, &sender);
                    }
                    break;
                }
            }
            drop(sender);
            loop {
                let mut answer = match told.recv_timeout(POLL) {
                    Ok(news) => hear(news),
                    Err(RecvTimeoutError::Timeout) => ControlFlow::Continue(()),
                    Err(RecvTimeoutError::Disconnected) => break,
                };
                if answer.is_continue() {
                    answer = hear(News::Progress(work.samples.load(Ordering::Relaxed)));
                }
                if answer.is_break() {
                    work.stop.give_up();
                }
            }
        });
    }
}

impl<'a> Work<'a> {
    /// Takes one job after the other. The thread that is the first does what is to be done alone.
    fn take_all(&self, is_first: bool, sender: &Sender<News<'a>>) {
        if is_first {
            self.take_until(self.alone, sender);
            let _ = self.are_done.set(());
        }
        self.are_done.wait();
        self.take_until(self.queue.len(), sender);
    }

    /// Takes one job after the other, until so many have been begun.
    fn take_until(&self, end: usize, sender: &Sender<News<'a>>) {
        while !self.stop.is_set() {
            let is_left = |next| (next < end).then_some(next + 1);
            let relaxed = Ordering::Relaxed;
            let Ok(index) = self.next.fetch_update(relaxed, relaxed, is_left) else { return };
            if let Some(news) = self.done(self.queue[index], sender) {
                // Nobody hears of it any more if the batch is over.
                let _ = sender.send(news);
            }
        }
    }

    /// Does a job, and says what has become of it; nothing if it was ended from outside, which is
    /// as if it had not begun.
    fn done(&self, order: &'a Order, sender: &Sender<News<'a>>) -> Option<News<'a>> {
        let start = Instant::now();
        let mut account = Account::default();
        let mut made = self.try_to_make(order, &mut account);
        if let (How::Again, Err(error)) = (self.batch.how, &made)
            && error.may_pass()
        {
            let _ = sender.send(News::Again { order, error: error.to_string() });
            self.pause();
            if self.stop.is_set() {
                return None;
            }
            self.scenes.forget(&order.scene);
            let counted = account.counted;
            account = Account { counted, ..Account::default() };
            made = self.try_to_make(order, &mut account);
        }
        let Account { counted, inputs, warnings, seconds } = account;
        let left = order.cost().saturating_sub(counted.into_inner());
        self.samples.fetch_add(left, Ordering::Relaxed);
        let may_pass = made.as_ref().is_err_and(JobError::may_pass);
        let (error, checksum) = match made {
            Ok(checksum) => (None, Some(checksum?)),
            Err(error) => (Some(error.to_string()), None),
        };
        let record = Record {
            jobs: self.batch.jobs.clone(),
            index: order.index,
            name: order.name.clone(),
            values: order.values.clone(),
            output: order.output_name.clone(),
            seconds: seconds + start.elapsed().as_secs_f64(),
            error,
            checksum,
            key: order.key(),
            inputs,
        };
        let is_former = record.error.is_some() && order.is_there();
        Some(News::Ended { order, record: Box::new(record), warnings, may_pass, is_former })
    }

    /// Waits, unless the batch is over.
    fn pause(&self) {
        let start = Instant::now();
        while start.elapsed() < PAUSE && !self.stop.is_set() {
            thread::sleep(POLL);
        }
    }

    /// Makes the file of a job; returns its checksum, or nothing if it was stopped.
    fn try_to_make(
        &self,
        order: &Order,
        account: &mut Account,
    ) -> Result<Option<String>, JobError> {
        if let Some(words) = Failures::known().words(&order.output_name) {
            return Err(JobError::Failed(words.to_owned()));
        }
        let _in_work = InWork::new(&order.output_name);
        match self.batch.how {
            How::Once(whole) => match whole.get(&order.index) {
                Some(merging) => self.merge_or_render(merging, order, account),
                None => self.render(order, account),
            },
            How::Again => self.render(order, account),
            How::Merging(merging) => self.merge(merging, order, account).map(Some),
        }
    }

    fn render(&self, order: &Order, account: &mut Account) -> Result<Option<String>, JobError> {
        let Account { counted, inputs, warnings, .. } = account;
        let batch = self.batch;
        let start = Instant::now();
        let (world, permit) = self.scenes.world(order, &self.gate)?;
        if self.stop.is_set() {
            return Ok(None);
        }
        warnings.extend(world.warnings().map(|warning| format!("warning: {warning}")));
        warnings
            .extend(order.asked.iter().map(|asked| format!("note: as the scene asks: {asked}")));
        let files = world.world().files();
        *inputs = batch.checksums.of_all(files, &batch.folder).map_err(JobError::Inputs)?;
        refuse_overwriting(order, files)?;
        let film = world.film(&order.settings).map_err(RenderError::from)?;
        let [width, height] = film.cut.size;
        // Tables of large scenes take a quarter of what their shapes do, for every job in work.
        let room = match triangles_of(world.world()) {
            LARGE.. => u64::MAX,
            _ => u64::from(width) * u64::from(height),
        };
        let _permit = permit.unwrap_or_else(|| self.gate.enter(room));
        let renderer = Renderer::new(&world, &order.settings)?;
        let lacks = world.lacks(renderer.settings())?;
        warnings.extend(lacks.iter().map(|lack| format!("warning: {lack}")));
        let mut renderer = renderer.on(&batch.threads).stopped_by(&self.stop);
        renderer.run(|so_far| {
            let share = f64::from(so_far.samples) / f64::from(so_far.total);
            let now = (order.cost() as f64 * share) as u64;
            let before = counted.fetch_max(now, Ordering::Relaxed);
            self.samples.fetch_add(now.saturating_sub(before), Ordering::Relaxed);
            ControlFlow::Continue(())
        });
        if self.stop.is_set() {
            return Ok(None);
        }
        make_folder_of(order)?;
        if order.settings.part.is_some() {
            renderer.save(&order.output)?;
        } else {
            let image = self.finished(renderer, &world, warnings);
            batch.save(image, order, start.elapsed(), room <= SMALL)?;
        }
        order.checksum().map(Some).map_err(JobError::Again)
    }

    /// The image of a render that is done; adds what may be wrong with it to the warnings.
    fn finished(
        &self,
        renderer: Renderer,
        world: &PlacedWorld,
        warnings: &mut Vec<String>,
    ) -> Developed<'static> {
        let (settings, doubts) = (renderer.settings().clone(), doubts(&renderer, world));
        let mut image = renderer.finish_rows();
        if !settings.variance {
            image.drop_variance();
        }
        warnings.extend(doubts.note().iter().map(|note| format!("note: {note}")));
        let doubts = doubts.about(&image);
        warnings.extend(doubts.iter().map(|doubt| format!("warning: {doubt}")));
        image
    }

    /// Makes an image of its parts, which were there a moment ago; else renders it.
    fn merge_or_render(
        &self,
        merging: &Merging,
        order: &Order,
        account: &mut Account,
    ) -> Result<Option<String>, JobError> {
        let made = self.merge(merging, order, account);
        if let Err(JobError::Merging(_)) = made {
            return self.render(order, account);
        }
        made.map(Some)
    }

    /// Makes the image of a job of its parts; returns its checksum.
    fn merge(
        &self,
        merging: &Merging,
        order: &Order,
        account: &mut Account,
    ) -> Result<String, JobError> {
        let batch = self.batch;
        let first = merging.file_of_first(order)?;
        let bytes = fs::metadata(first).map_or(0, |found| found.len());
        let _permit = self.gate.enter(bytes / BYTES_OF_PIXEL);
        let Merged { image, inputs, seconds } =
            merging.image(order, &batch.folder, batch.checksums)?;
        let files: Vec<PathBuf> = inputs.keys().map(|name| batch.folder.join(name)).collect();
        refuse_overwriting(order, &files)?;
        make_folder_of(order)?;
        let is_small = bytes / BYTES_OF_PIXEL <= SMALL;
        batch.save(image, order, Duration::from_secs_f64(seconds), is_small)?;
        (account.inputs, account.seconds) = (inputs, seconds);
        order.checksum().map_err(JobError::Again)
    }
}

impl Batch<'_> {
    /// Writes an image that took so long.
    fn save(
        &self,
        mut image: Developed,
        order: &Order,
        time: Duration,
        is_small: bool,
    ) -> Result<(), JobError> {
        self.add_metadata(&mut image.metadata, order, time);
        let save = || image::save(&image, &order.output);
        // Of a small one, waiting for the disk takes longer than packing, and no thread is to wait.
        match is_small {
            true => save(),
            false => self.threads.run(save),
        }?;
        Ok(())
    }

    /// Adds what the renderer does not know.
    fn add_metadata(&self, to: &mut Vec<(String, String)>, order: &Order, time: Duration) {
        let edits = order.edits.iter().map(|edit| format!("{} = {}", edit.target, edit.value));
        let own = [
            ("scene", order.scene.display().to_string()),
            ("job", order.label()),
            ("edits", edits.collect::<Vec<_>>().join("; ")),
            ("seconds", format!("{:.3}", time.as_secs_f64())),
        ];
        let own = own
            .into_iter()
            .filter(|(_, value)| !value.is_empty())
            .map(|(key, value)| (key.to_owned(), value));
        to.splice(0..0, own.chain(self.facts.iter().cloned()));
    }
}

fn make_folder_of(order: &Order) -> Result<(), JobError> {
    let failed = |error| OutputError::write(&order.output, error);
    Ok(fs::create_dir_all(image::folder_of(&order.output)).map_err(failed)?)
}

/// Refuses to replace what the scene was read from.
fn refuse_overwriting(order: &Order, inputs: &[PathBuf]) -> Result<(), JobError> {
    for file in order.files()? {
        let Ok(target) = fs::canonicalize(&file) else { continue };
        let is_it = |input: &&PathBuf| fs::canonicalize(input).is_ok_and(|input| input == target);
        if let Some(input) = inputs.iter().find(is_it) {
            return Err(JobError::OverScene(input.clone()));
        }
    }
    Ok(())
}
