//! The threads that a render runs on. Their number changes the time it takes and no bit of it.

/// A number of threads, started once.
pub struct Threads(rayon::ThreadPool);

/// The system did not start the threads.
#[derive(Debug, thiserror::Error)]
#[error("cannot start the threads: {0}")]
pub struct ThreadsError(#[from] rayon::ThreadPoolBuildError);

impl Threads {
    /// Starts `count` threads, or one per processor.
    pub fn start(count: Option<usize>) -> Result<Self, ThreadsError> {
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
