//! What numbers may be: ranges with names, and what is said about a value outside of its own.
//!
//! Whoever owns a value checks it with these: metals and particles, the components of a scene.
//! Who reads a file or takes a program's call says where the value stands.

use std::fmt::Display;

use super::text::sentence;

/// A set of numbers, and its name in errors.
#[derive(Clone, Copy, Debug)]
pub struct Range {
    text: &'static str,
    contains: fn(f64) -> bool,
}

impl Range {
    /// Finite numbers.
    pub const ANY: Self = Self::new("a finite number", |_| true);
    /// More than zero, as an `f32`.
    pub const POSITIVE: Self = Self::new("greater than 0", |x| x as f32 >= f32::MIN_POSITIVE);
    /// Zero or more.
    pub const NOT_NEGATIVE: Self = Self::new("not negative", |x| x >= 0.0);
    /// From zero to one.
    pub const UNIT: Self = Self::new("within [0, 1]", |x| (0.0..=1.0).contains(&x));
    /// One or more.
    pub const AT_LEAST_ONE: Self = Self::new("at least 1", |x| x >= 1.0);
    /// Shares that are not nothing: greater than zero, one at most.
    pub const FRACTION: Self = Self::new("greater than 0 and at most 1", |x| 1e-30 < x && x <= 1.0);

    /// A set of numbers that errors call `text`, as in "0 must be greater than 0".
    pub const fn new(text: &'static str, contains: fn(f64) -> bool) -> Self {
        Self { text, contains }
    }

    /// Refuses a number that is not in the range, or not finite as an `f32`. `field` is what
    /// errors call it. Numbers are what their digits say: 0.01 as an `f32` is at least 0.01, though
    /// its bits are a little less.
    ///
    /// # Errors
    /// With the number and the name of the range.
    pub fn check<T: Copy + Display + Into<f64>>(self, field: &str, number: T) -> Result<(), Fault> {
        let value: f64 = number.into();
        let as_written = || number.to_string().parse().is_ok_and(self.contains);
        if (value as f32).is_finite() && ((self.contains)(value) || as_written()) {
            return Ok(());
        }
        Err(Fault::new(field, format!("{number} must be {}", self.text), ""))
    }
}

/// What is wrong with a field of something, and how to mend it; whose field it is, others know.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", self.text())]
pub struct Fault {
    /// The field, as `reflectance` or `components[0].eta`; empty for the whole.
    pub field: String,
    /// What is wrong with it.
    pub problem: String,
    /// How to mend it; empty where the problem says it.
    pub remedy: String,
}

impl Fault {
    /// A problem of a field.
    pub fn new(
        field: impl Into<String>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self { field: field.into(), problem: problem.into(), remedy: remedy.into() }
    }

    fn text(&self) -> String {
        sentence(&self.field, &self.problem)
    }

    /// The same fault, of a field that has another name.
    #[must_use]
    pub fn of(self, field: impl Into<String>) -> Self {
        Self { field: field.into(), ..self }
    }

    /// The same fault, seen from what holds the thing as `part`.
    #[must_use]
    pub fn within(self, part: &str) -> Self {
        let separator = if self.field.is_empty() { "" } else { "." };
        Self { field: format!("{part}{separator}{}", self.field), ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_refused_by_name() {
        let fault = Range::UNIT.check("reflectance", 1.1_f32).unwrap_err();
        assert_eq!(fault.problem, "1.1 must be within [0, 1]");
        assert_eq!(fault.within("rows[1]").field, "rows[1].reflectance");
        assert!(Range::ANY.check("x", 1e39).is_err(), "no f32");
        assert!(Range::POSITIVE.check("x", 1e-39).is_err(), "not normal as an f32");
        for range in [Range::ANY, Range::POSITIVE, Range::NOT_NEGATIVE, Range::UNIT] {
            assert!(range.check("x", 1.0).is_ok());
            assert!(range.check("x", f64::NAN).is_err());
        }
        // The nearest `f32` to 0.01 is less, and that to 0.7 too; that to 0.1 is more.
        let bounded = Range::new("from 0.01 to 0.1", |x| (0.01..=0.1).contains(&x));
        assert!(f64::from(0.01_f32) < 0.01 && f64::from(0.1_f32) > 0.1);
        for number in [0.01_f32, 0.05, 0.1] {
            assert!(bounded.check("x", number).is_ok(), "{number}");
        }
        for number in [0.01_f32.next_down(), 0.1_f32.next_up(), f32::NAN, -0.05] {
            assert!(bounded.check("x", number).is_err(), "{number}");
        }
        assert!(bounded.check("x", f64::from(0.01_f32)).is_err(), "as an f64 it is less");
        assert!(
            Range::FRACTION.check("x", 0.0).is_err() && Range::FRACTION.check("x", 1.0).is_ok()
        );
    }
}
