//! The verb `merge`: an image of its parts.

use std::path::Path;

use crate::image::format::{Format, extension, extensions, named_by};
use crate::image::rows::Rows;
use crate::image::{check_savable, files_of};
use crate::math::text::counted;
use crate::render::merge_as_asked_for;

use super::CliError;
use super::args::MergeArguments;
use super::files::{refuse_overwriting, say};
use super::rescue;

/// Writes the image of all parts.
pub(super) fn merge(arguments: &MergeArguments) -> Result<(), CliError> {
    let MergeArguments { parts, output, quiet } = arguments;
    let outputs = files_of(output).map_err(|error| CliError::Usage(error.to_string()))?;
    outputs.iter().try_for_each(|output| refuse_overwriting(output, parts))?;
    check_savable(output)?;
    let (mut image, with_variance) = merge_as_asked_for(parts)?;
    if !with_variance {
        image.drop_variance();
    }
    let keeps = named_by(output, "written", Format::writes_variance).is_ok();
    if with_variance && !keeps {
        // `render` refuses that before it has rendered; here the parts are there and stay.
        say(format_args!(
            "warning: no variances are stored: .{} files hold none; the parts do, and an output \
             that ends in {} keeps them",
            extension(output),
            extensions(Format::writes_variance),
        ));
    }
    let count = ("parts".to_owned(), parts.len().to_string());
    image.metadata.insert(0, count);
    rescue::save(&image, output)?;
    if !quiet {
        let frame = image.frame();
        say(closing_line(output, parts.len(), [frame.width, frame.height]));
    }
    Ok(())
}

fn closing_line(output: &Path, parts: usize, [width, height]: [usize; 2]) -> String {
    let of = counted(parts, ["part", "parts"]);
    format!("{}: {width} x {height}, of {of}", output.display())
}
