//! What triangles have at their corners for textures: coordinates, colors and tangents.

use glam::{Mat3A, Vec2, Vec3, Vec3A, Vec4, Vec4Swizzles};

use super::baked::Shapes;
use super::instanced::Instance;
use super::world::{Geometry, Textures};

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
            tangents: textures.relief.is_some(),
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

/// A triangle of a scene, for textures.
#[derive(Clone, Copy)]
pub struct Painted<'a> {
    corners: [Vec3; 3],
    of: &'a Corners,
    row: usize,
    instance: Option<&'a Instance>,
}

impl Shapes {
    /// A primitive, if it is a triangle.
    #[inline]
    pub fn painted(&self, primitive: u32) -> Option<Painted<'_>> {
        if let Some(triangle) = self.triangles.get(primitive as usize) {
            let (corners, of, row) = (triangle.corners, &self.corners, primitive as usize);
            return Some(Painted { corners, of, row, instance: None });
        }
        let (instance, object, row) = self.instanced.find(primitive)?;
        let (corners, of) = (object.triangles[row].corners, &object.corners);
        Some(Painted { corners, of, row, instance: Some(instance) })
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
    /// Texture coordinates of a set.
    #[inline]
    pub fn coordinates(&self, set: usize, weights: [f32; 2]) -> Vec2 {
        between(self.of.coordinates_of(set, self.row), weights)
    }

    /// The colors of the corners.
    #[inline]
    pub fn colors(&self) -> [Vec4; 3] {
        self.of.colors.get(self.row).copied().unwrap_or([Vec4::ONE; 3])
    }

    /// The weights of the second and third corner at a point of the triangle in the world.
    pub fn weights_at(&self, position: Vec3) -> [f32; 2] {
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

    /// Unit vectors to the right and up of a picture, in the world and about a unit normal: those
    /// of the mesh, or those along which its coordinates, `place` of a set, change. None where
    /// they do not.
    pub fn frame(
        &self,
        (set, place): (usize, impl Fn(Vec2) -> Vec2),
        weights: [f32; 2],
        normal: Vec3,
    ) -> Option<[Vec3; 2]> {
        let (to_world, turns) = match self.instance {
            Some(it) => (it.to_world.matrix3, it.to_world.matrix3.determinant() < 0.0),
            None => (Mat3A::IDENTITY, false),
        };
        let stated = self.of.tangents.get(self.row).map(|tangents| between(*tangents, weights));
        let (right, side) = match stated {
            Some(tangent) if tangent.w != 0.0 && tangent.xyz() != Vec3::ZERO => {
                (to_world * tangent.xyz(), if turns { -tangent.w } else { tangent.w })
            }
            Some(_) | None => {
                let [a, b, c] = self.of.coordinates_of(set, self.row).map(place);
                let ((b_u, b_v), (c_u, c_v)) = ((b - a).into(), (c - a).into());
                let area = b_u * c_v - c_u * b_v;
                let [along, beside] = [1, 2].map(|corner| self.corners[corner] - self.corners[0]);
                let right = to_world * (along * c_v - beside * b_v) * area.signum();
                let down = to_world * (beside * b_u - along * c_u) * area.signum();
                if area == 0.0 || !area.is_finite() {
                    return None;
                }
                (right, normal.cross(right).dot(-down))
            }
        };
        let right = right.reject_from_normalized(normal).try_normalize()?;
        Some([right, normal.cross(right) * side.signum()])
    }
}
