//! The command line as typed.

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::output::visualize::Map;

/// Polarized, bidirectional light transport: a glTF scene in, a Stokes image out.
#[derive(Debug, Parser)]
#[command(name = "sunstone", version, arg_required_else_help = true)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const EXAMPLES: &str = "\
Examples:
  sunstone render scenes/cornell.gltf -o cornell.exr
      a polarized RGB render with bidirectional path tracing
  sunstone render scenes/cornell.gltf -o cornell.exr --mode scalar --integrator path --spp 256
      the same scene without polarization, by path tracing
  sunstone visualize cornell.exr -o panels.png
      intensity, degree of polarization and linear-versus-circular side by side
  sunstone compare a.exr b.exr
      errors per Stokes component, and z-scores where the images hold variances
  sunstone inspect scenes/cornell.gltf
      what is in a scene (or an image), in words

Exit codes: 0 done, 1 something went wrong, 2 the command line was wrong.";

/// The verbs.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a glTF scene to a Stokes image
    Render(RenderArguments),
    /// Draw maps of an image's polarization, with legends, as PNG
    Visualize(VisualizeArguments),
    /// Compare two images: errors, and z-scores where they hold variances
    Compare(CompareArguments),
    /// Say in words what is in a scene or an image
    Inspect(InspectArguments),
}

/// Integrators by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum IntegratorName {
    /// From the sensor, with next-event estimation
    Path,
    /// From the emitters, connected to the sensor
    Light,
    /// From both, with all connections
    Bdpt,
}

/// Modes by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ModeName {
    /// Intensity only
    Scalar,
    /// Stokes vectors
    Polarized,
}

/// Color modes by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ColorName {
    /// Red, green and blue
    Rgb,
    /// One wavelength
    Mono,
}

/// Formats of statistics.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum StatsFormat {
    /// A few lines
    Text,
    /// One JSON object
    Json,
}

/// `render` as typed.
#[derive(Debug, Args)]
pub struct RenderArguments {
    /// The scene: .gltf or .glb
    pub scene: PathBuf,
    /// Where to write: .exr (everything), .hdr (S0 and S' of Jarabo and Gutierrez 2016), .png
    #[arg(short, long)]
    pub output: PathBuf,
    /// How light is found
    #[arg(long, value_enum, default_value = "bdpt")]
    pub integrator: IntegratorName,
    /// Intensity only, or Stokes vectors
    #[arg(long, value_enum, default_value = "polarized")]
    pub mode: ModeName,
    /// What the channels stand for
    #[arg(long, value_enum, default_value = "rgb")]
    pub color: ColorName,
    /// Wavelength of `--color mono`, in nanometers [default: 550]
    #[arg(long, value_name = "NM")]
    pub wavelength: Option<f32>,
    /// Samples per pixel (also --iterations)
    #[arg(long, visible_alias = "iterations", value_name = "N", default_value_t = 64)]
    pub spp: u32,
    /// Width in pixels [default: the scene's, or 512]
    #[arg(long, value_name = "PIXELS")]
    pub width: Option<u32>,
    /// Height in pixels [default: from the width and the camera's aspect]
    #[arg(long, value_name = "PIXELS")]
    pub height: Option<u32>,
    /// Most segments of a path: 1 shows emitters only, 2 adds direct light
    #[arg(long, value_name = "SEGMENTS", default_value_t = 16)]
    pub max_path_length: u32,
    /// Segments after which roulette may end a path
    #[arg(long, value_name = "SEGMENTS", default_value_t = 6)]
    pub roulette_after: u32,
    /// Stop after this many seconds, with the iterations done by then
    #[arg(long, value_name = "SECONDS")]
    pub time_limit: Option<f64>,
    /// Seed of all randomness; the same seed gives the same bits on any number of threads
    #[arg(long, default_value_t = 0)]
    pub seed: u32,
    /// Threads [default: all processors]
    #[arg(long)]
    pub threads: Option<usize>,
    /// Name of the camera [default: the scene's first]
    #[arg(long, value_name = "NAME")]
    pub camera: Option<String>,
    /// Also store the variance of every value, from independent replicates
    #[arg(long)]
    pub variance: bool,
    /// Independent replicates that the iterations are split into [default: 16 with --variance]
    #[arg(long, value_name = "N")]
    pub replicates: Option<u32>,
    /// Print what the render took
    #[arg(long, value_enum, value_name = "FORMAT")]
    pub stats: Option<StatsFormat>,
    /// No progress bar and no closing lines
    #[arg(short, long)]
    pub quiet: bool,
}

/// The map that is three maps: the paper's figures.
pub const PANELS: &str = "panels";

/// `visualize` as typed.
#[derive(Debug, Args)]
pub struct VisualizeArguments {
    /// The image: .exr, .hdr or .npy
    pub image: PathBuf,
    /// Where to write the PNG
    #[arg(short, long)]
    pub output: PathBuf,
    /// Which map; `panels` shows intensity, dop and linear-circular as the paper does
    #[arg(long, default_value = PANELS, value_parser = map_names())]
    pub map: String,
    /// Exposure of intensities in stops
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_negative_numbers = true)]
    pub exposure: f32,
    /// Fit the scales to the image, so that weak polarization shows
    #[arg(long)]
    pub fit: bool,
}

fn map_names() -> PossibleValuesParser {
    std::iter::once(PANELS).chain(Map::ALL.into_iter().map(Map::name)).collect::<Vec<_>>().into()
}

/// `compare` as typed.
#[derive(Debug, Args)]
pub struct CompareArguments {
    /// The image under test
    pub image: PathBuf,
    /// What it is compared with
    pub reference: PathBuf,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    /// Also draw the differences as PNG
    #[arg(long, value_name = "PNG")]
    pub difference: Option<PathBuf>,
}

/// `inspect` as typed.
#[derive(Debug, Args)]
pub struct InspectArguments {
    /// A scene (.gltf, .glb) or an image (.exr, .hdr, .npy)
    pub file: PathBuf,
}
