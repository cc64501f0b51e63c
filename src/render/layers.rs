//! What the camera sees first: layers beside the light, in world space and in RGB whatever the
//! light is carried at. They depend on no sample of the render.

use glam::Vec3;
use rayon::prelude::*;

use crate::geometry::{
    Hit, HitColumns, RayColumns, SurfaceColumns, TraceScratch, resolve_surfaces, trace_closest,
};
use crate::image::cut::Cut;
use crate::image::layers::{Layer, LayerKind};
use crate::math::columns::{Columns, Rows};
use crate::math::{F32s, LANES, U32s, lanes};
use crate::scattering::Scene;
use crate::scattering::painting::paint_normals;
use crate::scattering::surface::SurfaceKind;
use crate::scene::baked::NONE;
use crate::scene::world::SurfaceModel;
use crate::transport::sampler::{Purpose, Stream, draw, path_seed};

/// Rays of a pixel that means are taken over, two times [`LANES`]: those of the first samples of a
/// render by `path`.
const SAMPLES: usize = 16;
/// Rows of the film whose pixels are there at once.
const ROWS_AT_ONCE: usize = 256;
/// Boundaries and holes in a row that a ray looks through at most.
const PASSED_MAX: usize = 1000;
/// What a hole is, of the share that textures leave of a surface.
const HOLE: f32 = 0.5;

/// What the camera of a film sees first.
#[derive(Default)]
pub struct SeenFirst {
    /// The layers that were asked for.
    pub layers: Vec<Layer>,
    /// What the numbers in them stand for, as metadata.
    pub names: Vec<(String, String)>,
}

/// The layers of the film of a scene.
pub fn layers(scene: &Scene<3>, kinds: &[LayerKind], seed: u32) -> Vec<Layer> {
    let Cut { size: [width, height], start, .. } = scene.sensor.layout.cut;
    let mut layers: Vec<Layer> = (kinds.iter())
        .map(|&kind| Layer { kind, planes: vec![Vec::new(); kind.channels().len()] })
        .collect();
    // A pixel knows more than is asked for: only so many of them are there at once.
    for first in (0..height).step_by(ROWS_AT_ONCE) {
        let rows = first..height.min(first + ROWS_AT_ONCE as u32);
        let rows: Vec<Vec<Pixel>> = rows
            .into_par_iter()
            .map_init(Rays::new, |rays, y| {
                let pixel = |x| rays.pixel(scene, [start[0] + x, start[1] + y], seed);
                (0..width).map(pixel).collect()
            })
            .collect();
        for Layer { kind, planes } in &mut layers {
            for (channel, plane) in planes.iter_mut().enumerate() {
                plane.extend(rows.iter().flatten().map(|pixel| pixel.value(*kind, channel)));
            }
        }
    }
    layers
}

/// What a pixel sees.
#[derive(Default)]
struct Pixel {
    /// Samples that hit anything, and the sum of what they see.
    hits: u32,
    depth: f32,
    normal: Vec3,
    albedo: Vec3,
    position: Vec3,
    /// At the center.
    uv: [f32; 2],
    material: u32,
    object: u32,
}

impl Pixel {
    fn value(&self, kind: LayerKind, channel: usize) -> f32 {
        let of_hits = 1.0 / self.hits.max(1) as f32;
        let of_all = 1.0 / SAMPLES as f32;
        match kind {
            LayerKind::Depth if self.hits == 0 => f32::INFINITY,
            LayerKind::Depth => self.depth * of_hits,
            LayerKind::Normal => self.normal[channel] * of_all,
            LayerKind::Albedo => self.albedo[channel] * of_all,
            LayerKind::Position => self.position[channel] * of_hits,
            LayerKind::Uv => self.uv[channel],
            // Exact up to 16,777,216.
            LayerKind::Material => self.material as f32,
            LayerKind::Object => self.object as f32,
        }
    }
}

/// The rays of a pixel, behind each other: [`SAMPLES`] of them and the one through its center.
struct Rays {
    rays: RayColumns,
    hits: HitColumns,
    surfaces: SurfaceColumns,
    scratch: TraceScratch,
}

impl Rays {
    fn new() -> Self {
        Self {
            rays: RayColumns::with_room(SAMPLES + 1),
            hits: HitColumns::with_room(SAMPLES + 1),
            surfaces: SurfaceColumns::with_room(SAMPLES + 1),
            scratch: TraceScratch::default(),
        }
    }

    fn pixel(&mut self, scene: &Scene<3>, [column, row]: [u32; 2], seed: u32) -> Pixel {
        self.send(scene, [column, row], seed);
        let Self { rays, hits, surfaces, scratch } = self;
        trace_closest(hits, scratch, rays, 0..SAMPLES + 1, &scene.accelerator);
        for index in 0..=SAMPLES {
            let hit = seen(scene, rays, hits, index);
            hits.set(index, hit);
        }
        resolve_surfaces(surfaces, hits, rays, 0..SAMPLES + 1, &scene.shapes);
        paint_normals(surfaces, hits, 0..SAMPLES + 1, scene);
        let mut pixel = Pixel::default();
        for index in 0..SAMPLES {
            self.add(&mut pixel, scene, index);
        }
        self.name(&mut pixel, scene);
        pixel
    }

    /// The rays that samples of a render would begin with, and that through the center.
    fn send(&mut self, scene: &Scene<3>, [column, row]: [u32; 2], seed: u32) {
        let sensor = &scene.sensor;
        let seed = U32s::splat(path_seed(seed, Stream::Sensor, row * sensor.width + column));
        let pixel = [column, row].map(|at| F32s::splat(at as f32));
        for first in (0..SAMPLES).step_by(LANES) {
            let iteration = U32s::from(lanes::each(|lane| (first + lane) as u32));
            let film = sensor.points(pixel, draw(seed, iteration, 0, Purpose::Pixel));
            let lens = || draw(seed, iteration, 0, Purpose::Lens);
            let (origin, direction, _) = sensor.rays(film, lens);
            origin.store(&mut self.rays.origin, first, SAMPLES);
            direction.store(&mut self.rays.direction, first, SAMPLES);
        }
        let center = pixel.map(|at| at + F32s::splat(0.5));
        let (origin, direction, _) = sensor.rays(center, || [F32s::splat(0.0); 2]);
        origin.store(&mut self.rays.origin, SAMPLES, SAMPLES + 1);
        direction.store(&mut self.rays.direction, SAMPLES, SAMPLES + 1);
    }

    /// Adds what a ray sees to the means.
    fn add(&self, pixel: &mut Pixel, scene: &Scene<3>, index: usize) {
        let Self { rays, hits, surfaces, .. } = self;
        if hits.primitive[index] == NONE {
            return;
        }
        let of = |columns| Vec3::from(lanes::row_of(columns, index));
        let (direction, position) = (of(&rays.direction), of(&surfaces.position));
        // Turned by the front, as a shading normal may look away where the surface does not.
        let is_back = of(&surfaces.geometric_normal).dot(direction) > 0.0;
        let normal = of(&surfaces.shading_normal);
        pixel.hits += 1;
        pixel.depth += (position - scene.camera.position).dot(scene.camera.forward);
        pixel.normal += if is_back { -normal } else { normal };
        pixel.albedo += Vec3::from(base_color(&model_at(scene, (hits, index), position)));
        pixel.position += (scene.shapes.origin + position.as_dvec3()).as_vec3();
    }

    /// What the ray through the center sees.
    fn name(&self, pixel: &mut Pixel, scene: &Scene<3>) {
        let (primitive, at) = (self.hits.primitive[SAMPLES], self.weights(SAMPLES));
        if primitive == NONE {
            return;
        }
        let object = scene.shapes.surface_of(primitive);
        pixel.object = object + 1;
        pixel.material = scene.shapes.surfaces[object as usize].material + 1;
        if let Some(on) = scene.shapes.painted(primitive) {
            let position = lanes::row_of(&self.surfaces.position, SAMPLES).into();
            pixel.uv = on.coordinates(0, on.weights(at, position)).to_array();
        }
    }

    fn weights(&self, index: usize) -> [f32; 2] {
        [self.hits.u[index], self.hits.v[index]]
    }
}

/// What a ray sees from its first hit on: not boundaries of media, nor holes of textures.
fn seen(scene: &Scene<3>, rays: &RayColumns, hits: &HitColumns, index: usize) -> Hit {
    let mut hit = hits.get(index);
    let of = |columns| Vec3::from(lanes::row_of(columns, index));
    for _ in 0..PASSED_MAX {
        if hit.primitive == NONE {
            break;
        }
        let is_boundary = scene.material_at(hit.primitive).kind == SurfaceKind::Null;
        let position = of(&rays.origin) + hit.t * of(&rays.direction);
        let is_hole = || scene.coverage_at(hit.primitive, ([hit.u, hit.v], position)) < HOLE;
        if !is_boundary && !is_hole() {
            break;
        }
        hit = scene.accelerator.next(of(&rays.origin), of(&rays.direction), hit);
    }
    hit
}

/// The model of what has been hit, with its parameters as textures have them there.
fn model_at(
    scene: &Scene<3>,
    (hits, index): (&HitColumns, usize),
    position: Vec3,
) -> SurfaceModel<[f32; 3]> {
    let primitive = hits.primitive[index];
    let material = scene.material_row(primitive);
    let model = &scene.optics.materials[material].model;
    let painted = || {
        let painting = scene.optics.painting.as_deref()?;
        let (textures, on) = (painting.of(material)?, scene.shapes.painted(primitive)?);
        let weights = on.weights([hits.u[index], hits.v[index]], position);
        Some(painting.model_at(model.clone(), textures, (&on, weights)))
    };
    painted().unwrap_or_else(|| model.clone())
}

/// The color of what light goes into or off, by a model in RGB.
fn base_color(model: &SurfaceModel<[f32; 3]>) -> [f32; 3] {
    match model {
        SurfaceModel::Absorber => [0.0; 3],
        SurfaceModel::Diffuse { reflectance } | SurfaceModel::Plastic { reflectance, .. } => {
            *reflectance
        }
        SurfaceModel::MetallicRoughness { base_color, .. } => *base_color,
        SurfaceModel::Layered { layers } => layers.base_color,
        SurfaceModel::Conductor { eta, k }
        | SurfaceModel::FilmedConductor { eta, k, .. }
        | SurfaceModel::RoughConductor { eta, k, .. } => std::array::from_fn(|n| {
            let [above, below] = [eta[n] - 1.0, eta[n] + 1.0].map(|it| it * it + k[n] * k[n]);
            above / below
        }),
        SurfaceModel::Measured { table, .. } => [table.lobe().albedo; 3],
        SurfaceModel::Brushed { of, .. } | SurfaceModel::Filmed { of, .. } => base_color(of),
        SurfaceModel::Blend { parts, weight } => {
            let [first, second] = parts.each_ref().map(base_color);
            std::array::from_fn(|n| first[n] + (second[n] - first[n]) * weight)
        }
        SurfaceModel::Dielectric { .. }
        | SurfaceModel::DispersiveDielectric { .. }
        | SurfaceModel::RoughDielectric { .. }
        | SurfaceModel::FilmedDielectric { .. }
        | SurfaceModel::Sheet { .. }
        | SurfaceModel::ThinDielectric { .. }
        | SurfaceModel::Polarizer { .. }
        | SurfaceModel::Retarder { .. }
        | SurfaceModel::Null => [1.0; 3],
    }
}
