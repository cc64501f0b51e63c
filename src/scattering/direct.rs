//! Light sources as chosen from points of the scene (next-event estimation), eight at a time.
//!
//! Densities as in `emission`: `pdf_w` is that of choosing the point or direction, `emission_pdf`
//! that of starting a light path with it; both include the probability of choosing the emitter.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use crate::math::{F32s, LANES, Real, Vector, warp};
use crate::scene::baked::{Emitter, EmitterKind, Optics, Shapes};

use super::emission::{SPHERE_PDF, cone_pdf, disk_pdf};

/// Floats of an emitter's record: two packets, so that eight records are loaded by two
/// transpositions.
const FIELDS: usize = 2 * LANES;

/// All emitters, one record of plain numbers each.
#[derive(Clone, Debug)]
pub struct DirectTable<const N: usize> {
    kinds: Vec<EmitterKind>,
    records: Vec<[f32; FIELDS]>,
    radiance: Vec<[f32; N]>,
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

impl<const N: usize> DirectTable<N> {
    /// The records of a scene's emitters.
    pub fn new(shapes: &Shapes, optics: &Optics<N>) -> Self {
        let emitters = &optics.emitters;
        Self {
            kinds: emitters.iter().map(|emitter| emitter.kind).collect(),
            records: emitters.iter().map(|emitter| record(shapes, emitter)).collect(),
            radiance: emitters.iter().map(|emitter| emitter.radiance).collect(),
        }
    }

    /// Chooses a point of, or direction to, the emitters `chosen` from the points `reference`.
    #[inline(always)]
    pub fn sample(
        &self,
        chosen: [usize; LANES],
        reference: Vector<F32s>,
        u: [F32s; 2],
    ) -> DirectLanes<N> {
        let fields = Fields::gather(&self.records, chosen);
        let mut radiance = [[0.0; LANES]; N];
        for lane in 0..LANES {
            for (n, radiance) in radiance.iter_mut().enumerate() {
                radiance[lane] = self.radiance[chosen[lane]][n];
            }
        }
        let radiance = radiance.map(F32s::from);
        let first = self.kinds[chosen[0]];
        let mut lanes = sample_kind(first, &fields, reference, radiance, u);
        if chosen.iter().all(|&emitter| self.kinds[emitter] == first) {
            return lanes;
        }
        for kind in KINDS.into_iter().filter(|&kind| kind != first) {
            let of_kind = chosen.map(|emitter| self.kinds[emitter] == kind);
            if of_kind.contains(&true) {
                let mask = F32s::from(of_kind.map(|is| if is { 1.0 } else { 0.0 }));
                let others = sample_kind(kind, &fields, reference, radiance, u);
                lanes = select(mask.simd_gt(F32s::splat(0.5)), &others, &lanes);
            }
        }
        lanes
    }
}

const KINDS: [EmitterKind; 6] = [
    EmitterKind::Triangle,
    EmitterKind::Sphere,
    EmitterKind::Point,
    EmitterKind::Spot,
    EmitterKind::Directional,
    EmitterKind::Environment,
];

/// Eight records, field by field.
struct Fields {
    /// Triangle: corner a. Sphere: center. Point, Spot: position. Directional: to the light.
    a: Vector<F32s>,
    /// Triangle: b - a. Sphere: radius in x. Spot: axis.
    b: Vector<F32s>,
    /// Triangle: c - a. Spot: cosines of the inner and outer angle in x and y.
    c: Vector<F32s>,
    /// Triangle: normal.
    normal: Vector<F32s>,
    /// Probability of choosing the emitter.
    probability: F32s,
    /// Triangle, Sphere: one over the area. Others: the density of emission.
    measure: F32s,
    /// Triangle: 1 if both sides emit, else 0.
    two_sided: F32s,
}

impl Fields {
    #[inline(always)]
    fn gather(records: &[[f32; FIELDS]], chosen: [usize; LANES]) -> Self {
        let mut halves = [[F32s::splat(0.0); LANES]; 2];
        for (lane, &emitter) in chosen.iter().enumerate() {
            let packets: [[f32; LANES]; 2] = bytemuck::cast(records[emitter]);
            halves[0][lane] = F32s::from(packets[0]);
            halves[1][lane] = F32s::from(packets[1]);
        }
        let [[a0, a1, a2, b0, b1, b2, c0, c1], [c2, n0, n1, n2, probability, measure, sides, _]] =
            halves.map(F32s::transpose);
        Self {
            a: Vector::new(a0, a1, a2),
            b: Vector::new(b0, b1, b2),
            c: Vector::new(c0, c1, c2),
            normal: Vector::new(n0, n1, n2),
            probability,
            measure,
            two_sided: sides,
        }
    }
}

fn record<const N: usize>(shapes: &Shapes, emitter: &Emitter<N>) -> [f32; FIELDS] {
    let zero = Vec3::ZERO;
    let probability = emitter.probability;
    let (a, b, c, normal, measure) = match emitter.kind {
        EmitterKind::Triangle => {
            let [a, b, c] = shapes.triangles[emitter.primitive as usize].corners;
            let (b, c) = (b - a, c - a);
            (a, b, c, b.cross(c).normalize(), 1.0 / emitter.area)
        }
        EmitterKind::Sphere => {
            let sphere = shapes.spheres[emitter.primitive as usize - shapes.triangles.len()];
            let radius = Vec3::new(sphere.radius, 0.0, 0.0);
            (sphere.center, radius, zero, zero, 1.0 / emitter.area)
        }
        EmitterKind::Point => {
            // A cone that holds the whole sphere at full intensity.
            let cosines = Vec3::new(-2.0, -3.0, 0.0);
            let measure = probability * cone_pdf(emitter);
            (emitter.position, Vec3::Z, cosines, zero, measure)
        }
        EmitterKind::Spot => {
            let cosines = Vec3::new(emitter.cos_inner, emitter.cos_outer, 0.0);
            let measure = probability * cone_pdf(emitter);
            (emitter.position, emitter.direction, cosines, zero, measure)
        }
        EmitterKind::Directional => {
            (-emitter.direction, zero, zero, zero, probability * disk_pdf(&shapes.bounds))
        }
        EmitterKind::Environment => {
            let measure = probability * SPHERE_PDF * disk_pdf(&shapes.bounds);
            (zero, zero, zero, zero, measure)
        }
    };
    let sides = if emitter.two_sided { 1.0 } else { 0.0 };
    let mut record = [0.0; FIELDS];
    let fields = [a, b, c, normal].into_iter().flat_map(|vector| vector.to_array());
    for (to, from) in record.iter_mut().zip(fields.chain([probability, measure, sides])) {
        *to = from;
    }
    record
}

#[inline(always)]
fn sample_kind<const N: usize>(
    kind: EmitterKind,
    fields: &Fields,
    reference: Vector<F32s>,
    radiance: [F32s; N],
    u: [F32s; 2],
) -> DirectLanes<N> {
    match kind {
        EmitterKind::Triangle => {
            let [v, w] = warp::triangle(u);
            let point = fields.b.mul_add(v, fields.c.mul_add(w, fields.a));
            on_surface(fields, reference, radiance, point, fields.normal)
        }
        EmitterKind::Sphere => {
            let normal = sphere_direction(u);
            let point = normal.mul_add(fields.b.x, fields.a);
            on_surface(fields, reference, radiance, point, normal)
        }
        EmitterKind::Point | EmitterKind::Spot => at_point(fields, reference, radiance),
        EmitterKind::Directional => {
            at_infinity(fields, radiance, fields.a, F32s::splat(1.0), F32s::splat(0.0))
        }
        EmitterKind::Environment => {
            let (pdf, one) = (F32s::splat(SPHERE_PDF), F32s::splat(1.0));
            at_infinity(fields, radiance, sphere_direction(u), pdf, one)
        }
    }
}

#[inline(always)]
fn on_surface<const N: usize>(
    fields: &Fields,
    reference: Vector<F32s>,
    radiance: [F32s; N],
    point: Vector<F32s>,
    normal: Vector<F32s>,
) -> DirectLanes<N> {
    let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
    let offset = point - reference;
    let distance2 = offset.length_squared();
    let direction = offset * (one / distance2.sqrt());
    let cosine = -direction.dot(normal);
    let seen = Real::select(Real::gt(fields.two_sided, zero), cosine.abs(), cosine);
    let faces = seen.simd_gt(zero);
    let cos_at_light = Real::select(faces, seen, one);
    let pdf_a = fields.probability * fields.measure;
    DirectLanes {
        direction,
        point,
        normal,
        finite: F32s::splat(f32::from_bits(u32::MAX)),
        radiance: radiance.map(|radiance| faces & radiance),
        pdf_w: pdf_a * distance2 / cos_at_light,
        emission_pdf: pdf_a * cos_at_light * F32s::splat(FRAC_1_PI) / (one + fields.two_sided),
        cos_at_light,
        reachable: one,
    }
}

#[inline(always)]
fn at_point<const N: usize>(
    fields: &Fields,
    reference: Vector<F32s>,
    radiance: [F32s; N],
) -> DirectLanes<N> {
    let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
    let offset = fields.a - reference;
    let distance2 = offset.length_squared();
    let direction = offset * (one / distance2.sqrt());
    let [inner, outer] = [fields.c.x, fields.c.y];
    // Linear in the cosine, squared, as KHR_lights_punctual recommends.
    let ramp = (-direction.dot(fields.b) - outer) / (inner - outer);
    let ramp = ramp.max(zero).min(one);
    DirectLanes {
        direction,
        point: fields.a,
        normal: Vector::new(zero, zero, zero),
        finite: F32s::splat(f32::from_bits(u32::MAX)),
        radiance: radiance.map(|intensity| intensity * (ramp * ramp)),
        pdf_w: fields.probability * distance2,
        emission_pdf: fields.measure,
        cos_at_light: one,
        reachable: zero,
    }
}

#[inline(always)]
fn at_infinity<const N: usize>(
    fields: &Fields,
    radiance: [F32s; N],
    direction: Vector<F32s>,
    pdf: F32s,
    reachable: F32s,
) -> DirectLanes<N> {
    let zero = F32s::splat(0.0);
    let nowhere = Vector::new(zero, zero, zero);
    DirectLanes {
        direction,
        point: nowhere,
        normal: nowhere,
        finite: zero,
        radiance,
        pdf_w: fields.probability * pdf,
        emission_pdf: fields.measure,
        cos_at_light: F32s::splat(1.0),
        reachable,
    }
}

#[inline(always)]
fn sphere_direction(u: [F32s; 2]) -> Vector<F32s> {
    let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
    warp::cone(Vector::new(zero, zero, one), -one, u)
}

#[inline(always)]
fn select<const N: usize>(mask: F32s, a: &DirectLanes<N>, b: &DirectLanes<N>) -> DirectLanes<N> {
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
