//! Spots and projectors of Mitsuba 3, and its measured reflectance: values have been measured with
//! Mitsuba 3.9.1.

use std::f64::consts::{PI, TAU};
use std::fs;
use std::path::PathBuf;

use glam::{DMat3, DVec3, Vec3};
use serde_json::json;
use sunstone::internals::scene::baked::BakedScene;
use sunstone::internals::scene::pattern::Pattern;
use sunstone::internals::scene::world::{Bsdf, PunctualKind, World};
use sunstone::internals::scene::{Written, bake, load};
use sunstone::internals::spectrum::Carried;
use sunstone::world::{Falloff, Projection, Punctual, Transform};

use crate::common::{good, load_json, scratch};
use crate::mitsuba::{loaded, scene};

const SPOT: &str = "<emitter type='spot'><transform name='to_world'><lookat origin='0,5,0' \
    target='1,0,0.5' up='0,0,1'/></transform><float name='beam_width' value='10'/><float \
    name='cutoff_angle' value='35'/><rgb name='intensity' value='2 3 4'/></emitter>\
    <shape type='sphere'/>";

/// The only pattern of a world, and what its lamp emits on the average.
fn pattern(world: &World) -> (Pattern, [f32; 3]) {
    let baked: BakedScene<3> = bake(world, &Carried::RGB).unwrap();
    let row = |model: &sunstone::internals::scene::emitter::EmitterModel| {
        matches!(model, sunstone::internals::scene::emitter::EmitterModel::Patterned(_))
    };
    let at = baked.optics.emitters.iter().position(|it| row(&it.model)).expect("it has a pattern");
    (baked.optics.patterns[0].clone(), baked.optics.radiance_of(at))
}

fn kinds(world: &World) -> Vec<PunctualKind> {
    world.entities().query::<&Punctual>().iter().map(|light| light.kind).collect()
}

/// The intensity in Mitsuba falls off evenly with the angle from the beam to the cutoff.
#[test]
fn spots_fall_off_as_in_mitsuba() {
    let world = loaded(SPOT);
    assert_eq!(world.warnings(), [] as [String; 0]);
    let (pattern, mean) = pattern(&world);
    let axis = DVec3::new(1.0, -5.0, 0.5).normalize();
    let across = axis.any_orthonormal_vector();
    for (degrees, share) in [
        (0.0, 1.0),
        (9.9, 1.0),
        (10.1, 0.996),
        (22.5, 0.5),
        (34.0, 0.04),
        (35.1, 0.0),
        (120.0, 0.0),
    ] {
        let angle = f64::to_radians(degrees);
        let direction = axis * angle.cos() + across * angle.sin();
        let found = pattern.share(direction.as_vec3(), &Carried::RGB);
        for (n, intensity) in [2.0, 3.0, 4.0].into_iter().enumerate() {
            let found = f64::from(found[n] * mean[n]);
            assert!((found - share * intensity).abs() < 2e-5 * intensity, "{degrees}: {found}");
        }
    }
    // What is drawn is drawn by its density, and the mean is that of all directions: by a sum over
    // rings, of which there are many.
    let (steps, edge) = (100_000, f64::to_radians(35.0));
    let step = edge / f64::from(steps);
    let (mut all, mut sum) = (0.0, 0.0);
    for ring in 0..steps {
        let angle = (f64::from(ring) + 0.5) * step;
        let direction = (axis * angle.cos() + across * angle.sin()).as_vec3();
        let size = TAU * angle.sin() * step;
        all += size * f64::from(pattern.density(direction));
        sum += size * f64::from(pattern.share(direction, &Carried::RGB)[0]);
    }
    assert!((all - 1.0).abs() < 1e-4 && (sum / (4.0 * PI) - 1.0).abs() < 1e-4, "{all} {sum}");
    for u in [[0.0, 0.0], [0.3, 0.9], [0.999_999, 0.5]] {
        let direction = pattern.direction(u).as_dvec3();
        // Even in the solid angle.
        let expected = 1.0 - f64::from(u[0]) * (1.0 - edge.cos());
        assert!((direction.dot(axis) - expected).abs() < 1e-6, "{u:?}");
    }
}

#[test]
fn falloffs_are_keys_of_gltf_and_are_written() {
    let own = kinds(&loaded(SPOT));
    let falloff = Falloff::Angle;
    let [PunctualKind::Spot { inner, outer, .. }] = own[..] else { panic!("{own:?}") };
    assert_eq!(own, [PunctualKind::Spot { inner, outer, falloff }]);
    let path = scratch("spot.gltf");
    let written = Written::of(&loaded(SPOT)).unwrap();
    assert_eq!(written.warnings(), [] as [String; 0]);
    written.save(&path).unwrap();
    let again = kinds(&load(&path).unwrap());
    fs::remove_file(&path).unwrap();
    let single = |angle: f64| f64::from(angle as f32);
    let (inner, outer) = (single(inner), single(outer));
    assert_eq!(again, [PunctualKind::Spot { inner, outer, falloff }]);
    // A hard edge is one in both, and stays as it was.
    let hard = SPOT.replace("'10'", "'35'");
    let falloff = Falloff::Cosine;
    let of_hard = kinds(&loaded(&hard));
    assert!(matches!(of_hard[..], [PunctualKind::Spot { falloff: it, .. }] if it == falloff));
    for (kind, falloff, words) in
        [("spot", "sharp", "falloff is not known"), ("point", "angle", "falloff is for spots")]
    {
        let mut document = good();
        let light = &mut document["extensions"]["KHR_lights_punctual"]["lights"][0];
        light["type"] = json!(kind);
        light["spot"] = json!({});
        light["extensions"] = json!({"SUNSTONE_polarization": {"falloff": falloff}});
        let error = load_json(&document).map(|_| ()).unwrap_err();
        assert!(error.contains(words), "{error}");
    }
}

/// Narrow and wide ones, and hard edges, of which the mean is that of a sum over rings.
#[test]
fn spots_of_all_widths_have_their_means() {
    for (inner, outer) in [(0.0, 1e-6), (0.0, 9e-4), (0.0, 1.1e-3), (0.2, 0.2001), (0.0, 1.57)] {
        let light = Punctual {
            kind: PunctualKind::Spot { inner, outer, falloff: Falloff::Angle },
            intensity: 1.0.into(),
        };
        let mut world = loaded("<shape type='sphere'/>");
        world.add_light("lamp", light, Transform::IDENTITY).unwrap();
        let (pattern, _) = pattern(&world);
        let steps = 20_000;
        let step = outer / f64::from(steps);
        let ring = |ring: u32| {
            let angle = (f64::from(ring) + 0.5) * step;
            let share = if angle < inner { 1.0 } else { (outer - angle) / (outer - inner) };
            0.5 * angle.sin() * step * share
        };
        let expected: f64 = (0..steps).map(ring).sum();
        let error = pattern.mean() / expected - 1.0;
        assert!(error.abs() < 1e-5, "{inner} {outer}: {error}");
        let drawn = pattern.direction([0.5, 0.25]);
        assert!(pattern.density(drawn) > 0.0 && pattern.share(drawn, &Carried::RGB)[0] >= 0.0);
    }
}

/// A folder with a picture of 3 x 2 texels.
fn folder(name: &str) -> PathBuf {
    let folder = scratch(name);
    fs::create_dir_all(&folder).unwrap();
    let texels = [[255_u8, 0, 0], [0, 255, 0], [0, 0, 255], [200, 200, 0], [0, 120, 220], [255; 3]];
    image::ImageBuffer::from_fn(3, 2, |x, y| image::Rgb(texels[(3 * y + x) as usize]))
        .save(folder.join("p.png"))
        .unwrap();
    folder
}

fn in_folder(name: &str, body: &str) -> Result<World, String> {
    let path = folder(name).join("scene.xml");
    fs::write(&path, scene(body)).unwrap();
    load(&path).map_err(|error| error.to_string())
}

const PLACE: &str = "<transform name='to_world'><lookat origin='0.2,0.1,1.5' target='0,0,0' \
                     up='0,1,0'/></transform><float name='fov' value='50'/>";

/// A projector of the picture, of which more is said.
fn bitmap(more: &str) -> String {
    format!(
        "<shape type='sphere'/><emitter type='projector'>{PLACE}<float name='scale' value='2'/>\
         <texture type='bitmap' name='irradiance'><string name='filename' value='p.png'/><string \
         name='wrap_mode' value='clamp'/>{more}</texture></emitter>"
    )
}

/// On a wall at a distance of 1 that faces it, the irradiance is pi times the texel; right in the
/// picture is what a camera in its place has to the right.
#[test]
fn projectors_throw_what_they_do_in_mitsuba() {
    let axis = DVec3::new(-0.2, -0.1, -1.5).normalize();
    let right = axis.cross(DVec3::Y).normalize();
    let to_world = DMat3::from_cols(right, right.cross(axis), axis);
    let half = f64::to_radians(25.0).tan();
    // The middles of texels.
    let texel = |column: f64, row: f64| {
        let at = DVec3::new((column - 1.0) * half * 2.0 / 3.0, (0.5 - row) * half * 2.0 / 3.0, 1.0);
        ((to_world * at).normalize().as_vec3(), at.length().powi(3))
    };
    let srgb = |byte: f64| ((byte / 255.0 + 0.055) / 1.055).powf(2.4);
    let raw = "<boolean name='raw' value='true'/>";
    for (more, value_of) in [("", srgb as fn(f64) -> f64), (raw, |byte: f64| byte / 255.0)] {
        let world = in_folder("projector", &bitmap(more)).unwrap();
        assert_eq!(world.warnings(), [] as [String; 0]);
        let (pattern, mean) = pattern(&world);
        for (column, row, bytes) in [
            (0.0, 0.0, [255.0, 0.0, 0.0]),
            (2.0, 0.0, [0.0, 0.0, 255.0]),
            (0.0, 1.0, [200.0, 200.0, 0.0]),
            (1.0, 1.0, [0.0, 120.0, 220.0]),
        ] {
            let (direction, cube) = texel(column, row);
            let found = pattern.share(direction, &Carried::RGB);
            for n in 0..3 {
                let value = if bytes[n] == 0.0 { 0.0 } else { value_of(bytes[n]) };
                let (found, expected) = (f64::from(found[n] * mean[n]), 2.0 * PI * value * cube);
                assert!((found - expected).abs() < 1e-4 * (1.0 + expected), "{found} {expected}");
            }
        }
        // As glTF, the angle of the picture has single precision.
        let path = folder("written").join("again.gltf");
        Written::of(&world).unwrap().save(&path).unwrap();
        let (again, _) = self::pattern(&load(&path).unwrap());
        let (direction, _) = texel(0.3, 0.2);
        let [own, other] = [&pattern, &again].map(|it| it.share(direction, &Carried::RGB));
        let error = (Vec3::from(own) - Vec3::from(other)).length() / Vec3::from(own).length();
        assert!(error < 1e-5, "{own:?} {other:?}");
    }
}

#[test]
fn projectors_without_a_picture_throw_a_square() {
    let even = format!("<shape type='sphere'/><emitter type='projector'>{PLACE}</emitter>");
    let world = loaded(&even);
    let sizes: Vec<_> = world
        .entities()
        .query::<&Projection>()
        .iter()
        .map(|projection| projection.0.texels().size())
        .collect();
    assert_eq!(sizes, [[1, 1]]);
    let (pattern, mean) = pattern(&world);
    let axis = Vec3::new(-0.2, -0.1, -1.5).normalize();
    let found = pattern.share(axis, &Carried::RGB)[1] * mean[1];
    assert!((f64::from(found) - PI).abs() < 1e-5, "{found}");
    for (more, words) in [
        ("<transform name='to_uv'><scale value='2'/></transform>", "is no picture as it lies"),
        ("<string name='filter_type' value='nearest'/>", "is no picture as it lies"),
    ] {
        let error = in_folder("projector", &bitmap(more)).map(|_| ()).unwrap_err();
        assert!(error.contains("irradiance") && error.contains(words), "{error}");
    }
    let repeated = bitmap("").replace("'clamp'", "'repeat'");
    let world = in_folder("projector", &repeated).unwrap();
    assert!(world.warnings().concat().contains("outermost texels"), "{:?}", world.warnings());
    let wide = even.replace("'50'", "'179.5'");
    let path = folder("wide").join("scene.xml");
    fs::write(&path, scene(&wide)).unwrap();
    let error = load(&path).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("projector"), "{error}");
}

#[test]
fn measured_tables_are_those_of_the_file() {
    let body = |more: &str| {
        format!(
            "<shape type='rectangle'><bsdf type='measured_polarized'><string name='filename' \
             value='table.pbsdf'/><float name='alpha_sample' value='0.1'/>{more}</bsdf></shape>"
        )
    };
    let here = folder("measured");
    fs::write(here.join("table.pbsdf"), crate::measured::even_table()).unwrap();
    let load_of = |more: &str| {
        fs::write(here.join("scene.xml"), scene(&body(more))).unwrap();
        load(&here.join("scene.xml")).map_err(|error| error.to_string())
    };
    let places = |world: &World| {
        let mut query = world.entities().query::<&Bsdf>();
        let found = query.iter().find_map(|bsdf| match bsdf {
            Bsdf::Measured { places, .. } => Some(places.clone()),
            _ => None,
        });
        found.expect("it is measured")
    };
    let world = load_of("").unwrap();
    assert_eq!(places(&world).at(550.0).unwrap(), 0.5);
    for to in ["same.gltf", "whole.glb"] {
        let path = here.join(to);
        Written::of(&world).unwrap().save(&path).unwrap();
        assert_eq!(places(&load(&path).unwrap()), places(&world), "{to}");
    }
    assert_eq!(places(&load_of("<float name='wavelength' value='-1'/>").unwrap()), places(&world));
    let one = load_of("<float name='wavelength' value='575'/>").unwrap();
    assert_eq!(places(&one).at(510.0).unwrap(), 0.75);
    let error = Written::of(&one).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("one wavelength for all"), "{error}");
    for (more, words) in [
        ("<float name='wavelength' value='700'/>", "700 nm is not among those of the table"),
        ("<float name='roughness' value='1'/>", "roughness is no property"),
    ] {
        let error = load_of(more).map(|_| ()).unwrap_err();
        assert!(error.contains(words), "{error}");
    }
    fs::write(here.join("table.pbsdf"), b"none").unwrap();
    let error = load_of("").map(|_| ()).unwrap_err();
    assert!(error.contains("is no file of tensors"), "{error}");
}
