//! What is shown of a render on its way: its intensity, and the degree and angle of its
//! polarization, as a viewer takes them that knows channels of numbers and no Stokes vectors.

use std::f32::consts::PI;

use rayon::prelude::*;

use super::rows::{Frame, Rows};
use super::visualize::{aolp, dop, luminance};
use crate::spectrum::Color;

/// The channels that are shown of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct Live {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// The names of the channels.
    pub channels: &'static [&'static str],
    /// Their values, pixel by pixel; rows from the top, pixels from the left.
    pub values: Vec<f32>,
}

/// The names of the channels, each as LAYER.CHANNEL: S0, of bands and responses their mean; of an
/// image of all Stokes components, the degree of polarization and the angle of linear polarization,
/// too, of its luminance as in [`super::visualize`]. The angle is in half turns, from 0 to 1,
/// counterclockwise from the right.
pub fn channels(frame: &Frame) -> &'static [&'static str] {
    match (&frame.color, frame.components) {
        (Color::Rgb, 4) => &["S0.R", "S0.G", "S0.B", "degree.Y", "angle.Y"],
        (Color::Rgb, _) => &["S0.R", "S0.G", "S0.B"],
        (Color::Mono { .. } | Color::Bands(_) | Color::Responses(_), 4) => {
            &["S0.Y", "degree.Y", "angle.Y"]
        }
        (Color::Mono { .. } | Color::Bands(_) | Color::Responses(_), _) => &["S0.Y"],
    }
}

/// What is shown of an image.
pub fn shown(image: &dyn Rows) -> Live {
    let frame = image.frame();
    let Frame { width, height, ref color, components, .. } = frame;
    let channels = channels(&frame);
    let intensities = channels.iter().filter(|name| name.starts_with("S0")).count();
    let mut values = vec![0.0; width * height * channels.len()];
    let rows = values.par_chunks_exact_mut(width * channels.len()).enumerate();
    rows.for_each_init(
        || vec![0.0; frame.numbers_of_row()],
        |numbers, (y, row)| {
            image.row(y, numbers);
            let planes = color.channels();
            for (x, values) in row.chunks_exact_mut(channels.len()).enumerate() {
                let value =
                    |component, channel| numbers[(component * planes + channel) * width + x];
                let (s0, polarization) = values.split_at_mut(intensities);
                match s0 {
                    [s0] => *s0 = luminance(color, |plane| value(0, plane)),
                    s0 => s0.iter_mut().enumerate().for_each(|(it, s0)| *s0 = value(0, it)),
                }
                if let ([degree, angle], 4) = (polarization, components) {
                    let stokes = [0, 1, 2, 3].map(|it| luminance(color, |plane| value(it, plane)));
                    (*degree, *angle) = (dop(stokes), aolp(stokes) / PI);
                }
            }
        },
    );
    Live { width, height, channels, values }
}
