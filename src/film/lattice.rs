//! Samples that count for all pixels whose filters reach them.
//!
//! The samples of one iteration stand in a lattice, one in each pixel and all at the same place of
//! it, and a pixel is the mean over those about it, weighted by its filter. With `u` the place, of
//! the density `W(u)`, the sum of the filter over a lattice, the weights `f(k + u) / W(u)` sum to
//! one in every iteration: an even picture is even after the first, and the mean over iterations is
//! that by the filter. What a sample of the pixel alone would say of them (filter importance
//! sampling) is replaced by its expectation over the pixels of the lattice, so that a pixel has as
//! many samples as its filter covers, and neighbors have most of them in common.

use super::filter::{Filter, Profile};

/// Least sum of a filter with negative lobes over a lattice, of which the mean is one: where it is
/// less, lobes that should cancel count for much.
const SUM_MIN: f64 = 0.5;
/// Places at which that is looked at.
const PLACES: u16 = 64;

/// How far beyond its pixel a sample counts, in pixels.
pub fn reach(filter: Filter) -> u32 {
    (filter.radius - 0.5).ceil().max(0.0) as u32
}

/// A filter over lattices.
#[derive(Clone, Debug)]
pub struct Lattice {
    profile: Profile,
    /// Where lattices stand, from the middles of pixels; where the filter is positive, it says so
    /// itself.
    places: Option<Profile>,
    reach: u32,
}

/// Where the lattice of an iteration stands, and what its samples count.
#[derive(Clone, Debug)]
pub struct Shift {
    /// From the left and upper edges of each pixel to its sample, in pixels.
    pub place: [f32; 2],
    /// By axis, what a sample counts for the pixel so many before or behind its own: from those
    /// [`reach`] before it on.
    pub weights: [Vec<f32>; 2],
}

impl Lattice {
    /// The lattices of a filter; none where samples are better each pixel's own, as filters end
    /// within pixels, or lobes of both signs hardly cancel.
    pub fn new(filter: Filter) -> Option<Self> {
        let profile = Profile::new(filter).filter(|_| filter.radius > 0.5)?;
        let is_signed = profile.is_signed();
        let lattice = Self { profile, places: None, reach: reach(filter) };
        if !is_signed {
            return Some(lattice);
        }
        let sum = |share: f64| f64::from(lattice.sum((0.5 + 0.5 * share) as f32));
        let is_enough = |step| sum(f64::from(step) / f64::from(PLACES)) >= SUM_MIN;
        let places = (0..=PLACES).all(is_enough).then(|| Profile::of(0.5, sum))?;
        Some(Self { places: Some(places), ..lattice })
    }

    /// The lattice that two numbers in [0, 1) say.
    pub fn shift(&self, numbers: [f32; 2]) -> Shift {
        let [(x, of_x), (y, of_y)] = numbers.map(|number| self.along(number));
        Shift { place: [x, y], weights: [of_x, of_y] }
    }

    /// The same along one axis.
    fn along(&self, number: f32) -> (f32, Vec<f32>) {
        let (from_middle, _) = self.places.as_ref().unwrap_or(&self.profile).draw(number);
        let from_edge = from_middle + 0.5;
        // Tables end at the edges.
        let place = (from_edge - from_edge.floor()).clamp(f32::EPSILON, 1.0 - f32::EPSILON);
        let density = match &self.places {
            Some(places) => places.at(place - 0.5),
            None => self.sum(place),
        };
        (place, self.values(place).map(|value| value / density).collect())
    }

    /// The filters of the pixels about a sample, at it.
    fn values(&self, place: f32) -> impl Iterator<Item = f32> {
        let reach = self.reach as i32;
        (-reach..=reach).map(move |pixel| self.profile.at(pixel as f32 + 0.5 - place))
    }

    fn sum(&self, place: f32) -> f32 {
        self.values(place).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::filter::FilterKind;

    /// Means over places are the filter: its moments about the middle of a pixel, and one in all.
    #[test]
    fn lattices_are_the_filter_on_the_average() {
        const PLACES: u32 = 1 << 14;
        for kind in FilterKind::ALL {
            for radius in [kind.radius(), 0.6, 1.0, 2.0, 3.0, 5.5] {
                let filter = Filter { kind, radius };
                let Some(lattice) = Lattice::new(filter) else { continue };
                let profile = Profile::new(filter).unwrap();
                let reach = reach(filter) as i32;
                let (mut met, mut expected) = ([0.0; 3], [0.0; 3]);
                for step in 0..PLACES {
                    let number = (step as f32 + 0.5) / PLACES as f32;
                    let Shift { place: [place, _], weights: [weights, _] } =
                        lattice.shift([number; 2]);
                    assert_eq!(weights.len() as i32, 2 * reach + 1, "{filter}");
                    for (pixel, weight) in (-reach..=reach).zip(weights) {
                        let at = f64::from(pixel as f32 + 0.5 - place);
                        for (power, met) in met.iter_mut().enumerate() {
                            *met += f64::from(weight) * at.powi(2 * power as i32);
                        }
                    }
                    let at = (2.0 * number - 1.0) * radius;
                    let value = f64::from(2.0 * radius * profile.at(at));
                    for (power, expected) in expected.iter_mut().enumerate() {
                        *expected += value * f64::from(at).powi(2 * power as i32);
                    }
                }
                for (met, expected) in met.into_iter().zip(expected) {
                    let [met, expected] = [met, expected].map(|sum| sum / f64::from(PLACES));
                    let scale = expected.abs().max(1.0);
                    assert!((met - expected).abs() < 1e-3 * scale, "{filter}: {met}, {expected}");
                }
            }
        }
    }

    /// An even picture is even in every iteration.
    #[test]
    fn weights_sum_to_one() {
        for kind in FilterKind::ALL {
            for radius in [0.51, 0.7, 1.0, 2.0, 3.3, 32.0] {
                let Some(lattice) = Lattice::new(Filter { kind, radius }) else {
                    assert!(radius <= 1.0, "{kind:?} {radius}");
                    continue;
                };
                for number in [0.0, 1e-7, 0.2, 0.5, 0.75, 0.999, 1.0 - 1e-7] {
                    let Shift { place, weights } = lattice.shift([number, 1.0 - number]);
                    assert!(place.iter().all(|at| (0.0..1.0).contains(at)), "{kind:?} {place:?}");
                    for weights in weights {
                        let sum: f32 = weights.iter().sum();
                        assert!((sum - 1.0).abs() < 1e-4, "{kind:?} {radius}: {sum}");
                    }
                }
            }
        }
    }

    #[test]
    fn some_filters_have_nothing_to_share() {
        let of = |kind, radius| Lattice::new(Filter { kind, radius });
        assert!(Lattice::new(Filter::PIXEL).is_none());
        assert!(of(FilterKind::Gaussian, 0.5).is_none());
        for (kind, none, some) in [
            (FilterKind::Mitchell, 1.0, 1.4),
            (FilterKind::CatmullRom, 1.0, 1.4),
            (FilterKind::Lanczos, 1.5, 1.9),
        ] {
            assert!(of(kind, none).is_none(), "{kind:?}");
            assert!(of(kind, some).is_some(), "{kind:?}");
            assert!(Lattice::new(Filter::of(kind)).is_some(), "{kind:?}");
        }
    }
}
