//! Meshes: indexed triangles, and the checks that they can be rendered.

use std::sync::Arc;

use glam::{DVec3, Vec2, Vec3, Vec4};

use crate::math::Fault;

/// Triangles, shared by all instances of a mesh.
#[derive(Clone, Debug)]
pub struct Mesh(pub Arc<Geometry>);

/// Indexed triangles in the space of the mesh, counter-clockwise from the front.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Geometry {
    /// Vertex positions, finite.
    pub positions: Vec<Vec3>,
    /// Vertex normals of any length, as many as positions, or none: then the triangles are flat.
    /// Finite; zero where a vertex has none of its own.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, as many as positions, or none; finite. (0, 0) is the upper left corner
    /// of a picture.
    pub texture_coordinates: Vec<Vec2>,
    /// A second set of these.
    pub texture_coordinates_1: Vec<Vec2>,
    /// Linear red, green, blue and alpha, as many as positions, or none; finite, not negative.
    pub colors: Vec<Vec4>,
    /// Where texture coordinates grow to the right, and in the fourth place 1 or -1 for the side
    /// that up is on: as many as positions, or none; finite.
    pub tangents: Vec<Vec4>,
    /// Corners: rows of `positions`. Not empty; every triangle has an area.
    pub triangles: Vec<[u32; 3]>,
}

impl Geometry {
    /// Flat triangles.
    pub fn new(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Self {
        Self { positions, triangles, ..Self::default() }
    }

    /// A parallelogram about `center` that faces along `u` cross `v`, its half edges.
    pub fn quad(center: Vec3, u: Vec3, v: Vec3) -> Self {
        let corners = [center - u - v, center + u - v, center + u + v, center - u + v];
        Self::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])
    }

    /// A box along the axes, given by its least and greatest corner; its faces look outwards.
    pub fn cuboid(low: Vec3, high: Vec3) -> Self {
        let corner = |at: u32| {
            let side =
                |axis: u32, low: f32, high: f32| if at >> axis & 1 == 0 { low } else { high };
            Vec3::new(side(0, low.x, high.x), side(1, low.y, high.y), side(2, low.z, high.z))
        };
        // Corners in the order of their bits x, y, z; two triangles to each face.
        let faces =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
        Self::new((0..8).map(corner).collect(), faces.into_iter().flat_map(halves).collect())
    }

    /// The box of all vertices.
    pub(in crate::scene) fn bounds(&self) -> [DVec3; 2] {
        let none = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        self.positions.iter().fold(none, |[low, high], position| {
            [low.min(position.as_dvec3()), high.max(position.as_dvec3())]
        })
    }

    /// Drops triangles that no ray will ever meet: with two corners in one place, which strips
    /// and the poles of spheres are full of, or with three in line. Returns how many. Refuses all
    /// else that cannot be rendered, but for a mesh that has nothing left.
    pub(crate) fn clean(&mut self) -> Result<usize, Fault> {
        self.check_vertices()?;
        let before = self.triangles.len();
        let positions = &self.positions;
        self.triangles.retain(|triangle| !is_line(triangle.map(|row| positions[row as usize])));
        Ok(before - self.triangles.len())
    }

    /// Refuses what cannot be rendered.
    pub(crate) fn check(&self) -> Result<(), Fault> {
        self.check_vertices()?;
        if let Some(index) =
            self.triangles.iter().position(|triangle| !has_area(self.corners(triangle)))
        {
            let problem = format!("triangle {index} has no area: its corners are in line");
            return Err(Fault::new("", problem, "dissolve it in the modeling program"));
        }
        if self.triangles.is_empty() {
            return Err(Fault::new("", "has no triangle with an area", "remove it or mend it"));
        }
        Ok(())
    }

    /// Corners whose normal is on the back of their triangle, or that have none in a mesh that
    /// has normals. They are mirrored to the front.
    pub(crate) fn corners_behind(&self) -> usize {
        if self.normals.is_empty() {
            return 0;
        }
        let behind = self.triangles.iter().flat_map(|triangle| {
            let front = scaled_normal(self.corners(triangle));
            triangle.map(|row| front.dot(self.normals[row as usize].as_dvec3()) <= 0.0)
        });
        behind.filter(|behind| *behind).count()
    }

    fn corners(&self, triangle: &[u32; 3]) -> [Vec3; 3] {
        triangle.map(|row| self.positions[row as usize])
    }

    /// Refuses vertices that are not finite or do not belong together, and corners without vertex.
    fn check_vertices(&self) -> Result<(), Fault> {
        let count = self.positions.len();
        if let Some(vertex) = self.positions.iter().position(|position| !position.is_finite()) {
            let problem = format!("vertex {vertex} is not finite");
            return Err(Fault::new("positions", problem, "clean the mesh up"));
        }
        let mut corners = self.triangles.as_flattened().iter();
        if let Some(index) = corners.find(|index| **index as usize >= count) {
            let problem = format!("{index} is not one of the {count} vertices");
            return Err(Fault::new("triangles", problem, "count vertices from 0"));
        }
        let fits = |length: usize| length == 0 || length == count;
        if !fits(self.normals.len()) {
            let problem = format!("{} normals for {count} vertices", self.normals.len());
            return Err(Fault::new("normals", problem, "give one to each vertex, or none"));
        }
        if let Some(vertex) = self.normals.iter().position(|normal| !normal.is_finite()) {
            let problem = format!("the normal of vertex {vertex} is not finite");
            return Err(Fault::new("normals", problem, "clean the mesh up"));
        }
        self.check_paint()
    }

    /// Refuses what textures go by if it is not finite, or not of the vertices.
    fn check_paint(&self) -> Result<(), Fault> {
        let count = self.positions.len();
        let sets = [
            ("texture_coordinates", &self.texture_coordinates),
            ("texture_coordinates_1", &self.texture_coordinates_1),
        ];
        for (field, texture) in sets {
            if !(texture.is_empty() || texture.len() == count) {
                let problem = format!("{} for {count} vertices", texture.len());
                return Err(Fault::new(field, problem, "give one pair to each vertex, or none"));
            }
            if let Some(vertex) = texture.iter().position(|pair| !pair.is_finite()) {
                let problem = format!("those of vertex {vertex} are not finite");
                return Err(Fault::new(field, problem, "clean the mesh up"));
            }
        }
        for (field, values) in [("colors", &self.colors), ("tangents", &self.tangents)] {
            if !(values.is_empty() || values.len() == count) {
                let problem = format!("{} for {count} vertices", values.len());
                return Err(Fault::new(field, problem, "give one to each vertex, or none"));
            }
            if let Some(vertex) = values.iter().position(|value| !value.is_finite()) {
                let problem = format!("that of vertex {vertex} is not finite");
                return Err(Fault::new(field, problem, "clean the mesh up"));
            }
        }
        if let Some(vertex) = self.colors.iter().position(|color| color.min_element() < 0.0) {
            let problem = format!("that of vertex {vertex} is below zero");
            return Err(Fault::new("colors", problem, "clean the mesh up"));
        }
        Ok(())
    }
}

/// Whether the corners are in line, as far as positions in `f32` can tell: the height above the
/// longest edge is nothing beside that edge.
fn is_line([a, b, c]: [Vec3; 3]) -> bool {
    let [a, b, c] = [a, b, c].map(|corner| corner.as_dvec3());
    let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
    (b - a).cross(c - a).length() <= f64::from(f32::EPSILON) * longest
}

fn has_area([a, b, c]: [Vec3; 3]) -> bool {
    let (ab, ac) = (b.as_dvec3() - a.as_dvec3(), c.as_dvec3() - a.as_dvec3());
    // Far from zero in most triangles, and without a root; the others are asked in earnest.
    let sine2 = ab.cross(ac).length_squared();
    sine2 > 1e-20 * ab.length_squared() * ac.length_squared()
        || scaled_normal([a, b, c]) != DVec3::ZERO
}

/// The normal of a triangle, of any length; zero only if its area is.
fn scaled_normal([a, b, c]: [Vec3; 3]) -> DVec3 {
    let (ab, ac) = (b.as_dvec3() - a.as_dvec3(), c.as_dvec3() - a.as_dvec3());
    ab.normalize_or_zero().cross(ac.normalize_or_zero())
}
