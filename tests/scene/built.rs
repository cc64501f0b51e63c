//! Worlds that a program makes or edits: the same tables as from a file, names, and entities that
//! do not go together.

use std::sync::{Arc, Barrier};
use std::thread;

use crate::common::{good, load_json};
use crate::room::{despawn, edited, has_all, insert, refusal, remove, room};
use glam::{DVec3, Vec3};
use serde_json::{Value, json};
use sunstone::internals::scene::world::{
    Ball, Boundary, Bsdf, Emission, Environment, Filling, FillsScene, Geometry, Lens, MadeOf,
    Medium, Name, Order, Phase, Punctual, Sides, Skin, SurfaceModel, Transform,
};
use sunstone::internals::scene::{View, World, bake};
use sunstone::internals::spectrum::{Carried, Spectrum};
use sunstone::{Analyzer, Edit, PlacedWorld, SceneFile};

/// The same room as a file.
fn room_file() -> Value {
    let mut document = good();
    let media = json!({"media": [
        {"name": "fog", "phase": "isotropic", "sigma_a": 0.25, "sigma_s": [1, 2, 3]}]});
    document["extras"]["sunstone"] = media;
    document["extras"]["sunstone_environment"] = json!({"radiance": 0.125});
    document["nodes"][2]["extensions"]["SUNSTONE_polarization"]["interior"] = json!(0);
    document["extensions"]["KHR_lights_punctual"]["lights"][0] = json!({"name": "bulb",
        "type": "point", "intensity": 1.0, "extras": {"sunstone_units": "radiometric"}});
    document["cameras"][0]["extras"]["sunstone_film"] = json!({"resolution": [32, 32]});
    document
}

#[test]
fn code_and_file_give_the_same_tables() {
    let built = format!("{:?}", bake(&room(), &Carried::RGB).unwrap());
    let read = load_json(&room_file()).unwrap();
    assert_eq!(built, format!("{:?}", bake(&read, &Carried::RGB).unwrap()));
    assert_eq!(read.warnings(), room().warnings());
    // The room has everything that the descriptions of worlds know.
    let lines = |world: &World| world.describe().lines().count();
    assert_eq!(lines(&room()), lines(&read));
}

#[test]
fn entities_are_found_by_their_names() {
    let built = room();
    let name = |world: &World, name: &str| {
        let entity = world.find(name)?;
        Some(world.entities().get::<&Name>(entity).unwrap().0.clone())
    };
    assert_eq!(name(&built, "ball").as_deref(), Some("sphere `ball`"));
    assert_eq!(name(&built, "sphere `ball`").as_deref(), Some("sphere `ball`"));
    assert_eq!(name(&built, "bal"), None);
    let read = load_json(&room_file()).unwrap();
    for (own, whole) in [
        ("glow", "material 0 \"glow\""),
        ("panel", "node 1 \"panel\", mesh 0 \"square\", primitive 0"),
        ("square", "node 1 \"panel\", mesh 0 \"square\", primitive 0"),
        ("ball", "node 2 \"ball\", sphere"),
        ("bulb", "node 3 \"lamp\", light 0 \"bulb\""),
        ("lens", "node 0 \"eye\", camera 0 \"lens\""),
        ("material 1 \"glass\"", "material 1 \"glass\""),
    ] {
        assert_eq!(name(&read, own).as_deref(), Some(whole));
    }
    assert_eq!(read.find("stand-in"), None);
}

/// The same by code, by file and in words; a new camera has none, and neither has `none`.
#[test]
fn cameras_have_analyzers() {
    let cases = [
        (json!({"kind": "linear", "axis_deg": 22.5}), Analyzer::Linear { axis_deg: 22.5 }),
        (json!({"kind": "linear"}), Analyzer::Linear { axis_deg: 0.0 }),
        (json!({"kind": "right_circular"}), Analyzer::RightCircular),
        (json!({"kind": "left_circular"}), Analyzer::LeftCircular),
    ];
    let of = |world: &World| bake(world, &Carried::RGB).unwrap().camera.analyzer;
    for (body, analyzer) in cases {
        let mut document = room_file();
        document["cameras"][0]["extras"]["sunstone_film"]["analyzer"] = body;
        let read = load_json(&document).unwrap();
        assert_eq!(of(&read), Some(analyzer));
        let words = format!("behind an analyzer: {analyzer}");
        has_all(&read.describe(), &[&words]);
        let mut built = room();
        built.set_analyzer(Some(Analyzer::LeftCircular)).unwrap();
        built.set_analyzer(Some(analyzer)).unwrap();
        assert_eq!(of(&built), Some(analyzer));
        built.set_analyzer(None).unwrap();
        assert_eq!(of(&built), None);
        built.set_analyzer(Some(analyzer)).unwrap();
        built.set_camera("other", Lens::pinhole(1.0), DVec3::Z).unwrap();
        assert_eq!(of(&built), None);
    }
    let mut document = room_file();
    document["cameras"][0]["extras"]["sunstone_film"]["analyzer"] = json!({"kind": "none"});
    let read = load_json(&document).unwrap();
    assert_eq!(of(&read), None);
    assert!(!read.describe().contains("analyzer"));
}

#[test]
fn what_is_set_replaces_what_was_there() {
    let mut world = room();
    world.set_camera("other", Lens::pinhole(1.0), DVec3::Z).unwrap();
    world.set_environment([0.0, 0.0, 1.0]).unwrap();
    let scene = bake(&world, &Carried::RGB).unwrap();
    assert_eq!(scene.camera.resolution, None, "it was the other camera's");
    assert_eq!(scene.optics.lamps.last().copied().unwrap(), [0.0, 0.0, 1.0]);
    assert!(world.find("eye").is_none());

    // What is refused leaves the world as it was.
    assert!(world.set_camera("bad", Lens::pinhole(0.0), DVec3::Z).is_err());
    assert!(world.set_environment(-1.0).is_err());
    assert_eq!(format!("{:?}", bake(&world, &Carried::RGB).unwrap()), format!("{scene:?}"));

    let fog = world.find("fog").unwrap();
    world.set_environment(0.0).unwrap();
    world.set_scene_medium(fog).unwrap();
    assert_eq!(bake(&world, &Carried::RGB).unwrap().shapes.scene_medium, 0);
    let thin = world.add_medium("", Medium::new(0.0, 0.1, Phase::isotropic())).unwrap();
    world.set_scene_medium(thin).unwrap();
    assert_eq!(bake(&world, &Carried::RGB).unwrap().shapes.scene_medium, 1);
    world.set_scene_medium(None).unwrap();
    assert_eq!(bake(&world, &Carried::RGB).unwrap().shapes.scene_medium, u32::MAX);
    let error = world.set_scene_medium(world.find("glass").unwrap()).unwrap_err().to_string();
    has_all(&error, &["scene, medium", "not a medium"]);
}

#[test]
fn lights_can_be_put_out_and_geometry_shared() {
    let mut world = room();
    insert(&mut world, "glow", Emission { radiance: Spectrum::Constant(0.0) });
    insert(&mut world, "lamp", Punctual::point(0.0));
    assert_eq!(bake(&world, &Carried::RGB).unwrap().optics.emitters.len(), 1);

    let grid = 200;
    let at = |index: u32| Vec3::new((index % grid) as f32, (index / grid) as f32, 0.0);
    let inner = (0..grid * grid).filter(|at| at % grid + 1 < grid && at / grid + 1 < grid);
    let triangles = inner.map(|at| [at, at + 1, at + grid]).collect();
    let mesh = Arc::new(Geometry::new((0..grid * grid).map(at).collect(), triangles));
    let glass = world.find("glass").unwrap();
    for index in 0..4 {
        world.add_mesh("", Arc::clone(&mesh), glass, DVec3::Z * f64::from(index)).unwrap();
    }
    assert_eq!(bake(&world, &Carried::RGB).unwrap().shapes.instanced.instances().len(), 4);
    let name = world.entities().iter().filter_map(|it| it.get::<&Name>().map(|it| it.0.clone()));
    assert_eq!(name.filter(|name| name.starts_with("mesh ")).count(), 5);
}

#[test]
fn worlds_of_a_file_have_one_tree_even_if_they_are_made_at_once() {
    const THREADS: usize = 6;
    for _ in 0..8 {
        let file = SceneFile::read("scenes/cornell.gltf".as_ref(), false).unwrap();
        let start = Barrier::new(THREADS);
        let world = |grey: usize| {
            start.wait();
            let edit = Edit::new("materials/white/reflectance", 0.1 * grey as f64);
            file.world(&View::default(), &[edit]).unwrap()
        };
        let worlds: Vec<World> = thread::scope(|scope| {
            let made = (0..THREADS).map(|grey| scope.spawn(move || world(grey)));
            made.collect::<Vec<_>>().into_iter().map(|it| it.join().unwrap()).collect()
        });
        let mut worlds = worlds.into_iter();
        let placed = PlacedWorld::new(worlds.next().unwrap()).unwrap();
        assert!(worlds.all(|world| placed.shares_shapes(&world).unwrap()));
    }
}

#[test]
fn worlds_go_from_thread_to_thread() {
    fn is_sent<T: Send + Sync>(_: &T) {}
    is_sent(&room());
}

#[test]
fn shapes_look_outwards() {
    let cuboid = Geometry::cuboid(Vec3::splat(-1.0), Vec3::new(1.0, 2.0, 3.0));
    let mut area = 0.0;
    for triangle in &cuboid.triangles {
        let [a, b, c] = triangle.map(|row| cuboid.positions[row as usize]);
        let normal = (b - a).cross(c - a);
        let middle = (a + b + c) / 3.0 - Vec3::new(0.0, 0.5, 1.0);
        assert!(normal.dot(middle) > 0.0, "{triangle:?}");
        area += 0.5 * normal.length();
    }
    assert_eq!(area, 2.0 * (2.0 * 3.0 + 3.0 * 4.0 + 4.0 * 2.0));
    let place = Transform::looking(DVec3::X, DVec3::new(1.0, 2.0, 0.0), DVec3::Z * 3.0);
    assert!((place.0.transform_vector3(DVec3::NEG_Z) - DVec3::Y).length() < 1e-15);
    assert!((place.0.transform_vector3(DVec3::Y) - DVec3::Z).length() < 1e-15);
}

#[test]
fn skins() {
    let opaque = "an opaque surface has nothing behind it";
    let text = edited(|world| insert(world, "glass", Bsdf::diffuse(0.5)));
    has_all(&text, &["sphere `ball`, interior", opaque, "use a material that transmits"]);
    let text = edited(|world| {
        insert(world, "glass", Bsdf::Null);
        insert(world, "ball", Boundary::default());
    });
    has_all(&text, &["sphere `ball`: a null surface without media", "`interior`"]);

    let mut world = room();
    let [glow, glass, fog] = ["glow", "glass", "fog"].map(|name| world.find(name).unwrap());
    let mut add = |skin: Skin| match world.add_sphere("new", 1.0, skin, DVec3::ZERO) {
        Ok(_) => String::new(),
        Err(error) => error.to_string(),
    };
    has_all(&add(Skin::from(glow).exterior(Filling::Clear)), &["`new`, exterior", opaque]);
    has_all(&add(Skin::from(fog)), &["`new`, material", "not a material of this world"]);
    has_all(&add(Skin::from(glass).exterior(glow)), &["`new`, exterior", "not a medium of"]);
    has_all(&add(Skin::from(hecs::Entity::DANGLING)), &["`new`, material", "not a material"]);
    assert_eq!(add(Skin::from(glass).interior(fog).exterior(Filling::Clear)), "");
    let null = world.add_material("null", Bsdf::Null).unwrap();
    let error = world.add_sphere("new", 1.0, null, DVec3::ZERO).unwrap_err().to_string();
    has_all(&error, &["sphere `new`: a null surface without media"]);
}

#[test]
fn what_is_gone_is_missed() {
    let gone = edited(|world| despawn(world, "glass"));
    has_all(&gone, &["sphere `ball`, material is not a material of this world (any more)"]);
    let gone = edited(|world| remove::<Bsdf>(world, "glass"));
    has_all(&gone, &["sphere `ball`, material is not a material of this world"]);
    let gone = edited(|world| despawn(world, "fog"));
    has_all(&gone, &["sphere `ball`, interior is not a medium of this world (any more)"]);
    let gone = edited(|world| insert(world, "ball", MadeOf(world.find("eye").unwrap())));
    has_all(&gone, &["sphere `ball`, material"]);
    let gone = edited(|world| despawn(world, "eye"));
    has_all(&gone, &["camera: the world has no camera", "set_camera"]);
    assert!(edited(|world| world.entities_mut().clear()).contains("no camera"));

    type Edit = (fn(&mut World), &'static [&'static str]);
    let edits: [Edit; 9] = [
        (|w| remove::<Sides>(w, "glow"), &["material `glow`, Sides is missing", "a material ne"]),
        (|w| remove::<Order>(w, "ball"), &["sphere `ball`, Order is missing"]),
        (|w| remove::<Transform>(w, "ball"), &["sphere `ball`, Transform is missing"]),
        (|w| remove::<Boundary>(w, "panel"), &["mesh `panel`, Boundary is missing"]),
        (|w| remove::<MadeOf>(w, "panel"), &["mesh `panel`, MadeOf is missing"]),
        (|w| remove::<Name>(w, "lamp"), &["entity ", ", Name is missing"]),
        (|w| remove::<Transform>(w, "eye"), &["camera `eye`, Transform is missing"]),
        (|w| insert(w, "ball", Emission { radiance: 1.0.into() }), &["Emission means nothing"]),
        (|w| insert(w, "panel", Ball { radius: 1.0 }), &["is both a mesh and a sphere"]),
    ];
    for (edit, expected) in edits {
        has_all(&edited(edit), expected);
    }
}

#[test]
fn some_things_are_there_once() {
    let twice = |name: &str| {
        edited(|world| {
            let entity = world.find(name).unwrap();
            let (lens, place) = (Lens::pinhole(1.0), Transform::IDENTITY);
            let name = Name("another".to_owned());
            let is_camera = world.entities().satisfies::<&Lens>(entity);
            let entities = world.entities_mut();
            if is_camera {
                entities.spawn((Order(99), name, lens, place));
            } else {
                entities.spawn((Order(99), name, Environment::constant(1.0)));
            }
        })
    };
    has_all(
        &twice("eye"),
        &["another is one camera too many, after camera `eye`", "keep 1 at most"],
    );
    has_all(&twice("environment"), &["another is one environment too many, after environment"]);
    let text = edited(|world| {
        world.add_medium("haze", Medium::new(0.0, 0.0, Phase::isotropic())).unwrap();
        insert(world, "fog", FillsScene);
        insert(world, "haze", FillsScene);
    });
    has_all(&text, &["medium `haze` is one medium of the scene too many, after medium `fog`"]);
    let text = edited(|world| {
        for _ in 0..4096 {
            world.add_medium("", Medium::new(0.0, 1.0, Phase::isotropic())).unwrap();
        }
    });
    has_all(&text, &["keep 4096 at most"]);
}

#[test]
fn edits_of_a_file_are_refused_in_its_words() {
    let mut world = load_json(&room_file()).unwrap();
    insert(&mut world, "glow", Bsdf::diffuse(2.5));
    let text = refusal(&world);
    has_all(&text, &["scene.gltf: material 0 \"glow\", reflectance: 2.5 must be within [0, 1]"]);
    insert(&mut world, "glow", Bsdf::diffuse(0.25));
    let scene = bake(&world, &Carried::RGB).unwrap();
    assert_eq!(scene.optics.materials[0].model, SurfaceModel::Diffuse { reflectance: [0.25; 3] });
    // A file can be added to.
    let glow = world.find("glow").unwrap();
    world.add_sphere("moon", 0.1, glow, DVec3::X * 3.0).unwrap();
    assert_eq!(bake(&world, &Carried::RGB).unwrap().shapes.spheres.len(), 2);
}
