//! Work on another thread, for which the interpreter waits while it serves its other threads,
//! signals and whoever wants to hear how far the work is.

use std::panic;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::thread;
use std::time::{Duration, Instant};

use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use sunstone::Stop;

use crate::threads::Pool;

/// Time between two looks at the signals.
const POLL: Duration = Duration::from_millis(50);
/// How long work that is given up is waited for. It may be in something that nothing can stop, as
/// building a tree: then it ends by itself, and nobody takes what it brings.
const PATIENCE: Duration = Duration::from_millis(400);

/// What the thread has to say.
enum News<T> {
    /// How much is done, and of how much.
    Progress([u32; 2]),
    /// The end.
    Done(T),
}

/// What tells how far the work is.
pub struct Teller<T>(Sender<News<T>>);

impl<T> Teller<T> {
    /// So much is done, of so much.
    pub fn tell(&self, progress: [u32; 2]) {
        // Nobody listens any more if the work was given up.
        let _ = self.0.send(News::Progress(progress));
    }
}

/// Does `work` on so many threads. `hear` is called in this one, with what has been told last;
/// if that fails, or a signal comes, the work is given up and the error returned.
pub fn wait_for<T: Send + 'static>(
    py: Python,
    threads: Option<usize>,
    stop: &Stop,
    mut hear: impl FnMut([u32; 2]) -> PyResult<()>,
    work: impl FnOnce(&Pool, &Teller<(Pool, T)>) -> T + Send + 'static,
) -> PyResult<T> {
    let pool = Pool::take(py, threads)?;
    let (sender, mut receiver) = mpsc::channel();
    let teller = Teller(sender);
    let run = move || {
        let result = work(&pool, &teller);
        let _ = teller.0.send(News::Done((pool, result)));
    };
    let thread = thread::Builder::new().name("sunstone".to_owned()).spawn(run);
    let thread = thread.map_err(|error| PyOSError::new_err(error.to_string()))?;
    loop {
        let (heard, news) = py.detach(move || {
            let news = latest(&receiver);
            (receiver, news)
        });
        receiver = heard;
        let heard = match news {
            Ok((progress, done)) => {
                let heard = progress.map_or(Ok(()), &mut hear);
                if let Some((pool, result)) = done {
                    pool.give_back(py);
                    // It is about to end.
                    let _ = py.detach(|| thread.join());
                    return heard.map(|()| result);
                }
                heard
            }
            Err(RecvTimeoutError::Timeout) => Ok(()),
            // It panicked, and so does this.
            Err(RecvTimeoutError::Disconnected) => match py.detach(|| thread.join()) {
                Ok(()) => return Err(PyOSError::new_err("a thread has ended without a result")),
                Err(panic) => panic::resume_unwind(panic),
            },
        };
        if let Err(error) = heard.and_then(|()| py.check_signals()) {
            stop.give_up();
            py.detach(move || wait_patiently(&receiver));
            return Err(error);
        }
    }
}

/// How far the work was last, of what has come already, and its result if that has come, too: work
/// that ends at once is heard of like any other.
fn latest<T>(
    receiver: &Receiver<News<T>>,
) -> Result<(Option<[u32; 2]>, Option<T>), RecvTimeoutError> {
    let mut progress = None;
    let mut news = receiver.recv_timeout(POLL)?;
    loop {
        match news {
            News::Done(result) => return Ok((progress, Some(result))),
            News::Progress(so_far) => progress = Some(so_far),
        }
        match receiver.try_recv() {
            Ok(later) => news = later,
            Err(_) => return Ok((progress, None)),
        }
    }
}

fn wait_patiently<T>(receiver: &Receiver<News<T>>) {
    let end = Instant::now() + PATIENCE;
    loop {
        let left = end.saturating_duration_since(Instant::now());
        match receiver.recv_timeout(left) {
            Ok(News::Progress(_)) => {}
            Ok(News::Done(_)) | Err(_) => return,
        }
    }
}
