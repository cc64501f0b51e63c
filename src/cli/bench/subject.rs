//! What is measured: scenes, ready to be rendered in any color.

use std::path::{Path, PathBuf};

use crate::bench::table1::{PAPER, PaperRow};
use crate::cli::CliError;
use crate::cli::files::say;
use crate::render::session::Session;
use crate::render::{self, Outcome, Settings};
use crate::scattering::Scene;
use crate::scene::{self, World};
use crate::spectrum::Color;

/// A scene of the paper's table that the program carries with it.
struct Shipped {
    file: &'static str,
    bytes: &'static [u8],
    paper: &'static PaperRow,
}

const SHIPPED: [Shipped; 2] = [
    Shipped {
        file: "scenes/mirror.gltf",
        bytes: include_bytes!("../../../scenes/mirror.gltf"),
        paper: &PAPER.rows[0],
    },
    Shipped {
        file: "scenes/tank.gltf",
        bytes: include_bytes!("../../../scenes/tank.gltf"),
        paper: &PAPER.rows[1],
    },
];

/// A scene that has been loaded.
pub struct Subject {
    /// As it was named.
    pub name: String,
    /// Its row in the paper's table.
    pub paper: Option<&'static PaperRow>,
    world: World,
}

impl Subject {
    /// The scene as tables, in a color and on a film of a size.
    pub fn bake(
        &self,
        color: Color,
        (width, height): (u32, u32),
    ) -> Result<Box<dyn Renderable>, CliError> {
        Ok(match color {
            Color::Rgb => {
                Box::new(Scene::new(scene::bake::<3>(&self.world, color)?, width, height))
            }
            Color::Mono { .. } => {
                Box::new(Scene::new(scene::bake::<1>(&self.world, color)?, width, height))
            }
        })
    }

    /// What figures call it: its name, or that of its file without folder and extension.
    pub fn short_name(&self) -> String {
        let stem = Path::new(&self.name).file_stem();
        stem.map_or_else(|| self.name.clone(), |stem| stem.to_string_lossy().into_owned())
    }
}

/// A scene with whatever number of wavelengths.
pub trait Renderable: Sync {
    /// A render that is stepped.
    fn session<'a>(&'a self, settings: &'a Settings) -> Session<'a>;
    /// A render in one go.
    fn render(&self, settings: &Settings) -> Outcome;
}

impl<const N: usize> Renderable for Scene<N> {
    fn session<'a>(&'a self, settings: &'a Settings) -> Session<'a> {
        Session::new(self, settings)
    }

    fn render(&self, settings: &Settings) -> Outcome {
        render::render(self, settings, &|_| ())
    }
}

/// Loads scenes, all before the first is measured; those that the program carries, if none are
/// named.
pub fn load_all(paths: &[PathBuf]) -> Result<Vec<Subject>, CliError> {
    match paths {
        [] => SHIPPED.iter().map(carried).collect(),
        paths => paths.iter().map(|path| load(path)).collect(),
    }
}

/// Loads a scene.
pub fn load(path: &Path) -> Result<Subject, CliError> {
    let world = scene::load(path)?;
    // A copy of a shipped scene is that scene.
    let bytes = std::fs::read(path).unwrap_or_default();
    let shipped = SHIPPED.iter().find(|shipped| shipped.bytes == bytes);
    Ok(subject(path.display().to_string(), shipped.map(|shipped| shipped.paper), world))
}

fn carried(shipped: &Shipped) -> Result<Subject, CliError> {
    let world = scene::load_from_memory(Path::new(shipped.file), shipped.bytes)?;
    Ok(subject(world.name().to_owned(), Some(shipped.paper), world))
}

fn subject(name: String, paper: Option<&'static PaperRow>, world: World) -> Subject {
    for warning in world.warnings() {
        say(format_args!("warning: {name}: {warning}"));
    }
    Subject { name, paper, world }
}
