//! Pictures of all layouts, sound, unsuited and damaged: what textures and environments make of
//! them, and in which words they are refused.

use std::io::Cursor;

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage,
};
use glam::DQuat;
use image::{ImageBuffer, ImageFormat, Luma, Rgb};
use serde_json::{Value, json};
use sunstone::internals::image::texels::{Coding, Texels};
use sunstone::internals::scene::World;
use sunstone::world::Picture;

use crate::common::{data_uri, load_json};
use crate::room::{has_all, room};
use crate::textures::painted;

const SIZE: [usize; 2] = [4, 2];

/// OpenEXR of these channels, each of a value by its texel.
fn openexr(channels: &[(&str, &dyn Fn(usize) -> f32)]) -> Vec<u8> {
    let list = channels.iter().map(|(name, value)| {
        let values: Vec<f32> = (0..SIZE[0] * SIZE[1]).map(value).collect();
        AnyChannel::new(*name, FlatSamples::F32(values))
    });
    let channels = AnyChannels::sort(list.collect());
    let attributes = LayerAttributes::default();
    let layer = Layer::new((SIZE[0], SIZE[1]), attributes, Encoding::SMALL_FAST_LOSSLESS, channels);
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

/// The same where all channels are one.
fn even(names: &[&str]) -> Vec<u8> {
    let one: &dyn Fn(usize) -> f32 = &|_| 1.0;
    openexr(&names.iter().map(|name| (*name, one)).collect::<Vec<_>>())
}

/// The room under a picture; else what is wrong with that.
fn under(bytes: &[u8]) -> Result<World, String> {
    let mut world = room();
    let set = world.set_environment_map(bytes, [1.0; 3], DQuat::IDENTITY);
    set.map(|_| world).map_err(|error| error.to_string())
}

/// The painted document with another picture.
fn painted_by(bytes: &[u8]) -> Value {
    let mut document = painted();
    document["images"][0]["uri"] = json!(data_uri(bytes));
    document
}

#[test]
fn every_value_of_a_polarized_sky_is_looked_at() {
    let names: Vec<String> =
        (0..4).flat_map(|s| ["R", "G", "B"].map(|color| format!("S{s}.{color}"))).collect();
    let sky = |spoilt: &str, bad: f32| {
        // Half polarized; the fifth texel is the first of the second row.
        let value = move |is_spoilt: bool, sound: f32| {
            move |texel: usize| if is_spoilt && texel == 5 { bad } else { sound }
        };
        let of_channel =
            |name: &String| value(name == spoilt, if name.starts_with("S0") { 1.0 } else { 0.2 });
        let values: Vec<_> = names.iter().map(of_channel).collect();
        let rows = names.iter().zip(&values);
        let rows: Vec<(&str, &dyn Fn(usize) -> f32)> =
            rows.map(|(name, value)| (name.as_str(), value as &dyn Fn(usize) -> f32)).collect();
        under(&openexr(&rows))
    };
    assert!(sky("none", 0.0).is_ok());
    for name in &names {
        for (bad, what) in [(f32::NAN, "not a number"), (f32::INFINITY, "an infinite value")] {
            let error = sky(name, bad).map(|_| ()).unwrap_err();
            has_all(&error, &[what, &format!("in {name}, column 1, row 1"), "clean the picture"]);
        }
    }
    has_all(&sky("S0.G", -1.0).map(|_| ()).unwrap_err(), &["a negative value in S0.G"]);
    assert!(sky("S2.G", -0.2).is_ok(), "those of S1 to S3 have signs");
    let error = sky("S1.B", 1.5).map(|_| ()).unwrap_err();
    has_all(&error, &["more than wholly polarized light in column 1, row 1"]);
    // None at all where S0 is none, but for what is nothing.
    let error = sky("S0.R", 0.0).map(|_| ()).unwrap_err();
    has_all(&error, &["more than wholly polarized light in column 1, row 1"]);
}

/// All of S1 to S3 of a texel not numbers, which no largest of them tells.
#[test]
fn skies_of_no_numbers_at_all_are_refused() {
    let nan: &dyn Fn(usize) -> f32 = &|_| f32::NAN;
    let one: &dyn Fn(usize) -> f32 = &|_| 1.0;
    let names = (0..4).flat_map(|s| ["R", "G", "B"].map(|color| (s, format!("S{s}.{color}"))));
    let rows: Vec<(usize, String)> = names.collect();
    let rows: Vec<_> =
        rows.iter().map(|(s, name)| (name.as_str(), if *s == 0 { one } else { nan })).collect();
    has_all(&under(&openexr(&rows)).map(|_| ()).unwrap_err(), &["not a number in S1.R, column 0"]);
}

#[test]
fn a_gray_picture_is_all_three_colors() {
    let value: &dyn Fn(usize) -> f32 = &|texel| texel as f32;
    let half: &dyn Fn(usize) -> f32 = &|_| 0.5;
    let gray = Texels::decode(&openexr(&[("Y", value)])).unwrap();
    assert_eq!((gray.size(), gray.has_alpha()), ([4, 2], false));
    for coding in [Coding::Srgb, Coding::Linear] {
        assert_eq!(gray.at(1, 1, coding), [5.0, 5.0, 5.0, 1.0], "floats are linear");
    }
    let faint = Texels::decode(&openexr(&[("Y", value), ("A", half)])).unwrap();
    assert!(faint.has_alpha());
    assert_eq!(faint.at(3, 0, Coding::Linear), [3.0, 3.0, 3.0, 0.5]);
    // Colors come before a gray beside them, as in films.
    let both = Texels::decode(&openexr(&[("R", value), ("G", half), ("B", half), ("Y", half)]));
    assert_eq!(both.unwrap().at(2, 0, Coding::Linear), [2.0, 0.5, 0.5, 1.0]);
    assert!(load_json(&painted_by(&openexr(&[("Y", half)]))).is_ok());
    let world = under(&openexr(&[("Y", value)])).unwrap();
    let entity = world.find("environment").unwrap();
    let environment = world.entities().get::<&sunstone::world::Environment>(entity).unwrap();
    let mean = environment.mean();
    let [red, green, blue] = mean.values() else { panic!("{mean:?}") };
    assert!(*red > 0.0 && red == green && green == blue, "{mean:?}");
}

#[test]
fn other_layouts_are_told_with_those_that_are_read() {
    for names in [
        &["R", "G"][..],
        &["Z"],
        &["A"],
        &["Y", "RY", "BY"],
        &["S0.550,000000nm", "S0.600,000000nm"],
        &["left.R", "left.G", "left.B"],
        &["r", "g", "b"],
    ] {
        let bytes = even(names);
        let as_texture = load_json(&painted_by(&bytes)).map(|_| ()).unwrap_err();
        for error in [as_texture, under(&bytes).map(|_| ()).unwrap_err()] {
            let found = format!("is an OpenEXR file with the channels {}", sorted(names));
            has_all(&error, &[&found, "channels R, G and B, or with one, Y"]);
            assert!(!error.contains("OpenEXR or Radiance"), "it is OpenEXR already: {error}");
        }
    }
    let many: Vec<String> = (0..300).map(|number| format!("layer{number:03}.Z")).collect();
    let many: Vec<&str> = many.iter().map(String::as_str).collect();
    has_all(&under(&even(&many)).map(|_| ()).unwrap_err(), &["layer000.Z", "and 290 more"]);
}

fn sorted(names: &[&str]) -> String {
    let mut names = names.to_vec();
    names.sort_unstable();
    names.join(", ")
}

#[test]
fn unfit_stokes_vectors_are_told_with_what_environments_need() {
    let mut lacking: Vec<String> =
        (0..4).flat_map(|s| ["R", "G", "B"].map(|color| format!("S{s}.{color}"))).collect();
    lacking.retain(|name| name != "S3.G" && name != "S1.R");
    let lacking: Vec<&str> = lacking.iter().map(String::as_str).collect();
    for (names, words) in [
        (&lacking[..], "OpenEXR file of Stokes vectors that lacks S1.R, S3.G"),
        (&["S0", "S1", "S2"], "that has the channels S0, S1, S2"),
        (&["S0", "S1", "S2", "S3", "Y"], "holds Stokes vectors of"),
        (&["S1.550,000000nm"], "S1.550,000000nm"),
    ] {
        let error = under(&even(names)).map(|_| ()).unwrap_err();
        has_all(&error, &[words, "S0.R, S0.G and S0.B to S3.R, S3.G and S3.B"]);
        assert!(!error.contains("nm and the like"), "{error}");
    }
}

#[test]
fn damaged_files_are_told_in_one_line_with_a_way_out() {
    let mut files = vec![("OpenEXR", even(&["R", "G", "B"])), ("OpenEXR", even(&["Y"]))];
    let picture = ImageBuffer::from_fn(16, 16, |x, y| Rgb([x as u8 * 9, y as u8 * 9, 7]));
    for (name, format) in
        [("PNG", ImageFormat::Png), ("JPEG", ImageFormat::Jpeg), ("WebP", ImageFormat::WebP)]
    {
        let mut bytes = Cursor::new(Vec::new());
        picture.write_to(&mut bytes, format).unwrap();
        files.push((name, bytes.into_inner()));
    }
    for (name, bytes) in &files {
        let length = bytes.len();
        for cut in [length / 8, length / 4, length / 2] {
            let [problem, remedy] = Texels::decode(&bytes[..cut.max(12)]).unwrap_err();
            assert!(!problem.contains('\n') && !problem.contains("\\n"), "{problem}");
            assert!(problem.contains(&format!("{name} ")), "{name}: {problem}");
            assert!(remedy.contains("again") && !remedy.contains("pixels"), "{remedy}");
        }
    }
    // A header that promises a million columns and rows.
    let mut vast = even(&["Y"]);
    let at = vast.windows(16).position(|it| it == b"dataWindow\0box2i").unwrap() + 21;
    vast[at + 8..at + 16].copy_from_slice(&[0xff, 0xff, 0x0f, 0, 0xff, 0xff, 0x0f, 0]);
    let [problem, _] = Texels::decode(&vast).unwrap_err();
    assert!(problem.contains("far more pixels"), "{problem}");
    for (bytes, name) in [
        (&b"II*\0\x08\0\0\0"[..], "is TIFF, which is not read"),
        (b"MM\0*\0\0\0\x08", "is TIFF, which is not read"),
        (b"nonsense", "is of a format that is not known"),
    ] {
        let [problem, remedy] = Texels::decode(bytes).unwrap_err();
        assert_eq!(problem, name);
        assert!(remedy.contains("PNG, JPEG, WebP, BMP, OpenEXR or Radiance HDR"), "{remedy}");
    }
}

/// What errors offer is read.
#[test]
fn textures_may_be_radiance_pictures() {
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n".to_vec();
    bytes.extend([128, 64, 32, 129, 128, 128, 128, 129]);
    let mut document = painted_by(&bytes);
    document["images"][0]["mimeType"] = json!("image/vnd.radiance");
    let world = load_json(&document).unwrap();
    let material = world.find("painted").unwrap();
    let textures = world.entities().get::<&sunstone::world::Textures>(material).unwrap();
    let texture = textures.textures().next().unwrap();
    assert_eq!(texture.picture.texels().at(0, 0, Coding::Srgb), [1.0, 0.5, 0.25, 1.0]);
}

/// A file with a square of one color as its normal map, and how many texels of it are astray.
fn relief(texel: [u8; 3]) -> (Vec<String>, usize) {
    let image =
        ImageBuffer::from_fn(4, 2, |x, _| Rgb(if x == 0 { [128, 128, 255] } else { texel }));
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, ImageFormat::Png).unwrap();
    let bytes = bytes.into_inner();
    let mut document = painted_by(&bytes);
    document["materials"][0]["normalTexture"] = json!({"index": 0});
    let world = load_json(&document).unwrap();
    let picture = Picture::new(Texels::decode(&bytes).unwrap(), 0);
    (world.warnings().to_vec(), picture.normals_astray())
}

#[test]
fn normal_maps_that_are_none_are_told_once() {
    for texel in [[128, 128, 255], [255, 128, 130], [20, 200, 160], [128, 128, 200]] {
        assert_eq!(relief(texel), (Vec::new(), 0), "{texel:?}");
    }
    // Black, into the surface, along it, none at all, a picture of something else.
    for texel in [[0, 0, 0], [128, 128, 0], [255, 128, 127], [128, 128, 128], [250, 250, 90]] {
        let (warnings, astray) = relief(texel);
        assert_eq!((warnings.len(), astray), (1, 6), "{texel:?}: {warnings:?}");
        has_all(&warnings[0], &["material 0 \"painted\", normalTexture has texels", "(6 of 8)"]);
    }
    let gray = ImageBuffer::from_pixel(3, 3, Luma([9_u8]));
    let mut bytes = Cursor::new(Vec::new());
    gray.write_to(&mut bytes, ImageFormat::Png).unwrap();
    let mut document = painted_by(&bytes.into_inner());
    document["materials"].as_array_mut().unwrap().push(Value::Null);
    let relief = json!({"normalTexture": {"index": 0}});
    document["materials"][0] = relief.clone();
    document["materials"][2] = relief;
    let mut second = document["meshes"][0]["primitives"][0].clone();
    second["material"] = json!(2);
    document["meshes"][0]["primitives"].as_array_mut().unwrap().push(second);
    let warnings = load_json(&document).unwrap().warnings().join("\n");
    assert_eq!(warnings.matches("normalTexture").count(), 1, "{warnings}");
    has_all(&warnings, &["material 0, normalTexture (and 1 other) has texels"]);
}
