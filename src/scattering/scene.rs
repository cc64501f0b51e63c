//! The scene as the stages see it: the baked tables, the tree, and the look-ups derived from both.

use glam::Vec3;

use crate::geometry::{self, Accelerator};
use crate::scene::baked::{BakedScene, MaterialKind, NONE};

use super::Sensor;
use super::direct::DirectTable;

/// Everything read-only that a render needs, for `N` wavelengths.
pub struct Scene<const N: usize> {
    /// The tables.
    pub tables: BakedScene<N>,
    /// The tree over the primitives.
    pub accelerator: Accelerator,
    /// The camera with its film.
    pub sensor: Sensor,
    /// For every primitive, its row in `tables.materials`.
    pub material_of_primitive: Vec<u32>,
    /// Nothing, then for every primitive, the kind of its material.
    kind_of_hit: Vec<MaterialKind>,
    /// For every material, the probability with which roulette lets a path go on.
    pub survival_of_material: Vec<f32>,
    /// Bound of the coordinates of all primitives, which scales the offsets of rays.
    pub reach: f32,
    /// The emitters as connections see them.
    pub direct: DirectTable<N>,
    /// Running sum of the emitters' probabilities; the last entry is exactly one.
    emitter_cdf: Vec<f32>,
}

impl<const N: usize> Scene<N> {
    /// Builds the tree and the look-ups for a film of `width` times `height` pixels.
    pub fn new(tables: BakedScene<N>, width: u32, height: u32) -> Self {
        let material_of_primitive: Vec<u32> = tables
            .surface_of_primitive
            .iter()
            .map(|&surface| tables.surfaces[surface as usize].material)
            .collect();
        let kinds = material_of_primitive.iter().map(|&row| tables.materials[row as usize].kind);
        let kind_of_hit = std::iter::once(MaterialKind::Absorber).chain(kinds).collect();
        let survival_of_material = tables.materials.iter().map(super::specular::survival).collect();
        Self {
            accelerator: Accelerator::build(&tables.triangles, &tables.spheres),
            sensor: Sensor::new(&tables.camera, width, height),
            direct: DirectTable::new(&tables),
            reach: geometry::reach(&tables.bounds),
            emitter_cdf: running_sum(tables.emitters.iter().map(|emitter| emitter.probability)),
            tables,
            material_of_primitive,
            kind_of_hit,
            survival_of_material,
        }
    }

    /// The emitter that the random number `u` in [0, 1) chooses, by its probability.
    pub fn choose_emitter(&self, u: f32) -> usize {
        self.emitter_cdf.partition_point(|&sum| sum <= u).min(self.emitter_cdf.len() - 1)
    }

    /// The kind of material that a ray hit; nothing ([`NONE`]) counts as an absorber.
    #[inline(always)]
    pub fn kind_hit(&self, primitive: u32) -> MaterialKind {
        self.kind_of_hit[primitive.wrapping_add(1) as usize]
    }

    /// The emitter of a primitive, or of what a ray that hits nothing ([`NONE`]) sees.
    pub fn emitter_seen(&self, primitive: u32) -> u32 {
        if primitive == NONE {
            self.tables.environment
        } else {
            self.tables.emitter_of_primitive[primitive as usize]
        }
    }

    /// The geometric normal of a primitive at a point on it, to its front.
    pub fn geometric_normal(&self, primitive: u32, position: Vec3) -> Vec3 {
        let primitive = primitive as usize;
        match primitive.checked_sub(self.tables.triangles.len()) {
            None => {
                let [a, b, c] = self.tables.triangles[primitive].corners;
                (b - a).cross(c - a).normalize()
            }
            Some(sphere) => (position - self.tables.spheres[sphere].center).normalize(),
        }
    }
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
