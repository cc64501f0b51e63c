//! Rough surfaces under films against bare ones, against smooth ones under the same films, and
//! against the laws that every model has to obey.

use super::super::SurfaceKind;
use super::super::Surfaces;
use super::super::blend::tests::{Tabled, alike, facing, pure, ways};
use super::super::model::LaneRows;
use super::super::rough::tests::{Numbers, directions};
use super::*;
use crate::polarization::{Film, Kernel, Rotation, Stokes, filmed_conductor, filmed_dielectric};
use crate::scene::world::{Along, Grain};

type Model = SurfaceModel<[f32; 1]>;
type OneFilm = ThinFilm<[f32; 1]>;

fn film(eta: f32, k: f32, waves: f32) -> OneFilm {
    let [eta, k, thickness, spread] = [eta, k, waves, 0.0].map(|of| [of]);
    ThinFilm { eta, k, thickness, spread, share: 1.0, portion: 1.0, portions: [0.0, 1.0] }
}

fn filmed(of: Model, film: OneFilm) -> Model {
    Model::Filmed { of: Box::new(of), film }
}

fn metal(eta: f32, k: f32, alpha: f32, distribution: Distribution) -> Model {
    let multiple_scattering = true;
    Model::RoughConductor { eta: [eta], k: [k], alpha, distribution, multiple_scattering }
}

fn glass(ior: f32, alpha: f32, distribution: Distribution) -> Model {
    let (ior, exterior_ior, multiple_scattering) = ([ior], [1.0], true);
    Model::RoughDielectric { ior, exterior_ior, alpha, distribution, multiple_scattering }
}

fn mixed(base_color: f32, metallic: f32, alpha: f32, ior: f32) -> Model {
    Model::MetallicRoughness { base_color: [base_color], metallic, alpha, ior, specular: 1.0 }
}

/// Any film, some of which absorb and some of which leave a part of the surface bare.
fn random_film(numbers: &mut Numbers) -> OneFilm {
    let [a, b, c, d] = [0, 1, 2, 3].map(|_| numbers.next());
    let film = film(1.0 + 1.6 * a, (2.0 * b - 1.0).max(0.0), 1.5 * c * c);
    let share = (2.0 * d).min(1.0);
    ThinFilm { spread: [if a < 0.5 { 0.0 } else { 0.025 }], share, ..film }
}

/// One of the models, of facets of this roughness or, one time of three, stretched ones.
fn random_base(numbers: &mut Numbers, alpha_min: f32) -> Model {
    let alpha = alpha_min + (1.0 - alpha_min) * numbers.next();
    let [a, b, c] = [0, 1, 2].map(|_| numbers.next());
    let distribution = Distribution::ALL[usize::from(c < 0.5)];
    let of = match (numbers.next() * 3.0) as u32 {
        0 => metal(0.05 + 3.0 * a, 7.0 * b, alpha, distribution),
        1 => glass([0.6, 1.5, 2.4][(3.0 * a) as usize], alpha, distribution),
        _ => mixed(a, (2.0 * b - 0.5).clamp(0.0, 1.0), alpha, 1.0 + c),
    };
    if numbers.next() > 0.33 {
        return of;
    }
    let along = alpha_min + (1.0 - alpha_min) * numbers.next();
    let place = directions(F32s::ZERO, numbers.lanes()).to_rows()[0];
    let grain = Grain { place, ..Grain::new(Along::Alpha(along)) };
    Model::Brushed { of: Box::new(of), grain }
}

fn random(numbers: &mut Numbers, alpha_min: f32) -> Model {
    let (of, film) = (random_base(numbers, alpha_min), random_film(numbers));
    // Films of what has a base do not absorb.
    let is_mixed = matches!(of.without_grain(), Model::MetallicRoughness { .. });
    let k = if is_mixed { [0.0] } else { film.k };
    filmed(of, ThinFilm { k, ..film })
}

/// A film of no thickness, and one that covers nothing.
#[test]
fn surfaces_without_a_film_are_bare() {
    let mut numbers = Numbers(210_000);
    for case in 0..60 {
        let plain = random_base(&mut numbers, 0.05);
        let none = match case % 2 {
            0 => film(1.0 + numbers.next(), 0.0, 0.0),
            _ => ThinFilm { share: 0.0, ..film(1.0 + numbers.next(), 0.0, numbers.next()) },
        };
        let (whole, bare) = (Tabled::new(&filmed(plain.clone(), none)), Tabled::new(&plain));
        let [given, drawn] = ways(&mut numbers, case);
        // Albedos of coats and of glass are integrated in other ways, to 0.003, and tails are
        // exponentials of what is rounded.
        let beside = match plain.without_grain() {
            Model::MetallicRoughness { .. } => 300.0,
            Model::RoughDielectric { .. } => 30.0,
            _ => 0.0,
        };
        let beside = F32s::splat(beside);
        let alpha = plain.without_grain().facets_alpha().copied().unwrap_or(1.0);
        let peak = F32s::splat(0.1 / (alpha * alpha));
        let value = bare.value(given, drawn);
        let scale = value * F32s::splat(100.0) + beside + peak;
        alike(whole.value(given, drawn), value, scale, &plain);
        let pdf = bare.pdf(given, drawn);
        alike(whole.pdf(given, drawn), pdf, pdf * F32s::splat(100.0) + beside + peak, &plain);
        let light = pure(&mut numbers);
        let [found, expected] = [&whole, &bare].map(|it| it.scatter(given, drawn, light));
        for (found, expected) in found.into_iter().zip(expected) {
            alike(found, expected, scale + scale, &plain);
        }
    }
}

/// What stays on one side is reciprocal, and no light is polarized more than wholly.
#[test]
fn both_directions_are_alike_and_matrices_are_physical() {
    let mut numbers = Numbers(220_000);
    for case in 0..100 {
        let model = random(&mut numbers, 0.0);
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
}

/// Counts of draws in bins of the sphere against the density's sums over them.
#[test]
fn draws_have_their_densities() {
    let mut numbers = Numbers(230_000);
    for case in 0..8 {
        let model = random(&mut numbers, 0.35);
        let cos = (0.1 + 0.85 * numbers.next()) * if case % 4 == 0 { -1.0 } else { 1.0 };
        let given = directions(F32s::splat(cos), F32s::splat(numbers.next()));
        // Of 4.2, one of 75,000 cases by chance.
        let z = Tabled::new(&model).score_of_draws(given, (16, 2000), &mut numbers);
        assert!(z < 4.2, "case {case}: z {z}, {model:?}, cos {cos}");
    }
}

/// Eight of them at once, of models that differ, are each what they are alone.
#[test]
fn lanes_do_not_mix() {
    let mut numbers = Numbers(240_000);
    for case in 0..10 {
        let models: [Model; LANES] = std::array::from_fn(|_| random(&mut numbers, 0.05));
        let mut tables = Surfaces::default();
        let rows = models.each_ref().map(|model| tables.append(model) as usize);
        let of = |rows| Tabled { tables: tables.clone(), kind: SurfaceKind::Filmed, rows };
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

/// Light of a Stokes vector across the plane of incidence that leaves on the same side or on the
/// other, its components summed over draws, with the standard error of the first.
fn leaving(model: &Model, cos: f32, light: [f32; 4], numbers: &mut Numbers) -> [[f64; 4]; 2] {
    const PACKETS: usize = 1500;
    let tabled = Tabled::new(model);
    let given = directions(F32s::splat(cos), F32s::ZERO);
    let across = Vector::splat([0.0, 1.0, 0.0]);
    let mut sums = [[0.0; 4]; 2];
    for _ in 0..PACKETS {
        let Drawn { direction, weight: [weight], .. } = tabled.draw(given, numbers);
        let (kernel, axis) = tabled.kernel(given, direction);
        let arriving =
            Rotation::between(across, axis, -given).apply(Stokes(light.map(F32s::splat)));
        let to = across - direction * across.dot(direction);
        let Stokes(out) = Rotation::between(axis, to, direction).apply(kernel.scatter(arriving));
        let lit = weight.simd_gt(F32s::ZERO);
        let passes = (direction.z * given.z).simd_lt(F32s::ZERO);
        for (sums, mask) in sums.iter_mut().zip([lit & !passes, lit & passes]) {
            for (sum, component) in sums.iter_mut().zip(out) {
                *sum += f64::from((mask & (weight * component)).reduce_add());
            }
        }
    }
    sums.map(|sums| sums.map(|sum| sum / (PACKETS * LANES) as f64))
}

#[test]
fn hardly_rough_ones_are_as_smooth_ones() {
    let mut numbers = Numbers(250_000);
    let light = [1.0, 0.2, -0.6, 0.5];
    let of_film = |film: &OneFilm| Film {
        eta: f64::from(film.eta[0]),
        k: f64::from(film.k[0]),
        waves: f64::from(film.thickness[0]),
        spread: 0.0,
    };
    for distribution in Distribution::ALL {
        for (eta, k, waves, cos) in [(2.3, 0.0, 0.11, 0.7), (1.4, 0.1, 0.3, 0.3)] {
            let film = film(eta, k, waves);
            let model = filmed(metal(0.96, 2.4, 0.002, distribution), film);
            let [found, passed] = leaving(&model, cos, light, &mut numbers);
            let (m00, block) = filmed_conductor(f64::from(cos), &of_film(&film), [0.96, 2.4]);
            let Stokes(expected) = block.scatter(Stokes(light.map(f64::from)));
            assert_eq!(passed, [0.0; 4]);
            for (found, expected) in found.into_iter().zip(expected) {
                assert!((found - m00 * expected).abs() < 6e-3, "{found} {}", m00 * expected);
            }
        }
        for (eta, k, waves, cos) in
            [(1.38, 0.0, 0.2, 0.4), (2.2, 0.0, 0.13, 0.9), (1.8, 0.2, 0.2, -0.9)]
        {
            let film = film(eta, k, waves);
            let model = filmed(glass(1.5, 0.002, distribution), film);
            let both = leaving(&model, cos, light, &mut numbers);
            let indices = if cos > 0.0 { [1.0, 1.5] } else { [1.5, 1.0] };
            let face = filmed_dielectric(f64::from(cos.abs()), &of_film(&film), indices);
            let eta = indices[1] / indices[0];
            let blocks = [
                (face.reflectance, face.reflection),
                // Radiance that arrives there is less by the square of the index.
                (face.transmittance / (eta * eta), face.transmission),
            ];
            for (found, (share, block)) in both.into_iter().zip(blocks) {
                let Stokes(expected) = block.scatter(Stokes(light.map(f64::from)));
                for (found, expected) in found.into_iter().zip(expected) {
                    // Of 12,000 draws: four standard errors, and what facets of 0.1 degrees turn.
                    let expected = share * expected;
                    assert!((found - expected).abs() < 0.016, "{cos}: {found} {expected}");
                }
            }
        }
    }
}

/// The share of light of the cosine that leaves; of power, or, with that of radiance.
fn albedo(model: &Model, cos: f32, numbers: &mut Numbers) -> [f64; 2] {
    const PACKETS: usize = 400;
    let tabled = Tabled::new(model);
    let given = directions(F32s::splat(cos), F32s::splat(0.3));
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..PACKETS {
        let u = [numbers.lanes(), numbers.lanes(), numbers.lanes()];
        let weight = tabled.draw_for(given, u, Side::Light);
        sum += f64::from(weight.reduce_add());
        squares += f64::from((weight * weight).reduce_add());
    }
    let all = (PACKETS * LANES) as f64;
    let mean = sum / all;
    [mean, ((squares / all - mean * mean).max(0.0) / all).sqrt()]
}

/// All light leaves that no film absorbs, and no metal.
#[test]
fn lossless_ones_keep_all_light() {
    let mut numbers = Numbers(260_000);
    for (eta, waves, alpha) in [(1.3, 0.3, 0.05), (2.4, 0.12, 0.3), (1.8, 0.9, 1.0)] {
        let models = [
            metal(1e-6, 1.0, alpha, Distribution::Ggx),
            mixed(1.0, 0.0, alpha, 1.5),
            glass(1.5, alpha, Distribution::Ggx),
            glass(1.5, alpha, Distribution::Beckmann),
        ];
        let cosines = [0.05, 0.4, 1.0, -0.1, -0.7].into_iter();
        for (of, cos) in models.iter().flat_map(|of| cosines.clone().map(move |cos| (of, cos))) {
            if cos < 0.0 && !of.transmits() {
                continue;
            }
            let model = filmed(of.clone(), film(eta, 0.0, waves));
            let [mean, error] = albedo(&model, cos, &mut numbers);
            // Four standard errors: by chance in one of 16,000 cases, of which there are fifty.
            assert!((mean - 1.0).abs() < 0.012 + 4.0 * error, "{mean} {model:?} {cos}");
        }
    }
    assert_eq!(facing().shading.to_rows()[0], [0.0, 0.0, 1.0]);
}
