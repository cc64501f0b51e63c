//! What the base of plastic is, computed otherwise; the laws of all rough models are tested with
//! them ([`super::super::rough`]).

use std::f64::consts::PI;

use super::*;
use crate::math::LANES;
use crate::scattering::surface::rough::tests::{Model, Numbers, Said, coated as limit, directions};

const ALL: [InternalReflection; 3] = InternalReflection::ALL;

fn plastic(reflectance: f32, ior: f32, alpha: f32, within: InternalReflection) -> Model {
    coated(reflectance, ior, alpha, 1.0, within)
}

fn coated(
    reflectance: f32,
    ior: f32,
    alpha: f32,
    specular: f32,
    internal_reflection: InternalReflection,
) -> Model {
    let (exterior_ior, distribution) = (1.0, Distribution::Ggx);
    let coat = Coat { ior, exterior_ior, alpha, distribution, specular, internal_reflection };
    Model::Plastic(Plastic::of([reflectance], coat))
}

/// The base alone.
fn base(reflectance: f32, ior: f32, alpha: f32, within: InternalReflection) -> Model {
    coated(reflectance, ior, alpha, 0.0, within)
}

/// T_s and T_p by the cosines on both sides.
fn transmittances(ior: f64, cos: f64) -> [f64; 2] {
    let within = (1.0 - (1.0 - cos * cos) / (ior * ior)).sqrt();
    let passed = 4.0 * ior * cos * within;
    [passed / (cos + ior * within).powi(2), passed / (ior * cos + within).powi(2)]
}

fn mean_transmittance(ior: f64) -> f64 {
    const STEPS: usize = 4000;
    let at = |step: usize| {
        let cos = (step as f64 + 0.5) / STEPS as f64;
        let [s, p] = transmittances(ior, cos);
        cos * (s + p) / STEPS as f64
    };
    (0..STEPS).map(at).sum()
}

#[test]
fn white_bases_reflect_what_facets_do_not() {
    for within in [InternalReflection::Linear, InternalReflection::Nonlinear] {
        for (alpha, ior) in [(0.0, 1.5), (0.004, 1.5), (0.3, 1.2)] {
            for cos in [0.0175, 0.07, 0.2, 1.0] {
                let albedo = plastic(1.0, ior, alpha, within).albedo(cos);
                assert!((albedo - 1.0).abs() < limit(alpha), "{alpha} {ior} {cos}: {albedo}");
            }
        }
    }
}

/// With nothing given back, what gets in and out: Fresnel's transmittances alone.
#[test]
fn bases_that_lose_light_reflect_what_gets_in_and_out() {
    for ior in [1.1_f32, 2.4] {
        for cos in [0.2_f32, 0.8] {
            let [s, p] = transmittances(f64::from(ior), f64::from(cos));
            let expected = 0.7 * 0.5 * (s + p) * mean_transmittance(f64::from(ior));
            let found = base(0.7, ior, 0.2, InternalReflection::Lost).albedo(cos);
            assert!((found - expected).abs() < 2e-3, "{ior} {cos}: {found}, {expected}");
        }
        for alpha in [0.1, 1.0] {
            for cos in [0.05, 1.0] {
                let whole = plastic(1.0, ior, alpha, InternalReflection::Lost).albedo(cos);
                assert!(whole < 1.0, "{ior} {alpha} {cos}: {whole}");
            }
        }
    }
}

/// Smooth: what is reflected within, once, twice and so on, summed up.
#[test]
fn light_that_is_reflected_within_comes_out_later() {
    let (ior, cos) = (1.5_f64, 0.7_f64);
    let [s, p] = transmittances(ior, cos);
    let (in_, out) = (0.5 * (s + p), mean_transmittance(ior) / (ior * ior));
    for r in [0.1_f64, 0.5, 0.9] {
        let rounds = |of_more: f64| {
            let (mut sum, mut left) = (0.0, in_ * r);
            for _ in 0..1000 {
                sum += left * out;
                left *= (1.0 - out) * of_more;
            }
            sum
        };
        for (within, expected) in
            [(InternalReflection::Nonlinear, rounds(r)), (InternalReflection::Linear, rounds(1.0))]
        {
            let found = base(r as f32, ior as f32, 0.0, within).albedo(cos as f32);
            assert!((found - expected).abs() < 0.01 * expected, "{r}: {found}, {expected}");
        }
    }
}

/// The matrices in the frames of both planes of incidence, multiplied out.
#[test]
fn bases_are_two_refractions_about_a_depolarizer() {
    let mut numbers = Numbers(7000);
    let mut seen = 0;
    for case in 0..60 {
        let ior = [1.1, 1.6, 2.5][case % 3];
        let model = base(numbers.next(), ior, 0.5, ALL[case / 3 % 3]);
        let (given, drawn) = (numbers.directions(), numbers.directions());
        let Said { kernel: Dense(found), axis, .. } = model.say(given, drawn);
        let [given, drawn, axis] = [given, drawn, axis].map(|v| v.to_rows());
        for lane in 0..LANES {
            let [i, o, x] = [given[lane], drawn[lane], axis[lane]].map(|v| v.map(f64::from));
            // Angles of the axis from the s axes, z x k, about the light.
            let [k_in, k_out] = [i.map(|c| -c), o];
            let angle = |k: [f64; 3]| {
                let s = [-k[1], k[0], 0.0];
                let along: f64 = (0..3).map(|c| s[c] * x[c]).sum();
                let y = [
                    k[1] * s[2] - k[2] * s[1],
                    k[2] * s[0] - k[0] * s[2],
                    k[0] * s[1] - k[1] * s[0],
                ];
                let across: f64 = (0..3).map(|c| y[c] * x[c]).sum();
                across.atan2(along)
            };
            let a = |cos: f64| {
                let [s, p] = transmittances(f64::from(ior), cos);
                (s - p) / (s + p)
            };
            let turned =
                |a: f64, angle: f64| [1.0, a * (2.0 * angle).cos(), -a * (2.0 * angle).sin(), 0.0];
            // A state seen from an axis at an angle; a row takes states of that axis.
            let column = turned(a(o[2]), angle(k_out));
            let row = turned(a(i[2]), angle(k_in));
            for (r, c) in (0..4).flat_map(|r| (0..4).map(move |c| (r, c))) {
                let (found, expected) = (found[r][c].to_array()[lane], column[r] * row[c]);
                let error = (f64::from(found) - expected).abs();
                assert!(error < 2e-4, "{case} {r} {c}: {found}, {expected}");
                seen += usize::from(expected.abs() > 0.01 && r * c == 4);
            }
        }
    }
    assert!(seen > 20, "{seen} elements that no block has");
}

/// Light that leaves towards grazing is polarized in the plane of the normal: S1 about the axis
/// across it is below zero, as much as Fresnel says.
#[test]
fn unpolarized_light_leaves_polarized_along_the_normals_plane() {
    let model = base(0.8, 1.5, 0.3, InternalReflection::Nonlinear);
    let up = Vector::splat([0.0, 0.0, 1.0]);
    for cos in [0.15_f32, 0.5, 0.8] {
        let drawn = directions(F32s::splat(cos), F32s::splat(0.1));
        let given = directions(F32s::splat(0.9), F32s::splat(0.35));
        let Said { kernel, axis, .. } = model.say(given, drawn);
        let state = crate::polarization::Kernel::first_stokes(kernel);
        let Stokes([s0, s1, s2, s3]) = Rotation::between(axis, up.cross(drawn), drawn).apply(state);
        let [s, p] = transmittances(1.5, f64::from(cos));
        let of = |v: F32s| f64::from(v.to_array()[0]);
        assert!((of(s1) / of(s0) - (s - p) / (s + p)).abs() < 1e-5 && of(s1) < -0.01);
        assert!(of(s2).abs() < 1e-5 && of(s3) == 0.0);
    }
}

/// Without an interface it is Lambertian.
#[test]
fn matched_indices_leave_the_base() {
    for within in ALL {
        let model = plastic(0.6, 1.0, 0.2, within);
        let Said { value, kernel: Dense(of), .. } = model.say(
            directions(F32s::splat(0.4), F32s::splat(0.2)),
            directions(F32s::splat(0.9), F32s::splat(0.7)),
        );
        let value = f64::from(value.to_array()[0]);
        assert!((value - 0.6 / PI).abs() < 1e-6, "{value}");
        let rest = of.as_flattened()[1..].iter().map(|element| element.to_array()[0].abs());
        assert!(rest.fold(0.0, f32::max) < 1e-6);
    }
}
