//! Where rows go next, and the Mueller kernels of this bounce's polarizing events.

use crate::math::columns::{Channels, Column, columns};
use crate::math::{F32s, Vector, lanes};
use crate::polarization::kernel::{Block, Dense, Kernel, SpheroidBlock};
use crate::scattering::event::Form;

columns! {
    /// Where rows go next.
    pub struct DepartureColumns<const N: usize> {
        /// New directions, unit length.
        pub direction: [Column; 3],
        /// What that does to polarization.
        pub kernels: KernelColumns<N>,
    }
}

columns! {
    /// One sparse block per row, relative to the scalar value M00 that already is in `beta`;
    /// `Event::channel` says which wavelengths are stored.
    pub struct KernelColumns<const N: usize> {
        /// M01: diattenuation.
        pub a: Channels<N>,
        /// M11; only for spheroids.
        pub b: Channels<N>,
        /// M22: cosine-like element of the lower block.
        pub c: Channels<N>,
        /// M33; only for spheroids.
        pub d: Channels<N>,
        /// M23: sine-like element of the lower block.
        pub s: Channels<N>,
        /// All sixteen elements, row by row; only for dense kernels, which are few: room that
        /// nothing is written to costs no memory.
        pub dense: Vec<[[f32; 16]; N]>,
        /// The x axis of the block's frames: perpendicular to the light before and after.
        pub axis: [Column; 3],
    }
}

impl<const N: usize> KernelColumns<N> {
    /// Writes the kernels of the rows from `row` to `end`, eight at most, of an event of this
    /// `form`: of an achromatic one, only the first.
    #[inline(always)]
    pub fn store_events(
        &mut self,
        (form, achromatic): (Form, bool),
        (kernels, axis): &([SpheroidBlock<F32s>; N], Vector<F32s>),
        (row, end): (usize, usize),
    ) {
        for (n, &kernel) in kernels.iter().enumerate().take(if achromatic { 1 } else { N }) {
            let SpheroidBlock { a, c, s, .. } = kernel;
            match form {
                Form::Depolarizer => {}
                Form::Block => Block { a, c, s }.store(self, n, row, end),
                Form::Spheroid => kernel.store(self, n, row, end),
                Form::Dense => unreachable!("dense kernels are no spheroids: see `store_dense`"),
            }
        }
        axis.store(&mut self.axis, row, end);
    }

    /// Writes the dense kernels of a row, whose axis is `x`.
    pub fn store_dense(&mut self, kernels: &[Dense<f32>; N], x: [f32; 3], row: usize) {
        for (to, Dense(matrix)) in self.dense[row].iter_mut().zip(kernels) {
            for (to, from) in to.iter_mut().zip(matrix.iter().flatten()) {
                *to = *from;
            }
        }
        for (column, x) in self.axis.iter_mut().zip(x) {
            column[row] = x;
        }
    }
}

/// Kernels that are read from the columns, eight rows at a time.
pub trait StoredKernel: Kernel<F32s> {
    /// Reads the rows from `row` on.
    fn load<const N: usize>(columns: &KernelColumns<N>, channel: usize, row: usize) -> Self;
}

/// And written.
trait Store {
    /// Writes the rows from `row` to `end`, eight at most.
    fn store<const N: usize>(
        self,
        columns: &mut KernelColumns<N>,
        channel: usize,
        row: usize,
        end: usize,
    );
}

impl StoredKernel for Block<F32s> {
    #[inline(always)]
    fn load<const N: usize>(columns: &KernelColumns<N>, channel: usize, row: usize) -> Self {
        Self {
            a: lanes::load(&columns.a[channel], row),
            c: lanes::load(&columns.c[channel], row),
            s: lanes::load(&columns.s[channel], row),
        }
    }
}

impl Store for Block<F32s> {
    #[inline(always)]
    fn store<const N: usize>(
        self,
        columns: &mut KernelColumns<N>,
        channel: usize,
        row: usize,
        end: usize,
    ) {
        lanes::store(&mut columns.a[channel], row, end, self.a);
        lanes::store(&mut columns.c[channel], row, end, self.c);
        lanes::store(&mut columns.s[channel], row, end, self.s);
    }
}

impl StoredKernel for SpheroidBlock<F32s> {
    #[inline(always)]
    fn load<const N: usize>(columns: &KernelColumns<N>, channel: usize, row: usize) -> Self {
        let Block { a, c, s } = Block::load(columns, channel, row);
        let b = lanes::load(&columns.b[channel], row);
        Self { a, b, c, d: lanes::load(&columns.d[channel], row), s }
    }
}

impl Store for SpheroidBlock<F32s> {
    #[inline(always)]
    fn store<const N: usize>(
        self,
        columns: &mut KernelColumns<N>,
        channel: usize,
        row: usize,
        end: usize,
    ) {
        Block { a: self.a, c: self.c, s: self.s }.store(columns, channel, row, end);
        lanes::store(&mut columns.b[channel], row, end, self.b);
        lanes::store(&mut columns.d[channel], row, end, self.d);
    }
}

impl StoredKernel for Dense<F32s> {
    #[inline(always)]
    fn load<const N: usize>(columns: &KernelColumns<N>, channel: usize, row: usize) -> Self {
        let mut elements = [[F32s::ZERO; 4]; 4];
        for (index, element) in elements.iter_mut().flatten().enumerate() {
            let of = lanes::each(|lane| columns.dense[row + lane][channel][index]);
            *element = F32s::from(of);
        }
        Self(elements)
    }
}
