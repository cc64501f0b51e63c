//! The verb `convert`: a scene of any format as glTF.

use std::path::PathBuf;

use clap::Args;

use crate::scene::{self, AUTO, LightChoice, View, Written};

use super::CliError;
use super::files::{FileArguments, refuse_overwriting, require_gltf, say};

const NOTES: &str = "\
The file has all that was understood of the scene, its meshes too; what glTF has no words for is \
in the extension SUNSTONE_polarization. Pictures and measured tables are in a .glb; of a .gltf \
they are copied beside it, unless they lie in its folder or below: no file there is replaced by \
another. No camera and no light is put in. What is not written as it is, a warning tells. Angles \
of view have single precision, so an image of it may have other last bits.";

/// `convert` as typed.
#[derive(Debug, Args)]
#[command(after_long_help = NOTES)]
pub struct ConvertArguments {
    /// The scene: .xml, .gltf or .glb
    #[arg(value_name = "SCENE")]
    pub scene: PathBuf,
    /// Where to write it: .gltf or .glb
    #[arg(value_name = "GLTF")]
    pub output: PathBuf,
    /// What the scene may read.
    #[command(flatten)]
    pub files: FileArguments,
    /// The camera that is written: its name, or 0, 1, ... [default: the first, if there is one]
    #[arg(long, value_name = "NAME")]
    pub camera: Option<String>,
}

/// Writes a scene as glTF, and says what is not written as it is.
pub(super) fn convert(arguments: &ConvertArguments) -> Result<(), CliError> {
    let ConvertArguments { scene, output, files, camera } = arguments;
    require_gltf(output)?;
    refuse_overwriting(output, &[scene])?;
    if camera.as_deref() == Some(AUTO) {
        let text = "--camera names one that the scene has: what is put in is not written";
        return Err(CliError::Usage(text.to_owned()));
    }
    let view = View { camera: camera.clone(), light: LightChoice::None, time: None };
    let world = scene::load_with(scene, &files.reading(view))?;
    refuse_overwriting(output, world.files())?;
    let written = Written::of(&world)?;
    let warnings = world.warnings().iter().chain(written.warnings());
    warnings.for_each(|warning| say(format_args!("warning: {warning}")));
    for file in written.save(output)? {
        say(format_args!("note: beside it: {}", file.display()));
    }
    Ok(())
}
