//! Stretched facets against their definitions, and against the laws that every model has to obey.

use std::f64::consts::PI;

use super::super::blend::tests::{Tabled, alike, facing, pure, ways};
use super::super::rough::tests::{Numbers, directions};
use super::*;
use crate::math::LANES;
use crate::polarization::{Distribution, Kernel, Stokes};
use crate::scene::world::Along;

type Model = SurfaceModel<[f32; 1]>;

fn metal(eta: f32, k: f32, alpha: f32, of: (Distribution, bool)) -> Model {
    let (distribution, multiple_scattering) = of;
    Model::RoughConductor { eta: [eta], k: [k], alpha, distribution, multiple_scattering }
}

/// One of the models, of this roughness.
fn random(numbers: &mut Numbers, alpha: f32) -> Model {
    let [a, b, c] = [numbers.next(), numbers.next(), numbers.next()];
    let distribution = if c < 0.5 { Distribution::Ggx } else { Distribution::Beckmann };
    match (numbers.next() * 3.0) as u32 {
        0 => metal(0.05 + 3.0 * a, 7.0 * b, alpha, (distribution, true)),
        1 => Model::RoughDielectric {
            ior: [0.6 + a],
            exterior_ior: [1.0],
            alpha,
            distribution,
            multiple_scattering: true,
        },
        _ => Model::MetallicRoughness {
            base_color: [a],
            metallic: b,
            alpha,
            ior: 1.0 + c,
            specular: 1.0,
        },
    }
}

/// With other facets along a direction that is turned about the normal, by turns.
fn brushed(of: Model, along: f32, turns: f32) -> Model {
    let place = directions(F32s::ZERO, F32s::splat(turns)).to_rows()[0];
    let grain = Grain { place, ..Grain::new(Along::Alpha(along)) };
    Model::Brushed { of: Box::new(of), grain }
}

fn random_brushed(numbers: &mut Numbers, alpha_min: f32) -> Model {
    let [along, across] =
        [0, 1].map(|_| alpha_min + (1.0 - alpha_min) * numbers.next() * numbers.next());
    let of = random(numbers, across);
    brushed(of, along, numbers.next())
}

/// Facets that are as rough along as across are those of the plain model.
#[test]
fn even_facets_are_not_brushed() {
    let mut numbers = Numbers(110_000);
    for case in 0..60 {
        let alpha = 0.05 + 0.95 * numbers.next();
        let plain = random(&mut numbers, alpha);
        let model = brushed(plain.clone(), alpha, numbers.next());
        let (whole, plain) = (Tabled::new(&model), Tabled::new(&plain));
        let [given, drawn] = ways(&mut numbers, case);
        // Tails are exponentials of what is rounded: of the peak, they are alike.
        let peak = F32s::splat(0.05 / (alpha * alpha));
        let value = plain.value(given, drawn);
        let scale = value * F32s::splat(20.0) + peak;
        alike(whole.value(given, drawn), value, scale, &model);
        let pdf = plain.pdf(given, drawn);
        alike(whole.pdf(given, drawn), pdf, pdf * F32s::splat(20.0) + peak, &model);
        let light = pure(&mut numbers);
        let [found, expected] = [&whole, &plain].map(|it| it.scatter(given, drawn, light));
        for (found, expected) in found.into_iter().zip(expected) {
            alike(found, expected, scale + scale, &model);
        }
    }
}

/// D and L by slopes, from their definitions, of slopes of these roughnesses along x and y.
mod textbook {
    use super::*;

    fn density(distribution: Distribution, [a, b]: [f64; 2], h: [f64; 3]) -> f64 {
        let steepness = ((h[0] / a).powi(2) + (h[1] / b).powi(2)) / (h[2] * h[2]);
        let shape = match distribution {
            Distribution::Ggx => 1.0 / (PI * (1.0 + steepness).powi(2)),
            Distribution::Beckmann => (-steepness).exp() / PI,
        };
        // Of slopes, and of normals per steradian.
        shape / (a * b) / h[2].powi(4)
    }

    fn erf(x: f64) -> f64 {
        let at = |step: i32| (-((f64::from(step) + 0.5) * x / 4000.0).powi(2)).exp();
        (0..4000).map(at).sum::<f64>() * x / 4000.0 * 2.0 / PI.sqrt()
    }

    fn lambda(distribution: Distribution, [a, b]: [f64; 2], v: [f64; 3]) -> f64 {
        // The roughness along the direction, times the tangent.
        let slope = ((a * v[0]).powi(2) + (b * v[1]).powi(2)).sqrt() / v[2];
        match distribution {
            Distribution::Ggx => 0.5 * ((1.0 + slope * slope).sqrt() - 1.0),
            Distribution::Beckmann => {
                let a = 1.0 / slope;
                0.5 * (erf(a) - 1.0) + (-a * a).exp() / (2.0 * a * PI.sqrt())
            }
        }
    }

    /// D G2 / (4 cos cos) between directions.
    pub fn facets(of: Distribution, alpha: [f64; 2], [i, o]: [[f64; 3]; 2]) -> f64 {
        let sum: [f64; 3] = std::array::from_fn(|axis| i[axis] + o[axis]);
        let length = sum.iter().map(|x| x * x).sum::<f64>().sqrt();
        let [of_i, of_o] = [i, o].map(|v| lambda(of, alpha, v));
        density(of, alpha, sum.map(|x| x / length)) / (1.0 + of_i + of_o) / (4.0 * i[2] * o[2])
    }
}

#[test]
fn single_reflections_are_those_of_the_definitions() {
    let mut numbers = Numbers(120_000);
    for (distribution, tolerance) in [(Distribution::Ggx, 2e-4), (Distribution::Beckmann, 8e-3)] {
        for _ in 0..12 {
            let alpha = [0, 1].map(|_| 0.05 + 0.95 * numbers.next());
            // They reflect all light but what meets others.
            let mirrors = metal(1e-6, 1.0, alpha[1], (distribution, false));
            let model = Tabled::new(&brushed(mirrors, alpha[0], 0.0));
            let (given, drawn) = (numbers.directions(), numbers.directions());
            let values = model.value(given, drawn).to_array();
            for (lane, value) in values.into_iter().enumerate() {
                let both = [given, drawn].map(|v| v.to_rows()[lane].map(f64::from));
                let expected = textbook::facets(distribution, alpha.map(f64::from), both);
                let error = (f64::from(value) - expected).abs();
                assert!(error < tolerance * expected + 1e-9, "{alpha:?}: {value}, {expected}");
            }
        }
    }
}

/// All light comes back that lossless metal has reflected, to what is stated.
#[test]
fn lossless_facets_lose_little() {
    const PACKETS: usize = 800;
    let (mut numbers, mut worst) = (Numbers(130_000), 0.0_f64);
    for distribution in Distribution::ALL {
        for (alpha, cos) in
            [([0.5, 0.125], 0.1), ([0.5, 0.125], 0.9), ([0.2, 0.8], 0.3), ([1.0, 0.25], 0.6)]
        {
            let mirrors = metal(1e-6, 1.0, alpha[1], (distribution, true));
            let model = Tabled::new(&brushed(mirrors, alpha[0], 0.0));
            for turns in [0.0, 0.125, 0.25] {
                let given = directions(F32s::splat(cos), F32s::splat(turns));
                let (mut sum, mut squares) = (0.0, 0.0);
                for _ in 0..PACKETS {
                    let Drawn { weight: [weight], .. } = model.draw(given, &mut numbers);
                    sum += f64::from(weight.reduce_add());
                    squares += f64::from((weight * weight).reduce_add());
                }
                let all = (PACKETS * LANES) as f64;
                let mean = sum / all;
                let error = ((squares / all - mean * mean).max(0.0) / all).sqrt();
                println!("{distribution:?} {alpha:?} {cos} {turns}: {mean} {error}");
                // Four standard errors: by chance in one of 16,000 cases, of which there are 24.
                worst = worst.max((mean - 1.0).abs() - 4.0 * error);
            }
        }
    }
    assert!(worst < 0.06, "{worst}");
}

/// Surfaces that are turned with the light are the same.
#[test]
fn the_direction_turns_with_the_surface() {
    let mut numbers = Numbers(140_000);
    for _ in 0..40 {
        let (along, across) = (0.1 + 0.5 * numbers.next(), 0.1 + 0.9 * numbers.next());
        let of = random(&mut numbers, across);
        let heights = [0, 1].map(|_| numbers.lanes() * F32s::splat(0.9) + F32s::splat(0.05));
        let places = [numbers.lanes(), numbers.lanes()];
        let by = numbers.next();
        let wrapped = |turns: F32s| turns - turns.floor();
        let at = |turned: f32| {
            let model = Tabled::new(&brushed(of.clone(), along, turned));
            let [given, drawn] =
                [0, 1].map(|it| directions(heights[it], wrapped(places[it] + F32s::splat(turned))));
            (model.value(given, drawn), model.pdf(given, drawn))
        };
        let ((value, pdf), (turned, turned_pdf)) = (at(0.0), at(by));
        alike(turned, value, value * F32s::splat(200.0), &of);
        alike(turned_pdf, pdf, pdf * F32s::splat(200.0), &of);
    }
}

/// Opaque ones of one side are black from behind.
#[test]
fn backs_send_nothing_on() {
    let mut numbers = Numbers(190_000);
    let one_sided = Facing { two_sided: F32s::ZERO, ..facing() };
    for case in 0..40 {
        let of = match case % 2 {
            0 => metal(0.1, 6.0, 0.2, (Distribution::Ggx, true)),
            _ => Model::MetallicRoughness {
                base_color: [0.8],
                metallic: 0.5,
                alpha: 0.3,
                ior: 1.5,
                specular: 1.0,
            },
        };
        let model = Tabled::new(&brushed(of, 0.5, numbers.next()));
        let [front, back] = [0, 1].map(|way| ways(&mut numbers, way)[0]);
        let sum = |given, numbers: &mut Numbers| {
            model.draw_on(&one_sided, given, numbers).weight[0].reduce_add()
        };
        assert!(sum(front, &mut numbers) > 0.0, "the test cannot fail");
        assert_eq!(sum(back, &mut numbers), 0.0);
    }
}

/// Eight of them at once, of models that differ, are each what they are alone.
#[test]
fn lanes_do_not_mix() {
    let mut numbers = Numbers(150_000);
    for case in 0..10 {
        let models: [Model; LANES] = std::array::from_fn(|_| random_brushed(&mut numbers, 0.05));
        let mut tables = Surfaces::default();
        let rows = models.each_ref().map(|model| tables.append(model) as usize);
        let of = |rows| Tabled { tables: tables.clone(), kind: SurfaceKind::Brushed, rows };
        let all = of(LaneRows::Each(rows));
        let [given, drawn] = ways(&mut numbers, case);
        let light = pure(&mut numbers);
        let together = all.scatter(given, drawn, light);
        let starts = numbers.0;
        let taken = all.draw(given, &mut numbers);
        for lane in 0..LANES {
            let alone = of(LaneRows::Same(rows[lane]));
            for (found, expected) in together.into_iter().zip(alone.scatter(given, drawn, light)) {
                let [found, expected] = [found, expected].map(|it| it.to_array()[lane]);
                assert_eq!(found, expected, "{:?}", models[lane]);
            }
            let own = alone.draw(given, &mut Numbers(starts));
            let [found, expected] = [&taken, &own].map(|it| it.direction.to_rows()[lane]);
            assert_eq!(found, expected, "{:?}", models[lane]);
            assert_eq!(taken.pdf.to_array()[lane], own.pdf.to_array()[lane]);
        }
    }
}

/// What stays on one side is reciprocal, and no light is polarized more than wholly.
#[test]
fn both_directions_are_alike_and_matrices_are_physical() {
    let mut numbers = Numbers(160_000);
    for case in 0..150 {
        let model = random_brushed(&mut numbers, 0.0);
        let tabled = Tabled::new(&model);
        let [given, mut drawn] = ways(&mut numbers, case);
        if case % 2 == 0 {
            let [there, back] = [tabled.value(given, drawn), tabled.value(drawn, given)];
            let same = (given.z * drawn.z).simd_gt(F32s::ZERO);
            let off = (there - back).abs() - (there * F32s::splat(2e-3) + F32s::splat(1e-6));
            assert!((!same | off.simd_le(F32s::ZERO)).all(), "{there:?} {back:?} {model:?}");
        } else {
            drawn = tabled.draw(given, &mut numbers).direction;
        }
        let value = tabled.value(given, drawn);
        let (kernel, axis) = tabled.kernel(given, drawn);
        let Stokes(s) = kernel.scatter(Stokes(pure(&mut numbers)));
        let polarized = (s[1] * s[1] + s[2] * s[2] + s[3] * s[3]).sqrt();
        let lit = value.simd_gt(F32s::ZERO);
        assert!(!(lit & polarized.simd_gt(s[0] + F32s::splat(1e-5))).any(), "{model:?}");
        assert!(value.simd_ge(F32s::ZERO).all(), "{value:?}, {model:?}");
        for v in [given, drawn] {
            let across = v.dot(axis).abs().simd_lt(F32s::splat(2e-3));
            assert!((across | !lit).all(), "{axis:?}, {model:?}");
        }
    }
    assert_eq!(facing().shading.to_rows()[0], [0.0, 0.0, 1.0]);
}

/// Counts of draws in bins of the sphere against the density's sums over them.
#[test]
fn draws_have_their_densities() {
    let mut numbers = Numbers(170_000);
    for case in 0..8 {
        let model = random_brushed(&mut numbers, 0.35);
        let cos = (0.1 + 0.85 * numbers.next()) * if case % 4 == 0 { -1.0 } else { 1.0 };
        let given = directions(F32s::splat(cos), F32s::splat(numbers.next()));
        let z = Tabled::new(&model).score_of_draws(given, (16, 2000), &mut numbers);
        assert!(z < 4.2, "case {case}: z {z}, {model:?}, cos {cos}");
    }
}
