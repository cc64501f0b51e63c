//! Lamps as paths see them on their way through media: those whose light falls off so fast that
//! scattering near them is rarely found by free flights, which do not know of them.

use crate::math::{F32s, LANES, Vector, lanes};
use crate::scene::baked::{KEEP, NONE, Optics, SOUGHT, Shapes};
use crate::scene::emitter::Emitter;

use super::super::immersion::Around;
use super::super::medium::Medium;
use super::super::surface::Material;
use super::tree::{LightTree, Outline, Vantage};
use super::{is_delta, outline};

/// The lamps of a scene, and the media that they light straight on.
#[derive(Clone, Debug)]
pub struct Lamps {
    /// The only one, if it is.
    single: Option<usize>,
    /// Over the lamps, each as bright in all directions.
    tree: LightTree,
    /// Where each emitter is, if it is a lamp.
    places: Vec<Option<[f32; 3]>>,
    /// Whether each medium is lit, and scatters.
    lit: Vec<bool>,
}

impl Lamps {
    /// The lamps of a scene; none if they light no medium.
    pub fn new<const N: usize>(
        (shapes, optics): (&Shapes, &Optics<N>),
        materials: &[Material],
        media: &[Medium<N>],
        emitter_media: &[Around<[u32; 2]>],
    ) -> Option<Self> {
        let is_lamp = |emitter: &Emitter| emitter.model.is_finite() && is_delta(&emitter.model);
        let lamps = || (0..).zip(&*optics.emitters).filter(|(_, emitter)| is_lamp(emitter));
        let mut lit = vec![false; media.len()];
        let mut light = |medium: u32| match medium {
            // Next to what cannot be told, or is told path by path, there may be any.
            SOUGHT => lit.fill(true),
            NONE | KEEP => {}
            medium => lit[medium as usize] = true,
        };
        for (row, _) in lamps() {
            match emitter_media[row as usize] {
                Around::Same(sides) => sides.into_iter().for_each(&mut light),
                Around::Varies => light(SOUGHT),
            }
        }
        for surface in &shapes.surfaces {
            if materials[surface.material as usize].is_straight_on() {
                [surface.interior, surface.exterior].into_iter().for_each(&mut light);
            }
        }
        for (lit, medium) in lit.iter_mut().zip(media) {
            *lit &= medium.sigma_s.iter().any(|&sigma_s| sigma_s > 0.0);
        }
        let mut outlines = Vec::new();
        let mut places = vec![None; optics.emitters.len()];
        for (row, emitter) in lamps() {
            let seen = outline(&emitter.model, shapes).scaled(emitter.brightness);
            let place = 0.5 * seen.lower + 0.5 * seen.upper;
            places[row as usize] = Some(place.to_array());
            // A segment may see any side of it.
            let even = seen.even + seen.axis.length();
            outlines.push((row, Outline { even, ..Outline::at(place) }));
        }
        if outlines.is_empty() || !lit.contains(&true) {
            return None;
        }
        let single = match outlines[..] {
            [(row, _)] => Some(row as usize),
            _ => None,
        };
        Some(Self { single, tree: LightTree::new(outlines, places.len()), places, lit })
    }

    /// The media that are lit.
    pub fn media_lit(&self) -> impl Iterator<Item = u32> {
        (0..).zip(&self.lit).filter(|(_, lit)| **lit).map(|(medium, _)| medium)
    }

    /// Whether a medium is.
    #[inline(always)]
    pub fn light(&self, medium: u32) -> bool {
        self.lit[medium as usize]
    }

    /// Chooses one for each of eight segments, that are near `from`, with the probabilities of
    /// that; only the first `live` have a meaning.
    #[inline(always)]
    pub fn choose(
        &self,
        from: impl FnOnce() -> [Vantage; LANES],
        u: F32s,
        live: usize,
    ) -> [(usize, f32); LANES] {
        match self.single {
            Some(lamp) => [(lamp, 1.0); LANES],
            None => self.choose_by_tree(&from(), u, live),
        }
    }

    fn choose_by_tree(
        &self,
        from: &[Vantage; LANES],
        u: F32s,
        live: usize,
    ) -> [(usize, f32); LANES] {
        let brought = self.tree.brought_to_all(from);
        let mut chosen = self.tree.choose(from, &brought, u, lanes::each(|lane| lane < live));
        let first = chosen[0];
        chosen[live..].fill(first);
        chosen
    }

    /// The probabilities with which [`Self::choose`] chooses emitters: 0 for what is not a lamp.
    #[inline(always)]
    pub fn chances(
        &self,
        from: impl FnOnce() -> [Vantage; LANES],
        emitters: [usize; LANES],
    ) -> F32s {
        match self.single {
            Some(lamp) => lanes::each(|lane| f32::from(u8::from(emitters[lane] == lamp))).into(),
            None => self.chances_by_tree(&from(), emitters),
        }
    }

    fn chances_by_tree(&self, from: &[Vantage; LANES], emitters: [usize; LANES]) -> F32s {
        let of = |lane: usize| match self.places[emitters[lane]] {
            Some(_) => {
                let brought = self.tree.brought_to(&from[lane]);
                self.tree.chance(&from[lane], brought, emitters[lane])
            }
            None => 0.0,
        };
        lanes::each(of).into()
    }

    /// Where eight of them are.
    pub fn places(&self, emitters: [usize; LANES]) -> Vector<F32s> {
        Vector::gather(|lane| self.places[emitters[lane]].unwrap_or_default())
    }
}
