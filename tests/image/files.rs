//! Files of the output floor: round trips, garbage, and writing as a whole or not at all.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use sunstone::internals::image::StokesImage;
use sunstone::internals::image::inspect::pixel;
use sunstone::internals::image::{self, OutputError, atomic, exr, hdr, npy};
use sunstone::internals::spectrum::{Band, Bands, Color, Curves};

const MONO: Color = Color::Mono { wavelength_nm: 532.1 };

/// A folder of its own for one test, empty at the start.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("output").join(name);
    if folder.exists() {
        fs::remove_dir_all(&folder).unwrap();
    }
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// Uniform numbers from a seed (SplitMix64).
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    }

    fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1_u64 << 24) as f32
    }

    fn below(&mut self, end: usize) -> usize {
        (self.bits() % end as u64) as usize
    }
}

/// Physical Stokes vectors over ten decades of intensity, a few of them black.
fn sample(width: usize, height: usize, color: Color, components: usize) -> StokesImage {
    let mut random = Random(7);
    let mut image = StokesImage::new(width, height, color.clone(), components);
    let channels = color.channels();
    for pixel in 0..width * height {
        for channel in 0..channels {
            let s0 = if pixel % 17 == 0 { 0.0 } else { 10_f32.powf(10.0 * random.unit() - 5.0) };
            image.planes[channel][pixel] = s0;
            for component in 1..components {
                let share = (2.0 * random.unit() - 1.0) / 3_f32.sqrt();
                image.planes[component * channels + channel][pixel] = s0 * share;
            }
        }
    }
    image.metadata = vec![
        ("scene".to_owned(), "cornell.gltf".to_owned()),
        ("command".to_owned(), "sunstone render \"a b\" --größe 3\nsecond line".to_owned()),
        ("a".to_owned(), String::new()),
    ];
    image
}

fn all_layouts() -> [StokesImage; 4] {
    [(Color::Rgb, 4), (Color::Rgb, 1), (MONO, 4), (MONO, 1)]
        .map(|(color, components)| sample(19, 23, color, components))
}

fn bits(planes: &[Vec<f32>]) -> Vec<Vec<u32>> {
    planes.iter().map(|plane| plane.iter().map(|value| value.to_bits()).collect()).collect()
}

/// What has lost a channel on its way is no image of intensity.
#[test]
fn an_exr_that_lacks_a_stokes_channel_is_refused() {
    let path = folder("lacking").join("s.exr");
    image::save(&sample(4, 3, Color::Rgb, 4), &path).unwrap();
    let bytes = fs::read(&path).unwrap();
    let name = b"S3.R\0";
    let at = bytes.windows(name.len()).position(|window| window == name).unwrap();
    let mut other = bytes.clone();
    other[at] = b'Z';
    fs::write(&path, other).unwrap();
    let error = exr::read(&path).unwrap_err().to_string();
    assert!(error.contains("Z3.R") && error.contains("S0.R S0.G S0.B ... S3.B"), "{error}");
}

#[test]
fn exr_round_trips_bit_for_bit() {
    let folder = folder("exr_round_trip");
    for (i, mut image) in all_layouts().into_iter().enumerate() {
        for variance in [false, true] {
            if variance {
                let mut planes = image.planes.clone();
                planes.reverse();
                image.variance = Some(planes);
            }
            image.planes[0][3] = f32::NAN;
            image.planes[0][4] = f32::NEG_INFINITY;
            image.planes[0][5] = -0.0;
            let path = folder.join(format!("{i}.exr"));
            exr::write(&image, &path).unwrap();
            let back = exr::read(&path).unwrap();
            assert_eq!(bits(&back.planes), bits(&image.planes));
            assert_eq!(back.variance.as_deref().map(bits), image.variance.as_deref().map(bits));
            assert_eq!(back.metadata, image.metadata);
            assert_eq!((back.width, back.height), (image.width, image.height));
            assert_eq!((&back.color, back.components), (&image.color, image.components));
        }
    }
}

/// Reads every truncation in steps and seeded byte flips of a file; none may panic, and nothing
/// that is cut short may pass for whole.
fn torture(path: &Path, read: impl Fn(&Path) -> Result<StokesImage, OutputError>) {
    let whole = fs::read(path).unwrap();
    let torn = path.with_file_name(format!("torn_{}", path.file_name().unwrap().display()));
    for length in (0..whole.len()).step_by(1 + whole.len() / 400) {
        fs::write(&torn, &whole[..length]).unwrap();
        assert!(read(&torn).is_err(), "{} bytes of {}", length, path.display());
    }
    let mut random = Random(11);
    for round in 0..600 {
        let mut bytes = whole.clone();
        let end = if round % 2 == 0 { bytes.len() } else { bytes.len().min(1200) };
        for _ in 0..=random.below(3) {
            bytes[random.below(end)] = random.bits() as u8;
        }
        fs::write(&torn, &bytes).unwrap();
        let _ = read(&torn);
    }
    let noise: Vec<u8> = (0..4096).map(|_| random.bits() as u8).collect();
    fs::write(&torn, noise).unwrap();
    assert!(read(&torn).is_err());
    fs::remove_file(torn).unwrap();
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn torn_exr_files_are_refused() {
    let folder = folder("exr_torn");
    for (i, image) in all_layouts().iter().enumerate() {
        let path = folder.join(format!("{i}.exr"));
        exr::write(image, &path).unwrap();
        torture(&path, exr::read);
    }
}

#[test]
fn a_failed_write_leaves_nothing() {
    let folder = folder("atomic");
    let file = folder.join("plain");
    fs::write(&file, "former").unwrap();
    let inside = file.join("image.exr");
    let image = sample(4, 4, Color::Rgb, 4);
    let message = exr::write(&image, &inside).unwrap_err().to_string();
    assert!(message.contains("image.exr") && message.contains("not a folder"), "{message}");
    let missing = folder.join("none").join("image.exr");
    let message = atomic::probe_writable(&missing).unwrap_err().to_string();
    assert!(message.contains("create the folder"), "{message}");
    let message = exr::write(&image, &folder).unwrap_err().to_string();
    assert!(message.contains("it is a folder"), "{message}");
    assert!(atomic::write(Path::new("/dev/null"), b"x").is_err());
    // The second of a set fails: the first must stay as it was.
    let set = [(file.clone(), b"new".to_vec()), (missing, b"new".to_vec())];
    assert!(atomic::write_set(&set).is_err());
    assert_eq!(fs::read_to_string(&file).unwrap(), "former");
    atomic::probe_writable(&file).unwrap();
    let names: Vec<_> = fs::read_dir(&folder).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(names, ["plain"]);
}

#[test]
fn images_that_contradict_themselves_are_refused() {
    let path = folder("contradiction").join("image.exr");
    let mut image = sample(4, 4, Color::Rgb, 4);
    image.planes[5].pop();
    assert!(exr::write(&image, &path).is_err());
    assert!(exr::write(&StokesImage::new(0, 4, MONO, 1), &path).is_err());
    let mut image = sample(4, 4, MONO, 1);
    image.metadata.push(("scene".to_owned(), "again".to_owned()));
    assert!(exr::write(&image, &path).unwrap_err().to_string().contains("twice"));
    image.metadata = vec![("frame".to_owned(), "another".to_owned())];
    assert!(exr::write(&image, &path).unwrap_err().to_string().contains("the format's own"));
    assert!(!path.exists());
}

#[test]
fn hdr_round_trips_within_its_bounds() {
    let folder = folder("hdr_round_trip");
    for (i, mut image) in all_layouts().into_iter().enumerate() {
        let channels = image.color.channels();
        if image.components == 4 {
            // Fully polarized pixels reach the ends of the scale: S' of 0 and 2.
            for (pixel, sign) in [(1, 1.0), (2, -1.0)] {
                let s0 = image.planes[0][pixel];
                (1..4).for_each(|c| image.planes[c * channels][pixel] = 0.0);
                image.planes[channels][pixel] = sign * s0;
            }
        }
        let path = folder.join(format!("{i}.x.hdr"));
        image::save(&image, &path).unwrap();
        let back = image::load(&path).unwrap();
        assert_eq!(back.metadata, image.metadata);
        assert_eq!((back.width, back.height, &back.color), (19, 23, &image.color));
        assert_eq!(back.components, image.components);
        for pixel in 0..image.width * image.height {
            let largest =
                (0..channels).map(|c| image.plane(0, c)[pixel]).fold(0.0, |a: f32, b| a.max(b));
            for channel in 0..channels {
                let (s0, read) = (image.plane(0, channel)[pixel], back.plane(0, channel)[pixel]);
                assert!((s0 - read).abs() <= largest / 255.0, "{s0} {read} of {largest}");
                for component in 1..image.components {
                    if read == 0.0 {
                        // Black, or so much fainter than another channel that it rounds to 0.
                        assert_eq!(back.plane(component, channel)[pixel], 0.0);
                        continue;
                    }
                    let share = image.plane(component, channel)[pixel] / s0;
                    let share_read = back.plane(component, channel)[pixel] / read;
                    let error = (share - share_read).abs();
                    assert!(error <= 1.0 / 128.0 + 1e-6, "{share} {share_read}");
                }
            }
        }
    }
    let names = fs::read_dir(&folder).unwrap().count();
    assert_eq!(names, 4 + 1 + 4 + 1);
}

#[test]
fn hdr_of_unpolarized_light_is_exactly_unpolarized() {
    let path = folder("hdr_exact").join("grey.S0.hdr");
    let mut image = StokesImage::new(200, 3, MONO, 4);
    image.planes[0] = (0..600).map(|i| (i / 7) as f32).collect();
    image::save(&image, &path).unwrap();
    let back = image::load(&path).unwrap();
    assert!(back.planes[1..].iter().flatten().all(|&value| value == 0.0));
    assert_eq!(back.planes[0], image.planes[0]);
    // Written over by intensity alone, the old S1..S3 beside it must not come back.
    image::save(&StokesImage::new(200, 3, MONO, 1), &path).unwrap();
    assert_eq!(image::load(&path).unwrap().components, 1);
}

#[test]
fn torn_hdr_files_are_refused() {
    let folder = folder("hdr_torn");
    for (i, image) in all_layouts().iter().filter(|image| image.components == 1).enumerate() {
        let path = folder.join(format!("{i}.hdr"));
        hdr::write(image, &path).unwrap();
        torture(&hdr::component_path(&path, 0), hdr::read);
    }
}

/// The bytes of a .npy file of version 1.
fn npy(header: &str, values: &[f32]) -> Vec<u8> {
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend_from_slice(&(header.len() as u16).to_le_bytes());
    bytes.extend_from_slice(header.as_bytes());
    bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

#[test]
fn npy_arrays_become_stokes_images() {
    let folder = folder("npy");
    let path = folder.join("stokes.npy");
    let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3, 4), }\n";
    let values: Vec<f32> = (0..24).map(|i| i as f32).collect();
    fs::write(&path, npy(header, &values)).unwrap();
    let image = image::load(&path).unwrap();
    assert_eq!((image.width, image.height, image.components), (3, 2, 4));
    assert_eq!(image.planes[1], [1.0, 5.0, 9.0, 13.0, 17.0, 21.0]);
    assert_eq!(image.variance, None);
    fs::copy(&path, folder.join("stderr.npy")).unwrap();
    let variance = image::load(&path).unwrap().variance.unwrap();
    assert_eq!(variance[3], [9.0, 49.0, 121.0, 225.0, 361.0, 529.0]);
    torture(&path, npy::read_npy);
    for (from, to) in [("<f4", "<f8"), ("False", "True"), ("(2, 3, 4)", "(99999999999999, 4)")] {
        fs::write(&path, npy(&header.replace(from, to), &values)).unwrap();
        assert!(npy::read_npy(&path).is_err());
    }
}

#[test]
fn unknown_extensions_are_refused_with_the_known_ones() {
    let image = StokesImage::new(1, 1, MONO, 1);
    for name in ["image.jpg", "image", ".exr"] {
        let message = image::save(&image, Path::new(name)).unwrap_err().to_string();
        assert!(message.contains(".exr, .hdr, .png"), "{message}");
        assert!(image::load(Path::new(name)).unwrap_err().to_string().contains(".npy"));
        assert!(image::check_savable(Path::new(name)).is_err());
    }
}

/// An EXR of the exr crate's own making.
fn foreign_exr(path: &Path, channels: &[&str], sample: impl Fn(usize) -> ::exr::prelude::f16) {
    use ::exr::prelude::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, WritableImage};
    let list = channels
        .iter()
        .enumerate()
        .map(|(i, name)| AnyChannel::new(*name, FlatSamples::F16(vec![sample(i); 6])));
    let channels = AnyChannels::sort(list.collect());
    Image::from_encoded_channels((3, 2), Encoding::FAST_LOSSLESS, channels)
        .write()
        .to_file(path)
        .unwrap();
}

#[test]
fn exr_files_of_mitsuba_are_read() {
    let path = folder("exr_foreign").join("mitsuba.exr");
    // The stokes integrator over path, in the 16-bit format that is Mitsuba's default.
    let names = "R G B A S0.R S0.G S0.B S1.R S1.G S1.B S2.R S2.G S2.B S3.R S3.G S3.B";
    let names: Vec<&str> = names.split(' ').collect();
    foreign_exr(&path, &names, |i| ::exr::prelude::f16::from_f32(i as f32));
    let image = image::load(&path).unwrap();
    assert_eq!((image.width, image.height, image.components), (3, 2, 4));
    assert_eq!(image.color, Color::Rgb);
    for (i, plane) in image.planes.iter().enumerate() {
        assert_eq!(*plane, vec![(i + 4) as f32; 6]);
    }
    let one = |_| ::exr::prelude::f16::ONE;
    foreign_exr(&path, &["A", "Z", "depth"], one);
    let message = exr::read(&path).unwrap_err().to_string();
    assert!(message.contains("A Z depth") && message.contains("mitsuba.exr"), "{message}");
    foreign_exr(&path, &["R", "G", "B", "albedo"], one);
    assert_eq!(exr::read(&path).unwrap().components, 1);
    foreign_exr(&path, &["Y"], one);
    assert_eq!(exr::read(&path).unwrap().color.channels(), 1);
}

#[test]
fn an_exr_that_promises_too_much_is_refused() {
    let path = folder("exr_bomb").join("bomb.exr");
    exr::write(&sample(4, 4, Color::Rgb, 4), &path).unwrap();
    let mut bytes = fs::read(&path).unwrap();
    let name = b"dataWindow\0box2i\0";
    let start = bytes.windows(name.len()).position(|window| window == name).unwrap();
    let corner = start + name.len() + 4 + 8;
    for end in [1_000_000_i32, i32::MAX, i32::MIN, -1] {
        bytes[corner..corner + 4].copy_from_slice(&end.to_le_bytes());
        bytes[corner + 4..corner + 8].copy_from_slice(&end.to_le_bytes());
        fs::write(&path, &bytes).unwrap();
        assert!(exr::read(&path).is_err());
    }
}

/// Bands come back with their names and widths, and files of others with what can be told.
#[test]
fn bands_come_back() {
    let folder = folder("bands");
    let list = [("blue", 450.0, 20.0), ("a line", 589.3, 0.5), ("red edge", 700.1, 31.5)];
    let band = |(name, center_nm, width_nm): (&str, f32, f32)| Band {
        name: name.to_owned(),
        center_nm,
        width_nm,
    };
    let color = Color::Bands(Arc::new(Bands::new(list.map(band).to_vec()).unwrap()));
    for (components, with_variance) in [(1, false), (4, true)] {
        let mut image = sample(9, 5, color.clone(), components);
        image.variance = with_variance.then(|| image.planes.clone());
        let path = folder.join(format!("{components}.exr"));
        image.save(&path).unwrap();
        assert_eq!(StokesImage::load(&path).unwrap(), image);
        let of_line = image.at_wavelength(589.2).unwrap();
        assert_eq!(of_line.color, Color::Mono { wavelength_nm: 589.3 });
        assert_eq!(of_line.plane(components - 1, 0), image.plane(components - 1, 1));
        let error = image.at_wavelength(500.0).unwrap_err().to_string();
        assert!(error.contains("3 bands") && error.contains("500 nm"), "{error}");
        let error = image.save(&folder.join("x.hdr")).unwrap_err().to_string();
        assert!(error.contains("write an .exr"), "{error}");
        image.save(&folder.join("x.png")).unwrap();
    }
}

/// Responses come back with their curves and factors, whatever their channels are called, and what
/// is not the same is told.
#[test]
fn responses_come_back() {
    let folder = folder("responses");
    let curves = |names: [&str; 3]| {
        let nm = vec![400.0, 500.1, 600.0];
        let values = [vec![0.0, 0.1, 1e-7], vec![0.3, 3e7, -0.7], vec![0.0, 1.0, 0.0]];
        let channels = names.into_iter().map(str::to_owned).zip(values).collect();
        Curves::new("a \"sensor\"", nm, channels).unwrap()
    };
    let names = ["R", "550nm", "red edge (a)"];
    let normalized = curves(names).normalized([400.0, 600.0], None).unwrap();
    for (components, curves) in [(1, curves(names)), (4, normalized)] {
        let color = Color::Responses(Arc::new(curves));
        let mut image = sample(9, 5, color, components);
        image.variance = Some(image.planes.clone());
        let path = folder.join(format!("{components}.exr"));
        image.save(&path).unwrap();
        assert_eq!(StokesImage::load(&path).unwrap(), image);
        let of_one = image.at_channel("red edge (a)").unwrap();
        assert_eq!(of_one.plane(components - 1, 0), image.plane(components - 1, 2));
        let Color::Mono { wavelength_nm } = of_one.color else { panic!("one wavelength") };
        assert!((wavelength_nm - 500.033).abs() < 1e-2, "{wavelength_nm}");
        let error = image.at_channel("red").unwrap_err().to_string();
        assert!(error.contains("`red`; it has R, 550nm, red edge (a)"), "{error}");
        assert!(image.at_wavelength(550.0).is_err());
        let error = image.save(&folder.join("x.hdr")).unwrap_err().to_string();
        assert!(error.contains("write an .exr"), "{error}");
        image.save(&folder.join("x.png")).unwrap();
    }
    // The curves of the one and the channels of the other.
    let bytes = fs::read(folder.join("1.exr")).unwrap();
    let at = bytes.windows(9).position(|it| it == b"S0.550nm\0").unwrap();
    let mut other = bytes.clone();
    other[at..at + 8].copy_from_slice(b"S0.551nm");
    fs::write(folder.join("other.exr"), other).unwrap();
    let error = StokesImage::load(&folder.join("other.exr")).unwrap_err().to_string();
    assert!(error.contains("not the channels that its sunstone.responses name"), "{error}");
}

/// Of every layout, a pixel tells its channels with their wavelengths and Stokes vectors.
#[test]
fn a_pixel_is_a_table() {
    let list = [Band::new(450.0, 20.0), Band { name: "a, b".to_owned(), ..Band::new(500.5, 2.0) }];
    let bands = Color::Bands(Arc::new(Bands::new(list.to_vec()).unwrap()));
    let mut image = StokesImage::new(3, 2, bands, 4);
    for (plane, values) in image.planes.iter_mut().enumerate() {
        values[5] = plane as f32 + 0.25;
    }
    assert_eq!(
        pixel(&image, [2, 1]).unwrap(),
        "channel,wavelength_nm,S0,S1,S2,S3\n450 nm,450,0.25,2.25,4.25,6.25\n\
         \"a, b\",500.5,1.25,3.25,5.25,7.25\n"
    );
    let mut image = StokesImage::new(1, 1, Color::Rgb, 1);
    image.planes = vec![vec![0.5], vec![1.0], vec![-2e-9]];
    image.variance = Some(vec![vec![0.25], vec![4.0], vec![0.0]]);
    assert_eq!(
        pixel(&image, [0, 0]).unwrap(),
        "channel,wavelength_nm,S0,stderr_S0\nR,,0.5,0.5\nG,,1,2\nB,,-0.000000002,0\n"
    );
    for place in [[1, 0], [0, 1], [usize::MAX, usize::MAX]] {
        let error = pixel(&image, place).unwrap_err().to_string();
        assert!(error.contains("1 x 1 pixels, counted from 0,0"), "{error}");
    }
}

/// What `exr` itself would write, but for the level of its deflate: its own types, from scratch.
fn write_by_library(image: &StokesImage, path: &Path) {
    use ::exr::prelude::*;
    let names: &[&str] = match image.color {
        Color::Rgb => &["R", "G", "B"],
        Color::Mono { .. } | Color::Bands(_) | Color::Responses(_) => &[""],
    };
    let name_of = |plane: usize| {
        let (component, channel) = (plane / names.len(), names[plane % names.len()]);
        format!("S{component}.{channel}").trim_end_matches('.').to_owned()
    };
    let mut list = Vec::new();
    let mut add = |name: String, plane: &[f32]| {
        let values = FlatSamples::F32(plane.to_vec());
        list.push(AnyChannel::new(Text::new_or_panic(name), values));
    };
    for (channel, name) in names.iter().enumerate() {
        let name = if name.is_empty() { "Y" } else { name };
        add(name.to_owned(), &image.planes[channel]);
    }
    for (plane, values) in image.planes.iter().enumerate() {
        if image.components == 4 || names.len() == 1 {
            add(name_of(plane), values);
        }
    }
    for (plane, values) in image.variance.iter().flatten().enumerate() {
        add(format!("variance.{}", name_of(plane)), values);
    }
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: ::exr::image::Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let (size, channels) = ((image.width, image.height), AnyChannels::sort(list.into()));
    let layer = Layer::new(size, LayerAttributes::default(), encoding, channels);
    Image::from_layer(layer).write().non_parallel().to_file(path).unwrap();
}

fn read_by_library(path: &Path) -> ::exr::prelude::FlatImage {
    use ::exr::prelude::*;
    read().no_deep_data().all_resolution_levels().all_channels().all_layers().all_attributes();
    read_all_flat_layers_from_file(path).unwrap()
}

/// Sizes about those of blocks, noise that does not shrink, what shrinks to nothing, and every
/// kind of number.
#[test]
fn exr_blocks_are_those_of_the_library() {
    let folder = folder("exr_blocks");
    let sizes = [(1, 1), (1, 16), (3, 17), (64, 64), (200, 33), (1500, 90), (5300, 3), (9000, 2)];
    for (index, (width, height)) in sizes.into_iter().enumerate() {
        for (color, components) in [(Color::Rgb, 4), (Color::Rgb, 1), (MONO, 4), (MONO, 1)] {
            let mut image = sample(width, height, color.clone(), components);
            let mut random = Random(index as u64);
            match index % 3 {
                0 => image.planes.iter_mut().flatten().for_each(|value| *value = 0.0),
                1 => image.planes.iter_mut().flatten().for_each(|value| {
                    *value = f32::from_bits(random.bits() as u32);
                }),
                _ => image.variance = Some(image.planes.clone()),
            }
            let [ours, theirs] = ["ours.exr", "theirs.exr"].map(|name| folder.join(name));
            exr::write(&image, &ours).unwrap();
            write_by_library(&image, &theirs);
            let [mut ours, theirs] = [&ours, &theirs].map(|path| read_by_library(path));
            // The one has metadata, the other has none.
            let attributes = &mut ours.layer_data[0].attributes;
            attributes.other.retain(|name, _| !name.to_string().starts_with("sunstone."));
            attributes.software_name = None;
            assert_eq!(ours.attributes, theirs.attributes);
            let [ours, theirs] = [&ours, &theirs].map(|image| &image.layer_data[0]);
            assert_eq!((ours.size, ours.encoding), (theirs.size, theirs.encoding));
            assert_eq!(ours.attributes, theirs.attributes);
            let bits = |layer: &::exr::prelude::Layer<_>| {
                let channels: &::exr::prelude::AnyChannels<::exr::prelude::FlatSamples> =
                    &layer.channel_data;
                let of = |channel: &::exr::prelude::AnyChannel<::exr::prelude::FlatSamples>| {
                    let values = channel.sample_data.values_as_f32().map(f32::to_bits);
                    let linear = channel.quantize_linearly;
                    (channel.name.to_string(), linear, channel.sampling, values.collect::<Vec<_>>())
                };
                channels.list.iter().map(of).collect::<Vec<_>>()
            };
            assert!(bits(ours) == bits(theirs), "{width} x {height}, {color}, {components}");
        }
    }
}

/// The bytes of a file depend on the image alone.
#[test]
fn exr_bytes_do_not_depend_on_threads() {
    let folder = folder("exr_threads");
    let image = sample(300, 200, Color::Rgb, 4);
    let bytes = [1, 2, 7].map(|threads| {
        let path = folder.join(format!("{threads}.exr"));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| exr::write(&image, &path)).unwrap();
        fs::read(path).unwrap()
    });
    assert!(bytes[0] == bytes[1] && bytes[0] == bytes[2]);
    // As OpenEXR's own library writes them.
    let place = |name: &str| {
        let name = format!("{name}\0");
        bytes[0].windows(name.len()).position(|bytes| bytes == name.as_bytes()).unwrap()
    };
    assert!(place("compression\0compression") < place("displayWindow\0box2i"));
    assert!(place("screenWindowWidth\0float") < place("sunstone.a\0string"));
    assert!(place("sunstone.a\0string") < place("sunstone.scene\0string"));
}
