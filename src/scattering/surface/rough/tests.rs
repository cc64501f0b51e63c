//! Laws that every rough model has to obey, and integrals that are computed otherwise.

use std::f64::consts::PI;

use super::*;
use crate::math::hash::{combine, mix};
use crate::math::{LANES, lanes};
use crate::polarization::kernel::Kernel;
use crate::polarization::{Dense, Distribution, Rotation, Stokes};
use crate::scattering::phase::half_sine2;
use crate::scattering::side::Side;
use crate::scattering::surface::glossy::{GlossyLanes, GlossyTable};
use crate::scattering::surface::measured::Measured;
use crate::scattering::surface::metallic_roughness::MetallicRoughness;
use crate::scattering::surface::model::{Connecting, LaneRows, Surface};
use crate::scattering::surface::plastic::Plastic;
use crate::scattering::surface::rough_conductor::RoughConductor;
use crate::scene::world::{Coat, InternalReflection};

/// Numbers in [0, 1) that depend on nothing but their place.
pub struct Numbers(pub u32);

impl Numbers {
    pub fn next(&mut self) -> f32 {
        self.0 += 1;
        (mix(combine(self.0, 0x51ab)) >> 8) as f32 / (1 << 24) as f32
    }

    pub fn lanes(&mut self) -> F32s {
        let mut numbers = [0.0; LANES];
        numbers.iter_mut().for_each(|number| *number = self.next());
        F32s::from(numbers)
    }

    /// Unit vectors above the surface.
    pub fn directions(&mut self) -> Vector<F32s> {
        directions(self.lanes() * F32s::splat(0.98) + F32s::splat(0.01), self.lanes())
    }
}

/// Those of these cosines and turns about the normal.
pub fn directions(cos: F32s, turns: F32s) -> Vector<F32s> {
    let (sine, cosine) = warp::sin_cos_turns(turns);
    let sin = (F32s::splat(1.0) - cos * cos).sqrt();
    Vector::new(sin * cosine, sin * sine, cos)
}

/// One of the models.
#[derive(Clone, Debug)]
pub enum Model {
    Metal(RoughConductor<1>),
    Mixed(MetallicRoughness<1>),
    Plastic(Plastic<1>),
    Measured(Measured<1>),
}

/// What one says between two directions, and what it draws.
pub struct Said {
    pub value: F32s,
    pub kernel: Dense<F32s>,
    pub axis: Vector<F32s>,
}

impl Model {
    fn table(&self) -> GlossyTable<'_, 1> {
        match self {
            Self::Metal(model) => GlossyTable::RoughConductor(std::slice::from_ref(model)),
            Self::Mixed(model) => GlossyTable::MetallicRoughness(std::slice::from_ref(model)),
            Self::Plastic(model) => GlossyTable::Plastic(std::slice::from_ref(model)),
            Self::Measured(model) => GlossyTable::Measured(std::slice::from_ref(model)),
        }
    }

    fn lanes(&self) -> GlossyLanes<'_, 1> {
        self.table().lanes(&LaneRows::Same(0))
    }

    fn metal(eta: f32, k: f32, alpha: f32, distribution: Distribution, multiple: bool) -> Self {
        Self::Metal(RoughConductor::of([eta], [k], alpha, distribution, multiple))
    }

    /// It reflects all light but what is left out.
    fn lossless(alpha: f32, distribution: Distribution, multiple: bool) -> Self {
        Self::metal(1e-6, 1.0, alpha, distribution, multiple)
    }

    fn mixed(color: f32, metallic: f32, alpha: f32, ior: f32) -> Self {
        Self::Mixed(MetallicRoughness::of([color], metallic, alpha, ior, 1.0))
    }

    /// Some of all sorts.
    fn random(numbers: &mut Numbers, alpha_min: f32) -> Self {
        let alpha = alpha_min + (1.0 - alpha_min) * numbers.next();
        let of = [numbers.next(), numbers.next(), numbers.next()];
        match (of[2] * 6.0) as u32 {
            0 => Self::metal(0.05 + 3.0 * of[0], 7.0 * of[1], alpha, Distribution::Ggx, true),
            1 => Self::metal(0.05 + 3.0 * of[0], 7.0 * of[1], alpha, Distribution::Beckmann, true),
            2 => Self::plastic(of[0], 1.5, (alpha, Distribution::Beckmann), numbers),
            3 => Self::plastic(of[0], 2.0, (alpha, Distribution::Ggx), numbers),
            4 => Self::mixed(of[0], 0.0, alpha, if of[1] < 0.5 { 1.2 } else { 2.0 }),
            _ => Self::mixed(of[0], of[1], alpha, 1.5),
        }
    }

    /// With any share of what its facets reflect, and anything within.
    fn plastic(
        reflectance: f32,
        ior: f32,
        (alpha, distribution): (f32, Distribution),
        numbers: &mut Numbers,
    ) -> Self {
        let internal_reflection = InternalReflection::ALL[(numbers.next() * 3.0) as usize];
        let (exterior_ior, specular) = (1.0, numbers.next());
        let coat = Coat { ior, exterior_ior, alpha, distribution, specular, internal_reflection };
        Self::Plastic(Plastic::of([reflectance], coat))
    }

    fn facing() -> Facing {
        let up = Vector::splat([0.0, 0.0, 1.0]);
        Facing { geometric: up, shading: up, two_sided: F32s::splat(0.0) }
    }

    pub fn say(&self, given: Vector<F32s>, drawn: Vector<F32s>) -> Said {
        let (of, facing) = (self.lanes(), Self::facing());
        let [value] = GlossyTable::shape(&of, &facing, given, drawn, Side::Sensor);
        let ([kernel], axis) = GlossyTable::dense_kernels(&of, &facing, -given, drawn);
        Said { value, kernel, axis }
    }

    fn pdf(&self, given: Vector<F32s>, drawn: Vector<F32s>) -> F32s {
        GlossyTable::pdf(&self.lanes(), &Self::facing(), given, drawn)
    }

    fn draw(&self, given: Vector<F32s>, u: [F32s; 2]) -> Drawn<1> {
        let rows = LaneRows::Same(0);
        let u = [u[0], u[1], F32s::splat(0.0)];
        self.table().draw((&rows, &self.lanes()), &Self::facing(), given, u, Side::Sensor)
    }

    fn scattered(&self) -> f32 {
        match self {
            Self::Metal(model) => model.scattered(),
            Self::Mixed(model) => model.scattered(),
            Self::Plastic(model) => model.scattered(),
            Self::Measured(model) => model.scattered(),
        }
    }

    /// The share of light of the cosine that is reflected: the mean weight of what is drawn.
    pub fn albedo(&self, cos: f32) -> f64 {
        // Finely where the first number chooses: of Beckmann's mirrors, the others have a hundredth
        // of it, which counts as much per place. And more where the long tail is.
        const PLACES: usize = 1024;
        const HEIGHTS: usize = 32;
        let given = directions(F32s::splat(cos), F32s::splat(0.3));
        let mut sum = 0.0;
        for height in 0..HEIGHTS {
            let left = 1.0 - (height as f32 + 0.5) / HEIGHTS as f32;
            let second = F32s::splat(1.0 - left * left);
            for place in (0..PLACES).step_by(LANES) {
                let first = lanes::each(|lane| ((place + lane) as f32 + 0.5) / PLACES as f32);
                let drawn = self.draw(given, [F32s::from(first), second]);
                sum += f64::from(2.0 * left * drawn.weight[0].reduce_add());
            }
        }
        sum / (PLACES * HEIGHTS) as f64
    }

    /// The same by a sum over directions.
    pub fn integrated_albedo(&self, cos: f32) -> f64 {
        let given = directions(F32s::splat(cos), F32s::splat(0.3));
        let of = |cos_out: F32s, turns| {
            let value = self.say(given, directions(cos_out, turns)).value;
            f64::from((value * cos_out).reduce_add())
        };
        over_hemisphere(128, of)
    }
}

/// The integral over the hemisphere of a function of cosines and turns, which says sums of eight.
fn over_hemisphere(edge: usize, mut of: impl FnMut(F32s, F32s) -> f64) -> f64 {
    let at = |place: usize| (place as f32 + 0.5) / edge as f32;
    let mut sum = 0.0;
    for row in 0..edge {
        for turn in (0..2 * edge).step_by(LANES) {
            let turns = F32s::from(lanes::each(|lane| 0.5 * at(turn + lane)));
            sum += of(F32s::splat(at(row)), turns);
        }
    }
    2.0 * PI * sum / (2 * edge * edge) as f64
}

/// D and L from their definitions by slopes, with erf by a sum.
mod textbook {
    use super::*;

    pub fn density(distribution: Distribution, alpha: f64, cos: f64) -> f64 {
        let tan2 = (1.0 - cos * cos) / (cos * cos);
        match distribution {
            Distribution::Ggx => {
                1.0 / (PI * alpha * alpha * cos.powi(4) * (1.0 + tan2 / (alpha * alpha)).powi(2))
            }
            Distribution::Beckmann => {
                (-tan2 / (alpha * alpha)).exp() / (PI * alpha * alpha * cos.powi(4))
            }
        }
    }

    fn erf(x: f64) -> f64 {
        let at = |step: i32| (-((f64::from(step) + 0.5) * x / 4000.0).powi(2)).exp();
        (0..4000).map(at).sum::<f64>() * x / 4000.0 * 2.0 / PI.sqrt()
    }

    pub fn lambda(distribution: Distribution, alpha: f64, cos: f64) -> f64 {
        let tan = (1.0 - cos * cos).sqrt() / cos;
        match distribution {
            Distribution::Ggx => 0.5 * ((1.0 + (alpha * tan).powi(2)).sqrt() - 1.0),
            Distribution::Beckmann => {
                let a = 1.0 / (alpha * tan);
                0.5 * (erf(a) - 1.0) + (-a * a).exp() / (2.0 * a * PI.sqrt())
            }
        }
    }

    /// D G2 / (4 cos cos) between directions.
    pub fn facets(distribution: Distribution, alpha: f64, [i, o]: [[f64; 3]; 2]) -> f64 {
        let sum: [f64; 3] = std::array::from_fn(|axis| i[axis] + o[axis]);
        let cos_h = sum[2] / sum.iter().map(|x| x * x).sum::<f64>().sqrt();
        let [of_i, of_o] = [i, o].map(|v| lambda(distribution, alpha, v[2]));
        density(distribution, alpha, cos_h) / (1.0 + of_i + of_o) / (4.0 * i[2] * o[2])
    }
}

fn lane_of(v: Vector<F32s>, lane: usize) -> [f64; 3] {
    v.to_rows()[lane].map(f64::from)
}

#[test]
fn single_reflections_are_those_of_the_definitions() {
    let mut numbers = Numbers(0);
    for (distribution, tolerance) in [(Distribution::Ggx, 2e-4), (Distribution::Beckmann, 8e-3)] {
        for _ in 0..20 {
            let alpha = 0.05 + 0.95 * numbers.next();
            let model = Model::lossless(alpha, distribution, false);
            let (given, drawn) = (numbers.directions(), numbers.directions());
            let values = model.say(given, drawn).value.to_array();
            for (lane, value) in values.into_iter().enumerate() {
                let both = [given, drawn].map(|v| lane_of(v, lane));
                let expected = textbook::facets(distribution, f64::from(alpha), both);
                let error = (f64::from(value) - expected).abs();
                assert!(error < tolerance * expected + 1e-9, "{alpha}: {value}, {expected}");
            }
        }
    }
}

#[test]
fn draws_have_their_densities() {
    const ROWS: usize = 8;
    const TURNS: usize = 16;
    const FINE: usize = 16;
    const PACKETS: usize = 4096;
    let mut numbers = Numbers(1000);
    for case in 0..8 {
        let model = Model::random(&mut numbers, 0.2);
        let cos = 0.05 + 0.95 * numbers.next();
        let given = directions(F32s::splat(cos), F32s::splat(numbers.next()));
        let mut counts = [0.0_f64; ROWS * TURNS];
        for _ in 0..PACKETS {
            let drawn = model.draw(given, [numbers.lanes(), numbers.lanes()]).direction;
            for [x, y, z] in drawn.to_rows() {
                let turn = (y.atan2(x) / std::f32::consts::TAU).rem_euclid(1.0);
                let turn = ((turn * TURNS as f32) as usize).min(TURNS - 1);
                let row = (z * ROWS as f32) as usize;
                if z > 0.0 {
                    counts[row.min(ROWS - 1) * TURNS + turn] += 1.0;
                }
            }
        }
        let all = (PACKETS * LANES) as f64;
        let (mut chi2, mut freedom, mut left) = (0.0, 0.0, [all, all]);
        for (bin, count) in counts.into_iter().enumerate() {
            let mut sum = 0.0;
            for row in 0..FINE {
                let cos = ((bin / TURNS) as f32 + (row as f32 + 0.5) / FINE as f32) / ROWS as f32;
                for first in (0..FINE).step_by(LANES) {
                    let turns = lanes::each(|lane| {
                        let part = ((first + lane) as f32 + 0.5) / FINE as f32;
                        ((bin % TURNS) as f32 + part) / TURNS as f32
                    });
                    let drawn = directions(F32s::splat(cos), F32s::from(turns));
                    sum += f64::from(model.pdf(given, drawn).reduce_add());
                }
            }
            let cell = 2.0 * PI / (ROWS * TURNS * FINE * FINE) as f64;
            let expected = all * sum * cell;
            left = [left[0] - count, left[1] - expected];
            if expected > 10.0 {
                chi2 += (count - expected).powi(2) / expected;
                freedom += 1.0;
            }
        }
        // Those below the surface.
        if left[1] > 10.0 {
            chi2 += (left[0] - left[1]).powi(2) / left[1];
        }
        // Wilson and Hilferty 1931: a standard normal number, which is above 4.2 in one of 75,000
        // cases, of which there are eight.
        let part = 2.0 / (9.0 * freedom);
        let z = ((chi2 / freedom).cbrt() - (1.0 - part)) / part.sqrt();
        assert!(z < 4.2, "case {case}: {chi2} of {freedom}, z {z}, {model:?}, cos {cos}");
    }
}

#[test]
fn what_is_drawn_weighs_what_is_reflected() {
    let mut numbers = Numbers(2000);
    for _ in 0..12 {
        let model = Model::random(&mut numbers, 0.25);
        let cos = 0.1 + 0.9 * numbers.next();
        let [drawn, summed] = [model.albedo(cos), model.integrated_albedo(cos)];
        assert!((drawn - summed).abs() < 4e-3, "{drawn}, {summed}, {model:?} at {cos}");
        assert!(drawn < 1.005, "{drawn}, {model:?} at {cos}");
        // What steers roulette is near it.
        assert!(model.scattered() <= 1.0 && model.scattered() > 0.3 * drawn as f32);
    }
}

/// The stated error of the albedo of facets, and a little for the sums here.
pub fn furnace(distribution: Distribution) -> f64 {
    match distribution {
        Distribution::Ggx => 0.003,
        Distribution::Beckmann => 0.008,
    }
}

/// The same of coats.
pub fn coated(alpha: f32) -> f64 {
    if alpha < 0.2 { 0.012 } else { 0.008 }
}

#[test]
fn lossless_metal_reflects_everything_if_multiple_scattering_is_there() {
    for distribution in Distribution::ALL {
        for alpha in [0.0015, 0.0065, 0.035, 0.3, 1.0] {
            for cos in [0.0175, 0.07, 0.7, 1.0] {
                let [all, once] = [true, false]
                    .map(|multiple| Model::lossless(alpha, distribution, multiple).albedo(cos));
                assert!(
                    (all - 1.0).abs() < furnace(distribution),
                    "{distribution:?} {alpha} {cos}: {all}"
                );
                assert!(once < 1.0 + 2e-3, "{distribution:?} {alpha} {cos}: {once}");
            }
        }
    }
    // At normal incidence on GGX of alpha 1, D = 1 / pi and G1 = 2 c / (1 + c): 1 - ln 2.
    let once = Model::lossless(1.0, Distribution::Ggx, false).albedo(1.0);
    assert!((once - (1.0 - 2.0_f64.ln())).abs() < 1e-3, "{once}");
}

#[test]
fn white_bases_reflect_what_their_coats_do_not() {
    for alpha in [0.0, 0.004, 0.02, 0.1, 0.3, 1.0] {
        for ior in [1.0, 1.5, 2.4] {
            for cos in [0.0175, 0.07, 0.1, 0.4, 1.0] {
                let albedo = Model::mixed(1.0, 0.0, alpha, ior).albedo(cos);
                assert!(
                    (albedo - 1.0).abs() < coated(alpha),
                    "alpha {alpha}, {ior}, {cos}: {albedo}"
                );
            }
        }
        // Its facets reflect 0.999 at most.
        let default = Model::mixed(1.0, 1.0, alpha.max(0.1), 1.5).albedo(0.5);
        assert!((default - 0.998).abs() < coated(alpha), "alpha {alpha}: {default}");
    }
}

#[test]
fn both_directions_are_alike() {
    let mut numbers = Numbers(3000);
    for _ in 0..200 {
        let model = Model::random(&mut numbers, 0.0);
        let (given, drawn) = (numbers.directions(), numbers.directions());
        let [there, back] = [(given, drawn), (drawn, given)]
            .map(|(given, drawn)| model.say(given, drawn).value.to_array());
        for (there, back) in there.into_iter().zip(back) {
            assert!((there - back).abs() <= 2e-4 * there + 1e-12, "{there}, {back}, {model:?}");
        }
    }
}

#[test]
fn no_light_is_polarized_more_than_wholly() {
    let mut numbers = Numbers(4000);
    for case in 0..400 {
        let model = Model::random(&mut numbers, 0.0);
        let given = numbers.directions();
        let drawn = match case % 2 {
            0 => numbers.directions(),
            _ => model.draw(given, [numbers.lanes(), numbers.lanes()]).direction,
        };
        let Said { value, kernel, axis } = model.say(given, drawn);
        let pure =
            directions(numbers.lanes() * F32s::splat(2.0) - F32s::splat(1.0), numbers.lanes());
        let Stokes(s) = kernel.scatter(Stokes([F32s::splat(1.0), pure.x, pure.y, pure.z]));
        let polarized = (s[1] * s[1] + s[2] * s[2] + s[3] * s[3]).sqrt();
        for lane in 0..LANES {
            let [s0, polarized, value] = [s[0], polarized, value].map(|it| it.to_array()[lane]);
            if value > 0.0 {
                assert!(polarized <= s0 + 1e-5, "{polarized} of {s0}, {model:?}");
            }
            assert!(value >= 0.0 && value.is_finite(), "{value}, {model:?}");
            let across = [given, drawn].map(|v| v.dot(axis).to_array()[lane].abs());
            assert!(across.iter().all(|it| *it < 1e-3), "{across:?}");
        }
    }
}

/// Light of a Stokes vector whose axis is across the plane of incidence, reflected: the mean of
/// what is drawn, in a frame across the same plane.
fn reflected(model: &Model, cos: f32, light: [f32; 4]) -> [f64; 4] {
    let given = directions(F32s::splat(cos), F32s::splat(0.0));
    let (k_in, across) = (-given, Vector::splat([0.0, 1.0, 0.0]));
    let mut sums = [0.0; 4];
    let mut numbers = Numbers(5000);
    const PACKETS: usize = 1000;
    for _ in 0..PACKETS {
        let drawn = model.draw(given, [numbers.lanes(), numbers.lanes()]);
        let Said { kernel, axis, .. } = model.say(given, drawn.direction);
        let arriving = Rotation::between(across, axis, k_in).apply(Stokes(light.map(F32s::splat)));
        let out = drawn.direction;
        let to = out.mul_add(-across.dot(out), across);
        let Stokes(leaving) = Rotation::between(axis, to, out).apply(kernel.scatter(arriving));
        let lit = drawn.weight[0].simd_gt(F32s::splat(0.0));
        for (sum, component) in sums.iter_mut().zip(leaving) {
            *sum += f64::from((lit & (drawn.weight[0] * component)).reduce_add());
        }
    }
    sums.map(|sum| sum / (PACKETS * LANES) as f64)
}

#[test]
fn hardly_rough_metal_is_as_smooth_metal() {
    let (eta, k) = (0.96, 6.69);
    for distribution in Distribution::ALL {
        let model = Model::metal(eta, k, 0.002, distribution, true);
        for cos in [0.3, 0.6, 0.9] {
            let (m00, block) = fresnel::conductor(f64::from(cos), f64::from(eta), f64::from(k));
            let light = [1.0, 0.2, -0.6, 0.5];
            let Stokes(expected) = block.scatter(Stokes(light.map(f64::from)));
            let found = reflected(&model, cos, light);
            for (found, expected) in found.into_iter().zip(expected) {
                assert!((found - m00 * expected).abs() < 6e-3, "{found} {}", m00 * expected);
            }
        }
    }
}

/// Of GGX, facets with slopes above three alpha are a tenth.
#[test]
fn peaks_hold_nine_tenths_of_what_is_reflected_straight_back() {
    let alpha = 0.1;
    let model = Model::lossless(alpha, Distribution::Ggx, false);
    let given = Vector::splat([0.0, 0.0, 1.0]);
    let (mut numbers, mut outside) = (Numbers(6000), 0);
    const PACKETS: usize = 1000;
    for _ in 0..PACKETS {
        let drawn = model.draw(given, [numbers.lanes(), numbers.lanes()]).direction;
        let is_outside = half_sine2(given, drawn).simd_ge(F32s::splat(peak(alpha)));
        outside += is_outside.to_bitmask().count_ones();
    }
    // Five standard errors: by chance in one of two million.
    let share = f64::from(outside) / (PACKETS * LANES) as f64;
    let error = (0.1 * 0.9 / (PACKETS * LANES) as f64).sqrt();
    assert!((share - 0.1).abs() < 5.0 * error, "{share}");
    assert_eq!([peak(NARROW), peak(1.0)], [0.0; 2]);
}

/// Unpolarized light at Brewster's angle on rough glass of which nothing but the coat reflects:
/// the sum over facets of the fields that they reflect.
#[test]
fn rough_glass_at_brewsters_angle_polarizes_as_fields_do() {
    let (ior, alpha) = (1.5_f64, 0.3);
    let cos = 1.0 / (1.0 + ior * ior).sqrt();
    let model = Model::mixed(0.0, 0.0, alpha as f32, ior as f32);
    let found = reflected(&model, cos as f32, [1.0, 0.0, 0.0, 0.0]);
    let (sin, mut expected) = ((1.0 - cos * cos).sqrt(), [0.0; 2]);
    let i = [sin, 0.0, cos];
    const EDGE: usize = 200;
    for (row, turn) in (0..EDGE).flat_map(|row| (0..2 * EDGE).map(move |turn| (row, turn))) {
        let z = (row as f64 + 0.5) / EDGE as f64;
        let phi = (turn as f64 + 0.5) * PI / EDGE as f64;
        let r = (1.0 - z * z).sqrt();
        let o = [r * phi.cos(), r * phi.sin(), z];
        let facets = textbook::facets(Distribution::Ggx, alpha, [i, o]) * z;
        for (sum, part) in expected.iter_mut().zip(by_fields(ior, i, o)) {
            *sum += facets * part * 2.0 * PI / (2 * EDGE * EDGE) as f64;
        }
    }
    assert!(expected[1] > 0.6 * expected[0], "{expected:?}");
    for (found, expected) in found.into_iter().zip(expected) {
        assert!((found - expected).abs() < 0.01 * expected, "{found}, {expected}");
    }
}

/// S0 and S1, about the axis across the plane of incidence, of unpolarized light from `i` that a
/// mirror of glass sends to `o`: of two fields that are perpendicular to each other.
fn by_fields(ior: f64, i: [f64; 3], o: [f64; 3]) -> [f64; 2] {
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let unit = |a: [f64; 3]| a.map(|x| x / dot(a, a).sqrt());
    let h = unit(std::array::from_fn(|axis| i[axis] + o[axis]));
    let k_in = i.map(|x| -x);
    let s = unit(cross(h, k_in));
    let (p_in, p_out) = (cross(k_in, s), cross(o, s));
    let cos_i = dot(i, h);
    let cos_t = (1.0 - (1.0 - cos_i * cos_i) / (ior * ior)).sqrt();
    let r_s = (cos_i - ior * cos_t) / (cos_i + ior * cos_t);
    // Of p axes that turn with the light: at normal incidence they are opposite.
    let r_p = (ior * cos_i - cos_t) / (ior * cos_i + cos_t);
    let x = [0.0, 1.0, 0.0];
    let x = unit(std::array::from_fn(|axis| x[axis] - dot(x, o) * o[axis]));
    let y = cross(o, x);
    let mut sums = [0.0; 2];
    for field in [s, p_in] {
        let [of_s, of_p] = [r_s * dot(field, s), r_p * dot(field, p_in)];
        let out: [f64; 3] = std::array::from_fn(|axis| of_s * s[axis] + of_p * p_out[axis]);
        let [along, across] = [dot(out, x).powi(2), dot(out, y).powi(2)];
        sums[0] += 0.5 * (along + across);
        sums[1] += 0.5 * (along - across);
    }
    sums
}
