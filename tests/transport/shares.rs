//! Surfaces that are there by a share, against what holds whatever the share is: what is white
//! vanishes in a white sky, and balls let the rest through, twice.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::Mode;
use sunstone::internals::scattering::Scene;
use sunstone::internals::scene::World;
use sunstone::world::{
    Bsdf, Coverage, Filter, Lens, Material, Medium, Paint, Phase, Reads, Skin, Textures, Transform,
};

use crate::support::painted::{picture, quad, texture};
use crate::support::rendering::{MONO, replicates, scene, settings};
use crate::support::statistics::{Estimate, mean_s0};

/// All that brings light by surfaces that connect.
const ALL: [Integrator; 3] = [Integrator::Path, Integrator::Bdpt, Integrator::Ppm];

/// The same share everywhere.
fn even(share: f32) -> Textures {
    let factor = [share; 3];
    let paint = Paint { factor, texture: None, reads: Reads::Alpha, by_vertices: false };
    Textures { coverage: Some(Coverage { paint, cutoff: None }), ..Textures::default() }
}

/// Shares by a picture: columns that are hardly there beside some that are.
fn columns(cutoff: Option<f32>) -> Textures {
    let alpha = [3, 255, 40, 0];
    let picture = picture(4, |x, _| [0, 0, 0, alpha[x as usize]]);
    let texture = Some(texture(picture, Filter::Nearest));
    let paint = Paint { factor: [1.0; 3], texture, reads: Reads::Alpha, by_vertices: false };
    Textures { coverage: Some(Coverage { paint, cutoff }), ..Textures::default() }
}

fn looked_at(world: &mut World) {
    let place = Transform::looking(DVec3::Z * 2.0, DVec3::ZERO, DVec3::Y);
    let lens = Lens::Orthographic { half_width: 1.0, half_height: 1.0 };
    world.set_camera("eye", lens, place).unwrap();
    world.set_environment(1.0).unwrap();
}

/// How many standard errors the mean of 12 images is off, and the mean.
fn score(world: &World, integrator: Integrator, expected: f64) -> (f64, f64) {
    let scene: Arc<Scene<1>> = scene(world, MONO, [6, 6]);
    let images = replicates(&scene, &settings(integrator, Mode::Scalar, MONO, 12, 100), 12);
    let found = Estimate::of(&images.iter().map(mean_s0).collect::<Vec<f64>>());
    (found.score(&Estimate::exact(expected), 1.0).unwrap_or(0.0), found.mean)
}

/// Between two white sheets, under a sky of one, everything is one, whatever light has met before:
/// what photons bring, too, where hardly any of them meet the sheets. 5 standard errors by 12
/// replicates are exceeded in 1 of 2,500 cases at worst, of which there are 15.
#[test]
fn white_sheets_vanish_in_a_white_sky() {
    for of in [even(0.02), even(0.3), even(0.8), columns(None), columns(Some(0.5))] {
        let white = || Material::from(Bsdf::diffuse(1.0)).two_sided();
        let mut world = World::new("sheets");
        for (name, height) in [("near", 0.0), ("far", -0.4)] {
            let material = world.add_material(name, white()).unwrap();
            world.set_textures(material, of.clone()).unwrap();
            let shape = quad(Vec3::Z * height, Vec3::X, Vec3::Y);
            world.add_mesh(name, shape, material, Transform::IDENTITY).unwrap();
        }
        looked_at(&mut world);
        for integrator in ALL {
            let (score, mean) = score(&world, integrator, 1.0);
            assert!(score.abs() < 5.0, "{integrator:?} {of:?}: {mean}, {score}");
        }
    }
}

/// The same in a ball of fog that absorbs nothing.
#[test]
fn white_sheets_vanish_in_white_fog() {
    for share in [0.05, 0.5] {
        let mut world = World::new("fog");
        let white = Material::from(Bsdf::diffuse(1.0)).two_sided();
        let white = world.add_material("white", white).unwrap();
        world.set_textures(white, even(share)).unwrap();
        let shape = quad(Vec3::ZERO, Vec3::X * 0.6, Vec3::Y * 0.6);
        world.add_mesh("sheet", shape, white, Transform::IDENTITY).unwrap();
        world.add_sphere("core", 0.4, white, DVec3::ZERO).unwrap();
        let fog = world.add_medium("fog", Medium::new(0.0, 1.0, Phase::isotropic())).unwrap();
        let border = world.add_material("border", Bsdf::Null).unwrap();
        world.add_sphere("ball", 0.9, Skin::from(border).interior(fog), DVec3::ZERO).unwrap();
        looked_at(&mut world);
        for integrator in ALL {
            let (score, mean) = score(&world, integrator, 1.0);
            assert!(score.abs() < 5.0, "{integrator:?} {share}: {mean}, {score}");
        }
    }
}

/// A ball that emits from outside and takes all else, by a share c: of a radiance of 3 before a sky
/// of 1, 3 c + (1 - c)^2 is seen where the ball is.
#[test]
fn balls_that_emit_by_a_share_let_the_rest_through() {
    for share in [0.1_f32, 0.6] {
        let mut world = World::new("lamp");
        let lamp = world.add_material("lamp", Material::emitter(3.0)).unwrap();
        world.set_textures(lamp, even(share)).unwrap();
        world.add_sphere("lamp", 1.5, lamp, DVec3::ZERO).unwrap();
        looked_at(&mut world);
        let share = f64::from(share);
        for integrator in ALL {
            let (score, mean) = score(&world, integrator, 3.0 * share + (1.0 - share).powi(2));
            assert!(score.abs() < 5.0, "{integrator:?} {share}: {mean}, {score}");
        }
    }
}
