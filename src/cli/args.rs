//! The command line as typed.

use std::path::PathBuf;
use std::sync::LazyLock;

use clap::builder::{PossibleValue, PossibleValuesParser};
use clap::{Args, Parser, Subcommand, ValueEnum};

use super::batch::args::{FarmArguments, TaskArguments};
use super::bench::args::BenchArguments;
use super::color::ColorArguments;
use super::convert::ConvertArguments;
use super::files::FileArguments;
use super::film::FilmArguments;
use super::images::{ChannelArguments, PixelText};
use super::view::LightName;
use crate::image::analyzed::ANALYZERS;
use crate::image::format::FORMATS;
use crate::image::visualize::Map;
use crate::integrators::Integrator;
use crate::render::settings::AUTO;
use crate::render::{Mode, Part};
use crate::transport::Sampling;

/// Polarized, bidirectional light transport: a scene of glTF or Mitsuba in, a Stokes image out.
#[derive(Debug, Parser)]
#[command(name = "sunstone", version, arg_required_else_help = true)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const EXAMPLES: &str = include_str!("examples.txt");

const RENDER_NOTES: &str = "\
Results go to the output file and, with --stats, to standard output; progress, warnings and the \
closing line go to standard error. The output appears under its name when it is complete, never as \
half a file. Ctrl-C, SIGTERM and SIGHUP end a render with the image as it is; a second one ends it \
at once and leaves a former file as it was. An image that cannot be written where it should goes \
into the current folder or that of temporary files.

The image depends on the scene, the options above --threads and the seed alone: the same command \
gives the same bits on any number of threads, unless there is a --time-limit.

Tables of spheres and milk that took milliseconds to compute are kept in the folder \
sunstone of the user's caches ($XDG_CACHE_HOME or ~/.cache), 128 MiB at most, and change no bit. \
SUNSTONE_CACHE is the path of another folder; SUNSTONE_CACHE=off keeps none.";

/// The verbs.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene to a Stokes image
    Render(RenderArguments),
    /// Make an image of its parts, which `render --part` has rendered
    Merge(MergeArguments),
    /// Draw maps of an image's polarization, look at it through analyzers, or record it as cameras
    /// of polarization do
    Visualize(VisualizeArguments),
    /// Make a page to look at an image in, or at two: maps, an analyzer, values
    View(ViewArguments),
    /// Compare two images: errors, and z-scores where they hold variances
    Compare(CompareArguments),
    /// Say in words what is in a scene or an image
    Inspect(InspectArguments),
    /// Write a scene as glTF
    Convert(ConvertArguments),
    /// Render all that a job file asks for: sweeps, data sets
    Batch(BatchArguments),
    /// Make a page of a batch: its images, times and errors, with filters and plots
    Report(ReportArguments),
    /// Write what has a cluster or a render farm do a batch in tasks
    Farm(FarmArguments),
    /// Measure this program on this machine
    Bench(BenchArguments),
}

/// An integrator, by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IntegratorName(pub Integrator);

impl ValueEnum for IntegratorName {
    fn value_variants<'a>() -> &'a [Self] {
        static NAMES: LazyLock<Vec<IntegratorName>> =
            LazyLock::new(|| Integrator::ALL.iter().copied().map(IntegratorName).collect());
        &NAMES
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.0.name()).help(self.0.summary()))
    }
}

/// An integrator by its name, or none: what suits the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IntegratorChoice(pub Option<Integrator>);

impl ValueEnum for IntegratorChoice {
    fn value_variants<'a>() -> &'a [Self] {
        static NAMES: LazyLock<Vec<IntegratorChoice>> = LazyLock::new(|| {
            let named = Integrator::ALL.iter().copied().map(Some);
            std::iter::once(None).chain(named).map(IntegratorChoice).collect()
        });
        &NAMES
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        match self.0 {
            Some(integrator) => IntegratorName(integrator).to_possible_value(),
            None => Some(PossibleValue::new(AUTO).help(
                "What suits the scene: `ppm` or `bdpt` where points or small lamps light mirrors \
                 or glass, else `path`",
            )),
        }
    }
}

/// A mode, by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModeName(pub Mode);

impl ValueEnum for ModeName {
    fn value_variants<'a>() -> &'a [Self] {
        static NAMES: [ModeName; Mode::ALL.len()] = {
            let [a, b, c] = Mode::ALL;
            [ModeName(a), ModeName(b), ModeName(c)]
        };
        &NAMES
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let help = match self.0 {
            Mode::Scalar => {
                "Light without polarization, its intensity; traces the same paths as `polarized`"
            }
            Mode::Intensity => "Polarized light, its intensity: S0 of `polarized`, at less cost",
            Mode::Polarized => "Polarized light, its Stokes vector: S0 to S3",
        };
        Some(PossibleValue::new(self.0.name()).help(help))
    }
}

/// What directions are drawn by, by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SamplingName(pub Sampling);

impl ValueEnum for SamplingName {
    fn value_variants<'a>() -> &'a [Self] {
        static NAMES: [SamplingName; Sampling::ALL.len()] = {
            let [a, b] = Sampling::ALL;
            [SamplingName(a), SamplingName(b)]
        };
        &NAMES
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let help = match self.0 {
            Sampling::Stokes => "What polarized light does, in media that polarize and at glass",
            Sampling::Intensity => {
                "What unpolarized light would do: all modes trace the same paths, and share noise"
            }
        };
        Some(PossibleValue::new(self.0.name()).help(help))
    }
}

/// Formats of statistics and reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum StatsFormat {
    /// Lines and tables to read
    Text,
    /// One JSON object
    Json,
}

/// What `render --help` says about formats.
static OUTPUT_HELP: LazyLock<String> = LazyLock::new(|| {
    let savable = FORMATS.iter().filter(|format| format.write.is_some());
    let formats = savable.map(|format| format!("\n.{}: {}", format.extension, format.summary));
    format!("Where to write; the extension names the format:{}", formats.collect::<String>())
});

/// `render` as typed.
#[derive(Clone, Debug, Args)]
#[command(after_long_help = RENDER_NOTES, args_override_self = true)]
pub struct RenderArguments {
    /// The scene: .gltf, .glb, or .xml of Mitsuba 3
    #[arg(value_name = "SCENE")]
    pub scene: PathBuf,
    /// What the scene may read.
    #[command(flatten)]
    pub files: FileArguments,
    /// Where to write; the extension names the format, and .exr keeps everything
    #[arg(
        short,
        long,
        value_name = "FILE",
        allow_hyphen_values = true,
        long_help = OUTPUT_HELP.as_str()
    )]
    pub output: PathBuf,

    /// How light is found [default: the scene's, or auto]
    #[arg(long, value_enum, value_name = "NAME", help_heading = LIGHT)]
    pub integrator: Option<IntegratorChoice>,
    /// Without polarization, or with it: on a film of intensities or of Stokes vectors
    #[arg(long, value_enum, default_value = "polarized", help_heading = LIGHT)]
    pub mode: ModeName,
    /// What light is made of.
    #[command(flatten)]
    pub color: ColorArguments,
    /// Most segments of a path: 1 shows emitters only, 2 adds direct light [default: the
    /// scene's, or no limit]
    #[arg(long, value_name = "SEGMENTS", help_heading = LIGHT)]
    pub max_path_length: Option<u32>,
    /// Segments after which roulette may end a path; it adds noise and no error [default: the
    /// scene's, or 5, or 3 by bdpt, and 1 for paths from the emitters]
    #[arg(long, value_name = "SEGMENTS", help_heading = LIGHT)]
    pub roulette_after: Option<u32>,
    /// What directions are drawn by where light is polarized; it changes noise and no mean
    #[arg(long, value_enum, default_value = "stokes", value_name = "LIGHT", help_heading = LIGHT)]
    pub sampling: SamplingName,

    /// Samples per pixel [default: the scene's, or 64]
    #[arg(long, value_name = "N", conflicts_with = "iterations", help_heading = SAMPLES)]
    pub spp: Option<u32>,
    /// Iterations: one sample in every pixel, or, with ppm, one pass of photons and the samples
    /// of --samples-per-iteration
    #[arg(long, value_name = "N", help_heading = SAMPLES)]
    pub iterations: Option<u32>,
    /// Stop after this many seconds, with what is done by then: one iteration at least
    #[arg(long, value_name = "SECONDS", help_heading = SAMPLES)]
    pub time_limit: Option<f64>,
    /// Render one of N parts of the image, by its samples, into a .part file; `sunstone merge`
    /// makes the image of all, to the bits of one render
    #[arg(long, value_name = "K/N", conflicts_with = "time_limit", help_heading = SAMPLES)]
    pub part: Option<Part>,
    /// Also write the image as it is every so many seconds, without variances
    #[arg(long, value_name = "SECONDS", help_heading = SAMPLES)]
    pub update: Option<f64>,
    /// Show the image as it is in the viewer tev, which listens there (127.0.0.1:14158): S0, degree
    /// of polarization, angle of linear polarization in half turns; at most once a second, or
    /// --update
    #[arg(long, value_name = "HOST:PORT", help_heading = SAMPLES)]
    pub tev: Option<String>,
    /// Seed of all randomness [default: the scene's, or 0]
    #[arg(long, value_name = "N", help_heading = SAMPLES)]
    pub seed: Option<u32>,
    /// Also store the variance of every value (not in every format): from blocks of the samples,
    /// which costs the image nothing and overestimates it where pixels are smooth, or from
    /// --replicates
    #[arg(long, help_heading = SAMPLES)]
    pub variance: bool,
    /// Independent replicates that the iterations are split into; they cost stratification
    #[arg(long, value_name = "N", help_heading = SAMPLES)]
    pub replicates: Option<u32>,

    /// Photons.
    #[command(flatten)]
    pub photons: PhotonArguments,

    /// Width in pixels [default: the scene's, or 512]
    #[arg(long, value_name = "PIXELS", help_heading = FILM)]
    pub width: Option<u32>,
    /// Height in pixels [default: from the width and the camera's aspect]
    #[arg(long, value_name = "PIXELS", help_heading = FILM)]
    pub height: Option<u32>,
    /// How the film's pixels see.
    #[command(flatten)]
    pub film: FilmArguments,
    /// Name of the camera or of its node, or 0, 1, ... by the file's order; `auto` puts one in that
    /// sees all of the scene [default: the first, and auto where there is none]
    #[arg(long, value_name = "NAME", help_heading = FILM)]
    pub camera: Option<String>,
    /// What shines where nothing in the scene does
    #[arg(long, value_enum, default_value = "auto", value_name = "NAME", help_heading = FILM)]
    pub light: LightName,
    /// Seconds into the animations of a glTF file [default: nothing moves: nodes and meshes are as
    /// they are stated]
    #[arg(long, value_name = "SECONDS", help_heading = FILM)]
    pub time: Option<f64>,

    /// Checkpoints.
    #[command(flatten)]
    pub checkpoints: CheckpointArguments,
    /// Threads [default: all processors]
    #[arg(long, value_name = "N", help_heading = RUN)]
    pub threads: Option<usize>,
    /// Print what the render took, on standard output
    #[arg(long, value_enum, value_name = "FORMAT", help_heading = RUN)]
    pub stats: Option<StatsFormat>,
    /// No progress, no notes and no closing line; warnings and errors remain
    #[arg(short, long, help_heading = RUN)]
    pub quiet: bool,
}

/// How a render can be taken up again.
#[derive(Clone, Debug, Args)]
pub struct CheckpointArguments {
    /// Keep what is needed to go on in this file while the render runs; it is removed when the
    /// output is written
    #[arg(long, value_name = "FILE", conflicts_with = "time_limit", help_heading = RUN)]
    pub checkpoint: Option<PathBuf>,
    /// Write it every so many seconds, and when a signal ends the render [default: 60]
    #[arg(long, value_name = "SECONDS", requires = "checkpoint", help_heading = RUN)]
    pub checkpoint_every: Option<f64>,
    /// Go on from the checkpoint, if it is there, to the bits of a render that was never stopped
    #[arg(long, requires = "checkpoint", help_heading = RUN)]
    pub resume: bool,
}

/// Options of photon mapping.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = PHOTONS)]
pub struct PhotonArguments {
    /// Light paths an iteration [default: 4 for every pixel, from 10000 to 4000000]
    #[arg(long, value_name = "N")]
    pub photons: Option<u32>,
    /// Samples per pixel an iteration [default: 4, or fewer where those do not divide --spp]
    #[arg(long, value_name = "N")]
    pub samples_per_iteration: Option<u32>,
    /// Radius of the first iteration in scene units [default: what holds 25 photons]
    #[arg(long, value_name = "LENGTH")]
    pub radius: Option<f32>,
    /// How the kernel shrinks, from 0 (fast, noisy) to 1 (not at all, biased) [default: 2/3]
    #[arg(long, value_name = "ALPHA")]
    pub alpha: Option<f32>,
}

const BATCH_NOTES: &str = "\
A job file is TOML with defaults and jobs, or has the table of a job in every line as JSON (.jsonl):

  version = 1
  [defaults]                  # long options of `render`, with _ for -
  scene = \"lab.gltf\"         # paths are relative to the job file
  spp = 64
  [[jobs]]
  name = \"still\"
  output = \"out/{name}.exr\"
  set = { \"materials/analyzer/axis_deg\" = 30 }
  [[jobs]]                    # 36 x 3 jobs, the last axis fastest
  name = \"malus\"
  output = \"out/{name}-{angle:05.1}-{ior}.exr\"   # also {index:04}, {seed}
  sweep = [
    { name = \"angle\", key = \"materials/analyzer/axis_deg\", from = 0, to = 175, count = 36 },
    { name = \"ior\", key = \"materials/glass/ior\", values = [1.33, 1.5, 1.7] },
  ]                           # step_with = \"ior\" walks in step instead

An option of a job goes before the default of that name, and before a default that it excludes \
(iterations and spp). Jobs are counted from 0 in the order of the file, each of a sweep for \
itself: in messages, in results.jsonl and in {index}. In names of files a table, or a list of more \
than 4 items or of lists, is its number on its axis, from 0.

Edits are KIND/NAME/KEY: materials, nodes, lights, cameras or media, a name or #0, #1, ... by the \
order in the file, and a key of the scene file (dots lead inwards). Those of a job are checked \
together; unset = [KIND/NAME/KEY, ...] takes away what the file states. Axes may sweep options, \
too, by bare name. All jobs have the same seed unless they say another; seed = \"job\" gives each \
its index.

A batch that is started again does what is left, and again what has failed or whose scene, \
options, program or image has changed. What another job file of the same results makes is not \
written over, unless that file is gone, or asks for the same image. Exit codes: 0 all done, 1 \
some jobs failed, 2 the job file is wrong and nothing was rendered, 128 + N signal N ended it.

Many machines that share a folder do a share each with --task K/N, of parts of images if there \
are to be some, and --merge makes one batch of all shares. A task tries again, once, what the \
system has refused (a full disk, a server that does not answer), and ends with 0 unless something \
is left that another try might do: jobs that cannot be rendered are told by --merge. 'sunstone \
farm' writes what has an engine run all that. Without --task and --merge, images are made of \
parts that are all there, and rendered as a whole where some are missing.";

/// `batch` as typed.
#[derive(Debug, Args)]
#[command(after_long_help = BATCH_NOTES, args_override_self = true)]
pub struct BatchArguments {
    /// The job file: .toml or .jsonl
    #[arg(value_name = "JOBS")]
    pub jobs: PathBuf,
    /// List the jobs on standard output, and which are done, and render nothing
    #[arg(long, help_heading = RUN)]
    pub dry_run: bool,
    /// Where it is noted what has been done [default: results.jsonl beside the job file]
    #[arg(long, value_name = "FILE", help_heading = RUN)]
    pub results: Option<PathBuf>,
    /// Let scenes read, and jobs write, files outside their folders: only for those that you trust
    #[arg(long, help_heading = RUN)]
    pub allow_outside: bool,
    /// Tasks.
    #[command(flatten)]
    pub tasks: TaskArguments,
    /// Threads for all jobs together [default: all processors]
    #[arg(long, value_name = "N", help_heading = RUN)]
    pub threads: Option<usize>,
    /// No progress and no closing line; warnings and errors remain
    #[arg(short, long, help_heading = RUN)]
    pub quiet: bool,
}

const REPORT_NOTES: &str = "\
The page is one file with everything in it, opened from the disk by Chromium 104, Firefox 113, \
Safari 16.4 or newer; it asks the network for nothing, and links to the images by their paths \
from the page. It shows what results.jsonl tells of every job, with small copies of the images \
in any map of 'sunstone visualize', and plots means of Stokes components, degrees, angles and \
seconds over the axes of sweeps. Means are of the whole images, as they are in the files, but \
for pixels that are not finite. Images that are gone, damaged or not those that were rendered \
are told by their jobs and stop nothing, as are images of former runs under the names of jobs \
that have failed. Small copies have up to 160 pixels a side, 64 where \
there are 1,000 images, 24 where there are 7,000 or more: a page of 1,000 takes 20 to 30 MB.";

/// `report` as typed.
#[derive(Debug, Args)]
#[command(after_long_help = REPORT_NOTES)]
pub struct ReportArguments {
    /// The folder of a batch, which holds results.jsonl, or a file of results
    #[arg(value_name = "BATCH_FOLDER")]
    pub batch: PathBuf,
    /// Where to write the page
    #[arg(short, long, value_name = "HTML", allow_hyphen_values = true)]
    pub output: PathBuf,
    /// What the paths of images are relative to: the folder of the job file [default: that of
    /// results.jsonl]
    #[arg(long, value_name = "FOLDER")]
    pub images: Option<PathBuf>,
    /// Longer side of the small copies, 8 to 512 [default: what suits their number]
    #[arg(long, value_name = "PIXELS")]
    pub thumbnails: Option<usize>,
    /// Show images outside the folder, too: only of batches that you trust
    #[arg(long)]
    pub allow_outside: bool,
    /// No progress and no closing line; warnings and errors remain
    #[arg(short, long)]
    pub quiet: bool,
}

const PHOTONS: &str = "Photons (ppm)";
pub(super) const LIGHT: &str = "Light transport";
const SAMPLES: &str = "Samples";
pub(super) const FILM: &str = "Film";
pub(super) const RUN: &str = "Run";

/// `merge` as typed.
#[derive(Debug, Args)]
pub struct MergeArguments {
    /// The parts, in any order: all of an image
    #[arg(value_name = "PART", required = true)]
    pub parts: Vec<PathBuf>,
    /// Where to write; the extension names the format, as for `render`
    #[arg(short, long, value_name = "FILE", allow_hyphen_values = true)]
    pub output: PathBuf,
    /// No closing line
    #[arg(short, long)]
    pub quiet: bool,
}

/// The map that is three maps: the paper's figures.
pub const PANELS: &str = "panels";

/// The map that is the pictures of all analyzers.
pub const ANALYZERS_MAP: &str = "analyzers";
/// The map that is the raw image of a sensor.
pub const MOSAIC: &str = "mosaic";

/// `visualize` as typed.
#[derive(Debug, Args)]
pub struct VisualizeArguments {
    /// The image, in a format that keeps what was rendered (.exr, .hdr, ...)
    pub image: PathBuf,
    /// Where to write the PNG; of one analyzer also .exr or .hdr: what passes, as an image
    #[arg(short, long, value_name = "FILE", allow_hyphen_values = true)]
    pub output: PathBuf,
    /// Which map; `panels` shows intensity, dop and linear-circular as the paper does, `analyzers`
    /// what passes six ideal analyzers, `mosaic` what a camera of polarization records
    #[arg(long, default_value = PANELS, value_parser = map_names())]
    pub map: String,
    /// Exposure of intensities in stops; of a mosaic 1 then fills the well
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_negative_numbers = true)]
    pub exposure: f32,
    /// Which channel of the image.
    #[command(flatten)]
    pub channel: ChannelArguments,
    /// Scales that end at full polarization; without it they end where the image's does, so that
    /// weak polarization shows (the legend says where)
    #[arg(long, visible_alias = "no-fit")]
    pub full_scale: bool,
    /// The sensor.
    #[command(flatten)]
    pub sensor: SensorArguments,
}

/// The sensor of `--map mosaic`.
#[derive(Debug, Args)]
#[command(next_help_heading = MOSAIC_HEADING)]
pub struct SensorArguments {
    /// With a Bayer mosaic of squares of four pixels, or without [default: as the image is]
    #[arg(long, value_enum, value_name = "KIND")]
    pub sensor: Option<SensorName>,
    /// Bits of its numbers: 8, or 12 or 16 in a PNG of 16, where 12 are the lower ones [default: 8]
    #[arg(long, value_name = "N")]
    pub bits: Option<u32>,
    /// Electrons that a pixel holds; without it there is no noise
    #[arg(long, value_name = "ELECTRONS")]
    pub full_well: Option<f64>,
    /// Numbers for an electron [default: such that the full well is the largest number]
    #[arg(long, value_name = "NUMBERS", requires = "full_well")]
    pub gain: Option<f64>,
    /// Standard deviation of reading a pixel out [default: 0]
    #[arg(long, value_name = "ELECTRONS", requires = "full_well")]
    pub read_noise: Option<f64>,
    /// What no light is [default: 0]
    #[arg(long, value_name = "NUMBER")]
    pub black_level: Option<u32>,
    /// Seed of the noise [default: 0]
    #[arg(long, value_name = "N", requires = "full_well")]
    pub seed: Option<u32>,
}

/// Sensors of polarization.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SensorName {
    /// Of luminance, or of the one wavelength, as IMX250MZR
    Mono,
    /// Of red, green and blue, as IMX250MYR
    Color,
}

const MOSAIC_HEADING: &str = "Sensor (mosaic)";

/// The names of all maps.
fn map_names() -> PossibleValuesParser {
    let maps = std::iter::once(PANELS).chain(Map::ALL.into_iter().map(Map::name));
    let analyzers = ANALYZERS.iter().map(|(name, _)| *name);
    maps.chain(analyzers).chain([ANALYZERS_MAP, MOSAIC]).collect::<Vec<_>>().into()
}

const VIEW_NOTES: &str = "\
The page is one file with everything in it, opened from the disk by Chromium 104, Firefox 113, \
Safari 16.4 or newer; it asks the network for nothing. Maps have the colors and legends of \
'sunstone visualize'. The analyzer is an ideal one before the sensor: linear at an angle a from \
the right of the image, counterclockwise, (S0 + S1 cos 2a + S2 sin 2a) / 2; circular, \
(S0 + S3) / 2 and (S0 - S3) / 2. The page is about as large as the values of the images, 12 to \
16 MB for a million pixels of one wavelength; of more than 2 GiB none is written. Bands are shown \
in color, as the CIE 1931 observer sees them, or one by one, with the spectrum of the pixel under \
the pointer; maps of all of them are of their mean.";

/// `view` as typed.
#[derive(Debug, Args)]
#[command(after_long_help = VIEW_NOTES)]
pub struct ViewArguments {
    /// The image, in a format that keeps what was rendered (.exr, .hdr, ...)
    pub image: PathBuf,
    /// A second one of the same size and bands, beyond a divider
    pub other: Option<PathBuf>,
    /// Where to write the page
    #[arg(short, long, value_name = "HTML", allow_hyphen_values = true)]
    pub output: PathBuf,
    /// Leave out the standard errors of values, which are as large as these
    #[arg(long)]
    pub no_variance: bool,
    /// Which channel of the images.
    #[command(flatten)]
    pub channel: ChannelArguments,
}

/// `compare` as typed.
#[derive(Debug, Args)]
pub struct CompareArguments {
    /// The image under test
    pub image: PathBuf,
    /// What it is compared with
    pub reference: PathBuf,
    /// Which channel of the images.
    #[command(flatten)]
    pub channel: ChannelArguments,
    /// Print JSON instead of a table
    #[arg(long)]
    pub json: bool,
    /// Also draw the differences as PNG
    #[arg(long, value_name = "PNG")]
    pub difference: Option<PathBuf>,
}

/// `inspect` as typed.
#[derive(Debug, Args)]
pub struct InspectArguments {
    /// A scene (.gltf, .glb, .xml), an image (.exr, .hdr, ...), or a part of one or a checkpoint by
    /// whatever name
    pub file: PathBuf,
    /// Of an image the Stokes vector of every channel in a pixel, as comma-separated values; pixels
    /// are counted from 0,0 at the upper left
    #[arg(long, value_name = "X,Y")]
    pub pixel: Option<PixelText>,
    /// What a scene may read.
    #[command(flatten)]
    pub files: FileArguments,
}
