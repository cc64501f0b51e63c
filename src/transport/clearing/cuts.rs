//! What shapes cut off from the surroundings of a vertex.

use glam::{Vec2, Vec3A};

use crate::geometry::nearest_in_triangle;

/// Nearer than this, relative to the radius, the way to a shape does not tell its side.
pub const TOUCHING: f32 = 1e-4;
/// So near to the middle of a ring, relative to its radius, a disk ends where it meets that.
const ROUND: f32 = 0.75;
/// Radius of a disk on a sphere at most, relative to the sphere's: farther off, that is lit
/// differently.
const PART_OF_SPHERE: f32 = 0.5;
/// So near to a sphere, relative to its radius, a vertex is on it.
const ON_SPHERE: f32 = 1.0 / 128.0;

/// A shape that is to be kept out.
#[derive(Clone, Copy)]
pub struct Cut {
    /// From the vertex to it.
    pub distance: f32,
    /// How.
    pub by: By,
    /// Points that say all about where it is; none lies anywhere else.
    pub points: [Vec3A; 3],
}

/// How a shape is kept out.
#[derive(Clone, Copy)]
pub enum By {
    /// A plane, with the unit vector from it to the vertex.
    Plane(Vec3A),
    /// The same for a sphere that the vertex is in.
    Shell(Vec3A, (Vec3A, f32)),
    /// A smaller radius.
    Radius,
}

/// What a sphere keeps of the ball about `center`.
pub fn cut_of_sphere(center: Vec3A, (middle, radius): (Vec3A, f32)) -> Cut {
    let offset = center - middle;
    let outwards = offset.normalize_or(Vec3A::Z);
    let height = offset.length() - radius;
    let point = middle + outwards * radius;
    let normal = outwards * height.signum();
    let by = if height < 0.0 { By::Shell(normal, (middle, radius)) } else { By::Plane(normal) };
    Cut { distance: height.abs(), by, points: [point; 3] }
}

/// What a triangle keeps of the ball about `center`.
pub fn cut_of_triangle(center: Vec3A, corners: &[Vec3A; 3]) -> Cut {
    let [a, b, c] = *corners;
    let offset = center - nearest_in_triangle(center, corners);
    let distance = offset.length();
    let of_face = (b - a).cross(c - a).normalize_or_zero();
    let side = of_face.dot(center - a);
    // The way to the face itself is along its normal, which rounding does not turn.
    let is_face = side.abs() >= distance * (1.0 - TOUCHING) && of_face != Vec3A::ZERO;
    let normal = if is_face { of_face * 1.0_f32.copysign(side) } else { offset / distance };
    Cut { distance, by: By::Plane(normal), points: *corners }
}

/// The plane in which the disk of a surface is looked at.
pub struct Plane {
    /// The vertex.
    pub center: Vec3A,
    /// Unit normal of the surface.
    pub normal: Vec3A,
    /// Of the coordinates in the plane.
    pub axes: (Vec3A, Vec3A),
    /// Of the plane above the surface, or below it.
    pub height: f32,
}

impl Plane {
    /// Coordinates in the plane.
    fn flat(&self, point: Vec3A) -> Vec2 {
        let (x, y) = self.axes;
        Vec2::new(x.dot(point - self.center), y.dot(point - self.center))
    }

    fn cut(&self, distance: f32, normal: Vec2, points: [Vec2; 2]) -> Cut {
        let (x, y) = self.axes;
        let [p, q] = points.map(|point| self.center + x * point.x + y * point.y);
        let normal = x * normal.x + y * normal.y;
        Cut { distance, by: By::Plane(normal), points: [p, q, q] }
    }

    /// What a triangle that crosses the plane keeps of it: a line, of which the vertex is on one
    /// side.
    pub fn cut_of_triangle(&self, corners: &[Vec3A; 3]) -> Option<Cut> {
        let heights = corners.map(|corner| self.normal.dot(corner - self.center) - self.height);
        let mut ends = [Vec2::ZERO; 2];
        let mut count = 0;
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            let (below, above) = (heights[from], heights[to]);
            if (below < 0.0) != (above < 0.0) && count < 2 {
                let along = below / (below - above);
                ends[count] = self.flat(corners[from].lerp(corners[to], along));
                count += 1;
            }
        }
        if count < 2 {
            return None;
        }
        let [p, q] = ends;
        let (_, nearest) = nearest_on_line(p, q);
        let distance = nearest.length();
        // Where the vertex touches it, its side is not known.
        (distance > TOUCHING * self.height.abs())
            .then(|| self.cut(distance, -nearest / distance, ends))
    }

    /// What is behind a rim within `thickness` of the plane: the surface ends there.
    pub fn cut_of_rim(&self, rim: [Vec3A; 2], thickness: f32) -> Option<Cut> {
        let [p, q] = rim.map(|end| self.flat(end));
        let (place, nearest) = nearest_on_line(p, q);
        let [below, above] = rim.map(|end| self.normal.dot(end - self.center));
        let distance = nearest.length();
        let is_of_surface = (below + (above - below) * place).abs() < thickness;
        (is_of_surface && distance > TOUCHING * thickness)
            .then(|| self.cut(distance, -nearest / distance, [p, q]))
    }

    /// The same of a sphere; near to the middle of the ring, and on the sphere itself, it is the
    /// disk that ends there.
    pub fn cut_of_sphere(&self, (middle, radius): (Vec3A, f32)) -> Option<Cut> {
        let off = self.normal.dot(middle - self.center) - self.height;
        if off.abs() > radius {
            return None;
        }
        let ends = |distance| Some(Cut { distance, by: By::Radius, points: [self.center; 3] });
        let ring = (radius * radius - off * off).sqrt();
        let above = (middle - self.center).length() - radius;
        let middle = self.flat(middle);
        let apart = middle.length();
        if above.abs() < ON_SPHERE * radius {
            let (largest, is_deep) = (PART_OF_SPHERE * radius, self.height.abs() > radius);
            return ends(if is_deep { largest } else { largest.min(ring - apart) });
        }
        if apart < ROUND * ring {
            return ends(ring - apart);
        }
        let away = -middle / apart.max(f32::MIN_POSITIVE);
        let distance = apart - ring;
        Some(self.cut(distance.abs(), away * distance.signum(), [away * -distance; 2]))
    }
}

/// Where on a line from `p` to `q` it is nearest to the origin: the share of the way, and the
/// point.
fn nearest_on_line(p: Vec2, q: Vec2) -> (f32, Vec2) {
    let along = q - p;
    let place = (-p.dot(along) / along.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
    (place, p + along * place)
}
