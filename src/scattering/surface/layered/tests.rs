//! Layers against energy, reciprocity, densities, and the smooth models that they approach.

use std::f64::consts::PI;

use super::super::glossy::{GlossyLanes, GlossyTable};
use super::super::metallic_roughness::MetallicRoughness;
use super::super::model::{Connecting, LaneRows};
use super::super::rough::tests::{Numbers, directions};
use super::*;
use crate::math::{LANES, lanes};
use crate::polarization::Stokes;
use crate::polarization::kernel::Kernel;

type Model = Layered<1>;

fn plain(base_color: f32, metallic: f32, alpha: f32) -> Layers<[f32; 1]> {
    Layers {
        base_color: [base_color],
        metallic,
        alpha,
        ior: 1.5,
        specular: 1.0,
        specular_color: [1.0],
        transmission: 0.0,
        diffuse_transmission: 0.0,
        diffuse_transmission_color: [1.0],
        coat: 0.0,
        coat_alpha: 0.0,
        cloth_color: [0.0],
        cloth_alpha: 0.0,
    }
}

pub fn random(numbers: &mut Numbers, alpha_min: f32) -> Layers<[f32; 1]> {
    let alpha = |numbers: &mut Numbers| alpha_min + (1.0 - alpha_min) * numbers.next();
    // Half of all shares are none or all.
    let share = |numbers: &mut Numbers| (2.0 * numbers.next() - 0.5).clamp(0.0, 1.0);
    Layers {
        base_color: [share(numbers)],
        metallic: share(numbers) * share(numbers),
        alpha: alpha(numbers),
        ior: 1.0 + 1.5 * numbers.next(),
        specular: share(numbers),
        specular_color: [share(numbers)],
        transmission: share(numbers),
        diffuse_transmission: share(numbers),
        diffuse_transmission_color: [share(numbers)],
        coat: share(numbers),
        coat_alpha: alpha(numbers),
        cloth_color: [share(numbers)],
        cloth_alpha: alpha(numbers),
    }
}

fn facing(two_sided: bool) -> Facing {
    let up = Vector::splat([0.0, 0.0, 1.0]);
    Facing { geometric: up, shading: up, two_sided: lanes::mask_of([two_sided; LANES]) }
}

const ROWS: LaneRows = LaneRows::Same(0);

fn table(model: &Model) -> GlossyTable<'_, 1> {
    GlossyTable::Layered(std::slice::from_ref(model))
}

fn lanes_of(model: &Model) -> GlossyLanes<'_, 1> {
    table(model).lanes(&ROWS)
}

fn value(model: &Model, given: Vector<F32s>, drawn: Vector<F32s>) -> F32s {
    let [value] = GlossyTable::shape(&lanes_of(model), &facing(true), given, drawn, Side::Sensor);
    value
}

fn draw(model: &Model, given: Vector<F32s>, numbers: &mut Numbers) -> Drawn<1> {
    let u = [numbers.lanes(), numbers.lanes(), numbers.lanes()];
    table(model).draw((&ROWS, &lanes_of(model)), &facing(true), given, u, Side::Sensor)
}

/// The share of light of the cosine that leaves, its standard error, and what goes through.
fn albedo(model: &Model, cos: f32, numbers: &mut Numbers) -> [f64; 3] {
    const PACKETS: usize = 1000;
    const ALL: f64 = (PACKETS * LANES) as f64;
    let given = directions(F32s::splat(cos), F32s::splat(0.3));
    let (mut sum, mut squares, mut through) = (0.0, 0.0, 0.0);
    for _ in 0..PACKETS {
        let Drawn { direction, weight: [weight], .. } = draw(model, given, numbers);
        sum += f64::from(weight.reduce_add());
        squares += f64::from((weight * weight).reduce_add());
        let passes = (direction.z * given.z).simd_lt(F32s::splat(0.0));
        through += f64::from((passes & weight).reduce_add());
    }
    let mean = sum / ALL;
    [mean, ((squares / ALL - mean * mean) / ALL).sqrt(), through / ALL]
}

#[test]
fn plain_layers_are_metallic_roughness() {
    let mut numbers = Numbers(100);
    for _ in 0..100 {
        let color = numbers.next();
        let (metallic, alpha, ior) = (numbers.next(), numbers.next(), 1.0 + numbers.next());
        let specular = numbers.next();
        let layers = Layers { ior, specular, ..plain(color, metallic, alpha) };
        let model = Layered::of(layers);
        let other = MetallicRoughness::of([color], metallic, alpha, ior, specular);
        let other = GlossyTable::MetallicRoughness(std::slice::from_ref(&other));
        let (given, drawn) = (numbers.directions(), numbers.directions());
        let of = other.lanes(&ROWS);
        let facing = facing(false);
        let [expected] = GlossyTable::shape(&of, &facing, given, drawn, Side::Sensor);
        let ([own], axis) = GlossyTable::dense_kernels(&lanes_of(&model), &facing, -given, drawn);
        let ([kernel], its_axis) = GlossyTable::dense_kernels(&of, &facing, -given, drawn);
        let found = value(&model, given, drawn).to_array();
        for (found, expected) in found.into_iter().zip(expected.to_array()) {
            assert!((found - expected).abs() <= 1e-5 * expected, "{found} {expected} {layers:?}");
        }
        assert_eq!(axis, its_axis);
        let pairs = own.0.as_flattened().iter().zip(kernel.0.as_flattened());
        for (own, kernel) in pairs {
            assert!((*own - *kernel).abs().simd_lt(F32s::splat(1e-5)).all(), "{own:?} {kernel:?}");
        }
    }
}

/// A wall of white glass loses nothing, and layers over what is white add nothing.
#[test]
fn no_light_is_made_and_white_walls_lose_none() {
    let mut numbers = Numbers(200);
    for alpha in [0.25, 0.5, 1.0] {
        for cos in [0.15, 0.5, 0.95, -0.5] {
            for transmission in [0.4, 1.0] {
                let layers = Layers { transmission, ..plain(1.0, 0.0, alpha) };
                let [all, error, through] = albedo(&Layered::of(layers), cos, &mut numbers);
                // The stated error of albedos, and four standard errors: by chance in one of 16,000
                // cases, of which there are 24.
                assert!((all - 1.0).abs() < 0.012 + 4.0 * error, "{alpha} {cos}: {all}");
                assert!(through > 0.2 * f64::from(transmission), "{alpha} {cos}: {through}");
            }
        }
    }
    for _ in 0..40 {
        let layers = random(&mut numbers, 0.2);
        let cos = 0.1 + 0.9 * numbers.next();
        let model = Layered::of(layers);
        let [all, error, _] = albedo(&model, cos, &mut numbers);
        assert!(all < 1.012 + 4.0 * error, "{layers:?} {cos}: {all}");
        let near = f64::from(model.scattered());
        assert!(near > 0.4 * all - 0.1 && near <= 1.0, "{layers:?} {cos}: {all} {near}");
    }
}

#[test]
fn light_that_is_lit_through_is_shared() {
    let mut numbers = Numbers(300);
    let layers = Layers {
        diffuse_transmission: 0.75,
        specular: 0.0,
        diffuse_transmission_color: [0.8],
        ..plain(0.4, 0.0, 0.5)
    };
    let [all, _, through] = albedo(&Layered::of(layers), 0.6, &mut numbers);
    assert!((through - 0.6).abs() < 5e-3 && (all - 0.7).abs() < 5e-3, "{all} {through}");
}

#[test]
fn both_directions_are_alike() {
    let mut numbers = Numbers(400);
    for case in 0..300 {
        let layers = random(&mut numbers, 0.0);
        let model = Layered::of(layers);
        let (given, mut drawn) = (numbers.directions(), numbers.directions());
        if case % 2 == 0 {
            drawn = -drawn;
        }
        let there = value(&model, given, drawn).to_array();
        let back = value(&model, drawn, given).to_array();
        for (there, back) in there.into_iter().zip(back) {
            assert!((there - back).abs() <= 2e-3 * there + 1e-6, "{there} {back} {layers:?}");
        }
    }
}

/// Counts of draws in bins of the sphere against the density's sums over them.
#[test]
fn draws_have_their_densities() {
    const HEIGHTS: usize = 16;
    const TURNS: usize = 16;
    const FINE: usize = 16;
    const PACKETS: usize = 4096;
    let mut numbers = Numbers(500);
    for case in 0..8 {
        let layers = random(&mut numbers, 0.35);
        let model = Layered::of(layers);
        let cos = (0.1 + 0.85 * numbers.next()) * if case % 2 == 0 { 1.0 } else { -1.0 };
        let given = directions(F32s::splat(cos), F32s::splat(numbers.next()));
        let mut counts = [0.0_f64; HEIGHTS * TURNS];
        for _ in 0..PACKETS {
            let u = [numbers.lanes(), numbers.lanes(), numbers.lanes()];
            let drawn = table(&model).draw(
                (&ROWS, &lanes_of(&model)),
                &facing(true),
                given,
                u,
                Side::Sensor,
            );
            let values = drawn.weight[0].to_array();
            for ([x, y, z], weight) in drawn.direction.to_rows().into_iter().zip(values) {
                // Those are lost, and in no density.
                if weight == 0.0 {
                    continue;
                }
                let turn = (y.atan2(x) / std::f32::consts::TAU).rem_euclid(1.0);
                let turn = ((turn * TURNS as f32) as usize).min(TURNS - 1);
                let height = ((0.5 * z + 0.5) * HEIGHTS as f32) as usize;
                counts[height.min(HEIGHTS - 1) * TURNS + turn] += 1.0;
            }
        }
        let all = (PACKETS * LANES) as f64;
        let (of, mut chi2, mut freedom, mut rest) = (lanes_of(&model), 0.0, 0.0, [0.0; 2]);
        for (bin, count) in counts.into_iter().enumerate() {
            let mut sum = 0.0;
            for row in 0..FINE {
                let height = (bin / TURNS) as f32 + (row as f32 + 0.5) / FINE as f32;
                let cos = F32s::splat(2.0 * height / HEIGHTS as f32 - 1.0);
                for first in (0..FINE).step_by(LANES) {
                    let turns = lanes::each(|lane| {
                        let part = ((first + lane) as f32 + 0.5) / FINE as f32;
                        ((bin % TURNS) as f32 + part) / TURNS as f32
                    });
                    let drawn = directions(cos, F32s::from(turns));
                    let dark = value(&model, given, drawn).simd_le(F32s::splat(0.0));
                    let pdf = GlossyTable::pdf(&of, &facing(true), given, drawn);
                    sum += f64::from((!dark & pdf).reduce_add());
                }
            }
            let expected = all * sum * 4.0 * PI / (HEIGHTS * TURNS * FINE * FINE) as f64;
            if expected > 20.0 {
                chi2 += (count - expected).powi(2) / expected;
                freedom += 1.0;
            } else {
                rest = [rest[0] + count, rest[1] + expected];
            }
        }
        if rest[1] > 20.0 {
            chi2 += (rest[0] - rest[1]).powi(2) / rest[1];
        }
        // Wilson and Hilferty 1931: a standard normal number, above 4.2 in one of 75,000 cases.
        let part = 2.0 / (9.0 * freedom);
        let z = ((chi2 / freedom).cbrt() - (1.0 - part)) / f64::sqrt(part);
        assert!(z < 4.2, "case {case}: {chi2} of {freedom}, z {z}, {layers:?}, cos {cos}");
    }
}

#[test]
fn no_light_is_polarized_more_than_wholly() {
    let mut numbers = Numbers(600);
    for case in 0..400 {
        let layers = random(&mut numbers, 0.0);
        let model = Layered::of(layers);
        let mut given = numbers.directions();
        if case % 2 == 0 {
            given = -given;
        }
        let drawn = match case % 3 {
            0 => numbers.directions(),
            _ => draw(&model, given, &mut numbers).direction,
        };
        let ([kernel], axis) =
            GlossyTable::dense_kernels(&lanes_of(&model), &facing(true), -given, drawn);
        let value = value(&model, given, drawn);
        let pure =
            directions(numbers.lanes() * F32s::splat(2.0) - F32s::splat(1.0), numbers.lanes());
        let Stokes(s) = kernel.scatter(Stokes([F32s::splat(1.0), pure.x, pure.y, pure.z]));
        let polarized = (s[1] * s[1] + s[2] * s[2] + s[3] * s[3]).sqrt();
        for lane in 0..LANES {
            let [s0, polarized, value] = [s[0], polarized, value].map(|it| it.to_array()[lane]);
            assert!(value >= 0.0 && value.is_finite(), "{value}, {layers:?}");
            if value > 0.0 {
                assert!(polarized <= s0 + 1e-5, "{polarized} of {s0}, {layers:?}");
                let across = [given, drawn].map(|v| v.dot(axis).to_array()[lane].abs());
                assert!(across.iter().all(|it| *it < 2e-3), "{across:?}, {layers:?}");
            }
        }
    }
}

/// What a wall of hardly rough white glass lets through and reflects is what a smooth pane does.
#[test]
fn hardly_rough_walls_are_panes() {
    const PACKETS: usize = 4000;
    let layers = Layers { transmission: 1.0, ..plain(1.0, 0.0, 0.002) };
    let model = Layered::of(layers);
    let mut numbers = Numbers(700);
    for cos in [0.3_f32, -0.5, 0.8] {
        let given = directions(F32s::splat(cos), F32s::splat(0.0));
        let (k_in, across) = (-given, Vector::splat([0.0, 1.0, 0.0]));
        let light = [1.0_f32, 0.3, -0.6, 0.5];
        let mut sums = [[0.0; 4]; 2];
        for _ in 0..PACKETS {
            let Drawn { direction, weight: [weight], .. } = draw(&model, given, &mut numbers);
            let ([kernel], axis) =
                GlossyTable::dense_kernels(&lanes_of(&model), &facing(false), k_in, direction);
            let arriving =
                Rotation::between(across, axis, k_in).apply(Stokes(light.map(F32s::splat)));
            let to = across - direction * across.dot(direction);
            let Stokes(leaving) =
                Rotation::between(axis, to, direction).apply(kernel.scatter(arriving));
            let lit = weight.simd_gt(F32s::splat(0.0));
            let passes = (direction.z * given.z).simd_lt(F32s::splat(0.0));
            for (mask, sums) in [!passes, passes].into_iter().zip(&mut sums) {
                for (sum, component) in sums.iter_mut().zip(leaving) {
                    *sum += f64::from((mask & lit & (weight * component)).reduce_add());
                }
            }
        }
        let Pane { transmittance, transmission, reflection } = pane(f64::from(cos).abs(), 1.5);
        let blocks = [(1.0 - transmittance, reflection), (transmittance, transmission)];
        for ((m00, block), sums) in blocks.into_iter().zip(sums) {
            let Stokes(expected) = block.scatter(Stokes(light.map(f64::from)));
            for (found, expected) in sums.into_iter().zip(expected) {
                let (found, expected) = (found / (PACKETS * LANES) as f64, m00 * expected);
                // Of 32,000 draws: four standard errors and what facets of 0.1 degrees turn.
                assert!((found - expected).abs() < 0.012, "{cos}: {found} {expected}");
            }
        }
    }
}

/// An opaque surface of one side does nothing behind.
#[test]
fn backs_of_opaque_layers_are_black() {
    let layers = Layers { coat: 1.0, cloth_color: [0.5], ..plain(0.8, 0.3, 0.4) };
    let model = Layered::of(layers);
    let mut numbers = Numbers(800);
    let (given, drawn) = (-numbers.directions(), -numbers.directions());
    for (two_sided, lit) in [(false, false), (true, true)] {
        let [value] =
            GlossyTable::shape(&lanes_of(&model), &facing(two_sided), given, drawn, Side::Sensor);
        assert_eq!(value.simd_gt(F32s::splat(0.0)).all(), lit);
        assert_eq!(value.simd_gt(F32s::splat(0.0)).any(), lit);
    }
}
