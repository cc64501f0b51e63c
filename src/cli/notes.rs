//! What a user should know of a finished image before trusting it.

use crate::image::StokesImage;
use crate::render::Settings;

/// The share of the paths' throughput that may be cut off without a word.
const CUT_MAX: f64 = 0.01;

/// What there is to doubt about an image; `cut` is the share of the paths' throughput that the
/// limit of segments has cut off.
pub(super) fn doubts(image: &StokesImage, settings: &Settings, cut: f64) -> Vec<String> {
    let is_black = image.planes.iter().flatten().all(|&value| value == 0.0);
    let mut doubts = Vec::new();
    if cut > CUT_MAX {
        doubts.push(format!(
            "warning: paths were cut off after {} segments with {:.0} % of what they carried at \
             first: the image may be too dark; give a greater --max-path-length",
            settings.path_length_max,
            100.0 * cut,
        ));
    }
    if is_black {
        let name = settings.integrator.name();
        doubts.push(format!(
            "warning: the image is black: `{name}` has found no light. The camera may be inside \
             something, face away or see only what nothing lights; small lamps behind glass or in \
             mirrors are found by --integrator ppm"
        ));
    }
    doubts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Options;
    use crate::spectrum::Color;

    #[test]
    fn what_is_black_or_cut_is_told() {
        let settings = Settings::new(Options::default()).unwrap();
        let mut image = StokesImage::new(2, 2, Color::Rgb, 4);
        assert_eq!(doubts(&image, &settings, 0.0).len(), 1);
        image.planes[0][3] = 0.5;
        assert!(doubts(&image, &settings, 0.001).is_empty());
        let [cut] = &doubts(&image, &settings, 0.285)[..] else { panic!("one doubt") };
        assert!(cut.contains("16 segments with 28 %"), "{cut}");
    }
}
