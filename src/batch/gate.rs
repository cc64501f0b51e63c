//! How much is in work at once: small jobs side by side, large ones alone, so that a batch takes
//! hardly more memory than its largest job.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// Lets so much in at once.
pub struct Gate {
    room: u64,
    free: Mutex<u64>,
    freed: Condvar,
    /// Held by who waits: nobody overtakes a large job.
    turn: Mutex<()>,
}

/// Room that is taken until this is dropped.
pub struct Permit<'a> {
    gate: &'a Gate,
    taken: u64,
}

impl Gate {
    /// A gate with so much room.
    pub fn new(room: u64) -> Self {
        Self { room, free: Mutex::new(room), freed: Condvar::new(), turn: Mutex::new(()) }
    }

    /// Waits for room, for all that there is if more is asked for.
    pub fn enter(&self, size: u64) -> Permit<'_> {
        let taken = size.min(self.room);
        let _turn = locked(&self.turn);
        let mut free = locked(&self.free);
        while *free < taken {
            free = self.freed.wait(free).unwrap_or_else(PoisonError::into_inner);
        }
        *free -= taken;
        Permit { gate: self, taken }
    }
}

impl Drop for Permit<'_> {
    fn drop(&mut self) {
        *locked(&self.gate.free) += self.taken;
        self.gate.freed.notify_all();
    }
}

/// The value, whoever panicked with the lock.
pub fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use std::thread;
    use std::time::Duration;

    use super::*;

    #[test]
    fn what_is_too_large_goes_alone() {
        let gate = Gate::new(10);
        let small = [gate.enter(4), gate.enter(4)];
        thread::scope(|scope| {
            let large = scope.spawn(|| gate.enter(1000).taken);
            thread::sleep(Duration::from_millis(20));
            assert!(!large.is_finished());
            drop(small);
            assert_eq!(large.join().unwrap(), 10);
        });
        assert_eq!(*locked(&gate.free), 10);
    }
}
