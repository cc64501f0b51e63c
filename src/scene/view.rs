//! How a scene file is seen: what it may leave open.

use crate::math::text::{excerpt, listed, number_of};

/// Most characters of a name in a list of cameras.
const NAME: usize = 60;

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

    /// Which of the cameras of a file is wanted: its place among them; none if one is to be put in.
    ///
    /// # Errors
    /// What is wrong and how to mend it, when there is no such camera, or more than one may be
    /// meant.
    pub(super) fn camera_of(&self, cameras: &[Seer]) -> Result<Option<usize>, (String, String)> {
        match (self.camera.as_deref(), cameras) {
            (Some(AUTO), _) | (None, []) => Ok(None),
            (None, [_, ..]) => Ok(Some(0)),
            (Some(wanted), _) => chosen(cameras, wanted).map(Some),
        }
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

/// A camera of a file.
pub(super) struct Seer<'a> {
    /// What it is called, by all its names.
    pub names: Vec<&'a str>,
    /// Its number in the file.
    pub number: usize,
}

/// The place of the camera of a name, or of a number, as `#0`, `#00` or `0`, if only one is meant.
fn chosen(cameras: &[Seer], wanted: &str) -> Result<usize, (String, String)> {
    let places = || cameras.iter().enumerate();
    let named: Vec<usize> =
        places().filter(|(_, it)| it.names.contains(&wanted)).map(|(place, _)| place).collect();
    // A name that is a number is a name first.
    let plain = || named.is_empty().then(|| number_of(&format!("#{wanted}"))).flatten();
    let number = number_of(wanted).or_else(plain);
    let same = |place: usize| Some(cameras[place].number) == number;
    let numbered = places().map(|(place, _)| place).find(|place| same(*place));
    let problem = match (&named[..], numbered) {
        (&[place], other) if other.is_none() || same(place) => return Ok(place),
        (&[_], _) => "one camera is called, and another has the index",
        ([], Some(place)) => return Ok(place),
        ([], None) => "no camera is called",
        (_, _) => "several cameras are called",
    };
    let known = cameras.iter().map(|camera| {
        let names = excerpt(&camera.names.join(" or "), NAME);
        format!("#{} {names}", camera.number).trim_end().to_owned()
    });
    let remedy = match cameras.is_empty() {
        true => format!("the scene has none; `{AUTO}` puts one in"),
        false => format!("the cameras are {}, and `{AUTO}` puts one in", listed(known)),
    };
    Err((format!("{problem} `{}`", excerpt(wanted, NAME)), remedy))
}
