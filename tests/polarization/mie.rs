//! Spheres against published efficiencies, amplitudes and phase matrices.

use std::f64::consts::PI;

use sunstone::internals::polarization::mie::MieSphere;
use sunstone::internals::polarization::rayleigh::{rayleigh, rayleigh_depolarized, rayleigh_phase};
use sunstone::internals::polarization::{Block, Kernel, SpheroidBlock, Stokes};

/// Relative, against an independent double-precision code.
const TOLERANCE: f64 = 1e-10;

/// The rows of a table without its header.
fn rows(table: &str) -> impl Iterator<Item = Vec<&str>> {
    table.lines().skip(1).map(|line| line.split(',').collect())
}

fn number(cell: &str) -> f64 {
    cell.parse().expect("a number")
}

fn relative_error(found: f64, expected: f64) -> f64 {
    ((found - expected) / expected).abs()
}

/// Two units of the last printed digit, for much was computed in single precision.
fn printed_precision(cell: &str) -> f64 {
    let (digits, exponent) = cell.split_once('e').unwrap_or((cell, "0"));
    let decimals = digits.split_once('.').map_or(0, |(_, decimals)| decimals.len() as i32);
    let exponent: i32 = exponent.parse().expect("an exponent");
    2.0 * 10.0_f64.powi(exponent - decimals)
}

/// Wiscombe's test cases and Bohren and Huffman's, as printed and as another code computes them.
#[test]
fn published_efficiencies() {
    let mut worst = 0.0_f64;
    for row in rows(include_str!("../data/mie/published_efficiencies.csv")) {
        let sphere = MieSphere::new(number(row[1]), number(row[2]), number(row[3]));
        let found = [sphere.q_ext, sphere.q_sca, sphere.g];
        for ((value, printed), computed) in found.into_iter().zip(&row[4..7]).zip(&row[7..10]) {
            let error = relative_error(value, number(computed));
            assert!(error <= TOLERANCE, "{}: {value} is not {computed}", row[0]);
            worst = worst.max(error);
            if !printed.is_empty() {
                let error = (value - number(printed)).abs();
                assert!(error <= printed_precision(printed), "{}: {value}, {printed}", row[0]);
            }
        }
    }
    println!("published efficiencies: largest relative error {worst:e}");
}

#[test]
fn efficiencies_of_single_spheres() {
    let mut worst = 0.0_f64;
    for row in rows(include_str!("../data/mie/single_spheres_eff.csv")) {
        let sphere = MieSphere::new(number(row[1]), number(row[2]), number(row[3]));
        for (value, expected) in [sphere.q_ext, sphere.q_sca, sphere.g].iter().zip(&row[4..7]) {
            worst = worst.max(relative_error(*value, number(expected)));
        }
    }
    println!("single spheres: largest relative error {worst:e}");
    assert!(worst <= TOLERANCE);
}

#[test]
fn phase_matrices_of_single_spheres() {
    let mut worst = 0.0_f64;
    for row in rows(include_str!("../data/mie/single_spheres.csv")) {
        let sphere = MieSphere::new(number(row[1]), number(row[2]), number(row[3]));
        let phase = sphere.phase(number(row[4]).to_radians().cos());
        let expected = [5, 6, 7, 8].map(|column| number(row[column]));
        worst = worst.max(relative_error(phase.m00, expected[0]));
        for (value, expected) in [phase.m01, phase.m22, phase.m23].iter().zip(&expected[1..]) {
            worst = worst.max((value - expected).abs() / phase.m00);
        }
        let (m00, Block { a, c, s }) = phase.block();
        assert_eq!(m00, phase.m00);
        assert!((a * a + c * c + s * s - 1.0).abs() <= 1e-12);
    }
    println!("phase matrices: largest error over M00 {worst:e}");
    assert!(worst <= TOLERANCE);
}

/// Wiscombe's amplitudes of m = 1.5 - i, x = 1, printed to six digits.
#[test]
fn published_amplitudes() {
    let sphere = MieSphere::new(1.5, 1.0, 1.0);
    for row in rows(include_str!("../data/mie/wiscombe_amplitudes_m1.5-1i_x1.csv")) {
        let (s1, s2) = sphere.amplitudes(number(row[0]).to_radians().cos());
        for (value, printed) in [s1.re, s1.im, s2.re, s2.im].iter().zip(&row[1..]) {
            assert!((value - number(printed)).abs() <= printed_precision(printed));
        }
    }
}

/// The sample output of Bohren and Huffman's program, signs included.
#[test]
fn published_phase_matrix() {
    let sphere = MieSphere::new(1.55, 0.0, 2.0 * PI * 0.525 / 0.6328);
    let forward = sphere.phase(1.0).m00;
    for row in rows(include_str!("../data/mie/bohren_huffman_table.csv")) {
        let phase = sphere.phase(number(row[0]).to_radians().cos());
        let found = [
            phase.m00 / forward,
            phase.m01 / phase.m00,
            phase.m22 / phase.m00,
            phase.m23 / phase.m00,
        ];
        for (value, printed) in found.iter().zip(&row[1..]) {
            assert!((value - number(printed)).abs() <= 1e-6);
        }
    }
}

/// Integral over the sphere of directions by the midpoint rule in the angle.
fn integrate(f: impl Fn(f64) -> f64) -> f64 {
    let count = 20_000;
    let step = PI / f64::from(count);
    let ring = |i: i32| {
        let theta = step * (f64::from(i) + 0.5);
        2.0 * PI * theta.sin() * step * f(theta.cos())
    };
    (0..count).map(ring).sum()
}

#[test]
fn phase_functions_integrate_to_one() {
    for (n, k, x) in [(1.33, 0.0, 0.1), (1.5, 0.0, 2.0), (1.5, 0.1, 5.0), (0.75, 0.0, 10.0)] {
        let sphere = MieSphere::new(n, k, x);
        assert!((integrate(|cos| sphere.phase(cos).m00) - 1.0).abs() <= 1e-7);
        assert!((integrate(|cos| cos * sphere.phase(cos).m00) - sphere.g).abs() <= 1e-7);
    }
    assert!((integrate(rayleigh_phase) - 1.0).abs() <= 1e-7);
    assert!((integrate(|cos| rayleigh_depolarized(cos, 0.1).0) - 1.0).abs() <= 1e-7);
}

#[test]
fn small_spheres_scatter_as_dipoles() {
    let sphere = MieSphere::new(1.33, 0.0, 1e-3);
    for degrees in [0.0_f64, 20.0, 45.0, 70.0, 90.0, 120.0, 180.0] {
        let cos_theta = degrees.to_radians().cos();
        let (m00, block) = rayleigh(cos_theta);
        assert_eq!(m00, rayleigh_phase(cos_theta));
        let (mie_m00, mie_block) = sphere.phase(cos_theta).block();
        assert!(relative_error(mie_m00, m00) <= 1e-5);
        let differences = [mie_block.a - block.a, mie_block.c - block.c, mie_block.s - block.s];
        assert!(differences.iter().all(|difference| difference.abs() <= 1e-5));
    }
}

/// Hansen and Travis 1974: the two intensities at 90 degrees have the stated ratio, and dipoles
/// that are isotropic are Rayleigh's.
#[test]
fn anisotropic_molecules() {
    for depolarization in [0.0_f64, 0.0279, 0.1, 0.5] {
        let (_, SpheroidBlock { a, .. }) = rayleigh_depolarized(0.0, depolarization);
        assert!((a - (1.0 - depolarization) / (1.0 + depolarization)).abs() <= 1e-15);
    }
    for cos_theta in [-1.0_f64, -0.3, 0.0, 0.6, 1.0] {
        let (m00, Block { a, c, s }) = rayleigh(cos_theta);
        let (six_m00, six) = rayleigh_depolarized(cos_theta, 0.0);
        assert!((six_m00 - m00).abs() <= 1e-16);
        let stokes = Stokes([1.0_f64, 0.2, -0.4, 0.5]);
        let (four, six) = (Block { a, c, s }.scatter(stokes), six.scatter(stokes));
        for (x, y) in four.0.iter().zip(six.0) {
            assert!((x - y).abs() <= 1e-15);
        }
    }
}
