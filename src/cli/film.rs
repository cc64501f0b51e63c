//! The film on the command line: how its pixels see, and which of them are rendered.

use clap::builder::PossibleValue;
use clap::{Args, ValueEnum};

use super::args::FILM;
use crate::film::filter::{FilterKind, FilterSamples};
use crate::film::layout::Crop;
use crate::image::layers::LayerKind;
use crate::render::Options;

/// A filter, by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FilterName(pub FilterKind);

impl ValueEnum for FilterName {
    fn value_variants<'a>() -> &'a [Self] {
        static NAMES: [FilterName; FilterKind::ALL.len()] = {
            let [a, b, c, d, e, f] = FilterKind::ALL;
            [
                FilterName(a),
                FilterName(b),
                FilterName(c),
                FilterName(d),
                FilterName(e),
                FilterName(f),
            ]
        };
        &NAMES
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.0.name()).help(self.0.summary()))
    }
}

/// What samples of a filter count for, by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SamplesName(pub FilterSamples);

impl ValueEnum for SamplesName {
    fn value_variants<'a>() -> &'a [Self] {
        static NAMES: [SamplesName; FilterSamples::ALL.len()] = {
            let [a, b] = FilterSamples::ALL;
            [SamplesName(a), SamplesName(b)]
        };
        &NAMES
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.0.name()).help(self.0.summary()))
    }
}

/// The film as typed, but for its size.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = FILM)]
pub struct FilmArguments {
    /// How light about a pixel counts for it [default: the scene's, or box]
    #[arg(long, value_enum, value_name = "NAME")]
    pub filter: Option<FilterName>,
    /// Where the filter ends, in pixels from the center [default: the filter's, or the scene's]
    #[arg(long, value_name = "PIXELS")]
    pub filter_radius: Option<f32>,
    /// Which pixels samples count for where the filter is wider than a pixel [default: shared,
    /// unless its lobes hardly cancel over pixels]
    #[arg(long, value_enum, value_name = "NAME")]
    pub filter_samples: Option<SamplesName>,
    /// Render a part of the film alone: left, top, right, bottom in pixels (100,50,300,200) or in
    /// percent (25%,25%,75%,75%); its pixels are those of the whole, bit for bit [default: the
    /// scene's, or all]
    #[arg(long, value_name = "X0,Y0,X1,Y1")]
    pub crop: Option<Crop>,
    /// Also store what the camera sees first, in RGB: depth, normal, albedo, position, uv,
    /// material, object, with commas between (.exr only); means over 16 samples, or of uv and the
    /// numbers of materials and objects what is at the pixel's center
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub layers: Vec<LayerKind>,
    /// Width of a pixel over its height [default: the scene's, or 1]
    #[arg(long, value_name = "RATIO")]
    pub pixel_aspect: Option<f32>,
}

impl FilmArguments {
    /// The same options with these.
    pub fn with(&self, options: Options) -> Options {
        Options {
            filter: self.filter.map(|name| name.0),
            filter_radius: self.filter_radius,
            filter_samples: self.filter_samples.map(|name| name.0),
            crop: self.crop,
            pixel_aspect: self.pixel_aspect,
            layers: self.layers.clone(),
            ..options
        }
    }
}
