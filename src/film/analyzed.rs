//! Films behind ideal analyzers, which measure one number: twice what passes, so that unpolarized
//! light counts in full and nothing that draws or weighs paths has to know.

use crate::image::StokesImage;
use crate::polarization::{Analyzer, Stokes};

/// The image of so many Stokes components behind an analyzer, from that of what was measured: all
/// light is in the state that the analyzer passes, so each component is the first times a number,
/// and its error that error times the same.
pub fn spread(measured: StokesImage, analyzer: Analyzer, components: usize) -> StokesImage {
    let Stokes(state) = analyzer.state();
    let gains: Vec<f32> = state[..components].iter().map(|share| (0.5 * share) as f32).collect();
    let planes = |planes: &[Vec<f32>], gain_of: fn(f32) -> f32| {
        let of_component = |gain: f32| {
            planes.iter().map(move |plane| plane.iter().map(|value| gain * value).collect())
        };
        gains.iter().flat_map(|&gain| of_component(gain_of(gain))).collect()
    };
    StokesImage {
        components,
        planes: planes(&measured.planes, |gain| gain),
        variance: measured.variance.as_deref().map(|of| planes(of, |gain| gain * gain)),
        ..measured
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::Color;

    /// Half of what was measured, in the state that passes, with its variance.
    #[test]
    fn components_and_variances_follow_from_the_first() {
        let mut measured = StokesImage::new(2, 1, Color::Mono { wavelength_nm: 550.0 }, 1);
        measured.planes = vec![vec![4.0, 1.0]];
        measured.variance = Some(vec![vec![1.0, 0.25]]);
        let left = spread(measured.clone(), Analyzer::LeftCircular, 4);
        let expected = [[2.0, 0.5], [0.0; 2], [0.0; 2], [-2.0, -0.5]];
        assert_eq!(left.planes, expected);
        let expected = [[0.25, 0.0625], [0.0; 2], [0.0; 2], [0.25, 0.0625]];
        assert_eq!(left.variance.expect("it was there"), expected);
        let intensity = spread(measured, Analyzer::Linear { axis_deg: 20.0 }, 1);
        assert_eq!(intensity.planes, [[2.0, 0.5]]);
        assert_eq!(intensity.components, 1);
    }
}
