//! Laws of optics, and of the algebra itself, that hold whatever the numbers.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use sunstone::internals::math::{F32s, LANES, Real, Vector};
use sunstone::internals::polarization::elements::{
    polarizer_block, retarder_block, transmission_axis,
};
use sunstone::internals::polarization::{Block, Dense, Kernel, LightCarrier, Rotation, SensorRow};
use sunstone::internals::polarization::{
    SpheroidBlock, Stokes, conductor, dielectric, film_axis, s_axis,
};

use crate::vertex::Vertex;

const TOLERANCE: f64 = 1e-14;

fn vector(x: f64, y: f64, z: f64) -> Vector<f64> {
    Vector::new(x, y, z)
}

/// The axis at an angle from x about +z, the direction of the light in most of these tests.
fn axis(angle: f64) -> Vector<f64> {
    vector(angle.cos(), angle.sin(), 0.0)
}

/// An element in a beam along +z whose axis is at this angle from x.
fn element(kernel: Block<f64>, angle: f64) -> Vertex<f64> {
    let k = vector(0.0, 0.0, 1.0);
    Vertex { kernel, x: axis(angle), k_in: k, k_out: k }
}

fn scatter<F: Real>(light: LightCarrier<F>, event: &Vertex<F>) -> LightCarrier<F> {
    light.scatter(&event.arrival(light.x), event.kernel)
}

fn collect<F: Real>(sensor: SensorRow<F>, event: &Vertex<F>) -> SensorRow<F> {
    sensor.collect(&event.departure(sensor.x), event.kernel)
}

fn assert_stokes(found: Stokes<f64>, expected: [f64; 4], tolerance: f64) {
    for (a, b) in found.0.iter().zip(expected) {
        assert!((a - b).abs() <= tolerance, "{found:?} is not {expected:?}");
    }
}

/// Power behind ideal polarizers at these angles, from both sides.
fn power_behind_polarizers(angles_deg: &[f64]) -> f64 {
    let (m00, block) = polarizer_block(1.0, 0.0);
    let events: Vec<_> =
        angles_deg.iter().map(|angle| element(block, angle.to_radians())).collect();
    let light = LightCarrier::unpolarized(axis(0.3));
    let scattered = events.iter().fold(light, scatter);
    let row = events.iter().rev().fold(SensorRow::intensity(axis(1.1)), collect);
    let power = scattered.depolarized();
    assert!((row.depolarized() - power).abs() <= TOLERANCE);
    m00.powi(i32::try_from(angles_deg.len()).expect("a few polarizers")) * power
}

#[test]
fn malus() {
    for degrees in [0.0_f64, 10.0, 30.0, 45.0, 77.0, 90.0, 120.0] {
        let expected = 0.5 * degrees.to_radians().cos().powi(2);
        assert!((power_behind_polarizers(&[0.0, degrees]) - expected).abs() <= TOLERANCE);
    }
}

#[test]
fn polarizers_between_crossed_polarizers_let_light_through() {
    assert!(power_behind_polarizers(&[0.0, 90.0]) <= TOLERANCE);
    assert!((power_behind_polarizers(&[0.0, 45.0, 90.0]) - 0.125).abs() <= TOLERANCE);
    let expected = 0.5 * (PI / 8.0).cos().powi(8);
    let five = power_behind_polarizers(&[0.0, 22.5, 45.0, 67.5, 90.0]);
    assert!((five - expected).abs() <= TOLERANCE);
}

#[test]
fn partial_polarizers_are_physical() {
    for (t_max, t_min) in [(1.0, 0.0), (0.9, 0.1), (0.5, 0.5), (0.7, 1e-6)] {
        let (m00, Block { a, c, s }) = polarizer_block(t_max, t_min);
        assert!((m00 * (1.0 + a) - t_max).abs() <= TOLERANCE);
        assert!((m00 * (1.0 - a) - t_min).abs() <= TOLERANCE);
        assert!((a * a + c * c - 1.0).abs() <= TOLERANCE && s == 0.0);
    }
    assert_eq!(polarizer_block(0.0, 0.0), (0.0, Block::identity()));
}

/// Light linear at 45 degrees, `S2 = 1`: the slow y axis then lags by a quarter wave, so that
/// `Ey` follows `Ex` and the field turns from x to y, counterclockwise for the receiver.
#[test]
fn quarter_and_half_wave_plates() {
    let light = LightCarrier { stokes: Stokes([1.0, 0.0, 1.0, 0.0]), x: axis(0.0) };
    let quarter = element(retarder_block(90.0), 0.0);
    assert_stokes(scatter(light, &quarter).stokes, [1.0, 0.0, 0.0, -1.0], TOLERANCE);
    let half = scatter(scatter(light, &quarter), &quarter);
    assert_stokes(half.stokes, [1.0, 0.0, -1.0, 0.0], TOLERANCE);
    let aligned = scatter(light, &element(retarder_block(71.0), PI / 4.0));
    assert_stokes(aligned.stokes, [1.0, 1.0, 0.0, 0.0], TOLERANCE);
}

/// Two total reflections at the tabulated angles make linear light circular.
#[test]
fn fresnel_rhomb() {
    let rhombs = [
        (1.5, [50.229_449_755_525_34, 53.258_229_121_044_415]),
        (1.51, [48.624_359_160_306_675, 54.623_105_441_186_29]),
        (1.6, [42.495_774_236_900_19, 58.733_835_787_996_28]),
    ];
    for (n, angles_deg) in rhombs {
        for degrees in angles_deg {
            let interface = dielectric(f64::to_radians(degrees).cos(), 1.0 / n);
            let once = interface.reflection.scatter(Stokes([1.0, 0.0, 1.0, 0.0]));
            assert_stokes(interface.reflection.scatter(once), [1.0, 0.0, 0.0, 1.0], 1e-12);
        }
    }
}

/// Unpolarized light, two metal mirrors, the second turned by psi: circular light, in the second
/// mirror's frame.
#[test]
fn two_mirrors_make_circular_light() {
    let cases = [
        (
            [0.963, 6.7],
            [45.0, 45.0, 45.0],
            [0.8412418683879458, 0.024349138047334986, 0.023828827775694637, -0.004956893407989861],
        ),
        (
            [0.963, 6.7],
            [60.0, 60.0, 45.0],
            [0.8221531071103777, 0.048290852530239924, 0.04383666053869754, -0.02005761978732479],
        ),
        (
            [0.963, 6.7],
            [70.0, 30.0, 30.0],
            [0.8197743564663055, 0.047679126248390005, 0.06529243587396186, -0.005508670637236029],
        ),
        (
            [0.166, 3.15],
            [45.0, 45.0, 45.0],
            [0.8823823678966974, 0.01846376454812036, 0.016777178423971747, -0.007699845270708424],
        ),
        (
            [0.166, 3.15],
            [60.0, 60.0, 45.0],
            [0.8769153717789002, 0.03252832890546947, 0.021221724127723277, -0.02462264620424729],
        ),
        (
            [0.166, 3.15],
            [70.0, 30.0, 30.0],
            [0.8810808310834777, 0.02879145574723113, 0.035241310110459875, -0.0064151822391238],
        ),
    ];
    for ([n, k], [theta1_deg, theta2_deg, psi_deg], expected) in cases {
        let mirror = |degrees: f64| conductor(degrees.to_radians().cos(), n, k);
        let ((m00_1, first), (m00_2, second)) = (mirror(theta1_deg), mirror(theta2_deg));
        let psi = f64::to_radians(psi_deg);
        let rotation = Rotation { cos2: (2.0 * psi).cos(), sin2: (2.0 * psi).sin() };
        let between = rotation.apply(first.scatter(Stokes::unpolarized()));
        let found = second.scatter(between).scaled(m00_1 * m00_2);
        assert_stokes(found, expected, 1e-13);
    }
}

#[test]
fn brewster_reflection_is_fully_polarized_across_the_plane_of_incidence() {
    for eta in [1.33, 1.5, 2.4, 1.0 / 1.5] {
        let reflection = dielectric(f64::atan(eta).cos(), eta).reflection;
        let Stokes([s0, s1, s2, s3]) = reflection.scatter(Stokes::unpolarized());
        assert!((s1 / s0 - 1.0).abs() <= TOLERANCE && s2 == 0.0 && s3 == 0.0);
    }
}

/// Light that retraces its path through an interface meets the same kernel.
#[test]
fn refraction_is_reciprocal() {
    for eta in [1.2, 1.5, 3.0] {
        for cos_i in [0.05, 0.3, 0.7, 0.95] {
            let there = dielectric(cos_i, eta);
            let back = dielectric(there.cos_t, 1.0 / eta);
            assert!((back.cos_t - cos_i).abs() <= 1e-13);
            assert!((back.transmittance - there.transmittance).abs() <= 1e-13);
            assert!((back.transmission.a - there.transmission.a).abs() <= 1e-13);
            assert!((back.transmission.c - there.transmission.c).abs() <= 1e-13);
        }
    }
}

/// A conductor that does not conduct is a dielectric, total reflection included.
#[test]
fn conductors_without_absorption_are_dielectrics() {
    for eta in [0.6, 1.5] {
        for cos_i in [0.01, 0.3, 0.5, 0.9, 1.0] {
            let (m00, block) = conductor(cos_i, eta, 0.0);
            let interface = dielectric(cos_i, eta);
            assert!((m00 - interface.reflectance).abs() <= TOLERANCE);
            assert!((block.a - interface.reflection.a).abs() <= TOLERANCE);
            assert!((block.c - interface.reflection.c).abs() <= TOLERANCE);
            assert!((block.s - interface.reflection.s).abs() <= TOLERANCE);
        }
    }
}

#[test]
fn rotations_turn_the_frame_about_the_direction_of_travel() {
    let k = vector(0.0, 0.0, 1.0);
    let light = Stokes([1.0, 1.0, 0.0, 0.5]);
    let turned = Rotation::between(axis(0.0), axis(PI / 8.0), k);
    let expected = [1.0, FRAC_1_SQRT_2, -FRAC_1_SQRT_2, 0.5];
    assert_stokes(turned.apply(light), expected, TOLERANCE);
    assert_stokes(turned.inverse().apply(turned.apply(light)), light.0, TOLERANCE);
    // The axis is a line: its sign and length do not matter, nor does a component along k.
    let same = Rotation::between(axis(0.0), axis(PI / 8.0 + PI) * 3.0 + k, k);
    assert!((same.cos2 - turned.cos2).abs() <= TOLERANCE);
    assert!((same.sin2 - turned.sin2).abs() <= TOLERANCE);
    let missing = Rotation::between(axis(0.0), vector(0.0, 0.0, 0.0), k);
    assert_eq!(missing, Rotation::identity());
}

/// Numbers from -1 to 1 that are the same in every run and exact in single precision.
struct Random(u64);

impl Random {
    fn number(&mut self) -> f64 {
        let (factor, addend) = (6_364_136_223_846_793_005, 1_442_695_040_888_963_407);
        self.0 = self.0.wrapping_mul(factor).wrapping_add(addend);
        (self.0 >> 40) as f64 / f64::from(1 << 23) - 1.0
    }

    fn numbers<const N: usize>(&mut self) -> [f64; N] {
        std::array::from_fn(|_| self.number())
    }

    /// Uniform enough over directions; rounded to single precision.
    fn direction(&mut self) -> Vector<f64> {
        let [x, y, z] = self.numbers();
        let unit = vector(x, y, z + 1e-3).normalize();
        let round = |value: f64| f64::from(value as f32);
        vector(round(unit.x), round(unit.y), round(unit.z))
    }
}

fn splat(value: f64) -> F32s {
    F32s::splat(value as f32)
}

fn splat_vector(value: Vector<f64>) -> Vector<F32s> {
    Vector::new(splat(value.x), splat(value.y), splat(value.z))
}

fn first_lane(value: F32s) -> f64 {
    let lanes = value.to_array();
    assert!(lanes.iter().all(|lane| *lane == lanes[0]) && lanes.len() == LANES);
    f64::from(lanes[0])
}

#[test]
fn axes_are_perpendicular_and_never_missing() {
    let mut random = Random(3);
    let check = |direction: Vector<f64>, other: Vector<f64>| {
        let tilted = other - direction * other.dot(direction);
        for found in [
            s_axis(other, direction),
            film_axis(direction, other),
            transmission_axis(tilted, other, direction),
        ] {
            assert!((found.length() - 1.0).abs() <= 1e-6, "{found:?}");
            assert!(found.dot(direction).abs() <= 1e-6);
        }
        let (lanes, other_lanes) = (splat_vector(direction), splat_vector(other));
        for found in [s_axis(other_lanes, lanes), film_axis(lanes, other_lanes)] {
            assert!((first_lane(found.length()) - 1.0).abs() <= 1e-6, "{found:?}");
            assert!(first_lane(found.dot(lanes)).abs() <= 1e-3);
        }
    };
    for _ in 0..2_000 {
        let (k, tilt) = (random.direction(), random.direction());
        check(k, random.direction());
        check(k, k);
        check(k, -k);
        for size in [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7] {
            check(k, (k + tilt * size).normalize());
        }
    }
    check(vector(0.0, 0.0, 1.0), vector(0.0, 0.0, 1.0));
    check(vector(0.0, 0.0, -1.0), vector(0.0, 0.0, 1.0));
}

/// Korger et al. 2013: at normal incidence the axis itself; tilted about it, the axis still; tilted
/// otherwise, the perpendicular of the absorbing axis, which is not the axis projected.
#[test]
fn polarizers_seen_at_an_angle() {
    let (normal, transmitting) = (vector(0.0, 0.0, 1.0), axis(0.4));
    let absorbing = normal.cross(transmitting);
    let straight = transmission_axis(transmitting, normal, normal);
    assert!((straight.dot(transmitting).abs() - 1.0).abs() <= TOLERANCE);
    let about = (normal + absorbing * 0.8).normalize();
    let found = transmission_axis(transmitting, normal, about);
    assert!((found.dot(transmitting).abs() - 1.0).abs() <= TOLERANCE);
    let k = vector(0.5, 0.2, 0.7).normalize();
    let found = transmission_axis(transmitting, normal, k);
    assert!(found.dot(absorbing).abs() <= TOLERANCE && found.dot(k).abs() <= TOLERANCE);
}

fn dense_of(block: Block<f64>) -> Dense<f64> {
    let Block { a, c, s } = block;
    Dense([[1.0, a, 0.0, 0.0], [a, 1.0, 0.0, 0.0], [0.0, 0.0, c, s], [0.0, 0.0, -s, c]])
}

fn inner(row: [f64; 4], stokes: Stokes<f64>) -> f64 {
    row.iter().zip(stokes.0).map(|(a, b)| a * b).sum()
}

/// `r (M S) = (r M) S` for every kind of kernel, and the sparse kinds are what they stand for.
#[test]
fn both_sides_of_every_kernel_agree() {
    fn adjoint<K: Kernel<f64>>(kernel: K, row: [f64; 4], stokes: Stokes<f64>) {
        let light = inner(row, kernel.scatter(stokes));
        let sensor = inner(kernel.collect_row(row), stokes);
        assert!((light - sensor).abs() <= TOLERANCE);
        assert_eq!(kernel.first_stokes(), kernel.scatter(Stokes::unpolarized()));
        assert_eq!(kernel.first_row(), kernel.collect_row(Stokes::unpolarized().0));
    }
    let mut random = Random(4);
    for _ in 0..1_000 {
        let (row, stokes) = (random.numbers(), Stokes(random.numbers()));
        let [a, b, c, d, s] = random.numbers();
        let block = Block { a, c, s };
        let wide = SpheroidBlock { a, b: 1.0, c, d: c, s };
        adjoint(block, row, stokes);
        adjoint(SpheroidBlock { a, b, c, d, s }, row, stokes);
        adjoint(Dense(std::array::from_fn(|_| random.numbers())), row, stokes);
        assert_stokes(dense_of(block).scatter(stokes), block.scatter(stokes).0, TOLERANCE);
        assert_stokes(wide.scatter(stokes), block.scatter(stokes).0, TOLERANCE);
        let matrix = std::array::from_fn(|_| random.numbers());
        let rotation = Rotation::between(axis(a), axis(b), vector(0.0, 0.0, 1.0));
        let expected = matrix.map(|row| block.collect_row(rotation.collect_row(row)));
        assert_eq!(block.collect_columns(rotation.collect_matrix(matrix)), expected);
        let light = inner(row, rotation.apply(stokes));
        assert!((light - inner(rotation.collect_row(row), stokes)).abs() <= TOLERANCE);
    }
}

/// The same inputs in `f64` and in eight `f32` lanes.
#[test]
fn lanes_agree_with_doubles_on_random_events() {
    let mut random = Random(5);
    let mut worst = 0.0_f64;
    for _ in 0..20_000 {
        let [a, c, s] = random.numbers();
        let (k, normal, up) = (random.direction(), random.direction(), random.direction());
        if normal.cross(k).length() < 0.1 || up.cross(k).length() < 0.1 {
            continue;
        }
        let stokes = Stokes(random.numbers());
        let expected = one_event(Block { a, c, s }, stokes, [k, normal, up]);
        let block = Block { a: splat(a), c: splat(c), s: splat(s) };
        let found =
            one_event(block, Stokes(stokes.0.map(splat)), [k, normal, up].map(splat_vector));
        for (a, b) in found.iter().zip(expected) {
            worst = worst.max((first_lane(*a) - b).abs());
        }
    }
    println!("random events: lanes differ from doubles by at most {worst:e}");
    assert!(worst <= 1e-5);
}

/// The light's Stokes vector behind an event and the sensor's row before it.
fn one_event<F: Real>(kernel: Block<F>, stokes: Stokes<F>, [k, n, up]: [Vector<F>; 3]) -> [F; 8] {
    let x = s_axis(n, k);
    let event = Vertex { kernel, x, k_in: k, k_out: k };
    let x = film_axis(k, up);
    let Stokes(light) = scatter(LightCarrier { stokes, x }, &event).stokes;
    let sensor = collect(SensorRow { row: stokes.0, x }, &event).row;
    std::array::from_fn(|i| if i < 4 { light[i] } else { sensor[i - 4] })
}
