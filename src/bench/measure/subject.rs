//! What is measured: scenes, ready to be rendered in any color.

use std::path::{Path, PathBuf};

use crate::bench::table1::{PAPER, PaperRow};
use crate::render::{PlacedWorld, RenderError};
use crate::scene::{self, Reading, World};

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
    /// What the scene asks for and the renderer ignores, one sentence each.
    pub warnings: Vec<String>,
    /// The scene itself.
    pub world: PlacedWorld,
}

impl Subject {
    /// What figures call it: its name, or that of its file without folder and extension.
    pub fn short_name(&self) -> String {
        let stem = Path::new(&self.name).file_stem();
        stem.map_or_else(|| self.name.clone(), |stem| stem.to_string_lossy().into_owned())
    }
}

/// Loads scenes, all before the first is measured; those that the program carries, if none are
/// named.
pub fn load_all(paths: &[PathBuf], reading: Reading) -> Result<Vec<Subject>, RenderError> {
    match paths {
        [] => SHIPPED.iter().map(carried).collect(),
        paths => paths.iter().map(|path| load(path, reading)).collect(),
    }
}

/// Loads a scene.
pub fn load(path: &Path, reading: Reading) -> Result<Subject, RenderError> {
    let world = scene::load_with(path, reading)?;
    // A copy of a shipped scene is that scene.
    let bytes = std::fs::read(path).unwrap_or_default();
    let shipped = SHIPPED.iter().find(|shipped| shipped.bytes == bytes);
    subject(path.display().to_string(), shipped.map(|shipped| shipped.paper), world)
}

fn carried(shipped: &Shipped) -> Result<Subject, RenderError> {
    let world = scene::load_from_memory(Path::new(shipped.file), shipped.bytes)?;
    subject(world.name().to_owned(), Some(shipped.paper), world)
}

fn subject(
    name: String,
    paper: Option<&'static PaperRow>,
    world: World,
) -> Result<Subject, RenderError> {
    let world = PlacedWorld::new(world)?;
    let warnings = world.warnings().map(str::to_owned).collect();
    Ok(Subject { name, paper, warnings, world })
}
