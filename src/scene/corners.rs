//! What triangles have at their corners for textures: coordinates, colors and tangents; and what
//! spheres have all over.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::{Mat3A, Vec2, Vec3, Vec3A, Vec4, Vec4Swizzles};

use super::baked::{Shapes, Sphere, Surface};
use super::instanced::Instance;
use super::world::{Geometry, ReliefOf, Textures};
use crate::math::elementary::{acos, atan2, hypot};

/// Which of it textures need.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Needs {
    /// Coordinates of the two sets.
    pub coordinates: [bool; 2],
    /// Colors.
    pub colors: bool,
    /// Tangents.
    pub tangents: bool,
}

impl Needs {
    /// What says where pictures have their right.
    pub const TO_THE_RIGHT: Self =
        Self { coordinates: [true, false], colors: false, tangents: true };

    /// Those of the textures of a material.
    pub fn of(textures: &Textures) -> Self {
        let has_set = |set| textures.textures().any(|texture| texture.set == set);
        Self {
            coordinates: [has_set(0), has_set(1)],
            colors: textures.read_vertices(),
            tangents: textures
                .relief
                .as_ref()
                .is_some_and(|relief| matches!(relief.of, ReliefOf::Normals(_))),
        }
    }

    /// All that one or the other needs.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            coordinates: [0, 1].map(|set| self.coordinates[set] || other.coordinates[set]),
            colors: self.colors || other.colors,
            tangents: self.tangents || other.tangents,
        }
    }
}

/// One corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// Texture coordinates of the two sets; zero where there are none.
    pub coordinates: [Vec2; 2],
    /// Linear red, green, blue and alpha; one where there are none.
    pub color: Vec4,
    /// As [`Geometry::tangents`]; zero where there are none.
    pub tangent: Vec4,
}

impl Corner {
    /// That of a vertex of a mesh.
    pub fn of(geometry: &Geometry, vertex: usize) -> Self {
        let sets = [&geometry.texture_coordinates, &geometry.texture_coordinates_1];
        Self {
            coordinates: sets.map(|set| set.get(vertex).copied().unwrap_or_default()),
            color: geometry.colors.get(vertex).copied().unwrap_or(Vec4::ONE),
            tangent: geometry.tangents.get(vertex).copied().unwrap_or_default(),
        }
    }

    /// In the middle of two.
    #[must_use]
    pub fn middle(self, other: Self) -> Self {
        let coordinates = [0, 1].map(|set| 0.5 * (self.coordinates[set] + other.coordinates[set]));
        // Of two sides of a seam there is none.
        let tangent = match self.tangent.w == other.tangent.w {
            true => 0.5 * (self.tangent + other.tangent),
            false => Vec4::ZERO,
        };
        Self { coordinates, color: 0.5 * (self.color + other.color), tangent }
    }
}

/// The corners of some triangles, three a row; what is not needed is empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Corners {
    needs: Needs,
    coordinates: [Vec<[Vec2; 3]>; 2],
    colors: Vec<[Vec4; 3]>,
    tangents: Vec<[Vec4; 3]>,
}

impl Corners {
    /// None yet.
    pub fn new(needs: Needs) -> Self {
        Self { needs, ..Self::default() }
    }

    /// What is kept.
    pub fn needs(&self) -> Needs {
        self.needs
    }

    /// Appends a triangle.
    pub fn push(&mut self, corners: [Corner; 3]) {
        for (set, column) in self.coordinates.iter_mut().enumerate() {
            if self.needs.coordinates[set] {
                column.push(corners.map(|corner| corner.coordinates[set]));
            }
        }
        if self.needs.colors {
            self.colors.push(corners.map(|corner| corner.color));
        }
        if self.needs.tangents {
            self.tangents.push(corners.map(|corner| corner.tangent));
        }
    }

    /// The corners of a triangle.
    pub fn row(&self, row: usize) -> [Corner; 3] {
        [0, 1, 2].map(|corner| Corner {
            coordinates: [0, 1].map(|set| self.coordinates_of(set, row)[corner]),
            color: self.colors.get(row).map_or(Vec4::ONE, |colors| colors[corner]),
            tangent: self.tangents.get(row).map_or(Vec4::ZERO, |tangents| tangents[corner]),
        })
    }

    fn coordinates_of(&self, set: usize, row: usize) -> [Vec2; 3] {
        self.coordinates[set].get(row).copied().unwrap_or_default()
    }

    /// Memory of all triangles in bytes.
    pub fn bytes(&self) -> usize {
        let [first, second] = &self.coordinates;
        size_of::<[Vec2; 3]>() * (first.len() + second.len())
            + size_of::<[Vec4; 3]>() * (self.colors.len() + self.tangents.len())
    }
}

/// A primitive of a scene, for textures. Where it has been hit is said by two weights: those of the
/// second and third corner of a triangle, and the coordinates of a sphere.
#[derive(Clone, Copy)]
pub enum Painted<'a> {
    /// A triangle.
    Flat(Flat<'a>),
    /// A sphere, whose coordinates are those of Mitsuba's: u goes once round the z axis of its
    /// node, from x over y, and v from the pole on that axis to the other.
    Round(Round<'a>),
}

/// A triangle with its corners.
#[derive(Clone, Copy)]
pub struct Flat<'a> {
    corners: [Vec3; 3],
    of: &'a Corners,
    row: usize,
    instance: Option<&'a Instance>,
}

/// A sphere with the axes of its node.
#[derive(Clone, Copy)]
pub struct Round<'a> {
    sphere: &'a Sphere,
    surface: &'a Surface,
}

impl Shapes {
    /// A primitive, if there is one of this number.
    #[inline]
    pub fn painted(&self, primitive: u32) -> Option<Painted<'_>> {
        let row = primitive as usize;
        if let Some(triangle) = self.triangles.get(row) {
            let (corners, of) = (triangle.corners, &self.corners);
            return Some(Painted::Flat(Flat { corners, of, row, instance: None }));
        }
        if let Some(sphere) = self.spheres.get(row - self.triangles.len()) {
            let surface = &self.surfaces[self.surface_of_primitive[row] as usize];
            return Some(Painted::Round(Round { sphere, surface }));
        }
        let (instance, object, row) = self.instanced.find(primitive)?;
        let (corners, of) = (object.triangles[row].corners, &object.corners);
        Some(Painted::Flat(Flat { corners, of, row, instance: Some(instance) }))
    }
}

/// Between three corners, by the weights of the second and third.
#[inline]
fn between<T>([a, b, c]: [T; 3], [u, v]: [f32; 2]) -> T
where
    T: Copy
        + std::ops::Add<Output = T>
        + std::ops::Sub<Output = T>
        + std::ops::Mul<f32, Output = T>,
{
    a + (b - a) * u + (c - a) * v
}

impl Painted<'_> {
    /// The weights where a ray has hit it, by those of a triangle and by the point.
    #[inline]
    pub fn weights(&self, of_triangle: [f32; 2], position: Vec3) -> [f32; 2] {
        match self {
            Self::Flat(_) => of_triangle,
            Self::Round(round) => round.coordinates(position),
        }
    }

    /// The weights at a point of it in the world.
    pub fn weights_at(&self, position: Vec3) -> [f32; 2] {
        match self {
            Self::Flat(flat) => flat.weights_at(position),
            Self::Round(round) => round.coordinates(position),
        }
    }

    /// Texture coordinates of a set.
    #[inline]
    pub fn coordinates(&self, set: usize, weights: [f32; 2]) -> Vec2 {
        match self {
            Self::Flat(flat) => flat.coordinates(set, weights),
            Self::Round(_) => weights.into(),
        }
    }

    /// The colors of the corners.
    #[inline]
    pub fn colors(&self) -> [Vec4; 3] {
        match self {
            Self::Flat(flat) => flat.of.colors.get(flat.row).copied().unwrap_or([Vec4::ONE; 3]),
            Self::Round(_) => [Vec4::ONE; 3],
        }
    }

    /// Unit vectors to the right and up of a picture, in the world and about a unit normal: those
    /// of the mesh, or those along which its coordinates, `place` of a set, change. None where
    /// they do not.
    pub fn frame(
        &self,
        (set, place): (usize, impl Fn(Vec2) -> Vec2),
        weights: [f32; 2],
        normal: Vec3,
    ) -> Option<[Vec3; 2]> {
        let stated = match self {
            Self::Flat(flat) => flat.tangent(weights),
            Self::Round(_) => None,
        };
        let (right, side) = match stated {
            Some(stated) => stated,
            None => {
                let ([right, down], area) = self.edges(set, place, normal).along_coordinates();
                let [right, down] = [right, down].map(|along| along * area.signum());
                if area == 0.0 || !area.is_finite() {
                    return None;
                }
                (right, normal.cross(right).dot(-down))
            }
        };
        let right = right.reject_from_normalized(normal).try_normalize()?;
        Some([right, normal.cross(right) * side.signum()])
    }

    /// How places change with the first coordinate of a set, and with the second, at the unit
    /// `normal` without a relief. None where they do not.
    pub fn derivatives(&self, set: usize, normal: Vec3) -> Option<[Vec3; 2]> {
        let (along, area) = self.edges(set, |place| place, normal).along_coordinates();
        let along = along.map(|along| along / area);
        along.iter().all(|along| along.is_finite()).then_some(along)
    }

    /// About the root of the number of texels that it shows of a picture of a size, in which its
    /// coordinates are `place` of a set.
    pub fn texels(&self, set: usize, place: impl Fn(Vec2) -> Vec2, size: [u32; 2]) -> f32 {
        let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
            .map(|weights| place(self.coordinates(set, weights)));
        let [right, down] = [1, 2].map(|corner| corners[corner] - corners[0]);
        let [width, height] = size.map(|side| side as f32);
        (right.perp_dot(down) * width * height).abs().sqrt()
    }

    /// Weights of points all over it, of which each stands for the same area: about half as many
    /// as the square of the steps.
    pub fn spread(&self, steps: usize) -> Vec<[f32; 2]> {
        let mut all = Vec::new();
        for i in 0..steps {
            match self {
                Self::Flat(_) => all.extend(
                    (0..steps - i).map(|j| [i, j].map(|at| (at as f32 + 1.0 / 3.0) / steps as f32)),
                ),
                Self::Round(_) => all.extend((0..steps.div_ceil(2)).map(|j| {
                    let rows = steps.div_ceil(2) as f32;
                    let height = 1.0 - 2.0 * (j as f32 + 0.5) / rows;
                    let angle = acos(f64::from(height)) as f32;
                    [(i as f32 + 0.5) / steps as f32, angle * FRAC_1_PI]
                })),
            }
        }
        all
    }

    fn edges(&self, set: usize, place: impl Fn(Vec2) -> Vec2, normal: Vec3) -> Edges {
        match self {
            Self::Flat(flat) => flat.edges(set, place),
            Self::Round(round) => round.edges(place, normal),
        }
    }
}

/// Two ways along a surface in the world, and how coordinates change on them.
struct Edges {
    ways: [Vec3; 2],
    changes: [Vec2; 2],
}

impl Edges {
    /// How places change with the first coordinate and with the second, times what these are
    /// to be divided by.
    #[inline]
    fn along_coordinates(&self) -> ([Vec3; 2], f32) {
        let [along, beside] = self.ways;
        let [(b_u, b_v), (c_u, c_v)] = self.changes.map(<(f32, f32)>::from);
        let area = b_u * c_v - c_u * b_v;
        ([along * c_v - beside * b_v, beside * b_u - along * c_u], area)
    }
}

impl Flat<'_> {
    #[inline]
    fn coordinates(&self, set: usize, weights: [f32; 2]) -> Vec2 {
        between(self.of.coordinates_of(set, self.row), weights)
    }

    fn weights_at(&self, position: Vec3) -> [f32; 2] {
        let position = match self.instance {
            Some(it) => it.to_object * (Vec3A::from(position) - it.to_world.translation),
            None => position.into(),
        };
        let [a, b, c] = self.corners.map(Vec3::as_dvec3);
        let (b, c) = (b - a, c - a);
        let normal = b.cross(c);
        let to = position.as_dvec3() - a;
        let scale = normal.length_squared().recip();
        let (u, v) = (to.cross(c).dot(normal) * scale, b.cross(to).dot(normal) * scale);
        // Rounding takes points out of slivers.
        let u = u.clamp(0.0, 1.0);
        [u as f32, v.clamp(0.0, 1.0 - u) as f32]
    }

    fn to_world(self) -> Mat3A {
        self.instance.map_or(Mat3A::IDENTITY, |it| it.to_world.matrix3)
    }

    /// The tangent that the mesh states, in the world, and on which side of it up is.
    fn tangent(&self, weights: [f32; 2]) -> Option<(Vec3, f32)> {
        let tangent = between(*self.of.tangents.get(self.row)?, weights);
        let is_stated = tangent.w != 0.0 && tangent.xyz() != Vec3::ZERO;
        let to_world = self.to_world();
        let turns = self.instance.is_some() && to_world.determinant() < 0.0;
        let side = if turns { -tangent.w } else { tangent.w };
        is_stated.then(|| (to_world * tangent.xyz(), side))
    }

    fn edges(&self, set: usize, place: impl Fn(Vec2) -> Vec2) -> Edges {
        let [a, b, c] = self.of.coordinates_of(set, self.row).map(place);
        let to_world = self.to_world();
        let ways = [1, 2].map(|corner| to_world * (self.corners[corner] - self.corners[0]));
        Edges { ways, changes: [b - a, c - a] }
    }
}

impl Round<'_> {
    fn coordinates(&self, position: Vec3) -> [f32; 2] {
        let Surface { axis_x, axis_y, axis_z, .. } = self.surface;
        let normal = (position - self.sphere.center).as_dvec3();
        let [x, y, z] = [axis_x, axis_y, axis_z].map(|axis| normal.dot(axis.as_dvec3()));
        let turn = atan2(y, x) as f32 * (0.5 * FRAC_1_PI);
        let v = atan2(hypot(x, y), z) as f32 * FRAC_1_PI;
        [if turn < 0.0 { turn + 1.0 } else { turn }, v]
    }

    fn edges(&self, place: impl Fn(Vec2) -> Vec2, normal: Vec3) -> Edges {
        let Surface { axis_x, axis_y, axis_z, .. } = self.surface;
        let (radius, cosine) = (self.sphere.radius, normal.dot(*axis_z));
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let round = axis_x.cross(*axis_y).cross(normal) * (2.0 * PI * radius);
        let down = (normal * cosine - *axis_z) / sine * (PI * radius);
        let start = place(Vec2::ZERO);
        Edges { ways: [round, down], changes: [Vec2::X, Vec2::Y].map(|step| place(step) - start) }
    }
}
