//! What is seen of a scene, as typed and as validated.

use clap::ValueEnum;
use clap::builder::PossibleValue;

use super::CliError;
use super::args::RenderArguments;
use crate::scene::{LightChoice, View};

/// What shines where nothing does, by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightName(pub LightChoice);

impl ValueEnum for LightName {
    fn value_variants<'a>() -> &'a [Self] {
        &[Self(LightChoice::Auto), Self(LightChoice::None)]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let help = match self.0 {
            LightChoice::Auto => "A neutral sky",
            LightChoice::None => "Nothing: the scene is refused",
        };
        Some(PossibleValue::new(self.0.name()).help(help))
    }
}

/// What is seen of the scene.
pub(super) fn view(arguments: &RenderArguments) -> Result<View, CliError> {
    let RenderArguments { camera, light, time, .. } = arguments;
    let view = View { camera: camera.clone(), light: light.0, time: *time };
    view.check().map_err(|rule| CliError::Usage(format!("--time {rule}")))?;
    Ok(view)
}
