//! Renders of the public library, and means with their errors.

use std::ops::ControlFlow;
use std::sync::Arc;

use sunstone::{
    Band, Bands, Color, Options, PlacedWorld, Renderer, Settings, Spectral, StokesImage,
};

/// Options of a film of some bands, over no more wavelengths than those need.
pub fn spectral(wavelengths: u32, bands: Vec<Band>, options: Options) -> Options {
    let ends = |band: &Band| band.ends_nm().map(|nm| nm as f32);
    let range_nm = [ends(&bands[0])[0], ends(&bands[bands.len() - 1])[1]];
    let bands = Bands::new(bands).expect("sound bands");
    let spectral = Some(Spectral { wavelengths, range_nm });
    Options { color: Color::Bands(Arc::new(bands)), spectral, ..options }
}

/// Independent images: of seeds that follow each other.
pub fn images(world: &PlacedWorld, options: &Options, replicates: u32) -> Vec<StokesImage> {
    let image = |replicate| {
        let seed = options.seed + replicate;
        let settings = Settings::new(Options { seed, ..options.clone() }).expect("sound options");
        let mut renderer = Renderer::new(world, &settings).expect("a sound world");
        renderer.run(|_| ControlFlow::Continue(()));
        renderer.finish()
    };
    (0..replicates).map(image).collect()
}

/// A number that independent renders know.
#[derive(Clone, Copy, Debug)]
pub struct Measured {
    pub mean: f64,
    /// The standard error of the mean.
    pub error: f64,
}

impl Measured {
    pub fn of(values: &[f64]) -> Self {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        Self { mean, error: (squares / (count * (count - 1.0))).sqrt() }
    }

    /// How many standard errors it is off; `rounding` is an error that comes with them.
    pub fn score(&self, expected: f64, rounding: f64) -> f64 {
        (self.mean - expected) / self.error.hypot(rounding)
    }
}

/// The mean over a plane of an image.
pub fn mean(image: &StokesImage, component: usize, channel: usize) -> f64 {
    let plane = image.plane(component, channel);
    plane.iter().map(|value| f64::from(*value)).sum::<f64>() / plane.len() as f64
}
