//! How what is emitted is polarized: in files, by programs, and what is refused.

use glam::{DQuat, DVec3, Vec3};
use serde_json::{Value, json};
use sunstone::internals::scene::emitted::LampState;
use sunstone::internals::scene::world::{EmittedStokes, Transform};
use sunstone::internals::scene::{World, Written, bake, load};
use sunstone::internals::spectrum::{Beyond, Carried, Spectrum};

use crate::common::{good, load_json, scratch};
use crate::room::{edited, has_all, insert, room};

/// The good document with states on its material, light and environment.
fn with(material: &Value, light: &Value, sky: &Value) -> Value {
    let mut document = good();
    document["materials"][0]["extensions"]["SUNSTONE_polarization"]["stokes"] = material.clone();
    let lights = &mut document["extensions"]["KHR_lights_punctual"]["lights"];
    lights[0]["extensions"]["SUNSTONE_polarization"]["stokes"] = light.clone();
    document["scenes"][0]["extensions"]["SUNSTONE_polarization"]["environment"] =
        json!({"radiance": 0.5, "stokes": sky});
    document
}

/// The numbers of a state that is the same in all directions, and its axes.
fn same<const N: usize>(state: &LampState<N>) -> ([[f32; 3]; N], Option<[Vec3; 2]>) {
    match state {
        LampState::Same { stokes, axes } => (*stokes, *axes),
        LampState::Incandescent => panic!("it is not stated"),
    }
}

/// The states of the lamps, in their order, at some wavelengths.
fn states<const N: usize>(world: &World, carried: &Carried<N>) -> Vec<Option<[[f32; 3]; N]>> {
    let states = bake(world, carried).unwrap().optics.states;
    states.of_lamps.into_iter().map(|state| Some(same(&state?).0)).collect()
}

#[test]
fn files_state_them_by_number_color_and_table() {
    let table = json!({"nm": [400, 700], "value": [0.0, 0.6]});
    let document =
        with(&json!([0.5, -0.25, 0.75]), &json!([[0.1, 0.2, 0.3], 0, 0.5]), &json!([table, 0, 0]));
    let world = load_json(&document).unwrap();
    let found: Vec<_> = states(&world, &Carried::RGB).into_iter().flatten().collect();
    let [of_material, of_light, of_sky] = found[..] else { panic!("{found:?}") };
    assert_eq!(of_material, [[0.5, -0.25, 0.75]; 3]);
    assert_eq!(of_light, [[0.1, 0.0, 0.5], [0.2, 0.0, 0.5], [0.3, 0.0, 0.5]]);
    for (state, expected) in of_sky.into_iter().zip([0.5, 0.3, 0.1]) {
        assert!((state[0] - expected).abs() < 1e-6 && state[1..] == [0.0; 2], "{state:?}");
    }
    // Between the channels at 550 and 450 nm.
    let at: Vec<_> = states(&world, &Carried::at([500.0])).into_iter().flatten().collect();
    assert_eq!(at[1], [[0.25, 0.0, 0.5]]);
    has_all(
        &world.describe(),
        &[
            "polarized [0.5, -0.25, 0.75]",
            "polarized [[0.1, 0.2, 0.3], 0, 0.5]",
            "polarized [table of 2 wavelengths, 0, 0]",
        ],
    );
    // In the ways that Blender writes custom properties.
    let mut extras = good();
    extras["materials"][0]["extras"] = json!({"sunstone_stokes": [0.5, -0.25, 0.75]});
    let of_extras = states(&load_json(&extras).unwrap(), &Carried::RGB);
    assert_eq!(of_extras.into_iter().flatten().next(), Some([[0.5, -0.25, 0.75]; 3]));
}

#[test]
fn what_is_unpolarized_has_none() {
    for stokes in [json!([0, 0, 0]), json!([0.0, [0, 0, 0], 0])] {
        let world = load_json(&with(&stokes, &stokes, &stokes)).unwrap();
        assert!(states(&world, &Carried::RGB).is_empty(), "{stokes}");
    }
    assert!(states(&load_json(&good()).unwrap(), &Carried::RGB).is_empty());
}

#[test]
fn files_that_state_them_wrongly_are_refused() {
    let degree = "has a degree of polarization of";
    for (stokes, words) in [
        (json!([1, 0, 0, 0]), "is not three components"),
        (json!([1, 0]), "is not three components"),
        (json!(0.5), "is not three components"),
        (json!([1.5, 0, 0]), "1.5 must be within [-1, 1]"),
        (json!([0.9, 0.9, 0]), degree),
        (json!([[0.1, 0.9, 0], [0, 0.9, 0], 0]), degree),
        (json!([{"nm": [400, 700], "value": [0, 1]}, [0, 0, 0.9], [0.9, 0, 0]]), degree),
        (json!(["Au", 0, 0]), "is not a spectrum"),
        (json!([{"nm": [400], "value": [0, 1]}, 0, 0]), "as many wavelengths as values"),
        (json!([{"sellmeier": 1}, 0, 0]), "is not a key"),
        (json!([null, 0, 0]), "is not a spectrum"),
    ] {
        let none = json!([0, 0, 0]);
        for (document, place) in [
            (with(&stokes, &none, &none), "material 0"),
            (with(&none, &stokes, &none), "light 0"),
            (with(&none, &none, &stokes), "environment"),
        ] {
            let error = load_json(&document).unwrap_err();
            has_all(&error, &[place, "stokes", words]);
        }
    }
    // Of a wall nobody knows what it is to mean; of a lamp that is switched off it means nothing.
    let mut wall = good();
    wall["materials"][1]["extensions"]["SUNSTONE_polarization"]["stokes"] = json!([1, 0, 0]);
    has_all(&load_json(&wall).unwrap_err(), &["material 1", "stokes", "nothing is", "emission"]);
    wall["materials"][1]["extensions"]["SUNSTONE_polarization"]["emission"] = json!(0);
    assert!(load_json(&wall).is_ok());
}

#[test]
fn programs_state_them_and_edits_are_checked() {
    let mut world = room();
    let circular = || EmittedStokes::new([0.0, 0.0, 1.0]).unwrap();
    for name in ["glow", "lamp", "environment"] {
        let entity = world.find(name).unwrap();
        world.set_emitted_stokes(entity, circular()).unwrap();
    }
    let found = states(&world, &Carried::RGB);
    assert_eq!(found.iter().flatten().count(), 3);
    for (name, words) in [("glass", "nothing is"), ("eye", "nothing is"), ("ball", "nothing is")] {
        let entity = world.find(name).unwrap();
        let error = world.set_emitted_stokes(entity, circular()).unwrap_err().to_string();
        has_all(&error, &[name, "stokes", words]);
    }
    for stokes in [[f32::NAN, 0.0, 0.0], [2.0, 0.0, 0.0], [0.8, 0.8, 0.0]] {
        assert!(EmittedStokes::new(stokes).is_err());
        let stokes = EmittedStokes { stokes: stokes.map(Spectrum::from) };
        let words = edited(|world| insert(world, "lamp", stokes));
        has_all(&words, &["lamp", "stokes"]);
    }
    has_all(&edited(|world| insert(world, "glass", circular())), &["glass", "nothing is"]);
    has_all(&edited(|world| insert(world, "eye", circular())), &["eye", "means nothing for"]);
}

/// A table that does not cover the render is refused, or held.
#[test]
fn tables_end() {
    let table = Spectrum::table(&[400.0, 600.0], &[0.5, 1.0]).unwrap();
    let mut world = room();
    let lamp = world.find("lamp").unwrap();
    let stokes = EmittedStokes { stokes: [table, 0.0.into(), 0.0.into()] };
    world.set_emitted_stokes(lamp, stokes).unwrap();
    let error = bake(&world, &Carried::RGB).map(|_| ()).unwrap_err().to_string();
    has_all(&error, &["lamp", "stokes", "covers 400 to 600 nm only"]);
    let baked = bake(&world, &Carried::RGB.beyond(Beyond::Held)).unwrap().optics;
    assert!(baked.states.is_chromatic && baked.held.len() == 1, "{:?}", baked.held);
    let [red, ..] = same(baked.states.of_lamps.iter().flatten().next().unwrap()).0;
    assert_eq!(red, [1.0, 0.0, 0.0]);
}

/// The frame of a light is that of its node, of any scale.
#[test]
fn frames_are_those_of_nodes() {
    let turn = DQuat::from_rotation_y(0.3) * DQuat::from_rotation_z(1.1);
    let mut world = room();
    let lamp = world.find("lamp").unwrap();
    world.set_emitted_stokes(lamp, EmittedStokes::new([1.0, 0.0, 0.0]).unwrap()).unwrap();
    let scale = DVec3::new(2.0, 0.5, 7.0);
    let place = glam::DAffine3::from_scale_rotation_translation(scale, turn, DVec3::Y);
    insert(&mut world, "lamp", Transform(place));
    let states = bake(&world, &Carried::RGB).unwrap().optics.states;
    let state = states.of_lamps.iter().flatten().next().unwrap();
    for (axis, expected) in same(state).1.unwrap().into_iter().zip([DVec3::X, DVec3::Y]) {
        let expected: Vec3 = (turn * expected).as_vec3();
        assert!(axis.distance(expected) < 1e-6, "{axis}, not {expected}");
    }
}

/// What was understood is written, and read again as the same.
#[test]
fn they_are_written() {
    let table = json!({"nm": [400, 700], "value": [0.0, 0.5]});
    let document = with(
        &json!([0.5, -0.25, 0.75]),
        &json!([[0.25, 0.5, 0.125], 0, 0.5]),
        &json!([table, 0, 0]),
    );
    let world = load_json(&document).unwrap();
    let path = scratch("stokes.gltf");
    Written::of(&world).unwrap().save(&path).unwrap();
    let again = load(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    let of = |world: &World| bake(world, &Carried::RGB).unwrap().optics.states;
    assert_eq!(of(&world).of_lamps.iter().flatten().count(), 3);
    let [first, second] =
        [&world, &again].map(|world| of(world).of_lamps.into_iter().flatten().collect::<Vec<_>>());
    assert_eq!(first, second);
}

/// What glows by its heat, in files; it is written, and what it does not go together with refused.
#[test]
fn files_have_hot_surfaces() {
    let hot = |body: Value| {
        let mut document = good();
        let own = &mut document["materials"][0]["extensions"]["SUNSTONE_polarization"];
        *own = body;
        document
    };
    let tungsten = json!({"bsdf": "conductor", "metal": "W", "incandescent": true,
        "emission": {"blackbody_k": 2800, "scale": 50}});
    let world = load_json(&hot(tungsten.clone())).unwrap();
    has_all(&world.describe(), &["by its heat"]);
    let is_hot = |world: &World| bake(world, &Carried::RGB).unwrap().optics.states.has_incandescent;
    assert!(is_hot(&world));
    let path = scratch("hot.gltf");
    Written::of(&world).unwrap().save(&path).unwrap();
    assert!(is_hot(&load(&path).unwrap()));
    std::fs::remove_file(&path).unwrap();
    let mut cold = tungsten.clone();
    cold["incandescent"] = json!(false);
    assert!(!is_hot(&load_json(&hot(cold)).unwrap()));
    for (key, value, words) in [
        ("stokes", json!([1, 0, 0]), "stokes"),
        ("incandescent", json!("yes"), "neither true nor false"),
        ("bsdf", json!("rough_conductor"), "smooth"),
    ] {
        let mut wrong = tungsten.clone();
        wrong[key] = value;
        if key == "bsdf" {
            wrong["alpha"] = json!(0.3);
        }
        has_all(&load_json(&hot(wrong)).unwrap_err(), &["material 0", "incandescent", words]);
    }
    // What does not go together is named, and the way to mend it.
    let glass = json!({"bsdf": "dielectric", "incandescent": true, "emission": 5});
    let film = json!({"eta": 1.5, "thickness_nm": 300});
    for (body, key, value, words) in [
        (&tungsten, "film", film.clone(), ["does not go with film", "remove the film"]),
        (&glass, "film", film, ["does not go with film", "or incandescent"]),
        (&tungsten, "reflected", json!(0.5), ["does not go with reflected", "remove reflected"]),
        (&glass, "transmitted", json!(0.5), ["does not go with transmitted", "remove the color"]),
        (&glass, "ior", json!(1), ["ior is that of what is around it", "another ior"]),
        (&glass, "bsdf", json!("thin_dielectric"), ["the model is thin dielectric", "use a"]),
        (&tungsten, "emission", Value::Null, ["nothing is emitted", "add a blackbody"]),
    ] {
        let mut wrong = body.clone();
        wrong[key] = value;
        let mut document = hot(wrong);
        document["materials"][0].as_object_mut().unwrap().remove("emissiveFactor");
        let error = load_json(&document).unwrap_err();
        has_all(&error, &["material 0 \"glow\", SUNSTONE_polarization.incandescent "]);
        has_all(&error, &words);
    }
    // It emits less of what light paths start from than a black body, by a share of the power.
    let power = |world: &World| bake(world, &Carried::RGB).unwrap().optics.emitters[0].brightness;
    let mut black = tungsten;
    black["bsdf"] = json!("absorber");
    for key in ["metal", "incandescent"] {
        black.as_object_mut().unwrap().remove(key);
    }
    let share = power(&world) / power(&load_json(&hot(black)).unwrap());
    // CRC Handbook: tungsten at 550 nm reflects 0.5 of what falls straight on it.
    assert!((0.4..0.6).contains(&share), "{share}");
}
