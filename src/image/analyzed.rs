//! Images behind ideal analyzers, without rendering again.

use super::error::OutputError;
use super::picture::Picture;
use super::visualize::{INTENSITY_ALONE, intensity};
use super::{check_shape, legend};
use crate::image::StokesImage;
use crate::polarization::{Analyzer, Stokes};

/// The analyzers that `visualize` shows, and their names there.
pub const ANALYZERS: [(&str, Analyzer); 6] = [
    ("analyzer-0", Analyzer::Linear { axis_deg: 0.0 }),
    ("analyzer-45", Analyzer::Linear { axis_deg: 45.0 }),
    ("analyzer-90", Analyzer::Linear { axis_deg: 90.0 }),
    ("analyzer-135", Analyzer::Linear { axis_deg: 135.0 }),
    ("analyzer-right", Analyzer::RightCircular),
    ("analyzer-left", Analyzer::LeftCircular),
];

/// Columns of the picture of all of them.
const COLUMNS: usize = 3;

/// The Stokes image behind an analyzer in the film's frame. Variances are not kept: that of what
/// passes depends on how the errors of the components go together, which no image tells.
pub fn behind(image: &StokesImage, analyzer: Analyzer) -> Result<StokesImage, OutputError> {
    check_stokes(image)?;
    let Stokes(state) = analyzer.state();
    let channels = image.color.channels();
    let passed: Vec<Vec<f32>> = (0..channels)
        .map(|channel| {
            let components = [0, 1, 2, 3].map(|component| image.plane(component, channel));
            let of_pixel = |pixel: usize| analyzer.passed(components.map(|plane| plane[pixel]));
            (0..image.width * image.height).map(of_pixel).collect()
        })
        .collect();
    let component = |share: f64| {
        let share = share as f32;
        passed.iter().map(move |plane| plane.iter().map(|value| share * value).collect())
    };
    let mut metadata = image.metadata.clone();
    match metadata.iter_mut().find(|(key, _)| key == "analyzer") {
        Some((_, before)) => *before += &format!(", then {analyzer}"),
        None => metadata.push(("analyzer".to_owned(), analyzer.to_string())),
    }
    Ok(StokesImage {
        planes: state.into_iter().flat_map(component).collect(),
        variance: None,
        layers: image.layers.clone(),
        metadata,
        width: image.width,
        height: image.height,
        color: image.color.clone(),
        components: image.components,
    })
}

/// What passes an analyzer as a picture, with its legend beneath.
pub fn picture(
    image: &StokesImage,
    analyzer: Analyzer,
    exposure_ev: f32,
) -> Result<Picture, OutputError> {
    let title = format!("behind an analyzer: {analyzer}");
    let (picture, legend) = intensity(&behind(image, analyzer)?, exposure_ev, title);
    Ok(legend::with_legend_of(image, &picture, legend))
}

/// All of [`ANALYZERS`] side by side.
pub fn pictures(image: &StokesImage, exposure_ev: f32) -> Result<Picture, OutputError> {
    let all = ANALYZERS.iter().map(|(_, analyzer)| picture(image, *analyzer, exposure_ev));
    Ok(legend::arrange(&all.collect::<Result<Vec<Picture>, OutputError>>()?, COLUMNS))
}

/// Refuses images of intensity alone.
pub(super) fn check_stokes(image: &StokesImage) -> Result<(), OutputError> {
    check_shape(image).map_err(|reason| OutputError::Image { reason })?;
    match image.components {
        4 => Ok(()),
        _ => Err(OutputError::Image { reason: INTENSITY_ALONE }),
    }
}
