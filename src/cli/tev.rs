//! A render on its way, as tev shows it (<https://github.com/Tom94/tev>): images over a connection.
//!
//! The render leaves what is to be shown to a thread that sends it, and looks at the clock: both
//! together take a hundredth of the time at most. Whatever becomes of the viewer, the render goes
//! on.

use std::io;
use std::net::{TcpStream, ToSocketAddrs};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, SyncSender, TryRecvError};
use std::thread;
use std::time::{Duration, Instant};

use tev_client::{PacketCreateImage, PacketUpdateImage, TevClient};

use super::CliError;
use super::files::say;
use crate::image::live::{self, Live};
use crate::image::rows::Rows;
use crate::render::system::thread_cpu_seconds;
use crate::render::threads::Threads;

/// How long a viewer may take to answer at first, for every address of its name.
const ANSWER: Duration = Duration::from_secs(3);
/// How long it may take nothing of what is sent.
const HANGING: Duration = Duration::from_secs(5);
/// How long the end of the program waits for the last image to be sent.
const LAST: Duration = Duration::from_secs(20);
/// Least time between two images.
const INTERVAL: Duration = Duration::from_secs(1);
/// The share of the time that images may take.
const SHARE: f64 = 0.01;
/// Values that are sent at a time: a packet that tev has room for from the start.
const VALUES: usize = 1 << 17;

/// A viewer that has answered.
pub(super) struct Tev {
    address: String,
    stream: TcpStream,
}

/// A viewer that shows a render.
pub(super) struct Viewer {
    address: String,
    images: SyncSender<Live>,
    /// What is heard when all has been sent, or nothing can be any more.
    end: Receiver<()>,
    sent: Arc<Sent>,
    interval: Duration,
    latest: Option<Latest>,
}

/// What the thread that sends has done.
#[derive(Default)]
struct Sent {
    images: AtomicU64,
    nanoseconds: AtomicU64,
}

/// The latest image: when it was left to the thread, what that had cost and what the thread had
/// done before.
struct Latest {
    when: Instant,
    taken: Duration,
    images: u64,
    nanoseconds: u64,
}

impl Tev {
    /// Connects to the viewer at HOST:PORT.
    ///
    /// # Errors
    /// When that is no address, or nobody answers there.
    pub(super) fn connect(address: &str) -> Result<Self, CliError> {
        let port = address.rsplit_once(':').filter(|(host, _)| !host.is_empty());
        if port.is_none_or(|(_, port)| port.parse::<u16>().is_err()) {
            return Err(CliError::Usage(format!(
                "--tev takes HOST:PORT, such as 127.0.0.1:14158, not {address}"
            )));
        }
        let stream = connected(address).map_err(|error| {
            CliError::System(format!(
                "no tev answers at {address}: {error}; start it there (tev --hostname {address}), \
                 or leave out --tev"
            ))
        })?;
        Ok(Self { address: address.to_owned(), stream })
    }

    /// Begins to show an image under the name of a file, every `interval` or as often as it may.
    ///
    /// # Errors
    /// When the system starts no thread.
    pub(super) fn show(
        self,
        file: &Path,
        image: &dyn Rows,
        interval: Option<Duration>,
    ) -> Result<Viewer, CliError> {
        let Self { address, stream } = self;
        let frame = image.frame();
        let [width, height] = [frame.width, frame.height].map(|size| size as u32);
        let channels = live::channels(&frame);
        let (images, queue) = mpsc::sync_channel(1);
        let (ended, end) = mpsc::channel();
        let sent = Arc::new(Sent::default());
        let mut sender = Sender {
            client: TevClient::wrap(stream),
            name: file.to_string_lossy().into_owned(),
            sent: Arc::clone(&sent),
        };
        let named = address.clone();
        let send = move || {
            let _ended = ended;
            if let Err(error) = sender.send_all([width, height], channels, &queue) {
                say(format_args!("warning: tev at {named} {}", why_it_ends(&error)));
            }
        };
        thread::Builder::new()
            .spawn(send)
            .map_err(|error| CliError::System(format!("cannot start a thread: {error}")))?;
        let interval = interval.map_or(INTERVAL, |interval| interval.max(INTERVAL));
        Ok(Viewer { address, images, end, sent, interval, latest: None })
    }
}

impl Viewer {
    /// Shows an image if it is time.
    pub(super) fn update(&mut self, image: &dyn Rows, threads: &Threads) {
        if self.is_time(threads.count()) {
            self.leave(image, threads);
        }
    }

    /// Shows the last image, and waits until it has been sent.
    pub(super) fn finish(mut self, image: &dyn Rows, threads: &Threads) {
        if self.end.try_recv() == Err(TryRecvError::Disconnected) {
            // It is gone, and that has been said.
            return;
        }
        self.leave(image, threads);
        let Self { address, images, end, .. } = self;
        drop(images);
        if end.recv_timeout(LAST) == Err(RecvTimeoutError::Timeout) {
            say(format_args!("warning: tev at {address} is too slow to show the last image"));
        }
    }

    /// Whether the latest image has been sent, and all that it took, on one of `threads` or on all,
    /// was no more than its share.
    fn is_time(&self, threads: usize) -> bool {
        let Some(latest) = &self.latest else { return true };
        let images = self.sent.images.load(Ordering::Acquire);
        let nanoseconds = self.sent.nanoseconds.load(Ordering::Acquire) - latest.nanoseconds;
        let of_thread = Duration::from_nanos(nanoseconds).div_f64(threads as f64);
        let cost = (latest.taken + of_thread).div_f64(SHARE);
        images > latest.images && latest.when.elapsed() >= self.interval.max(cost)
    }

    /// Leaves an image to the thread that sends; if that has ended, nothing is left.
    fn leave(&mut self, image: &dyn Rows, threads: &Threads) {
        let start = Instant::now();
        let latest = Latest {
            when: start,
            taken: Duration::ZERO,
            images: self.sent.images.load(Ordering::Acquire),
            nanoseconds: self.sent.nanoseconds.load(Ordering::Acquire),
        };
        let _ = self.images.send(threads.run(|| live::shown(image)));
        self.latest = Some(Latest { taken: start.elapsed(), ..latest });
    }
}

/// What sends.
struct Sender {
    client: TevClient,
    name: String,
    sent: Arc<Sent>,
}

impl Sender {
    /// Sends an image of this size and all that it becomes, until nobody leaves any more.
    fn send_all(
        &mut self,
        [width, height]: [u32; 2],
        channel_names: &[&str],
        queue: &Receiver<Live>,
    ) -> io::Result<()> {
        let image_name = &self.name;
        let packet =
            PacketCreateImage { image_name, grab_focus: true, width, height, channel_names };
        self.client.send(packet)?;
        for image in queue {
            let (start, cpu_start) = (Instant::now(), thread_cpu_seconds());
            self.send(&image)?;
            let cpu = thread_cpu_seconds().zip(cpu_start).map(|(end, start)| end - start);
            let taken = cpu.map_or(start.elapsed(), Duration::from_secs_f64);
            self.sent.nanoseconds.fetch_add(taken.as_nanos() as u64, Ordering::Release);
            self.sent.images.fetch_add(1, Ordering::Release);
        }
        Ok(())
    }

    /// Sends an image, some rows at a time.
    fn send(&mut self, image: &Live) -> io::Result<()> {
        let Live { width, channels, values, .. } = image;
        let values_of_row = width * channels.len();
        let rows = (VALUES / values_of_row).max(1);
        let offsets: Vec<u64> = (0..channels.len() as u64).collect();
        let strides = vec![channels.len() as u64; channels.len()];
        for (piece, data) in values.chunks(rows * values_of_row).enumerate() {
            self.client.send(PacketUpdateImage {
                image_name: &self.name,
                grab_focus: false,
                channel_names: channels,
                channel_offsets: &offsets,
                channel_strides: &strides,
                x: 0,
                y: (piece * rows) as u32,
                width: *width as u32,
                height: (data.len() / values_of_row) as u32,
                data,
            })?;
        }
        Ok(())
    }
}

/// A connection to the first of a name's addresses that answers.
fn connected(address: &str) -> io::Result<TcpStream> {
    let mut failed = io::Error::other("the name has no address");
    for address in address.to_socket_addrs()? {
        match TcpStream::connect_timeout(&address, ANSWER) {
            Ok(stream) => {
                stream.set_write_timeout(Some(HANGING))?;
                stream.set_nodelay(true)?;
                return Ok(stream);
            }
            Err(error) => failed = error,
        }
    }
    Err(failed)
}

/// Why nothing can be sent any more.
fn why_it_ends(error: &io::Error) -> String {
    let rest = "it shows no more of the render, which goes on";
    match error.kind() {
        io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut => {
            format!("has taken nothing for {} seconds: {rest}", HANGING.as_secs())
        }
        _ => format!("is gone ({error}): {rest}"),
    }
}
