//! Textures of Mitsuba 3: what they feed, and how they lie on its shapes. Values at points have
//! been measured with Mitsuba 3.9.1 (`eval` of textures, `ray_intersect` of shapes).

use std::fs;
use std::path::PathBuf;

use glam::{DVec3, Vec2, Vec3};
use sunstone::internals::image::texels::Coding;
use sunstone::internals::scene::world::{Mesh, World};
use sunstone::internals::scene::{bake, load};
use sunstone::internals::spectrum::Carried;
use sunstone::world::{
    Bsdf, Emission, Filter, Parameter, Reads, ReliefFrame, ReliefOf, Stain, Texture, Textures,
    Transform, Wrap,
};

use crate::common::{load_bytes, scratch};
use crate::mitsuba::{loaded, scene};

const CHECKERS: &str = "<texture type='checkerboard' name='reflectance'>\
                        <float name='color0' value='0.1'/><float name='color1' value='0.7'/>";

/// A square of a diffuse texture.
fn square(texture: &str) -> String {
    format!("<shape type='rectangle'><bsdf type='diffuse'>{texture}</bsdf></shape>")
}

fn painted(world: &World) -> Textures {
    let mut query = world.entities().query::<&Textures>();
    query.iter().next().cloned().expect("a material is painted")
}

fn reflectance(world: &World) -> Texture {
    let textures = painted(world);
    let (parameter, paint) = &textures.parameters[0];
    assert_eq!((*parameter, paint.reads), (Parameter::Reflectance, Reads::Color));
    paint.texture.clone().expect("by a picture")
}

/// A folder for the files of a test.
fn folder(name: &str) -> PathBuf {
    let folder = scratch(name);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// A picture of 2 x 2 texels beside a scene that refers to it by `b.png`.
fn with_picture(name: &str, body: &str) -> Result<World, String> {
    let folder = folder(name);
    let texels = [[255_u8, 0, 0], [0, 255, 0], [0, 0, 255], [188, 188, 188]];
    let picture =
        image::ImageBuffer::from_fn(2, 2, |x, y| image::Rgb(texels[(2 * y + x) as usize]));
    picture.save(folder.join("b.png")).unwrap();
    let path = folder.join("scene.xml");
    fs::write(&path, scene(body)).unwrap();
    load(&path).map_err(|error| error.to_string())
}

#[test]
fn checkerboards_have_the_values_that_mitsuba_says() {
    let cases = [
        ("", [0.1, 0.7, 0.7, 0.1, 0.7, 0.1]),
        (
            "<transform name='to_uv'><translate x='0.5'/></transform>",
            [0.7, 0.1, 0.1, 0.7, 0.1, 0.7],
        ),
    ];
    for (transform, expected) in cases {
        let texture = reflectance(&loaded(&square(&format!("{CHECKERS}{transform}</texture>"))));
        let places =
            [[0.25, 0.25], [0.75, 0.25], [0.25, 0.75], [0.75, 0.75], [-0.25, 0.25], [1.25, 0.25]];
        let found = places.map(|place| texture.at(Vec2::from(place))[0]);
        assert_eq!(found, expected, "{transform}");
    }
}

/// As `eval_1` says, which has the colors of `eval` the other way round.
#[test]
fn checkerboards_of_numbers_are_those_that_mitsuba_says() {
    let board = |name: &str| CHECKERS.replace("name='reflectance'", &format!("name='{name}'"));
    let inner = "<bsdf type='diffuse'/>";
    let alpha = format!("<bsdf type='roughconductor'>{}</texture></bsdf>", board("alpha"));
    let mask = format!("<bsdf type='mask'>{}</texture>{inner}</bsdf>", board("opacity"));
    let weight =
        format!("<bsdf type='blendbsdf'>{}</texture>{inner}{inner}</bsdf>", board("weight"));
    for bsdf in [alpha, mask, weight] {
        let textures = painted(&loaded(&format!("<shape type='rectangle'>{bsdf}</shape>")));
        let paint = textures.paints().next().expect("it is painted");
        let texture = paint.texture.as_ref().expect("by a picture");
        let places = [[0.25, 0.25], [0.75, 0.25], [0.25, 0.75], [0.75, 0.75]];
        let found = places.map(|place| paint.color(texture.at(Vec2::from(place)))[0]);
        assert_eq!(found, [0.7, 0.1, 0.1, 0.7], "{bsdf}");
    }
}

#[test]
fn colors_of_glass_and_metal_are_read() {
    let load = |bsdf: &str| with_picture("stains", &format!("<shape type='sphere'>{bsdf}</shape>"));
    let rgb = |name: &str| format!("<rgb name='{name}' value='0.2, 0.5, 0.9'/>");
    let bitmap = |name: &str| {
        format!(
            "<texture type='bitmap' name='{name}'><string name='filename' value='b.png'/></texture>"
        )
    };
    let [reflectance, transmittance] = ["specular_reflectance", "specular_transmittance"];
    for kind in ["dielectric", "thindielectric", "roughdielectric"] {
        let inner = rgb(reflectance) + &bitmap(transmittance);
        let textures = painted(&load(&format!("<bsdf type='{kind}'>{inner}</bsdf>")).unwrap());
        let reflected = textures.stain.reflected.expect("it is stated");
        assert_eq!((reflected.factor, reflected.texture), ([0.2, 0.5, 0.9], None), "{kind}");
        let transmitted = textures.stain.transmitted.expect("it is stated");
        assert_eq!((transmitted.factor, transmitted.reads), ([1.0; 3], Reads::Color), "{kind}");
        let size = transmitted.texture.map(|texture| texture.picture.texels().size());
        assert_eq!(size, Some([2, 2]), "{kind}");
    }
    for kind in ["conductor", "roughconductor"] {
        let bsdf = format!("<bsdf type='{kind}'>{}</bsdf>", bitmap(reflectance));
        let Stain { reflected, transmitted } = painted(&load(&bsdf).unwrap()).stain;
        assert!(reflected.is_some() && transmitted.is_none(), "{kind}");
        let bsdf = format!("<bsdf type='{kind}'>{}</bsdf>", rgb(transmittance));
        assert!(load(&bsdf).unwrap_err().contains("is no property"), "{kind}");
    }
    let more = "<bsdf type='dielectric'><float name='specular_transmittance' value='1.5'/></bsdf>";
    assert!(load(more).unwrap_err().contains("must be within [0, 1]"));
    let table = "<spectrum name='specular_transmittance' value='400:0.1, 700:0.9'/>";
    let error = load(&format!("<bsdf type='dielectric'>{table}</bsdf>")).unwrap_err();
    assert!(error.contains("is given by wavelength"), "{error}");
}

#[test]
fn bitmaps_have_the_values_that_mitsuba_says() {
    let texture = |inner: &str| {
        let body = format!(
            "<texture type='bitmap' name='reflectance'>{inner}\
            <string name='filename' value='b.png'/></texture>"
        );
        reflectance(&with_picture("bitmap_values", &square(&body)).unwrap())
    };
    let raw = "<boolean name='raw' value='true'/>";
    let nearest = format!("{raw}<string name='filter_type' value='nearest'/>");
    let [red, green, blue] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let grey = [188.0 / 255.0; 3];
    let cases = [
        ("", [red, green, blue, grey]),
        ("<translate x='0.5'/>", [green, red, grey, blue]),
        ("<translate y='0.25'/>", [blue, grey, red, green]),
        ("<scale value='2'/>", [blue; 4]),
        ("<rotate z='1' angle='90'/>", [green, grey, red, blue]),
        ("<scale value='0.5'/><translate x='0.5'/>", [green; 4]),
    ];
    for (steps, expected) in cases {
        let steps = format!("{nearest}<transform name='to_uv'>{steps}</transform>");
        let texture = texture(&steps);
        let places = [[0.2, 0.3], [0.7, 0.3], [0.2, 0.8], [0.7, 0.8]];
        let found = places.map(|place| texture.at(Vec2::from(place)));
        assert_eq!(found.map(|[r, g, b, _]| [r, g, b]), expected, "{steps}");
    }
    // Red at v = 1/4, between the two texels and beyond the edges.
    let red_at = |wrap: &str, expected: [f32; 5]| {
        let texture = texture(&format!("{raw}<string name='wrap_mode' value='{wrap}'/>"));
        for (u, expected) in [0.5, 1.1, -0.1, 1.6, 0.05].into_iter().zip(expected) {
            let red = texture.at(Vec2::new(u, 0.25))[0];
            assert!((red - expected).abs() < 1e-5, "{wrap}, {u}: {red}");
        }
    };
    red_at("repeat", [0.5, 0.7, 0.3, 0.3, 0.6]);
    red_at("mirror", [0.5, 0.0, 1.0, 0.7, 1.0]);
    red_at("clamp", [0.5, 0.0, 1.0, 0.0, 1.0]);
    let decoded = texture("");
    assert_eq!((decoded.coding, decoded.filter), (Coding::Srgb, Filter::Linear));
    assert_eq!((decoded.wrap, texture(raw).coding), ([Wrap::Repeat; 2], Coding::Linear));
}

#[test]
fn coordinates_of_shapes_are_those_that_mitsuba_says() {
    // A point of the shape, and u and v there.
    type At = ([f64; 3], [f32; 2]);
    let cases: [(&str, &str, &[At]); 5] = [
        ("rectangle", "", &[([-0.5, -0.25, 0.0], [0.25, 0.375])]),
        ("disk", "", &[([0.5, 0.1, 0.0], [0.5099, 0.0314]), ([-0.2, -0.5, 0.0], [0.5385, 0.6894])]),
        (
            "sphere",
            "",
            &[
                ([0.3, 0.2, 0.93274], [0.0936, 0.1174]),
                ([-0.89443, 0.2, 0.4], [0.465, 0.369]),
                ([0.1, -0.91104, 0.4], [0.7674, 0.369]),
            ],
        ),
        (
            "cylinder",
            "",
            &[([0.9798, 0.2, 0.3], [0.032, 0.3]), ([0.2, -0.9798, 0.7], [0.782, 0.7])],
        ),
        (
            "cube",
            "",
            &[
                ([0.5, 0.2, 1.0], [0.6, 0.75]),
                ([0.5, 0.2, -1.0], [0.4, 0.75]),
                ([1.0, 0.5, 0.2], [0.75, 0.4]),
                ([-1.0, 0.5, 0.2], [0.75, 0.6]),
                ([0.5, 1.0, 0.2], [0.25, 0.4]),
                ([0.5, -1.0, 0.2], [0.6, 0.75]),
            ],
        ),
    ];
    for (shape, inner, points) in cases {
        let bsdf = format!("<bsdf type='diffuse'>{CHECKERS}</texture></bsdf>");
        let world = loaded(&format!("<shape type='{shape}'>{inner}{bsdf}</shape>"));
        for (point, expected) in points {
            let found = coordinates_at(&world, DVec3::from(*point));
            let error = (found - Vec2::from(*expected)).abs().max_element();
            // What 256 corners leave: half of one of them, at the middle of a disk.
            assert!(error < 2.5e-3, "{shape} at {point:?}: {found}, not {expected:?}");
        }
    }
}

/// Texture coordinates of the only shape of a world, where its surface is next to a point.
fn coordinates_at(world: &World, point: DVec3) -> Vec2 {
    let mut query = world.entities().query::<(&Mesh, &Transform)>();
    let Some((mesh, place)) = query.iter().next() else {
        let baked = bake::<1>(world, &Carried::at([550.0])).expect("it has a sphere");
        let at = (point - baked.shapes.origin).as_vec3();
        let on = baked.shapes.painted(0).expect("it is the only one");
        return on.coordinates(0, on.weights_at(at));
    };
    let geometry = &mesh.0;
    let mut best = (f64::INFINITY, Vec2::ZERO);
    for triangle in &geometry.triangles {
        let corner =
            |row: u32| place.0.transform_point3(geometry.positions[row as usize].as_dvec3());
        let [a, b, c] = triangle.map(corner);
        let normal = (b - a).cross(c - a);
        let weight = |from: DVec3, to: DVec3| {
            (to - from).cross(point - from).dot(normal) / normal.length_squared()
        };
        let weights = [weight(b, c), weight(c, a), weight(a, b)];
        let distance = (point - a).dot(normal.normalize()).abs();
        let outside = weights.into_iter().fold(0.0, |worst: f64, it| worst.max(-it));
        if distance + 1e3 * outside < best.0 {
            let pairs = triangle.map(|row| geometry.texture_coordinates[row as usize]);
            let mixed = pairs.iter().zip(weights).map(|(pair, weight)| *pair * weight as f32);
            best = (distance + 1e3 * outside, mixed.fold(Vec2::ZERO, |a, b| a + b));
        }
    }
    best.1
}

#[test]
fn coordinates_of_files_are_read() {
    let folder = folder("coordinates");
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.1 0.2\nvt 0.3 0.4 0\nvt 0.5 0.6\nf 1/1 2/2 3/3\n";
    fs::write(folder.join("a.obj"), obj).unwrap();
    for (name, [u, v]) in [("b.ply", ["u", "v"]), ("c.ply", ["s", "t"])] {
        let ply = format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
             property float z\nproperty float {u}\nproperty float {v}\nelement face 1\nproperty \
             list uchar int vertex_indices\nend_header\n0 0 0 0.1 0.2\n1 0 0 0.3 0.4\n0 1 0 0.5 \
             0.6\n3 0 1 2\n"
        );
        fs::write(folder.join(name), ply).unwrap();
    }
    let of_files = [Vec2::new(0.1, 0.2), Vec2::new(0.3, 0.4), Vec2::new(0.5, 0.6)];
    let mirrored = of_files.map(|pair| Vec2::new(pair.x, 1.0 - pair.y));
    let flip = |on: bool| format!("<boolean name='flip_tex_coords' value='{on}'/>");
    let cases = [
        ("obj", "a.obj", String::new(), mirrored),
        ("obj", "a.obj", flip(false), of_files),
        ("ply", "b.ply", String::new(), of_files),
        ("ply", "c.ply", String::new(), of_files),
        ("ply", "c.ply", flip(true), mirrored),
    ];
    for (kind, file, inner, expected) in cases {
        let path = folder.join("scene.xml");
        let body = format!(
            "<shape type='{kind}'>{inner}<string name='filename' value='{file}'/>\
            <bsdf type='diffuse'>{CHECKERS}</texture></bsdf></shape>"
        );
        fs::write(&path, scene(&body)).unwrap();
        let world = load(&path).unwrap_or_else(|error| panic!("{error}"));
        let mut query = world.entities().query::<&Mesh>();
        let mesh = query.iter().next().unwrap();
        assert_eq!(mesh.0.texture_coordinates, expected, "{file} {inner}");
    }
}

#[test]
fn all_that_is_painted_is() {
    let bitmap = |name: &str, inner: &str| {
        format!(
            "<texture type='bitmap' name='{name}'>{inner}<string name='filename' \
            value='b.png'/></texture>"
        )
    };
    let raw = "<boolean name='raw' value='true'/>";
    let body = |bsdf: String| format!("<shape type='rectangle'>{bsdf}</shape>");
    let load = |bsdf: String| with_picture("all_painted", &body(bsdf)).unwrap();
    for (kind, field) in
        [("plastic", "diffuse"), ("roughplastic", "diffuse"), ("pplastic", "diffuse")]
    {
        let name = format!("{field}_reflectance");
        let world = load(format!("<bsdf type='{kind}'>{}</bsdf>", bitmap(&name, "")));
        assert!(reflectance(&world).picture.texels().size() == [2, 2], "{kind}");
    }
    for kind in ["roughconductor", "roughdielectric"] {
        let world = load(format!("<bsdf type='{kind}'>{}</bsdf>", bitmap("alpha", raw)));
        let textures = painted(&world);
        let (parameter, paint) = &textures.parameters[0];
        assert_eq!((*parameter, paint.reads), (Parameter::Alpha, Reads::Luminance), "{kind}");
        let green = paint.color(paint.texture.as_ref().unwrap().at(Vec2::new(0.75, 0.25)))[0];
        assert!((green - 0.715_2).abs() < 1e-6, "{green}");
        let baked = bake::<1>(&world, &Carried::at([550.0]));
        baked.unwrap_or_else(|error| panic!("{kind}: {error}"));
    }
    let inner = "<bsdf type='twosided'><bsdf type='diffuse'/></bsdf>";
    let world = load(format!("<bsdf type='mask'>{}{inner}</bsdf>", bitmap("opacity", raw)));
    let coverage = painted(&world).coverage.expect("it has holes");
    assert_eq!((coverage.cutoff, coverage.paint.reads), (None, Reads::Luminance));
    let world =
        load(format!("<bsdf type='mask'><float name='opacity' value='0.25'/>{inner}</bsdf>"));
    assert_eq!(painted(&world).coverage.unwrap().paint.factor, [0.25; 3]);
    let relief = load(format!("<bsdf type='normalmap'>{}{inner}</bsdf>", bitmap("normalmap", raw)));
    let relief = painted(&relief).relief.expect("it has normals of its own");
    assert_eq!((relief.of, relief.scale), (ReliefOf::Normals(ReliefFrame::Mesh), 1.0));
    // The texture has any name.
    let scale = "<float name='scale' value='0.25'/>";
    let raised =
        load(format!("<bsdf type='bumpmap'>{scale}{}{inner}</bsdf>", bitmap("bricks", raw)));
    let relief = painted(&raised).relief.expect("it is raised");
    assert_eq!((relief.of, relief.scale), (ReliefOf::Heights(Reads::Luminance), 0.25));
    let world = load(format!("<emitter type='area'>{}</emitter>", bitmap("radiance", "")));
    assert!(painted(&world).emission.is_some());
    let material = world.entities().query::<(&Bsdf, &Emission)>().iter().count();
    assert_eq!(material, 1);
}

#[test]
fn normals_go_by_the_coordinates_of_the_mesh() {
    // Right is where u grows, whatever turns the picture, and up is the normal cross right.
    let folder = folder("normals");
    let texel = image::Rgb([255_u8, 128, 128]);
    image::ImageBuffer::from_pixel(2, 2, texel).save(folder.join("n.png")).unwrap();
    let path = folder.join("scene.xml");
    let body = "<shape type='rectangle'><bsdf type='normalmap'><texture type='bitmap' \
        name='normalmap'><boolean name='raw' value='true'/><transform name='to_uv'><rotate z='1' \
        angle='90'/></transform><string name='filename' value='n.png'/></texture><bsdf \
        type='diffuse'/></bsdf></shape>";
    fs::write(&path, scene(body)).unwrap();
    let world = load(&path).unwrap_or_else(|error| panic!("{error}"));
    let baked = bake::<1>(&world, &Carried::at([550.0])).unwrap();
    let textures = painted(&world);
    let on = baked.shapes.painted(0).unwrap();
    let relief = textures.relief.as_ref().unwrap();
    let normal = sunstone::internals::scene::painting::normal_at(
        relief,
        (&on, [0.3, 0.3]),
        [Vec3::Z, Vec3::Z],
    );
    assert!(normal.x > 0.99 && normal.y.abs() < 0.01, "{normal}");
}

#[test]
fn what_is_wrong_with_heights_is_told() {
    let bump = |inner: &str| {
        format!("<shape type='rectangle'><bsdf type='bumpmap'>{inner}</bsdf></shape>")
    };
    let wood = "<texture type='bitmap' name='opacity'><string name='filename' value='b.png'/>\
        </texture>";
    let cases = [
        (bump(""), "has no bsdf in it"),
        (bump("<bsdf type='diffuse'/>"), "must have one texture in it"),
        (bump(&format!("{wood}{wood}<bsdf type='diffuse'/>")), "must have one texture in it"),
        (bump(&format!("{CHECKERS}</texture><bsdf type='diffuse'/>")), "have no slopes"),
        (
            bump(&format!(
                "{wood}<bsdf type='bumpmap'>{}<bsdf type='diffuse'/></bsdf>",
                wood.replace("opacity", "other")
            )),
            "a bumpmap within it",
        ),
        (
            bump(&format!("{wood}<bsdf type='diffuse'/>"))
                .replace("'rectangle'>", "'sphere'><boolean name='flip_normals' value='true'/>")
                .replace("type='diffuse'", "type='dielectric'"),
            "a relief on a sphere that is inside out",
        ),
    ];
    for (body, expected) in cases {
        let error = with_picture("wrong_heights", &body).map(|_| ()).unwrap_err();
        assert!(error.contains(expected), "{error}\nis not: {expected}");
    }
    for sheet in ["polarizer", "retarder", "circular"] {
        let body = bump(&format!("{wood}<bsdf type='{sheet}'/>"));
        let error = with_picture("wrong_heights", &body).map(|_| ()).unwrap_err();
        assert!(error.contains("has a sheet within it, which has no normals"), "{error}");
    }
    // What is not there at all may have any heights.
    let none = format!(
        "{wood}<bsdf type='mask'><float name='opacity' value='0'/><bsdf type='diffuse'/></bsdf>"
    );
    let medium = "<medium name='interior' type='homogeneous'/>";
    let body = bump(&none).replace("</shape>", &format!("{medium}</shape>"));
    let world = with_picture("no_heights", &body).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(world.entities().query::<&Textures>().iter().count(), 0);
}

#[test]
fn what_is_wrong_with_textures_is_told() {
    let bitmap = |inner: &str| {
        square(&format!(
            "<texture type='bitmap' name='reflectance'>{inner}\
        </texture>"
        ))
    };
    let file = "<string name='filename' value='b.png'/>";
    let mask = "<bsdf type='mask'>";
    let wood = "<texture type='bitmap' name='opacity'><string name='filename' value='b.png'/>\
        </texture>";
    let cases = [
        (bitmap(""), "texture (bitmap), filename is missing"),
        (bitmap("<string name='filename' value='none.png'/>"), "cannot read"),
        (bitmap(&format!("{file}<string name='wrap_mode' value='zigzag'/>")), "`zigzag` is not"),
        (bitmap(&format!("{file}<float name='raw' value='1'/>")), "must be a boolean"),
        (bitmap(&format!("{file}<float name='blur' value='1'/>")), "blur is no property"),
        (square(&CHECKERS.replace("float", "boolean").replace("0.1", "true")), "is not XML"),
        (
            format!("<shape type='rectangle'>{mask}{wood}<bsdf type='dielectric'/></bsdf></shape>"),
            "glass that refracts, and sheets, have no holes",
        ),
        (
            format!(
                "<shape type='rectangle'>{mask}{wood}{mask}<bsdf type='diffuse'/></bsdf></bsdf>\
                </shape>"
            ),
            "a mask within a mask",
        ),
        (
            "<shape type='rectangle'><bsdf type='normalmap'><bsdf type='diffuse'/></bsdf></shape>"
                .into(),
            "normalmap is no picture",
        ),
        (
            "<shape type='rectangle'><bsdf type='roughconductor'><texture type='checkerboard' \
             name='alpha_u'/></bsdf></shape>"
                .into(),
            "alpha_u: pictures of facets that differ",
        ),
    ];
    for (body, expected) in cases {
        let error = match with_picture("wrong_textures", &body) {
            Ok(_) => panic!("{body} has been read"),
            Err(error) => error,
        };
        assert!(error.contains(expected), "{error}\nis not: {expected}");
    }
    // A mesh without coordinates.
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let body = format!(
        "<shape type='obj'><string name='filename' value='a.obj'/><bsdf \
        type='diffuse'>{CHECKERS}</texture></bsdf></shape>"
    );
    let path = folder("bare").join("scene.xml");
    fs::write(&path, scene(&body)).unwrap();
    fs::write(path.with_file_name("a.obj"), triangle).unwrap();
    let error = load(&path).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("(obj), TEXCOORD_0 is missing, and a texture of"), "{error}");
    assert!(load_bytes("whole.xml", scene("").as_bytes()).is_ok());
}
