//! Colors: the sRGB transfer curve and the scales of the visualizations.
//!
//! Scales are interpolated in Oklab (Ottosson 2020), where equal steps look equal; a value is so
//! read from lightness as well as from hue, which helps print and color-blind eyes.

use crate::math::elementary::{cbrt, pow, sin_cos};

/// A linear value as an eight-bit sRGB code (IEC 61966-2-1), clipped; NaN is 0.
pub fn encode_srgb(linear: f32) -> u8 {
    let linear = if linear.is_nan() { 0.0 } else { linear.clamp(0.0, 1.0) };
    let encoded = match linear <= 0.003_130_8 {
        true => 12.92 * linear,
        false => 1.055 * pow(linear, 1.0 / 2.4) - 0.055,
    };
    (255.0 * encoded).round() as u8
}

/// The linear value of an eight-bit sRGB code.
pub fn decode_srgb(code: u8) -> f32 {
    let encoded = f32::from(code) / 255.0;
    match encoded <= 0.040_45 {
        true => encoded / 12.92,
        false => pow((encoded + 0.055) / 1.055, 2.4),
    }
}

/// Colors at equal distances over [0, 1].
pub type Scale = &'static [[u8; 3]];

/// The paper's scale, from blue (unpolarized, circular) to yellow (polarized, linear).
pub const BLUE_YELLOW: Scale = &[[22, 38, 148], [255, 226, 48]];
/// Degree of polarization in the manner of Wilkie and Weidlich 2010: black to red.
pub const BLACK_RED: Scale = &[[0, 0, 0], [255, 30, 20]];
/// Type of polarization in the manner of Wilkie and Weidlich 2010: circular yellow, linear cyan.
pub const YELLOW_CYAN: Scale = &[[255, 222, 30], [20, 214, 235]];
/// A signed value: negative blue, none nearly white, positive red.
pub const BLUE_WHITE_RED: Scale =
    &[[10, 50, 130], [60, 135, 205], [247, 247, 245], [225, 95, 65], [130, 5, 30]];
/// Handedness: left blue, none dark, right yellow.
pub const BLUE_DARK_YELLOW: Scale = &[[90, 190, 255], [34, 34, 40], [255, 215, 60]];
/// Where there is no light there is nothing to show.
pub const NO_LIGHT: [u8; 3] = [0, 0, 0];
/// Light without the polarization that a map shows.
pub const NEUTRAL: [u8; 3] = [70, 70, 76];

/// The color of `t` on a scale; outside of [0, 1] and for NaN the nearer end and the beginning.
pub fn sample(scale: Scale, t: f32) -> [u8; 3] {
    let (Some(first), Some(last)) = (scale.first(), scale.last()) else {
        return NO_LIGHT;
    };
    let position = if t > 0.0 { t * (scale.len() - 1) as f32 } else { 0.0 };
    let i = position.floor() as usize;
    match scale.get(i..i.saturating_add(2)) {
        Some([from, to]) => mix(*from, *to, position - i as f32),
        _ if t > 0.0 => *last,
        _ => *first,
    }
}

/// The color between two colors.
pub fn mix(from: [u8; 3], to: [u8; 3], t: f32) -> [u8; 3] {
    let (from, to) = (to_oklab(from), to_oklab(to));
    from_oklab([0, 1, 2].map(|i| from[i] + t * (to[i] - from[i])))
}

/// A wheel of even lightness and chroma, once round over `turn` in [0, 1]: red, yellow, green,
/// blue.
pub fn wheel(turn: f32) -> [u8; 3] {
    let (sin, cos) = sin_cos(std::f32::consts::TAU * turn + 0.45);
    from_oklab([0.74, 0.123 * cos, 0.123 * sin])
}

/// The hue circle of HSV at full saturation.
pub fn hsv(turn: f32, value: f32) -> [u8; 3] {
    let channel = |offset: f32| {
        let k = (offset + 6.0 * turn).rem_euclid(6.0);
        let level = value * (1.0 - k.min(4.0 - k).clamp(0.0, 1.0));
        (255.0 * level.clamp(0.0, 1.0)).round() as u8
    };
    [channel(5.0), channel(3.0), channel(1.0)]
}

/// Rows of 3x3 matrices between linear sRGB, the cones' answers and Oklab, both ways.
pub mod oklab {
    type Matrix = [[f32; 3]; 3];
    /// Linear sRGB to the answers of the cones.
    pub const CONES_OF_RGB: Matrix = [
        [0.412_221_46, 0.536_332_55, 0.051_445_995],
        [0.211_903_5, 0.680_699_5, 0.107_396_96],
        [0.088_302_46, 0.281_718_85, 0.629_978_7],
    ];
    /// Cube roots of the answers to lightness, a and b.
    pub const LAB_OF_ROOTS: Matrix = [
        [0.210_454_26, 0.793_617_8, -0.004_072_047],
        [1.977_998_5, -2.428_592_2, 0.450_593_7],
        [0.025_904_037, 0.782_771_77, -0.808_675_77],
    ];
    /// Lightness, a and b to the cube roots.
    pub const ROOTS_OF_LAB: Matrix = [
        [1.0, 0.396_337_78, 0.215_803_76],
        [1.0, -0.105_561_346, -0.063_854_17],
        [1.0, -0.089_484_18, -1.291_485_5],
    ];
    /// The answers of the cones to linear sRGB.
    pub const RGB_OF_CONES: Matrix = [
        [4.076_741_7, -3.307_711_6, 0.230_969_94],
        [-1.268_438, 2.609_757_4, -0.341_319_4],
        [-0.004_196_086, -0.703_418_6, 1.707_614_7],
    ];

    /// A matrix times a column.
    pub fn apply(matrix: &Matrix, [x, y, z]: [f32; 3]) -> [f32; 3] {
        matrix.map(|[a, b, c]| a * x + b * y + c * z)
    }
}

fn to_oklab(color: [u8; 3]) -> [f32; 3] {
    let cones = oklab::apply(&oklab::CONES_OF_RGB, color.map(decode_srgb));
    oklab::apply(&oklab::LAB_OF_ROOTS, cones.map(cbrt))
}

fn from_oklab(lab: [f32; 3]) -> [u8; 3] {
    let roots = oklab::apply(&oklab::ROOTS_OF_LAB, lab);
    oklab::apply(&oklab::RGB_OF_CONES, roots.map(|root| root.powi(3))).map(encode_srgb)
}
