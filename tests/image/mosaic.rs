//! Raw images of sensors with analyzers: which pixel is what, and their noise against closed forms.

use std::path::Path;

use sunstone::mosaic::{Electrons, Filters, PolarizationSensor, RawImage};
use sunstone::{Analyzer, Color, StokesImage};

const MONO: Color = Color::Mono { wavelength_nm: 550.0 };
/// Edge of images of one color: 65,536 pixels.
const EDGE: usize = 256;
/// Added to numbers that are electrons.
const BLACK: u32 = 1000;

/// An image of the same light everywhere.
fn even(width: usize, height: usize, color: Color, stokes: &[[f32; 4]]) -> StokesImage {
    let mut image = StokesImage::new(width, height, color.clone(), 4);
    let channels = color.channels();
    for (index, plane) in image.planes.iter_mut().enumerate() {
        plane.fill(stokes[index % channels][index / channels]);
    }
    image
}

/// Unpolarized light of which every analyzer lets so much pass.
fn passing(share: f32) -> StokesImage {
    even(EDGE, EDGE, MONO, &[[2.0 * share, 0.0, 0.0, 0.0]])
}

/// What a sensor reads, whose numbers are electrons above [`BLACK`].
fn electrons(share: f32, full_well: f64, read_noise: f64, seed: u32) -> Vec<f64> {
    let electrons = Some(Electrons { full_well, gain: Some(1.0), read_noise });
    let ideal = PolarizationSensor::ideal(Filters::Mono, 16);
    let sensor = PolarizationSensor { black_level: BLACK, electrons, seed, ..ideal };
    let raw = sensor.record(&passing(share)).expect("it fits");
    raw.values.iter().map(|&value| f64::from(value) - f64::from(BLACK)).collect()
}

fn mean_and_variance(values: &[f64]) -> [f64; 2] {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    [mean, squares / (count - 1.0)]
}

/// Mean and variance are those expected, within five standard errors: that of a variance v of
/// nearly normal numbers is v sqrt(2 / n), and more by the kurtosis 1 / lambda of Poisson's.
#[track_caller]
fn assert_moments(values: &[f64], [mean, variance]: [f64; 2], kurtosis: f64) {
    let count = values.len() as f64;
    let [found_mean, found_variance] = mean_and_variance(values);
    let z = (found_mean - mean) / (variance / count).sqrt();
    assert!(z.abs() < 5.0, "mean {found_mean} for {mean}: z {z}");
    let z = (found_variance - variance) / (variance * ((2.0 + kurtosis) / count).sqrt());
    assert!(z.abs() < 5.0, "variance {found_variance} for {variance}: z {z}");
}

/// Polarized along x: nothing at 90, all at 0 and half at 45 and 135 degrees; the first at 45: all
/// where that stands, on the right above.
#[test]
fn pixels_stand_behind_their_analyzers() {
    let record = |image: &StokesImage, filters| {
        PolarizationSensor::ideal(filters, 8).record(image).expect("it fits").values
    };
    let along_x = even(4, 2, MONO, &[[1.0, 1.0, 0.0, 0.0]]);
    assert_eq!(record(&along_x, Filters::Mono), [0, 128, 0, 128, 128, 255, 128, 255]);
    let diagonal = even(2, 2, MONO, &[[1.0, 0.0, 1.0, 0.0]]);
    assert_eq!(record(&diagonal, Filters::Mono), [128, 255, 0, 128]);
    // Circular light is as good as unpolarized.
    let circular = even(2, 2, MONO, &[[0.4, 0.0, 0.0, -0.4]]);
    assert_eq!(record(&circular, Filters::Mono), [51; 4]);
    let rgb = [[0.2, 0.2, 0.0, 0.0], [0.4, 0.4, 0.0, 0.0], [0.8, 0.8, 0.0, 0.0]];
    let raw = record(&even(4, 4, Color::Rgb, &rgb), Filters::Bayer);
    let expected = [[0, 26, 0, 51], [26, 51, 51, 102], [0, 51, 0, 102], [51, 102, 102, 204]];
    assert_eq!(raw, expected.concat());
    // Of RGB a sensor without filters sees luminance.
    let raw = record(&even(2, 2, Color::Rgb, &rgb), Filters::Mono);
    let luminance = 0.2126 * 0.2 + 0.7152 * 0.4 + 0.0722 * 0.8;
    assert_eq!(raw[3], (255.0_f64 * luminance).round() as u16);
}

#[test]
fn numbers_are_rounded_and_cut_off() {
    for (bits, top) in [(8, 255), (12, 4095), (16, 65_535)] {
        let sensor = PolarizationSensor::ideal(Filters::Mono, bits);
        let sensor = PolarizationSensor { black_level: 16, ..sensor };
        let noisy = PolarizationSensor { electrons: Some(Electrons::of_full_well(1e6)), ..sensor };
        let of = |sensor: &PolarizationSensor, value: f32| {
            let image = even(2, 2, MONO, &[[value, 0.0, 0.0, 0.0]]);
            sensor.record(&image).expect("it fits").values[0]
        };
        for sensor in [sensor, noisy] {
            for dark in [0.0, -1.0, f32::NAN, f32::NEG_INFINITY] {
                assert_eq!(of(&sensor, dark), 16, "{dark}");
            }
            for bright in [100.0, 1e30, f32::INFINITY] {
                assert_eq!(of(&sensor, bright), top, "{bright}");
            }
        }
        assert_eq!(of(&sensor, 1.0), (16.0 + 0.5 * f64::from(top - 16)).round() as u16);
        let brighter = PolarizationSensor { exposure_ev: -1.0, ..sensor };
        assert_eq!(of(&brighter, 2.0), of(&sensor, 1.0));
    }
}

/// Shot noise: the variance of electrons is their mean, from none to many; of half an electron
/// the share without any is that of Poisson.
#[test]
fn the_variance_of_electrons_is_their_mean() {
    for (seed, mean) in [0.5, 3.0, 9.0, 40.0, 1_000.0, 20_000.0].into_iter().enumerate() {
        let full_well = 40_000.0;
        let values = electrons((mean / full_well) as f32, full_well, 0.0, seed as u32);
        assert_moments(&values, [mean, mean], 1.0 / mean);
        if mean < 4.0 {
            let count = values.len() as f64;
            let none = values.iter().filter(|it| **it == 0.0).count() as f64 / count;
            let chance = (-mean).exp();
            let z = (none - chance) / (chance * (1.0 - chance) / count).sqrt();
            assert!(z.abs() < 5.0, "{mean}: {none} for {chance}");
        }
    }
    assert!(electrons(0.0, 100.0, 0.0, 0).iter().all(|it| *it == 0.0));
}

/// Reading adds its variance, gains and rounding theirs.
#[test]
fn reading_adds_noise() {
    assert_moments(&electrons(0.0, 100.0, 20.0, 1), [0.0, 400.0 + 1.0 / 12.0], 0.0);
    assert_moments(&electrons(0.5, 2_000.0, 30.0, 2), [1_000.0, 1_900.0 + 1.0 / 12.0], 0.0);
    let sensor = PolarizationSensor {
        electrons: Some(Electrons { full_well: 10_000.0, gain: Some(0.3), read_noise: 5.0 }),
        black_level: 240,
        ..PolarizationSensor::ideal(Filters::Mono, 12)
    };
    let raw = sensor.record(&passing(0.4)).expect("it fits");
    let values: Vec<f64> = raw.values.iter().map(|&value| f64::from(value)).collect();
    let variance = 0.3 * 0.3 * (4_000.0 + 25.0) + 1.0 / 12.0;
    assert_moments(&values, [240.0 + 0.3 * 4_000.0, variance], 0.0);
    // Without a gain the full well is the largest number.
    let sensor = PolarizationSensor {
        electrons: Some(Electrons::of_full_well(10_000.0)),
        ..PolarizationSensor::ideal(Filters::Mono, 8)
    };
    let raw = sensor.record(&passing(2.0)).expect("it fits");
    assert!(raw.values.iter().all(|&value| value == 255));
}

/// Of light that just fills the well W on average, E[min(X, W)] = W - W P(X = W), since all
/// but one term of E[max(W - X, 0)] cancel.
#[test]
fn wells_are_full_at_the_full_well() {
    let full_well = 400.0;
    let values = electrons(1.0, full_well, 0.0, 3);
    assert!(values.iter().all(|&it| it <= full_well));
    let log_factorial: f64 = (1..=400).map(|it| f64::from(it).ln()).sum();
    let chance = (400.0 * full_well.ln() - full_well - log_factorial).exp();
    let mean = full_well * (1.0 - chance);
    let [found, variance] = mean_and_variance(&values);
    let z = (found - mean) / (variance / values.len() as f64).sqrt();
    assert!(z.abs() < 5.0, "{found} for {mean}: z {z}");
    assert!(electrons(1.5, full_well, 0.0, 4).iter().all(|&it| it == full_well));
}

#[test]
fn noise_is_a_function_of_seed_and_pixel() {
    let first = electrons(0.25, 400.0, 2.0, 7);
    assert_eq!(first, electrons(0.25, 400.0, 2.0, 7));
    let other = electrons(0.25, 400.0, 2.0, 8);
    let correlation = |a: &[f64], b: &[f64]| {
        let ([mean_a, var_a], [mean_b, var_b]) = (mean_and_variance(a), mean_and_variance(b));
        let pairs = a.iter().zip(b);
        let sum: f64 = pairs.map(|(a, b)| (a - mean_a) * (b - mean_b)).sum();
        sum / (var_a * var_b).sqrt() / a.len() as f64
    };
    let limit = 5.0 / (first.len() as f64).sqrt();
    assert!(correlation(&first, &other).abs() < limit);
    for step in [1, 2, EDGE] {
        let pair = (&first[step..], &first[..first.len() - step]);
        assert!(correlation(pair.0, pair.1).abs() < limit, "{step} apart");
    }
}

#[test]
fn what_is_no_sensor_or_does_not_fit_is_refused() {
    let ideal = PolarizationSensor::ideal(Filters::Mono, 12);
    let noisy = |full_well, gain, read_noise| {
        let electrons = Some(Electrons { full_well, gain, read_noise });
        PolarizationSensor { electrons, ..ideal }
    };
    let cases = [
        (PolarizationSensor { bits: 10, ..ideal }, "bits: 10 must be 8, 12 or 16"),
        (PolarizationSensor { bits: 40, ..ideal }, "bits: 40 must"),
        (PolarizationSensor { black_level: 4095, ..ideal }, "black_level: 4095 must be less"),
        (PolarizationSensor { exposure_ev: f32::NAN, ..ideal }, "exposure: NaN must"),
        (noisy(0.0, None, 0.0), "full_well: 0 must be from 1 to 1e12"),
        (noisy(f64::INFINITY, None, 0.0), "full_well: inf must"),
        (noisy(10.0, Some(0.0), 0.0), "gain: 0 must be greater than 0"),
        (noisy(10.0, None, -1.0), "read_noise: -1 must be not negative"),
    ];
    for (sensor, expected) in cases {
        let error = sensor.record(&passing(0.5)).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    let light = [[1.0, 0.0, 0.0, 0.0]; 3];
    let color = PolarizationSensor::ideal(Filters::Bayer, 12);
    let intensity = StokesImage::new(4, 4, MONO, 1);
    let cases = [
        (ideal, even(3, 2, MONO, &light[..1]), "multiples of 2"),
        (ideal, even(2, 1, Color::Rgb, &light), "multiples of 2"),
        (color, even(4, 6, Color::Rgb, &light), "multiples of 4"),
        (color, even(4, 4, MONO, &light[..1]), "take a mono sensor"),
        (ideal, intensity.clone(), "the intensity alone"),
        (ideal, StokesImage::new(0, 0, MONO, 4), "no pixels"),
    ];
    for (sensor, image, expected) in cases {
        let error = sensor.record(&image).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    let analyzer = Analyzer::RightCircular;
    assert!(intensity.behind(analyzer).unwrap_err().to_string().contains("intensity alone"));
}

/// The numbers of a file are those of the sensor, whatever their bits.
#[test]
fn files_hold_the_numbers() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mosaic with spaces");
    std::fs::create_dir_all(&folder).unwrap();
    for bits in [8, 12, 16] {
        let sensor = PolarizationSensor {
            electrons: Some(Electrons::of_full_well(300.0)),
            ..PolarizationSensor::ideal(Filters::Mono, bits)
        };
        let raw = sensor.record(&passing(0.5)).unwrap();
        let path = folder.join(format!("{bits} bits.png"));
        raw.save(&path).unwrap();
        assert_eq!(decoded(&path), (raw.values.clone(), raw.description.clone()));
        for words in ["[[90, 45], [135, 0]]", &format!("{bits} bits"), "full well 300"] {
            assert!(raw.description.contains(words), "{}", raw.description);
        }
        let nowhere = folder.join("no/such.png");
        assert!(raw.save(&nowhere).is_err() && !nowhere.exists());
        let RawImage { width, height, .. } = raw;
        assert_eq!([width, height], [EDGE; 2]);
    }
}

/// The numbers of a gray PNG, and its description.
fn decoded(path: &Path) -> (Vec<u16>, String) {
    let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
    let mut reader = ::png::Decoder::new(file).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let frame = reader.next_frame(&mut bytes).unwrap();
    assert_eq!(frame.color_type, ::png::ColorType::Grayscale);
    let numbers = match frame.bit_depth {
        ::png::BitDepth::Eight => bytes.iter().map(|&byte| u16::from(byte)).collect(),
        _ => bytes.as_chunks::<2>().0.iter().map(|&pair| u16::from_be_bytes(pair)).collect(),
    };
    let text = &reader.info().uncompressed_latin1_text;
    (numbers, text[0].text.clone())
}

/// Images behind analyzers say so, and keep no variances.
#[test]
fn images_behind_analyzers_say_so() {
    let mut image = even(2, 1, MONO, &[[1.0, 0.5, 0.0, -0.25]]);
    image.variance = Some(image.planes.clone());
    image.metadata = vec![("mode".to_owned(), "polarized".to_owned())];
    let right = image.behind(Analyzer::RightCircular).unwrap();
    assert_eq!(right.planes, [[0.375; 2], [0.0; 2], [0.0; 2], [0.375; 2]]);
    assert!(right.variance.is_none());
    assert_eq!(right.metadata("analyzer"), Some("right circular"));
    let both = right.behind(Analyzer::Linear { axis_deg: 90.0 }).unwrap();
    assert_eq!(both.planes, [[0.1875; 2], [-0.1875; 2], [0.0; 2], [0.0; 2]]);
    assert_eq!(both.metadata("analyzer"), Some("right circular, then linear at 90 degrees"));
    assert_eq!(both.metadata("mode"), Some("polarized"));
}
