//! Where directions are in an equirectangular picture, eight at a time.

use crate::math::{F32s, LANES, Real, Vector, lanes};

use std::f32::consts::{PI, TAU};

/// How near to the edge of a cell points are, relative to its size: at an edge there may be none.
pub const EDGE: f32 = 1e-6;

/// Eight points of a picture: each in a cell between two rows, or a row and a pole, and two
/// columns.
pub struct Places {
    /// Columns and rows.
    size: [usize; 2],
    /// The cells: those behind so many columns, and behind so many rows.
    cells: [[u32; LANES]; 2],
    /// Where in the cells: to the right and down, from 0 to 1.
    shares: [F32s; 2],
}

impl Places {
    /// Those in cells of a picture, by where they are in these.
    pub fn new(size: [usize; 2], cells: [[u32; LANES]; 2], shares: [F32s; 2]) -> Self {
        let [least, most] = [EDGE, 1.0 - EDGE].map(F32s::splat);
        let shares = shares.map(|share| share.fast_max(least).fast_min(most));
        Self { size, cells, shares }
    }

    /// Those of directions of unit length.
    pub fn of(direction: Vector<F32s>, size: [usize; 2]) -> Self {
        let [width, height] = size.map(|it| it as f32);
        let [zero, half, one] = [0.0, 0.5, 1.0].map(F32s::splat);
        let around = direction.z.atan2(direction.x) * F32s::splat(1.0 / TAU) + half;
        let x = around * F32s::splat(width) - half;
        let x = Real::select(x.simd_lt(zero), x + F32s::splat(width), x);
        let x = x.fast_max(zero).fast_min(F32s::splat(width));
        // In rows from the nearer pole, so that no digits are lost there.
        let from_pole = across(direction).atan2(direction.y.abs()) * F32s::splat(height / PI);
        let y = from_pole.fast_max(zero).fast_min(F32s::splat(0.5 * height)) + half;
        let at_pole = y.simd_lt(one);
        let cell = Real::select(at_pole, zero, y.floor());
        let down = Real::select(at_pole, (y - half) * F32s::splat(2.0), y - cell);
        let is_below = direction.y.simd_lt(zero);
        let cell = Real::select(is_below, F32s::splat(height) - cell, cell);
        let down = Real::select(is_below, one - down, down);
        let column = x.floor().fast_min(F32s::splat(width - 1.0));
        let cells = [column, cell].map(|it| lanes::each(|lane| it.to_array()[lane] as u32));
        Self::new(size, cells, [x - column, down])
    }

    /// The directions, and the sines of their angles from +y.
    pub fn directions(&self) -> (Vector<F32s>, F32s) {
        let [width, height] = self.size.map(|it| it as f32);
        let [half, one] = [0.5, 1.0].map(F32s::splat);
        let [column, cell] = self.cells.map(|cells| F32s::from(cells.map(|it| it as f32)));
        let [share, down] = self.shares;
        // In rows from the nearer pole, where cells are half as high.
        let is_below = cell.simd_gt(F32s::splat(0.5 * height));
        let cell = Real::select(is_below, F32s::splat(height) - cell, cell);
        let down = Real::select(is_below, one - down, down);
        let at_pole = cell.simd_lt(half);
        let rows = Real::select(at_pole, half * down, cell - half + down);
        let (sine, cosine) = (rows * F32s::splat(PI / height)).sin_cos();
        let turns = (column + share + half) * F32s::splat(1.0 / width) - half;
        let (z, x) = (turns * F32s::splat(TAU)).sin_cos();
        let y = Real::select(is_below, -cosine, cosine);
        (Vector::new(sine * x, y, sine * z), sine)
    }

    /// The two rows about one of them, and their shares in the weight, which is zero at the poles.
    #[inline(always)]
    pub fn rows(&self, lane: usize) -> ([usize; 2], [f32; 2]) {
        let (cell, down) = (self.cells[1][lane] as usize, self.shares[1].to_array()[lane]);
        let height = self.size[1];
        match cell {
            0 => ([0; 2], [0.0, down]),
            _ if cell >= height => ([height - 1; 2], [1.0 - down, 0.0]),
            _ => ([cell - 1, cell], [1.0 - down, down]),
        }
    }

    /// The two columns about one of them, and the share of the second.
    #[inline(always)]
    pub fn columns(&self, lane: usize) -> ([usize; 2], f32) {
        let column = self.cells[0][lane] as usize;
        let next = if column + 1 == self.size[0] { 0 } else { column + 1 };
        ([column, next], self.shares[0].to_array()[lane])
    }

    /// The columns and rows about one of them, and their shares.
    pub fn corners(&self, lane: usize) -> [([usize; 2], f32); 4] {
        let (([upper, lower], [_, down]), ([left, right], across)) =
            (self.rows(lane), self.columns(lane));
        [
            ([left, upper], (1.0 - across) * (1.0 - down)),
            ([right, upper], across * (1.0 - down)),
            ([left, lower], (1.0 - across) * down),
            ([right, lower], across * down),
        ]
    }

    /// What is made of the texels about one of them, interpolated: exactly that of one if all are
    /// the same.
    #[inline(always)]
    pub fn mixed<const N: usize>(
        &self,
        lane: usize,
        of: impl Fn(usize, usize) -> [f32; N],
    ) -> [f32; N] {
        // Between the middle of an edge's texels and the pole both rows are one.
        let ((rows, [_, down]), ([left, right], across)) = (self.rows(lane), self.columns(lane));
        let [upper, lower] = rows.map(|row| between([of(left, row), of(right, row)], across));
        between([upper, lower], down)
    }
}

/// Between values, by the share of the second.
#[inline(always)]
fn between<const N: usize>([first, second]: [[f32; N]; 2], share: f32) -> [f32; N] {
    std::array::from_fn(|n| (second[n] - first[n]).mul_add(share, first[n]))
}

/// The sines of the angles of directions of unit length from +y.
pub fn across(direction: Vector<F32s>) -> F32s {
    direction.x.mul_add(direction.x, direction.z * direction.z).sqrt()
}
