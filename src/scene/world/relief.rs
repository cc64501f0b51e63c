//! Shading normals by pictures: of normals, or of heights.

use glam::Vec2;

use super::texture::{Filter, Reads, Texture, Wrap, columns_about};

/// What shading normals by a picture are relative to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ReliefFrame {
    /// Right and up of the picture as it lies on the surface, or the tangents of the mesh: glTF's.
    Picture,
    /// Right is where the first of the mesh's texture coordinates grows, whatever turns the
    /// picture, and up is the normal cross right: Mitsuba's.
    Mesh,
}

/// What a picture is of that shading normals go by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReliefOf {
    /// Of normals, relative to a frame: from 0 to 1 what is from -1 to 1 to the right, up, and out
    /// of it.
    Normals(ReliefFrame),
    /// Of heights of the surface along its normal; what of the texels they are. Normals are those
    /// of the raised surface where that is linear between texels, and nothing else is raised.
    Heights(Reads),
}

/// Shading normals by a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Relief {
    /// The picture.
    pub texture: Texture,
    /// What right and up of normals are multiplied by; of heights, how high 1 is, in units of the
    /// scene.
    pub scale: f32,
    /// What the picture is of.
    pub of: ReliefOf,
}

impl Texture {
    /// How a number that is read of texels changes with the two coordinates of a mesh at a point:
    /// that of what is linear between the four texels about it, and nothing else.
    pub fn slopes(&self, at: Vec2, reads: Reads) -> [f32; 2] {
        if self.filter == Filter::Nearest {
            return [0.0; 2];
        }
        let uv = self.place(at).to_array();
        let size = self.picture.texels().size();
        let along = |axis: usize| columns_about(uv[axis], size[axis], self.wrap[axis], self.filter);
        let ([left, right], across) = along(0);
        let ([upper, lower], down) = along(1);
        let value = |column, row| reads.of(self.picture.texels().at(column, row, self.coding))[0];
        let [first, second] = [value(left, upper), value(right, upper)];
        let [third, fourth] = [value(left, lower), value(right, lower)];
        let (upper, lower) = (second - first, fourth - third);
        let (left, right) = (third - first, fourth - second);
        let of_picture =
            [(lower - upper).mul_add(down, upper), (right - left).mul_add(across, left)];
        let in_picture: [f32; 2] = std::array::from_fn(|axis| {
            let turns = self.wrap[axis] == Wrap::Mirror && is_mirrored(uv[axis]);
            of_picture[axis] * size[axis] as f32 * if turns { -1.0 } else { 1.0 }
        });
        let [rows_u, rows_v] = self.transform;
        [0, 1].map(|axis| in_picture[0] * rows_u[axis] + in_picture[1] * rows_v[axis])
    }
}

/// Whether a mirrored picture is seen from its back at a coordinate.
fn is_mirrored(at: f32) -> bool {
    at.is_finite() && at - 2.0 * (0.5 * at).floor() >= 1.0
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::image::texels::{Coding, Texels};
    use crate::scene::world::Picture;

    #[test]
    fn slopes_are_differences_of_what_is_looked_up() {
        let colors = (0..12).map(|at| [(at * at % 7) as f32 / 7.0, (at % 5) as f32 / 5.0, 0.25]);
        let picture = Arc::new(Picture::new(Texels::of_colors(4, colors.collect()), 1));
        let coding = Coding::Linear;
        let transform = [[1.3, -0.4, 0.2], [0.3, 0.9, -0.1]];
        let mut checked = 0;
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            let (picture, filter) = (Arc::clone(&picture), Filter::Linear);
            let texture = Texture { picture, coding, wrap: [wrap; 2], filter, set: 0, transform };
            for step in 0..400 {
                let at = Vec2::new(0.0173 * step as f32 - 3.0, 2.0 - 0.0117 * step as f32);
                let height = |at: Vec2| Reads::Luminance.of(texture.at(at))[0];
                const STEP: f32 = 1.0 / 1024.0;
                let texel = |at: Vec2| (texture.place(at) * Vec2::new(4.0, 3.0) - 0.5).floor();
                let ends = [Vec2::X, Vec2::Y].map(|axis| [at - STEP * axis, at + STEP * axis]);
                // Where they go by the same four texels.
                if ends.as_flattened().iter().any(|end| texel(*end) != texel(at)) {
                    continue;
                }
                let expected = ends.map(|[a, b]| (height(b) - height(a)) / (2.0 * STEP));
                let found = texture.slopes(at, Reads::Luminance);
                let error = (Vec2::from(found) - Vec2::from(expected)).length();
                assert!(error < 2e-3, "{wrap:?} at {at}: {found:?}, not {expected:?}");
                checked += 1;
            }
        }
        assert!(checked > 600, "{checked}");
    }
}
