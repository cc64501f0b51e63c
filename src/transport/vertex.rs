//! What vertices do to light, on either side, whichever stage asks: eight rows of a sensor path's
//! vertices that have met the same, one of them in all lanes, and light vertices of any kind.

use crate::geometry::SurfaceColumns;
use crate::math::{F32s, LANES, Real, Vector, lanes, warp};
use crate::polarization::s_axis;
use crate::scattering::diffuse::{BRDF, Facing};
use crate::scattering::medium::{PhaseFunction, half_sine2};
use crate::scattering::phase::Scatters;
use crate::scattering::vertex::{Turn, VertexLanes, mean};
use crate::scattering::{Met, Scene};
use crate::scene::baked::NONE;

use super::LightModel;
use super::tables::states::{LightState, kernels_of_lanes};
use super::tables::vertices::VertexTable;

/// What a stage needs of the materials of eight rows that have hit diffuse surfaces.
pub struct MaterialLanes<const N: usize> {
    /// Reflectance.
    pub reflectance: [F32s; N],
    /// Mask of those whose back reflects too.
    pub two_sided: F32s,
}

impl<const N: usize> MaterialLanes<N> {
    /// The materials of the `live` rows from `row` on.
    #[inline(always)]
    pub fn gather(scene: &Scene<N>, surfaces: &SurfaceColumns, row: usize, live: usize) -> Self {
        let material =
            lanes::each(|lane| scene.material_row(surfaces.primitive[row + lane.min(live - 1)]));
        let of = |lane: usize| &scene.optics.materials[material[lane]];
        let two_sided = lanes::each(|lane| if of(lane).two_sided { 1.0 } else { 0.0 });
        let mut reflectance = [F32s::splat(0.0); N];
        for (n, reflectance) in reflectance.iter_mut().enumerate() {
            *reflectance = F32s::from(lanes::each(|lane| of(lane).reflectance[n]));
        }
        Self { reflectance, two_sided: F32s::from(two_sided).simd_gt(F32s::splat(0.5)) }
    }
}

/// The normals of eight rows.
#[inline(always)]
pub fn facing_of<const N: usize>(
    surfaces: &SurfaceColumns,
    material: &MaterialLanes<N>,
    row: usize,
) -> Facing {
    Facing {
        geometric: Vector::load(&surfaces.geometric_normal, row),
        shading: Vector::load(&surfaces.shading_normal, row),
        two_sided: material.two_sided,
    }
}

/// What eight rows that have met the same scatter.
#[inline(always)]
pub fn vertex_lanes<'a, const N: usize>(
    met: Met,
    surfaces: &SurfaceColumns,
    scene: &'a Scene<N>,
    row: usize,
    live: usize,
) -> VertexLanes<'a, N> {
    match met {
        Met::Medium(medium) => VertexLanes::Volume(scene.medium(medium)),
        Met::Surface(_) => {
            let material = MaterialLanes::gather(scene, surfaces, row, live);
            let mut brdf = material.reflectance;
            brdf.iter_mut().for_each(|brdf| *brdf *= F32s::splat(BRDF));
            VertexLanes::Surface { facing: facing_of(surfaces, &material, row), brdf }
        }
    }
}

/// A diffuse surface, in all lanes.
#[inline(always)]
pub fn on_surface<'a, const N: usize>(
    surfaces: &SurfaceColumns,
    scene: &Scene<N>,
    normal: [f32; 3],
    row: usize,
) -> VertexLanes<'a, N> {
    let material = scene.material_at(surfaces.primitive[row]);
    let two_sided = F32s::splat(if material.two_sided { 1.0 } else { 0.0 });
    let mut brdf = [F32s::splat(0.0); N];
    for (brdf, &reflectance) in brdf.iter_mut().zip(&material.reflectance) {
        *brdf = F32s::splat(reflectance * BRDF);
    }
    let facing = Facing {
        geometric: Vector::splat(normal),
        shading: Vector::splat(lanes::row_of(&surfaces.shading_normal, row)),
        two_sided: two_sided.simd_gt(F32s::splat(0.5)),
    };
    VertexLanes::Surface { facing, brdf }
}

/// The normals of eight light vertices.
#[inline(always)]
fn facing_of_vertices<const N: usize>(vertices: &VertexTable<N>, row: usize) -> Facing {
    Facing {
        geometric: Vector::load(&vertices.geometric_normal, row),
        shading: Vector::load(&vertices.shading_normal, row),
        two_sided: lanes::load(&vertices.two_sided, row).simd_gt(F32s::splat(0.5)),
    }
}

/// What eight light vertices do to light that leaves them along `direction`. The BRDF of
/// surfaces, which is in their power, is left out.
#[inline(always)]
pub fn light_turn<const N: usize>(
    vertices: &VertexTable<N>,
    scene: &Scene<N>,
    direction: Vector<F32s>,
    (row, live): (usize, usize),
) -> Turn<N> {
    let facing = facing_of_vertices(vertices, row);
    let given = Vector::load(&vertices.given, row);
    let cosine = direction.dot(facing.shading).abs();
    let adjoint = facing.adjoint(given, direction);
    let mut turn = Turn {
        value: [facing.reflects(given, direction) & (adjoint * cosine); N],
        pdf: warp::cosine_pdf(cosine),
        pdf_reverse: warp::cosine_pdf(given.dot(facing.shading).abs()),
        measure: direction.dot(facing.geometric).abs(),
    };
    for_each_volume(vertices, (row, live), |medium, mask| {
        let medium = scene.medium(medium);
        let values = medium.phase.values(half_sine2(-given, direction));
        let pdf = mean(&values);
        for (value, &phase) in turn.value.iter_mut().zip(&values) {
            *value = Real::select(mask, phase, *value);
        }
        turn.pdf = Real::select(mask, pdf, turn.pdf);
        turn.pdf_reverse = Real::select(mask, pdf, turn.pdf_reverse);
        turn.measure = Real::select(mask, F32s::splat(medium.density), turn.measure);
    });
    turn
}

/// The light that leaves eight vertices along `direction`, where it is polarized.
#[inline(always)]
pub fn departing_states<const N: usize, M: LightModel<N>>(
    vertices: &VertexTable<N>,
    scene: &Scene<N>,
    direction: Vector<F32s>,
    (row, live): (usize, usize),
) -> [Option<LightState<N>>; LANES] {
    let mut states = [None; LANES];
    if !M::POLARIZED {
        return states;
    }
    let k_in = -Vector::load(&vertices.given, row);
    for_each_volume(vertices, (row, live), |medium, mask| {
        let PhaseFunction::Table(table) = &scene.medium(medium).phase else { return };
        let kernels = kernels_of_lanes(&table.kernels(half_sine2(k_in, direction)));
        let (axis, k_in) = (s_axis(k_in, direction).to_rows(), k_in.to_rows());
        let mask = mask.to_bits().to_array();
        for lane in (0..live).filter(|&lane| mask[lane] != 0) {
            let [axis, k_in] = [axis[lane], k_in[lane]].map(Vector::from);
            states[lane] = Some(match vertices.state[row + lane] {
                NONE => LightState::first_event(&kernels[lane], axis),
                state => vertices.states[state as usize].scatter(&kernels[lane], axis, k_in),
            });
        }
    });
    states
}

/// Calls `work` once for every medium among eight vertices, with the mask of those in it.
#[inline(always)]
fn for_each_volume<const N: usize>(
    vertices: &VertexTable<N>,
    (row, live): (usize, usize),
    mut work: impl FnMut(u32, F32s),
) {
    let volumes = &vertices.volume[row..row + live];
    for (lane, &medium) in volumes.iter().enumerate() {
        if medium == NONE || volumes[..lane].contains(&medium) {
            continue;
        }
        let same = lanes::each(|lane| volumes.get(lane).is_some_and(|&other| other == medium));
        work(medium, lanes::mask_of(same));
    }
}
