//! The scenes of the race: triangles, a camera and an area light.

use std::f32::consts::{PI, TAU};
use std::path::Path;

use glam::{Quat, Vec3};
use sunstone::internals::scene::baked::{BakedScene, Triangle};
use sunstone::internals::scene::{bake, load};
use sunstone::internals::spectrum::Carried;

use crate::random::Random;

/// What rays are traced through.
pub struct Scene {
    pub name: &'static str,
    pub triangles: Vec<Triangle>,
    pub eye: Vec3,
    pub target: Vec3,
    /// Half the width of the film at unit distance.
    pub half_width: f32,
    /// A corner of the light and its two edges.
    pub light: [Vec3; 3],
}

/// The four scenes of the race, smallest first.
pub fn all() -> Result<Vec<Scene>, String> {
    Ok(vec![cornell(), bunny()?, room(), landscape()])
}

/// A Cornell box of 36 triangles.
fn cornell() -> Scene {
    let mut mesh = Mesh::default();
    mesh.block(Vec3::ZERO, Vec3::ONE, 0.0);
    mesh.block(Vec3::new(-0.3, -0.4, -0.3), Vec3::new(0.3, 0.6, 0.3), 0.3);
    mesh.block(Vec3::new(0.4, -0.7, 0.4), Vec3::splat(0.3), -0.3);
    Scene {
        name: "cornell",
        triangles: mesh.triangles,
        eye: Vec3::new(0.0, 0.0, 0.98),
        target: Vec3::ZERO,
        half_width: 0.8,
        light: [Vec3::new(-0.25, 0.99, -0.25), Vec3::X * 0.5, Vec3::Z * 0.5],
    }
}

/// The Stanford bunny of the tank scene, each triangle cut in sixteen, in a room.
fn bunny() -> Result<Scene, String> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../scenes/tank.gltf");
    let world = load(&file).map_err(|error| error.to_string())?;
    let baked = bake(&world, &Carried::RGB).map_err(|error| error.to_string())?;
    let mut triangles = largest_mesh(&baked);
    for _ in 0..2 {
        triangles = triangles.iter().flat_map(quartered).collect();
    }
    let mut mesh = Mesh { triangles: standing(triangles) };
    mesh.block(Vec3::new(0.0, 1.5, 0.0), Vec3::new(2.0, 1.5, 2.0), 0.0);
    Ok(Scene {
        name: "bunny",
        triangles: mesh.triangles,
        eye: Vec3::new(0.4, 1.0, 1.9),
        target: Vec3::new(0.0, 0.5, 0.0),
        half_width: 0.5,
        light: [Vec3::new(-0.4, 2.99, -0.4), Vec3::X * 0.8, Vec3::Z * 0.8],
    })
}

/// A furnished room of 111 thousand triangles of very different sizes: shelves of books, tables,
/// chairs, bowls and lamps, blinds before a window.
fn room() -> Scene {
    let mut mesh = Mesh::default();
    let random = &mut Random(1);
    mesh.block(Vec3::new(0.0, 1.5, 0.0), Vec3::new(4.0, 1.5, 3.0), 0.0);
    for shelf in 0..30 {
        let (column, row) = ((shelf % 6) as f32, (shelf / 6) as f32);
        let center = Vec3::new(-3.3 + 1.3 * column, 0.3 + 0.5 * row, -2.75);
        mesh.block(center - Vec3::Y * 0.2, Vec3::new(0.6, 0.01, 0.2), 0.0);
        for book in 0..28 {
            let half = Vec3::new(0.018, random.between(0.1, 0.17), random.between(0.1, 0.16));
            let along = -0.56 + 0.04 * book as f32;
            let lean = random.between(-0.02, 0.02);
            mesh.block(center + Vec3::new(along, half.y - 0.19, 0.0), half, lean);
        }
    }
    for blind in 0..60 {
        let center = Vec3::new(3.9, 0.6 + 0.035 * blind as f32, 0.0);
        mesh.block(center, Vec3::new(0.015, 0.002, 2.0), 0.0);
    }
    for place in 0..6 {
        let at = Vec3::new(-2.5 + 2.0 * (place % 3) as f32, 0.0, -0.8 + 2.0 * (place / 3) as f32);
        mesh.block(at + Vec3::Y * 0.75, Vec3::new(0.6, 0.02, 0.4), 0.2 * place as f32);
        for corner in 0..4 {
            let sign = Vec3::new((corner % 2) as f32 - 0.5, 0.0, (corner / 2) as f32 - 0.5);
            mesh.block(at + sign * 0.9 + Vec3::Y * 0.37, Vec3::new(0.02, 0.37, 0.02), 0.0);
            mesh.block(at + sign * 1.5 + Vec3::Y * 0.45, Vec3::new(0.2, 0.02, 0.2), 1.0);
        }
        for _ in 0..5 {
            let aside = Vec3::new(random.between(-0.5, 0.5), 0.83, random.between(-0.3, 0.3));
            mesh.ball(at + aside, random.between(0.03, 0.08), 40, 0.1, random);
        }
        mesh.ball(at + Vec3::Y * 2.4, 0.2, 64, 0.0, random);
    }
    Scene {
        name: "room",
        triangles: mesh.triangles,
        eye: Vec3::new(2.8, 1.7, 2.7),
        target: Vec3::new(-1.0, 0.9, -1.0),
        half_width: 0.8,
        light: [Vec3::new(-1.0, 2.99, -1.0), Vec3::X * 2.0, Vec3::Z * 2.0],
    }
}

/// Boulders on rough ground, 4.4 million triangles, under a large light.
fn landscape() -> Scene {
    let mut mesh = Mesh::default();
    let random = &mut Random(2);
    let height = |x: f32, z: f32| {
        let waves = [(0.35, 1.1, 0.6), (0.9, 0.3, 0.35), (2.3, 2.9, 0.12), (7.1, 6.3, 0.04)];
        waves.iter().map(|(a, b, height)| height * (a * x + 1.0).sin() * (b * z).cos()).sum()
    };
    mesh.ground(1024, 20.0, height);
    for _ in 0..285 {
        let (x, z) = (random.between(-9.0, 9.0), random.between(-9.0, 9.0));
        let radius = random.between(0.05, 0.4);
        mesh.ball(Vec3::new(x, height(x, z) + 0.5 * radius, z), radius, 64, 0.15, random);
    }
    Scene {
        name: "landscape",
        triangles: mesh.triangles,
        eye: Vec3::new(7.0, 3.0, 7.0),
        target: Vec3::ZERO,
        half_width: 0.7,
        light: [Vec3::new(-3.0, 8.0, -3.0), Vec3::X * 6.0, Vec3::Z * 6.0],
    }
}

#[derive(Default)]
struct Mesh {
    triangles: Vec<Triangle>,
}

impl Mesh {
    fn quad(&mut self, [a, b, c, d]: [Vec3; 4]) {
        self.triangles.push(Triangle { corners: [a, b, c] });
        self.triangles.push(Triangle { corners: [a, c, d] });
    }

    /// A box, turned about the vertical.
    fn block(&mut self, center: Vec3, half: Vec3, angle: f32) {
        let turn = Quat::from_rotation_y(angle);
        let corner = |x: f32, y: f32, z: f32| center + turn * (half * Vec3::new(x, y, z));
        for side in [-1.0, 1.0] {
            let ring = [(-side, -1.0), (side, -1.0), (side, 1.0), (-side, 1.0)];
            self.quad(ring.map(|(u, v)| corner(side, v, u)));
            self.quad(ring.map(|(u, v)| corner(u, side, v)));
            self.quad(ring.map(|(u, v)| corner(v, u, side)));
        }
    }

    /// A ball of `rings` times `rings` quadrilaterals, with bumps.
    fn ball(&mut self, center: Vec3, radius: f32, rings: usize, bump: f32, random: &mut Random) {
        let phase = random.between(0.0, TAU);
        let point = |ring: usize, step: usize| {
            let (theta, phi) =
                (PI * ring as f32 / rings as f32, TAU * (step % rings) as f32 / rings as f32);
            let normal = Vec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin());
            let wave = (5.0 * normal.x + phase).sin() * (4.0 * normal.y).cos()
                + (6.0 * normal.z - phase).sin();
            center + radius * (1.0 + bump * wave) * normal
        };
        for ring in 0..rings {
            for step in 0..rings {
                let (next, after) = (ring + 1, step + 1);
                let corners = [(ring, step), (ring, after), (next, after), (next, step)];
                let corners = corners.map(|(ring, step)| point(ring, step));
                self.quad(corners);
            }
        }
    }

    fn ground(&mut self, cells: usize, width: f32, height: impl Fn(f32, f32) -> f32) {
        let point = |i: usize, j: usize| {
            let at = |k: usize| width * (k as f32 / cells as f32 - 0.5);
            Vec3::new(at(i), height(at(i), at(j)), at(j))
        };
        for i in 0..cells {
            for j in 0..cells {
                self.quad([point(i, j), point(i, j + 1), point(i + 1, j + 1), point(i + 1, j)]);
            }
        }
    }
}

/// The triangles of the surface that has most of them.
fn largest_mesh(baked: &BakedScene<3>) -> Vec<Triangle> {
    let of_surface = |surface: usize| {
        let all = baked.shapes.triangles.iter().zip(&baked.shapes.surface_of_primitive);
        all.filter(|(_, of)| **of as usize == surface).map(|(triangle, _)| *triangle).collect()
    };
    (0..baked.shapes.surfaces.len()).map(of_surface).max_by_key(Vec::len).unwrap_or_default()
}

/// The four triangles between the corners and the middles of the edges.
fn quartered(triangle: &Triangle) -> [Triangle; 4] {
    let [a, b, c] = triangle.corners;
    let [d, e, f] = [a.midpoint(b), b.midpoint(c), c.midpoint(a)];
    [[a, d, f], [d, b, e], [f, e, c], [d, e, f]].map(|corners| Triangle { corners })
}

/// The mesh one unit high, standing on the ground at the origin.
fn standing(mut triangles: Vec<Triangle>) -> Vec<Triangle> {
    let corners = || triangles.iter().flat_map(|triangle| triangle.corners);
    let low = corners().fold(Vec3::INFINITY, Vec3::min);
    let high = corners().fold(Vec3::NEG_INFINITY, Vec3::max);
    let foot = low.midpoint(high).with_y(low.y);
    for corner in triangles.iter_mut().flat_map(|triangle| &mut triangle.corners) {
        *corner = (*corner - foot) / (high.y - low.y);
    }
    triangles
}
