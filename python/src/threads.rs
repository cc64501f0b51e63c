//! Pools of threads, kept from one render to the next.
//!
//! A render has a pool to itself: on a shared one, a thread that waits within the preparation of
//! one render could begin another of the same scene, and wait for itself.
//!
//! A forked process inherits no thread, and whoever waits for one there waits for ever. So pools
//! belong to a process by its number, and those of another are forgotten. The list is locked only
//! by threads that hold the interpreter's lock, as the one that forks does: it is never locked in
//! the child.

use std::mem;
use std::process;
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::prelude::*;
use sunstone::Threads;

use crate::errors;

/// Most pools that wait for work.
const IDLE_MAX: usize = 4;

/// Pools that wait for work.
struct Idle {
    /// The process that they run in.
    process: u32,
    /// The number of threads that was asked for, and these.
    pools: Vec<(Option<usize>, Arc<Threads>)>,
}

static IDLE: Mutex<Idle> = Mutex::new(Idle { process: 0, pools: Vec::new() });

/// A pool that nobody else has.
pub struct Pool {
    count: Option<usize>,
    /// Its threads.
    pub threads: Arc<Threads>,
}

impl Pool {
    /// One of so many threads, or of one for every processor.
    pub fn take(_attached: Python, count: Option<usize>) -> PyResult<Self> {
        let position = |idle: &Idle| idle.pools.iter().rposition(|(of, _)| *of == count);
        let waiting = with_idle(|idle| position(idle).map(|index| idle.pools.remove(index).1));
        let threads = match waiting {
            Some(threads) => threads,
            None => Arc::new(Threads::start(count).map_err(errors::of_threads)?),
        };
        Ok(Self { count, threads })
    }

    /// Keeps it for the next.
    pub fn give_back(self, _attached: Python) {
        let oldest = with_idle(|idle| {
            idle.pools.push((self.count, self.threads));
            (idle.pools.len() > IDLE_MAX).then(|| idle.pools.remove(0))
        });
        drop(oldest);
    }
}

fn with_idle<R>(work: impl FnOnce(&mut Idle) -> R) -> R {
    let mut idle = IDLE.lock().unwrap_or_else(PoisonError::into_inner);
    if idle.process != process::id() {
        // Dropped, they would be told to end, and there is nobody to listen.
        mem::forget(mem::take(&mut idle.pools));
        idle.process = process::id();
    }
    work(&mut idle)
}
