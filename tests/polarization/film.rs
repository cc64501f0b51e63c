//! Films on interfaces against tabulated ones, and against the interfaces that they lie on.

use std::f64::consts::PI;

use sunstone::internals::math::{F32s, Real};
use sunstone::internals::polarization::{
    Block, Film, Filmed, conductor, dielectric, filmed_conductor, filmed_dielectric,
};

/// Double precision against a table of the same.
const TOLERANCE_F64: f64 = 1e-9;
/// Single precision: phases of up to 90 radians are rounded to some 1e-5 of one, and close to total
/// reflection cosines count by their roots.
const TOLERANCE_F32: f64 = 2e-4;

/// A row of the table: indices and angle, and the eight elements.
type Row = ([f64; 7], [f64; 8]);

fn table() -> Vec<Row> {
    let text = include_str!("../data/film/films.csv");
    let row = |line: &str| {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().expect("a number")).collect();
        (
            cells[..7].try_into().expect("seven numbers"),
            cells[7..].try_into().expect("eight numbers"),
        )
    };
    text.lines().skip(1).map(row).collect()
}

fn film<F: Real>(eta: f64, k: f64, waves: f64, spread: f64) -> Film<F> {
    let [eta, k, waves, spread] = [eta, k, waves, spread].map(F::splat);
    Film { eta, k, waves, spread }
}

/// M00, M01, M22 and M32.
fn elements(m00: f64, Block { a, c, s }: Block<f64>) -> [f64; 4] {
    [m00, m00 * a, m00 * c, -(m00 * s)]
}

/// What light does at a row of the table, by the precision of `F`.
fn found<F: Real>([before, eta, k, behind, behind_k, waves, deg]: [f64; 7]) -> Filmed<F> {
    let cos_i = F::splat(deg.to_radians().cos());
    let film = film(eta, k, waves, 0.0);
    if behind_k > 0.0 {
        assert_eq!(before, 1.0, "conductors are relative to what is outside");
        let index = [F::splat(behind), F::splat(behind_k)];
        let (reflectance, reflection) = filmed_conductor(cos_i, &film, index);
        let (none, nothing) = (F::zero(), Block::identity());
        return Filmed {
            reflectance,
            reflection,
            transmittance: none,
            transmission: nothing,
            cos_t: none,
        };
    }
    filmed_dielectric(cos_i, &film, [before, behind].map(F::splat))
}

fn compare(
    of: impl Fn([f64; 7]) -> Filmed<f64>,
    tolerance: impl Fn(&[f64; 7]) -> f64,
    skips: impl Fn(&[f64; 7]) -> bool,
) -> f64 {
    let mut worst = 0.0_f64;
    for (media, expected) in table().into_iter().filter(|(media, _)| !skips(media)) {
        let filmed = of(media);
        let mut all = elements(filmed.reflectance, filmed.reflection).to_vec();
        let is_metal = media[4] > 0.0;
        if !is_metal {
            all.extend(elements(filmed.transmittance, filmed.transmission));
        }
        for (found, expected) in all.iter().zip(expected) {
            let error = (found - expected).abs();
            assert!(error < tolerance(&media), "{media:?}: {all:?} is not {expected:?}, {error:e}");
            worst = worst.max(error);
        }
    }
    worst
}

/// How much the elements change with the last digit that `f32` has of the thickness: films between
/// strong mirrors are that sharp.
fn resonance(media: &[f64; 7]) -> f64 {
    let of = |media: [f64; 7]| {
        let Filmed { reflectance, reflection, transmittance, transmission, .. } =
            found::<f64>(media);
        [elements(reflectance, reflection), elements(transmittance, transmission)]
    };
    let mut thicker = *media;
    thicker[5] *= 1.0 + f64::from(f32::EPSILON);
    let (of_this, of_that) = (of(*media), of(thicker));
    let pairs = of_this.iter().flatten().zip(of_that.iter().flatten());
    pairs.map(|(this, that)| (this - that).abs()).fold(0.0, f64::max)
}

#[test]
fn films_are_those_of_the_table() {
    let double = compare(found::<f64>, |_| TOLERANCE_F64, |_| false);
    let single = |media| {
        let Filmed { reflectance, reflection, transmittance, transmission, cos_t } =
            found::<F32s>(media);
        let number = |lanes: F32s| f64::from(lanes.to_array()[0]);
        let block = |of: Block<F32s>| Block { a: number(of.a), c: number(of.c), s: number(of.s) };
        Filmed {
            reflectance: number(reflectance),
            reflection: block(reflection),
            transmittance: number(transmittance),
            transmission: block(transmission),
            cos_t: number(cos_t),
        }
    };
    let single = compare(single, |media| TOLERANCE_F32 + resonance(media), |_| false);
    println!("films: largest errors {double:e} and {single:e}");
}

/// Rows of the shared reference, made by another Airy sum: index outside, of the film and behind;
/// waves, angle, R00, R01, R22, R32.
const OTHERS: [[f64; 10]; 2] = [
    [
        1.0,
        1.38,
        1.52,
        0.0,
        100.0 / 550.0,
        0.0,
        0.012_601_798_955_426_697,
        0.0,
        -0.012_601_798_955_426_697,
        0.0,
    ],
    [
        1.0,
        1.38,
        1.52,
        0.0,
        100.0 / 550.0,
        30.0,
        0.013_791_643_049_591_318,
        0.006_797_009_899_492_333,
        -0.011_996_817_881_692_039,
        0.000_293_998_549_414_570_87,
    ],
];

#[test]
fn films_are_those_of_another_sum() {
    for [before, eta, behind, k, waves, deg, expected @ ..] in OTHERS {
        let filmed = found::<f64>([before, eta, 0.0, behind, k, waves, deg]);
        let found = elements(filmed.reflectance, filmed.reflection);
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }
}

/// Without thickness, or of the index of either side, it is not there.
#[test]
fn films_that_are_none_are_not_seen() {
    for step in 0..=90 {
        let cos = f64::from(step).to_radians().cos().max(1e-6);
        for (eta, k, waves) in [(1.7, 0.0, 0.0), (2.0, 0.5, 0.0), (1.0, 0.0, 3.3)] {
            let (found, block) = filmed_conductor(cos, &film(eta, k, waves, 0.0), [0.9, 6.0]);
            let (expected, plain) = conductor(cos, 0.9, 6.0);
            assert!((found - expected).abs() < 1e-9, "{step} {eta}");
            if waves == 0.0 {
                for (a, b) in elements(found, block).into_iter().zip(elements(expected, plain)) {
                    assert!((a - b).abs() < 1e-9, "{step} {block:?} {plain:?}");
                }
            }
        }
        for [before, behind] in [[1.0, 1.5], [1.5, 1.0]] {
            let plain = dielectric(cos, behind / before);
            for (eta, waves) in [(2.2, 0.0), (before, 1.23), (behind, 0.77)] {
                let found = filmed_dielectric(cos, &film(eta, 0.0, waves, 0.0), [before, behind]);
                assert!((found.reflectance - plain.reflectance).abs() < 1e-9, "{step} {eta}");
                assert!((found.cos_t - plain.cos_t).abs() < 1e-12);
            }
        }
    }
}

/// The mean over a line of Lorentz's shape, by the sum over its quantiles: the phase of a film
/// counts, and nothing else changes.
#[test]
fn channels_are_means_over_their_lines() {
    const QUANTILES: usize = 20_000;
    let spread = 0.06;
    for (waves, cos) in [(0.3, 1.0), (0.7, 0.5), (2.0, 0.8)] {
        let mut means = [[0.0; 4]; 3];
        for quantile in 0..QUANTILES {
            let share = (quantile as f64 + 0.5) / QUANTILES as f64;
            let of_line = film(1.5, 0.0, waves * (1.0 + spread * (PI * (share - 0.5)).tan()), 0.0);
            let (m00, block) = filmed_conductor(cos, &of_line, [0.3, 3.0]);
            let glass = filmed_dielectric(cos, &of_line, [1.0, 2.0]);
            let all = [
                elements(m00, block),
                elements(glass.reflectance, glass.reflection),
                elements(glass.transmittance, glass.transmission),
            ];
            for (mean, of) in means.iter_mut().flatten().zip(all.iter().flatten()) {
                *mean += of / QUANTILES as f64;
            }
        }
        let of_channel = film(1.5, 0.0, waves, spread);
        let (m00, block) = filmed_conductor(cos, &of_channel, [0.3, 3.0]);
        let glass = filmed_dielectric(cos, &of_channel, [1.0, 2.0]);
        let all = [
            elements(m00, block),
            elements(glass.reflectance, glass.reflection),
            elements(glass.transmittance, glass.transmission),
        ];
        for (found, mean) in all.iter().flatten().zip(means.iter().flatten()) {
            // Phases differ by more than half a turn between quantiles beyond some 200 half-widths,
            // where 0.35 % of the line is: of amplitudes up to 0.5.
            assert!((found - mean).abs() < 2e-3, "{waves} {cos}: {found} {mean}");
        }
    }
}

/// Whatever the film: no light is made, and none is polarized more than wholly.
#[test]
fn films_are_physical() {
    let mut seed = 7_u64;
    let mut next = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 40) as f64 / f64::from(1 << 24)
    };
    let number = |lanes: F32s| f64::from(lanes.to_array()[0]);
    for _ in 0..20_000 {
        let absorbs = if next() < 0.5 { next() * 3.0 } else { 0.0 };
        let of: Film<F32s> = film(
            0.3 + 3.0 * next(),
            absorbs,
            20.0 * next() * next(),
            0.2 * (next() - 0.5).max(0.0),
        );
        let cos = F32s::splat((next() as f32).max(1e-6));
        let (before, behind) = (0.5 + 2.0 * next(), 0.5 + 2.0 * next());
        let glass = filmed_dielectric(cos, &of, [before, behind].map(Real::splat));
        let (m00, block) = filmed_conductor(cos, &of, [behind, 5.0 * next()].map(Real::splat));
        let [reflected, refracted] = [glass.reflectance, glass.transmittance].map(number);
        assert!((-1e-6..=1.0).contains(&reflected) && (0.0..=1.0).contains(&refracted));
        assert!(reflected + refracted <= 1.0 + 1e-6, "{of:?} {reflected} {refracted}");
        for (m00, Block { a, c, s }) in [
            (m00, block),
            (glass.reflectance, glass.reflection),
            (glass.transmittance, glass.transmission),
        ] {
            let [m00, a, c, s] = [m00, a, c, s].map(number);
            let size = a * a + c * c + s * s;
            // Of what is hardly there, rounding is all that is left: 1e-7 of what is absorbed.
            assert!(m00 < 1e-3 || size <= 1.0 + 1e-4, "{of:?} {m00} {a} {c} {s}");
            assert!(m00.is_finite() && size.is_finite(), "{of:?} {cos:?}");
        }
    }
}
