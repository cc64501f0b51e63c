//! Where rows go next, and the Mueller kernels of this bounce's polarizing events.

use crate::math::columns::{Channels, Column, Columns, columns};
use crate::math::{F32s, LANES, Vector, lanes};
use crate::polarization::kernel::{Block, Dense, Kernel, SpheroidBlock};
use crate::scattering::event::{Elements, Form};

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
    /// One kernel per row, relative to the scalar value M00 that already is in `beta`;
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
        /// All elements of dense kernels but the first, row by row; the columns above are not
        /// theirs. Absent until there is one.
        pub dense: [Channels<N>; DENSE],
        /// The x axis of the kernel's frames: perpendicular to the light before and after.
        pub axis: [Column; 3],
    }
}

/// Elements of a dense kernel besides M00, which is one.
const DENSE: usize = 15;

impl<const N: usize> DepartureColumns<N> {
    /// Room for `capacity` rows, but for dense kernels, which most scenes have none of.
    pub fn with_sparse_kernels(capacity: usize) -> Self {
        let mut columns = Self::new(capacity);
        columns.kernels.dense = Columns::absent();
        columns
    }
}

impl<const N: usize> KernelColumns<N> {
    /// Writes the kernels of the rows from `row` to `end`, eight at most, of an event of this
    /// `form`: of an achromatic one, only the first.
    #[inline(always)]
    pub fn store_events<K: Elements>(
        &mut self,
        (form, achromatic): (Form, bool),
        (kernels, axis): (&[K; N], Vector<F32s>),
        (row, end): (usize, usize),
    ) {
        for (n, &kernel) in kernels.iter().enumerate().take(if achromatic { 1 } else { N }) {
            let SpheroidBlock { a, c, s, .. } = kernel.spheroid();
            match form {
                Form::Depolarizer => {}
                Form::Block => Block { a, c, s }.store(self, n, row, end),
                Form::Spheroid => kernel.spheroid().store(self, n, row, end),
                Form::Dense => self.store_dense(&kernel.dense(), n, row, end),
            }
        }
        axis.store(&mut self.axis, row, end);
    }

    #[inline(never)]
    fn store_dense(&mut self, kernel: &Dense<F32s>, channel: usize, row: usize, end: usize) {
        if self.dense.room() == 0 {
            self.dense = Columns::with_room(self.axis.room() - LANES);
        }
        kernel.store(self, channel, row, end);
    }
}

/// Kernels that are read from the columns, eight rows at a time.
pub trait StoredKernel: Kernel<F32s> {
    /// Reads the rows from `row` on.
    fn load<const N: usize>(columns: &KernelColumns<N>, channel: usize, row: usize) -> Self;

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
        let mut kernel = [[F32s::ONE; 4]; 4];
        let elements = kernel.as_flattened_mut()[1..].iter_mut();
        for (element, column) in elements.zip(&columns.dense) {
            *element = lanes::load(&column[channel], row);
        }
        Self(kernel)
    }

    #[inline(always)]
    fn store<const N: usize>(
        self,
        columns: &mut KernelColumns<N>,
        channel: usize,
        row: usize,
        end: usize,
    ) {
        let elements = self.0.as_flattened()[1..].iter();
        for (&element, column) in elements.zip(&mut columns.dense) {
            lanes::store(&mut column[channel], row, end, element);
        }
    }
}
