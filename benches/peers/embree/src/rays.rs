//! The sets of rays that a renderer of paths traces.

use glam::Vec3;
use sunstone::internals::geometry::{
    Accelerator, HitColumns, RayColumns, TraceScratch, offset_distance, offset_origin,
    trace_closest,
};
use sunstone::internals::math::Vector;
use sunstone::internals::scene::baked::{NONE, Triangle};

use crate::random::Random;
use crate::scenes::Scene;

/// Pixels along one side of the film.
const SIZE: usize = 512;

/// Rays of one kind, in the order of the pixels that they belong to, which follow Morton's curve.
pub struct Set {
    pub name: &'static str,
    pub rays: RayColumns,
    /// Where visibility ends; empty when the closest hit is asked for.
    pub far: Vec<f32>,
    pub count: usize,
}

/// A point on a surface and the normal towards where its ray came from.
#[derive(Clone, Copy)]
struct Vertex {
    position: Vec3,
    normal: Vec3,
}

/// All five sets: camera rays, two diffuse bounces, shadow rays and connections.
pub fn sets(scene: &Scene, tree: &Accelerator) -> Vec<Set> {
    let random = &mut Random(3);
    let camera = camera_rays(scene, random);
    let first = vertices(&camera, scene, tree);
    let bounce1 = bounces("bounce 1", &first, scene, random);
    let second = vertices(&bounce1, scene, tree);
    let bounce2 = bounces("bounce 2", &second, scene, random);
    let light = vertices(&light_rays(scene, camera.count, random), scene, tree);
    let shadow = shadows(&first, scene, random);
    let connection = connections(&first, &light, scene, random);
    vec![camera, bounce1, bounce2, shadow, connection]
}

fn camera_rays(scene: &Scene, random: &mut Random) -> Set {
    let forward = (scene.target - scene.eye).normalize();
    let right = forward.cross(Vec3::Y).normalize();
    let up = right.cross(forward);
    let ray = |index: usize| {
        let (x, y) = (even_bits(index), even_bits(index >> 1));
        let mut at = |k: usize| 2.0 * (k as f32 + random.uniform()) / SIZE as f32 - 1.0;
        let (x, y) = (at(x), at(y));
        (scene.eye, (forward + scene.half_width * (x * right + y * up)).normalize())
    };
    closest_set("camera", (0..SIZE * SIZE).map(ray))
}

/// Every second bit of a Morton number, put together.
fn even_bits(index: usize) -> usize {
    (0..16).map(|bit| (index >> (2 * bit) & 1) << bit).sum()
}

fn light_rays(scene: &Scene, count: usize, random: &mut Random) -> Set {
    let ray = |_| (light_point(scene, random), random.cosine_about(Vec3::NEG_Y));
    closest_set("light", (0..count).map(ray))
}

fn light_point(scene: &Scene, random: &mut Random) -> Vec3 {
    let [corner, u, v] = scene.light;
    corner + random.uniform() * u + random.uniform() * v
}

fn bounces(name: &'static str, vertices: &[Vertex], scene: &Scene, random: &mut Random) -> Set {
    let reach = reach(scene);
    closest_set(
        name,
        vertices.iter().map(|vertex| {
            let direction = random.cosine_about(vertex.normal);
            (leave(vertex, direction, reach), direction)
        }),
    )
}

fn shadows(vertices: &[Vertex], scene: &Scene, random: &mut Random) -> Set {
    let reach = reach(scene);
    let ray = |vertex: &Vertex| {
        let to = light_point(scene, random);
        (leave(vertex, to - vertex.position, reach), to)
    };
    visibility_set("shadow", vertices.iter().map(ray))
}

/// From every vertex to one of the vertices of light paths, any of them.
fn connections(vertices: &[Vertex], light: &[Vertex], scene: &Scene, random: &mut Random) -> Set {
    let reach = reach(scene);
    let ray = |vertex: &Vertex| {
        let other = &light[random.below(light.len())];
        let along = other.position - vertex.position;
        (leave(vertex, along, reach), leave(other, -along, reach))
    };
    visibility_set("connection", vertices.iter().map(ray))
}

fn closest_set(name: &'static str, rays: impl ExactSizeIterator<Item = (Vec3, Vec3)>) -> Set {
    let count = rays.len();
    let mut columns = RayColumns::new(count);
    for (row, (origin, direction)) in rays.enumerate() {
        set_row(&mut columns, row, origin, direction);
    }
    Set { name, rays: columns, far: Vec::new(), count }
}

/// Rays between two points each.
fn visibility_set(name: &'static str, pairs: impl ExactSizeIterator<Item = (Vec3, Vec3)>) -> Set {
    let count = pairs.len();
    let mut columns = RayColumns::new(count);
    let mut far = vec![0.0; columns.origin[0].len()];
    for (row, (from, to)) in pairs.enumerate() {
        let along = to - from;
        far[row] = along.length() * (1.0 - 1e-4);
        set_row(&mut columns, row, from, along.normalize_or(Vec3::X));
    }
    Set { name, rays: columns, far, count }
}

fn set_row(columns: &mut RayColumns, row: usize, origin: Vec3, direction: Vec3) {
    for axis in 0..3 {
        columns.origin[axis][row] = origin[axis];
        columns.direction[axis][row] = direction[axis];
    }
}

/// What the rays of a set meet; those that meet nothing have no vertex.
fn vertices(set: &Set, scene: &Scene, tree: &Accelerator) -> Vec<Vertex> {
    let mut hits = HitColumns::new(set.count);
    trace_closest(&mut hits, &mut TraceScratch::default(), &set.rays, 0..set.count, tree);
    let vertex = |row: usize| {
        let triangle: &Triangle = scene.triangles.get(hits.primitive[row] as usize)?;
        let [a, b, c] = triangle.corners;
        let along = Vec3::from_array(std::array::from_fn(|axis| set.rays.direction[axis][row]));
        let normal = (b - a).cross(c - a).normalize();
        let position = a + hits.u[row] * (b - a) + hits.v[row] * (c - a);
        let normal = if normal.dot(along) < 0.0 { normal } else { -normal };
        Some(Vertex { position, normal })
    };
    let rows = (0..set.count).filter(|row| hits.primitive[*row] != NONE);
    rows.filter_map(vertex).collect()
}

fn reach(scene: &Scene) -> f32 {
    let corners = scene.triangles.iter().flat_map(|triangle| triangle.corners);
    corners.map(|corner| corner.abs().max_element()).fold(0.0, f32::max)
}

/// Where a ray along `direction` starts, in a scene of coordinates up to `reach`.
fn leave(vertex: &Vertex, direction: Vec3, reach: f32) -> Vec3 {
    let vector = |v: Vec3| Vector::new(v.x, v.y, v.z);
    let [position, normal] = [vertex.position, vertex.normal].map(vector);
    let origin = offset_origin(position, normal, vector(direction), offset_distance(reach));
    Vec3::new(origin.x, origin.y, origin.z)
}
