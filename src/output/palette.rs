//! Colors: the sRGB transfer curve and the scales of the visualizations.

/// A linear value as an eight-bit sRGB code (IEC 61966-2-1), clipped; NaN is 0.
pub fn encode_srgb(linear: f32) -> u8 {
    let linear = if linear.is_nan() { 0.0 } else { linear.clamp(0.0, 1.0) };
    let encoded = match linear <= 0.003_130_8 {
        true => 12.92 * linear,
        false => 1.055 * linear.powf(1.0 / 2.4) - 0.055,
    };
    (255.0 * encoded).round() as u8
}
