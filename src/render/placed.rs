//! A world in its place, ready to be rendered.

use std::sync::{Arc, Mutex};

use crate::geometry::Accelerator;
use crate::scattering::Scene;
use crate::scattering::boundaries::{Doubt, settle};
use crate::scene::baked::{Camera, Projection, Shapes};
use crate::scene::warnings::Warnings;
use crate::scene::{SceneError, World, bake_optics, bake_shapes};
use crate::spectrum::Color;

use super::RenderError;
use super::immersed::immersed;
use super::memory::{check_tree, check_world};
use super::settings::{Options, SettingsError, check_film};

/// Film width where neither the scene nor the options name one, in pixels.
const WIDTH: u32 = 512;

/// A world whose shapes have been placed and sorted into a tree. Renders share it: what it does to
/// light is evaluated once for every color and film, of which the latest are kept.
///
/// It is cheap to clone. An edit of the world needs a new one.
#[derive(Clone)]
pub struct PlacedWorld(Arc<Placed>);

struct Placed {
    world: World,
    shapes: Arc<Shapes>,
    accelerator: Arc<Accelerator>,
    rgb: Latest<3>,
    mono: Latest<1>,
}

/// Scenes that are kept for every number of wavelengths.
const KEPT_MAX: usize = 16;

/// The latest scenes of so many wavelengths, with their colors and films.
type Latest<const N: usize> = Mutex<Vec<(Color, [u32; 2], Arc<Scene<N>>)>>;

impl PlacedWorld {
    /// Places a world.
    ///
    /// # Errors
    /// When the world is not as it should be ([`World::check`]), or does not fit into the numbers
    /// of the renderer or into the memory.
    pub fn new(world: World) -> Result<Self, RenderError> {
        check_world(&world)?;
        let mut shapes = bake_shapes(&world)?;
        check_tree(&shapes)?;
        let accelerator = Accelerator::of_shapes(&shapes);
        let doubts = settle(&mut shapes, &accelerator);
        shapes.warnings.extend(sentences(&world, &doubts));
        Ok(Self(Arc::new(Placed {
            world,
            shapes: Arc::new(shapes),
            accelerator: Arc::new(accelerator),
            rgb: Mutex::default(),
            mono: Mutex::default(),
        })))
    }

    /// What has been placed.
    pub fn world(&self) -> &World {
        &self.0.world
    }

    /// What of the world is not rendered as it was described, one sentence each: what its file asks
    /// for and the renderer ignores, and what its place has made of it.
    pub fn warnings(&self) -> impl Iterator<Item = &str> {
        let Placed { world, shapes, .. } = &*self.0;
        world.warnings().iter().chain(&shapes.warnings).map(String::as_str)
    }

    /// Width and height of the film: what the options ask for, else what the camera does, else
    /// 512 pixels wide; an edge that is not given follows from the other and the camera's aspect.
    ///
    /// # Errors
    /// When such a film could not be counted or stored.
    pub fn film_size(&self, options: &Options) -> Result<[u32; 2], SettingsError> {
        film_size(options, &self.0.shapes.camera)
    }

    /// In words: what of the world is not rendered as it was described, the coefficients that its
    /// media compute, in RGB, and the media that the camera and the emitters are in. Nothing where
    /// there are no media and no doubts.
    ///
    /// # Errors
    /// When the world cannot be seen in RGB.
    pub fn describe(&self) -> Result<String, SceneError> {
        let Placed { world, shapes, .. } = &*self.0;
        let warnings = shapes.warnings.iter().map(|warning| format!("warning: {warning}\n"));
        let media = match world.media_names().is_empty() {
            true => String::new(),
            false => immersed(world, &*self.rgb(Color::Rgb, [1, 1])?),
        };
        Ok(media + &warnings.collect::<String>())
    }

    pub(super) fn rgb(&self, color: Color, film: [u32; 2]) -> Result<Arc<Scene<3>>, SceneError> {
        self.latest(&self.0.rgb, color, film)
    }

    pub(super) fn mono(&self, color: Color, film: [u32; 2]) -> Result<Arc<Scene<1>>, SceneError> {
        self.latest(&self.0.mono, color, film)
    }

    fn latest<const N: usize>(
        &self,
        latest: &Latest<N>,
        color: Color,
        [width, height]: [u32; 2],
    ) -> Result<Arc<Scene<N>>, SceneError> {
        let mut latest = latest.lock().expect("no thread panics while it holds the lock");
        let is_it =
            |(of, film, _): &&(Color, [u32; 2], _)| (*of, *film) == (color, [width, height]);
        if let Some((.., scene)) = latest.iter().find(is_it) {
            return Ok(Arc::clone(scene));
        }
        let Placed { world, shapes, accelerator, .. } = &*self.0;
        let optics = bake_optics(world, shapes, color)?;
        let (shapes, accelerator) = (Arc::clone(shapes), Arc::clone(accelerator));
        let scene = Arc::new(Scene::with_tree(shapes, accelerator, optics, width, height));
        if latest.len() == KEPT_MAX {
            latest.remove(0);
        }
        latest.push((color, [width, height], Arc::clone(&scene)));
        Ok(scene)
    }
}

fn film_size(options: &Options, camera: &Camera) -> Result<[u32; 2], SettingsError> {
    let aspect = match (camera.resolution, camera.projection) {
        (Some([width, height]), _) => width as f32 / height as f32,
        (None, Projection::Perspective { aspect, .. }) => aspect.unwrap_or(1.0),
        (None, Projection::Orthographic { half_width, half_height }) => half_width / half_height,
    };
    let edge = |value: f32| (value.round() as u32).max(1);
    let [width, height] = match (options.width, options.height) {
        (Some(width), Some(height)) => [width, height],
        (Some(width), None) => [width, edge(width as f32 / aspect)],
        (None, Some(height)) => [edge(height as f32 * aspect), height],
        (None, None) => camera.resolution.unwrap_or([WIDTH, edge(WIDTH as f32 / aspect)]),
    };
    check_film(width, height)?;
    Ok([width, height])
}

/// What boundaries leave in doubt, in the words of the world.
fn sentences(world: &World, doubts: &[Doubt]) -> Vec<String> {
    if doubts.is_empty() {
        return Vec::new();
    }
    let names = world.surface_names();
    let name = |surface: u32| names[surface as usize].as_str();
    let side = |side: usize| ["behind", "before"][side];
    let mut warnings = Warnings::default();
    for doubt in doubts {
        match *doubt {
            Doubt::Overlap([a, b]) => {
                let text = format!(
                    "overlaps {}: where both are, the medium is that of the smaller one",
                    name(b)
                );
                warnings.add_like("overlap", name(a), &text);
            }
            Doubt::Contradiction { surface, side: of, other } => {
                let text = format!(
                    "the medium {} it is not what {} says: paths in opposite directions may \
                     meet different media; state `interior` and `exterior` alike on both, and \
                     close what they bound",
                    side(of),
                    name(other)
                );
                warnings.add_like("contradiction", name(surface), &text);
            }
            Doubt::Open { surface, side: of } => {
                let text = format!(
                    "the medium {} it is not closed off from that of the scene, and where it ends \
                     cannot be known",
                    side(of)
                );
                warnings.add_like("open", name(surface), &text);
            }
        }
    }
    warnings.sentences()
}
