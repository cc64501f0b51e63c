//! The primitives of surfaces, taken together.

use std::collections::{BTreeMap, HashMap};

use glam::{DVec3, Vec3};

use super::immersion::{STEPS, spread};
use crate::geometry::offset_distance;
use crate::scene::baked::{Bounds, KEEP, Shapes, Slab, Surface};

/// How much of the area of a surface its triangles may leave open.
const OPEN_SHARE: f64 = 1e-3;

/// Most slabs about them.
const SLABS_MAX: usize = 12;

/// Steps of a component of a normal: those that differ by less count as one.
const NORMAL_STEPS: f64 = 4096.0;

/// Finds the surfaces that bound bodies together: open ones of one material, and with the same on
/// their sides, that share corners and are closed together.
pub fn join(shapes: &mut Shapes, primitives: &[Vec<u32>]) {
    let is_open = |row: &u32| {
        let surface = &shapes.surfaces[*row as usize];
        let bounds = surface.is_body || [surface.interior, surface.exterior] != [KEEP; 2];
        bounds && !Patches::new(shapes, &primitives[*row as usize]).is_closed()
    };
    let open: Vec<u32> = (0..shapes.surfaces.len() as u32).filter(is_open).collect();
    for group in groups(shapes, &open, primitives) {
        let all: Vec<u32> =
            group.iter().flat_map(|&row| primitives[row as usize].iter().copied()).collect();
        if Patches::new(shapes, &all).is_closed() {
            group.iter().for_each(|&row| shapes.surfaces[row as usize].whole = group[0]);
        }
    }
}

/// Surfaces that are alike and share corners.
fn groups(shapes: &Shapes, open: &[u32], primitives: &[Vec<u32>]) -> Vec<Vec<u32>> {
    let mut group_of: Vec<usize> = (0..open.len()).collect();
    let mut first_at = HashMap::new();
    for (index, &row) in open.iter().enumerate() {
        let Surface { material, interior, exterior, priority, .. } = shapes.surfaces[row as usize];
        for corner in Patches::new(shapes, &primitives[row as usize]).corners() {
            let place =
                (corner.to_array().map(f32::to_bits), material, interior, exterior, priority);
            let other: usize = *first_at.entry(place).or_insert(index);
            let [from, to] = [root(&group_of, index), root(&group_of, other)];
            group_of[from.max(to)] = from.min(to);
        }
    }
    let mut groups: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
    for (index, &row) in open.iter().enumerate() {
        groups.entry(root(&group_of, index)).or_default().push(row);
    }
    groups.into_values().collect()
}

/// The first of a group.
fn root(group_of: &[usize], mut index: usize) -> usize {
    while group_of[index] != index {
        index = group_of[index];
    }
    index
}

/// The primitives of all surfaces that bound something together, by the first surface.
pub fn wholes(shapes: &Shapes, primitives: &[Vec<u32>]) -> BTreeMap<u32, Vec<u32>> {
    let mut wholes: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (surface, primitives) in shapes.surfaces.iter().zip(primitives) {
        wholes.entry(surface.whole).or_default().extend(primitives);
    }
    wholes
}

/// For every surface that is wanted, its primitives.
pub fn primitives_of_surfaces(shapes: &Shapes, is_wanted: impl Fn(u32) -> bool) -> Vec<Vec<u32>> {
    let mut primitives: Vec<Vec<u32>> = vec![Vec::new(); shapes.surfaces.len()];
    let wanted: Vec<bool> = (0..shapes.surfaces.len() as u32).map(is_wanted).collect();
    for (primitive, &surface) in (0..).zip(&shapes.surface_of_primitive) {
        if wanted[surface as usize] {
            primitives[surface as usize].push(primitive);
        }
    }
    let instances = shapes.instanced.instances().iter();
    for instance in instances.filter(|instance| wanted[instance.surface as usize]) {
        let count = shapes.instanced.objects()[instance.object as usize].triangles.len() as u32;
        let first = instance.first_primitive;
        primitives[instance.surface as usize].extend(first..first + count);
    }
    primitives
}

/// The primitives of a surface.
pub struct Patches {
    /// Corners of the triangles.
    triangles: Vec<[Vec3; 3]>,
    /// Running sum of their areas.
    areas: Vec<f64>,
    /// Center and radius, if it is a sphere.
    sphere: Option<(Vec3, f32)>,
}

impl Patches {
    /// Those in some rows; spheres only by themselves.
    pub fn new(shapes: &Shapes, primitives: &[u32]) -> Self {
        let own = shapes.triangles.len();
        let sphere = primitives.first().and_then(|&primitive| {
            let row = (primitive as usize).checked_sub(own)?;
            shapes.spheres.get(row).map(|sphere| (sphere.center, sphere.radius))
        });
        let corners = |&primitive: &u32| match shapes.instanced.find(primitive) {
            Some((instance, object, row)) => {
                let corners = object.triangles[row].corners;
                let [a, b, c] = corners.map(|it| instance.to_world.transform_point3(it));
                // Normals keep their side where an instance is mirrored.
                if instance.to_world.matrix3.determinant() < 0.0 { [a, c, b] } else { [a, b, c] }
            }
            None => shapes.triangles[primitive as usize].corners,
        };
        let triangles: Vec<[Vec3; 3]> =
            if sphere.is_some() { Vec::new() } else { primitives.iter().map(corners).collect() };
        let mut sum = 0.0;
        let areas = triangles.iter().map(|triangle| {
            sum += area_vector(triangle).length();
            sum
        });
        Self { areas: areas.collect(), triangles, sphere }
    }

    /// Points all over them, by area, with the normals there.
    pub fn points(&self, count: usize) -> Vec<(Vec3, Vec3)> {
        if let Some((center, radius)) = self.sphere {
            return spread(count).map(|normal| (center + radius * normal, normal)).collect();
        }
        let Some(total) = self.areas.last() else { return Vec::new() };
        // The plastic sequence (Roberts 2018).
        let fraction = |index: usize, step: f64| (0.5 + index as f64 * step).fract() as f32;
        let point = |index: usize| {
            let at = total * (index as f64 + 0.5) / count as f64;
            let row = self.areas.partition_point(|sum| *sum < at).min(self.areas.len() - 1);
            let [a, b, c] = self.triangles[row];
            let (mut u, mut v) =
                (fraction(index, 0.754_877_666_246_693), fraction(index, 0.569_840_290_998_053));
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            (a + u * (b - a) + v * (c - a), area_vector(&[a, b, c]).normalize().as_vec3())
        };
        (0..count).map(point).collect()
    }

    /// How far off them one is on a side of them for sure.
    pub fn step(&self) -> f32 {
        STEPS * self.offset()
    }

    /// How far off them rays start, at most.
    pub fn offset(&self) -> f32 {
        let corners = self.triangles.as_flattened().iter();
        let reach = match self.sphere {
            Some((center, radius)) => center.abs().max_element() + radius,
            None => corners.fold(0.0, |reach: f32, at| reach.max(at.abs().max_element())),
        };
        offset_distance(reach)
    }

    /// Whether nothing gets out but through them.
    pub fn is_closed(&self) -> bool {
        let open: DVec3 = self.triangles.iter().map(area_vector).sum();
        let total = self.areas.last().copied().unwrap_or(0.0);
        self.sphere.is_some() || open.length() < OPEN_SHARE * total
    }

    /// Volume of the box.
    pub fn size(&self) -> f32 {
        let [low, high] = self.bounds();
        (high - low).element_product().max(0.0)
    }

    /// The corners of the box about them.
    pub fn bounds(&self) -> [Vec3; 2] {
        if let Some((center, radius)) = self.sphere {
            return [center - radius, center + radius];
        }
        let none = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        self.corners().fold(none, |[low, high], at| [low.min(at), high.max(at)])
    }

    /// The ball about their box's middle.
    pub fn ball(&self) -> Bounds {
        if let Some((center, radius)) = self.sphere {
            return Bounds { center, radius };
        }
        let [low, high] = self.bounds();
        let center = 0.5 * low + 0.5 * high;
        let reach2 = |reach2: f32, at: Vec3| reach2.max(at.distance_squared(center));
        Bounds { center, radius: self.corners().fold(0.0, reach2).sqrt() }
    }

    /// How far they reach along a direction of unit length: least and greatest.
    pub fn between(&self, along: Vec3) -> [f32; 2] {
        if let Some((center, radius)) = self.sphere {
            let middle = center.dot(along);
            return [middle - radius, middle + radius];
        }
        let none = [f32::INFINITY, f32::NEG_INFINITY];
        self.corners()
            .map(|at| at.dot(along))
            .fold(none, |[low, high], at| [low.min(at), high.max(at)])
    }

    /// The slabs about them along the normals that have most of their area.
    pub fn slabs(&self) -> Vec<Slab> {
        let mut by_normal: HashMap<[i32; 3], DVec3> = HashMap::new();
        for triangle in &self.triangles {
            let area = area_vector(triangle);
            // Both planes of a slab have the same.
            let area = area * area[area.abs().max_position()].signum();
            let key = (area.normalize_or_zero() * NORMAL_STEPS).round().as_ivec3();
            *by_normal.entry(key.to_array()).or_default() += area;
        }
        let mut normals: Vec<([i32; 3], DVec3)> = by_normal.into_iter().collect();
        normals.sort_by(|(key, area), (other, than)| {
            than.length_squared().total_cmp(&area.length_squared()).then(key.cmp(other))
        });
        let normals = normals.into_iter().filter_map(|(_, area)| area.try_normalize());
        let slab = |normal: DVec3| {
            let normal = normal.as_vec3();
            Slab { normal, between: self.between(normal) }
        };
        normals.take(SLABS_MAX).map(slab).collect()
    }

    /// The corners of all triangles.
    pub fn corners(&self) -> impl Iterator<Item = Vec3> {
        self.triangles.as_flattened().iter().copied()
    }
}

/// Half the area of a triangle, along its normal.
fn area_vector([a, b, c]: &[Vec3; 3]) -> DVec3 {
    let [a, b, c] = [a, b, c].map(|corner| corner.as_dvec3());
    0.5 * (b - a).cross(c - a)
}
