//! Batches: the library runs one on a thread of its own, and Python takes what it has to say.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::process;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use sunstone::Stop;
use sunstone::internals::batch::order::Order;
use sunstone::internals::batch::prepared::{Asked, Begun, Prepared, Work};
use sunstone::internals::batch::results::{Record, ResultsError};
use sunstone::internals::batch::run::News;
use sunstone::internals::batch::values::Values;
use sunstone::internals::cli::batch::reader;

use crate::errors::{ERROR, RENDER_ERROR, of_image, of_system};
use crate::json::dict;
use crate::options::option;
use crate::threads::Pool;
use crate::wait::wait_for;
use crate::words::in_python;

/// Time between two looks at the signals.
const POLL: Duration = Duration::from_millis(50);
/// How long jobs that are given up are waited for when a signal came: one may be in something that
/// nothing can stop, as building a tree. Then it ends by itself, without an image.
const PATIENCE: Duration = Duration::from_millis(400);

/// A batch whose job file is good.
#[pyclass(module = "sunstone._sunstone")]
pub struct Batch {
    state: State,
    /// The process that it runs in.
    process: u32,
}

enum State {
    Prepared(Box<Prepared>),
    Running(Running),
    Over,
}

/// A batch on its thread.
struct Running {
    told: Mutex<Receiver<Told>>,
    stop: Arc<AtomicBool>,
    /// Samples in all.
    cost: u64,
    /// Why results could not be noted.
    unwritten: Option<PyErr>,
}

/// What the thread has to say.
enum Told {
    Row(Box<Row>),
    /// Samples that are done.
    Progress(u64),
    Unwritten(ResultsError),
    Done(Pool),
}

/// A job, and what has become of it.
struct Row {
    record: Option<Record>,
    index: usize,
    name: String,
    values: Values,
    output: PathBuf,
    warnings: Vec<String>,
    was_done: bool,
}

#[pymethods]
impl Batch {
    /// Reads a job file; all that it alone shows to be wrong is told.
    #[new]
    fn new(
        py: Python,
        jobs: PathBuf,
        results: Option<PathBuf>,
        allow_outside: bool,
    ) -> PyResult<Self> {
        // The system's own word for a file that is not there, or may not be read.
        if let Err(error) = std::fs::File::open(&jobs) {
            let text = format!("cannot read {}: {error}", jobs.display());
            return Err(of_system(&jobs, &error, text));
        }
        let asked = Asked { jobs, results, allow_outside, work: Work::All };
        let read = move || Prepared::read(asked, &mut reader(allow_outside));
        let nothing = Stop::default();
        let prepared = wait_for(py, None, &nothing, |_| Ok(()), move |_, _| read())?;
        let prepared = prepared.map_err(|refused| ERROR.says(refused))?;
        Ok(Self { state: State::Prepared(Box::new(prepared)), process: process::id() })
    }

    /// All jobs, and what has become of those that are done.
    fn look<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyTuple>>> {
        let State::Prepared(prepared) = &self.state else { return Ok(Vec::new()) };
        let rows: Vec<Row> =
            py.detach(|| prepared.look().1.map(|(order, it)| Row::known(order, it)).collect());
        rows.into_iter().map(|row| row.into_python(py)).collect()
    }

    /// Begins to render what is left; returns what was done before.
    fn begin<'py>(
        &mut self,
        py: Python<'py>,
        options: &Bound<PyDict>,
    ) -> PyResult<Vec<Bound<'py, PyTuple>>> {
        self.refuse_in_child()?;
        let threads = option(options, "threads")?;
        let State::Prepared(prepared) = std::mem::replace(&mut self.state, State::Over) else {
            return Ok(Vec::new());
        };
        let pool = Pool::take(py, threads)?;
        let nothing = Stop::default();
        let begun = wait_for(py, None, &nothing, |_| Ok(()), move |_, _| prepared.begin())?;
        let begun = begun.map_err(of_results)?;
        warn_of(py, begun.notes())?;
        let done = begun.done().iter().map(|(order, it)| Row::known(order, Some(it.clone())));
        let done = done.map(|row| row.into_python(py)).collect::<PyResult<_>>()?;
        let (cost, stop) = (begun.cost(), Arc::new(AtomicBool::new(false)));
        let (sender, told) = mpsc::channel();
        let of_thread = Arc::clone(&stop);
        let run = move || run(begun, pool, &sender, &of_thread);
        let thread = thread::Builder::new().name("sunstone batch".to_owned()).spawn(run);
        thread.map_err(|error| PyOSError::new_err(error.to_string()))?;
        let told = Mutex::new(told);
        self.state = State::Running(Running { told, stop, cost, unwritten: None });
        Ok(done)
    }

    /// The next job that comes to an end; none if there is no other. `progress` is called
    /// meanwhile, and ends the batch if it returns False.
    fn next<'py>(
        &mut self,
        py: Python<'py>,
        progress: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Option<Bound<'py, PyTuple>>> {
        self.refuse_in_child()?;
        let State::Running(running) = &mut self.state else { return Ok(None) };
        let next = running.next(py, progress.as_ref());
        match next {
            Ok(Some(row)) => row.into_python(py).map(Some),
            Ok(None) => {
                let unwritten = running.unwritten.take();
                self.state = State::Over;
                unwritten.map_or(Ok(None), Err)
            }
            Err(error) => {
                running.give_up(py);
                self.state = State::Over;
                Err(error)
            }
        }
    }

    /// Ends the batch: jobs in work are dropped.
    fn close(&mut self, py: Python) -> PyResult<()> {
        let state = std::mem::replace(&mut self.state, State::Over);
        match state {
            State::Running(mut running) if self.process == process::id() => {
                running.stop.store(true, Ordering::Relaxed);
                while running.next(py, None)?.is_some() {}
                Ok(())
            }
            State::Prepared(_) | State::Running(_) | State::Over => Ok(()),
        }
    }
}

impl Batch {
    /// A forked process has no thread that would tell anything.
    fn refuse_in_child(&self) -> PyResult<()> {
        match self.process == process::id() {
            true => Ok(()),
            false => Err(RENDER_ERROR
                .says("this process was forked after the batch had been read: read it anew")),
        }
    }
}

impl Running {
    /// Waits for the next row, with the interpreter free.
    fn next(&mut self, py: Python, progress: Option<&Bound<PyAny>>) -> PyResult<Option<Row>> {
        loop {
            py.check_signals()?;
            match self.hear(py, POLL) {
                Ok(Told::Row(row)) => return Ok(Some(*row)),
                Ok(Told::Progress(done)) => {
                    let Some(progress) = progress else { continue };
                    let answer = progress.call1((done.min(self.cost), self.cost))?;
                    if answer.extract::<bool>().is_ok_and(|goes_on| !goes_on) {
                        self.stop.store(true, Ordering::Relaxed);
                    }
                }
                Ok(Told::Unwritten(error)) => self.unwritten = Some(of_results(error)),
                Ok(Told::Done(pool)) => {
                    pool.give_back(py);
                    return Ok(None);
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(PyOSError::new_err("a thread has ended without a result"));
                }
            }
        }
    }

    /// What comes next within a time; of progress the latest.
    fn hear(&self, py: Python, time: Duration) -> Result<Told, RecvTimeoutError> {
        py.detach(|| self.told.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(time))
    }

    /// Ends it, and waits for that as long as somebody who has pressed Ctrl-C does.
    fn give_up(&self, py: Python) {
        self.stop.store(true, Ordering::Relaxed);
        let end = Instant::now() + PATIENCE;
        loop {
            match self.hear(py, end.saturating_duration_since(Instant::now())) {
                Ok(Told::Done(pool)) => return pool.give_back(py),
                Ok(Told::Row(_) | Told::Progress(_) | Told::Unwritten(_)) => {}
                Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => return,
            }
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

/// Does the batch. Nobody hears of it any more if it was given up.
fn run(mut begun: Begun, pool: Pool, sender: &Sender<Told>, stop: &AtomicBool) {
    let mut latest = 0;
    begun.run(&pool.threads, Vec::new(), |news| {
        let told = match news {
            News::Ended { order, record, warnings, may_pass: _, is_former: _ } => {
                Some(Told::Row(Box::new(Row { warnings, ..Row::new(order, Some(*record)) })))
            }
            News::Progress(done) => {
                (std::mem::replace(&mut latest, done) != done).then_some(Told::Progress(done))
            }
            News::Unwritten(error) => Some(Told::Unwritten(error)),
            // Of tasks and merges, which only the command line does.
            News::Again { .. } | News::Left(_) => None,
        };
        let is_heard = told.is_none_or(|told| sender.send(told).is_ok());
        match is_heard && !stop.load(Ordering::Relaxed) {
            true => ControlFlow::Continue(()),
            false => ControlFlow::Break(()),
        }
    });
    // The file of results is free for others before anybody hears that it is.
    drop(begun);
    let _ = sender.send(Told::Done(pool));
}

impl Row {
    fn new(order: &Order, record: Option<Record>) -> Self {
        let Order { index, name, values, output, .. } = order;
        let (name, values, output) = (name.clone(), values.clone(), output.clone());
        Self { record, index: *index, name, values, output, warnings: Vec::new(), was_done: false }
    }

    /// One that has not been rendered now.
    fn known(order: &Order, record: Option<Record>) -> Self {
        Self { was_done: record.is_some(), ..Self::new(order, record) }
    }

    /// What `sunstone.Result` is made of.
    fn into_python(self, py: Python<'_>) -> PyResult<Bound<'_, PyTuple>> {
        let Self { record, index, name, values, output, warnings, was_done } = self;
        let seconds = record.as_ref().map(|record| record.seconds);
        let (error, checksum) = record.map_or((None, None), |it| (it.error, it.checksum));
        let error = error.map(|text| in_python(&text));
        let values: Bound<PyDict> = dict(py, values.iter())?;
        let warnings = PyTuple::new(py, warnings.iter().map(|text| in_python(text)))?;
        let output = output.to_string_lossy().into_owned();
        (index, name, values, output, error, seconds, checksum, was_done, warnings)
            .into_pyobject(py)
    }
}

/// Warns of what there is to know before a batch goes on.
fn warn_of(py: Python, notes: &[String]) -> PyResult<()> {
    let category = py.import("sunstone._errors")?.getattr("RenderWarning")?;
    let warn = py.import("warnings")?.getattr("warn")?;
    for note in notes {
        let text = note.split_once(": ").map_or(note.as_str(), |(_, text)| text);
        // By the line that asks for the first result.
        warn.call1((text, &category, 2))?;
    }
    Ok(())
}

/// What keeps results from being noted.
fn of_results(error: ResultsError) -> PyErr {
    let text = error.to_string();
    match error {
        ResultsError::Taken(_) | ResultsError::NotResults(_) => ERROR.says(text),
        ResultsError::Write { path, source } => of_system(&path, &source, text),
        ResultsError::Replace(error) => of_image(error),
    }
}
