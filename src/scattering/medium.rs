//! Participating media as the stages read them: coefficients and phase functions, eight rows of
//! one medium at a time.
//!
//! Scattering angles come as `half_sine2 = sin^2(theta / 2)`, which two unit vectors give without
//! cancellation however close to forward they are: a quarter of the square of their difference.

use std::f32::consts::PI;

use crate::math::{F32s, LANES, Real, Vector, lanes, warp};
use crate::polarization::kernel::SpheroidBlock;
use crate::scene::baked::{self, PhaseTable};

/// A homogeneous medium with what is derived from its coefficients.
#[derive(Clone, Debug)]
pub struct Medium<const N: usize> {
    /// Extinction coefficient per scene unit.
    pub sigma_t: [f32; N],
    /// Scattering coefficient per scene unit.
    pub sigma_s: [f32; N],
    /// Mean extinction coefficient over the wavelengths: what takes the place of a surface's
    /// cosine where strategies are weighed against each other.
    pub density: f32,
    /// The probability with which roulette lets a path go on.
    pub survival: f32,
    /// How it scatters.
    pub phase: PhaseFunction<N>,
}

/// A phase function, ready for look-ups.
#[derive(Clone, Debug)]
pub enum PhaseFunction<const N: usize> {
    /// Henyey and Greenstein, a depolarizer.
    HenyeyGreenstein([f32; N]),
    /// Tabulated, polarizing.
    Table(PhaseLookup<N>),
}

/// A tabulated phase matrix.
#[derive(Clone, Debug)]
pub struct PhaseLookup<const N: usize> {
    /// What sampling reads, by node.
    nodes: Vec<Node<N>>,
    /// By node: `half_sine2`, the reciprocal of its step to the next node, M00 at every
    /// wavelength, and the steps of those.
    values: Packets,
    /// By node: a, c, s, and for spheroids b, d, at every wavelength (one if achromatic), and the
    /// steps of those to the next node.
    elements: Packets,
    /// For every wavelength and equal share of the random numbers, the node to start from.
    guide: [Vec<u32>; N],
    /// Whether b = 1 and d = c.
    pub spheres: bool,
    /// Whether the elements are the same at all wavelengths.
    pub achromatic: bool,
}

#[derive(Clone, Copy, Debug)]
struct Node<const N: usize> {
    half_sine2: f32,
    m00: [f32; N],
    cdf: [f32; N],
}

/// Rows of numbers in packets of eight, so that eight rows are read by loads and transpositions.
#[derive(Clone, Debug)]
struct Packets {
    /// Packets of a row.
    stride: usize,
    rows: Vec<[f32; LANES]>,
}

impl Packets {
    fn new(rows: impl Iterator<Item = Vec<f32>>) -> Self {
        let mut packets = Self { stride: 0, rows: Vec::new() };
        for row in rows {
            packets.stride = row.len().div_ceil(LANES);
            for part in row.chunks(LANES) {
                let mut packet = [0.0; LANES];
                packet[..part.len()].copy_from_slice(part);
                packets.rows.push(packet);
            }
        }
        packets
    }

    /// The numbers from `LANES * packet` on of eight rows.
    #[inline(always)]
    fn gather(&self, rows: &[usize; LANES], packet: usize) -> [F32s; LANES] {
        let mut lanes = [F32s::splat(0.0); LANES];
        for (lane, &row) in lanes.iter_mut().zip(rows) {
            *lane = F32s::from(self.rows[row * self.stride + packet]);
        }
        F32s::transpose(lanes)
    }
}

/// Packets that rows have at most: with five elements and their steps at eight wavelengths.
const PACKETS_MAX: usize = 10;

/// The numbers of eight rows. Which packets there are is known when this is compiled, so that
/// those that are not read cost nothing.
struct Fields([[F32s; LANES]; PACKETS_MAX]);

impl Fields {
    #[inline(always)]
    fn gather(packets: &Packets, rows: &[usize; LANES], count: usize) -> Self {
        let mut fields = [[F32s::splat(0.0); LANES]; PACKETS_MAX];
        for (packet, fields) in fields.iter_mut().enumerate().take(count.div_ceil(LANES)) {
            *fields = packets.gather(rows, packet);
        }
        Self(fields)
    }

    #[inline(always)]
    fn at(&self, field: usize) -> F32s {
        self.0[field / LANES][field % LANES]
    }
}

impl<const N: usize> Medium<N> {
    /// Derives the row of a baked medium.
    pub fn new(medium: &baked::Medium<N>) -> Self {
        let mut sigma_t = medium.sigma_a;
        let mut albedo = 0.0_f32;
        for (sigma_t, &sigma_s) in sigma_t.iter_mut().zip(&medium.sigma_s) {
            *sigma_t += sigma_s;
            albedo = albedo.max(if sigma_s > 0.0 { sigma_s / *sigma_t } else { 0.0 });
        }
        Self {
            sigma_t,
            sigma_s: medium.sigma_s,
            density: sigma_t.iter().sum::<f32>() / N as f32,
            survival: albedo.clamp(0.05, 1.0),
            phase: match &medium.phase {
                baked::Phase::HenyeyGreenstein { g } => PhaseFunction::HenyeyGreenstein(*g),
                baked::Phase::Table(table) => PhaseFunction::Table(PhaseLookup::new(table)),
            },
        }
    }

    /// A medium that is not there.
    pub fn clear() -> Self {
        let phase = PhaseFunction::HenyeyGreenstein([0.0; N]);
        Self { sigma_t: [0.0; N], sigma_s: [0.0; N], density: 0.0, survival: 1.0, phase }
    }
}

/// `sin^2(theta / 2)` of the angle between two unit vectors.
#[inline(always)]
pub fn half_sine2<F: Real>(from: Vector<F>, to: Vector<F>) -> F {
    let quarter = (to - from).length_squared() * F::splat(0.25);
    F::select(quarter.gt(F::one()), F::one(), quarter)
}

/// A unit vector at the angle `half_sine2` to the unit vector `axis`, turned by `turns` about it.
#[inline(always)]
pub fn deflect(axis: Vector<F32s>, half_sine2: F32s, turns: F32s) -> Vector<F32s> {
    let one = F32s::splat(1.0);
    let cosine = one - half_sine2 - half_sine2;
    let sine = F32s::splat(2.0) * (half_sine2 * (one - half_sine2)).max(F32s::splat(0.0)).sqrt();
    let (y, x) = warp::sin_cos_turns(turns);
    let tangent = axis.any_perpendicular();
    let bitangent = axis.cross(tangent);
    tangent.mul_add(x * sine, bitangent.mul_add(y * sine, axis * cosine)).normalize()
}

impl<const N: usize> PhaseFunction<N> {
    /// The phase function at every wavelength, in 1/sr: also the density of [`Self::sample`].
    #[inline(always)]
    pub fn values(&self, half_sine2: F32s) -> [F32s; N] {
        match self {
            Self::HenyeyGreenstein(g) => {
                let mut values = [F32s::splat(0.0); N];
                for (value, &g) in values.iter_mut().zip(g) {
                    let back = F32s::splat((1.0 - g) * (1.0 - g));
                    let base = half_sine2.mul_add(F32s::splat(4.0 * g), back);
                    *value = F32s::splat((1.0 - g * g) * (0.25 / PI)) / (base * base.sqrt());
                }
                values
            }
            Self::Table(table) => table.values(half_sine2),
        }
    }

    /// An angle distributed by the phase function of each lane's wavelength.
    #[inline(always)]
    pub fn sample(&self, wavelength: [u32; LANES], u: F32s) -> F32s {
        match self {
            Self::HenyeyGreenstein(g) => {
                let g = F32s::from(lanes::each(|lane| g[wavelength[lane] as usize]));
                let one = F32s::splat(1.0);
                let (less, more) = (one - g, one + g);
                let inverse = one / (g * u).mul_add(F32s::splat(2.0), less);
                let half = less * (one - u) * inverse * F32s::splat(0.5);
                half * (less * more).mul_add(inverse, less)
            }
            Self::Table(table) => {
                let u = u.to_array();
                F32s::from(lanes::each(|lane| table.sample(wavelength[lane] as usize, u[lane])))
            }
        }
    }
}

impl<const N: usize> PhaseLookup<N> {
    fn new(table: &PhaseTable<N>) -> Self {
        let count = table.half_sine2.len();
        let node = |index: usize| Node {
            half_sine2: table.half_sine2[index],
            m00: table.m00[index],
            cdf: table.cdf[index],
        };
        let nodes: Vec<Node<N>> = (0..count).map(node).collect();
        let guide = std::array::from_fn(|n| guide(&nodes, n));
        let values = Packets::new(nodes.windows(2).map(|pair| {
            let inverse = 1.0 / (pair[1].half_sine2 - pair[0].half_sine2);
            let steps = pair[0].m00.iter().zip(&pair[1].m00).map(|(from, to)| to - from);
            [pair[0].half_sine2, inverse].into_iter().chain(pair[0].m00).chain(steps).collect()
        }));
        let PhaseTable { spheres, achromatic, .. } = *table;
        let stored: &[usize] = if spheres { &[0, 2, 4] } else { &[0, 2, 4, 1, 3] };
        let wavelengths = if achromatic { 1 } else { N };
        let flat = |row: &[[f32; N]; 5]| -> Vec<f32> {
            stored.iter().flat_map(|&element| row[element][..wavelengths].to_vec()).collect()
        };
        let elements = Packets::new(table.elements.windows(2).map(|pair| {
            let (from, to) = (flat(&pair[0]), flat(&pair[1]));
            let steps = from.iter().zip(&to).map(|(from, to)| to - from);
            from.iter().copied().chain(steps).collect()
        }));
        Self { nodes, values, elements, guide, spheres, achromatic }
    }

    /// Nodes before eight angles, and how far the angles are beyond, of the way to the next.
    #[inline(always)]
    fn locate(&self, half_sine2: F32s) -> ([usize; LANES], F32s) {
        let last = (self.nodes.len() - 2) as f32;
        let place = warp::angle_of_half_sine2(half_sine2) * F32s::splat(last + 1.0);
        let node = place.floor().max(F32s::splat(0.0)).min(F32s::splat(last));
        let index = node.to_array();
        (lanes::each(|lane| index[lane] as usize), place - node)
    }

    /// [`PhaseFunction::values`] and [`Self::kernels`] by one look.
    #[inline(always)]
    pub fn values_and_kernels(&self, half_sine2: F32s) -> ([F32s; N], [SpheroidBlock<F32s>; N]) {
        let place = self.locate(half_sine2);
        (self.values_at(half_sine2, &place.0), self.kernels_at(&place))
    }

    #[inline(always)]
    fn values(&self, half_sine2: F32s) -> [F32s; N] {
        self.values_at(half_sine2, &self.locate(half_sine2).0)
    }

    #[inline(always)]
    fn values_at(&self, half_sine2: F32s, index: &[usize; LANES]) -> [F32s; N] {
        let fields = Fields::gather(&self.values, index, 2 + 2 * N);
        let share = (half_sine2 - fields.at(0)) * fields.at(1);
        let share = share.max(F32s::splat(0.0)).min(F32s::splat(1.0));
        let mut values = [F32s::splat(0.0); N];
        for (n, value) in values.iter_mut().enumerate() {
            *value = fields.at(2 + N + n).mul_add(share, fields.at(2 + n));
        }
        values
    }

    /// The phase matrix over its first element, at every wavelength.
    #[inline(always)]
    pub fn kernels(&self, half_sine2: F32s) -> [SpheroidBlock<F32s>; N] {
        self.kernels_at(&self.locate(half_sine2))
    }

    #[inline(always)]
    fn kernels_at(&self, (index, share): &([usize; LANES], F32s)) -> [SpheroidBlock<F32s>; N] {
        match (self.spheres, self.achromatic) {
            (true, true) => self.read_kernels::<true, true>(index, *share),
            (true, false) => self.read_kernels::<true, false>(index, *share),
            (false, true) => self.read_kernels::<false, true>(index, *share),
            (false, false) => self.read_kernels::<false, false>(index, *share),
        }
    }

    #[inline(always)]
    fn read_kernels<const SPHERES: bool, const ACHROMATIC: bool>(
        &self,
        index: &[usize; LANES],
        share: F32s,
    ) -> [SpheroidBlock<F32s>; N] {
        let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
        let wavelengths = if ACHROMATIC { 1 } else { N };
        let elements = if SPHERES { 3 } else { 5 };
        let steps = elements * wavelengths;
        let fields = Fields::gather(&self.elements, index, 2 * steps);
        let value = |element: usize, n: usize| {
            let field = element * wavelengths + if ACHROMATIC { 0 } else { n };
            fields.at(steps + field).mul_add(share, fields.at(field))
        };
        let mut kernels = [SpheroidBlock { a: zero, b: one, c: zero, d: zero, s: zero }; N];
        for (n, kernel) in kernels.iter_mut().enumerate() {
            let (a, c, s) = (value(0, n), value(1, n), value(2, n));
            let (b, d) = if SPHERES { (one, c) } else { (value(3, n), value(4, n)) };
            *kernel = SpheroidBlock { a, b, c, d, s };
        }
        kernels
    }

    /// Inverts the running sum, whose density is linear in `half_sine2` between nodes.
    #[inline(always)]
    fn sample(&self, n: usize, u: f32) -> f32 {
        let guide = &self.guide[n];
        let mut index = guide[(u * guide.len() as f32) as usize] as usize;
        while index + 2 < self.nodes.len() && self.nodes[index + 1].cdf[n] <= u {
            index += 1;
        }
        let [from, to] = [&self.nodes[index], &self.nodes[index + 1]];
        let step = to.cdf[n] - from.cdf[n];
        let share = if step > 0.0 { ((u - from.cdf[n]) / step).clamp(0.0, 1.0) } else { 0.5 };
        let [first, last] = [from.m00[n], to.m00[n]];
        let root = (first * first + (last * last - first * first) * share).max(0.0).sqrt();
        let sum = first + root;
        let along = if sum > 0.0 { share * (first + last) / sum } else { share };
        from.half_sine2 + (to.half_sine2 - from.half_sine2) * along.min(1.0)
    }
}

/// For equal shares of the numbers in [0, 1), the last node whose running sum is not above.
fn guide<const N: usize>(nodes: &[Node<N>], n: usize) -> Vec<u32> {
    let mut index = 0;
    (0..nodes.len())
        .map(|share| {
            let u = share as f32 / nodes.len() as f32;
            while index + 2 < nodes.len() && nodes[index + 1].cdf[n] <= u {
                index += 1;
            }
            index as u32
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polarization::rayleigh::rayleigh_depolarized;

    /// The table of depolarized dipoles, made here so that nothing else is needed.
    fn dipoles() -> PhaseFunction<1> {
        const INTERVALS: usize = 1024;
        let angle = |i: usize| std::f64::consts::PI * i as f64 / INTERVALS as f64;
        let at = |i: usize| rayleigh_depolarized(angle(i).cos(), 0.03);
        let half_sine2: Vec<f64> =
            (0..=INTERVALS).map(|i| (0.5 * angle(i)).sin().powi(2)).collect();
        let mut cdf = vec![0.0];
        for i in 0..INTERVALS {
            let mean = 0.5 * (at(i).0 + at(i + 1).0);
            let step = half_sine2[i + 1] - half_sine2[i];
            cdf.push(cdf[i] + 4.0 * std::f64::consts::PI * mean * step);
        }
        let total = cdf[INTERVALS];
        let single = |value: f64| [value as f32];
        PhaseFunction::Table(PhaseLookup::new(&PhaseTable {
            half_sine2: half_sine2.iter().map(|&x| x as f32).collect(),
            m00: (0..=INTERVALS).map(|i| single(at(i).0 / total)).collect(),
            cdf: cdf.iter().map(|&x| single(x / total)).collect(),
            elements: (0..=INTERVALS)
                .map(|i| {
                    let kernel = at(i).1;
                    [kernel.a, kernel.b, kernel.c, kernel.d, kernel.s].map(single)
                })
                .collect(),
            spheres: false,
            achromatic: true,
        }))
    }

    #[test]
    fn tables_read_what_they_were_made_of() {
        let phase = dipoles();
        let PhaseFunction::Table(table) = &phase else { panic!("a table") };
        for step in 0..=1000 {
            let theta = std::f64::consts::PI * f64::from(step) / 1000.0;
            let v = F32s::splat((0.5 * theta).sin().powi(2) as f32);
            let (m00, expected) = rayleigh_depolarized(theta.cos(), 0.03);
            let found = f64::from(phase.values(v)[0].to_array()[0]);
            assert!((found / m00 - 1.0).abs() < 1e-5, "{theta}: {found}, {m00}");
            let [kernel] = table.kernels(v);
            for (found, expected) in [
                (kernel.a, expected.a),
                (kernel.b, expected.b),
                (kernel.c, expected.c),
                (kernel.d, expected.d),
                (kernel.s, expected.s),
            ] {
                assert!((f64::from(found.to_array()[0]) - expected).abs() < 2e-5, "{theta}");
            }
        }
    }

    /// The share of samples below an angle is the integral up to it: 2^16 equal steps of the
    /// random number leave no noise.
    #[test]
    fn samples_follow_the_values() {
        for phase in [
            dipoles(),
            PhaseFunction::HenyeyGreenstein([0.8]),
            PhaseFunction::HenyeyGreenstein([-0.3]),
            PhaseFunction::HenyeyGreenstein([0.0]),
        ] {
            const COUNT: usize = 1 << 16;
            let mut samples = Vec::new();
            for first in (0..COUNT).step_by(LANES) {
                let u = lanes::each(|lane| ((first + lane) as f32 + 0.5) / COUNT as f32);
                samples.extend(phase.sample([0; LANES], F32s::from(u)).to_array());
            }
            let mut integral = 0.0;
            for step in 0..2048 {
                let middle = F32s::splat((step as f32 + 0.5) / 2048.0);
                let value = f64::from(phase.values(middle)[0].to_array()[0]);
                integral += value * 4.0 * std::f64::consts::PI / 2048.0;
                let edge = (step as f32 + 1.0) / 2048.0;
                let below = samples.iter().filter(|&&v| v < edge).count() as f64 / COUNT as f64;
                assert!((below - integral).abs() < 2e-3, "{phase:?} {edge}: {below}, {integral}");
            }
            assert!((integral - 1.0).abs() < 2e-3, "{integral}");
        }
    }

    #[test]
    fn deflections_have_their_angle() {
        let axis = Vector::splat([0.6, 0.0, -0.8]);
        let angles = F32s::from([0.0, 1e-6, 1e-4, 0.01, 0.3, 0.7, 0.999, 1.0]);
        let found = half_sine2(axis, deflect(axis, angles, F32s::splat(0.3))).to_array();
        for (found, expected) in found.iter().zip(angles.to_array()) {
            assert!((found - expected).abs() < 1e-3 * expected.min(1e-3) + 1e-7);
        }
    }
}
