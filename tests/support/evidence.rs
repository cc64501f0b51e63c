//! What a failed comparison leaves behind.

use std::fs;
use std::path::{Path, PathBuf};

use sunstone::internals::image::StokesImage;
use sunstone::internals::image::{compare, png, save};

/// The mean of replicates with its squared standard error.
pub fn mean(images: &[StokesImage]) -> StokesImage {
    let mut result = images[0].clone();
    let mut variance = result.planes.clone();
    let count = images.len() as f64;
    for (plane, (means, variances)) in result.planes.iter_mut().zip(&mut variance).enumerate() {
        for (pixel, (mean, variance)) in means.iter_mut().zip(variances).enumerate() {
            let values = || images.iter().map(|image| f64::from(image.planes[plane][pixel]));
            let center = values().sum::<f64>() / count;
            let squares: f64 = values().map(|value| (value - center).powi(2)).sum();
            *mean = center as f32;
            *variance = (squares / (count * (count - 1.0))) as f32;
        }
    }
    result.variance = (images.len() > 1).then_some(variance);
    result
}

/// Writes an image, what it should have been, and their difference, as EXR and as PNG; returns
/// the folder.
pub fn keep(test: &str, image: &StokesImage, reference: &StokesImage) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(test.replace([' ', '/'], "_"));
    fs::create_dir_all(&folder).expect("the scratch folder can be made");
    let mut error = image.clone();
    error.variance = None;
    for (error, reference) in error.planes.iter_mut().zip(&reference.planes) {
        error.iter_mut().zip(reference).for_each(|(error, reference)| *error -= reference);
    }
    for (name, image) in [("image", image), ("reference", reference), ("error", &error)] {
        for extension in ["exr", "png"] {
            let path = folder.join(format!("{name}.{extension}"));
            save(image, &path).expect("the scratch folder takes files");
        }
    }
    let picture = compare::difference_picture(image, reference).expect("images of one shape");
    png::write(&picture, &folder.join("error.png")).expect("the scratch folder takes files");
    folder
}
