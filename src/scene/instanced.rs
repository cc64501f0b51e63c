//! Meshes that stand in several places of a scene and are kept once.

use glam::{Affine3A, Mat3A, Vec3, Vec3A};

use super::baked::Triangle;
use super::corners::Corners;

/// Primitives of instances are numbered from multiples of this.
const BLOCK: usize = 1 << BLOCK_SHIFT;
const BLOCK_SHIFT: u32 = 8;

/// The most primitives of a scene: from here on the numbers have other meanings.
pub const PRIMITIVES_MAX: usize = 1 << 31;

/// Shared meshes and where they stand.
///
/// The primitives of an instance are numbered as if the scene held a copy of its object, behind
/// all triangles and spheres of its own, with gaps between the instances.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Instanced {
    objects: Vec<Object>,
    instances: Vec<Instance>,
    /// The smallest primitive of an instance.
    first: usize,
    /// The instance of every block of primitives from `first` on.
    of_block: Vec<u32>,
    has_shading_normals: bool,
}

/// A mesh in its own space, whose origin is the middle of its box.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// Triangles.
    pub triangles: Vec<Triangle>,
    /// As [`super::baked::Shapes::shading_normals`], in this space.
    pub shading_normals: Vec<[Vec3; 3]>,
    /// As [`super::baked::Shapes::corners`], in this space.
    pub corners: Corners,
}

/// An object in its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// Row in the objects.
    pub object: u32,
    /// Row in the scene's surfaces.
    pub surface: u32,
    /// What its first triangle is called as a primitive of the scene.
    pub first_primitive: u32,
    /// From the object's space to the world.
    pub to_world: Affine3A,
    /// The inverse of its linear part.
    pub to_object: Mat3A,
    /// Its box in the world.
    pub bounds: [Vec3; 2],
}

impl Instance {
    /// Origin and direction of a ray of the world in the object's space, where distances along it
    /// are the same.
    #[inline(always)]
    pub fn ray_inside(&self, [origin, direction]: [Vec3A; 2]) -> [Vec3A; 2] {
        [self.to_object * (origin - self.to_world.translation), self.to_object * direction]
    }
}

impl Instanced {
    /// None yet, in a scene with so many primitives of its own.
    pub fn behind(primitives: usize) -> Self {
        Self { first: primitives.next_multiple_of(BLOCK), ..Self::default() }
    }

    /// Adds an object; its row.
    pub fn add_object(&mut self, object: Object) -> u32 {
        self.has_shading_normals |= !object.shading_normals.is_empty();
        self.objects.push(object);
        (self.objects.len() - 1) as u32
    }

    /// Adds an instance, whose `first_primitive` is set here; false if the numbers of primitives
    /// do not suffice.
    pub fn add_instance(&mut self, instance: Instance) -> bool {
        let count = self.objects[instance.object as usize].triangles.len();
        let first_primitive = self.first + self.of_block.len() * BLOCK;
        if first_primitive + count > PRIMITIVES_MAX {
            return false;
        }
        let row = self.instances.len() as u32;
        self.of_block.extend(std::iter::repeat_n(row, count.div_ceil(BLOCK)));
        self.instances.push(Instance { first_primitive: first_primitive as u32, ..instance });
        true
    }

    /// The shared meshes.
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// Where they stand.
    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }

    /// Whether any shading normal differs from the geometric one.
    pub fn has_shading_normals(&self) -> bool {
        self.has_shading_normals
    }

    /// The instance that a primitive belongs to, if any.
    #[inline(always)]
    pub fn instance_of(&self, primitive: u32) -> Option<&Instance> {
        let place = (primitive as usize).checked_sub(self.first)?;
        self.instance_at(place)
    }

    /// The instance of the primitive at a place behind the first of them.
    // Out of line: most scenes have none, and places that ask are many.
    #[inline(never)]
    fn instance_at(&self, place: usize) -> Option<&Instance> {
        self.of_block.get(place >> BLOCK_SHIFT).map(|row| &self.instances[*row as usize])
    }

    /// The instance that a primitive belongs to, its object, and the triangle's row there.
    #[inline(always)]
    pub fn find(&self, primitive: u32) -> Option<(&Instance, &Object, usize)> {
        let instance = self.instance_of(primitive)?;
        let object = &self.objects[instance.object as usize];
        Some((instance, object, (primitive - instance.first_primitive) as usize))
    }

    /// The unit geometric normal of a primitive to its front, if it belongs to an instance.
    pub fn geometric_normal(&self, primitive: u32) -> Option<Vec3> {
        let (instance, object, row) = self.find(primitive)?;
        let [a, b, c] = object.triangles[row].corners;
        Some(instance.normal_to_world((b - a).cross(c - a)).normalize())
    }
}

impl Instance {
    /// Turns a normal of the object into the world; the length changes.
    pub fn normal_to_world(&self, normal: Vec3) -> Vec3 {
        // Of the front: the transposed inverse keeps it on its side even in a reflection.
        (self.to_object.transpose() * Vec3A::from(normal)).into()
    }
}
