//! What files of Mitsuba 3 mean.

use std::f64::consts::PI;
use std::fs;
use std::path::Path;

use glam::Vec3;
use sunstone::internals::scene::baked::{BakedScene, NONE, Phase, Projection};
use sunstone::internals::scene::emitter::EmitterModel;
use sunstone::internals::scene::world::{Asked, Bsdf, Lens, SurfaceModel, Walk, World};
use sunstone::internals::scene::{Reading, SceneFile, View, Written, bake, load, load_with};
use sunstone::internals::spectrum::{Carried, Spectrum};

use crate::common::{load_bytes, scratch};

const GREEN: Carried<1> = Carried::at([550.0]);
const CAMERA: &str = "<sensor type='perspective'><film type='hdrfilm'><integer name='width' \
                      value='4'/><integer name='height' value='3'/><rfilter type='box'/></film>\
                      </sensor>";

/// A scene with a camera and what is given.
pub fn scene(body: &str) -> String {
    let light = "<emitter type='constant'/>";
    format!("<scene version='3.0.0'>{light}\n{CAMERA}\n{body}\n</scene>")
}

pub fn loaded(body: &str) -> World {
    load_bytes("scene.xml", scene(body).as_bytes()).unwrap_or_else(|error| panic!("{error}"))
}

fn baked(body: &str) -> BakedScene<1> {
    bake(&loaded(body), &GREEN).unwrap_or_else(|error| panic!("{error}"))
}

fn assert_near(a: Vec3, b: Vec3) {
    assert!((a - b).length() < 2e-6 * b.length().max(1.0), "{a} is not {b}");
}

#[test]
fn reference_scenes_are_those_of_gltf() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for name in ["brewster", "cornell", "mirror", "polarizers", "rayleigh", "tank"] {
        let path = root.join(format!("tests/data/images/{name}/scene.xml"));
        let world = load(&path).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(world.warnings(), [] as [String; 0], "{name}");
        let xml: BakedScene<1> = bake(&world, &GREEN).unwrap();
        let gltf = load(&root.join(format!("scenes/reference/{name}.gltf"))).unwrap();
        let gltf: BakedScene<1> = bake(&gltf, &GREEN).unwrap();
        compare(&xml, &gltf, name);
        let asked = world.asked();
        let edges = match name {
            "brewster" => 4,
            "polarizers" => 8,
            "rayleigh" => 20,
            "tank" => 40,
            _ => 12,
        };
        assert_eq!(asked.path_length_max, Some(edges), "{name}");
        assert_eq!((asked.roulette_after, asked.walk), (Some(100), Some(Walk::FromSensor)));
    }
}

#[test]
fn what_is_written_as_gltf_is_the_same_scene() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut lit = loaded(
        "<emitter type='point'><rgb name='intensity' value='4 5 6'/></emitter>\
         <emitter type='spot'><transform name='to_world'><lookat origin='0,5,0' target='1,0,0' \
         up='0,0,1'/></transform></emitter><shape type='cylinder'><bsdf type='thindielectric'/>\
         </shape><shape type='disk'><bsdf type='twosided'><bsdf type='conductor'>\
         <string name='material' value='Ag'/></bsdf></bsdf></shape>\
         <medium type='homogeneous' id='fog'><rgb name='albedo' value='0.2 0.3 0.4'/></medium>\
         <shape type='sphere'><bsdf type='null'/><ref name='interior' id='fog'/></shape>",
    );
    lit.set_analyzer(Some(sunstone::Analyzer::Linear { axis_deg: 30.0 })).unwrap();
    let mut worlds = vec![("lit", lit)];
    for name in ["brewster", "cornell", "mirror", "polarizers", "rayleigh"] {
        let path = root.join(format!("tests/data/images/{name}/scene.xml"));
        worlds.push((name, load(&path).unwrap_or_else(|error| panic!("{error}"))));
    }
    for (name, world) in worlds {
        let written = Written::of(&world).unwrap_or_else(|error| panic!("{error}"));
        let path = scratch("written.gltf");
        written.save(&path).unwrap();
        let again = load(&path).unwrap_or_else(|error| panic!("{name}: {error}"));
        fs::remove_file(&path).unwrap();
        let own: BakedScene<1> = bake(&world, &GREEN).unwrap();
        let other: BakedScene<1> = bake(&again, &GREEN).unwrap();
        compare(&own, &other, name);
        assert_eq!(own.camera.analyzer, other.camera.analyzer, "{name}");
    }
}

/// Whether two scenes are the same, but for the order of their materials and some last bits.
fn compare(a: &BakedScene<1>, b: &BakedScene<1>, name: &str) {
    let (shapes, others) = (&a.shapes, &b.shapes);
    assert_eq!(shapes.triangles.len(), others.triangles.len(), "{name}");
    let center = |origin: glam::DVec3, at: Vec3| (at.as_dvec3() + origin).as_vec3();
    for surface in 0..shapes.surfaces.len() as u32 {
        let (own, other) = (extent(a, surface), extent(b, surface));
        // Spheres are compared below.
        if own[0] == Vec3::INFINITY && other[0] == Vec3::INFINITY {
            continue;
        }
        own.into_iter().zip(other).for_each(|(own, other)| assert_near(own, other));
    }
    assert_eq!(shapes.shading_normals.len(), others.shading_normals.len(), "{name}");
    let normals = shapes.shading_normals.iter().zip(&others.shading_normals);
    for (own, other) in normals.flat_map(|(own, other)| own.iter().zip(other)) {
        assert_near(*own, *other);
    }
    for (own, other) in shapes.spheres.iter().zip(&others.spheres) {
        assert_near(center(shapes.origin, own.center), center(others.origin, other.center));
        assert!((own.radius - other.radius).abs() < 1e-6, "{name}");
    }
    assert_eq!(shapes.surfaces.len(), others.surfaces.len(), "{name}");
    for (own, other) in shapes.surfaces.iter().zip(&others.surfaces) {
        let (row, of) = (
            a.optics.materials[own.material as usize].clone(),
            b.optics.materials[other.material as usize].clone(),
        );
        assert_eq!(row.model, of.model, "{name}");
        assert!(row.two_sided == of.two_sided || row.model.transmits(), "{name}");
        assert_eq!((own.interior, own.exterior), (other.interior, other.exterior), "{name}");
        assert_near(own.axis_x, other.axis_x);
    }
    assert_eq!(a.optics.emitters.len(), b.optics.emitters.len(), "{name}");
    for index in 0..a.optics.emitters.len() {
        let [own, other] = [a, b].map(|it| it.optics.radiance_of(index)[0]);
        // Means over cones are of angles, which have single precision there.
        let by_angle = matches!(a.optics.emitters[index].model, EmitterModel::Patterned(_));
        let error = if by_angle { 2e-7 * own } else { 0.0 };
        assert!((own - other).abs() <= error, "{name}: {own} {other}");
    }
    for (own, other) in a.optics.media.iter().zip(&b.optics.media) {
        for (own, other) in [(own.sigma_a, other.sigma_a), (own.sigma_s, other.sigma_s)] {
            // It is a product here, and a number there.
            assert!((own[0] - other[0]).abs() <= 2e-6 * other[0], "{name}: {own:?} {other:?}");
        }
        assert_eq!(own.phase, other.phase, "{name}");
    }
    let (eye, other) = (&a.camera, &b.camera);
    assert_near(eye.position, other.position);
    assert_near(eye.forward, other.forward);
    assert_near(eye.right, other.right);
    assert_eq!((eye.projection, eye.resolution), (other.projection, other.resolution), "{name}");
}

/// The least and greatest corner of a surface, and its area along the axes.
fn extent(scene: &BakedScene<1>, surface: u32) -> [Vec3; 3] {
    let none = [Vec3::INFINITY, Vec3::NEG_INFINITY, Vec3::ZERO];
    let rows = scene.shapes.triangles.iter().zip(&scene.shapes.surface_of_primitive);
    rows.filter(|(_, of)| **of == surface).fold(none, |[low, high, area], (row, _)| {
        let corners = row.corners.map(|at| (at.as_dvec3() + scene.shapes.origin).as_vec3());
        let low = corners.into_iter().fold(low, Vec3::min);
        let high = corners.into_iter().fold(high, Vec3::max);
        let [a, b, c] = corners;
        // Fronts of cubes cancel, so each counts by itself.
        [low, high, area + (b - a).cross(c - a).max(Vec3::ZERO)]
    })
}

#[test]
fn steps_of_a_transform_follow_one_another() {
    let sphere = "<shape type='sphere'><point name='center' x='1' y='0' z='0'/>\
                  <transform name='to_world'><scale value='2'/><rotate z='1' angle='90'/>\
                  <translate x='5'/><matrix value='0 1 0 0  1 0 0 0  0 0 1 3  0 0 0 1'/>\
                  </transform></shape>";
    let scene = baked(sphere);
    let place = scene.shapes.spheres[0].center.as_dvec3() + scene.shapes.origin;
    // (1, 0, 0) becomes (2, 0, 0), (0, 2, 0), (5, 2, 0), (2, 5, 3).
    assert_near(place.as_vec3(), Vec3::new(2.0, 5.0, 3.0));
    assert_eq!(scene.shapes.spheres[0].radius, 2.0);
}

#[test]
fn cameras_have_their_angle_along_the_axis_that_is_named() {
    let lens = |properties: &str| {
        let text = format!(
            "<scene version='3.0.0'><sensor type='perspective'>{properties}<film type='hdrfilm'>\
             <integer name='width' value='40'/><integer name='height' value='30'/>\
             <rfilter type='box'/></film></sensor></scene>"
        );
        let world = load_bytes("lens.xml", text.as_bytes()).unwrap_or_else(|e| panic!("{e}"));
        let mut query = world.entities().query::<&Lens>();
        let lens = *query.iter().next().unwrap();
        let Lens::Perspective { yfov, .. } = lens else { panic!("{lens:?}") };
        (0.5 * yfov).tan()
    };
    let tan = |degrees: f64| (0.5 * degrees.to_radians()).tan();
    let axis = |axis: &str| {
        let axis = format!("<string name='fov_axis' value='{axis}'/>");
        lens(&format!("<float name='fov' value='50'/>{axis}"))
    };
    let near = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-12, "{a} is not {b}");
    for wide in ["x", "larger"] {
        near(axis(wide), 0.75 * tan(50.0));
    }
    for high in ["y", "smaller"] {
        near(axis(high), tan(50.0));
    }
    near(axis("diagonal"), 0.6 * tan(50.0));
    near(lens("<float name='fov' value='50'/>"), 0.75 * tan(50.0));
    // 36 by 24 mm have a diagonal of 43.27 mm.
    let diagonal = (36.0_f64.powi(2) + 24.0_f64.powi(2)).sqrt();
    near(lens("<string name='focal_length' value='35mm'/>"), 0.6 * 0.5 * diagonal / 35.0);
    near(lens(""), 0.6 * 0.5 * diagonal / 50.0);
}

#[test]
fn parallel_cameras_see_what_their_scale_says() {
    let text = "<scene version='3.0.0'><sensor type='orthographic'><transform name='to_world'>\
                <scale x='2' y='2' z='7'/><lookat origin='0,0,9' target='0,0,0' up='0,1,0'/>\
                </transform><film type='hdrfilm'><integer name='width' value='40'/>\
                <integer name='height' value='30'/><rfilter type='box'/></film></sensor></scene>";
    let world = load_bytes("parallel.xml", text.as_bytes()).unwrap_or_else(|e| panic!("{e}"));
    let mut query = world.entities().query::<&Lens>();
    let expected = Lens::Orthographic { half_width: 2.0, half_height: 1.5 };
    assert_eq!(query.iter().next(), Some(&expected));
}

#[test]
fn what_is_not_said_is_as_in_mitsuba() {
    let world = loaded(
        "<shape type='rectangle'/><shape type='cube'><bsdf type='dielectric'/></shape>\
         <shape type='sphere'><bsdf type='conductor'/></shape>\
         <shape type='rectangle'><emitter type='area'/></shape>",
    );
    let scene: BakedScene<1> = bake(&world, &GREEN).unwrap();
    let models: Vec<_> = scene.optics.materials.iter().map(|row| row.model.clone()).collect();
    assert_eq!(models[0], SurfaceModel::Diffuse { reflectance: [0.5] });
    assert_eq!(models[1], SurfaceModel::Dielectric { ior: 1.5046, exterior_ior: 1.000_277 });
    let SurfaceModel::Conductor { eta: [eta], k: [k] } = models[2] else { panic!("{models:?}") };
    let reflectance = ((eta - 1.0).powi(2) + k * k) / ((eta + 1.0).powi(2) + k * k);
    assert!((reflectance - 1.0).abs() < 1e-6, "{reflectance}");
    assert_eq!((models[3].clone(), scene.optics.radiance_of(0)), (SurfaceModel::Absorber, [1.0]));
    assert_eq!(*world.asked(), Asked::default());
}

#[test]
fn parameters_come_from_outside_or_from_their_defaults() {
    let text = scene(
        "<default name='r' value='0.25'/><default name='rad' value='3'/>\
         <shape type='sphere'><float name='radius' value='$rad'/><bsdf type='diffuse'>\
         <rgb name='reflectance' value='$r, 0.$digit, $r'/></bsdf></shape>\
         <default name='digit' value='5'/>",
    );
    let text =
        text.replace("<default name='r'", "<default name='digit' value='5'/><default name='r'");
    let path = scratch("parameters.xml");
    fs::write(&path, text).unwrap();
    let reflectance = |definitions: &[(&str, &str)]| {
        let own = |(name, value): &(&str, &str)| ((*name).to_owned(), (*value).to_owned());
        let definitions: Vec<_> = definitions.iter().map(own).collect();
        let reading = Reading { definitions, ..Reading::default() };
        let world = load_with(&path, &reading).map_err(|error| error.to_string())?;
        let mut query = world.entities().query::<&Bsdf>();
        Ok::<Bsdf, String>(query.iter().next().unwrap().clone())
    };
    let diffuse = |rgb: [f32; 3]| Ok(Bsdf::Diffuse { reflectance: Spectrum::Rgb(rgb) });
    assert_eq!(reflectance(&[]), diffuse([0.25, 0.5, 0.25]));
    assert_eq!(reflectance(&[("r", "0.75"), ("digit", "125")]), diffuse([0.75, 0.125, 0.75]));
    let error = reflectance(&[("radius", "1")]).unwrap_err();
    assert!(error.contains("no parameter `radius`") && error.contains("digit, r, rad"), "{error}");
    let file = SceneFile::read(&path, false).unwrap();
    let edit = sunstone::internals::scene::Edit::new("materials/a/ior", 1.5);
    let error = file.world(&View::default(), &[edit]).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("cannot be edited by name"), "{error}");
    fs::remove_file(&path).unwrap();
}

#[test]
fn files_are_included_with_what_is_in_them() {
    let folder = scratch("included");
    fs::create_dir_all(folder.join("parts")).unwrap();
    let write = |name: &str, text: &str| fs::write(folder.join(name), text).unwrap();
    write(
        "parts/red.xml",
        "<bsdf version='3.0.0' type='diffuse' id='red'>\
                            <rgb name='reflectance' value='0.7 0.1 0.1'/></bsdf>",
    );
    write(
        "parts/all.xml",
        "<scene version='3.0.0'><include filename='red.xml'/>\
                            <default name='size' value='4'/>\
                            <shape type='obj'><string name='filename' value='tri.obj'/>\
                            <ref id='red'/></shape></scene>",
    );
    write("parts/tri.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    write(
        "scene.xml",
        &scene(
            "<path value='parts'/><include filename='parts/all.xml'/>\
                               <shape type='sphere'><float name='radius' value='$size'/>\
                               <ref name='bsdf' id='red'/></shape>",
        ),
    );
    let path = folder.join("scene.xml");
    let world = load(&path).unwrap_or_else(|error| panic!("{error}"));
    let text = world.describe();
    assert!(text.contains("1 triangle in 1 mesh part, 1 analytic sphere"), "{text}");
    assert!(text.contains("parts/red.xml, line 1, bsdf \"red\" (diffuse)"), "{text}");
    assert!(text.contains("[0.7, 0.1, 0.1]; on 2 shapes"), "{text}");
    assert_eq!(world.files().len(), 4, "all that was read can be watched");

    write("parts/all.xml", "<scene version='3.0.0'><include filename='all.xml'/></scene>");
    let error = load(&path).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("too many files are included"), "{error}");
    write(
        "parts/all.xml",
        "<scene version='3.0.0'><default name='size' value='1'/>\n<shape type='rect'/>\
         <bsdf type='null' id='red'/></scene>",
    );
    let error = load(&path).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("parts/all.xml, line 2, shape (rect): `rect` is not"), "{error}");
    fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn media_stand_on_the_sides_that_are_named() {
    let scene = baked(
        "<medium type='homogeneous' id='fog'><float name='sigma_t' value='2'/>\
         <float name='albedo' value='0.25'/><float name='scale' value='3'/>\
         <phase type='hg'><float name='g' value='0.5'/></phase></medium>\
         <shape type='sphere'><bsdf type='null'/><ref name='interior' id='fog'/></shape>",
    );
    let medium = &scene.optics.media[0];
    assert_eq!((medium.sigma_a, medium.sigma_s), ([4.5], [1.5]));
    assert_eq!(medium.phase, Phase::HenyeyGreenstein { g: [0.5] });
    let surface = scene.shapes.surfaces[0];
    assert_eq!((surface.interior, surface.exterior), (0, NONE));
}

#[test]
fn media_of_opaque_surfaces_are_ignored_with_a_word() {
    let world = loaded(
        "<medium type='homogeneous' id='fog'/><shape type='sphere'><bsdf type='diffuse'/>\
         <ref name='exterior' id='fog'/></shape>",
    );
    assert!(world.warnings()[0].contains("media of opaque surfaces are ignored"));
    assert!(bake::<1>(&world, &GREEN).is_ok());
}

#[test]
fn spectra_are_seen_in_rgb_as_the_observer_sees_them() {
    let world = loaded(
        "<shape type='rectangle'><bsdf type='diffuse'><spectrum name='reflectance' \
         value='300:0.5, 900:0.5'/></bsdf></shape>\
         <shape type='rectangle'><emitter type='area'><spectrum name='radiance' value='2'/>\
         </emitter></shape><shape type='rectangle'><emitter type='area'>\
         <spectrum name='radiance' type='d65'><float name='scale' value='3'/></spectrum>\
         </emitter></shape>",
    );
    let scene: BakedScene<3> = bake(&world, &Carried::RGB).unwrap();
    let SurfaceModel::Diffuse { reflectance } = scene.optics.materials[0].model else {
        panic!("it is diffuse")
    };
    let near = |a: [f32; 3], b: [f64; 3]| {
        let is = a.into_iter().zip(b).all(|(a, b)| (f64::from(a) - b).abs() < 2e-3 * b);
        assert!(is, "{a:?} is not {b:?}");
    };
    near(reflectance, [0.5; 3]);
    // Sums of the rows of the matrix from XYZ to linear sRGB, IEC 61966-2-1, for equal energy.
    let flat = [3.2406 - 1.5372 - 0.4986, -0.9689 + 1.8758 + 0.0415, 0.0557 - 0.2040 + 1.0570];
    let radiance = |index| scene.optics.radiance_of(index);
    let lamps: Vec<[f32; 3]> = (0..scene.optics.emitters.len()).map(radiance).collect();
    near(*lamps.iter().find(|rgb| rgb[0] > 2.1 && rgb[0] < 2.9).unwrap(), flat.map(|x| 2.0 * x));
    assert!(lamps.contains(&[3.0; 3]), "{lamps:?}");
    let mono: BakedScene<1> = bake(&world, &GREEN).unwrap();
    let lamps = (0..mono.optics.emitters.len()).map(|index| mono.optics.radiance_of(index));
    assert!(lamps.into_iter().any(|lamp| lamp == [2.0]));
}

#[test]
fn spectra_at_even_steps_are_those_at_the_wavelengths_named() {
    let of = |spectrum: &str| {
        let bsdf = format!("<bsdf type='diffuse'>{spectrum}</spectrum></bsdf>");
        baked(&format!("<shape type='sphere'>{bsdf}</shape>")).optics.materials[0].model.clone()
    };
    let values = "<string name='values' value='0.25, 0.75, 0.5'/>";
    let even = of(&format!(
        "<spectrum type='regular' name='reflectance'><float name='wavelength_min' value='500'/>\
         <float name='wavelength_max' value='600'/>{values}"
    ));
    let named = of(&format!(
        "<spectrum type='irregular' name='reflectance'><string name='wavelengths' \
         value='500, 550, 600'/>{values}"
    ));
    assert_eq!(even, SurfaceModel::Diffuse { reflectance: [0.75] });
    assert_eq!(even, named);
}

#[test]
fn instances_put_groups_in_places() {
    let scene = baked(
        "<shape type='shapegroup' id='pair'><shape type='sphere'/><shape type='sphere'>\
         <point name='center' x='3' y='0' z='0'/></shape></shape>\
         <shape type='instance'><ref id='pair'/><transform name='to_world'>\
         <scale value='2'/><translate y='1'/></transform></shape>\
         <shape type='instance'><ref id='pair'/></shape>",
    );
    let places = scene.shapes.spheres.iter().map(|sphere| {
        let place = (sphere.center.as_dvec3() + scene.shapes.origin).as_vec3();
        (place.round().to_array(), sphere.radius)
    });
    let expected = [
        ([0.0, 1.0, 0.0], 2.0),
        ([6.0, 1.0, 0.0], 2.0),
        ([0.0, 0.0, 0.0], 1.0),
        ([3.0, 0.0, 0.0], 1.0),
    ];
    assert_eq!(places.collect::<Vec<_>>(), expected);
}

#[test]
fn disks_and_cylinders_have_the_area_of_what_they_stand_for() {
    let area = |body: &str| {
        let scene = baked(body);
        let triangles = scene.shapes.triangles.iter();
        let area = |[a, b, c]: [Vec3; 3]| 0.5 * (b - a).cross(c - a).as_dvec3().length();
        triangles.map(|row| area(row.corners)).sum::<f64>()
    };
    assert!((area("<shape type='disk'/>") / PI - 1.0).abs() < 1e-6);
    let cylinder = "<shape type='cylinder'><float name='radius' value='2'/>\
                    <point name='p0' value='1'/><point name='p1' x='1' y='4' z='5'/></shape>";
    assert!((area(cylinder) / (2.0 * PI * 2.0 * 5.0) - 1.0).abs() < 2e-4);
}

#[test]
fn lights_shine_where_mitsuba_has_them_shine() {
    let world = loaded(
        "<emitter type='point'><point name='position' x='1' y='2' z='3'/>\
         <rgb name='intensity' value='4 5 6'/></emitter>\
         <emitter type='directional'><vector name='direction' x='0' y='-2' z='0'/>\
         <float name='irradiance' value='7'/></emitter>\
         <emitter type='spot'><transform name='to_world'><lookat origin='0,5,0' target='0,0,0' \
         up='0,0,1'/></transform><float name='beam_width' value='20'/>\
         <float name='cutoff_angle' value='20'/></emitter>\
         <shape type='sphere'/>",
    );
    let scene: BakedScene<3> = bake(&world, &Carried::RGB).unwrap();
    let place = |at: Vec3| (at.as_dvec3() + scene.shapes.origin).as_vec3();
    for (index, emitter) in scene.optics.emitters.iter().enumerate() {
        let radiance = scene.optics.radiance_of(index);
        match &emitter.model {
            EmitterModel::Point(it) => {
                assert_near(place(it.position), Vec3::new(1.0, 2.0, 3.0));
                assert_eq!(radiance, [4.0, 5.0, 6.0]);
            }
            EmitterModel::Spot(it) => {
                assert_near(place(it.position), Vec3::Y * 5.0);
                assert_near(it.direction, Vec3::NEG_Y);
                assert!((it.cos_outer - 20_f32.to_radians().cos()).abs() < 1e-3);
            }
            EmitterModel::Directional(it) => {
                assert_near(it.direction, Vec3::NEG_Y);
                assert_eq!(radiance, [7.0; 3]);
            }
            EmitterModel::Environment(_) => assert_eq!(radiance, [1.0; 3]),
            EmitterModel::Triangle(_)
            | EmitterModel::Sphere(_)
            | EmitterModel::Patterned(_)
            | EmitterModel::Sun(_)
            | EmitterModel::Panorama(_) => panic!("none was asked for"),
        }
    }
    assert_eq!(scene.optics.emitters.len(), 4);
}

#[test]
fn the_wanted_camera_is_taken() {
    let text = "<scene version='3.0.0'><sensor type='orthographic' id='a'/>\
                <sensor type='perspective' id='b'/><emitter type='constant'/></scene>";
    let path = scratch("cameras.xml");
    fs::write(&path, text).unwrap();
    let is_parallel = |camera: Option<&str>| {
        let view = camera.map_or_else(View::default, View::by);
        let world = load_with(&path, &Reading { view, ..Reading::default() });
        let world = world.map_err(|error| error.to_string())?;
        let scene: BakedScene<1> = bake(&world, &GREEN).map_err(|error| error.to_string())?;
        Ok::<bool, String>(matches!(scene.camera.projection, Projection::Orthographic { .. }))
    };
    for (camera, expected) in [
        (None, true),
        (Some("a"), true),
        (Some("#0"), true),
        (Some("b"), false),
        (Some("1"), false),
    ] {
        assert_eq!(is_parallel(camera), Ok(expected), "{camera:?}");
    }
    let error = is_parallel(Some("c")).unwrap_err();
    assert!(error.contains("no camera is called `c`") && error.contains("#0 a, #1 b"), "{error}");
    fs::remove_file(&path).unwrap();
}

#[test]
fn names_of_old_versions_are_understood() {
    let text = scene(
        "<shape type='sphere'><transform name='toWorld'><scale value='2'/></transform>\
                      <boolean name='flipNormals' value='false'/></shape>",
    );
    let text = text.replace("3.0.0", "0.6.0");
    let world = load_bytes("old.xml", text.as_bytes()).unwrap_or_else(|error| panic!("{error}"));
    let scene: BakedScene<1> = bake(&world, &GREEN).unwrap();
    assert_eq!(scene.shapes.spheres[0].radius, 2.0);
}
