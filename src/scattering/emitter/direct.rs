//! Light sources as chosen from points of the scene (next-event estimation), eight at a time.
//!
//! Densities as in `emitter`: `pdf_w` is that of choosing the point or direction, `emission_pdf`
//! that of starting a light path with it; both include the probability of choosing the emitter,
//! from the point and by its power.

use crate::math::{F32s, LANES, Real, Vector, lanes};
use crate::scene::baked::Shapes;
use crate::scene::emitter::{Emitter, Panorama};

use super::{Emits, Kind, record};

/// Floats of an emitter's record: two packets, so that eight records are loaded by two
/// transpositions. They mean what its model has them mean.
pub const OWN: usize = 2 * LANES;

/// The floats of one emitter.
pub type Own = [f32; OWN];

/// The floats of eight emitters of one model.
pub type OwnLanes = [F32s; OWN];

/// Floats of a record, followed by zeros.
pub fn own<const M: usize>(floats: [f32; M]) -> Own {
    let mut own = [0.0; OWN];
    own[..M].copy_from_slice(&floats);
    own
}

/// All emitters, one record of plain numbers each.
#[derive(Clone, Debug)]
pub struct DirectTable {
    kinds: Vec<Kind>,
    records: Vec<Own>,
    /// For every emitter, its row in the lamps.
    lamps: Vec<u32>,
    tables: Tables,
}

/// What models have beside their records.
#[derive(Clone, Debug, Default)]
pub struct Tables {
    /// The picture of the environment, if it has one: there is one environment at most.
    pub panorama: Option<Panorama>,
}

impl Tables {
    fn new(emitters: &[Emitter]) -> Self {
        let panorama = emitters.iter().find_map(|emitter| emitter.model.panorama().cloned());
        Self { panorama }
    }
}

/// Eight points or directions on emitters.
#[derive(Clone, Copy)]
pub struct DirectLanes<const N: usize> {
    /// Towards the emitter, unit length.
    pub direction: Vector<F32s>,
    /// The point on the emitter; without meaning at infinity.
    pub point: Vector<F32s>,
    /// Geometric normal there; zero for emitters without a surface.
    pub normal: Vector<F32s>,
    /// Mask of the lanes whose emitter is at a finite distance.
    pub finite: F32s,
    /// Radiance that arrives, or its equivalent for `pdf_w` of a delta emitter; zero where the
    /// emitter does not face the point.
    pub radiance: [F32s; N],
    /// Density per steradian; greater than zero.
    pub pdf_w: F32s,
    /// Density of emission: per area and steradian, or per steradian for a point.
    pub emission_pdf: F32s,
    /// Cosine at the emitter, 1 where it has no surface.
    pub cos_at_light: F32s,
    /// 1 where paths can meet the emitter by chance, else 0.
    pub reachable: F32s,
}

impl DirectTable {
    /// The records of a scene's emitters.
    pub fn new(shapes: &Shapes, emitters: &[Emitter]) -> Self {
        let records =
            emitters.iter().map(|emitter| record(&emitter.model, shapes, emitter.probability));
        Self {
            kinds: emitters.iter().map(|emitter| Kind::of(&emitter.model)).collect(),
            records: records.collect(),
            lamps: emitters.iter().map(|emitter| emitter.lamp).collect(),
            tables: Tables::new(emitters),
        }
    }

    /// Chooses a point of, or direction to, the emitters `chosen`, with the probabilities `chance`,
    /// from the points `reference`; `lamps` are those of the scene.
    // Once for all stages and scatterers, rather than in each of them: all models are in it.
    #[inline(never)]
    pub fn sample<const N: usize>(
        &self,
        lamps: &[[f32; N]],
        (chosen, chance): ([usize; LANES], F32s),
        reference: Vector<F32s>,
        u: [F32s; 2],
    ) -> DirectLanes<N> {
        let records = gather(&self.records, chosen);
        let own = (&records, &self.tables);
        let mut radiance = [[0.0; LANES]; N];
        for lane in 0..LANES {
            let lamp = &lamps[self.lamps[chosen[lane]] as usize];
            for (radiance, of_lamp) in radiance.iter_mut().zip(lamp) {
                radiance[lane] = *of_lamp;
            }
        }
        let radiance = radiance.map(F32s::from);
        let first = self.kinds[chosen[0]];
        let mut lanes = first.choose(own, reference, radiance, chance, u);
        if chosen.iter().all(|&emitter| self.kinds[emitter] == first) {
            return lanes;
        }
        for &kind in Kind::ALL.iter().filter(|&&kind| kind != first) {
            let of_kind = chosen.map(|emitter| self.kinds[emitter] == kind);
            if of_kind.contains(&true) {
                let others = kind.choose(own, reference, radiance, chance, u);
                lanes = select(lanes::mask_of(of_kind), &others, &lanes);
            }
        }
        lanes
    }

    /// [`Self::sample`] of the first emitter or, in the lanes of the mask, of the second, which is
    /// of the same model; that may be the only one.
    #[inline(never)]
    pub fn sample_either<const N: usize>(
        &self,
        lamps: &[[f32; N]],
        (second, chance): (F32s, F32s),
        reference: Vector<F32s>,
        u: [F32s; 2],
    ) -> DirectLanes<N> {
        let last = self.records.len() - 1;
        let own = &self.records;
        let [first_lamp, last_lamp] = [0, last].map(|row| &lamps[self.lamps[row] as usize]);
        let own = std::array::from_fn(|field| either(second, [own[0][field], own[last][field]]));
        let own = (&own, &self.tables);
        let radiance = std::array::from_fn(|n| either(second, [first_lamp[n], last_lamp[n]]));
        self.kinds[0].choose(own, reference, radiance, chance, u)
    }
}

/// The first value or, in the lanes of the mask, the second.
#[inline(always)]
pub fn either(second: F32s, [a, b]: [f32; 2]) -> F32s {
    Real::select(second, F32s::splat(b), F32s::splat(a))
}

/// [`DirectLanes::finite`] of a model.
#[inline(always)]
pub fn finite<Model: Emits>() -> F32s {
    lanes::mask_of([Model::FINITE; LANES])
}

/// [`DirectLanes::reachable`] of a model.
#[inline(always)]
pub fn reachable<Model: Emits>() -> F32s {
    F32s::splat(if Model::DELTA { 0.0 } else { 1.0 })
}

/// Eight records, field by field.
#[inline(always)]
fn gather(records: &[Own], chosen: [usize; LANES]) -> OwnLanes {
    let mut halves = [[F32s::splat(0.0); LANES]; 2];
    for (lane, &emitter) in chosen.iter().enumerate() {
        let packets: [[f32; LANES]; 2] = bytemuck::cast(records[emitter]);
        halves[0][lane] = F32s::from(packets[0]);
        halves[1][lane] = F32s::from(packets[1]);
    }
    let [first, second] = halves;
    let [a, b, c, d, e, f, g, h] = F32s::transpose(first);
    let [i, j, k, l, m, n, o, p] = F32s::transpose(second);
    [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p]
}

/// Those of `a` where the mask is set, else those of `b`.
#[inline(always)]
pub fn select<const N: usize>(
    mask: F32s,
    a: &DirectLanes<N>,
    b: &DirectLanes<N>,
) -> DirectLanes<N> {
    let choose = |a, b| Real::select(mask, a, b);
    DirectLanes {
        direction: Vector::select(mask, a.direction, b.direction),
        point: Vector::select(mask, a.point, b.point),
        normal: Vector::select(mask, a.normal, b.normal),
        finite: choose(a.finite, b.finite),
        radiance: std::array::from_fn(|n| choose(a.radiance[n], b.radiance[n])),
        pdf_w: choose(a.pdf_w, b.pdf_w),
        emission_pdf: choose(a.emission_pdf, b.emission_pdf),
        cos_at_light: choose(a.cos_at_light, b.cos_at_light),
        reachable: choose(a.reachable, b.reachable),
    }
}
