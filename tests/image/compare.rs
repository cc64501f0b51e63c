//! Comparisons, calibrated on synthetic noise, and the words about images and renders.

use std::path::Path;

use sunstone::internals::image::StokesImage;
use sunstone::internals::image::compare::{compare, difference_picture};
use sunstone::internals::image::{inspect, png};
use sunstone::internals::render::statistics::{RenderStatistics, peak_memory_bytes};
use sunstone::internals::spectrum::Color;

const MONO: Color = Color::Mono { wavelength_nm: 550.0 };

/// Normal numbers from a seed (SplitMix64, Box and Muller).
struct Normal(u64);

impl Normal {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn draw(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.unit()).cos()
    }
}

/// A smooth truth with Gaussian noise of a known size that differs from pixel to pixel.
fn noisy(width: usize, height: usize, color: Color, seed: u64) -> StokesImage {
    let mut random = Normal(seed);
    let mut image = StokesImage::new(width, height, color.clone(), 4);
    let mut variance = image.planes.clone();
    for (i, plane) in image.planes.iter_mut().enumerate() {
        for pixel in 0..width * height {
            let error = 0.01 + 0.05 * (pixel % 13) as f64;
            let truth = if i < color.channels() { 10.0 } else { 2.0 - i as f64 };
            plane[pixel] = (truth + error * random.draw()) as f32;
            variance[i][pixel] = (error * error) as f32;
        }
    }
    image.variance = Some(variance);
    image
}

#[test]
fn noise_alone_stays_within_the_limits() {
    let mut alarms = 0;
    let mut comparisons = 0;
    for seed in 0..60 {
        let (a, b) = (noisy(61, 47, MONO, 1000 + seed), noisy(61, 47, MONO, 9000 + seed));
        for row in compare(&a, &b).unwrap().components {
            let found = row.significance.unwrap();
            assert_eq!((found.count, found.exact_mismatches), (61 * 47, 0));
            assert!((found.rms_z - 1.0).abs() < 0.07);
            assert!((found.share_beyond_3 - 0.0027).abs() < 0.005);
            alarms += usize::from(found.rms_z > found.rms_z_limit);
            alarms += usize::from(found.worst_block_z.abs() > found.worst_block_z_limit);
            comparisons += 2;
        }
    }
    // One in a thousand is promised: 0.48 of 480 expected; five or more have a chance of 2e-4.
    assert!(comparisons == 480 && alarms < 5, "{alarms} alarms");
}

#[test]
fn limits_are_tight_enough_to_see_wrong_variances_and_faint_bias() {
    let (a, b) = (noisy(64, 64, MONO, 3), noisy(64, 64, MONO, 4));
    let mut overconfident = a.clone();
    for plane in overconfident.variance.iter_mut().flatten() {
        plane.iter_mut().for_each(|variance| *variance *= 0.7);
    }
    let found = compare(&overconfident, &b).unwrap().components[2].significance.clone().unwrap();
    assert!(found.rms_z > found.rms_z_limit);
    let mut biased = a.clone();
    for y in 16..24 {
        // One standard error of a single pixel: unseen alone, seen in a block of 64.
        (40..48).for_each(|x| biased.planes[1][y * 64 + x] += 0.35);
    }
    let found = compare(&biased, &b).unwrap().components[1].significance.clone().unwrap();
    assert_eq!(found.worst_block, (40, 16));
    assert!(found.worst_block_z > found.worst_block_z_limit);
}

#[test]
fn shared_noise_of_the_channels_raises_no_alarm() {
    let mut alarms = 0;
    for seed in 0..40 {
        let mut a = noisy(40, 40, Color::Rgb, seed);
        let mut b = noisy(40, 40, Color::Rgb, 500 + seed);
        for image in [&mut a, &mut b] {
            for component in 0..4 {
                let first = image.planes[3 * component].clone();
                image.planes[3 * component + 1] = first.clone();
                image.planes[3 * component + 2] = first;
            }
        }
        for row in compare(&a, &b).unwrap().components {
            let found = row.significance.unwrap();
            alarms += usize::from(found.rms_z > found.rms_z_limit);
        }
    }
    // 0.16 of 160 are expected; three or more have a chance of 6e-4.
    assert!(alarms < 3, "{alarms} alarms");
}

#[test]
fn errors_are_what_they_are_called() {
    let mut a = StokesImage::new(4, 1, MONO, 4);
    let mut b = a.clone();
    a.planes[0] = vec![1.0, 2.0, 3.0, f32::NAN];
    b.planes[0] = vec![1.0, 2.0, 5.0, 1.0];
    let result = compare(&a, &b).unwrap();
    let row = &result.components[0];
    assert!((row.rmse - (4.0_f64 / 3.0).sqrt()).abs() < 1e-12);
    let floor = (0.01_f64 * 9.0 / 4.0).powi(2);
    assert!((row.relative_mse - 4.0 / (25.0 + floor) / 3.0).abs() < 1e-12);
    assert_eq!((row.max_abs, row.non_finite), (2.0, 1));
    assert_eq!((row.mean_first, row.mean_second), (2.0, 2.25));
    assert_eq!(row.significance, None);
    assert!(result.to_string().contains("no variance is known"));
    b.variance = Some(vec![vec![0.0; 4]; 4]);
    let found = compare(&a, &b).unwrap().components[0].significance.clone().unwrap();
    assert_eq!((found.count, found.exact_mismatches), (0, 1));
}

#[test]
fn images_that_do_not_go_together_are_refused() {
    let mono = noisy(8, 8, MONO, 1);
    let message = compare(&mono, &noisy(8, 9, MONO, 1)).unwrap_err().to_string();
    assert!(message.contains("8 x 9") && message.contains("sizes"), "{message}");
    assert!(compare(&mono, &noisy(8, 8, Color::Rgb, 1)).is_err());
    let mut grey = StokesImage::new(8, 8, Color::Rgb, 4);
    for (i, plane) in grey.planes.iter_mut().enumerate() {
        plane.clone_from(&mono.planes[i / 3]);
    }
    let same = compare(&mono, &grey).unwrap();
    assert!(same.components.iter().all(|row| row.max_abs == 0.0));
    let scalar = StokesImage::new(8, 8, MONO, 1);
    assert_eq!(compare(&mono, &scalar).unwrap().components.len(), 1);
    let broken = StokesImage { width: 9, ..mono.clone() };
    assert!(compare(&broken, &mono).is_err() && difference_picture(&broken, &mono).is_err());
}

#[test]
fn comparisons_print_and_serialize() {
    let (a, b) = (noisy(32, 24, Color::Rgb, 5), noisy(32, 24, Color::Rgb, 6));
    let result = compare(&a, &b).unwrap();
    let text = result.to_string();
    println!("{text}");
    assert!(text.lines().all(|line| line.len() <= 100));
    assert!(["S0", "S3", "rms z", "worst 8 x 8 block"].iter().all(|word| text.contains(word)));
    let json = serde_json::to_value(&result).unwrap();
    assert!(json["components"][3]["significance"]["rms_z"].is_number());
    let picture = difference_picture(&a, &b).unwrap();
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("difference.png");
    png::write(&picture, &path).unwrap();
}

#[test]
fn images_are_described_in_words() {
    let mut image = StokesImage::new(2, 1, MONO, 4);
    image.planes = vec![vec![1.0, 3.0], vec![1.0, 0.0], vec![0.0; 2], vec![0.1, 0.0]];
    image.metadata.push(("scene".to_owned(), "tank.gltf".to_owned()));
    let text = inspect::describe(&image);
    println!("{text}");
    for words in ["2 x 1", "550 nm", "mean 2.000000", "1 pixels (50.00%)", "tank.gltf"] {
        assert!(text.contains(words), "{words} in {text}");
    }
    let missing = inspect::inspect_image(Path::new("/nowhere/image.exr")).unwrap_err();
    assert!(missing.to_string().contains("/nowhere/image.exr"));
}

#[test]
fn statistics_print_and_serialize() {
    let mut statistics = RenderStatistics {
        scene: "cornell".to_owned(),
        width: 100,
        height: 50,
        iterations: 8,
        seconds: 2.0,
        rays_closest: 1_500_000,
        radii: vec![Some(0.5), Some(0.25)],
        stages: vec![("trace".to_owned(), 1.5), ("scatter".to_owned(), 0.5)],
        peak_memory_bytes: peak_memory_bytes(),
        ..RenderStatistics::default()
    };
    statistics.count_samples();
    assert_eq!(statistics.samples_per_second, 20_000.0);
    let text = statistics.to_string();
    println!("{text}");
    let kernels = "radius of 5.0000e-1 in the end; in a medium they have a radius of 2.5000e-1";
    assert!(text.contains(kernels), "{text}");
    assert!(text.contains("20.00 ksamples/s") && text.contains("75.0%"), "{text}");
    assert_eq!(serde_json::to_value(&statistics).unwrap()["stages"][0][1], 1.5);
    assert!(!cfg!(target_os = "linux") || statistics.peak_memory_bytes > Some(1 << 20));
}
