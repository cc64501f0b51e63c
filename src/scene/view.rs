//! How a scene file is seen: what it may leave open.

/// The word that stands for a camera that is put in.
pub const AUTO: &str = "auto";

/// By which camera, in which light and at which moment a scene file is seen.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct View {
    /// The camera: its name or its node's, its number as `#2` or `2`, from 0, or [`AUTO`] for one
    /// that is put in and sees all there is. By default the first of the scene, or one that is put
    /// in where there is none.
    pub camera: Option<String>,
    /// What shines where nothing does.
    pub light: LightChoice,
    /// Seconds into the file's animations, not negative; by default nothing moves, and all is as
    /// the nodes and meshes state it.
    pub time: Option<f64>,
}

/// What shines in a scene in which nothing does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightChoice {
    /// A neutral sky.
    #[default]
    Auto,
    /// Nothing, so that the scene is refused.
    None,
}

impl LightChoice {
    /// What users call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => AUTO,
            Self::None => "none",
        }
    }
}

impl View {
    /// That of a camera.
    pub fn by(camera: impl Into<String>) -> Self {
        Self { camera: Some(camera.into()), ..Self::default() }
    }

    /// Refuses a time that is none, in words that follow its name.
    pub fn check(&self) -> Result<(), String> {
        match self.time {
            Some(time) if !(time >= 0.0 && time.is_finite()) => {
                Err(format!("must be seconds from 0 on, not {time}"))
            }
            _ => Ok(()),
        }
    }
}
