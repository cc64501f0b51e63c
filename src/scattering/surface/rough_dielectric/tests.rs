//! Rough glass against its definitions, energy, reciprocity and densities.

use std::f64::consts::PI;

use super::super::glossy::{GlossyLanes, GlossyTable};
use super::super::model::{Connecting, LaneRows};
use super::*;
use crate::math::hash::{combine, mix};
use crate::math::{LANES, lanes};
use crate::polarization::kernel::Kernel;
use crate::polarization::{Rotation, Stokes};

/// Numbers in [0, 1) that depend on nothing but their place.
struct Numbers(u32);

impl Numbers {
    fn next(&mut self) -> f32 {
        self.0 += 1;
        (mix(combine(11, self.0)) >> 8) as f32 / (1 << 24) as f32
    }

    fn lanes(&mut self) -> F32s {
        let mut numbers = [0.0; LANES];
        numbers.iter_mut().for_each(|number| *number = self.next());
        F32s::from(numbers)
    }

    /// Directions from everywhere but grazing ones, on the side of the sign.
    fn directions(&mut self, sign: f32) -> Vector<F32s> {
        let cos = F32s::splat(sign) * (F32s::splat(0.98) * self.lanes() + F32s::splat(0.02));
        directions(cos, self.lanes())
    }
}

fn directions(cos: F32s, turns: F32s) -> Vector<F32s> {
    let sin = (F32s::splat(1.0) - cos * cos).sqrt();
    let (sine, cosine) = warp::sin_cos_turns(turns);
    Vector::new(sin * cosine, sin * sine, cos)
}

fn facing() -> Facing {
    let up = Vector::splat([0.0, 0.0, 1.0]);
    Facing { geometric: up, shading: up, two_sided: F32s::splat(0.0) }
}

type Glass = RoughDielectric<1>;

fn glass(ior: f32, alpha: f32, distribution: Distribution, multiple_scattering: bool) -> Glass {
    RoughDielectric::of([ior], [1.0], alpha, distribution, multiple_scattering)
}

fn random(numbers: &mut Numbers, alpha_min: f32) -> Glass {
    let alpha = alpha_min + (1.0 - alpha_min) * numbers.next();
    // Of nearly the same indices lobes are narrow whatever the roughness.
    let indices =
        if alpha_min < 0.2 { [0.7, 1.1, 1.33, 1.5, 2.4] } else { [0.6, 0.7, 1.5, 2.0, 2.4] };
    let ior = indices[(numbers.next() * 5.0) as usize];
    let distribution = Distribution::ALL[usize::from(numbers.next() < 0.5)];
    glass(ior, alpha, distribution, numbers.next() < 0.7)
}

const ROWS: LaneRows = LaneRows::Same(0);

fn table(model: &Glass) -> GlossyTable<'_, 1> {
    GlossyTable::RoughDielectric(std::slice::from_ref(model))
}

fn lanes_of(model: &Glass) -> GlossyLanes<'_, 1> {
    table(model).lanes(&ROWS)
}

fn draw(model: &Glass, given: Vector<F32s>, numbers: &mut Numbers, side: Side) -> Drawn<1> {
    let u = [numbers.lanes(), numbers.lanes(), numbers.lanes()];
    table(model).draw((&ROWS, &lanes_of(model)), &facing(), given, u, side)
}

/// The share of light of a cosine that leaves, its standard error, and the part that goes through.
fn albedo(model: &Glass, cos: f32, numbers: &mut Numbers) -> [f64; 3] {
    const PACKETS: usize = 1000;
    const ALL: f64 = (PACKETS * LANES) as f64;
    let given = directions(F32s::splat(cos), F32s::splat(0.0));
    let (mut sum, mut squares, mut through) = (0.0, 0.0, 0.0);
    for _ in 0..PACKETS {
        let Drawn { direction, weight: [weight], .. } = draw(model, given, numbers, Side::Light);
        sum += f64::from(weight.reduce_add());
        squares += f64::from((weight * weight).reduce_add());
        let passes = (direction.z * given.z).simd_lt(F32s::splat(0.0));
        through += f64::from((passes & weight).reduce_add());
    }
    let mean = sum / ALL;
    [mean, ((squares / ALL - mean * mean).max(0.0) / ALL).sqrt(), through / ALL]
}

#[test]
fn all_light_leaves_if_multiple_scattering_is_there() {
    /// Of the difference of two shares that are a half, of 8,000 directions each.
    const COUNT: f64 = 0.0079;
    let mut numbers = Numbers(0);
    for distribution in Distribution::ALL {
        for (ior, alpha) in
            [(1.5, 0.01), (1.5, 0.2), (1.5, 0.6), (1.5, 1.0), (2.4, 0.5), (0.7, 0.5)]
        {
            for cos in [0.02, 0.1, 0.4, 0.9, -0.02, -0.1, -0.4, -0.9] {
                let [all, once] = [true, false].map(|multiple| {
                    albedo(&glass(ior, alpha, distribution, multiple), cos, &mut numbers)
                });
                // The stated error of albedos, and four standard errors: by chance in one of 16,000
                // cases, of which there are 120.
                let [all, error, through] = all;
                assert!((all - 1.0).abs() < 0.006 + 4.0 * error, "{ior} {alpha} {cos}: {all}");
                let [once, error, through_once] = once;
                assert!(once < 1.0 + 4.0 * error, "{ior} {alpha} {cos}: {once}");
                // Both are counts, of a share of at most this error.
                assert!(through > through_once - 6.0 * COUNT, "{ior} {alpha} {cos}: {through}");
            }
        }
    }
}

#[test]
fn both_directions_are_alike_but_for_the_index() {
    let mut numbers = Numbers(1000);
    for case in 0..400 {
        let model = random(&mut numbers, 0.05);
        let (above, other) = (numbers.directions(1.0), numbers.directions([1.0, -1.0][case % 2]));
        let of = lanes_of(&model);
        let value = |given, drawn, side| {
            let [value] = GlossyTable::shape(&of, &facing(), given, drawn, side);
            value.to_array()
        };
        let there = value(above, other, Side::Sensor);
        let back = value(other, above, Side::Sensor);
        let adjoint = value(other, above, Side::Light);
        let square = if case % 2 == 1 { model.ior[0] * model.ior[0] } else { 1.0 };
        for lane in 0..LANES {
            // Radiance along one way, and power the other.
            assert_eq!(there[lane] > 0.0, back[lane] > 0.0, "{model:?}");
            let error = (there[lane] - adjoint[lane]).abs();
            assert!(error <= 2e-3 * there[lane] + 1e-6, "{} {}", there[lane], adjoint[lane]);
            let error = (there[lane] * square - back[lane]).abs();
            assert!(error <= 2e-3 * back[lane] + 1e-6, "{} {}", there[lane], back[lane]);
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
    let mut numbers = Numbers(2000);
    for case in 0..8 {
        let model = random(&mut numbers, 0.35);
        let cos = (0.1 + 0.85 * numbers.next()) * if case % 2 == 0 { 1.0 } else { -1.0 };
        let given = directions(F32s::splat(cos), F32s::splat(numbers.next()));
        let mut counts = [0.0_f64; HEIGHTS * TURNS];
        for _ in 0..PACKETS {
            let drawn = draw(&model, given, &mut numbers, Side::Sensor);
            let weight = drawn.weight[0].to_array();
            for ([x, y, z], weight) in drawn.direction.to_rows().into_iter().zip(weight) {
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
        let (of, mut chi2, mut freedom) = (lanes_of(&model), 0.0, 0.0);
        let mut rest = [0.0; 2];
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
                    let pdf = GlossyTable::pdf(&of, &facing(), given, drawn);
                    sum += f64::from(pdf.reduce_add());
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
        assert!(z < 4.2, "case {case}: {chi2} of {freedom}, z {z}, {model:?}, cos {cos}");
    }
}

#[test]
fn no_light_is_polarized_more_than_wholly() {
    let mut numbers = Numbers(3000);
    for case in 0..400 {
        let model = random(&mut numbers, 0.0);
        let given = numbers.directions([1.0, -1.0][case % 2]);
        let drawn = match case % 3 {
            0 => numbers.directions([1.0, -1.0][case / 2 % 2]),
            _ => draw(&model, given, &mut numbers, Side::Light).direction,
        };
        let of = lanes_of(&model);
        let ([kernel], axis) =
            <GlossyTable<'_, 1> as Connecting<1>>::kernels(&of, &facing(), -given, drawn);
        let [value] = GlossyTable::shape(&of, &facing(), given, drawn, Side::Light);
        let pure =
            directions(numbers.lanes() * F32s::splat(2.0) - F32s::splat(1.0), numbers.lanes());
        let Stokes(s) = kernel.scatter(Stokes([F32s::splat(1.0), pure.x, pure.y, pure.z]));
        let polarized = (s[1] * s[1] + s[2] * s[2] + s[3] * s[3]).sqrt();
        for lane in 0..LANES {
            let [s0, polarized, value] = [s[0], polarized, value].map(|it| it.to_array()[lane]);
            assert!(value >= 0.0 && value.is_finite(), "{value}, {model:?}");
            if value > 0.0 {
                assert!(polarized <= s0 + 1e-5, "{polarized} of {s0}, {model:?}");
                let across = [given, drawn].map(|v| v.dot(axis).to_array()[lane].abs());
                assert!(across.iter().all(|it| *it < 2e-3), "{across:?}, {model:?}");
            }
        }
    }
}

/// Light of a Stokes vector about the axis across the plane of incidence that goes through: the
/// mean of what is drawn, and is not reflected.
fn refracted(model: &Glass, cos: f32, light: [f32; 4]) -> [f64; 4] {
    let given = directions(F32s::splat(cos), F32s::splat(0.0));
    let (k_in, across) = (-given, Vector::splat([0.0, 1.0, 0.0]));
    let (mut sums, mut numbers, of) = ([0.0; 4], Numbers(4000), lanes_of(model));
    const PACKETS: usize = 4000;
    for _ in 0..PACKETS {
        let Drawn { direction, weight: [weight], .. } =
            draw(model, given, &mut numbers, Side::Light);
        let ([kernel], axis) =
            <GlossyTable<'_, 1> as Connecting<1>>::kernels(&of, &facing(), k_in, direction);
        let arriving = Rotation::between(across, axis, k_in).apply(Stokes(light.map(F32s::splat)));
        let to = across - direction * across.dot(direction);
        let Stokes(leaving) =
            Rotation::between(axis, to, direction).apply(kernel.scatter(arriving));
        let passes =
            (direction.z * given.z).simd_lt(F32s::splat(0.0)) & weight.simd_gt(F32s::splat(0.0));
        for (sum, component) in sums.iter_mut().zip(leaving) {
            *sum += f64::from((passes & (weight * component)).reduce_add());
        }
    }
    sums.map(|sum| sum / (PACKETS * LANES) as f64)
}

#[test]
fn hardly_rough_glass_is_as_smooth_glass() {
    for distribution in Distribution::ALL {
        for (ior, cos) in [(1.5, 0.4), (1.5, -0.9), (2.4, 0.7), (0.75, 0.9)] {
            let model = glass(ior, 0.002, distribution, true);
            let light = [1.0, 0.2, -0.6, 0.5];
            let eta = if cos > 0.0 { f64::from(ior) } else { 1.0 / f64::from(ior) };
            let face = fresnel::dielectric(f64::from(cos).abs(), eta);
            let Stokes(expected) = face.transmission.scatter(Stokes(light.map(f64::from)));
            let found = refracted(&model, cos, light);
            for (found, expected) in found.into_iter().zip(expected) {
                let expected = face.transmittance * expected;
                // Of 32,000 draws: four standard errors and what facets of 0.1 degrees turn.
                assert!((found - expected).abs() < 0.012, "{ior} {cos}: {found} {expected}");
            }
        }
    }
}

/// Of GGX, by Walter's equation 21, summed over directions below in double precision.
#[test]
fn what_goes_through_is_as_defined() {
    let (ior, alpha, cos) = (1.5_f64, 0.4_f64, 0.6_f64);
    let model = glass(ior as f32, alpha as f32, Distribution::Ggx, false);
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let i = [(1.0 - cos * cos).sqrt(), 0.0, cos];
    let g1 = |c: f64| 2.0 / (1.0 + (1.0 + alpha * alpha * (1.0 - c * c) / (c * c)).sqrt());
    let of = lanes_of(&model);
    let mut numbers = Numbers(5000);
    for _ in 0..50 {
        let drawn = numbers.directions(-1.0);
        let given = Vector::splat(i.map(|x| x as f32));
        let [found] = GlossyTable::shape(&of, &facing(), given, drawn, Side::Light);
        for (o, found) in drawn.to_rows().into_iter().zip(found.to_array()) {
            let o = o.map(f64::from);
            let sum: [f64; 3] = std::array::from_fn(|axis| -(i[axis] + ior * o[axis]));
            let length = dot(sum, sum).sqrt();
            let h = sum.map(|x| x / length);
            let (ih, oh) = (dot(i, h), dot(o, h));
            let expected = if h[2] > 0.0 && ih > 0.0 && oh < 0.0 {
                let tan2 = (1.0 - h[2] * h[2]) / (h[2] * h[2]);
                let d = alpha * alpha / (PI * h[2].powi(4) * (alpha * alpha + tan2).powi(2));
                let (reflectance, _) = fresnel::dielectric_reflectance(ih, ior);
                (1.0 - reflectance) * ih * -oh * ior * ior * d * g1(i[2]) * g1(-o[2])
                    / (i[2] * -o[2] * (ih + ior * oh).powi(2))
            } else {
                0.0
            };
            let error = (f64::from(found) - expected).abs();
            assert!(error < 1e-3 * expected + 1e-5, "{found} {expected}");
        }
    }
}

#[test]
fn wavelengths_of_dispersive_glass_have_a_density_in_common() {
    let model = RoughDielectric::of([1.45, 1.5, 1.6], [1.0; 3], 0.3, Distribution::Ggx, true);
    let table = GlossyTable::RoughDielectric(std::slice::from_ref(&model));
    let (of, mut numbers) = (table.lanes(&ROWS), Numbers(6000));
    let given = directions(F32s::splat(0.7), F32s::splat(0.2));
    let mut sums = [0.0; 3];
    const PACKETS: usize = 5000;
    for _ in 0..PACKETS {
        let u = [numbers.lanes(), numbers.lanes(), numbers.lanes()];
        let drawn = table.draw((&ROWS, &of), &facing(), given, u, Side::Light);
        for (sum, weight) in sums.iter_mut().zip(drawn.weight) {
            *sum += f64::from(weight.reduce_add()) / (PACKETS * LANES) as f64;
        }
    }
    // None is lost, but for the albedo's error and that of its index, which is the mean.
    for sum in sums {
        assert!((sum - 1.0).abs() < 0.015, "{sums:?}");
    }
}
