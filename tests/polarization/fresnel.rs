//! Interfaces against tabulated Mueller matrices and closed forms.

use std::f64::consts::PI;

use sunstone::internals::math::{F32s, LANES, Real};
use sunstone::internals::polarization::{Block, conductor, conductor_reflectance, dielectric};
use sunstone::internals::polarization::{Interface, dielectric_reflectance, pane};

/// Double precision against tables whose two independent methods agree to 6e-14.
const TOLERANCE_F64: f64 = 1e-12;

/// Single precision, for which cosines and indices are rounded before they arrive.
const TOLERANCE_F32: f64 = 5e-6;

/// Degrees about the critical angle where a rounded cosine alone moves R by more than that.
const CRITICAL_MARGIN_DEG: f64 = 0.05;

const DIELECTRICS: [(&str, f64); 4] = [
    (include_str!("../data/fresnel/dielectric_ext_1_to_1.33.csv"), 1.33),
    (include_str!("../data/fresnel/dielectric_ext_1_to_1.5.csv"), 1.5),
    (include_str!("../data/fresnel/dielectric_int_1.33_to_1.csv"), 1.0 / 1.33),
    (include_str!("../data/fresnel/dielectric_int_1.5_to_1.csv"), 1.0 / 1.5),
];

const CONDUCTORS: [(&str, &str, f64); 9] = [
    (include_str!("../data/fresnel/conductor_Al_450.csv"), "Al", 450.0),
    (include_str!("../data/fresnel/conductor_Al_550.csv"), "Al", 550.0),
    (include_str!("../data/fresnel/conductor_Al_650.csv"), "Al", 650.0),
    (include_str!("../data/fresnel/conductor_Au_450.csv"), "Au", 450.0),
    (include_str!("../data/fresnel/conductor_Au_550.csv"), "Au", 550.0),
    (include_str!("../data/fresnel/conductor_Au_650.csv"), "Au", 650.0),
    (include_str!("../data/fresnel/conductor_Cu_450.csv"), "Cu", 450.0),
    (include_str!("../data/fresnel/conductor_Cu_550.csv"), "Cu", 550.0),
    (include_str!("../data/fresnel/conductor_Cu_650.csv"), "Cu", 650.0),
];

/// The named columns of a table, row by row.
fn columns<const N: usize>(table: &str, names: [&str; N]) -> Vec<[f64; N]> {
    let mut lines = table.lines();
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let places = names
        .map(|name| header.iter().position(|column| *column == name).expect("the column exists"));
    let read = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        places.map(|place| cells[place].parse().expect("a number"))
    };
    lines.map(read).collect()
}

/// `n, k` of a metal from the table's own list.
fn metal(name: &str, wavelength_nm: f64) -> (f64, f64) {
    let list = include_str!("../data/fresnel/ior_used.csv");
    let line = list
        .lines()
        .find(|line| line.starts_with(&format!("{name},{wavelength_nm:.1}")))
        .expect("the metal is listed");
    let cells: Vec<&str> = line.split(',').collect();
    (cells[2].parse().expect("n"), cells[3].parse().expect("k"))
}

/// `R00 R01 R22 R32`.
fn reflection_elements(m00: f64, block: Block<f64>) -> [f64; 4] {
    [m00, m00 * block.a, m00 * block.c, -m00 * block.s]
}

/// `R00 R01 R22 R32 T00 T01 T22`.
fn interface_elements(interface: &Interface<f64>) -> [f64; 7] {
    let [r00, r01, r22, r32] = reflection_elements(interface.reflectance, interface.reflection);
    let (t00, block) = (interface.transmittance, interface.transmission);
    [r00, r01, r22, r32, t00, t00 * block.a, t00 * block.c]
}

fn lane(values: F32s, lane: usize) -> f64 {
    f64::from(values.to_array()[lane])
}

fn lane_block(block: Block<F32s>, l: usize) -> Block<f64> {
    Block { a: lane(block.a, l), c: lane(block.c, l), s: lane(block.s, l) }
}

fn lane_interface(interface: &Interface<F32s>, l: usize) -> Interface<f64> {
    Interface {
        reflectance: lane(interface.reflectance, l),
        reflection: lane_block(interface.reflection, l),
        transmittance: lane(interface.transmittance, l),
        transmission: lane_block(interface.transmission, l),
        cos_t: lane(interface.cos_t, l),
    }
}

/// Eight numbers, rounded; the last repeats where there are fewer.
fn pack(values: &[f64]) -> F32s {
    F32s::from(std::array::from_fn::<f32, LANES, _>(|l| values[l.min(values.len() - 1)] as f32))
}

fn largest_error(found: &[f64], expected: &[f64]) -> f64 {
    assert!(found.iter().all(|element| element.is_finite()));
    found.iter().zip(expected).fold(0.0, |worst, (a, b)| f64::max(worst, (a - b).abs()))
}

#[test]
fn dielectric_tables() {
    let names = ["theta_i_deg", "R00", "R01", "R22", "R32", "T00", "T01", "T22", "theta_t_deg"];
    let (mut worst, mut rows) = (0.0_f64, 0);
    for (table, eta) in DIELECTRICS {
        for [theta_deg, expected @ .., theta_t_deg] in columns(table, names) {
            let interface = dielectric(theta_deg.to_radians().cos(), eta);
            let error = largest_error(&interface_elements(&interface), &expected);
            assert!(error <= TOLERANCE_F64, "{eta} at {theta_deg} degrees: {error:e}");
            let cos_t = if theta_t_deg.is_nan() { 0.0 } else { theta_t_deg.to_radians().cos() };
            let grazing = theta_deg == 90.0; // tabulated as if total
            assert!(grazing || (interface.cos_t - cos_t).abs() <= TOLERANCE_F64);
            worst = worst.max(error);
            rows += 1;
        }
    }
    println!("dielectrics, f64: {rows} rows, largest error {worst:e}");
}

#[test]
fn conductor_tables() {
    let (mut worst, mut rows) = (0.0_f64, 0);
    for (table, name, wavelength_nm) in CONDUCTORS {
        let (n, k) = metal(name, wavelength_nm);
        let names = ["theta_i_deg", "R00", "R01", "R22", "R32"];
        for [theta_deg, expected @ ..] in columns(table, names) {
            let (m00, block) = conductor(theta_deg.to_radians().cos(), n, k);
            let error = largest_error(&reflection_elements(m00, block), &expected);
            assert!(error <= TOLERANCE_F64, "{name} at {theta_deg} degrees: {error:e}");
            worst = worst.max(error);
            rows += 1;
        }
    }
    println!("conductors, f64: {rows} rows, largest error {worst:e}");
}

#[test]
fn dielectric_tables_in_lanes() {
    let names = ["theta_i_deg", "R00", "R01", "R22", "R32", "T00", "T01", "T22"];
    let mut worst = 0.0_f64;
    for (table, eta) in DIELECTRICS {
        let critical_deg = eta.asin().to_degrees();
        let mut rows = columns(table, names);
        rows.retain(|row| eta > 1.0 || (row[0] - critical_deg).abs() > CRITICAL_MARGIN_DEG);
        for group in rows.chunks(LANES) {
            let cosines: Vec<f64> = group.iter().map(|row| row[0].to_radians().cos()).collect();
            let interface = dielectric(pack(&cosines), F32s::splat(eta as f32));
            for (l, [_, expected @ ..]) in group.iter().enumerate() {
                let elements = interface_elements(&lane_interface(&interface, l));
                worst = worst.max(largest_error(&elements, expected));
            }
        }
    }
    println!("dielectrics, f32 lanes: largest error {worst:e}");
    assert!(worst <= TOLERANCE_F32);
}

#[test]
fn conductor_tables_in_lanes() {
    let mut worst = 0.0_f64;
    for (table, name, wavelength_nm) in CONDUCTORS {
        let (n, k) = metal(name, wavelength_nm);
        let rows = columns(table, ["theta_i_deg", "R00", "R01", "R22", "R32"]);
        for group in rows.chunks(LANES) {
            let cosines: Vec<f64> = group.iter().map(|row| row[0].to_radians().cos()).collect();
            let (m00, block) =
                conductor(pack(&cosines), F32s::splat(n as f32), F32s::splat(k as f32));
            for (l, [_, expected @ ..]) in group.iter().enumerate() {
                let elements = reflection_elements(lane(m00, l), lane_block(block, l));
                worst = worst.max(largest_error(&elements, expected));
            }
        }
    }
    println!("conductors, f32 lanes: largest error {worst:e}");
    assert!(worst <= TOLERANCE_F32);
}

fn special_angles() -> serde_json::Value {
    let text = include_str!("../data/fresnel/special_angles.json");
    serde_json::from_str(text).expect("the special angles are valid JSON")
}

/// The interfaces of `special_angles.json` by name, with `n_t / n_i`.
const SPECIAL: [(&str, f64); 4] =
    [("1->1.5", 1.5), ("1.5->1", 1.0 / 1.5), ("1->1.33", 1.33), ("1.33->1", 1.0 / 1.33)];

#[test]
fn brewster_critical_and_normal_incidence() {
    let special = special_angles();
    for (name, eta) in SPECIAL {
        let number = |key: &str| special[name][key].as_f64().expect("a number");
        let brewster = dielectric(number("brewster_deg").to_radians().cos(), eta);
        assert!((brewster.reflection.a - 1.0).abs() <= TOLERANCE_F64);
        assert!(brewster.reflection.c.abs() <= TOLERANCE_F64);
        assert!((brewster.cos_t - eta.atan().sin()).abs() <= TOLERANCE_F64);

        let normal = dielectric(1.0, eta);
        assert!((normal.reflectance - number("R0")).abs() <= TOLERANCE_F64);
        assert_eq!(normal.reflection, Block { a: 0.0, c: -1.0, s: 0.0 });
        assert!((normal.transmission.c - 1.0).abs() <= 1e-15 && normal.transmission.a == 0.0);

        if eta < 1.0 {
            let critical = number("critical_deg").to_radians();
            let total = dielectric((critical + 1e-6).cos(), eta);
            assert_eq!((total.reflectance, total.transmittance, total.cos_t), (1.0, 0.0, 0.0));
            assert_eq!(total.transmission, Block::identity());
            let partial = dielectric((critical - 1e-6).cos(), eta);
            assert!(partial.transmittance > 0.0 && partial.transmittance < 0.02);
        }
    }
}

/// Azzam 2004: the phase `arg r_p - arg r_s` of total reflection, its largest value and the angle
/// where it is reached.
#[test]
fn total_reflection_phase() {
    let special = special_angles();
    for (name, eta) in [SPECIAL[1], SPECIAL[3]] {
        let number = |key: &str| special[name][key].as_f64().expect("a number");
        let phase = |theta: f64| {
            let Block { c, s, .. } = dielectric(theta.cos(), eta).reflection;
            (-s).atan2(c)
        };
        let largest_at = number("tir_theta_at_delta_max_deg").to_radians();
        let largest = phase(largest_at);
        assert!((largest - number("tir_delta_max_deg").to_radians()).abs() <= TOLERANCE_F64);
        assert!(phase(largest_at - 1e-4) < largest && phase(largest_at + 1e-4) < largest);
        let critical = eta.asin();
        for step in 1..100 {
            let theta = critical + (0.5 * PI - critical) * f64::from(step) / 100.0;
            let (sin, n) = (theta.sin(), 1.0 / eta);
            let decay = (n * n * sin * sin - 1.0).sqrt();
            let closed = 2.0 * (decay / (n * sin * theta.tan())).atan();
            assert!((phase(theta) - closed).abs() <= TOLERANCE_F64);
        }
    }
}

/// Nodes and weights of Gauss and Legendre on 0 to 1, by Newton's method.
fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    let node = |i: usize| {
        let mut x = (PI * (i as f64 + 0.75) / (count as f64 + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..10 {
            let (mut before, mut value) = (1.0, x);
            for n in 2..=count {
                let n = n as f64;
                (before, value) = (value, ((2.0 * n - 1.0) * x * value - (n - 1.0) * before) / n);
            }
            slope = count as f64 * (x * value - before) / (x * x - 1.0);
            x -= value / slope;
        }
        (0.5 + 0.5 * x, 1.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..count).map(node).collect()
}

/// Cosine-weighted averages over the hemisphere. Below the critical angle of an internal
/// reflection `g^2 = cos_i^2 + eta^2 - 1` is the variable (`cos_i dcos_i = g dg`), in which the
/// integrand is smooth; beyond that angle all is reflected.
#[test]
fn hemispherical_averages() {
    let special = special_angles();
    let mut worst = 0.0_f64;
    for (name, eta) in SPECIAL {
        let total = f64::max(1.0 - eta * eta, 0.0);
        let range = if total > 0.0 { eta } else { 1.0 };
        let (mut r00, mut r01) = (total, 0.0);
        for (node, weight) in gauss_legendre(64) {
            let variable = range * node;
            let weight = weight * range * 2.0 * variable;
            let interface = dielectric((variable * variable + total).sqrt(), eta);
            r00 += weight * interface.reflectance;
            r01 += weight * interface.reflectance * interface.reflection.a;
        }
        let found = [r00, r01, r00 + r01, r00 - r01];
        let number = |key: &str| special[name][key].as_f64().expect("a number");
        let expected = [
            number("hemispherical_R"),
            number("hemispherical_R01"),
            number("hemispherical_R_s"),
            number("hemispherical_R_p"),
        ];
        worst = worst.max(largest_error(&found, &expected));
    }
    println!("hemispherical averages: largest error {worst:e}");
    assert!(worst <= TOLERANCE_F64);
}

/// Numbers from 0 to 1 that are the same in every run.
fn random_numbers(mut state: u64) -> impl Iterator<Item = f64> {
    std::iter::repeat_with(move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    })
}

/// The polarized and the scalar renderer must agree in every bit.
#[test]
fn scalar_reflectances_are_the_same_bits() {
    let mut random = random_numbers(1);
    let mut draw = |scale: f64| -> F32s {
        pack(&std::array::from_fn::<f64, LANES, _>(|_| scale * random.next().expect("endless")))
    };
    for _ in 0..10_000 {
        let (cos_i, eta, k) = (draw(1.0), draw(3.0) + F32s::splat(0.3), draw(6.0));
        let interface = dielectric(cos_i, eta);
        let (reflectance, cos_t) = dielectric_reflectance(cos_i, eta);
        assert_eq!(reflectance.to_array(), interface.reflectance.to_array());
        assert_eq!(cos_t.to_array(), interface.cos_t.to_array());
        let (m00, _) = conductor(cos_i, eta, k);
        assert_eq!(conductor_reflectance(cos_i, eta, k).to_array(), m00.to_array());
    }
}

/// The same inputs, rounded first, in `f64` and in lanes; and every kernel is physical.
#[test]
fn lanes_agree_with_doubles_on_random_interfaces() {
    let mut random = random_numbers(2);
    let mut worst = 0.0_f64;
    for _ in 0..20_000 {
        let mut draw = || f64::from(random.next().expect("endless") as f32);
        let (cos_i, eta, k) = (draw(), 0.3 + 3.0 * draw(), 6.0 * draw());
        let (eta, k) = (f64::from(eta as f32), f64::from(k as f32));
        let interface = dielectric(cos_i, eta);
        let lanes = dielectric(pack(&[cos_i]), pack(&[eta]));
        let near_critical = (cos_i * cos_i + eta * eta - 1.0).abs() < 5e-3;
        if !near_critical {
            let found = interface_elements(&lane_interface(&lanes, 3));
            worst = worst.max(largest_error(&found, &interface_elements(&interface)));
        }
        let (m00, block) = conductor(cos_i, eta, k);
        let (lanes_m00, lanes_block) = conductor(pack(&[cos_i]), pack(&[eta]), pack(&[k]));
        let found = reflection_elements(lane(lanes_m00, 5), lane_block(lanes_block, 5));
        worst = worst.max(largest_error(&found, &reflection_elements(m00, block)));

        for physical in [interface.reflection, interface.transmission, block] {
            assert_pure(physical, 1e-14);
        }
        for physical in [lanes.reflection, lanes.transmission, lanes_block] {
            assert_pure(lane_block(physical, 0), 1e-6);
        }
        assert_eq!(interface.reflectance + interface.transmittance, 1.0);
    }
    println!("random interfaces: lanes differ from doubles by at most {worst:e}");
    assert!(worst <= TOLERANCE_F32);
}

/// A smooth interface depolarizes nothing: `a^2 + c^2 + s^2 = 1`.
fn assert_pure(block: Block<f64>, tolerance: f64) {
    let Block { a, c, s } = block;
    assert!(a.abs() <= 1.0 + tolerance);
    assert!((a * a + c * c + s * s - 1.0).abs() <= tolerance, "{block:?}");
}

/// Grazing, normal and index-matched light in every combination yields numbers.
#[test]
fn corner_cases_are_finite() {
    fn check<F: Real>(read: impl Fn(F) -> f64) {
        for cos_i in [0.0, 1e-30, 1e-12, 1e-4, 0.5, 1.0 - 6e-8, 1.0] {
            for eta in [0.4, 1.0 - 1e-7, 1.0, 1.0 + 1e-7, 1.5, 4.0] {
                let (cos_i, eta) = (F::splat(cos_i), F::splat(eta));
                let Interface { reflectance, reflection, transmission, cos_t, .. } =
                    dielectric(cos_i, eta);
                let (m00, metal) = conductor(cos_i, eta, F::zero());
                for block in [reflection, transmission, metal] {
                    let Block { a, c, s } = block;
                    let [a, c, s] = [a, c, s].map(&read);
                    assert_pure(Block { a, c, s }, 1e-6);
                }
                for fraction in [reflectance, cos_t, m00] {
                    assert!((0.0..=1.0).contains(&read(fraction)));
                }
            }
        }
    }
    check::<f64>(|value| value);
    check::<f32>(f64::from);
    check::<F32s>(|values| lane(values, 7));
}

/// Mueller matrix of a block whose first element is `m00`, between frames of the s axis.
fn mueller(m00: f64, Block { a, c, s }: Block<f64>) -> [[f64; 4]; 4] {
    let rows = [[1.0, a, 0.0, 0.0], [a, 1.0, 0.0, 0.0], [0.0, 0.0, c, s], [0.0, 0.0, -s, c]];
    rows.map(|row| row.map(|element| m00 * element))
}

fn product(a: &[[f64; 4]; 4], b: &[[f64; 4]; 4]) -> [[f64; 4]; 4] {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..4).map(|k| a[i][k] * b[k][j]).sum()))
}

/// A pane against the sum of what light does that is reflected to and fro between two faces, as
/// Mueller matrices of the interfaces.
#[test]
fn a_pane_is_the_sum_of_all_reflections_within() {
    for eta in [1.0001, 1.33, 1.5, 2.4, 0.8] {
        for degrees in [0.0_f64, 30.0, 45.0, 56.31, 75.0, 88.0] {
            let cos_i = degrees.to_radians().cos();
            let outer = dielectric(cos_i, eta);
            if outer.transmittance == 0.0 {
                let pane = pane(cos_i, eta);
                assert_eq!((pane.transmittance, pane.reflection), (0.0, outer.reflection));
                continue;
            }
            let inner = dielectric(outer.cos_t, 1.0 / eta);
            let enter = mueller(outer.transmittance, outer.transmission);
            let leave = mueller(inner.transmittance, inner.transmission);
            let bounce = mueller(inner.reflectance, inner.reflection);
            let mut inside = enter;
            let mut transmitted = [[0.0; 4]; 4];
            let mut reflected = mueller(outer.reflectance, outer.reflection);
            for order in 0..4000 {
                let leaves = product(&leave, &inside);
                let sum = if order % 2 == 0 { &mut transmitted } else { &mut reflected };
                for (sum, row) in sum.iter_mut().flatten().zip(leaves.iter().flatten()) {
                    *sum += row;
                }
                inside = product(&bounce, &inside);
            }
            let pane = pane(cos_i, eta);
            let passes = mueller(pane.transmittance, pane.transmission);
            let returns = mueller(1.0 - pane.transmittance, pane.reflection);
            for (found, expected) in [(passes, transmitted), (returns, reflected)] {
                for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
                    let error = (found - expected).abs();
                    assert!(error < 1e-10, "{found}, not {expected}: eta {eta}, {degrees} degrees");
                }
            }
        }
    }
}
