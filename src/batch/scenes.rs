//! Scenes, read once. Of the worlds that edits make of one, those in a row share shapes and tree
//! where these come out the same.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock};

use super::gate::{Gate, Permit, locked};
use super::order::Order;
use crate::render::memory::triangles_of;
use crate::render::{PlacedWorld, RenderError};
use crate::scene::{SceneError, SceneFile};

/// Triangles of which a second tree, or second tables of what they do to light, take memory that is
/// worth to be waited for.
pub const LARGE: usize = 200_000;
/// Most scene files that are kept.
const KEPT_MAX: usize = 8;

/// The latest scenes.
pub struct Scenes {
    allow_outside: bool,
    kept: Mutex<Vec<(PathBuf, Arc<Kept>)>>,
}

/// A scene file, and the latest world that was placed.
#[derive(Default)]
struct Kept {
    file: OnceLock<Result<SceneFile, SceneError>>,
    latest: Mutex<Option<(String, PlacedWorld)>>,
}

impl Scenes {
    /// None yet.
    pub fn new(allow_outside: bool) -> Self {
        Self { allow_outside, kept: Mutex::default() }
    }

    /// The world of a job in its place. Where that takes a large tree of its own, it is built when
    /// all other jobs are done, and the permit keeps them out.
    pub fn world<'a>(
        &self,
        order: &Order,
        gate: &'a Gate,
    ) -> Result<(PlacedWorld, Option<Permit<'a>>), RenderError> {
        let kept = self.kept(&order.scene);
        let read = || SceneFile::read(&order.scene, self.allow_outside);
        let file = kept.file.get_or_init(read).as_ref().map_err(SceneError::clone)?;
        let edits: Vec<_> =
            order.edits.iter().map(|edit| (&edit.target, edit.value.to_string())).collect();
        let key = format!("{:?} {edits:?}", order.view);
        if let Some((of, world)) = &*locked(&kept.latest)
            && *of == key
        {
            return Ok((world.clone(), None));
        }
        let world = file.world(&order.view, &order.edits)?;
        // With the lock, so that no two trees are built at once of what could be shared.
        let mut latest = locked(&kept.latest);
        let mut permit = None;
        if let Some((_, other)) = &*latest
            && triangles_of(&world) >= LARGE
            && !other.shares_shapes(&world)?
        {
            permit = Some(gate.enter(u64::MAX));
            *latest = None;
        }
        let world = match &*latest {
            Some((of, world)) if *of == key => return Ok((world.clone(), None)),
            Some((_, other)) => other.beside(world)?,
            None => PlacedWorld::new(world)?,
        };
        *latest = Some((key, world.clone()));
        Ok((world, permit))
    }

    /// Reads a scene anew when it is asked for again.
    pub fn forget(&self, path: &Path) {
        locked(&self.kept).retain(|(known, _)| known != path);
    }

    fn kept(&self, path: &Path) -> Arc<Kept> {
        let mut all = locked(&self.kept);
        let found = all.iter().position(|(known, _)| known == path);
        let kept = match found {
            Some(at) => all.remove(at),
            None => (path.to_owned(), Arc::default()),
        };
        if all.len() == KEPT_MAX {
            all.remove(0);
        }
        all.push(kept.clone());
        kept.1
    }
}
