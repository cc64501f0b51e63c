//! Scenes without a camera or light of their own: what is put in shows all of them.

use std::fs;

use crate::common::{good, load_json, scratch};
use glam::{DAffine3, DQuat, DVec3, EulerRot, Vec3};
use serde_json::{Value, json};
use sunstone::internals::film::layout::Layout;
use sunstone::internals::math::F32s;
use sunstone::internals::scattering::Sensor;
use sunstone::internals::scene::world::{Bsdf, Geometry, Material, Transform};
use sunstone::internals::scene::{
    LightChoice, Reading, SceneError, View, World, Written, bake, load, load_with,
};
use sunstone::internals::spectrum::Carried;

/// Films as wide as they are high, wider, and higher.
const FILMS: [[u32; 2]; 4] = [[64, 64], [160, 40], [40, 160], [1, 1000]];

/// Where points are on the film of a framed world, from 0 to 1 to the right and downwards, by the
/// film's size.
fn on_film(world: &World, points: &[DVec3], [width, height]: [u32; 2]) -> Vec<[f64; 2]> {
    let baked = bake(world, &Carried::RGB).unwrap();
    let sensor = Sensor::new(&baked.camera, Layout::plain([width, height]));
    let (camera, origin) = (&baked.camera, baked.shapes.origin);
    let [right, up, forward] =
        [camera.right, camera.up, camera.forward].map(|axis| axis.as_dvec3());
    // What the renderer's own ray through the corner of the film says.
    let corner = [width as f32, 0.0].map(F32s::splat);
    let (_, ray, _) = sensor.rays(corner, || [F32s::splat(0.0); 2]);
    let ray = Vec3::from(ray.to_rows()[0]).as_dvec3();
    let [half_width, half_height] = [right, up].map(|axis| ray.dot(axis) / ray.dot(forward));
    let place = |point: &DVec3| {
        let from_eye = *point - (origin + camera.position.as_dvec3());
        let depth = from_eye.dot(forward);
        assert!(depth > 0.0, "{point} is behind the camera");
        [
            0.5 + 0.5 * from_eye.dot(right) / (depth * half_width),
            0.5 - 0.5 * from_eye.dot(up) / (depth * half_height),
        ]
    };
    points.iter().map(place).collect()
}

/// A world of one mesh in a place, framed and lit.
fn framed(geometry: Geometry, place: DAffine3, two_sided: bool) -> World {
    let mut world = World::new("one thing");
    let mut material = Material::from(Bsdf::diffuse(0.5));
    material.sides.two_sided = two_sided;
    let material = world.add_material("paint", material).unwrap();
    world.add_mesh("thing", geometry, material, Transform(place)).unwrap();
    world.frame().unwrap();
    world.set_environment(1.0).unwrap();
    world
}

/// Boxes of all shapes, somewhere: rods, panes, crumbs, mountains.
fn things() -> Vec<(Geometry, DAffine3)> {
    let sizes = [
        [1.0, 1.0, 1.0],
        [1e-6, 1.0, 1.0],
        [1.0, 1e-6, 1.0],
        [1.0, 1.0, 1e-6],
        [1e-4, 1e-4, 1.0],
        [1.0, 1e-4, 1e-4],
        [1e-9, 2e-9, 3e-9],
        [3e6, 1e6, 1e6],
    ];
    let places = [DVec3::ZERO, DVec3::new(100.0, -50.0, 20.0), DVec3::new(-30.0, 40.0, 70.0)];
    let mut things = Vec::new();
    for (index, size) in sizes.into_iter().enumerate() {
        for (turn, place) in places.into_iter().enumerate() {
            let angle = 0.7 * (index + turn) as f64;
            let turned = DQuat::from_euler(EulerRot::XYZ, angle, 2.0 * angle, 0.3 * angle);
            let half = Vec3::from_array(size);
            let reach = f64::from(half.length());
            let place = DAffine3::from_rotation_translation(turned, place * reach);
            things.push((Geometry::cuboid(-half, half), place));
        }
    }
    things
}

#[test]
fn all_of_a_thing_is_in_the_picture_and_fills_it() {
    for (geometry, place) in things() {
        let points: Vec<DVec3> =
            geometry.positions.iter().map(|at| place.transform_point3(at.as_dvec3())).collect();
        let world = framed(geometry, place, true);
        for film in FILMS {
            let on_film = on_film(&world, &points, film);
            let of_axis = |axis: usize| {
                let along = on_film.iter().map(|at| at[axis]);
                (along.clone().fold(f64::INFINITY, f64::min), along.fold(0.0, f64::max))
            };
            let (left, right) = of_axis(0);
            let (top, bottom) = of_axis(1);
            let inside = |low: f64, high: f64| low > 0.01 && high < 0.99;
            assert!(inside(left, right) && inside(top, bottom), "{film:?}: {on_film:?}");
            let fills = (right - left).max(bottom - top);
            assert!(fills > 0.8, "{film:?}: it fills {fills} of the picture");
        }
    }
}

#[test]
fn what_has_one_side_is_seen_from_it() {
    let turns = [(DVec3::Y, 0.0), (DVec3::Y, 90.0), (DVec3::Y, 180.0), (DVec3::Y, 270.0)];
    let turns = turns.into_iter().chain([(DVec3::X, 90.0), (DVec3::X, -90.0)]);
    for (axis, degrees) in turns {
        // It faces +z before it is turned; in a mirror it faces there too.
        for mirrored in [1.0, -1.0] {
            let quad = Geometry::quad(Vec3::ZERO, Vec3::X, Vec3::Y);
            let turn = DQuat::from_axis_angle(axis, f64::to_radians(degrees));
            let mirror = DVec3::new(mirrored, 1.0, 1.0);
            let place = DAffine3::from_scale_rotation_translation(mirror, turn, DVec3::ZERO);
            let baked = bake(&framed(quad, place, false), &Carried::RGB).unwrap();
            let cosine = -baked.camera.forward.as_dvec3().dot(turn * DVec3::Z);
            assert!(cosine > 0.4, "{axis} {degrees} {mirrored}: {cosine}");
        }
    }
}

fn assert_refused(document: &Value, expected: &[&str]) {
    let error = load_json(document).map(|_| ()).unwrap_err();
    assert!(expected.iter().all(|part| error.contains(part)), "{expected:?}: {error}");
}

/// A file with a square and nothing else.
fn bare() -> Value {
    let mut document = good();
    document["scenes"][0]["nodes"] = json!([1]);
    document["materials"][0] = json!({"pbrMetallicRoughness": {"metallicFactor": 0}});
    document
}

#[test]
fn a_file_without_camera_and_light_gets_both_and_says_so() {
    let world = load_json(&bare()).unwrap();
    world.check().unwrap();
    let put_in: Vec<&str> = world.put_in().iter().map(|it| it.what).collect();
    assert_eq!(put_in, ["camera", "light"]);
    let notes: String = world.put_in().iter().map(|it| it.note.as_str()).collect();
    for told in ["--camera NAME", "a sky is put in", "\"gradient\": [", "--light none"] {
        assert!(notes.contains(told), "{told}: {notes}");
    }
    // One that has both gets none.
    assert!(load_json(&good()).unwrap().put_in().is_empty());
    let mut lit = bare();
    lit["materials"][0]["emissiveFactor"] = json!([1, 1, 1]);
    let world = load_json(&lit).unwrap();
    assert_eq!(world.put_in().len(), 1, "it emits");
}

#[test]
fn what_is_asked_for_is_put_in_or_left_out() {
    let path = scratch("asked.gltf");
    let load = |document: &Value, view: View| {
        fs::write(&path, document.to_string()).unwrap();
        load_with(&path, &Reading { view, ..Reading::default() })
    };
    let world = load(&good(), View::by("auto")).unwrap();
    assert_eq!(world.put_in().len(), 1);
    let dark = View { light: LightChoice::None, ..View::default() };
    let world = load(&bare(), dark).unwrap();
    assert_eq!(world.put_in().len(), 1, "no sky");
    let error = bake(&world, &Carried::RGB).map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("nothing in the scene emits"), "{error}");
    assert_eq!(error.place(), "lights");
    assert!(error.remedy().contains("add a light"));
    let error = load(&bare(), View::by("nose")).unwrap_err().to_string();
    assert!(error.contains("the scene has none; `auto` puts one in"), "{error}");
}

/// A scene of Mitsuba, as it is seen.
fn of_mitsuba(body: &str, view: View) -> Result<World, SceneError> {
    let path = scratch("framed.xml");
    fs::write(&path, format!("<scene version='3.0.0'>{body}</scene>")).unwrap();
    load_with(&path, &Reading { view, ..Reading::default() })
}

#[test]
fn scenes_of_mitsuba_get_what_they_leave_open_too() {
    let told = |world: &World| -> Vec<(&'static str, String)> {
        world.put_in().iter().map(|it| (it.what, it.text.clone())).collect()
    };
    let body = "<shape type='rectangle'/><shape type='sphere'><point name='center' x='1' y='2' \
                z='3'/></shape>";
    let world = of_mitsuba(body, View::default()).unwrap();
    world.check().unwrap();
    let put_in = told(&world);
    assert_eq!(put_in.iter().map(|it| it.0).collect::<Vec<_>>(), ["camera", "light"]);
    let notes: String = world.put_in().iter().map(|it| it.note.as_str()).collect();
    for words in ["add a <sensor>", "add an <emitter>", "--light none"] {
        assert!(notes.contains(words), "{words}: {notes}");
    }
    // Written as glTF it leaves the same open, and gets the same.
    let dark = View { light: LightChoice::None, ..View::default() };
    let path = scratch("framed.gltf");
    Written::of(&of_mitsuba(body, dark).unwrap()).unwrap().save(&path).unwrap();
    assert!(!fs::read_to_string(&path).unwrap().contains("\"cameras\""));
    assert_eq!(told(&load(&path).unwrap()), put_in);

    let seen = format!("{body}<sensor type='perspective' id='eye'/>");
    let what = |body: &str, view: View| {
        let world = of_mitsuba(body, view).unwrap_or_else(|error| panic!("{error}"));
        told(&world).into_iter().map(|it| it.0).collect::<Vec<_>>()
    };
    assert_eq!(what(&seen, View::default()), ["light"]);
    assert_eq!(what(&seen, View::by("auto")), ["camera", "light"]);
    // A lamp of no power is stated, as by a parameter.
    let off = format!("{seen}<emitter type='point'><float name='intensity' value='0'/></emitter>");
    assert_eq!(what(&off, View::by("eye")), [""; 0]);
    let timed = View { time: Some(1.0), ..View::default() };
    let error = of_mitsuba(&seen, timed).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("scenes of Mitsuba have none\n  help: leave out --time"), "{error}");
}

#[test]
fn fog_about_a_sensor_fills_the_scene_whoever_sees_it() {
    let fog = "<sensor type='perspective'><medium type='homogeneous' id='fog'/></sensor>";
    let body = format!("<shape type='sphere'/><emitter type='point'/>{fog}");
    let medium = |view: View| {
        let baked = bake(&of_mitsuba(&body, view).unwrap(), &Carried::RGB).unwrap();
        (baked.shapes.scene_medium, baked.optics.media.len())
    };
    assert_eq!(medium(View::by("auto")), medium(View::default()));
    assert_eq!(medium(View::default()).1, 1);
}

#[test]
fn skies_with_a_gradient_are_written() {
    let mut world = framed(Geometry::cuboid(Vec3::NEG_ONE, Vec3::ONE), DAffine3::IDENTITY, true);
    world.set_sky([0.5, 0.25, 1.0], Vec3::new(0.25, -0.5, 0.125)).unwrap();
    let path = scratch("gradient.gltf");
    Written::of(&world).unwrap().save(&path).unwrap();
    let again = load(&path).unwrap().describe();
    let line = "radiance [0.5, 0.25, 1], gradient [0.25, -0.5, 0.125]";
    assert!(world.describe().contains(line) && again.contains(line), "{again}");
}

#[test]
fn a_lamp_that_is_turned_off_is_off() {
    use sunstone::{Edit, SceneFile};
    let path = scratch("off.gltf");
    fs::write(&path, good().to_string()).unwrap();
    let file = SceneFile::read(&path, false).unwrap();
    let off = [
        Edit::new("lights/bulb/intensity", 0.0),
        Edit::new("materials/glow/emissiveFactor", json!([0, 0, 0])),
    ];
    let world = file.world(&View::default(), &off).unwrap();
    assert!(world.put_in().is_empty(), "{:?}", world.put_in());
    fs::write(&path, bare().to_string()).unwrap();
    let file = SceneFile::read(&path, false).unwrap();
    let painted = [Edit::new("materials/#0/pbrMetallicRoughness.metallicFactor", 0.0)];
    let world = file.world(&View::by("auto"), &painted).unwrap();
    assert_eq!(world.put_in().len(), 2);
}

#[test]
fn scenes_with_nothing_to_see_are_refused() {
    let mut document = bare();
    document["scenes"][0]["nodes"] = json!([]);
    assert_refused(&document, &["has nothing that could be seen"]);
    document["scenes"][0]["nodes"] = json!([1]);
    document["meshes"][0]["primitives"][0]["mode"] = json!(1);
    assert_refused(&document, &["has nothing that could be seen", "points and lines"]);
}

#[test]
fn a_vertex_far_off_is_shown_and_told() {
    let positions: Vec<Vec3> = (0..40)
        .map(|at| Vec3::new((at % 8) as f32, (at / 8) as f32, (at % 3) as f32))
        .chain([Vec3::new(1e4, 0.0, 0.0)])
        .collect();
    let mut triangles: Vec<[u32; 3]> = (0..30).map(|at| [at, at + 1, at + 9]).collect();
    triangles.push([0, 40, 9]);
    let points: Vec<DVec3> = positions.iter().map(|at| at.as_dvec3()).collect();
    let near = Geometry::new(positions.clone(), triangles[..30].to_vec());
    assert!(framed(near, DAffine3::IDENTITY, true).warnings().is_empty());
    let world = framed(Geometry::new(positions, triangles), DAffine3::IDENTITY, true);
    let told = world.warnings().join("\n");
    assert!(told.contains("mesh `thing`: reaches so far"), "{told}");
    for [x, y] in on_film(&world, &points, [64, 64]) {
        assert!((0.0..1.0).contains(&x) && (0.0..1.0).contains(&y), "{x} {y}");
    }
}

#[test]
fn skies_are_not_darker_than_black() {
    let mut world = World::new("sky");
    let error = world.set_sky(1.0, Vec3::new(0.8, 0.8, 0.0)).unwrap_err().to_string();
    assert!(error.contains("gradient: its length must be at most 1"), "{error}");
    let sky = |gradient: Value| {
        let mut document = good();
        let environment = json!({"radiance": 1, "gradient": gradient});
        document["scenes"][0]["extensions"] =
            json!({"SUNSTONE_polarization": {"environment": environment}});
        document
    };
    assert!(load_json(&sky(json!([0.6, 0.8, 0]))).is_ok());
    assert_refused(&sky(json!([1, 1, 0])), &["environment.gradient", "at most 1"]);
    assert_refused(&sky(json!([1, 0])), &["gradient", "three numbers"]);
    assert_refused(&sky(json!(1)), &["gradient"]);
}
