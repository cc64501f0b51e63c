//! Previews and maps of polarization, on Stokes vectors whose colors are known.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use sunstone::internals::image::StokesImage;
use sunstone::internals::image::picture::Picture;
use sunstone::internals::image::visualize::{self, Map, View, aolp, colorize, dop};
use sunstone::internals::image::{palette, png};
use sunstone::internals::spectrum::{Bands, Color};

const MONO: Color = Color::Mono { wavelength_nm: 550.0 };

fn folder() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("output").join("pictures");
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn row(vectors: &[[f32; 4]], color: Color) -> StokesImage {
    let mut image = StokesImage::new(vectors.len(), 1, color.clone(), 4);
    let channels = color.channels();
    for (i, plane) in image.planes.iter_mut().enumerate() {
        *plane = vectors.iter().map(|stokes| stokes[i / channels]).collect();
    }
    image
}

fn colors(vectors: &[[f32; 4]], map: Map) -> Vec<[u8; 3]> {
    colorize(&row(vectors, MONO), map, &View::default()).unwrap().pixels
}

/// A sky: full intensity range over x, a turning and ellipticizing polarization over y.
fn ramps(width: usize, height: usize, color: Color) -> StokesImage {
    let mut image = StokesImage::new(width, height, color.clone(), 4);
    let channels = color.channels();
    for pixel in 0..width * height {
        let (x, y) = (pixel % width, pixel / width);
        let (u, v) = (x as f32 / (width - 1) as f32, y as f32 / (height - 1) as f32);
        let (dx, dy) = (2.0 * u - 1.0, 1.0 - 2.0 * v);
        let radius = dx.hypot(dy);
        let degree = (1.1 - (radius - 0.7).abs() * 2.2).clamp(0.0, 1.0);
        let (sin2, cos2) = (2.0 * dy.atan2(dx)).sin_cos();
        let circular = (3.0 * dx * dy).clamp(-1.0, 1.0);
        let linear = (1.0 - circular * circular).sqrt();
        for channel in 0..channels {
            let s0 = if radius > 1.35 { 0.0 } else { (0.9 - 0.2 * channel as f32) * (1.1 - u) };
            let unit = [1.0, degree * linear * cos2, degree * linear * sin2, degree * circular];
            for (component, share) in unit.into_iter().enumerate() {
                image.planes[component * channels + channel][pixel] = s0 * share;
            }
        }
    }
    image
}

#[test]
fn srgb_codes_are_the_standard_ones() {
    let cases = [(0.0, 0), (0.002, 7), (0.0031308, 10), (0.18, 118), (0.5, 188), (1.0, 255)];
    for (linear, code) in cases {
        assert_eq!(palette::encode_srgb(linear), code);
    }
    for odd in [f32::NAN, f32::NEG_INFINITY, -1.0] {
        assert_eq!(palette::encode_srgb(odd), 0);
    }
    assert_eq!(palette::encode_srgb(f32::INFINITY), 255);
    assert!((0..=255).all(|code| palette::encode_srgb(palette::decode_srgb(code)) == code));
}

/// Equal energy is pinkish beside daylight: by IEC 61966-2-1, half of it has the codes 204, 183 and
/// 180. Bands that miss what is seen of it, and bands beyond, are the grey of their mean.
#[test]
fn bands_are_seen_in_color_or_grey() {
    for (first, last, count, codes) in [
        (400.0, 700.0, 31, [204, 183, 180]),
        (400.0, 720.0, 8, [204, 183, 180]),
        (460.0, 640.0, 10, [188; 3]),
        (800.0, 2000.0, 5, [188; 3]),
    ] {
        let bands = Bands::evenly(first, last, count).unwrap();
        let mut image = StokesImage::new(1, 1, Color::Bands(Arc::new(bands)), 1);
        image.planes.iter_mut().for_each(|plane| plane[0] = 0.5);
        let [found] = png::preview(&image, 0.0).pixels[..] else { panic!("one pixel") };
        let is_near = found.iter().zip(codes).all(|(found, code): (&u8, u8)| {
            found.abs_diff(code) <= if codes == [188; 3] { 0 } else { 2 }
        });
        assert!(is_near, "{count} bands from {first} to {last} nm: {found:?} and not {codes:?}");
    }
}

#[test]
fn previews_expose_by_powers_of_two() {
    let image = row(&[[0.25, 0.0, 0.0, 0.0], [4.0, 0.0, 0.0, 0.0]], MONO);
    assert_eq!(png::preview(&image, 1.0).pixels, [[188; 3], [255; 3]]);
    assert_eq!(png::preview(&image, -3.0).pixels[1], [188; 3]);
}

/// What the decoder of the png crate makes of a written picture.
fn decoded(path: &Path) -> (::png::ColorType, Vec<u8>) {
    let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
    let mut reader = ::png::Decoder::new(file).read_info().unwrap();
    let mut data = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut data).unwrap();
    data.truncate(info.buffer_size());
    (info.color_type, data)
}

#[test]
fn png_files_hold_the_picture() {
    let path = folder().join("tiny.png");
    let pixels = vec![[1, 2, 3], [255, 0, 7], [9, 9, 9], [0, 0, 0]];
    let picture = Picture { width: 2, height: 2, pixels };
    png::write(&picture, &path).unwrap();
    let expected = (::png::ColorType::Rgb, picture.pixels.as_flattened().to_vec());
    assert_eq!(decoded(&path), expected);
    png::write_preview(&row(&[[0.5, 0.0, 0.0, 0.0]], MONO), &path, 0.0).unwrap();
    assert_eq!(decoded(&path), (::png::ColorType::Grayscale, vec![188]));
}

#[test]
fn angles_and_degrees_follow_the_formulas() {
    for (stokes, angle) in [
        ([1.0, 1.0, 0.0, 0.0], 0.0),
        ([1.0, 0.0, 1.0, 0.0], FRAC_PI_4),
        ([1.0, -1.0, 0.0, 0.0], FRAC_PI_2),
        ([1.0, 0.0, -1.0, 0.0], 3.0 * FRAC_PI_4),
    ] {
        assert!((aolp(stokes) - angle).abs() < 1e-6);
    }
    for i in 0..1000 {
        let (sin, cos) = (TAU * i as f32 / 1000.0).sin_cos();
        assert!((0.0..PI).contains(&aolp([1.0, cos, sin, 0.0])));
    }
    assert!(aolp([1.0, 1.0, -1e-30, 0.0]) < PI);
    assert!((dop([2.0, 1.0, 0.5, 0.25]) - 1.3125_f32.sqrt() / 2.0).abs() < 1e-6);
    assert_eq!(dop([0.0, 1.0, 0.0, 0.0]), 0.0);
}

#[test]
fn maps_have_the_colors_of_their_legends() {
    let none = [1.0, 0.0, 0.0, 0.0];
    let along_x = [2.0, 2.0, 0.0, 0.0];
    let right = [0.5, 0.0, 0.0, 0.5];
    let left = [3.0, 0.0, 0.0, -3.0];
    let black = [0.0; 4];
    let broken = [1.0, f32::NAN, 0.0, 0.0];
    let all = [none, along_x, right, left, black, broken];
    let [blue, yellow] = [[22, 38, 148], [255, 226, 48]];
    let grey = palette::NEUTRAL;
    let dark = [0; 3];
    assert_eq!(colors(&all, Map::Dop), [blue, yellow, yellow, yellow, dark, dark]);
    assert_eq!(colors(&all, Map::LinearCircular), [grey, yellow, blue, blue, dark, dark]);
    let [lefty, righty, middle] = [[90, 190, 255], [255, 215, 60], [34, 34, 40]];
    assert_eq!(colors(&all, Map::Chirality), [middle, middle, righty, lefty, dark, dark]);
    assert_eq!(colors(&all, Map::Ellipticity), [grey, middle, righty, lefty, dark, dark]);
    let red = [255, 30, 20];
    assert_eq!(colors(&all, Map::DopRed), [dark, red, red, red, dark, dark]);
    let [circular, linear] = [[255, 222, 30], [20, 214, 235]];
    assert_eq!(colors(&all, Map::Type), [dark, linear, circular, circular, dark, dark]);
}

#[test]
fn angles_are_cyclic_hues() {
    let at = |degrees: f32, degree: f32| {
        let (sin, cos) = (2.0 * degrees.to_radians()).sin_cos();
        [1.0, degree * cos, degree * sin, 0.0]
    };
    let [a, b] = [colors(&[at(0.0, 1.0)], Map::Aolp), colors(&[at(179.99, 1.0)], Map::Aolp)];
    assert!((0..3).all(|i| a[0][i].abs_diff(b[0][i]) <= 1));
    let hues: Vec<[u8; 3]> = [0.0, 60.0, 120.0]
        .map(|angle| at(angle, 1.0))
        .to_vec()
        .into_iter()
        .flat_map(|stokes| colors(&[stokes], Map::AolpDark))
        .collect();
    assert_eq!(hues, [[255, 0, 0], [0, 255, 0], [0, 0, 255]]);
    assert_eq!(colors(&[at(0.0, 0.0)], Map::AolpDark), [[0; 3]]);
    let four = [0.0, 45.0, 90.0, 135.0].map(|angle| colors(&[at(angle, 1.0)], Map::Orientation)[0]);
    assert_eq!(four, [[235, 50, 40], [60, 90, 255], [40, 190, 70], [250, 220, 40]]);
}

#[test]
fn stokes_planes_are_signed() {
    let vectors = [[2.0, 2.0, -2.0, 0.0], [1.0, -1.0, 0.0, 1.0]];
    let picture = colorize(&row(&vectors, MONO), Map::StokesRelative, &View::default()).unwrap();
    let [minus, zero, plus] = [[10, 50, 130], [247, 247, 245], [130, 5, 30]];
    let white = [255; 3];
    assert_eq!((picture.width, picture.height), (4, 2));
    assert_eq!(picture.pixels, [white, white, plus, minus, minus, zero, zero, plus]);
    let absolute = colorize(&row(&vectors, MONO), Map::Stokes, &View::default()).unwrap();
    assert_eq!(absolute.pixels[2], plus);
}

#[test]
fn rgb_is_combined_by_luminance() {
    let mut image = StokesImage::new(1, 1, Color::Rgb, 4);
    image.planes[0][0] = 1.0;
    image.planes[1][0] = 1.0;
    image.planes[2][0] = 1.0;
    image.planes[3 + 1][0] = 1.0;
    assert!((dop(visualize::stokes_at(&image, 0)) - 0.7152).abs() < 1e-6);
}

#[test]
fn images_of_intensity_alone_show_only_that() {
    let image = StokesImage::new(3, 2, MONO, 1);
    for map in Map::ALL {
        assert_eq!(
            visualize::visualize(&image, map, &View::default()).is_ok(),
            map == Map::Intensity
        );
        assert_eq!(map.name().parse(), Ok(map));
    }
    assert!("rainbow".parse::<Map>().unwrap_err().contains("linear-circular"));
}

#[test]
fn legends_are_drawn_at_every_size() {
    for (width, height) in [(1, 1), (3, 200), (64, 64), (251, 10), (900, 300)] {
        let image = ramps(width.max(2), height.max(2), Color::Rgb);
        for map in Map::ALL {
            let bare = colorize(&image, map, &View::default()).unwrap();
            let full = visualize::visualize(&image, map, &View::default()).unwrap();
            assert!(full.width >= 250 && full.height > bare.height);
            assert_eq!(full.pixels.len(), full.width * full.height);
        }
    }
}

#[test]
fn weak_polarization_can_be_shown_on_a_shorter_scale() {
    let weak = row(&[[1.0, 0.03, 0.0, 0.0], [1.0, 0.0, 0.0, -0.05], [1.0, 0.0, 0.0, 0.0]], MONO);
    let view = View::fitted(&weak);
    assert_eq!(view.degree_max, 0.05);
    let picture = colorize(&weak, Map::Dop, &view).unwrap();
    assert_eq!(picture.pixels[1..], [[255, 226, 48], [22, 38, 148]]);
    let picture = colorize(&weak, Map::Chirality, &view).unwrap();
    assert_eq!(picture.pixels[1], [90, 190, 255]);
    // Below the fading degree a color is mixed with grey, from there on it is full.
    let faded = View { degree_faded: 0.04, ..view };
    let pixels = colorize(&weak, Map::LinearCircular, &faded).unwrap().pixels;
    assert_eq!(pixels[1..], [[22, 38, 148], palette::NEUTRAL]);
    assert_eq!(pixels[0], palette::mix(palette::NEUTRAL, [255, 226, 48], 0.75));
    for odd in [0.0, -1.0, f32::NAN] {
        let view = View { degree_max: odd, degree_faded: odd, exposure_ev: odd };
        assert!(Map::ALL.into_iter().all(|map| visualize::visualize(&weak, map, &view).is_ok()));
    }
    assert_eq!(View::fitted(&StokesImage::new(2, 2, MONO, 1)), View::default());
}

/// Beneath the picture of a channel stands its name, and nothing else is another.
#[test]
fn pictures_of_channels_are_named() {
    let bands = Bands::from_list("nir=850x50,550x10").unwrap();
    let bands = row(&[[1.0, 0.5, 0.0, 0.1]; 3], Color::Bands(Arc::new(bands)));
    let nir = bands.at_channel("nir").unwrap();
    assert_eq!((nir.channel(), bands.channel()), (Some("nir"), None));
    assert_eq!(bands.at_wavelength(550.0).unwrap().channel(), Some("550 nm"));
    let mut nameless = nir.clone();
    nameless.metadata.clear();
    for map in Map::ALL {
        let [named, plain] = [&nir, &nameless]
            .map(|image| visualize::visualize(image, map, &View::default()).unwrap());
        assert_eq!((named.width, named.height), (plain.width, plain.height));
        assert!(named.pixels != plain.pixels, "{}", map.name());
        // Three pixels, enlarged to 252 x 84.
        assert_eq!(named.pixels[..252 * 84], plain.pixels[..252 * 84]);
    }
}

/// Writes the gallery that a person looks at after a change to the palettes or legends.
#[test]
fn gallery() {
    for (name, image) in [("large", ramps(480, 360, Color::Rgb)), ("small", ramps(64, 48, MONO))] {
        for map in Map::ALL {
            let picture = visualize::visualize(&image, map, &View::default()).unwrap();
            png::write(&picture, &folder().join(format!("{name}-{}.png", map.name()))).unwrap();
        }
        let picture = visualize::panels(&image, &View::default()).unwrap();
        png::write(&picture, &folder().join(format!("{name}-panels.png"))).unwrap();
    }
}

/// What a picture shows of values is between black and white, and no other than the values are.
#[test]
fn previews_are_brightened_where_all_would_be_black() {
    let image = |scale: f32| {
        let ramp: Vec<[f32; 4]> =
            (0..=100).map(|at| [scale * at as f32 / 100.0, 0.0, 0.0, 0.0]).collect();
        row(&ramp, MONO)
    };
    for (scale, stops) in [(1.0, 0.0), (0.1, 0.0), (3.0, 0.0), (0.0, 0.0), (1.0 / 1024.0, 9.0)] {
        assert_eq!(png::exposure(&image(scale)), stops, "{scale}");
    }
    assert_eq!(png::exposure(&image(4096.0)), -13.0, "brighter than white but for a few");
    let dark = image(1.0 / 1024.0);
    let brightened = png::preview(&dark, png::exposure(&dark));
    assert_eq!(brightened.pixels, png::preview(&image(0.5), 0.0).pixels);
    let mut odd = image(1e-4);
    odd.planes[0][3] = f32::NAN;
    odd.planes[0][4] = f32::INFINITY;
    assert!(png::exposure(&odd) > 10.0);
    assert_eq!(png::exposure(&row(&[[f32::NAN; 4]], MONO)), 0.0);
}
