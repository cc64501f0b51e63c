//! Jobs side by side: every thread takes the next when it is done with one, and all render on the
//! same threads, so that these are busy whatever the sizes of the jobs.

use std::any::Any;
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::time::{Duration, Instant};
use std::{fs, io, thread};

use super::gate::Gate;
use super::order::{Checksums, Order, checksum_of_image};
use super::results::{Record, ResultsError};
use super::scenes::{LARGE, Scenes};
use crate::image::{self, OutputError};
use crate::render::doubts::doubts;
use crate::render::memory::triangles_of;
use crate::render::threads::Threads;
use crate::render::{RenderError, Renderer, Stop};

/// Pixels in work for every thread, beyond which jobs wait for others: their films take memory.
const PIXELS_OF_THREAD: u64 = 1 << 16;
/// Pixels of an image that is packed by one thread.
const SMALL: u64 = 1 << 13;
/// Jobs in work beside one for every thread, so that threads render while files are written.
const MORE: usize = 2;
/// Time between two looks at whether to end.
const POLL: Duration = Duration::from_millis(50);

/// What all jobs of a batch share.
pub struct Batch<'a> {
    /// The jobs to be done.
    pub orders: &'a [Order],
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
    },
    /// So many samples have been rendered, by the reckoning of [`Order::cost`].
    Progress(u64),
    /// What has become of a job could not be noted. It is told once.
    Unwritten(ResultsError),
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
    #[error("the program failed: {0}")]
    Panic(String),
}

/// What a thread has brought about.
enum Outcome<'a> {
    Ended(&'a Order, Box<Record>, Vec<String>),
    /// Ended from outside: as if it had not begun.
    Dropped,
}

/// What is in work.
struct Work<'a> {
    batch: &'a Batch<'a>,
    scenes: Scenes,
    gate: Gate,
    next: AtomicUsize,
    /// Samples so far.
    done: AtomicU64,
    /// Ends all of it.
    stop: Stop,
}

impl Batch<'_> {
    /// Does all jobs. `hear` is told what happens, on the thread of the caller, and says whether to
    /// go on; if not, jobs in work are dropped.
    pub fn run(&self, mut hear: impl FnMut(News) -> ControlFlow<()>) {
        let count = self.threads.count();
        let work = Work {
            batch: self,
            scenes: Scenes::new(self.allow_outside),
            gate: Gate::new(count as u64 * PIXELS_OF_THREAD),
            next: AtomicUsize::new(0),
            done: AtomicU64::new(0),
            stop: Stop::default(),
        };
        let (sender, news) = mpsc::channel();
        thread::scope(|scope| {
            for started in 0..(count + MORE).min(self.orders.len()) {
                let (work, of_thread) = (&work, sender.clone());
                let take = move || work.take_all(&of_thread);
                if thread::Builder::new().spawn_scoped(scope, take).is_err() {
                    // The system has no more of them.
                    if started == 0 {
                        work.take_all(&sender);
                    }
                    break;
                }
            }
            drop(sender);
            loop {
                let mut told = match news.recv_timeout(POLL) {
                    Ok(Outcome::Ended(order, record, warnings)) => {
                        hear(News::Ended { order, record, warnings })
                    }
                    Ok(Outcome::Dropped) | Err(RecvTimeoutError::Timeout) => {
                        ControlFlow::Continue(())
                    }
                    Err(RecvTimeoutError::Disconnected) => break,
                };
                if told.is_continue() {
                    told = hear(News::Progress(work.done.load(Ordering::Relaxed)));
                }
                if told.is_break() {
                    work.stop.give_up();
                }
            }
        });
    }
}

impl<'a> Work<'a> {
    /// Takes one job after the other.
    fn take_all(&self, sender: &Sender<Outcome<'a>>) {
        while !self.stop.is_set() {
            let index = self.next.fetch_add(1, Ordering::Relaxed);
            let Some(order) = self.batch.orders.get(index) else { return };
            // Nobody hears of it any more if the batch is over.
            let _ = sender.send(self.account(order));
        }
    }

    /// Does a job, and says what has become of it.
    fn account(&self, order: &'a Order) -> Outcome<'a> {
        let start = Instant::now();
        let counted = AtomicU64::new(0);
        let mut inputs = BTreeMap::new();
        let mut warnings = Vec::new();
        let made = catch_unwind(AssertUnwindSafe(|| {
            self.make(order, &counted, &mut inputs, &mut warnings)
        }));
        let made = made.unwrap_or_else(|panic| Err(JobError::Panic(words_of(&*panic))));
        let left = order.cost().saturating_sub(counted.load(Ordering::Relaxed));
        self.done.fetch_add(left, Ordering::Relaxed);
        let (error, checksum) = match made {
            Ok(Some(checksum)) => (None, Some(checksum)),
            Ok(None) => return Outcome::Dropped,
            Err(error) => (Some(error.to_string()), None),
        };
        let record = Record {
            jobs: self.batch.jobs.clone(),
            index: order.index,
            name: order.name.clone(),
            values: order.values.clone(),
            output: order.output_name.clone(),
            seconds: start.elapsed().as_secs_f64(),
            error,
            checksum,
            key: order.key(),
            inputs,
        };
        Outcome::Ended(order, Box::new(record), warnings)
    }

    /// Makes the image of a job; returns its checksum, or nothing if it was stopped.
    fn make(
        &self,
        order: &Order,
        counted: &AtomicU64,
        inputs: &mut BTreeMap<String, String>,
        warnings: &mut Vec<String>,
    ) -> Result<Option<String>, JobError> {
        let batch = self.batch;
        let start = Instant::now();
        let (world, permit) = self.scenes.world(order, &self.gate)?;
        if self.stop.is_set() {
            return Ok(None);
        }
        warnings.extend(world.warnings().map(|warning| format!("warning: {warning}")));
        let files = world.world().files();
        *inputs = batch.checksums.of_all(files, &batch.folder).map_err(JobError::Inputs)?;
        refuse_overwriting(&order.output, files)?;
        let [width, height] = world.film_size(&order.settings).map_err(RenderError::from)?;
        // Tables of large scenes take a quarter of what their shapes do, for every job in work.
        let room = match triangles_of(world.world()) {
            LARGE.. => u64::MAX,
            _ => u64::from(width) * u64::from(height),
        };
        let _permit = permit.unwrap_or_else(|| self.gate.enter(room));
        let renderer = Renderer::new(&world, &order.settings)?;
        let mut renderer = renderer.on(&batch.threads).stopped_by(&self.stop);
        renderer.run(|so_far| {
            let share = f64::from(so_far.samples) / f64::from(so_far.total);
            let now = (order.cost() as f64 * share) as u64;
            let before = counted.swap(now, Ordering::Relaxed);
            self.done.fetch_add(now.saturating_sub(before), Ordering::Relaxed);
            ControlFlow::Continue(())
        });
        if self.stop.is_set() {
            return Ok(None);
        }
        let (settings, doubts) = (*renderer.settings(), doubts(&renderer, &world));
        let mut image = renderer.finish_rows();
        if !settings.variance {
            image.drop_variance();
        }
        let doubts = doubts.about(&image);
        warnings.extend(doubts.iter().map(|doubt| format!("warning: {doubt}")));
        batch.add_metadata(&mut image.metadata, order, start.elapsed());
        let failed = |error| OutputError::write(&order.output, error);
        fs::create_dir_all(image::folder_of(&order.output)).map_err(failed)?;
        let save = || image::save(&image, &order.output);
        // Of a small one, waiting for the disk takes longer than packing, and no thread is to wait.
        match room <= SMALL {
            true => save(),
            false => batch.threads.run(save),
        }?;
        checksum_of_image(&order.output).map(Some).map_err(JobError::Again)
    }
}

impl Batch<'_> {
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

/// Refuses to replace what the scene was read from.
fn refuse_overwriting(output: &Path, inputs: &[PathBuf]) -> Result<(), JobError> {
    for file in image::files_of(output)? {
        let Ok(target) = fs::canonicalize(&file) else { continue };
        let is_it = |input: &&PathBuf| fs::canonicalize(input).is_ok_and(|input| input == target);
        if let Some(input) = inputs.iter().find(is_it) {
            return Err(JobError::OverScene(input.clone()));
        }
    }
    Ok(())
}

/// What a panic says.
fn words_of(panic: &(dyn Any + Send)) -> String {
    let words = panic.downcast_ref::<&str>().map(|words| (*words).to_owned());
    words.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default()
}
