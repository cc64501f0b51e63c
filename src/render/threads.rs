//! The threads that a render runs on. Their number changes the time it takes and no bit of it.

/// A number of threads, started once.
pub struct Threads(rayon::ThreadPool);

/// Most threads that can be asked for.
pub const THREADS_MAX: usize = 4096;

/// There are no such threads.
#[derive(Debug, thiserror::Error)]
pub enum ThreadsError {
    /// A number out of range.
    #[error("threads must be from 1 to {THREADS_MAX}, not {0}")]
    Count(usize),
    /// The system did not start them.
    #[error("cannot start the threads: {0}")]
    Start(#[from] rayon::ThreadPoolBuildError),
}

impl Threads {
    /// Starts `count` threads, from 1 to 4,096, or one per processor.
    ///
    /// # Errors
    /// When the number is out of range, or the system does not start so many.
    pub fn start(count: Option<usize>) -> Result<Self, ThreadsError> {
        if let Some(count) = count.filter(|count| !(1..=THREADS_MAX).contains(count)) {
            return Err(ThreadsError::Count(count));
        }
        let builder = rayon::ThreadPoolBuilder::new().num_threads(count.unwrap_or(0));
        Ok(Self(builder.build()?))
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.0.current_num_threads()
    }

    /// Does `work` on them.
    pub fn run<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        self.0.install(work)
    }
}
