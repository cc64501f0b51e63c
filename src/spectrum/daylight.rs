//! Average daylight: the CIE standard illuminant D65.

/// Where it is tabulated here, in nanometers.
pub const DAYLIGHT_NM: [f64; 2] = [360.0, 830.0];
/// Between values of the table.
const STEP_NM: f64 = 5.0;

/// Relative spectral power at a wavelength in nanometers, 100 at 560 nm (ISO/CIE 11664-2): linear
/// between values every 5 nm, and zero outside of [`DAYLIGHT_NM`], where it is not known.
pub fn d65(wavelength_nm: f64) -> f64 {
    let [first, last] = DAYLIGHT_NM;
    if !(first..=last).contains(&wavelength_nm) {
        return 0.0;
    }
    let place = (wavelength_nm - first) / STEP_NM;
    let lower = (place as usize).min(D65.len() - 2);
    let share = place - lower as f64;
    D65[lower] * (1.0 - share) + D65[lower + 1] * share
}

const D65: [f64; 95] = [
    46.638_3, 49.363_7, 52.089_1, 51.032_3, 49.975_5, 52.311_8, 54.648_2, 68.701_5, 82.754_9,
    87.120_4, 91.486, 92.458_9, 93.431_8, 90.057, 86.682_3, 95.773_6, 104.865, 110.936, 117.008,
    117.41, 117.812, 116.336, 114.861, 115.392, 115.923, 112.367, 108.811, 109.082, 109.354,
    108.578, 107.802, 106.296, 104.79, 106.239, 107.689, 106.047, 104.405, 104.225, 104.046,
    102.023, 100.0, 98.167_1, 96.334_2, 96.061_1, 95.788, 92.236_8, 88.685_6, 89.345_9, 90.006_2,
    89.802_6, 89.599_1, 88.648_9, 87.698_7, 85.493_6, 83.288_6, 83.493_9, 83.699_2, 81.863,
    80.026_8, 80.120_7, 80.214_6, 81.246_2, 82.277_8, 80.281, 78.284_2, 74.002_7, 69.721_3,
    70.665_2, 71.609_1, 72.979, 74.349, 67.976_5, 61.604, 65.744_8, 69.885_6, 72.486_3, 75.087,
    69.339_8, 63.592_7, 55.005_4, 46.418_2, 56.611_8, 66.805_4, 65.094_1, 63.382_8, 63.843_4,
    64.304, 61.877_9, 59.451_9, 55.705_4, 51.959, 54.699_8, 57.440_6, 58.876_6, 60.312_5,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_met_and_mixed_between_and_none_is_outside() {
        assert_eq!([360.0, 560.0, 830.0].map(d65), [46.6383, 100.0, 60.3125]);
        assert!((d65(562.5) - 0.5 * (100.0 + 98.1671)).abs() < 1e-12);
        for nm in [f64::NAN, -1.0, 0.0, 359.999, 830.001, f64::INFINITY] {
            assert_eq!(d65(nm), 0.0);
        }
    }
}
