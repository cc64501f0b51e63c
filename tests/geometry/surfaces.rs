//! Points on surfaces.

use glam::{DVec3, Vec3};
use sunstone::internals::geometry::{
    Accelerator, SurfaceColumns, TraceScratch, resolve_surfaces, trace_closest,
};
use sunstone::internals::scene::baked::{Bounds, KEEP, NONE, Shapes, Sphere, Surface, Triangle};
use sunstone::internals::scene::corners::Corners;
use sunstone::internals::scene::instanced::Instanced;

use super::fixtures::{Random, columns, no_hits, soup};

/// A scene out of nothing but shapes; each primitive is a surface of its own, in reverse order.
pub fn scene_of(triangles: &[Triangle], spheres: &[Sphere]) -> Shapes {
    let count = (triangles.len() + spheres.len()) as u32;
    let of_spheres = spheres
        .iter()
        .flat_map(|s| [s.center - Vec3::splat(s.radius), s.center + Vec3::splat(s.radius)]);
    let points: Vec<_> = triangles.iter().flat_map(|t| t.corners).chain(of_spheres).collect();
    let low = points.iter().fold(Vec3::INFINITY, |low, &p| low.min(p));
    let high = points.iter().fold(Vec3::NEG_INFINITY, |high, &p| high.max(p));
    let (axis_x, axis_y) = (Vec3::X, Vec3::Y);
    let surface = Surface {
        material: 0,
        nested_material: 0,
        axis_x,
        axis_y,
        axis_z: Vec3::Z,
        interior: KEEP,
        exterior: KEEP,
        unstated: [false; 2],
        is_opaque: true,
        is_body: false,
        priority: 0,
        whole: NONE,
        solid: NONE,
    };
    Shapes {
        triangles: triangles.to_vec(),
        shading_normals: Vec::new(),
        corners: Corners::default(),
        spheres: spheres.to_vec(),
        instanced: Instanced::default(),
        surface_of_primitive: (0..count).rev().collect(),
        surfaces: vec![surface; count as usize],
        bodies: Vec::new(),
        overlaps: false,
        are_bodies_all: false,
        solids: Vec::new(),
        around_solids: NONE,
        scene_medium: NONE,
        origin: DVec3::ZERO,
        warnings: Vec::new(),
        bounds: Bounds { center: (low + high) / 2.0, radius: (high - low).length() / 2.0 },
    }
}

#[test]
fn points_lie_on_what_was_hit() {
    let (triangles, spheres) = soup(21, 150, 50);
    let mut scene = scene_of(&triangles, &spheres);
    let mut random = Random(21);
    let bend = |t: &Triangle| {
        let normal = (t.corners[1] - t.corners[0]).cross(t.corners[2] - t.corners[0]);
        [0, 1, 2].map(|_| (normal.normalize() + random.in_cube() * 0.3).normalize())
    };
    let shading: Vec<_> = triangles.iter().map(bend).collect();
    let accelerator = Accelerator::build(&triangles, &spheres);
    let rays: Vec<_> = (0..5003).map(|_| (random.in_cube(), random.direction())).collect();
    let (columns, mut hits) = (columns(&rays), no_hits(rays.len()));
    trace_closest(&mut hits, &mut TraceScratch::default(), &columns, 0..rays.len(), &accelerator);
    for normals in [Vec::new(), shading] {
        scene.shading_normals = normals;
        let mut surfaces = SurfaceColumns::new(rays.len());
        resolve_surfaces(&mut surfaces, &hits, &columns, 0..rays.len(), &scene);
        let vector = |columns: &[Vec<f32>; 3], row: usize| {
            Vec3::new(columns[0][row], columns[1][row], columns[2][row])
        };
        for (row, &(origin, direction)) in rays.iter().enumerate() {
            let primitive = hits.primitive[row];
            assert_eq!(surfaces.primitive[row], primitive);
            let position = vector(&surfaces.position, row);
            if primitive == NONE {
                assert_eq!((surfaces.surface[row], position), (NONE, Vec3::ZERO));
                continue;
            }
            assert_eq!(surfaces.surface[row], 199 - primitive);
            assert!((origin + direction * hits.t[row] - position).length() < 1e-5);
            let normal = vector(&surfaces.geometric_normal, row);
            let shading = vector(&surfaces.shading_normal, row);
            assert!((normal.length() - 1.0).abs() < 1e-6);
            assert!((shading.length() - 1.0).abs() < 1e-6);
            if let Some(t) = triangles.get(primitive as usize) {
                let [a, b, c] = t.corners;
                assert!((b - a).cross(c - a).normalize().dot(normal) > 0.999_99);
                assert!((position - a).dot(normal).abs() < 1e-6);
                let expected = match scene.shading_normals.get(primitive as usize) {
                    Some([a, b, c]) => {
                        let (u, v) = (hits.u[row], hits.v[row]);
                        (a * (1.0 - u - v) + b * u + c * v).normalize()
                    }
                    None => normal,
                };
                assert!((expected - shading).length() < 1e-5);
            } else {
                let sphere = &spheres[primitive as usize - triangles.len()];
                let from = position - sphere.center;
                assert!((from.length() - sphere.radius).abs() < 1e-6);
                assert!(from.normalize().dot(normal) > 0.999_99);
                assert_eq!(shading, normal);
            }
        }
    }
}
