//! What polarizers and retarders have in common: sheets that let light straight on and act on its
//! polarization about an axis of their own.

use super::model::{Incidence, ModelLanes, Passage, Surface};
use crate::math::{F32s, Vector};
use crate::polarization::Block;
use crate::polarization::elements::{exact_sin_cos_deg, transmission_axis};

/// How an axis lies in a sheet: cosine and sine of the angle by which it is turned from the
/// surface's `axis_x`, counter-clockwise about the geometric normal.
#[derive(Clone, Copy, Debug)]
pub struct Axis(pub(super) [f32; 2]);

/// A kernel, and how its axis lies in the sheet.
#[derive(Clone, Copy, Debug)]
pub struct Element {
    /// The kernel in the frame of the axis.
    pub(super) block: Block<f32>,
    pub(super) axis: Axis,
}

impl Element {
    /// A kernel whose axis is turned by `axis_deg`.
    pub fn new(Block { a, c, s }: Block<f64>, axis_deg: f64) -> Self {
        let block = Block { a: a as f32, c: c as f32, s: s as f32 };
        Self { block, axis: Axis::turned(axis_deg) }
    }

    /// Straight on, with the weight `m00` of unpolarized light.
    #[inline(always)]
    pub fn pass<M: Surface, const N: usize, const POLARIZED: bool>(
        at: &Incidence<M>,
        element: impl Fn(&M) -> &Self + Copy,
        m00: F32s,
    ) -> Passage<N> {
        let (kernel, axis) = if POLARIZED {
            (Self::block(&at.models, element), Axis::across(at, |model| &element(model).axis))
        } else {
            (Block::identity(), at.direction)
        };
        Passage { transmittance: [m00; N], chance: F32s::splat(1.0), kernels: [kernel; N], axis }
    }

    #[inline(always)]
    fn block<M>(models: &ModelLanes<M>, element: impl Fn(&M) -> &Self + Copy) -> Block<F32s> {
        Block {
            a: models.field(|model| element(model).block.a),
            c: models.field(|model| element(model).block.c),
            s: models.field(|model| element(model).block.s),
        }
    }
}

impl Axis {
    /// Turned by `axis_deg`.
    pub fn turned(axis_deg: f64) -> Self {
        let (sin, cos) = exact_sin_cos_deg(axis_deg);
        Self([cos as f32, sin as f32])
    }

    /// The axis, turned within its surface and then laid across the light.
    #[inline(always)]
    pub fn across<M: Surface>(
        at: &Incidence<M>,
        axis: impl Fn(&M) -> &Self + Copy,
    ) -> Vector<F32s> {
        let node_x = Vector::gather(|lane| at.surface(lane).axis_x.to_array());
        let node_y = Vector::gather(|lane| at.surface(lane).axis_y.to_array());
        let normal = at.geometric;
        let project = |axis: Vector<F32s>| normal.mul_add(-axis.dot(normal), axis);
        let in_surface = project(node_x);
        let upright = in_surface.length_squared().simd_lt(F32s::splat(1e-4));
        let x = Vector::select(upright, project(node_y), in_surface).normalize();
        let y = normal.cross(x);
        let cosine = at.models.field(|model| axis(model).0[0]);
        let sine = at.models.field(|model| axis(model).0[1]);
        transmission_axis(x.mul_add(cosine, y * sine), normal, at.direction)
    }
}
