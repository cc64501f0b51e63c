//! Every check of a component's field: refused where a program adds it, with the same words as an
//! edit that is baked, and as the reader of files.

use std::sync::Arc;

use crate::common::{good, load_json};
use crate::room::{edited, has_all, insert, remove, room};
use glam::{DAffine3, DMat3, DVec3, Vec2, Vec3};
use serde_json::{Value, json};
use sunstone::Analyzer;
use sunstone::internals::polarization::milk::Milk;
use sunstone::internals::polarization::particles::{Amount, Sizes};
use sunstone::internals::scene::world::{
    Ball, Bsdf, Component, Emission, Environment, Geometry, Lens, Material, Medium, Mesh, Phase,
    Punctual, Resolution, Spheres, TabulatedMatrix, Transform,
};
use sunstone::internals::scene::{SceneError, World};
use sunstone::internals::spectrum::Spectrum;

/// Refused as a new material, with the same words as an edit of one, and as in a file.
#[track_caller]
fn material(material: impl Into<Material>, file: Option<Value>, expected: &[&str]) {
    let material: Material = material.into();
    let mut world = room();
    let added = world.add_material("new", material.clone()).unwrap_err().to_string();
    has_all(&added, expected);
    has_all(&added, &["material `new`"]);
    let baked = edited(|world| {
        insert(world, "glow", material.bsdf);
        insert(world, "glow", material.sides);
        match material.emission {
            Some(emission) => insert(world, "glow", emission),
            None => remove::<Emission>(world, "glow"),
        }
    });
    assert_eq!(baked, added.replace("`new`", "`glow`"));
    let Some(body) = file else { return };
    let mut document = good();
    document["materials"][0]["extensions"]["SUNSTONE_polarization"] = body;
    let read = load_json(&document).unwrap_err();
    let problem = |text: &str| text.rsplit_once(": ").unwrap().1.to_owned();
    assert_eq!(problem(&read), problem(&added), "in the file: {read}");
}

#[test]
fn materials() {
    let cases: [(Bsdf, Value, &[&str]); 9] = [
        (
            Bsdf::diffuse(2.5),
            json!({"bsdf": "diffuse", "reflectance": 2.5}),
            &["reflectance: 2.5 must be within [0, 1]"],
        ),
        (
            Bsdf::diffuse([0.1, -0.2, 0.3]),
            json!({"bsdf": "diffuse", "reflectance": [0.1, -0.2, 0.3]}),
            &["reflectance: -0.2 must"],
        ),
        (
            Bsdf::Conductor { eta: 0.0.into(), k: 1.0.into() },
            json!({"bsdf": "conductor", "eta": 0, "k": 1}),
            &["eta: 0 must be greater than 0"],
        ),
        (
            Bsdf::Conductor { eta: 1.0.into(), k: [1.0, 1.0, -1.0].into() },
            json!({"bsdf": "conductor", "eta": 1, "k": [1, 1, -1]}),
            &["k: -1 must be not negative"],
        ),
        (
            Bsdf::dielectric(0.0),
            json!({"bsdf": "dielectric", "ior": 0}),
            &["ior: 0 must be greater than 0"],
        ),
        (
            Bsdf::Dielectric { ior: 1.5, exterior_ior: -1.0 },
            json!({"bsdf": "dielectric", "ior": 1.5, "exterior_ior": -1}),
            &["exterior_ior: -1 must"],
        ),
        (
            Bsdf::Dielectric { ior: 1e30, exterior_ior: 1e-30 },
            json!({"bsdf": "dielectric", "ior": 1e30, "exterior_ior": 1e-30}),
            &["ior over exterior_ior: inf must"],
        ),
        (
            Bsdf::Polarizer { axis_deg: 0.0, extinction_ratio: 0.5 },
            json!({"bsdf": "polarizer", "extinction_ratio": 0.5}),
            &["extinction_ratio: 0.5 must be at least 1"],
        ),
        (
            Bsdf::Conductor {
                eta: Spectrum::table(&[400.0, 700.0], &[1.0, 0.0]).unwrap(),
                k: 1.0.into(),
            },
            json!({"bsdf": "conductor", "eta": {"nm": [400, 700], "value": [1, 0]}, "k": 1}),
            &["eta: 0 must"],
        ),
    ];
    for (bsdf, file, expected) in cases {
        material(bsdf, Some(file), expected);
    }
}

/// What JSON cannot say.
#[test]
fn materials_of_no_number() {
    let (nan, infinite) = (f64::NAN, f64::INFINITY);
    material(Bsdf::diffuse(f32::NAN), None, &["reflectance: NaN"]);
    material(Bsdf::dielectric(f32::INFINITY), None, &["ior: inf"]);
    material(Bsdf::polarizer(nan), None, &["axis_deg: NaN must be a finite number"]);
    material(
        Bsdf::Polarizer { axis_deg: 0.0, extinction_ratio: nan },
        None,
        &["extinction_ratio: NaN"],
    );
    material(Bsdf::retarder(infinite, 90.0), None, &["axis_deg: inf"]);
    material(Bsdf::retarder(0.0, nan), None, &["retardance_deg: NaN"]);
    material(Material::emitter(-1.0), None, &["radiance: -1 must be not negative"]);
    material(Material::emitter(f32::NAN), None, &["radiance: NaN"]);
    let error = Bsdf::metal("Xx").unwrap_err().to_string();
    has_all(&error, &["`Xx` is not tabulated", "Ag, Al, Au, Be"]);
    assert!(room().add_material("ideal", Bsdf::polarizer(30.0)).is_ok());
}

/// Refused as a new medium, with the same words as an edit of one.
#[track_caller]
fn medium(medium: impl Into<Medium>, expected: &str) {
    let medium: Medium = medium.into();
    let added = room().add_medium("new", medium.clone()).unwrap_err().to_string();
    has_all(&added, &["medium `new`", expected]);
    let baked = edited(|world| insert(world, "fog", medium));
    assert_eq!(baked, added.replace("`new`", "`fog`"));
}

#[test]
fn media() {
    let hg = |g: f32| Phase::HenyeyGreenstein { g: g.into() };
    medium(Medium::new(-1.0, 1.0, hg(0.0)), "sigma_a: -1 must be not negative");
    medium(Medium::new(1.0, [0.0, f32::NAN, 0.0], hg(0.0)), "sigma_s: NaN");
    medium(Medium::new(1.0, 1.0, hg(1.0)), "g: 1 must be within (-1, 1)");
    medium(hg(0.5), "sigma_a is missing");
    let rayleigh = |depolarization| Phase::Rayleigh { depolarization };
    medium(Medium::new(0.0, 1.0, rayleigh(0.6)), "depolarization: 0.6 must be within [0, 0.5]");
    medium(Medium { sigma_a: Some(1.0.into()), ..Medium::from(rayleigh(0.0)) }, "sigma_s is mis");
    let milk = |fat_percent, protein_percent, dilution| {
        Phase::Milk(Milk { fat_percent, protein_percent, dilution })
    };
    medium(milk(101.0, 3.4, 1.0), "fat_percent: 101 must be within [0, 100]");
    medium(milk(3.5, f64::NAN, 1.0), "protein_percent: NaN");
    medium(milk(3.5, 3.4, 0.0), "dilution: 0 must be greater than 0");
    medium(milk(0.0, 0.0, 1.0), "would fill 0 of the volume");
    assert!(room().add_medium("milk", milk(3.5, 3.4, 0.1)).is_ok());
}

#[test]
fn suspensions() {
    let component = |eta: f32, k: f32, volume_fraction| Component {
        sizes: Sizes::monodisperse(0.5).unwrap(),
        eta: eta.into(),
        k: k.into(),
        volume_fraction,
    };
    let spheres = |components, host_eta: f32, host_k: f32| {
        let (host_eta, host_k) = (host_eta.into(), host_k.into());
        Phase::Spheres(Spheres { components, host_eta, host_k })
    };
    let fine = component(1.59, 0.0, 1e-5);
    medium(spheres(vec![], 1.33, 0.0), "components has 0 kinds of particles");
    medium(spheres(vec![fine.clone(); 17], 1.33, 0.0), "components has 17 kinds");
    medium(spheres(vec![fine.clone()], 0.0, 0.0), "host_eta: 0 must be within [0.05, 20]");
    medium(spheres(vec![fine.clone()], 1.33, -1.0), "host_k: -1 must be within [0, 20]");
    let second = |second| spheres(vec![fine.clone(), second], 1.33, 0.0);
    medium(second(component(30.0, 0.0, 0.1)), "components[1].eta: 30 must be");
    medium(second(component(1.5, f32::NAN, 0.1)), "components[1].k: NaN");
    medium(second(component(1.5, 0.0, 0.0)), "components[1].volume_fraction: 0 must");
    medium(second(component(1.5, 0.0, 1.0)), "components fill 1.00001 of the volume");
    assert!(room().add_medium("spheres", second(component(1.5, 0.0, 0.1))).is_ok());

    // Sizes are checked where they are made, and cannot be edited.
    let of = Amount::Volume;
    for (sizes, field) in [
        (Sizes::monodisperse(0.0), "radius_um"),
        (Sizes::log_normal(f64::NAN, 0.1, of, None), "mean_um"),
        (Sizes::gamma(1.0, 2e3, of, None), "sd_um"),
        (Sizes::gamma(1.0, 5e-4, of, None), "sd_um"),
        (Sizes::gamma(1.0, 0.1, of, Some([2.0, 1.0])), "range_um"),
        (Sizes::log_normal(1.0, 0.1, of, Some([0.0, 1.0])), "range_um"),
        (Sizes::table(&[0.1, 2e3], &[1.0, 1.0], of), "radii_um"),
        (Sizes::table(&[0.1, 0.2], &[1.0, -1.0], of), "density"),
    ] {
        assert_eq!(sizes.unwrap_err().field, field);
    }
}

#[test]
fn phase_matrices() {
    let unit = 0.25 / std::f64::consts::PI;
    let fine = TabulatedMatrix {
        wavelength_nm: Some(500.0),
        theta_deg: vec![0.0, 90.0, 180.0],
        elements: vec![[unit, 0.0, unit, 0.0, 0.0, 0.0]; 3],
    };
    let table = |matrices| Medium::new(0.0, 1.0, Phase::Table(matrices));
    medium(table(vec![]), "table needs rows");
    medium(table(vec![fine.clone(), fine.clone()]), "table needs rows, sorted by increasing");
    let none = TabulatedMatrix { wavelength_nm: None, ..fine.clone() };
    medium(table(vec![none.clone(), fine.clone()]), "table needs rows, sorted");
    let spoilt = |spoil: fn(&mut TabulatedMatrix)| {
        let mut matrix = fine.clone();
        spoil(&mut matrix);
        table(vec![matrix])
    };
    medium(spoilt(|m| m.wavelength_nm = Some(-1.0)), "table needs rows, sorted");
    medium(spoilt(|m| m.theta_deg[1] = 0.0), "table[0] needs increasing angles");
    medium(spoilt(|m| m.theta_deg[2] = 170.0), "table[0] covers 0 to 170 degrees");
    medium(spoilt(|m| m.theta_deg.truncate(2)), "table[0] has columns of different lengths");
    medium(spoilt(|m| m.elements[1][0] = -1.0), "table[0]: M00 is negative at 90 degrees");
    medium(spoilt(|m| m.elements[1][3] = 1.0), "table[0]: an element exceeds M00 at 90");
    medium(spoilt(|m| m.elements[1][5] = f64::NAN), "table[0] has values that are not finite");
    medium(
        spoilt(|m| m.elements.as_flattened_mut().iter_mut().for_each(|m| *m *= 2.0)),
        "table[0]: M00 integrates to 2",
    );
    assert!(room().add_medium("table", table(vec![fine])).is_ok());
}

#[test]
fn lights() {
    for (light, expected) in [
        (Punctual::point(-1.0), "intensity: -1 must be not negative"),
        (Punctual::directional([1.0, f32::INFINITY, 1.0]), "intensity: inf"),
        (
            Punctual::spot(1.0, 0.5, 0.25),
            "spot: the inner cone angle of 0.5 and the outer of 0.25 radians do not fit",
        ),
        (Punctual::spot(1.0, 0.5, 2.0), "spot: "),
        (Punctual::spot(1.0, 0.0, 0.0), "spot: "),
        (Punctual::spot(1.0, f64::NAN, 1.0), "spot: "),
    ] {
        let added = room().add_light("new", light.clone(), DVec3::ZERO).unwrap_err().to_string();
        has_all(&added, &["light `new`", expected]);
        let baked = edited(|world| insert(world, "lamp", light));
        assert_eq!(baked, added.replace("`new`", "`lamp`"));
    }
    for radiance in [-1.0, f32::NAN] {
        let sky = Environment::constant(radiance);
        let set = room().set_environment(radiance).unwrap_err().to_string();
        has_all(&set, &["environment, radiance: "]);
        assert_eq!(edited(|world| insert(world, "environment", sky)), set);
    }
}

#[test]
fn cameras() {
    let perspective = |yfov, aspect, aperture_radius, focus_distance| Lens::Perspective {
        yfov,
        aspect,
        aperture_radius,
        focus_distance,
    };
    let parallel = |half_width, half_height| Lens::Orthographic { half_width, half_height };
    for (lens, expected) in [
        (Lens::pinhole(0.0), "yfov: 0 must be greater than 0 and less than pi"),
        (Lens::pinhole(f64::NAN), "yfov: NaN"),
        (perspective(1.0, Some(0.0), 0.0, 1.0), "aspect: 0 must"),
        (perspective(1.0, None, -1.0, 1.0), "aperture_radius: -1 must"),
        (perspective(1.0, None, 0.1, 0.0), "focus_distance: 0 must"),
        (parallel(0.0, 1.0), "half_width: 0 must"),
        (parallel(1.0, f32::NAN), "half_height: NaN"),
    ] {
        let set = room().set_camera("new", lens, DVec3::ZERO).unwrap_err().to_string();
        has_all(&set, &["camera `new`", expected]);
        assert_eq!(edited(|world| insert(world, "eye", lens)), set.replace("`new`", "`eye`"));
    }
    for sides in [[0, 5], [5, 0], [65_537, 5]] {
        let set = room().set_resolution(sides).unwrap_err().to_string();
        has_all(&set, &["camera `eye`, resolution", "whole numbers from 1 to 65535"]);
        assert_eq!(edited(|world| insert(world, "eye", Resolution(sides))), set);
    }
    assert!(World::new("").set_resolution([5, 5]).is_err(), "no camera yet");
}

#[test]
fn analyzers() {
    for axis_deg in [f64::NAN, f64::INFINITY, 1e39] {
        let analyzer = Analyzer::Linear { axis_deg };
        let set = room().set_analyzer(Some(analyzer)).unwrap_err().to_string();
        has_all(&set, &["camera `eye`, analyzer.axis_deg: ", "must be a finite number"]);
        assert_eq!(edited(|world| insert(world, "eye", analyzer)), set);
    }
    let nowhere = World::new("").set_analyzer(None).unwrap_err().to_string();
    has_all(&nowhere, &["analyzer: the world has no camera", "set the camera first"]);
    has_all(
        &edited(|world| insert(world, "glow", Analyzer::LeftCircular)),
        &["material `glow`, Analyzer means nothing for a material"],
    );
    let read = |analyzer: Value| {
        let mut document = good();
        document["cameras"][0]["extras"] = json!({"sunstone_film": {"analyzer": analyzer}});
        load_json(&document).unwrap_err()
    };
    let cases: [(Value, &[&str]); 7] = [
        (json!({}), &["sunstone_film.analyzer.kind is missing", "kind is linear, with axis_deg"]),
        (json!({"axis_deg": 10}), &["analyzer.kind is missing"]),
        (json!({"kind": "round"}), &["analyzer.kind: `round` is no analyzer", "left_circular"]),
        (
            json!({"kind": "right_circular", "axis_deg": 0}),
            &["analyzer.axis_deg: an analyzer of kind right_circular has no axis", "remove it"],
        ),
        (json!({"kind": "none", "axis_deg": 0}), &["axis_deg: an analyzer of kind none has no"]),
        (json!({"kind": "linear", "axis_deg": "x"}), &["analyzer.axis_deg is not a number"]),
        (
            json!({"kind": "linear", "hand": 1}),
            &["analyzer.hand", "the keys of an analyzer are axis_deg, kind"],
        ),
    ];
    for (analyzer, expected) in cases {
        has_all(&read(analyzer), expected);
    }
}

#[test]
fn places() {
    let scaled = |x: f64, y: f64, z: f64| Transform(DAffine3::from_scale(DVec3::new(x, y, z)));
    let sheared = DMat3::from_cols(DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Z);
    let sheared = Transform(DAffine3::from_mat3(sheared));
    let aimless = Transform::looking(DVec3::ONE, DVec3::ONE, DVec3::Y);
    let lost = Transform::from(DVec3::new(0.0, f64::INFINITY, 0.0));
    let glass = |world: &World| world.find("glass").unwrap();
    type Add = fn(&mut World, hecs::Entity, Transform) -> Result<hecs::Entity, SceneError>;
    let mesh: Add = |world, glass, place| {
        world.add_mesh("panel", Geometry::quad(Vec3::ZERO, Vec3::X, Vec3::Y), glass, place)
    };
    let ball: Add = |world, glass, place| world.add_sphere("ball", 1.0, glass, place);
    let lamp: Add = |world, _, place| world.add_light("lamp", Punctual::point(1.0), place);
    let eye: Add = |world, _, place| world.set_camera("eye", Lens::pinhole(1.0), place);
    let singular = "its transform is singular or not finite";
    for (name, add, place, expected) in [
        ("panel", mesh, scaled(1.0, 0.0, 1.0), singular),
        ("ball", ball, lost, singular),
        ("lamp", lamp, aimless, singular),
        ("eye", eye, aimless, singular),
        ("ball", ball, scaled(1.0, 2.0, 1.0), "a sphere cannot be scaled differently"),
        ("ball", ball, sheared, "a sphere cannot be scaled differently"),
        ("eye", eye, scaled(-1.0, 1.0, 1.0), "sheared or mirrored"),
        ("eye", eye, sheared, "sheared or mirrored"),
    ] {
        let mut world = room();
        let glass = glass(&world);
        let added = add(&mut world, glass, place).unwrap_err().to_string();
        has_all(&added, &[name, expected]);
        assert_eq!(edited(|world| insert(world, name, place)), added);
    }
}

#[test]
fn meshes() {
    let quad = || Geometry::quad(Vec3::ZERO, Vec3::X, Vec3::Y);
    let spoilt = |spoil: fn(&mut Geometry)| {
        let mut geometry = quad();
        spoil(&mut geometry);
        geometry
    };
    for (geometry, expected) in [
        (Geometry::default(), "has no triangle with an area"),
        (spoilt(|g| g.triangles.clear()), "has no triangle with an area"),
        (spoilt(|g| g.positions[1].y = f32::NAN), "positions: vertex 1 is not finite"),
        (spoilt(|g| g.triangles[1][2] = 4), "triangles: 4 is not one of the 4 vertices"),
        (spoilt(|g| g.triangles[1] = [0, 2, 2]), "triangle 1 has no area"),
        (spoilt(|g| g.positions[2] = g.positions[0]), "triangle 0 has no area"),
        (spoilt(|g| g.normals = vec![Vec3::Z; 3]), "normals: 3 normals for 4 vertices"),
        (
            spoilt(|g| g.normals = vec![Vec3::Z, Vec3::NAN, Vec3::Z, Vec3::Z]),
            "normals: the normal of vertex 1 is not finite",
        ),
        (spoilt(|g| g.texture_coordinates = vec![Vec2::X; 5]), "texture_coordinates: 5 for 4"),
        (spoilt(|g| g.texture_coordinates = vec![Vec2::NAN; 4]), "those of vertex 0 are not fin"),
    ] {
        let mut world = room();
        let glass = world.find("glass").unwrap();
        let added = world.add_mesh("new", geometry.clone(), glass, DVec3::ZERO);
        let added = added.unwrap_err().to_string();
        has_all(&added, &["mesh `new`", expected]);
        let replaced = edited(|world| insert(world, "panel", Mesh(Arc::new(geometry.clone()))));
        assert_eq!(replaced, added.replace("`new`", "`panel`"));
        // In place, although this geometry has been checked when it was added.
        let in_place = edited(|world| {
            let panel = world.find("panel").unwrap();
            let mut mesh = world.entities_mut().get::<&mut Mesh>(panel).unwrap();
            *Arc::make_mut(&mut mesh.0) = geometry;
        });
        assert_eq!(in_place, replaced);
    }
    for radius in [0.0, -1.0, f64::NAN, 1e39] {
        let mut world = room();
        let glass = world.find("glass").unwrap();
        let added = world.add_sphere("new", radius, glass, DVec3::ZERO).unwrap_err().to_string();
        has_all(&added, &["sphere `new`, radius: ", "must be greater than 0"]);
        let baked = edited(|world| insert(world, "ball", Ball { radius }));
        assert_eq!(baked, added.replace("`new`", "`ball`"));
    }
    let mut world = room();
    let glass = world.find("glass").unwrap();
    let mut leaning = quad();
    leaning.normals = vec![Vec3::Z, Vec3::Z, Vec3::NEG_Z, Vec3::ZERO];
    leaning.texture_coordinates = vec![Vec2::ZERO; 4];
    world.add_mesh("leaning", leaning, glass, DVec3::ZERO).unwrap();
    has_all(world.warnings().join("").as_str(), &["mesh `leaning`: 3 corners have a normal on"]);
}
