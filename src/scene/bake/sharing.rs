//! Which meshes are kept once although they stand in several places, and their tables.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;

use glam::{Affine3A, DAffine3, DMat3, DVec3, Mat3A, Vec3};

use super::check_range;
use super::primitives::{Part, Triangles, warn_of_dropped};
use crate::scene::corners::{Corners, Needs};
use crate::scene::error::SceneError;
use crate::scene::instanced::{Instance, Instanced, Object, PRIMITIVES_MAX};
use crate::scene::warnings::Warnings;
use crate::scene::world::Geometry;

/// Meshes are kept once if that saves so many triangles at least. Rays that run alike find copies
/// up to 1.6 times as fast; others find instances faster once copies exceed the caches (1.5 times
/// in sixty copies of 3,674 triangles).
const SAVED_LEAST: usize = 50_000;

/// How much longer the longest axis of a place may be than the shortest, about: rounding in the
/// object's space comes back to the world so much larger, and rays have to clear it.
const STRETCH_MAX: f64 = 4.0;

/// Tells which parts become instances: nothing that emits, as emitters are chosen by triangle.
pub fn shared(parts: &[Part]) -> Vec<bool> {
    let can_share = |part: &Part| !part.emits && stretch(&part.to_world.matrix3) <= STRETCH_MAX;
    let mut uses: HashMap<*const Geometry, usize> = HashMap::new();
    for part in parts.iter().filter(|part| can_share(part)) {
        *uses.entry(Arc::as_ptr(&part.geometry)).or_default() += 1;
    }
    let is_shared = |part: &Part| {
        let uses = uses.get(&Arc::as_ptr(&part.geometry)).copied().unwrap_or(0);
        let saved = uses.saturating_sub(1).saturating_mul(part.geometry.triangles.len());
        saved >= SAVED_LEAST && can_share(part)
    };
    parts.iter().map(is_shared).collect()
}

/// The condition number of a matrix in the Frobenius norm, over that of rotations: 1 for these,
/// and about half the ratio of the longest to the shortest axis where that is large.
fn stretch(matrix: &DMat3) -> f64 {
    let norm = |m: &DMat3| m.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt();
    norm(matrix) * norm(&matrix.inverse()) / 3.0
}

/// The tables of instances, behind so many primitives of the scene's own. Parts come with their
/// rows in the surfaces.
pub fn instanced(
    parts: &[(Part, u32)],
    primitives: usize,
    warnings: &mut Warnings,
) -> Result<Instanced, SceneError> {
    let mut tables = Instanced::behind(primitives);
    let mut known: HashMap<*const Geometry, (u32, Mold)> = HashMap::new();
    let needs = parts.iter().fold(Needs::default(), |needs, (part, _)| needs.and(part.needs));
    for (part, surface) in parts {
        let (object, mold) = match known.entry(Arc::as_ptr(&part.geometry)) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(place) => {
                let mold = Mold::new(part)?;
                place.insert((tables.add_object(mold.object((part, needs), warnings)?), mold))
            }
        };
        let to_world = part.to_world * DAffine3::from_translation(mold.middle);
        if tables.objects()[*object as usize].triangles.is_empty() {
            continue;
        }
        let instance = Instance {
            object: *object,
            surface: *surface,
            first_primitive: 0,
            to_world: Affine3A::from_mat3_translation(
                to_world.matrix3.as_mat3(),
                to_world.translation.as_vec3(),
            ),
            to_object: Mat3A::from(to_world.matrix3.inverse().as_mat3()),
            bounds: mold.bounds(part)?,
        };
        if !tables.add_instance(instance) {
            let problem = format!("brings the scene above {PRIMITIVES_MAX} primitives");
            return Err(SceneError::new(&part.name, problem, "use fewer instances"));
        }
    }
    Ok(tables)
}

/// What instances of a mesh are made with.
struct Mold {
    /// The positions that are corners, in the space of the file.
    positions: Vec<DVec3>,
    /// The middle of their box.
    middle: DVec3,
}

impl Mold {
    fn new(part: &Part) -> Result<Self, SceneError> {
        let geometry = &part.geometry;
        let mut is_corner = vec![false; geometry.positions.len()];
        geometry.triangles.iter().flatten().for_each(|row| is_corner[*row as usize] = true);
        let corners = geometry.positions.iter().zip(is_corner).filter(|(_, is_corner)| *is_corner);
        let positions: Vec<DVec3> = corners.map(|(position, _)| position.as_dvec3()).collect();
        let [low, high] = bounds(positions.iter().copied());
        check_range(low, high, &part.name)?;
        Ok(Self { positions, middle: 0.5 * (low + high) })
    }

    /// The mesh about its middle.
    fn object(
        &self,
        (part, needs): (&Part, Needs),
        warnings: &mut Warnings,
    ) -> Result<Object, SceneError> {
        let about_middle = |position: DVec3| position - self.middle;
        let mut triangles = Triangles { paint: Corners::new(needs), ..Triangles::default() };
        let dropped = triangles.add(part, about_middle, DMat3::IDENTITY)?;
        warn_of_dropped(part, dropped, warnings);
        triangles.finish_normals();
        let Triangles { rows: triangles, shading_normals, paint: corners } = triangles;
        Ok(Object { triangles, shading_normals, corners })
    }

    /// The box of an instance in the world.
    fn bounds(&self, part: &Part) -> Result<[Vec3; 2], SceneError> {
        let to_world = |position: &DVec3| part.to_world.transform_point3(*position);
        let [low, high] = bounds(self.positions.iter().map(to_world));
        check_range(low, high, &part.name)?;
        Ok([low.as_vec3(), high.as_vec3()])
    }
}

fn bounds(positions: impl Iterator<Item = DVec3>) -> [DVec3; 2] {
    let none = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    positions.fold(none, |[low, high], position| [low.min(position), high.max(position)])
}
