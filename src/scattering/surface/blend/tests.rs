//! Blends against their parts, and against the laws that every model has to obey.

use std::f64::consts::PI;

use super::super::diffuse::Diffuse;
use super::super::glossy::GlossyTable;
use super::super::layered::tests::random as random_layers;
use super::super::rough::tests::{Numbers, directions};
use super::*;
use crate::math::{LANES, lanes};
use crate::polarization::{Distribution, Kernel, Stokes};
use crate::scene::world::{Coat, InternalReflection};

type Model = SurfaceModel<[f32; 1]>;

/// A model that can be a part, which may be a blend of so many depths.
fn random(numbers: &mut Numbers, alpha_min: f32, depth: u32) -> Model {
    let alpha = alpha_min + (1.0 - alpha_min) * numbers.next();
    let [a, b, c] = [numbers.next(), numbers.next(), numbers.next()];
    let distribution = if c < 0.5 { Distribution::Ggx } else { Distribution::Beckmann };
    match (numbers.next() * if depth > 0 { 6.0 } else { 5.0 }) as u32 {
        0 => Model::Diffuse { reflectance: [a] },
        1 => Model::RoughConductor {
            eta: [0.05 + 3.0 * a],
            k: [7.0 * b],
            alpha,
            distribution,
            multiple_scattering: true,
        },
        2 => Model::MetallicRoughness {
            base_color: [a],
            metallic: b,
            alpha,
            ior: 1.0 + c,
            specular: 1.0,
        },
        3 => Model::Plastic {
            reflectance: [a],
            coat: Coat {
                ior: 1.1 + b,
                exterior_ior: 1.0,
                alpha,
                distribution,
                specular: 1.0,
                internal_reflection: InternalReflection::Nonlinear,
            },
        },
        4 => Model::Layered { layers: random_layers(numbers, alpha_min) },
        _ => random_blend(numbers, alpha_min, depth - 1),
    }
}

/// A blend, one of four of a part alone.
fn random_blend(numbers: &mut Numbers, alpha_min: f32, depth: u32) -> Model {
    let weight = (2.0 * numbers.next() - 0.5).clamp(0.0, 1.0);
    blend(random(numbers, alpha_min, depth), random(numbers, alpha_min, depth), weight)
}

fn blend(first: Model, second: Model, weight: f32) -> Model {
    Model::Blend { parts: Box::new([first, second]), weight }
}

/// A model in tables.
pub struct Tabled {
    pub tables: Surfaces<1>,
    pub kind: SurfaceKind,
    pub rows: LaneRows,
}

/// Runs code for the model of a row.
macro_rules! of {
    ($tabled:expr, $models:ident => $body:expr) => {
        with_table!($tabled.tables, $tabled.kind, $models => $body).expect("it can be connected")
    };
}

impl Tabled {
    pub fn new(model: &Model) -> Self {
        let mut tables = Surfaces::default();
        let row = tables.append(model) as usize;
        Self { tables, kind: SurfaceKind::of(model), rows: LaneRows::Same(row) }
    }

    pub fn value(&self, given: Vector<F32s>, drawn: Vector<F32s>) -> F32s {
        let way = [given, drawn];
        let [value] = of!(self, models => value(models, &self.rows, &facing(), way, Side::Sensor));
        value
    }

    pub fn pdf(&self, given: Vector<F32s>, drawn: Vector<F32s>) -> F32s {
        of!(self, models => pdf(models, &self.rows, &facing(), [given, drawn]))
    }

    pub fn draw(&self, given: Vector<F32s>, numbers: &mut Numbers) -> Drawn<1> {
        self.draw_on(&facing(), given, numbers)
    }

    /// Counts of so many draws, from one direction in all lanes, in bins of the sphere against the
    /// density's sums over them. Wilson and Hilferty 1931: a standard normal number, above 4.2 in
    /// one of 75,000 cases.
    pub fn score_of_draws(
        &self,
        given: Vector<F32s>,
        (turns, packets): (usize, usize),
        numbers: &mut Numbers,
    ) -> f64 {
        const HEIGHTS: usize = 16;
        const FINE: usize = LANES;
        let mut counts = vec![0.0_f64; HEIGHTS * turns];
        for _ in 0..packets {
            let drawn = self.draw(given, numbers);
            let lost = drawn.lost.to_bitmask();
            let kept = drawn.direction.to_rows().into_iter().enumerate();
            for (_, [x, y, z]) in kept.filter(|(lane, _)| lost >> lane & 1 == 0) {
                let turn = (y.atan2(x) / std::f32::consts::TAU).rem_euclid(1.0);
                let turn = ((turn * turns as f32) as usize).min(turns - 1);
                let height = ((0.5 * z + 0.5) * HEIGHTS as f32) as usize;
                counts[height.min(HEIGHTS - 1) * turns + turn] += 1.0;
            }
        }
        let all = (packets * LANES) as f64;
        let (mut chi2, mut freedom) = (0.0, 0.0);
        for (bin, count) in counts.into_iter().enumerate() {
            let place = lanes::each(|lane| {
                ((bin % turns) as f32 + (lane as f32 + 0.5) / FINE as f32) / turns as f32
            });
            let density = |row: usize| {
                let height = (bin / turns) as f32 + (row as f32 + 0.5) / FINE as f32;
                let cos = F32s::splat(2.0 * height / HEIGHTS as f32 - 1.0);
                f64::from(self.pdf(given, directions(cos, F32s::from(place))).reduce_add())
            };
            let sum: f64 = (0..FINE).map(density).sum();
            let expected = all * sum * 4.0 * PI / (HEIGHTS * turns * FINE * FINE) as f64;
            if expected > 20.0 {
                chi2 += (count - expected).powi(2) / expected;
                freedom += 1.0;
            }
        }
        let part = 2.0 / (9.0 * freedom);
        ((chi2 / freedom).cbrt() - (1.0 - part)) / f64::sqrt(part)
    }

    /// The weight of what is drawn for a path of a side.
    pub fn draw_for(&self, given: Vector<F32s>, u: [F32s; 3], side: Side) -> F32s {
        let Drawn { weight: [weight], .. } = of!(self, models => {
            models.draw((&self.rows, &models.lanes(&self.rows)), &facing(), given, u, side)
        });
        weight
    }

    pub fn draw_on(&self, facing: &Facing, given: Vector<F32s>, numbers: &mut Numbers) -> Drawn<1> {
        let u = [numbers.lanes(), numbers.lanes(), numbers.lanes()];
        of!(self, models => {
            models.draw((&self.rows, &models.lanes(&self.rows)), facing, given, u, Side::Sensor)
        })
    }

    pub fn kernel(&self, given: Vector<F32s>, drawn: Vector<F32s>) -> (Dense<F32s>, Vector<F32s>) {
        let ([kernel], axis) =
            of!(self, models => dense(models, &self.rows, &facing(), (-given, drawn)));
        (kernel, axis)
    }

    /// Light from `given` that leaves along `drawn`, between frames across both.
    pub fn scatter(&self, given: Vector<F32s>, drawn: Vector<F32s>, light: [F32s; 4]) -> [F32s; 4] {
        let (kernel, axis) = self.kernel(given, drawn);
        let across = s_axis(drawn, -given);
        let arriving = Rotation::between(across, axis, -given).apply(Stokes(light));
        let leaving = kernel.scatter(arriving);
        let Stokes(leaving) = Rotation::between(axis, across, drawn).apply(leaving);
        let value = self.value(given, drawn);
        leaving.map(|component| value * component)
    }
}

pub fn facing() -> Facing {
    let up = Vector::splat([0.0, 0.0, 1.0]);
    Facing { geometric: up, shading: up, two_sided: F32s::splat(1.0).simd_gt(F32s::ZERO) }
}

pub fn pure(numbers: &mut Numbers) -> [F32s; 4] {
    let v = directions(numbers.lanes() * F32s::splat(2.0) - F32s::ONE, numbers.lanes());
    [F32s::ONE, v.x, v.y, v.z]
}

/// One side or the other, both of the same or not.
pub fn ways(numbers: &mut Numbers, case: u32) -> [Vector<F32s>; 2] {
    let turn = |v: Vector<F32s>, back: bool| if back { -v } else { v };
    let (given, drawn) = (numbers.directions(), numbers.directions());
    [turn(given, case & 1 == 1), turn(drawn, case & 2 == 2)]
}

#[track_caller]
pub fn alike(found: F32s, expected: F32s, scale: F32s, context: &dyn std::fmt::Debug) {
    let off = (found - expected).abs() - (scale * F32s::splat(1e-5) + F32s::splat(1e-7));
    assert!(off.simd_le(F32s::ZERO).all(), "{found:?} {expected:?} {context:?}");
}

#[test]
fn light_is_the_weighted_sum_of_that_of_the_parts() {
    let mut numbers = Numbers(10_000);
    for case in 0..100 {
        let model = random_blend(&mut numbers, 0.05, 1);
        let Model::Blend { parts, weight } = &model else { panic!("no blend") };
        let shares = [1.0 - weight, *weight];
        let [given, drawn] = ways(&mut numbers, case);
        let light = pure(&mut numbers);
        let (whole, mut expected) = (Tabled::new(&model), [F32s::ZERO; 4]);
        for (part, share) in parts.iter().zip(shares) {
            let of_part = Tabled::new(part).scatter(given, drawn, light);
            for (sum, component) in expected.iter_mut().zip(of_part) {
                *sum += F32s::splat(share) * component;
            }
        }
        let found = whole.scatter(given, drawn, light);
        let scale = whole.value(given, drawn) * F32s::splat(10.0);
        for (found, expected) in found.into_iter().zip(expected) {
            alike(found, expected, scale, &model);
        }
    }
}

/// Of all of one part, and of a part and itself.
#[test]
fn blends_of_one_thing_are_that_thing() {
    let mut numbers = Numbers(20_000);
    for case in 0..40 {
        let [one, other] = [0, 1].map(|_| random(&mut numbers, 0.05, 0));
        let [given, drawn] = ways(&mut numbers, case);
        let same = blend(one.clone(), one.clone(), numbers.next());
        let first = blend(one.clone(), other.clone(), 0.0);
        let second = blend(other, one.clone(), 1.0);
        let alone = Tabled::new(&one);
        for model in [same, first, second] {
            let mixed = Tabled::new(&model);
            let value = alone.value(given, drawn);
            alike(mixed.value(given, drawn), value, value, &model);
            // Matte surfaces have a density for directions behind them, too, alone.
            if alone.kind != SurfaceKind::Diffuse {
                let pdf = alone.pdf(given, drawn);
                alike(mixed.pdf(given, drawn), pdf, pdf, &model);
            }
            let light = pure(&mut numbers);
            let [found, expected] =
                [&mixed, &alone].map(|tabled| tabled.scatter(given, drawn, light));
            for (found, expected) in found.into_iter().zip(expected) {
                alike(found, expected, value * F32s::splat(10.0), &model);
            }
        }
    }
}

/// Eight blends at once, of kinds that differ, are each what they are alone.
#[test]
fn lanes_do_not_mix() {
    let mut numbers = Numbers(30_000);
    for case in 0..12 {
        let models: [Model; LANES] = std::array::from_fn(|_| random_blend(&mut numbers, 0.1, 1));
        let mut tables = Surfaces::default();
        let rows = models.each_ref().map(|model| tables.append(model) as usize);
        let all = Tabled { tables, kind: SurfaceKind::Blend, rows: LaneRows::Each(rows) };
        let [given, drawn] = ways(&mut numbers, case);
        let light = pure(&mut numbers);
        let together = all.scatter(given, drawn, light);
        let pdf = all.pdf(given, drawn);
        for lane in 0..LANES {
            let alone = Tabled { rows: LaneRows::Same(rows[lane]), ..Tabled::new(&models[0]) };
            let alone = Tabled { tables: all.tables.clone(), ..alone };
            let expected = alone.scatter(given, drawn, light);
            for (found, expected) in together.into_iter().zip(expected) {
                let [found, expected] = [found, expected].map(|it| it.to_array()[lane]);
                assert_eq!(found, expected, "{:?}", models[lane]);
            }
            assert_eq!(pdf.to_array()[lane], alone.pdf(given, drawn).to_array()[lane]);
        }
        let starts = numbers.0;
        let drawn = all.draw(given, &mut numbers);
        for lane in 0..LANES {
            let alone = Tabled {
                tables: all.tables.clone(),
                kind: SurfaceKind::Blend,
                rows: LaneRows::Same(rows[lane]),
            };
            let own = alone.draw(given, &mut Numbers(starts));
            let [found, expected] = [&drawn, &own].map(|it| it.direction.to_rows()[lane]);
            assert_eq!(found, expected, "{:?}", models[lane]);
            let [found, expected] = [&drawn, &own].map(|it| it.weight[0].to_array()[lane]);
            assert_eq!(found, expected, "{:?}", models[lane]);
        }
    }
}

#[test]
fn both_directions_are_alike() {
    let mut numbers = Numbers(40_000);
    for case in 0..100 {
        let model = random_blend(&mut numbers, 0.0, 1);
        let tabled = Tabled::new(&model);
        let [given, drawn] = ways(&mut numbers, case);
        let [there, back] = [tabled.value(given, drawn), tabled.value(drawn, given)];
        let off = (there - back).abs() - (there * F32s::splat(2e-3) + F32s::splat(1e-6));
        assert!(off.simd_le(F32s::ZERO).all(), "{there:?} {back:?} {model:?}");
    }
}

#[test]
fn no_light_is_polarized_more_than_wholly() {
    let mut numbers = Numbers(50_000);
    for case in 0..100 {
        let model = random_blend(&mut numbers, 0.0, 1);
        let tabled = Tabled::new(&model);
        let [given, mut drawn] = ways(&mut numbers, case);
        if case % 3 > 0 {
            drawn = tabled.draw(given, &mut numbers).direction;
        }
        let value = tabled.value(given, drawn);
        let (kernel, axis) = tabled.kernel(given, drawn);
        let Stokes(s) = kernel.scatter(Stokes(pure(&mut numbers)));
        let polarized = (s[1] * s[1] + s[2] * s[2] + s[3] * s[3]).sqrt();
        let lit = value.simd_gt(F32s::ZERO);
        let wrong = lit & polarized.simd_gt(s[0] + F32s::splat(1e-5));
        assert!(!wrong.any(), "{polarized:?} of {:?}, {model:?}", s[0]);
        assert!(value.simd_ge(F32s::ZERO).all(), "{value:?}, {model:?}");
        for v in [given, drawn] {
            let across = v.dot(axis).abs().simd_lt(F32s::splat(2e-3));
            assert!((across | !lit).all(), "{axis:?}, {model:?}");
        }
    }
}

/// The share of light that leaves is that of the parts, whichever draws: the mean of what is drawn
/// is a sum over directions, to its own error and four standard errors, by chance in one of 16,000
/// cases, of which there are 12.
#[test]
fn what_is_drawn_weighs_what_parts_scatter() {
    const PACKETS: usize = 1000;
    const HEIGHTS: usize = 128;
    const TURNS: usize = 64;
    let summed = |model: &Model, given| {
        let (tabled, mut sum) = (Tabled::new(model), 0.0);
        for row in 0..HEIGHTS {
            let cos = F32s::splat(2.0 * (row as f32 + 0.5) / HEIGHTS as f32 - 1.0);
            for first in (0..TURNS).step_by(LANES) {
                let turns = lanes::each(|lane| ((first + lane) as f32 + 0.5) / TURNS as f32);
                let value = tabled.value(given, directions(cos, F32s::from(turns)));
                sum += f64::from((value * cos.abs()).reduce_add());
            }
        }
        sum * 4.0 * PI / (HEIGHTS * TURNS) as f64
    };
    let mut numbers = Numbers(60_000);
    for case in 0..12 {
        let parts = [0, 1].map(|_| random(&mut numbers, 0.4, u32::from(case % 2 == 0)));
        let weight = 0.1 + 0.8 * numbers.next();
        let cos = (0.3 + 0.65 * numbers.next()) * if case % 3 == 0 { -1.0 } else { 1.0 };
        let given = directions(F32s::splat(cos), F32s::splat(0.3));
        let [first, second] = parts.each_ref().map(|part| summed(part, given));
        let [one, two] = parts;
        let model = blend(one, two, weight);
        let (tabled, mut sum, mut squares) = (Tabled::new(&model), 0.0, 0.0);
        for _ in 0..PACKETS {
            let Drawn { weight: [weight], .. } = tabled.draw(given, &mut numbers);
            sum += f64::from(weight.reduce_add());
            squares += f64::from((weight * weight).reduce_add());
        }
        let all = (PACKETS * LANES) as f64;
        let found = sum / all;
        let error = ((squares / all - found * found).max(0.0) / all).sqrt();
        let weight = f64::from(weight);
        let expected = (1.0 - weight) * first + weight * second;
        let off = (found - expected).abs();
        assert!(off < 4.0 * error + 1.5e-3, "{found} {expected} {error} {model:?} {cos}");
    }
}

/// Counts of draws in bins of the sphere against the density's sums over them.
#[test]
fn draws_have_their_densities() {
    let mut numbers = Numbers(70_000);
    for case in 0..6 {
        let model = random_blend(&mut numbers, 0.4, 1);
        let cos = (0.1 + 0.85 * numbers.next()) * if case % 2 == 0 { 1.0 } else { -1.0 };
        let given = directions(F32s::splat(cos), F32s::splat(numbers.next()));
        let z = Tabled::new(&model).score_of_draws(given, (8, 1200), &mut numbers);
        assert!(z < 4.2, "case {case}: z {z}, {model:?}, cos {cos}");
    }
}

/// Photons and roulette go by the part that is narrow, and by the shares of both.
#[test]
fn rows_know_what_their_parts_are() {
    let narrow = Model::RoughConductor {
        eta: [0.2],
        k: [3.0],
        alpha: 0.05,
        distribution: Distribution::Ggx,
        multiple_scattering: true,
    };
    let matte = Model::Diffuse { reflectance: [0.4] };
    let mut tables = Surfaces::default();
    let alone = tables.add(&narrow);
    let Added { scattered, peak, .. } = tables.add(&blend(matte, narrow, 0.25));
    assert_eq!(peak, alone.peak);
    assert!((scattered - (0.75 * 0.4 + 0.25 * alone.scattered)).abs() < 1e-6, "{scattered}");
    // What is black is not drawn by more than it has to be.
    let black = Model::Diffuse { reflectance: [0.0] };
    let white = Model::Diffuse { reflectance: [1.0] };
    let row = tables.append(&blend(white, black, 0.5)) as usize;
    let [GlossyTable::Blend(tables)] = [tables.glossy(SurfaceKind::Blend).expect("glossy")] else {
        panic!("not that of blends")
    };
    assert!(tables.blend[row].chance < 0.05);
    assert_eq!(Diffuse::of([0.4]).scattered(), 0.4);
}
