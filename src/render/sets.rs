//! Sets of wavelengths: what each iteration of a spectral render is rendered at, and what of it
//! reaches the channels of the film.
//!
//! An iteration has one set, which all pixels and both sides share, so that photons can be merged
//! and vertices connected. Its wavelengths are `P^-1((i + u) / N)`, where P is the cumulated
//! density by which wavelengths are chosen ([`Density`]) and u is the first number of a Sobol'
//! sequence over the iterations, shifted by the seed (Wilkie et al. 2014, "Hero wavelength spectral
//! sampling", with one hero for all pixels). So the set is a function of the iteration's number,
//! seed and replicate. The second number says which of the wavelengths comes first: the one that
//! paths go on at where light disperses.

use std::sync::Arc;

use rayon::prelude::*;

use super::settings::SettingsError;
use super::spectral::Spectral;
use crate::math::U32s;
use crate::math::hash::mix;
use crate::scattering::Scene;
use crate::scene::baked::{Optics, Shapes};
use crate::scene::{
    Brightness, Common, Emitters, SceneError, Suspensions, World, bake_emission, bake_emitters,
    bake_optics_at, held_spectra, lamps,
};
use crate::spectrum::density::{Density, integral, nodes_nm};
use crate::spectrum::{Beyond, Carried, Responses, Taken, White};
use crate::transport::sampler::sobol_second;

/// What an iteration is rendered with.
pub struct Iteration<const N: usize> {
    /// The scene at its wavelengths.
    pub scene: Arc<Scene<N>>,
    /// What the film takes of it.
    pub film: Projection<N>,
}

/// What the channels of a film take of the columns of the transport.
pub enum Projection<const N: usize> {
    /// Each the column of its place.
    Columns,
    /// Some of them shares of all.
    Shares(Shares<N>),
}

/// What channels take of wavelengths.
pub struct Shares<const N: usize> {
    /// Those that take anything.
    pub taken: Vec<Taken<N>>,
    /// How many channels there are.
    pub channels: usize,
    /// What each adds to the gauge of the film: how often the wavelengths fall into it, over how
    /// often they do so on the average.
    pub met: Vec<f32>,
}

/// What is the same in all iterations of a spectral render.
pub struct Spectra {
    world: Arc<World>,
    shapes: Arc<Shapes>,
    common: Common,
    /// Under which red, green and blue have the color that they say, and what spectra say beyond
    /// their ends.
    by: (White, Beyond),
    /// Which of them are held there.
    held: Vec<String>,
    responses: Responses,
    density: Density,
    /// The share of all wavelengths that fall into each channel.
    expected: Vec<Option<f64>>,
    /// First and last wavelength, as they may be asked for.
    ends_nm: [f32; 2],
    /// Whether any surface refracts light in other ways at other wavelengths.
    disperses: bool,
}

/// The iterations of a render.
#[derive(Clone)]
pub struct Sets<const N: usize> {
    /// The scene by which everything is chosen and learned that is the same in all of them; that
    /// of all, if light has the same wavelengths throughout.
    pub scene: Arc<Scene<N>>,
    /// The wavelengths, if they differ.
    pub spectra: Option<Arc<Spectra>>,
}

impl<const N: usize> Sets<N> {
    /// Of a scene whose columns are the channels of its film.
    pub fn fixed(scene: Arc<Scene<N>>) -> Self {
        Self { scene, spectra: None }
    }

    /// Whether every iteration has wavelengths of its own.
    pub fn differ(&self) -> bool {
        self.spectra.is_some()
    }

    /// The channels that respond to none of the wavelengths that light goes on at which disperses,
    /// in the first iterations of some seeds; none if nothing disperses light.
    pub fn unmeasured_if_dispersed(
        &self,
        count: u32,
        seeds: impl Iterator<Item = u32>,
    ) -> Vec<usize> {
        let Some(spectra) = self.spectra.as_ref().filter(|spectra| spectra.disperses) else {
            return Vec::new();
        };
        let responses = spectra.responses.list();
        let mut unmet: Vec<usize> = (0..responses.len()).collect();
        for (seed, index) in seeds.flat_map(|seed| (0..count).map(move |index| (seed, index))) {
            let first_nm = f64::from(spectra.set::<N>(index, seed)[0]);
            unmet.retain(|channel| responses[*channel].at(first_nm) == 0.0);
            if unmet.is_empty() {
                break;
            }
        }
        unmet
    }

    /// `count` iterations from `first` on, of the sequences of a seed. If they do not differ, one
    /// stands for all.
    pub fn iterations(&self, first: u32, count: u32, seed: u32) -> Vec<Iteration<N>> {
        let Some(spectra) = &self.spectra else {
            return vec![Iteration { scene: Arc::clone(&self.scene), film: Projection::Columns }];
        };
        let iterations = (0..count).into_par_iter();
        iterations.map(|index| spectra.iteration(&self.scene, first + index, seed)).collect()
    }
}

impl Spectra {
    /// Those of a world for a film of such responses, and what emits in it.
    ///
    /// # Errors
    /// When a spectrum does not cover the wavelengths, nothing emits, or the film responds to none
    /// of them.
    pub fn new(
        world: &Arc<World>,
        shapes: &Arc<Shapes>,
        (responses, spectral, by): (Responses, Spectral, (White, Beyond)),
    ) -> Result<(Self, Emitters), super::RenderError> {
        let lamps = lamps(world);
        let knots = lamps.iter().flat_map(|lamp| lamp.spectrum.knots_nm());
        let nodes = nodes_nm(&responses, spectral.range_nm, knots);
        let (Some(&first), Some(&last)) = (nodes.first(), nodes.last()) else {
            let rule = "has no light that the film responds to".to_owned();
            return Err(SettingsError { setting: "range", rule }.into());
        };
        let ends_nm = within([first, last]);
        let held = held_spectra(world, &carried(ends_nm, by))?;
        let emitted = Emitted { by_lamp: bake_emission(world, &lamps, &nodes, by)? };
        let emitters = bake_emitters(world, shapes, &emitted.brightness(&responses, &nodes))?;
        let all = emitted.together(&emitters, shapes, nodes.len());
        let density = Density::new(&responses, &nodes, &all);
        let spectra = Self {
            world: Arc::clone(world),
            shapes: Arc::clone(shapes),
            by,
            held,
            common: Common { lamps, suspensions: Suspensions::new(world, [first, last], by.1)? },
            expected: expected(&responses, &density),
            density,
            responses,
            ends_nm,
            disperses: world.disperses(),
        };
        Ok((spectra, emitters))
    }

    /// The scene that everything is learned by, at wavelengths from the first to the last: where a
    /// spectrum does not cover one, it is told here.
    pub fn base<const N: usize>(
        &self,
        emitters: Emitters,
        scene: impl FnOnce(Optics<N>) -> Scene<N>,
    ) -> Result<Scene<N>, SceneError> {
        let [first, last] = self.ends_nm;
        let at = |index: usize| first + (last - first) * (index as f32 / (N - 1) as f32);
        let wavelengths =
            std::array::from_fn(|index| if index + 1 == N { last } else { at(index) });
        let optics = self.optics(&carried(wavelengths, self.by), emitters)?;
        Ok(scene(Optics { held: self.held.clone(), ..optics }))
    }

    fn optics<const N: usize>(
        &self,
        carried: &Carried<N>,
        emitters: Emitters,
    ) -> Result<Optics<N>, SceneError> {
        bake_optics_at(&self.world, &self.shapes, carried, &self.common, emitters)
    }

    /// The wavelengths of an iteration in nanometers.
    fn set<const N: usize>(&self, index: u32, seed: u32) -> [f32; N] {
        let [first, last] = self.ends_nm;
        let (place, hero) = (place(index, seed), hero(index, seed, N));
        std::array::from_fn(|column| {
            let share = (((column + hero) % N) as f64 + place) / N as f64;
            (self.density.inverse(share) as f32).clamp(first, last)
        })
    }

    fn iteration<const N: usize>(&self, base: &Scene<N>, index: u32, seed: u32) -> Iteration<N> {
        let wavelengths: [f32; N] = self.set(index, seed);
        let densities = wavelengths.map(|nm| self.density.at(f64::from(nm)));
        let emitters = Emitters {
            rows: Arc::clone(&base.optics.emitters),
            patterns: Arc::clone(&base.optics.patterns),
            emitter_of_primitive: Arc::clone(&base.optics.emitter_of_primitive),
            skies: base.optics.skies.clone(),
        };
        let optics = self.optics(&carried(wavelengths, self.by), emitters);
        let optics = optics.expect("spectra cover what lies between the ends of the range");
        let taken = self.responses.taken(&wavelengths, &densities);
        let (channels, met) = (self.expected.len(), self.met(&wavelengths));
        Iteration {
            scene: Arc::new(base.with_optics(optics)),
            film: Projection::Shares(Shares { taken, channels, met }),
        }
    }

    /// How often some wavelengths fall into each channel, over how often they do on the average.
    fn met(&self, wavelengths_nm: &[f32]) -> Vec<f32> {
        let mut found = vec![0.0; self.expected.len()];
        for nm in wavelengths_nm {
            let parts = self.responses.parts_at(f64::from(*nm));
            found.iter_mut().zip(parts).for_each(|(found, part)| *found += part);
        }
        let count = wavelengths_nm.len() as f64;
        let over = |(found, expected): (f64, &Option<f64>)| match expected {
            Some(expected) if *expected > 0.0 => (found / (count * expected)) as f32,
            Some(_) => 0.0,
            None => 1.0,
        };
        found.into_iter().zip(&self.expected).map(over).collect()
    }
}

/// The share of all wavelengths that fall into each channel; nothing is asked of one whose response
/// has both signs, as what it measures does not follow how often it is met.
fn expected(responses: &Responses, density: &Density) -> Vec<Option<f64>> {
    let list = responses.list();
    let shares = density.means(list.len(), |nm| responses.parts_at(nm));
    let pairs = list.iter().zip(shares);
    pairs.map(|(response, share)| (!response.is_signed()).then_some(share)).collect()
}

/// One of many sets of wavelengths in nanometers.
fn carried<const N: usize>(wavelengths_nm: [f32; N], by: (White, Beyond)) -> Carried<N> {
    let (white, beyond) = by;
    Carried::set(wavelengths_nm).under(white).beyond(beyond)
}

/// Where the wavelengths of a set are within their N-th parts of all: from 0 to 1.
fn place(iteration: u32, seed: u32) -> f64 {
    f64::from(point(iteration, seed)[0]) / (1_u64 << 32) as f64
}

/// Which part of the set comes first: the one whose wavelength paths go on at that disperse.
fn hero(iteration: u32, seed: u32, count: usize) -> usize {
    ((u64::from(point(iteration, seed)[1]) * count as u64) >> 32) as usize
}

/// The point of an iteration in the square, of 2^32: of Sobol's sequence, shifted digit by digit.
/// Of 2^k iterations in a row, from a multiple of that on, there is one in each of 2^k rectangles
/// of one shape, so that the first wavelengths are as even as all are.
fn point(iteration: u32, seed: u32) -> [u32; 2] {
    let first = iteration.reverse_bits();
    let [second, ..] = sobol_second(U32s::splat(first)).to_array();
    [first ^ mix(seed ^ 0x5bec_7a1e), second ^ mix(seed ^ 0x1f83_d9ab)]
}

/// The same ends in single precision, none of them outside.
fn within([first, last]: [f64; 2]) -> [f32; 2] {
    let [low, high] = [first as f32, last as f32];
    let low = if f64::from(low) < first { low.next_up() } else { low };
    let high = if f64::from(high) > last { high.next_down() } else { high };
    [low, high]
}

/// What lamps emit at the nodes of a density.
struct Emitted {
    /// One row of values for every lamp; empty if it is black.
    by_lamp: Vec<Vec<f64>>,
}

impl Emitted {
    /// How bright each lamp is to the film.
    fn brightness(&self, responses: &Responses, nodes: &[f64]) -> Vec<Brightness> {
        let all = integral(responses, nodes, &vec![1.0; nodes.len()]);
        let mean = |values: &Vec<f64>| match values.is_empty() {
            true => 0.0,
            false => integral(responses, nodes, values) / all,
        };
        let means = self.by_lamp.iter().map(mean);
        means.map(|mean| Brightness { mean, rounded: mean as f32 }).collect()
    }

    /// What all of them emit together, at each node.
    fn together(&self, emitters: &Emitters, shapes: &Shapes, nodes: usize) -> Vec<f64> {
        let mut sizes = vec![0.0; self.by_lamp.len()];
        for emitter in &*emitters.rows {
            sizes[emitter.lamp as usize] += emitter.model.size(shapes);
        }
        let mut all = vec![0.0; nodes];
        for (values, size) in self.by_lamp.iter().zip(sizes) {
            all.iter_mut().zip(values).for_each(|(sum, value)| *sum += size * value);
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::{Bands, Response};

    /// The wavelengths of an iteration.
    fn set<const N: usize>(density: &Density, index: u32, seed: u32) -> [f32; N] {
        let place = place(index, seed);
        std::array::from_fn(|column| density.inverse((column as f64 + place) / N as f64) as f32)
    }

    /// The mean over many sets of what channels take of a spectrum.
    fn measured<const N: usize>(
        responses: &Responses,
        density: &Density,
        spectrum: impl Fn(f64) -> f64,
        channels: usize,
    ) -> Vec<f64> {
        const SETS: u32 = 20_000;
        let mut sums = vec![0.0; channels];
        for index in 0..SETS {
            let wavelengths: [f32; N] = set(density, index, 7);
            let densities = wavelengths.map(|nm| density.at(f64::from(nm)));
            for Taken { channel, shares } in responses.taken(&wavelengths, &densities) {
                let light = wavelengths.map(|nm| spectrum(f64::from(nm)));
                let products = shares.iter().zip(light).map(|(share, it)| f64::from(*share) * it);
                sums[channel] += products.sum::<f64>() / f64::from(SETS);
            }
        }
        sums
    }

    fn wavy(nm: f64) -> f64 {
        1.0 + 0.5 * (nm / 13.0).sin() + 0.001 * (nm - 500.0)
    }

    /// The mean of a spectrum over a band by ten thousand steps.
    fn mean_over([from, to]: [f64; 2], spectrum: impl Fn(f64) -> f64) -> f64 {
        const STEPS: u32 = 10_000;
        let at = |step: u32| from + (to - from) * (f64::from(step) + 0.5) / f64::from(STEPS);
        (0..STEPS).map(|step| spectrum(at(step))).sum::<f64>() / f64::from(STEPS)
    }

    #[test]
    fn iterations_cover_all_evenly() {
        const COUNT: u32 = 1024;
        for seed in [0, 1, 0xffff_ffff] {
            let mut places: Vec<f64> = (0..COUNT).map(|index| place(index, seed)).collect();
            places.sort_by(f64::total_cmp);
            for (stratum, place) in (0_u32..).zip(places) {
                assert_eq!((place * f64::from(COUNT)) as u32, stratum, "{seed}");
            }
        }
        let starts: Vec<f64> = (0..COUNT).map(|seed| place(0, seed)).collect();
        let mean = starts.iter().sum::<f64>() / f64::from(COUNT);
        assert!((mean - 0.5).abs() < 5.0 * (1.0 / 12.0_f64 / f64::from(COUNT)).sqrt(), "{mean}");
    }

    #[test]
    fn every_wavelength_is_the_first_equally_often() {
        // One in each of 64 parts of all that is chosen from.
        for (seed, count) in [(0, 4), (7, 8), (u32::MAX, 8)] {
            let at = |it| (hero(it, seed, count) as f64 + place(it, seed)) / count as f64;
            let mut found: Vec<usize> = (64..128).map(|it| (64.0 * at(it)) as usize).collect();
            found.sort_unstable();
            assert_eq!(found, (0..64).collect::<Vec<_>>());
        }
        // Of a few iterations, by all seeds.
        let first = |place: usize| (0..8000).filter(|&seed| hero(0, seed, 8) == place).count();
        assert!((0..8).all(|place| (850..1150).contains(&first(place))));
        // Whatever comes first, its place is even.
        let of_first = (0..4000).filter(|it| hero(*it, 5, 8) == 0).map(|it| place(it, 5));
        let mean = of_first.clone().sum::<f64>() / of_first.count() as f64;
        assert!((mean - 0.5).abs() < 0.01, "{mean}");
    }

    #[test]
    fn the_mean_of_what_is_taken_is_the_integral() {
        let broad = Bands::evenly(420.0, 680.0, 14).unwrap();
        let mut list = broad.list().to_vec();
        list.push(crate::spectrum::Band::new(700.0, 2.0));
        let bands = Bands::new(list).unwrap();
        let responses = Responses::of_bands(&bands);
        let nodes = nodes_nm(&responses, [380.0, 780.0], std::iter::empty());
        // Another spectrum than the one that is measured.
        let emitted: Vec<f64> = nodes.iter().map(|nm| (nm - 390.0) * 0.01).collect();
        let density = Density::new(&responses, &nodes, &emitted);
        for values in [
            measured::<4>(&responses, &density, wavy, 15),
            measured::<8>(&responses, &density, wavy, 15),
        ] {
            for (band, value) in bands.list().iter().zip(values) {
                let expected = mean_over(band.ends_nm(), wavy);
                assert!((value / expected - 1.0).abs() < 2e-3, "{band:?}: {value}, {expected}");
            }
        }
    }

    /// Two halves of a normal distribution, of other widths: what the CIE's functions are made of
    /// by Wyman, Sloan and Shirley 2013, "Simple analytic approximations to the CIE XYZ color
    /// matching functions".
    fn lobe(nm: f64, middle: f64, widths: [f64; 2]) -> f64 {
        let width = if nm < middle { widths[0] } else { widths[1] };
        (-0.5 * ((nm - middle) / width).powi(2)).exp()
    }

    fn matching(nm: f64) -> [f64; 3] {
        let x = 1.056 * lobe(nm, 599.8, [37.9, 31.0]) + 0.362 * lobe(nm, 442.0, [16.0, 26.7])
            - 0.065 * lobe(nm, 501.1, [20.4, 26.2]);
        let y = 0.821 * lobe(nm, 568.8, [46.9, 40.5]) + 0.286 * lobe(nm, 530.9, [16.3, 31.1]);
        let z = 1.217 * lobe(nm, 437.0, [11.8, 36.0]) + 0.681 * lobe(nm, 459.0, [26.0, 13.8]);
        [x, y, z]
    }

    /// Signed responses, such as those of linear sRGB: a gray under the light that they are made
    /// white by is that gray in all three.
    #[test]
    fn a_gray_under_the_white_of_signed_responses_is_gray() {
        const FROM_XYZ: [[f64; 3]; 3] =
            [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]];
        let row = |nm: f64, row: [f64; 3]| -> f64 {
            row.iter().zip(matching(nm)).map(|(factor, value)| factor * value).sum()
        };
        let nodes = || (0..=400).map(|step| 380.0 + f64::from(step));
        let scaled = |of: [f64; 3]| {
            let white: f64 = nodes().map(|nm| row(nm, of) * wavy(nm)).sum();
            Response::new(nodes().map(|nm| [nm, row(nm, of) / white]).collect()).unwrap()
        };
        let responses = Responses::new(FROM_XYZ.map(scaled).to_vec());
        let nodes = nodes_nm(&responses, [380.0, 780.0], std::iter::empty());
        let emitted: Vec<f64> = nodes.iter().map(|nm| wavy(*nm)).collect();
        let density = Density::new(&responses, &nodes, &emitted);
        let gray = measured::<8>(&responses, &density, |nm| 0.4 * wavy(nm), 3);
        assert!(gray.iter().all(|value| (value - 0.4).abs() < 1e-3), "{gray:?}");
    }
}
