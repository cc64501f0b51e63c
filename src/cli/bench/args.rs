//! `bench` as typed.

use std::path::PathBuf;

use clap::builder::PossibleValue;
use clap::{Args, Subcommand, ValueEnum};

use crate::bench::measure::scaling::SeriesKind;
use crate::cli::args::{IntegratorName, ModeName, StatsFormat};
use crate::cli::color::ColorArguments;
use crate::cli::files::FileArguments;

/// Most segments of a path where no number is given: what measurements have always had, so that
/// they compare.
pub const PATH_LENGTH: u32 = 16;

/// `bench` as typed.
#[derive(Debug, Args)]
pub struct BenchArguments {
    /// What to measure.
    #[command(subcommand)]
    pub what: Bench,
}

/// What can be measured.
#[derive(Debug, Subcommand)]
pub enum Bench {
    /// What polarization costs: the paper's Table 1, and the stages behind it
    Table1(Table1Arguments),
    /// What polarization costs in any scenes, by any integrators, stage by stage
    Overhead(OverheadArguments),
    /// What wavelengths cost: one, three, four and eight of them, in both modes
    #[command(after_long_help = WAVELENGTHS_NOTES)]
    Wavelengths(OverheadArguments),
    /// How time grows with threads, samples, photons, pixels and wavelengths
    Scaling(ScalingArguments),
    /// How errors fall with time: integrators against each other
    Error(ErrorArguments),
    /// What has been recorded: how figures have changed
    History(HistoryArguments),
}

const TABLE1_NOTES: &str = "\
Renders each scene twice at once with progressive photon mapping in RGB, without and with \
polarization. Both trace the same paths. Their iterations alternate, so that whatever else the \
machine does hits both alike; the first of each, which also finds the radius of the kernels, is \
not counted.

The tables go to standard output; progress and warnings go to standard error. They mean most on a \
machine that does nothing else.";

const OVERHEAD_NOTES: &str = "\
Renders each scene twice at once with each integrator, without and with polarization. Both trace \
the same paths. Their rounds alternate, and every other begins with the other mode, so that \
whatever else the machine does hits both alike; the first round of each, which fills tables and \
finds the radius of the kernels, is not counted.

Ratios are medians over the rounds, with an interval that holds them whatever their distribution. \
A scene that takes milliseconds a round tells little: give more --spp.";

const WAVELENGTHS_NOTES: &str = "\
Renders each scene eight times at once with each integrator: at one wavelength, in RGB, and at \
four and eight wavelengths together, without and with polarization. Rounds go through all of them \
up and down, so that whatever else the machine does hits all alike; the first round, which fills \
tables and finds the radius of the kernels, is not counted.

Ratios are to the seconds of RGB in the same mode and round, and of the modes to each other. \
--color mono names the one wavelength by --wavelength; --color spectral the range and the film of \
four and eight, which is RGB otherwise.";

const SCALING_NOTES: &str = "\
Renders a scene at several sizes of the work and fits a line to the logarithms: a slope of 1 is \
time in proportion, 0 is time that does not depend on it, and -1, for threads and the clock on the \
wall, is perfect speedup. Rounds go through all sizes of a series up and down, so that whatever \
else the machine does spreads over them; the first round is not counted. Small renders are \
repeated until they take a tenth of a second. Times are of everything that a render does once the \
scene is baked.

threads: from 1 to all processors. samples: 1 to 32 per pixel. photons: 10 thousand to 4 million, \
with ppm on a film of 16 x 16. pixels: 64 x 64 to 1024 x 1024, of 4 samples. wavelengths: one, \
RGB, four and eight. Each series takes a minute or so.";

const ERROR_NOTES: &str = "\
Renders a scene with each integrator, and compares its image with a reference after 1, 2, 4, 8, \
... iterations (with ppm, passes of photons with one sample a pixel). Then compares the \
integrators with the first: errors at equal time, and times to equal error, interpolated between \
what was measured and never beyond.

Without --reference, one is rendered first, with a seed of its own and with variances. A reference \
must have the size and the channels of the render.";

const HISTORY_NOTES: &str = "\
The file is what --record of the other measurements appends to. Figures of different processors or \
numbers of threads are kept apart. They can only be compared if they were measured with the same \
options.";

const WORK: &str = "Work";
const REPORT: &str = "Report";

/// Where a report goes.
#[derive(Debug, Args)]
#[command(next_help_heading = REPORT)]
pub struct ReportArguments {
    /// What to print on standard output
    #[arg(long, value_enum, value_name = "FORMAT", default_value = "text")]
    pub format: StatsFormat,
    /// Also write the report with all that was measured as JSON
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Also draw it, as SVG
    #[arg(long, value_name = "FILE")]
    pub plot: Option<PathBuf>,
}

/// Where a report and its figures go.
#[derive(Debug, Args)]
#[command(next_help_heading = REPORT)]
pub struct RecordedReportArguments {
    /// Where the report goes.
    #[command(flatten)]
    pub report: ReportArguments,
    /// Also append the figures to this file, one line of JSON; see `bench history`
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
}

/// What is rendered, whatever is measured on it.
#[derive(Debug, Args)]
#[command(next_help_heading = WORK)]
pub struct WorkArguments {
    /// What the channels stand for, and what light is carried at.
    #[command(flatten)]
    pub color: ColorArguments,
    /// Width in pixels [default: that of a --reference, or 256]
    #[arg(long, value_name = "PIXELS")]
    pub width: Option<u32>,
    /// Height in pixels [default: that of a --reference, or 256]
    #[arg(long, value_name = "PIXELS")]
    pub height: Option<u32>,
    /// Light paths an iteration, with ppm [default: 1000000]
    #[arg(long, value_name = "N")]
    pub photons: Option<u32>,
    /// Most segments of a path
    #[arg(long, value_name = "SEGMENTS", default_value_t = PATH_LENGTH)]
    pub max_path_length: u32,
    /// Segments after which roulette may end a path [default: as of render]
    #[arg(long, value_name = "SEGMENTS")]
    pub roulette_after: Option<u32>,
    /// Seed of all randomness
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u32,
    /// Threads [default: all processors]
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    /// What scenes may read.
    #[command(flatten)]
    pub files: FileArguments,
}

/// `bench table1` as typed.
#[derive(Debug, Args)]
#[command(after_long_help = TABLE1_NOTES, args_override_self = true)]
pub struct Table1Arguments {
    /// Scenes, .gltf or .glb [default: the mirror and the tank that come with the program]
    #[arg(value_name = "SCENE")]
    pub scenes: Vec<PathBuf>,
    /// Iterations that are measured in each mode
    #[arg(long, value_name = "N", default_value_t = 8)]
    pub iterations: u32,
    /// Light paths an iteration
    #[arg(long, value_name = "N", default_value_t = 1_000_000)]
    pub photons: u32,
    /// Samples per pixel an iteration
    #[arg(long, value_name = "N", default_value_t = 16)]
    pub samples_per_iteration: u32,
    /// Width in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = 512)]
    pub width: u32,
    /// Height in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = 512)]
    pub height: u32,
    /// Seed of all randomness
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u32,
    /// Threads [default: all processors]
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    /// What scenes may read.
    #[command(flatten)]
    pub files: FileArguments,
    /// Where the report and its figures go.
    #[command(flatten)]
    pub output: RecordedReportArguments,
}

/// `bench overhead` and `bench wavelengths` as typed.
#[derive(Debug, Args)]
#[command(after_long_help = OVERHEAD_NOTES, args_override_self = true)]
pub struct OverheadArguments {
    /// Scenes, .gltf or .glb [default: the mirror and the tank that come with the program]
    #[arg(value_name = "SCENE")]
    pub scenes: Vec<PathBuf>,
    /// Integrators, one or several
    #[arg(long, value_enum, value_delimiter = ',', default_value = "path,bdpt,ppm")]
    #[arg(value_name = "NAME", help_heading = WORK)]
    pub integrator: Vec<IntegratorName>,
    /// Rounds that are measured in each mode
    #[arg(long, value_name = "N", default_value_t = 9, help_heading = WORK)]
    pub rounds: u32,
    /// Samples per pixel of a round [default: 16]
    #[arg(long, value_name = "N", conflicts_with = "iterations", help_heading = WORK)]
    pub spp: Option<u32>,
    /// Iterations of a round: one sample in every pixel, or, with ppm, one pass of photons and
    /// the samples of --samples-per-iteration
    #[arg(long, value_name = "N", help_heading = WORK)]
    pub iterations: Option<u32>,
    /// Samples per pixel an iteration, with ppm [default: 16]
    #[arg(long, value_name = "N", help_heading = WORK)]
    pub samples_per_iteration: Option<u32>,
    /// What is rendered.
    #[command(flatten)]
    pub work: WorkArguments,
    /// Where the report and its figures go.
    #[command(flatten)]
    pub output: RecordedReportArguments,
}

/// A series by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SeriesName(pub SeriesKind);

impl ValueEnum for SeriesName {
    fn value_variants<'a>() -> &'a [Self] {
        static NAMES: [SeriesName; SeriesKind::ALL.len()] = {
            let [a, b, c, d, e] = SeriesKind::ALL;
            [SeriesName(a), SeriesName(b), SeriesName(c), SeriesName(d), SeriesName(e)]
        };
        &NAMES
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let help = match self.0 {
            SeriesKind::Threads => "Threads, from 1 to all processors",
            SeriesKind::Samples => "Samples per pixel",
            SeriesKind::Photons => "Light paths an iteration, with ppm",
            SeriesKind::Pixels => "Pixels of the film",
            SeriesKind::Wavelengths => "Wavelengths or channels",
        };
        Some(PossibleValue::new(self.0.name()).help(help))
    }
}

/// `bench scaling` as typed.
#[derive(Debug, Args)]
#[command(after_long_help = SCALING_NOTES, args_override_self = true)]
pub struct ScalingArguments {
    /// The scene, .gltf or .glb [default: the mirror that comes with the program]
    pub scene: Option<PathBuf>,
    /// Which series, one or several
    #[arg(long, value_enum, value_delimiter = ',', value_name = "NAME", help_heading = WORK)]
    #[arg(default_value = "threads,samples,photons,pixels,wavelengths")]
    pub series: Vec<SeriesName>,
    /// Points of a series at most, the smallest first [default: all]
    #[arg(long, value_name = "N", help_heading = WORK)]
    pub points: Option<u32>,
    /// Rounds that are measured
    #[arg(long, value_name = "N", default_value_t = 5, help_heading = WORK)]
    pub rounds: u32,
    /// The integrator of all series but that of photons
    #[arg(long, value_enum, value_name = "NAME", default_value = "bdpt", help_heading = WORK)]
    pub integrator: IntegratorName,
    /// Without polarization, or with it: on a film of intensities or of Stokes vectors
    #[arg(long, value_enum, default_value = "polarized", help_heading = WORK)]
    pub mode: ModeName,
    /// Samples per pixel where they do not grow [default: 16; 4 of pixels, 1 of photons]
    #[arg(long, value_name = "N", help_heading = WORK)]
    pub spp: Option<u32>,
    /// What is rendered.
    #[command(flatten)]
    pub work: WorkArguments,
    /// Where the report and its figures go.
    #[command(flatten)]
    pub output: RecordedReportArguments,
}

/// `bench error` as typed.
#[derive(Debug, Args)]
#[command(after_long_help = ERROR_NOTES, args_override_self = true)]
pub struct ErrorArguments {
    /// The scene, .gltf or .glb
    pub scene: PathBuf,
    /// The image that errors are measured against: .exr, .hdr or .npy [default: one is rendered]
    #[arg(long, value_name = "IMAGE", help_heading = WORK)]
    pub reference: Option<PathBuf>,
    /// Integrator of a reference that is rendered
    #[arg(long, value_enum, value_name = "NAME", default_value = "bdpt", help_heading = WORK)]
    #[arg(conflicts_with = "reference")]
    pub reference_integrator: IntegratorName,
    /// Samples per pixel of a reference that is rendered
    #[arg(long, value_name = "N", default_value_t = 1024, help_heading = WORK)]
    #[arg(conflicts_with = "reference")]
    pub reference_spp: u32,
    /// Integrators, one or several; the others are compared with the first
    #[arg(long, value_enum, value_delimiter = ',', default_value = "path,bdpt,ppm")]
    #[arg(value_name = "NAME", help_heading = WORK)]
    pub integrator: Vec<IntegratorName>,
    /// Without polarization, or with it: on a film of intensities or of Stokes vectors
    #[arg(long, value_enum, default_value = "polarized", help_heading = WORK)]
    pub mode: ModeName,
    /// Renders of each integrator, whose errors are averaged: 1 shows the luck of a seed
    #[arg(long, value_name = "N", default_value_t = 3, help_heading = WORK)]
    pub seeds: u32,
    /// CPU seconds that each of them may take
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0, help_heading = WORK)]
    pub seconds: f64,
    /// Most iterations of each
    #[arg(long, value_name = "N", default_value_t = 1 << 20, help_heading = WORK)]
    pub iterations: u32,
    /// What is rendered.
    #[command(flatten)]
    pub work: WorkArguments,
    /// Where the report and its figures go.
    #[command(flatten)]
    pub output: RecordedReportArguments,
}

/// `bench history` as typed.
#[derive(Debug, Args)]
#[command(after_long_help = HISTORY_NOTES, args_override_self = true)]
pub struct HistoryArguments {
    /// The record
    pub file: PathBuf,
    /// Only figures whose names begin so; may be given several times
    #[arg(long, value_name = "PREFIX")]
    pub figure: Vec<String>,
    /// Only processors whose model contains this
    #[arg(long, value_name = "MODEL")]
    pub cpu: Option<String>,
    /// Where the report goes.
    #[command(flatten)]
    pub report: ReportArguments,
}
