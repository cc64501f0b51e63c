//! Sums that do not depend on the order of what is added.
//!
//! Each is kept as two doubles, the sum and what rounding took from it so far, both without error
//! (Knuth, "The Art of Computer Programming", volume 2, section 4.2.2, theorem B). Values in single
//! precision that differ by up to 2^80 in size are added without any error: rounded at the end, the
//! sum is the same however they were grouped. A smaller value beside a larger one errs by 2^-106 of
//! that.

use std::ops::{Add, Sub};

use wide::{f32x4, f64x4};

/// Sums of columns of values.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExactSums {
    high: Vec<f64>,
    low: Vec<f64>,
}

impl ExactSums {
    /// So many sums of nothing.
    pub fn new(count: usize) -> Self {
        Self { high: vec![0.0; count], low: vec![0.0; count] }
    }

    /// The sums of two columns, value by value.
    pub fn of_columns(high: Vec<f64>, low: Vec<f64>) -> Self {
        assert_eq!(high.len(), low.len(), "two columns of one table");
        Self { high, low }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.high.len()
    }

    /// Sets all to zero.
    pub fn clear(&mut self) {
        self.high.fill(0.0);
        self.low.fill(0.0);
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.high.is_empty()
    }

    /// There are so many from now on; new ones are zero.
    pub fn resize(&mut self, count: usize) {
        self.high.resize(count, 0.0);
        self.low.resize(count, 0.0);
    }

    /// Adds values to the sums from `first` on.
    #[inline(always)]
    pub fn add(&mut self, first: usize, values: &[f32]) {
        let high = &mut self.high[first..first + values.len()];
        let low = &mut self.low[first..first + values.len()];
        for ((high, low), value) in high.iter_mut().zip(low).zip(values) {
            let error;
            (*high, error) = two_sum(*high, f64::from(*value));
            *low += error;
        }
    }

    /// Adds four values to the sums from `first` on, side by side.
    #[inline(always)]
    pub fn add_four(&mut self, first: usize, values: f32x4) {
        let [a, b, c, d] = values.to_array().map(f64::from);
        let high = &mut self.high[first..first + 4];
        let low = &mut self.low[first..first + 4];
        let of = |column: &[f64]| f64x4::new([column[0], column[1], column[2], column[3]]);
        let (sum, error) = two_sum(of(high), f64x4::new([a, b, c, d]));
        high.copy_from_slice(&sum.to_array());
        low.copy_from_slice(&(of(low) + error).to_array());
    }

    /// Adds `count` sums of others, from `from` on, to those from `first` on.
    #[inline(always)]
    pub fn add_sums(&mut self, first: usize, others: &Self, from: usize, count: usize) {
        let high = &mut self.high[first..first + count];
        let low = &mut self.low[first..first + count];
        let others = others.high[from..from + count].iter().zip(&others.low[from..from + count]);
        for ((high, low), (more, rest)) in high.iter_mut().zip(low).zip(others) {
            let error;
            (*high, error) = two_sum(*high, *more);
            *low += error;
            *low += *rest;
        }
    }

    /// A sum, rounded.
    #[inline(always)]
    pub fn get(&self, index: usize) -> f64 {
        self.high[index] + self.low[index]
    }

    /// The two columns.
    pub fn columns(&self) -> [&[f64]; 2] {
        [&self.high, &self.low]
    }
}

/// The rounded sum, and what is missing from it.
#[inline(always)]
fn two_sum<F: Copy + Add<Output = F> + Sub<Output = F>>(a: F, b: F) -> (F, F) {
    let sum = a + b;
    let of_b = sum - a;
    let error = (a - (sum - of_b)) + (b - of_b);
    (sum, error)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::combine;

    /// Values of all sizes in three orders, and in two halves: the sums have the same bits, where
    /// those in double precision alone differ.
    #[test]
    fn no_order_changes_a_bit() {
        const COUNT: u32 = 4096;
        let value = |index: u32| {
            let bits = combine(7, index);
            let exponent = (combine(8, index) % 60) as i32 - 30;
            let mantissa = bits as f32 / u32::MAX as f32 - 0.3;
            mantissa * 2f32.powi(exponent)
        };
        let values: Vec<f32> = (0..COUNT).map(value).collect();
        let sum_of = |values: &mut dyn Iterator<Item = f32>| {
            let mut sums = ExactSums::new(1);
            values.for_each(|value| sums.add(0, &[value]));
            sums
        };
        let forward = sum_of(&mut values.iter().copied());
        let backward = sum_of(&mut values.iter().rev().copied());
        let (first, second) = values.split_at(1000);
        let mut parts = sum_of(&mut second.iter().copied());
        parts.add_sums(0, &sum_of(&mut first.iter().copied()), 0, 1);
        let mut fours = ExactSums::new(4);
        values.as_chunks::<4>().0.iter().for_each(|four| fours.add_four(0, f32x4::new(*four)));
        let mut together = ExactSums::new(1);
        (0..4).for_each(|index| together.add_sums(0, &fours, index, 1));
        assert_eq!(forward.get(0).to_bits(), together.get(0).to_bits());
        assert_eq!(forward.get(0).to_bits(), backward.get(0).to_bits());
        assert_eq!(forward.get(0).to_bits(), parts.get(0).to_bits());
        let plain =
            |values: &mut dyn Iterator<Item = f32>| values.fold(0.0, |sum, v| sum + f64::from(v));
        assert_ne!(plain(&mut values.iter().copied()), plain(&mut values.iter().rev().copied()));
    }

    /// A large value that comes and goes leaves the small ones as they are.
    #[test]
    fn nothing_is_lost_beside_large_values() {
        let mut sums = ExactSums::new(2);
        for values in [[1.0, 0.1], [1e20, 1e10], [3.0, 0.2], [-1e20, -1e10]] {
            sums.add(0, &values);
        }
        assert_eq!(sums.get(0), 4.0);
        assert_eq!(sums.get(1), f64::from(0.1_f32) + f64::from(0.2_f32));
    }
}
