//! The weights of multiple importance sampling: dVCM, dVC and dVM of Georgiev's technical report
//! ("Implementing vertex connection and merging", Saarland University 2012), and the power
//! heuristic of the unidirectional integrator (Veach 1997, section 9.2.4).
//!
//! The balance heuristic weighs a strategy by its density over the sum of those of all strategies
//! that make the same path. Each subpath carries its part of that sum, relative to the density with
//! which it was made itself, so that the weight at the join needs no walk back:
//!
//! - **dVCM** of a vertex: one over the density (per area) of tracing it from the last one. At the
//!   first vertex, times the density of connecting to the subpath's start instead of tracing.
//! - **dVC**: all strategies that join before that, by connecting (or merging), without the reverse
//!   density of the last turn, which is known only when the path goes on or is joined.
//! - **dVM**: the same, relative to merging. Where connections compete, dVM is dVC over the eta of
//!   [`MergingFactors`], and needs no column; alone it stands where photons only are merged.
//!
//! | equation | what | here |
//! |---|---|---|
//! | 20 | merging against connecting | [`MergingFactors::both`] |
//! | 31, 32; 48, 49 (delta emitters) | start of a light path | [`PartialWeights::from_emitter`] |
//! | 31, the density there | first vertex of a light path | [`PartialWeights::beside_choice`] |
//! | 31, 32 | start of a sensor path | [`PartialWeights::from_sensor`] |
//! | 31, 32, 34, 35, second half | arrival | [`PartialWeights::arrive`] |
//! | 34, 35, first half | departure | [`PartialWeights::depart`] |
//! | 35, 40, 41, 45, 46 | the eta in them | [`PartialWeights::beside_merging`] |
//! | 53, 54 | specular departure | [`PartialWeights::depart_specular`] |
//! | 33, 36, 50, 55 | all of this for dVM | [`MergingWeights`] |
//! | 37 | full weight | every `weight_of_` |
//! | 38, 39 | merging | [`weight_of_vertices_merged`] |
//! | 40, 41 | connecting vertices | [`weight_of_vertices_connected`] |
//! | 42, 43 | meeting an emitter | [`weight_of_emission_met`] |
//! | 44, 45 | connecting to an emitter | [`chance_over_choice`], [`weight_of_emitter_connected`] |
//! | 46, 47 | connecting to the sensor | [`weight_of_sensor_connected`] |
//! | 37 | connecting an emitter to the sensor | [`weight_of_start_connected`] |
//!
//! Conventions: the density of a medium takes the place of cosines at its vertices. What is
//! infinitely far away has densities per steradian, no distance and no cosine. Roulette is left
//! out, as any weights do that add up to one over the strategies of a path.
//!
//! Numbers only: no columns, no Stokes values, no wavelengths. Generic over the number type, so
//! that the formulas which are compared with an enumeration of all strategies in `f64` (`tests`
//! below) are the ones that run in eight `f32` lanes.

use crate::math::{F32s, Real};
use crate::scattering::vertex::Turn;

/// Densities of a point of an emitter (or a direction, where that is infinitely far away) and of
/// the light that leaves it. Both include the probability of choosing the emitter, which differs:
/// light paths start at emitters by their power, connections choose them by what they bring to the
/// vertex.
#[derive(Clone, Copy, Debug)]
pub struct EmitterDensities<F> {
    /// Of choosing the point when connecting, from the vertex next to it: per area; per steradian
    /// where the emitter is infinitely far away.
    pub direct_pdf: F,
    /// Of starting a light path with it: per area and steradian; per steradian from a point.
    pub emission_pdf: F,
    /// Cosine at the emitter, 1 where it has no surface.
    pub cos_at_light: F,
}

/// Densities of a turn at a vertex: from where the path comes, to where it goes or is connected.
#[derive(Clone, Copy, Debug)]
pub struct TurnDensities<F> {
    /// Per steradian, of drawing the direction onwards.
    pub pdf: F,
    /// Per steradian, of drawing the direction back when coming from the one onwards.
    pub pdf_reverse: F,
    /// Cosine of the direction onwards, or the density of the medium for a vertex in one.
    pub measure: F,
}

impl<const N: usize> From<&Turn<N>> for TurnDensities<F32s> {
    #[inline(always)]
    fn from(turn: &Turn<N>) -> Self {
        let &Turn { pdf, pdf_reverse, measure, .. } = turn;
        Self { pdf, pdf_reverse, measure }
    }
}

/// One end of a connection between two subpaths.
#[derive(Clone, Copy, Debug)]
pub struct End<F> {
    /// On arrival.
    pub weights: PartialWeights<F>,
    /// To the other end.
    pub turn: TurnDensities<F>,
}

/// What a subpath knows of the strategies that compete with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartialWeights<F> {
    /// dVCM: reciprocal of the density of the last segment, times the density of connecting
    /// instead.
    pub d_vcm: F,
    /// dVC: what the connections at all earlier vertices add up to.
    pub d_vc: F,
}

impl<F: Real> PartialWeights<F> {
    /// Of a light path that leaves an emitter; `delta` where no path can meet that by chance.
    /// Equations 31 and 32, 48 and 49 for `delta`, still without the first segment and the density
    /// of choosing the emitter's point from its end ([`Self::beside_choice`]). `emission_pdf` and
    /// `cos_at_light` are those of [`EmitterDensities`].
    #[inline(always)]
    pub fn from_emitter(emission_pdf: F, cos_at_light: F, delta: F::Mask) -> Self {
        Self {
            d_vcm: F::one() / emission_pdf,
            d_vc: F::select(delta, F::zero(), cos_at_light / emission_pdf),
        }
    }

    /// At the first vertex of a light path, where it is known how likely that is to choose the
    /// emitter's point: `direct_pdf` of equation 31, as in [`EmitterDensities`].
    #[inline(always)]
    pub fn beside_choice(self, direct_pdf: F) -> Self {
        Self { d_vcm: self.d_vcm * direct_pdf, d_vc: self.d_vc }
    }

    /// Of a sensor path, where an iteration traces `light_paths` light paths that connect to the
    /// sensor. `pdf` is the density of the sensor's ray per steradian; per area of the film where
    /// projection is parallel. Equations 31 and 32, still without the first segment.
    #[inline(always)]
    pub fn from_sensor(pdf: F, light_paths: F) -> Self {
        Self { d_vcm: light_paths / pdf, d_vc: F::zero() }
    }

    /// From the measure of the last vertex to that of the new one: second half of equations 31, 32,
    /// 34, 35. `distance2` is the squared length of the segment, or 1 for one from infinity
    /// (section 5.1); `measure` the cosine of arrival, or the density of the medium.
    #[inline(always)]
    pub fn arrive(self, distance2: F, measure: F) -> Self {
        let inverse = F::one() / measure;
        Self { d_vcm: self.d_vcm * distance2 * inverse, d_vc: self.d_vc * inverse }
    }

    /// Through a surface on the way that lets the path go straight on with the probability
    /// `chance`, the same both ways: a factor of both densities of tracing the segment, of which
    /// dVC holds the ratio.
    #[inline(always)]
    pub fn pass(self, chance: F) -> Self {
        Self { d_vcm: self.d_vcm / chance, d_vc: self.d_vc }
    }

    /// Onwards from a vertex that connects: first half of equations 34 and 35.
    #[inline(always)]
    pub fn depart(self, turn: TurnDensities<F>) -> Self {
        let inverse = F::one() / turn.pdf;
        Self { d_vcm: inverse, d_vc: turn.measure * inverse * self.rivals(turn.pdf_reverse) }
    }

    /// Onwards from a vertex whose direction only sampling can find, so that no connection competes
    /// there: first half of equations 53 and 54. `measure` is the cosine of the direction onwards.
    #[inline(always)]
    pub fn depart_specular(self, measure: F) -> Self {
        Self { d_vcm: F::zero(), d_vc: self.d_vc * measure }
    }

    /// For use at a vertex that connects and also merges: adds the density of merging there to what
    /// the vertex competes with (equations 35, 40, 41, 45, 46). `mis_vm` as in [`MergingFactors`].
    #[inline(always)]
    pub fn beside_merging(self, mis_vm: F) -> Self {
        Self { d_vcm: self.d_vcm + mis_vm, d_vc: self.d_vc }
    }

    /// What connecting one vertex earlier, and at all before that, amounts to: the bracket that
    /// equations 35, 40, 41, 45 and 46 share.
    #[inline(always)]
    fn rivals(self, pdf_reverse: F) -> F {
        self.d_vc.mul_add(pdf_reverse, self.d_vcm)
    }
}

/// How connecting and merging count against each other (equation 20).
#[derive(Clone, Copy, Debug)]
pub struct MergingFactors<F> {
    /// One over eta; 0 where nothing connects.
    pub mis_vc: F,
    /// Eta: light paths an iteration times the area (or volume) in which they are merged; 0 where
    /// nothing merges.
    pub mis_vm: F,
}

impl<F: Real> MergingFactors<F> {
    /// For connecting and merging both.
    pub fn both(eta: F) -> Self {
        Self { mis_vc: F::one() / eta, mis_vm: eta }
    }

    /// For merging alone.
    pub fn merging_only() -> Self {
        Self { mis_vc: F::zero(), mis_vm: F::one() }
    }
}

/// What a subpath knows of its rivals where photons are merged.
#[derive(Clone, Copy, Debug)]
pub struct MergingWeights<F> {
    /// dVCM and dVC; the latter counts merging, too.
    pub connecting: PartialWeights<F>,
    /// dVM.
    pub d_vm: F,
}

impl<F: Real> MergingWeights<F> {
    /// Of a light path that leaves an emitter: equations 33 and 50.
    pub fn from_emitter(
        emission_pdf: F,
        cos_at_light: F,
        delta: F::Mask,
        factors: MergingFactors<F>,
    ) -> Self {
        let connecting = PartialWeights::from_emitter(emission_pdf, cos_at_light, delta);
        Self { connecting, d_vm: connecting.d_vc * factors.mis_vc }
    }

    /// As [`PartialWeights::beside_choice`].
    pub fn beside_choice(self, direct_pdf: F) -> Self {
        Self { connecting: self.connecting.beside_choice(direct_pdf), ..self }
    }

    /// Of a sensor path: equation 33.
    pub fn from_sensor(pdf: F, light_paths: F) -> Self {
        Self { connecting: PartialWeights::from_sensor(pdf, light_paths), d_vm: F::zero() }
    }

    /// As [`PartialWeights::arrive`]; second half of equations 33 and 36.
    pub fn arrive(self, distance2: F, measure: F) -> Self {
        Self { connecting: self.connecting.arrive(distance2, measure), d_vm: self.d_vm / measure }
    }

    /// As [`PartialWeights::pass`].
    pub fn pass(self, chance: F) -> Self {
        Self { connecting: self.connecting.pass(chance), ..self }
    }

    /// As [`PartialWeights::depart`], from a vertex that merges, too; first half of equation 36.
    pub fn depart(self, turn: TurnDensities<F>, factors: MergingFactors<F>) -> Self {
        let here = self.connecting.d_vcm * factors.mis_vc + F::one();
        Self {
            connecting: self.connecting.beside_merging(factors.mis_vm).depart(turn),
            d_vm: turn.measure / turn.pdf * self.d_vm.mul_add(turn.pdf_reverse, here),
        }
    }

    /// As [`PartialWeights::depart_specular`]; first half of equation 55.
    pub fn depart_specular(self, measure: F) -> Self {
        Self { connecting: self.connecting.depart_specular(measure), d_vm: self.d_vm * measure }
    }

    /// What joining earlier amounts to, relative to merging; `pdf` is the density per steradian of
    /// drawing the direction back along this subpath.
    fn rivals(self, pdf: F, factors: MergingFactors<F>) -> F {
        self.connecting.d_vcm * factors.mis_vc + self.d_vm * pdf
    }
}

/// Weight of two subpaths that are merged, both on arrival: equations 37 to 39. `turn` is that of
/// the sensor's vertex to where the light comes from.
pub fn weight_of_vertices_merged<F: Real>(
    sensor: MergingWeights<F>,
    light: MergingWeights<F>,
    turn: TurnDensities<F>,
    factors: MergingFactors<F>,
) -> F {
    let before = light.rivals(turn.pdf, factors);
    let after = sensor.rivals(turn.pdf_reverse, factors);
    F::one() / (before + F::one() + after)
}

/// Weight of an emitter that a sensor path meets, against all other strategies: equations 37, 42
/// and 43, from the partial weights on departure from the last vertex. `distance2` is the squared
/// length of the segment, or 1 for one to infinity.
#[inline(always)]
pub fn weight_of_emission_met<F: Real>(
    sensor: PartialWeights<F>,
    emitter: EmitterDensities<F>,
    distance2: F,
) -> F {
    let EmitterDensities { direct_pdf, emission_pdf, cos_at_light } = emitter;
    let rivals = direct_pdf * sensor.d_vcm * distance2 + emission_pdf * sensor.d_vc;
    F::one() / (F::one() + rivals / cos_at_light)
}

/// Density of meeting an emitter by chance, over that of choosing the same point of it when
/// connecting: equation 44. `pdf` is that of drawing the direction, `direct_pdf_w` that of choosing
/// it, both per steradian at the vertex; `reachable` is 0 for a delta emitter, else 1.
#[inline(always)]
pub fn chance_over_choice<F: Real>(pdf: F, reachable: F, direct_pdf_w: F) -> F {
    pdf * reachable / direct_pdf_w
}

/// Weight of an emitter that a sensor path's vertex connects to: equations 37 and 45. Here the
/// `direct_pdf` of the emitter is per steradian at the vertex; `chance` is [`chance_over_choice`].
#[inline(always)]
pub fn weight_of_emitter_connected<F: Real>(
    sensor: End<F>,
    emitter: EmitterDensities<F>,
    chance: F,
) -> F {
    let EmitterDensities { direct_pdf, emission_pdf, cos_at_light } = emitter;
    let to_vertex = emission_pdf * sensor.turn.measure / (direct_pdf * cos_at_light);
    let rivals = to_vertex * sensor.weights.rivals(sensor.turn.pdf_reverse);
    F::one() / (chance + F::one() + rivals)
}

/// Weight of a connection of two vertices, times `inverse2`, one over their squared distance:
/// equations 37, 40 and 41, and the geometry term without its cosines.
#[inline(always)]
pub fn weight_of_vertices_connected<F: Real>(sensor: End<F>, light: End<F>, inverse2: F) -> F {
    let sensor_to_light = sensor.turn.pdf * light.turn.measure * inverse2;
    let light_to_sensor = light.turn.pdf * sensor.turn.measure * inverse2;
    let before = sensor_to_light * light.weights.rivals(light.turn.pdf_reverse);
    let after = light_to_sensor * sensor.weights.rivals(sensor.turn.pdf_reverse);
    inverse2 / (before + F::one() + after)
}

/// Weight of a light vertex that connects to the sensor: equations 37, 46 and 47. `importance` is
/// the density of the sensor's ray, per area perpendicular to it at the vertex, over the number of
/// light paths.
#[inline(always)]
pub fn weight_of_sensor_connected<F: Real>(light: End<F>, importance: F) -> F {
    let rivals = importance * light.turn.measure * light.weights.rivals(light.turn.pdf_reverse);
    F::one() / (rivals + F::one())
}

/// Weight of a point of an emitter that is connected to the sensor, where paths of one segment are
/// found so, too: equation 37. `start_pdf` is the density of starting a light path there, per area;
/// the sensor's path that meets the point has that as its `direct_pdf` and no `emission_pdf`, for
/// nothing lies between ([`weight_of_emission_met`]). `importance` as for
/// [`weight_of_sensor_connected`].
#[inline(always)]
pub fn weight_of_start_connected<F: Real>(start_pdf: F, cos_at_light: F, importance: F) -> F {
    F::one() / (importance * cos_at_light / start_pdf + F::one())
}

/// What the weight of a connection is multiplied by if it crosses surfaces which paths pass with
/// the probability `chance` only: all its rivals trace that segment. For the power heuristic, the
/// square of that.
#[inline(always)]
pub fn gain_of_crossing<F: Real>(weight: F, chance: F) -> F {
    F::one() / (chance * (F::one() - weight) + weight)
}

/// Power heuristic (Veach 1997, section 9.2.4) for an emitter that a path meets, against choosing
/// its point when connecting. `pdf_w` is the density of the direction, infinite where no connection
/// competes; `distance2` as for [`weight_of_emission_met`].
#[inline(always)]
pub fn power_of_emission_met<F: Real>(pdf_w: F, emitter: EmitterDensities<F>, distance2: F) -> F {
    let ratio = emitter.direct_pdf * (distance2 / emitter.cos_at_light) / pdf_w;
    F::one() / (F::one() + ratio * ratio)
}

/// Power heuristic for an emitter that a vertex connects to, against meeting it by chance;
/// `chance` is [`chance_over_choice`].
#[inline(always)]
pub fn power_of_emitter_connected<F: Real>(chance: F) -> F {
    F::one() / chance.mul_add(chance, F::one())
}

#[cfg(test)]
mod tests;
