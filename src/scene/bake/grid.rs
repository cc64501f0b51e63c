//! What particles do to light at wavelengths all over a range, computed once: a render that asks
//! for other wavelengths in every iteration reads them from here, linear between the nodes.
//!
//! Nodes are [`STEP_NM`] apart or less. What is read between them is off by the curvature of the
//! phase matrix over the wavelength: of distributions of sizes about the wavelength, as of milk, by
//! less than a thousandth of the coefficients, and two of M00 at any angle (tested below). Spheres
//! of one size that are large against the wavelength have resonances narrower than a step, of
//! which the nodes see what is there by chance.

use std::collections::HashMap;

use hecs::Entity;
use rayon::prelude::*;

use super::optics::{self, Derived};
use super::phase::{self, Elements};
use crate::polarization::kept;
use crate::scene::baked::Phase;
use crate::scene::error::SceneError;
use crate::scene::world::{self, Name, World};
use crate::spectrum::{Beyond, Carried};

/// Distance of nodes in nanometers, at most.
const STEP_NM: f64 = 5.0;
/// Most nodes.
const NODES_MAX: f64 = 512.0;

/// The media of a world, of which some are of particles.
#[derive(Debug)]
pub struct Suspensions {
    by_medium: HashMap<Entity, Grid>,
}

/// One medium.
#[derive(Debug)]
pub struct Grid {
    first_nm: f64,
    step_nm: f64,
    nodes: Vec<Node>,
}

/// One medium at one wavelength.
#[derive(Debug)]
struct Node {
    /// Coefficients per meter.
    sigma_a: f64,
    sigma_s: f64,
    matrix: Vec<Elements>,
}

impl Suspensions {
    /// Those of a world from the first to the last of some wavelengths in nanometers.
    ///
    /// # Errors
    /// When a medium is not known there, or its particles are too large.
    pub fn new(world: &World, ends_nm: [f64; 2], beyond: Beyond) -> Result<Self, SceneError> {
        let grid = |(entity, name, medium): (Entity, &Name, &world::Medium)| {
            Ok((entity, Grid::new(&medium.phase, (ends_nm, beyond), &name.0)?))
        };
        let grids = world.in_order::<(Entity, &Name, &world::Medium), _>(grid);
        let grids: Result<Vec<_>, SceneError> = grids.into_iter().collect();
        let grids = grids.map_err(|error| error.in_file(&world.file))?;
        let known = |(entity, grid): (Entity, Option<Grid>)| Some((entity, grid?));
        Ok(Self { by_medium: grids.into_iter().filter_map(known).collect() })
    }

    /// A medium, if it is of particles.
    pub(super) fn of(&self, medium: Entity) -> Option<&Grid> {
        self.by_medium.get(&medium)
    }
}

impl Grid {
    /// That of a phase function, if it is of particles.
    fn new(
        phase: &world::Phase,
        (ends_nm, beyond): ([f64; 2], Beyond),
        name: &str,
    ) -> Result<Option<Self>, SceneError> {
        let [first_nm, last_nm] = ends_nm;
        let steps = ((last_nm - first_nm) / STEP_NM).ceil().clamp(1.0, NODES_MAX);
        let step_nm = (last_nm - first_nm) / steps;
        let at = |index: usize| first_nm + step_nm * index as f64;
        let samples = (0..=steps as usize)
            // The last may not be beyond the range by rounding.
            .map(|index| optics::suspension_at(phase, (at(index).min(last_nm), beyond), name))
            .collect::<Result<Option<Vec<_>>, _>>()?;
        let Some(samples) = samples else { return Ok(None) };
        let sizes = samples.iter().map(|(suspension, _)| suspension.size_parameter_max());
        let intervals = optics::intervals_of(sizes.fold(0.0, f64::max), name)?;
        let node = |(suspension, host_sigma_a): &(_, f64)| {
            let found = kept::scattering(suspension, intervals);
            let matrix = optics::elements_of(&found.matrix);
            Node { sigma_a: found.sigma_a + host_sigma_a, sigma_s: found.sigma_s, matrix }
        };
        let nodes: Vec<Node> = samples.par_iter().map(node).collect();
        nodes.iter().try_for_each(|node| optics::check_series(&node.matrix, name))?;
        Ok(Some(Self { first_nm, step_nm, nodes }))
    }

    /// What the medium does at the wavelengths of the render.
    pub(super) fn at<const N: usize>(&self, carried: &Carried<N>) -> Derived<N> {
        let places = carried.wavelengths_nm().map(|nm| self.place(f64::from(nm)));
        let mixed = |of: fn(&Node) -> f64| {
            places.map(|(low, share)| {
                (of(&self.nodes[low]) * (1.0 - share) + of(&self.nodes[low + 1]) * share) as f32
            })
        };
        let matrices = places.map(|(low, share)| {
            let [low, high] = [low, low + 1].map(|node| &self.nodes[node].matrix);
            let mix = |(low, high): (&Elements, &Elements)| low.mixed(high, share);
            low.iter().zip(high).map(mix).collect()
        });
        let table = phase::table(&matrices);
        Derived {
            sigma_a: mixed(|node| node.sigma_a),
            sigma_s: mixed(|node| node.sigma_s),
            phase: Phase::Table(table),
        }
    }

    /// The node before a wavelength, and how far that is beyond, of the way to the next.
    fn place(&self, nm: f64) -> (usize, f64) {
        let place = ((nm - self.first_nm) / self.step_nm).clamp(0.0, (self.nodes.len() - 1) as f64);
        let low = (place as usize).min(self.nodes.len() - 2);
        (low, place - low as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polarization::particles::{Amount, Sizes};
    use crate::scene::baked::PhaseTable;
    use crate::scene::world::{Component, Spheres};
    use crate::spectrum::Spectrum;

    /// Drops whose indices change over the wavelength, as those of water do, or more.
    fn drops() -> world::Phase {
        let sizes = Sizes::log_normal(0.4, 0.15, Amount::Volume, None).unwrap();
        let table = |values: [f32; 2]| Spectrum::table(&[400.0, 700.0], &values).unwrap();
        let component = Component {
            sizes,
            eta: table([1.48, 1.45]),
            k: table([1e-4, 1e-5]),
            volume_fraction: 1e-3,
        };
        let (host_eta, host_k) = (table([1.34, 1.33]), 1e-8.into());
        world::Phase::Spheres(Spheres { components: vec![component], host_eta, host_k })
    }

    /// Halfway between two nodes, where it is off by most.
    #[test]
    fn what_is_read_between_nodes_is_what_is_computed_there() {
        let phase = drops();
        let ends = ([500.0, 520.0], Beyond::Refused);
        let grid = Grid::new(&phase, ends, "drops").unwrap().expect("particles");
        assert_eq!((grid.nodes.len(), grid.step_nm), (5, 5.0));
        for nm in [502.5, 517.5, 510.0] {
            let carried = Carried::at([nm as f32]);
            let read = grid.at(&carried);
            let at = (nm, Beyond::Refused);
            let (suspension, host) = optics::suspension_at(&phase, at, "drops").unwrap().unwrap();
            let intervals = grid.nodes[0].matrix.len() - 1;
            let found = kept::scattering(&suspension, intervals);
            let off = |read: f32, exact: f64| (f64::from(read) / exact - 1.0).abs();
            assert!(off(read.sigma_s[0], found.sigma_s) < 1e-3, "{nm}: sigma_s");
            assert!(off(read.sigma_a[0], found.sigma_a + host) < 1e-3, "{nm}: sigma_a");
            let Phase::Table(read) = read.phase else { panic!("no table") };
            let exact: PhaseTable<1> = phase::table(&[optics::elements_of(&found.matrix)]);
            let rows = read.m00.iter().zip(&exact.m00);
            let worst = rows.map(|(a, b)| (a[0] / b[0] - 1.0).abs()).fold(0.0, f32::max);
            assert!(worst < 2e-3, "{nm}: M00 is off by {worst} of itself");
            let rows = read.elements.as_flattened().iter().zip(exact.elements.as_flattened());
            let worst = rows.map(|(a, b)| (a[0] - b[0]).abs()).fold(0.0, f32::max);
            assert!(worst < 1e-3, "{nm}: elements are off by {worst}");
            assert!(nm != 510.0 || worst < 1e-6, "a node is off by {worst}");
        }
    }

    #[test]
    fn wavelengths_at_which_nothing_is_known_are_refused() {
        let grid = |ends, beyond| Grid::new(&drops(), (ends, beyond), "drops");
        for ends in [[390.0, 500.0], [500.0, 701.0]] {
            let error = grid(ends, Beyond::Refused).map(|_| ()).unwrap_err().to_string();
            assert!(error.contains("400 to 700 nm"), "{error}");
            assert!(grid(ends, Beyond::Held).is_ok());
        }
        let air = world::Phase::isotropic();
        let none = Grid::new(&air, ([1.0, 2.0], Beyond::Refused), "air").unwrap();
        assert!(none.is_none());
    }
}
