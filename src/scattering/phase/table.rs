//! Tabulated phase matrices: look-ups by angle, eight rows at a time.

use crate::math::{F32s, LANES, lanes, warp};
use crate::polarization::kernel::SpheroidBlock;
use crate::scattering::event::Form;
use crate::scene::baked::PhaseTable;

use super::Scatters;

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
    spheres: bool,
    /// Whether the elements are the same at all wavelengths.
    achromatic: bool,
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
    // Out of line: tables have up to ten packets, and places that read them are many.
    #[inline(never)]
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

impl<const N: usize> Scatters<N> for PhaseLookup<N> {
    const POLARIZES: bool = true;

    fn kernel(&self) -> (Form, bool) {
        (if self.spheres { Form::Block } else { Form::Spheroid }, self.achromatic)
    }

    /// Simpson's rule between nodes, which is exact for what is linear there.
    fn moments(&self, wavelength: usize) -> [f32; 2] {
        let (mut cosine, mut square) = (0.0, 0.0);
        for pair in self.nodes.windows(2) {
            let [from, to] = [0, 1].map(|end| {
                let Node { half_sine2, m00, .. } = pair[end];
                [half_sine2, m00[wavelength]].map(f64::from)
            });
            let middle = [0, 1].map(|part| 0.5 * (from[part] + to[part]));
            for ([half_sine2, value], weight) in [(from, 1.0), (middle, 4.0), (to, 1.0)] {
                let share = weight / 6.0 * (to[0] - from[0]) * value;
                cosine += share * (1.0 - 2.0 * half_sine2);
                square += share * value;
            }
        }
        let sphere = 4.0 * std::f64::consts::PI;
        [(sphere * cosine) as f32, (sphere * sphere * square) as f32]
    }

    #[inline(always)]
    fn values(&self, half_sine2: F32s) -> [F32s; N] {
        self.values_at(half_sine2, &self.locate(half_sine2).0)
    }

    #[inline(always)]
    fn sample(&self, wavelength: [u32; LANES], u: F32s) -> F32s {
        let u = u.to_array();
        F32s::from(lanes::each(|lane| self.sample_one(wavelength[lane] as usize, u[lane])))
    }

    #[inline(always)]
    fn kernels(&self, half_sine2: F32s) -> [SpheroidBlock<F32s>; N] {
        self.kernels_at(&self.locate(half_sine2))
    }

    #[inline(always)]
    fn values_and_kernels(&self, half_sine2: F32s) -> ([F32s; N], [SpheroidBlock<F32s>; N]) {
        let place = self.locate(half_sine2);
        (self.values_at(half_sine2, &place.0), self.kernels_at(&place))
    }
}

impl<const N: usize> PhaseLookup<N> {
    /// The look-ups of a baked table.
    pub fn new(table: &PhaseTable<N>) -> Self {
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
    fn sample_one(&self, n: usize, u: f32) -> f32 {
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
