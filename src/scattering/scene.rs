//! The scene as the stages see it: the baked tables, the tree, and the look-ups derived from both.

use std::sync::Arc;

use crate::geometry::{self, Accelerator, medium_met};
use crate::scene::baked::{BakedScene, KEEP, NONE, Optics, Shapes};
use crate::scene::emitter::Emitter;

use super::Sensor;
use super::emitter;
use super::emitter::direct::DirectTable;
use super::event::{END, Event, Met, events};
use super::immersion::Immersion;
use super::medium::Medium;
use super::surface::{Material, Surfaces};

/// Everything read-only that a render needs, for `N` wavelengths.
pub struct Scene<const N: usize> {
    /// Where everything is.
    pub shapes: Arc<Shapes>,
    /// The tree over the primitives.
    pub accelerator: Arc<Accelerator>,
    /// What everything does to light.
    pub optics: Optics<N>,
    /// The camera with its film.
    pub sensor: Sensor,
    /// The materials, and the tables of their models.
    pub surfaces: Surfaces<N>,
    /// For every triangle and sphere, its row in the materials.
    material_of_primitive: Vec<u32>,
    /// All kinds of events.
    pub events: Vec<Event>,
    /// Nothing, then for every triangle and sphere, its kind of event.
    event_of_hit: Vec<u8>,
    /// The media, and behind them one that is clear.
    media: Vec<Medium<N>>,
    /// Whether there are surfaces that are nothing but boundaries of media.
    pub has_null_boundaries: bool,
    /// Whether light can leave vertices that connect polarized.
    pub has_polarizing_vertices: bool,
    /// Whether any shading normal differs from the geometric one.
    pub has_shading_normals: bool,
    /// Bound of the coordinates of all primitives, which scales the offsets of rays.
    pub reach: f32,
    /// The emitters as connections see them.
    pub direct: DirectTable<N>,
    /// The medium around the sensor: a row of the media, or [`NONE`].
    pub sensor_medium: u32,
    /// The media before and behind every emitter.
    emitter_media: Vec<[u32; 2]>,
    /// Running sum of the emitters' probabilities; the last entry is exactly one.
    emitter_cdf: Vec<f32>,
}

impl<const N: usize> Scene<N> {
    /// Builds the tree and the look-ups for a film of `width` times `height` pixels.
    pub fn new(baked: BakedScene<N>, width: u32, height: u32) -> Self {
        let accelerator = Accelerator::of_shapes(&baked.shapes);
        Self::with_tree(Arc::new(baked.shapes), Arc::new(accelerator), baked.optics, width, height)
    }

    /// Builds the look-ups for shapes whose tree there is already: that of other wavelengths, or
    /// of another film.
    pub fn with_tree(
        shapes: Arc<Shapes>,
        accelerator: Arc<Accelerator>,
        optics: Optics<N>,
        width: u32,
        height: u32,
    ) -> Self {
        let material_of = |&surface: &u32| shapes.surfaces[surface as usize].material;
        let material_of_primitive: Vec<u32> =
            shapes.surface_of_primitive.iter().map(material_of).collect();
        let surfaces = Surfaces::new(&optics.materials);
        let materials = surfaces.materials();
        let event_of = |&row: &u32| materials[row as usize].kind.event();
        let event_of_hit = std::iter::once(END)
            .chain(material_of_primitive.iter().map(event_of))
            .map(|event| event as u8)
            .collect();
        let mut media: Vec<Medium<N>> = optics.media.iter().map(Medium::new).collect();
        let events = events(&media);
        media.push(Medium::clear());
        let has_polarizing_vertices = present(&events, materials).any(|it| it.keeps_polarized());
        let immersion = Immersion::new(&shapes, &accelerator, !optics.media.is_empty());
        let media_of = |emitter: &Emitter<N>| emitter::media(&emitter.model, &immersion);
        let emitter_media = optics.emitters.iter().map(media_of).collect();
        Self {
            sensor_medium: immersion.at(shapes.camera.position),
            emitter_media,
            sensor: Sensor::new(&shapes.camera, width, height),
            direct: DirectTable::new(&shapes, &optics),
            reach: geometry::reach(&shapes.bounds),
            emitter_cdf: running_sum(optics.emitters.iter().map(|emitter| emitter.probability)),
            has_polarizing_vertices,
            events,
            has_null_boundaries: materials.iter().any(|it| it.kind.is_crossed()),
            has_shading_normals: shapes.has_shading_normals(),
            media,
            accelerator,
            shapes,
            optics,
            material_of_primitive,
            event_of_hit,
            surfaces,
        }
    }

    /// The row of a primitive's material.
    #[inline(always)]
    pub fn material_row(&self, primitive: u32) -> usize {
        match self.material_of_primitive.get(primitive as usize) {
            Some(row) => *row as usize,
            None => {
                let surface = self.shapes.surface_of(primitive);
                self.shapes.surfaces[surface as usize].material as usize
            }
        }
    }

    /// A primitive's material.
    #[inline(always)]
    pub fn material_at(&self, primitive: u32) -> &Material {
        &self.surfaces.materials()[self.material_row(primitive)]
    }

    /// The emitter that the random number `u` in [0, 1) chooses, by its probability.
    pub fn choose_emitter(&self, u: f32) -> usize {
        self.emitter_cdf.partition_point(|&sum| sum <= u).min(self.emitter_cdf.len() - 1)
    }

    /// The events that some surface or medium of the scene is met by.
    pub fn events_present(&self) -> impl Iterator<Item = Event> {
        present(&self.events, self.surfaces.materials())
    }

    /// The place in `events` of what a ray hit, which may be nothing ([`NONE`]) or a medium.
    #[inline(always)]
    pub fn event_hit(&self, primitive: u32) -> usize {
        match medium_met(primitive) {
            Some(medium) => Met::Medium(medium).event(),
            None => match self.event_of_hit.get(primitive.wrapping_add(1) as usize) {
                Some(event) => *event as usize,
                None => self.material_at(primitive).kind.event(),
            },
        }
    }

    /// The medium that an emitter's light enters, on its front or its back.
    pub fn medium_at_emitter(&self, emitter: usize, front: bool) -> u32 {
        self.emitter_media[emitter][usize::from(!front)]
    }

    /// Whether paths can be in anything but clear space, or meet its boundaries.
    pub fn has_media(&self) -> bool {
        self.media.len() > 1 || self.has_null_boundaries
    }

    /// Whether some surfaces leave light a single way, so that light paths cannot connect them to
    /// the sensor.
    pub fn has_specular_surfaces(&self) -> bool {
        let materials = self.surfaces.materials();
        let mut used = self.shapes.surfaces.iter().map(|it| &materials[it.material as usize]);
        used.any(|material| material.kind.is_specular())
    }

    /// A medium; a clear one for [`NONE`].
    #[inline(always)]
    pub fn medium(&self, row: u32) -> &Medium<N> {
        &self.media[(row as usize).min(self.media.len() - 1)]
    }

    /// The medium on the side of a primitive that is entered, for a path in the medium `before`.
    #[inline(always)]
    pub fn medium_beyond(&self, primitive: u32, to_front: bool, before: u32) -> u32 {
        let surface = &self.shapes.surfaces[self.shapes.surface_of(primitive) as usize];
        match if to_front { surface.exterior } else { surface.interior } {
            KEEP => before,
            medium => medium,
        }
    }

    /// The probability with which roulette lets a path go on from what it hit.
    #[inline(always)]
    pub fn survival(&self, primitive: u32) -> f32 {
        match medium_met(primitive) {
            Some(medium) => self.medium(medium).survival,
            None => self.material_at(primitive).survival,
        }
    }

    /// The emitter of a primitive, or of what a ray that hits nothing ([`NONE`]) sees; none in
    /// media.
    pub fn emitter_seen(&self, primitive: u32) -> u32 {
        if primitive == NONE {
            self.optics.environment
        } else {
            self.optics.emitter_of_primitive.get(primitive as usize).copied().unwrap_or(NONE)
        }
    }
}

/// Those of the events that media and these materials are met by.
fn present(events: &[Event], materials: &[Material]) -> impl Iterator<Item = Event> {
    let is_present = |met: Met| match met {
        Met::Surface(kind) => materials.iter().any(|material| material.kind == kind),
        Met::Medium(_) => true,
    };
    events.iter().filter(move |event| is_present(event.met)).copied()
}

fn running_sum(probabilities: impl Iterator<Item = f32>) -> Vec<f32> {
    let mut sum = 0.0_f64;
    let mut cdf: Vec<f32> = probabilities
        .map(|probability| {
            sum += f64::from(probability);
            sum as f32
        })
        .collect();
    if let Some(last) = cdf.last_mut() {
        *last = 1.0;
    }
    cdf
}
