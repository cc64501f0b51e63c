//! Texels as files again: PNG of integers, OpenEXR of floats. What is read of them has the same
//! values, bit for bit.

use std::borrow::Cow;

use super::{Texels, Values};
use crate::image::rows::{Frame, Rows};
use crate::image::{StokesImage, exr};
use crate::spectrum::Color;

impl Texels {
    /// The bytes of a file, and what its name ends in.
    ///
    /// # Errors
    /// When an encoder refuses them: what it says.
    pub fn encode(&self) -> Result<(Vec<u8>, &'static str), String> {
        match &self.values {
            Values::Bytes(bytes) => self.png(bytes, ::png::BitDepth::Eight),
            Values::Words(words) => {
                let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_be_bytes()).collect();
                self.png(&bytes, ::png::BitDepth::Sixteen)
            }
            Values::Floats(values) => {
                let names: &[&str] = match self.channels {
                    1 => &["Y"],
                    2 => &["Y", "A"],
                    3 => &["R", "G", "B"],
                    _ => &["R", "G", "B", "A"],
                };
                let mut channels: Vec<(String, usize)> =
                    names.iter().map(|name| (*name).to_owned()).zip(0..).collect();
                // As the format wants them.
                channels.sort();
                let rows = Floats { texels: self, values };
                exr::encode(&rows, channels).map(|bytes| (bytes, "exr"))
            }
        }
    }

    fn png(&self, data: &[u8], depth: ::png::BitDepth) -> Result<(Vec<u8>, &'static str), String> {
        let mut bytes = Vec::new();
        let mut encoder = ::png::Encoder::new(&mut bytes, self.width, self.height);
        encoder.set_depth(depth);
        encoder.set_color(match self.channels {
            1 => ::png::ColorType::Grayscale,
            2 => ::png::ColorType::GrayscaleAlpha,
            3 => ::png::ColorType::Rgb,
            _ => ::png::ColorType::Rgba,
        });
        let written = encoder.write_header().and_then(|mut writer| {
            writer.write_image_data(data)?;
            writer.finish()
        });
        written.map_err(|error| error.to_string())?;
        Ok((bytes, "png"))
    }
}

/// The rows of linear texels. What a file of them calls its channels is said beside.
struct Floats<'a> {
    texels: &'a Texels,
    values: &'a [f32],
}

impl Rows for Floats<'_> {
    /// One that has as many planes as a texel has values.
    fn frame(&self) -> Frame {
        let gray = Color::Mono { wavelength_nm: exr::WAVELENGTH_UNSTATED_NM };
        let (color, components, has_variance) = match self.texels.channels {
            1 => (gray, 1, false),
            2 => (gray, 1, true),
            3 => (Color::Rgb, 1, false),
            _ => (gray, 4, false),
        };
        let [width, height] = self.texels.size().map(|side| side as usize);
        Frame { width, height, color, components, has_variance, layers: Vec::new() }
    }

    fn metadata(&self) -> &[(String, String)] {
        &[]
    }

    fn row(&self, y: usize, numbers: &mut [f32]) {
        let (width, channels) = (self.texels.width as usize, self.texels.channels);
        let row = &self.values[channels * width * y..][..channels * width];
        for (channel, plane) in numbers.chunks_exact_mut(width).enumerate() {
            for (number, texel) in plane.iter_mut().zip(row.chunks_exact(channels)) {
                *number = texel[channel];
            }
        }
    }

    fn whole(&self) -> Cow<'_, StokesImage> {
        let Frame { width, height, color, components, .. } = self.frame();
        let mut numbers = vec![0.0; self.frame().numbers_of_row()];
        let mut planes = vec![Vec::new(); self.texels.channels];
        for y in 0..height {
            self.row(y, &mut numbers);
            for (plane, of_row) in planes.iter_mut().zip(numbers.chunks_exact(width)) {
                plane.extend_from_slice(of_row);
            }
        }
        let variance = self.frame().has_variance.then(|| planes.split_off(1));
        let (layers, metadata) = (Vec::new(), Vec::new());
        Cow::Owned(StokesImage {
            width,
            height,
            color,
            components,
            planes,
            variance,
            layers,
            metadata,
        })
    }

    fn fault(&self) -> Option<&'static str> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::texels::Coding;

    #[test]
    fn what_is_encoded_is_decoded_bit_for_bit() {
        let count = 5 * 3;
        for channels in 1..=4 {
            let of = |at: usize| (at * 7919) % 65536;
            let numbers = 0..channels * count;
            for values in [
                Values::Bytes(numbers.clone().map(|at| of(at) as u8).collect()),
                Values::Words(numbers.clone().map(|at| of(at) as u16).collect()),
                Values::Floats(numbers.clone().map(|at| (of(at) as f32).powi(-3)).collect()),
            ] {
                let texels = Texels { width: 5, height: 3, channels, values };
                let (bytes, kind) = texels.encode().unwrap();
                let again = Texels::decode(&bytes).unwrap_or_else(|[error, _]| panic!("{error}"));
                assert!(again == texels, "{channels} {kind}: {again:?} {texels:?}");
                let [own, other] = [&texels, &again].map(|it| it.at(4, 2, Coding::Srgb));
                assert_eq!(own.map(f32::to_bits), other.map(f32::to_bits));
            }
        }
    }
}
