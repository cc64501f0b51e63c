//! Milk against an independent code for the same model, at all wavelengths of the references.

use std::time::Instant;

use sunstone::internals::polarization::milk::{Milk, Serum};

/// Relative, and of the matrix relative to M00.
const TOLERANCE: f64 = 1e-3;
/// Intervals from 0 to pi: a multiple of the references' half degrees.
const INTERVALS: usize = 1440;

const WHOLE: Milk = Milk { fat_percent: 3.5, protein_percent: 3.4, dilution: 1.0 };
const SKIM: Milk = Milk { fat_percent: 0.1, ..WHOLE };

fn rows(table: &str) -> impl Iterator<Item = Vec<f64>> {
    table
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|cell| cell.parse().expect("a number")).collect())
}

/// Compares coefficients and phase matrix at every wavelength; the greatest errors of both.
fn compare(milk: Milk, coefficients: &str, phase: &str) -> [f64; 2] {
    let (mut worst_coefficient, mut worst_element) = (0.0_f64, 0.0_f64);
    for row in rows(coefficients) {
        let start = Instant::now();
        let particles = milk.suspension(row[0]).scattering(INTERVALS);
        let Serum { sigma_a_riboflavin, sigma_a_water } = milk.serum(row[0]);
        println!("{} nm: {:?}", row[0], start.elapsed());
        // The references are per millimeter.
        let found = [
            particles.sigma_s,
            particles.sigma_a,
            sigma_a_riboflavin,
            sigma_a_water,
            1e3 * particles.g,
        ];
        let expected = [row[4], row[7], row[8], row[9], row[10]].map(|value| 1e3 * value);
        for (value, expected) in found.into_iter().zip(expected) {
            worst_coefficient = worst_coefficient.max((value / expected - 1.0).abs());
        }
        let mut compared = 0;
        for reference in rows(phase).filter(|reference| reference[0] == row[0]) {
            let index = (reference[1] / 180.0 * INTERVALS as f64).round() as usize;
            let found = particles.matrix[index];
            let m00 = reference[2];
            let pairs = [
                (found.m00, m00),
                (found.m01, reference[3]),
                (found.m22, reference[4]),
                (found.m23, reference[5]),
            ];
            for (value, expected) in pairs {
                worst_element = worst_element.max((value - expected).abs() / m00);
            }
            compared += 1;
        }
        assert!(compared > 80, "{} nm: {compared} rows", row[0]);
    }
    [worst_coefficient, worst_element]
}

#[test]
fn whole_milk() {
    let worst = compare(
        WHOLE,
        include_str!("../data/mie/milk_whole_coeffs.csv"),
        include_str!("../data/mie/milk_whole_phase.csv"),
    );
    println!("whole milk: largest errors of coefficients and matrix {worst:?}");
    assert!(worst.iter().all(|error| *error <= TOLERANCE), "{worst:?}");
}

#[test]
fn skimmed_milk() {
    let worst = compare(
        SKIM,
        include_str!("../data/mie/milk_skim_coeffs.csv"),
        include_str!("../data/mie/milk_skim_phase.csv"),
    );
    println!("skimmed milk: largest errors of coefficients and matrix {worst:?}");
    assert!(worst.iter().all(|error| *error <= TOLERANCE), "{worst:?}");
}

#[test]
fn water_dilutes_all_but_itself() {
    let thin = Milk { dilution: 1.0 / 4000.0, ..WHOLE };
    let ratio = |thin: f64, full: f64| (thin / full * 4000.0 - 1.0).abs();
    let serums = [thin.serum(550.0), WHOLE.serum(550.0)];
    assert!(ratio(serums[0].sigma_a_riboflavin, serums[1].sigma_a_riboflavin) < 1e-12);
    assert_eq!(serums[0].sigma_a_water, serums[1].sigma_a_water);
    let [thin, full] = [thin, WHOLE].map(|milk| milk.suspension(550.0).scattering(512));
    assert!(ratio(thin.sigma_s, full.sigma_s) < 1e-12);
    assert!(ratio(thin.sigma_a, full.sigma_a) < 1e-12);
    for (thin, full) in thin.matrix.iter().zip(&full.matrix) {
        assert!((thin.m00 / full.m00 - 1.0).abs() < 1e-12);
    }
}
