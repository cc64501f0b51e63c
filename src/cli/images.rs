//! The verbs that need no renderer: `visualize`, `compare`, `inspect`.

use std::path::Path;

use crate::output::visualize::{Map, View, panels, visualize as draw};
use crate::output::{self, compare as comparison, inspect as image_inspection, png};
use crate::scene;

use super::CliError;
use super::args::{CompareArguments, InspectArguments, PANELS, VisualizeArguments};

/// Draws a map of an image's polarization.
pub(super) fn visualize(arguments: &VisualizeArguments) -> Result<(), CliError> {
    require_png(&arguments.output)?;
    let image = output::load(&arguments.image)?;
    let mut view = if arguments.fit { View::fitted(&image) } else { View::default() };
    view.exposure_ev = arguments.exposure;
    let picture = match Map::ALL.into_iter().find(|map| map.name() == arguments.map) {
        Some(map) => draw(&image, map, &view)?,
        None => {
            debug_assert_eq!(arguments.map, PANELS);
            panels(&image, &view)?
        }
    };
    Ok(png::write(&picture, &arguments.output)?)
}

/// Prints how two images differ.
pub(super) fn compare(arguments: &CompareArguments) -> Result<(), CliError> {
    if let Some(path) = &arguments.difference {
        require_png(path)?;
    }
    let image = output::load(&arguments.image)?;
    let reference = output::load(&arguments.reference)?;
    let comparison = comparison::compare(&image, &reference)?;
    if arguments.json {
        let text = serde_json::to_string_pretty(&comparison)
            .map_err(|error| CliError::System(format!("cannot write JSON: {error}")))?;
        println!("{text}");
    } else {
        println!("{comparison}");
    }
    if let Some(path) = &arguments.difference {
        png::write(&comparison::difference_picture(&image, &reference)?, path)?;
    }
    Ok(())
}

/// Prints what is in a file.
pub(super) fn inspect(arguments: &InspectArguments) -> Result<(), CliError> {
    let extension = arguments.file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if extension == "gltf" || extension == "glb" {
        let world = scene::load(&arguments.file)?;
        println!("{}", world.describe());
        for warning in world.warnings() {
            println!("warning: {warning}");
        }
    } else {
        println!("{}", image_inspection::inspect_image(&arguments.file)?);
    }
    Ok(())
}

fn require_png(path: &Path) -> Result<(), CliError> {
    let is_png = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png"));
    if is_png {
        return Ok(());
    }
    Err(CliError::Usage(format!("{} must end in .png: pictures are PNG files", path.display())))
}
