//! Scenes and rays of the tests, all from a seeded hash.

use glam::Vec3;
use sunstone::internals::geometry::{HitColumns, RayColumns};
use sunstone::internals::math::LANES;
use sunstone::internals::scene::baked::{Sphere, Triangle};

/// A small generator (splitmix64); tests print the seed with a failure.
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform within [0, 1).
    pub fn uniform(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 24) as f32
    }

    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.uniform()
    }

    pub fn below(&mut self, count: usize) -> usize {
        (self.bits() % count as u64) as usize
    }

    /// Uniform in the cube [-1, 1]^3.
    pub fn in_cube(&mut self) -> Vec3 {
        Vec3::new(self.between(-1.0, 1.0), self.between(-1.0, 1.0), self.between(-1.0, 1.0))
    }

    /// Uniform on the unit sphere.
    pub fn direction(&mut self) -> Vec3 {
        loop {
            let point = self.in_cube();
            if point.length_squared() <= 1.0 && point.length_squared() > 1e-4 {
                return point.normalize();
            }
        }
    }
}

pub fn triangle(a: Vec3, b: Vec3, c: Vec3) -> Triangle {
    Triangle { corners: [a, b, c] }
}

/// The two triangles of the parallelogram at `corner`; the front is the side of `x cross y`.
pub fn quad(corner: Vec3, x: Vec3, y: Vec3) -> [Triangle; 2] {
    let opposite = corner + x + y;
    [triangle(corner, corner + x, opposite), triangle(corner, opposite, corner + y)]
}

/// Triangles and spheres strewn over the cube.
pub fn soup(seed: u64, triangles: usize, spheres: usize) -> (Vec<Triangle>, Vec<Sphere>) {
    let mut random = Random(seed);
    let size = 1.5 / ((triangles + spheres) as f32).cbrt();
    let triangles = (0..triangles).map(|_| {
        let at = random.in_cube();
        triangle(at, at + random.in_cube() * size, at + random.in_cube() * size)
    });
    let triangles = triangles.collect();
    let spheres = (0..spheres)
        .map(|_| Sphere { center: random.in_cube(), radius: random.between(0.1, 0.5) * size });
    (triangles, spheres.collect())
}

/// A closed box, seen from outside counter-clockwise.
pub fn closed_box(low: Vec3, high: Vec3) -> Vec<Triangle> {
    let corner = |index: usize| {
        Vec3::new(
            if index & 1 == 0 { low.x } else { high.x },
            if index & 2 == 0 { low.y } else { high.y },
            if index & 4 == 0 { low.z } else { high.z },
        )
    };
    let faces =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let two = |[a, b, c, d]: [usize; 4]| {
        [triangle(corner(a), corner(b), corner(c)), triangle(corner(a), corner(c), corner(d))]
    };
    faces.into_iter().flat_map(two).collect()
}

/// A sphere of radius one out of `20 * 4^levels` triangles that share corners exactly.
pub fn icosphere(levels: usize) -> Vec<Triangle> {
    let g = (1.0 + 5.0_f32.sqrt()) / 2.0;
    let corners = [
        [-1., g, 0.],
        [1., g, 0.],
        [-1., -g, 0.],
        [1., -g, 0.],
        [0., -1., g],
        [0., 1., g],
        [0., -1., -g],
        [0., 1., -g],
        [g, 0., -1.],
        [g, 0., 1.],
        [-g, 0., -1.],
        [-g, 0., 1.],
    ];
    let faces = [
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    let point = |i: usize| Vec3::from(corners[i]).normalize();
    let mut mesh: Vec<_> = faces.iter().map(|f| f.map(point)).collect();
    for _ in 0..levels {
        // Addition commutes, so both triangles at an edge get the same middle.
        let middle = |a: Vec3, b: Vec3| (a + b).normalize();
        let split = |[a, b, c]: [Vec3; 3]| {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        mesh = mesh.into_iter().flat_map(split).collect();
    }
    mesh.into_iter().map(|corners| Triangle { corners }).collect()
}

/// A Cornell box of five walls at +-1, a light and two spheres: 12 triangles.
pub fn cornell() -> (Vec<Triangle>, Vec<Sphere>) {
    let v = Vec3::new;
    let (x, y, z) = (v(2., 0., 0.), v(0., 2., 0.), v(0., 0., 2.));
    let corner = v(-1., -1., -1.);
    let triangles = [
        quad(corner, z, x),
        quad(corner + y, x, z),
        quad(corner, x, y),
        quad(corner, y, z),
        quad(corner + x, z, y),
        quad(v(-0.5, 0.995, -0.5), v(1., 0., 0.), v(0., 0., 1.)),
    ];
    let spheres = [
        Sphere { center: v(-0.45, -0.62, -0.35), radius: 0.38 },
        Sphere { center: v(0.45, -0.56, 0.3), radius: 0.44 },
    ];
    (triangles.concat(), spheres.to_vec())
}

/// Columns of rays, and how many there are.
pub fn columns(rays: &[(Vec3, Vec3)]) -> RayColumns {
    let mut columns = RayColumns::new(rays.len());
    for (row, (origin, direction)) in rays.iter().enumerate() {
        for axis in 0..3 {
            columns.origin[axis][row] = origin[axis];
            columns.direction[axis][row] = direction[axis];
        }
    }
    columns
}

/// Empty hits for `count` rays.
pub fn no_hits(count: usize) -> HitColumns {
    HitColumns::new(count)
}

/// `count` distances, padded.
pub fn limits(count: usize, t_max: f32) -> Vec<f32> {
    vec![t_max; count + LANES]
}
