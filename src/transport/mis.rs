//! The weights of multiple importance sampling: dVCM and dVC of Georgiev's technical report
//! ("Implementing vertex connection and merging", Saarland University 2012), and the power
//! heuristic of the unidirectional integrator.
//!
//! Numbers only: no columns, no Stokes values, no wavelengths. Generic over the number type, so
//! that the formulas which are compared with an enumeration of all strategies in `f64` are the
//! ones that run in eight `f32` lanes.

use crate::math::{F32s, Real};
use crate::scattering::vertex::Turn;

/// Densities of a point of an emitter (or a direction, where that is infinitely far away) and of
/// the light that leaves it. All include the probability of choosing the emitter.
#[derive(Clone, Copy, Debug)]
pub struct EmitterDensities<F> {
    /// Of choosing the point when connecting: per area; per steradian where the emitter is
    /// infinitely far away.
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
    /// Equations 31 and 32, 48 and 49 for `delta`, still without the first segment.
    #[inline(always)]
    pub fn from_emitter(emitter: EmitterDensities<F>, delta: F::Mask) -> Self {
        let EmitterDensities { direct_pdf, emission_pdf, cos_at_light } = emitter;
        Self {
            d_vcm: direct_pdf / emission_pdf,
            d_vc: F::select(delta, F::zero(), cos_at_light / emission_pdf),
        }
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

    /// What connecting one vertex earlier, and at all before that, amounts to: the bracket that
    /// equations 34, 40, 41, 45 and 46 share.
    #[inline(always)]
    fn rivals(self, pdf_reverse: F) -> F {
        self.d_vc.mul_add(pdf_reverse, self.d_vcm)
    }
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
