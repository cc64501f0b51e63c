//! Scenes far from the origin: the tables are centered on what the camera sees.

use glam::{DQuat, DVec3, Vec3};
use serde_json::{Value, json};
use sunstone::internals::scene::bake;
use sunstone::internals::scene::baked::{BakedScene, Shapes};
use sunstone::internals::scene::emitter::EmitterModel;
use sunstone::internals::scene::world::{
    Bsdf, Geometry, Lens, Material, Punctual, Transform, World,
};
use sunstone::internals::spectrum::Carried;

use crate::common::{good, load_json};

/// The good scene below a node that moves it.
fn moved(by: DVec3) -> BakedScene<3> {
    let mut document = good();
    let nodes = document["nodes"].as_array_mut().unwrap();
    let root = nodes.len();
    nodes.push(json!({"translation": by.to_array(), "children": [0, 1, 2, 3]}));
    document["scenes"][0]["nodes"] = json!([root]);
    baked(&document)
}

fn baked(document: &Value) -> BakedScene<3> {
    let world = load_json(document).unwrap_or_else(|error| panic!("{error}"));
    bake(&world, &Carried::RGB).unwrap_or_else(|error| panic!("{error}"))
}

/// All positions in the tables, about the camera.
fn positions(scene: &BakedScene<3>) -> Vec<Vec3> {
    let Shapes { triangles, spheres, bounds, .. } = &scene.shapes;
    let corners = triangles.iter().flat_map(|triangle| triangle.corners);
    let lights = scene.optics.emitters.iter().filter_map(|emitter| match emitter.model {
        EmitterModel::Point(point) => Some(point.position),
        _ => None,
    });
    let all = corners.chain(spheres.iter().map(|sphere| sphere.center)).chain(lights);
    all.chain([bounds.center]).map(|position| position - scene.camera.position).collect()
}

#[test]
fn a_scene_far_away_is_the_same_scene() {
    let near = moved(DVec3::ZERO);
    assert_eq!(near.shapes.origin, DVec3::ZERO);
    for scale in [1e3, 1e5, 5e5, 1e8] {
        let by = scale * DVec3::new(1.234_567, -0.456_789, 0.987_654);
        let far = moved(by);
        assert!(far.shapes.origin.distance(by) < 64.0, "{}", far.shapes.origin);
        let both = positions(&near).into_iter().zip(positions(&far));
        // Numbers of up to 64 are a multiple of 4e-6, those of the file at 1e8 of 1.5e-8.
        let worst = both.map(|(a, b)| (a - b).length()).fold(0.0, f32::max);
        assert!(worst < 2e-5, "{scale}: {worst}");
    }
    // By powers of two, nothing is rounded at all.
    let far = moved(DVec3::new(131_072.0, -1_048_576.0, 65_536.0));
    assert_eq!(far.shapes.triangles, near.shapes.triangles);
    assert_eq!(far.shapes.spheres, near.shapes.spheres);
    assert_eq!(far.camera, near.camera);
    assert_eq!(far.optics.emitters, near.optics.emitters);
}

/// Turned by a parent that is far away, too: rotations are read in double precision.
#[test]
fn parents_far_away_turn_in_double_precision() {
    let turned = |far: f64| {
        let mut document = good();
        let nodes = document["nodes"].as_array_mut().unwrap();
        let root = nodes.len();
        // All is brought back to where it was by the parent's parent.
        let turn = DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 0.7).normalize();
        let back = turn * DVec3::new(-far, 0.0, 0.0);
        nodes.push(json!({"translation": back.to_array(), "rotation": turn.to_array(),
                          "children": [root + 1]}));
        nodes.push(json!({"translation": [far, 0.0, 0.0], "children": [0, 1, 2, 3]}));
        document["scenes"][0]["nodes"] = json!([root]);
        baked(&document)
    };
    let both = positions(&turned(0.0)).into_iter().zip(positions(&turned(1e6)));
    let worst = both.map(|(a, b)| (a - b).length()).fold(0.0, f32::max);
    assert!(worst < 2e-5, "{worst}");
}

/// A world in code, whose camera looks at a ball of 10 cm from half a meter, from the far end of
/// what it stands on: the nearest thing that is seen counts, not what is largest.
#[test]
fn worlds_in_code_are_centered_too() {
    let seen_at = |at: DVec3| {
        let mut world = World::new("far");
        let white = world.add_material("white", Bsdf::diffuse(0.5)).unwrap();
        let glass = world.add_material("glass", Bsdf::dielectric(1.5)).unwrap();
        let glow = world.add_material("glow", Material::emitter(1.0)).unwrap();
        let ground = Geometry::quad(Vec3::ZERO, Vec3::X * 500.0, Vec3::NEG_Z * 500.0);
        world.add_mesh("ground", ground, white, at + 450.0 * DVec3::X).unwrap();
        world.add_sphere("ball", 0.1, glass, at + 0.1 * DVec3::Y).unwrap();
        world.add_sphere("sun", 10.0, glow, at + 1e4 * DVec3::Y).unwrap();
        world.add_light("lamp", Punctual::point(1.0), at + DVec3::Y).unwrap();
        let place = Transform::looking(at + DVec3::new(0.5, 0.1, 0.0), at, DVec3::Y);
        world.set_camera("eye", Lens::pinhole(0.5), place).unwrap();
        bake(&world, &Carried::RGB).unwrap()
    };
    let near = seen_at(DVec3::ZERO);
    let far = seen_at(DVec3::new(3e5, 2e3, -5e6 / 3.0));
    let camera = |scene: &BakedScene<3>| scene.shapes.spheres[0].center - scene.camera.position;
    assert!((camera(&near) - camera(&far)).length() < 1e-6);
    let sun = far.shapes.spheres[1].center - far.shapes.spheres[0].center;
    assert!((sun - (1e4 - 0.1) * Vec3::Y).length() < 2e-3, "{sun}");
    let [EmitterModel::Sphere(_), EmitterModel::Point(lamp)] =
        [&far.optics.emitters[0].model, &far.optics.emitters[1].model]
    else {
        panic!("a sphere and a lamp")
    };
    assert!((lamp.position - far.shapes.spheres[0].center - 0.9 * Vec3::Y).length() < 1e-6);
}
