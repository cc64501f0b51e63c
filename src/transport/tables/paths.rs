//! Subpaths alive, one row each.

use std::any::Any;

use crate::geometry::RayColumns;
use crate::math::columns::{Channels, Column, Columns, columns};
use crate::math::{F32s, LANES, U32s, lanes};
use crate::scattering::emitter::tree::Vantage;
use crate::scattering::nesting::UNKNOWN;
use crate::transport::mis::{PartialWeights, TurnDensities};
use crate::transport::sampler::{Purpose, draw, draw_first};

use super::carriers::CarrierTable;
use super::media::MediaColumns;
use super::partition::Partition;
use super::pieces::LastPieceColumns;

/// The subpaths of one side that are still being extended.
pub struct PathTable<const N: usize, C: ?Sized> {
    /// Number of rows in use.
    pub len: usize,
    /// The current segment: from the last vertex on.
    pub rays: RayColumns,
    /// Who the rows are.
    pub identity: IdentityColumns,
    /// Scalar throughput: what both modes share, times the gains that polarizing events before
    /// the last depolarizer have brought.
    pub beta: Channels<N>,
    /// The odds of going on from the vertices at hand, of the rows that do; 0 for the others.
    pub odds: Column,
    /// What weighs strategies against each other.
    pub mis: MisColumns,
    /// The last vertex, if that matters to the choice of emitters.
    pub last: LastColumns,
    /// Nested dielectrics, if the scene has any.
    pub nested: NestedColumns,
    /// Media, if the scene has any.
    pub media: MediaColumns<N>,
    /// Where particles were met, if that matters to lamps.
    pub piece: LastPieceColumns,
    /// Polarization, for the rows that have any.
    pub carriers: C,
}

/// Paths of which nobody asks what they carry: what does not is compiled once for both sides and
/// modes. A reference to any [`PathTable`] is one to these.
pub type AnyPaths<const N: usize> = PathTable<N, dyn Any>;

columns! {
    /// Names of rows that survive every reordering.
    pub struct IdentityColumns {
        /// Place in the chunk: where measurements go, and which light path a sensor path meets.
        pub slot: Vec<u32>,
        /// Seed of the path's random sequences.
        pub seed: Vec<u32>,
        /// Index in those sequences.
        pub iteration: Vec<u32>,
    }
}

impl IdentityColumns {
    /// Two numbers in [0, 1) for each of the eight rows from `row` on, at the vertex after
    /// `path_length` segments.
    #[inline(always)]
    pub fn draw(&self, row: usize, path_length: u32, purpose: Purpose) -> [F32s; 2] {
        let seed = lanes::load_u32(&self.seed, row);
        let iteration = lanes::load_u32(&self.iteration, row);
        draw(seed, iteration, path_length, purpose)
    }

    /// The first of the two numbers of [`Self::draw`].
    #[inline(always)]
    pub fn draw_first(&self, row: usize, path_length: u32, purpose: Purpose) -> F32s {
        let seed = lanes::load_u32(&self.seed, row);
        let iteration = lanes::load_u32(&self.iteration, row);
        draw_first(seed, iteration, path_length, purpose)
    }

    /// Seeds and iterations of any eight rows.
    #[inline(always)]
    pub fn of_rows(&self, rows: &[usize; LANES]) -> (U32s, U32s) {
        let of = |column: &[u32]| U32s::from(lanes::each(|lane| column[rows[lane]]));
        (of(&self.seed), of(&self.iteration))
    }

    /// [`Self::draw`] for one row.
    pub fn draw_row(&self, row: usize, path_length: u32, purpose: Purpose) -> [f32; 2] {
        let (seed, iteration) = (U32s::splat(self.seed[row]), U32s::splat(self.iteration[row]));
        draw(seed, iteration, path_length, purpose).map(|u| u.as_array()[0])
    }

    /// The wavelengths that the distances and angles of eight paths are drawn for.
    #[inline(always)]
    pub fn wavelength<const N: usize>(&self, row: usize) -> [u32; LANES] {
        if N == 1 {
            return [0; LANES];
        }
        let u = self.draw_first(row, 0, Purpose::Wavelength);
        let place = (u * F32s::splat(N as f32)).to_array();
        lanes::each(|lane| (place[lane] as u32).min(N as u32 - 1))
    }
}

columns! {
    /// Partial weights, absent where strategies are weighed without them, and what the
    /// unidirectional heuristic takes in their place.
    pub struct MisColumns {
        /// Density per steradian of the current direction; infinite after a specular event and
        /// from the sensor. Used by `path`.
        pub pdf_w: Column,
        /// [`PartialWeights::d_vcm`].
        pub d_vcm: Column,
        /// [`PartialWeights::d_vc`].
        pub d_vc: Column,
    }
}

columns! {
    /// What else the choice of emitters is to know of the last vertex, where they are chosen by
    /// what they bring to it.
    pub struct LastColumns {
        /// [`Vantage::normal`].
        pub normal: [Column; 3],
    }
}

impl LastColumns {
    /// Whether there are columns at all.
    #[inline(always)]
    pub fn present(&self) -> bool {
        !self.normal[0].is_empty()
    }

    /// Makes the columns for `capacity` rows, unless there are.
    pub fn make(&mut self, capacity: usize) {
        if !self.present() {
            *self = Self::new(capacity);
        }
    }
}

columns! {
    /// What paths know of the dielectrics that they are in, where some overlap or touch.
    pub struct NestedColumns {
        /// The number of the index of refraction around the current segment's start, in the
        /// scene's [`Interfaces`](crate::scattering::nesting::Interfaces).
        pub inside: Vec<u32>,
    }
}

impl NestedColumns {
    /// Whether there are columns at all.
    #[inline(always)]
    pub fn present(&self) -> bool {
        !self.inside.is_empty()
    }

    /// Makes the columns for `capacity` rows, unless there are, for paths that have met nothing.
    pub fn start(&mut self, capacity: usize) {
        if !self.present() {
            *self = Self::new(capacity);
        }
        self.inside.fill(UNKNOWN);
    }
}

impl MisColumns {
    /// For `capacity` rows, with or without partial weights.
    fn if_weighed(capacity: usize, are_weighed: bool) -> Self {
        let all = Self::new(capacity);
        if are_weighed { all } else { Self { pdf_w: all.pdf_w, ..Self::absent() } }
    }

    /// Whether there are partial weights.
    #[inline(always)]
    fn are_weighed(&self) -> bool {
        !self.d_vcm.is_empty()
    }

    /// The partial weights of eight rows.
    #[inline(always)]
    pub fn load(&self, row: usize) -> PartialWeights<F32s> {
        PartialWeights { d_vcm: lanes::load(&self.d_vcm, row), d_vc: lanes::load(&self.d_vc, row) }
    }

    /// Those of one row.
    #[inline(always)]
    pub fn row(&self, row: usize) -> PartialWeights<f32> {
        PartialWeights { d_vcm: self.d_vcm[row], d_vc: self.d_vc[row] }
    }

    /// Those of one row, in all lanes.
    #[inline(always)]
    pub fn splat(&self, row: usize) -> PartialWeights<F32s> {
        let PartialWeights { d_vcm, d_vc } = self.row(row);
        PartialWeights { d_vcm: F32s::splat(d_vcm), d_vc: F32s::splat(d_vc) }
    }

    /// Sets the partial weights, if there are any, of the rows from `row` on that lie before `end`,
    /// eight at most.
    #[inline(always)]
    pub fn store(&mut self, row: usize, end: usize, weights: PartialWeights<F32s>) {
        if !self.are_weighed() {
            return;
        }
        lanes::store(&mut self.d_vcm, row, end, weights.d_vcm);
        lanes::store(&mut self.d_vc, row, end, weights.d_vc);
    }

    /// Sets those of one row, if there are any.
    #[inline(always)]
    pub fn set_row(&mut self, row: usize, weights: PartialWeights<f32>) {
        if !self.are_weighed() {
            return;
        }
        self.d_vcm[row] = weights.d_vcm;
        self.d_vc[row] = weights.d_vc;
    }

    /// Takes one row through a surface that it passes with the probability `chance`.
    #[inline(always)]
    pub fn pass(&mut self, row: usize, chance: f32) {
        if self.are_weighed() {
            self.set_row(row, self.row(row).pass(chance));
        }
        self.pdf_w[row] *= chance;
    }

    /// Sends eight rows on from vertices that connect.
    #[inline(always)]
    pub fn depart(&mut self, row: usize, end: usize, turn: TurnDensities<F32s>) {
        if self.are_weighed() {
            self.store(row, end, self.load(row).depart(turn));
        }
        lanes::store(&mut self.pdf_w, row, end, turn.pdf);
    }

    /// Sends eight rows on from specular events; `measure` is the cosine of the direction.
    #[inline(always)]
    pub fn depart_specular(&mut self, row: usize, end: usize, measure: F32s) {
        if self.are_weighed() {
            self.store(row, end, self.load(row).depart_specular(measure));
        }
        lanes::store(&mut self.pdf_w, row, end, F32s::splat(f32::INFINITY));
    }
}

impl<const N: usize, C: ?Sized> PathTable<N, C> {
    /// The last vertex of a row as those see it who choose emitters there.
    pub fn vantage(&self, row: usize) -> Vantage {
        let normal = match self.last.present() {
            true => lanes::row_of(&self.last.normal, row),
            false => [0.0; 3],
        };
        Vantage { position: lanes::row_of(&self.rays.origin, row).into(), normal: normal.into() }
    }
}

impl<const N: usize, C: CarrierTable> PathTable<N, C> {
    /// An empty table for `capacity` rows, with or without media and partial weights.
    pub fn new(capacity: usize, (with_media, are_weighed): (bool, bool)) -> Self {
        Self {
            len: 0,
            rays: RayColumns::new(capacity),
            identity: IdentityColumns::new(capacity),
            beta: Columns::with_room(capacity),
            odds: Column::with_room(capacity),
            mis: MisColumns::if_weighed(capacity, are_weighed),
            last: LastColumns::absent(),
            nested: NestedColumns::absent(),
            media: MediaColumns::if_any(capacity, with_media),
            piece: LastPieceColumns::absent(),
            carriers: C::new(capacity),
        }
    }

    /// Takes the rows that `partition` keeps from another table, in its order.
    pub fn take(&mut self, from: &Self, partition: &Partition) {
        let Self { len, rays, identity, beta, odds, mis, last, nested, media, piece, carriers } =
            self;
        let order = &partition.order;
        *len = order.len();
        rays.take_rows(&from.rays, order, 0);
        identity.take_rows(&from.identity, order, 0);
        beta.take_rows(&from.beta, order, 0);
        odds.take_rows(&from.odds, order, 0);
        mis.take_rows(&from.mis, order, 0);
        if last.present() {
            last.take_rows(&from.last, order, 0);
        }
        if nested.present() {
            nested.take_rows(&from.nested, order, 0);
        }
        media.take_rows(&from.media, order, 0);
        if piece.present() {
            piece.take_rows(&from.piece, order, 0);
        }
        for part in &partition.parts {
            carriers.gather(&from.carriers, order, part);
        }
    }
}
