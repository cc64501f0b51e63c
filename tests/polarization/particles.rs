//! Suspensions of spheres: sums over sizes against single spheres and against moments that are
//! known in closed form.

use std::f64::consts::PI;

use sunstone::internals::polarization::mie::MieSphere;
use sunstone::internals::polarization::particles::{Amount, Particles, Sizes, Suspension};

fn suspension(sizes: &Sizes, n: f64, k: f64) -> Suspension<'_> {
    let particles = vec![Particles { sizes, n, k, volume_fraction: 1e-3 }];
    Suspension { particles, host_n: 1.33, wavelength_nm: 550.0 }
}

/// The sums over symmetric angles are the series at each angle.
#[test]
fn one_size_is_one_sphere() {
    for (radius_um, n, k) in [(0.005, 1.5, 0.0), (0.3, 1.5, 0.01), (2.0, 1.2, 0.0), (5.0, 1.0, 0.1)]
    {
        let sizes = Sizes::monodisperse(radius_um).unwrap();
        let suspension = suspension(&sizes, n, k);
        let found = suspension.scattering(514);
        let x = 2.0 * PI * 1.33 / 0.55 * radius_um;
        assert!((suspension.size_parameter_max() / x - 1.0).abs() < 1e-12);
        let sphere = MieSphere::new(n / 1.33, k / 1.33, x);
        // Cross-section over volume, per meter.
        let scale = 1e-3 * 0.75 / radius_um * 1e6;
        assert!((found.sigma_s / (scale * sphere.q_sca) - 1.0).abs() < 1e-12);
        assert!((found.sigma_a - scale * (sphere.q_ext - sphere.q_sca)).abs() < 1e-9);
        assert!((found.g - sphere.g).abs() < 1e-12);
        assert_eq!(found.matrix.len(), 515);
        for (index, elements) in found.matrix.iter().enumerate() {
            let expected = sphere.phase((PI * index as f64 / 514.0).cos());
            for (a, b) in [
                (elements.m00, expected.m00),
                (elements.m01, expected.m01),
                (elements.m22, expected.m22),
                (elements.m23, expected.m23),
            ] {
                assert!((a - b).abs() <= 1e-9 * expected.m00, "{index}: {a} {b}");
            }
        }
    }
}

/// Where spheres are small, scattering goes as the third moment of the volume and absorption as
/// the volume itself.
#[test]
fn moments_of_distributions() {
    let (mean, sd): (f64, f64) = (0.002, 0.0006);
    let alone =
        |radius: f64| suspension(&Sizes::monodisperse(radius).unwrap(), 1.5, 0.0).scattering(4);
    let unit = alone(mean).sigma_s / mean.powi(3);
    let v = (sd / mean).powi(2);
    // E[r^j] over mean^j: log-normal (1 + v)^(j (j - 1) / 2), gamma the product of 1 + i v.
    let log_normal = |j: i32| (1.0 + v).powi(j * (j - 1) / 2);
    let gamma = |j: i32| (0..j).map(|i| 1.0 + f64::from(i) * v).product::<f64>();
    let cases = [
        (Sizes::log_normal(mean, sd, Amount::Volume, None), log_normal(3)),
        (Sizes::log_normal(mean, sd, Amount::Number, None), log_normal(6) / log_normal(3)),
        (Sizes::gamma(mean, sd, Amount::Volume, None), gamma(3)),
        (Sizes::gamma(mean, sd, Amount::Number, None), gamma(6) / gamma(3)),
    ];
    for (sizes, moment) in cases {
        let found = suspension(&sizes.unwrap(), 1.5, 0.0).scattering(4).sigma_s;
        let expected = unit * moment * mean.powi(3);
        assert!((found / expected - 1.0).abs() < 2e-3, "{found} {expected}");
    }
    // A triangle from a to b with its top at c: E[r^3] is the sum of all products of three of
    // them, each once, over 10.
    let radii = [0.1 * mean, mean, 2.0 * mean];
    let table = Sizes::table(&radii, &[0.0, 1.0, 0.0], Amount::Volume).unwrap();
    let third = 1.5731;
    let found = suspension(&table, 1.5, 0.0).scattering(4).sigma_s;
    assert!((found / (unit * third * mean.powi(3)) - 1.0).abs() < 2e-3, "{found}");
}

#[test]
fn two_kinds_of_particles_add_up() {
    let (small, large) = (Sizes::monodisperse(0.1).unwrap(), Sizes::monodisperse(1.0).unwrap());
    let [a, b] = [(&small, 1.6, 0.0), (&large, 1.4, 0.01)]
        .map(|(sizes, n, k)| suspension(sizes, n, k).scattering(64));
    let mut both = suspension(&small, 1.6, 0.0);
    both.particles.extend(suspension(&large, 1.4, 0.01).particles);
    let both = both.scattering(64);
    assert!((both.sigma_s / (a.sigma_s + b.sigma_s) - 1.0).abs() < 1e-12);
    assert!((both.sigma_a / (a.sigma_a + b.sigma_a) - 1.0).abs() < 1e-12);
    for (index, elements) in both.matrix.iter().enumerate() {
        let sum = a.sigma_s * a.matrix[index].m01 + b.sigma_s * b.matrix[index].m01;
        assert!((elements.m01 * both.sigma_s - sum).abs() < 1e-9 * both.sigma_s);
    }
}

#[test]
fn what_is_no_distribution_is_refused() {
    for (radii, density) in [
        (&[1.0][..], &[1.0][..]),
        (&[1.0, 2.0], &[1.0]),
        (&[2.0, 1.0], &[1.0, 1.0]),
        (&[1.0, 2.0], &[0.0, 0.0]),
        (&[1.0, 2.0], &[1.0, -1.0]),
        (&[1.0, 2.0], &[1.0, f64::NAN]),
        (&[-1.0, 2.0], &[1.0, 1.0]),
        (&[0.0, 2.0], &[1.0, 1.0]),
    ] {
        assert!(Sizes::table(radii, density, Amount::Number).is_err(), "{radii:?} {density:?}");
    }
    assert!(Sizes::log_normal(1.0, 0.01, Amount::Number, Some([500.0, 501.0])).is_err());
}

/// Radii of a sum that needs no nodes placed well: equally spaced, with ten times as many as would
/// do, at some angles.
const FINE: usize = 12_000;
/// Relative, and of the matrix relative to M00.
const RESOLVED: f64 = 1e-3;

/// Large globules, of size parameters up to 190, as in milk before it is homogenized; most that
/// comes back from them does so by interference, which too few sizes do not average out.
#[test]
fn large_spheres_are_resolved() {
    let (mean, sd, range): (f64, f64, [f64; 2]) = (2.0, 1.2, [0.005, 10.0]);
    let sizes = Sizes::log_normal(mean, sd, Amount::Volume, Some(range)).unwrap();
    let (n, k, host_n, wavelength_nm) = (1.468, 1e-5, 1.338, 450.0);
    let particles = vec![Particles { sizes: &sizes, n, k, volume_fraction: 1e-3 }];
    let suspension = Suspension { particles, host_n, wavelength_nm };
    let found = suspension.scattering(1440);
    let wave_number = 2.0 * PI * host_n / (1e-3 * wavelength_nm);
    let beta2 = (sd / mean).powi(2).ln_1p();
    let alpha = mean.ln() - 0.5 * beta2;
    let angles: Vec<usize> = (0..=24).map(|step| step * 60).collect();
    let mut sums = vec![[0.0; 4]; angles.len()];
    let [mut volume, mut scattered, mut absorbed, mut forwards] = [0.0; 4];
    for index in 0..FINE {
        let radius = range[0] + (range[1] - range[0]) * (index as f64 + 0.5) / FINE as f64;
        let share = (-0.5 * (radius.ln() - alpha).powi(2) / beta2).exp() / radius;
        let sphere = MieSphere::new(n / host_n, k / host_n, wave_number * radius);
        // Per volume of the sphere.
        let area = share * 0.75 / radius;
        volume += share;
        scattered += area * sphere.q_sca;
        absorbed += area * (sphere.q_ext - sphere.q_sca);
        forwards += area * sphere.q_sca * sphere.g;
        for (sums, &angle) in sums.iter_mut().zip(&angles) {
            let phase = sphere.phase((PI * angle as f64 / 1440.0).cos());
            let elements = [phase.m00, phase.m01, phase.m22, phase.m23];
            for (sum, element) in sums.iter_mut().zip(elements) {
                *sum += area * sphere.q_sca * element;
            }
        }
    }
    // Per meter.
    let scale = 1e-3 * 1e6 / volume;
    for (found, expected) in [
        (found.sigma_s, scale * scattered),
        (found.sigma_a, scale * absorbed),
        (found.g, forwards / scattered),
    ] {
        assert!((found / expected - 1.0).abs() < 1e-5, "{found} for {expected}");
    }
    let mut worst = 0.0_f64;
    for (&angle, sums) in angles.iter().zip(&sums) {
        let at = found.matrix[angle];
        let elements = [at.m00, at.m01, at.m22, at.m23];
        for (element, sum) in elements.into_iter().zip(sums) {
            worst = worst.max((element - sum / scattered).abs() * scattered / sums[0]);
        }
    }
    println!("greatest error of an element over M00: {worst:.1e}");
    assert!(worst < RESOLVED, "{worst}");
}
