//! Tables that are written from models, and read again.

use super::*;
use crate::polarization::kernel::Kernel;
use crate::polarization::{Distribution, Stokes};
use crate::scattering::surface::metallic_roughness::MetallicRoughness;
use crate::scattering::surface::plastic::Plastic;
use crate::scattering::surface::rough::tests::{Model, Numbers, Said, directions};
use crate::scattering::surface::rough_conductor::RoughConductor;
use crate::scene::world::{Coat, InternalReflection};

/// Numbers along phi_d, theta_d and theta_h.
const COUNTS: [usize; 3] = [25, 31, 41];

/// A file of a model, at wavelengths at which it is brighter and brighter; `mend` changes a matrix.
fn file(model: &Model, wavelengths: usize, mut mend: impl FnMut(&mut [f32; 16])) -> Vec<u8> {
    use std::f32::consts::{FRAC_PI_2, PI, TAU};
    let along = |count: usize, from: f32, range: f32| -> Vec<f32> {
        (0..count).map(|at| from + range * at as f32 / (count - 1) as f32).collect()
    };
    let axes = [
        along(COUNTS[0], -PI, TAU),
        along(COUNTS[1], 0.0, FRAC_PI_2),
        along(COUNTS[2], 0.0, FRAC_PI_2),
    ];
    let mut matrices = Vec::new();
    for &phi_d in &axes[0] {
        for &theta_d in &axes[1] {
            for row in axes[2].chunks(LANES) {
                let theta_h: [f32; LANES] = std::array::from_fn(|lane| row[lane % row.len()]);
                let of = matrix_of(model, phi_d, theta_d, F32s::from(theta_h));
                for matrix in &of[..row.len()] {
                    for wave in 0..wavelengths {
                        let mut matrix = matrix.map(|element| element * (1 + wave) as f32);
                        mend(&mut matrix);
                        matrices.extend(matrix);
                    }
                }
            }
        }
    }
    let nm: Vec<f32> = (0..wavelengths).map(|wave| 450.0 + 50.0 * wave as f32).collect();
    let [phi_d, theta_d, theta_h] = axes;
    let [a, b, c] = COUNTS;
    tensors(&[
        ("phi_d", &[1, a], phi_d),
        ("theta_d", &[1, b], theta_d),
        ("theta_h", &[1, c], theta_h),
        ("wvls", &[wavelengths], nm),
        ("M", &[a, b, c, wavelengths, 4, 4], matrices),
    ])
}

/// Fields of single precision.
fn tensors(fields: &[(&str, &[usize], Vec<f32>)]) -> Vec<u8> {
    let mut head = b"tensor_file\0\x01\x00".to_vec();
    head.extend((fields.len() as u32).to_le_bytes());
    let size = |(name, shape, _): &(&str, &[usize], Vec<f32>)| 13 + name.len() + 8 * shape.len();
    let mut at = head.len() + fields.iter().map(size).sum::<usize>();
    for (name, shape, values) in fields {
        head.extend((name.len() as u16).to_le_bytes());
        head.extend(name.as_bytes());
        head.extend((shape.len() as u16).to_le_bytes());
        head.push(10);
        head.extend((at as u64).to_le_bytes());
        head.extend(shape.iter().flat_map(|extent| (*extent as u64).to_le_bytes()));
        at += 4 * values.len();
    }
    head.extend(fields.iter().flat_map(|(_, _, values)| values).flat_map(|v| v.to_le_bytes()));
    head
}

/// What a model reflects of light from i to o, by Rusinkiewicz' angles; not a number where one is
/// below the surface.
fn matrix_of(model: &Model, phi_d: f32, theta_d: f32, theta_h: F32s) -> [[f32; 16]; LANES] {
    // About the half vector in the plane of x: `away` leads away from the normal.
    let (sin_h, cos_h) = (theta_h.sin(), theta_h.cos());
    let half = Vector::new(sin_h, F32s::ZERO, cos_h);
    let (across, away) =
        (Vector::new(F32s::ZERO, F32s::ONE, F32s::ZERO), Vector::new(cos_h, F32s::ZERO, -sin_h));
    // Straight back there is no plane of the two, but that of the turn which it is written for.
    let theta_d = theta_d.max(1e-3);
    let aside = away * F32s::splat(phi_d.cos()) + across * F32s::splat(phi_d.sin());
    let [sin_d, cos_d] = [theta_d.sin(), theta_d.cos()].map(F32s::splat);
    let (i, o) = (half * cos_d + aside * sin_d, half * cos_d - aside * sin_d);
    let Said { value, kernel: Dense(kernel), .. } = model.say(i, o);
    let (value, above) = (value.to_array(), [i.z, o.z].map(|z| z.to_array()));
    std::array::from_fn(|lane| {
        let is_above = above.iter().all(|z| z[lane] > 0.0);
        let value = if is_above { value[lane] } else { f32::NAN };
        std::array::from_fn(|at| value * kernel[at / 4][at % 4].to_array()[lane])
    })
}

fn measured(bytes: Vec<u8>) -> Model {
    let table = MeasuredTable::new("test", bytes).unwrap_or_else(|fault| panic!("{fault}"));
    Model::Measured(Measured::of(table, [0.0]))
}

fn models() -> [Model; 3] {
    let metal = RoughConductor::of([0.9], [3.0], 0.4, Distribution::Ggx, true);
    let coat = Coat {
        ior: 1.5,
        exterior_ior: 1.0,
        alpha: 0.5,
        distribution: Distribution::Ggx,
        specular: 1.0,
        internal_reflection: InternalReflection::Nonlinear,
    };
    let plastic = Plastic::of([0.5], coat);
    let mixed = MetallicRoughness::of([0.6], 0.3, 0.6, 1.5, 1.0);
    [Model::Metal(metal), Model::Plastic(plastic), Model::Mixed(mixed)]
}

#[test]
fn tables_of_models_are_as_the_models() {
    let mut numbers = Numbers(100);
    for model in models() {
        let table = measured(file(&model, 1, |_| ()));
        let mut sums = [0.0; 2];
        for _ in 0..40 {
            let cos = |number: F32s| number * F32s::splat(0.7) + F32s::splat(0.3);
            let [i, o] = [(); 2].map(|()| directions(cos(numbers.lanes()), numbers.lanes()));
            let [found, expected] = [&table, &model].map(|model| model.say(i, o));
            let [a, b] = [&found, &expected].map(|said| said.value.to_array());
            let [Dense(m), Dense(n)] = [found.kernel, expected.kernel];
            for lane in 0..LANES {
                let error = (a[lane] - b[lane]).abs();
                let way = [i, o].map(|v| v.to_rows()[lane]);
                assert!(error < 0.02 * b[lane] + 2e-3, "{}, {}, {way:?}", a[lane], b[lane]);
                sums = [sums[0] + a[lane], sums[1] + b[lane]];
                let elements = m.as_flattened().iter().zip(n.as_flattened());
                for (at, (m, n)) in elements.enumerate() {
                    let [m, n] = [m, n].map(|element| element.to_array()[lane]);
                    assert!((m - n).abs() < 0.04, "element {at}: {m}, {n}, {way:?}, {model:?}");
                }
            }
        }
        // What is linear between lies to one side of what bends.
        assert!((sums[0] / sums[1] - 1.0).abs() < 5e-3, "{sums:?}");
    }
}

#[test]
fn what_is_drawn_weighs_what_is_reflected() {
    let [_, model, _] = models();
    let table = measured(file(&model, 1, |_| ()));
    let [drawn, summed] = [table.albedo(0.6), table.integrated_albedo(0.6)];
    assert!((drawn - summed).abs() < 4e-3, "{drawn}, {summed}");
    assert!((drawn - model.albedo(0.6)).abs() < 0.02);
}

#[test]
fn noise_makes_no_light_and_no_way_forth_without_back() {
    let mut noise = Numbers(200);
    let [model, ..] = models();
    let table = measured(file(&model, 1, |matrix| {
        let m00 = matrix[0];
        matrix.iter_mut().for_each(|element| *element += 0.4 * m00 * (noise.next() - 0.5));
    }));
    let mut numbers = Numbers(300);
    let mut mended = 0;
    for _ in 0..60 {
        let (i, o) = (numbers.directions(), numbers.directions());
        let Said { value, kernel, .. } = table.say(i, o);
        let back = table.say(o, i);
        for (there, back) in value.to_array().into_iter().zip(back.value.to_array()) {
            assert!((there - back).abs() <= 1e-5 * there, "{there}, {back}");
        }
        let pure =
            directions(numbers.lanes() * F32s::splat(2.0) - F32s::splat(1.0), numbers.lanes());
        let Stokes(s) = kernel.scatter(Stokes([F32s::splat(1.0), pure.x, pure.y, pure.z]));
        let polarized = (s[1] * s[1] + s[2] * s[2] + s[3] * s[3]).sqrt();
        for lane in 0..LANES {
            let [s0, polarized, value] = [s[0], polarized, value].map(|it| it.to_array()[lane]);
            if value > 0.0 {
                assert!(polarized <= s0 + 1e-5, "{polarized} of {s0}");
                mended += usize::from(polarized > 0.9 * s0);
            }
        }
    }
    assert!(mended > 20, "{mended} are nearly polarized");
}

#[test]
fn wavelengths_are_linear_between_those_of_the_table() {
    let [model, ..] = models();
    let table = MeasuredTable::new("test", file(&model, 3, |_| ())).unwrap();
    assert_eq!((table.wavelengths(), table.ends_nm()), (3, [450.0, 550.0]));
    let angles = [0.7, 0.4, 0.3];
    let [one, between, last] = table.at::<1, 3>(angles, &[0.0, 0.25, 2.0]).map(|[m00]| m00);
    assert!((between / one - 1.25).abs() < 1e-4 && (last / one - 3.0).abs() < 1e-4);
    let places = crate::spectrum::Carried::at([450.0, 462.5, 550.0]);
    let places = table.places().sample(&places, crate::spectrum::Role::Index).unwrap();
    assert_eq!(places, [0.0, 0.25, 2.0]);
}
