//! Suspensions: spheres of many sizes and substances in a host, which scatter independently.
//!
//! Size distributions become sums over nodes (radius and share of the volume); the phase matrix
//! is the sum of the spheres' differential cross-sections over that of their cross-sections
//! (Hansen and Travis 1974, section 2.5). Radii are in micrometers, wavelengths in nanometers of
//! vacuum, coefficients in 1/m.

use std::f64::consts::PI;
use std::fmt;

use rayon::prelude::*;
use wide::f64x4;

use super::mie::{MieSphere, PhaseElements};
use crate::math::elementary::{cos, exp, ln, ln_1p};
use crate::math::{Fault, Range};

/// Fewest nodes of a distribution.
const NODES_MIN: usize = 768;
/// Most of them, for the time that they take: distributions this wide even out what is between.
const NODES_MAX: usize = 1024;
/// Nodes per factor e of the radius, and beside these per size parameter: what spheres scatter
/// goes up and down with their size parameter, as light that went through them interferes with
/// light that passed by, and resonates in them.
///
/// Of log-normal sizes in hosts of nearly their own index, as in milk (a ratio of 1.1), up to a
/// size parameter of 190, all elements of the matrix are within 1e-3 of M00 at every angle, and
/// the coefficients within 1e-5, of what eight times as many nodes find. Droplets of water in air
/// resonate sharply: there it is 2e-2, backwards most, and 5e-3.
const NODES_PER_FACTOR: f64 = 60.0;
const NODES_PER_SIZE: f64 = 2.5;
/// Nodes are left out whose share of the volume, and share times the cube of their radius over the
/// mean, which goes as the light they scatter forwards, are less than this.
const NEGLIGIBLE: f64 = 1e-7;
/// Smallest size parameter that the series is good for.
const SIZE_PARAMETER_MIN: f64 = 1e-6;
/// Radii that distributions are given with.
const RADIUS_UM: Range =
    Range::new("within [0.0001, 1000] micrometers", |x| (1e-4..=1e3).contains(&x));
/// Angles that are summed side by side.
const LANES: usize = 4;

/// What a density of sizes counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Amount {
    /// Particles per interval of radius.
    Number,
    /// Volume of particles per interval of radius.
    Volume,
}

/// How the volume of particles is shared among their radii.
#[derive(Clone, PartialEq)]
pub struct Sizes {
    law: Law,
    of: Amount,
    /// Least and greatest radius in micrometers.
    range_um: [f64; 2],
}

/// Densities of radii in micrometers, not normalized.
#[derive(Clone, PartialEq)]
pub(super) enum Law {
    /// All have the least of the range.
    Alone,
    /// Mean and standard deviation of the logarithm.
    LogNormal([f64; 2]),
    /// The log-normal density of `r / (limit - r)`.
    LogNormalBelow { limit_um: f64, parameters: [f64; 2] },
    /// Exponent of the radius over the mean, and what the radius is divided by in the exponential.
    Gamma { mean_um: f64, power: f64, scale_um: f64 },
    /// Linear between radii.
    Table { radii_um: Vec<f64>, density: Vec<f64> },
}

impl Law {
    fn density(&self, radius: f64) -> f64 {
        match self {
            Self::Alone => 1.0,
            &Self::LogNormal(parameters) => log_normal(radius, parameters),
            &Self::LogNormalBelow { limit_um, parameters } => {
                log_normal(radius / (limit_um - radius), parameters)
            }
            // Relative to the mean, where the exponent is about zero.
            &Self::Gamma { mean_um, power, scale_um } => {
                exp((power - 1.0) * ln(radius / mean_um) - (radius - mean_um) / scale_um)
            }
            Self::Table { radii_um, density } => linear(radii_um, density, radius),
        }
    }
}

/// A value that is linear between those at some places, two at least.
fn linear(places: &[f64], values: &[f64], at: f64) -> f64 {
    let upper = places.partition_point(|&place| place < at).clamp(1, places.len() - 1);
    let width = places[upper] - places[upper - 1];
    let share = ((at - places[upper - 1]) / width).clamp(0.0, 1.0);
    values[upper - 1] * (1.0 - share) + values[upper] * share
}

/// A radius in micrometers, and the share of the volume that it stands for.
type Node = (f64, f64);

impl fmt::Debug for Sizes {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let [low, high] = self.range_um;
        write!(f, "Sizes from {low} to {high} um, mean radius {} um", self.mean_radius_um())
    }
}

impl Sizes {
    /// Spheres of one radius, within [0.0001, 1000] micrometers as all radii.
    ///
    /// # Errors
    /// When the radius is not.
    pub fn monodisperse(radius_um: f64) -> Result<Self, Fault> {
        RADIUS_UM.check("radius_um", radius_um)?;
        Ok(Self::alone(radius_um))
    }

    /// Spheres of one radius, greater than zero.
    pub(super) fn alone(radius_um: f64) -> Self {
        Self { law: Law::Alone, of: Amount::Volume, range_um: [radius_um; 2] }
    }

    /// A log-normal density of the radius with this mean and standard deviation, not less than a
    /// thousandth of the mean. Without a range (least and greatest radius) it extends as far as it
    /// matters.
    ///
    /// # Errors
    /// When a number is not as described, or the density is zero throughout the range.
    pub fn log_normal(
        mean_um: f64,
        sd_um: f64,
        of: Amount,
        range_um: Option<[f64; 2]>,
    ) -> Result<Self, Fault> {
        check_density(mean_um, sd_um, range_um)?;
        // Light that is scattered forwards goes as the square of the volume.
        const REACH: f64 = 5.0;
        let [alpha, beta] = log_normal_parameters(mean_um, sd_um);
        let shift = if of == Amount::Number { 6.0 } else { 3.0 };
        let range = range_um.unwrap_or_else(|| {
            let high = alpha + shift * beta * beta + REACH * beta;
            [exp(alpha - REACH * beta), exp(high)]
        });
        Self::new(Law::LogNormal([alpha, beta]), of, range)
    }

    /// A gamma density of the radius, `r^(p-1) exp(-r/q)`, with this mean `p q` and standard
    /// deviation `q sqrt(p)`, not less than a thousandth of the mean. Without a range (least and
    /// greatest radius) it extends as far as it matters.
    ///
    /// # Errors
    /// When a number is not as described, or the density is zero throughout the range.
    pub fn gamma(
        mean_um: f64,
        sd_um: f64,
        of: Amount,
        range_um: Option<[f64; 2]>,
    ) -> Result<Self, Fault> {
        check_density(mean_um, sd_um, range_um)?;
        const REACH: f64 = 7.0;
        let (power, scale) = ((mean_um / sd_um).powi(2), sd_um * sd_um / mean_um);
        let shift = if of == Amount::Number { 6.0 } else { 3.0 };
        let range = range_um.unwrap_or_else(|| {
            let low = power - REACH * power.sqrt();
            let far = power + shift;
            [(low * scale).max(1e-3 * mean_um), (far + REACH * far.sqrt() + 15.0) * scale]
        });
        Self::new(Law::Gamma { mean_um, power, scale_um: scale }, of, range)
    }

    /// A density, not negative, that is linear between radii, at least two and increasing.
    ///
    /// # Errors
    /// When there are not as many radii as values, they are not as described, or all is zero.
    pub fn table(radii_um: &[f64], density: &[f64], of: Amount) -> Result<Self, Fault> {
        if radii_um.len() < 2 || radii_um.len() != density.len() {
            return Err(unfit("needs as many radii as values, and at least two"));
        }
        if !radii_um.is_sorted_by(|a, b| a < b) {
            return Err(unfit("needs radii in increasing order, each once"));
        }
        radii_um.iter().try_for_each(|radius| RADIUS_UM.check("radii_um", *radius))?;
        density.iter().try_for_each(|value| Range::NOT_NEGATIVE.check("density", *value))?;
        let last = radii_um[radii_um.len() - 1];
        let range = [radii_um[0].max(1e-4 * last), last];
        let law = Law::Table { radii_um: radii_um.to_vec(), density: density.to_vec() };
        Self::new(law, of, range)
    }

    /// Any density over a range of radii greater than zero.
    pub(super) fn new(law: Law, of: Amount, range_um: [f64; 2]) -> Result<Self, Fault> {
        let sizes = Self { law, of, range_um };
        let total: f64 = sizes.spread(0.0).iter().map(|(_, share)| share).sum();
        if !(total > 0.0 && total.is_finite()) {
            return Err(unfit("has no particles in its range"));
        }
        Ok(sizes)
    }

    /// Nodes that resolve what spheres do to light of a wave number (in the host, per micrometer);
    /// the shares add up to one.
    fn nodes(&self, wave_number: f64) -> Vec<Node> {
        let mut nodes = self.spread(wave_number);
        let total: f64 = nodes.iter().map(|(_, share)| share).sum();
        nodes.iter_mut().for_each(|(_, share)| *share /= total);
        let mean: f64 = nodes.iter().map(|(radius, share)| radius * share).sum();
        nodes.retain(|&(radius, share)| share * (radius / mean).powi(3).max(1.0) > NEGLIGIBLE);
        nodes
    }

    /// The same before shares are normalized: midpoints of intervals that are equally long in
    /// [`Places`].
    fn spread(&self, wave_number: f64) -> Vec<Node> {
        let [low, high] = self.range_um;
        if self.law == Law::Alone {
            return vec![(low, 1.0)];
        }
        let places = Places { per_factor: NODES_PER_FACTOR, per_um: NODES_PER_SIZE * wave_number };
        let (first, last) = (places.of(low), places.of(high));
        let count = ((last - first).ceil() as usize).clamp(NODES_MIN, NODES_MAX);
        let step = (last - first) / count as f64;
        let mut radius = low;
        let node = |index: usize| {
            radius = places.radius(first + step * (index as f64 + 0.5), radius);
            let volume = if self.of == Amount::Number { radius.powi(3) } else { 1.0 };
            // Up to a constant, the width of the node.
            let width = 1.0 / places.slope(radius);
            (radius, self.law.density(radius) * volume * width)
        };
        (0..count).map(node).collect()
    }

    /// All that they are made of, in an order of its own: other sizes have other numbers.
    pub(super) fn numbers(&self) -> Vec<f64> {
        let Self { law, of, range_um: [low, high] } = self;
        let of = match of {
            Amount::Number => 0.0,
            Amount::Volume => 1.0,
        };
        let mut numbers = vec![of, *low, *high];
        match law {
            Law::Alone => numbers.push(0.0),
            Law::LogNormal([alpha, beta]) => numbers.extend([1.0, *alpha, *beta]),
            Law::LogNormalBelow { limit_um, parameters: [alpha, beta] } => {
                numbers.extend([2.0, *limit_um, *alpha, *beta]);
            }
            Law::Gamma { mean_um, power, scale_um } => {
                numbers.extend([3.0, *mean_um, *power, *scale_um]);
            }
            Law::Table { radii_um, density } => {
                numbers.push(4.0);
                numbers.extend(radii_um.iter().chain(density));
            }
        }
        numbers
    }

    /// Mean radius by volume, in micrometers.
    pub fn mean_radius_um(&self) -> f64 {
        self.nodes(0.0).iter().map(|(radius, share)| radius * share).sum()
    }

    /// The greatest radius, in micrometers.
    pub fn radius_max_um(&self) -> f64 {
        let nodes = self.spread(0.0).into_iter().filter(|(_, share)| *share > 0.0);
        nodes.fold(0.0, |greatest, (radius, _)| radius.max(greatest))
    }
}

/// Where radii are on a scale on which nodes are equally spaced: their logarithms, and beside these
/// the radii themselves.
struct Places {
    per_factor: f64,
    per_um: f64,
}

impl Places {
    fn of(&self, radius: f64) -> f64 {
        self.per_factor * ln(radius) + self.per_um * radius
    }

    fn slope(&self, radius: f64) -> f64 {
        self.per_factor / radius + self.per_um
    }

    /// The radius in a place, from one `before`: Newton's method, which comes closer from there
    /// with every step as the scale is concave.
    fn radius(&self, place: f64, before: f64) -> f64 {
        const STEPS: usize = 8;
        (0..STEPS).fold(before, |radius, _| radius + (place - self.of(radius)) / self.slope(radius))
    }
}

/// Refuses mean, standard deviation and range of a density that is no density of radii.
fn check_density(mean_um: f64, sd_um: f64, range_um: Option<[f64; 2]>) -> Result<(), Fault> {
    RADIUS_UM.check("mean_um", mean_um)?;
    RADIUS_UM.check("sd_um", sd_um)?;
    if sd_um < 1e-3 * mean_um {
        let problem = "is less than a thousandth of the mean";
        return Err(Fault::new("sd_um", problem, "use monodisperse"));
    }
    let Some([low, high]) = range_um else { return Ok(()) };
    RADIUS_UM.check("range_um", low)?;
    RADIUS_UM.check("range_um", high)?;
    if low < high {
        return Ok(());
    }
    Err(Fault::new("range_um", "must be two radii in micrometers, the lesser first", ""))
}

fn unfit(problem: &str) -> Fault {
    Fault::new("", problem, "check radii and density")
}

/// Mean and standard deviation of the logarithm from those of the quantity.
pub(super) fn log_normal_parameters(mean: f64, sd: f64) -> [f64; 2] {
    let variance = ln_1p((sd / mean).powi(2));
    [ln(mean) - 0.5 * variance, variance.sqrt()]
}

/// Log-normal density, not normalized.
pub(super) fn log_normal(value: f64, [alpha, beta]: [f64; 2]) -> f64 {
    exp(-0.5 * ((ln(value) - alpha) / beta).powi(2)) / value
}

/// Spheres of one substance.
#[derive(Clone, Copy, Debug)]
pub struct Particles<'a> {
    /// Their sizes.
    pub sizes: &'a Sizes,
    /// Real part of their index of refraction n - i k, greater than zero; not that of the host
    /// if `k` is zero.
    pub n: f64,
    /// Extinction coefficient, not negative.
    pub k: f64,
    /// Share of the volume that they fill, greater than zero.
    pub volume_fraction: f64,
}

/// Particles in a host, seen at one wavelength.
#[derive(Clone, Debug)]
pub struct Suspension<'a> {
    /// What is suspended; not empty.
    pub particles: Vec<Particles<'a>>,
    /// Index of refraction of the host, greater than zero. Its absorption is left to the caller.
    pub host_n: f64,
    /// Wavelength in vacuum, in nanometers.
    pub wavelength_nm: f64,
}

/// What a suspension does to light of one wavelength.
#[derive(Clone, Debug, PartialEq)]
pub struct Scattering {
    /// Scattering coefficient in 1/m.
    pub sigma_s: f64,
    /// Absorption coefficient of the particles in 1/m.
    pub sigma_a: f64,
    /// Mean cosine of the scattering angle.
    pub g: f64,
    /// The phase matrix at equally spaced angles from 0 to pi.
    pub matrix: Vec<PhaseElements>,
}

/// A sphere of the sum.
struct Term {
    /// What its squared amplitudes count.
    weight: f64,
    series: Vec<[f64; 4]>,
}

impl Suspension<'_> {
    /// Wave number in the host, per micrometer.
    fn wave_number(&self) -> f64 {
        2.0 * PI * self.host_n / (1e-3 * self.wavelength_nm)
    }

    /// Size parameter of the greatest particle.
    pub fn size_parameter_max(&self) -> f64 {
        let radii = self.particles.iter().map(|particles| particles.sizes.radius_max_um());
        self.wave_number() * radii.fold(0.0, f64::max)
    }

    /// How much there is to do for [`Suspension::scattering`], at most: additions of an order of a
    /// sphere at an angle and its supplement. A processor does 0.3 to 3 of them in a nanosecond.
    pub(super) fn work(&self, intervals: usize) -> f64 {
        let orders = |particles: &Particles| {
            let Sizes { law, range_um: [_, high], .. } = particles.sizes;
            let spheres = if *law == Law::Alone { 1 } else { NODES_MAX };
            spheres as f64 * (self.wave_number() * high + 10.0)
        };
        self.particles.iter().map(orders).sum::<f64>() * intervals as f64 / 2.0
    }

    /// Coefficients, and the phase matrix at `intervals + 1` angles, computed on the threads of the
    /// caller's rayon pool; their number changes no bit. `intervals` is even.
    pub fn scattering(&self, intervals: usize) -> Scattering {
        let wave_number = self.wave_number();
        let mut found = Scattering { sigma_s: 0.0, sigma_a: 0.0, g: 0.0, matrix: Vec::new() };
        let mut terms = Vec::new();
        for particles in &self.particles {
            let (n, k) = (particles.n / self.host_n, particles.k / self.host_n);
            let expanded = |(radius, share): Node| {
                let size_parameter = (wave_number * radius).max(SIZE_PARAMETER_MIN);
                let sphere = MieSphere::new(n, k, size_parameter);
                ((radius, share), [sphere.q_ext, sphere.q_sca, sphere.g], sphere.series())
            };
            let nodes = particles.sizes.nodes(wave_number);
            let spheres: Vec<_> = nodes.into_par_iter().map(expanded).collect();
            for ((radius, share), [q_ext, q_sca, g], series) in spheres {
                let number = particles.volume_fraction * share / (4.0 / 3.0 * PI * radius.powi(3));
                // From 1/um to 1/m.
                let area = 1e6 * number * PI * radius * radius;
                found.sigma_s += area * q_sca;
                found.sigma_a += area * (q_ext - q_sca).max(0.0);
                found.g += area * q_sca * g;
                let weight = 1e6 * number / (wave_number * wave_number);
                terms.push(Term { weight, series });
            }
        }
        found.g /= found.sigma_s;
        found.matrix = matrix(&terms, intervals);
        for elements in &mut found.matrix {
            for element in
                [&mut elements.m00, &mut elements.m01, &mut elements.m22, &mut elements.m23]
            {
                *element /= found.sigma_s;
            }
        }
        found
    }
}

/// Elements of the matrix at some angles, and at pi minus them.
type Sums = [[f64x4; 4]; 2];

/// Sums of the differential cross-sections (Bohren and Huffman 1983, equation 4.77) at
/// `intervals + 1` equally spaced angles, those beyond a right angle from the symmetry of the
/// angular functions. Whatever thread has an angle, it adds the terms in their order.
fn matrix(terms: &[Term], intervals: usize) -> Vec<PhaseElements> {
    let orders = terms.iter().map(|term| term.series.len()).max().unwrap_or(0);
    let half = intervals / 2;
    let functions = || vec![[f64x4::ZERO; 2]; orders];
    let sums_of = |functions: &mut Vec<_>, group: usize| {
        let first = group * LANES;
        let angle = |lane: usize| PI * (first + lane).min(half) as f64 / intervals as f64;
        let cosines: [f64; LANES] = std::array::from_fn(|lane| cos(angle(lane)));
        angular_functions(functions, cosines.into());
        let mut sums: Sums = [[f64x4::ZERO; 4]; 2];
        for term in terms {
            add_term(&mut sums, term, functions);
        }
        sums
    };
    let groups = (0..1 + half / LANES).into_par_iter();
    let sums: Vec<Sums> = groups.map_init(functions, sums_of).collect();
    let at = |index: usize| {
        // The right angle is a supplement.
        let (side, from_end) = if index < half { (0, index) } else { (1, intervals - index) };
        let [m00, m01, m22, m23] =
            sums[from_end / LANES][side].map(|row| row.to_array()[from_end % LANES]);
        PhaseElements { m00, m01, m22, m23 }
    };
    (0..=intervals).map(at).collect()
}

/// `pi_n + tau_n` and `pi_n - tau_n` at some angles, from n = 1 on (equation 4.47).
fn angular_functions(functions: &mut [[f64x4; 2]], cosines: f64x4) {
    let (mut pi_previous, mut pi) = (f64x4::ZERO, f64x4::ONE);
    for (row, n) in functions.iter_mut().zip(1u32..) {
        let order = f64::from(n);
        let (along, fallen) = (cosines * pi, pi_previous * (order + 1.0));
        let tau = along * order - fallen;
        *row = [pi + tau, pi - tau];
        (pi_previous, pi) = (pi, (along * (2.0 * order + 1.0) - fallen) / order);
    }
}

/// Adds a sphere's m00, m01, m22, m23 at some angles, and at pi minus them.
///
/// With `P = S1 + S2 = sum (a + b)(pi + tau)` and `Q = S1 - S2 = sum (a - b)(pi - tau)`, weights
/// included, `|S1|^2 + |S2|^2 = (|P|^2 + |Q|^2) / 2` and so on. At the supplement of an angle,
/// `pi + tau` and `pi - tau` of even n change their places, and of odd n their signs too.
fn add_term(sums: &mut Sums, term: &Term, functions: &[[f64x4; 2]]) {
    // Real and imaginary parts of P and Q, here and at the supplement.
    let mut amplitudes = [[f64x4::ZERO; 4]; 2];
    let (pairs, last) = term.series.as_chunks::<2>();
    let (functions, function_last) = functions[..term.series.len()].as_chunks::<2>();
    for ([odd, even], [at_odd, at_even]) in pairs.iter().zip(functions) {
        add_order::<true>(&mut amplitudes, odd, at_odd);
        add_order::<false>(&mut amplitudes, even, at_even);
    }
    for (odd, at_odd) in last.iter().zip(function_last) {
        add_order::<true>(&mut amplitudes, odd, at_odd);
    }
    let (quarter, half) = (0.25 * term.weight, 0.5 * term.weight);
    for (sums, [p_re, p_im, q_re, q_im]) in sums.iter_mut().zip(amplitudes) {
        let (p, q) = (p_re * p_re + p_im * p_im, q_re * q_re + q_im * q_im);
        sums[0] += (p + q) * quarter;
        sums[1] += (p_re * q_re + p_im * q_im) * half;
        sums[2] += (p - q) * quarter;
        sums[3] += (p_im * q_re - p_re * q_im) * half;
    }
}

/// Adds an order to P and Q, the supplement's with the sign of its parity.
#[inline(always)]
fn add_order<const ODD: bool>(
    [here, there]: &mut [[f64x4; 4]; 2],
    order: &[f64; 4],
    [plus, minus]: &[f64x4; 2],
) {
    let [p_re, p_im, q_re, q_im] = order.map(f64x4::splat);
    let add = |sum: &mut f64x4, part: f64x4, function: f64x4| *sum = part.mul_add(function, *sum);
    let add_with_sign = |sum: &mut f64x4, part: f64x4, function: f64x4| match ODD {
        true => *sum = part.mul_add(function, *sum),
        false => *sum = part.mul_neg_add(function, *sum),
    };
    add(&mut here[0], p_re, *plus);
    add(&mut here[1], p_im, *plus);
    add(&mut here[2], q_re, *minus);
    add(&mut here[3], q_im, *minus);
    add_with_sign(&mut there[0], p_re, *minus);
    add_with_sign(&mut there[1], p_im, *minus);
    add_with_sign(&mut there[2], q_re, *plus);
    add_with_sign(&mut there[3], q_im, *plus);
}
