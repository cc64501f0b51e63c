//! Where things are.

use glam::{DAffine3, DMat3, DVec3};

use crate::math::Fault;

/// How much the axes of a similarity may differ in length, and from right angles.
const SIMILARITY_TOLERANCE: f64 = 1e-4;

/// From the entity's own space to world space; finite and invertible.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform(pub DAffine3);

impl Transform {
    /// The entity's own space is the world's.
    pub const IDENTITY: Self = Self(DAffine3::IDENTITY);

    /// The place of a camera or light at `eye` that looks at `target`; `up`, of any length and not
    /// along the line of sight, is up in the image.
    pub fn looking(eye: DVec3, target: DVec3, up: DVec3) -> Self {
        let backward = (eye - target).normalize();
        let right = up.cross(backward).normalize();
        let axes = DMat3::from_cols(right, backward.cross(right), backward);
        Self(DAffine3::from_mat3_translation(axes, eye))
    }

    /// The same about another point of the world.
    pub(in crate::scene) fn about(&self, origin: DVec3) -> DAffine3 {
        DAffine3 { translation: self.0.translation - origin, ..self.0 }
    }

    /// Refuses what makes volumes vanish, or is not finite.
    pub(crate) fn check(&self) -> Result<(), Fault> {
        const LEAST_RELATIVE_VOLUME: f64 = 1e-9;
        let axes = self.axes();
        let volume = axes[0].length() * axes[1].length() * axes[2].length();
        let determinant = self.0.matrix3.determinant().abs();
        let is_invertible = self.0.is_finite()
            && volume.is_normal()
            && determinant.is_normal()
            && determinant > LEAST_RELATIVE_VOLUME * volume;
        if is_invertible {
            return Ok(());
        }
        let problem = "its transform is singular or not finite";
        let remedy = "give it, and its parents, a scale that is not zero along any axis";
        Err(Fault::new("", problem, remedy))
    }

    /// Whether it is made of rotation, reflection, translation and one scale for all axes.
    pub(super) fn is_similarity(&self) -> bool {
        let axes = self.axes();
        let length = axes[0].length();
        let same = |axis: &DVec3| (axis.length() / length - 1.0).abs() <= SIMILARITY_TOLERANCE;
        axes.iter().all(same) && self.is_orthogonal()
    }

    /// Whether the axes are at right angles to each other.
    pub(super) fn is_orthogonal(&self) -> bool {
        let [x, y, z] = self.axes().map(DVec3::normalize);
        [x.dot(y), y.dot(z), z.dot(x)].iter().all(|cos| cos.abs() <= SIMILARITY_TOLERANCE)
    }

    fn axes(&self) -> [DVec3; 3] {
        let matrix = self.0.matrix3;
        [matrix.x_axis, matrix.y_axis, matrix.z_axis]
    }
}

impl From<DAffine3> for Transform {
    fn from(to_world: DAffine3) -> Self {
        Self(to_world)
    }
}

/// Moved there, and neither turned nor scaled.
impl From<DVec3> for Transform {
    fn from(translation: DVec3) -> Self {
        Self(DAffine3::from_translation(translation))
    }
}
