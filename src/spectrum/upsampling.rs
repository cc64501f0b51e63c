//! Smooth spectra of colors, after W. Jakob and J. Hanika, "A Low-Dimensional Function Space for
//! Efficient Spectral Upsampling", Computer Graphics Forum 38(2), 2019.
//!
//! A color is linear sRGB under a white: the spectrum times the white's, seen by a film on which
//! that white is (1, 1, 1). Of all spectra that are seen as the color one of the paper's family is
//! taken, which are smooth and within [0, 1]: S(a quadratic polynomial of the wavelength), where S
//! rises from 0 to 1. Its three coefficients are found when they are asked for, by Newton's method
//! with shorter steps where it would not get nearer, from between fits of a grid, or from a grey as
//! bright as the brightest channel. Colors nearer to white than to black are one less their
//! complement. Every color in the unit cube of sRGB is reached, its faces and
//! corners included, both by D65 and by E.
//!
//! The sums that see a spectrum have nodes every 5 nm: they are integrals every nanometer of its
//! cubic interpolation between these. For the steepest spectra, those of saturated colors, that
//! differs from the integral of themselves by up to 3e-5 of the brightest channel, and no color is
//! missed by more.
//!
//! Dark colors are fitted as bright ones that are scaled down: [`Smooth`]. Greys are constants: a
//! grey `g` is `g` at every wavelength, to the last bit of an `f32`.

use std::sync::LazyLock;

use glam::{DMat3, DVec3};
use wide::f64x4;

use super::cie::VISIBLE_NM;
use super::color_space::{NODES, RgbResponse, White, nodes_nm};
use super::fits::remembered;

/// Distance of a color from what is asked for, in the worst channel, at which it is met.
const TOLERANCE: f64 = 1e-9;
/// Most spectra that are tried. From a grey it mostly takes 7; the last of all colors, those that
/// differ from white by 1e-6, take 70.
const TRIALS_MAX: usize = 100;
/// Shortest step that is tried, as a share of Newton's.
const SHARE_MIN: f64 = 1e-6;

/// Nodes of the fit, from the first of the visible wavelengths to the last.
const FIT_NODES: usize = (NODES - 1) / NODES_APART + 1;
/// Every how many nanometers they are.
const NODES_APART: usize = 5;

/// A smooth spectrum within [0, 1]: S(c0 t^2 + c1 t + c2), where S(x) = 1/2 + x / (2 sqrt(1 + x^2))
/// and t grows from 0 at 360 nm to 1 at 830 nm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sigmoid {
    /// The coefficients, the quadratic one first.
    pub c: [f64; 3],
}

impl Sigmoid {
    /// The same value within [0, 1] at all wavelengths.
    fn constant(value: f64) -> Self {
        Self { c: [0.0, 0.0, (2.0 * value - 1.0) / (2.0 * (value * (1.0 - value)).sqrt())] }
    }

    /// The value at a wavelength in nanometers; beyond 360 and 830 nm that at these.
    #[inline]
    pub fn at(&self, wavelength_nm: f64) -> f64 {
        let [first, last] = VISIBLE_NM;
        let t = (wavelength_nm.clamp(first, last) - first) / (last - first);
        sigmoid(self.polynomial(t))[0]
    }

    fn polynomial(&self, t: f64) -> f64 {
        let [c0, c1, c2] = self.c;
        (c0 * t + c1) * t + c2
    }

    /// One less itself.
    fn complement(self) -> Self {
        Self { c: self.c.map(|c| -c) }
    }
}

/// S(x) and its derivative. Near zero and near one digits are kept: far out S is 1 / (4 x^2) from
/// these.
#[inline]
fn sigmoid(x: f64) -> [f64; 2] {
    let square = 1.0 + x * x;
    let root = square.sqrt();
    let tail = 0.5 / (root * (root + x.abs()));
    [if x < 0.0 { tail } else { 1.0 - tail }, 0.5 / (square * root)]
}

/// The fit of a color, which is remembered: spectral renders ask for all in every iteration, and
/// for those of pictures at every point.
fn known(rgb: DVec3, white: White) -> Sigmoid {
    remembered(rgb.to_array(), white, || fitted(rgb, white))
}

/// The smooth spectrum of a color: a number times a sigmoid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smooth {
    /// The number.
    pub scale: f64,
    /// The sigmoid.
    pub shape: Sigmoid,
}

impl Smooth {
    /// That of a reflectance: linear sRGB within [0, 1] under a white (what is outside is taken as
    /// what it is next to). It is within [0, 1]; colors up to 1/2 are scaled as
    /// [`Self::coefficient`] is, for no sigmoid is dark and saturated.
    pub fn reflectance(rgb: [f32; 3], white: White) -> Self {
        let rgb = rgb.map(|it| if it > 0.0 { f64::from(it.min(1.0)) } else { 0.0 });
        Self::scaled(rgb, white, 1.0)
    }

    /// That of red, green and blue that have no upper bound, and none below zero: twice the
    /// greatest times the sigmoid of what they are relative to it.
    pub fn coefficient(rgb: [f32; 3], white: White) -> Self {
        let rgb = rgb.map(|it| if it > 0.0 { f64::from(it) } else { 0.0 });
        Self::scaled(rgb, white, f64::INFINITY)
    }

    /// The value at a wavelength in nanometers.
    #[inline]
    pub fn at(&self, wavelength_nm: f64) -> f64 {
        self.scale * self.shape.at(wavelength_nm)
    }

    /// The values at wavelengths in nanometers.
    pub fn values<const N: usize>(&self, wavelengths_nm: &[f32; N]) -> [f32; N] {
        let mut values = [0.0; N];
        for (value, nm) in values.iter_mut().zip(wavelengths_nm) {
            *value = self.at(f64::from(*nm)) as f32;
        }
        values
    }

    fn scaled(rgb: [f64; 3], white: White, scale_max: f64) -> Self {
        let rgb = DVec3::from(rgb);
        let scale = (2.0 * rgb.max_element()).min(scale_max);
        if scale == 0.0 {
            return Self { scale, shape: Sigmoid::constant(0.5) };
        }
        let relative = rgb / scale;
        if relative.min_element() == relative.max_element() {
            return Self { scale, shape: Sigmoid::constant(relative.x) };
        }
        // Of one and the complement the darker one: what is left of it has more digits.
        let shape = match relative.min_element() + relative.max_element() > 1.0 {
            true => known(DVec3::ONE - relative, white).complement(),
            false => known(relative, white),
        };
        Self { scale, shape }
    }
}

/// The sigmoid of a color under a white.
fn fitted(rgb: DVec3, white: White) -> Sigmoid {
    let weights = &WEIGHTS[white as usize];
    let start = STARTS[white as usize].near(rgb).unwrap_or_else(|| grey_start(rgb));
    nearest(start, rgb, weights)
}

/// A grey as bright as the brightest channel.
fn grey_start(rgb: DVec3) -> Sigmoid {
    Sigmoid::constant(rgb.max_element().min(0.5))
}

/// What Newton's method makes of a sigmoid for a color.
fn nearest(start: Sigmoid, rgb: DVec3, weights: &Weights) -> Sigmoid {
    let mut best = Trial::of(start, rgb, weights);
    let mut trials = 1;
    let mut share = 1.0;
    while best.is_off() && trials < TRIALS_MAX && share >= SHARE_MIN {
        let step = best.derivative.inverse() * best.miss;
        if !step.is_finite() {
            break;
        }
        let shape = Sigmoid { c: (DVec3::from(best.shape.c) - share * step).to_array() };
        let next = Trial::of(shape, rgb, weights);
        trials += 1;
        // Steps that get nowhere near what they promise are too long.
        if next.miss.length() < best.miss.length() * (1.0 - 0.01 * share) {
            (best, share) = (next, 1.0);
        } else {
            share *= 0.5;
        }
    }
    best.shape
}

/// Where fits of colors begin whose greatest channel is 1/2, as all lights have it: between the
/// fits of a grid of the other two, which is finer where these are dark.
struct Starts([Vec<DVec3>; 3]);

impl Starts {
    /// Steps along an edge.
    const STEPS: usize = 32;

    fn new(weights: &Weights) -> Self {
        let fit = |greatest: usize, place: usize| {
            let of = |step: usize| 0.5 * (step as f64 / Self::STEPS as f64).powi(2);
            let mut rgb = DVec3::splat(0.5);
            rgb[(greatest + 1) % 3] = of(place % (Self::STEPS + 1));
            rgb[(greatest + 2) % 3] = of(place / (Self::STEPS + 1));
            DVec3::from(nearest(grey_start(rgb), rgb, weights).c)
        };
        let places = (Self::STEPS + 1) * (Self::STEPS + 1);
        Self(std::array::from_fn(|greatest| (0..places).map(|it| fit(greatest, it)).collect()))
    }

    fn near(&self, rgb: DVec3) -> Option<Sigmoid> {
        let greatest = (0..3).find(|channel| rgb[*channel] == 0.5)?;
        let along = |channel: usize| {
            let place = (2.0 * rgb[channel]).sqrt() * Self::STEPS as f64;
            let step = (place as usize).min(Self::STEPS - 1);
            (step, place - step as f64)
        };
        let ((column, right), (row, down)) = (along((greatest + 1) % 3), along((greatest + 2) % 3));
        let at = |row: usize| {
            let place = row * (Self::STEPS + 1) + column;
            self.0[greatest][place].lerp(self.0[greatest][place + 1], right)
        };
        Some(Sigmoid { c: at(row).lerp(at(row + 1), down).to_array() })
    }
}

/// Those of the whites, in their order.
static STARTS: LazyLock<[Starts; 2]> =
    LazyLock::new(|| White::ALL.map(|white| Starts::new(&WEIGHTS[white as usize])));

/// A sigmoid that may be that of a color.
struct Trial {
    shape: Sigmoid,
    /// Its color, less the one that is asked for.
    miss: DVec3,
    /// Of its color by its coefficients, one after the other.
    derivative: DMat3,
}

impl Trial {
    fn of(shape: Sigmoid, rgb: DVec3, weights: &Weights) -> Self {
        let [c0, c1, c2] = shape.c.map(f64x4::splat);
        let (zero, half, one) = (f64x4::ZERO, f64x4::HALF, f64x4::ONE);
        let (mut color, mut derivative) = ([zero; 3], [[zero; 3]; 3]);
        for (t, weight) in weights {
            // As in `sigmoid`.
            let x = (c0 * *t + c1) * *t + c2;
            let square = one + x * x;
            let root = square.sqrt();
            let tail = half / (root * (root + x.abs()));
            let value = x.simd_lt(zero).select(tail, one - tail);
            let slope = half / (square * root);
            for (channel, weight) in weight.iter().enumerate() {
                color[channel] += value * *weight;
                let by_constant = slope * *weight;
                let by_linear = by_constant * *t;
                derivative[2][channel] += by_constant;
                derivative[1][channel] += by_linear;
                derivative[0][channel] += by_linear * *t;
            }
        }
        let sum = |of: [f64x4; 3]| DVec3::from(of.map(|it| it.reduce_add()));
        let [by0, by1, by2] = derivative.map(sum);
        Self { shape, miss: sum(color) - rgb, derivative: DMat3::from_cols(by0, by1, by2) }
    }

    fn is_off(&self) -> bool {
        self.miss.abs().max_element() > TOLERANCE
    }
}

/// What the nodes of a spectrum, four at a time, bring to red, green and blue under a white: where
/// they are from 0 to 1, and how much.
type Weights = [(f64x4, [f64x4; 3]); FIT_NODES.div_ceil(4)];

/// Those of the whites, in their order.
static WEIGHTS: LazyLock<[Weights; 2]> = LazyLock::new(|| White::ALL.map(weights));

fn weights(white: White) -> Weights {
    let response = RgbResponse::by(white);
    // The last is no node.
    let mut weights = [DVec3::ZERO; FIT_NODES + 1];
    for (fine, nm) in nodes_nm().enumerate() {
        let seen = DVec3::from(response.at(nm)) * white.at(nm);
        let first = (fine / NODES_APART).saturating_sub(1).min(FIT_NODES - 4);
        let place = fine as f64 / NODES_APART as f64 - first as f64;
        for (node, share) in cubic(place).into_iter().enumerate() {
            weights[first + node] += share * seen;
        }
    }
    const { assert!((FIT_NODES + 1).is_multiple_of(4)) };
    std::array::from_fn(|four| {
        let node = |lane: usize| 4 * four + lane;
        let lanes = |of: &dyn Fn(usize) -> f64| f64x4::from([0, 1, 2, 3].map(|it| of(node(it))));
        let place = lanes(&|node| node as f64 / (FIT_NODES - 1) as f64);
        (place, [0, 1, 2].map(|channel| lanes(&|node| weights[node][channel])))
    })
}

/// What values at 0, 1, 2 and 3 have to do with that at a place: Lagrange's polynomials.
fn cubic(place: f64) -> [f64; 4] {
    std::array::from_fn(|node| {
        let others = (0..4).filter(|other| *other != node);
        let factor = |other: usize| (place - other as f64) / (node as f64 - other as f64);
        others.map(factor).product()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Red, green and blue that a film sees of a spectrum under a white, by sums every nanometer.
    fn seen(smooth: &Smooth, white: White) -> DVec3 {
        let lit = |nm: f64| smooth.at(nm) * white.at(nm);
        DVec3::from(RgbResponse::by(white).rgb(lit))
    }

    /// Distances of colors from what is seen of their spectra, the largest of all channels.
    fn error_of(rgb: [f32; 3], smooth: &Smooth, white: White) -> f64 {
        (seen(smooth, white) - DVec3::from(rgb.map(f64::from))).abs().max_element()
    }

    /// Numbers within [0, 1) that look random.
    fn random() -> impl FnMut() -> f32 {
        let mut state = 1_u32;
        move || {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (state >> 8) as f32 / (1 << 24) as f32
        }
    }

    /// Colors from everywhere in the cube, many of them where fits are hard.
    fn colors() -> Vec<[f32; 3]> {
        let grid = (0..9 * 9 * 9).map(|i| [i % 9, i / 9 % 9, i / 81].map(|it| it as f32 / 8.0));
        let ends = [
            0.0,
            1e-30,
            1e-12,
            1e-6,
            1e-3,
            0.1,
            0.5,
            0.500_001,
            0.9,
            0.999,
            0.999_999,
            0.999_999_9,
            1.0,
        ];
        let nasty = (0..13 * 13 * 13).map(|i| [ends[i % 13], ends[i / 13 % 13], ends[i / 169]]);
        let mut next = random();
        let inside = (0..2000).map(|_| [next(), next(), next()]);
        let mut colors: Vec<[f32; 3]> = grid.chain(nasty).chain(inside).collect();
        for channel in 0..3 {
            for at in [0.0, 1.0] {
                for _ in 0..300 {
                    let mut on_face = [next(), next(), next()];
                    on_face[channel] = at;
                    let mut on_edge = on_face;
                    on_edge[(channel + 1) % 3] = next().round();
                    colors.extend([on_face, on_edge]);
                }
            }
        }
        for _ in 0..1000 {
            let darkness = 10.0_f32.powf(-8.0 * next());
            let dark = [next(), next(), next()].map(|it| it * darkness);
            colors.extend([dark, dark.map(|it| 1.0 - it)]);
        }
        colors
    }

    #[test]
    fn every_color_of_the_cube_is_seen_as_itself() {
        for (white, rgb) in
            White::ALL.into_iter().flat_map(|it| colors().into_iter().map(move |rgb| (it, rgb)))
        {
            let smooth = Smooth::reflectance(rgb, white);
            let error = error_of(rgb, &smooth, white);
            let greatest = f64::from(rgb[0].max(rgb[1]).max(rgb[2]));
            assert!(error <= 4e-5 * greatest, "{rgb:?} by {white:?}: {error:e} off");
            for nm in (360..=830).step_by(10).map(f64::from) {
                assert!((0.0..=1.0).contains(&smooth.at(nm)), "{rgb:?} at {nm} nm");
            }
        }
    }

    /// By the package colour-science 0.4.7 for Python, `recovery.XYZ_to_sd_Jakob2019` under D65,
    /// at 420, 470 ... 670 nm. That minimizes the difference of colors in CIE Lab, by other means,
    /// and scales no dark colors.
    const OTHERS: [([f32; 3], [f64; 6]); 7] = [
        ([0.61, 0.07, 0.05], [0.078, 0.056, 0.065, 0.136, 0.584, 0.944]),
        ([0.13, 0.44, 0.09], [0.039, 0.167, 0.416, 0.398, 0.145, 0.034]),
        ([0.10, 0.20, 0.62], [0.756, 0.479, 0.263, 0.166, 0.128, 0.117]),
        ([0.68, 0.50, 0.14], [0.099, 0.226, 0.422, 0.573, 0.625, 0.588]),
        ([0.08, 0.42, 0.45], [0.353, 0.478, 0.466, 0.323, 0.151, 0.060]),
        ([0.92, 0.63, 0.51], [0.559, 0.518, 0.578, 0.717, 0.855, 0.933]),
        ([0.74, 0.09, 0.54], [0.876, 0.291, 0.129, 0.187, 0.710, 0.969]),
    ];

    #[test]
    fn spectra_are_those_of_others() {
        for (rgb, expected) in OTHERS {
            let smooth = Smooth::reflectance(rgb, White::D65);
            for (nm, expected) in (420..).step_by(50).map(f64::from).zip(expected) {
                let found = smooth.at(nm);
                assert!((found - expected).abs() < 0.007, "{rgb:?} at {nm}: {found}, {expected}");
            }
        }
    }

    #[test]
    fn greys_are_constants_to_the_last_bit() {
        let mut next = random();
        let greys = (0..2000).map(|_| next()).chain([0.0, 1e-45, 0.5, 0.999_999_94, 1.0]);
        for (grey, white) in greys.flat_map(|grey| White::ALL.map(|white| (grey, white))) {
            for smooth in
                [Smooth::reflectance([grey; 3], white), Smooth::coefficient([grey; 3], white)]
            {
                let exact = f64::from(grey);
                for nm in [-1.0, 360.0, 471.1, 830.0, 2000.0] {
                    let off = (smooth.at(nm) - exact).abs();
                    assert!(
                        off <= 2.0 * f64::EPSILON * exact,
                        "{grey} is off by {off:e} at {nm} nm"
                    );
                }
                assert_eq!(smooth.values(&[400.0, 700.0]), [grey; 2]);
            }
        }
    }

    #[test]
    fn coefficients_have_their_color_at_any_scale_and_lights_theirs() {
        for rgb in [[3.0, 1.0, 0.2], [0.0, 0.0, 5e-9], [1e30, 3e30, 2e30], [7.0, 7.1, 0.0]] {
            for white in White::ALL {
                let smooth = Smooth::coefficient(rgb, white);
                let greatest = f64::from(rgb[0].max(rgb[1]).max(rgb[2]));
                assert!(error_of(rgb, &smooth, white) <= 4e-5 * greatest, "{rgb:?}");
                let half = Smooth::coefficient(rgb.map(|it| 0.5 * it), white);
                assert_eq!((half.shape, 2.0 * half.scale), (smooth.shape, smooth.scale));
            }
        }
    }

    #[test]
    fn what_is_no_color_has_a_spectrum_of_numbers_all_the_same() {
        let infinite = f32::INFINITY;
        for rgb in [[-1.0, 0.5, 2.0], [f32::NAN, 0.2, 0.1], [f32::NAN; 3], [infinite, 0.0, 0.3]] {
            let smooth = Smooth::reflectance(rgb, White::D65);
            assert!((0.0..=1.0).contains(&smooth.at(500.0)), "{rgb:?}");
        }
        // Too bright to be anything, and an error where it is used.
        let smooth = Smooth::coefficient([infinite, 0.0, 0.3], White::E);
        assert!(!smooth.at(500.0).is_finite());
        assert_eq!(Smooth::coefficient([0.0; 3], White::E).at(500.0), 0.0);
        assert_eq!(Smooth::coefficient([-1.0; 3], White::E).at(500.0), 0.0);
    }

    #[test]
    fn the_sigmoid_keeps_its_digits_far_out() {
        for x in [0.0, 0.3, 1.0, 7.0, 1e3] {
            let [value, slope] = sigmoid(x);
            let [low, same] = sigmoid(-x);
            let root = (1.0 + x * x).sqrt();
            assert!((value - (0.5 + x / (2.0 * root))).abs() < 2e-16 && slope == same);
            assert!((value + low - 1.0).abs() < 2e-16);
            assert!((slope - 0.5 / root.powi(3)).abs() < 1e-15);
        }
        let [low, _] = sigmoid(-1e8);
        assert!((low / 0.25e-16 - 1.0).abs() < 1e-12, "{low:e}");
        assert_eq!((sigmoid(f64::INFINITY)[0], sigmoid(f64::NEG_INFINITY)[0]), (1.0, 0.0));
    }
}
