//! What files say of environments by pictures and of suns, and what of that is refused.

use std::f64::consts::{FRAC_PI_2, PI};
use std::fs;
use std::io::Cursor;

use exr::prelude::{Image, SpecificChannels, Vec2 as Place, WritableImage};
use glam::{DMat3, DQuat, DVec3, Vec3};
use serde_json::{Value, json};
use sunstone::internals::scene::baked::BakedScene;
use sunstone::internals::scene::emitter::{EmitterModel, Panorama};
use sunstone::internals::scene::{World, Written, bake, load};
use sunstone::internals::spectrum::Carried;

use crate::common::{data_uri, good, load_json, scratch};

/// OpenEXR of a picture, by column and row.
fn openexr(width: usize, height: usize, texel: fn(usize, usize) -> [f32; 3]) -> Vec<u8> {
    let channels = SpecificChannels::rgb(|at: Place<usize>| {
        let [red, green, blue] = texel(at.x(), at.y());
        (red, green, blue)
    });
    let mut bytes = Cursor::new(Vec::new());
    let image = Image::from_channels((width, height), channels);
    image.write().non_parallel().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

/// A Radiance picture of 4 by 2 texels, each `[1, 2, 4]` times its column.
fn radiance() -> Vec<u8> {
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n".to_vec();
    for column in [0_u8, 1, 2, 3, 0, 1, 2, 3] {
        bytes.extend([16 * column, 32 * column, 64 * column, 132]);
    }
    bytes
}

/// The good document with an environment and no other light.
fn under(environment: &Value) -> Value {
    let mut document = good();
    document["scenes"][0]["extras"] = json!({"sunstone_environment": environment});
    document["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"] = json!(0);
    document["materials"][0]["emissiveFactor"] = json!([0, 0, 0]);
    document
}

fn baked(world: &World) -> BakedScene<3> {
    bake(world, &Carried::RGB).unwrap_or_else(|error| panic!("{error}"))
}

fn panorama(world: &World) -> Panorama {
    let scene = baked(world);
    let last = scene.optics.emitters.last().unwrap();
    assert_eq!(scene.optics.skies.end as usize, scene.optics.emitters.len());
    match &last.model {
        EmitterModel::Panorama(panorama) => panorama.clone(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn pictures_are_read_scaled_and_turned() {
    let uri = data_uri(&radiance());
    let world = load_json(&under(&json!({"uri": uri}))).unwrap();
    assert_eq!(world.warnings(), [] as [String; 0]);
    let seen = |world: &World, at: Vec3| panorama(world).radiance(at, &Carried::RGB);
    // The middles of the second and third columns are an eighth of a turn from +x.
    let [right, left] = [1.0, -1.0].map(|z| Vec3::new(1.0, 0.0, z).normalize());
    for (at, column) in [(left, 1.0), (right, 2.0)] {
        for (n, found) in seen(&world, at).into_iter().enumerate() {
            let expected = column * [1.0, 2.0, 4.0][n];
            assert!((found / expected - 1.0).abs() < 1e-5, "{found} for {expected}");
        }
    }
    assert!((seen(&world, Vec3::X)[0] - 1.5).abs() < 1e-5);
    let half = 0.5_f64.sqrt();
    let turned = json!({"uri": uri, "radiance": [2, 1, 0.5], "rotation": [0, half, 0, half]});
    let turned = load_json(&under(&turned)).unwrap();
    // A quarter turn takes +x to -z.
    let found = seen(&turned, Vec3::new(1.0, 0.0, -1.0).normalize());
    for (found, expected) in found.into_iter().zip([4.0, 4.0, 4.0]) {
        assert!((found - expected).abs() < 1e-5, "{found}");
    }
    let scene = baked(&turned);
    let lamp = scene.optics.lamps.last().unwrap();
    lamp.iter().for_each(|lamp| assert!((lamp - 3.0).abs() < 1e-5, "{lamp}"));
}

#[test]
fn files_beside_the_scene_are_noted_and_all_formats_are_read() {
    let path = scratch("sky.exr");
    fs::write(&path, openexr(2, 1, |column, _| [column as f32; 3])).unwrap();
    let name = path.file_name().unwrap().to_str().unwrap();
    let world = load_json(&under(&json!({"uri": name}))).unwrap();
    assert!(world.files().iter().any(|file| file.ends_with(name)));
    let [mean, ..] = panorama(&world).mean();
    assert!((mean - 0.5).abs() < 1e-6, "{mean}");
    let world = load_json(&under(&json!({"uri": name, "radiance": 0}))).unwrap();
    assert!(bake::<3>(&world, &Carried::RGB).unwrap_err().to_string().contains("nothing"));
    fs::remove_file(&path).unwrap();
    let missing = load_json(&under(&json!({"uri": name}))).unwrap_err();
    assert!(
        missing.contains("environment.uri: cannot read") && missing.contains(name),
        "{missing}"
    );
}

#[test]
fn a_black_picture_is_no_light() {
    let black = data_uri(&openexr(4, 2, |_, _| [0.0; 3]));
    let world = load_json(&under(&json!({"uri": black}))).unwrap();
    let error = bake::<3>(&world, &Carried::RGB).unwrap_err().to_string();
    assert!(error.contains("nothing in the scene emits"), "{error}");
}

#[test]
fn what_is_wrong_is_told_by_name() {
    let good = data_uri(&radiance());
    let broken = |texel| data_uri(&openexr(4, 2, texel));
    let cases = [
        (json!({}), "environment has neither `radiance` nor `uri`"),
        (json!({"uri": 7}), "environment.uri is not a string"),
        (json!({"uri": data_uri(b"text")}), "environment.uri is of a format that is not known"),
        (json!({"uri": data_uri(b"#?RADIANCE\n\n-Y 2 +X 4\n")}), "is a Radiance picture, and it"),
        (json!({"radiance": 1, "rotation": [0, 0, 0, 1]}), "environment.rotation: turns"),
        (json!({"uri": good, "rotation": [0, 0, 1]}), "environment.rotation must be four"),
        (json!({"uri": good, "rotation": [0, 0, 0, 2]}), "environment.rotation: its length must"),
        (json!({"uri": good, "rotation": [0, 0, 0, 0]}), "environment.rotation: its length must"),
        (json!({"uri": good, "gradient": [0, 1, 0]}), "environment.gradient does not go with"),
        (json!({"uri": good, "radiance": -1}), "environment.radiance: -1 must"),
        (json!({"uri": good, "radiance": 3e38}), "environment.radiance: times the picture"),
        (json!({"uri": good, "radiance": {"illuminant": "D65"}}), "environment.radiance is a sp"),
        (
            json!({"uri": broken(|x, y| [if x == 2 && y == 1 { f32::NAN } else { 1.0 }; 3])}),
            "environment.uri has a value that is not a number in column 2, row 1",
        ),
        (
            json!({"uri": broken(|x, _| [if x == 3 { -1.0 } else { 1.0 }; 3])}),
            "has a negative value in column 3, row 0",
        ),
        (
            json!({"uri": broken(|x, _| [if x == 1 { f32::INFINITY } else { 1.0 }; 3])}),
            "has an infinite value in column 1, row 0",
        ),
    ];
    for (environment, expected) in cases {
        let error = load_json(&under(&environment)).map(|_| ()).unwrap_err();
        assert!(error.contains(expected), "{error}");
    }
    let cube = data_uri(&openexr(4, 3, |_, _| [1.0; 3]));
    let world = load_json(&under(&json!({"uri": cube}))).unwrap();
    let warnings = world.warnings().concat();
    assert!(warnings.contains("environment.uri is not twice as wide as high"), "{warnings}");
}

fn with_sun(body: &Value, kind: &str) -> Value {
    let mut document = under(&json!({"radiance": 0.5}));
    document["extensions"]["KHR_lights_punctual"]["lights"][0] = json!({
        "type": kind, "intensity": 683.0, "name": "bulb",
        "extensions": {"SUNSTONE_polarization": body}});
    document
}

#[test]
fn directional_lights_with_an_angle_are_suns() {
    let world = load_json(&with_sun(&json!({"angular_diameter_deg": 0.533}), "directional"));
    let scene = baked(&world.unwrap());
    assert_eq!(scene.optics.skies, 0..2);
    let EmitterModel::Sun(sun) = scene.optics.emitters[0].model else { panic!("first a sun") };
    assert!((sun.direction - Vec3::NEG_Z).length() < 1e-6);
    // Of the sun 6.8e-5 sr are seen from the earth.
    let radius = 0.5 * 0.533_f64.to_radians();
    assert!((sun.solid_angle() / (2.0 * PI * (1.0 - radius.cos())) - 1.0).abs() < 1e-5);
    let expected = 1.0 / (PI * radius.sin().powi(2));
    let [radiance, ..] = scene.optics.radiance_of(0).map(f64::from);
    assert!((radiance / expected - 1.0).abs() < 1e-5, "{radiance}, {expected}");
    for ends in [0.0006, 179.999] {
        let body = json!({"angular_diameter_deg": ends});
        assert!(load_json(&with_sun(&body, "directional")).is_ok(), "{ends} is said to be fine");
    }
    let zero = load_json(&with_sun(&json!({"angular_diameter_deg": 0}), "directional"));
    let scene = baked(&zero.unwrap());
    assert!(matches!(scene.optics.emitters[0].model, EmitterModel::Directional(_)));
    for (body, kind, expected) in [
        (json!({"angular_diameter_deg": -1}), "directional", "diameter_deg is -1 degrees"),
        (json!({"angular_diameter_deg": 180}), "directional", "diameter_deg is 180 degrees"),
        (json!({"angular_diameter_deg": 5e-4}), "directional", "from 0.0006 to less than 180"),
        (json!({"angular_diameter_deg": "a"}), "directional", "is not a number"),
        (json!({"angular_diameter_deg": 1}), "point", "angular_diameter_deg is for directional"),
    ] {
        let error = load_json(&with_sun(&body, kind)).map(|_| ()).unwrap_err();
        assert!(error.contains(expected), "{error}");
    }
}

fn of_mitsuba(emitter: &str) -> Result<World, String> {
    let text = format!(
        "<scene version='3.0.0'><sensor type='perspective'/><shape type='sphere'/>\n{emitter}\
         </scene>"
    );
    let path = scratch("scene.xml");
    fs::write(&path, text).unwrap();
    let world = load(&path).map_err(|error| error.to_string());
    fs::remove_file(&path).unwrap();
    world
}

/// Mitsuba's documentation: at (u, v) of the picture is seen the direction of the longitude 2 pi u
/// from -z towards +x and of the colatitude pi v.
#[test]
fn pictures_of_mitsuba_lie_as_there_and_are_written() {
    let path = scratch("env.exr");
    fs::write(&path, openexr(8, 4, |x, y| [x as f32 + 1.0, y as f32 + 1.0, 0.5])).unwrap();
    let name = path.file_name().unwrap().to_str().unwrap();
    let body = |more: &str| {
        format!(
            "<emitter type='envmap'><string name='filename' value='{name}'/>\
             <float name='scale' value='2'/>{more}</emitter>"
        )
    };
    let turn = "<transform name='to_world'><rotate x='1' angle='90'/>\
                <rotate z='1' angle='30'/></transform>";
    for (more, to_world) in [
        ("", DQuat::IDENTITY),
        (turn, DQuat::from_rotation_z(PI / 6.0) * DQuat::from_rotation_x(FRAC_PI_2)),
    ] {
        let world = of_mitsuba(&body(more)).unwrap();
        let written = Written::of(&world).unwrap();
        assert_eq!(written.warnings(), [] as [String; 0]);
        let gltf = scratch("written.gltf");
        written.save(&gltf).unwrap();
        let again = load(&gltf).unwrap();
        fs::remove_file(&gltf).unwrap();
        for world in [&world, &again] {
            let sky = panorama(world);
            for (column, row) in [(0, 0), (1, 2), (3, 1), (6, 3), (7, 2)] {
                let [u, v] = [(column as f64 + 0.5) / 8.0, (row as f64 + 0.5) / 4.0];
                let (longitude, colatitude) = (2.0 * PI * u, PI * v);
                let at = DVec3::new(
                    colatitude.sin() * longitude.sin(),
                    colatitude.cos(),
                    -colatitude.sin() * longitude.cos(),
                );
                let at = (DMat3::from_quat(to_world) * at).as_vec3();
                let found = sky.radiance(at, &Carried::RGB);
                let expected = [column + 1, row + 1].map(|it| 2.0 * it as f32);
                for (found, expected) in found.into_iter().zip(expected) {
                    assert!((found - expected).abs() < 1e-3, "{column}, {row}: {found}");
                }
            }
        }
    }
    let mirrored = "<transform name='to_world'><scale x='-1'/></transform>";
    let second = format!("{}{}", body(""), body(""));
    let flat = "<transform name='to_world'><scale y='2'/></transform>";
    for (emitter, expected) in [
        (body(mirrored), "(envmap), to_world: mirrors or stretches"),
        (body(flat), "(envmap), to_world: mirrors or stretches"),
        (second, "(envmap) is a second environment"),
        (body("<float name='scale' value='-2'/>").replacen("'scale'", "'x'", 1), "(envmap)"),
        ("<emitter type='envmap'/>".to_owned(), "(envmap), filename is missing"),
    ] {
        let error = of_mitsuba(&emitter).map(|_| ()).unwrap_err();
        assert!(error.contains(expected), "{error}");
    }
    let scaled = "<transform name='to_world'><scale value='3'/></transform>";
    assert!(of_mitsuba(&body(scaled)).is_ok());
    fs::remove_file(&path).unwrap();
}

#[test]
fn clear_skies_are_read_written_and_refused() {
    let sky = |body: Value| under(&json!({"sky": body, "radiance": 0.5}));
    let sun = DVec3::new(0.5, 0.7, 0.1);
    let document = sky(json!({"sun_direction": sun.to_array(), "turbidity": 4}));
    let world = load_json(&document).unwrap();
    let found = panorama(&world);
    assert!(found.is_polarized());
    let seen = |at: DVec3| found.radiance(at.normalize().as_vec3(), &Carried::RGB);
    // Blue above, bright about the sun and less so on the other side, dark below the horizon.
    let [zenith, at_sun, other] = [DVec3::Y, sun, DVec3::new(-0.5, 0.7, -0.1)].map(seen);
    assert!(zenith[2] > zenith[0]);
    assert!(at_sun[1] > 2.0 * zenith[1] && zenith[1] > 1.2 * other[1]);
    assert_eq!(seen(DVec3::NEG_Y), [0.0; 3]);
    let (state, _) =
        found.state::<3>(Vec3::new(0.7, -0.5, 0.1).normalize(), &Carried::RGB).unwrap();
    assert_eq!(state, [[0.0; 3]; 3]);
    // Mirrored in the plane of sun and zenith, nothing changes.
    let side = sun.cross(DVec3::Y).normalize();
    let [left, right] = [1.0, -1.0].map(|sign| seen(sign * side + 0.8 * DVec3::Y + 0.3 * sun));
    for (left, right) in left.into_iter().zip(right) {
        assert!((left / right - 1.0).abs() < 1e-3, "{left} {right}");
    }
    let path = scratch("clear.gltf");
    Written::of(&world).unwrap().save(&path).unwrap();
    let again = panorama(&load(&path).unwrap());
    fs::remove_file(&path).unwrap();
    assert_eq!(again.mean(), found.mean());
    let up = [0, 1, 0];
    for (body, expected) in [
        (json!({}), "sky.sun_direction is missing"),
        (json!({"sun_direction": [1, 0]}), "sky.sun_direction must be three"),
        (json!({"sun_direction": [1, -0.1, 0]}), "sky.sun_direction: [1, -0.1, 0] is not above"),
        (json!({"sun_direction": [0, 0, 0]}), "sky.sun_direction: [0, 0, 0] is not above"),
        (json!({"sun_direction": up, "turbidity": 1}), "sky.turbidity: 1 is not known"),
        (json!({"sun_direction": up, "max_degree": 1.5}), "sky.max_degree: 1.5 must be within"),
        (json!({"sun_direction": up, "haze": 1}), "sky.haze is not a key"),
    ] {
        let error = load_json(&sky(body)).map(|_| ()).unwrap_err();
        assert!(error.contains(expected), "{error}");
    }
    for (key, value) in [
        ("uri", json!("a.exr")),
        ("gradient", json!([0, 1, 0])),
        ("rotation", json!([0, 0, 0, 1])),
        ("stokes", json!([0.1, 0, 0])),
    ] {
        let both = json!({"sky": {"sun_direction": up}, key: value});
        let error = load_json(&under(&both)).map(|_| ()).unwrap_err();
        assert!(error.contains(&format!("environment.{key} does not go with `sky`")), "{error}");
    }
}

/// Of the paper's formulas by hand, for a turbidity of 3 and the sun 45 degrees from the zenith.
#[test]
fn the_zenith_is_as_bright_as_is_published() {
    let sky = json!({"sky": {"sun_direction": [1, 1, 0], "turbidity": 3}});
    let found = panorama(&load_json(&under(&sky)).unwrap());
    // On both sides of it, for it is brighter towards the sun.
    let luminance = |x: f32| {
        let at = Vec3::new(x, 1.0, 0.0).normalize();
        let [red, green, blue] = found.radiance(at, &Carried::RGB).map(f64::from);
        0.212_639 * red + 0.715_169 * green + 0.072_192 * blue
    };
    let luminance = 0.5 * (luminance(1e-3) + luminance(-1e-3));
    // 7.1649 tan 0.65886 + 1.7727 thousand candelas a square meter.
    let expected = (7.1649 * 0.65886_f64.tan() + 1.7727) * 1000.0 / 683.0;
    assert!((luminance / expected - 1.0).abs() < 2e-3, "{luminance} for {expected}");
}
