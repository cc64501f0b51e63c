//! Fresnel's equations for numbers, as textbooks have them, and published indices of refraction.

/// Reflectances of a boundary to an index n - i k over that before it, of light polarized
/// perpendicular to the plane of incidence and in it, by the cosine of the angle of incidence
/// (Born and Wolf 1999, section 14.4.1).
pub fn reflectances([n, k]: [f64; 2], cos_i: f64) -> [f64; 2] {
    let sin2 = 1.0 - cos_i * cos_i;
    let (real, imaginary) = (n * n - k * k - sin2, 2.0 * n * k);
    let size = real.hypot(imaginary);
    let (a2, a) = (0.5 * (size + real), (0.5 * (size + real)).max(0.0).sqrt());
    let b2 = 0.5 * (size - real);
    let s =
        (a2 + b2 - 2.0 * a * cos_i + cos_i * cos_i) / (a2 + b2 + 2.0 * a * cos_i + cos_i * cos_i);
    let (tangent, t2) = (sin2 / cos_i, sin2 * sin2 / (cos_i * cos_i));
    let p = s * (a2 + b2 - 2.0 * a * tangent + t2) / (a2 + b2 + 2.0 * a * tangent + t2);
    [s, p]
}

/// The index at a wavelength in nanometers by Sellmeier's formula of three terms.
fn sellmeier(b: [f64; 3], c_um2: [f64; 3], nm: f64) -> f64 {
    let squared = (nm * 1e-3).powi(2);
    let terms = b.iter().zip(&c_um2).map(|(b, c)| b * squared / (squared - c));
    (1.0 + terms.sum::<f64>()).sqrt()
}

/// N-BK7: SCHOTT's data sheet of 2014.
pub fn bk7(nm: f64) -> f64 {
    sellmeier(
        [1.039_612_12, 0.231_792_344, 1.010_469_45],
        [0.006_000_698_67, 0.020_017_914_4, 103.560_653],
        nm,
    )
}

/// N-SF11: SCHOTT's data sheet of 2014.
pub fn n_sf11(nm: f64) -> f64 {
    sellmeier(
        [1.737_596_95, 0.313_747_346, 1.898_781_01],
        [0.013_188_707, 0.062_306_814_2, 155.236_29],
        nm,
    )
}

#[test]
fn the_formulas_are_those_of_the_data_sheets() {
    for (found, stated) in [
        (bk7(587.561_8), 1.516_80),
        (bk7(435.834_3), 1.526_68),
        (n_sf11(587.561_8), 1.784_72),
        (n_sf11(486.132_7), 1.806_51),
    ] {
        assert!((found - stated).abs() < 1e-5, "{found} {stated}");
    }
    // Glass straight on, at its Brewster angle, and total reflection.
    let [s, p] = reflectances([1.5, 0.0], 1.0);
    assert!((s - 0.04).abs() < 1e-12 && (p - 0.04).abs() < 1e-12);
    assert!(reflectances([1.5, 0.0], 1.5_f64.atan().cos())[1] < 1e-12);
    assert!(reflectances([1.0 / 1.5, 0.0], 0.5).iter().all(|r| (r - 1.0).abs() < 1e-12));
}
