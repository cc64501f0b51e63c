//! The verbs `view`, `compare` and `inspect`.

use std::path::Path;
use std::str::FromStr;

use clap::Args;

use crate::image::cut::{CROP, FILTER, PIXEL_ASPECT};
use crate::image::view::{self as pages, Named};
use crate::image::{self, compare as comparison, inspect as image_inspection, png};
use crate::image::{OutputError, StokesImage, extension};
use crate::render::{PlacedWorld, describe_part, is_part};
use crate::scene::{self, View, World};

use super::CliError;
use super::args::{CompareArguments, InspectArguments, ViewArguments};
use super::files::{json, print, refuse_overwriting, require_html, require_png, say};
use super::job::PART;

/// Which channel is looked at, of an image that has several.
#[derive(Debug, Args)]
pub struct ChannelArguments {
    /// Of bands the one that has this wavelength, in nanometers [default: all, or their mean]
    #[arg(long, value_name = "NM", conflicts_with = "channel")]
    pub wavelength: Option<f32>,
    /// The channel of this name: R, G or B, or that of a band or a response [default: all, or their
    /// mean; of responses red, green and blue these]
    #[arg(long, value_name = "NAME")]
    pub channel: Option<String>,
}

/// Two numbers of a pixel with a comma between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelText(pub [usize; 2]);

impl FromStr for PixelText {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text
            .split_once(',')
            .and_then(|(x, y)| Some([x.trim().parse().ok()?, y.trim().parse().ok()?]));
        numbers.map(Self).ok_or_else(|| "it is two numbers, as in 12,7".to_owned())
    }
}

/// Writes a page to look at images in.
pub(super) fn view(arguments: &ViewArguments) -> Result<(), CliError> {
    let paths: Vec<&Path> =
        std::iter::once(&arguments.image).chain(&arguments.other).map(|path| &**path).collect();
    require_html(&arguments.output)?;
    refuse_overwriting(&arguments.output, &paths)?;
    let load = |path: &&Path| load_at(path, &arguments.channel);
    let mut images = paths.iter().map(load).collect::<Result<Vec<_>, _>>()?;
    if arguments.no_variance {
        images.iter_mut().for_each(|image| image.variance = None);
    }
    let mut names = names_of(&paths);
    for (name, image) in names.iter_mut().zip(&images) {
        if let Some(channel) = image.channel() {
            *name += &format!(", {channel}");
        }
    }
    let named: Vec<Named> =
        names.iter().zip(&images).map(|(name, image)| Named { name, image }).collect();
    let bytes = pages::write(&named, &arguments.output)?;
    say(format_args!("{}: {:.1} MB", arguments.output.display(), bytes as f64 / 1e6));
    Ok(())
}

/// Reads an image, or that of one of its channels.
pub(super) fn load_at(path: &Path, of: &ChannelArguments) -> Result<StokesImage, OutputError> {
    let image = image::load(path)?;
    match (of.wavelength, &of.channel) {
        (Some(wavelength_nm), _) => image.at_wavelength(wavelength_nm),
        (None, Some(name)) => image.at_channel(name),
        (None, None) => Ok(image),
    }
}

/// What the images are called on a page: their files' names, with the folders before if the names
/// are alike.
fn names_of(paths: &[&Path]) -> Vec<String> {
    let short = |path: &Path| path.file_name().map(|name| name.to_string_lossy().into_owned());
    let are_alike = paths.len() > 1 && short(paths[0]) == short(paths[1]);
    let name = |path: &&Path| short(path).filter(|_| !are_alike);
    paths
        .iter()
        .map(|path| name(path).unwrap_or_else(|| path.to_string_lossy().into_owned()))
        .collect()
}

/// Prints how two images differ.
pub(super) fn compare(arguments: &CompareArguments) -> Result<(), CliError> {
    if let Some(path) = &arguments.difference {
        require_png(path)?;
        refuse_overwriting(path, &[&arguments.image, &arguments.reference])?;
    }
    let image = load_at(&arguments.image, &arguments.channel)?;
    let reference = load_at(&arguments.reference, &arguments.channel)?;
    let comparison = comparison::compare(&image, &reference)?;
    for what in [FILTER, CROP, PIXEL_ASPECT] {
        let said = [&image, &reference].map(|image| image.metadata(what));
        // What says nothing of a filter may have any; of others, what says nothing has none.
        let are_known = what != FILTER || said.iter().all(Option::is_some);
        if are_known && said[0] != said[1] {
            let [one, other] = said.map(|it| it.unwrap_or("none"));
            say(format_args!("warning: the {what} of one is {one}, of the other {other}"));
        }
    }
    if arguments.json {
        print(json(&comparison)?)?;
    } else {
        print(&comparison)?;
    }
    if let Some(path) = &arguments.difference {
        png::write(&comparison::difference_picture(&image, &reference)?, path)?;
    }
    Ok(())
}

/// The same error, where a scene would do too.
fn or_scenes(error: OutputError) -> OutputError {
    if let OutputError::Extension { path, known } = error {
        return OutputError::Extension { path, known: known + ", .gltf, .glb, .xml" };
    }
    error
}

/// What is in a scene, and what will become of it.
fn inspect_scene(world: World) -> String {
    let text = world.describe();
    let placed = PlacedWorld::new(world).map_err(|error| error.to_string());
    match placed.and_then(|placed| placed.describe().map_err(|error| error.to_string())) {
        Ok(more) => text + &more,
        Err(error) => text + &format!("warning: it cannot be rendered: {error}\n"),
    }
}

/// Prints what a pixel of an image has.
fn inspect_pixel(path: &Path, PixelText(pixel): PixelText) -> Result<(), CliError> {
    let is_no_image =
        ["gltf", "glb", "xml", PART].contains(&extension(path).as_str()) || is_part(path);
    if is_no_image {
        let text = format!("--pixel goes with images, and {} is none", path.display());
        return Err(CliError::Usage(text));
    }
    print(image_inspection::pixel(&image::load(path)?, pixel)?.trim_end())
}

/// Prints what is in a file.
pub(super) fn inspect(arguments: &InspectArguments) -> Result<(), CliError> {
    if let Some(pixel) = arguments.pixel {
        return inspect_pixel(&arguments.file, pixel);
    }
    // Checkpoints are called as their users like.
    if is_part(&arguments.file) || extension(&arguments.file) == PART {
        return print(describe_part(&arguments.file)?.trim_end());
    }
    match extension(&arguments.file).as_str() {
        "gltf" | "glb" | "xml" => {
            let reading = arguments.files.reading(View::default());
            print(inspect_scene(scene::load_with(&arguments.file, &reading)?).trim_end())
        }
        _ => print(image_inspection::inspect_image(&arguments.file).map_err(or_scenes)?.trim_end()),
    }
}
