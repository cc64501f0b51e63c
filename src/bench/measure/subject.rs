//! What is measured: scenes, ready to be rendered in any color.

use std::ffi::OsString;
use std::path::{Path, PathBuf, absolute};

use crate::bench::figures::part;
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
    /// What reports and figures call it: its file without folder and extension, or with what of
    /// these tells it from others.
    pub label: String,
    /// Its row in the paper's table.
    pub paper: Option<&'static PaperRow>,
    /// What the scene asks for and the renderer ignores, one sentence each.
    pub warnings: Vec<String>,
    /// The scene itself.
    pub world: PlacedWorld,
}

/// Loads scenes, all before the first is measured; those that the program carries, if none are
/// named.
pub fn load_all(paths: &[PathBuf], reading: &Reading) -> Result<Vec<Subject>, RenderError> {
    let mut subjects: Vec<Subject> = match paths {
        [] => SHIPPED.iter().map(carried).collect::<Result<_, _>>()?,
        paths => paths.iter().map(|path| load(path, reading)).collect::<Result<_, _>>()?,
    };
    let names: Vec<&str> = subjects.iter().map(|subject| subject.name.as_str()).collect();
    for (label, subject) in labels(&names).into_iter().zip(&mut subjects) {
        subject.label = label;
    }
    Ok(subjects)
}

/// What files are called in a report: by their names without extension. Those that figures would
/// write alike have as many of their folders before them as tell them apart; those of one folder
/// keep their extensions. Only a file that is there twice is called so twice.
fn labels(names: &[&str]) -> Vec<String> {
    let paths: Vec<PathBuf> =
        names.iter().map(|name| absolute(name).unwrap_or_else(|_| name.into())).collect();
    let beside =
        |path: &Path| (path.parent().map(Path::to_owned), path.file_stem().map(Into::into));
    let beside: Vec<(Option<PathBuf>, Option<OsString>)> =
        paths.iter().map(|path| beside(path)).collect();
    let words: Vec<Vec<String>> = paths
        .iter()
        .enumerate()
        .map(|(index, path)| {
            let has_twin = (0..paths.len()).any(|it| it != index && beside[it] == beside[index]);
            let path = if has_twin { path.clone() } else { path.with_extension("") };
            path.iter().rev().map(|word| word.to_string_lossy().into_owned()).collect()
        })
        .collect();
    let label =
        |words: &[String]| words.iter().rev().map(String::as_str).collect::<Vec<_>>().join("/");
    let mut counts = vec![1; paths.len()];
    loop {
        let labels: Vec<String> =
            words.iter().zip(&counts).map(|(words, &count)| label(&words[..count])).collect();
        let written: Vec<String> = labels.iter().map(|label| part(label)).collect();
        let can_grow = |&index: &usize| {
            let is_alike = |other: usize| other != index && written[other] == written[index];
            (0..paths.len()).any(is_alike) && counts[index] < words[index].len()
        };
        let grown: Vec<usize> = (0..paths.len()).filter(can_grow).collect();
        if grown.is_empty() {
            return labels;
        }
        grown.into_iter().for_each(|index| counts[index] += 1);
    }
}

/// Loads a scene.
pub fn load(path: &Path, reading: &Reading) -> Result<Subject, RenderError> {
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
    let label = labels(&[&name]).swap_remove(0);
    Ok(Subject { name, label, paper, warnings, world })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_of_one_name_are_told_apart_by_their_folders() {
        assert_eq!(labels(&["mirror", "scenes/my tank.v2.gltf"]), ["mirror", "my tank.v2"]);
        let names = ["a/room.gltf", "b/room.gltf", "b/hall.gltf"];
        assert_eq!(labels(&names), ["a/room", "b/room", "hall"]);
        let names = ["x/in/room.gltf", "y/in/room.gltf", "y/room.gltf"];
        assert_eq!(labels(&names), ["x/in/room", "y/in/room", "y/room"]);
        assert_eq!(labels(&["a/room.gltf", "a/room.glb"]), ["room.gltf", "room.glb"]);
        // Figures write these two alike.
        assert_eq!(labels(&["a/my room.gltf", "b/my_room.gltf"]), ["a/my room", "b/my_room"]);
        let [one, two] = &labels(&["a/room.gltf", "a/./room.gltf"])[..] else { panic!("two") };
        assert_eq!(one, two);
    }
}
