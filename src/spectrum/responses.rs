//! How strongly the channels of a film respond to light, by wavelength.

use super::cie::VISIBLE_NM;
use super::color_space::RgbResponse;
use super::{Band, Bands, Color};
use crate::math::Fault;

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

    /// The mean over a band.
    pub fn of_band(band: &Band) -> Self {
        let [first, last] = band.ends_nm();
        let value = 1.0 / (last - first);
        Self { nodes: vec![[first, 0.0], [first, value], [last, value], [last, 0.0]] }
    }

    /// The value at a wavelength in nanometers; where it jumps, the second.
    pub fn at(&self, nm: f64) -> f64 {
        self.between(self.nodes.partition_point(|[at, _]| *at <= nm), nm)
    }

    /// The value just before a wavelength.
    pub fn before(&self, nm: f64) -> f64 {
        self.between(self.nodes.partition_point(|[at, _]| *at < nm), nm)
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

    /// Those of the channels of a film on which spectra are measured: of red, green and blue, what
    /// the CIE 1931 observer sees of them, which is negative in part, so that daylight of luminance
    /// 1 is (1, 1, 1). None of one wavelength.
    pub fn of(color: &Color) -> Option<Self> {
        match color {
            Color::Bands(bands) => Some(Self::of_bands(bands)),
            Color::Rgb => Some(Self::of_rgb()),
            Color::Mono { .. } => None,
        }
    }

    fn of_rgb() -> Self {
        let response = RgbResponse::new();
        let [first, last] = VISIBLE_NM.map(|nm| nm as u32);
        let nodes = |channel: usize| {
            let node = |nm: u32| [f64::from(nm), response.at(f64::from(nm))[channel]];
            Response { nodes: (first..=last).map(node).collect() }
        };
        Self { list: (0..3).map(nodes).collect() }
    }

    fn of_bands(bands: &Bands) -> Self {
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
    fn responses_are_linear_between_their_nodes() {
        let response = Response::new(vec![[400.0, 0.0], [500.0, 1.0], [600.0, -1.0]]).unwrap();
        assert_eq!((response.at(450.0), response.at(500.0), response.at(575.0)), (0.5, 1.0, -0.5));
        assert_eq!((response.at(399.0), response.at(600.0)), (0.0, 0.0));
        assert!(Response::new(vec![[400.0, 0.0]]).is_err());
        assert!(Response::new(vec![[400.0, 0.0], [399.0, 0.0]]).is_err());
        assert!(Response::new(vec![[400.0, 0.0], [500.0, f64::NAN]]).is_err());
    }
}
