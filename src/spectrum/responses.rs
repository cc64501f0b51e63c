//! How strongly the channels of a film respond to light, by wavelength.

use wide::f32x4;

use super::cie::VISIBLE_NM;
use super::color_space::RgbResponse;
use super::{Band, Bands, Color, WhiteBalance};
use crate::math::Fault;

/// Where the points of Gauss and Legendre's rule are, as a share of the width from the middle:
/// 1 / sqrt(12).
const GAUSS: f64 = 0.288_675_134_594_812_9;

/// The response of one channel: linear between its nodes, zero outside of them. At two nodes of one
/// wavelength it jumps from the first to the second.
#[derive(Clone, Debug, PartialEq)]
pub struct Response {
    /// Wavelengths in nanometers, in order, and values per nanometer.
    nodes: Vec<[f64; 2]>,
}

/// The responses of all channels of a film, in their order. Any set of them may be one, with
/// negative values too; the value of a channel is the integral of radiance times response.
#[derive(Clone, Debug, PartialEq)]
pub struct Responses {
    list: Vec<Response>,
}

/// What a channel takes of each column of the transport.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taken<const N: usize> {
    /// The channel.
    pub channel: usize,
    /// Factors of the columns, not all of them zero.
    pub shares: [f32; N],
}

impl<const N: usize> Taken<N> {
    /// What it takes of values in the columns.
    #[inline(always)]
    pub fn of(&self, columns: &[f32; N]) -> f32 {
        let mut parts = *columns;
        parts.iter_mut().zip(&self.shares).for_each(|(part, share)| *part *= share);
        // By halves, which are added side by side.
        let mut count = N;
        while count > 1 {
            let half = count.div_ceil(2);
            for index in half..count {
                parts[index - half] += parts[index];
            }
            count = half;
        }
        parts[0]
    }

    /// The same of the Stokes vectors in the columns.
    #[inline(always)]
    pub fn of_each(&self, columns: &[f32x4; N]) -> f32x4 {
        let mut sum = f32x4::ZERO;
        for (share, column) in self.shares.iter().zip(columns) {
            sum = column.mul_add(f32x4::splat(*share), sum);
        }
        sum
    }
}

impl Response {
    /// That of nodes: wavelengths in nanometers, not decreasing, and finite values.
    ///
    /// # Errors
    /// When there are fewer than two, or they are out of order or not finite.
    pub fn new(nodes: Vec<[f64; 2]>) -> Result<Self, Fault> {
        let fault = |problem: &str| Err(Fault::new("response", problem, ""));
        if nodes.len() < 2 {
            return fault("needs two wavelengths or more");
        }
        if !nodes.as_flattened().iter().all(|number| number.is_finite()) {
            return fault("needs finite numbers");
        }
        if !nodes.is_sorted_by(|a, b| a[0] <= b[0]) {
            return fault("needs wavelengths in increasing order");
        }
        Ok(Self { nodes })
    }

    /// That of nodes which are in order and finite, two at least.
    pub(super) fn between_nodes(nodes: Vec<[f64; 2]>) -> Self {
        debug_assert!(nodes.len() >= 2 && nodes.is_sorted_by(|a, b| a[0] <= b[0]));
        Self { nodes }
    }

    /// The mean over a band.
    pub fn of_band(band: &Band) -> Self {
        let [first, last] = band.ends_nm();
        let value = 1.0 / (last - first);
        Self { nodes: vec![[first, 0.0], [first, value], [last, value], [last, 0.0]] }
    }

    /// Whether it is below zero somewhere.
    pub fn is_signed(&self) -> bool {
        self.nodes.iter().any(|[_, value]| *value < 0.0)
    }

    /// The value at a wavelength in nanometers; where it jumps, the second.
    pub fn at(&self, nm: f64) -> f64 {
        self.between(self.nodes.partition_point(|[at, _]| *at <= nm), nm)
    }

    /// The value just before a wavelength.
    pub fn before(&self, nm: f64) -> f64 {
        self.between(self.nodes.partition_point(|[at, _]| *at < nm), nm)
    }

    /// The integral over a range of it times a spectrum, of which `knots` are the wavelengths where
    /// it bends or jumps, in order; all in nanometers. Exact where the spectrum is a polynomial of
    /// the second degree between them.
    pub fn integral(
        &self,
        range_nm: [f64; 2],
        knots: &[f64],
        spectrum: impl Fn(f64) -> f64,
    ) -> f64 {
        // Steps between knots, and the most in a segment.
        const STEP_NM: f64 = 2.0;
        const STEPS_MAX: f64 = 1000.0;
        let mut sum = 0.0;
        for nodes in self.nodes.windows(2) {
            let [from, to] = [nodes[0][0].max(range_nm[0]), nodes[1][0].min(range_nm[1])];
            let slope = (nodes[1][1] - nodes[0][1]) / (nodes[1][0] - nodes[0][0]);
            let within = knots.partition_point(|nm| *nm <= from);
            let within = knots[within..].iter().copied().take_while(|nm| *nm < to);
            let mut start = from;
            for end in within.chain([to]).filter(|end| *end > from) {
                let steps = ((end - start) / STEP_NM).ceil().clamp(1.0, STEPS_MAX);
                let width = (end - start) / steps;
                for step in 0..steps as u32 {
                    // Gauss and Legendre's rule of two points, which are within: a jump at an end
                    // has the value of its side.
                    let middle = start + (f64::from(step) + 0.5) * width;
                    for at in [middle - width * GAUSS, middle + width * GAUSS] {
                        let value = nodes[0][1] + slope * (at - nodes[0][0]);
                        sum += 0.5 * width * value * spectrum(at);
                    }
                }
                start = end;
            }
        }
        sum
    }

    /// The first and the last wavelength within a range between which it is not zero, in
    /// nanometers; none if it is zero there.
    pub(super) fn ends_within(&self, [first, last]: [f64; 2]) -> Option<[f64; 2]> {
        let segments = || {
            self.nodes.windows(2).filter_map(|nodes| {
                let ends = [nodes[0][0].max(first), nodes[1][0].min(last)];
                let is_lit = nodes[0][1] != 0.0 || nodes[1][1] != 0.0;
                (is_lit && ends[0] < ends[1]).then_some(ends)
            })
        };
        Some([segments().next()?[0], segments().next_back()?[1]])
    }

    /// The value on the line from the node before `upper` to that.
    fn between(&self, upper: usize, nm: f64) -> f64 {
        let Some([from_nm, from]) = upper.checked_sub(1).map(|lower| self.nodes[lower]) else {
            return 0.0;
        };
        let Some([to_nm, to]) = self.nodes.get(upper) else { return 0.0 };
        let share = (nm - from_nm) / (to_nm - from_nm);
        from * (1.0 - share) + to * share
    }
}

impl Responses {
    /// Of some channels.
    pub fn new(list: Vec<Response>) -> Self {
        Self { list }
    }

    /// Those of the channels of a film on which spectra of a range in nanometers are measured: of
    /// red, green and blue, what the CIE 1931 observer sees of them, which is negative in part, so
    /// that daylight of luminance 1 is (1, 1, 1), or another `white` of luminance 1. None of one
    /// wavelength.
    ///
    /// # Errors
    /// When red, green and blue cannot be balanced to that white.
    pub fn of(
        color: &Color,
        range_nm: [f32; 2],
        white: Option<&WhiteBalance>,
    ) -> Result<Option<Self>, Fault> {
        Ok(match color {
            Color::Bands(bands) => Some(Self::of_bands(bands)),
            Color::Responses(curves) => Some(curves.responses()),
            Color::Rgb => Some(Self::of_rgb(&match white {
                Some(white) => white.rgb_response(range_nm)?,
                None => RgbResponse::new(),
            })),
            Color::Mono { .. } => None,
        })
    }

    fn of_rgb(response: &RgbResponse) -> Self {
        let [first, last] = VISIBLE_NM.map(|nm| nm as u32);
        let nodes = |channel: usize| {
            let node = |nm: u32| [f64::from(nm), response.at(f64::from(nm))[channel]];
            Response { nodes: (first..=last).map(node).collect() }
        };
        Self { list: (0..3).map(nodes).collect() }
    }

    /// All of them.
    pub fn list(&self) -> &[Response] {
        &self.list
    }

    /// Of bands, each the mean over its width.
    pub fn of_bands(bands: &Bands) -> Self {
        Self { list: bands.list().iter().map(Response::of_band).collect() }
    }

    /// The sum of the sizes of all at a wavelength in nanometers.
    pub fn size_at(&self, nm: f64) -> f64 {
        self.list.iter().map(|response| response.at(nm).abs()).sum()
    }

    /// The same just before a wavelength.
    pub fn size_before(&self, nm: f64) -> f64 {
        self.list.iter().map(|response| response.before(nm).abs()).sum()
    }

    /// The share that each channel has in the sum of the sizes of all at a wavelength in
    /// nanometers; zeros where there is none.
    pub fn parts_at(&self, nm: f64) -> Vec<f64> {
        let sizes: Vec<f64> = self.list.iter().map(|response| response.at(nm).abs()).collect();
        let all: f64 = sizes.iter().sum();
        sizes.into_iter().map(|size| if all > 0.0 { size / all } else { 0.0 }).collect()
    }

    /// Every wavelength at which some response bends or jumps, in nanometers.
    pub fn nodes_nm(&self) -> impl Iterator<Item = f64> {
        self.list.iter().flat_map(|response| response.nodes.iter().map(|[nm, _]| *nm))
    }

    /// What the channels take of columns at some wavelengths, which were drawn with these densities
    /// per nanometer: of each a share of the integral that the others do not have.
    pub fn taken<const N: usize>(
        &self,
        wavelengths_nm: &[f32; N],
        densities: &[f64; N],
    ) -> Vec<Taken<N>> {
        let of = |(channel, response): (usize, &Response)| {
            let share = |column: usize| {
                let value = response.at(f64::from(wavelengths_nm[column]));
                if value == 0.0 { 0.0 } else { value / (N as f64 * densities[column]) }
            };
            let shares = std::array::from_fn(|column| share(column) as f32);
            (shares != [0.0; N]).then_some(Taken { channel, shares })
        };
        self.list.iter().enumerate().filter_map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_band_is_a_mean() {
        let response = Response::of_band(&Band::new(550.0, 10.0));
        assert_eq!((response.at(545.0), response.at(550.0), response.at(554.9)), (0.1, 0.1, 0.1));
        assert_eq!((response.at(544.9), response.at(555.0), response.at(600.0)), (0.0, 0.0, 0.0));
        assert_eq!((response.before(545.0), response.before(555.0)), (0.0, 0.1));
    }

    #[test]
    fn integrals_are_those_of_calculus() {
        let response = Response::new(vec![[400.0, 0.0], [500.0, 1.0], [600.0, -1.0]]).unwrap();
        let near = |found: f64, expected: f64| {
            assert!((found - expected).abs() < 1e-9 * expected.abs().max(1.0), "{found}");
        };
        near(response.integral([0.0, 1e9], &[], |_| 1.0), 50.0);
        near(response.integral([450.0, 500.0], &[], |_| 1.0), 37.5);
        near(response.integral([550.0, 900.0], &[], |_| 2.0), -50.0);
        // The integral of (x - 400) / 100 x^2.
        let antiderivative = |x: f64| (x.powi(4) / 4.0 - 400.0 * x.powi(3) / 3.0) / 100.0;
        let expected = antiderivative(500.0) - antiderivative(400.0);
        near(response.integral([400.0, 500.0], &[], |nm| nm * nm), expected);
        // A jump between nodes, and a line of a tenth of a nanometer.
        let step = |nm: f64| if nm < 433.3 { 0.0 } else { 1.0 };
        near(response.integral([400.0, 500.0], &[433.3], step), 50.0 - 0.5 * 33.3 * 0.333);
        let line = |nm: f64| if (450.0..450.1).contains(&nm) { 10.0 } else { 0.0 };
        near(response.integral([400.0, 600.0], &[450.0, 450.1], line), 0.5005);
        for empty in [[300.0, 390.0], [600.0, 700.0], [500.0, 450.0]] {
            assert_eq!(response.integral(empty, &[420.0, 500.0], |_| 1.0), 0.0);
        }
    }

    #[test]
    fn the_ends_of_a_response_are_those_of_what_is_not_zero() {
        let nodes = vec![[400.0, 0.0], [450.0, 0.0], [500.0, 1.0], [550.0, 0.0], [600.0, 0.0]];
        let response = Response::new(nodes).unwrap();
        assert_eq!(response.ends_within([300.0, 700.0]), Some([450.0, 550.0]));
        assert_eq!(response.ends_within([460.0, 510.0]), Some([460.0, 510.0]));
        assert_eq!(response.ends_within([550.0, 700.0]), None);
    }

    #[test]
    fn responses_are_linear_between_their_nodes() {
        let response = Response::new(vec![[400.0, 0.0], [500.0, 1.0], [600.0, -1.0]]).unwrap();
        assert_eq!((response.at(450.0), response.at(500.0), response.at(575.0)), (0.5, 1.0, -0.5));
        assert_eq!((response.at(399.0), response.at(600.0)), (0.0, 0.0));
        assert!(Response::new(vec![[400.0, 0.0]]).is_err());
        assert!(Response::new(vec![[400.0, 0.0], [399.0, 0.0]]).is_err());
        assert!(Response::new(vec![[400.0, 0.0], [500.0, f64::NAN]]).is_err());
    }
}
