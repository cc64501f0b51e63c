//! Reconstruction filters: how much light at a point of the film counts for a pixel.
//!
//! A pixel is the mean of the light about its center, weighted by the filter along the two axes:
//! `f(dx) f(dy)`. Both ways of finding light measure that mean:
//!
//! - a sample of a pixel lies where the filter's magnitude draws it, and counts by its sign (filter
//!   importance sampling: Ernst, Stamminger and Greiner 2006, "Filter importance sampling"), unless
//!   neighbors share their samples (`lattice`);
//! - light that comes to a point of the film counts for one of the pixels whose filters reach
//!   there, drawn by their magnitudes, times the sum of these.
//!
//! Strategies are weighed as if the filter were the pixel's square, on both sides. These weights
//! are functions of the point of the film alone, so that they sum to one with any filter.

use std::fmt;

use crate::math::elementary::{exp, sin};
use crate::math::{Fault, Range};

/// Pieces of a [`Profile`] from the center to the end.
const PIECES: usize = 768;
/// Radii that filters may have, in pixels.
const RADII: Range = Range::new("from 0.01 to 32 pixels", |x| (0.01..=32.0).contains(&x));

/// What a filter looks like, whatever its width.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilterKind {
    /// The same everywhere: of half a pixel, the mean over the pixel's square.
    Box,
    /// Falls linearly to zero.
    Tent,
    /// A Gaussian of a standard deviation of a quarter of the radius, less its value there.
    Gaussian,
    /// Mitchell and Netravali 1988, "Reconstruction filters in computer graphics", with B and C of
    /// a third; it has negative lobes.
    Mitchell,
    /// The same with B = 0 and C = 1/2, which interpolates: sharper.
    CatmullRom,
    /// A sinc under a sinc that ends after three zeros, the sharpest.
    Lanczos,
}

impl FilterKind {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Box, Self::Tent, Self::Gaussian, Self::Mitchell, Self::CatmullRom, Self::Lanczos];

    /// What users call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Box => "box",
            Self::Tent => "tent",
            Self::Gaussian => "gaussian",
            Self::Mitchell => "mitchell",
            Self::CatmullRom => "catmullrom",
            Self::Lanczos => "lanczos",
        }
    }

    /// What it is, in a few words.
    pub fn summary(self) -> &'static str {
        match self {
            Self::Box => "The mean over squares: those of pixels by radius 0.5, the default",
            Self::Tent => "Falls linearly; radius 1 by default",
            Self::Gaussian => "Standard deviation a quarter of the radius, which is 2 by default",
            Self::Mitchell => "Mitchell and Netravali's, a little sharpened; radius 2 by default",
            Self::CatmullRom => "Interpolates, sharper; radius 2 by default",
            Self::Lanczos => "Three lobes of a sinc, the sharpest; radius 3 by default",
        }
    }

    /// Its radius in pixels where none is named, that of Mitsuba 3.
    pub fn radius(self) -> f32 {
        match self {
            Self::Box => 0.5,
            Self::Tent => 1.0,
            Self::Gaussian | Self::Mitchell | Self::CatmullRom => 2.0,
            Self::Lanczos => 3.0,
        }
    }

    /// Its value, up to a factor, at a share of its radius from the center, from 0 to 1.
    fn value(self, share: f64) -> f64 {
        match self {
            Self::Box => 1.0,
            Self::Tent => 1.0 - share,
            Self::Gaussian => exp(-8.0 * share * share) - exp(-8.0),
            Self::Mitchell => cubic([1.0 / 3.0; 2], 2.0 * share),
            Self::CatmullRom => cubic([0.0, 0.5], 2.0 * share),
            Self::Lanczos => sinc(3.0 * share) * sinc(share),
        }
    }
}

/// Mitchell and Netravali's equation 8, of `x` from 0 to 2.
fn cubic([b, c]: [f64; 2], x: f64) -> f64 {
    let [x2, x3] = [x * x, x * x * x];
    if x < 1.0 {
        return (12.0 - 9.0 * b - 6.0 * c) * x3 + (12.0 * b + 6.0 * c - 18.0) * x2 + 6.0 - 2.0 * b;
    }
    (-b - 6.0 * c) * x3
        + (6.0 * b + 30.0 * c) * x2
        + (-12.0 * b - 48.0 * c) * x
        + 8.0 * b
        + 24.0 * c
}

fn sinc(x: f64) -> f64 {
    let angle = std::f64::consts::PI * x;
    if x == 0.0 { 1.0 } else { sin(angle) / angle }
}

/// Which pixels samples count for, where filters are wider than a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilterSamples {
    /// All whose filters reach them: least noise, alike in neighbors ([`super::lattice`]).
    Shared,
    /// One: noise is each pixel's own.
    Own,
}

impl FilterSamples {
    /// Both of them.
    pub const ALL: [Self; 2] = [Self::Shared, Self::Own];

    /// What users call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Shared => "shared",
            Self::Own => "own",
        }
    }

    /// What it is, in a few words.
    pub fn summary(self) -> &'static str {
        match self {
            Self::Shared => "Count for all pixels whose filters reach them: least noise",
            Self::Own => "Count for one pixel: noise of neighbors is independent",
        }
    }
}

/// A filter of some width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filter {
    /// What it looks like.
    pub kind: FilterKind,
    /// Where it ends, in pixels along either axis.
    pub radius: f32,
}

impl Filter {
    /// The mean over the square of a pixel.
    pub const PIXEL: Self = Self { kind: FilterKind::Box, radius: 0.5 };

    /// A filter with the radius that its kind has by default.
    pub fn of(kind: FilterKind) -> Self {
        Self { kind, radius: kind.radius() }
    }

    /// Refuses a radius that is out of range.
    pub(crate) fn check(self) -> Result<(), Fault> {
        RADII.check("filter_radius", self.radius)
    }

    /// How far beyond a film light counts for its pixels.
    pub fn margin(self) -> f32 {
        self.radius - 0.5
    }
}

impl Default for Filter {
    fn default() -> Self {
        Self::PIXEL
    }
}

impl fmt::Display for Filter {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{}, radius {}", self.kind.name(), self.radius)
    }
}

/// A filter along one axis, as a table: linear from node to node, for drawing and for weighing
/// alike, so that both mean the same filter to the last bit of it. It is even, and integrates to
/// one.
#[derive(Clone, Debug)]
pub struct Profile {
    radius: f32,
    /// Magnitudes at the nodes, from the center to the end.
    magnitudes: [f32; PIECES + 1],
    /// Whether a piece is negative.
    negative: [bool; PIECES],
    /// The integral of the magnitude from the center to each node, of which the last is 1.
    shares: [f32; PIECES + 1],
    /// The integral of the magnitude: one without negative lobes.
    gain: f32,
}

impl Profile {
    /// The table of a filter; none for the square of a pixel, which needs no table.
    pub fn new(filter: Filter) -> Option<Self> {
        (filter != Filter::PIXEL).then(|| Self::of(filter.radius, |share| filter.kind.value(share)))
    }

    /// The table of an even function, by its values, up to a factor, at shares of the radius.
    pub fn of(radius: f32, value: impl Fn(f64) -> f64) -> Self {
        let nodes: Vec<f64> = (0..=PIECES).map(|node| value(node as f64 / PIECES as f64)).collect();
        let areas: Vec<f64> =
            nodes.windows(2).map(|ends| 0.5 * (ends[0].abs() + ends[1].abs())).collect();
        let negative: [bool; PIECES] =
            std::array::from_fn(|piece| nodes[piece] + nodes[piece + 1] < 0.0);
        let signed: f64 =
            areas.iter().zip(negative).map(|(area, is)| if is { -area } else { *area }).sum();
        let total: f64 = areas.iter().sum();
        let mut sum = 0.0;
        let mut shares = [0.0; PIECES + 1];
        for (share, area) in shares[1..].iter_mut().zip(&areas) {
            sum += area;
            *share = (sum / total) as f32;
        }
        // Both halves of it, over pieces of this width, integrate to one.
        let scale = PIECES as f64 / (2.0 * signed * f64::from(radius));
        let magnitudes = std::array::from_fn(|node| (nodes[node].abs() * scale) as f32);
        let gain = (total / signed) as f32;
        Self { radius, magnitudes, negative, shares, gain }
    }

    /// Its radius in pixels.
    pub fn radius(&self) -> f32 {
        self.radius
    }

    /// Whether samples count by other weights than one.
    pub fn is_signed(&self) -> bool {
        self.negative.contains(&true)
    }

    /// Where a number in [0, 1) puts a sample, in pixels from the center, and what it counts.
    pub fn draw(&self, number: f32) -> (f32, f32) {
        let centered = 2.0 * number - 1.0;
        let share = centered.abs();
        let piece = self.shares[1..PIECES].partition_point(|&end| end <= share);
        let [start, end] = [self.shares[piece], self.shares[piece + 1]];
        let [from, to] = [self.magnitudes[piece], self.magnitudes[piece + 1]];
        // Of the piece's area, which is that of a trapezoid.
        let part =
            if end > start { ((share - start) / (end - start)).clamp(0.0, 1.0) } else { 0.5 };
        let area = part * (from + to);
        let root = (from * from + area * (to - from)).max(0.0).sqrt();
        let way = if from + root > 0.0 { (area / (from + root)).min(1.0) } else { part };
        let offset = (piece as f32 + way) * (self.radius / PIECES as f32);
        let weight = if self.negative[piece] { -self.gain } else { self.gain };
        (offset.copysign(centered), weight)
    }

    /// Its value at a distance from the center in pixels, per pixel.
    pub fn at(&self, offset: f32) -> f32 {
        let place = offset.abs() * (PIECES as f32 / self.radius);
        let piece = place as usize;
        if piece >= PIECES {
            return 0.0;
        }
        let [from, to] = [self.magnitudes[piece], self.magnitudes[piece + 1]];
        let magnitude = from + (to - from) * (place - piece as f32);
        if self.negative[piece] { -magnitude } else { magnitude }
    }

    /// The pixel that light at a point of a row counts for, and how much of it: one of those whose
    /// filters reach there, by a number in [0, 1); the row goes on without end either way.
    pub fn pixel_of(&self, point: f32, number: f32) -> Option<(i32, f32)> {
        let first = (point - 0.5 - self.radius).ceil() as i32;
        let last = (point - 0.5 + self.radius).floor() as i32;
        let at = |pixel: i32| self.at(pixel as f32 + 0.5 - point);
        let sum: f32 = (first..=last).map(|pixel| at(pixel).abs()).sum();
        let mut left = number * sum;
        let mut chosen = None;
        for pixel in first..=last {
            let value = at(pixel);
            if value == 0.0 {
                continue;
            }
            chosen = Some((pixel, sum.copysign(value)));
            left -= value.abs();
            if left < 0.0 {
                break;
            }
        }
        chosen
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn profiles() -> impl Iterator<Item = (Filter, Profile)> {
        let radii = |kind: FilterKind| [kind.radius(), 0.3, 1.7, 9.0].map(move |it| (kind, it));
        let filters = FilterKind::ALL.into_iter().flat_map(radii);
        filters.filter_map(|(kind, radius)| {
            let filter = Filter { kind, radius };
            Some((filter, Profile::new(filter)?))
        })
    }

    /// The published formulas, written otherwise: pieces of polynomials, normalized by hand.
    #[test]
    fn profiles_are_the_formulas() {
        let mitchell = Profile::new(Filter::of(FilterKind::Mitchell)).unwrap();
        let catmull = Profile::new(Filter::of(FilterKind::CatmullRom)).unwrap();
        let lanczos = Profile::new(Filter::of(FilterKind::Lanczos)).unwrap();
        let tent = Profile::new(Filter::of(FilterKind::Tent)).unwrap();
        let gaussian = Profile::new(Filter::of(FilterKind::Gaussian)).unwrap();
        // Each half is erf(4 / sqrt 2) sqrt(pi / 2) / 2, less what is cut off.
        let area = 2.0 * (0.626_657_07 * 0.999_936_66 - 2.0 * (-8.0_f64).exp());
        for step in 0..200 {
            let x = f64::from(step) / 100.0;
            let close = |profile: &Profile, expected: f64| {
                let value = f64::from(profile.at(x as f32));
                assert!((value - expected).abs() < 2e-5, "{x}: {value}, not {expected}");
            };
            // 8/9 - 2 x^2 + 7/6 x^3, and 16/9 - 10/3 x + 2 x^2 - 7/18 x^3 beyond 1.
            close(
                &mitchell,
                match x < 1.0 {
                    true => 8.0 / 9.0 + x * x * (-2.0 + x * 7.0 / 6.0),
                    false => 16.0 / 9.0 + x * (-10.0 / 3.0 + x * (2.0 - x * 7.0 / 18.0)),
                },
            );
            close(
                &catmull,
                match x < 1.0 {
                    true => 1.0 - 2.5 * x * x + 1.5 * x * x * x,
                    false => 2.0 - 4.0 * x + 2.5 * x * x - 0.5 * x * x * x,
                },
            );
            close(&tent, (1.0 - x).max(0.0));
            close(&gaussian, ((-2.0 * x * x).exp() - (-8.0_f64).exp()) / area);
            let angle = std::f64::consts::PI * x;
            let windowed = 3.0 * angle.sin() * (angle / 3.0).sin() / (angle * angle);
            // Its integral, summed over 200,000 pieces elsewhere.
            let expected = if x == 0.0 { 1.0 } else { windowed } / 0.997_055;
            close(&lanczos, expected);
        }
    }

    /// Moments of what is drawn, with its weights, are those of the filter by a sum over it.
    #[test]
    fn samples_are_drawn_by_the_filter() {
        const DRAWS: u32 = 1 << 14;
        for (filter, profile) in profiles() {
            let mut drawn = [0.0_f64; 4];
            for draw in 0..DRAWS {
                let (x, weight) = profile.draw((draw as f32 + 0.5) / DRAWS as f32);
                assert!(x.abs() <= filter.radius, "{filter}: {x}");
                assert_eq!(profile.at(x) < 0.0, weight < 0.0, "{filter} at {x}");
                let x = f64::from(x / filter.radius);
                for (power, sum) in drawn.iter_mut().enumerate() {
                    *sum += f64::from(weight) * x.powi(power as i32) / f64::from(DRAWS);
                }
            }
            let mut summed = [0.0_f64; 4];
            for step in 0..DRAWS {
                let x = (2.0 * f64::from(step) + 1.0) / f64::from(DRAWS) - 1.0;
                let value = f64::from(profile.at(x as f32 * filter.radius));
                let width = 2.0 * f64::from(filter.radius) / f64::from(DRAWS);
                for (power, sum) in summed.iter_mut().enumerate() {
                    *sum += value * width * x.powi(power as i32);
                }
            }
            for power in 0..4 {
                let [drawn, summed] = [drawn[power], summed[power]];
                assert!((drawn - summed).abs() < 3e-4, "{filter}, x^{power}: {drawn} {summed}");
            }
            assert!((summed[0] - 1.0).abs() < 1e-4, "{filter}: {}", summed[0]);
        }
    }

    /// What light at a point counts for pixels is the filter about each, on the average.
    #[test]
    fn light_counts_for_pixels_by_the_filter() {
        const DRAWS: u32 = 4096;
        for (filter, profile) in profiles() {
            for point in [0.0, 0.2, 3.5, -7.9, 100.25, 100.999] {
                let mut counted = std::collections::BTreeMap::<i32, f64>::new();
                for draw in 0..DRAWS {
                    let number = (draw as f32 + 0.5) / DRAWS as f32;
                    if let Some((pixel, weight)) = profile.pixel_of(point, number) {
                        *counted.entry(pixel).or_default() += f64::from(weight) / f64::from(DRAWS);
                    }
                }
                let reach = filter.radius.ceil() as i32 + 1;
                let middle = point.floor() as i32;
                for pixel in middle - reach..=middle + reach {
                    let expected = f64::from(profile.at(pixel as f32 + 0.5 - point));
                    let found = counted.get(&pixel).copied().unwrap_or(0.0);
                    let sum: f64 = counted.values().map(|it| it.abs()).sum();
                    let error = (found - expected).abs();
                    assert!(error <= 2.0 * sum / f64::from(DRAWS), "{filter} at {point}: {pixel}");
                }
            }
        }
    }

    #[test]
    fn radii_are_of_some_pixels() {
        for radius in [f32::NAN, f32::INFINITY, 0.0, -1.0, 33.0] {
            let error = Filter { kind: FilterKind::Tent, radius }.check().unwrap_err();
            assert!(error.to_string().contains("from 0.01 to 32 pixels"), "{error}");
        }
        assert!(FilterKind::ALL.into_iter().all(|kind| Filter::of(kind).check().is_ok()));
        assert!(Profile::new(Filter::PIXEL).is_none());
    }
}
