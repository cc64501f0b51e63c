//! Signals that ask a render to end: the image so far is written before the program goes.
//!
//! The render hears of a signal when the wave of samples in hand is done, or while it shoots
//! photons. As the wave can take longer than whoever sent the signal waits, a thread keeps the
//! image of the wave before, if waves are long, and writes that.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use super::CliError;
use super::files::say;
use crate::image::StokesImage;
use crate::render::threads::Threads;
use crate::render::{Progress, Stop};

/// How long the wave in hand may take before the image of the one before is written instead.
const PATIENCE: Duration = Duration::from_millis(800);
/// Time between two looks at the signals.
const POLL: Duration = Duration::from_millis(50);

/// A signal that asks the program to end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Signal {
    name: &'static str,
    number: u8,
}

impl Signal {
    /// What it is called.
    pub fn name(self) -> &'static str {
        self.name
    }

    /// What the program ends with.
    pub fn exit_code(self) -> u8 {
        128 + self.number
    }
}

/// Listens to signals where nothing has to be written when they come. From now on, the first
/// signal of its kind is no longer the end, but the second is. The function tells which has come.
///
/// # Errors
/// When the system refuses.
pub fn signals() -> Result<impl Fn() -> Option<Signal>, CliError> {
    let number = Arc::new(AtomicUsize::new(0));
    register(&number)
        .map_err(|error| CliError::System(format!("cannot listen to signals: {error}")))?;
    Ok(move || signal_of(&number))
}

/// Listens to signals for as long as a render runs.
pub struct Interrupt {
    /// The number of the signal that has come; zero if none has.
    number: Arc<AtomicUsize>,
    state: Arc<Mutex<State>>,
}

/// What the render leaves for the thread that waits for signals.
struct State {
    /// The render is over, and its image is being written by others.
    over: bool,
    /// The image of the latest wave and its samples per pixel, if the next wave is likely to take
    /// long.
    image: Option<(StokesImage, u32)>,
    /// When the latest wave ended.
    latest: Instant,
}

impl Interrupt {
    /// Begins to listen. From now on, the first signal of its kind is no longer the end, but the
    /// second is, and `stop` is told to the render. `write` is what writes an image, with the
    /// number of its samples per pixel, when the render cannot be waited for; the program ends with
    /// the exit code that it returns.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn listen(
        stop: Stop,
        write: impl FnOnce(StokesImage, u32, Signal) -> u8 + Send + 'static,
    ) -> Result<Self, CliError> {
        let number = Arc::new(AtomicUsize::new(0));
        register(&number)
            .map_err(|error| CliError::System(format!("cannot listen to signals: {error}")))?;
        let state = State { over: false, image: None, latest: Instant::now() };
        let state = Arc::new(Mutex::new(state));
        let (of_thread, seen) = (Arc::clone(&state), Arc::clone(&number));
        let watch = move || watch((&of_thread, &seen), &stop, write);
        thread::Builder::new()
            .spawn(watch)
            .map_err(|error| CliError::System(format!("cannot start a thread: {error}")))?;
        Ok(Self { number, state })
    }

    /// The signal that has come.
    pub fn signal(&self) -> Option<Signal> {
        signal_of(&self.number)
    }

    /// Takes notice that a wave is done, and keeps its image on these threads.
    pub fn keep(&self, so_far: &Progress, threads: &Threads) {
        let mut state = locked(&self.state);
        // After the last wave there is none that could take long.
        let is_long = state.latest.elapsed() > PATIENCE && so_far.samples < so_far.total;
        // First, as there is no need for two of them at once.
        state.image = None;
        state.image = is_long.then(|| (threads.run(|| so_far.preview()), so_far.samples));
        state.latest = Instant::now();
    }

    /// Takes notice that the render is over.
    pub fn end(&self) {
        let mut state = locked(&self.state);
        state.over = true;
        state.image = None;
    }
}

/// Waits for a signal, and then for the render or for its own patience to end.
fn watch(
    (state, number): (&Mutex<State>, &AtomicUsize),
    stop: &Stop,
    write: impl FnOnce(StokesImage, u32, Signal) -> u8,
) {
    let signal = loop {
        if let Some(signal) = signal_of(number) {
            break signal;
        }
        if locked(state).over {
            return;
        }
        thread::sleep(POLL);
    };
    // The render has begun by then.
    thread::sleep(POLL);
    stop.stop();
    let name = signal.name();
    say(format_args!("{name}: writing the image as it is; the next signal ends at once"));
    thread::sleep(PATIENCE);
    // The lock is held to the end, so that the render does not write too.
    let mut state = locked(state);
    if let Some((image, samples)) = state.image.take() {
        std::process::exit(write(image, samples, signal).into());
    }
}

/// What the state is worth does not depend on whoever panicked with the lock.
fn locked(state: &Mutex<State>) -> MutexGuard<'_, State> {
    state.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(unix)]
const SIGNALS: [Signal; 3] = {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    [
        Signal { name: "SIGHUP", number: SIGHUP as u8 },
        Signal { name: "SIGINT", number: SIGINT as u8 },
        Signal { name: "SIGTERM", number: SIGTERM as u8 },
    ]
};
#[cfg(not(unix))]
const SIGNALS: [Signal; 0] = [];

fn signal_of(number: &AtomicUsize) -> Option<Signal> {
    let number = number.load(Ordering::Relaxed);
    SIGNALS.into_iter().find(|signal| usize::from(signal.number) == number)
}

#[cfg(unix)]
fn register(number: &Arc<AtomicUsize>) -> std::io::Result<()> {
    use signal_hook::flag;
    let armed = Arc::new(AtomicBool::new(false));
    for signal in SIGNALS {
        let raw = signal.number.into();
        // Whoever started the program with `nohup` wants it to outlive the terminal.
        if raw == signal_hook::consts::SIGHUP && is_ignored(raw) {
            continue;
        }
        // In this order: the second signal, of whichever kind, finds the flag of the first.
        flag::register_conditional_shutdown(raw, signal.exit_code().into(), Arc::clone(&armed))?;
        flag::register(raw, Arc::clone(&armed))?;
        flag::register_usize(raw, Arc::clone(number), signal.number.into())?;
    }
    // A file that grows beyond a limit is an error to be told, and not the end.
    flag::register(signal_hook::consts::SIGXFSZ, Arc::new(AtomicBool::new(false)))?;
    Ok(())
}

#[cfg(not(unix))]
fn register(_: &Arc<AtomicUsize>) -> std::io::Result<()> {
    Ok(())
}

/// Whether the program was started with a signal ignored, where the system tells.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    mask >> (signal - 1) & 1 == 1
}
