//! Meshes out of files, and what Mitsuba makes of them: smooth where nothing else is said.

mod bytes;
pub mod obj;
pub mod ply;
pub mod serialized;

use glam::{DVec3, Vec3};

use crate::math::elementary::acos;
use crate::scene::world::Geometry;

/// Most vertices, and most triangles, of a mesh.
pub const ELEMENTS_MAX: usize = 1 << 26;

/// A mesh as a file has it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Soup {
    /// Positions, normals if there are any, and triangles.
    pub geometry: Geometry,
    /// Vertices that are one point but for their normals have the same number; none if each is a
    /// point of its own.
    pub points: Vec<u32>,
}

impl Soup {
    /// Gives it normals where it is smooth and has none, turns triangles so that their fronts are
    /// where their normals are, and turns everything round if it is inside out.
    pub fn finished(mut self, face_normals: bool, flip_normals: bool) -> Geometry {
        let geometry = &mut self.geometry;
        if face_normals {
            geometry.normals = Vec::new();
        } else if geometry.normals.is_empty() {
            geometry.normals = smooth_normals(geometry, &self.points);
        } else {
            turn_to_normals(geometry);
        }
        if flip_normals {
            geometry.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
            geometry.normals.iter_mut().for_each(|normal| *normal = -*normal);
        }
        self.geometry
    }
}

/// Turns triangles whose normals are on their back: light sees the side of the normals as front.
fn turn_to_normals(geometry: &mut Geometry) {
    let Geometry { positions, normals, triangles, .. } = geometry;
    for triangle in triangles {
        let corners = triangle.map(|row| positions[row as usize].as_dvec3());
        let front = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let side: f64 =
            triangle.iter().map(|row| front.dot(normals[*row as usize].as_dvec3())).sum();
        if side < 0.0 {
            triangle.swap(1, 2);
        }
    }
}

/// Normals of points: means of those of their triangles by the angles of these (G. Thürmer and
/// C. A. Wüthrich, "Computing Vertex Normals from Polygonal Facets", JGT 3(1), 1998).
fn smooth_normals(geometry: &Geometry, points: &[u32]) -> Vec<Vec3> {
    let positions = &geometry.positions;
    let point = |row: u32| points.get(row as usize).copied().unwrap_or(row) as usize;
    let mut sums = vec![DVec3::ZERO; positions.len().max(points.len())];
    for triangle in &geometry.triangles {
        let corners = triangle.map(|row| positions[row as usize].as_dvec3());
        let front = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
        for (index, row) in triangle.iter().enumerate() {
            let to = |other: usize| {
                let edge = corners[(index + other) % 3] - corners[index];
                edge.normalize_or_zero()
            };
            let angle = acos(to(1).dot(to(2)).clamp(-1.0, 1.0));
            sums[point(*row)] += front * angle;
        }
    }
    let rows = 0..positions.len() as u32;
    rows.map(|row| sums[point(row)].normalize_or_zero().as_vec3()).collect()
}

/// The triangles of a polygon, all with its first corner.
fn fan(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    let hub = corners.first().copied().unwrap_or_default();
    corners.get(1..).unwrap_or_default().windows(2).map(move |edge| [hub, edge[0], edge[1]])
}
