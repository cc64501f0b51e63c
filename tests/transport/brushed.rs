//! Where facets that are stretched lie, on surfaces of all sorts: what they reflect of a far lamp,
//! against the formula of GGX by its slopes.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use serde_json::{Value, json};
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::Mode;
use sunstone::internals::scene::World;
use sunstone::world::{Along, Bsdf, Grain, Lens, Material, Punctual, Transform};

use crate::support::gltf::Document;
use crate::support::painted::quad as painted_quad;
use crate::support::rendering::{MONO, image, scene, settings};

const ALPHA: [f64; 2] = [0.6, 0.15];

/// Mirrors, with these keys.
fn mirrors(mut keys: Value) -> Value {
    keys["bsdf"] = json!("rough_conductor");
    keys["multiple_scattering"] = json!(false);
    (keys["eta"], keys["k"]) = (json!(1e-6), json!(1.0));
    keys
}

fn brushed(axis_deg: f64) -> Value {
    mirrors(json!({"alpha_u": ALPHA[0], "alpha_v": ALPHA[1], "axis_deg": axis_deg}))
}

fn matte() -> Value {
    json!({"bsdf": "diffuse", "reflectance": 1.0})
}

/// The mean of what is seen.
fn seen(world: &World) -> f64 {
    let options = settings(Integrator::Path, Mode::Scalar, MONO, 1, 2);
    let image = image(&scene::<1>(world, MONO, [2, 2]), &options);
    image.planes[0].iter().map(|value| f64::from(*value)).sum::<f64>() / 4.0
}

/// What facets reflect from l to v, vectors along, across and up: D G2 / (4 cos cos).
fn expected([l, v]: [DVec3; 2]) -> f64 {
    let [a, b] = ALPHA;
    let h = (l + v).normalize();
    let steepness = ((h.x / a).powi(2) + (h.y / b).powi(2)) / (h.z * h.z);
    let density = 1.0 / (PI * a * b * h.z.powi(4) * (1.0 + steepness).powi(2));
    let lambda = |w: DVec3| {
        let slope = ((a * w.x).powi(2) + (b * w.y).powi(2)).sqrt() / w.z;
        0.5 * ((1.0 + slope * slope).sqrt() - 1.0)
    };
    density / (1.0 + lambda(l) + lambda(v)) / (4.0 * l.z * v.z)
}

/// Compares what is seen of a surface with what a white one shows, whose frame is (along, up).
#[track_caller]
fn check(worlds: [World; 2], [l, v]: [Vec3; 2], [along, normal]: [Vec3; 2]) {
    let across = normal.cross(along);
    let within = |w: Vec3| [along, across, normal].map(|axis| f64::from(w.dot(axis))).into();
    let [found, white] = worlds.each_ref().map(seen);
    let (found, expected) = (found / white / PI, expected([l, v].map(within)));
    assert!((found / expected - 1.0).abs() < 3e-3, "{found} {expected}");
}

/// A square in xy, without coordinates of pictures.
fn square(body: Value, [l, v]: [Vec3; 2]) -> World {
    let mut document = Document::default();
    let material = document.material(body);
    document.quad(Vec3::ZERO, Vec3::X, Vec3::Y, material);
    document.light(json!({"type": "directional", "intensity": 1.0}), Vec3::ZERO, -l);
    document.orthographic(4.0 * v, Vec3::ZERO, 0.01);
    document.load("square")
}

const L: Vec3 = Vec3::new(-0.4, 0.3, 0.9);
const V: Vec3 = Vec3::new(0.5, 0.2, 0.8);

#[test]
fn squares_have_the_x_axis_of_their_node() {
    let way = [L, V].map(Vec3::normalize);
    for (axis_deg, along) in [(0.0, Vec3::X), (90.0, Vec3::Y), (-270.0, Vec3::Y)] {
        let worlds = [brushed(axis_deg), matte()].map(|body| square(body, way));
        check(worlds, way, [along, Vec3::Z]);
    }
    let turned = Vec3::new(3_f32.sqrt() / 2.0, 0.5, 0.0);
    check([brushed(30.0), matte()].map(|body| square(body, way)), way, [turned, Vec3::Z]);
    // Even ones are those of `alpha`, and as rough across as along.
    let even = [
        mirrors(json!({"alpha_u": 0.3, "alpha_v": 0.3, "axis_deg": 50})),
        mirrors(json!({"alpha": 0.3})),
    ];
    let [one, other] = even.map(|body| seen(&square(body, way)));
    assert!((one / other - 1.0).abs() < 1e-4, "{one} {other}");
}

/// A square that is turned has its picture to the right of that.
#[test]
fn pictures_say_where_the_right_is() {
    let way = [L, V].map(Vec3::normalize);
    let metal = || Bsdf::RoughConductor {
        eta: 1e-6.into(),
        k: 1.0.into(),
        alpha: ALPHA[1] as f32,
        distribution: Default::default(),
        multiple_scattering: false,
    };
    let world = |bsdf: Bsdf| {
        let mut world = World::new("square");
        let material = world.add_material("it", Material::from(bsdf)).expect("sound");
        let square = painted_quad(Vec3::ZERO, Vec3::Y, Vec3::NEG_X);
        world.add_mesh("square", square, material, Transform::IDENTITY).expect("sound");
        let of = |eye: Vec3| Transform::looking(eye.as_dvec3(), DVec3::ZERO, DVec3::Y);
        world.add_light("sun", Punctual::directional(1.0), of(way[0])).expect("sound");
        let lens = Lens::Orthographic { half_width: 0.01, half_height: 0.01 };
        world.set_camera("eye", lens, of(4.0 * way[1])).expect("sound");
        world
    };
    let of = |along, direction, turn| {
        let grain = Grain { direction, turn, ..Grain::new(along) };
        Bsdf::brushed(metal(), grain)
    };
    // The strength whose square leads from 0.15 to 0.6.
    let strength = ((ALPHA[0] - ALPHA[1]) / (1.0 - ALPHA[1])).sqrt() as f32;
    let quarter = std::f32::consts::FRAC_PI_2;
    for (bsdf, along) in [
        (of(Along::Alpha(0.6), [1.0, 0.0], 0.0), Vec3::Y),
        (of(Along::Strength(strength), [2.0, 0.0], 0.0), Vec3::Y),
        (of(Along::Alpha(0.6), [0.0, 1.0], 0.0), Vec3::X),
        (of(Along::Alpha(0.6), [1.0, 0.0], quarter), Vec3::X),
        (of(Along::Alpha(0.6), [0.0, 0.0], 0.0), Vec3::Y),
        (of(Along::Alpha(0.6), [1.0, 1.0], 0.5 * quarter), Vec3::X),
    ] {
        check([world(bsdf), world(Bsdf::diffuse(1.0))], way, [along, Vec3::Z]);
    }
}

/// Spheres have it round the z axis of their node.
#[test]
fn spheres_have_it_round_their_axis() {
    let way = [Vec3::new(0.8, 0.5, 0.3).normalize(), Vec3::X];
    let world = |body: Value| {
        let mut document = Document::default();
        let material = document.material(body);
        document.sphere(Vec3::ZERO, 1.0, material);
        document.light(json!({"type": "directional", "intensity": 1.0}), Vec3::ZERO, -way[0]);
        document.orthographic(4.0 * way[1], Vec3::ZERO, 1e-4);
        document.load("sphere")
    };
    check([brushed(0.0), matte()].map(world), way, [Vec3::Y, Vec3::X]);
    check([brushed(90.0), matte()].map(world), way, [Vec3::Z, Vec3::X]);
}
