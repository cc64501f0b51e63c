//! What a look depends on beside the shapes: where that is the same, so is what is found.

use std::ops::Range;
use std::sync::Mutex;

use super::surface::SurfaceKind;
use super::{Look, Scene};
use crate::scene::baked::Camera;
use crate::scene::emitter::EmitterModel;

/// Materials, emitters and media of a scene, in all, whose look is kept.
const ROWS_MAX: usize = 1 << 12;
/// Looks that are kept.
const KEPT_MAX: usize = 16;

/// What looks at scenes of the same shapes have found: the latest. Many scenes differ in numbers
/// that no look sees, as the axis of an analyzer or an index.
#[derive(Default)]
pub struct Looks(Mutex<Vec<(Subject, Look)>>);

/// All of a scene that [`Look::at`] sees, but for its shapes.
#[derive(PartialEq)]
struct Subject {
    camera: Camera,
    /// Of the materials, and whether they have holes.
    kinds: Vec<(SurfaceKind, bool)>,
    emitters: Vec<EmitterModel>,
    /// Of all of these in turn.
    radiance: Vec<f32>,
    skies: Range<u32>,
    /// Of each medium, whether it scatters.
    scattering: Vec<bool>,
}

impl Looks {
    /// Looks at a scene, unless one that looks the same has been looked at.
    pub fn at<const N: usize>(&self, scene: &Scene<N>) -> Look {
        let Some(subject) = Subject::of(scene) else { return Look::at(scene) };
        let lock = || self.0.lock().expect("no thread panics while it holds the lock");
        let known = lock().iter().find(|(other, _)| *other == subject).map(|(_, look)| *look);
        if let Some(look) = known {
            return look;
        }
        let look = Look::at(scene);
        let mut kept = lock();
        if kept.len() == KEPT_MAX {
            kept.remove(0);
        }
        kept.push((subject, look));
        look
    }
}

impl Subject {
    /// None of a scene of so many things that comparing them takes long, or keeping them room.
    fn of<const N: usize>(scene: &Scene<N>) -> Option<Self> {
        let (optics, materials) = (&scene.optics, scene.surfaces.materials());
        if materials.len() + optics.emitters.len() + optics.media.len() > ROWS_MAX {
            return None;
        }
        let emitters = &optics.emitters;
        Some(Self {
            camera: scene.camera,
            kinds: materials.iter().map(|material| (material.kind, material.has_holes)).collect(),
            emitters: emitters.iter().map(|emitter| emitter.model.clone()).collect(),
            radiance: (0..emitters.len()).flat_map(|row| optics.radiance_of(row)).collect(),
            skies: optics.skies.clone(),
            scattering: optics.media.iter().map(|medium| medium.scatters()).collect(),
        })
    }
}
